/* Weights of Adams' formulas of variable step: integrals of Lagrange's polynomials. */
#include <slipcompat.h>
#include <slipcore.h>

/*
  SlipAdamsWeights - weight[j] = the integral over [0, 1] of the polynomial that is 1 at node[j] and 0 at the others

  n <= SLIP_ADAMS_NODES nodes that differ, in units of the step, 0 its start and 1 its end. A factor (t - x_m)/(x_j -
  x_m) is taken as a + b t, so that nodes far in the past, after a step that was cut, do no harm.
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
