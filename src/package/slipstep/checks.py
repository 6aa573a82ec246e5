"""Numbers that no fault has, as in other units: one set for all of the package, with the words of the program `fault`
(src/run/watch/warn.c), and by that itself where it is there."""

import math
import os
import re
import subprocess
import tempfile

from .errors import Error, warn, warnings_of
from .modules import ENVIRONMENT, program_fault

# quantity -> unit, the least and the largest magnitude in nature or in a laboratory, and what a smaller and a larger
# one looks like; 0 is plausible everywhere
PLAUSIBLE = {
    "pressure": ("Pa", 100, 1e10, "MPa", "Pa, in a column of MPa"),  # as -fault_injection_pressure
    "rate": ("m^3/s", 1e-12, 1, "km^3/s", "L/s or m^3/day"),
    "diffusivity": ("m^2/s", 1e-7, 1e3, "km^2/s", "m^2/day or mm^2/s"),
    "permeability_thickness": ("m^3", 1e-22, 1e-6, "km^3", "mD m"),
    "viscosity": ("Pa s", 1e-6, 0.1, "kPa s", "mPa s"),
    "time": ("s", 1e-6, 3.2e10, "years", "s, in a column of days or hours"),
    "radius": ("m", 1e-3, 10, "km", "mm or cm"),
}
# What the program says
REFUSED = re.compile(r"/(\w+)\[0, ([01])\] is (\S+), (expected .*)")
UNKNOWN = re.compile(r" holds /(\w+), which nothing reads")
IN_OTHER_UNITS = "is it given in"


def doubt(what, quantity, value):
    """A SlipStepWarning where a number in SI units, called so, looks as if it were in another unit."""
    unit, least, most, small, large = PLAUSIBLE[quantity]
    if value and math.isfinite(value) and not least <= abs(value) <= most:
        warn(f"{what} is {value:.6g} {unit}: is it given in {small if abs(value) < least else large}? Expected "
             f"{least:g} to {most:g} {unit}")


def check_fields(path, fields, options=None):
    """What the program refuses or doubts of parameters, by its own table of bounds and plausible sizes: fields {name:
    array} in SI units of the file at a path, and options {name: value} of fault. It is asked for two cells, that have
    the least and the largest values. Error: a field or an option is out of its bounds. A SlipStepWarning: it looks as
    if it were in another unit. Without the program, and on several processes, from which it cannot be started, nothing
    is checked."""
    import h5py
    import numpy as np
    fields = {name: np.asarray(values, float).ravel() for name, values in fields.items()}
    try:
        program = program_fault()
    except Error:
        return
    if int(os.environ.get("OMPI_COMM_WORLD_SIZE", os.environ.get("PMI_SIZE", "1"))) > 1:
        return
    with tempfile.TemporaryDirectory(prefix="slipstep-") as folder:
        given, left = os.path.join(folder, "fields.h5"), dict(fields)
        while True:
            with h5py.File(given, "w") as file:
                for name, values in left.items():
                    file[name] = [[values.min(), values.max()]]
            words = [program, "-fault_nx", "2", "-fault_nz", "1", "-ts_max_steps", "1", "-ts_max_time", "1",
                     *(["-fault_parameters", given] if left else [])]
            words += [word for name, value in (options or {}).items() for word in (f"-fault_{name}", str(value))]
            text = subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, encoding="utf-8",
                                  env={**ENVIRONMENT, **os.environ}, check=False).stdout
            unknown = UNKNOWN.search(text)
            if not unknown or unknown[1] not in left:
                break
            del left[unknown[1]]  # of a law of one's own, perhaps
        if found := REFUSED.search(text):
            values = fields[found[1]]
            cell = int(values.argmin() if found[2] == "0" else values.argmax())
            raise Error(f"{path}: {found[1]} of cell {cell + 1} is {found[3]}, {found[4]}")
        if (found := re.search(r"error: -fault_(\w+) is (.*)", text)) and found[1] in (options or {}):
            raise Error(f"{path}: {found[1]} is {found[2]}")
        warn(*(line.replace(given, str(path)).replace("-fault_", f"{path}: ") for line in warnings_of(text)
               if IN_OTHER_UNITS in line))
