// A fault with rate-and-state friction, whose slip has c = 1 or 2 components

// The stored numbers of cells, [n] each, one after the other: of the law, with psi = s - SHIFT; of the load; and, if these change, the numbers
// from which they follow. With two components ALONG is the unit vector of loading.
enum { OFFSET, SLOPE, INVERSE, SCALE, LOAD, SLIP, LOADING, TRACTION, WEIGHT, CREEP, SHIFT };
enum { LOAD_UP = 11, ALONG, ALONG_UP, GROWTH = 14, DIRECT, REFERENCE, FOLLOW, NORMAL, STRESS };
#define OF(what) cells[(what)*n + i]

// Entries of cell i of a state, and vectors of slip of one cell
#define RATE(k) state[(2 * c + 1) * i + (k)]
#define DISPLACEMENT(k) state[(2 * c + 1) * i + c + (k)]
#define STATE state[(2 * c + 1) * i + 2 * c]
#define ALONG_OF(k) (c == 1 ? 1.0 : OF(ALONG + (k)))

static double size_of(int c, double x, double y)
{
  return c == 1 ? fabs(x) : hypot(x, y);
}

static double log_sinh(double y)
{
  return y > 20 ? y - M_LN2 : log(sinh(y));
}

// Solves y + c sinh y = load, y = mu/a, where the closed form does not hold, by Newton's method from above, where it is monotone, with ln c.
static double rate_by_newton(double load, double log_c, double scale)
{
  double z = log(load) - log_c, y = fmin(load, z > 20 ? z + M_LN2 : asinh(exp(z)));

  if (load == 0) return 0;
  if (z < -600) return scale * load; // the strength is negligible
  for (int k = 0; k < 100; k++) {
    const double s = exp(log_c + log_sinh(y)), change = (y + s - load) / (1 + (y > 20 ? s : s / tanh(y)));

    y -= change;
    if (!(change > 4e-16 * y)) break;
  }
  return scale * exp(log_c + log_sinh(y));
}

// Cells for which the closed form does not hold are marked; a kernel of its own has their branches.
#define MARK SLIP_NO_RATE

// Computes the slip rates of a state; force is K u.
__kernel void fault_rates(int n, __global const double *restrict cells, __global const double *restrict state, __global const double *restrict force,
                          __global double *restrict rate)
{
  const int i = get_global_id(0);

  if (i < n) {
    const double tau = OF(LOAD) - force[i], load = fabs(tau) * OF(INVERSE);
    const double speed = SlipBalanceRate(load, load + OF(OFFSET) - OF(SLOPE) * (state[3 * i + 2] - OF(SHIFT)), OF(SCALE), SLIP_LEAST_LOG);
    const double v = (tau < 0) & (speed != MARK) ? -speed : speed;

    rate[i] = OF(CREEP) > 0 ? OF(LOADING) : v;
  }
}

// Computes slip rates of two components, along the stress.
__kernel void fault_rates_2(int n, __global const double *restrict cells, __global const double *restrict state,
                            __global const double *restrict force, __global double *restrict rate)
{
  const int i = get_global_id(0);

  if (i < n) {
    const double x = OF(LOAD) - force[2 * i], y = OF(LOAD_UP) - force[2 * i + 1], size = sqrt(x * x + y * y), load = size * OF(INVERSE);
    const double speed = SlipBalanceRate(load, load + OF(OFFSET) - OF(SLOPE) * (state[5 * i + 4] - OF(SHIFT)), OF(SCALE), SLIP_LEAST_LOG);
    const double share = size > 0 ? speed / size : 0, creeps = OF(CREEP), v = creeps * OF(LOADING);

    rate[2 * i] = creeps > 0 ? v * OF(ALONG) : speed == MARK ? MARK : share * x;
    rate[2 * i + 1] = creeps > 0 ? v * OF(ALONG_UP) : share * y;
  }
}

// Computes the slip rates of the marked cells.
__kernel void fault_others(int n, int c, double eta, __global const double *restrict cells, __global const double *restrict state,
                           __global const double *restrict force, __global double *restrict rate)
{
  const int i = get_global_id(0);

  if (i < n && rate[c * i] == MARK) {
    const double x = OF(LOAD) - force[c * i], y = c == 1 ? 0 : OF(LOAD_UP) - force[c * i + 1], size = size_of(c, x, y), psi = STATE - OF(SHIFT);
    const double speed =
      OF(SCALE) > 0 ? rate_by_newton(size * OF(INVERSE), M_LN2 + OF(OFFSET) - OF(SLOPE) * psi, OF(SCALE)) : size / (eta * OF(WEIGHT));

    rate[c * i] = c == 1 ? (x < 0 ? -speed : speed) : (size > 0 ? speed * (x / size) : 0);
    if (c > 1) rate[c * i + 1] = size > 0 ? speed * (y / size) : 0;
  }
}

enum { AGING, SLIP_LAW, COMPOSITE, PRZ }; // SlipStateLaw of slipcore.h

static double state_rate(int state_law, double V0, double cutoff, double length, double psi, double speed)
{
  if (state_law == PRZ) return SlipPrzRate(V0, length, psi, speed);
  if (state_law == COMPOSITE) return SlipCompositeRate(V0, 1 / cutoff, length, psi, speed);
  return state_law == SLIP_LAW ? SlipSlipLawRate(1 / V0, length, psi, speed) : SlipAgingRate(V0, length, psi, speed);
}

// Computes the derivative of a state from its slip rates.
__kernel void fault_derivative(int n, int state_law, double V0, double cutoff, __global const double *restrict cells,
                               __global const double *restrict state, __global const double *restrict rate, __global double *restrict f)
{
  const int i = get_global_id(0);

  if (i < n) {
    const double v = rate[i], ds = state_rate(state_law, V0, cutoff, OF(SLIP), state[3 * i + 2] - OF(SHIFT), fabs(v));

    f[3 * i] = 0;
    f[3 * i + 1] = v - OF(LOADING);
    f[3 * i + 2] = OF(CREEP) > 0 ? 0 : ds;
  }
}

__kernel void fault_derivative_2(int n, int state_law, double V0, double cutoff, __global const double *restrict cells,
                                 __global const double *restrict state, __global const double *restrict rate, __global double *restrict f)
{
  const int i = get_global_id(0);

  if (i < n) {
    const double x = rate[2 * i], y = rate[2 * i + 1];
    const double ds = state_rate(state_law, V0, cutoff, OF(SLIP), state[5 * i + 4] - OF(SHIFT), hypot(x, y));

    f[5 * i] = f[5 * i + 1] = 0;
    f[5 * i + 2] = x - OF(LOADING) * OF(ALONG);
    f[5 * i + 3] = y - OF(LOADING) * OF(ALONG_UP);
    f[5 * i + 4] = OF(CREEP) > 0 ? 0 : ds;
  }
}

// Counts displacements and states that are out of bounds or NaN.
__kernel void fault_outside(int n, int c, double displacement, double bound, __global const double *state, __global double *room)
{
  __local double all[ITEMS];
  double mine[1] = {0};

  EACH(i, n) {
    for (int k = 0; k < c; k++) mine[0] += (double)!(fabs(DISPLACEMENT(k)) < displacement);
    mine[0] += (double)!(fabs(STATE) < bound);
  }
  fold(1, 1, mine, all, room);
}

// Returns mu sigma and V dmu/dV sigma of a cell from its stored ln(V0/scale) - f0/a, b/a and a sigma/eta.
static double strength(double psi, double speed, double offset, double slope, double scale, double eta, double *direct)
{
  // ln(V/(2 V0)) + (f0 + b psi)/a, as offset is ln(V0/scale) - f0/a
  const double x = SlipLog(speed / (2 * scale)) - offset + slope * psi, small = SlipExp(-fabs(x)), root = sqrt(1 + small * small);
  const double strength = scale * eta; // a sigma

  *direct = strength * (x > 0 ? 1 : small) / root;
  // asinh(e^x) = x + ln(1 + sqrt(1 + e^-2x)), and ln(small + root) with small = e^x below
  return strength * ((x > 0 ? x : 0) + SlipLog((x > 0 ? 1 : small) + root));
}

// Returns the strength of cell i, and 0 if it does not slide.
static double strength_of(int n, int i, double eta, __global const double *cells, double s, double speed, double *direct)
{
  const bool slides = (OF(SCALE) > 0) & (speed > 0);
  const double q = strength(s - OF(SHIFT), slides ? speed : 1, OF(OFFSET), OF(SLOPE), slides ? OF(SCALE) : 1, eta, direct);

  *direct = slides ? *direct : 0;
  return slides ? q : 0;
}

// Finds the largest dv/dtau of the balance.
__kernel void fault_relaxation(int n, int c, double eta, __global const double *cells, __global const double *state, __global const double *rate,
                               __global double *room)
{
  __local double all[ITEMS];
  double mine[1] = {0};

  EACH(i, n) {
    const double speed = size_of(c, rate[c * i], c == 1 ? 0 : rate[c * i + 1]), most = eta * OF(SCALE); // a sigma
    double direct;
    const double q = strength_of(n, i, eta, cells, STATE, speed, &direct);
    const double growth = q > 10 * most ? most : direct; // bounded away from 0, as on the processor

    mine[0] = larger(mine[0], (speed > 0) & !(OF(CREEP) > 0) ? speed / (eta * speed + growth) : 0);
  }
  fold(1, 0, mine, all, room);
}

// Sums over the cells in the order of SlipFaultSumId, and the largest |v|; since: time for which the shear load has grown, if it grows
enum { V, ABS_V, V2, U, S, SLIDING, U_KU, V_KU, VINF_KU, VINF, U_T, LOADING_T, STRENGTH, WEAKENING, PUSH, NUM_SUMS };
__kernel void fault_sums(int n, int c, double eta, int shears, int grows, double since, __global const double *cells, __global const double *state,
                         __global const double *force, __global double *room)
{
  __local double all[ITEMS];
  double mine[NUM_SUMS + 1];

  for (int k = 0; k <= NUM_SUMS; k++) mine[k] = 0;
  EACH(i, n) {
    const double x = RATE(0), y = c == 1 ? 0 : RATE(1), ux = DISPLACEMENT(0), uy = c == 1 ? 0 : DISPLACEMENT(1);
    const double fx = force[c * i], fy = c == 1 ? 0 : force[c * i + 1], ax = ALONG_OF(0), ay = c == 1 ? 0 : OF(ALONG_UP);
    const double s = STATE, vinf = OF(LOADING), speed = size_of(c, x, y), weight = OF(WEIGHT), u = ux * ax + uy * ay, push = x * fx + y * fy;
    double direct;
    const double q = weight * strength_of(n, i, eta, cells, s, speed, &direct);

    mine[V] += weight * (x * ax + y * ay);
    mine[ABS_V] += weight * speed;
    mine[V2] += weight * (x * x + y * y);
    mine[U] += weight * u;
    mine[S] += weight * s;
    mine[SLIDING] += speed != 0 ? weight : 0;
    mine[U_KU] += ux * fx + uy * fy;
    mine[V_KU] += push;
    mine[VINF_KU] += vinf * (ax * fx + ay * fy);
    mine[VINF] += weight * vinf;
    if (shears) {
      const double growth = grows ? OF(GROWTH) : 0, shear = OF(TRACTION) + since * growth;

      mine[U_T] += weight * u * shear;
      mine[LOADING_T] += weight * (vinf * shear - u * growth);
    }
    mine[STRENGTH] += q;
    mine[WEAKENING] += q;
    mine[PUSH] += speed > 0 ? -push / speed - q : fmax(size_of(c, fx, fy) - q, 0.0);
    mine[NUM_SUMS] = larger(mine[NUM_SUMS], speed);
  }
  fold(NUM_SUMS + 1, NUM_SUMS, mine, all, room);
}

// Computes a state's power of radiation damping for the slip rate relative to the far field, of the far field, and of friction.
__kernel void fault_powers(int n, int c, double eta, __global const double *cells, __global const double *state, __global double *room)
{
  __local double all[ITEMS];
  double mine[3] = {0, 0, 0};

  EACH(i, n) {
    const double x = RATE(0), y = c == 1 ? 0 : RATE(1), vinf = OF(LOADING), ax = ALONG_OF(0), ay = c == 1 ? 0 : OF(ALONG_UP);
    const double dx = x - vinf * ax, dy = y - vinf * ay, speed = size_of(c, x, y), damping = eta * OF(WEIGHT);
    double direct;
    const double q = strength_of(n, i, eta, cells, STATE, speed, &direct);

    mine[0] += damping * (dx * dx + dy * dy);
    mine[1] += damping * vinf * (ax * dx + ay * dy);
    mine[2] += OF(WEIGHT) * speed * q;
  }
  fold(3, 3, mine, all, room);
}

// Computes for one of several faults the power of friction, and the sums of slip rate, displacement and loading along the rake.
__kernel void fault_share(int n, int c, int which, double eta, __global const double *faults, __global const double *cells,
                          __global const double *state, __global double *room)
{
  __local double all[ITEMS];
  double mine[4] = {0, 0, 0, 0};

  EACH(i, n) {
    const double x = RATE(0), y = c == 1 ? 0 : RATE(1), speed = size_of(c, x, y), weight = faults[i] == which ? OF(WEIGHT) : 0;
    const double ax = ALONG_OF(0), ay = c == 1 ? 0 : OF(ALONG_UP);
    double direct;

    mine[0] += weight * speed * strength_of(n, i, eta, cells, STATE, speed, &direct);
    mine[1] += weight * (x * ax + y * ay);
    mine[2] += weight * (DISPLACEMENT(0) * ax + (c == 1 ? 0 : DISPLACEMENT(1) * ay));
    mine[3] += weight * OF(LOADING);
  }
  fold(4, 4, mine, all, room);
}

// Finds the largest slip since displacements were u, a time dt ago.
__kernel void fault_slip(int n, int c, double dt, __global const double *cells, __global const double *state, __global const double *u,
                         __global double *room)
{
  __local double all[ITEMS];
  double mine[1] = {0};

  EACH(i, n) {
    const double x = DISPLACEMENT(0) - u[c * i] + OF(LOADING) * ALONG_OF(0) * dt;
    const double y = c == 1 ? 0 : DISPLACEMENT(1) - u[c * i + 1] + OF(LOADING) * OF(ALONG_UP) * dt;

    mine[0] = larger(mine[0], size_of(c, x, y));
  }
  fold(1, 0, mine, all, room);
}
