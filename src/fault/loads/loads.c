/* Computes what loads and unclamps a fault in time: the shear stress at the start and its rate, the pressures of
   pressures.c, and the terms of terms.c. */
#include <slipstep/private/slipfault.h>
#include <slipstep/private/slipsys.h>
#include <math.h>
#include <slipstep/private/slipwork.h>

#define NEVER PETSC_MAX_REAL

/* Returns the number of the first corner of records after t, or the number of corners if there is none. */
PetscInt SlipLoadsCornerAfter(const SlipFaultLoads *loads, PetscReal t)
{
  const PetscReal after = SlipTimeAfter(t);
  PetscReal share;

  if (!loads->ncorners || after >= loads->corners[loads->ncorners - 1]) return loads->ncorners;
  return after < loads->corners[0] ? 0 : SlipRecordInterval(loads->ncorners, loads->corners, after, &share) + 1;
}

/* Computes the shear load, times weights, along the rake of each cell (1 for one component). Adding t to the origin
   first would lose the changes within the steps of an event to rounding. */
static void ShearAt(const SlipFaultLoads *loads, PetscReal t, PetscReal *restrict a)
{
  const PetscReal *restrict weight = loads->weight, *restrict traction = loads->traction, *restrict rate = loads->rate;
  const PetscInt c = loads->fault->layout.components, n = loads->n;
  const PetscReal origin = loads->origin;

  for (PetscInt i = 0; i < n && c == 1; i++) a[i] = weight[i] * (traction[i] + origin * rate[i] + t * rate[i]);
  for (PetscInt i = 0; i < n && c > 1; i++)
    for (PetscInt k = 0; k < c; k++)
      a[c * i + k] = weight[i] * (traction[i] + origin * rate[i] + t * rate[i]) * SlipFaultAlong(loads->fault, i)[k];
  SlipLoadsAddTerms(loads, t, PETSC_FALSE, weight, a, NULL);
}

/*
  SlipLoadsEvaluate - computes shear load and effective normal stress at the time t

  Collective. A pure function: the same t gives the same bits, whatever calls came before. out is zero before the first
  call and owns its arrays, which SlipLoadDestroy() frees; nothing is computed when it has that time already.
*/
PetscErrorCode SlipLoadsEvaluate(const SlipFaultLoads *loads, PetscReal t, SlipFaultLoad *out)
{
  PetscReal *a;

  PetscFunctionBegin;
  if (out->stress && ((out->time == t && out->origin == loads->origin) || !SlipLoadsVary(loads)))
    PetscFunctionReturn(PETSC_SUCCESS);
  out->stress = out->bare = loads->normal;
  if (loads->pressed) {
    if (!out->own) PetscCall(PetscMalloc1(2 * loads->n + 1, &out->own));
    PetscCall(SlipLoadsPressures(loads, t, PETSC_TRUE, out->own));
    SlipLoadsAddTerms(loads, t, PETSC_FALSE, NULL, NULL, out->own);
    for (PetscInt i = 0; i < loads->n; i++) {
      out->own[loads->n + i] = loads->normal[i] - out->own[i];
      out->own[i] = PetscMax(out->own[loads->n + i], 0);
    }
    out->stress = out->own;
    out->bare = out->own + loads->n;
  }
  if (loads->shears && (!out->shear || loads->grows || SlipFaultOpens(loads->fault))) {
    if (!out->shear) {
      PetscCall(VecCreate(loads->fault->comm, &out->shear));
      PetscCall(VecSetSizes(out->shear, loads->fault->layout.components * loads->n, PETSC_DETERMINE));
      PetscCall(VecSetType(out->shear, VECSTANDARD));
    }
    PetscCall(VecGetArrayWrite(out->shear, &a));
    ShearAt(loads, t, a);
    for (PetscInt i = 0; i < loads->n && SlipFaultOpens(loads->fault); i++)
      a[3 * i + 2] = -loads->weight[i] * out->bare[i];
    PetscCall(VecRestoreArrayWrite(out->shear, &a));
  }
  out->time = t;
  out->origin = loads->origin;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipLoadDestroy(SlipFaultLoad *load)
{
  PetscFunctionBegin;
  PetscCall(VecDestroy(&load->shear));
  PetscCall(PetscFree(load->own));
  *load = (SlipFaultLoad){0};
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets the load at t, borrowed until the next call for another time. */
PetscErrorCode SlipFaultGetLoad(SlipFault fault, PetscReal t, const SlipFaultLoad **load)
{
  PetscFunctionBegin;
  PetscCall(SlipLoadsEvaluate(&fault->loads, t, &fault->known.load));
  *load = &fault->known.load;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the next time after t at which a source stops, a well changes, or a course begins or ends; PETSC_MAX_REAL:
   there is none. */
PetscReal SlipLoadsNextEnd(const SlipFaultLoads *loads, PetscReal t)
{
  const PetscReal after = SlipTimeAfter(t);
  PetscReal next = SlipLoadsPressuresEnd(loads, t);

  for (PetscInt k = 0; k < loads->nterms; k++)
    next = PetscMin(next, loads->terms[k].course->end(&loads->terms[k], after));
  return next;
}

/* Returns the next corner of records, or end of a source, course or rate of a well, after t; PETSC_MAX_REAL: there is
   none. */
PetscReal SlipLoadsNextCorner(const SlipFaultLoads *loads, PetscReal t)
{
  const PetscInt corner = SlipLoadsCornerAfter(loads, t);
  const PetscReal next = SlipLoadsNextEnd(loads, t);

  return corner < loads->ncorners ? PetscMin(next, loads->corners[corner]) : next;
}

/* Returns for how long after t loads are nearly linear in time, which limits the pieces of a search for an onset. Both
   ends of a piece may miss the crest of a tide between them by 1 - cos(pi/64), a thousandth of its amplitude. */
PetscReal SlipLoadsPressureScale(const SlipFaultLoads *loads, PetscReal t, PetscReal duration)
{
  const PetscReal course = SlipLoadsScale(loads, t);

  return PetscMin(SlipLoadsPressuresScale(loads, t, duration), course < NEVER ? course / 64 : NEVER);
}

/* Sets up the loads; after the cells and the weights. */
PetscErrorCode SlipFaultLoadsSetUp(SlipFault fault)
{
  SlipFaultLoads *loads = &fault->loads;
  SlipFaultKind *kind = &fault->kind;
  PetscInt any[3] = {0, 0, 0};
  PetscReal fastest = 0;
  PetscBool medium;

  PetscFunctionBegin;
  loads->fault = fault;
  loads->n = fault->mesh.n;
  loads->weight = fault->mesh.weight;
  loads->traction = fault->fields.cell[FIELD_INITIAL_TRACTION];
  loads->rate = fault->fields.cell[FIELD_STRESSING_RATE];
  loads->normal = fault->fields.cell[FIELD_NORMAL_STRESS];
  for (PetscInt i = 0; i < loads->n; i++) {
    if (loads->traction[i] != 0 || loads->rate[i] != 0) any[0] = 1;
    if (loads->rate[i] != 0) any[1] = 1;
    if (fault->fields.cell[FIELD_HEALING_TIME][i] > 0) any[2] = 1;
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, any, 3, MPIU_INT, MPI_MAX, fault->comm));
  /* A traction balances the start of a smooth law, and the normal stress of cells that open is a load. */
  loads->shears = any[0] || fault->friction.law->always_slides || SlipFaultOpens(fault) ? PETSC_TRUE : PETSC_FALSE;
  loads->grows = any[1] ? PETSC_TRUE : PETSC_FALSE;
  PetscCall(SlipLoadsPressuresSetUp(loads));
  loads->pressed = loads->pore;
  PetscCall(SlipLoadsTermsSetUp(loads));
  for (PetscInt k = 0; k < loads->nterms; k++) {
    if (loads->terms[k].normal) loads->pressed = PETSC_TRUE;
    if (loads->terms[k].shear) loads->shears = loads->grows = PETSC_TRUE;
    /* one event may follow another, as at a rate; policies, which are for one event with inertia, know no such load */
    if (loads->terms[k].shear && !(loads->terms[k].course->once && !kind->inertia)) any[1] = 1;
  }
  /* the kind of problem that the loads and the healing make */
  kind->heals = (PetscBool)any[2];
  PetscCall(SlipElasticLoads(fault->medium, &medium));
  kind->sequence = kind->loaded || any[1] || medium || any[2] ? PETSC_TRUE : PETSC_FALSE;
  kind->driven = kind->sequence || SlipLoadsChange(loads) || !kind->inertia || fault->friction.law->always_slides
                   ? PETSC_TRUE
                   : PETSC_FALSE;
  if (!kind->heals) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(PetscMax(loads->n, 1), &fault->friction.healing));
  for (PetscInt i = 0; i < loads->n; i++) {
    const PetscReal time = fault->fields.cell[FIELD_HEALING_TIME][i];

    fault->friction.healing[i] = time > 0 ? 1 / time : 0;
    fastest = PetscMax(fastest, fault->friction.healing[i]);
  }
  PetscCallMPI(MPI_Allreduce(&fastest, &loads->fastest_healing, 1, MPIU_REAL, MPIU_MAX, fault->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultLoadsDestroy(SlipFault fault)
{
  SlipFaultLoads *loads = &fault->loads;

  PetscFunctionBegin;
  PetscCall(VecDestroy(&loads->drive));
  PetscCall(VecDestroy(&loads->pull));
  PetscCall(VecDestroy(&loads->hold));
  PetscCall(SlipLoadsPressuresDestroy(fault));
  PetscCall(SlipLoadsTermsDestroy(loads));
  PetscCall(PetscFree(fault->friction.healing));
  PetscCall(SlipLoadDestroy(&fault->known.load));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipFaultSetPressureFunction - sets a function of the caller that gives the pore pressure in time and space

  Logically collective; before SlipFaultSetUp().

  Input Parameters:
+ fault    - the fault
. function - fills p [n] with the pore pressure [Pa] of the n cells of this process at the time t [s], in the order of
             the state; smooth in time, and dependent on time alone, as times come in any order
- ctx      - context of the function; the fault stores the pointer

  Level: intermediate

  Notes:
  The strength is mu (sigma_n - p), never below 0. p adds to -fault_pore_pressure, -fault_injection and the
  fluid of -fault_permeability, as these add to each other. The search for the end of rest steps by thousandths of the
  run's duration: it may miss shorter pulses of pressure.

  Errors: PETSC_ERR_ORDER after SlipFaultSetUp(); of the run PETSC_ERR_FP for a pressure that is not finite

.seealso: SlipFaultSetField(), SlipFaultSetUp()
@*/
PetscErrorCode SlipFaultSetPressureFunction(SlipFault fault, SlipFaultPressureFn function, void *ctx)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(fault, SLIP_FAULT_CLASSID, 1);
  PetscCheck(!fault->setup, fault->comm, PETSC_ERR_ORDER,
             "call SlipFaultSetPressureFunction() before SlipFaultSetUp()");
  fault->loads.function = function;
  fault->loads.ctx = ctx;
  PetscFunctionReturn(PETSC_SUCCESS);
}
