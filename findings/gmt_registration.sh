#!/usr/bin/env bash
# GMT reads a netCDF grid as one of pixels when its first coordinate is half a step off zero, and then extrapolates past the points.
#
# Seen with GMT 6.4.0 (Debian 12). Two grids by netCDF 4.9.0 have the same values, 1 to 12, on 4 by 3 points one apart: the first starts at 0
# and is "gridline", with x from 0 to 3; the second starts at 0.5 and becomes "pixel", with x from 0 to 4. Nothing in either file
# speaks of cells (no bounds, no node_offset), and no warning is printed. A point 0.3 to the left of and below the first point is outside
# of the first grid for grdtrack; in the second it gets -0.6, though the least value is 1. With the attribute node_offset = 0,
# GMT's own, the second grid is gridline too, with a warning about a guess.
#
# Guess before the run: gridline registration for both, as coordinates of CF are those of points and no attribute says else.
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

grid() { # file, x, y, global attributes
  echo "netcdf grid { dimensions: y = 3; x = 4; variables: double x(x); double y(y); float z(y, x); :Conventions = \"CF-1.7\"; $4
    data: x = $2; y = $3; z = 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12; }" | "$bin"/ncgen -4 -o "$1".nc
}
grid zero "0, 1, 2, 3" "0, 1, 2" ""
grid half "0.5, 1.5, 2.5, 3.5" "0.5, 1.5, 2.5" ""
grid said "0.5, 1.5, 2.5, 3.5" "0.5, 1.5, 2.5" ":node_offset = 0;"
echo "-0.3 -0.3" >zero.txt
echo "0.2 0.2" >half.txt
cp half.txt said.txt
for file in zero half said; do
  "$bin"/gmt grdinfo -C $file.nc 2>$file.warning | cut -f 2-5,12 >$file.range
  "$bin"/gmt grdtrack $file.txt -G$file.nc >$file.value 2>$file.said
  echo "$file.nc: x and y from and to, pixels or not: $(tr '\t' ' ' <$file.range); at $(cat $file.txt): '$(tr '\t' ' ' <$file.value)' $(cat $file.said)"
done
[ ! -s half.warning ] && [ "$(cat zero.range half.range said.range)" = $'0\t3\t0\t2\t0\n0\t4\t0\t3\t1\n0.5\t3.5\t0.5\t2.5\t0' ] &&
  [ ! -s zero.value ] && [ ! -s said.value ] && grep -q '^0.2	0.2	-0.6' half.value
