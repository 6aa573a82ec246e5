/* The history of a medium with memory: slot 1 has the last accepted or tried state, slot 0 an attempt's start. */
#include <slipstep/private/slipelastic.h>
#include <slipstep/private/slipstate.h>

/* Returns whether the stress depends on slip alone, neither on time nor on the past. rests: `PETSC_TRUE`: a run may
   skip the times at which no cell slips. */
PetscErrorCode SlipElasticRests(SlipElastic el, PetscBool *rests)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(el, SLIP_ELASTIC_CLASSID, 1);
  *rests = el->ops->rests;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns whether the medium loads the fault by itself. loads: `PETSC_TRUE`: steps and error estimates are those of a
   loaded fault. */
PetscErrorCode SlipElasticLoads(SlipElastic el, PetscBool *loads)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(el, SLIP_ELASTIC_CLASSID, 1);
  *loads = el->ops->loads;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns whether the stress depends on the history of slip. remembers: `PETSC_TRUE`: a time integrator must call
   SlipElasticAccept(), SlipElasticAdvance(), SlipElasticRollBack(). */
PetscErrorCode SlipElasticRemembers(SlipElastic el, PetscBool *remembers)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(el, SLIP_ELASTIC_CLASSID, 1);
  *remembers = el->ops->advance ? PETSC_TRUE : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets the shortest useful step: in shorter ones waves do not leave a cell. step: the step [s]; 0: there is no such
   limit. */
PetscErrorCode SlipElasticGetShortestStep(SlipElastic el, PetscReal *step)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(el, SLIP_ELASTIC_CLASSID, 1);
  *step = 0;
  if (el->ops->shortest) PetscCall((*el->ops->shortest)(el, step));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets when the waves of the fault's periodic images arrive at the fault. first: time from slip until the first of
   these waves arrive [s]; PETSC_MAX_REAL: they never do; last: time from slip until the last waves that matter have
   passed [s]. */
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

/* Stores the accepted state from which a step begins. t: the time [s]; u: displacement [m]; first: a run begins: there
   is no earlier history. Call it where a step begins, not where the step before ends: until then the states within the
   last step, which observers interpolate, and steps that an event takes back follow from the same history as before. */
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

/* Stores the state from which a part of an attempted step begins, until the attempt is accepted. t: the time [s]; u:
   displacement [m]. Errors: PETSC_ERR_SUP for a medium that stores whole steps only (a type without the operation
   copy). */
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

/* Restores the history of the start of the step after an attempt was rejected. */
PetscErrorCode SlipElasticRollBack(SlipElastic el)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(el, SLIP_ELASTIC_CLASSID, 1);
  if (el->trial) PetscCall(CopySlot(el, 0, 1));
  el->trial = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipElasticFindPast - finds the slot of the history from which the state at a time follows

  Not collective; for types of media

  Input Parameters:
+ el - the medium
- t  - the time [s], not before the start of the last step

  Output Parameter:
. slot - 0 or 1; -1: there is no history yet, as before a run

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
  SlipElasticGetPast - gets the state in a slot of the history

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

/* Writes the history and the cached products of a medium to a checkpoint, or reads them. */
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
