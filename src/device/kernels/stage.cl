// Stages of set-valued friction: the preconditioner on an endless plane, as in src/mat/grid/toeplitz_root.c, and loops over cells of src/snes

// Pads a field on a plane of 2 length rows: it begins at row `first`, and is zero elsewhere; with image it is even about both ends of the first
// length rows.
__kernel void plane_pad(int nx, int nz, int width, int length, int first, int image, __global const double *u, __global double *pad)
{
  const int i = get_global_id(0), j = get_global_id(1), row = (j < length || !image ? j : 2 * length - 1 - j) - first;

  if (i < width) pad[(size_t)j * width + i] = i < nx && row >= 0 && row < nz ? u[(size_t)row * nx + i] : 0;
}

// Divides by f of S, values [length + 1][columns], which is even in both wavenumbers.
__kernel void plane_inverse(int columns, int length, double identity, double root, double stiffness, double slope, double limit, double smallest,
                            __global const double *values, __global double2 *pad)
{
  const int i = get_global_id(0), j = get_global_id(1);

  if (i < columns) {
    const double s = values[(size_t)(j <= length ? j : 2 * length - j) * columns + i], g = identity + root * sqrt(s) + stiffness * s;

    pad[(size_t)j * columns + i] /= fmax(fmax(g + slope, limit * g), smallest);
  }
}

__kernel void plane_take(int nx, int nz, int width, int first, __global const double *pad, __global double *y)
{
  const int i = get_global_id(0), j = get_global_id(1);

  if (i < nx && j < nz) y[(size_t)j * nx + i] = pad[(size_t)(first + j) * width + i];
}

// Divides y - z by the tolerance of the larger of both, as TSErrorWeightedNorm(): sum of squares, count of tolerances, and largest
__kernel void weighted_norm(int n, double atol, double rtol, double vectors, __global const double *y, __global const double *z,
                            __global const double *absolute, __global const double *relative, __global double *room)
{
  __local double all[ITEMS];
  double mine[3] = {0, 0, 0};

  EACH(i, n) {
    const double a = vectors > 0 ? absolute[i] : atol, r = vectors > 1 ? relative[i] : rtol;
    const double tolerance = a + r * fmax(fabs(y[i]), fabs(z[i])), error = tolerance > 0 ? fabs(y[i] - z[i]) / tolerance : 0;

    mine[0] += error * error;
    mine[1] += tolerance > 0;
    mine[2] = larger(mine[2], error);
  }
  fold(3, 2, mine, all, room);
}

// ---- faults whose friction sticks, of one component and one state that does not heal: their numbers are (v, u, s) ----

// The stored numbers of cells, [n] each, one after the other
enum { KEPT_RESIDUAL, KEPT_DROP, KEPT_DISTANCE, KEPT_RATE, KEPT_STRESS, KEPT_VINF, KEPT_T0, KEPT_DT0 };
enum { EXPONENTIAL, LINEAR, BY_RATE, CONSTANT };
#define KEPT(what) cells[KEPT_##what * n + i]

// Returns mu of a cell less its residual value, and the derivatives.
static double excess(double law, double drop, double distance, double rate, double s, double v, double *ds, double *dv)
{
  const double fall = 1 / (1 + v / rate), left = drop * SlipExp(-s / distance);
  const bool weakening = s < distance;

  *ds = law == EXPONENTIAL ? -left / distance : law == LINEAR && weakening ? -drop / distance : 0;
  *dv = law == BY_RATE ? -drop * fall * fall / rate : 0;
  return law == EXPONENTIAL ? left : law == LINEAR ? (weakening ? drop * (1 - s / distance) : 0) : law == BY_RATE ? drop * fall : 0;
}

#define EXCESS(s, v) excess(law, KEPT(DROP), KEPT(DISTANCE), KEPT(RATE), s, v, &ds, &dv)

__kernel void stick_eliminate(int n, double inertia, double theta, double more, __global const double *base, __global const double *ex,
                              __global const double *vinf, __global double *c, __global double *u0, __global double *s0)
{
  const int i = get_global_id(0);

  if (i < n) {
    const double a = more != 0 ? ex[3 * i] : 0, b = more != 0 ? ex[3 * i + 1] : 0, d = more != 0 ? ex[3 * i + 2] : 0;

    c[i] = inertia != 0 ? inertia * base[3 * i] + a : 0;
    u0[i] = base[3 * i + 1] + theta * (b - vinf[i]);
    s0[i] = base[3 * i + 2] + theta * d;
  }
}

__kernel void stick_bound(int n, double law, double theta, double slopes, __global const double *x, __global const double *s0, __global double *q,
                          __global double *dq, __global const double *cells)
{
  const int i = get_global_id(0);

  if (i < n) {
    const double v = fabs(x[i]);
    double ds, dv;
    const double mu = KEPT(RESIDUAL) + EXCESS(s0[i] + theta * v, v);

    q[i] = KEPT(STRESS) * mu;
    if (slopes != 0) dq[i] = KEPT(STRESS) * (theta * ds + dv);
  }
}

__kernel void stick_start_slope(int n, double law, double theta, __global const double *s0, __global double *slope, __global const double *cells)
{
  const int i = get_global_id(0);

  if (i < n) {
    double ds, dv;

    (void)EXCESS(s0[i], 0);
    slope[i] = theta * ds * KEPT(STRESS);
  }
}

__kernel void stick_strength(int n, double law, __global const double *w, __global double *q, __global const double *cells)
{
  const int i = get_global_id(0);

  if (i < n) {
    double ds, dv;

    q[i] = KEPT(STRESS) * (KEPT(RESIDUAL) + EXCESS(w[3 * i + 2], fabs(w[3 * i])));
  }
}

__kernel void stick_lift(int n, double theta, __global const double *v, __global const double *u0, __global const double *s0, __global double *w)
{
  const int i = get_global_id(0);

  if (i < n) {
    w[3 * i] = v[i];
    w[3 * i + 1] = u0[i] + theta * v[i];
    w[3 * i + 2] = s0[i] + theta * fabs(v[i]);
  }
}

__kernel void stick_smooth(int n, __global const double *w, __global const double *relative, __global const double *force, __global double *F)
{
  const int i = get_global_id(0);

  if (i < n) {
    F[3 * i] = -force[i];
    F[3 * i + 1] = relative[i];
    F[3 * i + 2] = fabs(w[3 * i]);
  }
}

__kernel void stick_add_reaction(int n, double a, __global const double *r, __global double *F)
{
  const int i = get_global_id(0);

  if (i < n) F[3 * i] += a * r[i];
}

// Divides by the mass; without mass the result is 0.
__kernel void stick_mass(int n, double mass, __global double *k)
{
  const int i = get_global_id(0);

  if (i < n) k[3 * i] = mass != 0 ? k[3 * i] / mass : 0;
}

__kernel void stick_kick(int n, double law, double mass, double a, double damped, __global const double *push, __global const double *vinf, __global const double *eta,
                         __global double *w, __global const double *cells)
{
  const int i = get_global_id(0);

  if (i < n) {
    const double own = damped != 0 ? eta[i] : 0;
    double ds, dv;
    const double q = KEPT(STRESS) * (KEPT(RESIDUAL) + EXCESS(w[3 * i + 2], 0));

    w[3 * i] = SlipKickConstant(mass, own, a, push[i] + own * vinf[i], q, w[3 * i]);
  }
}

__kernel void stick_drift(int n, double h, __global const double *vinf, __global double *w)
{
  const int i = get_global_id(0);

  if (i < n) {
    w[3 * i + 1] += h * (w[3 * i] - vinf[i]);
    w[3 * i + 2] += h * fabs(w[3 * i]);
  }
}

// Sums over the cells in the order of SlipFaultSumId, and the largest |v|; V, NUM_SUMS and the others are those of the sums of rate and state
__kernel void stick_sums(int n, double law, double shears, double time, __global const double *w, __global const double *force,
                         __global const double *cells, __global double *room)
{
  __local double all[ITEMS];
  double mine[NUM_SUMS + 1];

  for (int k = 0; k <= NUM_SUMS; k++) mine[k] = 0;
  EACH(i, n) {
    const double v = w[3 * i], u = w[3 * i + 1], s = w[3 * i + 2], ku = force[i], vinf = KEPT(VINF), speed = fabs(v);
    double ds, dv;
    const double more = EXCESS(s, speed), q = KEPT(STRESS) * (KEPT(RESIDUAL) + more), shear = KEPT(T0) + time * KEPT(DT0);

    mine[V] += v;
    mine[ABS_V] += speed;
    mine[V2] += v * v;
    mine[U] += u;
    mine[S] += s;
    mine[SLIDING] += speed != 0;
    mine[U_KU] += u * ku;
    mine[V_KU] += v * ku;
    mine[VINF_KU] += vinf * ku;
    mine[VINF] += vinf;
    if (shears != 0) {
      mine[U_T] += u * shear;
      mine[LOADING_T] += vinf * shear - u * KEPT(DT0);
    }
    mine[STRENGTH] += q;
    mine[WEAKENING] += KEPT(STRESS) * more;
    mine[PUSH] += speed > 0 ? (v > 0 ? -ku : ku) - q : fmax(fabs(ku) - q, 0.0);
    mine[NUM_SUMS] = larger(mine[NUM_SUMS], speed);
  }
  fold(NUM_SUMS + 1, NUM_SUMS, mine, all, room);
}

// Computes the sums of a mode x whose K x is kx, in the order of SlipFaultModeId.
__kernel void stick_mode(int n, double law, double mass, __global const double *w, __global const double *x, __global const double *kx,
                         __global const double *cells, __global double *room)
{
  __local double all[ITEMS];
  double mine[3] = {0, 0, 0};

  EACH(i, n) {
    double ds, dv;

    (void)EXCESS(w[3 * i + 2], fabs(w[3 * i]));
    mine[0] += x[i] * kx[i];
    mine[1] -= ds * KEPT(STRESS) * x[i] * x[i];
    mine[2] += mass * x[i] * x[i];
  }
  fold(3, 3, mine, all, room);
}

// Computes |e_s| and d|v|/dt of sliding cells.
__kernel void stick_estimates(int n, double estimates, double derivatives, __global const double *w, __global const double *e, __global const double *d,
                              __global double *room)
{
  __local double all[ITEMS];
  double mine[2] = {0, 0};

  EACH(i, n) {
    const double v = w[3 * i];

    if (estimates != 0) mine[0] += fabs(e[3 * i + 2]);
    if (derivatives != 0) mine[1] += v > 0 ? d[3 * i] : v < 0 ? -d[3 * i] : 0;
  }
  fold(2, 2, mine, all, room);
}

// Computes the effect of a step's error on the balance, and the remaining slip, in the order of src/run/watch/slipestimate.c.
__kernel void stick_step(int n, double law, double mass, __global const double *w, __global const double *e, __global const double *ku,
                         __global const double *cells, __global double *room)
{
  __local double all[ITEMS];
  double mine[4] = {0, 0, 0, 0};

  EACH(i, n) {
    const double v = w[3 * i], s = w[3 * i + 2];
    double ds, dv;
    const double q = KEPT(STRESS) * (KEPT(RESIDUAL) + EXCESS(s, fabs(v)));

    mine[0] += mass * v * e[3 * i] + ku[i] * e[3 * i + 1] + q * e[3 * i + 2];
    mine[1] += (ku[i] + q) * s;
    mine[2] += s;
    mine[3] += v != 0 ? s : 0;
  }
  fold(4, 4, mine, all, room);
}

// Computes sums in the order of src/run/watch/courseestimate.c.
__kernel void stick_timing(int n, double mass, __global const double *w, __global const double *e, __global const double *d, __global double *room)
{
  __local double all[ITEMS];
  double mine[6] = {0, 0, 0, 0, 0, 0};

  EACH(i, n) {
    const double v = w[3 * i], grows = v > 0 ? d[3 * i] : v < 0 ? -d[3 * i] : 0;

    mine[0] += fabs(v);
    mine[1] += w[3 * i + 2];
    mine[2] += e[3 * i + 2];
    mine[3] += mass * (v * e[3 * i] - grows * e[3 * i + 2]);
    mine[4] += mass * v * v;
    mine[5] += grows;
  }
  fold(6, 6, mine, all, room);
}

// Computes the power of damping for the rate relative to the far field, of the far field, and of friction, with r or the state's strength.
__kernel void stick_powers(int n, double law, double known, __global const double *w, __global const double *relative, __global const double *damping,
                           __global const double *r, __global const double *cells, __global double *room)
{
  __local double all[ITEMS];
  double mine[3] = {0, 0, 0};

  EACH(i, n) {
    const double v = w[3 * i], speed = fabs(v);
    double ds, dv;
    const double q = KEPT(STRESS) * (KEPT(RESIDUAL) + EXCESS(w[3 * i + 2], speed));

    mine[0] += relative[i] * damping[i];
    mine[1] += KEPT(VINF) * damping[i];
    mine[2] += known != 0 ? -v * r[i] : speed * q;
  }
  fold(3, 3, mine, all, room);
}
