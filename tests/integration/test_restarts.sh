#!/usr/bin/env bash
# Runs that go on from a checkpoint are the unbroken ones to the bit: a few of the integrators and controllers of restarts.py,
# which does all of them by hand (--all).
set -uo pipefail
. "$SLIPSTEP_SOURCE/tests/integration/prelude.sh"
"$SLIPSTEP_PYTHON" -c 'import h5py, numpy' || exit 77
export TMPDIR=$work
"$SLIPSTEP_PYTHON" "$SLIPSTEP_SOURCE/tests/integration/restarts.py" "$SLIPSTEP_BUILD" --moments 2 --steps || fail "a restart is another run"
exit $failed
