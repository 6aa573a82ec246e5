"""Copy an output file without its fields and with few rows, small enough to keep under version control.

    slipstep compact IN.h5 OUT.h5 [--rows 500]

/series and /steps keep every k-th row and the last one; /result and /run are kept whole, of /mesh the cell centres.
/run gets the attribute "rows_kept_every" with k, since the rows of /steps then no longer add up to /result.
"""

import argparse
import os

import h5py
import numpy as np
from ..results.files import replacing
from ..results.run import MESH, Run


def store(file, data, rows):
    """A compressed copy of some rows of a dataset, under its own name and with its attributes."""
    copy = file.create_dataset(data.name, data=data[()][rows], compression="gzip", shuffle=True)
    copy.attrs.update(data.attrs)


def compact(source, target, rows):
    run = Run(source)
    count = len(run.series["time"])
    stride = max(1, -(-count // rows))
    with run.open() as old, replacing(target, source) as part, h5py.File(part, "w") as new:
        for group in ("run", "result", "mesh"):
            new.create_group(group).attrs.update(old[group].attrs)
        new["run"].attrs["rows_kept_every"] = stride
        for name in MESH:
            store(new, old[f"mesh/{name}"], slice(None))
        for group in ("steps", "series"):
            for data in old[group].values():
                store(new, data, np.unique(np.append(np.arange(stride - 1, len(data), stride), len(data) - 1)))
    return stride


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("source", metavar="IN", help="output file of a run")
    parser.add_argument("target", metavar="OUT", help="file to write")
    parser.add_argument("--rows", type=int, default=500, help="rows to keep at most, default 500")
    options = parser.parse_args()
    if options.rows < 1:
        parser.error(f"--rows is {options.rows}, expected a number >= 1")
    stride = compact(options.source, options.target, options.rows)
    run = Run(options.target)
    print(f"{options.target}: final mean slip {run.result['mean_slip']:.8f} m after {run.result['accepted']} steps; "
          f"every {stride}. row kept, {os.path.getsize(options.target) // 1024} KB")
