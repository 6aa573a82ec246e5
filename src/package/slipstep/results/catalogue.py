"""Read the catalogue of a run, -fault_catalogue: Catalogue(path) and its events in SI units, also while the run goes
on.

    from slipstep.results.catalogue import Catalogue
    catalogue = Catalogue("events.h5")
    catalogue.event["onset"], catalogue.event["magnitude"]   # one value per event
    catalogue.of_fault("moment", 7)                          # of the fault with this label
    catalogue.map("slip")                                    # [n, Nz, Nx], or [n, N] of a mesh
"""

import os
import sys

import numpy as np

from ..errors import OutputError
from ..modules import program
from ..times import since
from .files import attributes, columns, datasets, drawn, is_catalogue, is_complete, open_file, split


class Catalogue:
    """Everything but the maps is in memory after construction; the file is not kept open.

    event      dict of arrays, one value per event, in the order of the file; "fault_moment" and its like [n, faults]
               where a mesh has several faults
    faults     labels of the faults in that order; of an older file those of its mesh, or 0
    units      dict of their units
    attributes dict: event_rate [m/s], shear_modulus [Pa], ...
    mesh       dict: x, z cell centres [m]; of irregular cells also y, length, width [m]
    has_maps   whether map() has some
    complete   whether the run has ended
    goes_on    dict: the columns of an event that went on when the run ended, so far, which is then the last of the
               lists above, and event["goes_on"] is 1 there. None: there is none
    """

    def __init__(self, path):
        self.path = os.fspath(path)
        with self.open() as file:
            if not is_catalogue(file):
                raise OutputError(f"{self.path}: no catalogue of events, as fault -fault_catalogue writes it")
            self.attributes = attributes(file)
            self.event, self.units = columns(file, True, "onset")  # while a row is written they may differ in length
            if "ledger" in self.event:  # the name before version 0.5
                for columns_of in self.event, self.units:
                    columns_of["energy_residual"] = columns_of.pop("ledger")
            self.count = min(len(values) for values in (*self.event.values(),
                                                        *(file[f"maps/{name}"] for name in ("slip", "rupture_time")
                                                          if f"maps/{name}" in file)))
            self.event = {name: values[:self.count] for name, values in self.event.items()}
            self.has_maps = "maps/slip" in file
            self.mesh = {name: data[()] for name, data in datasets(file["mesh"]).items()}
            self.faults = np.atleast_1d(file.attrs["faults"] if "faults" in file.attrs
                                        else np.unique(self.mesh.get("fault", 0)))
            self.complete = is_complete(file)
        going = self.count and self.event.get("goes_on", np.zeros(1))[-1]
        self.goes_on = {name: values[-1] for name, values in self.event.items()} if going else None

    def open(self):
        return open_file(self.path, "fault -fault_catalogue writes it")

    @property
    def over(self):
        """Which events had ended when the run did."""
        return self.event.get("goes_on", np.zeros(self.count)) == 0

    @property
    def duration(self):
        """Of each event [s], also where times are of a million years."""
        return since(self.event, "end", (self.event["onset"], self.event.get("onset_rest", 0.0)))

    def warn(self):
        """A line on standard error where the last event goes on at the end of the run."""
        if self.goes_on:
            print(f"{program()}: {self.path}: the last event, M {self.goes_on['magnitude']:.2f} so far, goes on at the "
                  "end of the run", file=sys.stderr)

    def none(self):
        """What is said of a list without events"""
        if not self.complete:
            return f"{self.path}: no event is there yet"
        return f"{self.path}: no event is there"

    def number_of(self, event):
        """The row of an event that is named by its number from 1 on, or of the "largest"."""
        if not self.count:
            raise OutputError(self.none())
        number = int(np.nanargmax(self.event["moment"])) if event == "largest" else int(event) - 1
        if not 0 <= number < self.count:
            raise OutputError(f"{self.path}: no event {event}, expected a number from 1 to {self.count}, or largest")
        return number

    def of_fault(self, name, label):
        """ "moment", "area", "mean_slip", "stress_drop", "onset", "cell" or "dissipated_energy" of one fault in each
        event."""
        if label not in self.faults:
            raise OutputError(f"{self.path}: no fault {label}, expected one of {', '.join(map(str, self.faults))}")
        if len(self.faults) == 1 and name in self.event:
            return self.event[name]
        if f"fault_{name}" not in self.event:
            raise OutputError(f"{self.path}: no dataset /fault_{name}; it has {', '.join(sorted(self.event))}")
        return self.event[f"fault_{name}"][:, list(self.faults).index(label)]

    def map(self, name):
        """"slip" [m], of two components its magnitude, or one of them, "slip_along_strike", "slip_up_dip"; or
        "rupture_time" [s] after the onset, NaN where a cell stayed below the rate; with -fault_catalogue_maps."""
        name, part = split(name)
        with self.open() as file:
            if f"maps/{name}" not in file:
                raise OutputError(f"{self.path}: no /maps/{name}; fault -fault_catalogue_maps writes it")
            maps = file[f"maps/{name}"][:self.count]
            if maps.ndim > file["maps/rupture_time"].ndim:
                return drawn(maps, part)
            if part is not None:
                raise OutputError(f"{self.path}: /maps/{name} has one component; expected a run with "
                                  "-fault_slip_components 2")
            return maps

    @property
    def extents(self):
        """Of a grid: length_x, length_z [m]."""
        return self.attributes

    @property
    def has_vectors(self):
        """Whether the maps of slip have two components."""
        with self.open() as file:
            return "maps/slip" in file and file["maps/slip"].ndim > file["maps/rupture_time"].ndim
