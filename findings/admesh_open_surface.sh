#!/usr/bin/env bash
# admesh closes an open surface by default: a fault gets facets that nobody drew.
#
# Seen with admesh 0.98.4 (Debian 12). STL files of faults are open surfaces. `admesh -a OUT IN`, without any option of repair,
# makes a square of 32 facets one of 46: it closes the boundary by facets within the same plane, folded back over the square, so
# the area is twice that of the fault and some facets look down. The exit code is 0. With `--exact` alone, the check of edges
# that match, nothing is added.
#
# Guess before the run: without an option of repair the facets are only checked and copied.
# Exit code: 0 as seen, 1 when it behaves in another way, 77 when the packages cannot be had.
set -euo pipefail
room=$(mktemp -d)
trap 'rm -rf "$room"' EXIT
cd "$room"
apt-get -qq download admesh=0.98.4-2 libadmesh1=0.98.4-2 >apt.log 2>&1 || { tail -3 apt.log; exit 77; }
for deb in *.deb; do dpkg -x "$deb" tree; done
admesh() { LD_LIBRARY_PATH=tree/usr/lib/x86_64-linux-gnu tree/usr/bin/admesh "$@"; }

# a square of 4 x 4 quadrilaterals, two facets each, all counterclockwise seen from above
awk 'function facet(a, b, c, d, e, f) {
    printf "facet normal 0 0 1\n outer loop\n  vertex %d %d 0\n  vertex %d %d 0\n  vertex %d %d 0\n endloop\nendfacet\n", a, b, c, d, e, f
  }
  BEGIN {
    print "solid fault"
    for (i = 0; i < 4; i++) for (j = 0; j < 4; j++) { facet(i, j, i + 1, j, i + 1, j + 1); facet(i, j, i + 1, j + 1, i, j + 1) }
    print "endsolid fault"
  }' >in.stl
facts() { # FILE: facets, area, facets that look down
  awk '$1 == "vertex" { x[n % 3] = $2; y[n % 3] = $3; n++
      if (n % 3 == 0) { s = ((x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0])) / 2; area += s < 0 ? -s : s; down += s < 0 } }
    END { printf "%d facets, area %g, %d look down\n", n / 3, area, down }' "$1"
}
admesh -a default.stl in.stl >default.log
admesh --exact -a exact.stl in.stl >exact.log
for name in in default exact; do echo "$name: $(facts $name.stl)"; done
grep 'Facets added' default.log
[ "$(facts in.stl)" = "32 facets, area 16, 0 look down" ] && grep -q 'Facets added *: *14$' default.log && grep -q '^46 facets' <(facts default.stl)
