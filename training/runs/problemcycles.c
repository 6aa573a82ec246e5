/* Cycles of events as a problem for CMA-ES: a network of three units that begins as the smaller of what the error estimate
   and the stability of explicit steps allow. */
#include "cycles.h"
#include "runs/libraryepisode.h"
#include <slipcompat.h>

enum { UNITS = 3 };
static const PetscReal Dial[2] = {1e-4, 1e-2};    /* range of the training */
static const PetscReal Trusted[2] = {1e-4, 1e-3}; /* and of the file: beyond, coarser faults than these lose events */
static const PetscReal Judged[CMA_DIALS] = {3e-4, 1e-3, 5e-3}; /* of the validation */

/* What is observed, scaled and shifted, and the start: the elementary controller's ratio of steps by the error, and that to
   the longest stable step, which grows with the dial. The scale is also how little a weight counts beside others. */
static const struct {
  const char *name;
  double scale, offset, error, stable;
} Rows[] = {{"log_error_step", 1, 0, 1, 0},   {"change_log_error_step", 1, 0, 0, 0},   {"log_step_ratio", 1, 0, 0, 0},
            {"rejected", 1, 0, 0, 0},         {SLIP_OBSERVES_ACCURACY, 1, 3, 0, 0.12}, {"log_step", 0.1, 0, 0, -1},
            {"log_relaxation", 0.1, 0, 0, -1}};
enum { ROWS = PETSC_STATIC_ARRAY_LENGTH(Rows), WEIGHTS = (ROWS + 2) * UNITS + 1 };
#define ERROR_BIAS (-0.046) /* log10 of the safety factor */
#define STABLE_BIAS 0.48    /* log10 of the step at the dial 1e-3 in units of the relaxation time: 3 */
#define RTOL_START 2e-2     /* tolerance at the dial 1e-3, of the worst cell */
#define RTOL_POWER 1
#define UNIT 1e-3 /* that dial */

static PetscErrorCode SetUp(CMAOptions *o)
{
  const char *names[ROWS + 1] = {NULL};

  PetscFunctionBegin;
  *o = (CMAOptions){.problem = o->problem,
                    .hidden = UNITS,
                    .layers = 1,
                    .activation = SLIP_ACTIVATION_RELU,
                    .more = 2,
                    .nsingle = 16,
                    .batch_single = 6,
                    .validation = 8,
                    .population = 12,
                    .diagonal = 100000000, /* always */
                    .generations = 25,
                    .interval = 5,
                    .sigma = 0.04,
                    .low = Dial[0],
                    .high = Dial[1]};
  for (PetscInt i = 0; i < ROWS; ++i) names[i] = Rows[i].name;
  PetscCall(CMAObservationsSet(o, names));
  for (PetscInt i = 0; i < ROWS; ++i) {
    o->scale[i] = Rows[i].scale;
    o->offset[i] = Rows[i].offset;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* min(e, s) = e - relu(e - s); e itself is relu(e) - relu(-e) */
static void Start(const CMAOptions *o, double w[])
{
  double *bias = w + ROWS * UNITS, *out = bias + UNITS;

  (void)o;
  for (PetscInt i = 0; i < ROWS; ++i) {
    const double e = Rows[i].error / Rows[i].scale, s = Rows[i].stable / Rows[i].scale;

    w[i] = e;
    w[ROWS + i] = -e;
    w[2 * ROWS + i] = e - s;
  }
  bias[0] = ERROR_BIAS;
  bias[1] = -ERROR_BIAS;
  bias[2] = ERROR_BIAS - STABLE_BIAS;
  out[0] = 1;
  out[1] = out[2] = -1;
  CMARatioStart(RTOL_START, RTOL_POWER, w + WEIGHTS);
}

static void Range(const CMAOptions *o, PetscReal low[], PetscReal high[])
{
  CMADialRange(o, Trusted, low, high);
}

static PetscErrorCode Policy(const CMAOptions *o, const double w[], SlipPolicy policy)
{
  return CMARatioPolicy(o, w + WEIGHTS, UNIT, Dial, policy);
}

static PetscErrorCode Create(const CMAOptions *o, uint64_t seed, void *e)
{
  (void)o;
  return CycleEpisodeCreate(seed, (CycleEpisode *)e);
}

static PetscErrorCode Destroy(void *e)
{
  return CycleEpisodeDestroy((CycleEpisode *)e);
}

static PetscErrorCode Run(void *episode, SlipPolicy policy, TSAdaptType type, PetscReal setting, EpisodeResult *result)
{
  CycleEpisode *e = (CycleEpisode *)episode;
  CycleResult r;

  PetscFunctionBegin;
  (void)type;
  PetscCall(CycleEpisodeRun(e, policy, setting, setting, &r));
  result->solves = r.products;
  result->attempts = r.steps + r.rejected;
  result->failures = r.rejected;
  result->error = r.good ? r.error : -1;
  result->usual = (PetscReal)e->usual;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static const LibraryEpisodes Episodes = {sizeof(CycleEpisode), Create,     Destroy, Run, .lost = 4, .free = 1,
                                         .steep = 1,           .worst = 50};

static PetscErrorCode Say(const CMAScore *score, char text[], size_t len)
{
  PetscFunctionBegin;
  PetscCall(PetscSNPrintf(text, len, "cost %7.4f  dial kept %3.0f %%  products %6.4f of basic's", (double)score->cost,
                          100 * (double)score->within, (double)score->over_usual));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static const CMAProblem CMACycles = {LIBRARY_EPISODES, .episodes = "faults", .stream = 3,    .dial = CMA_DIAL_DRAWN,
                                     .judged = Judged, .library = &Episodes, .setup = SetUp, .start = Start,
                                     .policy = Policy, .range = Range,       .say = Say};

const Problem ProblemCycles = {
  .name = "cycles", .meaning = "cycles of events of small rate-and-state faults", .cma = &CMACycles};
