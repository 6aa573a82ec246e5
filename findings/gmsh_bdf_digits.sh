#!/usr/bin/env bash
# Gmsh writes Nastran files with eight characters for a coordinate: a northing of 4123456.789 m becomes 4.12E+06.
#
# Seen with Gmsh 4.8.4 (Debian 12). "gmsh -2 -o fault.bdf" chooses fields of eight characters (Mesh.BdfFieldFormat = 1) whatever the numbers
# need. A plane of 1 km in UTM coordinates that dips by 45 degrees, with eastings from 512345.678 and northings from 4123456.789, keeps its
# eastings to 0.1 m, but all of its northings are one number, 4120000: the file has a vertical plane, 3.5 to 4.5 km further south. There is
# no warning. Abaqus', STL, UNV and VTK files of the same mesh keep the millimetre. Mesh.BdfFieldFormat = 2 asks for fields of sixteen
# characters, which keep the centimetre. An origin near the fault helps as well.
#
# Guess before the run: seven digits or more, as of floats, by long fields where short ones do not hold the number.
# Exit code: 0 as seen, 1 when it behaves in another way, 77 when the packages cannot be had.
set -euo pipefail
room=$(mktemp -d)
trap 'rm -rf "$room"' EXIT
cd "$room"
mkdir -p debs/partial tree && : >status
apt-get -qq -y -o Dir::State::status="$room/status" -o Dir::Cache::archives="$room/debs" -o Debug::NoLocking=1 \
  --no-install-recommends --download-only install gmsh=4.8.4+ds2-3 >apt.log 2>&1 || { tail -3 apt.log; exit 77; }
rm -f debs/libc6_*.deb
for deb in debs/*.deb; do dpkg -x "$deb" tree; done
lib=tree/usr/lib/x86_64-linux-gnu
gmsh() { LD_LIBRARY_PATH=$lib:tree/lib/x86_64-linux-gnu:$lib/blas:$lib/lapack:$lib/pulseaudio HWLOC_COMPONENTS=-opencl tree/usr/bin/gmsh -nopopup -v 2 "$@"; }

cat >fault.geo <<'GEO'
Point(1) = {512345.678, 4123456.789, -1234.5, 1e3}; Point(2) = {513345.678, 4123456.789, -1234.5, 1e3};
Point(3) = {513345.678, 4124456.789, -2234.5, 1e3}; Point(4) = {512345.678, 4124456.789, -2234.5, 1e3};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4}; Plane Surface(1) = {1}; Physical Surface("fault", 7) = {1};
GEO
gmsh -2 -o short.bdf fault.geo 2>&1 | tee said.txt
gmsh -2 -setnumber Mesh.BdfFieldFormat 2 -o long.bdf fault.geo
gmsh -2 -o fault.inp fault.geo
grep -m 3 '^GRID' short.bdf
grep -m 1 -A 1 '^GRID' long.bdf
# fields of 8 characters: GRID, number, frame, x, y, z; of 16: GRID*, number, frame, x, y and, on the next line, z
short=$(grep '^GRID' short.bdf | cut -c 33-40 | sort -u) long=$(grep '^GRID' long.bdf | cut -c 57-72 | sort -u | wc -l)
inp=$(sed -n '/^\*NODE/,/^\*\*/p' fault.inp | awk -F, 'NF == 4 { print $3 }' | sort -u | wc -l)
echo "northings of short fields: $(xargs <<<"$short"); numbers of them in long fields: $long, in Abaqus' format: $inp; lines of warnings: $(wc -l <said.txt)"
[ "$(xargs <<<"$short")" = 4.12E+06 ] && [ "$long" -gt 2 ] && [ "$inp" -gt 2 ] && [ ! -s said.txt ]
