/*
  Rate-and-state friction that weakens strongly at seismic rates, as by flash heating of contacts (Noda, Dunham & Rice
  2009; Dunham et al. 2011):

     mu = a asinh( V/(2 V0) exp(psi/a) ),   dpsi/dt = -V/d_c (psi - psi_ss(V)),   psi_ss = a ln( 2 V0/V sinh(f_ss/a) ),
     f_ss = f_w + (f_LV - f_w)/(1 + (V/V_w)^8)^(1/8),   f_LV = f0 - (b - a) ln(V/V0).

  psi is f0 + b s with the state s = ln(V0 theta/d_c) of ratestate.c, so that friction, its balance and the effect of
  changing normal stress are those of rate_and_state; b is not 0. Far below V_w this is its slip law.
*/
#include <slipcompat.h>
#include <slipstep/rooms/slipcore.h>
#include <math.h>

/* Places in the law's own parameters */
enum { WEAKENED, WEAKENING_RATE };

const SlipParameter SlipStrongParameters[] = {
  [WEAKENED] = {"friction_weakened", 0.2, "", 0, PETSC_MAX_REAL, PETSC_FALSE, PETSC_FALSE,
                "Steady friction f_w of strong_rate_weakening far above the rate V_w", SLIP_PART_PROBLEM},
  [WEAKENING_RATE] = {"friction_weakening_rate", 0.1, "m/s", 0, PETSC_MAX_REAL, PETSC_TRUE, PETSC_FALSE,
                      "Rate V_w at which strong_rate_weakening weakens", SLIP_PART_PROBLEM},
  {.name = NULL},
};

/* f_ss/a is at least this, as of rates that no friction is for: steps that are rejected need finite numbers. */
#define LEAST_STEADY 1e-3

/* 2 sinh(y) is exp(y) to rounding from here on, as of nearly all friction. */
#define SINH_IS_EXP 20

/* s of the steady state, and its derivative with respect to ln V (NULL: not wanted). The eighth power and its root are
   products and square roots: friction took a fifth of the time of TPV103, which is now 0.92 of what it was. A loop by
   vector instructions is no faster, as divisions take most of it. */
static PetscReal SteadyOf(const SlipFriction *p, PetscReal v, PetscReal *slope)
{
  const PetscReal weakened = p->own[WEAKENED], rate = PetscMax(v, 1e-300), over = rate / p->own[WEAKENING_RATE],
                  log_rate = PetscLogReal(rate / p->reference_rate),
                  fourth = PetscSqr(PetscSqr(PetscMin(over, 1 / over))), eighth = fourth * fourth,
                  root = PetscSqrtReal(PetscSqrtReal(PetscSqrtReal(1 + eighth))) * PetscMax(over, 1);
  const PetscReal fall = 1 / root, /* (1 + (V/V_w)^8)^(-1/8) */
    share = (over > 1 ? 1 : eighth) / (1 + eighth), excess = p->reference - (p->b - p->a) * log_rate - weakened,
                  y = PetscMax((weakened + excess * fall) / p->a, LEAST_STEADY);
  const PetscReal log_sinh = y > SINH_IS_EXP ? y : y + log1p(-PetscExpReal(-2 * y));

  if (slope) *slope = ((y > LEAST_STEADY ? fall * (p->a - p->b - excess * share) / tanh(y) : 0) - p->a) / p->b;
  return (p->a * (log_sinh - log_rate) - p->reference) / p->b;
}

/* ds/dt and its derivatives: a SlipStateFn */
void SlipStrongRate(const SlipFriction *p, const PetscReal s[], PetscReal v, PetscReal rate[], PetscReal drate_ds[],
                    PetscReal drate_dv[])
{
  PetscReal slope, excess;

  excess = *s - p->shift - SteadyOf(p, v, &slope);
  *rate = v > 0 ? -v / p->slip * excess : 0;
  *drate_ds = -v / p->slip;
  *drate_dv = (slope - excess) / p->slip;
}

/* s with ds/dt = 0: a SlipSteadyFn */
void SlipStrongSteady(const SlipFriction *p, PetscReal v, PetscReal s[])
{
  *s = SteadyOf(p, v, NULL) + p->shift;
}

/* Ten times V_w, where friction has lost nine tenths of what it can lose */
PetscReal SlipStrongRupture(const SlipFriction *p)
{
  return 10 * p->own[WEAKENING_RATE];
}

/* The parameters of cell i that its rate needs */
static SlipFriction CellOf(const SlipFrictionCells *f, PetscInt i)
{
  return (SlipFriction){.slip = f->slip[i],
                        .a = f->a[i],
                        .b = f->b[i],
                        .reference = f->reference[i],
                        .reference_rate = f->reference_rate,
                        .own = f->own + f->nown * i,
                        .shift = f->alpha ? SlipRateAndStateShift(f->alpha[i], f->b[i], f->stress[i], f->start[i]) : 0};
}

/* SlipFrictionBalance() of this law: the rates of rate_and_state, and what they do to the state */
void SlipStrongBalance(const SlipFrictionCells *f, const PetscReal kept[], PetscInt n, PetscReal eta,
                       const PetscReal tau[], PetscInt stride, const PetscReal s[], PetscReal v[], PetscReal ds[])
{
  SlipRateAndStateBalance(f, kept, n, eta, tau, stride, s, v, NULL);
  for (PetscInt i = 0; i < n && ds; i++) {
    const SlipFriction p = CellOf(f, i);
    const PetscReal rate = PetscAbsReal(v[i]);

    ds[stride * i] = rate > 0 ? -rate / p.slip * (s[stride * i] - p.shift - SteadyOf(&p, rate, NULL)) : 0;
  }
}

/* The state of n cells after h at constant rates, exactly: it approaches the steady one exponentially. */
PetscBool SlipStrongDrift(const SlipFrictionCells *f, PetscInt n, PetscReal h, const PetscReal v[], PetscInt stride,
                          PetscReal s[])
{
  for (PetscInt i = 0; i < n; i++) {
    const SlipFriction p = CellOf(f, i);
    const PetscReal rate = PetscAbsReal(v[i]);
    PetscReal steady;

    if (rate == 0) continue;
    SlipStrongSteady(&p, rate, &steady);
    s[stride * i] = steady + (s[stride * i] - steady) * PetscExpReal(-rate * h / p.slip);
  }
  return PETSC_TRUE;
}
