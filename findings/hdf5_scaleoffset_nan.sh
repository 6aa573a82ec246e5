#!/usr/bin/env bash
# HDF5's scale-offset filter turns NaN into the least number of its chunk, without an error.
#
# Seen with HDF5 1.10.8 and h5py 3.7.0 (Debian 12). The filter keeps floating-point numbers to so many decimal digits and is what
# people take to make fields small. NaN, which marks cells without a value, comes back as the minimum of the chunk: [1.25, NaN,
# 3.5, 2.125] becomes [1.25, 1.25, 3.5, 2.125], even where the fill value is NaN itself. A chunk that has an infinite number is
# stored as it is, by eight bytes a number, and keeps it.
#
# Guess before the run: NaN stays NaN, or the filter refuses it.
# Exit code: 0 as seen, 1 when it behaves in another way, 77 when the packages cannot be had.
set -euo pipefail
room=$(mktemp -d)
trap 'rm -rf "$room"' EXIT
cd "$room"
mkdir -p debs/partial tree && : >status
apt-get -qq -y -o Dir::State::status="$room/status" -o Dir::Cache::archives="$room/debs" -o Debug::NoLocking=1 \
  --no-install-recommends --download-only install python3-h5py-serial=3.7.0-8 libhdf5-103-1=1.10.8+repack1-1 >apt.log 2>&1 ||
  { tail -3 apt.log; exit 77; }
rm -f debs/libc6_*.deb
for deb in debs/*.deb; do dpkg -x "$deb" tree; done
export LD_LIBRARY_PATH=tree/usr/lib/x86_64-linux-gnu:tree/lib/x86_64-linux-gnu:tree/usr/lib/x86_64-linux-gnu/blas:tree/usr/lib/x86_64-linux-gnu/lapack

PYTHONHOME=$room/tree/usr tree/usr/bin/python3.11 - <<'PY'
import sys
sys.path.insert(0, "tree/usr/lib/python3/dist-packages")
import h5py
import numpy as np

print("h5py", h5py.version.version, "HDF5", h5py.version.hdf5_version)
values = [1.25, np.nan, 3.5, 2.125]
infinite = [1.25, np.inf, 3.5, 2.125]
with h5py.File("a.h5", "w") as file:
    for name, data, fill in (("plain", values, None), ("fill", values, np.nan), ("infinite", infinite, None)):
        file.create_dataset(name, data=data, chunks=(4,), scaleoffset=3, fillvalue=fill)
with h5py.File("a.h5") as file:
    read = {name: file[name][...] for name in file}
    size = {name: file[name].id.get_storage_size() for name in file}
print("written      ", values)
for name in read:
    print(f"{name:13s}", read[name], size[name], "bytes")
least = np.array([1.25, 1.25, 3.5, 2.125])
ok = np.allclose(read["plain"], least) and np.allclose(read["fill"], least) and np.isinf(read["infinite"][1])
sys.exit(0 if ok else 1)
PY
