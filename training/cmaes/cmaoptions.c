/* -train_* options of -train_algorithm cmaes. */
#include "cmatrain.h"
#include "common/files.h"
#include <slipcompat.h>

/* Names, and the scaling that brings them to order one; an energy of a fault lies in [0, 1] */
static PetscErrorCode SetObservations(CMAOptions *o, PetscInt n, const char *const names[])
{
  PetscFunctionBegin;
  for (PetscInt i = 0; i < o->nobs; ++i) PetscCall(PetscFree(o->names[i]));
  o->nobs = n;
  for (PetscInt i = 0; i < n; ++i) {
    PetscCall(PetscStrallocpy(names[i], &o->names[i]));
    EnvObservationScale(names[i], &o->scale[i], &o->offset[i]);
    if (strcmp(names[i], "energy")) continue;
    o->scale[i] = 2;
    o->offset[i] = -1;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ParseProblem(CMAOptions *o, SlipOptionItems PetscOptionsObject)
{
  char problem[64] = "fault", *names[CMA_MAX_OBS];
  PetscInt n = 0;
  const Preset *preset;
  PetscBool set;

  PetscFunctionBegin;
  PetscCall(PetscOptionsString("-train_problem", "What is simulated: fault, sliding_mode or circuit, drawn at random",
                               NULL, problem, problem, sizeof(problem), NULL));
  PetscCall(ProblemFind(problem, &o->problem));
  if (o->problem == &ProblemFault) o->problem = &ProblemDial; /* whose episodes have the dial */
  preset = ProblemPreset(o->problem, "dial");
  while (preset->names[n]) ++n;
  PetscCall(SetObservations(o, n, preset->names));
  o->dt_min = preset->dt_min;
  o->dt_max = preset->dt_max;
  PetscCall(PetscStrncpy(o->dt_max_unit, preset->dt_max_unit, sizeof(o->dt_max_unit)));
  n = CMA_MAX_OBS;
  PetscCall(
    PetscOptionsStringArray("-train_observations", "Names of the observations, in order", NULL, names, &n, &set));
  if (!set) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCheck(n > 0, PETSC_COMM_SELF, PETSC_ERR_ARG_WRONG, "-train_observations has no value, expected names");
  PetscCheck(n <= ENV_MAX_OBS || !o->problem->model, PETSC_COMM_SELF, PETSC_ERR_ARG_WRONG,
             "-train_observations has %" PetscInt_FMT " names, expected %d at most for %s", n, ENV_MAX_OBS, problem);
  PetscCall(SetObservations(o, n, (const char *const *)names));
  for (PetscInt i = 0; i < n; ++i) PetscCall(PetscFree(names[i]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Other problems than the fault need fewer weights. */
static PetscErrorCode ParseCounts(MPI_Comm comm, CMAOptions *o, SlipOptionItems PetscOptionsObject)
{
  const PetscBool small = o->problem->model ? PETSC_TRUE : PETSC_FALSE;
  const struct {
    const char *name, *text;
    PetscInt *value, initial, low, high;
  } row[] = {
    {"-train_hidden", "Width of the hidden layers", &o->hidden, 8, 1, 256},
    {"-train_layers", "Number of hidden layers", &o->layers, small ? 1 : 2, 1, CMA_MAX_LAYERS},
    {"-train_singles", "Episodes of one cell", &o->nsingle, 256, 1, 100000},
    {"-train_meshes", "Episodes on small heterogeneous meshes", &o->nmesh, 144, 0, 100000},
    {"-train_mesh_side", "Largest number of cells along a side of these meshes", &o->side, 7, 2, 12},
    {"-train_batch_singles", "Episodes of one cell in a generation", &o->batch_single, small ? 48 : 28, 1, 100000},
    {"-train_batch_meshes", "Episodes on meshes in a generation", &o->batch_mesh, 20, 0, 100000},
    {"-train_validation", "Episodes of each kind in a validation", &o->validation, small ? 60 : 50, 1, 100000},
    {"-train_calibration", "Episodes of each kind by which the dial is calibrated", &o->calibration, small ? 75 : 150,
     1, 100000},
    {"-train_population", "Members of a generation, 0: 4 + 3 ln(weights)", &o->population, small ? 16 : 24, 0, 10000},
    {"-train_diagonal", "Generations before the covariance may leave its diagonal", &o->diagonal, 200, 0, 100000000},
    {"-train_generations", "Generations, in total with those of -train_resume", &o->generations, 1500, 1, 100000000},
    {"-train_validation_interval", "Generations between validations; the best mean is written", &o->interval, 50, 1,
     1000000},
    {"-train_seed", "Seed of everything random", &o->seed, 0, 0, PETSC_MAX_INT},
  };

  PetscFunctionBegin;
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(row); ++i) {
    *row[i].value = row[i].initial;
    PetscCall(PetscOptionsInt(row[i].name, row[i].text, NULL, *row[i].value, row[i].value, NULL));
    PetscCheck(*row[i].value >= row[i].low && *row[i].value <= row[i].high, comm, PETSC_ERR_ARG_OUTOFRANGE,
               "%s is %" PetscInt_FMT ", expected %" PetscInt_FMT " to %" PetscInt_FMT, row[i].name, *row[i].value,
               row[i].low, row[i].high);
  }
  if (small) o->nmesh = o->batch_mesh = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ParseNumbers(MPI_Comm comm, CMAOptions *o, SlipOptionItems PetscOptionsObject)
{
  const struct {
    const char *name, *text;
    PetscReal *value, initial, low;
  } row[] = {
    {"-train_sigma", "First step length of CMA-ES, in weights", &o->sigma, 0.1, 1e-6},
    {"-train_minutes", "Wall time after which training ends [min], 0: no limit", &o->minutes, 0, 0},
    {"-train_moving_dt_max",
     "Longest step while anything moves [T*]; what rests is stepped over to the end of its rest. 0: no such rule",
     &o->moving, o->problem->model ? 0 : 3, 0},
    {"-train_within",
     "Share of the calibration's runs, of single cells and of meshes, that shall keep the dial in every third of "
     "its "
     "range, at most 1: it is moved for that. 0: as trained",
     &o->within, 0.97, 0},
    {"-train_dt_min", "Shortest step the policy can choose [T*]", &o->dt_min, o->dt_min, 1e-12},
    {"-train_dt_max", "Longest step the policy can choose [T*; the circuit: t_max]", &o->dt_max, o->dt_max, 1e-12},
    {"-train_dial_low", "Lowest position of the accuracy dial", &o->low, TSADAPTRL_ACCURACY_MIN,
     TSADAPTRL_ACCURACY_MIN},
    {"-train_dial_high", "Highest position of the accuracy dial", &o->high, TSADAPTRL_ACCURACY_MAX,
     TSADAPTRL_ACCURACY_MIN},
  };

  PetscFunctionBegin;
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(row); ++i) {
    *row[i].value = row[i].initial;
    PetscCall(PetscOptionsReal(row[i].name, row[i].text, NULL, *row[i].value, row[i].value, NULL));
    PetscCheck(*row[i].value >= row[i].low && !PetscIsInfOrNanReal(*row[i].value), comm, PETSC_ERR_ARG_OUTOFRANGE,
               "%s is %.6g, expected at least %.6g", row[i].name, (double)*row[i].value, (double)row[i].low);
  }
  PetscCheck(o->within <= 1, comm, PETSC_ERR_ARG_OUTOFRANGE, "-train_within is %.6g, expected at most 1",
             (double)o->within);
  PetscCheck(o->dt_min < o->dt_max || o->problem->model, comm, PETSC_ERR_ARG_OUTOFRANGE,
             "-train_dt_min is %.6g T* and -train_dt_max %.6g T*, expected a longer -train_dt_max", (double)o->dt_min,
             (double)o->dt_max);
  PetscCheck(o->low <= o->high && o->high <= TSADAPTRL_ACCURACY_MAX, comm, PETSC_ERR_ARG_OUTOFRANGE,
             "-train_dial_low is %.6g and -train_dial_high %.6g, expected them in order and at most %g", (double)o->low,
             (double)o->high, TSADAPTRL_ACCURACY_MAX);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CMAOptionsSet(MPI_Comm comm, CMAOptions *o)
{
  PetscFunctionBegin;
  PetscCall(PetscMemzero(o, sizeof(*o)));
  PetscOptionsBegin(comm, NULL, "Training a step-size policy with an accuracy dial by CMA-ES", "train");
  PetscCall(ParseProblem(o, PetscOptionsObject));
  PetscCall(ParseCounts(comm, o, PetscOptionsObject));
  PetscCall(ParseNumbers(comm, o, PetscOptionsObject));
  PetscCall(TrainSetFiles(PetscOptionsObject, "Checkpoint to write at every validation", o->output, o->log,
                          o->checkpoint, o->resume));
  PetscOptionsEnd();
  PetscCall(TrainCheckFiles(comm, o->output, o->log, o->checkpoint));
  PetscFunctionReturn(PETSC_SUCCESS);
}
