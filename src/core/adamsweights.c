/* Adams formulas of variable step: their weights, which are integrals of Lagrange polynomials, and the coefficients of
   repeated corrections of a step */
#include <slipcompat.h>
#include <slipstep/rooms/slipcore.h>

/*
  SlipAdamsWeights - computes weight[j], the integral over [0, 1] of the polynomial with 1 at node[j], 0 at the others

  The n <= SLIP_ADAMS_NODES nodes differ, in units of the step: 0 is its start and 1 its end. A factor (t - x_m)/(x_j -
  x_m) is computed as a + b t, so that nodes far in the past, after a step was shortened, do no harm.
*/
void SlipAdamsWeights(PetscInt n, const PetscReal node[], PetscReal weight[])
{
  for (PetscInt j = 0; j < n; j++) {
    PetscReal c[SLIP_ADAMS_NODES + 1] = {1};

    for (PetscInt m = 0, degree = 0; m < n; m++) {
      const PetscReal b = m == j ? 0 : 1 / (node[j] - node[m]), a = -node[m] * b;

      if (m == j) continue;
      degree++;
      for (PetscInt r = degree; r > 0; r--) c[r] = a * c[r] + b * c[r - 1];
      c[0] *= a;
    }
    weight[j] = 0;
    for (PetscInt r = n - 1; r >= 0; r--) weight[j] += c[r] / (PetscReal)(r + 1);
  }
}

/* ---- corrections ---- */

/* For y' = lambda y, a predictor y* of order k and y* + gamma h (f - f^), where f_n ... f_n-k+1 extrapolate to f^, a
   step is y^ + Q (y* - y^), where y^ is the extrapolation of y, Q = 1 - x and x = -gamma h lambda. With m corrections,
   each from y to y + tau h (f(y) - f^), Q is a polynomial of degree m, the product of 1 - tau/gamma x. All sums of tau
   are gamma, so that each has the order of the formula. The factors below are chosen such that the roots of the
   recurrence in n are below 0.97 from h |lambda| = 1 to the largest x, for constant steps and steps that grow by 1.2 or
   shrink by 0.85 each time, and such that this x is as large as possible (a linear program for each x; with k = 2 they
   are close to Fejer's kernel, whose x is 0.33 ((m + 1)^2 - 1)). Each row has the factors 1 - a x + b x^2, beginning
   with those that are smallest at the largest x. Predictors of higher order do not benefit from more factors. */
enum { ORDERS = 4, FACTORS = (SLIP_ADAMS_CORRECTIONS + 1) / 2 };

typedef struct {
  PetscReal reach; /* largest x, 0 if there is no formula */
  PetscReal factor[FACTORS][2];
} Corrections;

static const Corrections table[ORDERS][SLIP_ADAMS_CORRECTIONS + 1] = {
  {
    /* predictor of order 1 */
    [2] = {3.092, {{1, 0.252030159}}},
    [3] = {5.951, {{0.167821803, 0}, {0.832178197, 0.175186258}}},
    [4] = {9.614, {{0.232044518, 0.0134659375}, {0.767955482, 0.149413269}}},
    [5] = {14.086, {{0.070954965, 0}, {0.193107467, 0.00932959231}, {0.735937568, 0.137321982}}},
    [6] = {19.370, {{0.108828865, 0.00296115906}, {0.173644151, 0.00754582254}, {0.717526984, 0.130588761}}},
  },
  {
    /* predictor of order 2 */
    [2] = {2.707, {{1, 0.267969959}}},
    [3] = {5.215, {{0.188507457, 0}, {0.811492543, 0.183260299}}},
    [4] = {8.439, {{0.260454083, 0.0170421682}, {0.739545917, 0.154993327}}},
    [5] = {12.375, {{0.080220411, 0}, {0.21606985, 0.0117950424}, {0.703709739, 0.141792112}}},
    [6] = {17.032, {{0.123027093, 0.00378826417}, {0.193796049, 0.00952627987}, {0.683176858, 0.134453865}}},
    [7] = {22.399,
           {{0.044462933, 0}, {0.10445935, 0.00273588331}, {0.180761625, 0.00831339128}, {0.670316092, 0.129907608}}},
  },
  {
    /* predictor of order 3 */
    [2] = {1.681, {{1, 0.362561522}}},
    [3] = {3.195, {{0.270763638, 0}, {0.729236362, 0.255035291}}},
    [4] = {5.114, {{0.380820394, 0.0377563327}, {0.619179606, 0.216675121}}},
    [5] = {7.425, {{0.12518785, 0}, {0.312731372, 0.0268235863}, {0.562080778, 0.198416384}}},
    [6] = {10.164, {{0.194060734, 0.00952133363}, {0.276119173, 0.021778979}, {0.529820093, 0.187708777}}},
    [7] = {13.318,
           {{0.071847695, 0}, {0.164596753, 0.00697286619}, {0.254637798, 0.019083229}, {0.508917754, 0.181133087}}},
  },
  {
    /* predictor of order 4 */
    [2] = {1.020, {{1, 0.46501896}}},
    [3] = {1.826, {{0.374504673, 0}, {0.625495327, 0.342237021}}},
    [4] = {2.696, {{0.548002156, 0.0829204252}, {0.451997844, 0.29468939}}},
  },
};

/*
  SlipAdamsReach - gets the largest gamma h r for which a step is stable, for a predictor of order k and m >= 2
  corrections, if all relaxation rates are real and at most r

  gamma is the weight of the new derivative in the corrector, over h. Without such a formula the result is 0.
*/
PetscReal SlipAdamsReach(PetscInt k, PetscInt m)
{
  return k >= 1 && k <= ORDERS && m >= 2 && m <= SLIP_ADAMS_CORRECTIONS ? table[k - 1][m].reach : 0;
}

/* SlipAdamsFactors - gets the (m + 1)/2 factors 1 - a x + b x^2 as pairs of a and b */
const PetscReal (*SlipAdamsFactors(PetscInt k, PetscInt m))[2]
{
  return table[k - 1][m].factor;
}
