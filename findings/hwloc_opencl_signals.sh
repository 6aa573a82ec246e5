#!/usr/bin/env bash
# hwloc asks OpenCL drivers for devices, and pocl then leaves signal handlers and threads in the program.
#
# Seen with hwloc 2.9.0 and pocl 3.1 (LLVM 14; Debian 12). hwloc_topology_load() with devices of the machine switched on, as
# Open MPI calls it in mpirun and in every process, loads hwloc's plugin `opencl`, which asks every installed OpenCL driver for
# its devices. pocl's LLVM installs handlers for some fifteen signals, among them SIGUSR1, SIGXFSZ, SIGTERM and SIGINT, and pocl starts
# a thread for each processor; destroying the topology takes neither back. A signal that a program left at its default, or a
# file-size limit that it relied on as SIGXFSZ, then acts otherwise on machines with pocl. HWLOC_COMPONENTS=-opencl avoids it.
#
# Guess before the run: looking for hardware changes nothing in the program.
# Exit code: 0 as seen, 1 when it behaves in another way, 77 when the packages cannot be had.
set -euo pipefail
room=$(mktemp -d)
trap 'rm -rf "$room"' EXIT
cd "$room"
mkdir -p debs/partial tree && : >status
apt-get -qq -y -o Dir::State::status="$room/status" -o Dir::Cache::archives="$room/debs" -o Debug::NoLocking=1 --no-install-recommends \
  --download-only install libhwloc-dev=2.9.0-1 libhwloc-plugins=2.9.0-1 pocl-opencl-icd=3.1-3+deb12u1 >apt.log 2>&1 || { tail -3 apt.log; exit 77; }
rm -f debs/libc6_*.deb debs/libc6-dev_*.deb
for deb in debs/*.deb; do dpkg -x "$deb" tree; done
lib=$room/tree/usr/lib/x86_64-linux-gnu
# the driver's own file names its library below /usr
mkdir vendors && echo "$(ls $lib/libpocl.so.2* | head -1)" >vendors/pocl.icd

cat >try.c <<'C'
#include <hwloc.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>

static void Say(const char *when)
{
  const int   number[] = {SIGUSR1, SIGXFSZ, SIGTERM, SIGINT};
  const char *name[]   = {"SIGUSR1", "SIGXFSZ", "SIGTERM", "SIGINT"};
  char        line[256], threads[32] = "";
  int         all = 0;
  FILE       *status = fopen("/proc/self/status", "r");

  while (fgets(line, sizeof line, status)) sscanf(line, "Threads: %31s", threads);
  fclose(status);
  printf("%s: threads %s, handlers of", when, threads);
  for (int k = 0; k < 4; k++) {
    struct sigaction old;

    sigaction(number[k], NULL, &old);
    if (old.sa_handler != SIG_DFL) printf(" %s", name[k]);
  }
  for (int k = 1; k < 32; k++) {
    struct sigaction old;

    if (!sigaction(k, NULL, &old)) all += old.sa_handler != SIG_DFL && old.sa_handler != SIG_IGN;
  }
  printf(", %d in all\n", all);
}

int main(void)
{
  hwloc_topology_t topology;

  Say("before");
  hwloc_topology_init(&topology);
  hwloc_topology_set_io_types_filter(topology, HWLOC_TYPE_FILTER_KEEP_IMPORTANT);
  hwloc_topology_load(topology);
  hwloc_topology_destroy(topology);
  Say("after");
  return 0;
}
C
cc -I tree/usr/include try.c -o try -L "$lib" -lhwloc -Wl,-rpath-link,"$lib"
export LD_LIBRARY_PATH=$lib:$room/tree/lib/x86_64-linux-gnu OCL_ICD_VENDORS=$room/vendors HWLOC_PLUGINS_PATH=$lib/hwloc POCL_CACHE_DIR=$room/cache
echo "with the plugin:"
./try | tee with.txt
echo "HWLOC_COMPONENTS=-opencl:"
HWLOC_COMPONENTS=-opencl ./try | tee without.txt
grep -q '^before: threads 1, handlers of, 0 in all' with.txt && grep -q '^after: .*handlers of SIGUSR1 SIGXFSZ SIGTERM SIGINT,' with.txt &&
  ! grep -q '^after: threads 1,' with.txt && grep -q '^after: threads 1, handlers of, 0 in all' without.txt
