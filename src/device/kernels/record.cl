// Values of a step that observers of a fault with rate-and-state friction read, as in src/record

// Collects for m cells, in rows of `out` [m][2 c + 3], the state, the strength, and the normal stress if it changes.
__kernel void fault_look(int m, int n, int c, double eta, int changes, __global const double *places, __global const double *cells,
                         __global const double *state, __global double *out)
{
  const int row = get_global_id(0), width = 2 * c + 3;

  if (row < m) {
    const int i = (int)places[row];
    const double speed = size_of(c, RATE(0), c == 1 ? 0 : RATE(1));
    double direct;

    for (int k = 0; k < 2 * c; k++) out[row * width + k] = RATE(k);
    out[row * width + 2 * c] = STATE;
    out[row * width + 2 * c + 1] = strength_of(n, i, eta, cells, STATE, speed, &direct);
    out[row * width + 2 * c + 2] = changes ? OF(STRESS) : 0;
  }
}

// Computes displacements of the ground since those of the fault were u0, and their rates relative to the far field: `count` numbers from number
// `first` on, each of which is a row of the matrix [numbers][c n].
#define MOST 12
__kernel void fault_ground(int n, int c, int first, int count, __global const double *matrix, __global const double *u0,
                           __global const double *cells, __global const double *state, __global double *room)
{
  __local double all[ITEMS];
  double mine[2 * MOST];

  for (int k = 0; k < 2 * count; k++) mine[k] = 0;
  EACH(i, n) {
    for (int j = 0; j < c; j++) {
      const double u = DISPLACEMENT(j) - u0[c * i + j], v = RATE(j) - OF(LOADING) * ALONG_OF(j);

      for (int k = 0; k < count; k++) {
        const double m = matrix[(long)(first + k) * c * n + c * i + j];

        mine[k] += m * u;
        mine[count + k] += m * v;
      }
    }
  }
  fold(2 * count, 2 * count, mine, all, room);
}

// Finds when cells first exceed a rate, since the onset of their event, in a step of length dt that begins at `begin` after it, from nodes at
// shares of the step; -1: never. It does the same as SlipCatalogueMarkRuptured().
__kernel void fault_rupture(int n, int c, int nodes, double bound, double begin, double dt, double share0, double share1, double share2,
                            __global const double *node0, __global const double *node1, __global const double *node2, __global double *rupture)
{
  const int i = get_global_id(0), block = 2 * c + 1;

  if (i < n && rupture[i] < 0) {
    __global const double *node[3] = {node0, node1, node2};
    const double share[3] = {share0, share1, share2};
    double speed[3];
    int k = 0;

    for (int j = 0; j < nodes; j++) speed[j] = size_of(c, node[j][block * i], c == 1 ? 0 : node[j][block * i + 1]);
    if (!(speed[nodes - 1] <= bound)) {
      double t = 0;

      while (speed[k] <= bound) k++;
      if (k) {
        const double slow = c == 1 ? node[k - 1][block * i] : speed[k - 1], fast = c == 1 ? node[k][block * i] : speed[k];
        const double x = fast > 0 ? slow : -slow, y = fabs(fast);

        t = share[k - 1] + (share[k] - share[k - 1]) * (x > 0 ? log(bound / x) / log(y / x) : (bound - x) / (y - x));
        t = fmax(0.0, begin + dt * t);
      }
      rupture[i] = t;
    }
  }
}
