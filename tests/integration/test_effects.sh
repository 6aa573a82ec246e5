#!/usr/bin/env bash
# Options that were given are obeyed, refused, or named as without effect: a few of them for a few kinds of run of effects.py,
# which tries all by hand (--all).
set -uo pipefail
. "$SLIPSTEP_SOURCE/tests/integration/prelude.sh"
"$SLIPSTEP_PYTHON" -c 'import h5py, numpy' || exit 77
export TMPDIR=$work
"$SLIPSTEP_PYTHON" "$SLIPSTEP_SOURCE/tests/integration/effects.py" "$SLIPSTEP_BUILD" || fail "an option that is neither obeyed nor named"
exit $failed
