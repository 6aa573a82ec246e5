# Shared set-up of tests/run.sh and examples/quickstart.sh. Source it, then call
#   slipstep_setup [extra package...]    install what is missing, set the environment, find a python
#   slipstep_build DIR [cmake argument...]
# SLIPSTEP_SKIP_PACKAGES=1 skips the package check, for PETSc installed in other ways.

SLIPSTEP_PACKAGES=(build-essential cmake ninja-build pkg-config libpetsc-real-dev libopenmpi-dev openmpi-bin
  libhdf5-openmpi-dev libopenblas0-pthread libopenblas-pthread-dev libfftw3-dev libfftw3-mpi-dev libmetis-dev
  python3 python3-h5py python3-numpy python3-matplotlib)

slipstep_die() {
  printf '%s\n' "$*" >&2
  exit 1
}

# The packages among "$@" that dpkg does not have, one a line.
slipstep_missing() {
  local package
  for package in "$@"; do
    [ "$(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null)" = installed ] || printf '%s\n' "$package"
  done
}

# Prints the command prefix that gives root ("" for root itself); fails where there is none.
slipstep_root() {
  if [ "$(id -u)" = 0 ]; then
    echo ""
  elif command -v sudo >/dev/null && sudo -n true 2>/dev/null; then
    echo "sudo -n"
  else
    return 1
  fi
}

slipstep_install() {
  local missing system root
  if [ "${SLIPSTEP_SKIP_PACKAGES:-0}" = 1 ]; then return; fi
  if command -v dpkg-query >/dev/null; then
    missing=($(slipstep_missing "$@"))
  else
    missing=("$@")
  fi
  if [ ${#missing[@]} = 0 ]; then return; fi

  system=$(. /etc/os-release 2>/dev/null && echo "${ID:-unknown} ${VERSION_ID:-}")
  if [ "$system" != "debian 12" ]; then
    slipstep_die "SlipStep: packages are missing, and they are installed automatically on Debian 12 only (this is ${system:-unknown}).
Please install (Debian's names)
  ${missing[*]}
and run this again. For PETSc from elsewhere set PETSC_DIR, PETSC_ARCH and SLIPSTEP_SKIP_PACKAGES=1."
  fi
  root=$(slipstep_root) || slipstep_die "SlipStep: packages are missing, and installing them needs root. Please run
  sudo apt-get install --no-install-recommends ${missing[*]}
and then this again."
  echo "Installing: ${missing[*]}"
  $root apt-get -q update || echo "apt-get update reported errors; going on with the package lists there are." >&2
  $root env DEBIAN_FRONTEND=noninteractive apt-get -q -y install --no-install-recommends "${missing[@]}" ||
    slipstep_die "SlipStep: apt-get could not install ${missing[*]}"
}

# Exports SLIPSTEP_PYTHON: python3 on PATH may be one that lacks the modules, Debian's has them.
slipstep_find_python() {
  local python
  for python in "${SLIPSTEP_PYTHON:-}" python3 /usr/bin/python3; do
    if [ -n "$python" ] && "$python" -c 'import h5py, numpy, matplotlib' 2>/dev/null; then
      SLIPSTEP_PYTHON=$(command -v "$python")
      export SLIPSTEP_PYTHON
      return
    fi
  done
  slipstep_die "SlipStep: no python3 that imports h5py, numpy and matplotlib (tried python3 on PATH and /usr/bin/python3).
Install python3-h5py python3-numpy python3-matplotlib, or set SLIPSTEP_PYTHON."
}

# One BLAS thread a rank; Open MPI as root, with more ranks than cores, and without ptrace (containers forbid it).
slipstep_environment() {
  export OPENBLAS_NUM_THREADS=1 OMP_NUM_THREADS=1
  export OMPI_MCA_rmaps_base_oversubscribe=1 OMPI_MCA_mpi_yield_when_idle=1 OMPI_MCA_btl_vader_single_copy_mechanism=none
  if [ "$(id -u)" = 0 ]; then export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1; fi
}

slipstep_setup() {
  slipstep_install "${SLIPSTEP_PACKAGES[@]}" "$@"
  slipstep_environment
  slipstep_find_python
}

slipstep_build() {
  local build=$1
  shift
  [ -f "$build/CMakeCache.txt" ] || set -- -G Ninja "$@"
  cmake -S . -B "$build" "$@"
  cmake --build "$build" -j 2
}
