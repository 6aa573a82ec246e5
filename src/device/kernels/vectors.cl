// Operations on vectors

__kernel void set(int n, double a, __global double *x)
{
  const int i = get_global_id(0);

  if (i < n) x[i] = a;
}

__kernel void shift(int n, double a, __global double *x)
{
  const int i = get_global_id(0);

  if (i < n) x[i] += a;
}

// Computes y = c z + the sum of m terms a x; z may be y, and is not read if c is 0.
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

// Divides x by y; z is 0 where y is 0, as with PETSc.
__kernel void divide(int n, __global const double *x, __global const double *y, __global double *z)
{
  const int i = get_global_id(0);

  if (i < n) z[i] = y[i] != 0 ? x[i] / y[i] : 0;
}

// Computes a / x of entries that are not 0, as PETSc does for a = 1.
__kernel void reciprocal(int n, double a, __global double *x)
{
  const int i = get_global_id(0);

  if (i < n) x[i] = x[i] != 0 ? a / x[i] : 0;
}

// Copies entries start, start + step, ... of x to y; scatter() copies them back.
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

  EACH(i, n) { mine[0] += x[i] * y[i]; }
  fold(1, 1, mine, all, room);
}

// Computes the sums of x, |x| and x^2, and the largest |x|.
__kernel void norms(int n, __global const double *x, __global double *room)
{
  __local double all[ITEMS];
  double mine[4] = {0, 0, 0, 0};

  EACH(i, n) {
    const double size = fabs(x[i]);

    mine[0] += x[i];
    mine[1] += size;
    mine[2] += size * size;
    mine[3] = larger(mine[3], size);
  }
  fold(4, 3, mine, all, room);
}

// Finds the largest magnitude of the first c numbers of blocks.
__kernel void largest(int n, double c, double block, __global const double *x, __global double *room)
{
  __local double all[ITEMS];
  double mine[1] = {0};

  EACH(i, n)
  {
    __global const double *v = x + (size_t)i * (int)block;

    mine[0] = larger(mine[0], c == 1 ? fabs(v[0]) : hypot(v[0], v[1]));
  }
  fold(1, 0, mine, all, room);
}

// Finds the largest -x.
__kernel void least(int n, __global const double *x, __global double *room)
{
  __local double all[ITEMS];
  double mine[1] = {-INFINITY};

  EACH(i, n) { mine[0] = larger(mine[0], -x[i]); }
  fold(1, 0, mine, all, room);
}

// Counts the entries that differ.
__kernel void differ(int n, __global const double *x, __global const double *y, __global double *room)
{
  __local double all[ITEMS];
  double mine[1] = {0};

  EACH(i, n) { mine[0] += x[i] != y[i]; }
  fold(1, 1, mine, all, room);
}
