#!/usr/bin/env bash
# A tide on patches of a creeping fault: installs what is missing (Debian 12 and 13, Ubuntu 24.04), builds into build/,
# simulates small repeating events with the tide of the moon and without it, and draws the phases of the events.
#
#   examples/tides.sh [OPTION...]                 options of build/bin/fault
#   DAYS=400 examples/tides.sh                    longer
set -euo pipefail
cd "$(dirname "$0")/.."
. tests/setup.sh

slipstep_ready
name=$SLIPSTEP_OUTPUT/tides
"$SLIPSTEP_PYTHON" - "${name}_fields.h5" <<'PY'
import sys
import h5py
import numpy as np

# Eight patches of one cell weaken with rate, all around them creeps; a is 0.01.
b = np.full((6, 12), 0.006)
b[1::3, 1::3] = 0.016
with h5py.File(sys.argv[1], "w") as f:
    f["friction_b"] = b
PY
# a sigma is 10 kPa: fluids carry nearly all of the weight, as where tremor follows tides
for case in without with; do
  tide=()
  if [ "$case" = with ]; then tide=(-fault_tide_period 12.42h -fault_tide_shear 2e3); fi
  printf '\n== %s the tide ==\n' "$case"
  "$SLIPSTEP_BUILD/bin/fault" -fault_nx 12 -fault_nz 6 -fault_length_x 1200 -fault_length_z 600 \
    -fault_depth_top 20000 -fault_kernel full_space -fault_normal_stress 1e6 -fault_friction_law rate_and_state \
    -fault_friction_a 0.01 -fault_friction_slip 1e-5 -fault_loading_rate 1e-9 -fault_event_rate 1e-5 \
    -fault_parameters "${name}_fields.h5" -ts_max_time "${DAYS:-200}d" -fault_output "${name}_$case.h5" \
    -fault_catalogue "${name}_${case}_events.h5" -fault_output_time_interval 10d \
    -fault_output_xdmf no -fault_output_overwrite "${tide[@]}" "$@" | tail -n 1
done
slipstep tides "${name}_with.h5" "${name}_with_events.h5" --since 20d --figure "$name.png"
