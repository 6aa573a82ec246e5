"""A job array of Slurm for a study: each task runs its one run and goes back into the queue until that is over; the
table is collected afterwards."""

import shlex

from ..errors import Error

DEFAULT = {"time": "04:00:00", "mem-per-cpu": "2G"}
FIXED = {"array", "ntasks", "signal", "requeue", "open-mode", "output"}
AGAIN = 75  # exit code of a task whose run goes on (EX_TEMPFAIL)

SCRIPT = """#!/usr/bin/env bash
# A job array, a task for each run of a study: sbatch {name}
# A task that Slurm is about to end stops after its step, with a checkpoint, and goes back into the queue.
# Afterwards: {program} {study} --table
#SBATCH --job-name={job}
#SBATCH --array={array}
#SBATCH --ntasks={ranks}
#SBATCH --signal=B:USR1@120
#SBATCH --requeue
#SBATCH --open-mode=append
#SBATCH --output={folder}/slurm_%a.txt
{more}set -u
export HWLOC_COMPONENTS=${{HWLOC_COMPONENTS--opencl}}
{program} {study} --task "$SLURM_ARRAY_TASK_ID" &
job=$!
trap 'kill -USR1 $job' USR1 TERM
code=0
wait $job || code=$?
while kill -0 $job 2>/dev/null; do # a signal ends a wait
  code=0
  wait $job || code=$?
done
[ $code = {again} ] || exit $code
scontrol requeue "${{SLURM_ARRAY_JOB_ID}}_$SLURM_ARRAY_TASK_ID"
"""


def ranges(numbers):
    """Ascending numbers as sbatch --array has them: 1-3,7."""
    parts = []
    for number in numbers:
        if parts and number == parts[-1][1] + 1:
            parts[-1][1] = number
        else:
            parts.append([number, number])
    return ",".join(str(a) if a == b else f"{a}-{b}" for a, b in parts)


def script(plan, folder, study, numbers, name, program):
    """The text of the job array for the runs of these numbers."""
    given = {key.replace("_", "-"): value for key, value in plan.given["slurm"].items()}
    for key in given:
        if key in FIXED:
            raise Error(f"{plan.source}: slurm.{key} is of the job array itself, expected another option of sbatch")
    if not numbers:
        raise Error(f"{plan.source}: all runs are over, there is none for a job array")
    ranks, job = max(run.ranks for run in plan.runs), given.pop("job-name", "study")
    more = "".join(f"#SBATCH --{key}" + ("" if value is True else f"={value}") + "\n"
                   for key, value in {**DEFAULT, **given}.items() if value is not False)
    return SCRIPT.format(name=name, program=" ".join(map(shlex.quote, program)), study=shlex.quote(study), job=job,
                         array=ranges(numbers), ranks=ranks, folder=folder, more=more, again=AGAIN)

