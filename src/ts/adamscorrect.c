/* Steps of TSADAMS that are corrected more than once, where stability and not the error limits them: m corrections are
   stable over some 0.8 ((m + 1)^2 - 1) relaxation times with a predictor of order 2, two thirds of that with one of
   order 3, for m + 1 right-hand sides, and have the order and the derivatives of one (src/core/adamsweights.c). */
#include <slipstep/private/slipts.h>

/* Steps with one correction are stable to some three relaxation times, of the order that errors near there lead to. */
#define STABLE 3
/* Margin of the fastest rate, which is found by products, from below */
#define RATE_MARGIN 1.05
/* A step beyond STABLE is to be this much more exact than the tolerance: errors of quiet times add up to those of the
   times of events, and steps that stability limits are that exact. */
#define EXACT 40
/* Two corrections pay from a step 1.5 times as long on, which a controller at the bound may not ask for: pi asks for
   1.2. So many times the step that it asks for are looked at, as far as they are EXACT: with cells of 500 m 0.78 of the
   products of BP5 at the same error. */
#define LEAP 2
/* A rate that has grown since the step before grows by no more within the next one. */
#define MOST_GROWTH 2

/* Weights of the corrector with k derivatives beside f*; [0] is that of f* */
void SlipAdamsCorrector(const TS_Adams *ad, PetscReal h, PetscInt k, PetscReal weight[])
{
  PetscReal node[SLIP_ADAMS_NODES] = {1};

  for (PetscInt j = 0; j < k; j++) node[j + 1] = -ad->age[j] / h;
  SlipAdamsWeights(k + 1, node, weight);
}

/* Weight of the new derivative in the corrector, over h */
static PetscReal Gamma(const TS_Adams *ad, PetscReal h, PetscInt k)
{
  PetscReal weight[SLIP_ADAMS_NODES];

  SlipAdamsCorrector(ad, h, k, weight);
  return weight[0];
}

/* ---- how many, and how long a step ---- */

/* Corrections of a step of hr relaxation times with a predictor of order k: the least that are stable, or as many as
   may be */
static PetscInt Needed(const TS_Adams *ad, PetscInt k, PetscReal gamma, PetscReal hr)
{
  PetscInt m = 2;

  if (hr <= STABLE || ad->most < 2 || SlipAdamsReach(k, 2) == 0) return 1;
  while (m < ad->most && SlipAdamsReach(k, m + 1) > 0 && SlipAdamsReach(k, m) < gamma * RATE_MARGIN * hr) m++;
  return m;
}

/* What a step of hr relaxation times is cut to: stable, and no longer than it pays in right-hand sides, whose number is
   *cost */
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

/* How many relaxation times a step may be long, after one of hr whose estimate of order k has this norm */
static PetscReal Exact(PetscInt k, PetscReal norm, PetscReal hr)
{
  return PetscMax(STABLE, hr * PetscPowReal(EXACT * norm, -1 / (PetscReal)(k + 1)));
}

/* How much longer a step of order k may be by its estimate; beyond what is stable with one correction, for as many
   right-hand sides as that takes */
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

/* Corrections of the attempt, whose rate may grow as it did in the step before */
void SlipAdamsCount(TS ts)
{
  TS_Adams *ad = (TS_Adams *)ts->data;
  const PetscReal h = ts->time_step, hr = h * ad->rates[0];
  PetscReal grown = 1;

  ad->corrections = 1;
  if (hr <= STABLE) return; /* as it was bounded */
  if (ad->rates[1] > 0) grown = PetscPowReal(ad->rates[0] / ad->rates[1], h / ad->at.h);
  ad->corrections = Needed(ad, ad->order, Gamma(ad, h, ad->order), PetscClipInterval(grown, 1, MOST_GROWTH) * hr);
}

/* Steps are stable to some three relaxation times with one correction, and with more as long as pays. A learned
   controller observes them, and constant steps are the user's; others go by an error that shows an instability when it
   is there. */
PetscErrorCode SlipAdamsBoundStep(TS ts, const SlipProblemOps *problem, void *ctx)
{
  TS_Adams *ad = (TS_Adams *)ts->data;
  PetscReal rate, hr, longest;
  PetscBool left;
  PetscInt cost;

  PetscFunctionBegin;
  PetscCall(PetscObjectTypeCompareAny((PetscObject)ts->adapt, &left, TSADAPTNONE, TSADAPTHISTORY, "rl", ""));
  if (left) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall((*problem->relaxation)(ts, ts->vec_sol, &rate, ctx));
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

/* y += weight (f - extrapolated); good: it is a state at t */
static PetscErrorCode Relax(TS ts, PetscReal t, Vec extrapolated, PetscReal weight, Vec f, Vec y, PetscBool *good)
{
  PetscFunctionBegin;
  PetscCall(VecAXPBYPCZ(y, weight, -weight, 1, f, extrapolated));
  PetscCall(SlipGuardState(y, good));
  if (*good) PetscCall(TSFunctionDomainError(ts, t, y, good));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* y = the corrected state from the predicted one, with its derivative in ad->star, at first that of the predicted one.
   Factor by factor of src/core/adamsweights.c; one of degree 2, 1 - a x + b x^2, goes by way of a state between. */
PetscErrorCode SlipAdamsCorrectMore(TS ts, Vec predicted, Vec y, PetscBool *good)
{
  TS_Adams *ad = (TS_Adams *)ts->data;
  const PetscReal t = ts->ptime + ts->time_step, h = ts->time_step;
  const PetscReal(*factor)[2] = SlipAdamsFactors(ad->order, ad->corrections);
  const Vec extrapolated = ad->room[0], between = ad->room[1], f = ad->star;
  PetscReal node[SLIP_ADAMS_NODES], weight[SLIP_ADAMS_NODES], corrector[SLIP_ADAMS_NODES], whole;
  const PetscInt k = ad->order;

  PetscFunctionBegin;
  /* with the derivative to which those before extrapolate the corrected state would be the predicted one */
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
