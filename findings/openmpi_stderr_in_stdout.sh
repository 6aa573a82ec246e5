#!/usr/bin/env bash
# Open MPI's mpirun writes pieces of a rank's stderr to its own stdout.
#
# Seen with Open MPI 5.0.7 (Debian 13, with its PRRTE and PMIx). Rank 0 of two writes the line "warning: slow" to stderr by two calls of write(),
# then a line to stdout, 20 times. In 16 of 60 runs of "mpirun -n 2 ./try >out 2>err" some pieces "warning: " (1 to 9 of 20) were in out, in front of
# a result, and missing in err; no byte is lost, and none of stdout came to err. Lines that go to stderr by one write() stayed there
# in 60 runs. glibc 2.41 writes a long fprintf() to stderr in pieces of 128 bytes, so that programs need no write() of their own for it.
# Open MPI 4.1.4 (Debian 12) kept the streams apart in 40 runs. setvbuf(stderr, NULL, _IOLBF, size) makes one write() of a line.
#
# The script runs Debian 13's packages in a chroot of its own, by unshare, and stops at the first run with a piece in out, of up to 120.
#
# Guess before the run: the two streams of a rank may come in another order, but a byte never changes from one to the other.
# Exit code: 0 as seen, 1 when it behaves in another way, 77 when the packages cannot be had or a chroot is not allowed.
set -euo pipefail
room=$(mktemp -d)
trap 'rm -rf "$room"' EXIT
cd "$room"
unshare -rm chroot / true 2>/dev/null || { echo "unshare cannot make a chroot here"; exit 77; }
mkdir -p debs/partial lists/partial tree && : >status
echo "deb [signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] http://deb.debian.org/debian trixie main" >sources
apt=(apt-get -qq -y -o Dir::Etc::sourcelist="$room/sources" -o Dir::Etc::sourceparts=- -o Dir::State::lists="$room/lists" -o Dir::State::status="$room/status"
  -o Dir::Cache::archives="$room/debs" -o Dir::Cache::pkgcache= -o Dir::Cache::srcpkgcache= -o Debug::NoLocking=1 --no-install-recommends)
{ "${apt[@]}" update && "${apt[@]}" --download-only install openmpi-bin=5.0.7-1 libopenmpi40=5.0.7-1 libpmix2t64=5.0.7-1 bash coreutils base-files &&
  "${apt[@]}" download libopenmpi-dev=5.0.7-1; } >apt.log 2>&1 || { tail -3 apt.log; exit 77; }
dpkg -x debs/base-files_*.deb tree
for deb in debs/*.deb libopenmpi-dev_*.deb; do dpkg -x "$deb" tree; done
mpi=tree/usr/lib/x86_64-linux-gnu

cat >try.c <<'C'
#include <mpi.h>
#include <stdio.h>
#include <unistd.h>

int main(int argc, char **argv)
{
  int rank;

  MPI_Init(&argc, &argv);
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  if (!rank) {
    for (int k = 0; k < 20; k++) {
      char line[32];
      int  size = sprintf(line, "result %d\n", k);

      if (write(2, "warning: ", 9) != 9 || write(2, "slow\n", 5) != 5 || write(1, line, size) != size) return 2;
    }
  }
  MPI_Finalize();
  return 0;
}
C
cc -I $mpi/openmpi/include try.c -o tree/try $mpi/libmpi.so.40 -Wl,--allow-shlib-undefined
cat >tree/runs.sh <<'S'
export HOME=/tmp PATH=/usr/bin OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 PRTE_ALLOW_RUN_AS_ROOT=1 PRTE_ALLOW_RUN_AS_ROOT_CONFIRM=1
export OMPI_MCA_btl=self,sm
mpirun.openmpi --version | { read -r line; echo "$line"; }
for ((run = 1; run <= 120; run++)); do
  mpirun.openmpi --oversubscribe -n 2 /try >/tmp/out 2>/tmp/err || exit 1
  [[ $(</tmp/out) != *warning* ]] || break
done
echo "runs: $run"
S
unshare -rm bash -c 'for folder in dev proc sys; do mount --rbind /$folder tree/$folder || exit 1; done; exec chroot tree bash /runs.sh'
echo "out: $(grep -c warning tree/tmp/out || true) pieces of stderr, err: $(grep -c result tree/tmp/err || true) of stdout; bytes in all" \
  "$(cat tree/tmp/out tree/tmp/err | wc -c), as written: $((20 * 14 + 10 * 9 + 10 * 10))"
grep -m 1 warning tree/tmp/out
[ "$(cat tree/tmp/out tree/tmp/err | wc -c)" = $((20 * 14 + 10 * 9 + 10 * 10)) ] && [ "$(grep -c result tree/tmp/out)" = 20 ] &&
  [ "$(grep -c slow tree/tmp/err)" = 20 ] && [ "$(grep -c warning tree/tmp/err)" -lt 20 ]
