/* TSADAMS corrects a step more than once where stability and not the error limits it. A step with m corrections is
   stable over about 0.8 ((m + 1)^2 - 1) relaxation times with a predictor of order 2, two thirds of that with order 3,
   and takes m + 1 right-hand sides; order and derivatives are those of one correction (src/core/adamsweights.c). */
#include <slipstep/private/slipts.h>

/* A step with one correction is stable to about 3 relaxation times, at the order that is chosen near that limit. */
#define STABLE 3
/* Margin of the fastest rate, because products estimate it from below */
#define RATE_MARGIN 1.05
/* The error of a step beyond STABLE must be so many times below the tolerance: errors of quiet times add up to errors
   of the times of events, and steps that stability limits are as accurate. */
#define EXACT 40
/* Two corrections pay if the step becomes 1.5 times as long, but a controller at the bound may not propose that: pi
   proposes 1.2. Steps up to so many times the proposed one are therefore considered if they are EXACT. With cells of
   500 m, BP5 then takes 0.78 of the products at the same error. */
#define LEAP 2
/* Largest assumed growth of the rate within the next step */
#define MOST_GROWTH 2

/* Computes the weights of the corrector with k derivatives besides f*; weight[0] is that of f*. */
void SlipAdamsCorrector(const TS_Adams *ad, PetscReal h, PetscInt k, PetscReal weight[])
{
  PetscReal node[SLIP_ADAMS_NODES] = {1};

  for (PetscInt j = 0; j < k; j++) node[j + 1] = -ad->age[j] / h;
  SlipAdamsWeights(k + 1, node, weight);
}

/* Returns the weight of the new derivative in the corrector over h. */
static PetscReal Gamma(const TS_Adams *ad, PetscReal h, PetscInt k)
{
  PetscReal weight[SLIP_ADAMS_NODES];

  SlipAdamsCorrector(ad, h, k, weight);
  return weight[0];
}

/* ---- how many, and how long a step ---- */

/* Returns the number of corrections of a step of hr relaxation times with a predictor of order k: the smallest number
   that is stable, or the largest allowed one. */
static PetscInt Needed(const TS_Adams *ad, PetscInt k, PetscReal gamma, PetscReal hr)
{
  PetscInt m = 2;

  if (hr <= STABLE || ad->most < 2 || SlipAdamsReach(k, 2) == 0) return 1;
  while (m < ad->most && SlipAdamsReach(k, m + 1) > 0 && SlipAdamsReach(k, m) < gamma * RATE_MARGIN * hr) m++;
  return m;
}

/* Returns the length, in relaxation times, to which a step of hr is cut so that it is stable and advances the most per
   right-hand side; *cost is their number. */
static PetscReal Bound(const TS_Adams *ad, PetscInt k, PetscReal gamma, PetscReal hr, PetscInt *cost)
{
  const PetscInt m = Needed(ad, k, gamma, hr);
  PetscReal less = STABLE;

  *cost = m + 1;
  if (m == 1) return PetscMin(hr, STABLE);
  if (m > 2) less = PetscMax(less, SlipAdamsReach(k, m - 1) / (gamma * RATE_MARGIN));
  hr = PetscMin(hr, SlipAdamsReach(k, m) / (gamma * RATE_MARGIN));
  if (less / (PetscReal)m < hr / (PetscReal)(m + 1)) return hr;
  *cost = m;
  return less;
}

/* Returns the allowed length, in relaxation times, after a step of hr whose estimate of order k has this norm. */
static PetscReal Exact(PetscInt k, PetscReal norm, PetscReal hr)
{
  return PetscMax(STABLE, hr * PetscPowReal(EXACT * norm, -1 / (PetscReal)(k + 1)));
}

/* Returns the factor by which a step of order k may be longer by its estimate. Beyond the stability of one correction
   the factor is per right-hand side. */
PetscReal SlipAdamsPromise(TS ts, PetscReal norm, PetscInt k)
{
  const TS_Adams *ad = (TS_Adams *)ts->data;
  const PetscReal longer = PetscPowReal(norm, -1 / (PetscReal)(k + 1)), hr = ts->time_step * ad->rates[0];
  PetscReal bound;
  PetscInt cost;

  if (longer * hr <= STABLE || ad->most < 2) return longer;
  bound = Bound(ad, k, Gamma(ad, ts->time_step, k), Exact(k, norm, hr), &cost);
  return bound / hr * 2 / (PetscReal)cost;
}

/* Sets the number of corrections of the attempt, in which the rate may grow as in the step before. */
void SlipAdamsCount(TS ts)
{
  TS_Adams *ad = (TS_Adams *)ts->data;
  const PetscReal h = ts->time_step, hr = h * ad->rates[0];
  PetscReal grown = 1;

  ad->corrections = 1;
  if (hr <= STABLE) return; /* one correction is stable */
  if (ad->rates[1] > 0) grown = PetscPowReal(ad->rates[0] / ad->rates[1], h / ad->at.h);
  ad->corrections = Needed(ad, ad->order, Gamma(ad, h, ad->order), PetscClipInterval(grown, 1, MOST_GROWTH) * hr);
}

/* Bounds the next step to what is stable with the number of corrections that pays. A learned controller observes the
   relaxation times and constant steps are the user's choice, so these are not bounded; the other controllers see an
   instability in the error only after it has begun. */
PetscErrorCode SlipAdamsBoundStep(TS ts)
{
  TS_Adams *ad = (TS_Adams *)ts->data;
  PetscReal rate = 0, hr, longest;
  PetscBool left;
  PetscInt cost;

  PetscFunctionBegin;
  PetscCall(PetscObjectTypeCompareAny((PetscObject)ts->adapt, &left, TSADAPTNONE, TSADAPTHISTORY, "rl", ""));
  if (left) PetscFunctionReturn(PETSC_SUCCESS);
  SlipProblemTry(ts, steps.relaxation, ts->vec_sol, &rate);
  ad->rates[1] = ad->rates[0];
  ad->rates[0] = rate;
  if (!(rate > 0)) PetscFunctionReturn(PETSC_SUCCESS);
  longest = PetscMin(LEAP * ts->time_step, ts->adapt->dt_max);
  if (ts->time_step * rate <= STABLE || longest < ts->time_step || ts->ptime + longest >= ts->max_time)
    longest = ts->time_step;
  hr = PetscMin(longest * rate, Exact(ad->order, ad->estimated ? ad->norm : 1, ad->at.h * rate));
  hr = Bound(ad, ad->order, Gamma(ad, ts->time_step, ad->order), hr, &cost);
  ts->time_step = PetscMin(longest, hr / rate);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- corrections ---- */

/* y += weight (f - extrapolated); good: y is in the domain of the right-hand side at t. */
static PetscErrorCode Relax(TS ts, PetscReal t, Vec extrapolated, PetscReal weight, Vec f, Vec y, PetscBool *good)
{
  PetscFunctionBegin;
  PetscCall(VecAXPBYPCZ(y, weight, -weight, 1, f, extrapolated));
  PetscCall(SlipGuardState(y, good));
  if (*good) PetscCall(TSFunctionDomainError(ts, t, y, good));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Corrects the predicted state to y. ad->star is the derivative of the predicted state on entry, that of y on return.
   Corrections are the factors of src/core/adamsweights.c; one of degree 2, 1 - a x + b x^2, needs a state between. */
PetscErrorCode SlipAdamsCorrectMore(TS ts, Vec predicted, Vec y, PetscBool *good)
{
  TS_Adams *ad = (TS_Adams *)ts->data;
  const PetscReal t = ts->ptime + ts->time_step, h = ts->time_step;
  const PetscReal(*factor)[2] = SlipAdamsFactors(ad->order, ad->corrections);
  const Vec extrapolated = ad->room[0], between = ad->room[1], f = ad->star;
  PetscReal node[SLIP_ADAMS_NODES], weight[SLIP_ADAMS_NODES], corrector[SLIP_ADAMS_NODES], whole;
  const PetscInt k = ad->order;

  PetscFunctionBegin;
  /* with the derivative that extrapolates the earlier ones, the corrector would return the predicted state */
  for (PetscInt j = 0; j < k; j++) node[j] = -ad->age[j] / h;
  SlipAdamsWeights(k, node, weight);
  SlipAdamsCorrector(ad, h, k, corrector);
  for (PetscInt j = 0; j < k; j++) weight[j] = (weight[j] - corrector[j + 1]) / corrector[0];
  PetscCall(VecZeroEntries(extrapolated));
  PetscCall(VecMAXPY(extrapolated, k, weight, ad->rate));
  PetscCall(VecCopy(predicted, y));
  whole = corrector[0] * h;
  for (PetscInt j = 0; j < (ad->corrections + 1) / 2 && *good; j++) {
    const PetscReal a = factor[j][0], b = factor[j][1], second = 2 * b / a;

    if (b > 0) {
      PetscCall(VecCopy(y, between));
      PetscCall(Relax(ts, t, extrapolated, a / 2 * whole, f, between, good));
      if (!*good) break;
      PetscCall(VecAXPBYPCZ(y, (a - second) * whole, (second - a) * whole, 1, f, extrapolated));
      PetscCall(TSComputeRHSFunction(ts, t, between, f));
    }
    PetscCall(Relax(ts, t, extrapolated, (b > 0 ? second : a) * whole, f, y, good));
    if (*good) PetscCall(TSComputeRHSFunction(ts, t, y, f));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
