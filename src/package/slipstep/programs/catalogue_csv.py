"""The catalogue of a run as CSV: a line of names with units, then a line an event, numbers to their last bit. What has
a number for each of several faults is a column for each label: "fault_moment 7 [N m]".

    slipstep catalogue-csv EVENTS.h5 [OUT.csv]
    slipstep catalogue-csv EVENTS.h5 [OUT.csv] --csep --origin 13.3 42.5 [--start 2000-01-01]
            the columns that pyCSEP reads

Without OUT.csv it goes to standard output. A catalogue that is still written, EVENTS.h5.part, is read up to its last
whole row.
"""

import argparse
import csv
import sys

from ..geometry.geographic import add_arguments, check_origin, dates, local, lonlat
from ..results.catalogue import Catalogue
from ..results.files import write_csv

# These first, as people read them; all others follow.
FIRST = ("onset", "end", "magnitude", "fault", "x", "y", "z", "mean_slip", "max_slip", "rake", "area", "moment",
         "stress_drop", "peak_slip_rate")


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


def csep(catalogue, origin, at, start):
    """Rows of the format csep-csv of pyCSEP (docs.cseptesting.org, catalogs): depths in km."""
    of = catalogue.event
    columns = (*lonlat(*local(catalogue, at), origin), of["magnitude"], dates(catalogue, start), of["z"] / 1e3)
    yield "lon", "lat", "M", "time_string", "depth", "catalog_id", "event_id"
    for number, (lon, lat, magnitude, when, depth) in enumerate(zip(*columns), 1):
        yield (f"{lon:.6f}", f"{lat:.6f}", f"{magnitude:.4f}", when.isoformat(timespec="microseconds"), f"{depth:.4f}",
               0, number)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("catalogue", metavar="EVENTS", help="file of -fault_catalogue")
    parser.add_argument("output", metavar="OUT", nargs="?", help="file to write; default: standard output")
    parser.add_argument("--csep", action="store_true", help="write the columns lon, lat, M, time_string, depth, "
                                                            "catalog_id, event_id that pyCSEP reads")
    add_arguments(parser)
    options = parser.parse_args()
    if options.csep:
        check_origin(parser, options.origin)
    elif options.origin or options.origin_at:
        parser.error("--origin and --origin-at are for --csep")

    catalogue = Catalogue(options.catalogue)
    catalogue.warn()
    if options.csep:
        rows = csep(catalogue, options.origin, options.origin_at, options.start)
    else:
        titles, values = zip(*columns(catalogue))
        rows = [titles, *zip(*values)]
    if not options.output:
        csv.writer(sys.stdout, lineterminator="\n").writerows(rows)
        return
    write_csv(options.output, rows, options.catalogue)
    print(f"Table: {options.output}, {catalogue.count} event{'s' * (catalogue.count != 1)}")
