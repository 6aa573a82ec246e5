/* Finds how long a fault at rest stays at rest, and its state when a cell starts to slide.

   At v = 0 the force on a cell is f(t) = T(t) - K u + H v_inf. As du/dt = -v_inf, f changes at the constant rate
   K v_inf + dT/dt, and as the terms of the load do. The strength q(t) = mu(s(t)) (sigma - p(t)) changes when the state
   s heals or the pressure p does, and falls at the rate mu Kn v_inf where slip changes normal stress. A cell starts to
   slip at the first root of |f| - q. */
#include <slipstep/private/slipfault.h>
#include <slipstep/private/slipsys.h>

enum { MAX_BISECTIONS = 200, MAX_PIECES = 100000000 };
/* Lengths of the pieces of the search, in each of which |f| - q has at most one root by assumption: shares of the
   healing time, and of the time since the search began, as healing slows down with it. */
static const PetscReal piece_of_healing = 0.05, piece_of_past = 0.1;
/* First step after the onset, over the time of growth of the cell that starts. Where it does not grow, it is a share of
   the rest, which only rounding limits where the cell has just stopped, and at least a fiftieth of the time in which
   the cell finds its rate, or a hundred of them where it would swing. */
static const PetscReal step_of_growth = 0.5, step_of_rest = 1e-3, step_of_relaxation = 0.02, steps_of_swing = 100;
/* Where the remaining force over the strength of the starting cell is at most this, it is only the rounding of K u. The
   rest would be too short to change displacements, and another one would follow, and so on. */
static const PetscReal rounding = 4 * PETSC_MACHINE_EPSILON;

typedef struct {
  SlipFault fault;
  SlipFrictionCells friction;
  PetscReal t;              /* start of the rest [s] */
  const PetscReal *w;       /* the state at that start */
  const PetscReal *ku;      /* K u [Pa] */
  const PetscReal *hold;    /* H v_inf [Pa] */
  const PetscReal *drive;   /* rate of the force [Pa/s] */
  const PetscReal *shear;   /* T(t) [Pa]; NULL: 0 */
  const PetscReal *clamp;   /* Kn v_inf [Pa/s]; NULL: 0 */
  PetscReal held;           /* factor of the strength: explicit steps hold cells that exceed it by rounding */
  PetscReal *begin, *moved; /* of terms at the start, and their change since then; NULL: there are none [Pa] */
  Vec load, force;          /* vectors of shear and ku, between RestBegin() and RestEnd() */
} Rest;

/* Computes K v_inf + w dT/dt and H v_inf, once. */
PetscErrorCode SlipFaultRestSetUp(SlipFault fault)
{
  SlipFaultLoads *loads = &fault->loads;
  PetscReal *d, largest;

  PetscFunctionBegin;
  if (loads->drive) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecDuplicate(fault->critical.uc, &loads->drive));
  PetscCall(VecDuplicate(fault->critical.uc, &loads->hold));
  PetscCall(VecDuplicate(fault->critical.uc, &loads->pull));
  if (fault->kind.loaded) {
    PetscCall(SlipProductsPush(SLIP_PRODUCTS_SETUP));
    PetscCall(SlipElasticForce(fault->medium, 0, NULL, fault->operators.vinf, loads->hold, NULL));
    PetscCall(SlipElasticApply(fault->medium, fault->operators.vinf, loads->drive, NULL));
    PetscCall(SlipProductsPop());
  } else {
    PetscCall(VecZeroEntries(loads->hold));
    PetscCall(VecZeroEntries(loads->drive));
  }
  PetscCall(VecCopy(loads->drive, loads->pull));
  PetscCall(VecGetArray(loads->drive, &d));
  for (PetscInt i = 0, c = fault->layout.components; i < fault->mesh.n; i++)
    for (PetscInt k = 0; k < c; k++)
      d[c * i + k] += fault->mesh.weight[i] * fault->fields.cell[FIELD_STRESSING_RATE][i] * SlipFaultAlong(fault, i)[k];
  PetscCall(VecRestoreArray(loads->drive, &d));
  PetscCall(SlipVecLargest(loads->drive, &largest));
  loads->drives = largest != 0 ? PETSC_TRUE : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Moves(SlipFault fault, Vec w, PetscBool *moves)
{
  const PetscReal *a;
  PetscReal largest;

  PetscFunctionBegin;
  if (!SlipFaultOpens(fault)) {
    PetscCall(SlipFaultLargestSpeed(fault, w, &largest));
    *moves = largest != 0 ? PETSC_TRUE : PETSC_FALSE;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  *moves = PETSC_FALSE;
  PetscCall(VecGetArrayRead(w, &a));
  for (PetscInt i = 0; i < fault->mesh.n && !*moves; i++)
    *moves =
      SlipFaultSpeed(fault, a, i) != 0 || SlipFaultAcross(fault, a + SlipFaultDisplacementAt(fault, i)) > 0 /* open */
        ? PETSC_TRUE
        : PETSC_FALSE;
  PetscCall(VecRestoreArrayRead(w, &a));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, moves, 1, MPIU_BOOL, MPI_LOR, fault->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns q of cell i after the rest dt [Pa]; r->friction must be that of this time. */
static PetscReal Strength(const Rest *r, PetscInt i, PetscReal dt)
{
  PetscReal s[SLIP_MAX_STATES], mu, ds, dv;

  SlipFrictionStateAtRest(&r->friction, i, r->w + SlipFaultStateAt(r->fault, i), dt, s);
  SlipFrictionEvaluate(&r->friction, i, s, 0, &mu, &ds, &dv);
  return r->held * mu * r->fault->mesh.weight[i] * r->friction.stress[i];
}

/* Returns the change of number k of f since the start [Pa]; the terms' as of FrictionAfter(). */
static PetscReal Change(const Rest *r, PetscInt k, PetscReal dt)
{
  return dt * r->drive[k] + (r->moved ? r->moved[k] : 0);
}

/* Returns f of number k of a vector of slip at the start [Pa]. */
static PetscReal Force(const Rest *r, PetscInt k)
{
  return (r->shear ? r->shear[k] : 0) + r->hold[k] - r->ku[k];
}

/* Sets the friction of all cells, and the terms of the load, to those of the time dt after the start. Collective. */
static PetscErrorCode FrictionAfter(Rest *r, PetscReal dt)
{
  const SlipFaultLoads *loads = &r->fault->loads;
  const PetscInt m = r->fault->layout.components * loads->n;

  PetscFunctionBegin;
  if (r->clamp)
    PetscCall(SlipFaultCoupledFriction(r->fault, r->t + dt, dt, &r->friction));
  else
    PetscCall(SlipFaultGetFriction(r->fault, r->t + dt, &r->friction));
  for (PetscInt k = 0; k < m && r->moved; k++) r->moved[k] = -r->begin[k];
  if (r->moved) SlipLoadsAddTerms(loads, r->t + dt, PETSC_FALSE, loads->weight, r->moved, NULL);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the largest |f| - q of all cells after the rest dt [Pa], or the stress that opens a cell, and the number of
   that cell on its process, -1 on others. Collective. */
static PetscErrorCode Excess(Rest *r, PetscReal dt, PetscReal *excess, PetscInt *cell)
{
  SlipFault fault = r->fault;
  struct {
    double value;
    int rank;
  } mine = {-PETSC_MAX_REAL, 0}, all;
  const PetscInt c = fault->layout.components;
  PetscInt best = -1;
  PetscMPIInt rank;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(fault->comm, &rank));
  PetscCall(FrictionAfter(r, dt));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    PetscReal f[3] = {0, 0, 0}, e;

    for (PetscInt k = 0; k < c; k++) f[k] = Force(r, c * i + k) + Change(r, c * i + k, dt);
    e = SlipFaultLength(fault, f) - Strength(r, i, dt);
    if (SlipFaultOpens(fault))
      e = PetscMax(e, fault->mesh.weight[i] * fault->coupling.pull[i]); /* without shear, too */
    if (e <= mine.value) continue;
    mine.value = (double)e;
    best = i;
  }
  mine.rank = rank;
  PetscCallMPI(MPI_Allreduce(&mine, &all, 1, MPI_DOUBLE_INT, MPI_MAXLOC, fault->comm));
  *excess = (PetscReal)all.value;
  if (cell) *cell = all.rank == rank ? best : -1;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the time at which +-(f + d t) equals q - e t; PETSC_MAX_REAL: never. */
static PetscReal CoupledOnset(PetscReal f, PetscReal d, PetscReal q, PetscReal e)
{
  PetscReal first = PETSC_MAX_REAL;

  for (int sign = -1; sign < 2; sign += 2)
    if (sign * d + e > 0) first = PetscMin(first, (q - sign * f) / (sign * d + e));
  return first;
}

/* Returns the time at which |f + d t| of two components equals q - e t, which it does not exceed at 0; PETSC_MAX_REAL:
   never. The difference of squares is a t^2 + 2 b t + c with c <= 0. Its first root after 0 has q - e t >= 0, as it is
   not negative where q - e t is 0. */
static PetscReal VectorOnset(const PetscReal f[2], const PetscReal d[2], PetscReal q, PetscReal e)
{
  const PetscReal a = d[0] * d[0] + d[1] * d[1] - e * e, b = f[0] * d[0] + f[1] * d[1] + q * e;
  const PetscReal c = f[0] * f[0] + f[1] * f[1] - q * q, square = b * b - a * c;
  PetscReal root;

  if (c >= 0 && a > 0) return PetscMax(-2 * b / a, 0);
  if (c >= 0) return b > 0 ? 0 : PETSC_MAX_REAL;
  if (square < 0) return PETSC_MAX_REAL;
  root = PetscSqrtReal(square);
  if (b < 0) return a > 0 ? (root - b) / a : PETSC_MAX_REAL;
  return b + root > 0 ? -c / (b + root) : PETSC_MAX_REAL;
}

/* Finds the onset where strengths are constant, or linear as the force: a quotient gives the root of each cell. */
static PetscErrorCode LinearOnset(Rest *r, PetscReal limit, PetscReal *rest)
{
  SlipFault fault = r->fault;
  const PetscInt c = fault->layout.components;

  PetscFunctionBegin;
  *rest = limit;
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    const PetscReal f = Force(r, c * i), d = r->drive[c * i], q = Strength(r, i, 0);
    const PetscReal falls = r->clamp && q > 0 ? r->clamp[i] / r->friction.stress[i] * q : 0;

    if (c > 1) {
      const PetscReal both[2] = {f, Force(r, c * i + 1)};

      *rest = PetscMin(*rest, SlipFaultLength(fault, both) > q ? 0 : VectorOnset(both, r->drive + c * i, q, falls));
    } else if (PetscAbsReal(f) > q)
      *rest = 0;
    else if (r->clamp)
      *rest = PetscMin(*rest, CoupledOnset(f, d, q, falls));
    else if (d != 0)
      *rest = PetscMin(*rest, ((d > 0 ? q : -q) - f) / d);
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, rest, 1, MPIU_REAL, MPIU_MIN, fault->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the length of the piece that begins dt after the start of the search. */
static PetscErrorCode Piece(Rest *r, PetscReal dt, PetscReal limit, PetscReal *piece)
{
  SlipFault fault = r->fault;
  const PetscReal healing = fault->loads.fastest_healing;
  const PetscReal pressure = SlipLoadsPressureScale(&fault->loads, r->t + dt, limit);
  const PetscReal corner = SlipLoadsNextCorner(&fault->loads, r->t + dt);

  PetscFunctionBegin;
  *piece = limit - dt;
  if (healing > 0) *piece = PetscMin(*piece, piece_of_healing / healing + piece_of_past * dt);
  *piece = PetscMin(*piece, PetscMin(pressure, corner - (r->t + dt)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the first root in [0, limit], in a piece at whose end the excess is positive. The excess is not negative at the
   returned time. */
static PetscErrorCode SearchOnset(Rest *r, PetscReal limit, PetscReal *rest)
{
  PetscReal low = 0, high = 0, excess, piece = 0, at_low, at_high = 0;

  PetscFunctionBegin;
  *rest = limit;
  PetscCall(Excess(r, 0, &at_low, NULL));
  if (at_low >= 0) *rest = 0;
  for (PetscInt k = 0; *rest > 0 && k < MAX_PIECES; k++) {
    PetscCall(Piece(r, low, limit, &piece));
    high = low + piece;
    if (high >= limit || !(high > low)) high = limit;
    PetscCall(Excess(r, high, &at_high, NULL));
    if (at_high >= 0) break;
    if (high >= limit) PetscFunctionReturn(PETSC_SUCCESS);
    low = high;
    at_low = at_high;
  }
  if (*rest == 0) PetscFunctionReturn(PETSC_SUCCESS);
  /* Illinois' false position halves the weight of the end that does not move. */
  for (PetscInt k = 0; k < MAX_BISECTIONS && high - low > 4 * PETSC_MACHINE_EPSILON * (PetscAbsReal(r->t) + high);
       k++) {
    PetscReal x = (low * at_high - high * at_low) / (at_high - at_low);

    if (k % 3 == 2 || !(x > low && x < high)) x = 0.5 * (low + high);
    PetscCall(Excess(r, x, &excess, NULL));
    if (excess >= 0) {
      high = x;
      at_high = excess;
      at_low *= 0.5;
    } else {
      low = x;
      at_low = excess;
      at_high *= 0.5;
    }
    if (excess == 0) break;
  }
  *rest = high;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Onset(Rest *r, PetscReal limit, PetscReal *rest)
{
  PetscFunctionBegin;
  if (r->fault->kind.heals || SlipLoadsChange(&r->fault->loads))
    PetscCall(SearchOnset(r, limit, rest));
  else
    PetscCall(LinearOnset(r, limit, rest));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds whether a rest changes force or strength of cell i, which starts at its end, by more than rounding; i < 0 on
   other processes. Collective. */
static PetscErrorCode IsLong(Rest *r, PetscReal rest, PetscInt i, PetscBool *is)
{
  const PetscInt c = r->fault->layout.components;
  PetscReal begin = 0, end, force, change[3] = {0, 0, 0};
  PetscBool mine = PETSC_FALSE;

  PetscFunctionBegin;
  PetscCall(FrictionAfter(r, 0));
  if (i >= 0) begin = Strength(r, i, 0);
  PetscCall(FrictionAfter(r, rest));
  if (i >= 0) {
    end = Strength(r, i, rest);
    for (PetscInt k = 0; k < c; k++) change[k] = Change(r, c * i + k, rest);
    force = SlipFaultLength(r->fault, change);
    mine = force > rounding * end || PetscAbsReal(end - begin) > rounding * end ? PETSC_TRUE : PETSC_FALSE;
  }
  PetscCallMPI(MPI_Allreduce(&mine, is, 1, MPIU_BOOL, MPI_LOR, r->fault->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds a step to continue with from the onset. The growth x of cell i, which starts, follows from M x^2 + (H + dq/dv)
   x + K + dq/ds = 0 for this cell alone; i < 0 on other processes. */
static PetscErrorCode FirstStep(Rest *r, PetscReal rest, PetscInt i, PetscReal *h)
{
  SlipFault fault = r->fault;
  const PetscReal *k, *viscosity;
  Vec diagonal[2];
  PetscReal rate[2] = {-PETSC_MAX_REAL, -PETSC_MAX_REAL}; /* of growth, of relaxation */

  PetscFunctionBegin;
  PetscCall(SlipElasticGetDiagonals(fault->medium, &diagonal[0], &diagonal[1]));
  if (i >= 0) {
    const PetscReal M = fault->kind.inertia ? fault->operators.mass * fault->mesh.weight[i] : 0;
    const PetscReal stress = r->friction.stress[i] * fault->mesh.weight[i];
    PetscReal s[SLIP_MAX_STATES], mu, ds, dv, damping, stiffness;

    PetscCall(VecGetArrayRead(diagonal[0], &k));
    PetscCall(VecGetArrayRead(diagonal[1], &viscosity));
    SlipFrictionStateAtRest(&r->friction, i, r->w + SlipFaultStateAt(fault, i), rest, s);
    SlipFrictionEvaluate(&r->friction, i, s, 0, &mu, &ds, &dv);
    damping = SlipFaultLargest(fault, viscosity, i) + dv * stress;
    stiffness = SlipFaultLargest(fault, k, i) + ds * stress;
    if (M > 0 && PetscSqr(damping) >= 4 * M * stiffness)
      rate[0] = (-damping + PetscSqrtReal(PetscSqr(damping) - 4 * M * stiffness)) / (2 * M);
    else if (M == 0 && damping > 0)
      rate[0] = -stiffness / damping;
    if (stiffness > 0) rate[1] = M > 0 ? PetscSqrtReal(stiffness / M) : -rate[0];
    /* The cell would swing and stick again within the step; long steps average that. */
    if (M > 0 && damping < 0) rate[1] *= step_of_relaxation / steps_of_swing;
    PetscCall(VecRestoreArrayRead(diagonal[1], &viscosity));
    PetscCall(VecRestoreArrayRead(diagonal[0], &k));
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, rate, 2, MPIU_REAL, MPIU_MAX, fault->comm));
  *h = step_of_rest * rest;
  if (rate[0] > 0)
    *h = step_of_growth / rate[0];
  else if (rate[1] > 0)
    *h = PetscMax(*h, step_of_relaxation / rate[1]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the state after the rest dt. */
static PetscErrorCode StateAfter(const Rest *r, PetscReal dt, Vec after)
{
  const PetscReal *vinf = r->fault->fields.cell[FIELD_LOADING_RATE];
  PetscReal *b;

  PetscFunctionBegin;
  PetscCall(VecGetArrayWrite(after, &b));
  for (PetscInt i = 0; i < r->fault->mesh.n; i++) {
    for (PetscInt k = 0; k < r->fault->layout.components; k++) {
      b[SlipFaultRateAt(r->fault, i) + k] = 0;
      b[SlipFaultDisplacementAt(r->fault, i) + k] =
        r->w[SlipFaultDisplacementAt(r->fault, i) + k] - dt * (vinf[i] * SlipFaultAlong(r->fault, i)[k]);
    }
    SlipFrictionStateAtRest(&r->friction, i, r->w + SlipFaultStateAt(r->fault, i), dt,
                            b + SlipFaultStateAt(r->fault, i));
  }
  PetscCall(VecRestoreArrayWrite(after, &b));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prepares r for a state w that rests at t; RestEnd() returns its arrays. */
static PetscErrorCode RestBegin(SlipFault fault, PetscReal t, Vec w, Rest *r)
{
  const PetscInt m = fault->layout.components * fault->mesh.n;
  const SlipFaultLoad *load;

  PetscFunctionBegin;
  *r = (Rest){.fault = fault,
              .t = t,
              .held = fault->problem.steps.any_integrator || fault->problem.sides.side ? 1 + SLIP_FRICTION_HOLD : 1};
  PetscCall(SlipFaultRestSetUp(fault));
  PetscCall(SlipFaultGetLoad(fault, t, &load));
  PetscCall(SlipFaultGetFrictionOf(fault, t, w, &r->friction));
  if (fault->kind.coupled) PetscCall(VecGetArrayRead(fault->coupling.drive, &r->clamp));
  PetscCall(SlipFaultGetWork(fault, &r->load));
  PetscCall(SlipFaultGetWork(fault, &r->force));
  PetscCall(SlipFaultForce(fault, t, w, r->load, r->force));
  PetscCall(VecCopy(load->shear ? load->shear : fault->loads.hold, r->load));
  PetscCall(VecGetArrayRead(w, &r->w));
  PetscCall(VecGetArrayRead(r->force, &r->ku));
  PetscCall(VecGetArrayRead(r->load, &r->shear));
  if (!load->shear) r->shear = NULL;
  PetscCall(VecGetArrayRead(fault->loads.hold, &r->hold));
  PetscCall(VecGetArrayRead(fault->loads.drive, &r->drive));
  if (!fault->loads.nterms) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscCalloc2(m, &r->begin, m, &r->moved));
  SlipLoadsAddTerms(&fault->loads, t, PETSC_FALSE, fault->loads.weight, r->begin, NULL);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode RestEnd(Vec w, Rest *r)
{
  SlipFault fault = r->fault;
  const PetscReal *shear = NULL;

  PetscFunctionBegin;
  PetscCall(PetscFree2(r->begin, r->moved));
  if (r->clamp) PetscCall(VecRestoreArrayRead(fault->coupling.drive, &r->clamp));
  PetscCall(VecRestoreArrayRead(fault->loads.drive, &r->drive));
  PetscCall(VecRestoreArrayRead(fault->loads.hold, &r->hold));
  PetscCall(VecRestoreArrayRead(r->load, r->shear ? &r->shear : &shear));
  PetscCall(VecRestoreArrayRead(r->force, &r->ku));
  PetscCall(SlipFaultRestoreWork(fault, &r->force));
  PetscCall(SlipFaultRestoreWork(fault, &r->load));
  PetscCall(VecRestoreArrayRead(w, &r->w));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  SlipFaultRestTime - SlipControlOps.rest_time: finds how long the state w at t stays exactly at rest [s]

  Collective. *rest is 0 when a cell moves or its force exceeds the strength, and PETSC_MAX_REAL for ever. It is 0 as
  well when strengths may change in time, as with states of the law's own: then there is no search.
*/
PetscErrorCode SlipFaultRestTime(TS ts, PetscReal t, Vec w, PetscReal *rest, void *ctx)
{
  SlipFault fault = (SlipFault)ctx;
  PetscBool moves, rests;
  Rest r;

  PetscFunctionBegin;
  (void)ts;
  *rest = 0;
  PetscCall(SlipElasticRests(fault->medium, &rests));
  PetscCall(Moves(fault, w, &moves));
  if (moves || !rests || fault->zone.presses || fault->kind.heals || SlipLoadsChange(&fault->loads) ||
      fault->friction.law->nstates)
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(RestBegin(fault, t, w, &r));
  PetscCall(LinearOnset(&r, PETSC_MAX_REAL, rest));
  PetscCall(RestEnd(w, &r));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  SlipFaultRest - SlipStepOps.rest: finds the end of the rest that begins with the state w at t, at most limit, and
  the exact states halfway and at its end

  Collective. *end = t when a cell moves or is at its strength. *h: a step to continue with [s].
*/
PetscErrorCode SlipFaultRest(TS ts, PetscReal t, PetscReal limit, Vec w, Vec half, Vec after, PetscReal *end,
                             PetscReal *h, void *ctx)
{
  SlipFault fault = (SlipFault)ctx;
  PetscReal rest, excess;
  PetscBool moves, rests, is_long = PETSC_FALSE;
  PetscInt first = -1;
  Rest r;

  PetscFunctionBegin;
  (void)ts;
  *end = t;
  PetscCall(SlipElasticRests(fault->medium, &rests));
  if (!rests || fault->zone.presses) PetscFunctionReturn(PETSC_SUCCESS); /* pressure changes */
  PetscCall(Moves(fault, w, &moves));
  if (moves) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(RestBegin(fault, t, w, &r));
  PetscCall(Onset(&r, limit - t, &rest));
  if (t + rest > t) {
    PetscCall(Excess(&r, rest, &excess, &first));
    PetscCall(IsLong(&r, rest, first, &is_long));
  }
  if (is_long || (t + rest > t && rest >= limit - t)) {
    *end = rest >= limit - t ? limit : t + rest;
    PetscCall(StateAfter(&r, rest / 2, half));
    PetscCall(StateAfter(&r, rest, after));
    PetscCall(FirstStep(&r, rest, first, h));
  }
  PetscCall(RestEnd(w, &r));
  PetscFunctionReturn(PETSC_SUCCESS);
}
