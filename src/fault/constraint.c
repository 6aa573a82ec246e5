/* The fault's constraint: elimination of u and s from a stage, and the strength as the bound of the reaction. */
#include <slipstep/private/slipfault.h>
#include <slipstep/private/slipsnes.h>

/* Positions in a block of the state. */
enum { V, U, S };

/* x_i = w[3 i + which] */
static PetscErrorCode SlipFaultExtract(Vec w, PetscInt which, Vec x)
{
  const PetscReal *a;
  PetscReal *b;
  PetscInt n;

  PetscFunctionBegin;
  PetscCall(VecGetLocalSize(x, &n));
  PetscCall(VecGetArrayRead(w, &a));
  PetscCall(VecGetArrayWrite(x, &b));
  for (PetscInt i = 0; i < n; i++) b[i] = a[3 * i + which];
  PetscCall(VecRestoreArrayWrite(x, &b));
  PetscCall(VecRestoreArrayRead(w, &a));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* u0 = base_u + theta (ex_u - v_inf), s0 = base_s + theta ex_s, c = (w M/theta) base_v + ex_v, w: the weights. */
static PetscErrorCode SlipFaultEliminate(SlipFault fault, const SlipStage *stage)
{
  const PetscReal theta = stage->theta;
  const PetscReal *base, *ex = NULL, *vinf;
  PetscReal *c, *u0, *s0;

  PetscFunctionBegin;
  PetscCall(VecGetArrayRead(stage->base, &base));
  if (stage->explicit_part) PetscCall(VecGetArrayRead(stage->explicit_part, &ex));
  PetscCall(VecGetArrayRead(fault->vinf, &vinf));
  PetscCall(VecGetArrayWrite(fault->c, &c));
  PetscCall(VecGetArrayWrite(fault->u0, &u0));
  PetscCall(VecGetArrayWrite(fault->s0, &s0));
  for (PetscInt i = 0; i < fault->n; i++) {
    c[i] = fault->weight[i] * (fault->mass / theta) * base[3 * i + V] + (ex ? ex[3 * i + V] : 0);
    u0[i] = base[3 * i + U] + theta * ((ex ? ex[3 * i + U] : 0) - vinf[i]);
    s0[i] = base[3 * i + S] + theta * (ex ? ex[3 * i + S] : 0);
  }
  PetscCall(VecRestoreArrayWrite(fault->s0, &s0));
  PetscCall(VecRestoreArrayWrite(fault->u0, &u0));
  PetscCall(VecRestoreArrayWrite(fault->c, &c));
  PetscCall(VecRestoreArrayRead(fault->vinf, &vinf));
  if (ex) PetscCall(VecRestoreArrayRead(stage->explicit_part, &ex));
  PetscCall(VecRestoreArrayRead(stage->base, &base));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipFaultGetFriction - the friction of the cells of this process, for SlipFrictionStrength() and its like

  Not collective; after SlipFaultSetUp()

  Input Parameter:
. fault - the fault

  Output Parameter:
. friction - law and parameters, borrowed arrays in the order of the state; the effective normal stress [Pa] counts with
             the weights of the cells, area over mean area

  Level: advanced

.seealso: SlipFaultGetOperators(), SlipFrictionStrength()
@*/
PetscErrorCode SlipFaultGetFriction(SlipFault fault, SlipFrictionCells *friction)
{
  PetscFunctionBegin;
  *friction = (SlipFrictionCells){.law = fault->law,
                                  .residual = fault->field[FIELD_FRICTION_RESIDUAL],
                                  .drop = fault->field[FIELD_FRICTION_DROP],
                                  .slip = fault->field[FIELD_FRICTION_SLIP],
                                  .rate = fault->field[FIELD_FRICTION_RATE],
                                  .stress = fault->field[FIELD_NORMAL_STRESS],
                                  .weight = fault->weight};
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* c = (M/theta) base_v + ex_v + H v_inf - K u0 */
PetscErrorCode SlipFaultConstraintStage(SlipFault fault, const SlipStage *stage)
{
  PetscFunctionBegin;
  fault->theta = stage->theta;
  PetscCall(MatSlipStageSetTheta(fault->B, stage->theta));
  PetscCall(SlipFaultEliminate(fault, stage));
  PetscCall(MatMult(fault->K, fault->u0, fault->work[0]));
  PetscCall(VecAXPY(fault->c, -1, fault->work[0]));
  if (fault->loaded) {
    PetscCall(MatMult(fault->H, fault->vinf, fault->work[0]));
    PetscCall(VecAXPY(fault->c, 1, fault->work[0]));
  }
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
  PetscCall(MatMult(fault->B, x, g));
  PetscCall(VecAXPY(g, -1, fault->c));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Residual(SlipConstraint con, Vec x, Vec g, void *ctx)
{
  PetscFunctionBegin;
  (void)con;
  PetscCall(SlipFaultConstraintResidual((SlipFault)ctx, x, g));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Jacobian(SlipConstraint con, Vec x, Mat *B, void *ctx)
{
  PetscFunctionBegin;
  (void)con;
  (void)x;
  *B = ((SlipFault)ctx)->B;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* q_i = mu(s_i, |v_i|) sigma_i and dq_i/d|v_i|, s the state at the stage's end. */
static PetscErrorCode Bound(SlipConstraint con, Vec x, Vec q, Vec dq, void *ctx)
{
  SlipFault fault = (SlipFault)ctx;
  SlipFrictionCells friction;
  const PetscReal *v, *s0;
  PetscReal *a, *b = NULL;

  PetscFunctionBegin;
  (void)con;
  PetscCall(SlipFaultGetFriction(fault, &friction));
  PetscCall(VecGetArrayRead(x, &v));
  PetscCall(VecGetArrayRead(fault->s0, &s0));
  PetscCall(VecGetArrayWrite(q, &a));
  if (dq) PetscCall(VecGetArrayWrite(dq, &b));
  SlipFrictionStrength(&friction, fault->n, fault->theta, 1, s0, v, a, b);
  if (dq) PetscCall(VecRestoreArrayWrite(dq, &b));
  PetscCall(VecRestoreArrayWrite(q, &a));
  PetscCall(VecRestoreArrayRead(fault->s0, &s0));
  PetscCall(VecRestoreArrayRead(x, &v));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Reduce(SlipConstraint con, Vec w, Vec x, void *ctx)
{
  PetscFunctionBegin;
  (void)con;
  (void)ctx;
  PetscCall(SlipFaultExtract(w, V, x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* w = (v, u0 + theta v, s) */
PetscErrorCode SlipFaultConstraintLift(SlipFault fault, Vec x, Vec w)
{
  SlipFrictionCells friction;
  const PetscReal *v, *u0, *s0;
  PetscReal *a;

  PetscFunctionBegin;
  PetscCall(SlipFaultGetFriction(fault, &friction));
  PetscCall(VecGetArrayRead(x, &v));
  PetscCall(VecGetArrayRead(fault->u0, &u0));
  PetscCall(VecGetArrayRead(fault->s0, &s0));
  PetscCall(VecGetArrayWrite(w, &a));
  for (PetscInt i = 0; i < fault->n; i++) {
    a[3 * i + V] = v[i];
    a[3 * i + U] = u0[i] + fault->theta * v[i];
  }
  SlipFrictionStateAdvance(&friction, fault->n, fault->theta, s0, v, 3, a + S);
  PetscCall(VecRestoreArrayWrite(w, &a));
  PetscCall(VecRestoreArrayRead(fault->s0, &s0));
  PetscCall(VecRestoreArrayRead(fault->u0, &u0));
  PetscCall(VecRestoreArrayRead(x, &v));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Lift(SlipConstraint con, Vec x, Vec w, void *ctx)
{
  PetscFunctionBegin;
  (void)con;
  PetscCall(SlipFaultConstraintLift((SlipFault)ctx, x, w));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* F = (-H (v - v_inf) - K u, v - v_inf, ds/dt), in Pa, m/s, m/s. */
PetscErrorCode SlipFaultSmooth(SlipFault fault, Vec w, Vec F)
{
  SlipFrictionCells friction;
  Vec rel = fault->work[0], u = fault->work[1], force = fault->work[2];
  const PetscReal *a, *r, *f;
  PetscReal *b;

  PetscFunctionBegin;
  PetscCall(SlipFaultGetFriction(fault, &friction));
  PetscCall(SlipFaultExtract(w, U, u));
  PetscCall(SlipFaultExtract(w, V, rel));
  if (fault->loaded) PetscCall(VecAXPY(rel, -1, fault->vinf));
  PetscCall(MatMult(fault->K, u, force));
  PetscCall(MatMult(fault->H, rel, u));
  PetscCall(VecAXPY(force, 1, u));
  PetscCall(VecGetArrayRead(w, &a));
  PetscCall(VecGetArrayRead(rel, &r));
  PetscCall(VecGetArrayRead(force, &f));
  PetscCall(VecGetArrayWrite(F, &b));
  for (PetscInt i = 0; i < fault->n; i++) {
    b[3 * i + V] = -f[i];
    b[3 * i + U] = r[i];
  }
  SlipFrictionStateRate(&friction, fault->n, 3, a + S, a + V, b + S);
  PetscCall(VecRestoreArrayWrite(F, &b));
  PetscCall(VecRestoreArrayRead(force, &f));
  PetscCall(VecRestoreArrayRead(rel, &r));
  PetscCall(VecRestoreArrayRead(w, &a));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Smooth(SlipConstraint con, PetscReal t, Vec w, Vec Fs, void *ctx)
{
  PetscFunctionBegin;
  (void)con;
  (void)t;
  PetscCall(SlipFaultSmooth((SlipFault)ctx, w, Fs));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode AddReaction(SlipConstraint con, PetscReal a, Vec r, Vec F, void *ctx)
{
  const PetscReal *tau;
  PetscReal *f;

  PetscFunctionBegin;
  (void)con;
  PetscCall(VecGetArrayRead(r, &tau));
  PetscCall(VecGetArray(F, &f));
  for (PetscInt i = 0; i < ((SlipFault)ctx)->n; i++) f[3 * i + V] += a * tau[i];
  PetscCall(VecRestoreArray(F, &f));
  PetscCall(VecRestoreArrayRead(r, &tau));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SolveMass(SlipConstraint con, Vec F, Vec k, void *ctx)
{
  SlipFault fault = (SlipFault)ctx;
  PetscReal *a;

  PetscFunctionBegin;
  (void)con;
  if (F != k) PetscCall(VecCopy(F, k));
  PetscCall(VecGetArray(k, &a));
  for (PetscInt i = 0; i < fault->n; i++) a[3 * i + V] /= fault->mass * fault->weight[i];
  PetscCall(VecRestoreArray(k, &a));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* q = mu(s, |v|) sigma_n w [Pa], reduced, of a state; the weights w are 1 on a grid. */
PetscErrorCode SlipFaultStrength(SlipFault fault, Vec w, Vec q)
{
  SlipFrictionCells friction;
  const PetscReal *a;
  PetscReal *b;

  PetscFunctionBegin;
  PetscCall(SlipFaultGetFriction(fault, &friction));
  PetscCall(VecGetArrayRead(w, &a));
  PetscCall(VecGetArrayWrite(q, &b));
  SlipFrictionStrength(&friction, fault->n, 0, 3, a + S, a + V, b, NULL);
  PetscCall(VecRestoreArrayWrite(q, &b));
  PetscCall(VecRestoreArrayRead(w, &a));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode BoundState(SlipConstraint con, PetscReal t, Vec w, Vec q, void *ctx)
{
  PetscFunctionBegin;
  (void)con;
  (void)t;
  PetscCall(SlipFaultStrength((SlipFault)ctx, w, q));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultConstraintCreate(SlipFault fault)
{
  const SlipConstraintOps ops = {.stage = Stage,
                                 .residual = Residual,
                                 .jacobian = Jacobian,
                                 .bound = Bound,
                                 .reduce = Reduce,
                                 .lift = Lift,
                                 .smooth = Smooth,
                                 .add_reaction = AddReaction,
                                 .solve_mass = SolveMass,
                                 .bound_state = BoundState};

  PetscFunctionBegin;
  if (!fault->con) PetscCall(SlipConstraintCreate(fault->comm, &ops, fault, fault->uc, &fault->con));
  fault->con->number = fault->order;
  PetscFunctionReturn(PETSC_SUCCESS);
}
