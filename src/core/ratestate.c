/*
  Rate-and-state friction (Dieterich 1979, Ruina 1983), regularised at zero slip rate (Rice & Ben-Zion 1996; Lapusta et
  al. 2000), with the state psi = ln(V0 theta/d_c), dimensionless:

     mu = a asinh( V/(2 V0) exp((f0 + b psi)/a) ),
     dpsi/dt = V0/d_c exp(-psi) - V/d_c                    aging law, dtheta/dt = 1 - V theta/d_c
     dpsi/dt = -V/d_c (ln(V/V0) + psi)                     slip law, dtheta/dt = -(V theta/d_c) ln(V theta/d_c)
     dpsi/dt = V0/d_c exp(-psi - V/V_c) - V/d_c (ln(V/V0) + psi)
                          composite law (Kato & Tullis 2001), dtheta/dt = exp(-V/V_c) - (V theta/d_c) ln(V theta/d_c)
     dpsi/dt = V0/d_c exp(-psi) - V^2/(4 d_c V0) exp(psi)
                          law of Perrin, Rice & Zheng (1995), dtheta/dt = 1 - (V theta/(2 d_c))^2

  where normal stress changes the state by alpha/b ln(sigma/sigma0) (Linker & Dieterich 1992: d psi/dt is that of the
  law minus alpha/(b sigma) dsigma/dt). The state is s = psi + alpha/b ln(sigma/sigma0), whose rate is that of the law
  alone, so that the rate of sigma is not needed; sigma0 is the normal stress before any change.

  The file also computes the slip rate at which friction and radiation damping eta V balance a shear stress.
*/
#include <slipcompat.h>
#include <slipstep/rooms/slipcore.h>
#include <math.h>

/* ln(V/(2 V0)) + (f0 + b psi)/a: the logarithm of the argument of asinh, because a small a makes the argument large */
static PetscReal Argument(const SlipFriction *p, PetscReal s, PetscReal v)
{
  return PetscLogReal(v / (2 * p->reference_rate)) + (p->reference + p->b * (s - p->shift)) / p->a;
}

/* mu and its derivatives (v >= 0): a SlipFrictionFn */
void SlipRateAndState(const SlipFriction *p, const PetscReal s[], PetscReal v, PetscReal *mu, PetscReal dmu_ds[],
                      PetscReal *dmu_dv)
{
  PetscReal x, small, share;

  *mu = *dmu_ds = 0;
  *dmu_dv = p->a * PetscMin(PetscExpReal(PetscMin((p->reference + p->b * (*s - p->shift)) / p->a, 660)) /
                              (2 * p->reference_rate),
                            1e300);
  if (v <= 0) return;
  v = PetscMax(v, 1e-300); /* avoids a logarithm of 0 in steps that are rejected */
  x = Argument(p, *s, v);
  small = PetscExpReal(-PetscAbsReal(x));
  /* asinh(e^x) = x + ln(1 + sqrt(1 + e^-2x)) */
  *mu = p->a * (x > 0 ? x + PetscLogReal(1 + PetscSqrtReal(1 + small * small)) : asinh(small));
  share = x > 0 ? 1 / PetscSqrtReal(1 + small * small) : small / PetscSqrtReal(1 + small * small);
  *dmu_ds = p->b * share;
  *dmu_dv = p->a * share / v;
}

/* dpsi/dt and its derivatives: a SlipStateFn */
void SlipRateAndStateRate(const SlipFriction *p, const PetscReal s[], PetscReal v, PetscReal rate[],
                          PetscReal drate_ds[], PetscReal drate_dv[])
{
  const PetscReal aging = p->reference_rate / p->slip * PetscExpReal(PetscMin(p->shift - *s, SLIP_MOST_HEALING));
  PetscReal excess;

  if (p->state_law == SLIP_STATE_PRZ) {
    const PetscReal fall =
      v * v / (4 * p->slip * p->reference_rate) * PetscExpReal(PetscMin(*s - p->shift, SLIP_MOST_HEALING));

    *rate = aging - fall;
    *drate_ds = -aging - fall;
    *drate_dv = v > 0 ? -2 * fall / v : 0;
    return;
  }
  if (p->state_law != SLIP_STATE_AGING) {
    excess = v > 0 ? PetscLogReal(v / p->reference_rate) + *s - p->shift : 0;
    *rate = -v / p->slip * excess;
    *drate_ds = -v / p->slip;
    *drate_dv = -(excess + 1) / p->slip;
    if (p->state_law == SLIP_STATE_COMPOSITE) {
      const PetscReal healing = aging * PetscExpReal(-v / p->cutoff_rate);

      *rate += healing;
      *drate_ds -= healing;
      *drate_dv -= healing / p->cutoff_rate;
    }
    return;
  }
  *rate = aging - v / p->slip;
  *drate_ds = -aging;
  *drate_dv = -1 / p->slip;
}

/* If normal stress vanishes, this fraction of it is used, so that the strength is 0 and psi a finite number */
#define LEAST_STRESS 1e-12

/* s - psi */
PetscReal SlipRateAndStateShift(PetscReal alpha, PetscReal b, PetscReal stress, PetscReal start)
{
  return alpha > 0 ? alpha / b * PetscLogReal(PetscMax(stress / start, LEAST_STRESS)) : 0;
}

/* The steady state: theta = d_c/V, or twice that by the law of Perrin, Rice and Zheng. By the composite law y = ln(V
   theta/d_c) has y exp(y) = exp(-V/V_c): it is 0.567 far below the cut-off rate, and 0 far above it. */
void SlipRateAndStateSteady(const SlipFriction *p, PetscReal v, PetscReal s[])
{
  PetscReal unused;

  *s = PetscLogReal(p->reference_rate / v) + p->shift;
  if (p->state_law == SLIP_STATE_COMPOSITE)
    *s += SlipLambertOfExp(PetscMax(-v / p->cutoff_rate, SLIP_LEAST_LOG), &unused);
  if (p->state_law == SLIP_STATE_PRZ) *s += PetscLogReal(2);
}

/* theta [s] of psi, the state in outputs */
PetscReal SlipRateAndStateTheta(const SlipFriction *p, PetscReal s)
{
  return p->slip / p->reference_rate * PetscExpReal(s - p->shift);
}

/* s = ln(V0 theta/d_c) of theta [s] */
PetscReal SlipRateAndStateOfTheta(const SlipFriction *p, PetscReal theta)
{
  return PetscLogReal(p->reference_rate * theta / p->slip) + p->shift;
}

/* dmu/d ln v where friction is much larger than a */
PetscReal SlipRateAndStateDirect(const SlipFriction *p)
{
  return p->a;
}

/* ---- the balance of one cell ---- */

/* sigma mu(s, v) + eta v - tau and its derivative with respect to ln v */
static PetscReal Excess(const SlipFrictionLaw *law, const SlipFriction *p, const PetscReal s[], PetscReal sigma,
                        PetscReal eta, PetscReal tau, PetscReal v, PetscReal *slope)
{
  PetscReal mu, ds[SLIP_MAX_STATES], dv;

  law->eval(p, s, v, &mu, ds, &dv);
  *slope = (sigma * dv + eta) * v;
  return sigma * mu + eta * v - tau;
}

/*
  The slip rate v of one cell, sigma mu(s, |v|) sign(v) + eta v = tau, by Newton's method in ln v in a bracket, for any
  law whose cells always slide, sigma >= 0 and eta > 0. Without friction v is tau/eta, which bounds it; from there the
  bracket is extended downwards until it contains the root, by factors that are squared each time, so that 300 decades
  take nine of them. The sum is convex in ln v: a step from below passes the root, and where friction is small also the
  upper end, close above the root, from which the next step goes on; bisection towards it would take 50.
*/
PetscReal SlipFrictionBalanceOne(const SlipFrictionLaw *law, const SlipFriction *p, const PetscReal s[],
                                 PetscReal sigma, PetscReal eta, PetscReal tau)
{
  enum { MAX_IT = 200 };
  const PetscReal load = PetscAbsReal(tau), least = PetscLogReal(1e-300);
  PetscReal high = PetscLogReal(load / eta), low = high, x, open = 1, slope;

  if (load == 0 || sigma == 0 || PetscIsInfOrNanReal(high)) return tau / eta;
  for (;;) {
    low = PetscMax(low - open, least);
    if (low <= least || Excess(law, p, s, sigma, eta, load, PetscExpReal(low), &slope) <= 0) break;
    high = low;
    open *= 2;
  }
  x = 0.5 * (low + high);
  for (int it = 0; it < MAX_IT; it++) {
    const PetscReal g = Excess(law, p, s, sigma, eta, load, PetscExpReal(x), &slope);
    PetscReal next = x - g / slope;

    if (PetscAbsReal(g) <= 4 * PETSC_MACHINE_EPSILON * load || /* the rounding of g */
        PetscAbsReal(next - x) <= 2 * PETSC_MACHINE_EPSILON * PetscMax(PetscAbsReal(x), 1)) {
      x = next;
      break;
    }
    if (g > 0)
      high = x;
    else
      low = x;
    if (next >= high && x < high)
      next = high;
    else if (!(next > low && next < high))
      next = 0.5 * (low + high);
    if (next == x) break;
    x = next;
  }
  return tau < 0 ? -PetscExpReal(x) : PetscExpReal(x);
}

/* ---- the balance of many cells ---- */

/* L of slow cells: slip rates below 1.5e-3 a sigma/eta */
#define MOST_SLOW (-6.5)

/* Constants of the balance of a cell: ln(eta V0/(a sigma)) - f0/a, b/a, 1/(a sigma w) [1/Pa], a sigma/eta [m/s] */
typedef struct {
  PetscReal *offset, *slope, *inverse, *scale;
} Constants;

/* The constants from cell i on of n cells; one array is stored after the other */
static Constants ConstantsAt(PetscReal kept[], PetscInt n, PetscInt i)
{
  return (Constants){kept + i, kept + n + i, kept + 2 * n + i, kept + 3 * n + i};
}

/* Cells per chunk: contiguous copies of their numbers fit in the nearest cache, whatever the stride of the state */
enum { CHUNK = 256, AT_ONCE = 32 };

/*
  With y = mu/a the balance is  a sigma y + eta 2 V0 e^-Q sinh y = tau,  Q = (f0 + b psi)/a. If sinh is e^y/2 it is w +
  ln w = L in w = eta V/(a sigma), L = tau/(a sigma) - Q + ln(eta V0/(a sigma)). One step of Newton's method adds the
  other half of sinh; the remaining error is of the order of e^-4y, below rounding from y = 10 on. The few cells below
  that are solved one by one. Loops over cells have no branches or calls, so that they are vectorised.
*/
SLIP_VECTOR static void BalanceFast(PetscInt n, const PetscReal *restrict scale, const PetscReal *restrict load,
                                    const PetscReal *restrict L, PetscReal *restrict v)
{
  /* an impossible rate marks the others, and those of the loop below */
  for (PetscInt i = 0; i < n; i++) v[i] = SlipBalanceRate(load[i], L[i], scale[i], MOST_SLOW);
}

/* The same where L is at most MOST_SLOW, by the series of w in e^L, which is as exact there and saves four divisions
   and four logarithms; most cells between events are slow. Other cells keep their rate. */
SLIP_VECTOR static void BalanceSlow(PetscInt n, const PetscReal *restrict scale, const PetscReal *restrict load,
                                    const PetscReal *restrict L, PetscReal *restrict v)
{
  for (PetscInt i = 0; i < n; i++) {
    /* marked cells also need finite numbers here, or -fp_trap would end a run because of unused values */
    const PetscReal least = L[i] > SLIP_LEAST_LOG ? L[i] : SLIP_LEAST_LOG,
                    x = SlipExp(least < MOST_SLOW ? least : MOST_SLOW);
    const PetscReal w =
      x * (1 - x * (1 - x * (1.5 - x * (8.0 / 3 - x * (125.0 / 24 - x * (10.8 - x * (16807.0 / 720)))))));
    const PetscReal y = load[i] - w, tail = SlipRoughExp(y > SLIP_SINH_IS_EXP ? -2 * y : -2 * SLIP_SINH_IS_EXP);
    const PetscReal V = w * scale[i] * (1 + w * tail) * (1 - tail);
    const PetscReal slow = (y > SLIP_SINH_IS_EXP) & (L[i] > SLIP_LEAST_LOG) & (scale[i] > 0) ? V : PETSC_MAX_REAL;

    v[i] = L[i] <= MOST_SLOW ? slow : v[i];
  }
}

/* Computes load and L of cells, and how many have L beyond MOST_SLOW. */
SLIP_VECTOR static PetscInt Loads(PetscInt n, const Constants *c, const PetscReal *restrict tau,
                                  const PetscReal *restrict s, PetscReal *restrict load, PetscReal *restrict L)
{
  const PetscReal *restrict offset = c->offset, *restrict slope = c->slope, *restrict inverse = c->inverse;
  PetscInt fast = 0;

  for (PetscInt i = 0; i < n; i++) {
    load[i] = PetscAbsReal(tau[i]) * inverse[i];
    L[i] = load[i] + offset[i] - slope[i] * s[i];
    fast += !(L[i] <= MOST_SLOW); /* also if it is NaN */
  }
  return fast;
}

static void BalanceSome(PetscInt n, const Constants *c, const PetscReal tau[], const PetscReal s[], PetscReal v[])
{
  PetscReal load[AT_ONCE], L[AT_ONCE];
  const PetscInt fast = Loads(n, c, tau, s, load, L);

  if (fast) BalanceFast(n, c->scale, load, L, v);
  if (fast < n) BalanceSlow(n, c->scale, load, L, v);
  for (PetscInt i = 0; i < n; i++) v[i] = tau[i] < 0 && v[i] != PETSC_MAX_REAL ? -v[i] : v[i];
}

/* The constants of SlipRateAndStateKeep(), without weights */
SLIP_VECTOR static void ConstantsChunk(PetscInt n, PetscReal eta, PetscReal V0, const PetscReal *restrict a,
                                       const PetscReal *restrict b, const PetscReal *restrict f0,
                                       const PetscReal *restrict stress, const Constants *c)
{
  PetscReal *restrict offset = c->offset, *restrict slope = c->slope, *restrict inverse = c->inverse;
  PetscReal *restrict scale = c->scale;

  for (PetscInt i = 0; i < n; i++) {
    const PetscReal strength = a[i] * stress[i];

    inverse[i] = 1 / (strength > 0 ? strength : 1); /* unused without strength */
    scale[i] = strength / eta;
    slope[i] = b[i] / a[i];
    offset[i] = SlipLog(eta * V0 * inverse[i]) - f0[i] / a[i];
  }
}

/* dpsi/dt of the aging law */
SLIP_VECTOR static void AgingChunk(PetscInt n, PetscReal V0, const PetscReal *restrict slip,
                                   const PetscReal *restrict s, const PetscReal *restrict v, PetscReal *restrict ds)
{
  for (PetscInt i = 0; i < n; i++) ds[i] = SlipAgingRate(V0, slip[i], s[i], PetscAbsReal(v[i]));
}

/* dpsi/dt of the slip law */
SLIP_VECTOR static void SlipChunk(PetscInt n, PetscReal V0, const PetscReal *restrict slip, const PetscReal *restrict s,
                                  const PetscReal *restrict v, PetscReal *restrict ds)
{
  const PetscReal inverse = 1 / V0;

  for (PetscInt i = 0; i < n; i++) ds[i] = SlipSlipLawRate(inverse, slip[i], s[i], PetscAbsReal(v[i]));
}

/* dpsi/dt of the composite law */
SLIP_VECTOR static void CompositeChunk(PetscInt n, PetscReal V0, PetscReal cutoff, const PetscReal *restrict slip,
                                       const PetscReal *restrict s, const PetscReal *restrict v, PetscReal *restrict ds)
{
  const PetscReal inverse = 1 / cutoff;

  for (PetscInt i = 0; i < n; i++) ds[i] = SlipCompositeRate(V0, inverse, slip[i], s[i], PetscAbsReal(v[i]));
}

/* dpsi/dt of the law of Perrin, Rice and Zheng */
SLIP_VECTOR static void PrzChunk(PetscInt n, PetscReal V0, const PetscReal *restrict slip, const PetscReal *restrict s,
                                 const PetscReal *restrict v, PetscReal *restrict ds)
{
  for (PetscInt i = 0; i < n; i++) ds[i] = SlipPrzRate(V0, slip[i], s[i], PetscAbsReal(v[i]));
}

/* dpsi/dt by the law of the state */
static void RatesChunk(const SlipFrictionCells *f, PetscInt n, const PetscReal slip[], const PetscReal s[],
                       const PetscReal v[], PetscReal ds[])
{
  switch (f->state_law) {
  case SLIP_STATE_AGING:
    AgingChunk(n, f->reference_rate, slip, s, v, ds);
    break;
  case SLIP_STATE_SLIP:
    SlipChunk(n, f->reference_rate, slip, s, v, ds);
    break;
  case SLIP_STATE_COMPOSITE:
    CompositeChunk(n, f->reference_rate, f->cutoff_rate, slip, s, v, ds);
    break;
  case SLIP_STATE_PRZ:
    PrzChunk(n, f->reference_rate, slip, s, v, ds);
    break;
  }
}

/* Computes kept [4 n], the constants of SlipRateAndStateBalance(), valid while the normal stress does not change. */
void SlipRateAndStateKeep(const SlipFrictionCells *f, PetscInt n, PetscReal eta, PetscReal kept[])
{
  const Constants c = ConstantsAt(kept, n, 0);

  ConstantsChunk(n, eta, f->reference_rate, f->a, f->b, f->reference, f->stress, &c);
  for (PetscInt i = 0; i < n && f->weight; i++) c.inverse[i] /= f->weight[i];
}

/* psi of n cells from cell start on */
static void StatesOf(const SlipFrictionCells *f, PetscInt start, PetscInt n, PetscInt stride, const PetscReal s[],
                     PetscReal state[])
{
  for (PetscInt i = 0; i < n; i++) state[i] = s[stride * (start + i)];
  for (PetscInt i = 0; i < n && f->alpha; i++)
    state[i] -= SlipRateAndStateShift(f->alpha[start + i], f->b[start + i], f->stress[start + i], f->start[start + i]);
}

/* The balance of a cell for which the closed form does not hold. Events that take nearly all shear stress leave many
   such cells, locked under tau of a few a sigma: there damping is below the rounding of tau, and friction alone
   balances it. */
static PetscReal BalanceCell(const SlipFrictionCells *f, PetscInt i, PetscReal eta, PetscReal tau, PetscReal s)
{
  const SlipFriction p = {
    .a = f->a[i], .b = f->b[i], .reference = f->reference[i], .reference_rate = f->reference_rate};
  const PetscReal load = tau / (f->weight ? f->weight[i] : 1), strength = p.a * f->stress[i];

  if (PetscAbsReal(load) <= SLIP_SINH_IS_EXP * strength && strength > 0) {
    const PetscReal v = 2 * p.reference_rate * PetscExpReal(-(p.reference + p.b * s) / p.a) * sinh(load / strength);

    if (eta * PetscAbsReal(v) <= PETSC_MACHINE_EPSILON / 4 * PetscAbsReal(load)) return v;
  }
  return SlipFrictionBalanceOne(f->law, &p, &s, f->stress[i], eta, load);
}

/* SlipFrictionBalance() of this law; kept: see above, or NULL */
void SlipRateAndStateBalance(const SlipFrictionCells *f, const PetscReal kept[], PetscInt n, PetscReal eta,
                             const PetscReal tau[], PetscInt stride, const PetscReal s[], PetscReal v[], PetscReal ds[])
{
  PetscReal here[SLIP_RATE_AND_STATE_KEPT * CHUNK], state[CHUNK], rate[CHUNK];

  for (PetscInt start = 0; start < n; start += CHUNK) {
    const PetscInt m = PetscMin(CHUNK, n - start);
    const Constants c = kept ? ConstantsAt((PetscReal *)kept, n, start) : ConstantsAt(here, m, 0);

    if (!kept) {
      SlipFrictionCells part = *f;

      part.a += start;
      part.b += start;
      part.reference += start;
      part.stress += start;
      if (part.weight) part.weight += start;
      SlipRateAndStateKeep(&part, m, eta, here);
    }
    StatesOf(f, start, m, stride, s, state);
    for (PetscInt i = 0; i < m; i += AT_ONCE) {
      const Constants some = {c.offset + i, c.slope + i, c.inverse + i, c.scale + i};

      BalanceSome(PetscMin(AT_ONCE, m - i), &some, tau + start + i, state + i, v + start + i);
    }
    for (PetscInt i = start; i < start + m; i++)
      if (v[i] == PETSC_MAX_REAL) v[i] = BalanceCell(f, i, eta, tau[i], state[i - start]);
    if (!ds) continue;
    RatesChunk(f, m, f->slip + start, state, v + start, rate);
    for (PetscInt i = 0; i < m; i++) ds[stride * (start + i)] = rate[i];
  }
}

/* ---- the friction of many cells ---- */

/* mu of rates v > 0 where exp(x), the argument of asinh, is large: a (x + ln 2 + exp(-2 x)/4), to 1e-17 of x from x =
   SLIP_SINH_IS_EXP on. An impossible value marks the other cells. */
SLIP_VECTOR static void ValuesChunk(PetscInt n, PetscReal V0, const PetscReal *restrict a, const PetscReal *restrict b,
                                    const PetscReal *restrict f0, const PetscReal *restrict s,
                                    const PetscReal *restrict v, PetscReal *restrict mu)
{
  const PetscReal inverse = 0.5 / V0;

  for (PetscInt i = 0; i < n; i++) {
    const PetscReal rate = PetscAbsReal(v[i]), least = rate > 1e-300 ? rate : 1e-300;
    const PetscReal x = SlipLog(least * inverse) + (f0[i] + b[i] * s[i]) / a[i];
    const PetscReal tail = SlipRoughExp(x > SLIP_SINH_IS_EXP ? -2 * x : -2 * SLIP_SINH_IS_EXP);

    mu[i] =
      (x > SLIP_SINH_IS_EXP) & (rate > 1e-300) ? a[i] * (x + (0.69314718055994530942 + 0.25 * tail)) : PETSC_MAX_REAL;
  }
}

/* mu of a cell for which this does not hold */
static PetscReal ValueOfCell(const SlipFrictionCells *f, PetscInt i, PetscReal s, PetscReal v)
{
  const SlipFriction p = {
    .a = f->a[i], .b = f->b[i], .reference = f->reference[i], .reference_rate = f->reference_rate};
  PetscReal mu, ds, dv;

  SlipRateAndState(&p, &s, PetscAbsReal(v), &mu, &ds, &dv);
  return mu;
}

/* SlipFrictionValues */
void SlipRateAndStateValues(const SlipFrictionCells *f, PetscInt n, PetscInt stride, const PetscReal s[],
                            PetscInt rates, const PetscReal v[], PetscReal mu[])
{
  PetscReal state[CHUNK], rate[CHUNK];

  for (PetscInt start = 0; start < n; start += CHUNK) {
    const PetscInt m = PetscMin(CHUNK, n - start);

    StatesOf(f, start, m, stride, s, state);
    for (PetscInt i = 0; i < m; i++) rate[i] = v[rates * (start + i)];
    ValuesChunk(m, f->reference_rate, f->a + start, f->b + start, f->reference + start, state, rate, mu + start);
    for (PetscInt i = start; i < start + m; i++)
      if (mu[i] == PETSC_MAX_REAL) mu[i] = ValueOfCell(f, i, state[i - start], rate[i - start]);
  }
}

/* Computes psi of n cells after h at constant rates, exactly: theta approaches its steady value d_c/v exponentially by
   the aging law, as its logarithm does by the slip law. Other laws have no formula here. */
PetscBool SlipRateAndStateDrift(const SlipFrictionCells *f, PetscInt n, PetscReal h, const PetscReal v[],
                                PetscInt stride, PetscReal s[])
{
  const PetscReal V0 = f->reference_rate;

  if (f->state_law != SLIP_STATE_AGING && f->state_law != SLIP_STATE_SLIP) return PETSC_FALSE;
  for (PetscInt i = 0; i < n; i++) {
    const PetscReal rate = PetscAbsReal(v[i]), x = rate * h / f->slip[i], left = PetscExpReal(-x),
                    shift = f->alpha ? SlipRateAndStateShift(f->alpha[i], f->b[i], f->stress[i], f->start[i]) : 0,
                    psi = s[stride * i] - shift;

    if (f->state_law == SLIP_STATE_SLIP) {
      const PetscReal steady = rate > 0 ? -PetscLogReal(rate / V0) : psi;

      s[stride * i] = shift + steady + (psi - steady) * left;
    } else {
      const PetscReal gone = (x > 1e-8 ? -expm1(-x) / x : 1 - x / 2) * h * V0 / f->slip[i]; /* V0/v (1 - left) */

      s[stride * i] = shift + (x - psi > 30 ? PetscLogReal(PetscExpReal(psi - x) + gone)
                                            : psi - x + log1p(gone * PetscExpReal(x - psi)));
    }
  }
  return PETSC_TRUE;
}

/* ---- exponential slip weakening of many cells ---- */

/* Uses the exponential above: one loop without branches or calls, which is vectorised */
SLIP_VECTOR static void WeakeningChunk(PetscInt n, const PetscReal *restrict residual, const PetscReal *restrict drop,
                                       const PetscReal *restrict slip, const PetscReal *restrict s,
                                       PetscReal *restrict mu)
{
  for (PetscInt i = 0; i < n; i++) mu[i] = residual[i] + drop[i] * SlipExp(-s[i] / slip[i]);
}

/* SlipFrictionValues, independent of the rates */
void SlipExponentialWeakeningValues(const SlipFrictionCells *f, PetscInt n, PetscInt stride, const PetscReal s[],
                                    PetscInt rates, const PetscReal v[], PetscReal mu[])
{
  PetscReal state[CHUNK];

  (void)rates, (void)v;
  for (PetscInt start = 0; start < n; start += CHUNK) {
    const PetscInt m = PetscMin(CHUNK, n - start);

    for (PetscInt i = 0; i < m; i++) state[i] = s[stride * (start + i)];
    WeakeningChunk(m, f->residual + start, f->drop + start, f->slip + start, state, mu + start);
  }
}

/* Computes the strength; q stores the states first, and then mu. */
void SlipExponentialWeakeningStrength(const SlipFrictionCells *f, PetscInt n, PetscReal theta, PetscInt stride,
                                      const PetscReal s0[], PetscInt rates, const PetscReal v[], PetscReal q[],
                                      PetscReal dq[])
{
  for (PetscInt i = 0; i < n; i++)
    q[i] = (s0[stride * i] + theta * PetscAbsReal(v[rates * i])) / (1 + (f->healing ? theta * f->healing[i] : 0));
  SlipExponentialWeakeningValues(f, n, 1, q, rates, v, q);
  for (PetscInt i = 0; i < n; i++) {
    const PetscReal sigma = f->weight ? f->weight[i] * f->stress[i] : f->stress[i];

    if (dq)
      dq[i] = -sigma * (q[i] - f->residual[i]) / f->slip[i] * theta / (1 + (f->healing ? theta * f->healing[i] : 0));
    q[i] *= sigma;
  }
}

/* SlipFrictionBalanceFn of cells that may stick; v stores mu first */
void SlipExponentialWeakeningBalance(const SlipFrictionCells *f, const PetscReal kept[], PetscInt n, PetscReal eta,
                                     const PetscReal tau[], PetscInt stride, const PetscReal s[], PetscReal v[],
                                     PetscReal ds[])
{
  (void)kept;
  SlipExponentialWeakeningValues(f, n, stride, s, 1, NULL, v);
  for (PetscInt i = 0; i < n; i++) {
    const PetscReal load = f->weight ? tau[i] / f->weight[i] : tau[i], strength = f->stress[i] * v[i];
    const PetscReal excess = PetscAbsReal(load) - strength;
    const PetscReal speed = excess > SLIP_FRICTION_HOLD * strength ? excess / eta : 0;

    v[i] = load < 0 ? -speed : speed;
    if (ds) ds[stride * i] = speed - s[stride * i] * (f->healing ? f->healing[i] : 0);
  }
}
