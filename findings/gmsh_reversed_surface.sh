#!/usr/bin/env bash
# Gmsh reverses the triangles of a reversed physical surface in format 2.2, but leaves them as they are in 4.1.
#
# Seen with Gmsh 4.8.4 (Debian 12). A physical group that lists a surface by its negative number, Physical Surface(7) = {-1},
# asks for the opposite normal, which for a fault says which side is the hanging wall. Saved as 2.2, the corners of the triangles
# are in reversed order. Saved as 4.1, $Elements has the same triangles as without the sign: it stands in $Entities, as physical
# group -7 of the surface, and a reader has to turn them around by itself. Gmsh does when it opens the file.
#
# Guess before the run: the same triangles in both formats, as both are the same mesh.
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
gmsh() { LD_LIBRARY_PATH=$lib:tree/lib/x86_64-linux-gnu:$lib/blas:$lib/lapack:$lib/pulseaudio HWLOC_COMPONENTS=-opencl tree/usr/bin/gmsh -nopopup -v 1 "$@"; }

square() { # SIGN
  cat <<GEO
Point(1) = {0, 0, 0, 1}; Point(2) = {1, 0, 0, 1}; Point(3) = {1, 1, 0, 1}; Point(4) = {0, 1, 0, 1};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4}; Plane Surface(1) = {1};
Physical Surface("fault", 7) = {${1}1};
GEO
}
up() { # FILE of format 2.2 or 4.1: how many triangles of $Elements look up, and how many there are
  awk '/^\$MeshFormat/ { getline; v = $1 }
    /^\$Nodes/ && v < 4 { getline; n = $1; for (i = 0; i < n; i++) { getline; x[$1] = $2; y[$1] = $3 } }
    /^\$Nodes/ && v > 4 { getline; n = $1; for (i = 0; i < n; i++) { getline; m = $4
      for (j = 0; j < m; j++) { getline; tag[j] = $1 } for (j = 0; j < m; j++) { getline; x[tag[j]] = $1; y[tag[j]] = $2 } } }
    /^\$Elements/ && v < 4 { getline; n = $1; for (i = 0; i < n; i++) { getline; if ($2 == 2) count($(NF - 2), $(NF - 1), $NF) } }
    /^\$Elements/ && v > 4 { getline; n = $1; for (i = 0; i < n; i++) { getline; m = $4; kind = $3
      for (j = 0; j < m; j++) { getline; if (kind == 2) count($2, $3, $4) } } }
    function count(a, b, c) { all++; up += (x[b] - x[a]) * (y[c] - y[a]) - (x[c] - x[a]) * (y[b] - y[a]) > 0 }
    END { print up + 0 " of " all }' "$1"
}
square "" >plain.geo
square - >reversed.geo
for name in plain reversed; do
  gmsh -2 -format msh22 -o $name.22.msh $name.geo
  gmsh -2 -format msh41 -o $name.41.msh $name.geo
  gmsh -0 -save -format msh22 -o $name.41to22.msh $name.41.msh # 4.1, opened by Gmsh
  echo "$name: triangles that look up, 2.2: $(up $name.22.msh); 4.1: $(up $name.41.msh); 4.1 opened by Gmsh and saved as 2.2: $(up $name.41to22.msh)"
done
echo "the surface in \$Entities of 4.1: $(grep '^1 0 0 0 1 1 0 ' reversed.41.msh)"
all=$(up plain.22.msh) && all=${all#* of }
[ "$(up plain.22.msh)" = "$all of $all" ] && [ "$(up reversed.22.msh)" = "0 of $all" ] && [ "$(up reversed.41.msh)" = "$all of $all" ] && [ "$(up reversed.41to22.msh)" = "0 of $all" ] &&
  grep -q '^1 0 0 0 1 1 0 1 -7 ' reversed.41.msh
