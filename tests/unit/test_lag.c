/* The longest stable step of explicit steps with lagged damping: against eigenvalues of the step's matrix, and by steps
   of a system of which some degrees of freedom stick; and that of Adams' formulas that are corrected more than once. */
#include "../unit.h"
#include <slipstep/rooms/slipcore.h>
#include <petscblaslapack.h>
#include <math.h>

enum { S = 4 }; /* u, v+, v+' and the e of the step before */

/* One step of a mode, k = h^2 omega^2, c = h times the damping, by the steps themselves: half kicks and a drift, rates
   in units of u over h. x: u, the last v+, the v+ before it, what the last first kick took for the damping. */
static void Step(PetscReal k, PetscReal c, PetscReal weight, PetscReal x[S])
{
  const PetscReal u = x[0], half = x[1], before = x[2], e = x[3];
  const PetscReal end = half - k * u / 2 - (c * half - e / 2); /* the second kick of the step before */
  const PetscReal taken = c * (weight * half + (1 - weight) * before);

  x[1] = end - k * u / 2 - taken / 2;
  x[0] = u + x[1];
  x[2] = half;
  x[3] = taken;
}

/* Largest size of an eigenvalue */
static PetscReal Radius(PetscReal k, PetscReal c, PetscReal weight)
{
  const PetscBLASInt n = S, lwork = 8 * S;
  PetscReal A[S * S] = {0}, re[S], im[S], work[8 * S], none, largest = 0;
  PetscBLASInt info, one = 1;

  for (int j = 0; j < S; j++) {
    A[j * S + j] = 1;
    Step(k, c, weight, A + j * S);
  }
  LAPACKgeev_("N", "N", &n, A, &n, re, im, &none, &one, &none, &one, work, &lwork, &info);
  assert_int_equal(info, 0);
  for (int j = 0; j < S; j++) largest = PetscMax(largest, hypot(re[j], im[j]));
  return largest;
}

/* Below the bound nothing grows, whatever the frequency; just above it the fastest mode does. At the bound itself the
   eigenvalue is -1, on the unit circle, where undamped ones are everywhere. */
static void bound_is_that_of_eigenvalues(void **state)
{
  for (int i = 0; i < 7; i++)
    for (int j = 0; j <= 5; j++) {
      const PetscReal zeta = (const PetscReal[]){0, 0.02, 0.1, 0.8 / 3, 0.5, 1, 3}[i], weight = 0.5 + 0.25 * j;
      const PetscReal limit = SlipLagLimit(zeta, weight);

      for (int n = 1; n <= 100; n++) {
        const PetscReal W = 0.0099999 * n * limit;

        assert_true(Radius(W * W, 2 * zeta * W, weight) <= 1 + 1e-10);
      }
      assert_true(Radius(PetscSqr(1.01 * limit), 2.02 * zeta * limit, weight) > 1.001);
    }
  AssertNear(SlipLagLimit(0, 1), 2, 0);
  AssertNear(SlipLagLimit(0.8 / 3, 1), 1.2, 1e-14); /* W^2 + 8 zeta W = 1.44 + 2.56 */
}

/* The modes of part of the cells have any k and c up to those of the fastest one of all */
static void less_is_stable(void **state)
{
  for (int j = 0; j <= 5; j++) {
    const PetscReal weight = 0.5 + 0.25 * j;

    for (int a = 1; a < 40; a++)
      for (int b = 0; b < 40; b++) {
        const PetscReal k = 0.1 * a, c = (4 - k) / (4 * weight) * b / 40;

        assert_true(Radius(k, c, weight) <= 1 + 1e-10);
      }
  }
}

/* Steps that go up and down in turn, by up to 2, the longest at the bound: all dies away. With zeta = 0.08 the first of
   these makes the fastest mode grow by 12 % a step. */
static void varied_steps(void **state)
{
  static const struct {
    int period;
    PetscReal share[5];
  } pattern[] = {{2, {1, 0.5}}, {2, {1, 0.75}}, {3, {1, 1, 0.5}}, {3, {1, 0.5, 0.5}}, {5, {1, 1, 0.5, 1, 0.5}}};
  const PetscReal zeta = 0.12, limit = SlipLagLimit(zeta, 1);

  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(pattern); i++)
    for (int m = 1; m <= 20; m++) {
      const PetscReal w = 0.05 * m;
      PetscReal u = 1, half = 0, p = 0, e = 0, h = limit;

      for (int n = 0; n < 4000; n++) {
        const PetscReal before = h;

        h = limit * pattern[i].share[n % pattern[i].period];
        half -= before / 2 * w * w * u + before * p - before / 2 * e; /* the end of the step before */
        e = p;
        half -= h / 2 * (w * w * u + e);
        u += h * half;
        p = 2 * zeta * w * half;
      }
      assert_true(PetscMax(PetscAbsReal(w * u), PetscAbsReal(half)) < 1e-10);
    }
}

/* ---- corrections of Adams' formulas ---- */

/* Of every number of corrections, constant steps of y' = -r y die away from a history that alternates at all h r up to
   the reach, by the recurrence itself. */
static void reach(void **state)
{
  const PetscReal gamma[] = {0.5, 5.0 / 12, 3.0 / 8, 251.0 / 720};

  assert_true(SlipAdamsReach(5, 2) == 0 && SlipAdamsReach(4, 5) == 0 && SlipAdamsReach(2, 1) == 0);
  for (PetscInt k = 1; k <= 4; k++)
    for (PetscInt m = 2; SlipAdamsReach(k, m) > 0; m++) {
      const PetscReal(*factor)[2] = SlipAdamsFactors(k, m), most = SlipAdamsReach(k, m);
      PetscReal sum = 0;

      assert_true(m == 2 || most > SlipAdamsReach(k, m - 1));
      for (PetscInt j = 0; j < (m + 1) / 2; j++) sum += factor[j][0];
      AssertNear(sum, 1, 1e-9); /* the order of the formula */
      for (PetscReal x = 0.1; x <= most; x += 0.01) {
        PetscReal y[400], w[SLIP_ADAMS_NODES], node[SLIP_ADAMS_NODES], Q = 1;

        for (PetscInt j = 0; j < (m + 1) / 2; j++) Q *= 1 - factor[j][0] * x + factor[j][1] * x * x;
        for (PetscInt j = 0; j < k; j++) {
          node[j] = -j;
          y[j] = j % 2 ? -1 : 1;
        }
        SlipAdamsWeights(k, node, w);
        for (PetscInt n = k; n < 400; n++) {
          PetscReal predicted = y[n - 1], extrapolated = 0, binomial = (PetscReal)k;

          for (PetscInt j = 0; j < k; j++) {
            predicted -= x / gamma[k - 1] * w[j] * y[n - 1 - j];
            extrapolated += (j % 2 ? -1 : 1) * binomial * y[n - 1 - j];
            binomial *= (PetscReal)(k - 1 - j) / (PetscReal)(j + 2);
          }
          y[n] = extrapolated + Q * (predicted - extrapolated);
        }
        assert_true(fabs(y[399]) < 1e-2);
      }
    }
}

SLIP_TESTS(bound_is_that_of_eigenvalues, less_is_stable, varied_steps, reach)
