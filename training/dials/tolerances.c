/* See tolerances.h: options, runs, table and file. */
#include "tolerances.h"
#include "ladder.h"
#include "common/files.h"
#include "common/options.h"
#include <slipcompat.h>

static const PetscReal Accuracies[] = {1e-1, 3e-2, 1e-2, 3e-3, 1e-3};
enum { ACCURACIES = PETSC_STATIC_ARRAY_LENGTH(Accuracies) };
#define SMALL 0.5 /* errors below this share of the finest accuracy need no tighter tolerance */

#define SHRINK 0.85
enum { MOST_SHRINKS = 20 };

typedef struct {
  const Problem *problem;
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
  PetscCall(ProblemOption(PetscOptionsObject, PETSC_TRUE, &o->problem));
  PetscCall(OptionsNumbers(PetscOptionsObject, PETSC_STATIC_ARRAY_LENGTH(row), row));
  PetscCall(PetscOptionsString("-train_controllers", "Types, and filters of pi and dsp, with commas between", NULL,
                               o->controllers, o->controllers, sizeof(o->controllers), NULL));
  PetscCall(
    PetscOptionsString("-train_output", "File to write (HDF5)", NULL, o->output, o->output, sizeof(o->output), NULL));
  PetscOptionsEnd();
  PetscCallMPI(MPI_Comm_size(comm, &size));
  PetscCheck(size == 1, comm, PETSC_ERR_ARG_WRONG, "-train_algorithm tolerances runs on %d processes, expected one",
             size);
  PetscCall(TrainCheckFiles(comm, o->output, "", ""));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Solves and kept share are measured at the tolerance itself, which is between two of the ladder's, and tightened until it holds. */
static PetscErrorCode Calibrate(const Options *o, Ladder *l, PetscInt c, PetscReal rtol[ACCURACIES])
{
  PetscReal worst[LADDER_RUNGS];
  LadderScore score;

  PetscFunctionBegin;
  LadderWorst(l, c, o->within, worst);
  for (PetscInt a = 0; a < ACCURACIES; a++) {
    rtol[a] = LadderLoosest(worst, Accuracies[a]);
    if (rtol[a] < 0) {
      PetscCall(PetscPrintf(PETSC_COMM_SELF, "%-18s  %8.0e  none\n", l->controller[c], (double)Accuracies[a]));
      continue;
    }
    PetscCall(LadderScoreSetting(l, l->controller[c], rtol[a], Accuracies[a], &score));
    for (PetscInt k = 0; k < MOST_SHRINKS && score.kept < o->within; k++) {
      rtol[a] *= (PetscReal)SHRINK;
      PetscCall(LadderScoreSetting(l, l->controller[c], rtol[a], Accuracies[a], &score));
    }
    PetscCall(PetscPrintf(PETSC_COMM_SELF, "%-18s  %8.0e  %9.3g  %5.1f %%  %9.2e  %8.1f\n", l->controller[c],
                          (double)Accuracies[a], (double)rtol[a], 100 * (double)score.kept, (double)score.median,
                          (double)score.solves));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* /rtol [rungs]; /error and /solves [controllers][episodes][rungs], 0 where no run was needed; attribute controllers */
static PetscErrorCode Write(const Options *o, const Ladder *l)
{
  const PetscInt dims[3] = {l->ncontrollers, l->n, LADDER_RUNGS}, rungs[1] = {LADDER_RUNGS};
  PetscReal *error, *solves, rtol[LADDER_RUNGS];
  PetscInt i = 0;
  SlipH5 h;

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
  PetscCall(SlipH5Create(o->output, &h));
  PetscCall(SlipH5WriteAttrString(&h, "/", "format", "slipstep-tolerances"));
  PetscCall(SlipH5WriteAttrInt(&h, "/", "version", 1));
  PetscCall(SlipH5WriteAttrInt(&h, "/", "seed", o->seed));
  PetscCall(SlipH5WriteAttrString(&h, "/", "problem", o->problem->name));
  PetscCall(SlipH5WriteAttrString(&h, "/", "controllers", o->controllers));
  PetscCall(SlipH5WriteReal(&h, "/rtol", 1, rungs, rtol, NULL));
  PetscCall(SlipH5WriteReal(&h, "/error", 3, dims, error, NULL));
  PetscCall(SlipH5WriteReal(&h, "/solves", 3, dims, solves, NULL));
  PetscCall(SlipH5Close(&h));
  PetscCall(PetscFree2(error, solves));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TolerancesRun(MPI_Comm comm, PetscInt *failed)
{
  PetscReal rtol[LADDER_MAX_CONTROLLERS][ACCURACIES];
  PetscBool only_help, cut;
  Options o;
  Ladder l;

  PetscFunctionBegin;
  (void)failed;
  PetscCall(OptionsSet(comm, &o));
  PetscCall(PetscOptionsHasHelp(NULL, &only_help));
  if (only_help) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(LadderCreate(o.problem, NULL, o.seed, o.problem->cma->stream + 3, 0, o.n, o.controllers, &l));
  for (PetscInt e = 0; e < l.n; e++) {
    for (PetscInt c = 0; c < l.ncontrollers; c++)
      PetscCall(LadderClimb(&l, e, c, (PetscReal)SMALL * Accuracies[ACCURACIES - 1], 0, &cut));
    PetscCall(PetscFPrintf(comm, PETSC_STDERR, "%" PetscInt_FMT " of %" PetscInt_FMT " episodes\n", e + 1, l.n));
  }
  if (o.output[0]) PetscCall(Write(&o, &l));
  PetscCall(PetscPrintf(comm, "controller          accuracy   -ts_rtol     kept     median    solves\n"));
  for (PetscInt c = 0; c < l.ncontrollers; c++) PetscCall(Calibrate(&o, &l, c, rtol[c]));
  PetscCall(PetscPrintf(comm, "For the table of src/fault/steps.c:\n"));
  for (PetscInt c = 0; c < l.ncontrollers; c++) {
    PetscCall(PetscPrintf(comm, "{\"%s\", {", l.controller[c]));
    for (PetscInt a = 0; a < ACCURACIES; a++)
      PetscCall(PetscPrintf(comm, "%s%.3g", a ? ", " : "", (double)PetscMax(rtol[c][a], 0)));
    PetscCall(PetscPrintf(comm, "}},\n"));
  }
  PetscCall(LadderDestroy(&l));
  PetscFunctionReturn(PETSC_SUCCESS);
}
