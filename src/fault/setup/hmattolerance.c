/* Chooses the tolerance of the low-rank blocks of a hierarchical stiffness, -fault_hmat_tolerance, from the accuracy of
   the run, and tells it. K, Kn and, as a root of K, H have it. */
#include <slipstep/private/slipfault.h>
#include <slipstep/private/slipsys.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Tolerance over the wanted relative error of the run. A product's error is about 3e-3 of the tolerance, and the
   errors that it adds to when cells break, slip, moments, energies and times of events are at most a tenth of the
   tolerance, so that they are a thousandth of the wanted one (tests/benchmarks/README.md). Above the largest tolerance
   there is little left to save; the least is for runs whose accuracy is not known. */
#define HMAT_OF_ACCURACY 1e-2
#define HMAT_LEAST 1e-8
#define HMAT_MOST 1e-4

/* Options that may ask for more accuracy than -fault_accuracy */
static const char *const Finer[] = {"ts_rtol", "ts_adapt_rl_accuracy"};

/* Gets the tolerance, and why it is that: "from -fault_accuracy 0.01" (NULL: not wanted). After set-up these are those
   of the stiffness, before it what the options so far give. */
PetscErrorCode SlipFaultHmatTolerance(SlipFault fault, PetscReal *tolerance, char why[], size_t len)
{
  const PetscOptions options = ((PetscObject)fault)->options;
  const char *prefix = ((PetscObject)fault)->prefix, *name = "fault_accuracy";
  const PetscReal given = fault->options.value[FAULT_HMAT_TOLERANCE];
  PetscReal accuracy = SlipFaultAccuracy(fault);
  char type[64] = "", text[64], *end;
  PetscBool has;

  PetscFunctionBegin;
  if (why && fault->operators.hmat_tolerance > 0) PetscCall(PetscStrncpy(why, fault->operators.hmat_why, len));
  *tolerance = fault->operators.hmat_tolerance;
  if (*tolerance > 0) PetscFunctionReturn(PETSC_SUCCESS);
  *tolerance = given;
  if (why) (void)snprintf(why, len, "as asked");
  if (!PetscIsNanReal(given)) PetscFunctionReturn(PETSC_SUCCESS);
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(Finer) && fault->options.reports; i++) {
    PetscReal other;

    PetscCall(SlipPeekOption(options, prefix, Finer[i], text, sizeof(text), &has));
    other = (PetscReal)strtod(text, &end); /* its owner refuses what is no number */
    if (!has || end == text || *end || !(other < accuracy)) continue;
    accuracy = other;
    name = Finer[i];
  }
  if (fault->options.reports) PetscCall(SlipPeekOption(options, prefix, "ts_adapt_type", type, sizeof(type), &has));
  *tolerance = PetscMin(PetscMax((PetscReal)HMAT_OF_ACCURACY * accuracy, (PetscReal)HMAT_LEAST), (PetscReal)HMAT_MOST);
  if (why) (void)snprintf(why, len, "from -%s%s %g", SlipFaultPrefix(fault), name, (double)accuracy);
  if (PetscIsNanReal(fault->options.value[FAULT_ACCURACY]) &&
      (!strcmp(type, TSADAPTNONE) || !strcmp(type, TSADAPTHISTORY))) {
    *tolerance = HMAT_LEAST;
    if (why) (void)snprintf(why, len, "as steps are given");
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Fixes the tolerance of the stiffness that is computed now. */
PetscErrorCode SlipFaultHmatSetUp(SlipFault fault)
{
  SlipFaultOperators *o = &fault->operators;

  PetscFunctionBegin;
  PetscCall(SlipFaultHmatTolerance(fault, &o->hmat_tolerance, o->hmat_why, sizeof(o->hmat_why)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Is K hierarchical, or Kn, after set-up? -fault_operator auto may have chosen it. */
PetscErrorCode SlipFaultIsHierarchical(SlipFault fault, PetscBool *is)
{
  Mat matrix[2] = {NULL, NULL};

  PetscFunctionBegin;
  *is = PETSC_FALSE;
  PetscCall(SlipElasticGetMatrices(fault->medium, &matrix[0], &matrix[1], NULL));
  for (int k = 0; k < 2 && !*is; k++)
    if (matrix[k]) PetscCall(PetscObjectTypeCompare((PetscObject)matrix[k], "sliphmat", is));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prints a line before the run. Collective. */
PetscErrorCode SlipFaultHmatPrint(SlipFault fault)
{
  PetscBool is;

  PetscFunctionBegin;
  PetscCall(SlipFaultIsHierarchical(fault, &is));
  if (!is || !fault->options.progress) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscPrintf(fault->comm, "%-24s hierarchical, -%sfault_hmat_tolerance %g, %s\n", "stiffness:",
                        SlipFaultPrefix(fault), (double)fault->operators.hmat_tolerance, fault->operators.hmat_why));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the tolerance to /result and the summary. */
PetscErrorCode SlipFaultHmatResult(SlipFault fault, SlipOutput run)
{
  PetscBool is;

  PetscFunctionBegin;
  PetscCall(SlipFaultIsHierarchical(fault, &is));
  if (is)
    PetscCall(SlipOutputAddResult(run, "hmat_tolerance", "tolerance of stiffness", fault->operators.hmat_why,
                                  fault->operators.hmat_tolerance));
  PetscFunctionReturn(PETSC_SUCCESS);
}
