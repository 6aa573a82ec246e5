#!/usr/bin/env python3
"""The catalogue of a run as CSV: a line of names with units, then a line an event, numbers to their last bit. What has a number
for each of several faults is a column for each label: "fault_moment 7 [N m]".

    output/catalogue_csv.py EVENTS.h5 [OUT.csv]

Without OUT.csv it goes to standard output. A catalogue that is still written, EVENTS.h5.part, is read up to its last whole row.
"""

import argparse
import csv
import os
import sys

from slipstep_modules import need

need("h5py", "numpy")
from slipstep_catalogue import Catalogue
from slipstep_output import OutputError

# These first, as people read them; all others follow.
FIRST = ("onset", "end", "magnitude", "fault", "x", "y", "z", "mean_slip", "max_slip", "rake", "area", "moment", "stress_drop", "peak_slip_rate")


def columns(catalogue):
    """Title and values of each."""
    names = [name for name in FIRST if name in catalogue.event]
    names += sorted(name for name in catalogue.event if name not in FIRST)
    for name in names:
        unit = "" if catalogue.units[name] == "1" else f" [{catalogue.units[name]}]"
        values = catalogue.event[name]
        if values.ndim == 1:
            yield name + unit, values.tolist()
        else:
            yield from ((f"{name} {label}{unit}", own.tolist()) for label, own in zip(catalogue.faults, values.T))


def write(catalogue, file):
    titles, values = zip(*columns(catalogue))
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow(titles)
    for row in zip(*values):
        writer.writerow([repr(value) for value in row])


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("catalogue", metavar="EVENTS", help="file of -fault_catalogue")
    parser.add_argument("output", metavar="OUT", nargs="?", help="file to write; default: standard output")
    options = parser.parse_args()
    try:
        catalogue = Catalogue(options.catalogue)
        if options.output and os.path.exists(options.output) and os.path.samefile(options.catalogue, options.output):
            raise OutputError(f"{options.output} is the catalogue itself, expected another name")
        if not options.output:
            write(catalogue, sys.stdout)
            return
        with open(options.output + ".part", "w", encoding="utf-8") as file:
            write(catalogue, file)
        os.replace(options.output + ".part", options.output)
    except (OutputError, OSError) as error:
        sys.exit(f"catalogue_csv.py: {error}")


if __name__ == "__main__":
    main()
