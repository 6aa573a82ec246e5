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
   is h away. Eliminating lambda of two equal cells would leave the usual finite volumes. Where a side is cut into
   pieces, because other cells meet it there, T is that of mimetic differences,
     T = N K N'/A + Q' diag(t) Q,   Q = 1 - R N'/A,
   where rows of N are outward normals times lengths, rows of R the middles of the pieces from the centre, and t the
   weights above, in proportion to the length: R' N = A, so that a pressure that varies linearly is exact, and for a
   rectangle of four pieces T is the diagonal matrix of t. In all cases T 1 = t.

   Raviart, P.-A. and Thomas, J. M., 1977, A mixed finite element method for 2nd order elliptic problems, Lecture Notes
   in Mathematics 606, 292-315.
   Arnold, D. N. and Brezzi, F., 1985, Mixed and nonconforming finite element methods, RAIRO 19, 7-32.
   Brezzi, F., Lipnikov, K. and Simoncini, V., 2005, A family of mimetic finite difference methods on polygonal and
   polyhedral meshes, Mathematical Models and Methods in Applied Sciences 15, 1533-1551. */
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
static PetscReal Gradients(const SlipFluidCell *c, PetscReal g[3][2])
{
  const PetscReal(*const x)[2] = c->corner;
  const PetscReal twice =
    (x[1][0] - x[0][0]) * (x[2][1] - x[0][1]) - (x[1][1] - x[0][1]) * (x[2][0] - x[0][0]); /* and the sense */

  for (int k = 0; k < 3; k++) {
    const PetscReal *a = x[(k + 1) % 3], *b = x[(k + 2) % 3];

    g[k][0] = (a[1] - b[1]) / twice;
    g[k][1] = (b[0] - a[0]) / twice;
  }
  return 0.5 * PetscAbsReal(twice);
}

PetscReal SlipFluidCellWeights(const SlipFluidCell *c, const SlipFluidPieces *p)
{
  PetscReal *t = p->t;
  PetscReal total = 0;

  if (c->corners == 3) {
    PetscReal g[3][2], square[2] = {0, 0}, area = Gradients(c, g);

    for (int k = 0; k < 3; k++)
      for (int i = 0; i < 2; i++) square[i] += PetscSqr(c->corner[k][i]);
    square[0] = c->down * square[0] + c->along * square[1];
    t[0] = square[0] > 0 ? 16 * area * c->along * c->down / square[0] : 0; /* 4 A/(3 s) */
    t[1] = t[2] = t[0];
    for (int k = 0; k < 3; k++) {
      const PetscReal *a = g[(k + 1) % 3], *b = g[(k + 2) % 3];

      p->couple[k] = 4 * area * (a[0] * c->along * b[0] + a[1] * c->down * b[1]);
    }
    return 3 * t[0];
  }
  for (PetscInt k = 0; k < p->n; k++) {
    const int across = p->side[k] % 2 ? 0 : 1;

    t[k] = p->part[k] * 2 * (across ? c->down : c->along) * c->corner[0][1 - across] / c->corner[0][across];
    total += t[k];
  }
  return total;
}

/* Normal times length, outwards, and middle of a piece of a rectangle that begins at `begin` of its side */
static void Piece(const SlipFluidCell *c, PetscInt side, PetscReal begin, PetscReal part, PetscReal normal[2],
                  PetscReal middle[2])
{
  const int across = side % 2 ? 0 : 1; /* sides 1 and 3 are those at the ends along strike */
  const PetscReal *half = c->corner[0], sign = side == 1 || side == 2 ? 1 : -1;

  normal[across] = sign * part * 2 * half[1 - across];
  normal[1 - across] = 0;
  middle[across] = sign * half[across];
  middle[1 - across] = (side < 2 ? 1 : -1) * half[1 - across] * (2 * begin + part - 1);
}

/* Computes T x of a rectangle whose sides are cut; x + shift stands for x. */
static void Product(const SlipFluidCell *c, const SlipFluidPieces *p, const PetscReal x[], PetscReal shift,
                    PetscReal product[])
{
  const PetscReal area = 4 * c->corner[0][0] * c->corner[0][1];
  PetscReal slope[2] = {0, 0}, moment[2] = {0, 0}, normal[2], middle[2], begin = 0;

  for (int pass = 0; pass < 3; pass++) /* N' x/A, then R' diag(t) Q x/A, then all */
    for (PetscInt k = 0; k < p->n; k++) {
      const PetscReal y = x[k] + shift;
      PetscReal w;

      begin = k && p->side[k] == p->side[k - 1] ? begin + p->part[k - 1] : 0;
      Piece(c, p->side[k], begin, p->part[k], normal, middle);
      w = p->t[k] * (y - middle[0] * slope[0] - middle[1] * slope[1]);
      for (int i = 0; i < 2 && pass == 0; i++) slope[i] += normal[i] * y / area;
      for (int i = 0; i < 2 && pass == 1; i++) moment[i] += middle[i] * w / area;
      if (pass == 2)
        product[k] = w + normal[0] * (c->along * slope[0] - moment[0]) + normal[1] * (c->down * slope[1] - moment[1]);
    }
}

void SlipFluidCellMatrix(const SlipFluidCell *c, PetscReal kept, PetscReal dt, const SlipFluidPieces *p,
                         PetscReal total, PetscReal m[])
{
  const PetscReal whole = kept + dt * total;
  const PetscInt n = p->n;

  if (n == 3) { /* a triangle; rows of the second part add up to zero */
    const PetscReal all = p->t[0] * kept / (3 * whole);

    for (int i = 0; i < 3; i++) {
      const int j = (i + 1) % 3, k = (i + 2) % 3;

      m[3 * i + i] = dt * (all - p->couple[j] - p->couple[k]);
      m[3 * i + j] = dt * (all + p->couple[k]);
      m[3 * i + k] = dt * (all + p->couple[j]);
    }
    return;
  }
  if (n > 4) {
    for (PetscInt i = 0; i < n; i++) p->gathered[i] = 0;
    for (PetscInt i = 0; i < n; i++) {
      p->gathered[i] = 1;
      Product(c, p, p->gathered, 0, m + n * i);
      p->gathered[i] = 0;
      for (PetscInt j = 0; j < n; j++) m[n * i + j] = dt * (m[n * i + j] - p->t[i] * (dt * p->t[j] / whole));
    }
    return;
  }
  for (PetscInt i = 0; i < n; i++) {
    PetscReal others = 0;

    for (PetscInt j = 0; j < n; j++) {
      m[n * i + j] = -dt * p->t[i] * (dt * p->t[j] / whole);
      if (j != i) others += p->t[j];
    }
    m[n * i + i] = dt * p->t[i] * ((kept + dt * others) / whole);
  }
}

void SlipFluidCellFlux(const SlipFluidCell *c, const SlipFluidPieces *p, PetscReal y, const PetscReal lambda[],
                       PetscReal flux[])
{
  if (p->n == 3) {
    const PetscReal all = p->t[0] * (y - (lambda[0] + lambda[1] + lambda[2]) / 3);
    const PetscReal x[] = {p->couple[0] * (lambda[2] - lambda[1]), p->couple[1] * (lambda[0] - lambda[2]),
                           p->couple[2] * (lambda[1] - lambda[0])};

    for (int i = 0; i < 3; i++) flux[i] = all - x[(i + 2) % 3] + x[(i + 1) % 3];
    return;
  }
  if (p->n > 4) Product(c, p, lambda, -y, flux);
  for (PetscInt i = 0; i < p->n; i++) flux[i] = p->n > 4 ? -flux[i] : p->t[i] * (y - lambda[i]);
}

void SlipFluidCellCentre(const SlipFluidCell *c, const SlipFluidPieces *p, const PetscReal flux[], PetscReal centre[2])
{
  PetscReal g[3][2], normal[2], middle[2], begin = 0;
  const PetscReal area = c->corners == 3 ? Gradients(c, g) : 4 * c->corner[0][0] * c->corner[0][1];

  centre[0] = centre[1] = 0;
  for (PetscInt k = 0; k < p->n; k++) { /* the middle of a triangle's side is half as far as the corner opposite */
    begin = k && p->side[k] == p->side[k - 1] ? begin + p->part[k - 1] : 0;
    if (c->corners == 4) Piece(c, p->side[k], begin, p->part[k], normal, middle);
    for (int i = 0; i < 2; i++) centre[i] += flux[k] * (c->corners == 3 ? -0.5 * c->corner[k][i] : middle[i]) / area;
  }
}

/* Peaceman, D. W., 1983, Interpretation of well-block pressures in numerical reservoir simulation with nonsquare grid
   blocks and anisotropic permeability, SPE Journal 23, 531-543: the radius of rectangles, in coordinates in which the
   permeability is the same in both directions, exp(-0.57722)/4 times the diagonal. For triangles it was measured as
   the radius at which -log(r)/(2 pi) is
   the pressure of a cell with a source of one, whose border follows that logarithm: 0.333 sqrt(A) for equilateral and
   0.314 sqrt(A) for isosceles right triangles. For 120 triangles whose corners were shaken by 0.15 and 0.3 of a side,
   r/(A/sqrt(sum of squares of corners from the centroid)) is 0.512 +- 0.027 and 0.50 +- 0.06, for those without 0.507
   and 0.512. */
PetscReal SlipFluidCellRadius(const SlipFluidCell *c)
{
  const PetscReal a = c->along > 0 && c->down > 0 ? PetscSqrtReal(PetscSqrtReal(c->down / c->along)) : 1;
  PetscReal square = 0, g[3][2];

  if (c->corners == 4) return 0.280729 * 2 * PetscHypotReal(a * c->corner[0][0], c->corner[0][1] / a) / (a + 1 / a);
  for (int k = 0; k < 3; k++) square += PetscSqr(a * c->corner[k][0]) + PetscSqr(c->corner[k][1] / a);
  return 0.51 * Gradients(c, g) / PetscSqrtReal(square) * 2 / (a + 1 / a);
}
