#!/usr/bin/env python3
"""petsc4py drives SlipStep's integrator with a controller: an ODE, a system of two states with friction, and a fault.

    PYTHONPATH=build/lib/python3 examples/from_python.py [PETSc options]

All options are PETSc's database, as in C: -ts_adapt_type pi, -fault_nx 20, -ts_monitor, ... On several ranks (mpirun -n
2) the fault is distributed, and every rank integrates the other two.
"""
import ctypes
import os
import sys

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "src", "package"))
from slipstep.modules import need

need("petsc4py", "numpy")
import petsc4py

petsc4py.init(sys.argv)  # the options of the command line
import numpy as np
from petsc4py import PETSc
import slipstep


def report(name, ts, what):
    done = slipstep.totals(ts)
    PETSc.Sys.Print(f"{name}: {what}, {done.accepted} accepted and {done.attempts - done.accepted} rejected steps")


def new_ts(comm, end, step, rtol=None, atol=None):
    ts = PETSc.TS().create(comm)
    ts.setProblemType(PETSc.TS.ProblemType.NONLINEAR)
    ts.setMaxTime(end)
    ts.setTimeStep(step)
    ts.setMaxSteps(100000)
    ts.setExactFinalTime(PETSc.TS.ExactFinalTime.MATCHSTEP)
    ts.setTolerances(rtol=rtol, atol=atol)
    return ts


def ode():
    """y' = -50 (y - cos t): stiff. Without a constraint bathe is an implicit integrator of order 2."""
    rate, end, y = 50.0, 2.0, PETSc.Vec().createSeq(1)
    y.set(0)

    def rhs(ts, t, y, f):
        f[0] = -rate * (y[0] - np.cos(t))
        f.assemble()

    def jacobian(ts, t, y, J, P):
        P[0, 0] = -rate
        P.assemble()

    J = PETSc.Mat().createDense([1, 1], comm=PETSc.COMM_SELF)
    J.setUp()
    ts = new_ts(PETSc.COMM_SELF, end, 1e-3, 1e-5, 1e-5)
    ts.setType("bathe")
    adapt = ctypes.c_void_p()  # steps by heuristic unless -ts_adapt_type says otherwise, as small() has them
    slipstep.call("TSGetAdapt", ts, ctypes.byref(adapt))
    slipstep.call("TSAdaptSetType", adapt, "heuristic")
    ts.setRHSFunction(rhs, y.duplicate())
    ts.setRHSJacobian(jacobian, J)
    ts.setFromOptions()
    ts.solve(y)
    exact = rate * (rate * np.cos(end) + np.sin(end) - rate * np.exp(-rate * end)) / (rate ** 2 + 1)
    report("ode", ts, f"error {abs(y[0] - exact):.1e}")


def spring():
    """m v' = -k x + F, x' = v, F in -q Sign(v): a mass on a spring with dry friction, as in oscillator.c."""
    mass, stiffness, strength = 1.0, 40.0, 3.0

    def force(t, w, F):
        F[:] = -stiffness * w[1], w[0]

    def jacobian(t, w, J):
        J[0, 1], J[1, 0] = -stiffness, 1

    def bound(t, w, q, dq):
        q[0] = strength

    w = PETSc.Vec().createSeq(2)
    w.setArray([0.0, 1.0])
    ts = new_ts(PETSc.COMM_SELF, 5.0, 1e-3, 1e-4, 1e-6)
    slipstep.small(ts, [mass, 1.0], [0], force, jacobian, bound)
    ts.setFromOptions()
    ts.solve(w)
    report("spring", ts, f"v = {w[0]:g} m/s, x = {w[1]:.6f} m")


def fault():
    """The reference case of 3 km on 10 x 10 cells, from its frictional instability to rest."""
    ts = PETSc.TS().create()
    fault = slipstep.Fault(nx=10, nz=10)
    fault.configure(ts)
    ts.setFromOptions()
    ts.solve(ts.getSolution())  # fault.solve(ts) for files: -fault_output, -fault_catalogue, ...
    slip, traction, z = fault.values(ts, "slip"), fault.values(ts, "traction"), fault.centres()[2]
    report("fault", ts, f"mean slip {slip.mean():.6f} m at {ts.getTime():g} s, largest {slip.max():.4f} m at "
           f"{z.flat[slip.argmax()]:g} m of depth, shear stress up to {abs(traction).max() / 1e6:.1f} MPa")
    fault.destroy()


def main():
    slipstep.load()  # after PetscInitialize(), which petsc4py has called: the types are registered here
    PETSc.Sys.Print(f"SlipStep {slipstep.version()} on PETSc {'.'.join(map(str, PETSc.Sys.getVersion()))}")
    ode()
    spring()
    fault()


if __name__ == "__main__":
    main()
