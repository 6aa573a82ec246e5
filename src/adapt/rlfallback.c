/* TSADAPTRL: the classical controller that a run continues with once the policy is given up. It is a separate TSAdapt,
   so that it may be of any type, PETSc's among them; limits of the step and the like stay those of the one that hands
   over. */
#include <slipstep/private/slipadapt.h>
#include <slipts.h>

/* Types that problems name (SlipProblemOps), whose options a run by rl knows too */
static const char *const Types[] = {TSADAPTHEURISTIC, TSADAPTPI, TSADAPTDSP, TSADAPTBASIC};

/* The type that goes on: what the problem names, or the heuristic. */
const char *TSAdaptRLFallbackType_Private(const TSAdapt_RL *rl)
{
  const SlipProblemOps *problem = rl->observer.problem;

  return problem && problem->controller ? problem->controller : TSADAPTHEURISTIC;
}

/* A controller without memory */
static PetscErrorCode Create(TSAdapt adapt, const char type[], TSAdapt *heir)
{
  PetscFunctionBegin;
  PetscCall(TSAdaptCreate(PetscObjectComm((PetscObject)adapt), heir));
  PetscCall(TSAdaptSetOptionsPrefix(*heir, ((PetscObject)adapt)->prefix));
  PetscCall(PetscObjectSetOptions((PetscObject)*heir, ((PetscObject)adapt)->options));
  PetscCall(SlipAdaptSetController(*heir, type));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadOptions(TSAdapt heir, SlipOptionItems PetscOptionsObject)
{
  PetscFunctionBegin;
  if (heir->ops->setfromoptions) PetscCall((*heir->ops->setfromoptions)(heir, PetscOptionsObject));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The options of all types, for -help and so that a wrong value ends the run before its start */
PetscErrorCode TSAdaptRLFallbackOptions_Private(TSAdapt adapt, SlipOptionItems PetscOptionsObject)
{
  PetscFunctionBegin;
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(Types); i++) {
    TSAdapt heir;

    PetscCall(Create(adapt, Types[i], &heir));
    PetscCall(ReadOptions(heir, PetscOptionsObject));
    PetscCall(TSAdaptDestroy(&heir));
  }
  ((TSAdapt_RL *)adapt->data)->from_options = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* What belongs to the run and not to the type */
static void Share(TSAdapt from, TSAdapt to)
{
  to->dt_min = from->dt_min;
  to->dt_max = from->dt_max;
  to->always_accept = from->always_accept;
  to->wnormtype = from->wnormtype;
  to->ignore_max = from->ignore_max;
  if (!SlipAdaptClips(from, SLIP_CLIP_LOW, SLIP_CLIP_HIGH)) { /* else that of its type */
    to->clip[0] = from->clip[0];
    to->clip[1] = from->clip[1];
  }
  to->candidates = from->candidates;
  to->timestepjustdecreased = from->timestepjustdecreased;
  to->timestepjustdecreased_delay = from->timestepjustdecreased_delay;
}

/* The problem knows at which tolerance the heir keeps what the policy was asked for. */
static PetscErrorCode SetTolerance(TSAdapt adapt, TS ts)
{
  TSAdapt_RL *rl = (TSAdapt_RL *)adapt->data;
  const SlipProblemOps *problem = rl->observer.problem;

  PetscFunctionBegin;
  PetscCall(SlipAdaptGetController(rl->heir, rl->heir_name, sizeof(rl->heir_name)));
  if (problem && problem->hand_over)
    PetscCall((*problem->hand_over)(ts, rl->heir, rl->observer.run.accuracy, rl->observer.ctx));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Begin to go on by it, without memory. */
PetscErrorCode TSAdaptRLFallbackCreate_Private(TSAdapt adapt, TS ts)
{
  TSAdapt_RL *rl = (TSAdapt_RL *)adapt->data;

  PetscFunctionBegin;
  PetscCall(TSAdaptDestroy(&rl->heir));
  PetscCall(Create(adapt, TSAdaptRLFallbackType_Private(rl), &rl->heir));
  if (!rl->from_options) {
    PetscCall(SetTolerance(adapt, ts));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscOptionsBegin(PetscObjectComm((PetscObject)adapt), ((PetscObject)adapt)->prefix, "Controller that goes on", "TS");
  PetscCall(ReadOptions(rl->heir, PetscOptionsObject));
  PetscCall(PetscOptionsReal("-ts_adapt_safety", "Factor on the step that the error allows", "", rl->heir->safety,
                             &rl->heir->safety, NULL));
  PetscCall(PetscOptionsReal("-ts_adapt_reject_safety", "The same after a rejection", "", rl->heir->reject_safety,
                             &rl->heir->reject_safety, NULL));
  PetscOptionsEnd();
  PetscCall(SetTolerance(adapt, ts));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TSAdaptRLFallbackChoose_Private(TSAdapt adapt, TS ts, PetscReal h, PetscInt *next_sc, PetscReal *next_h,
                                               PetscBool *accept, PetscReal *wlte, PetscReal *wltea, PetscReal *wlter)
{
  TSAdapt heir = ((TSAdapt_RL *)adapt->data)->heir;

  PetscFunctionBegin;
  Share(adapt, heir);
  PetscCall((*heir->ops->choose)(heir, ts, h, next_sc, next_h, accept, wlte, wltea, wlter));
  adapt->timestepjustdecreased = heir->timestepjustdecreased;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Of a type that knows nothing of failed solves the next step is the one that PETSc has shortened, as in TSBATHE. */
PetscErrorCode TSAdaptRLFallbackAfterFailure_Private(TSAdapt adapt, TS ts, PetscReal h_failed, PetscReal *h_next)
{
  TSAdapt heir = ((TSAdapt_RL *)adapt->data)->heir;
  PetscErrorCode (*after)(TSAdapt, TS, PetscReal, PetscReal *);

  PetscFunctionBegin;
  Share(adapt, heir);
  PetscCall(PetscObjectQueryFunction((PetscObject)heir, "TSAdaptChooseAfterFailure_C", &after));
  *h_next = ts->time_step;
  if (after) PetscCall((*after)(heir, ts, h_failed, h_next));
  PetscFunctionReturn(PETSC_SUCCESS);
}
