/* Friction laws: one row each, with derivatives. Pure functions. */
#include <slipstep/private/slipfault.h>
#include <slipcompat.h>

static void ExponentialSlipWeakening(const SlipFriction *p, PetscReal s, PetscReal v, PetscReal *mu, PetscReal *dmu_ds,
                                     PetscReal *dmu_dv)
{
  const PetscReal weak = p->drop * PetscExpReal(-s / p->slip);

  (void)v;
  *mu = p->residual + weak;
  *dmu_ds = -weak / p->slip;
  *dmu_dv = 0;
}

/* Ida (1972). At the corner s = d_c the derivative is that of the plateau. */
static void LinearSlipWeakening(const SlipFriction *p, PetscReal s, PetscReal v, PetscReal *mu, PetscReal *dmu_ds,
                                PetscReal *dmu_dv)
{
  const PetscBool weakening = s < p->slip ? PETSC_TRUE : PETSC_FALSE;

  (void)v;
  *mu = p->residual + (weakening ? p->drop * (1 - s / p->slip) : 0);
  *dmu_ds = weakening ? -p->drop / p->slip : 0;
  *dmu_dv = 0;
}

/* Burridge and Knopoff (1967), Carlson and Langer (1989), above a residual. */
static void RateWeakening(const SlipFriction *p, PetscReal s, PetscReal v, PetscReal *mu, PetscReal *dmu_ds,
                          PetscReal *dmu_dv)
{
  const PetscReal fall = 1 / (1 + v / p->rate);

  (void)s;
  *mu = p->residual + p->drop * fall;
  *dmu_ds = 0;
  *dmu_dv = -p->drop * fall * fall / p->rate;
}

static void Constant(const SlipFriction *p, PetscReal s, PetscReal v, PetscReal *mu, PetscReal *dmu_ds,
                     PetscReal *dmu_dv)
{
  (void)s;
  (void)v;
  *mu = p->residual;
  *dmu_ds = 0;
  *dmu_dv = 0;
}

const SlipFrictionLaw SlipFrictionLaws[] = {
  {"exponential_slip_weakening", ExponentialSlipWeakening, "residual + drop exp(-s/slip)"},
  {"linear_slip_weakening", LinearSlipWeakening, "residual + drop max(0, 1 - s/slip)"},
  {"rate_weakening", RateWeakening, "residual + drop/(1 + |v|/rate)"},
  {"constant", Constant, "residual"},
  {NULL, NULL, NULL},
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
