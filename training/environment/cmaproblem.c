/* The network that CMA-ES trains, of any problem: its weights as a policy. */
#include "cmaproblem.h"
#include "environment.h"
#include "common/files.h"
#include <slipcompat.h>
#include <math.h>

/* An energy of a fault lies in [0, 1] */
PetscErrorCode CMAObservationsSet(CMAOptions *o, const char *const names[])
{
  PetscInt n = 0, energy;

  PetscFunctionBegin;
  while (names[n]) ++n;
  PetscCheck(n <= CMA_MAX_OBS, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
             "The problem %s has %" PetscInt_FMT " observations, expected %d at most", o->problem->name, n,
             CMA_MAX_OBS);
  PetscCall(EnvObservationsSet(n, names, &o->nobs, o->names, o->scale, o->offset));
  energy = CMAFind(o, "energy");
  if (energy >= 0) {
    o->scale[energy] = 2;
    o->offset[energy] = -1;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CMARowsSet(CMAOptions *o, PetscInt n, const CMARow row[])
{
  const char *names[CMA_MAX_OBS + 1] = {NULL};

  PetscFunctionBegin;
  for (PetscInt i = 0; i < n; ++i) names[i] = row[i].name;
  PetscCall(CMAObservationsSet(o, names));
  for (PetscInt i = 0; i < n; ++i) {
    o->scale[i] = (PetscReal)row[i].scale;
    o->offset[i] = (PetscReal)row[i].offset;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscInt CMACount(const CMAOptions *o)
{
  return o->nobs * o->hidden + o->hidden + (o->layers - 1) * (o->hidden + 1) * o->hidden + o->hidden + 1 + o->more;
}

PetscInt CMAFind(const CMAOptions *o, const char name[])
{
  for (PetscInt i = 0; i < o->nobs; ++i)
    if (!strcmp(o->names[i], name)) return i;
  return -1;
}

PetscErrorCode CMAPolicy(const CMAOptions *o, const double weights[], const PetscReal shift[2], SlipPolicy *policy)
{
  const PetscInt dial = CMAFind(o, SLIP_OBSERVES_ACCURACY);
  const PetscReal middle = 0.5 * PetscLog10Real(o->low * o->high);
  static const char moved[][2][32] = {/* numbers that follow the dial follow it where it is moved to */
                                      {SLIP_POLICY_RTOL_FACTOR, SLIP_POLICY_RTOL_POWER},
                                      {SLIP_POLICY_FIRST_STEP_FACTOR, SLIP_POLICY_FIRST_STEP_POWER}};
  PetscReal scale[CMA_MAX_OBS], offset[CMA_MAX_OBS];
  const double *w = weights;
  PetscInt in = o->nobs;

  PetscFunctionBegin;
  PetscCall(PetscArraycpy(scale, o->scale, o->nobs));
  PetscCall(PetscArraycpy(offset, o->offset, o->nobs));
  if (dial >= 0 && o->problem->cma->dial == CMA_DIAL_SPREAD) { /* x + shift[0] + shift[1] (x - middle) in place of x */
    scale[dial] *= 1 + shift[1];
    offset[dial] += o->scale[dial] * (shift[0] - shift[1] * middle);
  }
  PetscCall(SlipPolicyCreate(PETSC_COMM_SELF, policy));
  PetscCall(SlipPolicySetObservations(*policy, o->nobs, (const char *const *)o->names, scale, offset));
  for (PetscInt l = 0; l < o->layers; ++l) {
    PetscCall(SlipPolicyAddLayer(*policy, in, o->hidden, w, w + in * o->hidden, o->activation));
    w += (in + 1) * o->hidden;
    in = o->hidden;
  }
  PetscCall(SlipPolicyAddLayer(*policy, in, 1, w, w + in, SLIP_ACTIVATION_LINEAR));
  PetscCall((*o->problem->cma->policy)(o, weights, *policy));
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(moved) && (shift[0] != 0 || shift[1] != 0); ++i) {
    PetscReal factor, power;
    PetscBool follows, powered;

    PetscCall(SlipPolicyGetNumber(*policy, moved[i][0], &factor, &follows));
    PetscCall(SlipPolicyGetNumber(*policy, moved[i][1], &power, &powered));
    if (!follows || !powered) continue;
    factor *= PetscPowReal(10, power * (shift[0] - shift[1] * middle));
    PetscCall(PolicySetNumber(*policy, moved[i][0], "%.6g", (double)factor));
    PetscCall(PolicySetNumber(*policy, moved[i][1], "%.6g", (double)(power * (1 + shift[1]))));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
