#!/usr/bin/env bash
# GMT's grdinfo says that a netCDF grid ranges from 0 to 0 when the file has no actual_range, and -T builds a colour scale of it.
#
# Seen with GMT 6.4.0 (Debian 12). A grid by netCDF 4.9.0 with the values 1 to 12 and coordinates, as CF asks for and other programs
# write: grdinfo prints v_min 0 and v_max 0, and -C gives the same numbers to scripts, with exit code 0 and no warning. GMT's own files
# carry the attribute actual_range, which CF leaves free. -T1, the option for makecpt, answers -T0/0/1, and -T1/12/1 for a copy by grdmath,
# which has the attribute. grdinfo -M and -L0 read the data and are right. GMT's issue 6765 is about the numbers.
#
# Guess before the run: grdinfo reads the values, or prints NaN for what it does not know.
# Exit code: 0 as seen, 1 when it behaves in another way, 77 when the packages cannot be had.
set -euo pipefail
room=$(mktemp -d)
trap 'rm -rf "$room"' EXIT
cd "$room"
mkdir -p debs/partial tree && : >status
apt-get -qq -y -o Dir::State::status="$room/status" -o Dir::Cache::archives="$room/debs" -o Debug::NoLocking=1 --no-install-recommends \
  --download-only install gmt=6.4.0+dfsg-2 gmt-common=6.4.0+dfsg-2 netcdf-bin=1:4.9.0-3+b1 >apt.log 2>&1 || { tail -3 apt.log; exit 77; }
rm -f debs/libc6_*.deb
for deb in debs/*.deb; do dpkg -x "$deb" tree; done
lib=$room/tree/usr/lib/x86_64-linux-gnu bin=$room/tree/usr/bin
export LD_LIBRARY_PATH=$lib:$room/tree/lib/x86_64-linux-gnu:$room/tree/usr/lib:$lib/blas:$lib/lapack GMT_SHAREDIR=$room/tree/usr/share/gmt GMT_USERDIR=$room

"$bin"/ncgen -4 -o grid.nc <<'CDL'
netcdf grid {
dimensions: y = 3; x = 4;
variables: double x(x); double y(y); float z(y, x); :Conventions = "CF-1.7";
data: x = 0, 1, 2, 3; y = 0, 1, 2; z = 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12;
}
CDL
"$bin"/gmt grdinfo grid.nc >plain.txt 2>said.txt
"$bin"/gmt grdinfo -M grid.nc >read.txt
range=$("$bin"/gmt grdinfo -C grid.nc | cut -f 6,7) scale=$("$bin"/gmt grdinfo -T1 grid.nc)
l0=$("$bin"/gmt grdinfo -C -L0 grid.nc | cut -f 6,7)
"$bin"/gmt grdmath grid.nc 0 ADD = copy.nc
copy=$("$bin"/gmt grdinfo -T1 copy.nc)
grep v_min plain.txt read.txt
echo "grdinfo prints $(wc -l <said.txt) lines of warnings; -C: $range; -C -L0: $l0; -T1: $scale, of a copy by grdmath $copy"
grep -q 'v_min: 0 v_max: 0 ' plain.txt && [ ! -s said.txt ] && [ "$range" = $'0\t0' ] && [ "$l0" = $'1\t12' ] && [ "$scale" = -T0/0/1 ] && [ "$copy" = -T1/12/1 ] &&
  grep -q 'v_min: 1 .*v_max: 12 ' read.txt
