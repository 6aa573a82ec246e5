#!/usr/bin/env bash
# meshio writes Exodus, Abaqus and Nastran files without the data of cells and does not say so.
#
# Seen with Debian 12's python3-meshio 7.0.0-3, which calls itself 5.0.0. A mesh of two triangles has the slip of points and of cells and a number
# of the fault of each cell. In .vtu and .xdmf all are there. For .mesh, which holds one number of a cell, meshio warns that it skips
# slip. In .e (Exodus, which has variables of elements), .inp and .nas the data of cells is gone, with no warning and exit code 0;
# .e keeps those of points, the others lose these too. A mesh so converted has lost the numbers of its faults.
#
# Guess before the run: each format keeps the data of cells, or a warning names what it skips, as for .mesh.
# Exit code: 0 as seen, 1 when it behaves in another way, 77 when the packages cannot be had.
set -euo pipefail
room=$(mktemp -d)
trap 'rm -rf "$room"' EXIT
cd "$room"
mkdir -p debs/partial tree && : >status
apt-get -qq -y -o Dir::State::status="$room/status" -o Dir::Cache::archives="$room/debs" -o Debug::NoLocking=1 --no-install-recommends \
  --download-only install python3-meshio=7.0.0-3 python3-h5py-serial=3.7.0-8 python3-netcdf4=1.6.2-1+b1 >apt.log 2>&1 || { tail -3 apt.log; exit 77; }
rm -f debs/libc6_*.deb
for deb in debs/*.deb; do dpkg -x "$deb" tree; done
lib=$room/tree/usr/lib/x86_64-linux-gnu bin=$room/tree/usr/bin
export LD_LIBRARY_PATH=$lib:$room/tree/lib/x86_64-linux-gnu:$lib/blas:$lib/lapack

PYTHONHOME=$room/tree/usr OPENBLAS_NUM_THREADS=1 "$bin"/python3.11 - <<'PY'
import contextlib
import io
import sys
import warnings
sys.path.insert(0, "tree/usr/lib/python3/dist-packages")
warnings.simplefilter("ignore")
import meshio
import netCDF4  # warns once of numpy
import numpy as np

mesh = meshio.Mesh(np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]), [("triangle", np.array([[0, 1, 2], [0, 2, 3]]))],
                   point_data={"slip": np.array([0.0, 0.5, 1.0, 1.5])},
                   cell_data={"fault": [np.array([7, 8])], "slip": [np.array([0.25, 0.75])]})
print("meshio", meshio.__version__)
seen = {}
for kind in ["vtu", "xdmf", "mesh", "e", "inp", "nas"]:
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err), warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        meshio.write("mesh." + kind, mesh)
    said = " ".join((out.getvalue() + err.getvalue()).split() + [str(w.message) for w in caught])
    back = meshio.read("mesh." + kind)
    seen[kind] = sorted(back.cell_data), sorted(back.point_data), said != ""
    print(f".{kind}: cells {sum(len(c.data) for c in back.cells)}, data of cells {seen[kind][0]}, of points {seen[kind][1]}; said: {said or 'nothing'}")
full = ["fault", "slip"]
sys.exit(not (seen["vtu"] == seen["xdmf"] == (full, ["slip"], False) and seen["mesh"][0] == ["medit:ref"] and seen["mesh"][2] and
              seen["e"] == ([], ["slip"], False) and seen["inp"] == seen["nas"] == ([], [], False)))
PY
