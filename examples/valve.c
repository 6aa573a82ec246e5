static const char help[] =
  "A fault as a valve: fluid diffuses along its plane, the more easily the more it has slipped and the higher the "
  "pressure is, and weakens it.\n  valve -fault_nx 24 -fault_nz 20 -fault_length_x 2400 -fault_length_z 2000 "
  "-fault_depth_top 2000 -fault_inertia no -fault_viscosity radiation -fault_normal_stress 40e6 "
  "-fault_normal_stress_gradient 0 -fault_friction_slip 0.05 -fault_initial traction -fault_initial_traction 21e6 "
  "-valve_points 1200,3000 -valve_pressures 3.5e6 -valve_stop 20d -valve_slip_factor 10 -ts_max_time 40d "
  "-fault_output run.h5\nAll else is as in fault, on a uniform grid.\n\n";

#include <slipstep.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/*
  The pore pressure p of a layer along the fault obeys

     dp/dt = div(D grad p) + 4 pi D0 sum_k p*_k delta(x - x_k),
     D = D0 (1 + F (1 - exp(-s/L))) exp(p/S),

  with s the slip so far (permeability that shear dilates grows to 1 + F times its start within some L) and
  exp(p/S) the effect of pressure (Rice 1992: k falls exponentially with the effective normal stress). With F = 0 and
  without S each point is the source p* E1(r^2/(4 D0 t)) of -fault_injection, in the cells of a finite plane whose
  edges are closed or at p = 0.

  Finite volumes, harmonic means of D at faces, and backward Euler in steps of -valve_step, with D of their start. The
  slip is that of the start of the fault's step: between accepted steps the pressure is a function of the time alone, as
  SlipFaultSetPressureFunction() asks, and it is continuous. Both make errors of first order in the steps: halve
  -valve_step and -ts_adapt_dt_max to see them.
*/
enum { MOST_POINTS = 64 };

/* A state of the fluid, and how far it has been followed from there by whole steps */
typedef struct {
  PetscReal time;
  Vec p, slip; /* [Pa], [m] */
  PetscInt steps;
  Vec now; /* after so many steps; valid if steps > 0 */
} Base;

typedef struct {
  PetscReal point[2 * MOST_POINTS], pressure[MOST_POINTS], diffusivity, stop, slip_factor, slip, scale, step;
  PetscInt points;
  PetscBool open;
  PetscInt nx, nz, cell[MOST_POINTS];
  PetscReal d[2];  /* sides of a cell along strike and down dip [m] */
  Base base[2];    /* of the start of the last step and of its end: 0 and 1 */
  Vec D, all, rhs; /* diffusivity [m^2/s], here and of all cells */
  VecScatter gather;
  Mat A;
  KSP ksp;
} Valve;

/* ---- options ---- */

/* A list of numbers: PETSc's own error would not name the option */
static PetscErrorCode CheckList(const char option[])
{
  char text[1024], **words;
  int n;
  PetscBool set;

  PetscFunctionBeginUser;
  PetscCall(PetscOptionsGetString(NULL, NULL, option, text, sizeof(text), &set));
  if (!set) PetscFunctionReturn(0);
  PetscCall(PetscStrToArray(text, ',', &n, &words));
  for (int i = 0; i < n; i++) {
    char *end;

    PetscCheck(isfinite(strtod(words[i], &end)) && end != words[i] && !*end, PETSC_COMM_WORLD, PETSC_ERR_ARG_WRONG,
               "%s is \"%s\": \"%s\" is no finite number", option, text, words[i]);
  }
  PetscCall(PetscStrToArrayDestroy(n, words));
  PetscFunctionReturn(0);
}

static PetscErrorCode Options(Valve *v)
{
  char edges[16] = "closed";
  PetscInt n = 2 * MOST_POINTS, m = MOST_POINTS;
  PetscBool open, closed, only_help;
  PetscMPIInt rank;
  const struct {
    const char *name, *help, *unit;
    PetscReal *value;
    PetscBool zero; /* is a value */
    PetscReal least, most;
    const char *small, *large; /* what other magnitudes look like */
  } row[] = {
    {"-valve_diffusivity", "Hydraulic diffusivity D0 at the start [m^2/s]", "m^2/s", &v->diffusivity, PETSC_FALSE, 1e-7,
     1e3, "km^2/s", "m^2/day or mm^2/s"},
    {"-valve_stop", "When the injection stops [s]; 0: never", "s", &v->stop, PETSC_TRUE, 1e-6, 3.2e10, "years",
     "less than a s"},
    {"-valve_slip_factor", "F: slip multiplies the diffusivity by up to 1 + F", "", &v->slip_factor, PETSC_TRUE, 0,
     PETSC_MAX_REAL, "", ""},
    {"-valve_slip", "L: slip within which it does [m]", "m", &v->slip, PETSC_FALSE, 1e-7, 20, "km", "mm"},
    {"-valve_pressure_scale", "S: the diffusivity grows by exp(p/S) [Pa]; 0: it does not", "Pa", &v->scale, PETSC_TRUE,
     100, 1e10, "MPa", "less than a Pa"},
    {"-valve_step", "Step of the diffusion [s]", "s", &v->step, PETSC_FALSE, 1e-6, 3.2e10, "years", "less than a s"}};

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
  v->diffusivity = 0.05;
  v->slip = 0.01;
  v->step = 3600;
  PetscCall(SlipDeclareTimes("valve_stop valve_step"));
  PetscCall(SlipExpandTimes(NULL));
  PetscCall(CheckList("-valve_points"));
  PetscCall(CheckList("-valve_pressures"));
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(row); i++)
    PetscCall(SlipCheckFiniteOption(PETSC_COMM_WORLD, row[i].name));
  PetscOptionsBegin(PETSC_COMM_WORLD, NULL, "Fluid in a fault", NULL);
  PetscCall(PetscOptionsRealArray("-valve_points",
                                  "Points of injection x,z,x,z,...: along strike from the edge, and depth [m]", NULL,
                                  v->point, &n, NULL));
  PetscCall(PetscOptionsRealArray("-valve_pressures", "Strength p* = Q eta/(4 pi k h) of each point [Pa]", NULL,
                                  v->pressure, &m, NULL));
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(row); i++)
    PetscCall(PetscOptionsReal(row[i].name, row[i].help, NULL, *row[i].value, row[i].value, NULL));
  PetscCall(PetscOptionsString("-valve_edges",
                               "closed: nothing flows through the edges of the fault; open: p is 0 there", NULL, edges,
                               edges, sizeof(edges), NULL));
  PetscOptionsEnd();
  PetscCall(PetscOptionsHasHelp(NULL, &only_help)); /* which needs no points */
  PetscCheck((n > 0 && n == 2 * m) || only_help, PETSC_COMM_WORLD, PETSC_ERR_ARG_SIZ,
             "-valve_points has %" PetscInt_FMT " numbers and -valve_pressures %" PetscInt_FMT
             ", expected two and one for each of at most %d points",
             n, m, MOST_POINTS);
  v->points = m;
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(row); i++) {
    char what[64];

    PetscCheck(*row[i].value > 0 || (row[i].zero && *row[i].value == 0), PETSC_COMM_WORLD, PETSC_ERR_ARG_OUTOFRANGE,
               "%s is %.6g, expected a number %s 0%s%s", row[i].name, (double)*row[i].value, row[i].zero ? ">=" : ">",
               row[i].unit[0] ? " " : "", row[i].unit);
    PetscCall(PetscSNPrintf(what, sizeof(what), "%s is", row[i].name));
    if (!rank)
      PetscCall(
        SlipWarnOfUnit(what, *row[i].value, row[i].unit, row[i].least, row[i].most, row[i].small, row[i].large));
  }
  for (PetscInt k = 0; k < m && !rank; k++)
    PetscCall(SlipWarnOfUnit("-valve_pressures has", v->pressure[k], "Pa", 100, 1e10, "MPa", "less than a Pa"));
  PetscCall(PetscStrcmp(edges, "open", &open));
  PetscCall(PetscStrcmp(edges, "closed", &closed));
  PetscCheck(open || closed, PETSC_COMM_WORLD, PETSC_ERR_ARG_WRONG, "-valve_edges is \"%s\", expected closed or open",
             edges);
  v->open = open;
  PetscFunctionReturn(0);
}

/* ---- one step of the diffusion ---- */

/* D of all cells on all processes, by the pressure p and the slip */
static PetscErrorCode Diffusivity(Valve *v, Vec p, Vec slip)
{
  const PetscReal *a, *s;
  PetscReal *D;
  PetscInt n;

  PetscFunctionBeginUser;
  PetscCall(VecGetLocalSize(p, &n));
  PetscCall(VecGetArrayRead(p, &a));
  PetscCall(VecGetArrayRead(slip, &s));
  PetscCall(VecGetArrayWrite(v->D, &D));
  for (PetscInt i = 0; i < n; i++)
    D[i] = v->diffusivity * (1 - v->slip_factor * expm1(-s[i] / v->slip)) * (v->scale > 0 ? exp(a[i] / v->scale) : 1);
  PetscCall(VecRestoreArrayWrite(v->D, &D));
  PetscCall(VecRestoreArrayRead(slip, &s));
  PetscCall(VecRestoreArrayRead(p, &a));
  PetscCall(VecScatterBegin(v->gather, v->D, v->all, INSERT_VALUES, SCATTER_FORWARD));
  PetscCall(VecScatterEnd(v->gather, v->D, v->all, INSERT_VALUES, SCATTER_FORWARD));
  PetscFunctionReturn(0);
}

/* A = 1 + dt L, L p = -div(D grad p); at open edges D is that of p = 0 */
static PetscErrorCode Operator(Valve *v, Vec p, PetscReal dt)
{
  const PetscReal *D, *a;
  PetscInt begin, end;

  PetscFunctionBeginUser;
  PetscCall(VecGetArrayRead(p, &a));
  PetscCall(VecGetArrayRead(v->all, &D));
  PetscCall(MatGetOwnershipRange(v->A, &begin, &end));
  for (PetscInt e = begin; e < end; e++) {
    const PetscInt at[2] = {e % v->nx, e / v->nx}, size[2] = {v->nx, v->nz}, next[2] = {1, v->nx};
    PetscReal value[5] = {1}, flow;
    PetscInt column[5] = {e}, n = 1;

    for (PetscInt k = 0; k < 4; k++) { /* along strike and down dip, back and forth */
      const PetscInt way = k / 2, step = k % 2 ? 1 : -1, to = e + step * next[way];

      if (at[way] + step < 0 || at[way] + step >= size[way]) {
        const PetscReal edge = v->scale > 0 ? exp(-a[e - begin] / v->scale) : 1;

        if (v->open) value[0] += dt * 4 * D[e] * edge / (1 + edge) / PetscSqr(v->d[way]);
        continue;
      }
      flow = dt * 2 * D[e] * D[to] / (D[e] + D[to]) / PetscSqr(v->d[way]);
      value[0] += flow;
      value[n] = -flow;
      column[n++] = to;
    }
    PetscCall(MatSetValues(v->A, 1, &e, n, column, value, INSERT_VALUES));
  }
  PetscCall(VecRestoreArrayRead(v->all, &D));
  PetscCall(VecRestoreArrayRead(p, &a));
  PetscCall(MatAssemblyBegin(v->A, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(v->A, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(0);
}

/* From p at the time t to q at t + dt; q may be p */
static PetscErrorCode Step(Valve *v, PetscReal t, PetscReal dt, Vec slip, Vec p, Vec q)
{
  const PetscReal on =
    v->stop > 0 ? PetscClipInterval(v->stop - t, 0, dt) : dt; /* for how long of it fluid is injected */
  PetscInt begin, end;

  PetscFunctionBeginUser;
  PetscCall(Diffusivity(v, p, slip));
  PetscCall(Operator(v, p, dt));
  PetscCall(VecCopy(p, v->rhs));
  PetscCall(VecGetOwnershipRange(p, &begin, &end));
  for (PetscInt k = 0; k < v->points; k++)
    if (v->cell[k] >= begin && v->cell[k] < end)
      PetscCall(VecSetValue(v->rhs, v->cell[k],
                            on * 4 * PETSC_PI * v->diffusivity * v->pressure[k] / (v->d[0] * v->d[1]), ADD_VALUES));
  PetscCall(VecAssemblyBegin(v->rhs));
  PetscCall(VecAssemblyEnd(v->rhs));
  PetscCall(KSPSetOperators(v->ksp, v->A, v->A));
  PetscCall(KSPSolve(v->ksp, v->rhs, q));
  PetscFunctionReturn(0);
}

/* The pressure q at t >= base->time */
static PetscErrorCode Follow(Valve *v, Base *base, PetscReal t, Vec q)
{
  const PetscInt steps = (PetscInt)PetscFloorReal(PetscMax(t - base->time, 0) / v->step);
  PetscReal rest;

  PetscFunctionBeginUser;
  if (steps < base->steps) base->steps = 0;
  if (!base->steps) PetscCall(VecCopy(base->p, base->now));
  for (; base->steps < steps; base->steps++)
    PetscCall(Step(v, base->time + (PetscReal)base->steps * v->step, v->step, base->slip, base->now, base->now));
  rest = t - base->time - (PetscReal)steps * v->step;
  if (rest > 0)
    PetscCall(Step(v, t - rest, rest, base->slip, base->now, q));
  else
    PetscCall(VecCopy(base->now, q));
  PetscFunctionReturn(0);
}

/* ---- what the fault asks ---- */

static PetscErrorCode Pressure(SlipFault fault, PetscReal t, PetscInt n, PetscReal p[], void *ctx)
{
  Valve *v = (Valve *)ctx;
  Base *base = &v->base[t >= v->base[1].time ? 1 : 0];
  const PetscReal *a;
  Vec q;

  PetscFunctionBeginUser;
  (void)fault;
  PetscCall(VecDuplicate(v->rhs, &q));
  PetscCall(Follow(v, base, t, q));
  PetscCall(VecGetArrayRead(q, &a));
  PetscCall(PetscArraycpy(p, a, n));
  PetscCall(VecRestoreArrayRead(q, &a));
  PetscCall(VecDestroy(&q));
  PetscFunctionReturn(0);
}

/* After an accepted step: the fluid goes on from its end, with the slip there */
static PetscErrorCode Accept(SlipFault fault, TS ts, PetscInt number, PetscReal t, Vec w, void *ctx)
{
  Valve *v = (Valve *)ctx;
  const Base last = v->base[0];
  PetscInt begin, end;
  PetscReal *slip, *all;

  PetscFunctionBeginUser;
  (void)ts, (void)number;
  v->base[0] = v->base[1];
  v->base[1] = last; /* its vectors, for the new one */
  PetscCall(Follow(v, &v->base[0], t, v->base[1].p));
  v->base[1].time = t;
  v->base[1].steps = 0;
  PetscCall(PetscMalloc1(v->nx * v->nz, &all));
  PetscCall(SlipFaultGetCellValues(fault, t, w, "slip", v->nx * v->nz, all));
  PetscCall(VecGetOwnershipRange(v->base[1].slip, &begin, &end));
  PetscCall(VecGetArrayWrite(v->base[1].slip, &slip));
  for (PetscInt e = begin; e < end; e++) slip[e - begin] = PetscAbsReal(all[e]);
  PetscCall(VecRestoreArrayWrite(v->base[1].slip, &slip));
  PetscCall(PetscFree(all));
  PetscFunctionReturn(0);
}

/* What checkpoints hold, and runs that go on read */
static PetscErrorCode Visit(SlipFault fault, SlipState state, void *ctx)
{
  Valve *v = (Valve *)ctx;

  PetscFunctionBeginUser;
  (void)fault;
  for (int k = 0; k < 2; k++) {
    const char *const names[2][3] = {{"time_0", "pressure_0", "slip_0"}, {"time_1", "pressure_1", "slip_1"}};

    PetscCall(SlipStateReal(state, names[k][0], 1, &v->base[k].time));
    PetscCall(SlipStateVec(state, names[k][1], v->base[k].p));
    PetscCall(SlipStateVec(state, names[k][2], v->base[k].slip));
    if (SlipStateIsLoading(state)) v->base[k].steps = 0;
  }
  PetscFunctionReturn(0);
}

static PetscErrorCode SetUp(Valve *v, SlipFault fault)
{
  char mesh[PETSC_MAX_PATH_LEN];
  PetscReal number, length[2], *z;
  PetscInt n = PETSC_DECIDE, N;

  PetscFunctionBeginUser;
  PetscCall(Options(v));
  PetscCall(SlipFaultGetString(fault, "mesh", mesh, sizeof(mesh)));
  PetscCheck(!mesh[0], PETSC_COMM_WORLD, PETSC_ERR_SUP,
             "-fault_mesh %s: the fluid of this program is on a uniform grid, expected -fault_nx and -fault_nz", mesh);
  PetscCall(SlipFaultSetUpMesh(fault));
  PetscCall(SlipFaultGetReal(fault, "nx", &number));
  v->nx = (PetscInt)number;
  PetscCall(SlipFaultGetReal(fault, "nz", &number));
  v->nz = (PetscInt)number;
  PetscCall(SlipFaultGetReal(fault, "length_x", &length[0]));
  PetscCall(SlipFaultGetReal(fault, "length_z", &length[1]));
  v->d[0] = length[0] / (PetscReal)v->nx;
  v->d[1] = length[1] / (PetscReal)v->nz;
  N = v->nx * v->nz;
  PetscCall(PetscMalloc1(N, &z));
  PetscCall(SlipFaultGetGeometry(fault, "z", N, z));
  for (PetscInt k = 0; k < v->points; k++) { /* the cell that has the point */
    const PetscReal x = v->point[2 * k], half = v->nz > 1 ? (z[v->nx] - z[0]) / 2 : v->d[1] / 2;
    PetscInt row = 0;

    while (row < v->nz && v->point[2 * k + 1] > z[row * v->nx] + half) row++;
    PetscCheck(x >= 0 && x <= length[0] && row < v->nz && v->point[2 * k + 1] >= z[0] - half, PETSC_COMM_WORLD,
               PETSC_ERR_ARG_OUTOFRANGE,
               "-valve_points: x = %.6g, z = %.6g is not on the fault, expected 0 <= x <= %.6g m and a depth from %.6g "
               "to %.6g m",
               (double)x, (double)v->point[2 * k + 1], (double)length[0], (double)(z[0] - half),
               (double)(z[N - 1] + half));
    v->cell[k] = row * v->nx + PetscMin((PetscInt)(x / v->d[0]), v->nx - 1);
  }
  PetscCall(PetscFree(z));
  PetscCall(PetscSplitOwnership(PETSC_COMM_WORLD, &n, &N)); /* as cells are distributed */
  PetscCall(MatCreateAIJ(PETSC_COMM_WORLD, n, n, N, N, 5, NULL, 4, NULL, &v->A));
  PetscCall(MatCreateVecs(v->A, &v->rhs, &v->D));
  for (int k = 0; k < 2; k++) {
    Vec *vecs[] = {&v->base[k].p, &v->base[k].slip, &v->base[k].now};

    for (int i = 0; i < 3; i++) {
      PetscCall(VecDuplicate(v->rhs, vecs[i]));
      PetscCall(VecSet(*vecs[i], 0));
    }
  }
  PetscCall(VecScatterCreateToAll(v->D, &v->gather, &v->all));
  PetscCall(KSPCreate(PETSC_COMM_WORLD, &v->ksp));
  PetscCall(KSPSetType(v->ksp, KSPCG));
  PetscCall(KSPSetTolerances(v->ksp, 1e-10, 1e-50, PETSC_DEFAULT, 10000));
  PetscCall(KSPSetErrorIfNotConverged(v->ksp, PETSC_TRUE));
  PetscCall(KSPSetOptionsPrefix(v->ksp, "valve_"));
  PetscCall(KSPSetFromOptions(v->ksp));
  PetscCall(SlipFaultSetPressureFunction(fault, Pressure, v));
  PetscFunctionReturn(0);
}

static PetscErrorCode Destroy(Valve *v)
{
  PetscFunctionBeginUser;
  for (int k = 0; k < 2; k++) {
    PetscCall(VecDestroy(&v->base[k].p));
    PetscCall(VecDestroy(&v->base[k].slip));
    PetscCall(VecDestroy(&v->base[k].now));
  }
  PetscCall(VecDestroy(&v->D));
  PetscCall(VecDestroy(&v->all));
  PetscCall(VecDestroy(&v->rhs));
  PetscCall(VecScatterDestroy(&v->gather));
  PetscCall(MatDestroy(&v->A));
  PetscCall(KSPDestroy(&v->ksp));
  PetscFunctionReturn(0);
}

/* ---- the run ---- */

static PetscErrorCode Run(int *code)
{
  PetscBool only_help, complete = PETSC_TRUE;
  Valve valve = {.points = 0};
  const SlipFaultObserver observer = {.name = "valve", .step = Accept, .visit = Visit, .ctx = &valve};
  SlipFault fault;
  TS ts;
  Vec w;

  PetscFunctionBeginUser;
  PetscCall(PetscOptionsHasHelp(NULL, &only_help));
  PetscCall(SlipDeclareOptions("valve_", "points pressures diffusivity stop slip_factor slip pressure_scale step edges "
                                         "ksp_* pc_*"));
  PetscCall(SlipCheckOptionNames());
  PetscCall(SlipFaultRegisterObserver(&observer));
  PetscCall(SlipFaultCreate(PETSC_COMM_WORLD, &fault));
  PetscCall(SlipFaultSetReal(fault, "nx", 10));
  PetscCall(SlipFaultSetReal(fault, "nz", 10));
  PetscCall(SlipFaultSetFromOptions(fault));
  PetscCall(SetUp(&valve, fault));
  PetscCall(SlipFaultSetUp(fault));
  PetscCall(SlipFaultCreateState(fault, &w));
  PetscCall(SlipFaultSetInitialState(fault, w));
  PetscCall(TSCreate(PETSC_COMM_WORLD, &ts));
  PetscCall(SlipFaultConfigureTS(fault, ts));
  PetscCall(TSSetSolution(ts, w));
  PetscCall(SlipCheckSolverOptions(ts));
  PetscCall(TSSetFromOptions(ts));
  if (!only_help) {
    PetscCall(SlipCheckUnusedOptions());
    PetscCall(SlipFaultOutputStart(fault, ts));
    PetscCall(SlipFaultCheckpointStart(fault, ts));
    PetscCall(TSSolve(ts, w));
    PetscCall(SlipFaultCheckpointFinish(fault, ts, code));
    if (*code)
      PetscCall(SlipFaultReportStop(fault, ts, 0, 0));
    else {
      PetscCall(SlipFaultOutputFinish(fault, ts, 0, 0));
      PetscCall(SlipFaultReportEnd(fault, ts, &complete));
    }
    if (!complete) *code = SLIP_EXIT_INCOMPLETE;
    PetscCall(SlipWarnOfUnusedOptions());
  }
  PetscCall(VecDestroy(&w));
  PetscCall(TSDestroy(&ts));
  PetscCall(SlipFaultDestroy(&fault));
  PetscCall(Destroy(&valve));
  PetscFunctionReturn(0);
}

int main(int argc, char **argv)
{
  int code = 0;

  PetscFunctionBeginUser;
  PetscCall(SlipProgramInitialize(&argc, &argv, "valve", help));
  PetscCall(SlipStepInitializePackage());
  PetscCall(SlipSignalsPush());
  PetscCall(Run(&code));
  PetscCall(PetscFinalize());
  return code;
}
