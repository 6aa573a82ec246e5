// Products of a grid's block per wavenumber along strike, as in src/mat/grid/blocks_device.c. Fields have rows of `width` numbers, twice as
// many as wavenumbers; a block's number is stored for all wavenumbers one after the other.

// Pads fields with zeros beyond the grid. Field c of cell i is u[step * i + c], times its share [field][cell] if there is one. Each row of each
// field is a row of the launch.
__kernel void blocks_pad(int nx, int nz, int width, int step, int shared, __global const double *share, __global const double *u,
                         __global double *pad)
{
  const int i = get_global_id(0), row = get_global_id(1), c = row / nz, cell = row % nz * nx + i;

  if (i >= width) return;
  pad[(size_t)row * width + i] = i < nx ? (shared ? share[(size_t)c * nx * nz + cell] * u[cell] : u[(size_t)step * cell + c]) : 0;
}

// Computes y = A x at each wavenumber for four rows of A [m columns][rows], or of half a symmetric A: row a from column a on. Rows of x after
// the first nz are multiplied by the imaginary unit, and rows of y from `turned` on are divided by it. Transforms of reals are real at the
// first and at the last wavenumber.
__kernel void blocks_product(int waves, int rows, int m, int symmetric, int nz, int turned, __global const double *A, __global const double2 *x,
                             __global double2 *y)
{
  const int i = get_global_id(0), first = 4 * get_global_id(1);
  double2 sum[4] = {0, 0, 0, 0};

  if (i >= waves) return;
  for (int b = 0; b < m; b++) {
    const double2 f = x[(size_t)b * waves + i], v = b < nz ? f : (double2)(-f.y, f.x);

    for (int k = 0; k < 4; k++) {
      const int a = min(first + k, rows - 1), low = min(a, b), high = max(a, b);
      const size_t at = symmetric ? (size_t)low * m - (size_t)low * (low + 1) / 2 + high : (size_t)b * rows + a;

      sum[k] += A[at * waves + i] * v;
    }
  }
  for (int k = 0; k < 4 && first + k < rows; k++) {
    double2 s = first + k < turned ? sum[k] : (double2)(sum[k].y, -sum[k].x);

    if (i == 0 || i == waves - 1) s.y = 0;
    y[(size_t)(first + k) * waves + i] = s;
  }
}

// Does the reverse: y[step * i + c] is field c of cell i, or y[i] is the sum over `fields` of them times their shares.
__kernel void blocks_take(int nx, int nz, int width, int step, int fields, double scale, int shared, __global const double *share,
                          __global const double *pad, __global double *y)
{
  const int i = get_global_id(0), j = get_global_id(1), cell = j * nx + i;
  const size_t at = (size_t)j * width + i, next = (size_t)nz * width;
  double sum = 0;

  if (i >= nx) return;
  for (int c = 0; c < fields; c++) {
    if (shared)
      sum += share[(size_t)c * nx * nz + cell] * pad[at + c * next];
    else
      y[(size_t)step * cell + c] = scale * pad[at + c * next];
  }
  if (shared) y[cell] = scale * sum;
}
