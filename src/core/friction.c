/* Friction laws: one row each, with derivatives; the evolution of their state over a stage; the strength that they give
   a cell. Pure functions: the fault's constraint and the trainer's loop without objects both call them, so that a law
   is written here and nowhere else. */
#include <slipcompat.h>
#include <slipcore.h>

/* Slip and slip rate beyond which no law weakens any more; finite, so that laws can divide by them. */
#define WEAK_SLIP 1e30
#define WEAK_RATE 1e30

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
  (void)p;
  (void)s;
  (void)v;
  *excess = 0;
  *dmu_ds = 0;
  *dmu_dv = 0;
}

const SlipFrictionLaw SlipFrictionLaws[] = {
  {"exponential_slip_weakening", ExponentialSlipWeakening, "residual + drop exp(-s/slip)", PETSC_FALSE},
  {"linear_slip_weakening", LinearSlipWeakening, "residual + drop max(0, 1 - s/slip)", PETSC_FALSE},
  {"rate_weakening", RateWeakening, "residual + drop/(1 + |v|/rate)", PETSC_TRUE},
  {"constant", Constant, "residual", PETSC_FALSE},
  {NULL, NULL, NULL, PETSC_FALSE},
};

/*
  SlipFrictionFind - the friction law of a name

  Not collective. law is NULL when there is none.
*/
PetscErrorCode SlipFrictionFind(const char name[], const SlipFrictionLaw **law)
{
  PetscFunctionBegin;
  *law = NULL;
  for (const SlipFrictionLaw *l = SlipFrictionLaws; l->name; l++) {
    PetscBool same;

    PetscCall(PetscStrcmp(name, l->name, &same));
    if (same) *law = l;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the state: the slip s of both signs, which rest lets heal: ds/dt = |v| - s/t_h ---- */

static PetscReal StateRate(const SlipFriction *p, PetscReal s, PetscReal rate)
{
  return rate - s * p->healing;
}

/* At the end of a stage that is implicit by theta, s = s0 + theta ds/dt, and its derivative with respect to the rate
   there */
static PetscReal StateAdvance(const SlipFriction *p, PetscReal theta, PetscReal s0, PetscReal rate, PetscReal *ds)
{
  const PetscReal share = 1 / (1 + theta * p->healing);

  *ds = theta * share;
  return (s0 + theta * rate) * share;
}

/* After t [s] of rest, exactly */
static PetscReal StateAtRest(const SlipFriction *p, PetscReal s0, PetscReal t)
{
  return p->healing > 0 ? s0 * PetscExpReal(-t * p->healing) : s0;
}

/* ---- many cells ---- */

static inline SlipFriction At(const SlipFrictionCells *f, PetscInt i)
{
  const SlipFriction p = {f->residual[i], f->drop[i], f->slip[i], f->rate[i], f->healing ? f->healing[i] : 0};

  return p;
}

/* mu of cell i and its derivatives */
void SlipFrictionEvaluate(const SlipFrictionCells *f, PetscInt i, PetscReal s, PetscReal v, PetscReal *mu,
                          PetscReal *dmu_ds, PetscReal *dmu_dv)
{
  const SlipFriction p = At(f, i);

  f->law->eval(&p, s, v, mu, dmu_ds, dmu_dv);
  *mu = p.residual + *mu;
}

/* What mu of cell i exceeds its residual by */
PetscReal SlipFrictionExcess(const SlipFrictionCells *f, PetscInt i, PetscReal s, PetscReal v)
{
  const SlipFriction p = At(f, i);
  PetscReal excess, ds, dv;

  f->law->eval(&p, s, v, &excess, &ds, &dv);
  return excess;
}

/* mu of cell i after all weakening */
PetscReal SlipFrictionWeakest(const SlipFrictionCells *f, PetscInt i)
{
  return f->residual[i] + SlipFrictionExcess(f, i, WEAK_SLIP, WEAK_RATE);
}

/* mu of cell i at the end of a stage that starts from s0 and is implicit by theta [s], with the rate v there; its
   derivatives and that of the state s there with respect to |v| */
void SlipFrictionStage(const SlipFrictionCells *f, PetscInt i, PetscReal theta, PetscReal s0, PetscReal v,
                       PetscReal *mu, PetscReal *dmu_ds, PetscReal *dmu_dv, PetscReal *ds_dv)
{
  const SlipFriction p = At(f, i);
  const PetscReal rate = PetscAbsReal(v), s = StateAdvance(&p, theta, s0, rate, ds_dv);

  f->law->eval(&p, s, rate, mu, dmu_ds, dmu_dv);
  *mu = p.residual + *mu;
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

    ds[stride * i] = StateRate(&p, s[stride * i], PetscAbsReal(v[stride * i]));
  }
}

/* The state at the end of a stage with the rates v; s, and only it, has a stride */
void SlipFrictionStateAdvance(const SlipFrictionCells *f, PetscInt n, PetscReal theta, const PetscReal s0[],
                              const PetscReal v[], PetscInt stride, PetscReal s[])
{
  for (PetscInt i = 0; i < n; i++) {
    const SlipFriction p = At(f, i);
    PetscReal ds;

    s[stride * i] = StateAdvance(&p, theta, s0[i], PetscAbsReal(v[i]), &ds);
  }
}

/* The state of cell i after t [s] of rest */
PetscReal SlipFrictionStateAtRest(const SlipFrictionCells *f, PetscInt i, PetscReal s0, PetscReal t)
{
  const SlipFriction p = At(f, i);

  return StateAtRest(&p, s0, t);
}
