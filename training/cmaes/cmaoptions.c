/* -train_* options of -train_algorithm cmaes. */
#include "cmatrain.h"
#include "common/files.h"
#include "common/options.h"
#include <slipcompat.h>

#define USER_DIAL_LOW 3e-3
#define FAULT_DIAL_LOW 1e-3 /* finer accuracies of the whole history take hundreds of steps */

/* Names, and the scaling that brings them to order one; an energy of a fault lies in [0, 1] */
static PetscErrorCode SetObservations(CMAOptions *o, PetscInt n, const char *const names[])
{
  PetscFunctionBegin;
  PetscCall(EnvObservationsSet(n, names, &o->nobs, o->names, o->scale, o->offset));
  for (PetscInt i = 0; i < n; ++i)
    if (!strcmp(names[i], "energy")) {
      o->scale[i] = 2;
      o->offset[i] = -1;
    }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ParseObservations(CMAOptions *o, SlipOptionItems PetscOptionsObject)
{
  char *names[CMA_MAX_OBS];
  PetscInt n = CMA_MAX_OBS;
  PetscBool set;

  PetscFunctionBegin;
  PetscCall(
    PetscOptionsStringArray("-train_observations", "Names of the observations, in order", NULL, names, &n, &set));
  if (!set) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCheck(n > 0, PETSC_COMM_SELF, PETSC_ERR_ARG_WRONG, "-train_observations has no value, expected names");
  PetscCheck(n <= ENV_MAX_OBS || !o->small || o->user, PETSC_COMM_SELF, PETSC_ERR_ARG_WRONG,
             "-train_observations has %" PetscInt_FMT " names, expected %d at most for %s", n, ENV_MAX_OBS,
             o->problem->name);
  PetscCall(SetObservations(o, n, (const char *const *)names));
  for (PetscInt i = 0; i < n; ++i) PetscCall(PetscFree(names[i]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SetUser(CMAOptions *o, const SlipTrainProblem *user)
{
  PetscInt n = 0;

  PetscFunctionBegin;
  while (user->observations[n]) ++n;
  PetscCheck(n <= CMA_MAX_OBS, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
             "SlipTrain(): the problem %s has %" PetscInt_FMT " observations, expected %d at most", user->name, n,
             CMA_MAX_OBS);
  PetscCall(SetObservations(o, n, user->observations));
  o->user = user;
  o->small = PETSC_TRUE;
  o->dt_min = user->dt_min;
  o->dt_max = user->dt_max;
  PetscCall(PetscStrncpy(o->dt_max_unit, "T*", sizeof(o->dt_max_unit)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ParseProblem(CMAOptions *o, SlipOptionItems PetscOptionsObject)
{
  char problem[64] = "fault";
  PetscInt n = 0;
  const Preset *preset;

  PetscFunctionBegin;
  PetscCall(PetscOptionsString("-train_problem",
                               "What is simulated: fault, sliding_mode, circuit or ode (any TS), drawn at random", NULL,
                               problem, problem, sizeof(problem), NULL));
  PetscCall(ProblemFind(problem, &o->problem));
  if (o->problem == &ProblemFault) o->problem = &ProblemDial; /* whose episodes have the dial */
  o->small = o->problem->model ? PETSC_TRUE : PETSC_FALSE;
  PetscCall(FamilyOption(PetscOptionsObject, o->problem == &ProblemDial ? PETSC_TRUE : PETSC_FALSE, &o->family));
  preset = ProblemPreset(o->problem, "dial");
  while (preset->names[n]) ++n;
  PetscCall(SetObservations(o, n, preset->names));
  o->dt_min = preset->dt_min;
  o->dt_max = preset->dt_max;
  PetscCall(PetscStrncpy(o->dt_max_unit, preset->dt_max_unit, sizeof(o->dt_max_unit)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Small models need fewer weights than faults. */
static PetscErrorCode ParseNumbers(MPI_Comm comm, CMAOptions *o, SlipOptionItems PetscOptionsObject)
{
  const PetscBool small = o->small;
  const NumberOption row[] = {
    OPTION_INTEGER("-train_hidden", "Width of the hidden layers", &o->hidden, 1, 256),
    OPTION_INTEGER("-train_layers", "Number of hidden layers", &o->layers, 1, CMA_MAX_LAYERS),
    OPTION_INTEGER("-train_singles", "Episodes of one cell", &o->nsingle, 1, 100000),
    OPTION_INTEGER("-train_meshes", "Episodes on small heterogeneous meshes", &o->nmesh, 0, 100000),
    OPTION_INTEGER("-train_mesh_side", "Largest number of cells along a side of these meshes", &o->side, 2, 12),
    OPTION_INTEGER("-train_batch_singles", "Episodes of one cell in a generation", &o->batch_single, 1, 100000),
    OPTION_INTEGER("-train_batch_meshes", "Episodes on meshes in a generation", &o->batch_mesh, 0, 100000),
    OPTION_INTEGER("-train_late_generations", "Generations at the end that have batches of their own",
                   &o->late_generations, 0, 1e8),
    OPTION_INTEGER("-train_late_singles", "Episodes of one cell in one of these", &o->late_single, 1, 100000),
    OPTION_INTEGER("-train_late_meshes", "Episodes on meshes in one of these", &o->late_mesh, 0, 100000),
    OPTION_INTEGER("-train_validation", "Episodes of each kind in a validation", &o->validation, 1, 100000),
    OPTION_INTEGER("-train_calibration", "Episodes of each kind by which the dial is calibrated", &o->calibration, 1,
                   100000),
    OPTION_INTEGER("-train_population", "Members of a generation, 0: 4 + 3 ln(weights)", &o->population, 0, 10000),
    OPTION_INTEGER("-train_diagonal", "Generations before the covariance may leave its diagonal", &o->diagonal, 0, 1e8),
    OPTION_INTEGER("-train_generations", "Generations, in total with those of -train_resume", &o->generations, 1, 1e8),
    OPTION_INTEGER("-train_validation_interval", "Generations between validations; the best mean is written",
                   &o->interval, 1, 1e6),
    OPTION_INTEGER("-train_seed", "Seed of everything random", &o->seed, 0, PETSC_MAX_INT),
    OPTION_REAL("-train_sigma", "First step length of CMA-ES, in weights", &o->sigma, 1e-6, PETSC_MAX_REAL),
    OPTION_REAL("-train_minutes", "Wall time after which training ends [min], 0: no limit", &o->minutes, 0,
                PETSC_MAX_REAL),
    OPTION_REAL("-train_moving_dt_max",
                "Longest step while anything moves [T*]; what rests is stepped over to the end of its rest. 0: no such "
                "rule",
                &o->moving, 0, PETSC_MAX_REAL),
    OPTION_REAL("-train_within",
                "Share of the calibration's runs, of single cells and of meshes, that shall keep the dial in every "
                "third of its range: it is moved for that. 0: as trained",
                &o->within, 0, 1),
    OPTION_REAL("-train_dt_min", "Shortest step the policy can choose [T*]", &o->dt_min, 1e-12, PETSC_MAX_REAL),
    OPTION_REAL("-train_dt_max", "Longest step the policy can choose [T*; the circuit: t_max]", &o->dt_max, 1e-12,
                PETSC_MAX_REAL),
    OPTION_REAL("-train_dial_low", "Lowest position of the accuracy dial", &o->low, TSADAPTRL_ACCURACY_MIN,
                PETSC_MAX_REAL),
    OPTION_REAL("-train_dial_high", "Highest position of the accuracy dial", &o->high, TSADAPTRL_ACCURACY_MIN,
                PETSC_MAX_REAL)};

  PetscFunctionBegin;
  o->hidden = small ? 8 : 12;
  o->layers = 1;
  o->nsingle = small ? 256 : 400;
  o->nmesh = 200;
  o->side = 7;
  o->batch_single = small ? 48 : 24;
  o->batch_mesh = 20;
  o->late_generations = small ? 0 : 800;
  o->late_single = small ? 48 : 90;
  o->late_mesh = 60;
  o->validation = 60;
  o->calibration = small ? 75 : 100;
  o->population = small ? 16 : 24;
  o->diagonal = 200;
  o->generations = small ? 1500 : 2600;
  o->interval = 50;
  o->sigma = 0.1;
  o->moving = small ? 0 : 30;
  o->within = 0.97;
  o->low = small ? TSADAPTRL_ACCURACY_MIN : FAULT_DIAL_LOW;
  o->high = TSADAPTRL_ACCURACY_MAX;
  if (o->user) { /* whose runs are the library's, some ten times slower than those of small models */
    o->hidden = 6;
    o->nsingle = 128;
    o->batch_single = o->late_single = 16;
    o->validation = 40;
    o->calibration = 60;
    o->population = 12;
    o->diagonal = 60;
    o->generations = 160;
    o->interval = 20;
    o->low = USER_DIAL_LOW;
  }
  PetscCall(OptionsNumbers(PetscOptionsObject, PETSC_STATIC_ARRAY_LENGTH(row), row));
  if (small) o->nmesh = o->batch_mesh = o->late_mesh = 0;
  PetscCheck(o->dt_min < o->dt_max || strcmp(o->dt_max_unit, "T*"), comm, PETSC_ERR_ARG_OUTOFRANGE,
             "-train_dt_min is %.6g T* and -train_dt_max %.6g T*, expected a longer -train_dt_max", (double)o->dt_min,
             (double)o->dt_max);
  PetscCheck(o->low <= o->high && o->high <= TSADAPTRL_ACCURACY_MAX, comm, PETSC_ERR_ARG_OUTOFRANGE,
             "-train_dial_low is %.6g and -train_dial_high %.6g, expected them in order and at most %g", (double)o->low,
             (double)o->high, TSADAPTRL_ACCURACY_MAX);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CMAOptionsSet(MPI_Comm comm, const SlipTrainProblem *user, CMAOptions *o)
{
  PetscFunctionBegin;
  PetscCall(PetscMemzero(o, sizeof(*o)));
  PetscOptionsBegin(comm, NULL, "Training a step-size policy with an accuracy dial by CMA-ES", "train");
  if (user)
    PetscCall(SetUser(o, user));
  else
    PetscCall(ParseProblem(o, PetscOptionsObject));
  PetscCall(ParseObservations(o, PetscOptionsObject));
  PetscCall(ParseNumbers(comm, o, PetscOptionsObject));
  PetscCall(TrainSetFiles(PetscOptionsObject, "Checkpoint to write at every validation", o->output, o->log,
                          o->checkpoint, o->resume));
  PetscOptionsEnd();
  PetscCall(TrainCheckFiles(comm, o->output, o->log, o->checkpoint));
  PetscFunctionReturn(PETSC_SUCCESS);
}
