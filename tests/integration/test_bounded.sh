#!/usr/bin/env bash
# Nothing outlives its test: what bounded.c ran has ended, with all that it started in whatever group or session, at its limit, when it
# is told to end, when its starter is killed, and when a test leaves something behind; of the rest it passes the exit code on.
set -uo pipefail
. "$SLIPSTEP_SOURCE/tests/integration/prelude.sh"
[ -e /proc/self/stat ] || exit 77
bounded=$SLIPSTEP_BUILD/tests/bounded
export BOUNDED_GRACE=1

# a test that waits for a process in a session of its own, as mpirun does for its ranks; FILE gets its number
cat >waits.sh <<'S'
setsid sh -c 'trap "" TERM; echo $$ >"$0"; while :; do sleep 1000; done' "$1" &
wait
S
# ended FILE: its process ends
ended() {
  local pid
  pid=$(cat "$1") || { fail "no process in $1"; return; }
  for _ in $(seq 1000); do
    kill -0 "$pid" 2>/dev/null || return 0
    sleep 0.1
  done
  fail "$1: process $pid goes on"
  kill -9 "$pid"
}
appears() { until [ -s "$1" ]; do sleep 0.02; done; }

code=0
"$bounded" 100 bash -c 'exit 77' || code=$?
[ $code = 77 ] || fail "exit code $code in place of 77"
code=0
"$bounded" 100 bash -c 'kill -SEGV $$' 2>/dev/null || code=$?
[ $code = 139 ] || fail "exit code $code in place of 139"

"$bounded" 1 bash waits.sh limit 2>limit.txt & limit=$!
"$bounded" 100 bash waits.sh told 2>told.txt & told=$!
"$bounded" 100 bash -c 'bash waits.sh left & until [ -s left ]; do sleep 0.02; done; kill -9 $!' 2>left.txt & left=$!
bash -c '"$0" 100 bash waits.sh killed & wait' "$bounded" 2>/dev/null & starter=$!
appears killed && appears told
kill -9 $starter
kill -TERM $told
for which in limit:124 told:124 left:1; do
  name=${which%:*} code=0
  wait "${!name}" || code=$?
  [ $code = "${which#*:}" ] || fail "$name: exit code $code, $(cat "$name.txt")"
  ended "$name"
done
ended killed
grep -q "stopped after 1 s" limit.txt || fail "$(cat limit.txt)"
grep -q "left running: .*sh" left.txt || fail "$(cat left.txt)"
exit $failed
