/* Chooses controller and tolerance for cycles of friction whose cells always slide, by TSADAMS, and gives the error of
   event times over the recurrence at a tolerance. Numbers are from 78 drawn lines of 32 to 96 cells, 57 of them by dsp,
   whose errors at a tolerance equal those of pi, and 17 planes of 128 to 648 (tests/benchmarks/cycles.py --drawn). */
#include <slipstep/rooms/slipadapt.h>
#include <slipstep/private/slipfault.h>
#include <slipstep/private/slipsys.h>
#include <slipstep/private/slipts.h>

#define OTHERS_RTOL 1e-3 /* for other types, controllers and runs */
/* Over the accuracy, where slip changes the pressure of a fluid: 14 bursts of a valve in 220 years have times within
   4e-5 for 1.9 s by a tolerance of 3e-5, and 3 more, until 250 years, within 1.5e-4; by 1e-4 for 1.7 s within 2.5e-4
   and 1.2e-2 */
#define FLUID_RTOL 3e-3

/* Tolerances at which the errors of event times of a cycle, over the recurrence, stay within an accuracy in 95 % of
   drawn faults, and the error that 95 % have at a tolerance: for lines, and for planes, whose errors are a tenth */
enum { LINE, PLANE, SHAPES, ACCURACIES = 4, TOLERANCES = 6 };
static const PetscReal Tolerance[SHAPES][ACCURACIES][2] = {{{1e-1, 2e-2}, {1e-2, 2e-3}, {3e-3, 2e-4}, {1e-3, 3e-5}},
                                                           {{1e-1, 3e-2}, {1e-2, 2e-2}, {3e-3, 3e-3}, {1e-3, 3e-4}}};
static const PetscReal Error[SHAPES][TOLERANCES][2] = {
  {{2e-2, 7e-2}, {1e-2, 3e-2}, {2e-3, 9.5e-3}, {5e-4, 5e-3}, {2e-4, 2.9e-3}, {3e-5, 9.5e-4}},
  {{3e-2, 9e-3}, {1e-2, 5e-3}, {3e-3, 1.8e-3}, {1e-3, 1.4e-3}, {1e-4, 3e-4}, {3e-5, 1e-4}}};
/* A plane counts as one only with at least so many cells in a cohesive zone */
#define CELLS_OF_PLANE 2

static PetscBool IsCycle(SlipFault fault)
{
  return fault->kind.sequence && !SlipLoadsChange(&fault->loads) && !fault->kind.waves ? PETSC_TRUE : PETSC_FALSE;
}

static PetscInt ShapeOf(SlipFault fault)
{
  const PetscBool row =
    !fault->options.text[FAULT_MESH][0] && PetscMin(fault->options.value[FAULT_NX], fault->options.value[FAULT_NZ]) == 1
      ? PETSC_TRUE
      : PETSC_FALSE;

  return row || !(fault->resolution.least >= CELLS_OF_PLANE) ? LINE : PLANE;
}

/* Sets *other if an option names a type, or a controller, other than ours. */
static PetscErrorCode NamesOther(TS ts, const char option[], const char ours[], PetscBool *other)
{
  const char *prefix;
  char name[64] = "";
  PetscBool same = PETSC_TRUE, given;

  PetscFunctionBegin;
  PetscCall(TSGetOptionsPrefix(ts, &prefix));
  PetscCall(PetscOptionsGetString(((PetscObject)ts)->options, prefix, option, name, sizeof(name), &given));
  if (given) PetscCall(PetscStrcmp(name, ours, &same));
  if (!same) *other = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Chooses TSADAMS and a controller. At equal errors of times on lines, basic takes 1.2 times the time of pi, and dsp
   0.93 of it. But dsp accepts steps with errors of ten tolerances and more, whose slip rates may exceed those of
   events: a small event may be two such steps. Under a pore pressure dsp was measured. All types use the error of the
   worst cell: a mean over the cells hides a cell that becomes unstable, the more so the quieter the others are. */
PetscErrorCode SlipFaultCycleSteps(SlipFault fault, TS ts, PetscReal *rtol)
{
  const PetscReal accuracy = SlipFaultAccuracy(fault);
  const char *prefix, *ours = fault->loads.pressed ? TSADAPTDSP : TSADAPTPI;
  PetscBool other;
  TSAdapt adapt;

  PetscFunctionBegin;
  PetscCall(TSSetType(ts, TSADAMS));
  PetscCall(TSGetAdapt(ts, &adapt));
  PetscCall(SlipAdaptSetController(adapt, ours));
  PetscCall(SlipAdaptSetNorm(adapt, NORM_INFINITY));
  PetscCall(TSGetOptionsPrefix(ts, &prefix));
  PetscCall(SlipHasOption(((PetscObject)ts)->options, prefix, "ts_rtol", &other));
  PetscCall(NamesOther(ts, "-ts_type", TSADAMS, &other));
  PetscCall(NamesOther(ts, "-ts_adapt_type", ours, &other));
  *rtol = fault->fluid.follows ? FLUID_RTOL * accuracy : OTHERS_RTOL;
  if (other || !IsCycle(fault)) PetscFunctionReturn(PETSC_SUCCESS);
  fault->steps.accuracy = accuracy;
  *rtol = fault->steps.rtol = PetscMin(1, SlipFaultBetween(ACCURACIES, Tolerance[ShapeOf(fault)], accuracy));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultCycleError(SlipFault fault, TS ts, PetscReal *error, const char **why)
{
  PetscBool adams, pi;
  PetscReal rtol;
  TSAdapt adapt;

  PetscFunctionBegin;
  *error = 0;
  *why = NULL;
  PetscCall(TSGetTolerances(ts, NULL, NULL, &rtol, NULL));
  PetscCall(TSGetAdapt(ts, &adapt));
  PetscCall(PetscObjectTypeCompare((PetscObject)adapt, TSADAPTPI, &pi));
  PetscCall(PetscObjectTypeCompare((PetscObject)ts, TSADAMS, &adams));
  if (!adams)
    *why = "not calibrated for such steps";
  else if (!pi)
    *why = "not calibrated for this controller";
  else if (SlipFaultPressureFollows(fault))
    *why = SLIP_ZONE_UNCALIBRATED;
  else if (!IsCycle(fault))
    *why = fault->loads.pore                ? "not calibrated under a pore pressure"
           : SlipLoadsChange(&fault->loads) ? "not calibrated under stresses in time"
                                            : "not calibrated without loading";
  if (!*why) *error = SlipFaultBetween(TOLERANCES, Error[ShapeOf(fault)], rtol);
  PetscFunctionReturn(PETSC_SUCCESS);
}
