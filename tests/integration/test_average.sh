#!/usr/bin/env bash
# -fault_stiffness_average cell: every storage of the stiffness, a mesh that is the grid and numbers of ranks make the same
# run; it is nearer to the run on finer cells; checkpoints tell the averages apart; bad combinations are refused.
set -uo pipefail
. "$SLIPSTEP_SOURCE/tests/integration/prelude.sh"
fault=$bin/fault
steps=(-ts_adapt_type none -ts_bathe_error none -ts_dt 0.25 -fault_stiffness_average cell)

run() { # name options...
  "$fault" "${steps[@]}" -fault_output "$1.h5" "${@:2}" >log 2>&1 || { cat log; exit 1; }
}
grid=(-fault_nx 12 -fault_nz 10)
"$SLIPSTEP_PYTHON" "$SLIPSTEP_SOURCE/examples/make_mesh.py" mesh.h5 uniform --cells 12 10 --size 3000 3000 >/dev/null || exit 77
for operator in dense fft hmat; do run "grid_$operator" "${grid[@]}" -fault_operator $operator; done
run grid_transform "${grid[@]}" -fault_operator fft -mat_slipfft_depth transform
run grid_lanczos "${grid[@]}" -fault_operator fft -fault_viscosity lanczos
for operator in dense hmat; do run "mesh_$operator" -fault_mesh mesh.h5 -fault_operator $operator; done
run fine -fault_nx 24 -fault_nz 20
run centre "${grid[@]}" -fault_stiffness_average centre
run fine_centre -fault_nx 24 -fault_nz 20 -fault_stiffness_average centre
run2() { mpirun --oversubscribe -n 2 "$fault" "${steps[@]}" -fault_output "$1.h5" "${@:2}" >log 2>&1 || { cat log; exit 1; }; }
run2 grid_fft2 "${grid[@]}" -fault_operator fft
run2 mesh_hmat2 -fault_mesh mesh.h5 -fault_operator hmat

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

base, mean = slip("grid_dense.h5")
# 1e-7: hmat's blocks and Lanczos' products are exact to 1e-8 each, roots of rows without such to rounding
for name in sorted(glob.glob("grid_*.h5") + glob.glob("mesh_*.h5")):
    off = np.abs(slip(name)[0] - base).max() / base.max()
    check(off < 1e-7, f"{name} is the run of grid_dense.h5 to {off:.1e}")
fine, centre, fine_centre = (slip(name + ".h5")[1] for name in ("fine", "centre", "fine_centre"))
cell_change, change = abs(mean / fine - 1), abs(centre / fine_centre - 1)
# averages converge in the second order where all cells slide, centres in the first
check(change > 0.05 and cell_change < 0.25 * change,
      f"twice the cells across change the slip by {change:.3f} with centres, by {cell_change:.3f} with averages")
sys.exit(bool(failed))
P

tiny=("$fault" -fault_nx 3 -fault_nz 3 -ts_adapt_type heuristic)
"${tiny[@]}" -fault_stiffness_average cell -fault_checkpoint c.h5 -ts_max_steps 5 >log 2>&1
[ -f c.h5 ] || fail "no checkpoint: $(cat log)"
refuses "stiffness_average is centre, was cell" -- "${tiny[@]}" -fault_restart c.h5
"${tiny[@]}" -fault_stiffness_average cell -fault_restart c.h5 >log 2>&1 || fail "no restart: $(cat log)"
refuses "-fault_stiffness_average" '"edge"' "centre, cell" -- "${tiny[@]}" -fault_stiffness_average edge
refuses "-fault_stiffness_average cell" "-fault_viscosity spectral" -- "${tiny[@]}" -fault_stiffness_average cell -fault_viscosity spectral
"${tiny[@]}" -fault_stiffness_view binary:K.bin -fault_stiffness_average cell >log 2>&1 || fail "no view: $(cat log)"
"$SLIPSTEP_PYTHON" - <<'P' || exit 77
import h5py
import numpy as np
with h5py.File("k.h5", "w") as f:
    f["stiffness"] = np.eye(9) * 3e7
P
refuses "-fault_stiffness_average cell" "-fault_stiffness_file k.h5" -- "${tiny[@]}" -fault_stiffness_file k.h5 -fault_stiffness_average cell
exit $failed
