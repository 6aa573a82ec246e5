# Shared set-up of tests/run.sh and examples/quickstart.sh. Source it, then call
#   slipstep_setup [extra package...]    install what is missing, set the environment, find a python
#   slipstep_build DIR [cmake argument...]
#   slipstep_count FILE                  how many tests of a run of ctest passed, failed and were skipped
#   slipstep_failures DIR                what the failed tests of that run in build folder DIR printed, the end of it
#   slipstep_ready [extra package...]    both for an example, into build/, unless SLIPSTEP_BUILD names a build
# Debian 12 and 13 and Ubuntu 24.04 call these packages alike. With PETSC_DIR set, PETSc and what it was built with are
# the user's own; SLIPSTEP_SKIP_PACKAGES=1 skips the packages altogether.

SLIPSTEP_PACKAGES=(build-essential cmake ninja-build pkg-config libfftw3-dev libfftw3-mpi-dev
  ocl-icd-opencl-dev libvkfft-dev # for -fault_device, without which all else is built
  python3 python3-h5py python3-numpy python3-matplotlib)
SLIPSTEP_PETSC_PACKAGES=(libpetsc-real-dev libopenmpi-dev openmpi-bin libhdf5-openmpi-dev libopenblas0-pthread
  libopenblas-pthread-dev)
SLIPSTEP_SYSTEMS="debian 12, debian 13, ubuntu 24.04" # that install by themselves

# What tests need besides, one a line: clang-format 14 where there is one, and petsc4py for Debian's PETSc; with another
# PETSc the tests of Python look for that one's.
slipstep_test_packages() {
  echo libcmocka-dev
  echo pocl-opencl-icd # a device of OpenCL on the processor
  echo file # by which cpack -G DEB finds what the library needs
  printf '%s\n' python3-xarray python3-pandas python3-netcdf4 netcdf-bin python3-pyproj python3-scipy python3-nbconvert python3-ipykernel \
    python3-sphinx python3-myst-parser python3-sphinx-rtd-theme
  case $(. /etc/os-release 2>/dev/null && echo "${ID:-} ${VERSION_ID:-}") in
    "debian 12" | "ubuntu 24.04") echo clang-format-14 ;;
  esac
  [ -n "${PETSC_DIR:-}" ] || echo python3-petsc4py-real
}

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

# The command that installs packages here. Other systems than Debian's kin have other names for them.
slipstep_command() {
  if command -v apt-get >/dev/null; then
    echo "sudo apt-get update && sudo apt-get install --no-install-recommends $*"
  else
    echo "the installer of this system, for what Debian calls $*"
  fi
}

# apt-get by a command prefix; while another program holds its locks (updates that a system makes by itself), waits for it.
slipstep_apt() { # PREFIX ARGUMENT...
  local prefix=$1 said waits="" status
  shift
  said=$(mktemp)
  while :; do
    $prefix env DEBIAN_FRONTEND=noninteractive LC_ALL=C apt-get -q -y "$@" 2>"$said" && status=0 || status=$?
    if [ $status = 0 ] || ! grep -q "Could not get lock\|Unable to acquire the dpkg frontend lock\|Unable to lock" "$said"; then break; fi
    [ -n "$waits" ] || echo "Waiting for another program that installs packages: $(grep -m 1 "lock" "$said")"
    waits=yes
    sleep "${SLIPSTEP_LOCK_WAIT:-5}"
  done
  cat "$said" >&2
  rm -f "$said"
  return $status
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
  case ", $SLIPSTEP_SYSTEMS," in
    *", $system,"*) ;;
    *) slipstep_die "SlipStep: packages are missing, and they are installed automatically on $SLIPSTEP_SYSTEMS only
(this is ${system:-unknown}). Please run
  $(slipstep_command "${missing[@]}")
and then this again. For a PETSc from elsewhere, with real scalars, set PETSC_DIR, PETSC_ARCH and SLIPSTEP_SKIP_PACKAGES=1." ;;
  esac
  root=$(slipstep_root) || slipstep_die "SlipStep: packages are missing, and installing them needs root. Please run
  $(slipstep_command "${missing[@]}")
and then this again."
  echo "Installing: ${missing[*]}"
  slipstep_apt "$root" update || echo "apt-get update reported errors; going on with the package lists there are." >&2
  slipstep_apt "$root" install --no-install-recommends "${missing[@]}" ||
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

# One BLAS thread a rank; Open MPI as root, with more ranks than cores, and without ptrace (containers forbid it). Open MPI lets
# ranks yield where there are more of them than cores. Always (mpi_yield_when_idle=1) made two ranks on two cores 35 times slower
# beside one busy process, which then gets a time slice at each message (12 s in place of 0.3 s). And without a look at OpenCL's
# devices, for which Open MPI has hwloc load their drivers: compilers among them take over signals, in mpirun too, which then passes
# none on.
slipstep_environment() {
  export OPENBLAS_NUM_THREADS=1 OMP_NUM_THREADS=1
  export OMPI_MCA_btl_vader_single_copy_mechanism=none OMPI_MCA_smsc=^cma
  export OMPI_MCA_rmaps_base_oversubscribe=1 PRTE_MCA_rmaps_default_mapping_policy=:oversubscribe # Open MPI 4 and 5
  export HWLOC_COMPONENTS=${HWLOC_COMPONENTS--opencl}
  if [ "$(id -u)" = 0 ]; then export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1; fi
}

# A program of the package in Python, as an installation has it: slipstep NAME ...
slipstep() {
  "$SLIPSTEP_PYTHON" src/package/program.py "$@"
}

slipstep_setup() {
  [ -n "${PETSC_DIR:-}" ] || set -- "${SLIPSTEP_PETSC_PACKAGES[@]}" "$@"
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

# Of the file that `ctest --output-junit` writes; .ci/run adds such lines up.
slipstep_count() {
  [ -s "$1" ] || set -- /dev/null
  awk -F '"' '/^\t>/ { exit }
    /^\t(tests|failures|skipped|disabled)=/ { sub(/^\t/, "", $1); n[$1] = $2 }
    END {
      skipped = n["skipped="] + n["disabled="]
      printf "%d passed, %d failed, %d skipped\n", n["tests="] - n["failures="] - skipped, n["failures="], skipped
    }' "$1"
}

# From ctest's log and its list of what failed, which a run without failures leaves as it was: call it after one with
# some. Kept logs of CI are the ends of theirs, so this belongs there.
slipstep_failures() {
  local logs=$1/Testing/Temporary
  [ -s "$logs/LastTestsFailed.log" ] || return 0
  awk -v lines=40 'NR == FNR { failed[substr($0, index($0, ":") + 1)]; next }
    !within && /^[0-9]+\/[0-9]+ Test: / { name = $3 }
    !within && /^Output:$/ { within = 1; n = -1; next }
    /^<end of output>$/ {
      if (within && name in failed) {
        first = (n > lines) ? n - lines : 0
        printf("---- failed: %s%s\n", name, first ? ", the last " lines " of " n " lines" : "")
        for (i = first; i < n; i++) print "     " said[i]
      }
      within = 0
    }
    within { if (n >= 0) said[n] = $0; n++ }' "$logs/LastTestsFailed.log" "$logs/LastTest.log"
}

# What an example runs is in $SLIPSTEP_BUILD/bin, and it writes to $SLIPSTEP_OUTPUT. A new build has no tests, one that has
# them keeps them.
slipstep_ready() {
  local options=()
  SLIPSTEP_OUTPUT=${SLIPSTEP_OUTPUT:-output}
  [ -d "$SLIPSTEP_OUTPUT" ] || slipstep_die "SlipStep: SLIPSTEP_OUTPUT is $SLIPSTEP_OUTPUT, expected a folder"
  if [ -n "${SLIPSTEP_BUILD:-}" ]; then
    [ -x "$SLIPSTEP_BUILD/bin/fault" ] ||
      slipstep_die "SlipStep: SLIPSTEP_BUILD is $SLIPSTEP_BUILD, expected a build's folder with bin/fault in it"
    slipstep_environment
    slipstep_find_python
    return
  fi
  slipstep_setup "$@"
  [ -e build/CMakeCache.txt ] || options=(-DBUILD_TESTING=OFF)
  slipstep_build build "${options[@]}"
  SLIPSTEP_BUILD=build
}
