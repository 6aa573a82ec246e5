#!/usr/bin/env bash
# h5diff says nothing and ends with exit code 0, "no differences", for variables whose shape or type differs.
#
# Seen with HDF5's h5diff 1.10.8 on files of netCDF 4.9.0 (Debian 12). h5diff does not compare two datasets with different dimensions, or one
# of integers with one of floating-point numbers: they are "not comparable". Without -q a line says so, with -q nothing does, and the exit
# code is 0 both ways, which its help calls "no differences"; a changed value ends with 1. A test by "h5diff -q" passes
# a result with half of the steps, or with other values in another shape. Also look for "not comparable" in the output of h5diff -c.
#
# Guess before the run: exit code 1, as for any other difference.
# Exit code: 0 as seen, 1 when it behaves in another way, 77 when the packages cannot be had.
set -euo pipefail
room=$(mktemp -d)
trap 'rm -rf "$room"' EXIT
cd "$room"
mkdir -p debs/partial tree && : >status
apt-get -qq -y -o Dir::State::status="$room/status" -o Dir::Cache::archives="$room/debs" -o Debug::NoLocking=1 --no-install-recommends \
  --download-only install hdf5-tools=1.10.8+repack1-1 netcdf-bin=1:4.9.0-3+b1 >apt.log 2>&1 || { tail -3 apt.log; exit 77; }
rm -f debs/libc6_*.deb
for deb in debs/*.deb; do dpkg -x "$deb" tree; done
lib=$room/tree/usr/lib/x86_64-linux-gnu bin=$room/tree/usr/bin
export LD_LIBRARY_PATH=$lib:$room/tree/lib/x86_64-linux-gnu:$lib/blas:$lib/lapack

write() { # file, type, values
  echo "netcdf run { dimensions: x = $(echo "$3" | tr ',' '\n' | wc -l); variables: $2 slip(x); data: slip = $3; }" | "$bin"/ncgen -4 -o "$1".nc
}
write first double 1,2,3,4
write half double 7,8
write integers int 5,6,7,8
write value double 1,2,3,5
seen=
for file in first half integers value; do
  code=0 others=$("$bin"/h5diff -c first.nc $file.nc slip | grep -c 'Not comparable: </slip>' || true)
  said=$("$bin"/h5diff -q first.nc $file.nc slip) || code=$?
  echo "first.nc and $file.nc: h5diff -q prints '$said', exit code $code; h5diff -c finds $others not comparable"
  seen+="$code$others "
done
"$bin"/h5diff --help | grep -A 1 'Exit code'
[ "$seen" = "00 01 01 10 " ]
