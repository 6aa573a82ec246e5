/* Coefficients of the composite step: the trapezoidal rule to t + gamma h, the three-point backward formula to t + h.

   With k_i = A^-1 (F_s + r) at t, t + gamma h and t + h, the solution is w0 + h sum b_i k_i with
     b = ( 1/(2(2-gamma)), 1/(2(2-gamma)), (1-gamma)/(2-gamma) ),
   and the companion with the weights of the three-point quadrature at the same nodes,
     b1^ = 1/(6 gamma (1-gamma)), b2^ = (2-3 gamma)/(6 (1-gamma)), b0^ = 1 - b1^ - b2^,
   is of third order because both stages are of stage order two (Bank et al. 1985, IEEE Trans. CAD 4; Hosea and Shampine
   1996, Appl. Numer. Math. 20, for gamma = 2 - sqrt 2). Their difference is the embedded error.

   If stage 1 uses the backward rule, the split is gamma = 1 - 1/sqrt 2, both stages have the weight gamma, and
      b = ( 0, 1-gamma, gamma ):
   this is Alexander's (1977, SIAM J. Numer. Anal. 14) second formula, of second order, L-stable with the stability
   function of the split 2 - sqrt 2 above, and algebraically stable: neither friction that opposes its rate nor a stiff
   spring can make it gain energy, and no stage uses the forces at the start of the step. As its stage 1 is of stage
   order one, the companion with the quadrature weights is not of third order, but the difference still scales as h^3.
   */
#include <slipcompat.h>
#include <slipstep/rooms/slipcore.h>
#include <math.h>

/* The error weights follow from the others: the difference to those of the quadrature of third order. */
static void SetUpError(SlipBathe *c)
{
  const PetscReal gamma = c->gamma, b1 = 1.0 / (6.0 * gamma * (1.0 - gamma));
  const PetscReal b2 = (2.0 - 3.0 * gamma) / (6.0 * (1.0 - gamma));

  c->error[0] = c->weight[0] - (1.0 - b1 - b2);
  c->error[1] = c->weight[1] - b1;
  c->error[2] = c->weight[2] - b2;
}

/* Sets all coefficients of a step with two backward stages. */
void SlipBatheSetUpBackward(SlipBathe *c)
{
  const PetscReal gamma = 1.0 - PetscSqrtReal((PetscReal)0.5);

  c->gamma = c->theta[0] = c->theta[1] = gamma;
  c->a1 = (1.0 - gamma) / gamma; /* base = w0 + (1 - gamma) h k1, and h k1 = (w1 - w0)/gamma */
  c->a0 = c->a1 - 1.0;
  c->weight[0] = 0.0;
  c->weight[1] = 1.0 - gamma;
  c->weight[2] = gamma;
  SetUpError(c);
  c->divisor = -1.0 / c->error[1];
}

/* Sets all coefficients of a step with the split gamma in (0, 1). */
void SlipBatheSetUp(PetscReal gamma, SlipBathe *c)
{
  c->gamma = gamma;
  c->theta[0] = 0.5 * gamma;
  c->theta[1] = (1.0 - gamma) / (2.0 - gamma);
  c->a1 = 1.0 / (gamma * (2.0 - gamma));
  c->a0 = (1.0 - gamma) * (1.0 - gamma) / (gamma * (2.0 - gamma));
  c->weight[0] = c->weight[1] = 0.5 / (2.0 - gamma);
  c->weight[2] = c->theta[1];
  SetUpError(c);
  c->divisor = 6.0 * gamma * (1.0 - gamma) * (2.0 - gamma) / (3.0 * gamma * gamma - 4.0 * gamma + 2.0);
}

/* Keeps 12 binary digits. One or two decimal digits of an error estimate are significant; the rest is rounding and
   solver noise that differs with the number of ranks, and a controller that divides by it would turn 1e-13 into another
   sequence of steps. */
PetscReal SlipBatheRoundError(PetscReal error)
{
  int exponent;
  const PetscReal fraction = frexp(error, &exponent);

  return ldexp(round(ldexp(fraction, 12)), exponent - 12);
}
