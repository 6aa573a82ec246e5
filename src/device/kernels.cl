// All kernels of the device. Numbers are doubles; sums have a fixed tree, so that their bits repeat.
#pragma OPENCL EXTENSION cl_khr_fp64 : enable

// Places of the groups of a reduction, and of its items
#define ITEMS 128

// What is no number counts as infinite.
static double larger(double a, double b)
{
  return isnan(b) || isnan(a) ? INFINITY : fmax(a, b);
}

// The results of a group from those of its items, into room [results][groups]. Sums first, then largest values.
static void fold(int results, int sums, double *mine, __local double *all, __global double *room)
{
  const int i = get_local_id(0), group = get_group_id(0), groups = get_num_groups(0);

  for (int k = 0; k < results; k++) {
    all[i] = mine[k];
    for (int width = ITEMS / 2; width > 0; width /= 2) {
      barrier(CLK_LOCAL_MEM_FENCE);
      if (i < width) all[i] = k < sums ? all[i] + all[i + width] : fmax(all[i], all[i + width]);
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    if (i == 0) room[k * groups + group] = all[0];
    barrier(CLK_LOCAL_MEM_FENCE);
  }
}

// And those of all groups
__kernel void fold_groups(__global const double *room, int groups, int results, int sums, __global double *out)
{
  const int k = get_global_id(0);
  double all = 0;

  if (k >= results) return;
  all = room[k * groups];
  for (int g = 1; g < groups; g++) all = k < sums ? all + room[k * groups + g] : fmax(all, room[k * groups + g]);
  out[k] = all;
}

// ---- vectors ----

__kernel void set(int n, double a, __global double *x)
{
  const int i = get_global_id(0);

  if (i < n) x[i] = a;
}

// y = c z + the sum of m of a x; z may be y, and does not count where c is 0
__kernel void combine(int n, __global double *y, double c, __global const double *z, int m, double a0, __global const double *x0, double a1,
                      __global const double *x1, double a2, __global const double *x2, double a3, __global const double *x3)
{
  const int i = get_global_id(0);
  double sum;

  if (i >= n) return;
  sum = c == 0 ? 0 : c * z[i];
  if (m > 0) sum += a0 * x0[i];
  if (m > 1) sum += a1 * x1[i];
  if (m > 2) sum += a2 * x2[i];
  if (m > 3) sum += a3 * x3[i];
  y[i] = sum;
}

__kernel void multiply(int n, __global const double *x, __global const double *y, __global double *z)
{
  const int i = get_global_id(0);

  if (i < n) z[i] = x[i] * y[i];
}

// 0 where y is, as PETSc has it
__kernel void divide(int n, __global const double *x, __global const double *y, __global double *z)
{
  const int i = get_global_id(0);

  if (i < n) z[i] = y[i] != 0 ? x[i] / y[i] : 0;
}

// y = entries start, start + step, ... of x, and back
__kernel void gather(int n, int start, int step, __global const double *x, __global double *y)
{
  const int i = get_global_id(0);

  if (i < n) y[i] = x[start + step * i];
}

__kernel void scatter(int n, int start, int step, __global const double *x, __global double *y)
{
  const int i = get_global_id(0);

  if (i < n) y[start + step * i] = x[i];
}

__kernel void dot_product(int n, __global const double *x, __global const double *y, __global double *room)
{
  __local double all[ITEMS];
  double mine[1] = {0};

  for (int i = get_global_id(0); i < n; i += get_global_size(0)) mine[0] += x[i] * y[i];
  fold(1, 1, mine, all, room);
}

// The sums of x, |x| and x^2, and the largest |x|
__kernel void norms(int n, __global const double *x, __global double *room)
{
  __local double all[ITEMS];
  double mine[4] = {0, 0, 0, 0};

  for (int i = get_global_id(0); i < n; i += get_global_size(0)) {
    const double size = fabs(x[i]);

    mine[0] += x[i];
    mine[1] += size;
    mine[2] += size * size;
    mine[3] = larger(mine[3], size);
  }
  fold(4, 3, mine, all, room);
}

// The largest |x| of entries start, start + step, ...
__kernel void largest(int n, int start, int step, __global const double *x, __global double *room)
{
  __local double all[ITEMS];
  double mine[1] = {0};

  for (int i = get_global_id(0); i < n; i += get_global_size(0)) {
    const double size = fabs(x[start + step * i]);

    mine[0] = larger(mine[0], size);
  }
  fold(1, 0, mine, all, room);
}

// How many entries differ
__kernel void differ(int n, __global const double *x, __global const double *y, __global double *room)
{
  __local double all[ITEMS];
  double mine[1] = {0};

  for (int i = get_global_id(0); i < n; i += get_global_size(0)) mine[0] += x[i] != y[i];
  fold(1, 1, mine, all, room);
}

// ---- the stiffness of a uniform grid, as in src/mat/grid/toeplitz.c ----

// Fields u and z u, zero beyond the grid, in rows of `width` numbers; height rows a field
__kernel void grid_pad(int nx, int nz, int width, int height, int fields, __global const double *z, __global const double *u, __global double *pad)
{
  const int i = get_global_id(0), j = get_global_id(1);
  const size_t at = (size_t)j * width + i;
  double x;

  if (i >= width || j >= height) return;
  x = i < nx && j < nz ? u[(size_t)j * nx + i] : 0;
  pad[at] = x;
  if (fields > 1) pad[at + (size_t)width * height] = j < nz ? z[j] * x : 0;
}

// In place on pairs (k, -k) of wavenumbers in depth: u(k) = T u(k) + A(k) u(-k) and, of the second field, q(k) (z u)(-k). T, A and q
// [height/2 + 1][columns].
__kernel void grid_symbol(int columns, int height, int fields, __global const double *T, __global const double2 *A, __global const double2 *Q,
                          __global double2 *pad)
{
  const int i = get_global_id(0), j = get_global_id(1);
  const size_t at = (size_t)j * columns + i, other = (size_t)((height - j) % height) * columns + i, next = (size_t)columns * height;
  double2 a, b, s;
  double t;

  if (i >= columns || j > height / 2) return;
  a = pad[at];
  b = pad[other];
  t = T[at];
  if (fields == 1) {
    pad[at] = t * a;
    if (other != at) pad[other] = t * b;
    return;
  }
  s = A[at];
  pad[at] = (double2)(t * a.x + s.x * b.x - s.y * b.y, t * a.y + s.x * b.y + s.y * b.x);
  if (other != at) pad[other] = (double2)(t * b.x + s.x * a.x + s.y * a.y, t * b.y + s.x * a.y - s.y * a.x);
  a = pad[next + at];
  b = pad[next + other];
  s = Q[at];
  pad[next + at] = (double2)(s.x * b.x - s.y * b.y, s.x * b.y + s.y * b.x);
  if (other != at) pad[next + other] = (double2)(s.x * a.x + s.y * a.y, s.x * a.y - s.y * a.x);
}

__kernel void grid_take(int nx, int nz, int width, int height, int fields, double scale, __global const double *z, __global const double *pad,
                        __global double *y)
{
  const int i = get_global_id(0), j = get_global_id(1);
  const size_t at = (size_t)j * width + i;

  if (i < nx && j < nz) y[(size_t)j * nx + i] = scale * (fields > 1 ? pad[at] - z[j] * pad[at + (size_t)width * height] : pad[at]);
}

// ---- steps of TSADAMS, as in src/ts/adamssum.c ----

#define NODES 10
typedef struct {
  double of[4][NODES];
} Weights;

// The derivatives of entry i, by as many arguments
#define RATES                                                                                                                         \
  int m, __global const double *r0, __global const double *r1, __global const double *r2, __global const double *r3, __global const double *r4, \
    __global const double *r5, __global const double *r6, __global const double *r7, __global const double *r8, __global const double *r9
#define TAKE_RATES(i, r)                                                                                                              \
  double r[NODES] = {r0[i], m > 1 ? r1[i] : 0, m > 2 ? r2[i] : 0, m > 3 ? r3[i] : 0, m > 4 ? r4[i] : 0,                              \
                     m > 5 ? r5[i] : 0, m > 6 ? r6[i] : 0, m > 7 ? r7[i] : 0, m > 8 ? r8[i] : 0, m > 9 ? r9[i] : 0}

static double weighted(int m, const double w[NODES], const double r[NODES])
{
  double sum = 0;

  for (int k = 0; k < m; k++) sum += w[k] * r[k];
  return sum;
}

// y = start + the sum of derivatives times weight 0; the sum of y, which is no number where one of them is none
__kernel void adams(int n, __global const double *start, RATES, Weights weights, __global double *y, __global double *room)
{
  __local double all[ITEMS];
  double mine[1] = {0};

  for (int i = get_global_id(0); i < n; i += get_global_size(0)) {
    TAKE_RATES(i, r);

    y[i] = start[i] + weighted(m, weights.of[0], r);
    mine[0] += y[i];
  }
  fold(1, 1, mine, all, room);
}

// The same with three estimates, the sums by the other weights, over their tolerances: sums of squares, and how many have a tolerance; the
// largest of each
__kernel void adams_norms(int n, __global const double *start, RATES, Weights weights, __global double *y, __global const double *absolute,
                          __global const double *relative, __global double *room)
{
  __local double all[ITEMS];
  double mine[8] = {0, 0, 0, 0, 0, 0, 0, 0};

  for (int i = get_global_id(0); i < n; i += get_global_size(0)) {
    TAKE_RATES(i, r);

    y[i] = start[i] + weighted(m, weights.of[0], r);
    mine[0] += y[i];
    for (int k = 0; k < 3; k++) {
      const double e = weighted(m, weights.of[k + 1], r), tolerance = absolute[i] + relative[i] * fmax(fabs(y[i]), fabs(y[i] + e));
      const double share = tolerance > 0 ? fabs(e) / tolerance : 0;

      mine[1 + k] += share * share;
      mine[5 + k] = larger(mine[5 + k], share);
      if (k == 0) mine[4] += tolerance > 0;
    }
  }
  fold(8, 5, mine, all, room);
}

// ---- a fault of rate and state ----

// What its cells keep, [n] each one behind the other
enum { OFFSET, SLOPE, INVERSE, SCALE, LOAD, SLIP, LOADING, TRACTION };
#define OF(what) cells[(what)*n + i]

// w of w + ln w = L, Lambert's W(e^L), and 1/(1 + w): as src/core/ratestate.c has it
static double lambert_of_exp(double L, double *inverse)
{
  const double more = log1p(exp(fmin(L, 20.0))), p = L > 20 ? L : more, guess = p * (1 - log1p(p) / (2 + p)), z = L - log(guess) - guess;
  const double q = 2 * (1 + guess) * (1 + guess + 2.0 / 3 * z), w = guess * (1 + z * (q - z) / ((1 + guess) * (q - 2 * z))), near = 1 / (1 + w);
  const double a = near * (L - log(w) - w), r = 0.5 * a * near * (1 - 2.0 / 3 * a), solution = w * (1 + a * (1 + r * (1 + 2 * r)));

  *inverse = near * (2 - (1 + solution) * near);
  return solution;
}

static double log_sinh(double y)
{
  return y > 20 ? y - M_LN2 : log(sinh(y));
}

// Where the closed form does not hold: y + c sinh y = load, y = mu/a, by Newton's method from above, where it is monotone, with ln c
static double rate_by_newton(double load, double log_c, double scale)
{
  double z = log(load) - log_c, y = fmin(load, z > 20 ? z + M_LN2 : asinh(exp(z)));

  if (load == 0) return 0;
  if (z < -600) return scale * load; // no strength to speak of
  for (int k = 0; k < 100; k++) {
    const double s = exp(log_c + log_sinh(y)), change = (y + s - load) / (1 + (y > 20 ? s : s / tanh(y)));

    y -= change;
    if (!(change > 4e-16 * y)) break;
  }
  return scale * exp(log_c + log_sinh(y));
}

// |v| of the balance of friction and radiation damping, from the magnitude of the stress
static double balanced_rate(double stress, double psi, double offset, double slope, double inverse, double scale, double reference_rate, double eta)
{
  const double load = stress * inverse, L = load + offset - slope * psi;
  double near, w, y, tail;

  if (!(scale > 0)) return stress / eta; // without strength
  w = lambert_of_exp(fmax(L, -700.0), &near);
  y = load - w;
  if (y > 10 && L > -700) {
    tail = exp(-2 * y);
    return w * scale * (1 + w * tail * near) * (1 - tail);
  }
  return rate_by_newton(load, M_LN2 + offset - slope * psi, scale);
}

// The slip rates of a state, and unless f is not wanted its derivative; force is K u
__kernel void fault_rates(int n, int slip_law, double V0, double eta, __global const double *cells, __global const double *state,
                          __global const double *force, __global double *rate, int wanted, __global double *f)
{
  const int i = get_global_id(0);
  double psi, tau, speed, v, ds;

  if (i >= n) return;
  psi = state[3 * i + 2];
  tau = OF(LOAD) - force[i];
  speed = balanced_rate(fabs(tau), psi, OF(OFFSET), OF(SLOPE), OF(INVERSE), OF(SCALE), V0, eta);
  v = tau < 0 ? -speed : speed;
  rate[i] = v;
  if (!wanted) return;
  if (slip_law)
    ds = -speed / OF(SLIP) * (log(fmax(speed, 1e-300) / V0) + psi);
  else
    ds = (V0 * exp(fmin(-psi, 200.0)) - speed) / OF(SLIP);
  f[3 * i] = 0;
  f[3 * i + 1] = v - OF(LOADING);
  f[3 * i + 2] = ds;
}

// How many displacements and states are out of bounds, or no numbers
__kernel void fault_outside(int n, double displacement, double bound, __global const double *state, __global double *room)
{
  __local double all[ITEMS];
  double mine[1] = {0};

  for (int i = get_global_id(0); i < n; i += get_global_size(0))
    mine[0] += (double)!(fabs(state[3 * i + 1]) < displacement) + (double)!(fabs(state[3 * i + 2]) < bound);
  fold(1, 1, mine, all, room);
}

// mu and V dmu/dV of a cell, (f0 + b psi)/a - ln V0 and a sigma by what it keeps
static double strength(double psi, double speed, double offset, double slope, double scale, double V0, double eta, double *direct)
{
  // ln(V/(2 V0)) + (f0 + b psi)/a, where offset is ln(V0/scale) - f0/a
  const double x = log(speed / (2 * V0)) + log(V0 / scale) - offset + slope * psi, small = exp(-fabs(x)), root = sqrt(1 + small * small);
  const double strength = scale * eta; // a sigma

  *direct = strength * (x > 0 ? 1 : small) / root;
  return strength * (x > 0 ? x + log(1 + root) : asinh(small));
}

// The largest dv/dtau of the balance
__kernel void fault_relaxation(int n, double V0, double eta, __global const double *cells, __global const double *state, __global const double *rate,
                               __global double *room)
{
  __local double all[ITEMS];
  double mine[1] = {0};

  for (int i = get_global_id(0); i < n; i += get_global_size(0)) {
    const double speed = fabs(rate[i]);
    double direct = 0, compliance;

    if (OF(SCALE) > 0 && speed > 0) {
      const double q = strength(state[3 * i + 2], speed, OF(OFFSET), OF(SLOPE), OF(SCALE), V0, eta, &direct);

      if (q > 10 * eta * OF(SCALE)) direct = eta * OF(SCALE); // as the processor has it
    }
    compliance = speed > 0 ? speed / (eta * speed + direct) : 0;
    mine[0] = larger(mine[0], compliance);
  }
  fold(1, 0, mine, all, room);
}

// Sums over the cells in the order of SlipFaultSumId, and the largest |v|
enum { V, ABS_V, V2, U, S, SLIDING, U_KU, V_KU, VINF_KU, VINF, U_T, LOADING_T, STRENGTH, WEAKENING, PUSH, NUM_SUMS };
__kernel void fault_sums(int n, double V0, double eta, int shears, __global const double *cells, __global const double *state, __global const double *force,
                         __global double *room)
{
  __local double all[ITEMS];
  double mine[NUM_SUMS + 1];

  for (int k = 0; k <= NUM_SUMS; k++) mine[k] = 0;
  for (int i = get_global_id(0); i < n; i += get_global_size(0)) {
    const double v = state[3 * i], u = state[3 * i + 1], psi = state[3 * i + 2], ku = force[i], vinf = OF(LOADING), speed = fabs(v);
    double direct, q = 0;

    if (speed > 0 && OF(SCALE) > 0) q = strength(psi, speed, OF(OFFSET), OF(SLOPE), OF(SCALE), V0, eta, &direct);
    mine[V] += v;
    mine[ABS_V] += speed;
    mine[V2] += v * v;
    mine[U] += u;
    mine[S] += psi;
    mine[SLIDING] += v != 0;
    mine[U_KU] += u * ku;
    mine[V_KU] += v * ku;
    mine[VINF_KU] += vinf * ku;
    mine[VINF] += vinf;
    if (shears) {
      mine[U_T] += u * OF(TRACTION);
      mine[LOADING_T] += vinf * OF(TRACTION);
    }
    mine[STRENGTH] += q;
    mine[WEAKENING] += q;
    mine[PUSH] += speed > 0 ? (v > 0 ? -ku : ku) - q : fmax(fabs(ku) - q, 0.0);
    mine[NUM_SUMS] = larger(mine[NUM_SUMS], speed);
  }
  fold(NUM_SUMS + 1, NUM_SUMS, mine, all, room);
}
