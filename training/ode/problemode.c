/* Random equations as a problem for CMA-ES: the general policy, a small network that begins as a digital filter. */
#include "ode.h"
#include "environment/cmaproblem.h"
#include <slipcompat.h>
#include <math.h>

#define NEAR_LINEAR 0.3 /* slope of the tanh unit that is the filter at first */
#define RATIO_MAX 10    /* of steps, as basic's limits */

/* What is observed, its scaling for the network, and the filter at the start: a PI controller whose exponents are those
   of Hairer and Wanner (II, p. 31), 0.7 and -0.4 times q: 0.3 of the error's step and 0.4 of its change. */
static const CMARow Rows[] = {{"log_error_step", 3, 0, 0.3}, {"change_log_error_step", 3, 0, 0.4},
                              {"log_step_ratio", 3, 0, 0},   {"change_log_step_ratio", 3, 0, 0},
                              {"rejected", 1, 0, -0.1},      {"rejections", 3, 0, 0},
                              {"order", 0.25, 0, 0}};
enum { ROWS = PETSC_STATIC_ARRAY_LENGTH(Rows) };
#define FILTER_BIAS (-0.03) /* log10 of the safety factor */

static PetscErrorCode SetUp(CMAOptions *o)
{
  PetscFunctionBegin;
  *o = (CMAOptions){.problem = o->problem,
                    .hidden = 8,
                    .layers = 1,
                    .activation = SLIP_ACTIVATION_TANH,
                    .nsingle = 480,
                    .batch_single = 128,
                    .validation = 240,
                    .population = 20,
                    .diagonal = 40,
                    .generations = 240,
                    .interval = 20,
                    .sigma = 0.06};
  PetscCall(CMARowsSet(o, ROWS, Rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void Start(const CMAOptions *o, double w[])
{
  double *bias = w + ROWS * o->hidden;

  for (PetscInt i = 0; i < ROWS; ++i) w[i] = NEAR_LINEAR * Rows[i].start / Rows[i].scale;
  bias[0] = NEAR_LINEAR * FILTER_BIAS;
  bias[o->hidden] = 1 / NEAR_LINEAR;
}

static PetscErrorCode Policy(const CMAOptions *o, const double w[], SlipPolicy policy)
{
  (void)o, (void)w;
  return SlipPolicySetAction(policy, -1, 1, (PetscReal)1 / RATIO_MAX, "h", RATIO_MAX, "h", PETSC_TRUE);
}

static PetscErrorCode Create(const CMAOptions *o, uint64_t seed, PetscInt side, void **episode)
{
  OdeEpisode *e;

  PetscFunctionBegin;
  (void)o, (void)side;
  PetscCall(PetscNew(&e));
  PetscCall(OdeEpisodeCreate(seed, e));
  *episode = e;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Destroy(void **episode)
{
  PetscFunctionBegin;
  PetscCall(OdeEpisodeDestroy((OdeEpisode *)*episode));
  PetscCall(PetscFree(*episode));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Run(void *episode, SlipPolicy policy, PetscReal accuracy, EpisodeResult *result)
{
  const OdeEpisode *e = (const OdeEpisode *)episode;
  OdeResult r;

  PetscFunctionBegin;
  (void)accuracy;
  PetscCall(OdeEpisodeRun(e, policy, e->tol, &r));
  *result = (EpisodeResult){.solves = r.work,
                            .attempts = r.steps + r.rejected,
                            .failures = r.rejected,
                            .error = r.error,
                            .done = r.done ? 1 : 0,
                            .cost = OdeEpisodeCost(e, &r)};
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Say(const CMAScore *score, char text[], size_t len)
{
  PetscFunctionBegin;
  PetscCall(PetscSNPrintf(text, len, "work at equal error %6.4f of basic's  rejected %4.1f %%",
                          (double)PetscExpReal(score->cost), 100 * (double)score->failures));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static const CMAProblem CMAOde = {.episodes = "equations",
                                  .seed = RandomStreamHashed,
                                  .stream = 0,
                                  .start_counts = PETSC_TRUE,
                                  .setup = SetUp,
                                  .start = Start,
                                  .policy = Policy,
                                  .create = Create,
                                  .destroy = Destroy,
                                  .run = Run,
                                  .say = Say};

const Problem ProblemOde = {
  .name = "ode", .meaning = "random equations: the general policy, for any TS", .cma = &CMAOde};
