/* Ruptures of small faults from a given stress, which begin in a patch (train -train_algorithm cmaes -train_problem
   rupture): the problem of training/policies/rupture.h5, whose network begins as a digital filter. */
#include "runs.h"
#include "common/files.h"
#include <slipcompat.h>
#include <math.h>

#define RESIDUAL 0.5  /* friction after all weakening */
#define FULL 0.98     /* the stress outside of the patch is at most this share of the strength */
#define UNSTABLE 1.01 /* and this one in it */
#define COARSE_RTOL 1e-2
#define LEAST_BROKEN 0.1 /* share of the cells that a rupture breaks, not to be drawn again */
#define LONGEST 400      /* of the coarse run [T*] */
#define COARSE_STEPS 4000
#define MOST_ATTEMPTS 40000 /* of a reference and of classical controllers */

static const PetscInt Meshes[][2] = {{12, 6}, {16, 6}, {10, 10}, {16, 8}, {24, 4}, {20, 6}};

/* Some begin with inertia, of these some with viscosity by the square root. */
static PetscErrorCode DrawRupture(RunEpisode *e, Random *random)
{
  const PetscInt *mesh = Meshes[RandomIndex(random, PETSC_STATIC_ARRAY_LENGTH(Meshes))];
  const PetscInt nx = e->larger * mesh[0], nz = e->larger * mesh[1], n = nx * nz;
  const double kind = RandomUniform(random), side = RandomLog(random, 100, 1000),
               normal = RandomLog(random, 15e6, 100e6); /* [m], [Pa] */
  RunWeakening w;
  double share, patch[3], thickness; /* of the drop; x, z, radius [cells]; [m] */
  PetscReal *drop, *stress;

  PetscFunctionBegin;
  w.drop = RandomLog(random, 0.05, 0.3);
  w.weakening = RandomLog(random, 0.2, 0.8);
  w.scatter = 0.3 * RandomUniform(random);
  w.length = RandomLog(random, 2, 8);
  share = 0.45 + 0.3 * RandomUniform(random);
  patch[2] = (1.2 + 1.3 * RandomUniform(random)) * 0.58 / (RUN_CELL_STIFFNESS * w.weakening) + 0.8;
  patch[0] = RandomUniform(random) * (double)nx;
  patch[1] = RandomUniform(random) * (double)nz;
  thickness = RandomLog(random, 0.3, 1) * side * (double)PetscMax(nx, nz);
  const RunOption rows[] = {{"thickness", thickness, NULL},
                            {"friction_residual", RESIDUAL, NULL},
                            {"initial", 0, "traction"},
                            {"initial_unstable", 0, "yes"},
                            {"inertia", 0, kind < 0.3 ? "yes" : "no"},
                            {"viscosity", 0, kind < 0.1 ? "sqrtm" : "radiation"}};

  PetscCall(RunNewFault(e, nx, nz, side, normal));
  PetscCall(RunSetOptions(e->fault, PETSC_STATIC_ARRAY_LENGTH(rows), rows));
  PetscCall(PetscMalloc2(n, &drop, n, &stress));
  PetscCall(RunDrawWeakening(random, &w, nx, nz, side, normal, e->fault, drop, stress));
  for (PetscInt i = 0; i < n; i++) {
    const double x = (double)(i % nx) + 0.5 - patch[0], z = (double)(i / nx) + 0.5 - patch[1],
                 strength = (RESIDUAL + (double)drop[i]) * normal;

    stress[i] = (PetscReal)(normal * (RESIDUAL + share * (1 + w.scatter * (double)stress[i]) * (double)drop[i]));
    stress[i] = PetscMin(stress[i], (PetscReal)(FULL * strength));
    if (hypot(x, z) < patch[2]) stress[i] = (PetscReal)(UNSTABLE * strength);
  }
  PetscCall(SlipFaultSetField(e->fault, "initial_traction", n, stress));
  PetscCall(PetscFree2(drop, stress));
  PetscCall(SlipFaultSetUp(e->fault));
  e->margin = (PetscReal)(1 + 2 * RandomUniform(random) * RandomUniform(random));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- runs ---- */

/* The largest of all, by the measure of histories, and of the times at which cells break */
static PetscErrorCode Compare(const RunEpisode *e, const RunResult *r, PetscReal errors[], PetscReal *error)
{
  PetscFunctionBegin;
  SlipCourseCompare(r->course.n, CourseNodes(&r->course), e->reference.course.n, CourseNodes(&e->reference.course),
                    errors);
  errors[SLIP_ERROR_FIELD] = RunFieldError(e->n, r->slip, 1, e->reference.slip);
  *error = PetscMax(SlipMeasureOf(&SlipMeasures[0], errors), RunPassedError(e, r, e->span));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The coarse run does not end where the rupture has faded, after 3 to 15 T* mostly, so that episodes are far longer
   than their ruptures: rupture.h5 was trained and measured on these. One that takes too many steps is judged by those
   that it took. A cell breaks at its d_c. The span is the rise of the reference from 10 to 90 % of its slip. */
static PetscErrorCode Judge(RunEpisode *e, PetscBool *good)
{
  RunRequest coarse = {NULL, TSADAPTPI, COARSE_RTOL, .most = COARSE_STEPS};
  RunRequest tight = {NULL, TSADAPTPI, RUN_RUPTURE_RTOL, .most = MOST_ATTEMPTS};
  PetscReal tstar;
  PetscInt broken = 0;
  RunResult r, *reference = &e->reference;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(e->n, &e->level));
  PetscCall(SlipFaultGetField(e->fault, "friction_slip", e->n, e->level));
  PetscCall(SlipFaultGetTimeScale(e->fault, &tstar));
  coarse.end = LONGEST * tstar;
  PetscCall(RunIntegrate(e, &coarse, &r));
  for (PetscInt i = 0; i < e->n; i++) broken += r.passed[i] >= 0 ? 1 : 0;
  tight.end = e->end = CourseNodes(&r.course)[r.course.n - 1].time * e->margin;
  e->usual = r.solves;
  e->work = r.work;
  *good = (r.good || r.course.n > COARSE_STEPS) && (PetscReal)broken >= LEAST_BROKEN * (PetscReal)e->n ? PETSC_TRUE
                                                                                                       : PETSC_FALSE;
  PetscCall(RunResultDestroy(&r));
  if (!*good) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(RunIntegrate(e, &tight, reference));
  *good = reference->good;
  if (*good)
    e->span = SlipCourseTime(reference->course.n, CourseNodes(&reference->course), (PetscReal)0.9) -
              SlipCourseTime(reference->course.n, CourseNodes(&reference->course), (PetscReal)0.1);
  PetscFunctionReturn(PETSC_SUCCESS);
}

const RunKind RunRupture = {.size = sizeof(RunEpisode),
                            .column = 2,
                            .slips = 1,
                            .type = TSBATHE,
                            .draw = DrawRupture,
                            .judge = Judge,
                            .compare = Compare,
                            .most = MOST_ATTEMPTS,
                            .expected =
                              "ruptures: expected one whose slip passes friction_slip in a tenth of the cells, "
                              "and then fades within 400 T*",
                            .lost = 6,
                            .free = 0.8,
                            .steep = 2,
                            .worst = 50};

/* ---- the problem for CMA-ES: a network whose step is a ratio to the last one, with a tolerance and a first step that
   follow the dial ---- */

/* The unit that is PI42, h_new = h E_n^(-0.6 q) E_(n-1)^(0.2 q), about estimates of 0.2: few attempts are rejected for
   E > 1 */
#define PROPORTIONAL 0.4
#define CHANGE 0.2
#define TARGET (-0.093) /* 0.4 log10(0.2^(1/3)) */
#define RTOL_START 0.5  /* tolerance at the dial 1e-2 */
#define RTOL_POWER 1.5
#define FIRST_START 0.03 /* first step at that dial [T*] */
#define FIRST_POWER 0.4
#define CEILING 3    /* cells that break give estimates beyond 1 without harm */
#define SHARE_2 0.3  /* of the faults that are twice as large along either side */
#define SHARE_3 0.04 /* and three times */
#define LITTLE 2     /* d_c: where the broken cells slip less in the mean, */
#define KEPT 0.5     /* this share of the faults is kept */

static const CMARow Rows[] = {{SLIP_OBSERVES_ACCURACY, 1, 2, 0},
                              {"log_error_step", 1, 0, PROPORTIONAL},
                              {"log_step_ratio", 1, 0, 0},
                              {"rejected", 1, 0, 0},
                              {"sliding_fraction", 1, 0, 0},
                              {"change_sliding_fraction", 2, 0, 0},
                              {"log_step", 0.3, 0.3, 0},
                              {"log_velocity", 0.3, 0, 0},
                              {"change_log_velocity", 1, 0, 0},
                              {"log_peak_ratio", 1, -0.5, 0},
                              {"growth", 0.3, 0, 0},
                              {"weakening", 1, -0.5, 0},
                              {"change_log_error_step", 1, 0, CHANGE}};
enum {
  ROWS = PETSC_STATIC_ARRAY_LENGTH(Rows),
  UNITS = 4,
  NUMBERS = 4
};                                             /* those: of the tolerance, of the first step */
static const PetscReal Dial[2] = {2e-3, 1e-1}; /* of the training, and of the file */
#define UNIT 1e-2                              /* the dial at which the numbers are said */
#define RATIO_MAX 10                           /* of steps, as basic's limits */
#define NUMBER_SCALE 4                         /* of the numbers: they may move so much faster than weights */
#define LINEAR 0.4                             /* slope of the unit that is the controller at the start */
#define DRAWN 0.3                              /* standard deviation of the other units' weights */

static PetscErrorCode SetUp(CMAOptions *o)
{
  PetscFunctionBegin;
  *o = (CMAOptions){.problem = o->problem,
                    .family = o->family,
                    .hidden = UNITS,
                    .layers = 1,
                    .activation = SLIP_ACTIVATION_TANH,
                    .more = NUMBERS,
                    .nsingle = 56,
                    .batch_single = 12,
                    .validation = 8,
                    .calibration = 24,
                    .side = 2, /* there are no meshes, and no generations that are late, but options of these */
                    .late_single = 1,
                    .diagonal = 40,
                    .generations = 140,
                    .interval = 5,
                    .sigma = 0.1,
                    .within = (PetscReal)0.95,
                    .low = Dial[0],
                    .high = Dial[1]};
  PetscCall(CMARowsSet(o, ROWS, Rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* PI42 in one unit; weights of the others are drawn, and nothing reads them */
static void Start(const CMAOptions *o, double w[])
{
  const PetscInt n = o->nobs, units = o->hidden;
  double *bias = w + n * units, *out = bias + units, *number = w + CMACount(o) - NUMBERS;
  Random random;

  RandomSeed(&random, (uint64_t)o->seed);
  for (PetscInt i = 0; i < (n + 1) * units; ++i) w[i] = DRAWN * RandomNormal(&random);
  for (PetscInt i = 0; i < n; ++i) w[i] = 0;
  for (PetscInt i = 0; i < ROWS; ++i) {
    const PetscInt k = CMAFind(o, Rows[i].name); /* -train_observations may have others */

    if (k >= 0) w[k] = LINEAR * Rows[i].start;
  }
  bias[0] = LINEAR * TARGET;
  out[0] = 1 / LINEAR;
  number[0] = log(RTOL_START) / NUMBER_SCALE;
  number[1] = RTOL_POWER / NUMBER_SCALE;
  number[2] = log(FIRST_START) / NUMBER_SCALE;
  number[3] = FIRST_POWER / NUMBER_SCALE;
}

/* Two numbers as attributes factor and power: factor a^power with the dial at a */
static PetscErrorCode SetDialNumber(const double number[2], const char factor[], const char power[], SlipPolicy policy)
{
  const double exponent = NUMBER_SCALE * number[1];

  PetscFunctionBegin;
  PetscCall(PolicySetNumber(policy, factor, "%.6g", exp(NUMBER_SCALE * number[0]) * pow(UNIT, -exponent)));
  PetscCall(PolicySetNumber(policy, power, "%.6g", exponent));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Policy(const CMAOptions *o, const double w[], SlipPolicy policy)
{
  const double *number = w + CMACount(o) - NUMBERS;
  const PetscInt dial = CMAFind(o, SLIP_OBSERVES_ACCURACY);
  PetscReal low[CMA_MAX_OBS], high[CMA_MAX_OBS]; /* of the dial; others have no range that a run could leave */

  PetscFunctionBegin;
  PetscCall(SlipPolicySetAction(policy, -1, 1, (PetscReal)1 / RATIO_MAX, "h", RATIO_MAX, "h", PETSC_TRUE));
  for (PetscInt i = 0; i < o->nobs; ++i) {
    low[i] = i == dial ? PetscLog10Real(Dial[0]) : -1000;
    high[i] = i == dial ? PetscLog10Real(Dial[1]) : 1000;
  }
  PetscCall(SlipPolicySetRange(policy, low, high));
  PetscCall(SetDialNumber(number, SLIP_POLICY_RTOL_FACTOR, SLIP_POLICY_RTOL_POWER, policy));
  PetscCall(SetDialNumber(number + 2, SLIP_POLICY_FIRST_STEP_FACTOR, SLIP_POLICY_FIRST_STEP_POWER, policy));
  PetscCall(PolicySetNumber(policy, SLIP_POLICY_HOLD, "%.6g", 0));
  PetscCall(PolicySetNumber(policy, SLIP_POLICY_CEILING, "%.6g", CEILING));
  /* as of the file: by it runs with inertia take explicit steps */
  PetscCall(SlipPolicySetAttribute(policy, "problem", o->problem->name));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Say(const CMAScore *score, char text[], size_t len)
{
  PetscFunctionBegin;
  PetscCall(PetscSNPrintf(text, len, "cost %7.4f  dial kept %3.0f %%  solves %6.1f  error/dial %6.3f",
                          (double)score->cost, 100 * (double)score->within, (double)score->solves,
                          (double)score->error));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Some faults larger, as fronts run farther there; and fewer of those that hardly slip, of which every third would be
   one */
static PetscErrorCode Create(const CMAOptions *o, uint64_t seed, PetscInt side, void **episode)
{
  PetscBool kept = PETSC_FALSE;
  RunEpisode *e;
  Random random;

  PetscFunctionBegin;
  if (o->family) {
    PetscCall(RunsCreate(o, seed, side, episode));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  RandomSeed(&random, seed);
  while (!kept) {
    const double size = RandomUniform(&random);
    const PetscInt larger = size < SHARE_3 ? 3 : size < SHARE_3 + SHARE_2 ? 2 : 1;
    PetscReal slip = 0; /* of the cells that break [d_c] */
    PetscInt broken = 0;

    PetscCall(RunEpisodeCreate(&RunRupture, NULL, larger, random.s[0], &e));
    for (PetscInt i = 0; i < e->n; ++i)
      if (e->reference.passed[i] >= 0) {
        slip += e->reference.slip[i] / e->level[i];
        broken++;
      }
    kept = slip / (PetscReal)PetscMax(broken, 1) >= LITTLE || RandomUniform(&random) < KEPT ? PETSC_TRUE : PETSC_FALSE;
    if (!kept) PetscCall(RunEpisodeDestroy(&e));
  }
  *episode = e;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static const CMAProblem CMARuptures = {
  RUNS,           .episodes = "faults", .stream = 7,      .dial = CMA_DIAL_SPREAD, .runs = &RunRupture,
  .setup = SetUp, .start = Start,       .policy = Policy, .create = Create,        .classical = RunsClassical,
  .say = Say};

const Problem ProblemRupture = {
  .name = "rupture", .meaning = "ruptures of small faults from a given stress", .cma = &CMARuptures};
