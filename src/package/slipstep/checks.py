"""Numbers that no fault has, as in other units: one set for all of the package, with the words of the program `fault` (src/record/warn.c)."""

import math

from .errors import warn

# quantity -> unit, the least and the largest magnitude in nature or in a laboratory, and what a smaller and a larger one looks like; 0 is plausible everywhere
PLAUSIBLE = {
    "pressure": ("Pa", 100, 1e10, "MPa", "Pa, in a column of MPa"),  # as -fault_injection_pressure
    "rate": ("m^3/s", 1e-12, 1, "km^3/s", "L/s or m^3/day"),
    "diffusivity": ("m^2/s", 1e-7, 1e3, "km^2/s", "m^2/day or mm^2/s"),
    "permeability_thickness": ("m^3", 1e-22, 1e-6, "km^3", "mD m"),
    "viscosity": ("Pa s", 1e-6, 0.1, "kPa s", "mPa s"),
    "time": ("s", 1e-6, 3.2e10, "years", "s, in a column of days or hours"),
    "radius": ("m", 1e-3, 10, "km", "mm or cm"),
}


def doubt(what, quantity, value):
    """A SlipStepWarning where a number in SI units, called so, looks as if it were in another unit."""
    unit, least, most, small, large = PLAUSIBLE[quantity]
    if value and math.isfinite(value) and not least <= abs(value) <= most:
        warn(f"{what} is {value:.6g} {unit}: is it given in {small if abs(value) < least else large}? Expected {least:g} to {most:g} {unit}")
