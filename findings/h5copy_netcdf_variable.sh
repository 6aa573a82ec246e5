#!/usr/bin/env bash
# A variable that h5copy takes out of a netCDF file makes a file that netCDF cannot read, also with its dimensions and -f ref.
#
# Seen with HDF5's h5copy 1.10.8 and netCDF 4.9.0 (Debian 12). netCDF-4 keeps the dimensions of a variable as object references within a
# list of variable length (DIMENSION_LIST, HDF5's dimension scales). h5copy copies the attribute and turns each reference into a
# null one, with exit code 0; -f ref, "copy references and any referenced objects", does not reach them either. ncdump of the
# copy ends with "NetCDF: HDF error", though h5dump shows all values. -f noattr makes a copy that can be read, without units and
# with phony dimensions; nccopy -V does it right.
#
# Guess before the run: the copy can be read and has lost at most the names of its dimensions; with dimensions and -f ref it has all.
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

cat >run.cdl <<'CDL'
netcdf run {
dimensions: time = UNLIMITED; x = 3;
variables: double time(time); time:units = "s"; double x(x); float slip(time, x); slip:units = "m";
data: time = 0, 1; x = 1, 2, 3; slip = 1, 2, 3, 4, 5, 6;
}
CDL
"$bin"/ncgen -4 -o run.nc run.cdl
"$bin"/h5copy -i run.nc -o alone.nc -s slip -d slip
for name in time x slip; do "$bin"/h5copy -f ref -i run.nc -o all.nc -s $name -d $name; done
"$bin"/h5copy -f noattr -i run.nc -o bare.nc -s slip -d slip
"$bin"/nccopy -V time,x,slip run.nc right.nc
for file in alone all bare right; do
  code=0
  "$bin"/ncdump -v slip $file.nc >$file.cdl 2>$file.txt || code=$?
  echo "ncdump of $file.nc: exit code $code, $(grep -c 'float slip' $file.cdl || true) variable slip, $(head -1 $file.txt)"
done
"$bin"/h5dump -d slip all.nc >all.ddl
grep 'GROUP 0' all.ddl
grep -q 'HDF error' alone.txt && grep -q 'HDF error' all.txt && grep -q '4, 5, 6' all.ddl && grep -q 'slip(phony_dim_0, phony_dim_1)' bare.cdl &&
  grep -q 'slip(time, x)' right.cdl
