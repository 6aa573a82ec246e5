/* Episodes of the trainer: cost, references, and runs that depend on nothing but the episode, the policy and the
   dial. */
#include "policies.h"
#include "problems/episodes.h"
#include <math.h>

/* Constant steps h [T*] that the dial scales: y = atanh(log10 h/2) + slope (log_accuracy + 2). */
static SlipPolicy policy(double h, double slope)
{
  return PolicyOfOne("log_accuracy", slope, atanh(log10(h) / 2) + 2 * slope, 1e2);
}

static void penalty(void **state)
{
  assert_true(EpisodePenalty(0) == 0 && EpisodePenalty(0.5) == 0);
  assert_true(EpisodePenalty(0.75) == 0.25 && EpisodePenalty(1) == 1);
  assert_true(fabs(EpisodePenalty(exp(1)) - 4) < 1e-14);
  assert_true(EpisodePenalty(1e9) == EpisodePenalty(NAN)); /* the worst */
  for (double x = 0; x < 30; x += 0.1) assert_true(EpisodePenalty(x + 0.1) >= EpisodePenalty(x));
}

static void cost(void **state)
{
  const EpisodeResult good = {.solves = 20, .error = 1e-3, .done = 1}, more = {.solves = 40, .error = 1e-3, .done = 1};
  const EpisodeResult off = {.solves = 20, .error = 0.05, .done = 1}, cut = {.solves = 20, .error = 1e-3, .done = 0.9};

  assert_true(fabs(EpisodeCost(&good, 1e-2) - log(21)) < 1e-14); /* nothing but solves well within the dial */
  assert_true(EpisodeCost(&more, 1e-2) > EpisodeCost(&good, 1e-2));
  assert_true(EpisodeCost(&off, 1e-2) >
              EpisodeCost(&more, 1e-2)); /* five times the dial costs more than twice the solves */
  assert_true(EpisodeCost(&off, 1e-1) == EpisodeCost(&good, 1e-1)); /* half of the dial is free */
  assert_true(EpisodeCost(&cut, 1e-2) > EpisodeCost(&more, 1e-2) + 1);
}

/* An episode is its seed; its runs do not see earlier ones. */
static void reproducible(void **state)
{
  SlipPolicy coarse = policy(0.7, 0), fine = policy(0.1, 0.1);
  EpisodeResult r[4];
  Episode *a, *b;

  for (PetscInt side = 1; side <= 3; side += 2) {
    ok(EpisodeCreate(NULL, 77, side, &a));
    ok(EpisodeCreate(NULL, 77, side, &b));
    assert_true(a->slip == b->slip && a->tmax == b->tmax && a->reference.n == b->reference.n && a->reference.n > 10);
    memset(r, 0, sizeof(r)); /* with padding, for comparison */
    ok(EpisodeRun(a, coarse, 1e-2, &r[0]));
    ok(EpisodeRun(a, fine, 1e-3, &r[1]));
    ok(EpisodeRun(b, fine, 1e-3, &r[2]));
    ok(EpisodeRun(b, coarse, 1e-2, &r[3]));
    assert_memory_equal(&r[0], &r[3], sizeof(r[0]));
    assert_memory_equal(&r[1], &r[2], sizeof(r[0]));
    assert_true(r[0].solves > 0 && r[0].done == 1 && r[1].error < 0.3);
    ok(EpisodeDestroy((void **)&a));
    ok(EpisodeDestroy((void **)&b));
  }
  ObjectsDestroy(&coarse, &fine);
}

/* The whole reference against a run by another controller with a tight tolerance. Second order at steps of 1 % of the
   time of growth leaves (0.01)^2/24 of relative error in the growth's exponent, some ten to fifteen at the event: 6e-5;
   a run at rtol 1e-7 of some thousand steps less. The dial goes down to 1e-3, a tenth of which is allowed. */
static PetscErrorCode collect(TS ts, const SlipAttempt *attempt, Vec w, void *ctx)
{
  return attempt->accepted ? EpisodeFollow((Episode *)ctx, attempt->time + attempt->dt, w) : 0;
}

static void reference(void **state)
{
  for (uint64_t seed = 1; seed <= 6; seed++) {
    Episode *e;
    EpisodeResult r;
    TS ts;
    Vec atol;

    ok(EpisodeCreate(NULL, seed, seed > 3 ? 3 : 1, &e));
    ok(EpisodeRewind(e, 1e-2));
    ok(TSCreate(PETSC_COMM_SELF, &ts));
    ok(SlipFaultConfigureTS(e->fault, ts));
    SetAdapt(ts, TSADAPTHEURISTIC);
    ok(TSGetTolerances(ts, NULL, &atol, NULL, NULL));
    ok(VecScale(atol, 1e-4)); /* the growth begins from less than what users can see */
    ok(TSSetTolerances(ts, PETSC_DEFAULT, NULL, 1e-7, NULL));
    ok(TSSetMaxTime(ts, e->tmax));
    ok(TSSetMaxSteps(ts, 100000));
    ok(TSBatheMonitorSet(ts, collect, e, NULL));
    ok(TSSolve(ts, e->w));
    EpisodeConclude(e, 1, 1, &r);
    assert_true(r.done == 1 && r.error < 1e-4);
    ok(TSDestroy(&ts));
    ok(EpisodeDestroy((void **)&e));
  }
}

/* The growth that a single cell's numbers predict is that of its run in a window of the slip: twenty times as far as
   the perturbation alone would carry it, where the decaying root is gone (2/40^2), and below a hundredth of d_c, where
   the weakening has changed by at most 1 % and so the growth by at most 1.5 % (a weakening of 1.5 stiffnesses). */
static void growth(void **state)
{
  int found = 0;

  for (uint64_t seed = 100; found < 4; seed++) {
    Episode *e;
    PetscReal perturbation, first[2] = {0, 0}, last[2] = {0, 0};
    PetscInt k, row = SlipObservationFind("start_growth_rate", &k);

    ok(EpisodeCreate(NULL, seed, 1, &e));
    ok(SlipFaultGetReal(e->fault, "initial_perturbation", &perturbation));
    const SlipFaultNumbers *f = &e->plain.known;
    const double stiffness = f->critical_stiffness, high = 0.01 * f->mean_dc,
                 low = 20 * perturbation * f->mean_uc * stiffness / (f->critical_weakening - stiffness);

    if (low < 0.3 * high) {
      const double g = (*SlipObservations[row].fault)(f), lambda = sqrt(f->critical_stiffness) * g / (1 - g / 2);

      for (k = 0; k < e->reference.n; k++) {
        const SlipCourseNode *node = &CourseNodes(&e->reference)[k];

        if (node->slip < low || node->slip > high) continue;
        if (!first[0]) first[0] = node->time, first[1] = node->rate;
        last[0] = node->time, last[1] = node->rate;
      }
      AssertLess(first[0], last[0]);
      AssertNear(log(last[1] / first[1]) / (last[0] - first[0]) / lambda, 1, 0.03);
      found++;
    }
    ok(EpisodeDestroy((void **)&e));
  }
}

/* The plain fault takes the library's steps. Both solve each stage to rounding; a policy that feeds back on its error
   estimate and on the growth rate of a nucleating instability amplifies that by some powers of ten, which the bound
   leaves room for. */
enum { EXPLICIT_ROWS = 2 };

static void plain_steps(PetscBool moreau)
{
  const char *const names[] = {"log_step_limit",
                               "log_solve_cost",
                               "log_accuracy",
                               "log_growth_time",
                               "growth_rate",
                               "start_growth_rate",
                               "log_mode_rate",
                               "log_push",
                               "phase",
                               "progress",
                               "weakening",
                               "damping_ratio",
                               "log_step",
                               "change_log_mode_rate",
                               "log_slip_error",
                               "seen_growth",
                               "sliding_fraction",
                               "log_peak_ratio",
                               "log_rate",
                               "log_peak_rate",
                               "energy",
                               "log_drop",
                               "growth",
                               "change_sliding_fraction",
                               "log_time_left",
                               "converged"};
  enum { NAMES = 26, HIDDEN = 6 };
  const int first = moreau ? 0 : EXPLICIT_ROWS, rows = NAMES - first;
  double scale[NAMES], offset[NAMES] = {0}, w[NAMES * HIDDEN], b[HIDDEN], out[HIDDEN];
  Random random;

  RandomSeed(&random, 8);
  for (uint64_t seed = 1; seed <= 12; seed++) {
    EpisodeResult a, l;
    SlipPolicy p;
    Episode *e;
    double bias = -0.1;

    for (int i = 0; i < rows; i++) scale[i] = strcmp(names[first + i], "log_solve_cost") ? 0.5 : 1e-15;
    for (int i = 0; i < rows * HIDDEN; i++) w[i] = 0.2 * RandomNormal(&random);
    for (int i = 0; i < HIDDEN; i++) b[i] = 0.3 * RandomNormal(&random), out[i] = 0.15 * RandomNormal(&random);
    ok(SlipPolicyCreate(PETSC_COMM_SELF, &p));
    ok(SlipPolicySetObservations(p, rows, names + first, scale, offset));
    ok(SlipPolicyAddLayer(p, rows, HIDDEN, w, b, SLIP_ACTIVATION_TANH));
    ok(SlipPolicyAddLayer(p, HIDDEN, 1, out, &bias, SLIP_ACTIVATION_LINEAR));
    ok(SlipPolicySetAction(p, -1, 1, 1e-2, "T*", 1e2, "T*", PETSC_TRUE));
    if (seed > 6) ok(SlipPolicySetAttribute(p, SLIP_POLICY_MOVING_DT_MAX, "2.5"));
    if (seed % 2) ok(SlipPolicySetAttribute(p, SLIP_POLICY_STEP_FACTOR, "log_growth_time"));
    ok(EpisodeCreateProducts(NULL, seed, seed % 3 ? 1 + (PetscInt)(seed % 3) : 1, &e));
    e->fineness = 1; /* the fault's own bound */
    SlipMethodSetUp(&e->costs);
    if (moreau) {
      e->costs.solve = 1e6; /* no solve is worth it, as the library is told */
      ok(TSBatheSetMethod(e->ts, TSBATHE_METHOD_EXPLICIT));
      ok(EpisodeRunProducts(e, p, 1e-2, &a));
    } else
      ok(EpisodeRun(e, p, 1e-2, &a));
    ok(EpisodeRunLibrary(e, p, 1e-2, &l));
    assert_int_equal(a.attempts, l.solves);
    if (moreau) /* products; those of the first step twice, of long ones at rest at the end once, as what they begin
                   with is known */
      assert_int_equal(a.solves, 2 * (l.solves + 1));
    else
      assert_int_equal(a.solves, l.solves);
    assert_int_equal(a.failures, l.failures);
    /* the loops solve stages to rounding, the library to a tenth of a step's error, of which signs differ */
    assert_true(fabs(a.error - l.error) < 1e-6 + 0.03 * a.error && fabs(a.done - l.done) < 1e-4);
    for (int i = 0; i < SLIP_NUM_ERRORS; i++) AssertNear(a.errors[i], l.errors[i], 1e-6 + 0.03 * a.error);
    ok(EpisodeDestroy((void **)&e));
    ok(SlipPolicyDestroy(&p));
  }
}

static void plain(void **state)
{
  plain_steps(PETSC_FALSE);
}

/* Explicit steps, whose H the library multiplies with to an error of the dial */
static void plain_explicit(void **state)
{
  plain_steps(PETSC_TRUE);
}

/* The method of a run's steps, and its products: constant steps of 0.5 T* of a mesh so fine that explicit ones are
   dozens of times shorter, where solves are cheap and where they are dear. The counts follow from the rule by hand. */
static void plain_products(void **state)
{
  SlipPolicy steps = policy(0.5, 0);
  EpisodeResult r;
  Episode *e;

  ok(EpisodeCreateProducts(NULL, 5, 3, &e));
  assert_true(e->fineness >= 1 && e->fineness <= 30 && SlipMethodSolve(&e->costs, 1) >= 8 &&
              SlipMethodSolve(&e->costs, 1) <= 100);
  SlipMethodSetUp(&e->costs);
  e->tmax *= 0.3; /* it moves all the time: explicit steps at rest are as long as they are asked to be */
  for (int k = 0; k < 2; k++) {
    const double limit = (e->plain.omega = (e->fineness = 60) * e->omega, PlainFaultLimit(&e->plain));
    const double h = 0.5 * e->tstar, n = ceil(e->tmax / h);

    e->costs.solve = k ? 10 : 1e-2;
    ok(EpisodeRunProducts(e, steps, 1e-2, &r));
    assert_true(r.done == 1 && h > 5 * limit);
    if (k)
      AssertNear(r.solves, 2 * (e->tmax / limit + 1), 4);
    else
      AssertNear(r.solves, n * SlipMethodSolve(&e->costs, h / limit), 2 + SlipMethodSolve(&e->costs, h / limit));
  }
  ok(EpisodeDestroy((void **)&e));
  ok(SlipPolicyDestroy(&steps));
}

/* So do the small systems without objects. Their stages are linear where the reaction is known, so that only rounding
   differs; the predicted time to an event amplifies it, and the bound leaves room for that. */
static void plain_small(void **state)
{
  enum { NAMES = 8, HIDDEN = 4 };
  const struct {
    const Problem *problem;
    const char *names[NAMES];
    PetscReal high;
  } row[] = {
    {&ProblemSlidingMode,
     {"log_accuracy", "log_event", "log_state", "load", "bend", "rest", "log_step", "state_0"},
     0.6},
    {&ProblemCircuit,
     {"log_accuracy", "log_event", "log_time_left", "time_fraction", "log_energy", "log_level", "state_1", "converged"},
     5}};
  double scale[NAMES], offset[NAMES] = {0}, w[NAMES * HIDDEN], b[HIDDEN], out[HIDDEN], bias = 0;
  Random random;

  RandomSeed(&random, 9);
  for (int i = 0; i < NAMES; i++) scale[i] = 0.5;
  for (uint64_t seed = 0; seed < 12; seed++) {
    const int k = seed % 2;
    EnvOptions o = {.problem = row[k].problem,
                    .log_spacing = PETSC_TRUE,
                    .continuation = 1. / 12,
                    .nobs = NAMES,
                    .rtol = 1e-3,
                    .atol = 1e-6,
                    .dt_min = 3e-2,
                    .dt_max = row[k].high,
                    .dt_min_unit = "T*",
                    .dt_max_unit = "T*"};
    EpisodeResult a, l;
    SlipPolicy p;
    EpisodeSmall e;

    for (int i = 0; i < NAMES; i++) o.names[i] = (char *)row[k].names[i], o.scale[i] = 1;
    for (int i = 0; i < NAMES * HIDDEN; i++) w[i] = 0.4 * RandomNormal(&random);
    for (int i = 0; i < HIDDEN; i++) b[i] = 0.3 * RandomNormal(&random), out[i] = 0.3 * RandomNormal(&random);
    ok(SlipPolicyCreate(PETSC_COMM_SELF, &p));
    ok(SlipPolicySetObservations(p, NAMES, row[k].names, scale, offset));
    ok(SlipPolicyAddLayer(p, NAMES, HIDDEN, w, b, SLIP_ACTIVATION_TANH));
    ok(SlipPolicyAddLayer(p, HIDDEN, 1, out, &bias, SLIP_ACTIVATION_LINEAR));
    ok(SlipPolicySetAction(p, -1, 1, o.dt_min, "T*", o.dt_max, "T*", PETSC_TRUE));
    ok(EpisodeSmallCreate(&o, seed, &e));
    ok(EpisodeSmallRun(e, p, 1e-2, NULL, NULL, &a));
    ok(EpisodeSmallRunLibrary(e, p, 1e-2, NULL, NULL, &l));
    assert_int_equal(a.solves, l.solves);
    assert_true(a.done == 1 && l.done == 1);
    assert_true(l.error > 0 && fabs(a.error - l.error) < 1e-6);
    ok(EpisodeSmallDestroy((void **)&e));
    ok(SlipPolicyDestroy(&p));
  }
}

/* Every draw lies in bounds that the fault accepts, and cells of a mesh differ. */
static void draws(void **state)
{
  FaultDraw d;
  Random random;
  PetscReal low = PETSC_MAX_REAL, high = 0;

  RandomSeed(&random, 3);
  for (int k = 0; k < 200; k++) {
    FaultDrawAtRandom(&random, k % 2 ? 8 : 1, &d);
    assert_int_equal(d.n, d.nx * d.nz);
    assert_true(k % 2 ? d.nx >= 2 && d.nx <= 8 && d.nz >= 2 && d.nz <= 8 : d.n == 1);
    for (PetscInt f = 0; f < DRAW_FIELDS; f++)
      for (PetscInt i = 0; i < d.n; i++) assert_true(d.field[f][i] > 0 && isfinite(d.field[f][i]));
    for (PetscInt i = 0; i < d.n; i++) {
      low = PetscMin(low, d.field[0][i]);
      high = PetscMax(high, d.field[0][i]);
    }
  }
  assert_true(high > 10 * low);
}

SLIP_TESTS(penalty, cost, reproducible, reference, growth, plain, plain_explicit, plain_products, plain_small, draws)
