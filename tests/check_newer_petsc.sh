#!/usr/bin/env bash
# Compiles every C source, warnings being errors, against the PETSc headers of later Debian releases, uninstalled:
#   tests/check_newer_petsc.sh [--keep DIR] [release...]      default: trixie sid
# Headers come from the packages libpetsc-real*-dev, libpetsc*-dev-common and libopenmpi-dev (PETSc's headers insist on
# the MPI they were configured with), unpacked into a temporary folder (or DIR, where a later run finds them). It is a
# check by hand that needs the network; it says which versions it compiled against.
set -euo pipefail
cd "$(dirname "$0")/.."
. tests/setup.sh

keep=""
if [ "${1:-}" = --keep ]; then
  keep=$(mkdir -p "$2" && cd "$2" && pwd)
  shift 2
fi
if [ $# = 0 ]; then set -- trixie sid; fi
room=${keep:-$(mktemp -d)}
shopt -s globstar
sources=(src/**/*.c examples/*.c training/**/*.c tests/**/*.c)
[ -n "$keep" ] || trap 'rm -rf "$room"' EXIT

# Everything apt needs in a folder of its own, so that the machine's packages stay as they are.
apt_in() {
  local root=$1 tool=$2
  shift 2
  "$tool" -o Dir="$root" -o Dir::State::status="$root/status" -o APT::Architecture=amd64 -o APT::Sandbox::User=root \
    -o Acquire::Languages=none "$@"
}

fetch() {
  local root=$1 release=$2 packages
  mkdir -p "$root"/{etc/apt/{apt.conf.d,preferences.d,sources.list.d,trusted.gpg.d},var/lib/apt/lists/partial,var/cache/apt/archives/partial}
  touch "$root/status"
  echo "deb [signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] http://deb.debian.org/debian $release main" \
    >"$root/etc/apt/sources.list"
  apt_in "$root" apt-get -qq update
  packages=$(apt_in "$root" apt-cache search --names-only '^libpetsc(-real)?3[.0-9]*-dev(-common)?$' | cut -d' ' -f1)
  [ -n "$packages" ] || slipstep_die "no PETSc packages in Debian $release"
  (cd "$root" && apt_in "$root" apt-get -qq download $packages libopenmpi-dev && for deb in *.deb; do dpkg -x "$deb" tree; done)
}

# One line a failed file on stdout with the compiler's messages; returns the number of failures.
compile() {
  local root=$1 config version mpi failed=0 file
  config=$(find "$root/tree" -name petscconf.h | head -1)
  version=$(find "$root/tree" -name petscversion.h | head -1)
  mpi=$(find "$root/tree" -path '*openmpi*/include/mpi.h' | head -1)
  [ -n "$config" ] && [ -n "$version" ] && [ -n "$mpi" ] || slipstep_die "no PETSc and MPI headers below $root/tree"
  local release
  release=$(awk '/define PETSC_VERSION_(MAJOR|MINOR|SUBMINOR)/{printf "%s%s", dot, $3; dot="."}' "$version")
  local flags
  flags="-I$(dirname "$config") -I$(dirname "$version") -I$(dirname "$mpi") $(pkg-config --cflags hdf5-openmpi openblas cmocka)"
  for file in "${sources[@]}"; do
    gcc -std=c17 -fsyntax-only -Wall -Wextra -Wpedantic -Werror -Iinclude -Itraining -Itests $flags "$file" || {
      echo "FAILED with PETSc $release: $file"
      failed=$((failed + 1))
    }
  done
  echo "PETSc $release: ${#sources[@]} files, $failed failed."
  return $((failed > 0))
}

status=0
for release in "$@"; do
  [ -d "$room/$release/tree" ] || fetch "$room/$release" "$release"
  compile "$room/$release" || status=1
done
exit $status
