/* A test problem of its own: n sliding blocks coupled by a dense stiffness, with slip-weakening friction.

     m dv/dt = -H v - K u + load + r,  du/dt = v,  ds/dt = |v|,  |r| <= q(s) = bound (mud + dmu exp(-s/dc))

   State: (v, u, s) per block. Used by the tests of the SNES types and of TSBATHE only. */
#pragma once
#include "linear.h"

typedef struct {
  LinearSystem l; /* of the current stage; its B is dense */
  PetscReal mass, mud, dmu, dc;
  Mat K, H;        /* dense */
  Vec bound, load; /* reduced */
  Vec ubase, sbase, work;
  PetscReal theta;
  SlipConstraint con;
  PetscInt n, stages;
} Sliders;

static inline PetscErrorCode SlidersGet(Vec w, PetscInt field, Vec x)
{
  return VecStrideGather(w, field, x, INSERT_VALUES);
}

static PetscErrorCode SlidersStage(SlipConstraint con, const SlipStage *st, void *ctx)
{
  Sliders *p = (Sliders *)ctx;

  p->stages++;
  if (st->theta != p->theta) {
    p->theta = st->theta;
    PetscCall(MatCopy(p->K, p->l.B, SAME_NONZERO_PATTERN));
    PetscCall(MatScale(p->l.B, st->theta));
    PetscCall(MatAXPY(p->l.B, 1.0, p->H, SAME_NONZERO_PATTERN));
    PetscCall(MatShift(p->l.B, p->mass / st->theta));
  }
  PetscCall(SlidersGet(st->base, 1, p->ubase));
  PetscCall(SlidersGet(st->base, 2, p->sbase));
  if (st->explicit_part) {
    PetscCall(SlidersGet(st->explicit_part, 1, p->work));
    PetscCall(VecAXPY(p->ubase, st->theta, p->work));
    PetscCall(SlidersGet(st->explicit_part, 2, p->work));
    PetscCall(VecAXPY(p->sbase, st->theta, p->work));
  }
  PetscCall(MatMult(p->K, p->ubase, p->l.load));
  PetscCall(VecAYPX(p->l.load, -1.0, p->load));
  PetscCall(SlidersGet(st->base, 0, p->work));
  PetscCall(VecAXPY(p->l.load, p->mass / st->theta, p->work));
  if (st->explicit_part) {
    PetscCall(SlidersGet(st->explicit_part, 0, p->work));
    PetscCall(VecAXPY(p->l.load, 1.0, p->work));
  }
  return PETSC_SUCCESS;
}

/* q and, if dq is given, its derivative with s = s0 + theta |x| */
static PetscErrorCode SlidersFriction(Sliders *p, Vec s0, Vec x, PetscReal theta, Vec q, Vec dq)
{
  const PetscScalar *s, *v = NULL, *b;
  PetscScalar *qq, *d = NULL;
  PetscInt n;

  PetscCall(VecGetLocalSize(s0, &n));
  s = VecRead(s0);
  b = VecRead(p->bound);
  if (x) v = VecRead(x);
  PetscCall(VecGetArray(q, &qq));
  if (dq) PetscCall(VecGetArray(dq, &d));
  for (PetscInt i = 0; i < n; i++) {
    PetscReal e = p->dmu * PetscExpReal(-(s[i] + (v ? theta * PetscAbsScalar(v[i]) : 0.0)) / p->dc);

    qq[i] = b[i] * (p->mud + e);
    if (d) d[i] = -b[i] * theta * e / p->dc;
  }
  if (dq) PetscCall(VecRestoreArray(dq, &d));
  return VecRestoreArray(q, &qq);
}

static PetscErrorCode SlidersBound(SlipConstraint con, Vec x, Vec q, Vec dq, void *ctx)
{
  Sliders *p = (Sliders *)ctx;

  return SlidersFriction(p, p->sbase, x, p->theta, q, dq);
}

static PetscErrorCode SlidersBoundState(SlipConstraint con, PetscReal t, Vec w, Vec q, void *ctx)
{
  Sliders *p = (Sliders *)ctx;

  PetscCall(SlidersGet(w, 2, p->work));
  return SlidersFriction(p, p->work, NULL, 0.0, q, NULL);
}

static PetscErrorCode SlidersReduce(SlipConstraint con, Vec w, Vec x, void *ctx)
{
  return SlidersGet(w, 0, x);
}

static PetscErrorCode SlidersLift(SlipConstraint con, Vec x, Vec w, void *ctx)
{
  Sliders *p = (Sliders *)ctx;

  PetscCall(VecStrideScatter(x, 0, w, INSERT_VALUES));
  PetscCall(VecWAXPY(p->work, p->theta, x, p->ubase));
  PetscCall(VecStrideScatter(p->work, 1, w, INSERT_VALUES));
  PetscCall(VecCopy(x, p->work));
  PetscCall(VecAbs(p->work));
  PetscCall(VecAYPX(p->work, p->theta, p->sbase));
  return VecStrideScatter(p->work, 2, w, INSERT_VALUES);
}

static PetscErrorCode SlidersSmooth(SlipConstraint con, PetscReal t, Vec w, Vec F, void *ctx)
{
  Sliders *p = (Sliders *)ctx;
  Vec v, f;

  PetscCall(DuplicateVecs(p->work, &v, &f));
  PetscCall(SlidersGet(w, 0, v));
  PetscCall(SlidersGet(w, 1, p->work));
  PetscCall(MatMult(p->H, v, f));
  PetscCall(MatMultAdd(p->K, p->work, f, f));
  PetscCall(VecAYPX(f, -1.0, p->load));
  PetscCall(VecStrideScatter(f, 0, F, INSERT_VALUES));
  PetscCall(VecStrideScatter(v, 1, F, INSERT_VALUES));
  PetscCall(VecAbs(v));
  PetscCall(VecStrideScatter(v, 2, F, INSERT_VALUES));
  return DestroyObjects(&v, &f);
}

static PetscErrorCode SlidersAddReaction(SlipConstraint con, PetscReal a, Vec r, Vec F, void *ctx)
{
  Sliders *p = (Sliders *)ctx;

  PetscCall(VecCopy(r, p->work));
  PetscCall(VecScale(p->work, a));
  return VecStrideScatter(p->work, 0, F, ADD_VALUES);
}

static PetscErrorCode SlidersSolveMass(SlipConstraint con, Vec F, Vec k, void *ctx)
{
  if (F != k) PetscCall(VecCopy(F, k));
  return VecStrideScale(k, 0, 1.0 / ((Sliders *)ctx)->mass);
}

/* K is given by its entries, a function of two indices; H = eta I */
static inline PetscErrorCode SlidersCreate(MPI_Comm comm, PetscInt n, PetscReal (*entry)(PetscInt, PetscInt, PetscInt),
                                           PetscReal mass, PetscReal eta, Sliders *p)
{
  const SlipConstraintOps ops = {SlidersStage,
                                 LinearResidual,
                                 LinearJacobian,
                                 SlidersBound,
                                 SlidersReduce,
                                 SlidersLift,
                                 SlidersSmooth,
                                 SlidersAddReaction,
                                 SlidersSolveMass,
                                 SlidersBoundState,
                                 NULL,
                                 NULL,
                                 NULL,
                                 NULL,
                                 NULL,
                                 NULL,
                                 PETSC_TRUE};
  PetscInt first, last;

  *p = (Sliders){.n = n, .mass = mass, .mud = 1.0, .dmu = 0.0, .dc = 1.0, .theta = -1.0};
  PetscCall(MatCreateDense(comm, PETSC_DECIDE, PETSC_DECIDE, n, n, NULL, &p->K));
  PetscCall(MatGetOwnershipRange(p->K, &first, &last));
  for (PetscInt i = first; i < last; i++)
    for (PetscInt j = 0; j < n; j++) PetscCall(MatSetValue(p->K, i, j, entry(i, j, n), INSERT_VALUES));
  PetscCall(MatAssemble(p->K));
  PetscCall(MatDuplicate(p->K, MAT_COPY_VALUES, &p->l.B));
  PetscCall(MatDuplicate(p->K, MAT_DO_NOT_COPY_VALUES, &p->H));
  PetscCall(MatZeroEntries(p->H));
  PetscCall(MatShift(p->H, eta));
  PetscCall(MatCreateVecs(p->K, &p->bound, &p->load));
  PetscCall(VecSet(p->bound, 1.0));
  PetscCall(VecSet(p->load, 0.0));
  PetscCall(DuplicateVecs(p->bound, &p->l.load, &p->ubase, &p->sbase, &p->work));
  return SlipConstraintCreate(comm, &ops, p, p->bound, &p->con);
}

static inline PetscErrorCode SlidersCreateState(Sliders *p, Vec *w)
{
  PetscInt n;

  PetscCall(VecGetLocalSize(p->bound, &n));
  PetscCall(VecCreate(PetscObjectComm((PetscObject)p->bound), w));
  PetscCall(VecSetSizes(*w, 3 * n, PETSC_DETERMINE));
  PetscCall(VecSetBlockSize(*w, 3));
  PetscCall(VecSetFromOptions(*w));
  return VecZeroEntries(*w);
}

static inline PetscErrorCode SlidersDestroy(Sliders *p)
{
  return DestroyObjects(&p->K, &p->H, &p->l.B, &p->bound, &p->load, &p->l.load, &p->ubase, &p->sbase, &p->work,
                        &p->con);
}

/* A constant-step TSBATHE over [0, tmax] from w (which receives the end) */
static inline PetscErrorCode SlidersSolve(Sliders *p, TSBatheReactionType reaction, PetscReal tmax, PetscInt steps,
                                          Vec w, TS *out)
{
  TS ts;
  TSAdapt adapt;

  PetscCall(TSCreate(PetscObjectComm((PetscObject)w), &ts));
  PetscCall(TSSetType(ts, TSBATHE));
  PetscCall(TSBatheSetStageError(ts, 0)); /* numbers of the method alone */
  PetscCall(TSBatheSetConstraint(ts, p->con));
  PetscCall(TSBatheSetReactionType(ts, reaction));
  PetscCall(TSSetSolution(ts, w));
  PetscCall(TSSetMaxTime(ts, tmax));
  PetscCall(TSSetTimeStep(ts, tmax / steps));
  PetscCall(TSSetMaxSteps(ts, 100 * steps + 1000));
  PetscCall(TSSetExactFinalTime(ts, TS_EXACTFINALTIME_MATCHSTEP));
  PetscCall(TSGetAdapt(ts, &adapt));
  PetscCall(TSAdaptSetType(adapt, TSADAPTNONE));
  PetscCall(TSSetFromOptions(ts));
  PetscCall(TSSolve(ts, w));
  if (out)
    *out = ts;
  else
    PetscCall(TSDestroy(&ts));
  return PETSC_SUCCESS;
}
