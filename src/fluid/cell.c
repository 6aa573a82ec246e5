/* Darcy's law in one cell, by the lowest Raviart-Thomas element: the flux is constant along each side, and its
   divergence constant in the cell. The unknowns are one pressure p of the cell, its mean, and one lambda of each side,
   the mean there. What flows out through side i is u_i = sum_j T_ij (p - lambda_j).

   Triangles: T is the inverse of the mass matrix M_ij = integral of w_i . K^-1 w_j with w_j = (x - x_j)/(2 A), which
   carries a unit flux through side j, opposite of corner x_j. With coordinates from the centroid
     M = (s 1 1' + X K^-1 X')/(4 A),  s = sum_k x_k . K^-1 x_k/12,   so that   T = 4 A (1 1'/(9 s) + G K G'),
   where the rows of G are the gradients of the three barycentric coordinates: 1' X = 0 and X' G = 1. The second part is
   four times the stiffness of linear elements, as Arnold and Brezzi found, and both parts stand below by themselves,
   so that nothing cancels however large the step is.
   Rectangles: M by the trapezoidal rule is diagonal, u_i = 2 K L/h (p - lambda_i) of a side of length L whose opposite
   is h away; a part of a side has its part of that. Eliminating lambda of two equal cells would leave the usual finite
   volumes.

   Raviart, P.-A. and Thomas, J. M., 1977, A mixed finite element method for 2nd order elliptic problems, Lecture Notes
   in Mathematics 606, 292-315.
   Arnold, D. N. and Brezzi, F., 1985, Mixed and nonconforming finite element methods, RAIRO 19, 7-32. */
#include <slipstep/private/slipfluid.h>

void SlipFluidCellShape(const SlipFaultCell *from, SlipFluidCell *c)
{
  c->corners = from->vertices ? 3 : 4;
  if (!from->vertices)
    for (int i = 0; i < 2; i++) c->corner[0][i] = 0.5 * from->size[i];
  for (int k = 0; k < 3 && from->vertices; k++) { /* side k is that between corners k and k + 1 */
    const PetscReal *v = from->vertices + (k + 2) % 3 * 3;

    for (int i = 0; i < 2; i++) {
      c->corner[k][i] = 0;
      for (int j = 0; j < 3; j++) c->corner[k][i] += (v[j] - from->centre[j]) * from->direction[i][j];
    }
  }
}

/* Gradients of the barycentric coordinates of a triangle [3][2]; returns its area */
static PetscReal Gradients(const PetscReal x[3][2], PetscReal g[3][2])
{
  const PetscReal twice =
    (x[1][0] - x[0][0]) * (x[2][1] - x[0][1]) - (x[1][1] - x[0][1]) * (x[2][0] - x[0][0]); /* and the sense */

  for (int k = 0; k < 3; k++) {
    const PetscReal *a = x[(k + 1) % 3], *b = x[(k + 2) % 3];

    g[k][0] = (a[1] - b[1]) / twice;
    g[k][1] = (b[0] - a[0]) / twice;
  }
  return 0.5 * PetscAbsReal(twice);
}

PetscReal SlipFluidCellWeights(const SlipFluidCell *c, PetscInt pieces, const PetscInt side[], const PetscReal part[],
                               PetscReal t[])
{
  PetscReal total = 0;

  if (c->corners == 3) {
    PetscReal g[3][2], square[2] = {0, 0}, area = Gradients(c->corner, g);

    for (int k = 0; k < 3; k++)
      for (int i = 0; i < 2; i++) square[i] += PetscSqr(c->corner[k][i]);
    square[0] = c->down * square[0] + c->along * square[1];
    t[0] = square[0] > 0 ? 16 * area * c->along * c->down / square[0] : 0; /* 4 A/(3 s) */
    t[1] = t[2] = t[0];
    return 3 * t[0];
  }
  for (PetscInt k = 0; k < pieces; k++) {
    const int across = side[k] % 2 ? 0 : 1; /* sides 1 and 3 are those at the ends along strike */

    t[k] = part[k] * 2 * (across ? c->down : c->along) * c->corner[0][1 - across] / c->corner[0][across];
    total += t[k];
  }
  return total;
}

void SlipFluidCellMatrix(const SlipFluidCell *c, PetscReal dt, PetscInt pieces, const PetscReal t[], PetscReal total,
                         PetscReal m[])
{
  const PetscReal kept = c->storage + dt * c->sink, whole = kept + dt * total;

  if (c->corners == 3) {
    PetscReal g[3][2], area = Gradients(c->corner, g);

    for (int i = 0; i < 3; i++)
      for (int j = 0; j < 3; j++)
        m[3 * i + j] =
          dt * (t[0] * kept / (3 * whole) + 4 * area * (g[i][0] * c->along * g[j][0] + g[i][1] * c->down * g[j][1]));
    return;
  }
  for (PetscInt i = 0; i < pieces; i++) {
    PetscReal others = 0;

    for (PetscInt j = 0; j < pieces; j++) {
      m[pieces * i + j] = -dt * t[i] * (dt * t[j] / whole);
      if (j != i) others += t[j];
    }
    m[pieces * i + i] = dt * t[i] * ((kept + dt * others) / whole);
  }
}

void SlipFluidCellFlux(const SlipFluidCell *c, PetscInt pieces, const PetscReal t[], PetscReal p,
                       const PetscReal lambda[], PetscReal flux[])
{
  if (c->corners == 3) {
    const PetscReal mean = (lambda[0] + lambda[1] + lambda[2]) / 3;
    PetscReal g[3][2], slope[2] = {0, 0}, area = Gradients(c->corner, g);

    for (int i = 0; i < 3; i++)
      for (int j = 0; j < 2; j++) slope[j] += g[i][j] * (lambda[i] - mean);
    for (int i = 0; i < 3; i++)
      flux[i] = t[0] * (p - mean) - 4 * area * (g[i][0] * c->along * slope[0] + g[i][1] * c->down * slope[1]);
    return;
  }
  for (PetscInt i = 0; i < pieces; i++) flux[i] = t[i] * (p - lambda[i]);
}

void SlipFluidCellCentre(const SlipFluidCell *c, PetscInt pieces, const PetscInt side[], const PetscReal flux[],
                         PetscReal centre[2])
{
  PetscReal g[3][2], area = c->corners == 3 ? Gradients(c->corner, g) : 0;

  centre[0] = centre[1] = 0;
  for (PetscInt k = 0; k < pieces; k++) {
    if (c->corners == 3)
      for (int i = 0; i < 2; i++) centre[i] -= flux[k] * c->corner[k][i] / (2 * area);
    else { /* sides 1 and 2 are those ahead, along strike and down dip; the mean of both sides */
      const int across = side[k] % 2 ? 0 : 1;

      centre[across] += (side[k] == 1 || side[k] == 2 ? 1 : -1) * flux[k] / (4 * c->corner[0][1 - across]);
    }
  }
}

/* Peaceman, D. W., 1983, SPE Journal 23, 531-543: of rectangles, in coordinates in which the permeability is the same in
   both directions */
PetscReal SlipFluidCellRadius(const SlipFluidCell *c)
{
  const PetscReal a = c->along > 0 && c->down > 0 ? PetscSqrtReal(PetscSqrtReal(c->down / c->along)) : 1;
  PetscReal square = 0;

  if (c->corners == 4)
    square = 4 * (PetscSqr(a * c->corner[0][0]) + PetscSqr(c->corner[0][1] / a));
  else
    for (int k = 0; k < 3; k++) square += PetscSqr(a * c->corner[k][0]) + PetscSqr(c->corner[k][1] / a);
  return 0.28 * PetscSqrtReal(square) / (a + 1 / a);
}
