/* What point sources in a half-space do, as quadratures of slip take it, and Gauss's nodes. */
#pragma once
#include <math.h>
#include <petscsys.h>

/* A number with two infinitesimal parts, whose squares are 0: second mixed derivatives without differences. */
typedef struct {
  PetscReal v, a, b, ab;
} Dual;

static inline Dual Number(PetscReal v)
{
  return (Dual){v, 0, 0, 0};
}

static inline Dual Plus(Dual x, Dual y)
{
  return (Dual){x.v + y.v, x.a + y.a, x.b + y.b, x.ab + y.ab};
}

static inline Dual Times(Dual x, Dual y)
{
  return (Dual){x.v * y.v, x.a * y.v + x.v * y.a, x.b * y.v + x.v * y.b,
                x.ab * y.v + x.a * y.b + x.b * y.a + x.v * y.ab};
}

static inline Dual Scaled(PetscReal f, Dual x)
{
  return Times(Number(f), x);
}

/* x^p */
static inline Dual Power(Dual x, PetscReal p)
{
  const PetscReal f = pow(x.v, p), d = p * f / x.v, dd = (p - 1) * d / x.v;

  return (Dual){f, d * x.a, d * x.b, d * x.ab + dd * x.a * x.b};
}

static inline Dual Sum(int n, const Dual x[])
{
  Dual sum = Number(0);

  for (int i = 0; i < n; i++) sum = Plus(sum, x[i]);
  return sum;
}

/* 16 pi G (1 - nu) times the displacement i of a unit force j, Mindlin (1936) as printed; without a surface Kelvin's */
static inline void Mindlin(PetscReal nu, PetscBool full, const Dual at[3], const Dual from[3], Dual G[3][3])
{
  const Dual x = Plus(at[0], Scaled(-1, from[0])), y = Plus(at[1], Scaled(-1, from[1])), z = at[2], c = from[2];
  const Dual r[2] = {x, y}, dz = Plus(z, Scaled(-1, c)), w = Plus(z, c), h2 = Plus(Times(x, x), Times(y, y));
  const Dual R1s = Plus(h2, Times(dz, dz)), R2s = Plus(h2, Times(w, w)), cz = Times(c, z);
  const PetscReal k = 3 - 4 * nu, m = 4 * (1 - nu) * (1 - 2 * nu);
  const Dual a1 = Power(R1s, -0.5), a3 = Power(R1s, -1.5), b1 = Power(R2s, -0.5), b3 = Power(R2s, -1.5);
  const Dual b5 = Power(R2s, -2.5), T = Power(Plus(Power(R2s, 0.5), w), -1); /* 1/(R2 + z + c) */

  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) {
      const Dual d[3] = {x, y, dz};

      G[i][j] = Times(Times(d[i], d[j]), a3);
      if (i == j) G[i][j] = Plus(G[i][j], Scaled(k, a1));
    }
  if (full) return;
  for (int i = 0; i < 2; i++) {
    for (int j = 0; j < 2; j++) {
      const Dual xx = Times(r[i], r[j]);
      const Dual terms[] = {G[i][j], Scaled(k, Times(xx, b3)), Scaled(-6, Times(Times(cz, xx), b5)),
                            Scaled(-m, Times(Times(xx, b1), Times(T, T)))};
      const Dual equal[] = {b1, Scaled(2, Times(cz, b3)), Scaled(m, T)};

      G[i][j] = Sum(4, terms);
      if (i == j) G[i][j] = Plus(G[i][j], Sum(3, equal));
    }
    {
      const Dual same = Scaled(k, Times(dz, b3)), deep = Scaled(6, Times(Times(cz, w), b5)),
                 bT = Scaled(m, Times(b1, T));
      const Dual down[] = {same, Scaled(-1, deep), bT}, across[] = {same, deep, Scaled(-1, bT)};

      G[2][i] = Plus(G[2][i], Times(r[i], Sum(3, down)));
      G[i][2] = Plus(G[i][2], Times(r[i], Sum(3, across)));
    }
  }
  {
    const Dual w2 = Times(w, w);
    const Dual terms[] = {G[2][2], Scaled(8 * (1 - nu) * (1 - nu) - k, b1),
                          Times(Plus(Scaled(k, w2), Scaled(-2, cz)), b3), Scaled(6, Times(Times(cz, w2), b5))};

    G[2][2] = Sum(4, terms);
  }
}

/* u[3] and its gradient [3][3] at a point by unit area of slip b at another one on a plane with the normal n: the
   moment's components times the derivatives of the forces' displacements */
static inline void PointSource(PetscReal nu, PetscBool full, const PetscReal b[3], const PetscReal n[3],
                               const PetscReal at[3], const PetscReal from[3], PetscReal field[12])
{
  const PetscReal bn = b[0] * n[0] + b[1] * n[1] + b[2] * n[2];

  for (int i = 0; i < 12; i++) field[i] = 0;
  for (int k = 0; k < 3; k++)
    for (int l = 0; l < 3; l++) {
      Dual p[3], s[3], G[3][3];

      for (int i = 0; i < 3; i++) {
        p[i] = (Dual){at[i], 0, i == l, 0};
        s[i] = (Dual){from[i], i == k, 0, 0};
      }
      Mindlin(nu, full, p, s, G);
      for (int j = 0; j < 3; j++) {
        const PetscReal moment = b[j] * n[k] + b[k] * n[j] + (j == k ? 2 * nu / (1 - 2 * nu) * bn : 0);

        for (int i = 0; i < 3; i++) {
          if (l == 0) field[i] += moment * G[i][j].a / (16 * PETSC_PI * (1 - nu));
          field[3 + 3 * i + l] += moment * G[i][j].ab / (16 * PETSC_PI * (1 - nu));
        }
      }
    }
}

/* n nodes of Gauss and Legendre on (-1/2, 1/2), by Newton's method */
static inline void Gauss(int n, PetscReal node[], PetscReal weight[])
{
  for (int i = 0; i < n; i++) {
    PetscReal x = cos(PETSC_PI * (i + 0.75) / (n + 0.5)), slope = 1;

    for (int repeat = 0; repeat < 50; repeat++) {
      PetscReal p0 = 1, p1 = x;

      for (int k = 2; k <= n; k++) {
        const PetscReal p2 = ((2 * k - 1) * x * p1 - (k - 1) * p0) / k;

        p0 = p1;
        p1 = p2;
      }
      slope = n * (x * p1 - p0) / (x * x - 1);
      x -= p1 / slope;
    }
    node[i] = 0.5 * x;
    weight[i] = 1 / ((1 - x * x) * slope * slope);
  }
}
