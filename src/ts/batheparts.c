/* TSBATHE's steps in parts: two halves for the error of step doubling, and parts for the errors of whole runs. */
#include <slipstep/private/slipbathe.h>

PetscErrorCode TSBatheSubstep(TS ts, PetscReal t, PetscReal h, Vec w0, Vec r0, Vec w1, Vec w2, Vec r2,
                              PetscReal *residual, PetscBool *ok)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  PetscReal own = 0;

  PetscFunctionBegin;
  ba->last.solves++;
  PetscCall((*ba->was->substep)(ts, t, h, w0, r0, w1, w2, r2, &own, ok));
  *residual += *ok ? own : 2;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns whether the attempt doubles the step. It does not if the controller uses no error and the user has not chosen
   doubling. */
PetscErrorCode TSBatheWantsDoubling(TS ts, PetscBool *flg)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  PetscBool none, needs = PETSC_TRUE;
  PetscErrorCode (*f)(TSAdapt, PetscBool *);

  PetscFunctionBegin;
  *flg = PETSC_FALSE;
  if (ba->estimate.type == TSBATHE_ERROR_NONE) PetscFunctionReturn(PETSC_SUCCESS);
  if (ba->estimate.type == TSBATHE_ERROR_EMBEDDED && ba->k0_known) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscObjectQueryFunction((PetscObject)ts->adapt, "TSAdaptNeedsError_C", &f));
  if (f) PetscCall((*f)(ts->adapt, &needs));
  PetscCall(PetscObjectTypeCompareAny((PetscObject)ts->adapt, &none, TSADAPTNONE, TSADAPTHISTORY, ""));
  if (none && !(ba->estimate.given && ba->estimate.type == TSBATHE_ERROR_DOUBLING)) needs = PETSC_FALSE;
  *flg = needs;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates the vectors that only doubling needs. */
static PetscErrorCode TSBatheSetUpDoubling(TS ts)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;

  PetscFunctionBegin;
  if (!ba->parts.Wfull) PetscCall(VecDuplicate(ts->vec_sol, &ba->parts.Wfull));
  if (!ba->parts.Wmid) PetscCall(VecDuplicate(ts->vec_sol, &ba->parts.Wmid));
  if (ba->con && !ba->parts.rmid) PetscCall(VecDuplicate(ba->r, &ba->parts.rmid));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes a step h as two halves, whose result is the solution, and as a whole, which serves the error only. The whole
   comes first, so that Y, K2 and r end as those of the second half. The error is their difference over 2^p - 1, with
   p = 2 for a smooth problem where doubling replaces the embedded estimate. */
PetscErrorCode TSBatheDoubling(TS ts, PetscReal h, PetscReal *residual, PetscBool *ok)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  PetscReal t = ts->ptime;
  PetscInt run = 1, p = ba->estimate.type == TSBATHE_ERROR_DOUBLING ? ba->estimate.order : 2;

  PetscFunctionBegin;
  PetscCall(TSBatheSetUpDoubling(ts));
  PetscCall(TSBatheSubstep(ts, t, h, ba->X0, ba->r0, ba->Y[0], ba->parts.Wfull, ba->r, residual, ok));
  if (*ok) {
    run++;
    PetscCall(TSBatheSubstep(ts, t, 0.5 * h, ba->X0, ba->r0, ba->Y[0], ba->parts.Wmid, ba->parts.rmid, residual, ok));
  }
  if (*ok) {
    run++;
    SlipProblemTry(ts, history.advance, t + 0.5 * h, ba->parts.Wmid);
    PetscCall(TSBatheSubstep(ts, t + 0.5 * h, 0.5 * h, ba->parts.Wmid, ba->parts.rmid, ba->Y[0], ba->Y[1], ba->r,
                             residual, ok));
  }
  *residual += 2.0 * (3 - run);
  if (!*ok) PetscFunctionReturn(PETSC_SUCCESS);
  if (ba->was->end) PetscCall((*ba->was->end)(ts, 0.5 * h, ba->parts.Wmid, ba->Y[0], ba->Y[1]));
  PetscCall(VecCopy(ba->parts.Wmid, ba->Wm));
  ba->share = 0.5;
  PetscCall(VecWAXPY(ba->estimate.E, -1.0, ba->parts.Wfull, ba->Y[1]));
  PetscCall(VecScale(ba->estimate.E, 1.0 / (PetscPowRealInt(2.0, (int)p) - 1.0)));
  PetscCall(TSBatheErrorNorm(ts, NORM_2, &ba->last.error));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Repeats the step in an even number of parts for TSBatheSetParts(); the error estimate does not change. */
PetscErrorCode TSBatheInParts(TS ts, PetscReal h, PetscInt parts, PetscReal *residual, PetscBool *ok)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  const PetscReal part = h / (PetscReal)parts;

  PetscFunctionBegin;
  PetscCall(TSBatheSetUpDoubling(ts));
  PetscCall(SlipProblemRollBack(ts));
  for (PetscInt k = 0; k < parts && *ok; k++) {
    const PetscBool odd = k % 2 ? PETSC_TRUE : PETSC_FALSE;
    Vec from = k ? (odd ? ba->parts.Wmid : ba->Y[1]) : ba->X0, rfrom = k ? (odd ? ba->parts.rmid : ba->r) : ba->r0;

    if (k) SlipProblemTry(ts, history.advance, ts->ptime + (PetscReal)k * part, from);
    PetscCall(TSBatheSubstep(ts, ts->ptime + (PetscReal)k * part, part, from, rfrom, ba->Y[0],
                             odd ? ba->Y[1] : ba->parts.Wmid, odd ? ba->r : ba->parts.rmid, residual, ok));
    if (*ok && ba->parts.fn)
      PetscCall(
        (*ba->parts.fn)(ts, ts->ptime + (PetscReal)(k + 1) * part, odd ? ba->Y[1] : ba->parts.Wmid, ba->parts.ctx));
  }
  if (!*ok) PetscFunctionReturn(PETSC_SUCCESS);
  if (ba->was->end) PetscCall((*ba->was->end)(ts, part, ba->parts.Wmid, ba->Y[0], ba->Y[1]));
  PetscCall(VecCopy(ba->parts.Wmid, ba->Wm));
  ba->share = 1.0 - 1.0 / (PetscReal)parts;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the number of parts in which the solution of every step is computed, with the whole's error. parts: number of
   parts, even; 1: the step is not divided; told: function that is called with the time [s] and the state at the end of
   each part, also of attempts that are rejected later; may be NULL. A run with the same controller then chooses equal
   steps at equal states, but computes the solution in parts of them: the difference of two such runs is a Richardson
   estimate of the error of the coarser one. Equal times of steps would not do that, because an event that comes a
   little later would meet the long steps meant for the rest after it. With doubling, whose solution has two halves
   already, there are twice as many parts. Each part costs one more Bathe solve. Errors: PETSC_ERR_ARG_OUTOFRANGE for a
   number that is neither 1 nor even. */
PetscErrorCode TSBatheSetParts(TS ts, PetscInt parts, TSBathePartFn told, void *ctx)
{
  TS_Bathe *ba = NULL;

  PetscFunctionBegin;
  PetscCall(TSBatheGetData(ts, PETSC_TRUE, &ba));
  PetscCheck(parts == 1 || (parts > 0 && parts % 2 == 0), PetscObjectComm((PetscObject)ts), PETSC_ERR_ARG_OUTOFRANGE,
             "%" PetscInt_FMT " parts of a step; expected 1 or an even number", parts);
  ba->parts.n = parts;
  ba->parts.fn = told;
  ba->parts.ctx = ctx;
  PetscFunctionReturn(PETSC_SUCCESS);
}
