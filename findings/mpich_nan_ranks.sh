#!/usr/bin/env bash
# MPI_Allreduce() with MPI_MAX gives the ranks different results when one of them has NaN: some get NaN, others a number.
#
# Seen with MPICH 4.0.2 (Debian 12). Rank k of n has k + 1, but one has NaN, and all take the largest. With 2 ranks the one that has NaN
# gets the number and the other one NaN; with 4 ranks the results are, for NaN on the last one, NaN, 3, 2 and 3: not even the numbers agree.
# MPI_MIN does the same. For ten values and more the ranks agree, but the NaN is lost in three of four cases. Programs that test the result,
# "end if the error is not finite", then go different ways on different ranks, and wait for each other. Open MPI 4.1.4 gave all ranks the
# same, with the NaN lost unless rank 0 had it. MPI defines no order of NaN; reduce a flag of isnan() along with the number.
#
# Guess before the run: NaN may get lost, but all ranks get the same result, as they have to decide by it.
# Exit code: 0 as seen, 1 when it behaves in another way, 77 when the packages cannot be had.
set -euo pipefail
room=$(mktemp -d)
trap 'rm -rf "$room"' EXIT
cd "$room"
mkdir -p debs/partial tree && : >status
apt-get -qq -y -o Dir::State::status="$room/status" -o Dir::Cache::archives="$room/debs" -o Debug::NoLocking=1 --no-install-recommends \
  --download-only install mpich=4.0.2-3+b1 libmpich-dev=4.0.2-3+b1 >apt.log 2>&1 || { tail -3 apt.log; exit 77; }
rm -f debs/libc6_*.deb debs/libc6-dev_*.deb
for deb in debs/*.deb; do dpkg -x "$deb" tree; done
lib=$room/tree/usr/lib/x86_64-linux-gnu

cat >try.c <<'C'
#include <math.h>
#include <mpi.h>
#include <stdio.h>
#include <stdlib.h>

int main(int argc, char **argv)
{
  int rank, ranks, apart = 0, cases = 0, lost = 0;

  MPI_Init(&argc, &argv);
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  for (int n = 1; n <= 10; n += 9)
    for (int bad = 0; bad < ranks; bad++) {
      double mine[10], most[10], all[16];
      int    nans = 0;

      for (int i = 0; i < n; i++) mine[i] = rank == bad ? NAN : rank + 1;
      MPI_Allreduce(mine, most, n, MPI_DOUBLE, MPI_MAX, MPI_COMM_WORLD);
      MPI_Gather(most, 1, MPI_DOUBLE, all, 1, MPI_DOUBLE, 0, MPI_COMM_WORLD);
      if (rank) continue;
      printf("%d of %d ranks, %2d values, NaN on rank %d: the largest is", ranks, ranks, n, bad);
      for (int k = 0; k < ranks; k++) {
        printf(" %g", all[k]);
        nans += isnan(all[k]) != 0;
      }
      puts("");
      if (n == 1) apart += nans > 0 && nans < ranks;
      else lost += nans == 0;
      if (n > 1 && nans > 0 && nans < ranks) cases = 1000;
      cases++;
    }
  if (!rank) printf("%d ranks: in %d of %d cases they do not agree about one value\n", ranks, apart, ranks);
  MPI_Finalize();
  /* the number of cases where ranks differ, +100 when they differ for ten values */
  return rank ? 0 : apart + (cases >= 1000 ? 100 : 0);
}
C
cc -I tree/usr/include/x86_64-linux-gnu/mpich try.c -o try "$lib"/libmpich.so -Wl,--allow-shlib-undefined -lm
export LD_LIBRARY_PATH=$lib:$room/tree/lib/x86_64-linux-gnu HWLOC_COMPONENTS=-opencl
seen=true
for ranks in 2 4; do
  apart=0
  timeout 60 tree/usr/bin/mpiexec.hydra -n $ranks ./try || apart=$?
  [ "$apart" = $ranks ] || seen=false
done
$seen
