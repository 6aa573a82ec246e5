// The stiffness of a uniform grid, as in src/mat/grid/toeplitz.c

// Pads the fields u and z u with zeros beyond the grid, in rows of `width` numbers, with height rows per field.
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

// Computes in place, for pairs (k, -k) of wavenumbers in depth, u(k) = T u(k) + A(k) u(-k) and, for the second field, q(k) (z u)(-k). T, A and
// q are [height/2 + 1][columns]; without hankel A is 0.
__kernel void grid_symbol(int columns, int height, int fields, int hankel, __global const double *T, __global const double2 *A, __global const double2 *Q,
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
  if (!hankel) {
    pad[at] = t * a;
    if (other != at) pad[other] = t * b;
    return;
  }
  s = A[at];
  pad[at] = (double2)(t * a.x + s.x * b.x - s.y * b.y, t * a.y + s.x * b.y + s.y * b.x);
  if (other != at) pad[other] = (double2)(t * b.x + s.x * a.x + s.y * a.y, t * b.y + s.x * a.y - s.y * a.x);
  if (fields == 1) return;
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
