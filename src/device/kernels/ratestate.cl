// A fault of rate and state

// What its cells keep, [n] each one behind the other
enum { OFFSET, SLOPE, INVERSE, SCALE, LOAD, SLIP, LOADING, TRACTION };
#define OF(what) cells[(what)*n + i]

// Exponential and logarithm of numbers without calls or branches, from which compilers make vector code on processors; as
// src/core/ratestate.c has them, to 2 ulp, and to 1e-5 where they are rough.
#define ROUNDER 6755399441055744.0 // 1.5 * 2^52
#define LN2_HIGH 6.93147180369123816490e-01
#define LN2_LOW 1.90821492927058770002e-10

static double exp_of(double x)
{
  double k, r, sum;

  x = x < -708 ? -708 : x;
  k = x * 1.44269504088896340736 + ROUNDER;
  r = x - (k - ROUNDER) * LN2_HIGH - (k - ROUNDER) * LN2_LOW;
  sum = 1 + r * (1.0 / 13);
  sum = 1 + r * (1.0 / 12) * sum;
  sum = 1 + r * (1.0 / 11) * sum;
  sum = 1 + r * (1.0 / 10) * sum;
  sum = 1 + r * (1.0 / 9) * sum;
  sum = 1 + r * (1.0 / 8) * sum;
  sum = 1 + r * (1.0 / 7) * sum;
  sum = 1 + r * (1.0 / 6) * sum;
  sum = 1 + r * (1.0 / 5) * sum;
  sum = 1 + r * (1.0 / 4) * sum;
  sum = 1 + r * (1.0 / 3) * sum;
  sum = 1 + r * (1.0 / 2) * sum;
  sum = 1 + r * sum;
  return sum * as_double((as_ulong(k) + 1023) << 52);
}

static double split(double x, double *exponent)
{
  const ulong sqrt_half = 0x3fe6a09e667f3bcdUL, bits = as_ulong(x), shift = (bits - sqrt_half + (2048UL << 52)) >> 52;

  *exponent = as_double(0x4330000000000000UL | shift) - (4503599627370496.0 + 2048);
  return as_double(bits - ((shift - 2048) << 52));
}

static double log_of(double x)
{
  double exponent, m = split(x, &exponent), s = (m - 1) / (m + 1), s2 = s * s, sum;

  sum = 1.0 / 21;
  sum = 1.0 / 19 + s2 * sum;
  sum = 1.0 / 17 + s2 * sum;
  sum = 1.0 / 15 + s2 * sum;
  sum = 1.0 / 13 + s2 * sum;
  sum = 1.0 / 11 + s2 * sum;
  sum = 1.0 / 9 + s2 * sum;
  sum = 1.0 / 7 + s2 * sum;
  sum = 1.0 / 5 + s2 * sum;
  sum = 1.0 / 3 + s2 * sum;
  return exponent * LN2_LOW + (2 * s * s2 * sum + (2 * s + exponent * LN2_HIGH));
}

static double rough_exp(double x)
{
  double k, r;

  x = x < -708 ? -708 : x;
  k = x * 1.44269504088896340736 + ROUNDER;
  r = x - (k - ROUNDER) * (LN2_HIGH + LN2_LOW);
  return as_double((as_ulong(k) + 1023) << 52) * (1 + r * (1 + r * (1.0 / 2 + r * (1.0 / 6 + r * (1.0 / 24 + r * (1.0 / 120))))));
}

static double rough_log(double x)
{
  double exponent, t = split(x, &exponent) - 1;

  return exponent * (LN2_HIGH + LN2_LOW) + t * (0.99991888 + t * (-0.49923359 + t * (0.33734499 + t * (-0.27349856 + t * 0.1751314))));
}

// w of w + ln w = L, Lambert's W(e^L), L >= -708, and 1/(1 + w)
static double lambert_of_exp(double L, double *inverse)
{
  const double x = rough_exp(L > 20 ? 20 : L), more = rough_log(1 + x), p = L > 20 ? L : (x < 1e-3 ? x : more);
  const double guess = p * (1 - rough_log(1 + p) / (2 + p)), z = L - rough_log(guess) - guess;
  const double q = 2 * (1 + guess) * (1 + guess + 2.0 / 3 * z), w = guess * (1 + z * (q - z) / ((1 + guess) * (q - 2 * z))), near = 1 / (1 + w);
  const double a = near * (L - log_of(w) - w), r = 0.5 * a * near * (1 - 2.0 / 3 * a), solution = w * (1 + a * (1 + r * (1 + 2 * r)));

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

// What no rate is marks cells for which the closed form does not hold, whose branches are in a kernel of their own.
#define LEAST_LOG (-700.0)
#define MARK DBL_MAX

// The slip rates of a state; force is K u
__kernel void fault_rates(int n, __global const double *restrict cells, __global const double *restrict state, __global const double *restrict force,
                          __global double *restrict rate)
{
  const int i = get_global_id(0);

  if (i < n) {
    const double tau = OF(LOAD) - force[i], load = fabs(tau) * OF(INVERSE), L = load + OF(OFFSET) - OF(SLOPE) * state[3 * i + 2];
    double near;
    const double w = lambert_of_exp(L > LEAST_LOG ? L : LEAST_LOG, &near), y = load - w, tail = rough_exp(y > 10 ? -2 * y : -20);
    const double speed = w * OF(SCALE) * (1 + w * tail * near) * (1 - tail), v = tau < 0 ? -speed : speed;

    rate[i] = (y > 10) & (L > LEAST_LOG) & (OF(SCALE) > 0) ? v : MARK;
  }
}

// Those of the cells that are marked
__kernel void fault_others(int n, double eta, __global const double *restrict cells, __global const double *restrict state,
                           __global const double *restrict force, __global double *restrict rate)
{
  const int i = get_global_id(0);

  if (i < n && rate[i] == MARK) {
    const double tau = OF(LOAD) - force[i], psi = state[3 * i + 2];
    const double speed = OF(SCALE) > 0 ? rate_by_newton(fabs(tau) * OF(INVERSE), M_LN2 + OF(OFFSET) - OF(SLOPE) * psi, OF(SCALE)) : fabs(tau) / eta;

    rate[i] = tau < 0 ? -speed : speed;
  }
}

// The derivative of a state, of its slip rates
__kernel void fault_derivative(int n, int slip_law, double V0, __global const double *restrict cells, __global const double *restrict state,
                               __global const double *restrict rate, __global double *restrict f)
{
  const int i = get_global_id(0);

  if (i < n) {
    const double psi = state[3 * i + 2], v = rate[i], speed = fabs(v);
    double ds;

    if (slip_law)
      ds = -speed / OF(SLIP) * (log_of((speed > 1e-300 ? speed : 1e-300) / V0) + psi);
    else
      ds = (V0 * exp_of(-psi < 200 ? -psi : 200) - speed) / OF(SLIP);
    f[3 * i] = 0;
    f[3 * i + 1] = v - OF(LOADING);
    f[3 * i + 2] = ds;
  }
}

// How many displacements and states are out of bounds, or no numbers
__kernel void fault_outside(int n, double displacement, double bound, __global const double *state, __global double *room)
{
  __local double all[ITEMS];
  double mine[1] = {0};

  EACH(i, n)
    mine[0] += (double)!(fabs(state[3 * i + 1]) < displacement) + (double)!(fabs(state[3 * i + 2]) < bound);
  fold(1, 1, mine, all, room);
}

// mu and V dmu/dV of a cell, (f0 + b psi)/a - ln V0 and a sigma by what it keeps
static double strength(double psi, double speed, double offset, double slope, double scale, double eta, double *direct)
{
  // ln(V/(2 V0)) + (f0 + b psi)/a, as offset is ln(V0/scale) - f0/a
  const double x = log_of(speed / (2 * scale)) - offset + slope * psi, small = exp_of(-fabs(x)), root = sqrt(1 + small * small);
  const double strength = scale * eta; // a sigma

  *direct = strength * (x > 0 ? 1 : small) / root;
  // asinh(e^x) = x + ln(1 + sqrt(1 + e^-2x)), and ln(small + root) with small = e^x below
  return strength * ((x > 0 ? x : 0) + log_of((x > 0 ? 1 : small) + root));
}

// The largest dv/dtau of the balance
__kernel void fault_relaxation(int n, double eta, __global const double *cells, __global const double *state, __global const double *rate,
                               __global double *room)
{
  __local double all[ITEMS];
  double mine[1] = {0};

  EACH(i, n) {
    const double speed = fabs(rate[i]);
    const bool slides = (OF(SCALE) > 0) & (speed > 0);
    const double scale = slides ? OF(SCALE) : 1;
    double direct;
    const double q = strength(state[3 * i + 2], slides ? speed : 1, OF(OFFSET), OF(SLOPE), scale, eta, &direct);
    const double growth = slides ? (q > 10 * eta * scale ? eta * scale : direct) : 0; // far from 0 as the processor has it

    mine[0] = larger(mine[0], speed > 0 ? speed / (eta * speed + growth) : 0);
  }
  fold(1, 0, mine, all, room);
}

// Sums over the cells in the order of SlipFaultSumId, and the largest |v|
enum { V, ABS_V, V2, U, S, SLIDING, U_KU, V_KU, VINF_KU, VINF, U_T, LOADING_T, STRENGTH, WEAKENING, PUSH, NUM_SUMS };
__kernel void fault_sums(int n, double eta, int shears, __global const double *cells, __global const double *state, __global const double *force,
                         __global double *room)
{
  __local double all[ITEMS];
  double mine[NUM_SUMS + 1];

  for (int k = 0; k <= NUM_SUMS; k++) mine[k] = 0;
  EACH(i, n) {
    const double v = state[3 * i], u = state[3 * i + 1], psi = state[3 * i + 2], ku = force[i], vinf = OF(LOADING), speed = fabs(v);
    double direct, q = 0;

    if (speed > 0 && OF(SCALE) > 0) q = strength(psi, speed, OF(OFFSET), OF(SLOPE), OF(SCALE), eta, &direct);
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

// Of a state: what radiation damping takes of the slip rate relative to the far field, what the far field puts into that, and what friction takes
__kernel void fault_powers(int n, double eta, __global const double *cells, __global const double *state, __global double *room)
{
  __local double all[ITEMS];
  double mine[3] = {0, 0, 0};

  EACH(i, n) {
    const double v = state[3 * i], speed = fabs(v), vinf = OF(LOADING), relative = v - vinf;
    const bool slides = (OF(SCALE) > 0) & (speed > 0);
    double direct;
    const double q = strength(state[3 * i + 2], slides ? speed : 1, OF(OFFSET), OF(SLOPE), slides ? OF(SCALE) : 1, eta, &direct);

    mine[0] += relative * eta * relative;
    mine[1] += vinf * eta * relative;
    mine[2] += slides ? speed * q : 0;
  }
  fold(3, 3, mine, all, room);
}

// The largest slip since displacements were u, a time dt ago
__kernel void fault_slip(int n, double dt, __global const double *cells, __global const double *state, __global const double *u, __global double *room)
{
  __local double all[ITEMS];
  double mine[1] = {0};

  EACH(i, n) {
    mine[0] = larger(mine[0], fabs(state[3 * i + 1] - u[i] + OF(LOADING) * dt));
  }
  fold(1, 0, mine, all, room);
}
