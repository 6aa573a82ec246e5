/*
  Fourier transforms repeat the fault periodically. The periodic images of the fault add their waves to its stress, and
  their static stress, which is an error. The periodic stiffness contains this static stress from the start, and the
  stress of waves under way cancels it until the first waves of the images arrive; it is therefore subtracted with that
  delay, for the slip of that earlier time. Far from slip stress is smooth, so that a few moments of slip determine it:

     f = K_periodic u - sum over groups of images g of K_g u(t - T_g),  K_g = sum P_a(x) C_ab P_b(x'),

  where P are Legendre polynomials over the fault, and C is Gauss' quadrature of the stress of a point: near images
  count one by one, and all farther ones as an integral. One group has the images beside the fault along the shorter
  period, the other all others. Images also send a plane wave of the mean slip rate of a period, which slow slip does
  not have: delay times stress of uniform slip cancels it, which determines T_g. Slip that has been steady for longer
  than waves travel has neither error.
*/
#include <slipstep/private/slipwavespace.h>
#include <petscdt.h>
#include <math.h>

enum { DEGREES = 8, NODES = 12, FAR = 12, GROUPS = 2 }; /* polynomials of a line, Gauss points, images each way */
/* Stored polynomials per cell, padded with 0 to the length of a vector register */
enum { LANES = 8 };
enum { PLANE_DEGREES = 6, PLANE_NODES = 8 };

struct _n_SlipWaveImages {
  SlipWaveSpace space;
  PetscInt groups;
  PetscReal delay[GROUPS];
  PetscInt q;                         /* number of moments */
  PetscInt degrees;                   /* number of polynomials in each direction */
  PetscReal *C[GROUPS];               /* [q][q] */
  PetscReal *at[2];                   /* [cells in that direction][LANES] polynomials along strike and down dip */
  PetscReal *rows;                    /* [cells down dip][2][LANES] moments of rows of cells */
  PetscReal *moments, *past, *answer; /* [q] moments of now, moments of an earlier time, and K_g times those */
  PetscReal *time, *history;          /* [n] times of the history [s], [n][q] its moments */
  PetscInt n, size;
  PetscReal nu, G;
};

/* ---- the stress of a point ---- */

/* Stress of all periodic images of a cell of a line, at the centre of a cell that is n cells away from it */
static PetscReal LineImages(PetscReal G, PetscReal dx, PetscReal period, PetscReal n)
{
  const PetscReal turn = (PetscReal)PETSC_PI / period, above = n + (PetscReal)0.5, below = n - (PetscReal)0.5;
  const PetscReal all = turn * (1 / PetscTanReal(turn * above) - 1 / PetscTanReal(turn * below));

  return G / (2 * (PetscReal)PETSC_PI * dx) * (all - (1 / above - 1 / below));
}

/* Adds the static stress drop on a plane, at (x, z) along strike and down dip, of unit slip times area along each */
static void Point(PetscReal G, PetscReal nu, PetscReal x, PetscReal z, PetscReal K[3])
{
  const PetscReal r2 = x * x + z * z, cube = r2 * PetscSqrtReal(r2), ratio = nu / (1 - nu),
                  factor = -G / (4 * (PetscReal)PETSC_PI * cube);

  K[0] += factor * (1 + ratio * (3 * x * x / r2 - 1));
  K[1] += factor * ratio * 3 * x * z / r2;
  K[2] += factor * (1 + ratio * (3 * z * z / r2 - 1));
}

/* Adds the stress of all images beyond |x| = a and |z| = b, as an integral with one image per area */
static void Beyond(PetscReal G, PetscReal nu, PetscReal a, PetscReal b, PetscReal area, PetscReal K[3])
{
  const PetscReal root = PetscSqrtReal(a * a + b * b), ratio = nu / (1 - nu),
                  factor = -G / (4 * (PetscReal)PETSC_PI * area);

  K[0] += factor * (4 * root / (a * b) + ratio * 4 * b / (a * root));
  K[2] += factor * (4 * root / (a * b) + ratio * 4 * a / (b * root));
}

/* Stress at (x, z) of the images in a group: those beside the fault along the shorter period (0), or all others (1) */
static void PlaneImages(const struct _n_SlipWaveImages *w, int group, PetscReal x, PetscReal z, PetscReal K[3])
{
  const SlipElasticGrid *g = &w->space->grid;
  const PetscReal lx = (PetscReal)w->space->length[0] * g->size[0], lz = (PetscReal)w->space->length[1] * g->size[1];
  const PetscBool along = lx < lz ? PETSC_TRUE : PETSC_FALSE;

  K[0] = K[1] = K[2] = 0;
  for (int i = -FAR; i <= FAR; i++)
    for (int j = -FAR; j <= FAR; j++) {
      const PetscBool beside = (along ? j : i) == 0 ? PETSC_TRUE : PETSC_FALSE;

      if ((i || j) && (group == 0) == beside) Point(w->G, w->nu, x + (PetscReal)i * lx, z + (PetscReal)j * lz, K);
    }
  if (group) Beyond(w->G, w->nu, (FAR + (PetscReal)0.5) * lx, (FAR + (PetscReal)0.5) * lz, lx * lz, K);
}

/* ---- set-up ---- */

/* Computes Legendre's polynomials of x, of all degrees or of the even ones only. */
static void Polynomials(PetscReal x, PetscInt degrees, PetscBool even, PetscReal p[])
{
  PetscReal before = 1, now = x;

  p[0] = 1;
  for (PetscInt d = 1, k = 1; k < degrees; d++) {
    const PetscReal next = ((2 * (PetscReal)d + 1) * x * now - (PetscReal)d * before) / (PetscReal)(d + 1);

    if (!even || d % 2 == 0) p[k++] = now;
    before = now;
    now = next;
  }
}

/* Coordinate of cell i of n, which is in (0, 1) with a mirror and in (-1, 1) without */
static PetscReal Place(PetscReal i, PetscInt n, PetscBool mirror)
{
  return mirror ? (i + (PetscReal)0.5) / (PetscReal)n : 2 * (i + (PetscReal)0.5) / (PetscReal)n - 1;
}

/* Gauss' points, and the polynomials there [NODES][degrees], times the factors that make an integral an amplitude */
static PetscErrorCode Quadrature(PetscInt nodes, PetscInt degrees, PetscBool even, PetscReal x[], PetscReal p[])
{
  PetscReal weight[NODES];

  PetscFunctionBegin;
  if (even)
    PetscCall(PetscDTGaussQuadrature(nodes, 0, 1, x, weight));
  else
    PetscCall(PetscDTGaussQuadrature(nodes, -1, 1, x, weight));
  for (PetscInt k = 0; k < nodes; k++) {
    Polynomials(x[k], degrees, even, p + k * degrees);
    for (PetscInt a = 0; a < degrees; a++)
      p[k * degrees + a] *= weight[k] * (even ? 4 * (PetscReal)a + 1 : a + (PetscReal)0.5);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SetUpLine(SlipWaveImages w, PetscReal cs)
{
  const SlipWaveSpace s = w->space;
  const PetscInt n = s->grid.nz;
  const PetscReal dx = s->grid.size[1], period = (PetscReal)(s->mirror ? 2 : 1) * (PetscReal)s->length[1];
  PetscReal x[NODES], p[NODES * DEGREES];

  PetscFunctionBegin;
  w->groups = 1;
  w->delay[0] =
    3 / (PetscReal)PETSC_PI * period * dx / cs; /* G/(2 cs L) over that stress, G pi/(6 L^2), L = period dx */
  w->degrees = w->q = DEGREES;
  PetscCall(PetscCalloc1(DEGREES * DEGREES, &w->C[0]));
  PetscCall(Quadrature(NODES, DEGREES, s->mirror, x, p));
  for (PetscInt i = 0; i < NODES; i++)
    for (PetscInt j = 0; j < NODES; j++) {
      const PetscReal half = s->mirror ? (PetscReal)n : (PetscReal)n / 2;
      PetscReal K = LineImages(w->G, dx, period, half * (x[i] - x[j]));

      if (s->mirror) K += LineImages(w->G, dx, period, half * (x[i] + x[j]));
      for (PetscInt a = 0; a < DEGREES; a++)
        for (PetscInt b = 0; b < DEGREES; b++) w->C[0][a * DEGREES + b] += p[i * DEGREES + a] * K * p[j * DEGREES + b];
    }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Moments are [direction][degree along strike][degree down dip]. */
static PetscErrorCode SetUpPlane(SlipWaveImages w, const SlipElasticRock *rock, PetscReal cs)
{
  enum { D = PLANE_DEGREES, M = PLANE_NODES };
  const SlipElasticGrid *g = &w->space->grid;
  const PetscReal half[2] = {(PetscReal)g->nx * g->size[0] / 2,
                             (PetscReal)SlipWaveSpaceRows(w->space) * g->size[1] / 2};
  const PetscReal lx = (PetscReal)w->space->length[0] * g->size[0], lz = (PetscReal)w->space->length[1] * g->size[1];
  PetscReal x[NODES], p[NODES * D], damping = 0;

  PetscFunctionBegin;
  w->groups = 2;
  w->delay[0] = PetscMin(lx, lz) / cs;
  w->delay[1] = PetscMax(lx, lz) / cs;
  for (int group = 0; group < 2; group++) {
    PlaneImages(w, group, 0, 0, x);
    damping -= (x[0] + x[2]) / 2 * w->delay[group];
  }
  for (int group = 0; group < 2; group++) w->delay[group] *= rock->impedance / (lx * lz * damping);
  w->degrees = D;
  w->q = 2 * D * D;
  PetscCall(Quadrature(M, D, PETSC_FALSE, x, p));
  for (int group = 0; group < 2; group++) {
    PetscCall(PetscCalloc1(w->q * w->q, &w->C[group]));
    for (PetscInt e = 0; e < M * M * M * M; e++) {
      const PetscInt i = e % M, j = e / M % M, k = e / M / M % M, l = e / M / M / M; /* source x, z; receiver x, z */
      PetscReal K[3];

      PlaneImages(w, group, half[0] * (x[k] - x[i]), half[1] * (x[l] - x[j]), K);
      for (PetscInt a = 0; a < D * D; a++) {
        const PetscReal here = g->size[0] * g->size[1] * p[k * D + a / D] * p[l * D + a % D];

        for (PetscInt b = 0; b < D * D; b++) {
          const PetscReal both = here * p[i * D + b / D] * p[j * D + b % D];
          PetscReal *C = w->C[group] + a * w->q + b;

          C[0] += K[0] * both;
          C[D * D] += K[1] * both;
          C[D * D * w->q] += K[1] * both;
          C[D * D * w->q + D * D] += K[2] * both;
        }
      }
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipWaveImagesCreate(SlipWaveSpace space, const SlipElasticRock *rock, SlipWaveImages *images)
{
  const PetscReal cs = PetscSqrtReal(rock->shear_modulus / rock->density);
  const PetscInt n[2] = {space->grid.nx, space->grid.nz};
  SlipWaveImages w;

  PetscFunctionBegin;
  PetscCall(PetscNew(&w));
  *images = w;
  w->space = space;
  w->G = rock->shear_modulus;
  w->nu = rock->poisson_ratio;
  if (space->line)
    PetscCall(SetUpLine(w, cs));
  else
    PetscCall(SetUpPlane(w, rock, cs));
  for (int d = 0; d < 2; d++) {
    PetscCall(PetscCalloc1(n[d] * LANES, &w->at[d]));
    for (PetscInt i = 0; i < n[d]; i++)
      Polynomials(Place((PetscReal)i, n[d], space->mirror && (space->line || d)), w->degrees,
                  space->mirror && space->line, w->at[d] + i * LANES);
  }
  PetscCall(PetscMalloc4(w->q, &w->moments, w->q, &w->past, w->q, &w->answer, 2 * space->grid.nz * LANES, &w->rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipWaveImagesDestroy(SlipWaveImages *images)
{
  SlipWaveImages w = *images;

  PetscFunctionBegin;
  if (!w) PetscFunctionReturn(PETSC_SUCCESS);
  for (int d = 0; d < 2; d++) {
    PetscCall(PetscFree(w->at[d]));
    PetscCall(PetscFree(w->C[d]));
  }
  PetscCall(PetscFree4(w->moments, w->past, w->answer, w->rows));
  PetscCall(PetscFree(w->time));
  PetscCall(PetscFree(w->history));
  PetscCall(PetscFree(w));
  *images = NULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- moments ---- */

/* Slip of direction d of the cell in row i of those that this process transforms */
static PetscReal SlipOf(SlipWaveSpace s, const PetscReal u[], PetscInt i, int d)
{
  if (s->line) return u[i];
  if (s->components == 1) return u[i] * (d ? s->uz[i] : s->ux[i]);
  return d ? -u[2 * i + 1] : u[2 * i];
}

/* Cells of this process: all of a line, and the rows that a plane's transforms are given; first: of these rows */
static PetscInt Cells(SlipWaveSpace s, PetscInt *first)
{
  *first = s->line ? 0 : s->pencil->layout.row_start;
  return s->line ? s->grid.nz : s->pencil->layout.rows * s->grid.nx;
}

/* Adds to row[] the moments along strike of a row of cells, for both directions of its slip u[] */
SLIP_VECTOR static void SlipWaveImagesRow(SlipWaveSpace s, const PetscReal at[], const PetscReal u[], PetscInt first,
                                          PetscReal row[])
{
  for (PetscInt i = 0; i < s->grid.nx; i++)
    for (int d = 0; d < 2; d++) {
      const PetscReal slip = SlipOf(s, u, first + i, d);

      for (int b = 0; b < LANES; b++) row[d * LANES + b] += slip * at[i * LANES + b];
    }
}

/* Computes the moments of u. The order in which rows are added does not depend on the number of ranks. Collective. */
static PetscErrorCode Moments(SlipWaveImages w, Vec u, PetscReal q[])
{
  const SlipWaveSpace s = w->space;
  const PetscInt D = w->degrees, nx = s->grid.nx;
  PetscInt first;
  const PetscInt cells = Cells(s, &first);
  const PetscReal *a;

  PetscFunctionBegin;
  PetscCall(PetscArrayzero(q, w->q));
  PetscCall(SlipGatherGet(&s->gather, u, &a));
  if (s->line)
    for (PetscInt row = 0; row < cells; row++)
      for (PetscInt b = 0; b < w->q; b++) q[b] += a[row] * w->at[1][row * LANES + b];
  else {
    PetscCall(PetscArrayzero(w->rows, s->grid.nz * 2 * LANES));
    for (PetscInt i = 0; i < cells; i += nx)
      SlipWaveImagesRow(s, w->at[0], a, i, w->rows + (first + i / nx) * 2 * LANES);
    PetscCallMPI(
      MPI_Allreduce(MPI_IN_PLACE, w->rows, (PetscMPIInt)(s->grid.nz * 2 * LANES), MPIU_REAL, MPIU_SUM, s->comm));
    for (PetscInt row = 0; row < s->grid.nz; row++) {
      const PetscReal *z = w->at[1] + row * LANES, *sum = w->rows + row * 2 * LANES;

      for (PetscInt b = 0; b < w->q; b++) /* with an image, odd moments of slip along strike vanish */
        q[b] += (s->mirror ? 2 * (b % D % 2 == 0) : 1) * sum[b / (D * D) * LANES + b / D % D] * z[b % D];
    }
  }
  PetscCall(SlipGatherRestore(&s->gather, u, &a));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the present slip u, which the functions below use until the next call. Collective. */
PetscErrorCode SlipWaveImagesSet(SlipWaveImages w, Vec u)
{
  PetscFunctionBegin;
  PetscCall(Moments(w, u, w->moments));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipWaveImagesStart(SlipWaveImages w)
{
  PetscFunctionBegin;
  w->n = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Reserve(SlipWaveImages w, PetscInt n)
{
  PetscReal *time, *history;

  PetscFunctionBegin;
  if (n <= w->size) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(2 * n, &time));
  PetscCall(PetscMalloc1(2 * n * w->q, &history));
  PetscCall(PetscArraycpy(time, w->time, w->n));
  PetscCall(PetscArraycpy(history, w->history, w->n * w->q));
  PetscCall(PetscFree(w->time));
  PetscCall(PetscFree(w->history));
  w->time = time;
  w->history = history;
  w->size = 2 * n;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Appends the present moments to the history. When more than half of the entries are older than twice the longest
   delay, the others and the last of these move to the front. */
PetscErrorCode SlipWaveImagesAdd(SlipWaveImages w, PetscReal t)
{
  const PetscReal oldest = t - 2 * w->delay[w->groups - 1]; /* twice, because a step may be taken back */
  PetscInt old = 0;

  PetscFunctionBegin;
  while (w->n && w->time[w->n - 1] >= t) w->n--;
  while (old + 2 < w->n && w->time[old + 1] < oldest) old++;
  if (old > w->n / 2) {
    PetscCall(PetscArraymove(w->time, w->time + old, w->n - old));
    PetscCall(PetscArraymove(w->history, w->history + old * w->q, (w->n - old) * w->q));
    w->n -= old;
  }
  PetscCall(Reserve(w, w->n + 1));
  PetscCall(PetscArraycpy(w->history + w->n * w->q, w->moments, w->q));
  w->time[w->n++] = t;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Interpolates the moments of the time `then` in the history, or between its last entry and the present moments. */
static void MomentsOf(SlipWaveImages w, PetscReal then, PetscReal t)
{
  PetscInt low = 0, high = w->n; /* the first entry that is later; w->n: the present */
  const PetscReal *before, *after;
  PetscReal share, from, to;

  while (low < high) {
    const PetscInt middle = (low + high) / 2;

    if (w->time[middle] > then)
      high = middle;
    else
      low = middle + 1;
  }
  if (low == 0) {
    for (PetscInt b = 0; b < w->q; b++) w->past[b] = w->n ? w->history[b] : w->moments[b];
    return;
  }
  before = w->history + (low - 1) * w->q;
  after = low < w->n ? w->history + low * w->q : w->moments;
  from = w->time[low - 1];
  to = low < w->n ? w->time[low] : t;
  share = to > from ? (then - from) / (to - from) : 1;
  for (PetscInt b = 0; b < w->q; b++) w->past[b] = before[b] + share * (after[b] - before[b]);
}

PetscErrorCode SlipWaveImagesSubtract(SlipWaveImages w, PetscReal t, PetscBool steady, Vec f)
{
  const SlipWaveSpace s = w->space;
  const PetscInt D = w->degrees;
  PetscInt first;
  const PetscInt cells = Cells(s, &first);
  PetscReal *out;
  const PetscReal *a;

  PetscFunctionBegin;
  PetscCall(PetscArrayzero(w->answer, w->q));
  for (PetscInt g = 0; g < w->groups; g++) {
    if (steady)
      PetscCall(PetscArraycpy(w->past, w->moments, w->q));
    else
      MomentsOf(w, t - w->delay[g], t);
    for (PetscInt i = 0; i < w->q; i++)
      for (PetscInt b = 0; b < w->q; b++) w->answer[i] += w->C[g][i * w->q + b] * w->past[b];
  }
  PetscCall(PetscMalloc1(s->components * cells, &out));
  PetscCall(SlipGatherGet(&s->gather, f, &a));
  for (PetscInt row = 0; row < cells / s->grid.nx; row++) {
    const PetscReal *z = w->at[1] + (first + row) * LANES;
    PetscReal along[2][DEGREES] = {{0}}; /* amplitudes of this row's polynomials along strike */

    for (PetscInt b = 0; b < D && s->line; b++) along[0][0] += z[b] * w->answer[b];
    for (PetscInt b = 0; b < w->q && !s->line; b++) along[b / (D * D)][b / D % D] += w->answer[b] * z[b % D];
    for (PetscInt ix = 0, i = row * s->grid.nx; ix < s->grid.nx; ix++, i++) {
      const PetscReal *x = w->at[0] + ix * LANES;
      PetscReal sum[2] = {0, 0};

      for (PetscInt b = 0; b < (s->line ? 1 : D); b++) {
        sum[0] += along[0][b] * (s->line ? 1 : x[b]);
        sum[1] += along[1][b] * x[b];
      }
      if (s->line) {
        out[i] = a[i] - sum[0];
      } else if (s->components == 1) {
        out[i] = a[i] - s->ux[i] * sum[0] - s->uz[i] * sum[1];
      } else {
        out[2 * i] = a[2 * i] - sum[0];
        out[2 * i + 1] = a[2 * i + 1] + sum[1];
      }
    }
  }
  PetscCall(SlipGatherRestore(&s->gather, f, &a));
  PetscCall(SlipGatherPut(&s->gather, out, f));
  PetscCall(PetscFree(out));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipWaveImagesWork(SlipWaveImages w, PetscReal t, PetscBool steady, Vec v, PetscReal *work)
{
  PetscReal *q;
  PetscMPIInt rank;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(w->space->comm, &rank));
  PetscCall(PetscMalloc1(w->q, &q));
  if (v)
    PetscCall(Moments(w, v, q));
  else
    PetscCall(PetscArraycpy(q, w->moments, w->q));
  *work = 0;
  for (PetscInt g = 0; g < w->groups && !rank && !steady; g++) {
    MomentsOf(w, t - w->delay[g], t);
    for (PetscInt i = 0; i < w->q; i++)
      for (PetscInt b = 0; b < w->q; b++) *work += q[i] * w->C[g][i * w->q + b] * (w->past[b] - w->moments[b]);
  }
  if (w->space->mirror && !w->space->line) *work /= 2; /* moments are those of both halves */
  PetscCall(PetscFree(q));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipWaveImagesVisit(SlipWaveImages w, SlipState state)
{
  PetscInt n = w->n;

  PetscFunctionBegin;
  PetscCall(SlipStateInt(state, "images", 1, &n));
  PetscCall(Reserve(w, n));
  w->n = n;
  if (!n) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipStateReal(state, "images_time", n, w->time));
  PetscCall(SlipStateReal(state, "images_moments", n * w->q, w->history));
  PetscFunctionReturn(PETSC_SUCCESS);
}
