/* A whole training by CMA-ES, of a problem of the table or of a user's. */
#include "cmatrain.h"
#include <slipcompat.h>

/* The -train_ options that say something of a user's problem; test_options.py holds the list to the sources */
static const char names[] =
  "batch_singles calibrate calibration checkpoint diagonal dial_high dial_low dt_max dt_min generations hidden "
  "late_generations "
  "late_singles layers log log_overwrite minutes move observations output population resume seed sigma singles start "
  "validation "
  "validation_interval within";

PetscErrorCode CMATrain(MPI_Comm comm, const Problem *problem)
{
  CMAOptions o;
  CMATrainer t;
  PetscBool only_help;

  PetscFunctionBegin;
  PetscCall(CMAOptionsSet(comm, problem, &o));
  PetscCall(PetscOptionsHasHelp(NULL, &only_help));
  if (only_help) {
    PetscCall(CMAOptionsFree(&o));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(CMATrainerCreate(comm, &o, &t));
  PetscCall(CMATrainerRun(&t));
  PetscCall(CMATrainerDestroy(&t));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipTrain - train a policy that chooses the steps of a problem of one's own, by CMA-ES

  Collective; after SlipStepInitializePackage().

  Input Parameters:
+ comm    - the processes that share the work; their number does not change the result
- problem - the table of the problem, its steps in units of T*

  Options Database Keys:
+ -train_output <file.h5>       - the policy: the best so far from the first validation on
. -train_log <file.h5>          - the learning curve
. -train_checkpoint <file.h5>   - all that -train_resume needs, at every validation
. -train_resume <file.h5>       - go on from there
. -train_start <file.h5>        - a policy whose network it begins with
. -train_generations <160>      - how long
. -train_minutes <0>            - wall time after which training ends and calibration begins [min]; 0: no limit
. -train_singles <128>          - instances to learn from
. -train_batch_singles <16>     - of a generation
. -train_validation <40>        - other instances, by which the best policy is chosen
. -train_calibration <60>       - other ones, by which the dial is calibrated
. -train_within <0.97>          - share of these that shall keep the dial
. -train_calibrate <file.h5>    - a policy whose dial is calibrated anew; nothing is trained
. -train_move <middle,decade>   - with that: decades by which the dial is moved, in place of a calibration by instances
. -train_dial_low <3e-3>        - lowest position of the accuracy dial
. -train_observations <names>   - in place of the table's
- -train_seed <0>               - of everything random

  Level: intermediate

  Note:
  The options of `train -train_algorithm cmaes` that do not speak of faults are read; -help lists them. A run whose
  solves fail or that takes more than 400 steps counts as unfinished; a function of the table that returns an error ends
  the training.

  Errors: PETSC_ERR_ARG_NULL for an incomplete table, PETSC_ERR_ARG_OUTOFRANGE and PETSC_ERR_ARG_WRONG with the option
  and what was expected, and those of observations that nobody knows.

.seealso: TSADAPTRL, TSSetSlipProblem(), SlipSmallConfigureTS(), SlipDeclareOptions()
@*/
PetscErrorCode SlipTrain(MPI_Comm comm, const SlipTrainProblem *problem)
{
  const struct {
    const char *name;
    PetscBool there;
  } part[] = {{"name", problem->name && problem->name[0] ? PETSC_TRUE : PETSC_FALSE},
              {"draw", problem->draw ? PETSC_TRUE : PETSC_FALSE},
              {"error", problem->error ? PETSC_TRUE : PETSC_FALSE},
              {"destroy", problem->destroy ? PETSC_TRUE : PETSC_FALSE},
              {"observations", problem->observations && problem->observations[0] ? PETSC_TRUE : PETSC_FALSE}};

  PetscFunctionBegin;
  PetscCall(SlipStepInitializePackage());
  PetscCall(SlipDeclareOptions("train_", names));
  PetscCall(SlipCheckOptionNames());
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(part); ++i)
    PetscCheck(part[i].there, comm, PETSC_ERR_ARG_NULL, "SlipTrain(): the problem %s has no %s",
               problem->name ? problem->name : "", part[i].name);
  PetscCheck(problem->dt_min > 0 && problem->dt_max > problem->dt_min, comm, PETSC_ERR_ARG_OUTOFRANGE,
             "SlipTrain(): the steps of problem %s go from dt_min %g T* to dt_max %g T*, expected 0 < dt_min < dt_max",
             problem->name, (double)problem->dt_min, (double)problem->dt_max);
  const Problem row = {.name = problem->name, .cma = &CMAUser, .user = problem};

  PetscCall(CMATrain(comm, &row));
  PetscFunctionReturn(PETSC_SUCCESS);
}
