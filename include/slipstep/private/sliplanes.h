/* Internal part of src/mat/grid/lanes.c: its loops over lanes for one kind of vector unit. It is included once per
   kind, with LANES_WIDTH, the numbers in a vector, LANES_TARGET, the compiler's attribute for that unit, and
   LANES_NAME(name). Vectors wider than those of the unit take ten times as long (GCC 12, measured), so that one
   function cannot be compiled for several units. */

typedef double LANES_NAME(Vector) __attribute__((vector_size(8 * LANES_WIDTH), aligned(8), may_alias));
#define VECTOR LANES_NAME(Vector)
#define AT(p) (*(VECTOR *)(p))
#define BUTTERFLY LANES_TARGET static inline __attribute__((always_inline)) void

/* y[k] = b times a twiddle factor, if there are any: those of the last pass are 1 */
#define TURN(k, br, bi)                                                                                                \
  {                                                                                                                    \
    const VECTOR tr = br, ti = bi;                                                                                     \
                                                                                                                       \
    if (turn) {                                                                                                        \
      AT(yr + (k)*out) = w[2 * (k)-2] * tr - w[2 * (k)-1] * ti;                                                        \
      AT(yi + (k)*out) = w[2 * (k)-2] * ti + w[2 * (k)-1] * tr;                                                        \
    } else {                                                                                                           \
      AT(yr + (k)*out) = tr;                                                                                           \
      AT(yi + (k)*out) = ti;                                                                                           \
    }                                                                                                                  \
  }

BUTTERFLY LANES_NAME(Two)(PetscInt in, PetscInt out, int turn, const PetscReal w[], const PetscReal *xr,
                          const PetscReal *xi, PetscReal *yr, PetscReal *yi)
{
  const VECTOR ar = AT(xr), ai = AT(xi), br = AT(xr + in), bi = AT(xi + in);

  AT(yr) = ar + br;
  AT(yi) = ai + bi;
  TURN(1, ar - br, ai - bi)
}

BUTTERFLY LANES_NAME(Three)(PetscInt in, PetscInt out, int turn, const PetscReal w[], const PetscReal *xr,
                            const PetscReal *xi, PetscReal *yr, PetscReal *yi)
{
  const PetscReal sine = 0.86602540378443864676;
  const VECTOR ar = AT(xr), ai = AT(xi), br = AT(xr + in), bi = AT(xi + in), cr = AT(xr + 2 * in), ci = AT(xi + 2 * in);
  const VECTOR sr = br + cr, si = bi + ci, dr = sine * (br - cr), di = sine * (bi - ci);
  const VECTOR mr = ar - 0.5 * sr, mi = ai - 0.5 * si;

  AT(yr) = ar + sr;
  AT(yi) = ai + si;
  TURN(1, mr + di, mi - dr)
  TURN(2, mr - di, mi + dr)
}

BUTTERFLY LANES_NAME(Four)(PetscInt in, PetscInt out, int turn, const PetscReal w[], const PetscReal *xr,
                           const PetscReal *xi, PetscReal *yr, PetscReal *yi)
{
  const VECTOR ar = AT(xr) + AT(xr + 2 * in), ai = AT(xi) + AT(xi + 2 * in);
  const VECTOR br = AT(xr) - AT(xr + 2 * in), bi = AT(xi) - AT(xi + 2 * in);
  const VECTOR cr = AT(xr + in) + AT(xr + 3 * in), ci = AT(xi + in) + AT(xi + 3 * in);
  const VECTOR dr = AT(xr + in) - AT(xr + 3 * in), di = AT(xi + in) - AT(xi + 3 * in);

  AT(yr) = ar + cr;
  AT(yi) = ai + ci;
  TURN(1, br + di, bi - dr)
  TURN(2, ar - cr, ai - ci)
  TURN(3, br - di, bi + dr)
}

BUTTERFLY LANES_NAME(Five)(PetscInt in, PetscInt out, int turn, const PetscReal w[], const PetscReal *xr,
                           const PetscReal *xi, PetscReal *yr, PetscReal *yi)
{
  const PetscReal c1 = 0.30901699437494742410, s1 = 0.95105651629515357212;
  const PetscReal c2 = -0.80901699437494742410, s2 = 0.58778525229247312917;
  const VECTOR ar = AT(xr), ai = AT(xi);
  const VECTOR pr = AT(xr + in) + AT(xr + 4 * in), pi = AT(xi + in) + AT(xi + 4 * in);
  const VECTOR qr = AT(xr + 2 * in) + AT(xr + 3 * in), qi = AT(xi + 2 * in) + AT(xi + 3 * in);
  const VECTOR mr = AT(xr + in) - AT(xr + 4 * in), mi = AT(xi + in) - AT(xi + 4 * in);
  const VECTOR nr = AT(xr + 2 * in) - AT(xr + 3 * in), ni = AT(xi + 2 * in) - AT(xi + 3 * in);
  const VECTOR er = ar + c1 * pr + c2 * qr, ei = ai + c1 * pi + c2 * qi;
  const VECTOR fr = ar + c2 * pr + c1 * qr, fi = ai + c2 * pi + c1 * qi;
  const VECTOR gr = s1 * mr + s2 * nr, gi = s1 * mi + s2 * ni;
  const VECTOR hr = s2 * mr - s1 * nr, hi = s2 * mi - s1 * ni;

  AT(yr) = ar + pr + qr;
  AT(yi) = ai + pi + qi;
  TURN(1, er + gi, ei - gr)
  TURN(2, fr + hi, fi - hr)
  TURN(3, fr - hi, fi + hr)
  TURN(4, er - gi, ei + gr)
}

/* Combines two transforms of every other number, of length four each, by a butterfly of two for each pair. */
BUTTERFLY LANES_NAME(Eight)(PetscInt in, PetscInt out, int turn, const PetscReal w[], const PetscReal *xr,
                            const PetscReal *xi, PetscReal *yr, PetscReal *yi)
{
  const PetscReal root = 0.70710678118654752440;
  VECTOR er[2][4], ei[2][4];

  for (int o = 0; o < 2; o++) {
    const PetscReal *pr = xr + o * in, *pi = xi + o * in;
    const VECTOR ar = AT(pr) + AT(pr + 4 * in), ai = AT(pi) + AT(pi + 4 * in);
    const VECTOR br = AT(pr) - AT(pr + 4 * in), bi = AT(pi) - AT(pi + 4 * in);
    const VECTOR cr = AT(pr + 2 * in) + AT(pr + 6 * in), ci = AT(pi + 2 * in) + AT(pi + 6 * in);
    const VECTOR dr = AT(pr + 2 * in) - AT(pr + 6 * in), di = AT(pi + 2 * in) - AT(pi + 6 * in);

    er[o][0] = ar + cr;
    ei[o][0] = ai + ci;
    er[o][1] = br + di;
    ei[o][1] = bi - dr;
    er[o][2] = ar - cr;
    ei[o][2] = ai - ci;
    er[o][3] = br - di;
    ei[o][3] = bi + dr;
  }
  const VECTOR fr = root * (er[1][1] + ei[1][1]), fi = root * (ei[1][1] - er[1][1]);
  const VECTOR gr = root * (ei[1][3] - er[1][3]), gi = root * (er[1][3] + ei[1][3]);

  AT(yr) = er[0][0] + er[1][0];
  AT(yi) = ei[0][0] + ei[1][0];
  TURN(1, er[0][1] + fr, ei[0][1] + fi)
  TURN(2, er[0][2] + ei[1][2], ei[0][2] - er[1][2])
  TURN(3, er[0][3] + gr, ei[0][3] - gi)
  TURN(4, er[0][0] - er[1][0], ei[0][0] - ei[1][0])
  TURN(5, er[0][1] - fr, ei[0][1] - fi)
  TURN(6, er[0][2] - ei[1][2], ei[0][2] + er[1][2])
  TURN(7, er[0][3] - gr, ei[0][3] + gi)
}

/* A pass of radix r over s interleaved transforms of length r m: x to y, real and imaginary parts of each. The last
   pass, m = 1, has no twiddle factors. */
#define LOOP(butterfly, r, turn)                                                                                       \
  for (PetscInt p = 0; p < m; p++)                                                                                     \
    for (PetscInt q = 0; q < s; q++)                                                                                   \
      for (PetscInt l = 0; l < SLIP_LANES; l += LANES_WIDTH) {                                                         \
        const PetscInt from = SLIP_NUMBER * (q + s * p) + l, to = SLIP_NUMBER * (q + s * (r)*p) + l;                   \
                                                                                                                       \
        LANES_NAME(butterfly)                                                                                          \
        (in, out, turn, w + 2 * ((r)-1) * p, xr + from, xi + from, yr + to, yi + to);                                  \
      }
#define PASS(butterfly, r)                                                                                             \
  if (m > 1) {                                                                                                         \
    LOOP(butterfly, r, 1)                                                                                              \
  } else {                                                                                                             \
    LOOP(butterfly, r, 0)                                                                                              \
  }

LANES_TARGET static void LANES_NAME(Pass)(PetscInt r, PetscInt m, PetscInt s, const PetscReal w[], const PetscReal *xr,
                                          const PetscReal *xi, PetscReal *yr, PetscReal *yi)
{
  const PetscInt in = SLIP_NUMBER * s * m, out = SLIP_NUMBER * s;

  switch (r) {
  case 2:
    PASS(Two, 2)
    break;
  case 3:
    PASS(Three, 3)
    break;
  case 4:
    PASS(Four, 4)
    break;
  case 5:
    PASS(Five, 5)
    break;
  default:
    PASS(Eight, 8)
  }
}

/* Splits fields, of g->n numbers each, the first of 2 n numbers, into two halves, whose transforms of length n are the
   even and the odd numbers of their transform: unchanged, and multiplied by turn [n] complex. v, unless NULL: the same
   for z times the fields. */
LANES_TARGET static void LANES_NAME(Load)(PetscInt n, const PetscReal turn[], const SlipLanesFields *g,
                                          const PetscReal z[], const PetscReal field[], PetscReal *const u[2],
                                          PetscReal *const v[2])
{
  const size_t apart = (size_t)g->apart, imaginary = (size_t)g->imaginary;

  for (PetscInt i = 0; i < g->n; i++) {
    const PetscReal *f = field + g->step * i;
    const PetscInt at = SLIP_NUMBER * i;

    AHEAD(f + (size_t)(i % SLIP_LANES) * apart + LOAD_AHEAD, 0);
    AHEAD(f + (size_t)((i + SLIP_LANES / 2) % SLIP_LANES) * apart + imaginary + LOAD_AHEAD, 0);
    for (PetscInt l = 0; l < SLIP_LANES; l += LANES_WIDTH) {
      VECTOR re, im;

      for (int k = 0; k < LANES_WIDTH; k++) {
        re[k] = f[(l + k) * apart];
        im[k] = f[(l + k) * apart + imaginary];
      }
      const VECTOR tr = turn[2 * i] * re - turn[2 * i + 1] * im, ti = turn[2 * i] * im + turn[2 * i + 1] * re;

      AT(u[0] + at + l) = re;
      AT(u[0] + at + SLIP_LANES + l) = im;
      AT(u[1] + at + l) = tr;
      AT(u[1] + at + SLIP_LANES + l) = ti;
      if (!v) continue;
      AT(v[0] + at + l) = z[i] * re;
      AT(v[0] + at + SLIP_LANES + l) = z[i] * im;
      AT(v[1] + at + l) = z[i] * tr;
      AT(v[1] + at + SLIP_LANES + l) = z[i] * ti;
    }
  }
  for (int part = 0; part < 2; part++)
    for (PetscInt i = SLIP_NUMBER * g->n; i < SLIP_NUMBER * n; i++) {
      u[part][i] = 0;
      if (v) v[part][i] = 0;
    }
}

/* The inverse: scale (u - z v), v unless NULL */
LANES_TARGET static void LANES_NAME(Store)(const PetscReal turn[], const SlipLanesFields *g, const PetscReal z[],
                                           PetscReal scale, PetscReal *const u[2], PetscReal *const v[2],
                                           PetscReal field[])
{
  for (PetscInt i = 0; i < g->n; i++) {
    const PetscInt at = SLIP_NUMBER * i;
    const PetscReal c = turn[2 * i], s = turn[2 * i + 1];
    PetscReal sum[SLIP_NUMBER], *f = field + g->step * i;

    for (PetscInt l = 0; l < SLIP_LANES; l += LANES_WIDTH) {
      const PetscInt re = at + l, im = re + SLIP_LANES;
      VECTOR a = AT(u[0] + re) + c * AT(u[1] + re) + s * AT(u[1] + im);
      VECTOR b = AT(u[0] + im) + c * AT(u[1] + im) - s * AT(u[1] + re);

      if (v) {
        a -= z[i] * (AT(v[0] + re) + c * AT(v[1] + re) + s * AT(v[1] + im));
        b -= z[i] * (AT(v[0] + im) + c * AT(v[1] + im) - s * AT(v[1] + re));
      }
      AT(sum + l) = scale * a;
      AT(sum + SLIP_LANES + l) = scale * b;
    }
    for (PetscInt l = 0; l < SLIP_LANES; l++) {
      f[l * g->apart] = sum[l];
      f[l * g->apart + g->imaginary] = sum[SLIP_LANES + l];
    }
  }
}

/* In place on n pairs (k, -k) of 2 n numbers, the even ones in u[0] and the odd ones in u[1]:
   u(k) = T(k) u(k) + A(k) u(-k), A(-k) the conjugate of A(k); T or A may be NULL, for 0. */
LANES_TARGET static void LANES_NAME(Multiply)(PetscInt n, const PetscReal T[], const PetscReal A[],
                                              PetscReal *const u[2])
{
  for (PetscInt k = 0; k <= n; k++) {
    if (T) AHEAD(T + SLIP_LANES * (k + SYMBOL_AHEAD), 0);
    for (int part = 0; part < 2 && A; part++) AHEAD(A + SLIP_NUMBER * (k + SYMBOL_AHEAD) + SLIP_LANES * part, 0);
    for (PetscInt l = 0; l < SLIP_LANES; l += LANES_WIDTH) {
      PetscReal *a = u[k % 2] + SLIP_NUMBER * (k / 2) + l, *b = u[k % 2] + SLIP_NUMBER * (k ? (2 * n - k) / 2 : 0) + l;
      const VECTOR ar = AT(a), ai = AT(a + SLIP_LANES), br = AT(b), bi = AT(b + SLIP_LANES);
      const VECTOR none = {0}, t = T ? AT(T + SLIP_LANES * k + l) : none;
      const VECTOR r = A ? AT(A + SLIP_NUMBER * k + l) : none, i = A ? AT(A + SLIP_NUMBER * k + SLIP_LANES + l) : none;

      AT(a) = t * ar + r * br - i * bi;
      AT(a + SLIP_LANES) = t * ai + r * bi + i * br;
      AT(b) = t * br + r * ar + i * ai;
      AT(b + SLIP_LANES) = t * bi + r * ai - i * ar;
    }
  }
}

/* For wavenumbers k in [start, end) of 2 n, a[k - start] [fields] complex, na reals from one k to the next: the
   transforms of real fields, of which each two are the parts of complex ones with the transforms half[k % 2][k / 2]:
   X(k) = (Z(k) + Z*(-k))/2 and Y(k) = (Z(k) - Z*(-k))/2i */
LANES_TARGET static void LANES_NAME(Split)(PetscInt n, PetscReal *const half[2], PetscInt fields, PetscInt start,
                                           PetscInt end, PetscReal a[], PetscInt na)
{
  for (PetscInt k = start; k < end; k++) {
    const PetscReal *z = half[k % 2] + SLIP_NUMBER * (k / 2),
                    *c = half[k % 2] + SLIP_NUMBER * (k ? (2 * n - k) / 2 : 0);
    PetscReal part[4][SLIP_LANES], *to = a + (size_t)(k - start) * na;
    const PetscInt last = fields / 2;

    for (int line = 0; line < 4; line++) AHEAD(to + ROWS_AHEAD * na + SLIP_LANES * line, 1);
    for (PetscInt l = 0; l < SLIP_LANES; l += LANES_WIDTH) {
      const VECTOR zr = AT(z + l), zi = AT(z + SLIP_LANES + l), cr = AT(c + l), ci = AT(c + SLIP_LANES + l);

      AT(part[0] + l) = 0.5 * (zr + cr);
      AT(part[1] + l) = 0.5 * (zi - ci);
      AT(part[2] + l) = 0.5 * (zi + ci);
      AT(part[3] + l) = 0.5 * (cr - zr);
    }
    for (PetscInt l = 0; l < last; l++)
      for (int i = 0; i < 4; i++) to[4 * l + i] = part[i][l];
    for (int i = 0; i < 2 && fields % 2; i++) to[4 * last + i] = part[i][last];
  }
}

/* The inverse: Z(k) = X(k) + i Y(k), Z(-k) = X*(k) + i Y*(k); missing fields are zeros */
LANES_TARGET static void LANES_NAME(Join)(PetscInt n, PetscReal *const half[2], PetscInt fields, PetscInt start,
                                          PetscInt end, const PetscReal a[], PetscInt na)
{
  PetscReal some[4 * SLIP_LANES] = {0};

  for (PetscInt k = start; k < end; k++) {
    PetscReal *z = half[k % 2] + SLIP_NUMBER * (k / 2), *c = half[k % 2] + SLIP_NUMBER * (k ? (2 * n - k) / 2 : 0);
    const PetscReal *from = a + (size_t)(k - start) * na;

    for (int line = 0; line < 4; line++) AHEAD(from + ROWS_AHEAD * na + SLIP_LANES * line, 0);
    if (fields < 2 * SLIP_LANES) {
      for (PetscInt i = 0; i < 2 * fields; i++) some[i] = from[i];
      from = some;
    }
    for (PetscInt l = 0; l < SLIP_LANES; l += LANES_WIDTH) {
      VECTOR xr, xi, yr, yi;

      for (int i = 0; i < LANES_WIDTH; i++) {
        xr[i] = from[4 * (l + i)];
        xi[i] = from[4 * (l + i) + 1];
        yr[i] = from[4 * (l + i) + 2];
        yi[i] = from[4 * (l + i) + 3];
      }
      AT(c + l) = xr + yi;
      AT(c + SLIP_LANES + l) = yr - xi;
      AT(z + l) = xr - yi;
      AT(z + SLIP_LANES + l) = xi + yr;
    }
  }
}

static const Unit LANES_NAME(Unit) = {LANES_NAME(Pass),     LANES_NAME(Load),  LANES_NAME(Store),
                                      LANES_NAME(Multiply), LANES_NAME(Split), LANES_NAME(Join)};

#undef VECTOR
#undef AT
#undef BUTTERFLY
#undef TURN
#undef LOOP
#undef PASS
