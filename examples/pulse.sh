#!/usr/bin/env bash
# A stress pulse that passes a fault which is about to slip, as of the waves of a distant earthquake: installs what is missing
# (Debian 12 and 13, Ubuntu 24.04), builds into build/, simulates the event without the pulse and with it, hours to days before,
# and draws how much earlier it comes.
#
#   examples/pulse.sh [OPTION...]                            options of build/bin/fault
#   BEFORE="1h 3h 12h 2d" AMPLITUDES="4e5 8e5" examples/pulse.sh   when the pulse comes, and its largest stress [Pa]
set -euo pipefail
cd "$(dirname "$0")/.."
. tests/setup.sh

slipstep_ready
name=$SLIPSTEP_OUTPUT/pulse
"$SLIPSTEP_PYTHON" examples/pulse.py fields "$name"
# a sigma is 0.1 MPa, d_c 2.5 mm: slip accelerates for days and breaks the middle of 6 km x 3 km
run() {
  local case=$1
  shift
  "$SLIPSTEP_BUILD/bin/fault" -fault_nx 56 -fault_nz 32 -fault_length_x 7000 -fault_length_z 4000 -fault_depth_top 8000 \
    -fault_kernel full_space -fault_friction_law rate_and_state -fault_friction_a 0.01 -fault_friction_slip 0.0025 \
    -fault_normal_stress 10e6 -fault_normal_stress_gradient 0 -fault_initial rate -fault_initial_rate 1e-9 \
    -fault_loading_rate 1e-9 -fault_parameters "${name}_fields.h5" -ts_rtol 1e-5 -fault_output "${name}_$case.h5" \
    -fault_catalogue "${name}_${case}_events.h5" -fault_output_xdmf no -fault_output_overwrite "$@" | tail -n 1
}
printf '\n== without a pulse ==\n'
run without -ts_max_time 25d "$@"
rm -f "${name}"_*_stress.h5
read -ra before <<<"${BEFORE:-30min 1h 3h 8h 1d 3d}"
read -ra amplitudes <<<"${AMPLITUDES:-6e5 1e6}"
made=$("$SLIPSTEP_PYTHON" examples/pulse.py make "$name" --before "${before[@]}" --amplitude "${amplitudes[@]}")
read -ra cases <<<"$made"
for case in "${cases[@]:1}"; do
  printf '\n== %s ==\n' "$case"
  run "$case" -fault_stress_history "${name}_${case}_stress.h5" -ts_max_time "${cases[0]}" "$@"
done
"$SLIPSTEP_PYTHON" examples/pulse.py plot "$name"
