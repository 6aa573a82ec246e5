/* The norm of the error of TSADAMS' steps is PETSc's, whatever tolerances are given; when the order changes. */
#include "../lotka.h"
#include "../unit.h"
#include <slipstep/rooms/slipcore.h>
#include <petsc/private/tsimpl.h>

static PetscReal norm_error; /* the largest difference to PETSc's */

/* Of the first step, of order 1: its estimate is h (f - f*)/2, f* at y + h f. Norms to the rounding of y + e, which
   PETSc takes e back from. */
static PetscErrorCode ChooseByNorms(TSAdapt adapt, TS ts, PetscReal h, PetscInt *next_sc, PetscReal *next_h,
                                    PetscBool *accept, PetscReal *wlte, PetscReal *wltea, PetscReal *wlter)
{
  const NormType types[] = {NORM_INFINITY, NORM_2, NORM_INFINITY};
  PetscReal norm, absolute, relative, ours;
  Vec y, f, star;

  *accept = PETSC_TRUE;
  *next_h = h;
  *next_sc = 0;
  *wlte = *wltea = *wlter = -1;
  if (ts->steps) return PETSC_SUCCESS;
  PetscCall(VecDuplicate(ts->vec_sol, &y));
  PetscCall(DuplicateVecs(y, &f, &star));
  PetscCall(VecSetValues(y, 2, (const PetscInt[]){0, 1}, (const PetscScalar[]){2, 0.5}, INSERT_VALUES));
  PetscCall(Rate(ts, 0, y, f, NULL));
  PetscCall(VecAXPY(y, h, f));
  PetscCall(Rate(ts, h, y, star, NULL));
  PetscCall(VecAXPY(star, -1, f));
  PetscCall(VecWAXPY(y, -h / 2, star, ts->vec_sol));
  for (int k = 0; k < 3; k++) {
    PetscCall(TSErrorWeightedNorm(ts, ts->vec_sol, y, types[k], &norm, &absolute, &relative));
    PetscCall(TSEvaluateWLTE(ts, types[k], NULL, &ours));
    norm_error = PetscMax(norm_error, PetscAbsReal(ours / norm - 1));
  }
  return DestroyObjects(&y, &f, &star);
}

static PetscErrorCode CreateByNorms(TSAdapt adapt)
{
  adapt->ops->choose = ChooseByNorms;
  return PETSC_SUCCESS;
}

/* Numbers and vectors of tolerances, with and without relative ones, and an entry without any */
static void norms(void **state)
{
  const PetscScalar absolute[][2] = {{1e-6, 3e-5}, {1e-6, 3e-5}, {1e-6, 0}};
  const PetscScalar relative[][2] = {{0, 0}, {1e-3, 1e-5}, {0, 0}};

  ok(TSAdaptRegister("norms", CreateByNorms));
  for (int k = -1; k < 3; k++) {
    Vec u, tolerance[2] = {NULL, NULL};
    TS ts;

    Make(&ts, &u, TSADAMS, 1e-2);
    ok(TSSetMaxSteps(ts, 1));
    for (int i = 0; i < 2 && k >= 0; i++) {
      ok(VecDuplicate(u, &tolerance[i]));
      ok(VecSetValues(tolerance[i], 2, (const PetscInt[]){0, 1}, i ? relative[k] : absolute[k], INSERT_VALUES));
    }
    ok(TSSetTolerances(ts, 1e-5, tolerance[0], 1e-4, tolerance[1]));
    SetAdapt(ts, "norms");
    norm_error = -1;
    ok(TSSolve(ts, u));
    AssertNear(norm_error, 0, 1e-9); /* e is 1e-5 of y */
    ObjectsDestroy(&ts, &u);
    for (int i = 0; i < 2; i++) ok(VecDestroy(&tolerance[i]));
  }
}

/* ---- orders ---- */

enum { REFUSED = 30, MOST = 36 };
static PetscInt orders[MOST], attempts; /* of the steps after each attempt */

/* Steps of one length, of which one is refused twice */
static PetscErrorCode ChooseOrders(TSAdapt adapt, TS ts, PetscReal h, PetscInt *next_sc, PetscReal *next_h,
                                   PetscBool *accept, PetscReal *wlte, PetscReal *wltea, PetscReal *wlter)
{
  assert_true(attempts < MOST);
  PetscCall(TSEvaluateWLTE(ts, NORM_2, &orders[attempts], wlte));
  *accept = attempts == REFUSED || attempts == REFUSED + 1 ? PETSC_FALSE : PETSC_TRUE;
  *next_h = h;
  *next_sc = 0;
  *wltea = *wlter = -1;
  attempts++;
  return PETSC_SUCCESS;
}

static PetscErrorCode CreateOrders(TSAdapt adapt)
{
  adapt->ops->choose = ChooseOrders;
  return PETSC_SUCCESS;
}

/* The order k of smooth short steps rises after k of them, as differences of higher order are of the same one by then.
   Two refused attempts of a step begin anew, one does not. */
static void changes(void **state)
{
  static const PetscInt rises[] = {2, 3, 3, 3, 4, 4, 4, 4, 5};
  Vec u;
  TS ts;

  ok(TSAdaptRegister("orders", CreateOrders));
  Make(&ts, &u, TSADAMS, 1e-2);
  SetAdapt(ts, "orders");
  ok(TSSetMaxSteps(ts, MOST - 2));
  attempts = 0;
  ok(TSSolve(ts, u));
  assert_int_equal(MOST, attempts);
  assert_memory_equal(orders, rises, sizeof(rises));
  assert_true(orders[REFUSED] > 3 && orders[REFUSED + 1] > 3);
  assert_memory_equal(orders + REFUSED + 2, rises, 4 * sizeof(*rises));
  ObjectsDestroy(&u, &ts);
}

SLIP_TESTS(norms, changes)
