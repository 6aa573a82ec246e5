/* Friction laws: one row each, with derivatives; the evolution of their state over a stage; the strength that they give
   a cell. Pure functions: the fault's constraint and the trainer's loop without objects both call them, so that a law
   is written here and nowhere else. */
#include <slipcompat.h>
#include <slipcore.h>
#include <stdlib.h>

/* Slip and slip rate beyond which no law weakens any more; finite, so that laws can divide by them. */
#define WEAK_SLIP 1e30
#define WEAK_RATE 1e30

/* A step of Newton's method, over the unknown, whose square is below rounding: what is left after it */
#define NEWTON_ENOUGH 1e-9

enum { FRICTION_REGISTERED = 64, STATE_MAX_IT = 300 };

static void ExponentialSlipWeakening(const SlipFriction *p, PetscReal s, PetscReal v, PetscReal *excess,
                                     PetscReal *dmu_ds, PetscReal *dmu_dv)
{
  (void)v;
  *excess = p->drop * PetscExpReal(-s / p->slip);
  *dmu_ds = -*excess / p->slip;
  *dmu_dv = 0;
}

/* Ida (1972). At the corner s = d_c the derivative is that of the plateau. */
static void LinearSlipWeakening(const SlipFriction *p, PetscReal s, PetscReal v, PetscReal *excess, PetscReal *dmu_ds,
                                PetscReal *dmu_dv)
{
  const PetscBool weakening = s < p->slip ? PETSC_TRUE : PETSC_FALSE;

  (void)v;
  *excess = weakening ? p->drop * (1 - s / p->slip) : 0;
  *dmu_ds = weakening ? -p->drop / p->slip : 0;
  *dmu_dv = 0;
}

/* Burridge and Knopoff (1967), Carlson and Langer (1989), above a residual. */
static void RateWeakening(const SlipFriction *p, PetscReal s, PetscReal v, PetscReal *excess, PetscReal *dmu_ds,
                          PetscReal *dmu_dv)
{
  const PetscReal fall = 1 / (1 + v / p->rate);

  (void)s;
  *excess = p->drop * fall;
  *dmu_ds = 0;
  *dmu_dv = -p->drop * fall * fall / p->rate;
}

static void Constant(const SlipFriction *p, PetscReal s, PetscReal v, PetscReal *excess, PetscReal *dmu_ds,
                     PetscReal *dmu_dv)
{
  (void)p, (void)s, (void)v;
  *excess = 0;
  *dmu_ds = 0;
  *dmu_dv = 0;
}

const SlipFrictionLaw SlipFrictionLaws[] = {
  {"exponential_slip_weakening", ExponentialSlipWeakening, "residual + drop exp(-s/slip)", .by_rate = PETSC_FALSE,
   .reads = "residual drop slip"},
  {"linear_slip_weakening", LinearSlipWeakening, "residual + drop max(0, 1 - s/slip)", .by_rate = PETSC_FALSE,
   .reads = "residual drop slip"},
  {"rate_weakening", RateWeakening, "residual + drop/(1 + |v|/rate)", .by_rate = PETSC_TRUE,
   .reads = "residual drop rate"},
  {"constant", Constant, "residual", .by_rate = PETSC_FALSE, .reads = "residual"},
  {"rate_and_state", SlipRateAndState, "a asinh(|v|/(2 V0) exp((f0 + b ln(V0 theta/slip))/a))", .by_rate = PETSC_TRUE,
   .always_slides = PETSC_TRUE, .state = SlipRateAndStateRate, .steady = SlipRateAndStateSteady, .state_unit = "s",
   .shown = SlipRateAndStateTheta, .of_shown = SlipRateAndStateOfTheta, .largest_state = 500, /* exp(500) is 1e217 */
   .direct = SlipRateAndStateDirect, .balance = SlipRateAndStateBalance, .keep = SlipRateAndStateKeep,
   .nkept = SLIP_RATE_AND_STATE_KEPT, .reads = "slip a b alpha reference reference_rate"},
  {.name = NULL},
};

/* ---- the table, which users may add to ---- */

/* Rows of others, in the order in which they came */
static SlipFrictionLaw *registered[FRICTION_REGISTERED];
static PetscInt nregistered = 0;

/* The rows one after another: the first after NULL, NULL after the last */
const SlipFrictionLaw *SlipFrictionNext(const SlipFrictionLaw *law)
{
  if (!law) return SlipFrictionLaws;
  for (PetscInt k = 0; k < nregistered; k++)
    if (law == registered[k]) return k + 1 < nregistered ? registered[k + 1] : NULL;
  if (law[1].name) return law + 1;
  return nregistered ? registered[0] : NULL;
}

/*
  SlipFrictionFind - find the friction law with a name

  Not collective. law is NULL when there is none.
*/
PetscErrorCode SlipFrictionFind(const char name[], const SlipFrictionLaw **law)
{
  PetscFunctionBegin;
  *law = NULL;
  for (const SlipFrictionLaw *l = SlipFrictionNext(NULL); l; l = SlipFrictionNext(l)) {
    PetscBool same;

    PetscCall(PetscStrcmp(name, l->name, &same));
    if (same) *law = l;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  SlipFrictionRegister - add a friction law to the table

  Not collective. The row is copied; strings, context and parameters of its own, which SlipFaultRegisterFrictionLaw()
  checks, are not. PETSC_ERR_ARG_WRONG for a name that is taken, a row without functions, and too many rows.
*/
PetscErrorCode SlipFrictionRegister(const SlipFrictionLaw *law)
{
  const SlipFrictionLaw *same;

  PetscFunctionBegin;
  PetscCheck(law->name && law->name[0] && law->eval && law->formula, PETSC_COMM_SELF, PETSC_ERR_ARG_WRONG,
             "A friction law needs a name, a function and a formula");
  PetscCheck(!law->always_slides || law->state, PETSC_COMM_SELF, PETSC_ERR_ARG_WRONG,
             "The friction law %s, whose cells always slide, needs the rate of its state", law->name);
  PetscCheck(!law->state || law->steady, PETSC_COMM_SELF, PETSC_ERR_ARG_WRONG,
             "The friction law %s has a state but no steady one", law->name);
  PetscCheck(!law->shown == !law->of_shown && (!law->keep || (law->balance && law->nkept > 0)), PETSC_COMM_SELF,
             PETSC_ERR_ARG_WRONG, "The friction law %s has one of two functions that belong together", law->name);
  PetscCall(SlipFrictionFind(law->name, &same));
  PetscCheck(!same, PETSC_COMM_SELF, PETSC_ERR_ARG_WRONG, "There is a friction law %s already", law->name);
  PetscCheck(nregistered < FRICTION_REGISTERED, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
             "The friction law %s would be one of more than %d", law->name, FRICTION_REGISTERED);
  /* until the process ends: faults refer to it */
  registered[nregistered] = (SlipFrictionLaw *)malloc(sizeof(*law));
  PetscCheck(registered[nregistered], PETSC_COMM_SELF, PETSC_ERR_MEM, "No memory for the friction law %s", law->name);
  *registered[nregistered++] = *law;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the state: a law's own, or the slip s of both signs, which rest lets heal: ds/dt = |v| - s/t_h ---- */

static PetscReal StateRate(const SlipFrictionLaw *law, const SlipFriction *p, PetscReal s, PetscReal rate)
{
  PetscReal f, ds, dv;

  if (!law->state) return rate - s * p->healing;
  law->state(p, s, rate, &f, &ds, &dv);
  return f;
}

/* The root of s - s0 - theta ds/dt(s), which grows with s, by Newton's method; ds: its derivative with respect to the rate.
   It is between s0 and the steady state of the rate. A step that leaves what brackets the root, one after the residual has
   grown, and every eighth (far from the root, where an exponential rules, Newton's steps are of length 1) is of bisection. */
static PetscReal OwnStateAdvance(const SlipFrictionLaw *law, const SlipFriction *p, PetscReal theta, PetscReal s0,
                                 PetscReal rate, PetscReal *ds)
{
  const PetscReal steady = law->steady(p, rate);
  PetscReal s = s0, low = PetscMin(s0, steady), high = PetscMax(s0, steady), before = PETSC_MAX_REAL, f, f_s, f_v;

  for (int it = 0; it < STATE_MAX_IT; it++) {
    PetscReal g, next;
    PetscBool enough;

    law->state(p, s, rate, &f, &f_s, &f_v);
    g = s - s0 - theta * f;
    if (PetscAbsReal(g) <= PETSC_MACHINE_EPSILON * (PetscAbsReal(s) + PetscAbsReal(s0))) break;
    if (g > 0)
      high = PetscMin(high, s);
    else
      low = PetscMax(low, s);
    next = s - g / (1 - theta * f_s);
    enough = PetscAbsReal(next - s) <= NEWTON_ENOUGH * PetscMax(PetscAbsReal(s), 1) ? PETSC_TRUE : PETSC_FALSE;
    if (!enough && low > -PETSC_MAX_REAL && high < PETSC_MAX_REAL &&
        (!(next < high && next > low) || PetscAbsReal(g) > before || it % 8 == 7))
      next = 0.5 * (low + high);
    before = PetscAbsReal(g);
    s = next;
    if (enough) break;
  }
  law->state(p, s, rate, &f, &f_s, &f_v);
  *ds = theta * f_v / (1 - theta * f_s);
  return s;
}

/* At the end of a stage that is implicit by theta, s = s0 + theta ds/dt, and its derivative with respect to the rate
   there */
static PetscReal StateAdvance(const SlipFrictionLaw *law, const SlipFriction *p, PetscReal theta, PetscReal s0,
                              PetscReal rate, PetscReal *ds)
{
  const PetscReal share = 1 / (1 + theta * p->healing);

  if (theta == 0) { /* a state as it is */
    *ds = 0;
    return s0;
  }
  if (law->state) return OwnStateAdvance(law, p, theta, s0, rate, ds);
  *ds = theta * share;
  return (s0 + theta * rate) * share;
}

/* After t [s] of rest, exactly; cells that always slide never rest */
static PetscReal StateAtRest(const SlipFriction *p, PetscReal s0, PetscReal t)
{
  return p->healing > 0 ? s0 * PetscExpReal(-t * p->healing) : s0;
}

/* ---- many cells ---- */

static inline SlipFriction At(const SlipFrictionCells *f, PetscInt i)
{
  return (SlipFriction){.residual = f->residual[i],
                        .drop = f->drop[i],
                        .slip = f->slip[i],
                        .rate = f->rate[i],
                        .healing = f->healing ? f->healing[i] : 0,
                        .a = f->a ? f->a[i] : 0,
                        .b = f->b ? f->b[i] : 0,
                        .reference = f->reference ? f->reference[i] : 0,
                        .reference_rate = f->reference_rate,
                        .slip_law = f->slip_law,
                        .shift = f->alpha ? SlipRateAndStateShift(f->alpha[i], f->b[i], f->stress[i], f->start[i]) : 0,
                        .own = f->own ? f->own + f->nown * i : NULL,
                        .ctx = f->law->ctx};
}

/* mu of cell i and its derivatives */
void SlipFrictionEvaluate(const SlipFrictionCells *f, PetscInt i, PetscReal s, PetscReal v, PetscReal *mu,
                          PetscReal *dmu_ds, PetscReal *dmu_dv)
{
  const SlipFriction p = At(f, i);

  f->law->eval(&p, s, v, mu, dmu_ds, dmu_dv);
  if (!f->law->always_slides) *mu = p.residual + *mu;
}

/* What mu of cell i exceeds its residual by */
PetscReal SlipFrictionExcess(const SlipFrictionCells *f, PetscInt i, PetscReal s, PetscReal v)
{
  const SlipFriction p = At(f, i);
  PetscReal excess, ds, dv;

  f->law->eval(&p, s, v, &excess, &ds, &dv);
  return excess;
}

/* mu of cell i after all weakening; where cells always slide there is no such end */
PetscReal SlipFrictionWeakest(const SlipFrictionCells *f, PetscInt i)
{
  if (f->law->always_slides) return 0;
  return f->residual[i] + SlipFrictionExcess(f, i, WEAK_SLIP, WEAK_RATE);
}

/* mu of cell i at the end of a stage that starts from s0 and is implicit by theta [s], with the rate v there; its
   derivatives and that of the state s there with respect to |v| */
void SlipFrictionStage(const SlipFrictionCells *f, PetscInt i, PetscReal theta, PetscReal s0, PetscReal v,
                       PetscReal *mu, PetscReal *dmu_ds, PetscReal *dmu_dv, PetscReal *ds_dv)
{
  const SlipFriction p = At(f, i);
  const PetscReal rate = PetscAbsReal(v), s = StateAdvance(f->law, &p, theta, s0, rate, ds_dv);

  f->law->eval(&p, s, rate, mu, dmu_ds, dmu_dv);
  if (!f->law->always_slides) *mu = p.residual + *mu;
}

/* dq/dsigma of q = mu sigma at the end of that stage: mu, less what the state's share of the stress takes from it (At()) */
PetscReal SlipFrictionStressGain(const SlipFrictionCells *f, PetscInt i, PetscReal theta, PetscReal s0, PetscReal v)
{
  PetscReal mu, dmu_ds, dmu_dv, ds_dv, rate, rate_s, rate_v;

  SlipFrictionStage(f, i, theta, s0, v, &mu, &dmu_ds, &dmu_dv, &ds_dv);
  if (f->alpha && f->alpha[i] > 0 && f->stress[i] > 0) {
    const SlipFriction p = At(f, i);

    /* s - shift changes with the shift by -1/(1 - theta f_s), as s = s0 + theta f(s - shift) */
    f->law->state(&p, StateAdvance(f->law, &p, theta, s0, PetscAbsReal(v), &ds_dv), PetscAbsReal(v), &rate, &rate_s,
                  &rate_v);
    mu -= f->alpha[i] / f->b[i] * dmu_ds / (1 - theta * rate_s);
  }
  return mu;
}

/* q = mu sigma w [Pa] at the end of a stage (theta 0: of the state s0), and, unless dq is NULL, dq/d|v|. s0 and v have a
   stride: 3 in states (v, u, s) of a fault. */
void SlipFrictionStrength(const SlipFrictionCells *f, PetscInt n, PetscReal theta, PetscInt stride,
                          const PetscReal s0[], const PetscReal v[], PetscReal q[], PetscReal dq[])
{
  for (PetscInt i = 0; i < n; i++) {
    const PetscReal sigma = f->weight ? f->weight[i] * f->stress[i] : f->stress[i];
    PetscReal mu, dmu_ds, dmu_dv, ds_dv;

    SlipFrictionStage(f, i, theta, s0[stride * i], v[stride * i], &mu, &dmu_ds, &dmu_dv, &ds_dv);
    q[i] = sigma * mu;
    if (dq) dq[i] = sigma * (ds_dv * dmu_ds + dmu_dv);
  }
}

/* ds/dt at the state (v, s); all three arrays have the stride */
void SlipFrictionStateRate(const SlipFrictionCells *f, PetscInt n, PetscInt stride, const PetscReal s[],
                           const PetscReal v[], PetscReal ds[])
{
  for (PetscInt i = 0; i < n; i++) {
    const SlipFriction p = At(f, i);

    ds[stride * i] = StateRate(f->law, &p, s[stride * i], PetscAbsReal(v[stride * i]));
  }
}

/* The state at the end of a stage with the rates v; s, and only it, has a stride */
void SlipFrictionStateAdvance(const SlipFrictionCells *f, PetscInt n, PetscReal theta, const PetscReal s0[],
                              const PetscReal v[], PetscInt stride, PetscReal s[])
{
  for (PetscInt i = 0; i < n; i++) {
    const SlipFriction p = At(f, i);
    PetscReal ds;

    s[stride * i] = StateAdvance(f->law, &p, theta, s0[i], PetscAbsReal(v[i]), &ds);
  }
}

/* The state of cell i after t [s] of rest */
PetscReal SlipFrictionStateAtRest(const SlipFrictionCells *f, PetscInt i, PetscReal s0, PetscReal t)
{
  const SlipFriction p = At(f, i);

  return StateAtRest(&p, s0, t);
}

/* What outputs call the state s of cell i, and what users give */
PetscReal SlipFrictionShown(const SlipFrictionCells *f, PetscInt i, PetscReal s)
{
  const SlipFriction p = At(f, i);

  return f->law->shown ? f->law->shown(&p, s) : s;
}

/* The state of cell i that outputs call this */
PetscReal SlipFrictionOfShown(const SlipFrictionCells *f, PetscInt i, PetscReal shown)
{
  const SlipFriction p = At(f, i);

  return f->law->of_shown ? f->law->of_shown(&p, shown) : shown;
}

/* Of the state as users give it and outputs show it */
const char *SlipFrictionStateUnit(const SlipFrictionLaw *law)
{
  return law->state_unit ? law->state_unit : law->state ? "1" : "m";
}

/* dmu/d ln v of cell i, to 1e-9 where mu is more than ten times that; infinite where it is not known without the state */
PetscReal SlipFrictionDirect(const SlipFrictionCells *f, PetscInt i)
{
  const SlipFriction p = At(f, i);

  return f->law->direct ? f->law->direct(&p) : PETSC_INFINITY;
}

/* The state of cell i at which nothing changes with the rate v */
PetscReal SlipFrictionSteady(const SlipFrictionCells *f, PetscInt i, PetscReal v)
{
  const SlipFriction p = At(f, i);

  return f->law->steady ? f->law->steady(&p, PetscAbsReal(v)) : 0;
}

/* Of a law with a state of its own, where that is steady at the rate v > 0: what mu falls by per metre of slip that the state
   follows (b/d_c of rate-and-state friction), and the stiffness over the normal stress below which steady slip is unstable
   ((b - a)/d_c; Ruina 1983), not positive where it is stable. With x' = f(x, v) of the state x, they are -mu_x f_v and
   mu_v f_x - mu_x f_v. */
void SlipFrictionWeakening(const SlipFrictionCells *f, PetscInt i, PetscReal v, PetscReal *fall, PetscReal *critical)
{
  const SlipFriction p = At(f, i);
  const PetscReal s = f->law->steady(&p, v);
  PetscReal mu, mu_s, mu_v, rate, rate_s, rate_v;

  f->law->eval(&p, s, v, &mu, &mu_s, &mu_v);
  f->law->state(&p, s, v, &rate, &rate_s, &rate_v);
  *fall = -mu_s * rate_v;
  *critical = mu_v * rate_s - mu_s * rate_v;
}

/* The state in which the friction of cell i is mu with the rate v, by Newton's method from the steady one; NaN if there is
   none. Rate-and-state friction is almost linear in its state. */
PetscReal SlipFrictionStateOf(const SlipFrictionCells *f, PetscInt i, PetscReal mu, PetscReal v)
{
  const SlipFriction p = At(f, i);
  PetscReal s = f->law->steady(&p, PetscAbsReal(v)), now, ds, dv;

  for (int it = 0; it < STATE_MAX_IT; it++) {
    PetscReal change;

    f->law->eval(&p, s, PetscAbsReal(v), &now, &ds, &dv);
    change = (mu - now) / ds;
    if (PetscIsInfOrNanReal(change)) return change - change;
    s += change;
    if (PetscAbsReal(change) <= 4 * PETSC_MACHINE_EPSILON * PetscMax(PetscAbsReal(s), 1)) return s;
  }
  return s;
}

/* The slip rates v [n] at which friction and radiation damping balance the traction: w sigma mu(s, |v|) sign(v) + w eta v =
   tau [Pa], w the weights, and, unless ds is NULL, the rates of the state; s and ds have the stride. For laws whose cells
   always slide. kept [nkept n]: what the law's function keep made of f and eta, or NULL */
void SlipFrictionBalance(const SlipFrictionCells *f, const PetscReal kept[], PetscInt n, PetscReal eta,
                         const PetscReal tau[], PetscInt stride, const PetscReal s[], PetscReal v[], PetscReal ds[])
{
  if (f->law->balance) {
    f->law->balance(f, kept, n, eta, tau, stride, s, v, ds);
    return;
  }
  for (PetscInt i = 0; i < n; i++) {
    const SlipFriction p = At(f, i);
    const PetscReal weight = f->weight ? f->weight[i] : 1;

    v[i] = SlipFrictionBalanceOne(f->law, &p, s[stride * i], f->stress[i], eta, tau[i] / weight);
    if (ds) ds[stride * i] = StateRate(f->law, &p, s[stride * i], PetscAbsReal(v[i]));
  }
}

/* ---- a stage of one cell that always slides ---- */

/* omega w sigma mu + D v - load at the stage's end, and its derivative with respect to ln v */
static PetscReal StageExcess(const SlipFrictionCells *f, PetscInt i, const SlipFrictionStageCell *c, PetscReal load,
                             PetscReal v, PetscReal *slope)
{
  const PetscReal strength = c->omega * (f->weight ? f->weight[i] : 1) * f->stress[i];
  PetscReal mu, ds, dv, ds_dv;

  SlipFrictionStage(f, i, c->theta, c->s0, v, &mu, &ds, &dv, &ds_dv);
  *slope = (strength * (dv + ds_dv * ds) + c->diagonal) * v;
  return strength * mu + c->diagonal * v - load;
}

/* ln v to begin with: that of the guess, if it goes the right way; else of the state that rest would lead to, which
   leaves the cell stronger than it is, so that this is below the root */
static PetscReal StageStart(const SlipFrictionCells *f, PetscInt i, const SlipFrictionStageCell *c, PetscReal load,
                            PetscReal guess)
{
  const SlipFriction p = At(f, i);
  const PetscReal strength = c->omega * (f->weight ? f->weight[i] : 1) * f->stress[i];
  PetscReal ds;

  if (guess > 0) return PetscMin(PetscLogReal(guess), PetscLogReal(load / c->diagonal));
  return PetscLogReal(
    SlipFrictionBalanceOne(f->law, &p, StateAdvance(f->law, &p, c->theta, c->s0, 0, &ds), strength, c->diagonal, load));
}

/*
  SlipFrictionStageRate - the slip rate v of cell i alone at the end of a stage, D v + omega w sigma mu(s(v), |v|) sign(v)
  = load, of a law whose cells always slide

  s(v) = s0 + theta ds/dt is the state there. Newton's method in ln v inside a bracket, from the guess or the rate that it
  finds itself. Without the state's change friction grows with v, and the root is the only one. With it a long stage
  can weaken faster than D v grows: then the root next to the guess is taken, and *stable is false where none is at which the
  sum grows without a fall in between.
*/
PetscReal SlipFrictionStageRate(const SlipFrictionCells *f, PetscInt i, const SlipFrictionStageCell *c, PetscReal load,
                                PetscReal guess, PetscBool *stable)
{
  const PetscReal size = PetscAbsReal(load), sign = load < 0 ? -1 : 1, up = 1, down = 4;
  PetscReal low = -PETSC_MAX_REAL, high = PETSC_MAX_REAL, x, slope = 1;

  *stable = PETSC_TRUE;
  if (size == 0 || PetscIsInfOrNanReal(size) || !(f->stress[i] > 0)) return load / c->diagonal;
  x = StageStart(f, i, c, size, sign * guess);
  for (int it = 0; it < STATE_MAX_IT; it++) {
    const PetscReal g = StageExcess(f, i, c, size, PetscExpReal(x), &slope);
    PetscReal next = slope > 0 ? x - g / slope : x - down;
    PetscBool enough;

    if (g < 0 && slope <= 0) break;
    if (g > 0)
      high = PetscMin(high, x);
    else
      low = PetscMax(low, x);
    next = PetscClipInterval(next, x - down, x + up);
    enough = PetscAbsReal(next - x) <= NEWTON_ENOUGH * PetscMax(PetscAbsReal(x), 1) ? PETSC_TRUE : PETSC_FALSE;
    if (!enough && (next <= low || next >= high) && low > -PETSC_MAX_REAL && high < PETSC_MAX_REAL)
      next = 0.5 * (low + high);
    x = next;
    if (enough) break;
  }
  if (!(slope > 0)) *stable = PETSC_FALSE;
  return sign * PetscExpReal(x);
}
