// Products with a hierarchical matrix, as in src/mat/hmatrix/hdevice.c. Its numbers are in up to four arrays, in either precision; all
// arithmetic is in double precision. v has x in the order of the clusters, then the products of panels' columns, and sums over parts of
// their rows.

// at: place of the first number, in numbers of its precision; kind: 2 times the array, plus 1 for single precision
typedef struct {
  long at;
  int kind, stride, rows, columns, x, t;
} Dots;

// kind: as above; -1: t itself, row by row
typedef struct {
  long at;
  int kind, stride, columns, t;
} Sums;

// Rows of y from `row` on, which begin `first` rows after the first row of their leaf; the leaf has the items start to end
typedef struct {
  int row, rows, first, start, end, unused;
} Chunk;

#define ARRAYS __global const double *d0, __global const double *d1, __global const double *d2, __global const double *d3
#define ARRAY(kind) ((kind) < 2 ? d0 : (kind) < 4 ? d1 : (kind) < 6 ? d2 : d3)
#define LANES 32
#define ACROSS (ITEMS / LANES)
#define EACH_TURN 4
#define BATCH (ACROSS * EACH_TURN)

__kernel void hmat_order(int n, __global const int *from, __global const double *x, __global double *v)
{
  const int i = get_global_id(0);

  if (i < n) v[i] = x[from[i]];
}

// Computes the products of a panel's columns with x, one group per panel: 32 items share the rows, four times as many the columns.
__kernel void hmat_dots(int n, __global const Dots *panels, ARRAYS, __global double *v)
{
  __local double all[BATCH][LANES + 1], part[BATCH][9];
  const int id = get_local_id(0), lane = id % LANES, across = id / LANES;
  const Dots p = panels[get_group_id(0)];
  __global const double *a = ARRAY(p.kind) + (p.kind % 2 ? 0 : p.at);
  __global const float *s = (__global const float *)ARRAY(p.kind) + (p.kind % 2 ? p.at : 0);

  for (int start = 0; start < p.columns; start += BATCH) {
    double sum[EACH_TURN] = {0};
    size_t column[EACH_TURN];

    for (int k = 0; k < EACH_TURN; k++) column[k] = (size_t)min(start + k * ACROSS + across, p.columns - 1) * p.stride;
    for (int i = lane; i < p.rows; i += LANES) {
      const double x = v[p.x + i];

      if (p.kind % 2)
        for (int k = 0; k < EACH_TURN; k++) sum[k] += s[column[k] + i] * x;
      else
        for (int k = 0; k < EACH_TURN; k++) sum[k] += a[column[k] + i] * x;
    }
    for (int k = 0; k < EACH_TURN; k++) all[k * ACROSS + across][lane] = sum[k];
    barrier(CLK_LOCAL_MEM_FENCE);
    {
      const int c = id / 8, piece = id % 8 * 4;

      part[c][id % 8] = (all[c][piece] + all[c][piece + 1]) + (all[c][piece + 2] + all[c][piece + 3]);
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    if (id < BATCH && start + id < p.columns)
      v[p.t + start + id] = ((part[id][0] + part[id][1]) + (part[id][2] + part[id][3])) + ((part[id][4] + part[id][5]) + (part[id][6] + part[id][7]));
    barrier(CLK_LOCAL_MEM_FENCE);
  }
}

// Adds up the parts of panels whose rows were divided: entry (to, from, parts, their distance).
__kernel void hmat_fold(int n, __global const int4 *entries, __global double *v)
{
  const int i = get_global_id(0);
  double sum = 0;
  int4 e;

  if (i >= n) return;
  e = entries[i];
  for (int k = 0; k < e.z; k++) sum += v[e.y + k * e.w];
  v[e.x] = sum;
}

// Computes rows of y, one group per chunk: 2^shift items have adjacent rows, and the others share the columns.
__kernel void hmat_sums(int n, int shift, __global const Chunk *chunks, __global const Sums *items, ARRAYS, __global const double *v,
                        double scale, __global const int *to, __global double *y)
{
  __local double all[ITEMS];
  const int id = get_local_id(0), lanes = 1 << shift, lane = id & (lanes - 1), across = id >> shift, step = ITEMS >> shift;
  const Chunk c = chunks[get_group_id(0)];
  const int row = c.first + min(lane, c.rows - 1);
  double sum = 0;

  for (int k = c.start; k < c.end; k++) {
    const Sums p = items[k];

    if (p.kind < 0) {
      if (across == 0) sum += v[p.t + row];
    } else if (p.kind % 2) {
      __global const float *s = (__global const float *)ARRAY(p.kind) + p.at + row;

      for (int j = across; j < p.columns; j += step) sum += s[(size_t)j * p.stride] * v[p.t + j];
    } else {
      __global const double *a = ARRAY(p.kind) + p.at + row;

      for (int j = across; j < p.columns; j += step) sum += a[(size_t)j * p.stride] * v[p.t + j];
    }
  }
  all[id] = sum;
  barrier(CLK_LOCAL_MEM_FENCE);
  if (across == 0 && lane < c.rows) {
    for (int k = 1; k < step; k++) sum += all[k * lanes + lane];
    y[to[c.row + lane]] = scale * sum;
  }
}
