/* Ruptures without inertia, which explicit steps compute by default: formulas and tolerances.

   Only stress that is there at the start drives such a rupture, so that it is over after some times that S waves take
   along the fault. That is some hundreds of the times in which a cell relaxes, by which explicit steps are bounded; an
   implicit one takes more products than it saves. Where stress goes on to change, slip may last for years, and they
   lose. */
#include <slipadapt.h>
#include <slipstep/private/slipfault.h>
#include <slipstep/private/slipsys.h>
#include <string.h>

#define RKC_RTOL 1e-2 /* of TSRKC, and of the others, in runs that are no such ruptures */
#define OTHERS_RTOL 1e-3
/* Cells from which on stability bounds the steps of TSADAMS, which TSRKC takes longer */
#define MANY_CELLS 10000

/* Tolerances that keep an accuracy */
typedef PetscReal Row[2];
static const Row OfAdams[] = {{1e-1, 0.1}, {1e-2, 0.02}, {1e-3, 4e-4}};
static const Row OfRKC[] = {{1e-1, 0.1}, {1e-2, 0.01}, {1e-3, 4e-4}};

/* Powers between these, and beyond them those of the ends */
static PetscReal ToleranceOf(PetscInt rows, const Row row[], PetscReal accuracy)
{
  PetscInt k = 0;

  while (k < rows - 2 && accuracy < row[k + 1][0]) k++;
  const PetscReal *loose = row[k], *tight = row[k + 1];
  const PetscReal power = PetscLogReal(loose[1] / tight[1]) / PetscLogReal(loose[0] / tight[0]);

  return PetscMin(1, loose[1] * PetscPowReal(accuracy / loose[0], power));
}

/* A rupture that friction makes by weakening with slip, from a stress that does not change */
static PetscBool IsRupture(SlipFault fault)
{
  const SlipFrictionLaw *law = fault->friction.law;

  return !fault->kind.inertia && !fault->kind.sequence && !fault->loads.pressed && !fault->critical.known &&
             !law->always_slides && !law->by_rate && fault->resolution.weakens
           ? PETSC_TRUE
           : PETSC_FALSE;
}

/* Does an option speak to TSBATHE, to its solver, or to a controller, whose tolerances were measured with it? */
static PetscErrorCode SpeaksToBathe(SlipFault fault, TS ts, PetscBool *speaks)
{
  static const char *const names[] = {"ts_adapt_type",
                                      "ts_adapt_rl_policy",
                                      "ts_adapt_rl_accuracy",
                                      "ts_adapt_rl_measure",
                                      "ts_adapt_rl_strict",
                                      "ts_bathe_method",
                                      "ts_bathe_gamma",
                                      "ts_bathe_first_stage",
                                      "ts_bathe_reaction",
                                      "ts_bathe_stage_error",
                                      "ts_bathe_error",
                                      "ts_adapt_safety",
                                      "snes_type",
                                      "ts_adapt_pi_filter",
                                      "ts_adapt_dsp_filter",
                                      "ts_adapt_dsp_pid",
                                      "snes_slip_direct_max",
                                      "ksp_rtol"};
  const char *prefix;

  PetscFunctionBegin;
  *speaks = fault->options.text[FAULT_TOLERANCES][0] || fault->options.check_error ? PETSC_TRUE : PETSC_FALSE;
  PetscCall(TSGetOptionsPrefix(ts, &prefix));
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(names) && !*speaks; i++)
    PetscCall(SlipHasOption(((PetscObject)ts)->options, prefix, names[i], speaks));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* of a fault whose balance is explicit, of a TS whose type nobody has named */
PetscErrorCode SlipFaultExplicitIsDefault(SlipFault fault, TS ts, PetscBool *is)
{
  PetscBool speaks, bathe;

  PetscFunctionBegin;
  *is = IsRupture(fault);
  if (!*is) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SpeaksToBathe(fault, ts, &speaks));
  PetscCall(PetscObjectTypeCompare((PetscObject)ts, TSBATHE, &bathe));
  if (speaks || bathe) *is = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultExplicitSteps(SlipFault fault, TS ts, char type[], size_t len, PetscReal *rtol)
{
  const char *prefix;
  PetscBool given;

  PetscFunctionBegin;
  PetscCall(PetscStrncpy(type, IsRupture(fault) && fault->mesh.N <= MANY_CELLS ? TSADAMS : TSRKC, len));
  PetscCall(TSGetOptionsPrefix(ts, &prefix));
  PetscCall(PetscOptionsGetString(((PetscObject)ts)->options, prefix, "-ts_type", type, len, NULL));
  *rtol = strcmp(type, TSRKC) ? OTHERS_RTOL : RKC_RTOL;
  PetscCall(SlipHasOption(((PetscObject)ts)->options, prefix, "ts_rtol", &given));
  if (given || !IsRupture(fault) || (strcmp(type, TSRKC) && strcmp(type, TSADAMS))) PetscFunctionReturn(PETSC_SUCCESS);
  fault->steps.accuracy = fault->options.value[FAULT_ACCURACY];
  if (PetscIsNanReal(fault->steps.accuracy)) fault->steps.accuracy = SLIP_FAULT_ACCURACY;
  *rtol = fault->steps.rtol = strcmp(type, TSRKC)
                                ? ToleranceOf(PETSC_STATIC_ARRAY_LENGTH(OfAdams), OfAdams, fault->steps.accuracy)
                                : ToleranceOf(PETSC_STATIC_ARRAY_LENGTH(OfRKC), OfRKC, fault->steps.accuracy);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A tolerance that somebody has changed since is the user's. */
PetscErrorCode SlipFaultExplicitFollows(SlipFault fault, TS ts, PetscBool *follows)
{
  PetscBool constant;
  PetscReal rtol;
  TSAdapt adapt;

  PetscFunctionBegin;
  PetscCall(TSGetTolerances(ts, NULL, NULL, &rtol, NULL));
  PetscCall(TSGetAdapt(ts, &adapt));
  PetscCall(PetscObjectTypeCompare((PetscObject)adapt, TSADAPTNONE, &constant));
  *follows = fault->problem.any_integrator && fault->steps.accuracy > 0 && rtol == fault->steps.rtol && !constant
               ? PETSC_TRUE
               : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}
