#!/usr/bin/env bash
# -fault_cache_dir: the second run reads what the first wrote, on any number of ranks, and slips alike; files that
# cannot be right are reported and replaced; runs at the same time do not disturb each other; a directory that is none
# is an error.
set -uo pipefail
. "$SLIPSTEP_SOURCE/tests/integration/prelude.sh"
fault=$SLIPSTEP_BUILD/bin/fault
# slip OPTIONS...: final mean slip of a run; its messages go to messages
slip() { "$@" -ts_max_time 0.3 -fault_cache_dir cache 2>messages | awk '/final mean slip/{print $4}'; }
# the summary has seven digits: two numbers that are the same but for rounding are within 2e-6
same() { awk -v a="$1" -v b="$2" -v tol="$3" 'BEGIN{d = a - b; exit !(a > 0 && (d < 0 ? -d : d) <= tol * a)}' || fail "$4: slip $1 and $2"; }
files() { find cache -type f | wc -l; }

"$SLIPSTEP_PYTHON" - <<'P' || exit 77
import h5py
import numpy as np
# a stiffness of 1505 cells from a file: exponential decay, positive definite
x = np.arange(1505.0)
with h5py.File("k.h5", "w") as f:
    f["stiffness"] = 3e7 * np.exp(-np.abs(x[:, None] - x[None, :]))
P
for case in "truncated text foreign damaged:-fault_operator dense -fault_nx 42 -fault_nz 36" \
  ":-fault_stiffness_file k.h5 -fault_nx 43 -fault_nz 35"; do
  kind=${case#*:}
  read -r -a options <<<"$kind"
  run=("$fault" "${options[@]}")
  rm -rf cache && mkdir cache
  first=$(slip "${run[@]}")
  [ "$(files)" = 1 ] && [ ! -s messages ] || fail "$kind: $(files) files, messages: $(cat messages)"
  name=$(find cache -type f)
  cp "$name" good
  before=$(stat -c %i "$name")
  same "$first" "$(slip "${run[@]}")" 0 "$kind, from the cache"
  same "$first" "$(slip mpirun --oversubscribe -n 2 "${run[@]}")" 2e-6 "$kind, from the cache on two ranks"
  same "$first" "$(slip "${run[@]}" -fault_density 2500.0)" 0 "$kind, read again"
  slip "${run[@]}" -fault_density 3000 -fault_damping_ratio 0.1 >other
  [ "$(files)" = 1 ] && [ "$(stat -c %i "$name")" = "$before" ] || fail "$kind: the file serves every density and damping"

  for bad in ${case%%:*}; do
    case $bad in
    truncated) head -c 5000 good >"$name" ;;
    text) echo "not a cache" >"$name" ;;
    foreign) cp "$SLIPSTEP_SOURCE/training/policies/fault.h5" "$name" ;;
    damaged) cp good "$name" && printf '\377\377\377' | dd of="$name" bs=1 seek=200000 conv=notrunc status=none ;;
    esac
    same "$first" "$(slip "${run[@]}")" 0 "$kind, $bad file"
    grep -q "^fault: warning: .*$name.*; it is computed again$" messages || fail "$bad file: $(cat messages)"
    same "$first" "$(slip "${run[@]}")" 0 "$kind, after a $bad file"
    [ ! -s messages ] || fail "$kind: the $bad file was not replaced: $(cat messages)"
  done
done

# Something that cannot be replaced: the run goes on without.
rm "$name" && mkdir "$name"
same "$first" "$(slip "${run[@]}")" 0 "a directory in the file's place"
grep -q "^fault: warning: cannot replace $name: Is a directory; nothing was stored$" messages || fail "a directory: $(cat messages)"
[ "$(files)" = 0 ] || fail "a file that could not be renamed was left: $(find cache)"
rmdir "$name" && cp good "$name"

# A stiffness that changed does not find the old root.
"$SLIPSTEP_PYTHON" -c 'import h5py; f = h5py.File("k.h5", "r+"); f["stiffness"][7, 7] *= 1.001'
same "$(slip "${run[@]}")" "$("${run[@]}" -ts_max_time 0.3 | awk '/final mean slip/{print $4}')" 2e-6 "a changed stiffness"
[ "$(files)" = 2 ] || fail "a changed stiffness: $(files) files, expected 2"

# Two ranks write.
for kind in dense; do
  rm -rf cache && mkdir cache
  run=("$fault" -fault_operator $kind -fault_nx 42 -fault_nz 36)
  first=$(slip mpirun --oversubscribe -n 2 "${run[@]}" -fault_view)
  [ "$(files)" = 1 ] && [ ! -s messages ] || fail "$kind on two ranks: $(files) files, messages: $(cat messages)"
  same "$first" "$(slip mpirun --oversubscribe -n 2 "${run[@]}")" 0 "$kind, written and read on two ranks"
  same "$first" "$(slip "${run[@]}")" 2e-6 "$kind, written on two ranks, read on one"
done

# Three at once.
rm -rf cache && mkdir cache
run=("$fault" -fault_operator dense -fault_nx 42 -fault_nz 36 -ts_max_time 0.3 -fault_cache_dir cache)
for k in 1 2 3; do "${run[@]}" >log$k 2>err$k & done
wait
for k in 1 2 3; do
  same "$(awk '/final mean slip/{print $4}' log1)" "$(awk '/final mean slip/{print $4}' log$k)" 0 "run $k of 3 at once"
  [ ! -s err$k ] || fail "run $k of 3 at once: $(cat err$k)"
done
[ "$(files)" = 1 ] || fail "3 runs at once left $(find cache -type f)"

# Directories.
touch file
for dir in none file; do
  for ranks in 1 2; do
    mpirun --oversubscribe -n $ranks "$fault" -fault_cache_dir $dir >log 2>messages && fail "-fault_cache_dir $dir is no error"
    [ "$(grep -c "^fault: error: cache directory $dir: no such directory" messages)" = 1 ] ||
      fail "-fault_cache_dir $dir on $ranks ranks: $(cat messages)"
  done
done
exit $failed
