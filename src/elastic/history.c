/* The history of a medium that remembers: two slots, which states follow from, and when they move on. */
#include <slipstep/private/slipelastic.h>
#include <slipstep/private/slipstate.h>

/*@
  SlipElasticRests - does the stress depend on slip alone, neither on time nor on the past?

  Not collective

  Input Parameter:
. el - the medium

  Output Parameter:
. rests - the times at which no cell slips may be skipped

  Level: developer

.seealso: SlipElasticRemembers()
@*/
PetscErrorCode SlipElasticRests(SlipElastic el, PetscBool *rests)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(el, SLIP_ELASTIC_CLASSID, 1);
  *rests = el->ops->rests;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipElasticLoads - does the medium load the fault by itself?

  Not collective

  Input Parameter:
. el - the medium

  Output Parameter:
. loads - steps and estimates are those of a loaded fault

  Level: developer

.seealso: SlipElasticRests()
@*/
PetscErrorCode SlipElasticLoads(SlipElastic el, PetscBool *loads)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(el, SLIP_ELASTIC_CLASSID, 1);
  *loads = el->ops->loads;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipElasticRemembers - does the stress depend on the history of slip?

  Not collective

  Input Parameter:
. el - the medium

  Output Parameter:
. remembers - SlipElasticAccept() and its like are to be called

  Level: developer

.seealso: SlipElasticAccept()
@*/
PetscErrorCode SlipElasticRemembers(SlipElastic el, PetscBool *remembers)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(el, SLIP_ELASTIC_CLASSID, 1);
  *remembers = el->ops->advance ? PETSC_TRUE : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipElasticGetShortestStep - the step below which nothing is gained: within it, waves do not leave a cell

  Not collective

  Input Parameter:
. el - the medium

  Output Parameter:
. step - [s]; 0: there is none

  Level: developer

.seealso: SLIPELASTICWAVES
@*/
PetscErrorCode SlipElasticGetShortestStep(SlipElastic el, PetscReal *step)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(el, SLIP_ELASTIC_CLASSID, 1);
  *step = 0;
  if (el->ops->shortest) PetscCall((*el->ops->shortest)(el, step));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipElasticGetImages - when stress comes that no slip of the fault makes, but that of its periodic images

  Not collective

  Input Parameter:
. el - the medium

  Output Parameters:
+ first - this long after slip the first of it comes [s]; PETSC_MAX_REAL: never
- last  - this long after slip it has gone, as far as it matters [s]

  Level: developer

.seealso: SLIPELASTICWAVES
@*/
PetscErrorCode SlipElasticGetImages(SlipElastic el, PetscReal *first, PetscReal *last)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(el, SLIP_ELASTIC_CLASSID, 1);
  *first = PETSC_MAX_REAL;
  *last = 0;
  if (el->ops->images) PetscCall((*el->ops->images)(el, first, last));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode CopySlot(SlipElastic el, PetscInt from, PetscInt to)
{
  PetscFunctionBegin;
  PetscCall((*el->ops->copy)(el, from, to));
  PetscCall(VecCopy(el->past[from].u, el->past[to].u));
  el->past[to].t = el->past[from].t;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode AdvanceSlot(SlipElastic el, PetscInt from, PetscInt to, PetscReal t, Vec u)
{
  PetscFunctionBegin;
  PetscCall((*el->ops->advance)(el, from, to, t, u));
  PetscCall(VecCopy(u, el->past[to].u));
  el->past[to].t = t;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SetUpSlots(SlipElastic el)
{
  PetscFunctionBegin;
  for (int k = 0; k < 2; k++)
    if (!el->past[k].u) PetscCall(MatCreateVecs(el->K, &el->past[k].u, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipElasticAccept - a step begins from a state that was accepted

  Collective; a medium without history does nothing

  Input Parameters:
+ el    - the medium
. t     - the time [s]
. u     - displacement [m]
- first - a run begins: there is nothing before

  Level: developer

  Note:
  It is called where a step begins, not where the one before ends: states within the last step, which observers ask for
  in between, and steps that an event takes back then follow from the same history as they did.

.seealso: SlipElasticAdvance(), SlipElasticRollBack()
@*/
PetscErrorCode SlipElasticAccept(SlipElastic el, PetscReal t, Vec u, PetscBool first)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(el, SLIP_ELASTIC_CLASSID, 1);
  if (!el->ops->advance) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SetUpSlots(el));
  PetscCall(AdvanceSlot(el, first || !el->known ? -1 : 1, 1, t, u));
  el->known = PETSC_TRUE;
  el->trial = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipElasticAdvance - a part of an attempt begins, from a state that is only tried

  Collective; a medium without history does nothing

  Input Parameters:
+ el - the medium
. t  - the time [s]
- u  - displacement [m]

  Level: developer

  Errors: PETSC_ERR_SUP for a medium that remembers whole steps alone, without copy

.seealso: SlipElasticAccept(), SlipElasticRollBack()
@*/
PetscErrorCode SlipElasticAdvance(SlipElastic el, PetscReal t, Vec u)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(el, SLIP_ELASTIC_CLASSID, 1);
  if (!el->ops->advance) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCheck(el->ops->copy, PetscObjectComm((PetscObject)el), PETSC_ERR_SUP,
             "the medium %s remembers whole steps alone: expected steps without parts, as of -ts_type lapusta",
             ((PetscObject)el)->type_name);
  if (!el->trial) PetscCall(CopySlot(el, 1, 0));
  PetscCall(AdvanceSlot(el, 1, 1, t, u));
  el->trial = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipElasticRollBack - an attempt was refused: back to the start of the step

  Collective; without SlipElasticAdvance() since that start, and in a medium without history, it does nothing

  Input Parameter:
. el - the medium

  Level: developer

.seealso: SlipElasticAccept(), SlipElasticAdvance()
@*/
PetscErrorCode SlipElasticRollBack(SlipElastic el)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(el, SLIP_ELASTIC_CLASSID, 1);
  if (el->trial) PetscCall(CopySlot(el, 0, 1));
  el->trial = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipElasticFindPast - the slot that the state of a time follows from

  Not collective; for types of media

  Input Parameters:
+ el - the medium
- t  - the time [s], not before the start of the last step

  Output Parameter:
. slot - 0 or 1; -1: there is no history, as before a run

  Level: developer

.seealso: SlipElasticGetPast(), SlipElasticAccept()
@*/
PetscErrorCode SlipElasticFindPast(SlipElastic el, PetscReal t, PetscInt *slot)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(el, SLIP_ELASTIC_CLASSID, 1);
  *slot = !el->known ? -1 : el->trial && t < el->past[1].t ? 0 : 1;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipElasticGetPast - the state of a slot of the history

  Not collective; for types of media

  Input Parameters:
+ el   - the medium
- slot - 0 or 1

  Output Parameter:
. past - its time and displacement, borrowed

  Level: developer

.seealso: SlipElasticFindPast()
@*/
PetscErrorCode SlipElasticGetPast(SlipElastic el, PetscInt slot, SlipElasticPast *past)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(el, SLIP_ELASTIC_CLASSID, 1);
  *past = el->past[slot];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipElasticVisit - write what a medium remembers to a checkpoint, or read it

  Collective; between two steps

  Input Parameters:
+ el    - the medium
- state - the checkpoint

  Level: developer

.seealso: SlipElasticAccept()
@*/
PetscErrorCode SlipElasticVisit(SlipElastic el, SlipState state)
{
  static const char *const time[] = {"time_before", "time"}, *const slip[] = {"displacement_before", "displacement"};
  PetscBool has;

  PetscFunctionBegin;
  PetscValidHeaderSpecific(el, SLIP_ELASTIC_CLASSID, 1);
  PetscCall(SlipStateObject(state, "stiffness", (PetscObject)el->K));
  PetscCall(SlipStateObject(state, "viscosity", (PetscObject)el->H));
  PetscCall(SlipStateObject(state, "stage", (PetscObject)el->B));
  PetscCall(SlipElasticImagesState(el, state));
  PetscCall(SlipStateGroup(state, "medium"));
  PetscCall(SlipStateHasValue(state, "frequency", &has));
  if (has) PetscCall(SlipStateReal(state, "frequency", 1, &el->frequency));
  if (!el->ops->advance && !el->ops->visit) PetscFunctionReturn(PETSC_SUCCESS);
  if (!el->ops->advance) {
    PetscCall((*el->ops->visit)(el, state));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(SlipStateBool(state, "known", &el->known));
  if (!el->known) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipStateBool(state, "within_attempt", &el->trial));
  PetscCall(SetUpSlots(el));
  for (int k = el->trial ? 0 : 1; k < 2; k++) {
    PetscCall(SlipStateReal(state, time[k], 1, &el->past[k].t));
    PetscCall(SlipStateVec(state, slip[k], el->past[k].u));
  }
  PetscCall((*el->ops->visit)(el, state));
  PetscFunctionReturn(PETSC_SUCCESS);
}
