/*
  Derivatives of X_xx and X_xy, where X is the integral of w ln(R + w) - R over the mirror image of a dipping rectangle:
  the terms of the free surface besides the derivatives of V (dipping.c).

  x, y and w are the distances of a point from a corner of the image along strike, to the right of it and down, and in
  the image's plane and across it t = y ty + w tz and q = y tz - w ty, ty = -cos(dip), tz = sin(dip). With chi = w ln(R
  + w) - R and K and N the integrals of chi_x and chi_y along t, X_xx and X_xy are the double differences over the
  corners of K and N. Their derivatives are integrals of second and third derivatives of chi, of which those with two w
  are those of 1/R, and

     K_w = A = int x / (R (R + w)) dt           N_w = L = int y / (R (R + w)) dt = (ln(R + w) - tz ln(R + t)) / ty
     K_y = N_x = (chi_x - tz A) / ty            N_y = (chi_y - tz L) / ty           K_x = -N_y - ln(R + t).

  They are Okada's (1992) I and J, which divide by the cosine of the dip and by its square and have other formulas where
  it is 0. Here the quotients are computed directly: w - t = -ty (q + s t), s = ty / (1 + tz), gives

     L = e ln(1 + ty e) / (ty e) + s ln(R + t),  e = -(q + s t) / (R + t)
     A = -2 / (1 + tz) g atan(s g) / (s g),      g = x / (R + t - s q)
     1 / (R (R + w)) - tz / (R (R + t)) = ty E,  E = (y + s R) / (R (R + w) (R + t)),

  so that a vertical plane is no special case. A point below the ground has R + t > 0, as the image ends at the ground.
*/
#include <slipstep/private/slipdipping.h>
#include <math.h>

/* Arguments below which the functions are summed from their series, to rounding; above, they lose a digit */
#define SERIES_ATAN 0.3
#define SERIES_LOG 0.1
#define TERMS 18

/* Returns (atan(z)/z - 1)/z^2. */
static PetscReal AtanRest(PetscReal z)
{
  const PetscReal z2 = z * z;
  PetscReal sum = 0;

  if (PetscAbsReal(z) > SERIES_ATAN) return (PetscAtanReal(z) / z - 1) / z2;
  for (int n = TERMS; n >= 0; n--) sum = -1 / (PetscReal)(2 * n + 3) - z2 * sum;
  return sum;
}

/* Returns (ln(1 + z)/z - 1)/z. */
static PetscReal LogRest(PetscReal z)
{
  PetscReal sum = 0;

  if (PetscAbsReal(z) > SERIES_LOG) return (log1p(z) / z - 1) / z;
  for (int n = TERMS; n >= 0; n--) sum = -1 / (PetscReal)(n + 2) - z * sum;
  return sum;
}

SLIP_WITHIN SlipLogCorner CornerOf(const SlipPlatePoints *p, PetscInt k, PetscReal i, PetscReal j)
{
  return SlipLogCornerOf(SlipCorner(p->x[k], i * p->half_length[k], p->rounding[k]),
                         SlipCorner(p->t[k], j * p->half_width[k], p->rounding[k]) + p->move[k], p->q[k], p->ty[k],
                         p->tz[k], p->rounding[k]);
}

/*
  SlipLogFirst_Private - computes a corner's terms of the first derivatives of K and N; s = ty / (1 + tz)
*/
SlipLogSums SlipLogFirst_Private(const SlipLogCorner *c, PetscReal ty, PetscReal tz, PetscReal s)
{
  const PetscReal up = 1 + tz, logarithm = PetscLogReal(c->Rt), sum = c->Rt - s * c->q;
  const PetscReal e = -(c->q + s * c->t) / c->Rt, log_rest = LogRest(ty * e);
  const PetscReal g = c->x / sum, atan_rest = AtanRest(s * g);
  const PetscReal A = -2 / up * g * (1 + s * s * g * g * atan_rest);
  const PetscReal L = e * (1 + ty * e * log_rest) + s * logarithm;
  const PetscReal Nx = -c->x * (c->q * (2 * tz - 1) + s * (c->R + (1 + 2 * tz) * c->t)) / (up * c->Rw * sum) +
                       2 * tz / (up * up) * s * g * g * g * atan_rest;
  const PetscReal Ny =
    -c->t / c->Rw + tz * (c->q * e / c->Rw + c->t / (up * c->Rt) - e * e * log_rest) - tz / up * logarithm;

  return (SlipLogSums){{-(Ny + logarithm), Nx, A}, {Nx, Ny, L}};
}

static void First(const SlipPlatePoints *p, PetscReal i, PetscReal j, SlipLogPotential *l)
{
  const PetscReal sign = i * j;

  for (PetscInt k = 0; k < p->n; k++) {
    const SlipLogCorner c = CornerOf(p, k, i, j);
    const SlipLogSums sums = SlipLogFirst_Private(&c, p->ty[k], p->tz[k], p->lean[k]);

    for (int d = 0; d < 3; d++) {
      l->along[d][k] += sign * sums.K[d];
      l->across[d][k] += sign * sums.N[d];
    }
  }
}

SLIP_WIDE static void Second(const SlipPlatePoints *p, PetscReal i, PetscReal j, SlipLogPotential *restrict l)
{
  const PetscReal sign = i * j;

  for (PetscInt k = 0; k < p->n; k++) {
    const SlipLogCorner c = CornerOf(p, k, i, j);
    const SlipLogSums sums = SlipLogSecond(&c, p->ty[k], p->tz[k], p->lean[k]);

    for (int d = 0; d < 6; d++) {
      l->along_second[d][k] += sign * sums.K[d];
      l->across_second[d][k] += sign * sums.N[d];
    }
  }
}

/*
  SlipLogPotential_Private - computes the first derivatives of X_xx and X_xy, or the second ones if gradient is true
*/
void SlipLogPotential_Private(const SlipPlatePoints *p, PetscBool gradient, SlipLogPotential *l)
{
  for (PetscInt k = 0; k < p->n; k++) {
    for (int d = 0; d < 3; d++) l->along[d][k] = l->across[d][k] = 0;
    for (int d = 0; d < 6; d++) l->along_second[d][k] = l->across_second[d][k] = 0;
  }
  for (int i = -1; i <= 1; i += 2)
    for (int j = -1; j <= 1; j += 2) (*(gradient ? Second : First))(p, i, j, l);
}
