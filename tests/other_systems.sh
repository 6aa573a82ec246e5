#!/usr/bin/env bash
# Both commands of the README in other releases of Debian than this machine's, as root, with the network:
#   tests/other_systems.sh [--keep DIR] [--64] [--clang] [--ctest "ARGUMENTS"] [release...]      default: trixie
# Each release becomes a folder of its own by debootstrap, below DIR (where a later run finds it) or a temporary one. A
# clone of what is committed here is put in, examples/quickstart.sh and tests/run.sh are run there, and it is said what
# passed. sid has the newest PETSc; --64 then builds against the PETSc with 64-bit PetscInt and --clang by clang, each
# in a build folder of its own, and runs the tests. --ctest passes arguments to ctest, such as "-L unit".
# SLIPSTEP_MIRROR names another mirror of Debian than debootstrap's. The exit code is 1 when something failed there, and
# 77 when nothing did but a release could not be had: no root, no network, no right to mount.
set -euo pipefail
cd "$(dirname "$0")/.."
. tests/setup.sh
. tests/systems.sh

usage() { sed -n '2,10s/^# \{0,1\}//p' "$0"; exit "${1:-1}"; }

keep="" wide="" clang="" ctest=""
while [ $# != 0 ]; do
  case $1 in
    --keep) [ $# -gt 1 ] || usage; keep=$2; shift ;;
    --ctest) [ $# -gt 1 ] || usage; ctest=$2; shift ;;
    --64) wide=yes ;;
    --clang) clang=yes ;;
    --help) usage 0 ;;
    -*) usage ;;
    *) break ;;
  esac
  shift
done
[ $# != 0 ] || set -- trixie
for release in "$@"; do
  # its name is a folder of ours, below which things are removed
  [[ $release =~ ^[a-z]+$ ]] || slipstep_die "tests/other_systems.sh: \"$release\" is no release of Debian, expected a name such as trixie or sid"
done

status=0
unavailable() { # RELEASE WHY: one line, for a reason that is not ours
  echo "tests/other_systems.sh: not run in $1: $2"
  [ $status != 0 ] || status=77
}
if [ "$(id -u)" != 0 ]; then unavailable "$*" "debootstrap and chroot need root"; exit $status; fi
if [ -n "$keep" ]; then
  room=$(mkdir -p "$keep" && cd "$keep" && pwd -P)
else
  room=$(mktemp -d)
fi
# A second run there would change mounts and clones under the first.
exec 9>"$room/.lock"
if ! flock -n 9; then unavailable "$*" "another run is at work in $room"; exit $status; fi
clone=/srv/slipstep # within a release's folder: no path of this machine

leave() {
  dismount
  if [ -z "$keep" ]; then discard "$room"; fi
}
trap leave EXIT
trap 'exit 1' INT TERM

# The packages of both commands, before they ask for them: a server that does not answer is told from a package that the
# release does not have, which is left for the commands to say.
download() { # ROOT LOG
  local apt="apt-get -q -y -o Acquire::http::Timeout=60 -o Acquire::Retries=2"
  inside "$1" "$2" ". $clone/tests/setup.sh
    packages=(\$(slipstep_missing \"\${SLIPSTEP_PACKAGES[@]}\" \"\${SLIPSTEP_PETSC_PACKAGES[@]}\" \$(slipstep_test_packages)))
    if [ \${#packages[@]} = 0 ]; then exit 0; fi
    $apt -o APT::Update::Error-Mode=any update || exit 1
    install='install --no-install-recommends'
    $apt \$install --simulate \"\${packages[@]}\" || exit 0
    $apt \$install --download-only \"\${packages[@]}\""
}

report() { # RESULT LOG WHAT
  printf '%-7s %s\n' "$1" "$3" | tee -a "$room/report.txt"
  if [ "$1" != passed ]; then
    status=1
    # what the failed tests printed, or else the end
    { sed -n '/^---- failed: /,$p' "$2" | grep . || tail -n 30 "$2"; } | sed 's/^/        /'
  fi
}

# ROOT LOG WHAT COMMAND...: runs one command and says how many tests passed, where it runs tests
attempt() {
  local root=$1 log=$2 what=$3 result=passed count begin=$SECONDS
  shift 3
  inside "$root" "$log" "cd $clone && $*" || result=FAILED
  grep -a '^Format check\|\*\*\*\(Failed\|Timeout\|Exception\|Skipped\)' "$log" | sed 's/^/        /' || true
  count=$(grep -a '^Tests: ' "$log" | tail -n 1 || true)
  report $result "$log" "$what ($(((SECONDS - begin + 30) / 60)) min)${count:+. $count}"
}

for release in "$@"; do
  root="$room/$release" logs="$room/$release.logs" why=""
  mkdir -p "$logs"
  if ! complete "$root"; then
    echo "== $release: debootstrap and git =="
    bootstrap "$release" "$root" "$logs/debootstrap.log" || { unavailable "$release" "$why"; continue; }
  fi
  enter "$root" || { dismount; unavailable "$release" "/proc, /sys and /dev cannot be mounted there"; continue; }
  network "$root"
  rm -rf --one-file-system "${root:?}${clone:?}"
  git clone -q --no-hardlinks . "$root$clone"
  echo "== $release: $(cat "$root/etc/debian_version"), commit $(git rev-parse --short HEAD) =="
  if ! download "$root" "$logs/download.log"; then
    dismount
    unavailable "$release" "its packages cannot be had: $(reason "$logs/download.log")"
    continue
  fi
  attempt "$root" "$logs/quickstart.log" "$release: examples/quickstart.sh" examples/quickstart.sh
  attempt "$root" "$logs/run.log" "$release: tests/run.sh" tests/run.sh "$ctest"
  inside "$root" "$logs/versions.log" "dpkg-query -W -f '\${Package} \${Version}\n' gcc libpetsc-real-dev libopenmpi-dev libhdf5-openmpi-dev cmake python3 python3-numpy" || true
  sed 's/^/        /' "$logs/versions.log"
  if [ -n "$wide" ]; then
    attempt "$root" "$logs/64.log" "$release: 64-bit PetscInt" "apt-get -q -y install --no-install-recommends libpetsc64-real-dev &&
      export PETSC_DIR=\$(echo /usr/lib/petscdir/petsc64-*) PETSC_ARCH=x86_64-linux-gnu-real SLIPSTEP_BUILD_DIR=build-64 && tests/run.sh $ctest"
  fi
  if [ -n "$clang" ]; then
    attempt "$root" "$logs/clang.log" "$release: clang" "apt-get -q -y install --no-install-recommends clang &&
      export CC=clang SLIPSTEP_BUILD_DIR=build-clang && tests/run.sh $ctest"
  fi
  dismount
done
exit $status
