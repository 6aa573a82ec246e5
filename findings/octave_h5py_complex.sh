#!/usr/bin/env bash
# Octave reads complex numbers of h5py as zeros: the numbers are complex, as many as there were, and each is 0.
#
# Seen with Octave 7.3.0 and h5py 3.7.0 (Debian 12). h5py writes a complex number as a compound with the members "r" and "i", which others
# have taken over. Octave's load() knows compounds with "real" and "imag", takes this one for complex, and HDF5 fills in what it finds under
# those names: nothing. Other compounds get the warning "unknown datatype"; this one gets none. What Octave saves by "save -hdf5" h5py reads
# as a compound of real and imag. Spectra and modes are best kept as two datasets, of real and imaginary parts.
#
# Guess before the run: the numbers, or a warning and no variable.
# Exit code: 0 as seen, 1 when it behaves in another way, 77 when the packages cannot be had.
set -euo pipefail
room=$(mktemp -d)
trap 'rm -rf "$room"' EXIT
cd "$room"
mkdir -p debs/partial tree && : >status
apt-get -qq -y -o Dir::State::status="$room/status" -o Dir::Cache::archives="$room/debs" -o Debug::NoLocking=1 --no-install-recommends \
  --download-only install octave=7.3.0-2 python3-h5py-serial=3.7.0-8 >apt.log 2>&1 || { tail -3 apt.log; exit 77; }
rm -f debs/libc6_*.deb debs/libc6-dev_*.deb
for deb in debs/*.deb; do dpkg -x "$deb" tree; done
lib=$room/tree/usr/lib/x86_64-linux-gnu
export LD_LIBRARY_PATH=$lib:$room/tree/lib/x86_64-linux-gnu:$room/tree/usr/lib:$lib/blas:$lib/lapack:$lib/pulseaudio:$lib/octave/7.3.0
export OCTAVE_HOME=$room/tree/usr OCTAVE_EXEC_HOME=$room/tree/usr HWLOC_COMPONENTS=-opencl OPENBLAS_NUM_THREADS=1

PYTHONHOME=$room/tree/usr tree/usr/bin/python3.11 - <<'PY'
import sys
sys.path.insert(0, "tree/usr/lib/python3/dist-packages")
import h5py
import numpy as np

with h5py.File("modes.h5", "w") as file:
    file["slip"] = [0.5, 1.5]
    file["modes"] = np.array([1 + 2j, 3, 4j])
    file["single"] = np.array([1 + 2j], "c8")
with h5py.File("modes.h5") as file:
    print("h5py:", file["modes"][:], file["single"][:])
PY
cat >try.m <<'M'
d = load("modes.h5");
printf("Octave: slip %s; modes of %d: %s; single: %s; complex: %d\n", mat2str(d.slip), numel(d.modes), mat2str(d.modes), mat2str(d.single), iscomplex(d.modes));
exit(!(isequal(d.slip, [0.5 1.5]) && numel(d.modes) == 3 && all(d.modes == 0) && all(d.single == 0) && iscomplex(d.modes)));
M
tree/usr/bin/octave-cli --no-gui --no-init-file --no-site-file -q try.m 2>error.txt || { cat error.txt; exit 1; }
echo "warnings about modes: $(grep -c 'modes\|single\|unknown' error.txt || true)"
! grep -q 'modes\|single\|unknown' error.txt
