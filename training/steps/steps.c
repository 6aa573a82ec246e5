/* See steps.h: options, searches, table and file. CMA-ES on the logarithms of the steps; the landscape is rough, so
   several searches begin at other places. */
#include "steps.h"
#include "cmaes/cmaes.h"
#include "common/files.h"
#include "common/options.h"
#include "problems/episodes.h"
#include "runs/runs.h"
#include <slipcompat.h>
#include <math.h>

#define MAX_TIME 30    /* [s], the program fault's */
#define DRAW_SEED 77   /* of ruptures that are drawn for benchmarks */
#define FAILED 10      /* error of steps that fail or do not get to the end */
#define SIGMA 0.25     /* of ln(step) */
#define SPREAD 0.5     /* of starts that are drawn */
#define NOISE 0.1      /* of those that follow a reference */
#define REST_TAIL 1.05 /* a start's steps end a little after the reference rests */

typedef struct {
  PetscInt least, most; /* solves, the one to the end included */
  PetscInt generations, restarts, population, seed;
  PetscInt stride;  /* from one number of solves to the next */
  PetscInt draw[2]; /* of a drawn rupture: stream and number */
  PetscBool drawn;
  char output[PETSC_MAX_PATH_LEN];
} StepsOptions;

/* The fault whose steps are looked for: from its instability, on plain arrays, or under a given stress, by the
   library */
typedef struct {
  Episode *event;
  RunEpisode *rupture;
  PetscReal end; /* [s] */
} Target;

/* What was found for one number of solves. */
typedef struct {
  PetscInt n;       /* steps besides the one to the end */
  PetscReal error;  /* by the measure of the episode */
  double *log_step; /* [n] ln(step/s) */
} StepsPlan;

/* ---- searches ---- */

/* One search: the best steps so far */
typedef struct {
  const Target *target;
  PetscInt n;
  double *best, error; /* [n] */
} Search;

/* CMAESFn: the error of the steps exp(x) */
static PetscErrorCode Error(const double x[], void *ctx, double *error)
{
  Search *s = (Search *)ctx;
  double dt[EPISODE_MAX_STEPS];
  EpisodeResult r;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < s->n; ++i) dt[i] = exp(x[i]);
  if (s->target->rupture) {
    PetscCall(RuptureRunSteps(s->target->rupture, s->n, dt, &r.error));
    *error = r.error < 0 ? FAILED : r.error;
  } else {
    PetscCall(EpisodeRunSteps(s->target->event, s->n, dt, &r));
    *error = r.done < 1 || isnan(r.error) ? FAILED * (2 - r.done) : r.error;
  }
  if (*error >= s->error) PetscFunctionReturn(PETSC_SUCCESS);
  s->error = *error;
  PetscCall(PetscArraycpy(s->best, x, s->n));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Where shares of the steps of a rupture's reference lie: its controller put them where they are needed. */
static void StartAsReference(const RunEpisode *e, Random *random, PetscInt n, double x[])
{
  const SlipCourseNode *node = (const SlipCourseNode *)e->reference.course.data;
  const PetscInt steps = e->reference.course.n - 1;
  PetscReal before = 0;

  for (PetscInt i = 0; i < n; ++i) {
    const PetscReal at = (PetscReal)steps * (PetscReal)(i + 1) / (PetscReal)(n + 1);
    const PetscInt k = PetscMin((PetscInt)at, steps - 1);
    const PetscReal t = node[k].time + (at - (PetscReal)k) * (node[k + 1].time - node[k].time);

    x[i] = log(PetscMax((double)(t - before), 1e-12 * (double)e->end)) + NOISE * RandomNormal(random);
    before = t;
  }
}

/* The plan for one step less, one of whose steps is halved, and noise; or steps drawn about equal ones */
static void Start(const Target *target, const StepsPlan *fewer, PetscInt k, Random *random, PetscInt n, double x[])
{
  const PetscReal span = REST_TAIL * (target->event && target->event->rest > 0 ? target->event->rest : target->end);

  if (target->rupture && (k % 2 || !fewer || fewer->n != n - 1)) {
    StartAsReference(target->rupture, random, n, x);
  } else if (fewer && fewer->n == n - 1 && n > 1 && k % 2 == 0) {
    const PetscInt halved = (PetscInt)RandomIndex(random, (uint64_t)fewer->n);

    for (PetscInt i = 0; i < n; ++i) x[i] = fewer->log_step[i > halved ? i - 1 : i];
    x[halved] -= log(2);
    x[halved + 1] -= log(2);
  } else {
    for (PetscInt i = 0; i < n; ++i) x[i] = log((double)span / (double)n) + SPREAD * RandomNormal(random);
  }
}

static PetscErrorCode SearchOnce(const StepsOptions *o, const Target *e, const StepsPlan *fewer, PetscInt k, PetscInt n,
                                 double best[], double *error)
{
  Search search = {e, n, best, PETSC_MAX_REAL};
  double *start;
  Random random;
  CMAES es;

  PetscFunctionBegin;
  RandomSeed(&random, ((uint64_t)o->seed << 32) + ((uint64_t)n << 16) + (uint64_t)k);
  PetscCall(PetscMalloc1(n, &start));
  Start(e, fewer, k, &random, n, start);
  PetscCall(CMAESCreate(n, o->population, start, SIGMA, &es));
  PetscCall(PetscFree(start));
  for (PetscInt g = 0; g < o->generations; ++g)
    PetscCall(CMAESGeneration(&es, PETSC_COMM_SELF, &random, Error, &search, NULL, NULL));
  *error = search.error;
  PetscCall(CMAESDestroy(&es));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The best of some searches, started from the plan for one step less (NULL: none) and from steps drawn about equal
   ones; ranks share the searches, and all get the answer, the same on any number of them. plan->log_step is the
   caller's. */
static PetscErrorCode SearchAll(MPI_Comm comm, const StepsOptions *o, const Target *e, const StepsPlan *fewer,
                                StepsPlan *plan)
{
  const PetscInt n = plan->n;
  double *x, *error;
  PetscInt best = 0;
  PetscMPIInt rank, size;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCallMPI(MPI_Comm_size(comm, &size));
  PetscCall(PetscCalloc2(n * o->restarts, &x, o->restarts, &error));
  for (PetscInt k = rank; k < o->restarts; k += size) PetscCall(SearchOnce(o, e, fewer, k, n, x + k * n, &error[k]));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, x, (PetscMPIInt)(n * o->restarts), MPI_DOUBLE, MPI_SUM, comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, error, (PetscMPIInt)o->restarts, MPI_DOUBLE, MPI_SUM, comm));
  for (PetscInt k = 1; k < o->restarts; ++k)
    if (error[k] < error[best]) best = k;
  plan->error = error[best];
  PetscCall(PetscArraycpy(plan->log_step, x + best * n, n));
  PetscCall(PetscFree2(x, error));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the whole ---- */

static PetscErrorCode OptionsSet(MPI_Comm comm, StepsOptions *o)
{
  const NumberOption row[] = {
    OPTION_INTEGER("-train_steps_least", "Fewest Bathe solves, the one to the end included", &o->least, 2,
                   EPISODE_MAX_STEPS),
    OPTION_INTEGER("-train_steps_most", "Most Bathe solves", &o->most, 2, EPISODE_MAX_STEPS),
    OPTION_INTEGER("-train_steps_stride", "From one number of solves to the next", &o->stride, 1, EPISODE_MAX_STEPS),
    OPTION_INTEGER("-train_generations", "Generations of a search", &o->generations, 1, 1e8),
    OPTION_INTEGER("-train_restarts", "Searches for each number of solves, the best of which counts", &o->restarts, 1,
                   1000),
    OPTION_INTEGER("-train_population", "Members of a generation, 0: 4 + 3 ln(steps)", &o->population, 0, 10000),
    OPTION_INTEGER("-train_seed", "Seed of everything random", &o->seed, 0, PETSC_MAX_INT)};

  PetscInt two = 2;

  PetscFunctionBegin;
  *o = (StepsOptions){.least = 4, .most = 40, .stride = 1, .generations = 300, .restarts = 8};
  PetscOptionsBegin(comm, NULL, "The best steps of a fault, found by CMA-ES", "train");
  PetscCall(OptionsNumbers(PetscOptionsObject, PETSC_STATIC_ARRAY_LENGTH(row), row));
  PetscCall(
    PetscOptionsString("-train_output", "File to write (HDF5)", NULL, o->output, o->output, sizeof(o->output), NULL));
  PetscCall(SlipCheckIntegerOption(comm, NULL, NULL, "-train_draw"));
  PetscCall(
    PetscOptionsIntArray("-train_draw",
                         "Stream and number of a rupture that is drawn as by -train_problem rupture, by the seed "
                         "77, in place of the fault of the options",
                         NULL, o->draw, &two, &o->drawn));
  PetscOptionsEnd();
  PetscCheck(!o->drawn || (two == 2 && o->draw[0] >= 0 && o->draw[1] >= 0), comm, PETSC_ERR_ARG_WRONG,
             "-train_draw has %" PetscInt_FMT " numbers, expected a stream and a number, both >= 0", two);
  PetscCheck(o->least <= o->most, comm, PETSC_ERR_ARG_OUTOFRANGE,
             "-train_steps_least is %" PetscInt_FMT " and -train_steps_most %" PetscInt_FMT ", expected them in order",
             o->least, o->most);
  PetscCall(TrainCheckFiles(comm, o->output, "", ""));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* /steps [n]: solves; /error [n]; /dt [n][most]: steps [s], NaN behind the last */
static PetscErrorCode Write(const StepsOptions *o, const Target *e, PetscInt n, const StepsPlan plan[])
{
  const PetscInt dims[2] = {n, o->most};
  PetscReal *solves, *error, *dt;
  SlipH5 h;

  PetscFunctionBegin;
  PetscCall(PetscMalloc3(n, &solves, n, &error, n * o->most, &dt));
  for (PetscInt k = 0; k < n; ++k) {
    PetscReal t = 0;

    solves[k] = (PetscReal)(plan[k].n + 1);
    error[k] = plan[k].error;
    for (PetscInt i = 0; i < o->most; ++i) {
      PetscReal *step = &dt[k * o->most + i];

      *step = i < plan[k].n ? PetscMin(PetscExpReal(plan[k].log_step[i]), e->end - t)
                            : (i == plan[k].n ? e->end - t : (PetscReal)NAN);
      if (i <= plan[k].n) t += *step;
    }
  }
  PetscCall(SlipH5Create(o->output, &h));
  PetscCall(SlipH5WriteAttrString(&h, "/", "format", "slipstep-steps"));
  PetscCall(SlipH5WriteAttrInt(&h, "/", "version", 1));
  PetscCall(SlipH5WriteAttrInt(&h, "/", "seed", o->seed));
  PetscCall(SlipH5WriteAttrString(&h, "/", "measure", SlipMeasures[0].name));
  PetscCall(SlipH5WriteReal(&h, "/steps", 1, dims, solves, NULL));
  PetscCall(SlipH5WriteReal(&h, "/error", 1, dims, error, NULL));
  PetscCall(SlipH5WriteReal(&h, "/dt", 2, dims, dt, "s"));
  PetscCall(SlipH5Close(&h));
  PetscCall(PetscFree3(solves, error, dt));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The fault of the -fault_ options, as the program fault makes it, and -ts_max_time */
static PetscErrorCode MakeTarget(MPI_Comm comm, const StepsOptions *o, Target *target)
{
  PetscReal tmax = MAX_TIME, nx, nz;
  PetscBool mesh, rupture;
  SlipFault fault;
  char initial[32];

  PetscFunctionBegin;
  *target = (Target){0};
  if (o->drawn) {
    PetscCall(
      RunEpisodeCreate(&RunRupture, NULL, 1, RandomStreamHashed(DRAW_SEED, o->draw[0], o->draw[1]), &target->rupture));
    target->end = target->rupture->end;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(PetscOptionsGetReal(NULL, NULL, "-ts_max_time", &tmax, NULL));
  PetscCheck(tmax > 0 && !PetscIsInfOrNanReal(tmax), comm, PETSC_ERR_ARG_OUTOFRANGE,
             "-ts_max_time is %.6g, expected a number > 0 s", (double)tmax);
  PetscCall(SlipFaultCreate(PETSC_COMM_SELF, &fault));
  PetscCall(SlipFaultSetReal(fault, "nx", 1));
  PetscCall(SlipFaultSetReal(fault, "nz", 1));
  PetscCall(SlipFaultSetFromOptions(fault));
  target->end = tmax;
  PetscCall(SlipFaultGetString(fault, "initial", initial, sizeof(initial)));
  PetscCall(PetscStrcmp(initial, "traction", &rupture));
  if (rupture) {
    PetscCall(SlipFaultSetUp(fault));
    PetscCall(RuptureOfFault(fault, tmax, &target->rupture));
    PetscCall(SlipFaultDestroy(&fault));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(SlipFaultGetReal(fault, "nx", &nx));
  PetscCall(SlipFaultGetReal(fault, "nz", &nz));
  PetscCall(PetscOptionsHasName(NULL, NULL, "-fault_mesh", &mesh));
  PetscCheck(!mesh && nx * nz <= EPISODE_MAX_CELLS, comm, PETSC_ERR_ARG_OUTOFRANGE,
             "-fault_nx times -fault_nz is %g%s, expected a grid of at most %d cells: its matrices are dense",
             (double)(nx * nz), mesh ? " and there is -fault_mesh" : "", EPISODE_MAX_CELLS);
  PetscCall(EpisodeCreateFault(fault, tmax, &target->event));
  PetscCall(SlipFaultDestroy(&fault));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode StepsRun(MPI_Comm comm, PetscInt *failed)
{
  StepsOptions o;
  StepsPlan *plan;
  Target target;
  PetscMPIInt rank;
  PetscBool only_help;
  PetscInt n;

  PetscFunctionBegin;
  (void)failed;
  PetscCall(OptionsSet(comm, &o));
  PetscCall(PetscOptionsHasHelp(NULL, &only_help));
  if (only_help) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MakeTarget(comm, &o, &target));
  n = (o.most - o.least) / o.stride + 1;
  PetscCall(PetscCalloc1(n, &plan));
  PetscCall(PetscPrintf(comm, "solves  error (%s)\n", SlipMeasures[0].name));
  for (PetscInt k = 0; k < n; ++k) {
    plan[k].n = o.least + k * o.stride - 1;
    PetscCall(PetscMalloc1(plan[k].n, &plan[k].log_step));
    PetscCall(SearchAll(comm, &o, &target, k ? &plan[k - 1] : NULL, &plan[k]));
    PetscCall(PetscPrintf(comm, "%6" PetscInt_FMT "  %.3e\n", plan[k].n + 1, (double)plan[k].error));
  }
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  if (!rank && o.output[0]) PetscCall(Write(&o, &target, n, plan));
  for (PetscInt k = 0; k < n; ++k) PetscCall(PetscFree(plan[k].log_step));
  PetscCall(PetscFree(plan));
  PetscCall(EpisodeDestroy((void **)&target.event));
  PetscCall(RunEpisodeDestroy(&target.rupture));
  PetscFunctionReturn(PETSC_SUCCESS);
}
