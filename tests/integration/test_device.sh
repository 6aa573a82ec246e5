# Which device -fault_device takes, what it refuses, and its faults: one line each, and a checkpoint that goes on elsewhere. Signals and files
# that are too large do what they do without a device. tests/fakeopencl.c makes cards and faults of the device that there is.
here=$(cd "$(dirname "$0")" && pwd)
. "$here/prelude.sh"
fake=$SLIPSTEP_BUILD/tests/fakeopencl.so
base="-fault_nx 16 -fault_nz 8 -fault_length_x 32e3 -fault_length_z 16e3 -fault_friction_law rate_and_state -fault_normal_stress 25e6
 -fault_normal_stress_gradient 0 -fault_loading_rate 1e-9 -fault_friction_slip 0.1 -fault_friction_a 0.015 -fault_friction_b 0.02 -fault_progress no"
short="$base -ts_max_time 1e9"
fault=$bin/fault
as() { # what the device is to be, command...
  env LD_PRELOAD="$fake" FAKEOPENCL="$1" "${@:2}"
}

if ! "$fault" $base -ts_max_steps 1 -ts_max_time 1 -fault_device opencl >out.txt 2>&1; then
  grep -q "there is no device of OpenCL\|built without OpenCL" out.txt || fail "$(cat out.txt)"
  "$fault" $short -fault_device auto -fault_view >out.txt 2>&1 || fail "auto without a device: $(cat out.txt)"
  grep -q "^ *device: none by -fault_device auto, as " out.txt || fail "no reason: $(cat out.txt)"
  [ $failed = 0 ] || exit 1
  echo "skipped but for auto: $(grep "device: none" out.txt)"
  exit 77
fi

# The numbers of a run, without wall times
same() { # two files
  "$SLIPSTEP_PYTHON" - "$@" <<'PYTHON'
import sys, h5py
a, b = (h5py.File(name) for name in sys.argv[1:])
sys.exit(any(a["steps"][k][()].tobytes() != b["steps"][k][()].tobytes() for k in a["steps"] if "wall" not in k and "cost" not in k)
         or a["fields/displacement"][()].tobytes() != b["fields/displacement"][()].tobytes())
PYTHON
}
chooses() { # what the view says, what the device is, as which of none and opencl its numbers are, option...
  as "$2" "$fault" $short -fault_device auto -fault_view -fault_output auto.h5 -fault_output_overwrite "${@:4}" >view.txt 2>&1 || fail "auto of $2: $(cat view.txt)"
  grep -q "^ *device: .*$1" view.txt || fail "expected \"$1\" in the view of $2: $(grep device: view.txt)"
  as "$2" "$fault" $short -fault_device "$3" -fault_output fixed.h5 -fault_output_overwrite "${@:4}" >/dev/null 2>&1
  same auto.h5 fixed.h5 || fail "auto of $2 is not $3"
}
# the choice, and the numbers
chooses "none by -fault_device auto, as there is no graphics card: .* is a processor" "" none
chooses "none by -fault_device auto, as there is no device of OpenCL" none none
chooses "none by -fault_device auto, as .* has no double precision" card,nodoubles none
chooses "none by -fault_device auto, as the fault and its integrator need up to .* MB" card,memory=100000 none
chooses "none by -fault_device auto, as -fault_device auto knows no waves" card none -fault_medium waves -fault_kernel full_space
chooses "none by -fault_device auto, as no device of OpenCL is named nothing" card none -fault_device_name nothing
chooses "MB, by -fault_device auto" card opencl
mpirun --oversubscribe -n 2 "$fault" $short -fault_device auto -fault_view >view.txt 2>&1 || fail "auto on 2 ranks: $(cat view.txt)"
grep -q "^ *device: none by -fault_device auto, as a device is of one process, not of 2" view.txt || fail "$(grep device: view.txt)"

# refused before anything is computed, or at once
refuses "-fault_device opencl" -- mpirun --oversubscribe -n 2 "$fault" $short -fault_device opencl
refusing() { # what the device is, word...
  refuses "${@:2}" -- env LD_PRELOAD="$fake" FAKEOPENCL="$1" "$fault" $short -fault_device opencl -fault_output refused.h5
}
refusing none "-fault_device opencl"
refusing nodoubles "has no double precision"
refusing card,memory=100000 "0.1 MB of memory"
refusing card,full=60000 "its memory is full"
as broken "$fault" $short -fault_device opencl >out.txt 2>&1 && fail "kernels that do not build"
[ "$(grep -c "^fault: error: the kernels do not build on the device .*: .*'there' (OpenCL's error -11)\$" out.txt)" = 1 ] || fail "kernels that do not build: $(cat out.txt)"

# Cells that open, on a vertical and on a dipping plane, and averages over whole cells: as by the processor, to rounding (measured: 2e-15 of the largest)
opens="-fault_nx 12 -fault_nz 10 -fault_length_x 1200 -fault_length_z 1000 -fault_depth_top 1000 -fault_slip_components 2 -fault_opening yes -fault_inertia no -fault_viscosity radiation
 -fault_normal_stress 5e6 -fault_normal_stress_gradient 0 -fault_friction_law linear_slip_weakening -fault_friction_slip 0.02 -fault_initial traction -fault_initial_traction 2e6
 -fault_injection 600,1500 -fault_injection_pressure 2e6 -fault_injection_diffusivity 0.05 -ts_max_time 864000 -fault_output_fields slip,opening -fault_progress no"
for run in "$opens" "$opens -fault_dip 50" "$short -fault_stiffness_average whole"; do
  "$fault" $run -fault_output host.h5 -fault_output_overwrite >out.txt 2>&1 || fail "$run by the processor: $(cat out.txt)"
  for what in as_is card; do
    as "$what" "$fault" $run -fault_device opencl -fault_output there.h5 -fault_output_overwrite >out.txt 2>&1 || fail "$run on $what: $(cat out.txt)"
    "$SLIPSTEP_PYTHON" - host.h5 there.h5 <<'PYTHON' || fail "$run on $what differs"
import sys, h5py, numpy as np
a, b = (h5py.File(name)["fields"] for name in sys.argv[1:])
wrong = [name for name in set(a) - {"component"} if a[name].shape != b[name].shape or np.abs(a[name][()] - b[name][()]).max() > 1e-11 * np.abs(a[name][()]).max()]
sys.exit(wrong or not np.abs(a["opening" if "opening" in a else "slip"][()]).max() > 0)
PYTHON
  done
done

# A device that is lost: the checkpoint before goes on by the processor, with a warning, and on the device to the bit
run="$fault $base -ts_max_time 1.5e10 -fault_device opencl -fault_output_overwrite"
$run -fault_output whole.h5 >/dev/null 2>&1 || fail "the whole run"
code=0
as lost=2500 $run -fault_output part.h5 -fault_checkpoint state -fault_checkpoint_interval 0.001 >out.txt 2>err.txt || code=$?
[ $code != 0 ] && [ $code -lt 128 ] || fail "exit code $code of a run whose device was lost"
[ "$(grep -av 'warning: ' err.txt | grep -ac .)" = 1 ] || fail "not one line: $(cat err.txt)"
grep -q "the device .* failed, .*: it is out of resources, or was lost (OpenCL's error -5)" err.txt || fail "$(cat err.txt)"
[ -s state ] || fail "no checkpoint of a run whose device was lost"
cp state other
$run -fault_output part.h5 -fault_restart state >out.txt 2>&1 || fail "it does not go on: $(cat out.txt)"
same whole.h5 part.h5 || fail "it goes on otherwise"
"$fault" $base -ts_max_time 1.5e10 -fault_restart other >out.txt 2>&1 || fail "it does not go on by the processor: $(cat out.txt)"
grep -q "warning: .*device is none, was opencl" out.txt || fail "no warning of another device: $(cat out.txt)"

# Stops and kills at random moments, and a file that is too large
for signal in TERM USR1 KILL; do
  "$SLIPSTEP_PYTHON" "$here/kills.py" "$SLIPSTEP_BUILD" --moments 1 --signal $signal --only device || fail "ended by SIG$signal"
done
# the limit comes when output has begun: pocl and Open MPI 5 end a program that may not write their own files, of some MB
large="$fault $base -fault_nx 32 -fault_nz 32 -ts_max_time 4e10 -fault_output large.h5 -fault_output_overwrite"
for device in none opencl; do
  code=0
  rm -f large.h5 large.h5.part
  $large -fault_device $device >out.txt 2>&1 &
  until [ -s large.h5.part ] || ! kill -0 $! 2>/dev/null; do sleep 0.02; done
  prlimit --pid $! --fsize=3000000:unlimited || true # one that has ended is found below
  wait $! || code=$?
  echo "$code $(grep -c 'error: ' out.txt) $(grep -o 'File too large' out.txt | head -1)" >large.$device
done
cmp -s large.none large.opencl && grep -q "File too large" large.none || fail "a file that is too large: $(cat large.none), on a device $(cat large.opencl): $(cat out.txt)"
exit $failed
