/* Computes the fault's part in explicit steps (TSMOREAU): one product with K and one with H a step, and in between each
   cell by itself. Its results are cached for outputs, energies and observations of the step's nodes. */
#include <slipstep/private/slipfault.h>
#include <slipstep/private/slipsnes.h>
#include <slipstep/private/slipsys.h>
#include <string.h>
#include <slipstep/private/slipwork.h>

/* Error of a product with H over the accuracy of the run; at most half of it enters the error of the slip history */
static const PetscReal share_of_accuracy = 0.02;

/* Returns whether all damping depends on a cell's own rate alone. */
static PetscBool Radiates(SlipFault fault)
{
  return strcmp(fault->kind.viscosity, "radiation") ? PETSC_FALSE : PETSC_TRUE;
}

/* Computes v - v_inf of a state. */
static PetscErrorCode Relative(SlipFault fault, Vec w, Vec relative)
{
  PetscFunctionBegin;
  PetscCall(SlipFaultGetRate(fault, w, relative));
  if (fault->kind.loaded) PetscCall(VecAXPY(relative, -1, fault->operators.vinf));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- SlipExplicitOps ---- */

/* Computes T - f(u, 0, t), and what slip adds to the normal stress. */
static PetscErrorCode Drive(SlipConstraint con, PetscReal t, Vec w, Vec f, void *ctx)
{
  SlipFault fault = (SlipFault)ctx;
  SlipFaultBalance *b = &fault->balance;
  Vec shear;

  PetscFunctionBegin;
  (void)con;
  if (!b->u) PetscCall(VecDuplicate(fault->critical.uc, &b->u));
  if (!b->force) PetscCall(VecDuplicate(fault->critical.uc, &b->force));
  PetscCall(SlipFaultGetDisplacement(fault, w, b->u));
  PetscCall(
    SlipElasticForce(fault->medium, t, b->u, NULL, b->force, fault->kind.coupled ? fault->coupling.rise : NULL));
  fault->coupling.balanced = fault->kind.coupled;
  b->time = t;
  b->known = PETSC_TRUE;
  PetscCall(VecCopy(b->force, f));
  PetscCall(VecScale(f, -1));
  PetscCall(SlipFaultGetShear(fault, t, &shear));
  if (shear) PetscCall(VecAXPY(f, 1, shear));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Damping(SlipConstraint con, PetscReal t, Vec w, Vec p, void *ctx)
{
  SlipFault fault = (SlipFault)ctx;
  const PetscReal given = fault->options.value[FAULT_ACCURACY];
  Vec relative;

  PetscFunctionBegin;
  (void)con, (void)t;
  if (Radiates(fault)) {
    PetscCall(VecZeroEntries(p));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(SlipFaultGetWork(fault, &relative));
  PetscCall(Relative(fault, w, relative));
  PetscCall(SlipElasticViscous(
    fault->medium, relative, share_of_accuracy * (PetscIsNanReal(given) ? (PetscReal)SLIP_FAULT_ACCURACY : given), p));
  PetscCall(SlipFaultRestoreWork(fault, &relative));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Undamped(SlipConstraint con, PetscReal t, Vec w, PetscBool *undamped, void *ctx)
{
  SlipFault fault = (SlipFault)ctx;
  PetscReal largest;
  Vec relative;

  PetscFunctionBegin;
  (void)con, (void)t;
  PetscCall(SlipFaultGetWork(fault, &relative));
  PetscCall(Relative(fault, w, relative));
  PetscCall(SlipVecLargest(relative, &largest));
  PetscCall(SlipFaultRestoreWork(fault, &relative));
  *undamped = Radiates(fault) || largest == 0 ? PETSC_TRUE : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The inputs of a kick of the cells */
typedef struct {
  SlipFrictionCells friction;
  const PetscReal *push, *eta, *vinf; /* g, the damping of a cell's own rate (NULL: 0), and v_inf, of vectors of slip */
} Kick;

/* Computes v of cell i after the time a of M dv/dt = g - eta (v - v_inf) + r, from base, with friction of the states s.
   Where cells open, the pressure is that of the kick's start. */
static void KickCell(SlipFault fault, const Kick *kick, PetscInt i, PetscReal a, const PetscReal base[],
                     PetscBool backward, const PetscReal s[], PetscBool open, PetscReal v[], PetscBool *ok)
{
  const PetscInt c = fault->layout.components, plane = fault->layout.plane;
  const PetscReal mass = fault->operators.mass * fault->mesh.weight[i];
  SlipFrictionStageCell cell = {.omega = 1, .s0 = s};
  PetscReal load[3], speed, size;

  for (PetscInt k = 0; k < c; k++) {
    const PetscReal eta = kick->eta ? kick->eta[c * i + k] : 0;
    PetscReal left = 1, D = mass / a;

    if (backward)
      D += eta;
    else
      D /= SlipKickDamping(eta * a / mass, &left);
    load[k] = kick->push[c * i + k] + eta * kick->vinf[c * i + k] + (backward ? mass / a : D * left) * base[k];
    if (k == 0) cell.diagonal = D;
    if (k < plane) continue;
    cell.omega = !open && load[k] < 0 ? -load[k] : 0; /* the pressure */
    v[k] = cell.omega > 0 ? 0 : load[k] / D;
  }
  size = SlipFaultLength(fault, load);
  speed = SlipFrictionKick(&kick->friction, i, &cell, size, SlipFaultLength(fault, base), ok);
  for (PetscInt k = 0; k < plane; k++) v[k] = speed > 0 ? speed * (load[k] / size) : 0;
}

/* A kick is exact for friction that does not depend on the rate. Else it uses Alexander's second formula, which is of
   second order and L-stable, as friction at low rates is stiff. */
PetscErrorCode SlipFaultHostKick(SlipFault fault, PetscReal t, PetscReal a, Vec g, Vec eta, Vec w, PetscBool *ok)
{
  const PetscInt c = fault->layout.components;
  Kick kick = {.eta = NULL};
  SlipBathe alexander;
  PetscReal *b;
  const SlipArrays arrays[] = {{g, .read = &kick.push}, {fault->operators.vinf, .read = &kick.vinf}, {w, .write = &b}};

  PetscFunctionBegin;
  SlipBatheSetUpBackward(&alexander);
  PetscCall(SlipFaultGetFrictionOf(fault, t, w, &kick.friction));
  if (SlipFaultOpens(fault)) {
    kick.friction = SlipFaultCellFriction(fault, fault->coupling.one);
    kick.friction.weight = NULL;
  }
  PetscCall(SlipArraysGet(3, arrays));
  if (eta) PetscCall(VecGetArrayRead(eta, &kick.eta));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    PetscReal *v = b + SlipFaultRateAt(fault, i), first[3], base[3];
    const PetscReal *s = b + SlipFaultStateAt(fault, i);
    const PetscBool open = SlipFaultAcross(fault, b + SlipFaultDisplacementAt(fault, i)) > 0 ? PETSC_TRUE : PETSC_FALSE;

    for (PetscInt k = 0; k < c; k++) base[k] = v[k];
    if (c == 1 && !fault->friction.law->by_rate) {
      PetscReal mu, ds, dv;
      const PetscReal own = kick.eta ? kick.eta[i] : 0, weight = fault->mesh.weight[i];

      SlipFrictionEvaluate(&kick.friction, i, s, 0, &mu, &ds, &dv);
      *v = SlipKickConstant(fault->operators.mass * weight, own, a, kick.push[i] + own * kick.vinf[i],
                            mu * weight * kick.friction.stress[i], *v);
      continue;
    }
    if (!fault->friction.law->by_rate) {
      KickCell(fault, &kick, i, a, base, PETSC_FALSE, s, open, v, ok);
      continue;
    }
    KickCell(fault, &kick, i, alexander.theta[0] * a, base, PETSC_TRUE, s, open, first, ok);
    for (PetscInt k = 0; k < c; k++) base[k] = first[k] + alexander.a0 * (first[k] - base[k]);
    KickCell(fault, &kick, i, alexander.theta[1] * a, base, PETSC_TRUE, s, open, v, ok);
  }
  if (eta) PetscCall(VecRestoreArrayRead(eta, &kick.eta));
  PetscCall(SlipArraysRestore(3, arrays));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode KickCells(SlipConstraint con, PetscReal t, PetscReal a, Vec g, Vec w, PetscBool *ok, void *ctx)
{
  SlipFault fault = (SlipFault)ctx;
  Vec eta = NULL;

  PetscFunctionBegin;
  (void)con;
  SlipWorkCells(fault->mesh.n, fault->layout.components, fault->friction.law->always_slides);
  if (Radiates(fault)) PetscCall(SlipElasticGetDiagonals(fault->medium, NULL, &eta));
  PetscCall((*fault->cell_ops->kick)(fault, t, a, g, eta, w, ok));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Advances du/dt = v - v_inf and the states. A cell that closes stops: it does not bounce. */
PetscErrorCode SlipFaultHostDrift(SlipFault fault, PetscReal t, PetscReal h, Vec w)
{
  const PetscInt c = fault->layout.components;
  SlipFrictionCells friction;
  const PetscReal *vinf;
  PetscReal *a, *work, *speed;
  Vec rate;
  const SlipArrays arrays[] = {
    {fault->operators.vinf, .read = &vinf}, {fault->stage.s0, .write = &work}, {w, .write = &a}};

  PetscFunctionBegin;
  if (fault->kind.coupled) /* friction of the start, where states follow normal stress */
    friction = SlipFaultCellFriction(fault, fault->coupling.stress);
  else
    PetscCall(SlipFaultGetFriction(fault, t + 0.5 * h, &friction));
  PetscCall(SlipFaultGetWork(fault, &rate));
  PetscCall(SlipArraysGet(3, arrays));
  PetscCall(VecGetArrayWrite(rate, &speed));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    PetscReal *v = a + SlipFaultRateAt(fault, i), *u = a + SlipFaultDisplacementAt(fault, i);

    speed[i] = SlipFaultLength(fault, v);
    for (PetscInt k = 0; k < c; k++) u[k] += h * (v[k] - vinf[c * i + k]);
    if (c == 3 && u[2] <= 0 && v[2] <= 0) u[2] = v[2] = 0;
  }
  SlipFrictionStateDrift(&friction, fault->mesh.n, h, speed, fault->layout.block, a + fault->layout.state, work);
  PetscCall(VecRestoreArrayWrite(rate, &speed));
  PetscCall(SlipArraysRestore(3, arrays));
  PetscCall(SlipFaultRestoreWork(fault, &rate));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Drift(SlipConstraint con, SlipNode from, PetscReal t, PetscReal h, Vec w, void *ctx)
{
  SlipFault fault = (SlipFault)ctx;

  PetscFunctionBegin;
  (void)con, (void)from;
  SlipWorkCells(fault->mesh.n, fault->layout.components, fault->friction.law->always_slides);
  PetscCall((*fault->cell_ops->drift)(fault, t, h, w));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Stores the force of the last right-hand side, if it is that of this state. */
static PetscErrorCode KeepForce(SlipFault fault, PetscReal t, Vec w)
{
  SlipFaultSettled *s = &fault->settled;
  Vec u;

  PetscFunctionBegin;
  if (!s->force) PetscCall(VecDuplicate(fault->critical.uc, &s->force));
  if (fault->kind.coupled && !s->rise) PetscCall(VecDuplicate(fault->coupling.rise, &s->rise));
  PetscCall(SlipFaultGetWork(fault, &u));
  PetscCall(SlipFaultGetDisplacement(fault, w, u));
  PetscCall(SlipFaultDisplacementUnchanged(fault, t, u, &s->forced));
  PetscCall(SlipFaultRestoreWork(fault, &u));
  if (fault->kind.coupled && !fault->coupling.balanced) s->forced = PETSC_FALSE;
  if (!s->forced) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecCopy(fault->balance.force, s->force));
  if (fault->kind.coupled) PetscCall(VecCopy(fault->coupling.rise, s->rise));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Settle(SlipConstraint con, SlipNode node, PetscReal t, Vec w, Vec p, void *ctx)
{
  SlipFault fault = (SlipFault)ctx;
  SlipFaultSettled *s = &fault->settled;
  Vec eta, f;

  PetscFunctionBegin;
  if (!s->rate[node]) {
    PetscCall(VecDuplicate(fault->critical.uc, &s->rate[node]));
    PetscCall(VecDuplicate(fault->critical.uc, &s->damping[node]));
  }
  PetscCall(Relative(fault, w, s->rate[node]));
  if (Radiates(fault)) {
    PetscCall(SlipElasticGetDiagonals(fault->medium, NULL, &eta));
    PetscCall(VecPointwiseMult(s->damping[node], eta, s->rate[node]));
  } else
    PetscCall(VecCopy(p, s->damping[node]));
  s->known[node] = PETSC_TRUE;
  s->time[node] = t;
  if (!fault->balance.known) { /* the run continues from a checkpoint */
    PetscCall(SlipFaultGetWork(fault, &f));
    PetscCall(SlipProductsPush(SLIP_PRODUCTS_SETUP));
    PetscCall(Drive(con, t, w, f, ctx));
    PetscCall(SlipProductsPop());
    PetscCall(SlipFaultRestoreWork(fault, &f));
  }
  if (node == SLIP_NODE_START) PetscCall(KeepForce(fault, t, w));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets x, the inner rate of the explicit step that led to the state w at t, K x [n], as the change of the force over
   the step, and Kn x, as that of the normal stress, unless nx is NULL. *found is true if there was such a step and
   anything moved in it. Collective. */
PetscErrorCode SlipFaultInnerRate(SlipFault fault, PetscReal t, Vec w, Vec x, Vec kx, Vec nx, PetscBool *found)
{
  const SlipFaultSettled *s = &fault->settled;
  const PetscReal *time = s->time;
  PetscReal largest, h;
  PetscBool rests, same;

  PetscFunctionBegin;
  *found = PETSC_FALSE;
  PetscCall(SlipElasticRests(fault->medium, &rests));
  if (!rests || fault->kind.loaded || !s->forced) PetscFunctionReturn(PETSC_SUCCESS);
  if (SlipFaultOpens(fault)) PetscFunctionReturn(PETSC_SUCCESS); /* what closes moves by less than its rate */
  if (nx && fault->device.device) PetscFunctionReturn(PETSC_SUCCESS);
  for (int node = 0; node < SLIP_NUM_NODES; node++)
    if (!s->known[node]) PetscFunctionReturn(PETSC_SUCCESS);
  h = time[SLIP_NODE_END] - time[SLIP_NODE_START]; /* not two steps, the second of which is half of a doubled one */
  if (!(h > 0) || time[SLIP_NODE_END] != fault->balance.time ||
      PetscAbsReal(time[SLIP_NODE_INSIDE] - time[SLIP_NODE_START] - 0.5 * h) > (PetscReal)0.01 * h)
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipFaultGetDisplacement(fault, w, x));
  PetscCall(SlipFaultDisplacementUnchanged(fault, t, x, &same));
  if (!same || (nx && !fault->coupling.balanced)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecCopy(s->rate[SLIP_NODE_INSIDE], x));
  PetscCall(SlipVecLargest(x, &largest));
  if (largest == 0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecWAXPY(kx, -1, s->force, fault->balance.force));
  PetscCall(VecScale(kx, 1 / h));
  if (nx) PetscCall(VecWAXPY(nx, -1, s->rise, fault->coupling.rise));
  if (nx) PetscCall(VecScale(nx, 1 / h));
  *found = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Frequency(SlipConstraint con, PetscReal t, Vec w, PetscReal *omega, PetscReal *ratio, void *ctx)
{
  SlipFault fault = (SlipFault)ctx;

  PetscFunctionBegin;
  (void)con, (void)t, (void)w;
  PetscCall(SlipElasticGetFrequency(fault->medium, omega));
  *ratio = Radiates(fault) || !strcmp(fault->kind.viscosity, "none") ? 0 : fault->options.value[FAULT_DAMPING_RATIO];
  PetscFunctionReturn(PETSC_SUCCESS);
}

const SlipExplicitOps SlipFaultExplicitOps = {Drive,  Damping,   KickCells, Drift,
                                              Settle, Frequency, Undamped,  PETSC_FALSE};
