#!/usr/bin/env python3
"""Files of other projects, each by its commit, to a picture by two commands, and their length, width, upper edge and
moment against what their headers say.

    tests/benchmarks/real_files.py                     fetched from GitHub
    tests/benchmarks/real_files.py --git FOLDER        from git repositories FOLDER/OWNER+NAME/repo

Numbers of headers are typed here as they are printed there, not read by the readers that are checked. Nothing is kept;
the files are others'.
"""

import argparse
import contextlib
import io
import os
import subprocess
import sys
import tempfile
import urllib.request

from common import need

need("matplotlib")
from slipstep.formats.projection import Projection
from slipstep.formats.readers import read
from slipstep.formats.said import size_of
from slipstep.programs import convert, surface

USGS = "isabella232/finite-fault-product@5a991a73cab90d1ed3ba9d3243b5bc4295b9e0e8"
PYQUAKE = "Computational-Geophysics/PyQuake3D@221e8aabe8fca52aece7086a561651f47312f97f"
HBI = "sozawa94/hbi@29b8f905ec5cc4fd83e180da792660ae9825543a"
KMATERNA = "kmaterna/Elastic_stresses_py@4af0628331e1d589cdb8d29314c73d8c98b0b558"
MODELLING = "ucgmsim/source_modelling@1c00cf2ea9d1a4fc58d3e4c5deadf3bdc8df9f76"
# repository and commit, files (the first is read), options, and of the header: area [km2], upper edge [km], moment [N
# m]; None: it is a fault without slip
FILES = (("phoebemrdevries/Process-Srcmod-Files@8961f78171305ad02541cd53f2191dc84db8440f", ("s1992LANDER01COHE.fsp",),
          (), 27 * 18 + 30 * 18 + 45 * 18, 0.0, 4.66e19),
         (KMATERNA, ("examples/Norcia_Example/s2016NORCIA01PIZZ.fsp",), (), 36 * 13, 1.46515, 7.1e18),
         (KMATERNA, ("examples/strike-slip-example/Inputs/s2004PARKFI01CUST.fsp",), (), 40 * 15, 0.5, 1.36e18),
         (MODELLING, ("tests/fsps/s1999IZMITTbouc.fsp",), (), 155 * 18, 0.01, 2.70e20),
         (USGS, ("tests/data/products/000714t/p000714t.fsp",), (), 225 * 70 + 225 * 60, 11.83, 2.1948157e21),
         (USGS, ("tests/data/products/000714t/p000714t.param",), (), 15 * 15 * 7 * 10 + 15 * 15 * 6 * 10, 11.83,
          2.1948157e21),
         (USGS, ("tests/data/products/insar_product/basic_inversion.param",), (), 27 * 2.0 * 12 * 1.97, 0.122376,
          1.055262651644e19),
         (USGS, ("tests/data/products/000714t/p000714t_coulomb.inp",), (), 225 * 70 + 225 * 60, 11.83, 2.19e21),
         ("geodynamics/sw4@03cb7e8d77aa32ecd671a8fa0e146a9ccf2c1846", ("examples/essi/m5.5-5.6x5.6.s200.0.v5.1.srf",),
          (), 5.6 * 5.6, 1.0, "no moment"),
         (MODELLING, ("tests/srfs/test_v2.srf.gz",), (), 5.0699 * 5.0699, 0.0, 10 ** (1.5 * 5.4 + 9.05)),
         (HBI, ("examples/bp5r.in", "examples/bp5r_param.dat"), (), 100 * 40, 0.0, None),
         ("thwbecker/interact@5be436eed123582ac2dcb1d0cb067389000c024d", ("seas_bp_tests/bp5/geom_bp5_1km.in",),
          ("--unit", "m"), 100 * 40, 0.0, None),
         ("limkjae/Quake-DFN@9f5e104dfdaba816dcec71bdc84b782e76b0ff16",
          ("CuboidCoupling/Example2_RadialInjection/Input_BulkFaultGeometry.txt",), (), None, 1.5, None),
         (PYQUAKE, ("examples/BP5-QD/parameter.txt", "examples/BP5-QD/bp5t.msh", "examples/BP5-QD/bp5tparam.dat"), (),
          100 * 40, 0.0, None),)


def get(repository, path, git):
    """The bytes of a file."""
    name, commit = repository.split("@")
    if git:
        return subprocess.run(["git", "-C", os.path.join(git, name.replace("/", "+"), "repo"), "show",
                               f"{commit}:{path}"], capture_output=True, check=True).stdout
    with urllib.request.urlopen(f"https://raw.githubusercontent.com/{name}/{commit}/{path}") as answer:
        return answer.read()


def run(program, *arguments):
    """What a program of the package prints; its errors end this one."""
    sys.argv = [program.__name__.rsplit(".", 1)[-1], *arguments]
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        program.main()
    return out.getvalue()


def row(folder, repository, paths, options, area, top, moment, git):
    """A line of the table; what is off from the header."""
    for path in paths:
        target = os.path.join(folder, os.path.basename(path))
        with open(target, "wb") as file:
            file.write(get(repository, path, git))
    source = os.path.join(folder, os.path.basename(paths[0]))
    cells, picture = os.path.join(folder, "cells.h5"), os.path.join(folder, "picture.png")
    faults = moment is None
    run(convert, source, cells, *options, *(("--figure", picture) if faults else ()))
    if not faults:
        run(surface, cells, "--figure", picture)
    if os.path.getsize(picture) < 5000:
        sys.exit(f"{source}: no picture")
    unit = options[1] if options else None
    model = read(source, lambda lon, lat: Projection((lon, lat)), unit=unit)
    length, width = size_of(model)
    ours = model.area.sum() / 1e6, model.corners[..., 2].min() / 1e3, None if faults else model.moment()[0]
    words = [f"{ours[0]:.6g} / " + ("-" if area is None else f"{area:.6g}"), f"{ours[1]:.4g} / {top:.4g}", "" if faults
             else f"{ours[2]:.4g} / " + (moment if isinstance(moment, str) else f"{moment:.4g}")
             + f" ({model.moment()[1]})"]
    return (f"| {repository.split('@')[0]} {repository.split('@')[1][:8]} | {os.path.basename(paths[0])} | "
            f"{len(model.cells)} | {length:.5g} x {width:.5g} | " + " | ".join(words) + " |")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--git", metavar="FOLDER", help="folder with git repositories, in place of GitHub")
    git = parser.parse_args().git
    print("| project, commit | file | cells | length x width (km) | area (km2), ours / header | upper edge (km) | "
          "moment (N m) |\n|---|---|---|---|---|---|---|")
    for entry in FILES:
        with tempfile.TemporaryDirectory() as folder:
            print(row(folder, *entry, git), flush=True)


if __name__ == "__main__":
    main()
