/* See ladder.h: options, runs, table and file. */
#include "ladder.h"
#include "common/files.h"
#include "common/options.h"
#include "environment/family.h"
#include <slipcompat.h>
#include <math.h>
#include <string.h>
#include <time.h>

static const PetscReal Accuracies[] = {1e-1, 3e-2, 1e-2, 3e-3, 1e-3};
enum { ACCURACIES = PETSC_STATIC_ARRAY_LENGTH(Accuracies) };
#define SMALL 0.5 /* errors below this share of the finest accuracy need no tighter tolerance */

#define SHRINK 0.85
enum { MOST_SHRINKS = 20 };

typedef struct {
  const Problem *problem;
  Family *family; /* NULL: the problem's own draws */
  PetscInt n, seed;
  PetscReal within; /* share of the episodes */
  char controllers[256], output[PETSC_MAX_PATH_LEN];
} Options;

static PetscErrorCode OptionsSet(MPI_Comm comm, Options *o)
{
  const NumberOption row[] = {
    OPTION_INTEGER("-train_calibration", "Episodes that are drawn", &o->n, 1, 100000),
    OPTION_INTEGER("-train_seed", "Seed of everything random", &o->seed, 0, PETSC_MAX_INT),
    OPTION_REAL("-train_within", "Share of the episodes that shall keep an accuracy", &o->within, 0, 1)};
  PetscMPIInt size;

  PetscFunctionBegin;
  *o = (Options){.n = 64, .within = (PetscReal)0.97, .controllers = DIAL_CONTROLLERS};
  PetscOptionsBegin(comm, NULL, "Tolerances of classical controllers by the accuracy that they keep", "train");
  PetscCall(ProblemOption(PetscOptionsObject, PROBLEM_CLASSICAL, &o->problem, &o->family));
  PetscCall(OptionsNumbers(PetscOptionsObject, PETSC_STATIC_ARRAY_LENGTH(row), row));
  PetscCall(PetscOptionsString("-train_controllers", "Types, and filters of pi and dsp, with commas between", NULL,
                               o->controllers, o->controllers, sizeof(o->controllers), NULL));
  PetscCall(PetscOptionsString("-train_output", "File to write (HDF5), for -fault_tolerances", NULL, o->output,
                               o->output, sizeof(o->output), NULL));
  PetscOptionsEnd();
  PetscCallMPI(MPI_Comm_size(comm, &size));
  PetscCheck(size == 1, comm, PETSC_ERR_ARG_WRONG, "-train_algorithm tolerances runs on %d processes, expected one",
             size);
  PetscCall(TrainCheckFiles(comm, o->output, "", ""));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* What is written: [controllers][accuracies]; rtol 0: the controller keeps this accuracy at none */
typedef struct {
  PetscReal rtol[LADDER_MAX_CONTROLLERS * ACCURACIES], kept[LADDER_MAX_CONTROLLERS * ACCURACIES],
    solves[LADDER_MAX_CONTROLLERS * ACCURACIES];
} Table;

/* Solves and kept share are measured at the tolerance itself, which is between two of the ladder's, and tightened until
   it holds. */
static PetscErrorCode Calibrate(const Options *o, Ladder *l, PetscInt c, Table *t)
{
  PetscReal worst[LADDER_RUNGS];

  PetscFunctionBegin;
  LadderWorst(l, c, o->within, worst);
  for (PetscInt a = 0, i = c * ACCURACIES; a < ACCURACIES; a++, i++) {
    LadderScore score = {.kept = (PetscReal)NAN, .solves = (PetscReal)NAN};
    PetscReal rtol = LadderLoosest(worst, Accuracies[a]);

    if (a) rtol = PetscMin(rtol, t->rtol[i - 1]); /* a finer accuracy needs no looser one */
    if (rtol > 0) PetscCall(LadderScoreSetting(l, l->controller[c], rtol, Accuracies[a], &score));
    for (PetscInt k = 0; k < MOST_SHRINKS && rtol > 0 && score.kept < o->within; k++) {
      rtol *= (PetscReal)SHRINK;
      PetscCall(LadderScoreSetting(l, l->controller[c], rtol, Accuracies[a], &score));
    }
    t->rtol[i] = PetscMax(rtol, 0);
    t->kept[i] = score.kept;
    t->solves[i] = score.solves;
    if (rtol <= 0)
      PetscCall(PetscPrintf(PETSC_COMM_SELF, "%-18s  %8.0e  none\n", l->controller[c], (double)Accuracies[a]));
    else
      PetscCall(PetscPrintf(PETSC_COMM_SELF, "%-18s  %8.0e  %9.3g  %5.1f %%  %9.2e  %8.1f\n", l->controller[c],
                            (double)Accuracies[a], (double)rtol, 100 * (double)score.kept, (double)score.median,
                            (double)score.solves));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A group /KIND/runs: rtol [rungs]; error and solves [controllers][episodes][rungs], 0 where no run was needed */
static PetscErrorCode WriteRuns(const Ladder *l, const char kind[], SlipH5 *h)
{
  const PetscInt dims[3] = {l->ncontrollers, l->n, LADDER_RUNGS}, rungs[1] = {LADDER_RUNGS};
  PetscReal *error, *solves, rtol[LADDER_RUNGS];
  char path[3][128];
  PetscInt i = 0;

  PetscFunctionBegin;
  PetscCall(
    PetscMalloc2(l->ncontrollers * l->n * LADDER_RUNGS, &error, l->ncontrollers * l->n * LADDER_RUNGS, &solves));
  for (PetscInt c = 0; c < l->ncontrollers; c++)
    for (PetscInt e = 0; e < l->n; e++)
      for (PetscInt k = 0; k < LADDER_RUNGS; k++, i++) {
        const LadderRun *run = l->run + (e * l->ncontrollers + c) * LADDER_RUNGS + k;

        error[i] = run->error;
        solves[i] = (PetscReal)run->solves;
      }
  for (PetscInt k = 0; k < LADDER_RUNGS; k++) rtol[k] = LadderTolerance(k);
  PetscCall(PetscSNPrintf(path[0], sizeof(path[0]), "/%s/runs/rtol", kind));
  PetscCall(PetscSNPrintf(path[1], sizeof(path[1]), "/%s/runs/error", kind));
  PetscCall(PetscSNPrintf(path[2], sizeof(path[2]), "/%s/runs/solves", kind));
  PetscCall(SlipH5WriteReal(h, path[0], 1, rungs, rtol, NULL));
  PetscCall(SlipH5WriteReal(h, path[1], 3, dims, error, NULL));
  PetscCall(SlipH5WriteReal(h, path[2], 3, dims, solves, NULL));
  PetscCall(PetscFree2(error, solves));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The format of training/policies/README.md */
static PetscErrorCode Write(const Options *o, const Ladder *l, const Table *t)
{
  const char *kind = strcmp(o->problem->name, "fault_dial") ? o->problem->name : "event";
  const PetscInt dims[2] = {l->ncontrollers, ACCURACIES}, accuracies[1] = {ACCURACIES};
  const struct {
    const char *name;
    const PetscReal *value;
  } table[] = {{"rtol", t->rtol}, {"kept", t->kept}, {"solves", t->solves}};
  const time_t now = time(NULL);
  const struct tm *utc = gmtime(&now);
  char path[128], created[32] = "", *options, command[4096];
  SlipH5 h;

  PetscFunctionBegin;
  PetscCall(SlipH5Create(o->output, &h));
  PetscCall(SlipH5WriteAttrString(&h, "/", "format", "slipstep-tolerances"));
  PetscCall(SlipH5WriteAttrInt(&h, "/", "version", 2));
  PetscCall(PetscSNPrintf(path, sizeof(path), "/%s/accuracy", kind));
  PetscCall(SlipH5WriteReal(&h, path, 1, accuracies, Accuracies, NULL));
  PetscCall(PetscSNPrintf(path, sizeof(path), "/%s/controllers", kind));
  PetscCall(SlipH5WriteStrings(&h, path, l->ncontrollers, (const char *const *)l->controller));
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(table); i++) {
    PetscCall(PetscSNPrintf(path, sizeof(path), "/%s/%s", kind, table[i].name));
    PetscCall(SlipH5WriteReal(&h, path, 2, dims, table[i].value, NULL));
  }
  /* what made the numbers */
  if (utc) strftime(created, sizeof(created), "%Y-%m-%dT%H:%M:%SZ", utc);
  PetscCall(PetscOptionsGetAll(NULL, &options));
  PetscCall(PetscSNPrintf(command, sizeof(command), "train %s", options));
  PetscCall(PetscFree(options));
  PetscCall(PetscSNPrintf(path, sizeof(path), "/%s", kind));
  PetscCall(SlipH5WriteAttrString(&h, path, "command", command));
  PetscCall(SlipH5WriteAttrString(&h, path, "library_version", SLIPSTEP_VERSION));
  PetscCall(SlipH5WriteAttrString(&h, path, "created", created));
  PetscCall(SlipH5WriteAttrString(&h, path, "problem", o->problem->name));
  PetscCall(SlipH5WriteAttrString(&h, path, "family", o->family ? o->family->file : "the problem's own draws"));
  PetscCall(SlipH5WriteAttrInt(&h, path, "episodes", o->n));
  PetscCall(SlipH5WriteAttrInt(&h, path, "seed", o->seed));
  PetscCall(SlipH5WriteAttrReal(&h, path, "within", o->within));
  PetscCall(WriteRuns(l, kind, &h));
  PetscCall(SlipH5Close(&h));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TolerancesRun(MPI_Comm comm, PetscInt *failed)
{
  PetscBool only_help, cut;
  Options o;
  Ladder l;
  Table t;

  PetscFunctionBegin;
  (void)failed;
  PetscCall(OptionsSet(comm, &o));
  PetscCall(PetscOptionsHasHelp(NULL, &only_help));
  if (only_help) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(LadderCreate(o.problem, o.family, o.seed, o.problem->cma->stream + 3, 0, o.n, o.controllers, &l));
  for (PetscInt e = 0; e < l.n; e++) {
    for (PetscInt c = 0; c < l.ncontrollers; c++)
      PetscCall(LadderClimb(&l, e, c, (PetscReal)SMALL * Accuracies[ACCURACIES - 1], 0, &cut));
    PetscCall(PetscFPrintf(comm, PETSC_STDERR, "%" PetscInt_FMT " of %" PetscInt_FMT " episodes\n", e + 1, l.n));
  }
  PetscCall(PetscPrintf(comm, "controller          accuracy   -ts_rtol     kept     median    solves\n"));
  for (PetscInt c = 0; c < l.ncontrollers; c++) PetscCall(Calibrate(&o, &l, c, &t));
  if (o.output[0]) PetscCall(Write(&o, &l, &t));
  PetscCall(LadderDestroy(&l));
  PetscCall(PetscFree(o.family));
  PetscFunctionReturn(PETSC_SUCCESS);
}
