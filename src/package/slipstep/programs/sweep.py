"""Run a study: many runs whose options differ, each over once, and one table.

    slipstep sweep STUDY.toml                               run what is not over, then write STUDY.csv
    slipstep sweep STUDY.toml --plot magnitude normal_stress
    slipstep sweep STUDY.toml --slurm                       a job array; --table collects its table afterwards

The study file, its keys and columns are explained in examples/howto/studies.md.
"""

import argparse
import os
import sys

from ..modules import find_program
from ..errors import Error
from ..studies import Study
from ..studies.slurm import AGAIN
from ..studies.study import counted

STOPPED = 130  # exit code, as of Ctrl-C


def collected(study, path):
    """Write the table, say what it has, and return the number of runs that failed."""
    study.write_csv(path)
    status = [run.status for run in study.runs]
    words = [f"{status.count(name)} {text}"
             for name, text in (("ended", "ended"), ("early", "ended before their final time"), ("failed", "failed"),
                                ("begun", "begun"), ("open", "not started")) if name in status]
    for run in study.runs:
        if run.status == "failed":
            print(f"run {run.number} failed ({run.file('log.txt')}): {run.error}")
    for name, why in study.empty:
        print(f"sweep: warning: the column {name} is empty in all runs that ended: {why}", file=sys.stderr)
    for line, runs in study.warnings:
        print(f"{counted(len(runs), 'run')} of {len(status)} warn{'s' * (len(runs) == 1)}, the first of them run "
              f"{runs[0].number} ({runs[0].file('log.txt')}): {line}")
    warned = sum(bool(run.warnings) for run in study.runs)
    print(f"Table: {path}, {len(status)} runs: {', '.join(words)}; {warned or 'none'} with warnings")
    return status.count("failed")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("study", metavar="STUDY", help="study file, TOML")
    parser.add_argument("--cores", type=int, metavar="N",
                        help="cores that runs share; default: those of the study, or all of this machine")
    parser.add_argument("--retry", action="store_true", help="begin failed runs anew")
    parser.add_argument("--csv", metavar="OUT", help="table to write, default STUDY.csv")
    action = parser.add_mutually_exclusive_group()
    action.add_argument("--table", action="store_true", help="write the table of what is there, and run nothing")
    action.add_argument("--plot", nargs="+", metavar="COLUMN", help="Y X [BY]: picture of a column against what is "
                                                                    "varied, a line for each value of BY; run nothing")
    action.add_argument("--slurm", nargs="?", const="", metavar="OUT",
                        help="write a job array for the runs that are not over, default STUDY.slurm.sh; run nothing")
    action.add_argument("--task", type=int, metavar="N", help="run number N alone, as tasks of the job array do")
    action.add_argument("--list", action="store_true", help="list all runs and what has become of them; run nothing")
    parser.add_argument("--figure", metavar="OUT", help="picture to write, default STUDY_Y.png")
    options = parser.parse_args()
    if options.cores is not None and options.cores < 1:
        parser.error(f"--cores is {options.cores}, expected a number from 1 on")
    if options.plot and len(options.plot) not in (2, 3):
        parser.error(f"--plot has {len(options.plot)} columns, expected Y X or Y X BY")
    study = Study(options.study)
    stem = os.path.splitext(options.study)[0]
    table = options.csv or f"{stem}.csv"
    if options.list:
        print("\n".join(map(repr, study.runs)))
    elif options.plot:
        picture = options.figure or f"{stem}_{options.plot[0]}.png"
        study.plot(*options.plot[:2], picture, *options.plot[2:])
        print(f"Figure: {picture}")
    elif options.slurm is not None:
        path = options.slurm or f"{stem}.slurm.sh"
        program = find_program("slipstep")
        study.slurm(path, [program, "sweep"] if program else [sys.executable, "-m", "slipstep", "sweep"])
        print(f"Job array: {path}\nStart it by: sbatch {path}")
    elif options.task is not None:
        sys.exit(0 if study.task(options.task) else AGAIN)
    elif options.table:
        collected(study, table)
    else:
        if not study.runs:
            raise Error(f"{options.study}: no runs")
        try:
            study.run(options.cores, options.retry)
        except KeyboardInterrupt:
            collected(study, table)
            print("Stopped; the same command goes on")
            sys.exit(STOPPED)
        sys.exit(1 if collected(study, table) else 0)
