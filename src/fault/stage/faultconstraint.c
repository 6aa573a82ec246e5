/* Formulates the fault's constraint: eliminates u and s from a stage, and bounds the reaction by the strength. */
#include <slipstep/private/slipfault.h>
#include <slipstep/private/slipsnes.h>
#include <slipstep/private/slipsys.h>
#include <slipstep/private/slipwork.h>

/* Computes u0 = base_u + theta (ex_u - v_inf), s0 = base_s + theta ex_s, c = (w M/theta) base_v + ex_v, w: the weights.
   Without inertia the balance is that of the stage's end alone. */
PetscErrorCode SlipFaultHostEliminate(SlipFault fault, const SlipStage *stage)
{
  const PetscReal theta = stage->theta;
  const PetscInt n = fault->layout.components;
  const PetscReal *base, *ex = NULL, *vinf;
  PetscReal *c, *u0, *s0;
  const SlipArrays arrays[] = {{stage->base, .read = &base},           {stage->explicit_part, .read = &ex},
                               {fault->operators.vinf, .read = &vinf}, {fault->stage.c, .write = &c},
                               {fault->stage.u0, .write = &u0},        {fault->stage.s0, .write = &s0}};

  PetscFunctionBegin;
  PetscCall(SlipArraysGet(6, arrays));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    for (PetscInt k = n * i; k < n * (i + 1); k++) {
      const PetscInt rate = SlipFaultRateAt(fault, i) + k - n * i,
                     displacement = SlipFaultDisplacementAt(fault, i) + k - n * i;

      c[k] = 0;
      if (fault->kind.inertia)
        c[k] = fault->mesh.weight[i] * (fault->operators.mass / theta) * base[rate] + (ex ? ex[rate] : 0);
      u0[k] = base[displacement] + theta * ((ex ? ex[displacement] : 0) - vinf[k]);
    }
    /* A base below 0 belongs to a cell that has closed since the step's start, as a w1 - b w0 with w1 = 0: backward
       differences across an impact would let it bounce. */
    if (SlipFaultOpens(fault) && base[SlipFaultDisplacementAt(fault, i) + 2] < 0) {
      const PetscReal fall = base[SlipFaultRateAt(fault, i) + 2];

      u0[3 * i + 2] -= base[SlipFaultDisplacementAt(fault, i) + 2];
      if (fault->kind.inertia && fall > 0)
        c[3 * i + 2] -= fault->mesh.weight[i] * (fault->operators.mass / theta) * fall;
    }
    for (PetscInt k = 0, from = SlipFaultStateAt(fault, i), m = fault->layout.states; k < m; k++)
      s0[m * i + k] = base[from + k] + theta * (ex ? ex[from + k] : 0);
  }
  PetscCall(SlipArraysRestore(6, arrays));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Where cells open, x is the rate that opens a cell from the closed state: w/theta of the stage's end, as only this
   must not be negative. There v = x - u0/theta, so that B v - c = B x - (c + B u0/theta), for the opening in u0. */
static PetscErrorCode CountFromClosed(SlipFault fault)
{
  PetscReal *a, any = 0;
  Vec open, force;
  Mat B;

  PetscFunctionBegin;
  if (!SlipFaultOpens(fault)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipFaultGetWork(fault, &open));
  PetscCall(SlipFaultGetWork(fault, &force));
  PetscCall(VecCopy(fault->stage.u0, open));
  PetscCall(VecGetArray(open, &a));
  for (PetscInt i = 0; i < 3 * fault->mesh.n; i += 3) {
    a[i] = a[i + 1] = 0;
    if (a[i + 2] != 0) any = 1;
  }
  PetscCall(VecRestoreArray(open, &a));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &any, 1, MPIU_REAL, MPIU_MAX, fault->comm));
  if (any != 0) {
    PetscCall(SlipElasticGetStage(fault->medium, &B, NULL));
    PetscCall(MatMult(B, open, force));
    PetscCall(VecAXPY(fault->stage.c, 1 / fault->stage.theta, force));
  }
  PetscCall(SlipFaultRestoreWork(fault, &force));
  PetscCall(SlipFaultRestoreWork(fault, &open));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* c = (M/theta) base_v + ex_v + (df/dv) v_inf - f(u0, 0, t) + T */
PetscErrorCode SlipFaultConstraintStage(SlipFault fault, const SlipStage *stage)
{
  Vec force, shear;

  PetscFunctionBegin;
  fault->stage.time = stage->t;
  fault->stage.theta = stage->theta;
  fault->stage.last = stage->nfrom > 1 ? PETSC_TRUE : PETSC_FALSE;
  PetscCall(SlipElasticStage(fault->medium, stage->t, stage->theta));
  PetscCall((*fault->cell_ops->eliminate)(fault, stage));
  PetscCall(SlipFaultStoreStart(fault, stage));
  PetscCall(SlipFaultGetWork(fault, &force));
  PetscCall(SlipElasticForce(fault->medium, stage->t, fault->stage.u0, NULL, force, NULL));
  PetscCall(VecAXPY(fault->stage.c, -1, force));
  if (fault->kind.loaded) {
    PetscCall(SlipElasticForce(fault->medium, stage->t, NULL, fault->operators.vinf, force, NULL));
    PetscCall(VecAXPY(fault->stage.c, 1, force));
  }
  PetscCall(SlipFaultRestoreWork(fault, &force));
  PetscCall(SlipFaultGetShear(fault, stage->t, &shear));
  if (shear) PetscCall(VecAXPY(fault->stage.c, 1, shear));
  PetscCall(CountFromClosed(fault));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Stage(SlipConstraint con, const SlipStage *stage, void *ctx)
{
  PetscFunctionBegin;
  (void)con;
  PetscCall(SlipFaultConstraintStage((SlipFault)ctx, stage));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* g = B v - c */
PetscErrorCode SlipFaultConstraintResidual(SlipFault fault, Vec x, Vec g)
{
  PetscFunctionBegin;
  PetscCall(SlipElasticApplyStage(fault->medium, x, g));
  PetscCall(VecAXPY(g, -1, fault->stage.c));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Residual(SlipConstraint con, Vec x, Vec g, void *ctx)
{
  PetscFunctionBegin;
  (void)con;
  PetscCall(SlipFaultConstraintResidual((SlipFault)ctx, x, g));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* G(0) = -c */
static PetscErrorCode AtRest(SlipConstraint con, Vec g, void *ctx)
{
  PetscFunctionBegin;
  (void)con;
  PetscCall(VecCopy(((SlipFault)ctx)->stage.c, g));
  PetscCall(VecScale(g, -1));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Jacobian(SlipConstraint con, Vec x, Mat *B, void *ctx)
{
  PetscFunctionBegin;
  (void)con;
  (void)x;
  PetscCall(SlipElasticGetStage(((SlipFault)ctx)->medium, B, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns |v| of the cells of a vector of slip; for one component v itself, whose sign does not matter to friction. */
static const PetscReal *Speeds(SlipFault fault, const PetscReal v[])
{
  const PetscInt c = fault->layout.components;

  if (c == 1) return v;
  for (PetscInt i = 0; i < fault->mesh.n; i++) fault->layout.sizes[i] = SlipFaultLength(fault, v + c * i);
  return fault->layout.sizes;
}

/* Does the same for a state; for one component v stays in place, a block from the next cell's. */
static const PetscReal *StateSpeeds(SlipFault fault, const PetscReal a[])
{
  if (fault->layout.components == 1) return a + fault->layout.rate;
  for (PetscInt i = 0; i < fault->mesh.n; i++) fault->layout.sizes[i] = SlipFaultSpeed(fault, a, i);
  return fault->layout.sizes;
}

/* Returns the friction of cells whose pressure the constraint finds, as strength over pressure. */
static SlipFrictionCells FrictionOverPressure(SlipFault fault)
{
  SlipFrictionCells friction = SlipFaultCellFriction(fault, fault->coupling.one);

  friction.weight = NULL;
  return friction;
}

/* Computes q_i = mu(s_i, |v_i|) sigma_i, without sigma_i where cells open, and dq_i/d|v_i|; s: at the stage's end. */
PetscErrorCode SlipFaultHostBound(SlipFault fault, Vec x, Vec q, Vec dq)
{
  SlipFrictionCells friction;
  const PetscInt states = fault->layout.states;
  const PetscReal *v, *s0, *speed;
  PetscReal *a, *b = NULL, *factor;
  const SlipArrays arrays[] = {{x, .read = &v}, {fault->stage.s0, .read = &s0}, {q, .write = &a}, {dq, .write = &b}};

  PetscFunctionBegin;
  if (SlipFaultOpens(fault))
    friction = FrictionOverPressure(fault);
  else if (SlipFaultNormalFollows(fault))
    PetscCall(SlipFaultCoupledBound(fault, x, &friction));
  else
    PetscCall(SlipFaultGetFriction(fault, fault->stage.time, &friction));
  PetscCall(SlipArraysGet(4, arrays));
  speed = Speeds(fault, v);
  SlipFrictionStrength(&friction, fault->mesh.n, fault->stage.theta, states, s0, 1, speed, a, b);
  if (fault->zone.presses) PetscCall(SlipFaultZoneOfStage(fault, fault->stage.u0, v, fault->coupling.stress, a, b));
  if (fault->kind.coupled && !SlipFaultOpens(fault)) {
    PetscCall(VecGetArrayWrite(fault->coupling.factor, &factor));
    for (PetscInt i = 0; i < fault->mesh.n; i++)
      factor[i] = friction.stress[i] > 0
                    ? fault->stage.theta * fault->mesh.weight[i] *
                        SlipFrictionStressGain(&friction, i, fault->stage.theta, s0 + states * i, speed[i])
                    : 0;
    PetscCall(VecRestoreArrayWrite(fault->coupling.factor, &factor));
  }
  PetscCall(SlipArraysRestore(4, arrays));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Bound(SlipConstraint con, Vec x, Vec q, Vec dq, void *ctx)
{
  SlipFault fault = (SlipFault)ctx;

  PetscFunctionBegin;
  (void)con;
  SlipWorkCells(fault->mesh.n, fault->layout.components, fault->friction.law->always_slides);
  PetscCall((*fault->cell_ops->bound)(fault, x, q, dq));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets the change of q_i with the slip of all cells: mu_i w_i theta (Kn dv)_i. */
static PetscErrorCode Coupling(SlipConstraint con, Mat *C, Vec a, void *ctx)
{
  SlipFault fault = (SlipFault)ctx;

  PetscFunctionBegin;
  (void)con;
  PetscCall(SlipElasticGetStage(fault->medium, NULL, C));
  PetscCall(VecCopy(fault->coupling.factor, a));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets the friction of the last Bound(), where slip changes normal stress. */
static PetscErrorCode StageFriction(SlipFault fault, SlipFrictionCells *friction)
{
  PetscFunctionBegin;
  if (SlipFaultOpens(fault))
    *friction = FrictionOverPressure(fault);
  else if (SlipFaultNormalFollows(fault))
    *friction = SlipFaultCellFriction(fault, fault->coupling.stress);
  else
    PetscCall(SlipFaultGetFriction(fault, fault->stage.time, friction));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes dq_i/d|v_i| of laws that weaken with slip alone, at the state that the stage starts from. Healing does not
   count: it takes years, and a long stage sets it against the weakening, but instabilities take seconds. */
PetscErrorCode SlipFaultHostStartSlope(SlipFault fault, Vec dq)
{
  SlipFrictionCells friction;
  const PetscReal *s0;
  PetscReal *slope;
  const SlipArrays arrays[] = {{fault->stage.s0, .read = &s0}, {dq, .write = &slope}};

  PetscFunctionBegin;
  PetscCall(StageFriction(fault, &friction));
  PetscCall(SlipArraysGet(2, arrays));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    PetscReal mu, ds, dv;

    SlipFrictionEvaluate(&friction, i, s0 + fault->layout.states * i, 0, &mu, &ds, &dv);
    slope[i] = fault->stage.theta * ds * friction.stress[i] * (friction.weight ? friction.weight[i] : 1);
  }
  PetscCall(SlipArraysRestore(2, arrays));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode StartSlope(SlipConstraint con, Vec dq, void *ctx)
{
  PetscFunctionBegin;
  (void)con;
  PetscCall((*((SlipFault)ctx)->cell_ops->start_slope)((SlipFault)ctx, dq));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Solves each cell's own balance for smooth laws. */
static PetscErrorCode SolveCells(SlipConstraint con, PetscReal omega, Vec D, Vec f, Vec x, PetscBool *unstable,
                                 void *ctx)
{
  SlipFault fault = (SlipFault)ctx;
  const PetscBool *creeps = fault->balance.creeps;
  SlipFrictionCells friction;
  const PetscReal *d, *load, *s0, *vinf;
  PetscReal *v;
  const SlipArrays arrays[] = {{D, .read = &d},
                               {f, .read = &load},
                               {fault->stage.s0, .read = &s0},
                               {fault->operators.vinf, .read = &vinf},
                               {x, .write = &v}};

  PetscFunctionBegin;
  (void)con;
  SlipWorkCells(fault->mesh.n, fault->layout.components, fault->friction.law->always_slides);
  PetscCall(StageFriction(fault, &friction));
  PetscCall(SlipArraysGet(5, arrays));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    const SlipFrictionStageCell cell = {
      .diagonal = d[i], .omega = omega, .theta = fault->stage.theta, .s0 = s0 + fault->layout.states * i};
    PetscBool stable = PETSC_TRUE;

    if (creeps && creeps[i]) { /* the rate is prescribed, and for two components x contains it already */
      if (fault->layout.components == 1) v[i] = vinf[i];
      continue;
    }
    v[i] = SlipFrictionStageRate(&friction, i, &cell, load[i], v[i], &stable);
    if (!stable) *unstable = PETSC_TRUE;
  }
  PetscCall(SlipArraysRestore(5, arrays));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Prescribed(SlipConstraint con, Vec mask, void *ctx)
{
  SlipFault fault = (SlipFault)ctx;
  PetscReal *m;

  PetscFunctionBegin;
  (void)con;
  if (!fault->balance.creeps) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecGetArray(mask, &m));
  for (PetscInt i = 0; i < fault->mesh.n; i++)
    if (fault->balance.creeps[i]) m[i] = 0;
  PetscCall(VecRestoreArray(mask, &m));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Reduce(SlipConstraint con, Vec w, Vec x, void *ctx)
{
  PetscFunctionBegin;
  (void)con;
  PetscCall(SlipFaultGetRate((SlipFault)ctx, w, x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets w = (v, u0 + theta v, s), with the opening counted as in CountFromClosed(). */
PetscErrorCode SlipFaultHostLift(SlipFault fault, Vec x, Vec w)
{
  SlipFrictionCells friction;
  const PetscReal *v, *u0, *s0;
  const PetscInt c = fault->layout.components;
  PetscReal *a;
  const SlipArrays arrays[] = {
    {x, .read = &v}, {fault->stage.u0, .read = &u0}, {fault->stage.s0, .read = &s0}, {w, .write = &a}};

  PetscFunctionBegin;
  if (fault->kind.coupled && fault->friction.follows)
    PetscCall(SlipFaultCoupledBound(fault, x, &friction));
  else
    PetscCall(SlipFaultGetFriction(fault, fault->stage.time, &friction));
  PetscCall(SlipArraysGet(4, arrays));
  for (PetscInt i = 0; i < fault->mesh.n; i++)
    for (PetscInt k = 0; k < c; k++) {
      a[SlipFaultRateAt(fault, i) + k] = v[c * i + k];
      a[SlipFaultDisplacementAt(fault, i) + k] = u0[c * i + k] + fault->stage.theta * v[c * i + k];
    }
  for (PetscInt i = 0; i < fault->mesh.n && SlipFaultOpens(fault); i++) { /* closing cells stop: no bounce */
    const PetscReal open = fault->stage.theta * v[3 * i + 2];

    a[SlipFaultDisplacementAt(fault, i) + 2] = open;
    a[SlipFaultRateAt(fault, i) + 2] = open > 0 ? (open - u0[3 * i + 2]) / fault->stage.theta : 0;
  }
  SlipFrictionStateAdvance(&friction, fault->mesh.n, fault->stage.theta, s0, Speeds(fault, v), fault->layout.block,
                           a + fault->layout.state);
  for (PetscInt i = 0; i < fault->mesh.n && fault->balance.creeps; i++)
    for (PetscInt k = 0, m = fault->layout.states; k < m && fault->balance.creeps[i]; k++)
      a[SlipFaultStateAt(fault, i) + k] = s0[m * i + k];
  PetscCall(SlipArraysRestore(4, arrays));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultConstraintLift(SlipFault fault, Vec x, Vec w)
{
  PetscFunctionBegin;
  PetscCall((*fault->cell_ops->lift)(fault, x, w));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Lift(SlipConstraint con, Vec x, Vec w, void *ctx)
{
  SlipFault fault = (SlipFault)ctx;

  PetscFunctionBegin;
  PetscCall(SlipFaultConstraintLift(fault, x, w));
  if (con->balanced && !SlipFaultOpens(fault)) PetscCall(SlipFaultStoreEnd(fault, con->g, x, w));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Fills F from the force and the rates relative to the far field. */
PetscErrorCode SlipFaultHostSmooth(SlipFault fault, const SlipFrictionCells *friction, Vec w, Vec relative, Vec force,
                                   Vec F)
{
  const PetscInt c = fault->layout.components;
  const PetscReal *a, *r, *f;
  PetscReal *b;
  const SlipArrays arrays[] = {{w, .read = &a}, {relative, .read = &r}, {force, .read = &f}, {F, .write = &b}};

  PetscFunctionBegin;
  PetscCall(SlipArraysGet(4, arrays));
  for (PetscInt i = 0; i < fault->mesh.n; i++)
    for (PetscInt k = 0; k < c; k++) {
      b[SlipFaultRateAt(fault, i) + k] = -f[c * i + k];
      b[SlipFaultDisplacementAt(fault, i) + k] = r[c * i + k];
    }
  SlipFrictionStateRate(friction, fault->mesh.n, fault->layout.block, a + fault->layout.state,
                        c == 1 ? fault->layout.block : 1, StateSpeeds(fault, a), b + fault->layout.state);
  for (PetscInt i = 0; i < fault->mesh.n && fault->balance.creeps; i++)
    for (PetscInt k = 0; k < fault->layout.states && fault->balance.creeps[i]; k++)
      b[SlipFaultStateAt(fault, i) + k] = 0;
  PetscCall(SlipArraysRestore(4, arrays));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes F = (-f(u, v - v_inf, t) + T, v - v_inf, ds/dt), in Pa, m/s, m/s. */
PetscErrorCode SlipFaultSmooth(SlipFault fault, PetscReal t, Vec w, Vec F)
{
  SlipFrictionCells friction;
  Vec rel, u, force, shear;

  PetscFunctionBegin;
  SlipWorkCells(fault->mesh.n, fault->layout.components, fault->friction.law->always_slides);
  if (fault->friction.follows)
    PetscCall(SlipFaultGetFrictionOf(fault, t, w, &friction));
  else
    PetscCall(SlipFaultGetFriction(fault, t, &friction));
  PetscCall(SlipFaultGetWork(fault, &rel));
  PetscCall(SlipFaultGetWork(fault, &u));
  PetscCall(SlipFaultGetWork(fault, &force));
  PetscCall(SlipFaultGetDisplacement(fault, w, u));
  PetscCall(SlipFaultGetRate(fault, w, rel));
  if (fault->kind.loaded) PetscCall(VecAXPY(rel, -1, fault->operators.vinf));
  if (fault->balance.known) { /* an explicit step has cached both */
    Vec damping;

    PetscCall(SlipFaultGetWork(fault, &damping));
    PetscCall(SlipFaultDamping(fault, t, rel, damping));
    PetscCall(SlipFaultForce(fault, t, w, u, force));
    PetscCall(VecAXPY(force, 1, damping));
    PetscCall(SlipFaultRestoreWork(fault, &damping));
  } else
    PetscCall(SlipElasticForce(fault->medium, t, u, rel, force, NULL));
  PetscCall(SlipFaultGetShear(fault, t, &shear));
  if (shear) PetscCall(VecAXPY(force, -1, shear));
  PetscCall((*fault->cell_ops->smooth)(fault, &friction, w, rel, force, F));
  PetscCall(SlipFaultRestoreWork(fault, &force));
  PetscCall(SlipFaultRestoreWork(fault, &u));
  PetscCall(SlipFaultRestoreWork(fault, &rel));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Smooth(SlipConstraint con, PetscReal t, Vec w, Vec Fs, void *ctx)
{
  PetscFunctionBegin;
  (void)con;
  PetscCall(SlipFaultSmooth((SlipFault)ctx, t, w, Fs));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultHostAddReaction(SlipFault fault, PetscReal a, Vec r, Vec F)
{
  const PetscReal *tau;
  PetscReal *f;
  const SlipArrays arrays[] = {{r, .read = &tau}, {F, .write = &f}};

  PetscFunctionBegin;
  PetscCall(SlipArraysGet(2, arrays));
  for (PetscInt i = 0, c = fault->layout.components; i < fault->mesh.n; i++)
    for (PetscInt k = 0; k < c; k++) {
      PetscReal *force = f + SlipFaultRateAt(fault, i) + k;

      if (k < 2)
        *force += a * tau[c * i + k];
      else if (tau[c * i + k] > 0) /* a closed cell stays closed under pressure: r of an impact does not go on */
        *force = 0;
    }
  PetscCall(SlipArraysRestore(2, arrays));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode AddReaction(SlipConstraint con, PetscReal a, Vec r, Vec F, void *ctx)
{
  PetscFunctionBegin;
  (void)con;
  PetscCall((*((SlipFault)ctx)->cell_ops->add_reaction)((SlipFault)ctx, a, r, F));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultHostSolveMass(SlipFault fault, Vec k)
{
  PetscReal *a;

  PetscFunctionBegin;
  PetscCall(VecGetArray(k, &a));
  for (PetscInt i = 0; i < fault->mesh.n; i++)
    for (PetscInt k = SlipFaultRateAt(fault, i); k < SlipFaultDisplacementAt(fault, i); k++)
      a[k] = fault->kind.inertia ? a[k] / (fault->operators.mass * fault->mesh.weight[i]) : 0;
  PetscCall(VecRestoreArray(k, &a));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SolveMass(SlipConstraint con, Vec F, Vec k, void *ctx)
{
  PetscFunctionBegin;
  (void)con;
  if (F != k) PetscCall(VecCopy(F, k));
  PetscCall((*((SlipFault)ctx)->cell_ops->solve_mass)((SlipFault)ctx, k));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes q = mu(s, |v|) sigma_n w [Pa], a vector of cells, for a state at t; the weights w are 1 on a grid. */
PetscErrorCode SlipFaultHostStrength(SlipFault fault, PetscReal t, Vec w, Vec q)
{
  SlipFrictionCells friction;
  const PetscReal *a;
  PetscReal *b;
  const SlipArrays arrays[] = {{w, .read = &a}, {q, .write = &b}};

  PetscFunctionBegin;
  PetscCall(SlipFaultGetFrictionOf(fault, t, w, &friction));
  PetscCall(SlipArraysGet(2, arrays));
  SlipFrictionStrength(&friction, fault->mesh.n, 0, fault->layout.block, a + fault->layout.state,
                       fault->layout.components == 1 ? fault->layout.block : 1, StateSpeeds(fault, a), b, NULL);
  PetscCall(SlipArraysRestore(2, arrays));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultStrength(SlipFault fault, PetscReal t, Vec w, Vec q)
{
  PetscFunctionBegin;
  SlipWorkCells(fault->mesh.n, fault->layout.components, fault->friction.law->always_slides);
  PetscCall((*fault->cell_ops->strength)(fault, t, w, q));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode BoundState(SlipConstraint con, PetscReal t, Vec w, Vec q, void *ctx)
{
  PetscFunctionBegin;
  (void)con;
  PetscCall(SlipFaultStrength((SlipFault)ctx, t, w, q));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultConstraintCreate(SlipFault fault)
{
  const PetscBool smooth = fault->friction.law->always_slides;
  const SlipConstraintOps ops = {Stage,
                                 Residual,
                                 Jacobian,
                                 Bound,
                                 Reduce,
                                 Lift,
                                 Smooth,
                                 AddReaction,
                                 SolveMass,
                                 BoundState,
                                 AtRest,
                                 smooth ? SolveCells : NULL,
                                 smooth ? Prescribed : NULL,
                                 fault->friction.law->by_rate ? NULL : StartSlope,
                                 fault->kind.coupled && !SlipFaultOpens(fault) ? Coupling : NULL,
                                 fault->kind.inertia ? &SlipFaultExplicitOps : NULL,
                                 PETSC_TRUE};

  PetscFunctionBegin;
  if (!fault->stage.con) {
    PetscCall(SlipConstraintCreate(fault->comm, &ops, fault, fault->critical.uc, &fault->stage.con));
    PetscCall(SlipConstraintSetComponents(fault->stage.con, fault->layout.components, fault->cells));
  }
  fault->stage.con->number = fault->mesh.order;
  PetscCall(SlipConstraintSetRefuseUnstable(fault->stage.con, fault->kind.driven));
  PetscFunctionReturn(PETSC_SUCCESS);
}
