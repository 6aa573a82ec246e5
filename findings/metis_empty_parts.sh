#!/usr/bin/env bash
# METIS_PartGraphKway leaves parts empty on small graphs, and reports success.
#
# Seen with METIS 5.1.0 (Debian 12), default options, no weights. A path of 24 vertices, as the cells of a fault along strike, in
# 23 parts: METIS_OK, and more than half of the parts have no vertex while others have three. In 8 parts of 8 vertices five stay
# empty. The recursive bisection has at most two empty parts there. Who gives each part to a process must expect
# processes without a vertex, or ask for fewer parts.
#
# Guess before the run: one or two vertices a part, none empty, as the imbalance that METIS allows by default is 3 %.
# Exit code: 0 as seen, 1 when it behaves in another way, 77 when the packages cannot be had.
set -euo pipefail
room=$(mktemp -d)
trap 'rm -rf "$room"' EXIT
cd "$room"
apt-get -qq download libmetis5=5.1.0.dfsg-7 libmetis-dev=5.1.0.dfsg-7 >apt.log 2>&1 || { tail -3 apt.log; exit 77; }
for deb in *.deb; do dpkg -x "$deb" tree; done

cat >try.c <<'C'
#include <metis.h>
#include <stdio.h>

/* How many of the parts of a path of n vertices have none; *largest is the largest part */
static int Empty(int recursive, idx_t n, idx_t parts, int *largest)
{
  idx_t begin[64], next[128], part[64], k = 0, one = 1, cut, options[METIS_NOPTIONS];
  int   count[64] = {0}, empty = 0;

  for (idx_t i = 0; i < n; i++) {
    begin[i] = k;
    if (i) next[k++] = i - 1;
    if (i < n - 1) next[k++] = i + 1;
  }
  begin[n] = k;
  METIS_SetDefaultOptions(options);
  options[METIS_OPTION_SEED] = 1;
  if ((recursive ? METIS_PartGraphRecursive : METIS_PartGraphKway)(&n, &one, begin, next, NULL, NULL, NULL, &parts, NULL, NULL, options, &cut, part) !=
      METIS_OK)
    return -1;
  for (idx_t i = 0; i < n; i++) count[part[i]]++;
  *largest = 0;
  for (idx_t i = 0; i < parts; i++) {
    empty += !count[i];
    if (count[i] > *largest) *largest = count[i];
  }
  return empty;
}

int main(void)
{
  const idx_t size[][2] = {{8, 8}, {12, 10}, {24, 23}};
  int         seen      = 1;

  for (int i = 0; i < 3; i++) {
    int large, rlarge, kway = Empty(0, size[i][0], size[i][1], &large), recursive = Empty(1, size[i][0], size[i][1], &rlarge);

    printf("%2d vertices, %2d parts: kway %d empty, largest %d; recursive %d empty, largest %d\n", (int)size[i][0], (int)size[i][1], kway, large, recursive,
           rlarge);
    seen = seen && 2 * kway > (int)size[i][1] && large >= 3 && recursive >= 0 && recursive <= 2;
  }
  return !seen;
}
C
cc -I tree/usr/include try.c -o try -L tree/usr/lib/x86_64-linux-gnu -lmetis
LD_LIBRARY_PATH=tree/usr/lib/x86_64-linux-gnu ./try
