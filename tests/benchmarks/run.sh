#!/usr/bin/env bash
# The benchmark in one command: times and memory of every operator, scaling on 1 and 2 ranks, iterations of the linear
# solver and full runs, written to one HDF5 file.
#   tests/benchmarks/run.sh [--quick] [--max-n N] [--output F.h5] [--build DIR] [--timeout S] [--retry]
# Run again with the same --output it goes on where it stopped. --quick takes less than a minute.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
. "$root/tests/setup.sh"
slipstep_environment
slipstep_find_python
exec "$SLIPSTEP_PYTHON" "$here/run.py" "$@"
