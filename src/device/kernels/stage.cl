// Stages of set-valued friction: the preconditioner on an endless plane, as in src/mat/grid/toeplitz_root.c, and what src/snes does cell by cell

// A field on a plane of 2 length rows, from row `first` on, zero elsewhere; with image even about both ends of its first length rows
__kernel void plane_pad(int nx, int nz, int width, int length, int first, int image, __global const double *u, __global double *pad)
{
  const int i = get_global_id(0), j = get_global_id(1), row = (j < length || !image ? j : 2 * length - 1 - j) - first;

  if (i < width) pad[(size_t)j * width + i] = i < nx && row >= 0 && row < nz ? u[(size_t)row * nx + i] : 0;
}

// Over f of S, values [length + 1][columns], which is even in both wavenumbers
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

// z = x where the mask is not 0, else y
__kernel void choose(int n, __global const double *mask, __global const double *x, __global const double *y, __global double *z)
{
  const int i = get_global_id(0);

  if (i < n) z[i] = mask[i] != 0 ? x[i] : y[i];
}

// y = B (m x) + slope x on the sliding set, x elsewhere
__kernel void stage_jacobian(int n, __global const double *mask, __global const double *slope, __global const double *x, __global const double *product,
                             __global double *y)
{
  const int i = get_global_id(0);

  if (i < n) y[i] = mask[i] != 0 ? product[i] + slope[i] * x[i] : x[i];
}
