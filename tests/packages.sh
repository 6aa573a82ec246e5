#!/usr/bin/env bash
# The Debian package, outside of the suite, as root and with the network: it is built in each release of Debian, installed in a folder that has
# nothing else, tried, and removed again:
#   tests/packages.sh [--keep DIR] [release...]      default: bookworm trixie
# Folders are made by debootstrap below DIR (default: ~/.cache/slipstep), where a later run finds those for building, and what tests/other_systems.sh has
# made there. The clean ones are copies. SLIPSTEP_MIRROR names another mirror. The exit code is 1 when something failed.
set -euo pipefail
cd "$(dirname "$0")/.."
. tests/setup.sh
. tests/systems.sh

usage() { sed -n '2,6s/^# \{0,1\}//p' "$0"; exit "${1:-1}"; }

keep=${XDG_CACHE_HOME:-$HOME/.cache}/slipstep
while [ $# != 0 ]; do
  case $1 in
    --keep) [ $# -gt 1 ] || usage; keep=$2; shift ;;
    --help) usage 0 ;;
    -*) usage ;;
    *) break ;;
  esac
  shift
done
[ $# != 0 ] || set -- bookworm trixie
for release in "$@"; do
  [[ $release =~ ^[a-z]+$ ]] || slipstep_die "tests/packages.sh: \"$release\" is no release of Debian, expected a name such as trixie"
done
[ "$(id -u)" = 0 ] || slipstep_die "tests/packages.sh: debootstrap and chroot need root"
(slipstep_install debootstrap)
mkdir -p "$keep/systems"
exec 9>"$keep/systems/.lock" # that of tests/other_systems.sh, which mounts in the same folders
flock -n 9 || slipstep_die "tests/packages.sh: another run is at work in $keep/systems"
status=0 clone=/srv/package # within a release's folder; that of CI is another
trap dismount EXIT
trap 'exit 1' INT TERM
result() { # WHAT LOG CODE
  if [ "$3" = 0 ]; then
    echo "passed  $1"
  else
    echo "FAILED  $1"
    tail -n 25 "$2" | sed 's/^/        /'
    status=1
  fi
}
# WHAT LOG ROOT COMMANDS: in a folder of a system, until one fails. One command a line: bash -e does not end where the first of a && b fails.
attempt() {
  local code=0
  inside "$3" "$2" "set -eo pipefail
    export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
    $4" || code=1
  result "$1" "$2" $code
}

# In a clone of what is committed
build="cd $clone
  . tests/setup.sh
  slipstep_setup file
  slipstep_build build -DBUILD_TESTING=OFF
  cd build
  cpack -G DEB"
files() { # ROOT: of a system, but for what any package leaves: lists, logs and caches of apt, dpkg and the linker, and configurations of other packages
  find "$1" -xdev \( -path "$1/proc" -o -path "$1/sys" -o -path "$1/dev" -o -path "$1/tmp" -o -path "$1/var/lib/apt" -o -path "$1/var/cache" -o -path "$1/var/log" -o -path "$1/var/lib/dpkg" \
    -o -path "$1/root" \) -prune -o -print | sort
}
install="apt-get -q -y install --no-install-recommends /tmp/slipstep.deb"
first_run="cd \$(mktemp -d)
  slipstep-fault -fault_output run.h5 -fault_catalogue events.h5 -fault_output_overwrite
  mpirun --oversubscribe -n 2 slipstep-fault -ts_adapt_type rl -ts_max_time 10
  slipstep-fault -options_file /usr/share/slipstep/examples/fault_3km.opts -ts_max_time 5
  slipstep plot-run run.h5
  slipstep report run.h5 --catalogue events.h5
  slipstep catalogue-quakeml events.h5 e.xml --origin 10 50
  test -s run.png
  test -s run.html
  test -s e.xml
  python3 -c 'import slipstep; r = slipstep.Fault(nx=4, nz=4).run(progress=False); assert r.complete and r[\"slip\"].max() > 0; print(slipstep.Fault.backend, r)'
  slipstep-train -help train >help.txt
  grep -q -e -train_output help.txt
  zcat /usr/share/man/man1/slipstep-fault.1.gz >man.txt
  grep -q fault_nx man.txt"
developer="$install
  apt-get -q -y install --no-install-recommends gcc libc6-dev pkg-config cmake make libpetsc-real-dev libopenmpi-dev libhdf5-openmpi-dev libfftw3-dev libfftw3-mpi-dev ocl-icd-opencl-dev libopenblas-pthread-dev python3-petsc4py-real man-db
  cd \$(mktemp -d)
  printf '#include <slipstep.h>\nint main(int c, char **v) { SlipFault f; PetscCall(SlipProgramInitialize(&c, &v, \"mine\", \"\")); PetscCall(SlipStepInitializePackage()); PetscCall(SlipFaultCreate(PETSC_COMM_WORLD, &f)); PetscCall(SlipFaultDestroy(&f)); return PetscFinalize(); }\n' >mine.c
  mpicc mine.c -o mine \$(pkg-config --cflags --libs slipstep)
  ./mine
  mkdir -p c
  printf 'cmake_minimum_required(VERSION 3.16)\nproject(mine C)\nfind_package(slipstep REQUIRED)\nadd_executable(mine ../mine.c)\ntarget_link_libraries(mine slipstep::slipstep)\n' >c/CMakeLists.txt
  cmake -S c -B c/build
  cmake --build c/build
  c/build/mine
  MANWIDTH=100 man --warnings -l /usr/share/man/man1/slipstep-fault.1.gz >man.txt 2>man.err
  test ! -s man.err
  lexgrog /usr/share/man/man1/slipstep-*.1.gz
  export PYTHONPATH=\$(echo /usr/lib/petscdir/petsc3*/*-real/lib/python3/dist-packages)
  python3 -c 'import slipstep; assert slipstep.Fault.backend == \"petsc\"; print(slipstep.Fault(nx=4, nz=4).run(progress=False))'
  rm -rf moved c/build
  dpkg -x /tmp/slipstep.deb moved
  apt-get -q -y remove slipstep
  moved/usr/bin/slipstep-fault -ts_max_time 5
  export PKG_CONFIG_PATH=moved/usr/lib/pkgconfig
  mpicc mine.c -o mine \$(pkg-config --cflags --libs slipstep)
  ./mine
  cmake -S c -B c/build -DCMAKE_PREFIX_PATH=\$PWD/moved/usr
  cmake --build c/build
  c/build/mine"

for release in "$@"; do
  root=$keep/systems/$release clean=$keep/clean/$release trial=$keep/trial/$release logs=$keep/packages.logs/$release
  mkdir -p "$logs" "$keep/clean" "$keep/trial"
  for folder in "$root" "$clean"; do
    complete "$folder" || bootstrap "$release" "$folder" "$logs/debootstrap.log" || slipstep_die "tests/packages.sh: $release: $why"
  done
  enter "$root"
  network "$root"
  rm -rf --one-file-system "${root:?}$clone"
  git clone -q --no-hardlinks . "$root$clone"
  attempt "$release: cpack -G DEB" "$logs/build.log" "$root" "$build"
  dismount
  deb=$(ls "$root$clone"/build/slipstep_*.deb 2>/dev/null | head -n 1)
  [ -n "$deb" ] || continue
  rm -rf --one-file-system "$trial"
  cp -a "$clean" "$trial"
  enter "$trial"
  network "$trial"
  cp "$deb" "$trial/tmp/slipstep.deb"
  # what the package needs first, so that what it leaves itself is seen
  attempt "$release: its dependencies" "$logs/depends.log" "$trial" "apt-get -q update
    $install
    apt-get -q -y purge slipstep"
  files "$trial" >"$logs/before"
  attempt "$release: install" "$logs/install.log" "$trial" "$install"
  attempt "$release: first run, picture, report, QuakeML, Python" "$logs/first.log" "$trial" "$first_run"
  attempt "$release: purge" "$logs/purge.log" "$trial" "apt-get -q -y purge slipstep"
  files "$trial" >"$logs/after"
  code=0
  diff "$logs/before" "$logs/after" >"$logs/left.log" || code=1
  result "$release: nothing is left" "$logs/left.log" $code
  attempt "$release: pkg-config, find_package, man, petsc4py; moved to another folder" "$logs/developer.log" "$trial" "$developer"
  dismount
  discard "$trial"
done
exit $status
