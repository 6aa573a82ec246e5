#!/usr/bin/env bash
# A run that takes longer than a job may: the Slurm job stops in time, writes a checkpoint, and requeues itself until the
# run has ended.
#
#   sbatch examples/batch.sh examples/fault_3km.opts output/run     options of the run, and names of its files without .h5
#
# Ranks and memory for a size are in examples/howto/long_runs.md. -fault_wall_limit stops the run in time, and SIGUSR1 to this script
# if a step takes longer than the time that was left for it: it makes a file that the run looks for, whatever the launcher does with
# signals. `touch NAME.stop` stops the run for good; the job submitted again goes on.
#SBATCH --job-name=fault
#SBATCH --ntasks=16
#SBATCH --mem-per-cpu=4G
#SBATCH --time=04:00:00
#SBATCH --signal=B:USR1@120
#SBATCH --requeue
#SBATCH --open-mode=append
set -uo pipefail

options=${1:?"usage: sbatch batch.sh OPTIONS_FILE NAME"}
name=${2:?"usage: sbatch batch.sh OPTIONS_FILE NAME"}
fault=${SLIPSTEP_FAULT:-build/bin/fault}
margin=${SLIPSTEP_MARGIN:-120} # of the job's time, for starting and ending it [s]
state=$name.state.h5
stop=$name.stop
# without a look at OpenCL's devices, whose drivers may take over signals (as in tests/setup.sh)
export HWLOC_COMPONENTS=${HWLOC_COMPONENTS--opencl}

# Seconds until the job ends, from D-HH:MM:SS, HH:MM:SS or MM:SS.
left() {
  squeue --noheader --jobs="$SLURM_JOB_ID" --format=%L |
    awk -F '[-:]' '{ for (i = NF; i > 0; i--) s += $i * (i == NF ? 1 : i == NF - 1 ? 60 : i == NF - 2 ? 3600 : 86400); print s }'
}
limit=$(($(left) - margin))
[ "$limit" -gt 0 ] || { echo "batch.sh: less than $margin s are left (SLIPSTEP_MARGIN)" >&2; exit 1; }

if [ -e "$stop" ]; then
  rm "$stop"
  echo "batch.sh: stopped by $stop before it began"
  exit 0
fi

run=(-options_file "$options" -fault_output "$name.h5" -fault_checkpoint "$state" -fault_wall_limit "$limit" -fault_stop_file "$stop")
if [ -e "$state" ] || [ -e "$state.previous" ]; then
  run+=(-fault_restart "$state")
elif [ "${SLURM_RESTART_COUNT:-0}" -gt 0 ]; then
  run+=(-fault_output_overwrite) # ended before its first checkpoint
fi
before=$(cksum "$state" 2>/dev/null)

asked=
trap 'asked=yes; touch "$stop"' USR1 TERM
srun "$fault" "${run[@]}" &
job=$!
wait $job
while kill -0 $job 2>/dev/null; do wait $job; done # a signal ends a wait
code=0
wait $job || code=$?
if [ -e "$stop" ]; then
  rm "$stop"
  if [ $code = 138 ] && [ ! "$asked" ]; then
    echo "batch.sh: stopped by $stop"
    exit 0
  fi
fi
case $code in
0) echo "batch.sh: the run has reached its end" ;;
152 | 138 | 143) # the limit, SIGUSR1 or the file, SIGTERM
  [ "$(cksum "$state" 2>/dev/null)" != "$before" ] || { echo "batch.sh: no step fits into $limit s" >&2; exit 1; }
  echo "batch.sh: exit code $code, goes back into the queue"
  scontrol requeue "$SLURM_JOB_ID"
  ;;
*)
  echo "batch.sh: exit code $code" >&2
  exit "$code"
  ;;
esac
