/*
  The force of slip on one triangle on another one in a full space, in closed form.

  The traction of slip b on B, times a constant vector a, integrated over A, is a double integral over both outlines,
  like a dislocation's energy (Blin 1955; de Wit 1960; Hirth and Lothe 1982, (4-40)). With a as another slip it is
  symmetric in both. The stress drop, for edges with the directions d and d', u = a x d and v = b x d', is

     G/(4 pi) sum over pairs of edges of  [(a.d)(b.d') - 2 (a x b).(d x d')] J + u.T v/(1 - nu),

     J = int int 1/R ds ds',   T = int int grad grad R ds ds'.

  Points x - x' of a pair fill a parallelogram with the sides d and d', of the area sin(d, d') ds ds': J is its
  potential over that sine, and T that of R, seen from a point at the height h over it. As for triangles
  (triangle_potential.c) they are sums over its edges, with the outward normal m, the direction t, L the integral of
  1/R along the edge, p the distance from it, and the solid angle W:

     int 1/R = -sum p L - |h| W        int grad grad R: in the plane -sum m (m p L + t [R]),
                                       across it -h sum m L, and int 1/R - |h| W.

  Edges that are parallel have the second antiderivatives of 1/R and of grad grad R in s - s', which are, with s for
  it and r for the distance of the lines in the direction e,

     P = |s| ln((|s| + R)/r) - R   and   R along d, e r sign(s) ln((|s| + R)/r) along d and across, P - e e R across.

  On a line that two edges share the core c replaces r in P, as in average.c. The core represents a jump that decreases
  to zero over some width in the plane, along e. Slip has no term along e, but opening has, u = n x d, so that P - R
  replaces P, which is a core of exp(1) c. With c alone a crack that opens would have half the core of one that slips:
  with 20 triangles across, it would be 5 % too stiff where the other one is 3 % too soft. On a line where planes meet
  at an angle each opening has the e of its own plane. Near the ground the depth bounds the width: a wedge of rock above
  a wider one would have no stiffness.
*/
#include <slipcompat.h>
#include <slipstep/private/sliptriangle.h>

/* Edges with a smaller angle count as parallel. The parallelogram's error is 1e-16 over the angle, of terms that are a
   thousand times the force a few sides away; the parallel formula's error is about the angle: 1e-6 of such a force at
   most, 1e-8 of a cell's own. */
#define PARALLEL 2e-7
/* Largest core of opening, over the mean depth of its line. With it the stiffness of planes that dip by 15 degrees or
   more is positive definite up to the ground, and of squares also at 10 degrees; with 0.3 it hardly is there, with 0.6
   not at 10, and with 0.9 not at 30 degrees. */
#define SHALLOW 0.2

/* Two edges: the vector from the second's start to the first's, directions, lengths, and their integrals */
typedef struct {
  PetscReal D[3], d[2][3], length[2];
  PetscReal J, T[3][3];
  PetscReal line; /* R times the logarithm of the core of opening over that of slip; 0 unless on one line */
} Edges;

/* Integrates edges at an angle of the given sine. */
static void Parallelogram(Edges *e, PetscReal sine, const PetscReal normal[3])
{
  const PetscReal *d = e->d[0], size = e->length[0] + e->length[1], least = PetscSqr(1e-20 * size);
  const PetscReal cosine = SlipDot(d, e->d[1]), h = SlipDot(e->D, normal), side[2] = {e->length[0], e->length[1]};
  /* vertices from the point below, around the normal */
  const PetscReal corner[4][2] = {
    {0, 0}, {side[1] * cosine, side[1] * sine}, {side[1] * cosine - side[0], side[1] * sine}, {-side[0], 0}};
  PetscReal across[3], at[2], tensor[3][3] = {{0}}, potential = 0, angle = 0;

  SlipCross(normal, d, across);
  at[0] = SlipDot(e->D, d);
  at[1] = SlipDot(e->D, across);
  for (int k = 0; k < 4; k++) {
    const PetscReal sign = k < 2 ? 1 : -1;
    const PetscReal t[2] = {k % 2 ? -sign : sign * cosine, k % 2 ? 0 : sign * sine}, m[2] = {t[1], -t[0]};
    const PetscReal x[2] = {at[0] - corner[k][0], at[1] - corner[k][1]}, p = x[0] * m[0] + x[1] * m[1];
    const PetscReal s[2] = {x[0] * t[0] + x[1] * t[1], x[0] * t[0] + x[1] * t[1] - side[k % 2 ? 0 : 1]};
    const PetscReal r2 = PetscMax(p * p + h * h, least);
    PetscReal R[2], L = 0, side_of = s[0] + s[1] < 0 ? -1 : 1;

    for (int i = 0; i < 2; i++) {
      const PetscReal along = side_of * s[i], far = PetscSqrtReal(r2 + s[i] * s[i]) + PetscAbsReal(s[i]);

      R[i] = PetscSqrtReal(r2 + s[i] * s[i]);
      L += (i ? -1 : 1) * side_of * PetscLogReal(along >= 0 ? far : r2 / far);
      if (h != 0) angle -= (i ? -1 : 1) * PetscAtan2Real(p * s[i], r2 + PetscAbsReal(h) * R[i]);
    }
    potential -= p * L;
    for (int a = 0; a < 2; a++) {
      for (int b = 0; b < 2; b++) tensor[a][b] -= m[a] * (m[b] * p * L + t[b] * (R[0] - R[1]));
      tensor[a][2] -= m[a] * h * L;
    }
  }
  potential -= PetscAbsReal(h) * angle;
  tensor[2][0] = tensor[0][2];
  tensor[2][1] = tensor[1][2];
  tensor[2][2] = potential - PetscAbsReal(h) * angle;
  e->line = 0;
  e->J = potential / sine;
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) {
      const PetscReal left[3] = {d[i], across[i], normal[i]}, right[3] = {d[j], across[j], normal[j]};

      e->T[i][j] = 0;
      for (int a = 0; a < 3; a++)
        for (int b = 0; b < 3; b++) e->T[i][j] += left[a] * tensor[a][b] * right[b] / sine;
    }
}

/* Integrates parallel edges; core is used if they are within touch of one line, whose mean depth bounds the core of
   opening. */
static void Parallel(Edges *e, PetscReal touch, PetscReal core, PetscReal depth)
{
  const PetscReal *d = e->d[0], start = SlipDot(e->D, d), turn = SlipDot(d, e->d[1]) < 0 ? -1 : 1;
  PetscReal r[3], apart = 0, sum[3] = {0}; /* of P, R and the logarithm */

  /* halfway along the second edge, which need not be parallel to rounding */
  for (int i = 0; i < 3; i++) r[i] = e->D[i] + 0.5 * e->length[0] * d[i] - 0.5 * e->length[1] * e->d[1][i];
  {
    const PetscReal along = SlipDot(r, d);

    for (int i = 0; i < 3; i++) r[i] -= along * d[i];
    apart = PetscSqrtReal(SlipDot(r, r));
  }
  if (apart <= touch) apart = 0;
  for (int i = 0; i < 3; i++) r[i] = apart > 0 ? r[i] / apart : 0;
  for (int i = 0; i < 2; i++)
    for (int j = 0; j < 2; j++) {
      const PetscReal sign = i == j ? -1 : 1, value = start + i * e->length[0] - j * turn * e->length[1];
      const PetscReal s = apart == 0 && PetscAbsReal(value) <= touch ? 0 : value, size = PetscAbsReal(s);
      const PetscReal R = PetscSqrtReal(s * s + apart * apart);
      const PetscReal logarithm = size > 0 ? PetscLogReal((size + R) / (apart > 0 ? apart : core)) : 0;

      sum[0] += sign * (size * logarithm - R);
      sum[1] += sign * R;
      sum[2] += sign * (s < 0 ? -logarithm : logarithm);
    }
  /* along the second edge s' runs against d where the edge does */
  sum[0] *= turn;
  sum[1] *= turn;
  sum[2] *= apart * turn;
  e->J = sum[0];
  e->line = apart > 0 || depth <= touch ? 0 : sum[1] * PetscMin(1, PetscLogReal(SHALLOW * depth / core));
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      e->T[i][j] = d[i] * d[j] * sum[1] + (d[i] * r[j] + r[i] * d[j]) * sum[2] + ((i == j) - d[i] * d[j]) * sum[0] -
                   r[i] * r[j] * sum[1];
}

/* Returns whether an edge lies on the line of another one, within touch. */
static PetscBool OnLine(const Edges *e, PetscReal touch)
{
  for (int j = 0; j < 2; j++) {
    PetscReal x[3], along;

    for (int i = 0; i < 3; i++) x[i] = e->D[i] - j * e->length[1] * e->d[1][i];
    along = SlipDot(x, e->d[0]);
    if (SlipDot(x, x) - along * along > 4 * touch * touch) return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

static void Take(const SlipTriangleLoop *loop, int k, PetscReal d[3], PetscReal *length)
{
  const PetscReal *from = loop->vertices + 3 * k, *to = loop->vertices + 3 * ((k + 1) % 3);

  for (int i = 0; i < 3; i++) d[i] = to[i] - from[i];
  *length = PetscSqrtReal(SlipDot(d, d));
  for (int i = 0; i < 3; i++) d[i] /= *length;
}

/* Returns the depth of an edge's middle. */
static PetscReal Middle(const SlipTriangleLoop *loop, int k)
{
  return 0.5 * PetscAbsReal(loop->vertices[3 * k + 2] + loop->vertices[3 * ((k + 1) % 3) + 2]);
}

/* Returns (m x d).(n x c). */
static PetscReal Across(const PetscReal m[3], const PetscReal d[3], const PetscReal n[3], const PetscReal c[3])
{
  return SlipDot(m, n) * SlipDot(d, c) - SlipDot(m, c) * SlipDot(d, n);
}

/*
  SlipTriangleLoops - computes 4 pi/G times the force of the stress drop on one triangle along its own slip, by that of
  the other one, for each of na slips of the one and nb slips of the other, [na][nb]; core: core of edges that both
  share, over the smaller height: with the geometric mean a thin triangle beside one of many times its height would have
  a core that is wider than itself, and a negative stiffness
*/
void SlipTriangleLoops(PetscReal nu, const SlipTriangleLoop *A, PetscInt na, const PetscReal a[][3],
                       const SlipTriangleLoop *B, PetscInt nb, const PetscReal b[][3], PetscReal core,
                       PetscReal force[])
{
  const PetscReal touch = SLIP_TOUCH * PetscMin(A->least, B->least);

  for (PetscInt k = 0; k < na * nb; k++) force[k] = 0;
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) {
      PetscReal cross[3], normal[3], sine;
      Edges e;

      for (int l = 0; l < 3; l++) e.D[l] = A->vertices[3 * i + l] - B->vertices[3 * j + l];
      Take(A, i, e.d[0], &e.length[0]);
      Take(B, j, e.d[1], &e.length[1]);
      SlipCross(e.d[0], e.d[1], cross);
      sine = PetscSqrtReal(SlipDot(cross, cross));
      if (sine < PARALLEL || (sine * PetscMin(e.length[0], e.length[1]) <= touch && OnLine(&e, touch))) {
        const PetscReal height = 2 * PetscMin(A->area / e.length[0], B->area / e.length[1]);

        Parallel(&e, touch, core * height, A->full_space ? PETSC_MAX_REAL : 0.5 * (Middle(A, i) + Middle(B, j)));
      } else {
        for (int l = 0; l < 3; l++) normal[l] = cross[l] / sine;
        Parallelogram(&e, sine, normal);
      }
      for (PetscInt k = 0; k < na; k++)
        for (PetscInt m = 0; m < nb; m++) {
          PetscReal slips[3], u[3], v[3], T = 0;

          SlipCross(a[k], b[m], slips);
          SlipCross(a[k], e.d[0], u);
          SlipCross(b[m], e.d[1], v);
          for (int l = 0; l < 3; l++) T += u[l] * SlipDot(e.T[l], v);
          if (e.line != 0) /* between (a.n) n x d and (b.n) n x d' */
            T -= SlipDot(a[k], A->normal) * SlipDot(b[m], B->normal) * Across(A->normal, e.d[0], B->normal, e.d[1]) *
                 e.line;
          force[k * nb + m] +=
            (SlipDot(a[k], e.d[0]) * SlipDot(b[m], e.d[1]) - 2 * SlipDot(slips, cross)) * e.J + T / (1 - nu);
        }
    }
}

/*
  SlipTriangleLoopEdge - computes the change of 4 pi/G times a triangle's own force along a by slip b if an edge has
  ratio times the core along share of it
*/
PetscReal SlipTriangleLoopEdge(PetscReal nu, const SlipTriangleLoop *loop, const PetscReal a[3], const PetscReal b[3],
                               PetscInt edge, PetscReal share, PetscReal ratio)
{
  PetscReal d[3], length, u[3], v[3];

  Take(loop, (int)edge, d, &length);
  SlipCross(a, d, u);
  SlipCross(b, d, v);
  return -2 * share * length * PetscLogReal(ratio) * (SlipDot(a, d) * SlipDot(b, d) + SlipDot(u, v) / (1 - nu));
}
