/* Couples the pore fluid (fluid.c) to slip. The history is the fluid at the start of a step. Within the step the fluid
   goes on from there by itself: slip whose rate changes as in the last step changes its permeability, so that pressure
   is a function of time alone. When the step is accepted, the fluid is computed again with the slip that happened, as a
   parabola in time with the rate of the start, and goes on from there. Both pressures have errors of the order of the
   step's cube; that of the second is smaller, so that the difference estimates the error of what friction has seen.

   Where slip does not change the permeability, pressure is a function of time, whose steps do not depend on those of
   the fault: the history is the start of the step of the diffusion in which the fault is. */
#include <slipstep/private/slipfault.h>
#include <slipstep/private/slipfaultfluid.h>
#include <slipstep/private/slipsys.h>
#include <math.h>

/* Of the error of pressure that a step of the fault may make, solves of the second path leave at most this share, so
   that they need few iterations, and the estimate of that error, which steps follow, holds to a tenth of it. */
#define CORRECTION_SHARE 0.02

static const SlipFluidNode *EndOf(const SlipFluidPath *path)
{
  return path->stepped ? &path->to : &path->from;
}

/* The pressure of cell i that is beside the fluid's in the state psi, h after the history: pores that dilate otherwise
   than at the rate of the start, without any flow [Pa] */
PetscReal SlipFaultFluidUndrained(SlipFault fault, PetscInt i, PetscReal h, PetscReal change, PetscReal rate)
{
  return -SlipFaultFluidPores(fault, i) * (change - h * rate) / fault->fluid.storage[i];
}

/* Computes the part of an effective normal stress at t that slip has made [n] [Pa], in work space of the fluid. */
static PetscErrorCode Extra(SlipFault fault, PetscReal t, const PetscReal stress[], const PetscReal **extra)
{
  PetscReal *own = fault->fluid.work[FLUID_WORK_OWN], *hold = fault->fluid.work[FLUID_WORK_HOLD];

  PetscFunctionBegin;
  PetscCall(SlipFluidPressureAt(fault, t, own));
  PetscCall(SlipFluidHold(fault, t, hold));
  for (PetscInt i = 0; i < fault->mesh.n; i++) own[i] = stress[i] - PetscMax(hold[i] - own[i], 0);
  *extra = own;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the second path from the history to the state w at t, unless that is known. stress: the effective normal
   stress there; NULL: what slip has made of it goes on at its last rate. */
static PetscErrorCode Correct(SlipFault fault, PetscReal t, Vec w, const PetscReal stress[])
{
  SlipFaultFluid *f = &fault->fluid;
  SlipFluidPath *path = &f->path[1];
  const PetscInt c = fault->layout.components;
  const PetscReal h = t - f->past[1].time, *a, *past, *vinf;
  const SlipArrays arrays[] = {
    {w, .read = &a}, {f->past[1].cells, .read = &past}, {fault->operators.vinf, .read = &vinf}};
  const PetscReal *extra = NULL;
  PetscBool same = f->computed && EndOf(path)->time == t && !(stress && f->stressed) ? PETSC_TRUE : PETSC_FALSE;

  PetscFunctionBegin;
  PetscCall(SlipArraysGet(3, arrays));
  for (PetscInt i = 0; i < fault->mesh.n && same; i++)
    for (PetscInt k = 0; k < c; k++)
      if (f->reached[c * i + k] != a[SlipFaultDisplacementAt(fault, i) + k]) same = PETSC_FALSE;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &same, 1, MPIU_BOOL, MPI_LAND, fault->comm));
  if (!same) {
    if (!f->path[0].begun || f->path[0].slot != 1 || f->path[0].target != t) { /* a run that goes on has none either */
      PetscCall(SlipFluidBegin(fault, &f->path[0], 1));
      PetscCall(SlipFluidWalk(fault, &f->path[0], t, PETSC_TRUE));
    }
    f->path[0].target = (PetscReal)NAN;
    if (stress && f->stressed) PetscCall(Extra(fault, t, stress, &extra));
    PetscCall(SlipFluidBegin(fault, path, 1));
    for (PetscInt i = 0; i < fault->mesh.n; i++) {
      const PetscReal *u = a + SlipFaultDisplacementAt(fault, i), *b = past + f->block * i;

      PetscReal way[3];

      path->drive.curve[i] =
        (SlipFaultSlipped(fault, i, h, b + FLUID_DISPLACEMENT, u, vinf, way) - b[FLUID_SPEED] * h) / (h * h);
      if (extra) path->drive.extra_rate[i] = (extra[i] - b[FLUID_EXTRA]) / h;
      if (f->dilates)
        path->drive.swelling[i] = SlipFaultFluidPores(fault, i) *
                                  (a[SlipFaultStateAt(fault, i)] - b[FLUID_PSI] - h * b[FLUID_PSI_RATE]) / (h * h);
      for (PetscInt k = 0; k < c; k++) f->reached[c * i + k] = u[k];
    }
    PetscCall(SlipFluidWalk(fault, path, t, PETSC_TRUE));
    PetscCall(SlipDiffusionKeep(f->diffusion, f->most, f->sides[2]));
    f->computed = PETSC_TRUE;
  }
  PetscCall(SlipArraysRestore(3, arrays));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Moves slot 1 to the state w at t. */
static PetscErrorCode Move(SlipFault fault, PetscReal t, Vec w, const PetscReal stress[])
{
  SlipFaultFluid *f = &fault->fluid;
  const PetscInt c = fault->layout.components;
  const PetscReal h = t - f->past[1].time, *a;
  const PetscReal *extra = NULL;
  PetscReal *to;

  PetscFunctionBegin;
  if (h > 0) PetscCall(Correct(fault, t, w, stress));
  if (stress && f->stressed) PetscCall(Extra(fault, t, stress, &extra));
  if (h > 0) PetscCall(SlipFluidPutNode(fault, EndOf(&f->path[1])));
  PetscCall(VecGetArrayRead(w, &a));
  PetscCall(VecGetArray(f->past[1].cells, &to));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    PetscReal *b = to + f->block * i;
    const PetscReal speed = SlipFaultSpeed(fault, a, i);

    b[FLUID_CURVE] = h > 0 ? (speed - b[FLUID_SPEED]) / (2 * h) : 0;
    b[FLUID_SPEED] = speed;
    if (f->dilates) {
      b[FLUID_PSI] = a[SlipFaultStateAt(fault, i)];
      b[FLUID_PSI_RATE] = SlipFaultFirstStateRate(fault, i, a, b[FLUID_SPEED]);
    }
    if (extra) {
      if (h > 0) b[FLUID_EXTRA_RATE] = (extra[i] - b[FLUID_EXTRA]) / h;
      b[FLUID_EXTRA] = extra[i];
    }
    for (PetscInt k = 0; k < c; k++) b[FLUID_DISPLACEMENT + k] = a[SlipFaultDisplacementAt(fault, i) + k];
    for (PetscInt k = 0; k < f->most && h > 0; k++) b[FLUID_DISPLACEMENT + c + k] = f->sides[2][f->most * i + k];
  }
  PetscCall(VecRestoreArray(f->past[1].cells, &to));
  PetscCall(VecRestoreArrayRead(w, &a));
  f->computed = PETSC_FALSE;
  SlipFluidForget(fault);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultFluidAccept(SlipFault fault, PetscReal t, Vec w, PetscBool first, const PetscReal stress[])
{
  SlipFaultFluid *f = &fault->fluid;
  SlipFluidPlace place;

  PetscFunctionBegin;
  if (!f->on) PetscFunctionReturn(PETSC_SUCCESS);
  if (first) PetscCall(SlipFaultFluidStart(fault, t));
  if (f->follows) {
    PetscCall(Move(fault, t, w, stress));
    f->trial = PETSC_FALSE;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(SlipFluidReach(fault, t, &place));
  PetscCall(SlipFluidPutNode(fault, place.from));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode CopySlot(SlipFaultFluid *f, int from, int to)
{
  const Vec cells = f->past[to].cells;

  PetscFunctionBegin;
  PetscCall(VecCopy(f->past[from].cells, cells));
  f->past[to] = f->past[from];
  f->past[to].cells = cells;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultFluidAdvance(SlipFault fault, PetscReal t, Vec w, const PetscReal stress[])
{
  SlipFaultFluid *f = &fault->fluid;

  PetscFunctionBegin;
  if (!f->follows) PetscFunctionReturn(PETSC_SUCCESS);
  if (!f->trial) PetscCall(CopySlot(f, 1, 0));
  PetscCall(Move(fault, t, w, stress));
  f->trial = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultFluidRollBack(SlipFault fault)
{
  SlipFaultFluid *f = &fault->fluid;

  PetscFunctionBegin;
  if (!f->follows) PetscFunctionReturn(PETSC_SUCCESS);
  if (f->trial) PetscCall(CopySlot(f, 0, 1));
  f->trial = f->computed = PETSC_FALSE;
  SlipFluidForget(fault);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes the history to a checkpoint, or reads it. */
PetscErrorCode SlipFaultFluidVisit(SlipFault fault, SlipState state)
{
  static const char *const names[2][5] = {
    {"time_before", "next_before", "fresh_before", "volumes_before", "cells_before"},
    {"time", "next", "fresh", "volumes", "cells"}};
  SlipFaultFluid *f = &fault->fluid;

  PetscFunctionBegin;
  if (!f->on) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipStateGroup(state, "fluid"));
  PetscCall(SlipStateBool(state, "within_attempt", &f->trial));
  PetscCall(SlipStateReal(state, "allowed", 1, &f->allowed));
  for (int k = f->trial ? 0 : 1; k < 2; k++) {
    PetscCall(SlipStateReal(state, names[k][0], 1, &f->past[k].time));
    PetscCall(SlipStateReal(state, names[k][1], 1, &f->past[k].next));
    PetscCall(SlipStateBool(state, names[k][2], &f->past[k].fresh));
    PetscCall(SlipStateReal(state, names[k][3], FLUID_NUM_VOLUMES, f->past[k].volume));
    PetscCall(SlipStateVec(state, names[k][4], f->past[k].cells));
  }
  if (SlipStateIsLoading(state)) {
    f->computed = PETSC_FALSE;
    SlipFluidForget(fault);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A step is accurate enough if the error of pressure, which exceeds that of friction, is at most rtol times the change
   of friction in an event. */
PetscErrorCode SlipFaultFluidError(SlipFault fault, PetscReal rtol, PetscReal t, Vec w, PetscReal *E)
{
  SlipFaultFluid *f = &fault->fluid;
  const PetscReal h = t - f->past[1].time, *a, *past;
  PetscReal *seen = f->work[FLUID_WORK_OWN], largest = 0, least = PETSC_MAX_REAL;

  PetscFunctionBegin;
  *E = 0;
  if (!f->follows || !(t > f->past[1].time)) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    const PetscReal change = SlipFaultFrictionChange(fault, i);

    if (change > 0) least = PetscMin(least, change);
  }
  PetscCallMPI(MPI_Allreduce(&least, &f->allowed, 1, MPIU_REAL, MPIU_MIN, fault->comm));
  f->allowed *= CORRECTION_SHARE * rtol;
  PetscCall(Correct(fault, t, w, NULL));
  PetscCall(SlipFluidPressureAt(fault, t, seen));
  PetscCall(VecGetArrayRead(w, &a));
  PetscCall(VecGetArrayRead(f->past[1].cells, &past));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    const PetscReal change = SlipFaultFrictionChange(fault, i);

    if (f->dilates) {
      const PetscReal *b = past + f->block * i;

      seen[i] += SlipFaultFluidUndrained(fault, i, h, a[SlipFaultStateAt(fault, i)] - b[FLUID_PSI], b[FLUID_PSI_RATE]);
    }
    if (change > 0) largest = SlipLarger(largest, PetscAbsReal(seen[i] - EndOf(&f->path[1])->pressure[i]) / change);
  }
  PetscCall(VecRestoreArrayRead(f->past[1].cells, &past));
  PetscCall(VecRestoreArrayRead(w, &a));
  PetscCall(SlipAllreduceLargest(fault->comm, 1, &largest));
  *E = largest / rtol;
  PetscFunctionReturn(PETSC_SUCCESS);
}
