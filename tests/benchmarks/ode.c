static const char help[] = "Twenty ordinary differential equations of the literature, none of them in the training of "
                           "the general policy, under\n"
                           "any step-size controller: work and error, a line each run.\n"
                           "  ode -bench_problems duffing,flame -bench_controllers basic,dsp:PI42,rl,rl:other.h5\n"
                           "Prints \"problem method controller tolerance work error steps rejected end\". "
                           "tests/benchmarks/ode.py compares them.\n\n";

/* Error: root mean square over time and components, each in units of its largest value. Work: evaluations of f, and of
   its Jacobian with the solve that follows; Jacobians by differences count as one. */
#include "ode.h"
#include "../objects.h"
#include <math.h>
#include <stdlib.h>

enum { TOLERANCES = 7, MAX_STEPS = 60000, MAX_WORK = 200000, NEWTON = 10 };

static const char *const MethodNames[] = {"rk3bs", "rk5dp", "arkimex3", "arkimex4", "bdf2", "bathe"};
/* tightest and loosest tolerance */
static const double Tolerances[METHODS][2] = {{1e-6, 1e-2}, {1e-8, 1e-3}, {1e-6, 1e-2},
                                              {1e-7, 1e-2}, {1e-5, 1e-2}, {1e-5, 1e-2}};

/* ---- a run ---- */

typedef struct {
  const Reference *r;
  PetscInt f, jacobians, at;
  double t, before, integral;
} Run;

static PetscErrorCode Rhs(TS ts, PetscReal t, Vec y, Vec f, void *ctx)
{
  Run *run = (Run *)ctx;
  const PetscScalar *a;
  PetscScalar *b;

  run->f++;
  PetscCheck(run->f <= MAX_WORK, PETSC_COMM_SELF, PETSC_ERR_CONV_FAILED, "More than %d evaluations", (int)MAX_WORK);
  a = VecRead(y);
  PetscCall(VecGetArrayWrite(f, &b));
  (*run->r->c->f)(t, a, b);
  return VecRestoreArrayWrite(f, &b);
}

static PetscErrorCode IFunction(TS ts, PetscReal t, Vec y, Vec ydot, Vec F, void *ctx)
{
  PetscCall(Rhs(ts, t, y, F, ctx));
  return VecAYPX(F, -1, ydot);
}

/* shift I + factor df/dy */
static PetscErrorCode Differences(PetscReal t, Vec y, Mat P, PetscReal shift, PetscReal factor, Run *run)
{
  const Reference *r = run->r;
  const int n = r->c->n;
  const PetscScalar *a;
  PetscScalar *J;
  double z[MAX_N], f[MAX_N], g[MAX_N];

  run->jacobians++;
  a = VecRead(y);
  for (int i = 0; i < n; i++) z[i] = a[i];
  (*r->c->f)(t, z, f);
  PetscCall(MatDenseGetArrayWrite(P, &J));
  for (int j = 0; j < n; j++) {
    const double keep = z[j], step = 1e-7 * (fabs(keep) + 1e-3 * r->scale[j]);

    z[j] += step;
    (*r->c->f)(t, z, g);
    for (int i = 0; i < n; i++) J[j * n + i] = factor * (g[i] - f[i]) / (z[j] - keep) + (i == j ? shift : 0);
    z[j] = keep;
  }
  PetscCall(MatDenseRestoreArrayWrite(P, &J));
  return MatAssemble(P);
}

static PetscErrorCode Jacobian(TS ts, PetscReal t, Vec y, Mat J, Mat P, void *ctx)
{
  return Differences(t, y, P, 0, 1, (Run *)ctx);
}

static PetscErrorCode IJacobian(TS ts, PetscReal t, Vec y, Vec ydot, PetscReal shift, Mat J, Mat P, void *ctx)
{
  return Differences(t, y, P, shift, -1, (Run *)ctx);
}

static PetscErrorCode Measure(TS ts, PetscInt step, PetscReal t, Vec y, void *ctx)
{
  Run *run = (Run *)ctx;
  const PetscScalar *a;
  double now;

  if (step <= 0 || t <= run->t) return PETSC_SUCCESS;
  a = VecRead(y);
  now = ReferenceDeviation(run->r, t, a, &run->at);
  run->integral += 0.5 * (t - run->t) * (run->before + now);
  run->before = now;
  run->t = t;
  return PETSC_SUCCESS;
}

/* basic, basic:DELAY (attempts without growth after a failed solve), dsp:FILTER, pi, heuristic, rl or rl:FILE */
static PetscErrorCode SetController(TS ts, const char controller[])
{
  char type[32];
  const char *of = strchr(controller, ':');
  TSAdapt adapt;

  PetscCall(PetscStrncpy(type, controller, of ? (size_t)(of - controller) + 1 : sizeof(type)));
  PetscCall(TSGetAdapt(ts, &adapt));
  PetscCall(TSAdaptSetType(adapt, type));
  if (of && !strcmp(type, "basic"))
    PetscCall(TSAdaptSetTimeStepIncreaseDelay(adapt, (PetscInt)strtol(of + 1, NULL, 10)));
  if (of && !strcmp(type, "dsp")) PetscCall(TSAdaptDSPSetFilter(adapt, of + 1));
  if (of && !strcmp(type, "rl")) PetscCall(TSAdaptRLSetPolicyFile(adapt, of + 1));
  return PETSC_SUCCESS;
}

static PetscErrorCode SetUp(const Reference *r, Method method, double tol, Run *run, TS *ts, Vec *y)
{
  const int n = r->c->n;
  PetscScalar *a;
  Vec atol;
  Mat J;
  SNES snes;
  KSP ksp;
  PC pc;

  PetscCall(VecCreateSeq(PETSC_COMM_SELF, n, y));
  PetscCall(VecDuplicate(*y, &atol));
  PetscCall(VecGetArray(*y, &a));
  for (int i = 0; i < n; i++) a[i] = r->y0[i];
  PetscCall(VecRestoreArray(*y, &a));
  PetscCall(VecGetArray(atol, &a));
  for (int i = 0; i < n; i++) a[i] = tol * r->scale[i];
  PetscCall(VecRestoreArray(atol, &a));
  PetscCall(MatCreateSeqDense(PETSC_COMM_SELF, n, n, NULL, &J));
  PetscCall(TSCreate(PETSC_COMM_SELF, ts));
  PetscCall(TSSetType(*ts, method <= RK5 ? TSRK : method <= ARK4 ? TSARKIMEX : method == BDF ? TSBDF : "bathe"));
  if (method <= RK5) PetscCall(TSRKSetType(*ts, method == RK3 ? TSRK3BS : TSRK5DP));
  if (method == ARK3 || method == ARK4) PetscCall(TSARKIMEXSetType(*ts, method == ARK3 ? TSARKIMEX3 : TSARKIMEX4));
  if (method == BDF) PetscCall(TSBDFSetOrder(*ts, 2));
  if (method == ARK3 || method == ARK4 || method == BDF) {
    PetscCall(TSSetIFunction(*ts, NULL, IFunction, run));
    PetscCall(TSSetIJacobian(*ts, J, J, IJacobian, run));
  } else {
    PetscCall(TSSetRHSFunction(*ts, NULL, Rhs, run));
    PetscCall(TSSetRHSJacobian(*ts, J, J, Jacobian, run));
  }
  PetscCall(TSSetTolerances(*ts, 0, atol, tol, NULL));
  PetscCall(TSSetMaxTime(*ts, r->c->end));
  PetscCall(TSSetTimeStep(*ts, 1e-5 * r->c->end));
  PetscCall(TSSetMaxSteps(*ts, MAX_STEPS));
  PetscCall(TSSetMaxSNESFailures(*ts, -1));
  PetscCall(TSSetErrorIfStepFails(*ts, PETSC_FALSE));
  PetscCall(TSSetExactFinalTime(*ts, TS_EXACTFINALTIME_MATCHSTEP));
  PetscCall(TSMonitorSet(*ts, Measure, run, NULL));
  PetscCall(TSGetSNES(*ts, &snes));
  PetscCall(SNESSetTolerances(snes, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT, NEWTON, PETSC_DEFAULT));
  PetscCall(SNESGetKSP(snes, &ksp));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(KSPSetType(ksp, KSPPREONLY));
  PetscCall(PCSetType(pc, PCLU));
  return DestroyObjects(&J, &atol);
}

static PetscErrorCode RunOne(const Reference *r, Method method, const char controller[], double tol)
{
  Run run = {.r = r};
  PetscInt steps, rejected;
  PetscErrorCode ierr;
  TSConvergedReason reason;
  TS ts;
  Vec y;
  double error;

  PetscCall(SetUp(r, method, tol, &run, &ts, &y));
  PetscCall(SetController(ts, controller));
  PetscCall(PetscPushErrorHandler(PetscReturnErrorHandler, NULL));
  ierr = TSSolve(ts, y);
  PetscCall(PetscPopErrorHandler());
  PetscCall(TSGetConvergedReason(ts, &reason));
  PetscCall(TSGetStepNumber(ts, &steps));
  PetscCall(TSGetStepRejections(ts, &rejected));
  error = sqrt(run.integral / r->c->end);
  printf("%s %s %s %.3e %d %.6e %d %d %s\n", r->c->name, MethodNames[method], controller, tol,
         (int)(run.f + run.jacobians), error, (int)steps, (int)rejected,
         ierr                                           ? "error"
         : reason < 0 || run.t < r->c->end * (1 - 1e-9) ? "not_reached"
         : isfinite(error)                              ? "end"
                                                        : "nan");
  return DestroyObjects(&ts, &y);
}

static PetscErrorCode RunAll(void)
{
  char *problems[32], *controllers[32];
  PetscInt nproblems = 32, ncontrollers = 32;

  PetscOptionsBegin(PETSC_COMM_SELF, NULL, "Benchmark of controllers", "");
  PetscCall(PetscOptionsStringArray("-bench_problems", "Names of problems (all)", "", problems, &nproblems, NULL));
  PetscCall(PetscOptionsStringArray("-bench_controllers", "basic, basic:DELAY, dsp:FILTER, pi, heuristic, rl, rl:FILE",
                                    "", controllers, &ncontrollers, NULL));
  PetscOptionsEnd();
  for (size_t k = 0; Cases[k].name; k++) {
    PetscBool wanted = nproblems ? PETSC_FALSE : PETSC_TRUE;
    Reference r;

    for (PetscInt i = 0; i < nproblems; i++)
      if (!strcmp(problems[i], Cases[k].name)) wanted = PETSC_TRUE;
    if (!wanted) continue;
    PetscCall(ReferenceCreate(&Cases[k], &r));
    for (int m = 0; m < METHODS; m++) {
      if (!(Cases[k].methods & M(m))) continue;
      for (PetscInt c = 0; c < ncontrollers; c++)
        for (int i = 0; i < TOLERANCES; i++)
          PetscCall(RunOne(&r, (Method)m, controllers[c],
                           Tolerances[m][1] * pow(Tolerances[m][0] / Tolerances[m][1], i / (TOLERANCES - 1.))));
    }
    fflush(stdout);
    PetscCall(PetscFree(r.rows));
  }
  for (PetscInt i = 0; i < nproblems; i++) PetscCall(PetscFree(problems[i]));
  for (PetscInt i = 0; i < ncontrollers; i++) PetscCall(PetscFree(controllers[i]));
  return PETSC_SUCCESS;
}

int main(int argc, char **argv)
{
  PetscCall(PetscInitialize(&argc, &argv, NULL, help));
  PetscCall(SlipStepInitializePackage());
  PetscCall(SlipErrorHandlerPush("ode"));
  PetscCall(RunAll());
  return PetscFinalize();
}
