#!/usr/bin/env bash
# Fluid injected for 20 days into a fault near failure: installs what is missing (Debian 12), builds into build/, draws a
# random initial stress, simulates 40 days, and plots the run, its catalogue and its largest event.
#
#   examples/injection.sh [OPTION...]    options of build/bin/fault
set -euo pipefail
cd "$(dirname "$0")/.."
. tests/setup.sh

slipstep_ready
stress=$SLIPSTEP_OUTPUT/injection_stress.h5
run=$SLIPSTEP_OUTPUT/injection.h5
catalogue=$SLIPSTEP_OUTPUT/injection_catalogue.h5
rm -f "$stress"
"$SLIPSTEP_PYTHON" - "$stress" <<'PY'
import sys
import h5py
import numpy as np

# Shear stress of 48 x 48 cells [Pa]: 20.8 MPa with a scatter of 2 MPa, smooth over 300 m. Strength is 24 MPa, 20 after
# weakening: slip that begins in a highly stressed patch ends where there is little to release.
n, length, smooth = 48, 2400.0, 300.0
k = np.hypot(*np.meshgrid(np.fft.fftfreq(n, length / n), np.fft.fftfreq(n, length / n)))
noise = np.fft.fft2(np.random.default_rng(7).normal(size=(n, n)))
field = np.real(np.fft.ifft2(noise * np.exp(-((2 * np.pi * k * smooth) ** 2) / 2)))
with h5py.File(sys.argv[1], "w") as f:
    f["initial_traction"] = np.minimum(20.8e6 + 2e6 * field / field.std(), 23.8e6)
    f["initial_traction"].attrs["units"] = "Pa"
PY
"$SLIPSTEP_BUILD/bin/fault" -options_file examples/injection.opts -fault_parameters "$stress" \
  -fault_output "$run" -fault_catalogue "$catalogue" -fault_output_overwrite "$@"
slipstep plot-run "$run" --kind space-time --against time
slipstep plot-catalogue "$catalogue" "$run"
slipstep plot-catalogue "$catalogue" --event largest --figure "$SLIPSTEP_OUTPUT/injection_event.png"
