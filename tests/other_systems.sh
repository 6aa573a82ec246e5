#!/usr/bin/env bash
# Both commands of the README in other releases of Debian than this machine's, by hand, as root, with the network:
#   tests/other_systems.sh [--keep DIR] [--64] [--clang] [--ctest "ARGUMENTS"] [release...]      default: trixie
# Each release becomes a folder of its own by debootstrap, below DIR (where a later run finds it) or a temporary one. A
# clone of what is committed here is put in, examples/quickstart.sh and tests/run.sh are run there, and it is said what
# passed. sid has the newest PETSc; --64 then builds against the PETSc with 64-bit PetscInt and --clang by clang, each
# in a build folder of its own, and runs the tests. --ctest passes arguments to ctest, such as "-L unit".
# SLIPSTEP_MIRROR names another mirror of Debian than debootstrap's.
set -euo pipefail
cd "$(dirname "$0")/.."
. tests/setup.sh

usage() { sed -n '2,9s/^# \{0,1\}//p' "$0"; exit "${1:-1}"; }

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
[ "$(id -u)" = 0 ] || slipstep_die "tests/other_systems.sh: debootstrap and chroot need root"
command -v debootstrap >/dev/null || slipstep_die "tests/other_systems.sh: no debootstrap; apt-get install debootstrap"
if [ -n "$keep" ]; then
  room=$(mkdir -p "$keep" && cd "$keep" && pwd -P)
else
  room=$(mktemp -d)
fi
# A second run there would change mounts and clones under the first.
exec 9>"$room/.lock"
flock -n 9 || slipstep_die "tests/other_systems.sh: another one is at work in $room"
clone=/srv/slipstep # within a release's folder: no path of this machine

# Mounts go before anything is removed, and a folder that still has some is left alone: they are this machine's own.
mounted=()
leave() {
  local i
  for ((i = ${#mounted[@]} - 1; i >= 0; i--)); do umount -R "${mounted[i]}" || umount -R -l "${mounted[i]}" || true; done
  mounted=()
  if [ -z "$keep" ]; then
    if grep -qF " $room/" /proc/mounts; then echo "left, with mounts: $room" >&2; else rm -rf --one-file-system "$room"; fi
  fi
}
trap leave EXIT
trap 'exit 1' INT TERM

enter() { # ROOT: what programs expect of a system, from this machine; devices are the few that are needed
  local root=$1
  mountpoint -q "$root/proc" || { mount -t proc proc "$root/proc"; mounted+=("$root/proc"); }
  mountpoint -q "$root/sys" || { mount --rbind /sys "$root/sys"; mount --make-rslave "$root/sys"; mounted+=("$root/sys"); } # hwloc complains without
  mountpoint -q "$root/dev" || { mount --rbind /dev "$root/dev"; mount --make-rslave "$root/dev"; mounted+=("$root/dev"); }
}

# inside ROOT LOG COMMAND...: nothing of this machine's environment gets in
inside() {
  local root=$1 log=$2
  shift 2
  nice -n 19 chroot "$root" env -i HOME=/root PATH=/usr/sbin:/usr/bin:/sbin:/bin LANG=C.UTF-8 DEBIAN_FRONTEND=noninteractive \
    bash -c "cd $clone && $*" >"$log" 2>&1 9>&-
}

status=0
report() { # RESULT LOG WHAT
  printf '%-7s %s\n' "$1" "$3" | tee -a "$room/report.txt"
  if [ "$1" != passed ]; then
    status=1
    tail -n 30 "$2" | sed 's/^/        /'
  fi
}

# ROOT LOG WHAT COMMAND...: runs one command and says how many tests passed, where it runs tests
attempt() {
  local root=$1 log=$2 what=$3 result=passed count
  shift 3
  inside "$root" "$log" "$@" || result=FAILED
  count=$(grep -ao '[0-9]*% tests passed, .*' "$log" | tail -n 1 || true)
  report $result "$log" "$what${count:+: $count}"
  grep -a '^Format check\|\*\*\*\(Failed\|Timeout\|Exception\|Skipped\)' "$log" | sed 's/^/        /' || true
}

for release in "$@"; do
  # its name is a folder of ours, below which things are removed
  [[ $release =~ ^[a-z]+$ ]] || slipstep_die "tests/other_systems.sh: \"$release\" is no release of Debian, expected a name such as trixie or sid"
  root="$room/$release" logs="$room/$release.logs"
  mkdir -p "$root" "$logs"
  if [ ! -e "$logs/ready" ]; then
    echo "== $release: debootstrap and git =="
    debootstrap --variant=minbase --include=git,ca-certificates "$release" "$root" ${SLIPSTEP_MIRROR:+"$SLIPSTEP_MIRROR"} >"$logs/debootstrap.log" 2>&1 ||
      slipstep_die "tests/other_systems.sh: debootstrap failed: $(tail -n 3 "$logs/debootstrap.log")"
    touch "$logs/ready"
  fi
  enter "$root"
  cp -L /etc/resolv.conf "$root/etc/resolv.conf" 2>/dev/null || true
  # what is needed to reach packages here is needed there
  for file in /etc/apt/apt.conf /etc/apt/apt.conf.d/*proxy*; do [ ! -e "$file" ] || cp "$file" "$root$file"; done
  rm -rf --one-file-system "${root:?}${clone:?}"
  git clone -q --no-hardlinks . "$root$clone"
  echo "== $release: $(cat "$root/etc/debian_version"), commit $(git rev-parse --short HEAD) =="
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
done
exit $status
