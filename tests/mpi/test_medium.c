/* A medium that remembers, through TSBATHE, TSMOREAU, TSADAMS and TSRK: beside the static stiffness a spring and a
   dashpot in series on each cell, m' = -m/tau + k u', of which the medium keeps m. The exact answer is that of a larger
   system of differential equations, which is integrated here by itself. Steps that are refused, halves of steps, a run
   that goes on from a checkpoint to the bit, on several ranks. */
#include "ranks.h"
#include "faultstart.h"
#include "maxwell.h"
#include <slipstep/private/slipfault.h>
#include <slipstep/rooms/slipadapt.h>
#include <math.h>
#include <unistd.h>

enum { N = 4, FINE = 8000, ROOM = 1000 };

/* ---- two problems ---- */

/* Cells with inertia that slide all the time under constant friction: a linear system; and rate-and-state friction
   without. The latter slips by some of its d_c, the former for about the time that radiation takes. */
typedef struct {
  PetscBool smooth;
  PetscReal end, tau, first; /* [s]; a first step far too long */
} Problem;

static const Problem Linear = {PETSC_FALSE, 0.3, 0.1, 0.15}, Smooth = {PETSC_TRUE, 2e4, 4e3, 1e4};

static PetscErrorCode Create(MPI_Comm comm, const Problem *p, const char medium[], SlipFault *fault)
{
  PetscReal traction[N], rate[N];

  Tau = p->tau;
  for (int i = 0; i < N; i++) {
    traction[i] = 6e6 + 3e5 * i;
    rate[i] = 1e-6 * (1 + 0.5 * i);
  }
  PetscCall(SlipFaultCreate(comm, fault));
  PetscCall(FaultSetStrings(*fault, {"medium", medium}, {"viscosity", "radiation"}));
  PetscCall(FaultSetReals(*fault, {"nx", N}, {"nz", 1}, {"length_x", 2000}, {"length_z", 500}, {"normal_stress", 1e7},
                          {"normal_stress_gradient", 0}));
  if (p->smooth) {
    PetscCall(SlipFaultSetString(*fault, "friction_law", "rate_and_state"));
    PetscCall(FaultSetReals(*fault, {"friction_slip", 0.02}));
    PetscCall(SlipFaultSetField(*fault, "initial_rate", N, rate));
  } else {
    PetscCall(FaultSetStrings(*fault, {"friction_law", "constant"}, {"initial", "traction"}));
    PetscCall(SlipFaultSetBool(*fault, "inertia", PETSC_TRUE));
    PetscCall(SlipFaultSetBool(*fault, "initial_unstable", PETSC_TRUE));
    PetscCall(SlipFaultSetField(*fault, "initial_traction", N, traction));
  }
  return PETSC_SUCCESS;
}

/* ---- the larger system ---- */

typedef struct {
  SlipFrictionCells friction;
  PetscReal K[N][N], T[N], k, tau, M, eta;
  PetscBool smooth;
} System;

/* x = v or the state, u, m */
static void Rates(const System *s, const PetscReal x[3 * N], PetscReal f[3 * N])
{
  PetscReal stress[N], v[N];

  for (int i = 0; i < N; i++) {
    stress[i] = s->T[i] - x[2 * N + i];
    for (int j = 0; j < N; j++) stress[i] -= s->K[i][j] * x[N + j];
  }
  if (s->smooth)
    SlipFrictionBalance(&s->friction, NULL, N, s->eta, stress, 1, x, v, f);
  else
    for (int i = 0; i < N; i++) {
      v[i] = x[i];
      f[i] = (stress[i] - s->eta * v[i] - 0.5 * 1e7) / s->M;
    }
  for (int i = 0; i < N; i++) {
    f[N + i] = v[i];
    f[2 * N + i] = s->k * v[i] - x[2 * N + i] / s->tau;
  }
}

/* u at the end, by the classical formula of Runge and Kutta with steps of an 8000th: their error is below 1e-12 */
static PetscErrorCode Exact(const Problem *p, PetscReal u[N])
{
  const PetscReal h = p->end / FINE;
  PetscReal x[3 * N] = {0}, y[3 * N], f[4][3 * N];
  System s = {.smooth = p->smooth, .tau = p->tau, .k = Stiffness};
  SlipFault fault;
  Mat K;
  Vec e, Ke, w;
  const PetscReal *a;

  PetscCall(Create(PETSC_COMM_SELF, p, SLIPELASTICSTATIC, &fault));
  PetscCall(SlipFaultSetUp(fault));
  PetscCall(SlipFaultGetOperators(fault, &K, NULL, &s.M));
  PetscCall(MatCreateVecs(K, &e, &Ke));
  for (int j = 0; j < N; j++) {
    PetscCall(VecZeroEntries(e));
    PetscCall(VecSetValue(e, j, 1, INSERT_VALUES));
    PetscCall(VecAssemble(e));
    PetscCall(MatMult(K, e, Ke));
    a = VecRead(Ke);
    for (int i = 0; i < N; i++) s.K[i][j] = a[i];
  }
  PetscCall(SlipFaultGetField(fault, "initial_traction", N, s.T));
  PetscCall(SlipFaultGetFriction(fault, 0, &s.friction));
  PetscCall(SlipFaultCreateState(fault, &w));
  PetscCall(SlipFaultSetInitialState(fault, w));
  a = VecRead(w);
  for (int i = 0; i < N; i++) x[i] = a[3 * i + (p->smooth ? 2 : 0)];
  s.eta = 0.5 * sqrt(30e9 * 2500);
  for (int n = 0; n < FINE; n++) {
    Rates(&s, x, f[0]);
    for (int i = 0; i < 3 * N; i++) y[i] = x[i] + h / 2 * f[0][i];
    Rates(&s, y, f[1]);
    for (int i = 0; i < 3 * N; i++) y[i] = x[i] + h / 2 * f[1][i];
    Rates(&s, y, f[2]);
    for (int i = 0; i < 3 * N; i++) y[i] = x[i] + h * f[2][i];
    Rates(&s, y, f[3]);
    for (int i = 0; i < 3 * N; i++) x[i] += h / 6 * (f[0][i] + 2 * f[1][i] + 2 * f[2][i] + f[3][i]);
  }
  for (int i = 0; i < N; i++) u[i] = x[N + i];
  return DestroyObjects(&e, &Ke, &w, &fault);
}

/* ---- runs ---- */

typedef struct {
  const char *type, *adapt, *checkpoint, *restart;
  TSBatheError error;
  PetscReal h, rtol;
  PetscInt parts;
  PetscInt most;   /* steps; 0: to the end */
  PetscBool event; /* steps are taken back to end at some time */
  PetscInt *n;     /* number of steps taken, and these [s], at most ROOM: to be kept, or if there are some to be taken;
                      NULL: neither */
  PetscReal *step;
  PetscReal *energy; /* NULL, or what it does not close by, over what was lost */
} How;

static PetscErrorCode KeepStep(TS ts, const SlipAttempt *attempt, Vec w, void *ctx)
{
  const How *how = (const How *)ctx;

  if (attempt->accepted && *how->n < ROOM) how->step[(*how->n)++] = attempt->dt;
  return PETSC_SUCCESS;
}

static PetscErrorCode When(TS ts, PetscReal t, Vec w, PetscReal f[], void *ctx)
{
  f[0] = t - 0.37 * ((const Problem *)ctx)->end;
  return PETSC_SUCCESS;
}

/* Energy against work so far [J/m^2] */
typedef struct {
  SlipFault fault;
  PetscReal time, start, power, lost; /* of the last state; work that friction and the medium have taken */
  PetscReal residual;
} Energy;

static PetscErrorCode Balance(TS ts, PetscInt step, PetscReal t, Vec w, void *ctx)
{
  Energy *e = (Energy *)ctx;
  SlipFaultObservables o;
  PetscReal power;

  PetscCall(SlipFaultGetObservables(e->fault, t, w, NULL, &o));
  power = o.viscous_power + o.friction_power - o.loading_power;
  if (step == 0)
    e->start = o.kinetic + o.elastic;
  else
    e->lost += (t - e->time) * (power + e->power) / 2;
  e->residual = o.kinetic + o.elastic - e->start + e->lost;
  e->power = power;
  e->time = t;
  return PETSC_SUCCESS;
}

/* To the end, or by the steps that there are */
static PetscErrorCode Solve(TS ts, const How *how, Vec w)
{
  if (!how->n || !*how->n) {
    if (how->n) PetscCall(TSBatheMonitorSet(ts, KeepStep, (void *)how, NULL));
    PetscCall(TSSolve(ts, w));
    return PETSC_SUCCESS;
  }
  PetscCall(TSSetUp(ts));
  for (PetscInt i = 0; i < *how->n; i++) {
    PetscCall(TSSetTimeStep(ts, how->step[i]));
    PetscCall(TSStep(ts));
  }
  return PETSC_SUCCESS;
}

static PetscErrorCode Run(const Problem *p, const char medium[], const How *how, PetscReal u[N], PetscInt *refused)
{
  const PetscReal *a;
  SlipFault fault;
  VecScatter gather;
  PetscBool bathe, stops = PETSC_FALSE;
  Energy energy = {.lost = 0};
  PetscInt up = 1;
  int ended;
  Vec w, all;
  TS ts;

  PetscCall(Create(PETSC_COMM_WORLD, p, medium, &fault));
  if (how->checkpoint) PetscCall(SlipFaultSetString(fault, "checkpoint", how->checkpoint));
  if (how->restart) PetscCall(SlipFaultSetString(fault, "restart", how->restart));
  PetscCall(PetscStrcmp(how->type, TSBATHE, &bathe));
  if (bathe) PetscCall(PetscOptionsSetValue(NULL, "-ts_type", how->type)); /* that rate-and-state friction asks for */
  PetscCall(FaultStart(fault, how->adapt, how->h, p->end, &w, &ts));
  PetscCall(PetscOptionsClearValue(NULL, "-ts_type"));
  if (!bathe) PetscCall(TSSetType(ts, how->type));
  if (bathe) PetscCall(TSBatheSetError(ts, how->error));
  if (how->parts) PetscCall(TSBatheSetParts(ts, how->parts, NULL, NULL));
  if (how->rtol > 0) PetscCall(TSSetTolerances(ts, PETSC_DEFAULT, NULL, how->rtol, NULL));
  if (how->most) PetscCall(TSSetMaxSteps(ts, how->most));
  if (how->event) PetscCall(TSSetEventHandler(ts, 1, &up, &stops, When, NULL, (void *)p));
  energy.fault = fault;
  if (how->energy) PetscCall(TSMonitorSet(ts, Balance, &energy, NULL));
  PetscCall(TSSetSolution(ts, w));
  PetscCall(SlipFaultCheckpointStart(fault, ts));
  PetscCall(Solve(ts, how, w));
  PetscCall(SlipFaultCheckpointFinish(fault, ts, &ended));
  if (how->energy) *how->energy = PetscAbsReal(energy.residual) / energy.lost;
  if (refused) PetscCall(TSGetStepRejections(ts, refused));
  PetscCall(VecScatterCreateToAll(w, &gather, &all));
  PetscCall(VecScatterBegin(gather, w, all, INSERT_VALUES, SCATTER_FORWARD));
  PetscCall(VecScatterEnd(gather, w, all, INSERT_VALUES, SCATTER_FORWARD));
  a = VecRead(all);
  for (int i = 0; i < N; i++) u[i] = a[3 * i + 1];
  PetscCall(VecScatterDestroy(&gather));
  return DestroyObjects(&all, &w, &ts, &fault);
}

/* Largest difference over the largest slip */
static PetscReal Apart(const PetscReal a[N], const PetscReal b[N])
{
  PetscReal most = 0, size = 0;

  for (int i = 0; i < N; i++) {
    most = PetscMax(most, PetscAbsReal(a[i] - b[i]));
    size = PetscMax(size, PetscAbsReal(b[i]));
  }
  return most / size;
}

#define Expect(is, ...) Check(is, __VA_ARGS__)

/* The mean rate of a step is right to the second order, and so is a run: errors at h over those at h/2 are 4, a little
   more where Adams' formulas begin at order 1, and 2 would be the first. Steps that an event takes back change no more
   than that. The static medium is off by a tenth and more. */
static PetscErrorCode Order(const Problem *p, How how, const PetscReal exact[N])
{
  PetscReal u[N], e[3], without, open;

  how.energy = &open;
  for (int k = 0; k < 3; k++) {
    how.h = p->end / (k ? 640 : 320);
    how.event = k == 2 ? PETSC_TRUE : PETSC_FALSE;
    PetscCall(Run(p, "maxwell", &how, u, NULL));
    e[k] = Apart(u, exact);
  }
  /* the work by the trapezoidal rule, of the second order; what the dashpots lose is a tenth of it and more */
  Expect(open < 1e-3, "%s: the energy does not close by %g", how.type, (double)open);
  PetscCall(Run(p, SLIPELASTICSTATIC, &how, u, NULL));
  without = Apart(u, exact);
  Expect(e[0] / e[1] > 3.4 && e[0] / e[1] < 6, "%s: errors %g and %g at h and h/2, expected the second order", how.type,
         (double)e[0], (double)e[1]);
  Expect(e[1] < 2e-5, "%s: error %g, expected some 1e-5 of 640 steps", how.type, (double)e[1]);
  Expect(e[2] < 2 * e[0], "%s: error %g with an event, %g without", how.type, (double)e[2], (double)e[0]);
  Expect(without > 0.05, "%s: without memory the error is %g", how.type, (double)without);
  return PETSC_SUCCESS;
}

/* Doubling is steps of half the length, whose memory is that of halves too; and what was refused leaves nothing behind:
   a run by the same steps, without attempts that are refused, is the same. Both but for rounding; memory of whole steps
   would be off by 1e-5. */
static PetscErrorCode Halves(const Problem *p)
{
  PetscReal whole[N], u[N], step[ROOM];
  PetscInt refused, n = 0;
  How how = {.type = TSBATHE, .adapt = TSADAPTNONE, .error = TSBATHE_ERROR_DOUBLING, .h = p->end / 20};
  const How half = {.type = TSBATHE, .adapt = TSADAPTNONE, .error = TSBATHE_ERROR_NONE, .h = p->end / 40};
  const How quarter = {.type = TSBATHE, .adapt = TSADAPTNONE, .error = TSBATHE_ERROR_NONE, .h = p->end / 80};

  PetscCall(Run(p, "maxwell", &how, whole, NULL));
  PetscCall(Run(p, "maxwell", &half, u, NULL));
  Expect(Apart(u, whole) < 1e-10, "doubling and half steps are %g apart", (double)Apart(u, whole));
  how.error = TSBATHE_ERROR_NONE;
  how.parts = 2;
  PetscCall(Run(p, "maxwell", &how, whole, NULL));
  Expect(Apart(u, whole) < 1e-10, "two parts and half steps are %g apart", (double)Apart(u, whole));
  how.error = TSBATHE_ERROR_DOUBLING;
  PetscCall(Run(p, "maxwell", &how, whole, NULL));
  PetscCall(Run(p, "maxwell", &quarter, u, NULL));
  Expect(Apart(u, whole) < 1e-10, "four parts and quarter steps are %g apart", (double)Apart(u, whole));
  how.parts = 0;
  how.error = TSBATHE_ERROR_DOUBLING;
  how.adapt = TSADAPTHEURISTIC;
  how.h = p->first;
  how.rtol = 1e-4;
  how.n = &n;
  how.step = step;
  PetscCall(Run(p, "maxwell", &how, whole, &refused));
  Expect(refused > 0, "no step was refused");
  how.adapt = TSADAPTNONE;
  PetscCall(Run(p, "maxwell", &how, u, NULL));
  Expect(Apart(u, whole) < 1e-10, "with and without refused attempts runs are %g apart", (double)Apart(u, whole));
  return PETSC_SUCCESS;
}

/* Steps by an error estimate with a relative tolerance of 1e-4, of which the first are refused: errors are some 1e-3 at
   most. Five steps, and what follows from their checkpoint, are the whole run to the bit. */
static PetscErrorCode Adaptive(const Problem *p, How how, PetscReal within, const PetscReal exact[N])
{
  PetscReal whole[N], u[N];
  PetscInt refused;
  PetscMPIInt rank, size;
  char file[64];
  How part = how;

  PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
  PetscCallMPI(MPI_Comm_size(PETSC_COMM_WORLD, &size));
  PetscCall(PetscSNPrintf(file, sizeof(file), "medium_%d.state", (int)size));
  if (!rank) unlink(file);
  PetscCallMPI(MPI_Barrier(PETSC_COMM_WORLD));
  how.h = p->first;
  PetscCall(Run(p, "maxwell", &how, whole, &refused));
  Expect(refused > 0, "%s: no step was refused", how.type);
  Expect(Apart(whole, exact) < within, "%s: error %g, expected %g", how.type, (double)Apart(whole, exact),
         (double)within);
  part.h = how.h;
  part.most = 5;
  part.checkpoint = file;
  PetscCall(Run(p, "maxwell", &part, u, NULL));
  how.restart = file;
  PetscCall(Run(p, "maxwell", &how, u, NULL));
  for (int i = 0; i < N; i++)
    Expect(u[i] == whole[i], "%s: cell %d has slipped %.17g m after a restart, %.17g without", how.type, i,
           (double)u[i], (double)whole[i]);
  PetscCallMPI(MPI_Barrier(PETSC_COMM_WORLD));
  if (!rank) unlink(file);
  return PETSC_SUCCESS;
}

/* What a fault does that is loaded and rests: the static medium says until when, and the first step needs no solve;
 * what relaxes does not. */
static PetscErrorCode Quiet(const char medium[], PetscInt *solves)
{
  SlipAttempt last;
  SlipFault fault;
  TS ts;
  Vec w;

  PetscCall(SlipFaultCreate(PETSC_COMM_WORLD, &fault));
  PetscCall(FaultSetStrings(fault, {"initial", "rest"}, {"viscosity", "radiation"}, {"medium", medium}));
  PetscCall(FaultSetReals(fault, {"nx", N}, {"nz", 1}, {"loading_rate", 1e-9}));
  PetscCall(FaultStart(fault, TSADAPTNONE, 1e3, 1e5, &w, &ts));
  PetscCall(TSSetMaxSteps(ts, 1));
  PetscCall(TSSolve(ts, w));
  PetscCall(TSBatheGetLastAttempt(ts, &last));
  *solves = last.solves;
  return DestroyObjects(&w, &ts, &fault);
}

/* The springs' k adds to the stiffness, so omega^2 to that of static: k/M more, each to 1 % from above */
static PetscErrorCode Frequencies(void)
{
  const char *const media[] = {SLIPELASTICSTATIC, "maxwell"};
  PetscReal omega[2], mass, more;
  SlipFault fault;

  for (int k = 0; k < 2; k++) {
    PetscCall(Create(PETSC_COMM_WORLD, &Linear, media[k], &fault));
    PetscCall(SlipFaultSetUp(fault));
    PetscCall(SlipFaultGetOperators(fault, NULL, NULL, &mass));
    PetscCall(SlipElasticAccept(fault->medium, 0, fault->critical.uc, PETSC_TRUE));
    PetscCall(SlipElasticGetFrequency(fault->medium, &omega[k]));
    PetscCall(SlipFaultDestroy(&fault));
  }
  more = PetscSqr(omega[1]) - PetscSqr(omega[0]);
  Expect(PetscAbsReal(more - Stiffness / mass) < 0.01 * PetscSqr(omega[1]), "omega^2 grows by %g, expected %g",
         (double)more, (double)(Stiffness / mass));
  return PETSC_SUCCESS;
}

static PetscErrorCode Test(void)
{
  PetscReal exact[N];
  PetscInt solves[2];

  PetscCall(SlipElasticRegister("maxwell", Create_Maxwell));
  Tau = 1;
  Stiffness = 1e8; /* five times the K of a cell */
  PetscCall(Quiet(SLIPELASTICSTATIC, &solves[0]));
  PetscCall(Quiet("maxwell", &solves[1]));
  Expect(!solves[0] && solves[1], "at rest %d solves with the static medium, %d with memory", (int)solves[0],
         (int)solves[1]);
  PetscCall(Frequencies());
  PetscCall(Exact(&Linear, exact));
  PetscCall(Order(&Linear, (How){.type = TSBATHE, .adapt = TSADAPTNONE}, exact));
  PetscCall(Adaptive(&Linear, (How){.type = TSBATHE, .adapt = TSADAPTBASIC, .rtol = 1e-4}, 3e-3, exact));
  PetscCall(Adaptive(&Linear,
                     (How){.type = TSBATHE, .adapt = TSADAPTHEURISTIC, .rtol = 1e-4, .error = TSBATHE_ERROR_DOUBLING},
                     3e-3, exact));
  PetscCall(Order(&Linear, (How){.type = TSMOREAU, .adapt = TSADAPTNONE}, exact));
  PetscCall(Adaptive(&Linear, (How){.type = TSMOREAU, .adapt = TSADAPTBASIC, .rtol = 1e-4}, 3e-3, exact));
  PetscCall(Halves(&Linear));
  PetscCall(Exact(&Smooth, exact));
  PetscCall(Order(&Smooth, (How){.type = TSBATHE, .adapt = TSADAPTNONE}, exact));
  PetscCall(Order(&Smooth, (How){.type = TSADAMS, .adapt = TSADAPTNONE}, exact));
  PetscCall(Order(&Smooth, (How){.type = TSRK, .adapt = TSADAPTNONE}, exact));
  PetscCall(Adaptive(&Smooth, (How){.type = TSADAMS, .adapt = TSADAPTBASIC, .rtol = 1e-4}, 3e-3, exact));
  return Adaptive(&Smooth, (How){.type = TSRK, .adapt = TSADAPTBASIC, .rtol = 1e-4}, 3e-3, exact);
}

SLIP_RANKS(Test)
