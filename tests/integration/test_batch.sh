#!/usr/bin/env bash
# examples/batch.sh with a Slurm of three commands: it ends in time, whether the signal reaches the run or the script alone, goes back
# into the queue and goes on, until the run is the unbroken one; it gives up where nothing goes on or a file says so, and passes errors
# on.
set -uo pipefail
. "$SLIPSTEP_SOURCE/tests/integration/prelude.sh"
"$SLIPSTEP_PYTHON" -c 'import h5py, numpy' || exit 77

mkdir slurm
cat >slurm/squeue <<'S'
echo "$TIME_LEFT"
S
cat >slurm/srun <<'S'
[ "$SEND" ] || exec "$@"
"$@" & p=$!
until [ -e run.state.h5 ] || ! kill -0 $p; do sleep 0.01; done
case $SEND in
script) kill -USR1 $PPID ;;
file) touch run.stop ;;
*) kill -"$SEND" $p ;;
esac
wait $p
S
cat >slurm/scontrol <<'S'
[ "$1 $2" = "requeue 7" ] && echo again >queued
S
sed -i '1i #!/bin/sh' slurm/*
chmod +x slurm/*
export TMPDIR=$work PATH=$work/slurm:$PATH SLURM_JOB_ID=7 SLIPSTEP_FAULT=$bin/fault SLIPSTEP_MARGIN=60 SEND=
printf "%s\n" "-fault_nx 8" "-fault_nz 8" "-ts_max_time 3" "-ts_adapt_type none" "-ts_dt 1e-3" "-fault_checkpoint_interval 0.1" >run.opts

# job TIME_LEFT: exit code in $code, its words in job.txt
job() {
  rm -f queued
  code=0
  TIME_LEFT=$1 bash "$SLIPSTEP_SOURCE/examples/batch.sh" run.opts run >job.txt 2>&1 || code=$?
}

"$bin/fault" -options_file run.opts -fault_output whole.h5 >/dev/null || fail "the unbroken run"

SLURM_RESTART_COUNT=0
export SLURM_RESTART_COUNT
limit=3
for SEND in script USR1 "" "" "" "" "" "" "" "" ""; do # stopped by a signal, then by limits from 3 s on, as often as it takes
  export SEND
  if [ "$SEND" ]; then job 1-00:00:00; else job 0:$((60 + limit)); fi
  limit=$((2 * limit))
  [ $code = 1 ] && grep -q "no step fits into" job.txt && continue # on a busy machine
  [ $code = 0 ] || { fail "exit code $code: $(cat job.txt)"; break; }
  [ -e queued ] || break
  SLURM_RESTART_COUNT=$((SLURM_RESTART_COUNT + 1))
  cp job.txt queued.txt
done
[ ! -e queued ] || fail "still in the queue after $SLURM_RESTART_COUNT jobs: $(cat job.txt)"
[ "$SLURM_RESTART_COUNT" -ge 1 ] || fail "one job was enough: nothing was tested"
grep -q "goes back into the queue" queued.txt || fail "$(cat queued.txt)"
grep -q "has reached its end" job.txt || fail "$(cat job.txt)"
sums=$(cksum run.*h5*)
job 1-00:00:00 # once more, by mistake
[ $code = 0 ] && [ ! -e queued ] && grep -q "nothing is left to do" job.txt && grep -q "has reached its end" job.txt || fail "again: $code $(cat job.txt)"
[ "$(cksum run.*h5*)" = "$sums" ] || fail "a job that was submitted again after the end wrote: $(cksum run.*h5*)"
"$SLIPSTEP_PYTHON" - <<'P' || fail "the run of several jobs is not the unbroken one"
import h5py
with h5py.File("whole.h5") as a, h5py.File("run.h5") as b:
    for name in ("steps/dt", "series/time", "series/mean_slip", "fields/slip", "fields/slip_rate"):
        assert a[name].shape == b[name].shape and (a[name][...] == b[name][...]).all(), name
P
[ ! -e run.stop ] || fail "run.stop was left"

rm -f run.h5* run.state.h5*
export SLURM_RESTART_COUNT=0
SEND=file job 1-00:00:00
[ $code = 0 ] && [ ! -e queued ] && [ -e run.state.h5 ] && grep -q "batch.sh: stopped by run.stop" job.txt || fail "a file that stops: exit code $code, $(cat job.txt)"
touch run.stop
SEND= job 1-00:00:00
[ $code = 0 ] && grep -q "before it began" job.txt && [ ! -e run.stop ] || fail "a file that was there: $(cat job.txt)"

SEND=
rm -f run.h5* run.state.h5*
job 1-00:00:59
grep -q "reached its end" job.txt || fail "days and hours: $(cat job.txt)"
job 0:59 # less than the margin
[ $code = 1 ] && grep -q "less than 60 s" job.txt || fail "exit code $code: $(cat job.txt)"
echo "-fault_nx 0" >>run.opts
job 1:00:00
[ $code != 0 ] && [ ! -e queued ] && grep -q "fault_nx" job.txt || fail "an error was not passed on: $(cat job.txt)"
exit $failed
