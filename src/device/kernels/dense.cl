// Products with a dense matrix [n][m], whose column is m numbers one after the other, as in src/mat/common/matdevice.c

// Computes for each row the sums over so many groups of columns, one beside the other.
__kernel void dense_parts(int m, int n, int groups, __global const double *A, __global const double *x, __global double *parts)
{
  const int i = get_global_id(0), group = get_global_id(1), row = min(i, m - 1), each = (n + groups - 1) / groups;
  const int start = min(group * each, n), end = min(start + each, n);
  double sum = 0;

  for (int j = start; j < end; j++) sum += A[(size_t)j * m + row] * x[j];
  if (i < m) parts[(size_t)group * m + i] = sum;
}

__kernel void dense_sum(int m, int groups, __global const double *parts, __global double *y)
{
  const int i = get_global_id(0);
  double sum = 0;

  if (i >= m) return;
  for (int g = 0; g < groups; g++) sum += parts[(size_t)g * m + i];
  y[i] = sum;
}
