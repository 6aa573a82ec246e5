static const char help[] =
  "Runs step-size controllers on a matrix of problems, and stores steps, times and errors in one file.\n  evaluate "
  "-evaluate_quick -evaluate_output output/quick.h5                       (seconds)\n  mpirun -n 2 evaluate "
  "-evaluate_policies 'training/policies/*.h5' -evaluate_output output/study.h5\nErrors are against a reference of "
  "each mesh, computed once and kept in the file. A run that was stopped continues with the\nsame command; other "
  "options add to the same file. slipstep plot-study draws it, slipstep results-table tabulates it.\n\n";

#include "evaluate/evaluate.h"
#include <slipcompat.h>

/* What -evaluate_ options there are; test_options.py holds the list to the sources */
static const char names[] =
  "accuracies controllers errors list max_attempts meshes output policies problems quick reactions "
  "reference_steps repeat_failed repetitions sizes spread steps time_limit tolerances";

int main(int argc, char **argv)
{
  EvaluateOptions o;
  PetscBool only_help = PETSC_FALSE;

  PetscFunctionBeginUser;
  PetscCall(SlipProgramInitialize(&argc, &argv, "evaluate", help));
  PetscCall(SlipStepInitializePackage());
  PetscCall(SlipDeclareOptions("evaluate_", names));
  PetscCall(SlipCheckOptionNames());
  PetscCall(EvaluateOptionsSet(&o));
  PetscCall(PetscOptionsHasHelp(NULL, &only_help));
  if (only_help) {
    for (PetscInt i = 0; i < o.nproblems; i++) { /* the options of the problems and of TS: set each one up, small */
      const ProblemCase c = {.problem = o.problems[i], .size = 3, .mesh = 1};
      void *model;
      TS ts;
      Vec w;

      PetscCall(c.problem->evaluation->create(PETSC_COMM_SELF, &c, &model));
      PetscCall(c.problem->evaluation->start(PETSC_COMM_SELF, &c, model, &ts, &w));
      PetscCall(TSSetFromOptions(ts));
      PetscCall(VecDestroy(&w));
      PetscCall(TSDestroy(&ts));
      PetscCall(c.problem->evaluation->destroy(&model));
    }
  } else {
    PetscCall(EvaluateWork(&o));
    if (!o.list) PetscCall(SlipWarnOfUnusedOptions());
  }
  PetscCall(PetscFree(o.policies));
  PetscCall(PetscFree(o.settings));
  PetscCall(PetscFinalize());
  return 0;
}
