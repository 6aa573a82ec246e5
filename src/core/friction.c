/* Friction laws, one row each, with derivatives; the evolution of their state over a stage; the strength of a cell. All
   are pure functions, because the fault's constraint and the trainer's loop without objects both call them. */
#include <slipcompat.h>
#include <slipstep/rooms/slipcore.h>
#include <stdlib.h>

/* Slip and slip rate beyond which no law weakens further; finite, so that laws can divide by them */
#define WEAK_SLIP 1e30
#define WEAK_RATE 1e30

/* A relative step of Newton's method after which the error, of the order of its square, is below rounding */
#define NEWTON_ENOUGH 1e-9

enum { FRICTION_REGISTERED = 64, STATE_MAX_IT = 300 };

static void ExponentialSlipWeakening(const SlipFriction *p, const PetscReal s[], PetscReal v, PetscReal *excess,
                                     PetscReal dmu_ds[], PetscReal *dmu_dv)
{
  (void)v;
  *excess = p->drop * PetscExpReal(-*s / p->slip);
  *dmu_ds = -*excess / p->slip;
  *dmu_dv = 0;
}

/* Ida (1972). At the corner s = d_c the derivative is that of the plateau. */
static void LinearSlipWeakening(const SlipFriction *p, const PetscReal s[], PetscReal v, PetscReal *excess,
                                PetscReal dmu_ds[], PetscReal *dmu_dv)
{
  const PetscBool weakening = *s < p->slip ? PETSC_TRUE : PETSC_FALSE;

  (void)v;
  *excess = weakening ? p->drop * (1 - *s / p->slip) : 0;
  *dmu_ds = weakening ? -p->drop / p->slip : 0;
  *dmu_dv = 0;
}

/* Burridge and Knopoff (1967), Carlson and Langer (1989), with a residual added */
static void RateWeakening(const SlipFriction *p, const PetscReal s[], PetscReal v, PetscReal *excess,
                          PetscReal dmu_ds[], PetscReal *dmu_dv)
{
  const PetscReal fall = 1 / (1 + v / p->rate);

  (void)s;
  *excess = p->drop * fall;
  *dmu_ds = 0;
  *dmu_dv = -p->drop * fall * fall / p->rate;
}

static void Constant(const SlipFriction *p, const PetscReal s[], PetscReal v, PetscReal *excess, PetscReal dmu_ds[],
                     PetscReal *dmu_dv)
{
  (void)p, (void)s, (void)v;
  *excess = 0;
  *dmu_ds = 0;
  *dmu_dv = 0;
}

static const SlipFrictionState Theta[] = {{.name = "state",
                                           .unit = "s",
                                           .start = "initial_state",
                                           .shown = SlipRateAndStateTheta,
                                           .of_shown = SlipRateAndStateOfTheta,
                                           .largest = 500}}; /* exp(500) is 1e217 */

const SlipFrictionLaw SlipFrictionLaws[] = {
  {"exponential_slip_weakening", ExponentialSlipWeakening, "residual + drop exp(-s/slip)", .by_rate = PETSC_FALSE,
   .remembers = PETSC_TRUE, .values = SlipExponentialWeakeningValues, .balance = SlipExponentialWeakeningBalance,
   .reads = "residual drop slip"},
  {"linear_slip_weakening", LinearSlipWeakening, "residual + drop max(0, 1 - s/slip)", .by_rate = PETSC_FALSE,
   .reads = "residual drop slip"},
  {"rate_weakening", RateWeakening, "residual + drop/(1 + |v|/rate)", .by_rate = PETSC_TRUE,
   .reads = "residual drop rate"},
  {"constant", Constant, "residual", .by_rate = PETSC_FALSE, .reads = "residual"},
  {"rate_and_state", SlipRateAndState, "a asinh(|v|/(2 V0) exp((f0 + b ln(V0 theta/slip))/a))", .by_rate = PETSC_TRUE,
   .always_slides = PETSC_TRUE, .states = Theta, .nstates = 1, .rate = SlipRateAndStateRate,
   .steady = SlipRateAndStateSteady, .drift = SlipRateAndStateDrift, .direct = SlipRateAndStateDirect,
   .balance = SlipRateAndStateBalance, .keep = SlipRateAndStateKeep, .nkept = SLIP_RATE_AND_STATE_KEPT,
   .values = SlipRateAndStateValues, .reads = "slip a b alpha reference reference_rate"},
  {"strong_rate_weakening", SlipRateAndState,
   "a asinh(|v|/(2 V0) exp(psi/a)), psi = f0 + b ln(V0 theta/slip), of "
   "which the state towards f_w at rates above V_w",
   .by_rate = PETSC_TRUE, .always_slides = PETSC_TRUE, .states = Theta, .nstates = 1, .rate = SlipStrongRate,
   .steady = SlipStrongSteady, .own = SlipStrongParameters, .drift = SlipStrongDrift, .direct = SlipRateAndStateDirect,
   .balance = SlipStrongBalance, .keep = SlipRateAndStateKeep, .nkept = SLIP_RATE_AND_STATE_KEPT,
   .values = SlipRateAndStateValues, .rupture = SlipStrongRupture, .reads = "slip a b alpha reference reference_rate"},
  {.name = NULL},
};

/* ---- the table, to which users may add laws ---- */

/* Laws of users, in the order of registration */
static SlipFrictionLaw *registered[FRICTION_REGISTERED];
static PetscInt nregistered = 0;

/* The rows in sequence: the first after NULL, NULL after the last */
const SlipFrictionLaw *SlipFrictionNext(const SlipFrictionLaw *law)
{
  if (!law) return SlipFrictionLaws;
  for (PetscInt k = 0; k < nregistered; k++)
    if (law == registered[k]) return k + 1 < nregistered ? registered[k + 1] : NULL;
  if (law[1].name) return law + 1;
  return nregistered ? registered[0] : NULL;
}

/*
  SlipFrictionFind - finds the friction law with a name

  Not collective. law is NULL if there is none.
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

/* Raises an error for an incomplete friction law. law: the row: it needs a name and a formula and, if it declares
   states, their descriptions, their rates and a function for the steady states at a rate. Errors: PETSC_ERR_ARG_WRONG
   or PETSC_ERR_ARG_OUTOFRANGE, naming the law and what was expected. */
PetscErrorCode SlipFrictionCheck(const SlipFrictionLaw *law)
{
  PetscFunctionBegin;
  PetscCheck(law->name && law->name[0] && law->eval && law->formula, PETSC_COMM_SELF, PETSC_ERR_ARG_WRONG,
             "A friction law needs a name, a function and a formula");
  PetscCheck(!law->always_slides || law->nstates, PETSC_COMM_SELF, PETSC_ERR_ARG_WRONG,
             "The friction law %s, whose cells always slide, needs a state", law->name);
  PetscCheck(law->nstates >= 0 && law->nstates <= SLIP_MAX_STATES, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
             "The friction law %s has %" PetscInt_FMT " states, expected 0 to %d", law->name, law->nstates,
             SLIP_MAX_STATES);
  PetscCheck(!law->nstates || (law->states && law->rate && law->steady), PETSC_COMM_SELF, PETSC_ERR_ARG_WRONG,
             "The friction law %s has states, but not what they are, their rates and steady ones", law->name);
  PetscCheck(!law->keep || (law->balance && law->nkept > 0), PETSC_COMM_SELF, PETSC_ERR_ARG_WRONG,
             "The friction law %s has one of two functions that belong together", law->name);
  for (PetscInt k = 0; k < law->nstates; k++)
    PetscCheck(law->states[k].name && !law->states[k].shown == !law->states[k].of_shown, PETSC_COMM_SELF,
               PETSC_ERR_ARG_WRONG,
               "State %" PetscInt_FMT " of the friction law %s needs a name, and both or none of shown and of_shown", k,
               law->name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  SlipFrictionRegister - adds a friction law to the table

  Not collective. The row is copied; its strings, context, states and parameters, which SlipFaultRegisterFrictionLaw()
  checks, are not. It raises PETSC_ERR_ARG_WRONG for a name that is taken, a row without functions, and too many rows.
*/
PetscErrorCode SlipFrictionRegister(const SlipFrictionLaw *law)
{
  const SlipFrictionLaw *same;

  PetscFunctionBegin;
  PetscCall(SlipFrictionCheck(law));
  PetscCall(SlipFrictionFind(law->name, &same));
  PetscCheck(!same, PETSC_COMM_SELF, PETSC_ERR_ARG_WRONG, "There is a friction law %s already", law->name);
  PetscCheck(nregistered < FRICTION_REGISTERED, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
             "The friction law %s would be one of more than %d", law->name, FRICTION_REGISTERED);
  /* never freed, because faults refer to it */
  registered[nregistered] = (SlipFrictionLaw *)malloc(sizeof(*law));
  PetscCheck(registered[nregistered], PETSC_COMM_SELF, PETSC_ERR_MEM, "No memory for the friction law %s", law->name);
  *registered[nregistered++] = *law;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- states: those that a law declares, or the slip s of both signs, which heals at rest: ds/dt = |v| - s/t_h ---- */

/* Number of states */
PetscInt SlipFrictionStates(const SlipFrictionLaw *law)
{
  return law->nstates ? law->nstates : 1;
}

/* Name in datasets */
const char *SlipFrictionStateName(const SlipFrictionLaw *law, PetscInt k)
{
  return law->nstates ? law->states[k].name : "state";
}

/* Unit of inputs and outputs */
const char *SlipFrictionStateUnit(const SlipFrictionLaw *law, PetscInt k)
{
  if (!law->nstates) return "m";
  return law->states[k].unit ? law->states[k].unit : "1";
}

static void StateRate(const SlipFrictionLaw *law, const SlipFriction *p, const PetscReal s[], PetscReal rate,
                      PetscReal f[])
{
  PetscReal ds[SLIP_MAX_STATES * SLIP_MAX_STATES], dv[SLIP_MAX_STATES];

  if (law->nstates)
    law->rate(p, s, rate, f, ds, dv);
  else
    *f = rate - *s * p->healing;
}

/* Computes the states at the end of a stage that is implicit with theta, s = s0 + theta ds/dt, and their derivatives
   with respect to the rate there. */
static void StateAdvance(const SlipFrictionLaw *law, const SlipFriction *p, PetscReal theta, const PetscReal s0[],
                         PetscReal rate, PetscReal s[], PetscReal ds[])
{
  const PetscReal share = 1 / (1 + theta * p->healing);

  if (theta == 0) { /* states do not change */
    for (PetscInt k = 0; k < SlipFrictionStates(law); k++) {
      s[k] = s0[k];
      ds[k] = 0;
    }
  } else if (law->nstates)
    SlipFrictionAdvanceOwn(law, p, theta, s0, rate, s, ds);
  else {
    *ds = theta * share;
    *s = (*s0 + theta * rate) * share;
  }
}

/* Derivative of mu with respect to the rate through the states */
static PetscReal Along(const SlipFrictionLaw *law, const PetscReal ds_dv[], const PetscReal dmu_ds[])
{
  PetscReal sum = ds_dv[0] * dmu_ds[0];

  for (PetscInt k = 1; k < law->nstates; k++) sum += ds_dv[k] * dmu_ds[k];
  return sum;
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
                        .state_law = f->state_law,
                        .cutoff_rate = f->cutoff_rate,
                        .shift = f->alpha ? SlipRateAndStateShift(f->alpha[i], f->b[i], f->stress[i], f->start[i]) : 0,
                        .own = f->own ? f->own + f->nown * i : NULL,
                        .ctx = f->law->ctx};
}

static const PetscReal unslipped[SLIP_MAX_STATES] = {0};

/* Computes by how much mu of cell i exceeds its residual, or mu if cells always slide. At the end of a step it is
   called six times, for kicks, sums and estimates; for laws that cache mu, f->known stores that state, its excess and
   derivative, and the excess after all weakening. */
static void Excess(const SlipFrictionCells *f, PetscInt i, const PetscReal s[], PetscReal v, PetscReal *excess,
                   PetscReal dmu_ds[], PetscReal *dmu_dv)
{
  PetscReal *known = f->known ? f->known + 4 * i : NULL;
  SlipFriction p;

  if (known && known[0] == *s) {
    *excess = known[1];
    *dmu_ds = known[2];
    *dmu_dv = 0;
    return;
  }
  p = At(f, i);
  f->law->eval(&p, s, v, excess, dmu_ds, dmu_dv);
  if (!known) return;
  known[0] = *s;
  known[1] = *excess;
  known[2] = *dmu_ds;
}

/* mu of cell i and its derivatives with respect to all states together and to |v|; s NULL: 0 */
void SlipFrictionEvaluate(const SlipFrictionCells *f, PetscInt i, const PetscReal s[], PetscReal v, PetscReal *mu,
                          PetscReal *dmu_ds, PetscReal *dmu_dv)
{
  PetscReal ds[SLIP_MAX_STATES];

  Excess(f, i, s ? s : unslipped, v, mu, ds, dmu_dv);
  if (!f->law->always_slides) *mu = f->residual[i] + *mu;
  *dmu_ds = ds[0];
  for (PetscInt k = 1; k < f->law->nstates; k++) *dmu_ds += ds[k];
}

/* By how much mu of cell i exceeds its residual; s NULL: 0 */
PetscReal SlipFrictionExcess(const SlipFrictionCells *f, PetscInt i, const PetscReal s[], PetscReal v)
{
  const SlipFriction p = At(f, i);
  PetscReal excess, ds[SLIP_MAX_STATES], dv;

  f->law->eval(&p, s ? s : unslipped, v, &excess, ds, &dv);
  return excess;
}

/* mu of cell i after all weakening; if cells always slide there is no such limit */
PetscReal SlipFrictionWeakest(const SlipFrictionCells *f, PetscInt i)
{
  static const PetscReal weak[SLIP_MAX_STATES] = {WEAK_SLIP, WEAK_SLIP, WEAK_SLIP, WEAK_SLIP,
                                                  WEAK_SLIP, WEAK_SLIP, WEAK_SLIP, WEAK_SLIP};

  if (f->law->always_slides) return 0;
  if (f->known && !(f->known[4 * i + 3] == f->known[4 * i + 3]))
    f->known[4 * i + 3] = SlipFrictionExcess(f, i, weak, WEAK_RATE);
  return f->residual[i] + (f->known ? f->known[4 * i + 3] : SlipFrictionExcess(f, i, weak, WEAK_RATE));
}

/* mu of cell i at the end of a stage that starts from s0 and is implicit with theta [s], with the rate v there; also
   its derivatives, and those of the states there, with respect to |v| */
void SlipFrictionStage(const SlipFrictionCells *f, PetscInt i, PetscReal theta, const PetscReal s0[], PetscReal v,
                       PetscReal *mu, PetscReal dmu_ds[], PetscReal *dmu_dv, PetscReal ds_dv[])
{
  const PetscReal rate = PetscAbsReal(v);
  PetscReal s[SLIP_MAX_STATES];
  SlipFriction p;

  if (f->known && theta == 0) { /* one state, unchanged */
    Excess(f, i, s0, rate, mu, dmu_ds, dmu_dv);
    *mu = f->residual[i] + *mu;
    *ds_dv = 0;
    return;
  }
  p = At(f, i);
  StateAdvance(f->law, &p, theta, s0, rate, s, ds_dv);
  f->law->eval(&p, s, rate, mu, dmu_ds, dmu_dv);
  if (!f->law->always_slides) *mu = p.residual + *mu;
}

/* dq/dsigma of q = mu sigma at the end of that stage: mu, minus the effect of stress on the state (At()) */
PetscReal SlipFrictionStressGain(const SlipFrictionCells *f, PetscInt i, PetscReal theta, const PetscReal s0[],
                                 PetscReal v)
{
  PetscReal mu, dmu_ds[SLIP_MAX_STATES], dmu_dv, ds_dv[SLIP_MAX_STATES];

  SlipFrictionStage(f, i, theta, s0, v, &mu, dmu_ds, &dmu_dv, ds_dv);
  if (f->alpha && f->alpha[i] > 0 && f->stress[i] > 0) { /* the law has one state and uses alpha */
    const SlipFriction p = At(f, i);
    PetscReal s, rate, rate_s, rate_v;

    /* s - shift depends on the shift with the derivative -1/(1 - theta f_s), because s = s0 + theta f(s - shift) */
    StateAdvance(f->law, &p, theta, s0, PetscAbsReal(v), &s, ds_dv);
    f->law->rate(&p, &s, PetscAbsReal(v), &rate, &rate_s, &rate_v);
    mu -= f->alpha[i] / f->b[i] * *dmu_ds / (1 - theta * rate_s);
  }
  return mu;
}

/* q = mu sigma w [Pa] at the end of a stage (theta 0: for the states s0), and, unless dq is NULL, dq/d|v|. Successive
   cells are `stride` apart in s0 and `rates` apart in v, as in the states (v, u, s) of a fault. */
void SlipFrictionStrength(const SlipFrictionCells *f, PetscInt n, PetscReal theta, PetscInt stride,
                          const PetscReal s0[], PetscInt rates, const PetscReal v[], PetscReal q[], PetscReal dq[])
{
  if (f->law->values && !f->law->remembers && theta == 0 && !dq) {
    f->law->values(f, n, stride, s0, rates, v, q);
    for (PetscInt i = 0; i < n; i++) q[i] *= f->weight ? f->weight[i] * f->stress[i] : f->stress[i];
    return;
  }
  if (f->law->eval == ExponentialSlipWeakening && theta > 0) {
    SlipExponentialWeakeningStrength(f, n, theta, stride, s0, rates, v, q, dq);
    return;
  }
  for (PetscInt i = 0; i < n; i++) {
    const PetscReal sigma = f->weight ? f->weight[i] * f->stress[i] : f->stress[i];
    PetscReal mu, dmu_ds[SLIP_MAX_STATES], dmu_dv, ds_dv[SLIP_MAX_STATES];

    SlipFrictionStage(f, i, theta, s0 + stride * i, v[rates * i], &mu, dmu_ds, &dmu_dv, ds_dv);
    q[i] = sigma * mu;
    if (dq) dq[i] = sigma * (Along(f->law, ds_dv, dmu_ds) + dmu_dv);
  }
}

/* Computes the rates of the states of cell i. */
void SlipFrictionStateRateOf(const SlipFrictionCells *f, PetscInt i, const PetscReal s[], PetscReal v, PetscReal ds[])
{
  const SlipFriction p = At(f, i);

  StateRate(f->law, &p, s, PetscAbsReal(v), ds);
}

/* ds/dt at the state (v, s); s and ds have the stride `stride`, v has the stride `rates` */
void SlipFrictionStateRate(const SlipFrictionCells *f, PetscInt n, PetscInt stride, const PetscReal s[], PetscInt rates,
                           const PetscReal v[], PetscReal ds[])
{
  for (PetscInt i = 0; i < n; i++) SlipFrictionStateRateOf(f, i, s + stride * i, v[rates * i], ds + stride * i);
}

/* Computes the states at the end of a stage with the rates v from s0 [n][states]; s has a stride. */
void SlipFrictionStateAdvance(const SlipFrictionCells *f, PetscInt n, PetscReal theta, const PetscReal s0[],
                              const PetscReal v[], PetscInt stride, PetscReal s[])
{
  const PetscInt states = SlipFrictionStates(f->law);

  for (PetscInt i = 0; i < n; i++) {
    const SlipFriction p = At(f, i);
    PetscReal ds[SLIP_MAX_STATES];

    StateAdvance(f->law, &p, theta, s0 + states * i, PetscAbsReal(v[i]), s + stride * i, ds);
  }
}

/* The exact states of cell i after t [s] of rest, for laws without declared states */
void SlipFrictionStateAtRest(const SlipFrictionCells *f, PetscInt i, const PetscReal s0[], PetscReal t, PetscReal s[])
{
  const PetscReal healing = f->healing ? f->healing[i] : 0;

  s[0] = healing > 0 ? s0[0] * PetscExpReal(-t * healing) : s0[0];
}

/* Converts state k, s, of cell i to the value in inputs and outputs */
PetscReal SlipFrictionShown(const SlipFrictionCells *f, PetscInt i, PetscInt k, PetscReal s)
{
  const SlipFriction p = At(f, i);

  return f->law->nstates && f->law->states[k].shown ? f->law->states[k].shown(&p, s) : s;
}

/* Converts that value to the state k of cell i */
PetscReal SlipFrictionOfShown(const SlipFrictionCells *f, PetscInt i, PetscInt k, PetscReal shown)
{
  const SlipFriction p = At(f, i);

  return f->law->nstates && f->law->states[k].of_shown ? f->law->states[k].of_shown(&p, shown) : shown;
}

/* dmu/d ln v of cell i, to 1e-9 where mu is more than ten times that; infinite if it depends on the state */
PetscReal SlipFrictionDirect(const SlipFrictionCells *f, PetscInt i)
{
  const SlipFriction p = At(f, i);

  return f->law->direct ? f->law->direct(&p) : PETSC_INFINITY;
}

/* Computes the states of cell i that are steady at the rate v. */
void SlipFrictionSteady(const SlipFrictionCells *f, PetscInt i, PetscReal v, PetscReal s[])
{
  const SlipFriction p = At(f, i);

  if (f->law->nstates)
    f->law->steady(&p, PetscAbsReal(v), s);
  else
    *s = 0;
}

/* For a law with declared states that are steady at the rate v > 0: the decrease of mu per metre of slip that the
   states follow (b/d_c in rate-and-state friction), and the stiffness over the normal stress below which steady slip is
   unstable ((b - a)/d_c; Ruina 1983), which is not positive where it is stable */
void SlipFrictionWeakening(const SlipFrictionCells *f, PetscInt i, PetscReal v, PetscReal *fall, PetscReal *critical)
{
  const SlipFriction p = At(f, i);

  SlipFrictionInstability(f->law, &p, v, fall, critical);
}

/* Computes s[k] for which the friction of cell i is mu at the rate v, by Newton's method from s with the other states
   fixed; NaN if there is none. Rate-and-state friction is almost linear in its state. */
void SlipFrictionStateOf(const SlipFrictionCells *f, PetscInt i, PetscInt k, PetscReal mu, PetscReal v, PetscReal s[])
{
  const SlipFriction p = At(f, i);
  PetscReal now, ds[SLIP_MAX_STATES], dv;

  for (int it = 0; it < STATE_MAX_IT; it++) {
    PetscReal change;

    f->law->eval(&p, s, PetscAbsReal(v), &now, ds, &dv);
    change = (mu - now) / ds[k];
    if (PetscIsInfOrNanReal(change)) {
      s[k] = change - change;
      return;
    }
    s[k] += change;
    if (PetscAbsReal(change) <= 4 * PETSC_MACHINE_EPSILON * PetscMax(PetscAbsReal(s[k]), 1)) return;
  }
}

/* The slip rate of a cell that may stick: 0 while sigma mu(s, 0) holds it, except for rounding, else that of the
   balance. For laws that do not depend on the rate, the strength is that at rest. Other laws decrease with the rate by
   less than eta v grows, so that the balance grows with v and has one root between 0 and tau/eta, which Newton's method
   finds in this bracket. */
static PetscReal BalanceSticking(const SlipFrictionCells *f, PetscInt i, const PetscReal s[], PetscReal eta,
                                 PetscReal tau)
{
  const PetscReal load = PetscAbsReal(tau), sigma = f->stress[i], rounding = 2 * PETSC_MACHINE_EPSILON;
  PetscReal low = 0, high = load / eta, v = 0, excess, ds[SLIP_MAX_STATES], dv, g;
  SlipFriction p;

  Excess(f, i, s, 0, &excess, ds, &dv);
  g = sigma * (f->residual[i] + excess) - load;
  if (!(load > (1 + SLIP_FRICTION_HOLD) * sigma * (f->residual[i] + excess))) return 0;
  if (!f->law->by_rate) return (tau < 0 ? g : -g) / eta;
  p = At(f, i);
  for (int it = 0; it < STATE_MAX_IT && high - low > rounding * high; it++) {
    PetscReal next = v - g / (sigma * dv + eta);

    if (!(next > low && next < high)) next = 0.5 * (low + high);
    if (PetscAbsReal(next - v) <= rounding * next) break;
    v = next;
    f->law->eval(&p, s, v, &excess, ds, &dv);
    g = sigma * (p.residual + excess) + eta * v - load;
    *(g > 0 ? &high : &low) = v;
  }
  return tau < 0 ? -v : v;
}

/* Computes the slip rates v [n] at which friction and radiation damping balance the traction: w sigma mu(s, |v|)
   sign(v) + w eta v = tau [Pa], with the weights w, and 0 where friction holds the cell; and, unless ds is NULL, the
   rates of the state. s and ds have the stride. kept [nkept n]: output of the law's function keep for f and eta, or
   NULL */
void SlipFrictionBalance(const SlipFrictionCells *f, const PetscReal kept[], PetscInt n, PetscReal eta,
                         const PetscReal tau[], PetscInt stride, const PetscReal s[], PetscReal v[], PetscReal ds[])
{
  if (f->law->balance) {
    f->law->balance(f, kept, n, eta, tau, stride, s, v, ds);
    return;
  }
  for (PetscInt i = 0; i < n; i++) {
    const PetscReal weight = f->weight ? f->weight[i] : 1;

    if (!f->law->always_slides) v[i] = BalanceSticking(f, i, s + stride * i, eta, tau[i] / weight);
    if (ds && !f->law->nstates) /* as in StateRate() */
      ds[stride * i] = PetscAbsReal(v[i]) - s[stride * i] * (f->healing ? f->healing[i] : 0);
    if (!f->law->nstates) continue;
    const SlipFriction p = At(f, i);
    if (f->law->always_slides)
      v[i] = SlipFrictionBalanceOne(f->law, &p, s + stride * i, f->stress[i], eta, tau[i] / weight);
    if (ds) StateRate(f->law, &p, s + stride * i, PetscAbsReal(v[i]), ds + stride * i);
  }
}

/* ---- a stage of one cell that always slides ---- */

/* omega w sigma mu + D v - load at the stage's end, and its derivative with respect to ln v */
static PetscReal StageExcess(const SlipFrictionCells *f, PetscInt i, const SlipFrictionStageCell *c, PetscReal load,
                             PetscReal v, PetscReal *slope)
{
  const PetscReal strength = c->omega * (f->weight ? f->weight[i] : 1) * f->stress[i];
  PetscReal mu, ds[SLIP_MAX_STATES], dv, ds_dv[SLIP_MAX_STATES];

  SlipFrictionStage(f, i, c->theta, c->s0, v, &mu, ds, &dv, ds_dv);
  *slope = (strength * (dv + Along(f->law, ds_dv, ds)) + c->diagonal) * v;
  return strength * mu + c->diagonal * v - load;
}

/* Initial ln v: that of the guess if it has the right sign, else that for the state after rest. Rest makes the cell
   stronger than it is, so that this value is below the root. */
static PetscReal StageStart(const SlipFrictionCells *f, PetscInt i, const SlipFrictionStageCell *c, PetscReal load,
                            PetscReal guess)
{
  const SlipFriction p = At(f, i);
  const PetscReal strength = c->omega * (f->weight ? f->weight[i] : 1) * f->stress[i];
  PetscReal s[SLIP_MAX_STATES], ds[SLIP_MAX_STATES];

  if (guess > 0) return PetscMin(PetscLogReal(guess), PetscLogReal(load / c->diagonal));
  StateAdvance(f->law, &p, c->theta, c->s0, 0, s, ds);
  return PetscLogReal(SlipFrictionBalanceOne(f->law, &p, s, strength, c->diagonal, load));
}

/*
  SlipFrictionStageRate - computes the slip rate v of cell i alone at the end of a stage, D v + omega w sigma mu(s(v),
  |v|) sign(v) = load, for a law whose cells always slide

  s(v) = s0 + theta ds/dt is the state there. Newton's method in ln v works in a bracket, from the guess or an initial
  rate of its own. At constant state friction grows with v, and there is one root. With a changing state a long stage
  can weaken faster than D v grows: then the root next to the guess is used, and *stable is false if there is no root at
  which the sum grows without a decrease in between.
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
