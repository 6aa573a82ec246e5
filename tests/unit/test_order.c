/* The exponent that each controller takes is one over the power of h in the error estimate of the integrator, whatever
   it calls its order: the power is measured from estimates of two step lengths, the exponent from what is chosen
   next. */
#include "unit.h"
#include <petsc/private/tsimpl.h>
#include <math.h>

/* A controller that keeps the step and asks the others what they would do, once `wait` steps are done. */
static const struct {
  const char *type, *options;
  PetscBool limited; /* a ratio r becomes 1 + atan(r - 1) (Soederlind and Wang 2006, J. Comput. Appl. Math. 185) */
} Others[] = {
  {TSADAPTBASIC, "-ts_adapt_safety 1 -ts_adapt_clip 1e-9,1e9 -ts_adapt_reject_safety 1", PETSC_FALSE},
  {"heuristic", "-ts_adapt_heuristic_growth 1e9 -ts_adapt_safety 1", PETSC_FALSE},
  {"pi", "-ts_adapt_pi_filter elementary -ts_adapt_pi_ratio_max 1e9 -ts_adapt_pi_ratio_min 1e-9", PETSC_FALSE},
  {TSADAPTDSP, "-ts_adapt_dsp_pid 1,0,0 -ts_adapt_safety 1 -ts_adapt_clip 1e-9,1e9", PETSC_TRUE},
};
enum { OTHERS = PETSC_STATIC_ARRAY_LENGTH(Others) };
static PetscInt wait;
static PetscReal error, exponent[OTHERS];

static PetscErrorCode ChooseSpy(TSAdapt adapt, TS ts, PetscReal h, PetscInt *next_sc, PetscReal *next_h,
                                PetscBool *accept, PetscReal *wlte, PetscReal *wltea, PetscReal *wlter)
{
  PetscInt order = PETSC_DECIDE;

  *next_sc = 0;
  *next_h = h;
  *accept = PETSC_TRUE;
  *wlte = *wltea = *wlter = -1;
  if (ts->steps < wait) return PETSC_SUCCESS;
  PetscCall(TSEvaluateWLTE(ts, adapt->wnormtype, &order, &error));
  for (int k = 0; k < OTHERS; k++) {
    PetscBool accepted;
    PetscReal next, unused[3];
    PetscInt sc;
    TSAdapt other;

    PetscCall(PetscOptionsInsertString(NULL, Others[k].options));
    PetscCall(TSAdaptCreate(PETSC_COMM_SELF, &other));
    PetscCall(TSAdaptSetType(other, Others[k].type));
    PetscObjectOptionsBegin((PetscObject)other);
    PetscCall(TSAdaptSetFromOptions(other, PetscOptionsObject));
    PetscOptionsEnd();
    other->dt_min = 0;
    other->dt_max = 1e30;
    PetscCall((*other->ops->choose)(other, ts, h, &sc, &next, &accepted, &unused[0], &unused[1], &unused[2]));
    next /= h;
    if (Others[k].limited) next = 1 + tan(next - 1);
    exponent[k] = -log(next) / log(error);
    PetscCall(TSAdaptDestroy(&other));
    PetscCall(PetscOptionsClear(NULL));
  }
  return PETSC_SUCCESS;
}

static PetscErrorCode CreateSpy(TSAdapt adapt)
{
  adapt->ops->choose = ChooseSpy;
  return PETSC_SUCCESS;
}

/* y' = -y and, for its different derivatives, z' = -2 z: to t = 0.5 with steps 0.5/n, the last of which is looked at */
static void Run(const char type[], const char options[], PetscInt n)
{
  PetscScalar entries[] = {-1, 0, 0, -2};
  Mat J;
  Vec y;
  TS ts;

  ok(PetscOptionsInsertString(NULL, options));
  ok(VecCreateSeq(PETSC_COMM_SELF, 2, &y));
  ok(VecSet(y, 1));
  ok(MatCreateSeqDense(PETSC_COMM_SELF, 2, 2, entries, &J)); /* which it goes on using */
  ok(TSCreate(PETSC_COMM_SELF, &ts));
  ok(TSSetType(ts, type));
  ok(TSSetRHSFunction(ts, NULL, TSComputeRHSFunctionLinear, NULL));
  ok(TSSetRHSJacobian(ts, J, J, TSComputeRHSJacobianConstant, NULL));
  ok(TSSetTolerances(ts, 1e-9, NULL, 0, NULL));
  ok(TSSetTimeStep(ts, 0.5 / (PetscReal)n));
  ok(TSSetMaxSteps(ts, n));
  ok(TSSetMaxTime(ts, 1));
  ok(TSSetExactFinalTime(ts, TS_EXACTFINALTIME_STEPOVER));
  ok(TSSetFromOptions(ts));
  SetAdapt(ts, "spy");
  ok(PetscOptionsClear(NULL));
  wait = n - 1;
  ok(TSSolve(ts, y));
  ObjectsDestroy(&ts, &J, &y);
}

static void exponents(void **state)
{
  static const struct {
    const char *type, *options;
    PetscReal power,
      assumed; /* of h in the estimate: of its leading term, and what the user says that it is; 0: that */
  } methods[] = {
    {"bathe", "", 3, 0},
    {"bathe", "-ts_bathe_error doubling -ts_bathe_order 2", 3, 0},
    {"bathe", "-ts_bathe_error doubling -ts_bathe_order 1", 3, 2}, /* as published */
    {TSTHETA, "-ts_theta_theta 1 -ts_theta_adapt", 2, 0},
    {TSTHETA, "-ts_theta_theta 0.5 -ts_theta_adapt", 2, 0}, /* PETSc's estimate of the trapezoidal rule */
    {TSBDF, "-ts_bdf_order 2", 3, 0},
    {TSBDF, "-ts_bdf_order 3", 4, 0},
  };

  ok(TSAdaptRegister("spy", CreateSpy));
  for (size_t m = 0; m < PETSC_STATIC_ARRAY_LENGTH(methods); m++) {
    const PetscReal want = methods[m].assumed > 0 ? methods[m].assumed : methods[m].power;
    PetscReal coarse, power;

    Run(methods[m].type, methods[m].options, 50);
    coarse = error;
    Run(methods[m].type, methods[m].options, 100);
    power = log2(coarse / error);
    for (int k = 0; k < OTHERS; k++) print_message(" %s %.3f", Others[k].type, 1 / exponent[k]);
    /* the next term of the estimate is smaller by about 2 h = 0.01 to 0.02, and a wrong order is off by 1 */
    AssertNear(power, methods[m].power, 0.05);
    /* the controllers compute with E as it is */
    for (int k = 0; k < OTHERS; k++) AssertNear(1 / exponent[k], want, 1e-6);
  }
}

SLIP_TESTS(exponents)
