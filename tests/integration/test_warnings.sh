#!/usr/bin/env bash
# What a run is warned of before it begins: units, resolution, few cells, a steady start, a thickness, planes; each once, by rank 0, with
# the option and its value. Runs without a cause have no such line.
set -uo pipefail
. "$SLIPSTEP_SOURCE/tests/integration/prelude.sh"
few=("$bin/fault" -fault_nx 4 -fault_nz 3 -ts_max_time 1e-3)
short=("${few[@]}" -fault_stiffness_average whole)
cycle=("${few[@]}" -fault_length_x 4000 -fault_length_z 3000 -fault_normal_stress 50e6 -fault_normal_stress_gradient 0
  -fault_friction_law rate_and_state -fault_loading_rate 1e-9)

warns() { # word,word,... -- command: one warning that has all of them, and no other one
  local words=() line
  while [ "$1" != -- ]; do words+=("$1"); shift; done
  shift
  "$@" >out.txt 2>err.txt || fail "$*: $(cat err.txt)"
  line=$(grep -F "fault: warning: " err.txt)
  [ "$(grep -c . err.txt)" = 1 ] || fail "not one line from $*: $(cat err.txt)"
  for word in "${words[@]}"; do [[ $line == *"$word"* ]] || fail "no \"$word\" in the warning of $*: $line"; done
}
quiet() { # command: no warning
  "$@" >out.txt 2>err.txt || fail "$*: $(cat err.txt)"
  [ ! -s err.txt ] || fail "a warning of $*: $(cat err.txt)"
}

# What auto has chosen counts: a hierarchical matrix for a slender dipping plane, transforms for others
long=("$bin/fault" -fault_dip 30 -fault_length_x 1000 -fault_length_z 90000 -fault_inertia no -fault_viscosity radiation -ts_max_time 1e-3
  -fault_hmat_tolerance 1e-5)
"${long[@]}" -fault_nx 1 -fault_nz 300 -fault_view >out.txt 2>err.txt || fail "a slender plane: $(cat err.txt)"
grep -q "stiffness K: sliphmat" out.txt || fail "no hierarchical matrix where auto should have chosen it"
if grep "warning: -fault_hmat_tolerance" err.txt; then fail "the tolerance of a hierarchical matrix that auto has chosen is said to be idle"; fi
"${long[@]}" -fault_nx 4 -fault_nz 3 >out.txt 2>err.txt || fail "a small plane: $(cat err.txt)"
grep -q "warning: -fault_hmat_tolerance" err.txt || fail "no word that the tolerance is idle: $(cat err.txt)"

# Units, of options and of a file. 0 is no number to doubt.
quiet "${short[@]}"
warns "-fault_length_x is 40 m" km -- "${short[@]}" -fault_length_x 40
warns "-fault_length_z is 40 m" km -- "${short[@]}" -fault_length_z 40
quiet "${short[@]}" -fault_length_x 2 -fault_length_z 1 -fault_normal_stress 5e6 -fault_normal_stress_gradient 0 -fault_friction_slip 1e-6 # a laboratory
warns "-fault_shear_modulus is 30 Pa" GPa 1e+07 -- "${short[@]}" -fault_shear_modulus 30
warns "-fault_normal_stress is 50 Pa" MPa -- "${short[@]}" -fault_normal_stress 50
warns "-fault_normal_stress_gradient is 15 Pa/m" -- "${short[@]}" -fault_normal_stress_gradient 15
warns "-fault_density is 2.67 kg/m^3" "g/cm^3" -- "${short[@]}" -fault_density 2.67
warns "-fault_loading_rate is 32 m/s" "mm a year" -- "${short[@]}" -fault_loading_rate 32 -fault_friction_slip 5
warns "-fault_friction_drop is 10" "per cent" -- "${short[@]}" -fault_friction_drop 10
warns "-fault_initial_traction is 4 Pa" MPa -- "${short[@]}" -fault_initial traction -fault_initial_traction 4 -fault_friction_slip 10
"$SLIPSTEP_PYTHON" - <<'PY'
import h5py
import numpy as np

with h5py.File("mpa.h5", "w") as f:
    f["normal_stress"] = np.full((3, 4), 50.0)
with h5py.File("slip.h5", "w") as f:
    f["friction_slip"] = np.linspace(0.5, 0.1, 12).reshape(3, 4)
with h5py.File("planes.h5", "w") as f:
    f["cells"] = np.array([(500.0, y, 500.0, 1000.0, 1000.0) for y in (0.0, 500.0)])
with h5py.File("plane.h5", "w") as f:
    f["cells"] = np.array([(x, 0.0, 500.0, 1000.0, 1000.0) for x in (500.0, 1500.0)])
PY
warns "mpa.h5: /normal_stress is at most 50 Pa" MPa -- "${short[@]}" -fault_parameters mpa.h5

# Resolution: L_b = G d_c/(b sigma), 400 m with d_c = 0.01 m and 4000 m with 0.1 m, of cells of 1 km
warns "400 m" "0.4 cells" "at least 3" "Day et al. 2005" -fault_friction_slip -- "${cycle[@]}" -fault_friction_slip 0.01
quiet "${cycle[@]}" -fault_friction_slip 0.1
# The whole fault slides at once; when it is loaded ruptures will follow.
quiet "${short[@]}" -fault_friction_slip 0.01
warns "100 %" -fault_friction_slip -- "${short[@]}" -fault_friction_slip 0.01 -fault_loading_rate 1e-9 -fault_healing_time 1e7 -ts_adapt_type none

# The same of any number of ranks, in the line before the run, the summary, /result and -fault_view
for ranks in 1 2; do
  mpirun --oversubscribe -n $ranks "${cycle[@]}" -fault_parameters slip.h5 -fault_view -fault_output $ranks.h5 >$ranks.txt 2>err.txt ||
    fail "$ranks ranks: $(cat err.txt)"
  grep -E "resolution|fail alone" $ranks.txt >$ranks.lines
  [ "$(wc -l <$ranks.lines)" = 4 ] || fail "lines of $ranks ranks: $(cat $ranks.lines)"
done
cmp 1.lines 2.lines || fail "2 ranks: $(cat 2.lines)"
grep -q "^resolution: *4 cells of 1000 m .*4000 m" 1.lines || fail "the least of all cells: $(cat 1.lines)"
"$SLIPSTEP_PYTHON" -c 'import h5py; a = h5py.File("2.h5")["result"].attrs; assert abs(a["least_resolution"] - 4) < 1e-12 and a["cells_fail_alone"] == 0' ||
  fail "/result"

# Few cells with `centre`, where the whole fault slides
warns "4 x 3 cells" "-fault_stiffness_average whole" -- "${few[@]}"
warns "20 x 41 cells" -- "${few[@]}" -fault_nx 20 -fault_nz 41
quiet "${few[@]}" -fault_nx 21 -fault_nz 21
quiet "${few[@]}" -fault_stiffness_scaling mean_slip
warns "4 x 3 cells" "Use more cells" -- "${few[@]}" -fault_dip 60 -fault_depth_top 100 # which has no other average
quiet "${few[@]}" -fault_nx 1

# A gradient beside a field of normal stress, to which it is not added
"$SLIPSTEP_PYTHON" -c 'import h5py, numpy; h5py.File("stress.h5", "w")["normal_stress"] = numpy.full((3, 4), 40e6)' || fail "stress.h5"
warns "-fault_normal_stress_gradient" "stress.h5: /normal_stress" -- "${short[@]}" -fault_parameters stress.h5 -fault_normal_stress_gradient 2e4
quiet "${short[@]}" -fault_parameters stress.h5 -fault_normal_stress_gradient 0
quiet "${short[@]}" -fault_parameters stress.h5

# A policy whose training has not ended
"$SLIPSTEP_PYTHON" - <<'PY' || fail "unfinished.h5"
import h5py, os, shutil
shutil.copy(os.environ["SLIPSTEP_SOURCE"] + "/training/policies/fault.h5", "unfinished.h5")
with h5py.File("unfinished.h5", "r+") as file:
    del file.attrs["checksum"]
    file.attrs["unfinished"] = "not calibrated"
PY
learned=("${short[@]}" -ts_adapt_type rl -ts_adapt_rl_policy)
warns unfinished.h5 "not calibrated" -- "${learned[@]}" unfinished.h5
grep -q "^steps: .*rl at the accuracy 0.01, policy unfinished.h5$" out.txt || fail "the policy is not named: $(cat out.txt)"
quiet "${learned[@]}" "$SLIPSTEP_SOURCE/training/policies/fault.h5"

# An equilibrium that only rounding leaves: h* is 7.6 km, which the fault of 12 km x 9 km exceeds and that of 4 km x 3 km does not.
large=("${cycle[@]}" -fault_nx 12 -fault_nz 9 -fault_length_x 12000 -fault_length_z 9000)
warns "steady state" "-fault_initial_rate" -- "${large[@]}" -fault_initial_rate 1e-9
warns "steady state" -- "${large[@]}" -fault_initial traction -fault_initial_traction 31.726907e6 # of the mu that is steady
quiet "${large[@]}"
quiet "${cycle[@]}" -fault_initial_rate 1e-9
quiet "${large[@]}" -fault_initial_rate 2e-9
quiet "${large[@]}" -fault_initial_rate 1e-9 -fault_initial_state 2e8
quiet "${large[@]}" -fault_initial_rate 1e-9 -fault_friction_a 0.02
quiet "${large[@]}" -fault_initial_rate 1e-9 -fault_stressing_rate 1e-3

# A front slower than earthquakes: 0.6 cs sqrt(G/(W Ly)), G/W = 5 km, is 0.67 cs with Ly = 4 km and 0.21 with 40 km
front=("${few[@]}" -fault_length_x 4000 -fault_length_z 3000 -fault_normal_stress 30e6 -fault_normal_stress_gradient 0
  -fault_friction_law linear_slip_weakening -fault_friction_slip 0.5 -fault_initial traction -fault_initial_traction 17e6)
quiet "${front[@]}" -fault_inertia yes
warns "-fault_thickness is 40000 m" "-fault_inertia no" -- "${front[@]}" -fault_inertia yes -fault_thickness 40000
quiet "${front[@]}" -fault_thickness 40000
# and a faster one than shear waves: (2/3 of the drop - 0.35) 2.1 cs sqrt(G/(W Ly)) is 1.21 cs with Ly = 1.5 km under sqrtm, and 0.9 with 2.7 km;
# radiation limits it to 0.66
quick=("${front[@]}" -fault_inertia yes -fault_thickness 1500)
warns "-fault_thickness is 1500 m" "0.67 of the drop" "1.2 times" "2.7e+03 m" -- "${quick[@]}"
grep -q "^viscosity: *sqrtm, the default with -fault_inertia yes.* radiation (-fault_viscosity)" out.txt || fail "the viscosity is not said: $(cat out.txt)"
quiet "${quick[@]}" -fault_viscosity radiation
grep -q "^viscosity:" out.txt && fail "a viscosity that was chosen is said: $(cat out.txt)"
warns "1.3 times" -- "${quick[@]}" -fault_viscosity radiation -fault_thickness 100 -fault_initial_traction 17.5e6

# Normal stress does not pass between planes.
warns "planes.h5" "normal stress" -- "$bin/fault" -fault_mesh planes.h5 -ts_max_time 1e-3
quiet "$bin/fault" -fault_mesh plane.h5 -ts_max_time 1e-3
mpirun --oversubscribe -n 2 "$bin/fault" -fault_mesh planes.h5 -ts_max_time 1e-3 >out.txt 2>err.txt
[ "$(grep -c "fault: warning: " err.txt)" = 1 ] || fail "not one warning of two ranks: $(cat err.txt)"

exit $failed
