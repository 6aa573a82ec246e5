#!/usr/bin/env bash
# SEAS BP8-QD, the community's benchmark of slow slip by an injection into a square fault: installs what is missing (Debian 12 and 13,
# Ubuntu 24.04), builds into build/, computes the pressure of 100 hours of injection, simulates 30 days of slip, and draws both.
#
#   examples/seas_bp8.sh [OPTION...]                       options of build/bin/fault: seconds
#   CELL=5 SOURCE=well RATE=0.0015 examples/seas_bp8.sh     cells of 5 m; a well in place of the Gaussian source; m^3/s
#   SOURCE=diffusion examples/seas_bp8.sh                   the fault computes the diffusion, from -fault_wells; or diffusion_well
set -euo pipefail
cd "$(dirname "$0")/.."
. tests/setup.sh

slipstep_ready
name=$SLIPSTEP_OUTPUT/seas_bp8
source=${SOURCE:-gaussian}
words=(--cell "${CELL:-10}" --rate "${RATE:-0.003}")
load=(-fault_pore_pressure "${name}_pressure.h5")
case $source in *well) words+=(--well) ;; esac
case $source in diffusion*)
  words+=(--diffusion)
  load=(-fault_wells "${name}_wells.csv" -fault_permeability 5e-14 -fault_porosity 0.1 -fault_pore_compressibility 1e-8
    -fault_fluid_viscosity 1e-3 -fault_output_fields slip_rate,slip,pore_pressure) ;;
esac
n=$("$SLIPSTEP_PYTHON" examples/seas_bp8.py make "$name" "${words[@]}")
"$SLIPSTEP_BUILD/bin/fault" -options_file examples/seas_bp8.opts -fault_nx "$n" -fault_nz "$n" \
  "${load[@]}" -fault_output "$name.h5" -fault_output_overwrite "$@"
"$SLIPSTEP_PYTHON" examples/seas_bp8.py plot "$name"
