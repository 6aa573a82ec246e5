#!/usr/bin/env bash
# Pressure of -fault_pore_pressure and -fault_injection: bad input is one error; opening is said once; a run goes on from
# its checkpoint with the same bits, and not from that of another pressure; unstable starts.
set -uo pipefail
. "$SLIPSTEP_SOURCE/tests/integration/prelude.sh"
fault=$bin/fault

"$SLIPSTEP_PYTHON" - <<'P' || exit 77
import h5py
import numpy as np

t = np.array([0, 5e4, 1e5, 2e5])
p = np.outer([0, 2e6, 2.5e6, 2e6], np.linspace(1, 0.5, 30)).reshape(4, 5, 6)


def write(name, time=t, pressure=p, units=("s", "Pa"), **more):
    with h5py.File(name, "w") as f:
        for k, (path, data) in enumerate({"time": time, "pressure": pressure, **more}.items()):
            if data is not None:
                f[path] = data
                if k < 2:
                    f[path].attrs["units"] = units[k]


def changed(a, index, value):
    a = a.copy()
    a[index] = value
    return a


write("good.h5")
write("copy.h5", pressure=p.reshape(4, 30))
write("other.h5", pressure=changed(p, (2, 3, 3), 2.6e6))
write("later.h5", time=changed(t, 3, 3e5))
write("no_time.h5", time=None)
write("no_pressure.h5", pressure=None)
write("shape.h5", pressure=p.transpose(0, 2, 1))
write("short.h5", pressure=p[:3])
write("cells.h5", pressure=p.reshape(4, 30)[:, :29])
write("one.h5", pressure=p[0])
write("falls.h5", time=changed(t, 2, 5e4))
write("nan_time.h5", time=changed(t, 1, np.nan))
write("nan.h5", pressure=changed(p, (1, 2, 3), np.nan))
write("empty.h5", time=t[:0], pressure=p[:0])
write("mpa.h5", units=("s", "MPa"))
write("more.h5", presure=p)
write("open.h5", pressure=p * 10)
dense = np.append(np.arange(0, 2e5, 250), [123456.0, 123466.0, 2e5])
dense.sort()
write("dense.h5", dense, np.array([np.interp(x, t, np.arange(4.0)) / 3 * p[2] + (3e5 if x > 123460 else 0) for x in dense]))
P
echo "no HDF5" >not.h5

run=("$fault" -fault_nx 6 -fault_nz 5 -fault_normal_stress 10e6 -fault_normal_stress_gradient 0 -fault_friction_law constant
  -fault_initial traction -fault_initial_traction 4.5e6 -fault_inertia no -fault_viscosity radiation -fault_kernel full_space
  -ts_max_time 2e5 -ts_adapt_type heuristic)
record() { # word... FILE: refused with each word and the option
  local file=${*: -1}
  refuses "-fault_pore_pressure" "${@:1:$#-1}" -- "${run[@]}" -fault_pore_pressure "$file"
}
record missing.h5 missing.h5
record not.h5 not.h5
record "no_time.h5" "/time" no_time.h5
record "no_pressure.h5" "/pressure" no_pressure.h5
record "[4, 6, 5]" "[4, 5, 6]" shape.h5
record "[3, 5, 6]" "[4, 5, 6]" short.h5
record "[4, 29]" "[4, 30]" cells.h5
record "[5, 6]" one.h5
record "/time[2] is 50000 s" falls.h5
record "/time[1] is nan s" nan_time.h5
record /pressure "row 1, cell 15" nan.h5
record /time empty.h5
record '"MPa"' '"Pa"' mpa.h5
record /presure more.h5
for point in "" 3 1,2,3 a,2 1,nan 1,inf "1 2"; do
  refuses "-fault_injection" -- "${run[@]}" -fault_injection "$point" -fault_injection_pressure 1e6 -fault_injection_diffusivity 1
done
point=(-fault_injection 1500,1500)
refuses "-fault_injection 1500,1500" "-fault_injection_pressure" -- "${run[@]}" "${point[@]}" -fault_injection_diffusivity 1
refuses "-fault_injection 1500,1500" "-fault_injection_diffusivity" -- "${run[@]}" "${point[@]}" -fault_injection_pressure 1e6
refuses "-fault_injection_stop is -1" -- "${run[@]}" "${point[@]}" -fault_injection_stop -1
refuses "-fault_injection " -- "${run[@]}" -fault_injection_pressure 1e6
refuses "-fault_initial traction" "30 of 30 cells" "250 to 2750 m" "300 to 2700 m" "1e+06 Pa" \
  "-fault_initial_unstable" -- "${run[@]}" -fault_initial_traction 6e6
# A patch of 5 cells, one of which it meets at a corner, and two cells elsewhere: on the grid, as rectangles of which one is in four parts, and as
# triangles, two for each cell.
"$SLIPSTEP_PYTHON" - <<'P' || exit 77
import h5py
import numpy as np

above = np.zeros((5, 6), bool)
above[1:3, 1:3] = above[3, 3] = above[0, 5] = above[4, 0] = True
a, b = 500.0, 600.0
centre = np.array([(a * (k + 0.5), b * (i + 0.5)) for i in range(5) for k in range(6)])
flat = above.ravel()
rows = np.column_stack([centre[:, 0], 0 * flat, centre[:, 1], a + 0 * flat, b + 0 * flat])
parts = [(rows[7, 0] + i * a / 4, 0, rows[7, 2] + k * b / 4, a / 2, b / 2) for i in (-1, 1) for k in (-1, 1)]
point = np.array([(a * k, 0, b * i) for i in range(6) for k in range(7)])
first = np.array([7 * i + k for i in range(5) for k in range(6)])
halves = np.concatenate([np.column_stack([first, first + 1, first + 8]), np.column_stack([first, first + 8, first + 7])])
meshes = {"grid": ({}, above), "list": ({"cells": np.concatenate([np.delete(rows, 7, 0), parts])}, np.append(np.delete(flat, 7), [True] * 4)),
          "triangles": ({"vertices": point, "triangles": halves}, np.append(flat, flat))}
for name, (mesh, where) in meshes.items():
    with h5py.File(f"start_{name}.h5", "w") as f:
        f["initial_traction"] = np.where(where, 5.5e6, 4.5e6)
    if mesh:
        with h5py.File(f"mesh_{name}.h5", "w") as f:
            for key, value in mesh.items():
                f[key] = value
P
unstable() { # ranks, name, what is said, option...
  ranks "$1" err "${run[@]}" -fault_parameters "start_$2.h5" -fault_initial_unstable -ts_max_steps 1 "${@:4}" >log
  [ $? = 3 ] && [ "$(grep -c "^start: .* $3 " log)" = 1 ] || fail "an unstable start, $2: $(cat log err)"
}
unstable 2 grid "7 of 30 cells, .* 250 to 2750 m .* 300 to 2700 m, .* 500000 Pa; 2 .*(6.67 %"
grep -q "warning: 2 cells (6.67 % .*-fault_initial_unstable" err || fail "no warning of cells outside of the patch: $(cat err)"
unstable 1 list "10 of 33 cells, .*; 2 .*(6.06 %" -fault_mesh mesh_list.h5
unstable 2 triangles "14 of 60 cells, .*; 4 .*(6.67 %" -fault_mesh mesh_triangles.h5
"${run[@]}" -fault_initial_traction 6e6 -fault_initial_unstable >log 2>&1 || fail "an unstable start: $(cat log)"
grep -q "^normal stress: *1e+07 Pa, effective" log || fail "normal stress of an even fault: $(cat log)"
ranks 2 err "${run[@]}" -fault_normal_stress_gradient 1e3 -ts_max_steps 1 >log2
grep -q "^normal stress: *1.03e+07 to 1.27e+07 Pa, effective" log2 || fail "normal stress that grows with depth: $(cat log2)"
grep -q "30 of 30 cells.* 0 of them (0 %" log && ! grep -q "warning: .*-fault_initial_unstable" log || fail "a start of one patch: $(cat log)"

# ---- opening: said once, of the first time that the run has reached with such cells ----
"${run[@]}" -fault_pore_pressure open.h5 -fault_output open_run.h5 >log 2>&1 || fail "opening: $(cat log)"
[ "$(grep -c "warning: at .* cells" log)" = 1 ] || fail "opening: $(cat log)"
"$SLIPSTEP_PYTHON" - "$(sed -n 's/.* warning: at \([^ ]*\) s .* \([0-9]*\) cells.*/\1 \2/p' log)" <<'P' || fail "opening"
import sys
import h5py
import numpy as np
when, cells = sys.argv[1].split()
with h5py.File("open_run.h5") as f, h5py.File("open.h5") as r:
    t = f["series/time"][...]
    k = np.argmin(abs(t - float(when)))
    assert abs(t[k] - float(when)) < 1e-5 * t[k]
    p = lambda x: np.array([np.interp(x, r["time"][...], c) for c in r["pressure"][...].reshape(4, 30).T])
    # cells that are there without strength have not been so at the step before
    assert (p(t[k]) >= 10e6).sum() == int(cells) > 0 and (p(t[k - 1]) < 10e6).all()
    # steps end at the corners of the record
    assert all(abs(t - x).min() <= 1e-12 * x for x in r["time"][1:])
P

# ---- checkpoints ----
for what in record dense source; do
  these=(-fault_pore_pressure good.h5)
  [ $what != dense ] || these=(-fault_pore_pressure dense.h5)
  [ $what != source ] || these=("${point[@]}" -fault_injection_pressure 1e6 -fault_injection_diffusivity 2 -fault_injection_stop 1e5)
  "${run[@]}" "${these[@]}" -fault_output whole.h5 >log 2>&1 || fail "$what: $(cat log)"
  "${run[@]}" "${these[@]}" -ts_max_steps 9 -fault_output part.h5 -fault_checkpoint "$what.state" >log 2>&1
  [ $? = 3 ] || fail "$what, nine steps: $(cat log)"
  [ $what != record ] || these=(-fault_pore_pressure copy.h5) # another name and shape for the same record
  "${run[@]}" "${these[@]}" -fault_restart "$what.state" -fault_output part.h5 >log 2>&1 || fail "$what, restart: $(cat log)"
  "$SLIPSTEP_PYTHON" - $what <<'P' || fail "$what: another run after a restart"
import sys
import h5py
with h5py.File("whole.h5") as a, h5py.File("part.h5") as b:
    for name in ("steps/time", "steps/error", "fields/slip", "fields/traction"):
        assert a[name].shape == b[name].shape and (a[name][...] == b[name][...]).all(), name
    assert len(a["steps/time"]) > 12 and a["fields/slip"][-1].max() > 0
    if sys.argv[1] == "dense":  # 803 corners, of which those of a jump matter
        t = a["fields/time"][...]
        assert len(t) < 200 and all(abs(t - x).min() <= 1e-12 * x for x in (123456, 123466)), len(t)
P
  rm -f part.h5 whole.h5
done
again=("${run[@]}" -fault_restart record.state)
refuses "pore_pressure" "4 times" -- "${again[@]}"
refuses "pore_pressure" "4 times" -- "${again[@]}" -fault_pore_pressure other.h5
refuses "pore_pressure" "4 times" -- "${again[@]}" -fault_pore_pressure later.h5
refuses "inertia is yes" -- "${again[@]}" -fault_pore_pressure good.h5 -fault_inertia yes
again=("${run[@]}" -fault_restart source.state -fault_injection_pressure 1e6 -fault_injection_diffusivity 2 -fault_injection_stop 1e5)
refuses "injection is 1500,1400" -- "${again[@]}" -fault_injection 1500,1400
refuses "injection_stop is 110000 s" -- "${again[@]}" "${point[@]}" -fault_injection_stop 1.1e5
exit $failed
