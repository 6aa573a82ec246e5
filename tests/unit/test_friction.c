/* Friction laws: values at known points, derivatives against Richardson's extrapolated central differences. */
#include "unit.h"
#include <slipstep/private/slipfault.h>
#include <math.h>

static const SlipFriction p = {.residual = 0.5, .drop = 0.1, .slip = 0.08, .rate = 0.05};

static PetscReal Value(const SlipFrictionLaw *law, PetscReal s, PetscReal v)
{
  PetscReal excess, ds, dv;

  law->eval(&p, &s, v, &excess, &ds, &dv);
  return p.residual + excess;
}

/* (4 D(h/2) - D(h))/3, D the central difference: error O(h^4). */
static PetscReal Difference(const SlipFrictionLaw *law, PetscReal s, PetscReal v, PetscReal hs, PetscReal hv)
{
  const PetscReal h = hs + hv;
  const PetscReal D = (Value(law, s + hs, v + hv) - Value(law, s - hs, v - hv)) / (2 * h);
  const PetscReal half = (Value(law, s + hs / 2, v + hv / 2) - Value(law, s - hs / 2, v - hv / 2)) / h;

  return (4 * half - D) / 3;
}

/* With h = 1e-3 of the law's scale L the truncation, (h/L)^4, and the round-off, eps (mu/drop)(L/h), are both about
   1e-12 of the slope drop/L: 1e-10 is a hundred times that, and a wrong factor or sign is off by the slope itself. */
static void derivatives(void **state)
{
  const PetscReal s[] = {0.01, 0.05, 0.0799, 0.1, 0.4}, v[] = {0.001, 0.03, 0.2};

  for (const SlipFrictionLaw *law = SlipFrictionLaws; law->name; law++) {
    if (law->always_slides) continue; /* test_ratestate.c */
    for (size_t i = 0; i < sizeof(s) / sizeof(s[0]); i++) {
      for (size_t j = 0; j < sizeof(v) / sizeof(v[0]); j++) {
        PetscReal mu, ds, dv;

        law->eval(&p, &s[i], v[j], &mu, &ds, &dv);
        assert_true(fabs(ds - Difference(law, s[i], v[j], 1e-3 * p.slip, 0)) < 1e-10 * p.drop / p.slip);
        assert_true(fabs(dv - Difference(law, s[i], v[j], 0, 1e-3 * p.rate)) < 1e-10 * p.drop / p.rate);
      }
    }
  }
}

static void values(void **state)
{
  const SlipFrictionLaw *law;

  assert_int_equal(0, SlipFrictionFind("exponential_slip_weakening", &law));
  assert_true(fabs(Value(law, 0, 0) - 0.6) < 1e-15);
  assert_true(fabs(Value(law, p.slip, 0) - (0.5 + 0.1 * 0.36787944117144233)) < 1e-15); /* 1/e */
  assert_int_equal(0, SlipFrictionFind("linear_slip_weakening", &law));
  assert_true(fabs(Value(law, p.slip / 2, 1) - 0.55) < 1e-15);
  assert_true(Value(law, 2 * p.slip, 1) == 0.5);
  assert_int_equal(0, SlipFrictionFind("rate_weakening", &law));
  assert_true(fabs(Value(law, 7, p.rate) - 0.55) < 1e-15);
  assert_int_equal(0, SlipFrictionFind("constant", &law));
  assert_true(Value(law, 7, 3) == 0.5);
  assert_int_equal(0, SlipFrictionFind("velcro", &law));
  assert_null(law);
}

/* Healing, ds/dt = |v| - s/t_h. At rest the solution is s0 exp(-t/t_h). A stage that is implicit by theta is the
   backward rule: s = s0 + theta (|v| - s/t_h), whose error over n steps of t/n is t^2/(2 n) |s''| to first order: twice
   as many steps halve it within the next order, 1/n. 1e-15: rounding of numbers below 1. */
static void healing(void **state)
{
  const PetscReal one[] = {0.1}, rate[] = {0.25}, v[] = {-0.03}, s0 = 0.3, t = 2,
                  exact = 0.12 + (0.3 - 0.12) * exp(-0.5);
  const SlipFrictionCells cells = {
    .law = SlipFrictionLaws, .residual = one, .drop = one, .slip = one, .rate = one, .stress = one, .healing = rate};
  PetscReal error[2], rest;

  SlipFrictionStateAtRest(&cells, 0, &s0, t, &rest);
  assert_true(fabs(rest - s0 * exp(-0.5)) < 1e-15);
  for (int k = 0; k < 2; k++) {
    const int n = 1000 << k;
    PetscReal s = s0, ds, mu, dmu_ds, dmu_dv, ds_dv;

    for (int i = 0; i < n; i++) {
      const PetscReal before = s;

      SlipFrictionStateAdvance(&cells, 1, t / n, &before, v, 1, &s);
      SlipFrictionStateRate(&cells, 1, 1, &s, 1, v, &ds);
      assert_true(fabs(s - before - t / n * ds) < 1e-15);
    }
    SlipFrictionStage(&cells, 0, t, &s0, v[0], &mu, &dmu_ds, &dmu_dv, &ds_dv);
    assert_true(fabs(ds_dv - t / (1 + t * rate[0])) < 1e-15);
    error[k] = s - exact;
  }
  assert_true(fabs(error[0] / error[1] - 2) < 5e-3);
}

/* The functions of many cells that weaken exponentially, and heal, against those of one: the strength at a stage's end
   and its derivative, and the rates of slip and state where friction and damping balance. */
static void healing_of_many(void **state)
{
  enum { N = 2 };
  const PetscReal residual[] = {0.5, 0.6}, drop[] = {0.1, 0.2}, slip[] = {0.05, 0.2}, stress[] = {2, 3},
                  healing[] = {0.25, 4}, s0[] = {0.02, 0.3}, v[] = {0.1, -0.05}, tau[] = {1.5, -3}, theta = 0.4;
  const SlipFrictionCells f = {.law = SlipFrictionLaws,
                               .residual = residual,
                               .drop = drop,
                               .slip = slip,
                               .rate = drop,
                               .stress = stress,
                               .healing = healing};
  PetscReal q[N], dq[N], rate[N], ds[N], other[N];

  SlipFrictionStrength(&f, N, theta, 1, s0, 1, v, q, dq);
  SlipFrictionBalance(&f, NULL, N, 10, tau, 1, s0, rate, ds);
  SlipFrictionStateRate(&f, N, 1, s0, 1, rate, other);
  for (PetscInt i = 0; i < N; i++) {
    PetscReal mu, dmu_ds, dmu_dv, ds_dv;

    SlipFrictionStage(&f, i, theta, &s0[i], v[i], &mu, &dmu_ds, &dmu_dv, &ds_dv);
    AssertNear(q[i], stress[i] * mu, 1e-15);
    AssertNear(dq[i], stress[i] * dmu_ds * ds_dv, 1e-15);
    assert_true(rate[i] != 0 && ds[i] == other[i]);
  }
}

/* What a law remembers of a cell is the same, to the bit, whatever was asked for before. */
static void remembered(void **state)
{
  const PetscReal residual = 0.5, drop = 0.1, slip = 0.05, stress = 2;
  PetscReal known[] = {NAN, 0, 0, NAN};
  SlipFrictionCells f = {
    .law = SlipFrictionLaws, .residual = &residual, .drop = &drop, .slip = &slip, .rate = &drop, .stress = &stress};

  for (PetscInt k = 0; k < 40; k++) {
    const PetscReal s = 0.01 * (PetscReal)(k * k % 7);
    PetscReal mu[2], ds[2], dv[2], none;

    for (int i = 0; i < 2; i++) {
      f.known = i ? known : NULL;
      if (k % 2)
        SlipFrictionEvaluate(&f, 0, &s, 0.1, &mu[i], &ds[i], &dv[i]);
      else
        SlipFrictionStage(&f, 0, 0, &s, 0.1, &mu[i], &ds[i], &dv[i], &none);
    }
    assert_true(f.law->remembers && known[0] == s);
    assert_true(mu[0] == mu[1] && ds[0] == ds[1] && dv[0] == dv[1] && mu[0] == residual + drop * exp(-s / slip));
    assert_true(SlipFrictionWeakest(&f, 0) == residual);
  }
}

SLIP_TESTS(derivatives, values, healing, healing_of_many, remembered)
