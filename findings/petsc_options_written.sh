#!/usr/bin/env bash
# PETSc writes its options without quotes: read back, a value with a "#" is lost and one with blanks becomes other options.
#
# Seen with PETSc 3.18.5 (Debian 12). PetscOptionsView(), behind -options_view, prints "#PETSc Option Table entries:" and a line for each option, which
# is how files for -options_file look. Read back, "-color #1f77b4" has no value, as "#" begins a comment, and nothing is said.
# "-title slip rate -log" ends with "extra token". PetscOptionsGetAll() and PetscOptionsInsertString(), the pair for strings, cut the title to
# "slip" and make "-log" an option of its own, without an error. In a file quotes help: -title "slip rate"; so a copy of a run's options needs them by hand.
#
# Guess before the run: what PETSc writes of its options it reads back, with quotes where a value needs them.
# Exit code: 0 as seen, 1 when it behaves in another way, 77 when the packages cannot be had.
set -euo pipefail
room=$(mktemp -d)
trap 'rm -rf "$room"' EXIT
cd "$room"
mkdir -p debs/partial tree && : >status
apt-get -qq -y -o Dir::State::status="$room/status" -o Dir::Cache::archives="$room/debs" -o Debug::NoLocking=1 --no-install-recommends \
  --download-only install libpetsc-real3.18=3.18.5+dfsg1-1 libpetsc-real3.18-dev=3.18.5+dfsg1-1 >apt.log 2>&1 || { tail -3 apt.log; exit 77; }
rm -f debs/libc6_*.deb debs/libc6-dev_*.deb
for deb in debs/*.deb; do dpkg -x "$deb" tree; done
lib=$room/tree/usr/lib/x86_64-linux-gnu petsc=$(echo "$room"/tree/usr/lib/petscdir/petsc*/x86_64-linux-gnu-real)

cat >try.c <<'C'
#include <petscsys.h>
#include <petscviewer.h>

static void Say(const char *when, PetscOptions options)
{
  char      color[64] = "", title[64] = "";
  PetscBool log;

  PetscOptionsGetString(options, NULL, "-color", color, sizeof color, NULL);
  PetscOptionsGetString(options, NULL, "-title", title, sizeof title, NULL);
  PetscOptionsHasName(options, NULL, "-log", &log);
  PetscPrintf(PETSC_COMM_SELF, "%s: color '%s', title '%s'%s\n", when, color, title, log ? ", and an option -log" : "");
}

int main(int argc, char **argv)
{
  PetscOptions options;
  PetscViewer  viewer;
  PetscBool    view;
  char        *all;

  if (PetscInitialize(&argc, &argv, NULL, NULL)) return 2;
  Say("read", NULL);
  PetscOptionsHasName(NULL, NULL, "-view", &view);
  if (view) {
    PetscViewerASCIIOpen(PETSC_COMM_SELF, "written.txt", &viewer);
    PetscOptionsView(NULL, viewer);
    PetscViewerDestroy(&viewer);
    PetscOptionsGetAll(NULL, &all);
    PetscOptionsCreate(&options);
    PetscOptionsInsertString(options, all);
    Say("PetscOptionsGetAll() and PetscOptionsInsertString()", options);
    PetscOptionsDestroy(&options);
    PetscFree(all);
  }
  PetscFinalize();
  return 0;
}
C
include=$(for folder in "$petsc"/include "$petsc"/../include tree/usr/include tree/usr/lib/x86_64-linux-gnu/openmpi/include; do printf ' -I %s' "$folder"; done)
cc $include try.c -o try -L "$petsc"/lib -lpetsc_real -L "$lib" -lmpi -Wl,--allow-shlib-undefined
export LD_LIBRARY_PATH=$petsc/lib:$lib:$room/tree/lib/x86_64-linux-gnu:$lib/blas:$lib/lapack OPAL_PREFIX=$room/tree/usr PMIX_INSTALL_PREFIX=$lib/pmix2 HWLOC_COMPONENTS=-opencl
export OMPI_MCA_mca_base_component_path=$lib/openmpi/lib/openmpi3 OMPI_MCA_ess_singleton_isolated=1 OMPI_MCA_btl=self OMPI_MCA_pml=ob1 PMIX_MCA_gds=hash
./try -view -color '#1f77b4' -title seconds 2>error.txt | tee first.txt
cat written.txt
./try -options_file written.txt 2>>error.txt | tee back.txt
./try -view -title 'slip rate -log' 2>>error.txt | tee second.txt
./try -options_file written.txt >third.txt 2>&1 || true
grep -o 'Error in options file.*' third.txt
printf '%s\n' '-title "slip rate"' >quoted.txt
./try -options_file quoted.txt 2>>error.txt | tee quotes.txt
grep -q "^read: color '#1f77b4', title 'seconds'" first.txt && grep -q "^read: color '', title 'seconds'" back.txt &&
  grep -q "InsertString(): color '', title 'slip', and an option -log" second.txt && grep -q 'extra token' third.txt &&
  grep -q "^read: color '', title 'slip rate'" quotes.txt
