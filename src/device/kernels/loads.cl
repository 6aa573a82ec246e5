// Loads of a fault with rate-and-state friction that change with time, as in src/fault/loads/loads.c and coupling.c

// Returns the exponential integral E1(x), x > 0, as SlipExponentialIntegral() does.
static double exponential_integral(double x)
{
  double sum, term = 1;

  if (x > 700) return 0;
  if (x > 1) return SlipExponentialFraction(x) * exp(-x);
  sum = -log(x) - 0.57721566490153286061;
  for (int k = 1; k < 40; k++) {
    term *= -x / k;
    sum -= term / k;
  }
  return sum;
}

// Computes pore pressures: the present values if `own` is not 0, plus those between two rows of a record, and those of a source that began a
// time `open` ago and may have stopped a time `shut` ago (both are multiplied by 4 D).
__kernel void fault_pressure(int n, int own, int recorded, long row, double share, __global const double *record, double scale, double open,
                             double shut, __global const double *distance2, __global double *pressure)
{
  const int i = get_global_id(0);
  double p = 0;

  if (i >= n) return;
  if (recorded) {
    const long at = row * n + i;

    p += (1 - share) * record[at] + share * record[share > 0 ? at + n : at];
  }
  if (open > 0) p += scale * exponential_integral(distance2[i] / open);
  if (shut > 0) p -= scale * exponential_integral(distance2[i] / shut);
  pressure[i] = own ? p + pressure[i] : p;
}

// Computes w (T0 + t dT/dt), t since `origin`, along the rake of each cell, for c components.
__kernel void fault_shear(int n, int c, int grows, double origin, double t, __global const double *cells, __global double *shear)
{
  const int i = get_global_id(0);

  if (i < n) {
    const double growth = grows ? OF(GROWTH) : 0, load = OF(WEIGHT) * (OF(TRACTION) + origin * growth + t * growth);

    for (int k = 0; k < c; k++) shear[c * i + k] = load * ALONG_OF(k);
  }
}

// Computes the load, with the far field, that friction and radiation damping balance if slip has no stress.
__kernel void fault_load(int n, int c, int shears, int grows, double origin, double t, double eta, __global double *cells)
{
  const int i = get_global_id(0);

  if (i < n) {
    const double growth = grows ? OF(GROWTH) : 0, shear = shears ? OF(WEIGHT) * (OF(TRACTION) + origin * growth + t * growth) : 0;
    const double load = shear + eta * OF(WEIGHT) * OF(LOADING);

    OF(LOAD) = load * ALONG_OF(0);
    if (c > 1) OF(LOAD_UP) = load * OF(ALONG_UP);
  }
}

// Computes the law's stored numbers under the normal stress less pressure, if pressed is not 0, and its change by slip, if coupled is not 0.
__kernel void fault_strength(int n, double eta, double V0, int pressed, int coupled, __global const double *pressure, __global const double *rise,
                             __global double *cells)
{
  const int i = get_global_id(0);

  if (i < n) {
    const double bare = OF(NORMAL) - (pressed ? pressure[i] : 0) + (coupled ? rise[i] : 0), stress = bare > 0 ? bare : 0;
    const double strength = OF(DIRECT) * stress, inverse = 1 / (strength > 0 ? strength : 1), follow = OF(FOLLOW);

    OF(STRESS) = stress;
    OF(SCALE) = strength / eta;
    OF(OFFSET) = SlipLog(eta * V0 * inverse) - OF(REFERENCE);
    OF(INVERSE) = inverse / OF(WEIGHT);
    OF(SHIFT) = follow > 0 ? follow * SlipLog(fmax(stress / OF(NORMAL), 1e-12)) : 0;
  }
}

// Counts cells whose pressure exceeds their normal stress.
__kernel void fault_open(int n, __global const double *cells, __global const double *pressure, __global double *room)
{
  __local double all[ITEMS];
  double mine[1] = {0};

  EACH(i, n) { mine[0] += !(OF(NORMAL) - pressure[i] > 0); }
  fold(1, 1, mine, all, room);
}

// Counts cells that have lost their normal stress, except where bare is not 0, and finds the least normal stress times -1.
__kernel void fault_bare(int n, __global const double *cells, __global const double *bare, __global double *room)
{
  __local double all[ITEMS];
  double mine[2] = {0, -INFINITY};

  EACH(i, n) {
    mine[0] += (OF(STRESS) <= 0) & (bare[i] == 0);
    mine[1] = fmax(mine[1], -OF(STRESS));
  }
  fold(2, 1, mine, all, room);
}
