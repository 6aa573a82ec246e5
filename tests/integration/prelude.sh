# Sourced first by the tests of this folder: a working folder that goes with the test, and words for what must not
# happen.
bin=$SLIPSTEP_BUILD/bin
work=$(cd "$(mktemp -d)" && pwd -P)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
dt=-ts_dt # what PETSc, and so messages, call the first step
grep -q '^#define PETSC_VERSION_MINOR *\(2[5-9]\|[3-9][0-9]\)' "${SLIPSTEP_PETSC:-}/petscversion.h" 2>/dev/null && dt=-ts_time_step
failed=0 # the test's exit code
hang=1000 # a program that takes longer has stopped for good [s], on a busy machine as well

fail() {
  echo "FAILED: $*"
  failed=1
}

# Runs a program on some ranks, the standard error of each straight into a file: the launcher of Open MPI 5 puts pieces of it into
# the standard output now and then.
ranks() { # number, file, command...
  : >"$2"
  mpirun --oversubscribe -n "$1" sh -c 'exec "$@" 2>>"$0"' "$2" "${@:3}" 2>>"$2"
}

# Expects a command that fails by itself with one line on stderr (beside warnings and mpirun's own lines), an error that holds
# each of the words, and leaves no .part.
refuses() { # word... -- command
  local words=() code=0 lines=.
  while [ "$1" != -- ]; do words+=("$1"); shift; done
  shift
  : >err.txt
  if [ "$1" = mpirun ]; then set -- "${@:1:4}" sh -c 'exec "$@" 2>>err.txt' sh "${@:5}"; fi # mpirun --oversubscribe -n N ...; as ranks() does
  timeout -k 10 $hang "$@" >out.txt 2>>err.txt || code=$?
  [ $code != 0 ] && [ $code != 124 ] && [ $code != 137 ] || fail "exit code $code of $*"
  for word in "error: " "${words[@]}"; do grep -qF -e "$word" err.txt || fail "no \"$word\" in the message of $*: $(cat err.txt)"; done
  [ "$1" != mpirun ] || lines="error: "
  [ "$(grep -av ': warning: ' err.txt | grep -ac "$lines")" = 1 ] || fail "not one line from $*: $(cat err.txt)"
  [ -z "$(ls ./*.part 2>/dev/null)" ] || { fail "left by $*: $(ls ./*.part)"; rm -f ./*.part; }
}
