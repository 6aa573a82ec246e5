/* TSADAPTRL: the classical controller with which a run continues once the policy is given up. It is a separate TSAdapt,
   so that it may have any type, including PETSc's; limits of the step and similar settings remain those of the
   TSADAPTRL. */
#include <slipstep/private/slipadapt.h>
#include <slipstep/rooms/slipts.h>

/* Types that problems name (SlipProblemOps); a run with rl accepts their options, too. */
static const char *const Types[] = {TSADAPTHEURISTIC, TSADAPTPI, TSADAPTDSP, TSADAPTBASIC};

/* The type of the fallback: the one that the problem names, or the heuristic */
const char *TSAdaptRLFallbackType_Private(const TSAdapt_RL *rl)
{
  const SlipProblemOps *problem = rl->observer.problem;

  return problem && problem->control.controller ? problem->control.controller : TSADAPTHEURISTIC;
}

/* Creates a controller without memory */
static PetscErrorCode Create(TSAdapt adapt, const char type[], TSAdapt *fallback)
{
  PetscFunctionBegin;
  PetscCall(TSAdaptCreate(PetscObjectComm((PetscObject)adapt), fallback));
  PetscCall(TSAdaptSetOptionsPrefix(*fallback, ((PetscObject)adapt)->prefix));
  PetscCall(PetscObjectSetOptions((PetscObject)*fallback, ((PetscObject)adapt)->options));
  PetscCall(SlipAdaptSetController(*fallback, type));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadOptions(TSAdapt fallback, SlipOptionItems PetscOptionsObject)
{
  PetscFunctionBegin;
  if (fallback->ops->setfromoptions) PetscCall((*fallback->ops->setfromoptions)(fallback, PetscOptionsObject));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Declares the options of all types, for -help and so that a wrong value ends the run before it starts */
PetscErrorCode TSAdaptRLFallbackOptions_Private(TSAdapt adapt, SlipOptionItems PetscOptionsObject)
{
  PetscFunctionBegin;
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(Types); i++) {
    TSAdapt fallback;

    PetscCall(Create(adapt, Types[i], &fallback));
    PetscCall(ReadOptions(fallback, PetscOptionsObject));
    PetscCall(TSAdaptDestroy(&fallback));
  }
  ((TSAdapt_RL *)adapt->data)->from_options = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Copies settings that belong to the run and not to the type */
static void Share(TSAdapt from, TSAdapt to)
{
  to->dt_min = from->dt_min;
  to->dt_max = from->dt_max;
  to->always_accept = from->always_accept;
  to->wnormtype = from->wnormtype;
  to->ignore_max = from->ignore_max;
  if (!SlipAdaptClips(from, SLIP_CLIP_LOW, SLIP_CLIP_HIGH)) { /* otherwise those of its type apply */
    to->clip[0] = from->clip[0];
    to->clip[1] = from->clip[1];
  }
  to->candidates = from->candidates;
  to->timestepjustdecreased = from->timestepjustdecreased;
  to->timestepjustdecreased_delay = from->timestepjustdecreased_delay;
}

/* The problem computes the tolerance with which the fallback reaches the wanted accuracy. */
static PetscErrorCode SetTolerance(TSAdapt adapt, TS ts)
{
  TSAdapt_RL *rl = (TSAdapt_RL *)adapt->data;
  const SlipProblemOps *problem = rl->observer.problem;

  PetscFunctionBegin;
  PetscCall(SlipAdaptGetController(rl->fallback, rl->fallback_name, sizeof(rl->fallback_name)));
  if (problem && problem->control.hand_over)
    PetscCall((*problem->control.hand_over)(ts, rl->fallback, rl->observer.run.accuracy, rl->observer.ctx));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes the fallback, which has no memory, take over. */
PetscErrorCode TSAdaptRLFallbackCreate_Private(TSAdapt adapt, TS ts)
{
  TSAdapt_RL *rl = (TSAdapt_RL *)adapt->data;

  PetscFunctionBegin;
  PetscCall(TSAdaptDestroy(&rl->fallback));
  PetscCall(Create(adapt, TSAdaptRLFallbackType_Private(rl), &rl->fallback));
  if (!rl->from_options) {
    PetscCall(SetTolerance(adapt, ts));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscOptionsBegin(PetscObjectComm((PetscObject)adapt), ((PetscObject)adapt)->prefix, "Controller that goes on", "TS");
  PetscCall(ReadOptions(rl->fallback, PetscOptionsObject));
  PetscCall(PetscOptionsReal("-ts_adapt_safety", "Factor on the step that the error allows", "", rl->fallback->safety,
                             &rl->fallback->safety, NULL));
  PetscCall(PetscOptionsReal("-ts_adapt_reject_safety", "The same after a rejection", "", rl->fallback->reject_safety,
                             &rl->fallback->reject_safety, NULL));
  PetscOptionsEnd();
  PetscCall(SetTolerance(adapt, ts));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TSAdaptRLFallbackChoose_Private(TSAdapt adapt, TS ts, PetscReal h, PetscInt *next_sc, PetscReal *next_h,
                                               PetscBool *accept, PetscReal *wlte, PetscReal *wltea, PetscReal *wlter)
{
  TSAdapt fallback = ((TSAdapt_RL *)adapt->data)->fallback;

  PetscFunctionBegin;
  Share(adapt, fallback);
  PetscCall((*fallback->ops->choose)(fallback, ts, h, next_sc, next_h, accept, wlte, wltea, wlter));
  adapt->timestepjustdecreased = fallback->timestepjustdecreased;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* If the type does not handle failed solves, the next step is the one that PETSc has shortened, as in TSBATHE. */
PetscErrorCode TSAdaptRLFallbackAfterFailure_Private(TSAdapt adapt, TS ts, PetscReal h_failed, PetscReal *h_next)
{
  TSAdapt fallback = ((TSAdapt_RL *)adapt->data)->fallback;
  PetscErrorCode (*after)(TSAdapt, TS, PetscReal, PetscReal *);

  PetscFunctionBegin;
  Share(adapt, fallback);
  PetscCall(PetscObjectQueryFunction((PetscObject)fallback, "TSAdaptChooseAfterFailure_C", &after));
  *h_next = ts->time_step;
  if (after) PetscCall((*after)(fallback, ts, h_failed, h_next));
  PetscFunctionReturn(PETSC_SUCCESS);
}
