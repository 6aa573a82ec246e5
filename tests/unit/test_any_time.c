/* What is asked of a fault depends on the time and the state that are named, and on nothing asked before: loads,
   strength, sums, powers, observations, rest and errors in shuffled order are the numbers, bit for bit, that a new
   fault gives. */
#include "unit.h"
#include "faultstart.h"
#include <slipstep/private/slipfault.h>
#include <slipstep/private/slipsnes.h>
#include <slipstep/rooms/sliph5.h>
#include "tempdir.h"
#include "record.h"
#include <math.h>
#include <string.h>

enum { NX = 4, NZ = 3, N = NX * NZ, STATES = 3, TIMES = 4, ASKED = 600, MOST = 6 * N };
enum { LOAD, STRENGTH, SUMS, POWERS, OBSERVED, OBSERVABLES, STRESS, WORK, REST, ERROR, STAGE, RATES, QUESTIONS };
enum { WEAKENING, STRESSED, SLIDING, FALLING, RATE_STATE };
static const PetscReal times[TIMES] = {0, 4e5, 3e6, 7e6};

static char record[TEMPDIR_LENGTH + 8]; /* of pore pressure, a file */

static void WriteOwnRecord(void)
{
  const PetscReal at[] = {0, 1e6, 6e6};
  const PetscInt rows = 3, dims[] = {3, N};
  PetscReal p[3 * N];

  for (PetscInt i = 0; i < 3 * N; i++) p[i] = 2e6 * (PetscReal)(i % 17) / 17;
  ok(WriteRecord(record, rows, at, 2, dims, p));
}

static PetscErrorCode Pressure(SlipFault fault, PetscReal t, PetscInt n, PetscReal p[], void *ctx)
{
  for (PetscInt i = 0; i < n; i++) p[i] = 1e6 * (1 + (PetscReal)i / N) * PetscClipInterval(t / 2e6, 0, 1);
  return PETSC_SUCCESS;
}

static SlipFault Fault(int which)
{
  SlipFault fault;

  ok(SlipFaultCreate(PETSC_COMM_SELF, &fault));
  ok(FaultSetReals(fault, {"nx", NX}, {"nz", NZ}, {"normal_stress", 5e7}, {"normal_stress_gradient", 0}));
  if (which != SLIDING) ok(FaultSetReals(fault, {"loading_rate", 1e-9}, {"stressing_rate", 0.05}));
  if (which == WEAKENING) {
    ok(SlipFaultSetReal(fault, "healing_time", 1e7));
    ok(SlipFaultSetPressureFunction(fault, Pressure, NULL));
  }
  if (which == WEAKENING || which == RATE_STATE) {
    ok(SlipFaultSetString(fault, "injection", "3000,2000"));
    ok(FaultSetReals(fault, {"injection_pressure", 2e6}, {"injection_diffusivity", 0.5}, {"injection_stop", 5e6}));
  }
  if (which == RATE_STATE) ok(FaultSetStrings(fault, {"friction_law", "rate_and_state"}, {"pore_pressure", record}));
  if (which == FALLING) {
    ok(SlipFaultSetString(fault, "friction_law", "rate_weakening"));
    ok(SlipFaultSetReal(fault, "friction_rate", 0.05)); /* falls by more than inertia and stiffness make swing */
    ok(SlipFaultSetString(fault, "initial", "rest"));
    ok(SlipFaultSetPressureFunction(fault, Pressure, NULL));
  }
  if (which == WEAKENING || which == STRESSED) {
    ok(SlipFaultSetString(fault, "initial", "traction"));
    ok(SlipFaultSetReal(fault, "initial_traction", 1e7));
  }
  ok(SlipFaultSetUp(fault));
  ok(SlipFaultConstraintCreate(fault));
  return fault;
}

/* One at rest, others slide in some cells; with rate-and-state friction all do */
static Vec State(SlipFault fault, int k)
{
  PetscReal *a;
  Vec w;

  ok(SlipFaultCreateState(fault, &w));
  ok(SlipFaultSetInitialState(fault, w));
  ok(VecGetArray(w, &a));
  for (PetscInt i = 0; i < N && k; i++) {
    a[3 * i] = fault->friction.law->always_slides ? 1e-9 * (1 + sin(i + k)) + 1e-12 : PetscMax(0, 0.1 * sin(i + 2 * k));
    a[3 * i + 1] += 1e-3 * k * sin(3 * i);
    a[3 * i + 2] += 0.1 * k * fabs(cos(i));
  }
  ok(VecRestoreArray(w, &a));
  return w;
}

static PetscInt Put(Vec x, PetscReal out[])
{
  const PetscReal *a;
  PetscInt n;

  ok(VecGetLocalSize(x, &n));
  a = VecRead(x);
  memcpy(out, a, (size_t)n * sizeof(*out));
  return n;
}

/* All that a policy may observe but the integrator's estimates and the last right-hand side */
static PetscInt Observe(SlipFault fault, PetscReal t, Vec w, PetscReal out[])
{
  PetscInt row[MOST], n = 0;

  for (PetscInt i = 0; SlipObservations[i].name; i++)
    if (SlipObservations[i].fault && !(SlipObservations[i].reads & (SLIP_READS_ESTIMATES | SLIP_READS_STIFFNESS)))
      row[n++] = i;
  assert_true(n > 10 && n <= MOST);
  ok(SlipFaultObserve(fault, t, w, n, row, out));
  return n;
}

/* The bound of a stage that ends at t; disturbed: asked for after somebody else has looked at another time */
static PetscInt Stage(SlipFault fault, PetscReal t, Vec w, PetscBool disturbed, PetscReal out[])
{
  const SlipStage stage = {.t = t, .theta = 100, .omega = 1, .base = w};
  const SlipFaultLoad *other;
  Vec x, q;

  ok(VecDuplicate(fault->critical.uc, &x));
  ok(VecDuplicate(x, &q));
  ok(VecStrideGather(w, 0, x, INSERT_VALUES));
  ok(SlipFaultConstraintStage(fault, &stage));
  if (disturbed) ok(SlipFaultGetLoad(fault, t / 2 + 1, &other));
  ok((*fault->stage.con->ops->bound)(fault->stage.con, x, q, NULL, fault));
  Put(q, out);
  Put(fault->stage.c, out + N);
  ObjectsDestroy(&x, &q);
  return 2 * N;
}

static PetscInt Rest(SlipFault fault, PetscReal t, Vec w, PetscReal out[])
{
  PetscReal end = 0, h = 0;
  Vec half, after;

  VecsDuplicate(w, &half, &after);
  ok(VecZeroEntries(after));
  if (!fault->friction.law->always_slides) ok(SlipFaultRest(NULL, t, t + 1e9, w, half, after, &end, &h, fault));
  out[0] = end;
  out[1] = h;
  ok(SlipFaultRestTime(NULL, t, w, &out[2], fault));
  Put(after, out + 3);
  ObjectsDestroy(&half, &after);
  return 3 + 3 * N;
}

/* The rates of an explicit state, and the sums of the state into which they are put */
static PetscInt Rates(SlipFault fault, PetscReal t, Vec w, PetscReal out[])
{
  const SlipFaultSums *sums;
  PetscInt n;
  Vec F;

  if (fault->balance.eta == 0 || fault->kind.inertia) return 0;
  ok(VecDuplicate(w, &F));
  ok(SlipFaultGetSums(fault, t, w, &sums));
  ok(SlipFaultRates(fault, t, w, F));
  ok(SlipFaultPutRates(fault, w));
  ok(SlipFaultGetSums(fault, t, w, &sums));
  memcpy(out, sums->sum, sizeof(sums->sum));
  n = FAULT_NUM_SUMS + Put(F, out + FAULT_NUM_SUMS);
  ok(SlipFaultRelaxation(NULL, w, &out[n], fault));
  ok(VecDestroy(&F));
  return n + 1;
}

/* The answer to a question: numbers out, and how many. w: not kept by RATES */
static PetscInt Ask(SlipFault fault, int question, PetscReal t, Vec w, PetscBool fresh, PetscReal out[])
{
  const SlipFaultLoad *load;
  const SlipFaultSums *sums;
  SlipFaultObservables o;
  PetscInt n = N;
  Vec e;

  switch (question) {
  case LOAD:
    ok(SlipFaultGetLoad(fault, t, &load));
    memcpy(out, load->stress, N * sizeof(*out));
    if (load->shear) n += Put(load->shear, out + N);
    return n;
  case STRENGTH:
    ok(SlipFaultGetWork(fault, &e));
    ok(SlipFaultStrength(fault, t, w, e));
    n = Put(e, out);
    ok(SlipFaultRestoreWork(fault, &e));
    return n;
  case SUMS:
    ok(SlipFaultGetSums(fault, t, w, &sums));
    memcpy(out, sums->sum, sizeof(sums->sum));
    out[FAULT_NUM_SUMS] = sums->max_v;
    return FAULT_NUM_SUMS + 1;
  case POWERS:
    ok(SlipFaultGetPowers(fault, t, w, NULL, out, NULL));
    return 3;
  case OBSERVED:
    return Observe(fault, t, w, out);
  case OBSERVABLES:
    ok(SlipFaultGetObservables(fault, t, w, NULL, &o));
    memcpy(out, &o, sizeof(o));
    return (PetscInt)(sizeof(o) / sizeof(*out));
  case STRESS:
    ok(SlipFaultGetWork(fault, &e));
    ok(SlipFaultStress(fault, t, w, e));
    n = Put(e, out);
    ok(SlipFaultRestoreWork(fault, &e));
    return n;
  case WORK:
    ok(SlipFaultElasticEnergy(fault, t, w, &out[0]));
    ok(SlipFaultLoadingPower(fault, t, w, &out[1]));
    return 2;
  case REST:
    return Rest(fault, t, w, out);
  case ERROR:
    ok(VecDuplicate(w, &e));
    ok(VecCopy(w, e));
    ok(VecScale(e, 1e-12)); /* an instability says more */
    fault->stage.theta = 100;
    ok(SlipFaultErrorNorm(fault, 1e-3, t, 10, e, w, w, out));
    ok(VecDestroy(&e));
    return 1;
  case STAGE:
    return Stage(fault, t, w, fresh ? PETSC_FALSE : PETSC_TRUE, out);
  default:
    return Rates(fault, t, w, out);
  }
}

/* The same numbers whatever is next: xorshift */
static int Draw(uint64_t *seed, int n)
{
  *seed ^= *seed << 13;
  *seed ^= *seed >> 7;
  *seed ^= *seed << 17;
  return (int)(*seed % (uint64_t)n);
}

static void Shuffled(int which)
{
  static PetscReal fresh[QUESTIONS][STATES][TIMES][MOST];
  PetscReal now[MOST];
  uint64_t seed = 88172645463325252u;
  SlipFault fault;
  Vec state[STATES], used;

  memset(fresh, 0, sizeof(fresh));
  for (int k = 0; k < STATES; k++)
    for (int j = 0; j < TIMES; j++)
      for (int q = 0; q < QUESTIONS; q++) {
        fault = Fault(which);
        used = State(fault, k);
        ok(SlipLoadDestroy(&fault->known.load)); /* the set-up has looked at the start */
        (void)Ask(fault, q, times[j], used, PETSC_TRUE, fresh[q][k][j]);
        ObjectsDestroy(&used, &fault);
      }
  fault = Fault(which);
  for (int k = 0; k < STATES; k++) state[k] = State(fault, k);
  ok(VecDuplicate(state[0], &used));
  for (int i = 0, k = 0; i < ASKED; i++) {
    const int q = Draw(&seed, QUESTIONS), j = Draw(&seed, TIMES), own = Draw(&seed, 2);
    PetscInt n;

    /* the same vector holds one state, then another; now and then it is asked again as it is */
    if (i == 0 || own || q == RATES || Draw(&seed, 3)) {
      k = Draw(&seed, STATES);
      ok(VecCopy(state[k], used));
    }
    n = Ask(fault, q, times[j], q == RATES || own ? used : state[k], PETSC_FALSE, now);
    if (memcmp(now, fresh[q][k][j], (size_t)n * sizeof(*now)))
      fail_msg("fault %d, question %d, state %d, time %d: asked as number %d it has another answer", which, q, k, j, i);
    if (q == RATES) ok(VecCopy(state[k], used));
  }
  for (int k = 0; k < STATES; k++) ok(VecDestroy(&state[k]));
  ObjectsDestroy(&used, &fault);
}

static void weakening(void **state)
{
  Shuffled(WEAKENING);
}

static void stressed(void **state)
{
  Shuffled(STRESSED);
}

static void sliding(void **state)
{
  Shuffled(SLIDING);
}

/* Its strength falls with the slip rate, by less the less normal stress there is: the error's part by instability. */
static void falling(void **state)
{
  Shuffled(FALLING);
}

static void rate_and_state(void **state)
{
  char dir[TEMPDIR_LENGTH];

  assert_int_equal(0, TempDirMake("times", dir));
  snprintf(record, sizeof(record), "%s/p.h5", dir);
  WriteOwnRecord();
  Shuffled(RATE_STATE);
  assert_int_equal(0, TempDirRemove(dir));
}

SLIP_TESTS(weakening, stressed, sliding, falling, rate_and_state)
