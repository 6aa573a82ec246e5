/* Chooses formulas and tolerances for ruptures without inertia, which explicit steps compute by default.

   Only the stress at the start drives such a rupture, so that it ends within a few travel times of S waves along the
   fault. That is some hundreds of the times in which a cell relaxes, which bound explicit steps; an implicit step takes
   more products than it saves. Where stress continues to change, slip may last for years, and explicit steps lose.

   The default is TSRKC. TSADAMS, of higher order, is faster up to 6,000 cells where the error bounds a step. But once
   stability does, as an event ends, its slip rates fall too late, and with them the end of the event (by 1 of 29 s at
   1e-2 in the tutorial's). */
#include <slipstep/rooms/slipadapt.h>
#include <slipstep/private/slipfault.h>
#include <slipstep/private/slipsys.h>
#include <string.h>

#define RKC_RTOL 1e-2 /* for TSRKC, and below for the others, in runs that are no such ruptures */
#define OTHERS_RTOL 1e-3

/* Two numbers, one of which is a power of the other from row to row */
typedef PetscReal Row[2];

/* Tolerances that satisfy an accuracy in 95 % of each of six classes of drawn ruptures, for the history and the times
   when cells break: from 36 ruptures, and the finer ones from 24 others (tests/benchmarks/ruptures.py) */
enum { ACCURACIES = 4, TOLERANCES = 6 };
static const Row OfAdams[ACCURACIES] = {{1e-1, 0.3}, {1e-2, 0.015}, {3e-3, 6e-3}, {1e-3, 8e-4}};
static const Row OfRKC[ACCURACIES] = {{1e-1, 0.3}, {1e-2, 0.013}, {3e-3, 4e-3}, {1e-3, 7e-4}};
/* The error that 95 % of the 36 have at a tolerance */
static const Row ErrorOfAdams[TOLERANCES] = {{0.3, 7.1e-2},  {0.1, 2.7e-2},  {0.03, 1.2e-2},
                                             {0.01, 3.4e-3}, {3e-3, 1.8e-3}, {1e-3, 9.3e-4}};
static const Row ErrorOfRKC[TOLERANCES] = {{0.3, 5.1e-2},  {0.1, 2.8e-2},  {0.03, 9.9e-3},
                                           {0.01, 4.0e-3}, {3e-3, 1.7e-3}, {1e-3, 8.3e-4}};

PetscReal SlipFaultBetween(PetscInt rows, const PetscReal row[][2], PetscReal x)
{
  PetscInt k = 0;

  while (k < rows - 2 && x < row[k + 1][0]) k++;
  const PetscReal *large = row[k], *small = row[k + 1];
  const PetscReal power = PetscLogReal(large[1] / small[1]) / PetscLogReal(large[0] / small[0]);

  return large[1] * PetscPowReal(x / large[0], power);
}

/* Returns whether this is a rupture due to weakening with slip, from a stress that does not change. */
static PetscBool IsRupture(SlipFault fault)
{
  const SlipFrictionLaw *law = fault->friction.law;

  return !fault->kind.inertia && !fault->kind.sequence && !fault->loads.pressed && !fault->critical.known &&
             !law->always_slides && !law->by_rate && fault->resolution.weakens
           ? PETSC_TRUE
           : PETSC_FALSE;
}

/* Finds whether an option belongs to TSBATHE, to its solver, or to a controller with tolerances measured for TSBATHE.
   */
static PetscErrorCode NamesOptionOfBathe(SlipFault fault, TS ts, PetscBool *named)
{
  static const char *const stems[] = {"ts_bathe_", "ts_adapt_type", "ts_adapt_rl_", "ts_adapt_pi_",
                                      "snes_",     "ksp_",          "pc_"};
  const char *prefix;
  char *all, wanted[160];

  PetscFunctionBegin;
  *named = fault->options.text[FAULT_TOLERANCES][0] || fault->options.check_error ? PETSC_TRUE : PETSC_FALSE;
  PetscCall(TSGetOptionsPrefix(ts, &prefix));
  PetscCall(PetscOptionsGetAll(((PetscObject)ts)->options, &all)); /* "-name value -name ..." */
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(stems) && !*named; i++) {
    PetscCall(PetscSNPrintf(wanted, sizeof(wanted), "-%s%s", prefix ? prefix : "", stems[i]));
    for (const char *at = all; (at = strstr(at, wanted)) && !*named; at++)
      if (at == all || at[-1] == ' ') *named = PETSC_TRUE;
  }
  PetscCall(PetscFree(all));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds whether explicit steps are the default, for a fault with an explicit balance and a TS without a chosen type. */
PetscErrorCode SlipFaultExplicitIsDefault(SlipFault fault, TS ts, PetscBool *is)
{
  PetscBool named, bathe;

  PetscFunctionBegin;
  *is = IsRupture(fault);
  if (!*is) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(NamesOptionOfBathe(fault, ts, &named));
  PetscCall(PetscObjectTypeCompare((PetscObject)ts, TSBATHE, &bathe));
  if (named || bathe) *is = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultExplicitSteps(SlipFault fault, TS ts, char type[], size_t len, PetscReal *rtol)
{
  const PetscReal accuracy = SlipFaultAccuracy(fault);
  const char *prefix;
  PetscBool given, adams, rkc;

  PetscFunctionBegin;
  PetscCall(PetscStrncpy(type, TSRKC, len));
  PetscCall(TSGetOptionsPrefix(ts, &prefix));
  PetscCall(PetscOptionsGetString(((PetscObject)ts)->options, prefix, "-ts_type", type, len, NULL));
  PetscCall(PetscStrcmp(type, TSADAMS, &adams));
  PetscCall(PetscStrcmp(type, TSRKC, &rkc));
  *rtol = rkc ? RKC_RTOL : OTHERS_RTOL;
  PetscCall(SlipHasOption(((PetscObject)ts)->options, prefix, "ts_rtol", &given));
  if (given || !IsRupture(fault) || !(adams || rkc)) PetscFunctionReturn(PETSC_SUCCESS);
  fault->steps.accuracy = accuracy;
  *rtol = fault->steps.rtol = PetscMin(1, SlipFaultBetween(ACCURACIES, adams ? OfAdams : OfRKC, accuracy));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds whether the tolerance follows the accuracy: if it has changed since, it is the user's. */
PetscErrorCode SlipFaultExplicitFollows(SlipFault fault, TS ts, PetscBool *follows)
{
  PetscBool constant;
  PetscReal rtol;
  TSAdapt adapt;

  PetscFunctionBegin;
  PetscCall(TSGetTolerances(ts, NULL, NULL, &rtol, NULL));
  PetscCall(TSGetAdapt(ts, &adapt));
  PetscCall(PetscObjectTypeCompare((PetscObject)adapt, TSADAPTNONE, &constant));
  *follows = fault->problem.steps.any_integrator && fault->steps.accuracy > 0 && rtol == fault->steps.rtol && !constant
               ? PETSC_TRUE
               : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Estimates the error, which is relative to slip: the estimate needs less than a tenth of the slip to remain. */
PetscErrorCode SlipFaultExplicitEstimate(SlipFault fault, TS ts, PetscReal *error, const char **why)
{
  PetscBool basic, adams, rkc;
  PetscReal rtol, t, speed, displacement;
  TSAdapt adapt;
  Vec w;

  PetscFunctionBegin;
  *error = 0;
  *why = NULL;
  PetscCall(TSGetTolerances(ts, NULL, NULL, &rtol, NULL));
  PetscCall(TSGetAdapt(ts, &adapt));
  PetscCall(TSGetSolution(ts, &w));
  PetscCall(TSGetTime(ts, &t));
  PetscCall(PetscObjectTypeCompare((PetscObject)adapt, TSADAPTBASIC, &basic));
  PetscCall(PetscObjectTypeCompare((PetscObject)ts, TSADAMS, &adams));
  PetscCall(PetscObjectTypeCompare((PetscObject)ts, TSRKC, &rkc));
  PetscCall(SlipFaultLargestSpeed(fault, w, &speed));
  PetscCall(SlipFaultLargestDisplacement(fault, w, &displacement));
  if (!(adams || rkc) || !IsRupture(fault))
    *why = "not calibrated for such steps";
  else if (!basic)
    *why = "not calibrated for this controller";
  else if (SlipFaultPressureFollows(fault))
    *why = SLIP_ZONE_UNCALIBRATED;
  else if (speed * t > (PetscReal)0.1 * displacement)
    *why = "the fault still slides";
  if (*why) PetscFunctionReturn(PETSC_SUCCESS);
  *error = SlipFaultBetween(TOLERANCES, adams ? ErrorOfAdams : ErrorOfRKC, rtol);
  PetscFunctionReturn(PETSC_SUCCESS);
}
