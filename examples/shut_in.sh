#!/usr/bin/env bash
# An injection and its shut-in: a well injects for 30 days into a fault of triangles that is not flat, and patches fail as the pressure reaches
# them, after the shut-in too. Installs what is missing (Debian 12 and 13, Ubuntu 24.04), builds into build/, makes the fault, simulates 90 days,
# draws events against time and distance with the front before them and the one behind them, which say the diffusivity that the catalogue shows, and
# the pressure and the slip, with a film of the pressure. 80 s of processor time.
#
#   examples/shut_in.sh [OPTION...]                        options of build/bin/fault
#   CELL=160 examples/shut_in.sh                           5,000 triangles: many minutes
set -euo pipefail
cd "$(dirname "$0")/.."
. tests/setup.sh

slipstep_ready
name=$SLIPSTEP_OUTPUT/shut_in
"$SLIPSTEP_PYTHON" examples/shut_in.py "$name" --cell "${CELL:-280}"
"$SLIPSTEP_BUILD/bin/fault" -options_file examples/shut_in.opts -fault_mesh "${name}_mesh.h5" -fault_parameters "${name}_fields.h5" \
  -fault_wells "${name}_wells.csv" -fault_output "$name.h5" -fault_catalogue "${name}_events.h5" -fault_output_overwrite \
  -ts_max_time "${DAYS:-90}d" "$@"
echo "Diffusivity k/(viscosity porosity compressibility) of the fault: 0.3 m^2/s; of its events:"
slipstep injection "$name.h5" "${name}_events.h5" --wells "${name}_wells.csv"
slipstep plot-run "$name.h5" --field pore_pressure --range 0 3 --time 5d 30d "${DAYS:-90}d" --figure "${name}_pressure.png"
slipstep plot-run "$name.h5" --field slip --time 5d 30d "${DAYS:-90}d" --figure "${name}_slip.png"
slipstep plot-run "$name.h5" --film "$name.gif" --field pore_pressure --range 0 3 --frames 40
