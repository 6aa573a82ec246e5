// Steps of TSADAMS, for src/device/vecsum.c, as in src/ts/adamssum.c. Each item has four entries, so that processors use vector code although their compilers cannot
// know that so many arrays do not overlap.

#define NODES 10
typedef struct {
  double of[4][NODES];
} Weights;

// Returns entries 4 i to 4 i + 3 of n, and 0 beyond n.
static double4 four(int i, int n, __global const double *x)
{
  const int k = 4 * i;

  return k + 3 < n ? vload4(i, x) : (double4)(x[k], k + 1 < n ? x[k + 1] : 0, k + 2 < n ? x[k + 2] : 0, 0);
}

static void put_four(int i, int n, double4 y, __global double *x)
{
  const int k = 4 * i;

  if (k + 3 < n)
    vstore4(y, i, x);
  else {
    x[k] = y.x;
    if (k + 1 < n) x[k + 1] = y.y;
    if (k + 2 < n) x[k + 2] = y.z;
  }
}

// The derivatives; arguments beyond the last one repeat it with weights of 0, so that there are no branches
#define RATES                                                                                                                              \
  __global const double *r0, __global const double *r1, __global const double *r2, __global const double *r3, __global const double *r4,   \
    __global const double *r5, __global const double *r6, __global const double *r7, __global const double *r8, __global const double *r9
#define LOAD_RATES(i, n)                                                                                                                   \
  const double4 d0 = four(i, n, r0), d1 = four(i, n, r1), d2 = four(i, n, r2), d3 = four(i, n, r3), d4 = four(i, n, r4),                  \
                d5 = four(i, n, r5), d6 = four(i, n, r6), d7 = four(i, n, r7), d8 = four(i, n, r8), d9 = four(i, n, r9)
#define WEIGHTED(w)                                                                                                                        \
  ((w)[0] * d0 + (w)[1] * d1 + (w)[2] * d2 + (w)[3] * d3 + (w)[4] * d4 + (w)[5] * d5 + (w)[6] * d6 + (w)[7] * d7 + (w)[8] * d8 + (w)[9] * d9)

static double sum_four(double4 x)
{
  return x.x + x.y + (x.z + x.w);
}

// Computes y = start + the sum of derivatives times weight 0, and the sum of y, which is NaN if an entry is.
__kernel void adams(int n, __global const double *start, RATES, Weights weights, __global double *y, __global double *room)
{
  __local double all[ITEMS];
  double4 sum = 0;
  double mine[1];

  EACH_ALONE(i, (n + 3) / 4) {
    LOAD_RATES(i, n);
    const double4 x = four(i, n, start) + WEIGHTED(weights.of[0]);

    put_four(i, n, x, y);
    sum += x;
  }
  mine[0] = sum_four(sum);
  fold(1, 1, mine, all, room);
}

// Returns |sum by weights| over its tolerance, and 0 where there is no tolerance.
static double4 share_of(double4 e, double4 x, double4 absolute, double4 relative)
{
  const double4 size = fabs(x), other = fabs(x + e), tolerance = absolute + relative * select(size, other, other > size);

  return select((double4)0, fabs(e) / tolerance, tolerance > 0);
}

// Returns the larger one; NaN counts as infinite.
static double4 larger_four(double4 a, double4 b)
{
  return select((double4)INFINITY, select(a, b, b > a), b == b);
}

static double largest_four(double4 x)
{
  return fmax(fmax(x.x, x.y), fmax(x.z, x.w));
}

// Does the same, and for three estimates, the sums by the other weights over their tolerances, computes the sums of squares, the numbers of
// entries with a tolerance, and the largest values.
__kernel void adams_norms(int n, __global const double *start, RATES, Weights weights, __global double *y, __global const double *absolute,
                          __global const double *relative, __global double *room)
{
  __local double all[ITEMS];
  double4 sum = 0, count = 0, s1 = 0, s2 = 0, s3 = 0, m1 = 0, m2 = 0, m3 = 0;

  EACH_ALONE(i, (n + 3) / 4) {
    LOAD_RATES(i, n);
    const double4 x = four(i, n, start) + WEIGHTED(weights.of[0]), a = four(i, n, absolute), r = four(i, n, relative), e1 = WEIGHTED(weights.of[1]);
    const double4 h1 = share_of(e1, x, a, r), h2 = share_of(WEIGHTED(weights.of[2]), x, a, r), h3 = share_of(WEIGHTED(weights.of[3]), x, a, r);
    const double4 size = fabs(x), other = fabs(x + e1);

    put_four(i, n, x, y);
    sum += x;
    count += select((double4)0, (double4)1, a + r * select(size, other, other > size) > 0);
    s1 += h1 * h1;
    s2 += h2 * h2;
    s3 += h3 * h3;
    m1 = larger_four(m1, h1);
    m2 = larger_four(m2, h2);
    m3 = larger_four(m3, h3);
  }
  double mine[8] = {sum_four(sum), sum_four(s1), sum_four(s2), sum_four(s3), sum_four(count), largest_four(m1), largest_four(m2), largest_four(m3)};
  fold(8, 5, mine, all, room);
}
