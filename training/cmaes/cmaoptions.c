/* -train_* options of -train_algorithm cmaes: those that the problem's row has a meaning for. */
#include "cmatrain.h"
#include "common/files.h"
#include "common/options.h"
#include "environment/family.h"
#include <slipcompat.h>

/* Of all problems */
static PetscErrorCode ParseNumbers(CMAOptions *o, SlipOptionItems PetscOptionsObject)
{
  const PetscInt least = o->problem->cma->start_counts ? 0 : 1;
  const NumberOption row[] = {
    OPTION_INTEGER("-train_validation", "Episodes of each kind in a validation", &o->validation, 1, 100000),
    OPTION_INTEGER("-train_population", "Members of a generation, 0: 4 + 3 ln(weights)", &o->population, 0, 10000),
    OPTION_INTEGER("-train_diagonal", "Generations before the covariance may leave its diagonal", &o->diagonal, 0, 1e8),
    OPTION_INTEGER("-train_generations", "Generations, in total with those of -train_resume", &o->generations, least,
                   1e8),
    OPTION_INTEGER("-train_validation_interval", "Generations between validations; the best mean is written",
                   &o->interval, 1, 1e6),
    OPTION_INTEGER("-train_seed", "Seed of everything random", &o->seed, 0, PETSC_MAX_INT),
    OPTION_REAL("-train_sigma", "First step length of CMA-ES, in weights", &o->sigma, 1e-6, PETSC_MAX_REAL),
    OPTION_REAL("-train_minutes", "Wall time after which training ends and calibration begins [min], 0: no limit",
                &o->minutes, 0, PETSC_MAX_REAL)};
  const NumberOption of_episodes[] = {
    OPTION_INTEGER("-train_episodes", "Episodes of the training", &o->nsingle, 1, 100000),
    OPTION_INTEGER("-train_batch", "Episodes of a generation", &o->batch_single, 1, 100000)};
  const NumberOption hidden = OPTION_INTEGER("-train_hidden", "Width of the hidden layers", &o->hidden, 1, 256);

  PetscFunctionBegin;
  PetscCall(OptionsNumbers(PetscOptionsObject, PETSC_STATIC_ARRAY_LENGTH(row), row));
  if (!o->more) PetscCall(OptionsNumbers(PetscOptionsObject, 1, &hidden)); /* other networks are as they are */
  if (o->problem->cma->dial != CMA_DIAL_SPREAD)
    PetscCall(OptionsNumbers(PetscOptionsObject, PETSC_STATIC_ARRAY_LENGTH(of_episodes), of_episodes));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Of faults, small models and users' problems */
static PetscErrorCode ParseDial(MPI_Comm comm, CMAOptions *o, SlipOptionItems PetscOptionsObject)
{
  enum { OF_STEPS = 3 }; /* the last ones: others choose ratios of steps */
  const NumberOption row[] = {
    OPTION_INTEGER("-train_layers", "Number of hidden layers", &o->layers, 1, CMA_MAX_LAYERS),
    OPTION_INTEGER("-train_singles", "Episodes of one cell", &o->nsingle, 1, 100000),
    OPTION_INTEGER("-train_meshes", "Episodes on small heterogeneous meshes", &o->nmesh, 0, 100000),
    OPTION_INTEGER("-train_mesh_side", "Largest number of cells along a side of these meshes", &o->side, 2, 12),
    OPTION_INTEGER("-train_batch_singles", "Episodes of one cell in a generation", &o->batch_single, 1, 100000),
    OPTION_INTEGER("-train_batch_meshes", "Episodes on meshes in a generation", &o->batch_mesh, 0, 100000),
    OPTION_INTEGER("-train_late_generations", "Generations at the end that have separate batches", &o->late_generations,
                   0, 1e8),
    OPTION_INTEGER("-train_late_singles", "Episodes of one cell in one of these", &o->late_single, 1, 100000),
    OPTION_INTEGER("-train_late_meshes", "Episodes on meshes in one of these", &o->late_mesh, 0, 100000),
    OPTION_INTEGER("-train_calibration", "Episodes of each kind by which the dial is calibrated", &o->calibration, 1,
                   100000),
    OPTION_REAL("-train_within",
                "Share of the calibration's runs, of single cells and of meshes, that shall keep the dial in every "
                "third of its range: it is moved for that. 0: as trained",
                &o->within, 0, 1),
    OPTION_REAL("-train_dial_low", "Lowest position of the accuracy dial", &o->low, TSADAPTRL_ACCURACY_MIN,
                PETSC_MAX_REAL),
    OPTION_REAL("-train_dial_high", "Highest position of the accuracy dial", &o->high, TSADAPTRL_ACCURACY_MIN,
                PETSC_MAX_REAL),
    OPTION_REAL("-train_moving_dt_max",
                "Longest step while anything moves [T*]; what rests is stepped over to the end of its rest. 0: no such "
                "rule",
                &o->moving, 0, PETSC_MAX_REAL),
    OPTION_REAL("-train_dt_min", "Shortest step the policy can choose [T*]", &o->dt_min, 1e-12, PETSC_MAX_REAL),
    OPTION_REAL("-train_dt_max", "Longest step the policy can choose [T*; the circuit: t_max]", &o->dt_max, 1e-12,
                PETSC_MAX_REAL)};
  char *names[CMA_MAX_OBS + 1];
  PetscInt n = CMA_MAX_OBS;
  PetscBool set;

  PetscFunctionBegin;
  PetscCall(
    PetscOptionsStringArray("-train_observations", "Names of the observations, in order", NULL, names, &n, &set));
  if (set) {
    PetscCheck(n > 0, PETSC_COMM_SELF, PETSC_ERR_ARG_WRONG, "-train_observations has no value, expected names");
    names[n] = NULL;
    PetscCall(CMAObservationsSet(o, (const char *const *)names));
    for (PetscInt i = 0; i < n; ++i) PetscCall(PetscFree(names[i]));
  }
  PetscCall(PetscOptionsString("-train_start",
                               "Policy file whose network the training begins with; what it does not observe counts "
                               "nothing at first",
                               NULL, o->first, o->first, sizeof(o->first), NULL));
  PetscCall(OptionsNumbers(PetscOptionsObject, PETSC_STATIC_ARRAY_LENGTH(row) - (o->dt_max > 0 ? 0 : OF_STEPS), row));
  if (!o->problem->cma->kinds) o->nmesh = o->batch_mesh = o->late_mesh = 0;
  PetscCheck(o->dt_min < o->dt_max || strcmp(o->dt_max_unit, "T*"), comm, PETSC_ERR_ARG_OUTOFRANGE,
             "-train_dt_min is %.6g T* and -train_dt_max %.6g T*, expected a longer -train_dt_max", (double)o->dt_min,
             (double)o->dt_max);
  PetscCheck(o->low <= o->high && o->high <= TSADAPTRL_ACCURACY_MAX, comm, PETSC_ERR_ARG_OUTOFRANGE,
             "-train_dial_low is %.6g and -train_dial_high %.6g, expected them in order and at most %g", (double)o->low,
             (double)o->high, TSADAPTRL_ACCURACY_MAX);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CMAOptionsSet(MPI_Comm comm, const Problem *problem, CMAOptions *o)
{
  PetscInt moves = PETSC_STATIC_ARRAY_LENGTH(o->move);
  PetscBool set;

  PetscFunctionBegin;
  PetscCall(PetscMemzero(o, sizeof(*o)));
  o->problem = problem;
  PetscOptionsBegin(comm, NULL, "Training a step-size policy by CMA-ES", "train");
  if (!problem) PetscCall(ProblemOption(PetscOptionsObject, PROBLEM_BY_RUNS, &o->problem, &o->family));
  PetscCall((*o->problem->cma->setup)(o));
  PetscCall(ParseNumbers(o, PetscOptionsObject));
  if (o->problem->cma->dial == CMA_DIAL_SPREAD) PetscCall(ParseDial(comm, o, PetscOptionsObject));
  PetscCall(TrainSetFiles(PetscOptionsObject, "Checkpoint to write at every validation", o->output, o->log,
                          o->checkpoint, o->resume));
  PetscCall(PetscOptionsString(
    "-train_calibrate", "Policy file whose accuracy dial is calibrated again, by -train_within; nothing is trained",
    NULL, o->calibrate, o->calibrate, sizeof(o->calibrate), &set));
  PetscCall(PetscOptionsRealArray(
    "-train_move",
    "With -train_calibrate: by how many decades the policy sees the dial moved in the middle of its range, and by how "
    "many more for each decade above, as other runs than the trainer's have shown; no run is made",
    NULL, o->move, &moves, &o->moved));
  PetscOptionsEnd();
  PetscCheck(!o->moved || (o->calibrate[0] && moves == PETSC_STATIC_ARRAY_LENGTH(o->move)), comm, PETSC_ERR_ARG_WRONG,
             "-train_move %s, expected two numbers and -train_calibrate with a policy file",
             o->calibrate[0] ? "has not two values" : "has no policy");
  PetscCheck(!set || (o->calibrate[0] && !o->resume[0]), comm, PETSC_ERR_ARG_WRONG,
             "-train_calibrate is \"%s\"%s, expected the name of a policy file and no -train_resume", o->calibrate,
             o->resume[0] ? " beside -train_resume" : "");
  PetscCall(TrainCheckFiles(comm, o->output, o->log, o->checkpoint));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CMAOptionsFree(CMAOptions *o)
{
  PetscFunctionBegin;
  for (PetscInt i = 0; i < o->nobs; ++i) PetscCall(PetscFree(o->names[i]));
  PetscCall(PetscFree(o->family));
  PetscFunctionReturn(PETSC_SUCCESS);
}
