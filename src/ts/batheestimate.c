/* TSBATHE for those who estimate errors of whole runs: the estimates as vectors, their order, steps in halves. */
#include <slipstep/private/slipts.h>

/*@
  TSBatheGetOrder - order of the method as it is used: 2, or 1 when a set-valued reaction is treated implicitly

  Not collective

  Input Parameter:
. ts - of type TSBATHE

  Output Parameter:
. order - of the global error in the step, dimensionless

  Level: advanced

.seealso: TSBatheSetReaction(), TSBatheSetOrder()
@*/
PetscErrorCode TSBatheGetOrder(TS ts, PetscReal *order)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(ts, TS_CLASSID, 1);
  PetscUseMethod(ts, "TSBatheGetOrder_C", (TS, PetscReal *), (ts, order));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TSBatheGetOrder_Bathe(TS ts, PetscReal *order)
{
  const TS_Bathe *ba = (const TS_Bathe *)ts->data;

  PetscFunctionBegin;
  *order = ba->con && ba->reaction == TSBATHE_REACTION_IMPLICIT ? 1 : 2;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  TSBatheGetEstimates - what the last attempt knows beside its solution: its error, component by component, and dw/dt

  Not collective

  Input Parameter:
. ts - the integrator

  Output Parameters (each may be `NULL`):
+ error      - the estimated error in the layout and units of the solution, borrowed and valid until the next attempt;
               `NULL` when the last attempt did not converge or had no estimate, and when ts is not of type TSBATHE
. scale      - dimensionless factor that makes of the error the solution minus a more accurate one, to the method's order
- derivative - dw/dt at the attempt's end [units of the solution per s], borrowed likewise; `NULL` when not known

  Level: advanced

  Note:
  The embedded estimate is that difference, scale is 1. Doubling gives the two halves minus the whole, over 2^p - 1
  with an assumed order p (-ts_bathe_order), 1 as published; the error of the halves is minus the difference over 2^q
  - 1 with the order q of `TSBatheGetOrder()`.

.seealso: TSBatheGetLastAttempt(), TSBatheSetError(), TSBatheSetOrder()
@*/
PetscErrorCode TSBatheGetEstimates(TS ts, Vec *error, PetscReal *scale, Vec *derivative)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(ts, TS_CLASSID, 1);
  if (error) *error = NULL;
  if (scale) *scale = 1.0;
  if (derivative) *derivative = NULL;
  PetscTryMethod(ts, "TSBatheGetEstimates_C", (TS, Vec *, PetscReal *, Vec *), (ts, error, scale, derivative));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TSBatheGetEstimates_Bathe(TS ts, Vec *error, PetscReal *scale, Vec *derivative)
{
  const TS_Bathe *ba = (const TS_Bathe *)ts->data;
  const PetscBool known = ba->attempts && ba->last.converged ? PETSC_TRUE : PETSC_FALSE;

  PetscFunctionBegin;
  if (error && known && ba->last.error >= 0.0) *error = ba->E;
  if (derivative && known && ba->k2_known) *derivative = ba->K2;
  if (scale && ba->error == TSBATHE_ERROR_DOUBLING) {
    PetscReal order;

    PetscCall(TSBatheGetOrder_Bathe(ts, &order));
    *scale = -(PetscPowRealInt(2.0, (int)ba->order) - 1.0) / (PetscPowReal(2.0, order) - 1.0);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  TSBatheSetHalved - compute the solution of every step in two halves, the error estimate being that of the whole

  Logically collective

  Input Parameters:
+ ts     - of type TSBATHE
- halved - whether to

  Level: advanced

  Note:
  A run with the same controller then chooses steps of the same length at the same states, with a solution of half of
  them: the difference of two such runs is a Richardson estimate of the error of the coarser one. Steps put where they
  were in time would not do, as an event that comes a little later meets the long steps meant for the rest after it.
  With doubling, whose solution is one of halves already, it is computed in quarters. Costs two (four) further Bathe
  solves a step.

.seealso: TSBatheGetOrder(), TSBatheSetError()
@*/
PetscErrorCode TSBatheSetHalved(TS ts, PetscBool halved)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(ts, TS_CLASSID, 1);
  PetscUseMethod(ts, "TSBatheSetHalved_C", (TS, PetscBool), (ts, halved));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TSBatheSetHalved_Bathe(TS ts, PetscBool halved)
{
  PetscFunctionBegin;
  ((TS_Bathe *)ts->data)->halved = halved;
  PetscFunctionReturn(PETSC_SUCCESS);
}
