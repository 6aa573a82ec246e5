#!/usr/bin/env bash
# -fault_stiffness_average: every storage of the stiffness, a mesh that is the grid and two ranks make the same run; it is
# nearer to the run on finer cells than centres are; checkpoints tell averages apart; bad combinations are refused.
set -uo pipefail
. "$SLIPSTEP_SOURCE/tests/integration/prelude.sh"
fault=$bin/fault
steps=(-ts_adapt_type none -ts_bathe_error none -ts_dt 0.5 -fault_output_interval 1000 -fault_output_fields slip)

run() { # name command...
  "${@:2}" "${steps[@]}" -fault_output "$1.h5" >log 2>&1 || { cat log; exit 1; }
}
coarse=("$fault" -fault_nx 12 -fault_nz 10)
fine=("$fault" -fault_nx 24 -fault_nz 20)
"$SLIPSTEP_PYTHON" "$SLIPSTEP_SOURCE/examples/make_mesh.py" mesh.h5 uniform --cells 12 10 --size 3000 3000 >/dev/null || exit 77
for average in cell whole; do
  this=(-fault_stiffness_average $average)
  for operator in dense fft hmat; do run "grid_${average}_$operator" "${coarse[@]}" "${this[@]}" -fault_operator $operator; done
  run "grid_${average}_transform" "${coarse[@]}" "${this[@]}" -fault_operator fft -mat_slipfft_depth transform
  run "grid_${average}_lanczos" "${coarse[@]}" "${this[@]}" -fault_operator fft -fault_viscosity lanczos
  for operator in dense hmat; do run "grid_${average}_mesh_$operator" "$fault" -fault_mesh mesh.h5 "${this[@]}" -fault_operator $operator; done
  run "grid_${average}_ranks" mpirun --oversubscribe -n 2 "${coarse[@]}" "${this[@]}" -fault_operator fft
  run "grid_${average}_mesh_ranks" mpirun --oversubscribe -n 2 "$fault" -fault_mesh mesh.h5 "${this[@]}" -fault_operator hmat
done
for average in centre cell whole; do
  run "coarse_$average" "${coarse[@]}" -fault_stiffness_average $average
  run "fine_$average" "${fine[@]}" -fault_stiffness_average $average
done
run spectral "${coarse[@]}" -fault_operator fft -fault_viscosity spectral -fault_stiffness_average cell

"$SLIPSTEP_PYTHON" - <<'P' || failed=1
import glob
import sys
import h5py
import numpy as np

failed = []

def check(good, text):
    print(text if good else "FAILED: " + text)
    if not good:
        failed.append(text)

def slip(name):
    with h5py.File(name) as f:
        return f["fields/slip"][-1].ravel(), f["result"].attrs["mean_slip"]

# 1e-7: hmat's blocks and Lanczos' products are exact to 1e-8 each, the sketched root to 1e-10
for average in ("cell", "whole"):
    base = slip(f"grid_{average}_dense.h5")[0]
    for name in sorted(glob.glob(f"grid_{average}_*.h5")):
        off = np.abs(slip(name)[0] - base).max() / base.max()
        check(off < 1e-7, f"{name} is the run of dense storage to {off:.1e}")
# what twice the cells across change: averages of the whole are of the second order where all cells slide
change = {a: abs(slip(f"coarse_{a}.h5")[1] / slip(f"fine_{a}.h5")[1] - 1) for a in ("centre", "cell", "whole")}
check(change["centre"] > 0.05 and change["cell"] < 0.8 * change["centre"] and change["whole"] < 0.05 * change["centre"],
      f"twice the cells across change the slip by {change}")
sys.exit(bool(failed))
P

tiny=("$fault" -fault_nx 3 -fault_nz 3 -ts_adapt_type heuristic -ts_rtol 1e-3)
"${tiny[@]}" -fault_stiffness_average cell -fault_checkpoint c.h5 -ts_max_steps 5 >log 2>&1
[ -f c.h5 ] || fail "no checkpoint: $(cat log)"
refuses "stiffness_average is centre" -- "${tiny[@]}" -fault_restart c.h5
"${tiny[@]}" -fault_stiffness_average cell -fault_restart c.h5 >log 2>&1 || fail "no restart: $(cat log)"
refuses "-fault_stiffness_average" '"edge"' "centre, cell, whole" -- "${tiny[@]}" -fault_stiffness_average edge
refuses "-fault_stiffness_average whole" "-fault_viscosity spectral" -- "${tiny[@]}" -fault_stiffness_average whole -fault_viscosity spectral
"$SLIPSTEP_PYTHON" - <<'P' || exit 77
import h5py
import numpy as np
with h5py.File("k.h5", "w") as f:
    f["stiffness"] = np.eye(9) * 3e7
P
refuses "-fault_stiffness_average cell" "-fault_stiffness_file k.h5" -- "${tiny[@]}" -fault_stiffness_file k.h5 -fault_stiffness_average cell
exit $failed
