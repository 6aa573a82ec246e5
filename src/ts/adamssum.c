/* One pass over memory computes the sums of derivatives of TSADAMS and the norms of its estimates: separate ones would
   read each of up to ten derivatives four times. Vectorized loops work on chunks that fit into the nearest cache. */
#include <slipstep/private/slipts.h>

enum { CHUNK = 256, AT_ONCE = 4 };

/* Adds four derivatives times w[0][] to y, which is start if first is set, and the same derivatives times w[1][] and so
   on to the estimates e, f and g, which are 0 if first is set. Constant arguments give each case a loop of its own. */
SLIP_VECTOR_PART void Four(PetscInt n, int first, int estimates, const PetscReal *restrict a,
                           const PetscReal *restrict b, const PetscReal *restrict c, const PetscReal *restrict d,
                           const PetscReal w[][AT_ONCE], const PetscReal *restrict start, PetscReal *restrict y,
                           PetscReal *restrict e, PetscReal *restrict f, PetscReal *restrict g)
{
  for (PetscInt i = 0; i < n; i++) {
    y[i] = (first ? start[i] : y[i]) + (w[0][0] * a[i] + w[0][1] * b[i] + w[0][2] * c[i] + w[0][3] * d[i]);
    if (estimates < 2) continue;
    e[i] = (first ? 0 : e[i]) + (w[1][0] * a[i] + w[1][1] * b[i] + w[1][2] * c[i] + w[1][3] * d[i]);
    f[i] = (first ? 0 : f[i]) + (w[2][0] * a[i] + w[2][1] * b[i] + w[2][2] * c[i] + w[2][3] * d[i]);
    if (estimates < 3) continue;
    g[i] = (first ? 0 : g[i]) + (w[3][0] * a[i] + w[3][1] * b[i] + w[3][2] * c[i] + w[3][3] * d[i]);
  }
}

#define FOUR(name, first, estimates)                                                                                   \
  SLIP_VECTOR static void name(PetscInt n, const PetscReal *restrict a, const PetscReal *restrict b,                   \
                               const PetscReal *restrict c, const PetscReal *restrict d, const PetscReal w[][AT_ONCE], \
                               const PetscReal *restrict start, PetscReal *restrict y, PetscReal *restrict e,          \
                               PetscReal *restrict f, PetscReal *restrict g)                                           \
  {                                                                                                                    \
    Four(n, first, estimates, a, b, c, d, w, start, y, e, f, g);                                                       \
  }
FOUR(FirstAlone, 1, 0)
FOUR(AddAlone, 0, 0)
FOUR(FirstOfTwo, 1, 2)
FOUR(AddTwo, 0, 2)
FOUR(FirstOfThree, 1, 3)
FOUR(AddThree, 0, 3)

/* Divides each entry of the estimate e by its tolerance, and sets it to 0 where the tolerance is 0. The tolerance is
   PETSc's: absolute plus relative times the larger one of |y| and |y + e|. Returns the number of nonzero tolerances. */
SLIP_VECTOR static PetscInt Weigh(PetscInt n, const PetscReal *restrict absolute, const PetscReal *restrict relative,
                                  const PetscReal *restrict y, PetscReal *restrict e)
{
  PetscInt count = 0;

  for (PetscInt i = 0; i < n; i++) {
    const PetscReal a = PetscAbsReal(y[i]), b = PetscAbsReal(y[i] + e[i]), larger = a > b ? a : b;
    const PetscReal tolerance = absolute[i] + relative[i] * larger, size = PetscAbsReal(e[i]);

    e[i] = size / (tolerance > 0 ? tolerance : PETSC_MAX_REAL);
    count += tolerance > 0;
  }
  return count;
}

/* Updates the largest |x| and the sum of squares for each place in a chunk; x is multiplied by inverse unless that is
   NULL. inverse has tolerances that do not depend on y. A NaN stays in the sum. */
SLIP_VECTOR static void Gather(PetscInt n, const PetscReal *restrict x, const PetscReal *restrict inverse,
                               PetscReal *restrict most, PetscReal *restrict squares)
{
  if (inverse)
    for (PetscInt i = 0; i < n; i++) {
      const PetscReal size = PetscAbsReal(x[i]) * inverse[i];

      most[i] = size > most[i] ? size : most[i];
      squares[i] += size * size;
    }
  else
    for (PetscInt i = 0; i < n; i++) {
      most[i] = x[i] > most[i] ? x[i] : most[i];
      squares[i] += x[i] * x[i];
    }
}

SLIP_VECTOR static void AddNumbers(PetscInt n, const PetscReal *restrict x, PetscReal *restrict sum)
{
  for (PetscInt i = 0; i < n; i++) sum[i] += x[i];
}

/* ---- one rank's share of a step ---- */

/* Returns the tolerances of a chunk from entry i on, from a vector or from a number. */
static const PetscReal *Tolerance(const PetscReal vector[], PetscReal number, PetscInt i, PetscInt n, PetscReal room[])
{
  if (vector) return vector + i;
  for (PetscInt k = 0; k < n; k++) room[k] = number;
  return room;
}

/* Computes y = start + the sum of m derivatives times weight[0]. Each estimate is the sum of derivatives times its own
   weight; sums collects its norms relative to the tolerance. finite: y and the estimates are finite. */
void SlipAdamsSum(PetscInt n, const PetscReal start[], PetscInt m, const PetscReal *const rate[],
                  const PetscReal weight[][SLIP_ADAMS_NODES], PetscInt estimates, const SlipAdamsTolerance *tolerance,
                  PetscReal y[], SlipVecsSums *sums)
{
  void (*const add[3][2])(PetscInt, const PetscReal *, const PetscReal *, const PetscReal *, const PetscReal *,
                          const PetscReal[][AT_ONCE], const PetscReal *, PetscReal *, PetscReal *, PetscReal *,
                          PetscReal *) = {{FirstAlone, AddAlone}, {FirstOfTwo, AddTwo}, {FirstOfThree, AddThree}};
  PetscReal e[3][CHUNK], room[2][CHUNK], all[CHUNK] = {0}, most[3][CHUNK] = {{0}}, squares[3][CHUNK] = {{0}};

  *sums = (SlipVecsSums){.finite = PETSC_TRUE};
  for (PetscInt i = 0; i < n; i += CHUNK) {
    const PetscInt here = PetscMin(CHUNK, n - i);

    for (PetscInt j = 0; j < m; j += AT_ONCE) {
      const PetscReal *r[AT_ONCE];
      PetscReal w[4][AT_ONCE] = {{0}};

      for (PetscInt l = 0; l < AT_ONCE; l++) {
        r[l] = rate[PetscMin(j + l, m - 1)] + i; /* indices beyond the last have the weight 0 */
        for (PetscInt k = 0; k < estimates + 1 && j + l < m; k++) w[k][l] = weight[k][j + l];
      }
      (*add[estimates ? estimates - 1 : 0][j > 0])(here, r[0], r[1], r[2], r[3], (const PetscReal(*)[AT_ONCE])w,
                                                   start + i, y + i, e[0], e[1], e[2]);
    }
    AddNumbers(here, y + i, all);
    for (PetscInt k = 0; k < estimates; k++) {
      if (!tolerance->inverse)
        sums->count[k] += Weigh(here, Tolerance(tolerance->absolutes, tolerance->absolute, i, here, room[0]),
                                Tolerance(tolerance->relatives, tolerance->relative, i, here, room[1]), y + i, e[k]);
      Gather(here, e[k], tolerance->inverse ? tolerance->inverse + i : NULL, most[k], squares[k]);
    }
  }
  for (PetscInt i = 0; i < CHUNK; i++) {
    if (PetscIsInfOrNanReal(all[i])) sums->finite = PETSC_FALSE;
    for (PetscInt k = 0; k < estimates; k++) {
      sums->most[k] = PetscMax(sums->most[k], most[k][i]);
      sums->squares[k] += squares[k][i];
    }
  }
  /* a norm that is NaN must not look finite */
  for (PetscInt k = 0; k < estimates; k++)
    if (PetscIsInfOrNanReal(sums->squares[k])) sums->most[k] = PETSC_MAX_REAL;
}

/* Gets the tolerances. The inverse of vectors of absolute ones without relative ones is cached until they change. */
PetscErrorCode SlipAdamsGetTolerance(TS ts, SlipAdamsInverse *kept, SlipAdamsTolerance *tolerance)
{
  Vec v[2] = {ts->vatol, ts->vrtol};
  PetscBool same = PETSC_TRUE;
  PetscObjectState state;
  PetscReal most = 0;
  const PetscReal *a;
  PetscObjectId id;
  PetscInt n;

  PetscFunctionBegin;
  *tolerance = (SlipAdamsTolerance){.absolute = ts->atol, .relative = ts->rtol};
  if (!v[0] || !v[1]) PetscFunctionReturn(PETSC_SUCCESS);
  for (int i = 0; i < 2; i++) {
    PetscCall(PetscObjectStateGet((PetscObject)v[i], &state));
    PetscCall(PetscObjectGetId((PetscObject)v[i], &id));
    if (state != kept->state[i] || id != kept->id[i]) same = PETSC_FALSE;
    kept->state[i] = state;
    kept->id[i] = id;
  }
  if (!same) {
    PetscCall(PetscFree(kept->inverse));
    PetscCall(VecNorm(v[1], NORM_INFINITY, &most));
    PetscCall(VecGetLocalSize(v[0], &n));
    if (most == 0) {
      PetscCall(PetscMalloc1(n + 1, &kept->inverse));
      PetscCall(VecGetArrayRead(v[0], &a));
      kept->entries = 0;
      for (PetscInt i = 0; i < n; i++) {
        kept->inverse[i] = a[i] > 0 ? 1 / a[i] : 0;
        kept->entries += a[i] > 0;
      }
      PetscCall(VecRestoreArrayRead(v[0], &a));
    }
  }
  tolerance->inverse = kept->inverse;
  PetscFunctionReturn(PETSC_SUCCESS);
}
