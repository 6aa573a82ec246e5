/* Numbers of the composite step (src/core/batheweights.c) against what defines them: the orders of the formulas. */
#include "unit.h"
#include <slipstep/rooms/slipcore.h>
#include <math.h>

/* Each formula integrates polynomials exactly up to its degree, here x^k over [0, 1] with nodes 0, gamma, 1. The error
   weights are those of the step minus those of the quadrature of third order, so that they give the error of x^2 (the
   derivative of x^3/3) and nothing of 1 and x. 1e-14: rounding of sums of numbers of about 1. */
static void Quadrature(const SlipBathe *c, const PetscReal node[3], int k)
{
  PetscReal step = 0, error = 0;

  for (int i = 0; i < 3; i++) {
    step += c->weight[i] * pow(node[i], k);
    error += c->error[i] * pow(node[i], k);
  }
  if (k < 2) assert_true(fabs(step - 1.0 / (k + 1)) < 1e-14);
  assert_true(fabs(error - (step - 1.0 / (k + 1))) < 1e-14);
}

static void weights(void **state)
{
  const PetscReal gammas[] = {0.5, 2 - sqrt(2), 0.3, 0.9};

  for (size_t m = 0; m < PETSC_STATIC_ARRAY_LENGTH(gammas); m++) {
    const PetscReal gamma = gammas[m], node[] = {0, gamma, 1};
    SlipBathe c;

    SlipBatheSetUp(gamma, &c);
    assert_true(fabs(c.theta[0] - gamma / 2) < 1e-15);
    for (int k = 0; k <= 2; k++) {
      Quadrature(&c, node, k);
      /* stage 2 of y' = k x^(k - 1) from exact values at 0 and gamma */
      assert_true(k > 2 || fabs(c.a1 * pow(gamma, k) - c.a0 * (k == 0) + c.theta[1] * k - 1) < 1e-14);
    }
    /* the error once more, as one difference */
    assert_true(fabs(c.error[0] - (1 - gamma) / c.divisor) < 1e-14);
    assert_true(fabs(c.error[1] + 1 / c.divisor) < 1e-14);
    assert_true(fabs(c.error[2] - gamma / c.divisor) < 1e-14);
  }
}

/* Both stages backward. Alexander's (1977) coefficients: gamma (2 - gamma) = 1/2, weights of x^0 and x^1, stage 1 the
   backward rule to gamma, stage 2 from base = a1 w1 - a0 w0. The function of y' = z y at z -> -infinity is 0
   (L-stable), and at -1 that of the trapezoidal split 2 - sqrt 2, whose denominator and order are the same. 1e-14:
   rounding. */
static void backward(void **state)
{
  const PetscReal z = -1;
  PetscReal node[3], w[2];
  SlipBathe c, t;

  SlipBatheSetUpBackward(&c);
  SlipBatheSetUp(2 - sqrt(2), &t);
  assert_true(fabs(c.gamma * (2 - c.gamma) - 0.5) < 1e-15);
  assert_true(c.theta[0] == c.gamma && c.theta[1] == c.gamma);
  node[0] = 0, node[1] = c.gamma, node[2] = 1;
  for (int k = 0; k <= 2; k++) Quadrature(&c, node, k);
  assert_true(fabs(c.error[0] - (1 - c.gamma) / c.divisor) < 1e-14);
  assert_true(fabs(c.error[2] - c.gamma / c.divisor) < 1e-14);
  w[0] = (c.a1 / (1 - c.theta[0] * z) - c.a0) / (1 - c.theta[1] * z);
  w[1] = (t.a1 * (1 + t.theta[0] * z) / (1 - t.theta[0] * z) - t.a0) / (1 - t.theta[1] * z);
  assert_true(fabs(w[0] - w[1]) < 1e-14);
  assert_true(fabs((c.a1 / (1 + c.theta[0] * 1e9) - c.a0) / (1 + c.theta[1] * 1e9)) < 1e-8);
}

SLIP_TESTS(weights, backward)
