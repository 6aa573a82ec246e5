#!/usr/bin/env bash
# netCDF passes over HDF5's booleans, complex numbers and references in silence: variables and attributes are not there.
#
# Seen with netCDF 4.9.0 and h5py 3.7.0 (Debian 12). h5py stores bool as an enumeration, which netCDF-4 has as a type. ncdump of a
# file with a dataset of floats, one of booleans, one of complex numbers, and attributes of both kinds shows the floats only, with exit
# code 0 and not a word: netCDF takes only types that the file names ("committed"). A mask or a flag "complete" that h5py wrote is lost to every reader
# above netCDF (xarray by default, NCO, Panoply). A named enumeration, as the second file has it, is shown.
#
# Guess before the run: enumerations are shown as such, and what cannot be shown is an error or a warning.
# Exit code: 0 as seen, 1 when it behaves in another way, 77 when the packages cannot be had.
set -euo pipefail
room=$(mktemp -d)
trap 'rm -rf "$room"' EXIT
cd "$room"
mkdir -p debs/partial tree && : >status
apt-get -qq -y -o Dir::State::status="$room/status" -o Dir::Cache::archives="$room/debs" -o Debug::NoLocking=1 --no-install-recommends \
  --download-only install python3-h5py-serial=3.7.0-8 netcdf-bin=1:4.9.0-3+b1 >apt.log 2>&1 || { tail -3 apt.log; exit 77; }
rm -f debs/libc6_*.deb
for deb in debs/*.deb; do dpkg -x "$deb" tree; done
lib=$room/tree/usr/lib/x86_64-linux-gnu
export LD_LIBRARY_PATH=$lib:$room/tree/lib/x86_64-linux-gnu:$lib/blas:$lib/lapack

PYTHONHOME=$room/tree/usr tree/usr/bin/python3.11 - <<'PY'
import sys
sys.path.insert(0, "tree/usr/lib/python3/dist-packages")
import h5py
import numpy as np

with h5py.File("plain.h5", "w") as file:
    file["slip"] = [0.5, 1.5]
    file["slides"] = np.array([True, False])
    file["modes"] = np.array([1 + 2j, 3])
    file.attrs["complete"] = True
    file.attrs["runs"] = 3
with h5py.File("named.h5", "w") as file:
    file["boolean"] = h5py.enum_dtype({"FALSE": 0, "TRUE": 1}, basetype="i1")
    file.create_dataset("slides", (2,), dtype=file["boolean"])[:] = [1, 0]
PY
tree/usr/bin/ncdump -h plain.h5 | tee plain.cdl
tree/usr/bin/ncdump -h named.h5 | tee named.cdl
grep -q 'double slip' plain.cdl && grep -q ':runs = 3' plain.cdl && ! grep -q 'slides\|modes\|complete' plain.cdl && grep -q 'boolean slides' named.cdl
