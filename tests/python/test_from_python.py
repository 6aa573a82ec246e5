"""slipstep.py and examples/from_python.py on petsc4py: the numbers are those of the C programs. Skipped where there is
no petsc4py of the PETSc that the build is of (Debian: python3-petsc4py-real)."""
import os
import re
import subprocess
import sys
import tempfile
import unittest

from scripts import BUILD, SOURCE

import h5py
import numpy as np

MODULE = os.path.join(BUILD, "lib", "python3")
EXAMPLE = os.path.join(SOURCE, "examples", "from_python.py")

PRELUDE = """
import petsc4py, sys
petsc4py.init(sys.argv)
from petsc4py import PETSc
import slipstep

def fails(text, function, *arguments):
    try:
        function(*arguments)
    except PETSc.Error as error:
        assert text in str(error), error
        return
    sys.exit(f"no error: {text}")
"""


def environment():
    """PYTHONPATH with slipstep.py, and with the petsc4py of the build's PETSc: Debian's own is not on Python's path."""
    with open(os.path.join(BUILD, "include", "slipbuild.h"), encoding="utf-8") as file:
        petsc = re.search(r'LIBDIR "(.*)"', file.read())[1]
    path = [MODULE, os.path.join(petsc, "python3", "dist-packages"), petsc, os.environ.get("PYTHONPATH", "")]
    return dict(os.environ, PYTHONPATH=os.pathsep.join(filter(None, path)))


def python(*arguments, ranks=None, **more):
    """more: of the environment"""
    launch = ["mpirun", "--oversubscribe", "-n", str(ranks)] if ranks else []
    return subprocess.run([*launch, sys.executable, *arguments], env={**environment(), **more}, capture_output=True,
                          text=True)


class FromPython(unittest.TestCase):
    def run_code(self, code, *arguments):
        done = python("-c", PRELUDE + code, *arguments)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return done

    def program(self, name, pattern, *options):
        done = subprocess.run([os.path.join(BUILD, "bin", name), *options], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        return [float(re.search(p, done.stdout)[1]) for p in pattern]

    def example(self, *options, ranks=None):
        done = python(EXAMPLE, *options, ranks=ranks)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        found = {}
        for name, number in (("ode", r"error (\S+),"), ("spring", r"x = (\S+) m"), ("fault", r"mean slip (\S+) m")):
            line = re.search(rf"^{name}: .*{number}.* (\d+) accepted and (\d+) rejected", done.stdout, re.M)
            self.assertTrue(line, done.stdout)
            found[name] = [float(group) for group in line.groups()]
        return found

    def test_the_example_gives_the_numbers_of_the_programs(self):
        for controller in ("heuristic", "pi"):
            found = self.example("-ts_adapt_type", controller)
            # Local errors are kept below 2e-5, and this equation forgets them within a step or two.
            self.assertLess(found["ode"][0], 1e-4)
            steps = (r"accepted steps: +(\d+)", r"rejected steps: +(\d+)")
            # The same arithmetic, printed with six decimals.
            want = self.program("oscillator", (r"final x: +(\S+)", *steps), "-ts_adapt_type", controller)
            self.assertAlmostEqual(found["spring"][0], want[0], delta=5.1e-7)
            self.assertEqual(found["spring"][1:], want[1:])
            want = self.program("fault", (r"final mean slip: +(\S+)", *steps), "-ts_adapt_type", controller,
                                "-fault_nx", "10", "-fault_nz", "10")
            self.assertAlmostEqual(found["fault"][0], want[0], delta=5.1e-7)
            self.assertEqual(found["fault"][1:], want[1:])

    def test_ranks(self):
        one, two = self.example(), self.example(ranks=2)
        for name, values in one.items():
            self.assertEqual(values[1:], two[name][1:])
            self.assertAlmostEqual(values[0], two[name][0], delta=1.1e-6)

    def test_types_come_with_load(self):
        self.run_code("""
fails("bathe", PETSc.TS().create().setType, "bathe")
slipstep.load()
ts = PETSc.TS().create()
ts.setType("bathe")
slipstep.call("TSBatheSetGamma", ts, 2 - 2 ** 0.5)
import ctypes
gamma = ctypes.c_double()
slipstep.call("TSBatheGetGamma", ts, ctypes.byref(gamma))
assert gamma.value == 2 - 2 ** 0.5
fails("-3", slipstep.call, "TSBatheSetGamma", ts, -3.0)
""")

    def test_the_learned_policy_and_prefixes(self):
        """rl on a fault from Python, with its default policy; fields, and options of two faults."""
        done = self.run_code("""
import numpy as np
slipstep.load()
stress = np.full((4, 4), 2e7)
faults = {}
for name in ("upper_", "lower_"):
    ts = PETSc.TS().create()
    faults[name] = fault = slipstep.Fault(nx=4, nz=4, normal_stress=stress)
    slipstep.call("SlipFaultSetOptionsPrefix", fault, name)
    fault.configure(ts)
    ts.setFromOptions()
    ts.solve(ts.getSolution())
    assert 5 < slipstep.totals(ts).accepted < 100
    print(name, fault.get("length_x"), ts.getSolution().strideSum(2) / 16)
""", "-ts_adapt_type", "rl", "-lower_fault_length_x", "5000")
        # newer PETSc adds unused options
        upper, lower = (line.split() for line in done.stdout.splitlines() if "er_ " in line)
        self.assertEqual((upper[1], lower[1]), ("3000.0", "5000.0"))
        self.assertNotEqual(upper[2], lower[2])

    def test_a_run_is_the_programs(self):
        """Without a word about the controller, of TSBATHE and of rate-and-state friction: the same steps to the last
        bit."""
        smooth = dict(friction_law="rate_and_state", friction_slip=0.05, loading_rate=1e-9, normal_stress=5e7,
                      normal_stress_gradient=0)
        for parameters, end in (({}, "30"), (smooth, "20y")):
            with tempfile.TemporaryDirectory() as folder:
                names = [os.path.join(folder, name) for name in ("python.h5", "program.h5")]
                self.run_code(f"""
slipstep.load()
fault, ts = slipstep.Fault(nx=6, nz=4, output={names[0]!r}, progress=False, **{parameters!r}), PETSc.TS().create()
fault.configure(ts)
ts.setFromOptions()
assert fault.solve(ts)
done = slipstep.totals(ts)
assert done.accepted > 10 and done.attempts >= done.accepted, done
""", "-ts_max_time", end)
                options = [word for name, value in parameters.items() for word in (f"-fault_{name}", str(value))]
                self.program("fault", (), "-fault_nx", "6", "-fault_nz", "4", "-fault_output", names[1], "-ts_max_time",
                             end, *options)
                with h5py.File(names[0]) as one, h5py.File(names[1]) as two:
                    for path in ("series/time", "series/mean_slip", "fields/slip_rate", "fields/traction"):
                        self.assertTrue(np.array_equal(one[path], two[path]), path)

    def test_arrays(self):
        """Fields, centres, values and events as numpy arrays are those of the files; a turned array is refused."""
        for ranks in (None, 2):
            with tempfile.TemporaryDirectory() as folder:
                code = PRELUDE + f"""
import numpy as np
slipstep.load()
stress = 2e7 + 1e5 * np.arange(12.0).reshape(3, 4)
for wrong in (dict(nx=4, nz=3), dict(nz=3)):
    fault = slipstep.Fault(**wrong)
    try:
        fault.set(nx=4, normal_stress=stress.T)
        sys.exit("an array [nx, nz] was taken for one [nz, nx]")
    except ValueError as error:
        assert "normal_stress" in str(error) and "(3, 4)" in str(error), error
fault = slipstep.Fault(nx=4, nz=3, normal_stress=stress, output={folder!r} + "/o.h5", catalogue={folder!r} + "/c.h5",
                       progress=False)
assert (fault.get("normal_stress") == stress).all()
ts = PETSc.TS().create()
fault.configure(ts)
ts.setFromOptions()
assert (fault.get("normal_stress") == stress).all() and (fault.get("friction_drop") == 0.1).all()
assert fault.get("nx") == 4 and fault.get("kernel") == "half_space"
fails("colour", fault.get, "colour")
assert fault.solve(ts)
events = fault.events()
assert len(events) == 1 and events["moment"][0] > 0 and events["onset"][0] < events["end"][0]
x, y, z = fault.centres()
assert (x[0] == 750 * (np.arange(4) + 0.5)).all() and (z[:, 0] == 1000 * (np.arange(3) + 0.5)).all() and not y.any()
values = {{name: fault.values(ts, name) for name in ("slip", "traction", "slip_rate", "displacement", "stress")}}
if PETSc.COMM_WORLD.rank == 0:
    np.savez({folder!r} + "/a.npz", events=events, **values)
"""
                done = python("-c", code, ranks=ranks)
                self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
                with np.load(os.path.join(folder, "a.npz")) as got, h5py.File(os.path.join(folder, "o.h5")) as out, \
                        h5py.File(os.path.join(folder, "c.h5")) as events:
                    for name in ("slip", "traction", "slip_rate", "displacement"):
                        self.assertTrue(np.array_equal(got[name], out["fields"][name][-1]), name)
                    # at rest friction holds what elasticity pulls by, but for products with K in another order
                    np.testing.assert_allclose(got["stress"], -got["traction"], rtol=1e-9)
                    self.assertEqual(got["events"]["moment"][0], events["moment"][0])
                    self.assertEqual(set(got["events"].dtype.names),
                                     {name for name in events if isinstance(events[name], h5py.Dataset)})

    def test_stresses(self):
        """add_stress() is a group of -fault_stress_history, in this process and by the program, bit by bit."""
        self.run_code("""
import numpy as np
from slipstep.running import Fault as Program
found = []
for kind in (slipstep.Fault, Program):
    fault = kind(nx=4, nz=3, friction_law="constant", inertia=False, viscosity="radiation", initial="traction",
                 normal_stress=5e7, normal_stress_gradient=0.0, ts_max_time=50)
    fault.add_stress([0, 100], [0, 1], shear=5e7, normal=np.full((3, 4), -1e7))
    fault.add_stress([0, 50], [0, 1], shear=1e6)
    found.append(fault.run(progress=False))
slips = [np.asarray(result.series["mean_slip"]) for result in found]
assert slips[0][-1] > 0.01 and (slips[0] == slips[1]).all(), slips
fault = slipstep.Fault()
try:
    fault.add_stress([0, 1], [1], shear=1e6)
    sys.exit("a course of another length was taken")
except ValueError as error:
    assert "(2,)" in str(error) and "(1,)" in str(error), error
""")

    def test_vectors(self):
        """Two components of slip: two numbers a cell, but for what has one, as the output has them; cells that open
        likewise. The largest rate of a state is that of /series, of all cells and components."""
        one = ("state", "normal_stress", "opening")
        opening = dict(initial="traction", initial_traction=2e5, normal_stress=1e4, normal_stress_gradient=0,
                       opening=True, initial_unstable=True,
                       injection="1500,1500", injection_pressure=1e5, injection_diffusivity=1e6)
        for ranks, block, more in ((None, 5, {}), (2, 5, {}), (None, 7, opening), (2, 7, opening)):
            with tempfile.TemporaryDirectory() as folder:
                code = PRELUDE + f"""
import numpy as np
slipstep.load()
fault = slipstep.Fault(nx=4, nz=3, rake=30, slip_components=2, output={folder!r} + "/o.h5", progress=False,
                       output_fields="slip,displacement,slip_rate,traction,state,normal_stress", **{more!r})
ts = PETSc.TS().create()
for accessor in (fault.labels, lambda: fault.values(ts, "slip")):
    try:
        accessor()
        sys.exit("a fault without a set-up had something to say")
    except slipstep.Error as error:
        assert "configure" in str(error), error
fault.configure(ts)
ts.setFromOptions()
ts.setMaxTime({10 if more else 30})
assert ts.getSolution().getBlockSize() == {block}
rates = []
ts.setMonitor(lambda ts, step, time, w: rates.append(slipstep.petsc.largest_rate(ts, w)))
assert fault.solve(ts)
values = {{name: fault.values(ts, name) for name in ("slip", "traction", "slip_rate", "displacement", "stress",
                                                     *{one!r})}}
fails('no "colour"', fault.values, ts, "colour")
if PETSc.COMM_WORLD.rank == 0:
    np.savez({folder!r} + "/a.npz", rates=rates[1:-1], **values)
"""
                done = python("-c", code, ranks=ranks)
                self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
                with np.load(os.path.join(folder, "a.npz")) as got, h5py.File(os.path.join(folder, "o.h5")) as out:
                    for name in ("slip", "traction", "slip_rate", "displacement", *one):
                        self.assertEqual(got[name].shape, (3, 4) if name in one else (3, 4, 2))
                        if name in out["fields"]:
                            self.assertTrue(np.array_equal(got[name], out["fields"][name][-1]), name)
                    self.assertEqual("opening" in out["fields"], bool(more))
                    self.assertEqual(got["opening"].any(), bool(more))
                    if not more:
                        np.testing.assert_allclose(got["stress"], -got["traction"], rtol=0,
                                                   atol=1e-9 * np.abs(got["stress"]).max())
                    self.assertGreater(np.abs(got["slip"]).min(), 0)
                    np.testing.assert_allclose(got["rates"], out["series/max_slip_rate"][1:-1], rtol=1e-14)

    def test_progress_of_vectors(self):
        """The line of run() has the rate of /series, along both components."""
        done = self.run_code("""
result = slipstep.Fault(nx=4, nz=3, rake=80, slip_components=2, ts_max_time=10.0).run()
print("rate", result.series["max_slip_rate"][-1])
""")
        found = [re.findall(pattern, done.stdout, re.MULTILINE)
                 for pattern in (r"largest slip rate (\S+) m/s", r"^rate (\S+)$")]
        self.assertTrue(all(found), done.stdout + done.stderr)
        shown, rate = (float(numbers[-1]) for numbers in found)
        self.assertAlmostEqual(shown, rate, delta=6e-4 * rate)  # three digits are shown

    def test_faults_of_a_mesh(self):
        """Events with a number for each fault, in the order of labels()."""
        with tempfile.TemporaryDirectory() as folder:
            mesh, events = os.path.join(folder, "mesh.h5"), os.path.join(folder, "events.h5")
            with h5py.File(mesh, "w") as file:
                file["cells"] = [[1500, y, 1500, 3000, 3000] for y in (0.0, 5e3)]
                file["fault"] = [4, -2]
            self.run_code(f"""
slipstep.load()
fault, ts = slipstep.Fault(mesh={mesh!r}, catalogue={events!r}, thickness=3000.0, loading_rate=1e-9, initial="rest",
                           friction_law="rate_weakening", progress=False), PETSc.TS().create()
fault.configure(ts)
ts.setFromOptions()
assert fault.labels().tolist() == [-2, 4]
assert fault.solve(ts)
import h5py
events = fault.events()
with h5py.File({events!r}) as file:
    columns = {{name: file[name][...] for name in set(file) - {{"fault_index"}}
               if isinstance(file[name], h5py.Dataset)}}
assert len(events) == len(columns["end"]) > 0 and set(columns) == set(events.dtype.names), events.dtype
assert events["fault_moment"].shape == (len(events), 2)
for name, values in columns.items():
    assert ((events[name] == values) | (values != values)).all(), name
""", "-ts_max_time", "4e9")

    def test_options_are_not_ignored(self):
        self.run_code("""
slipstep.load()
fails("there is no option -fault_lenght_x: did you mean -fault_length_x?", slipstep.Fault().configure,
      PETSc.TS().create())
PETSc.Options().delValue("fault_lenght_x")
fails("kernl", lambda: slipstep.Fault(kernl="full_space"))
fault = slipstep.Fault(nx=3, nz=3, inertia=False, initial_unstable=True, viscosity="radiation", initial="traction",
                       initial_traction=5e7,
                       normal_stress=5e7, normal_stress_gradient=0, progress=False)
ts = PETSc.TS().create()
fault.configure(ts)          # 50 MPa exceed the strength, 30 MPa: refused unless initial_unstable
ts.setFromOptions()
assert ts.getMaxTime() == 6.0, ts.getMaxTime()
ts.solve(ts.getSolution())
fails("must be set before", lambda: fault.set(initial_unstable=False))
fails("before SlipFaultSetUp()", lambda: fault.set(inertia=True))
fails('no switch "nonsense"', lambda: slipstep.Fault(nonsense=True))
fault, ts = slipstep.Fault(catalogue="c.h5", progress=False), PETSc.TS().create()
fault.configure(ts)
try:
    ts.solve(ts.getSolution())
    sys.exit("ts.solve() without the files that were asked for")
except RuntimeError as error:  # later petsc4py raises it as the cause of an error of its own
    said = f"{error} {error.__cause__}"
    assert "catalogue" in said and "fault.solve" in said, said
""", "-fault_lenght_x", "5000", "-ts_max_time", "0.1min", "--of-the-script", "word")

    def test_errors(self):
        done = self.run_code("""
slipstep.load()
fault = slipstep.Fault()
fails('no number "colour"', lambda: fault.set(colour=3))
fails("nx is 0", lambda: fault.set(nx=0))
fails("velcro", lambda: fault.set(friction_law="velcro"))

def broken(t, w, F):
    raise RuntimeError("a mistake of the user's")

ts = PETSc.TS().create(PETSc.COMM_SELF)
slipstep.small(ts, [1.0], [0], broken, lambda t, w, J: None, lambda t, w, q, dq: None)
ts.setMaxTime(1.0)
fails("", ts.solve, PETSc.Vec().createSeq(1))
fails("mass", slipstep.small, ts, [-1.0], [0], broken, broken, broken)
try:
    slipstep.call("SlipFaultSetField", fault, "normal_stress", 1, __import__("numpy").ones(1, "f4"))
except TypeError:
    pass
else:
    sys.exit("an array of floats was taken for one of doubles")
""")
        self.assertIn("a mistake of the user's", done.stderr)


if __name__ == "__main__":
    if not os.path.exists(os.path.join(BUILD, "lib", "libslipstep.so")):
        print("skipped: this build has no shared library")
        sys.exit(77)
    if python("-c", "import petsc4py").returncode:
        print("skipped: no petsc4py of the build's PETSc for", sys.executable, "(Debian: python3-petsc4py-real)")
        sys.exit(77)
    unittest.main()
