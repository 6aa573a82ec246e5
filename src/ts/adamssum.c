/* Sums of derivatives of TSADAMS and norms of its estimates, in one pass over memory: apart, a step would read each of
   up to ten derivatives four times. Loops over a chunk that stays in the nearest cache, for vector units. */
#include <slipstep/private/slipts.h>

/* For the machine that the program meets, not only for the one that compiled it */
#if defined(__x86_64__) && defined(__gnu_linux__) && defined(__GNUC__) && !defined(__clang__) &&                       \
  !defined(__SANITIZE_ADDRESS__)
  #define VECTOR __attribute__((target_clones("avx512f", "avx2,fma", "default")))
#else
  #define VECTOR
#endif

enum { CHUNK = 256, AT_ONCE = 4 };

/* y += the sum of four derivatives times w[0][], and e[k] that times w[k + 1][] */
VECTOR static void AddFour(PetscInt n, const PetscReal *restrict a, const PetscReal *restrict b,
                           const PetscReal *restrict c, const PetscReal *restrict d, const PetscReal w[][AT_ONCE],
                           PetscReal *restrict y, PetscReal *restrict e, PetscReal *restrict f, PetscReal *restrict g)
{
  for (PetscInt i = 0; i < n; i++) {
    y[i] += w[0][0] * a[i] + w[0][1] * b[i] + w[0][2] * c[i] + w[0][3] * d[i];
    e[i] += w[1][0] * a[i] + w[1][1] * b[i] + w[1][2] * c[i] + w[1][3] * d[i];
    f[i] += w[2][0] * a[i] + w[2][1] * b[i] + w[2][2] * c[i] + w[2][3] * d[i];
    g[i] += w[3][0] * a[i] + w[3][1] * b[i] + w[3][2] * c[i] + w[3][3] * d[i];
  }
}

VECTOR static void AddFourAlone(PetscInt n, const PetscReal *restrict a, const PetscReal *restrict b,
                                const PetscReal *restrict c, const PetscReal *restrict d, const PetscReal w[][AT_ONCE],
                                PetscReal *restrict y)
{
  for (PetscInt i = 0; i < n; i++) y[i] += w[0][0] * a[i] + w[0][1] * b[i] + w[0][2] * c[i] + w[0][3] * d[i];
}

/* The estimate e over its tolerance in each entry, 0 where that is 0; PETSc's: absolute and that share of the larger
   one of y and y + e. The number of entries where it is not 0. */
VECTOR static PetscInt Weigh(PetscInt n, const PetscReal *restrict absolute, const PetscReal *restrict relative,
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

/* The same where tolerances do not depend on y: inverse has theirs */
VECTOR static void WeighFixed(PetscInt n, const PetscReal *restrict inverse, PetscReal *restrict e)
{
  for (PetscInt i = 0; i < n; i++) e[i] = PetscAbsReal(e[i]) * inverse[i];
}

/* Largest x >= 0 and sum of squares of each place of the chunks so far; what is no number stays in the sum */
VECTOR static void Gather(PetscInt n, const PetscReal *restrict x, PetscReal *restrict most,
                          PetscReal *restrict squares)
{
  for (PetscInt i = 0; i < n; i++) {
    most[i] = x[i] > most[i] ? x[i] : most[i];
    squares[i] += x[i] * x[i];
  }
}

VECTOR static void AddNumbers(PetscInt n, const PetscReal *restrict x, PetscReal *restrict sum)
{
  for (PetscInt i = 0; i < n; i++) sum[i] += x[i];
}

/* ---- one rank's share of a step ---- */

/* Those of a chunk from entry i on, of vectors or numbers */
static const PetscReal *Tolerance(const PetscReal vector[], PetscReal number, PetscInt i, PetscInt n, PetscReal room[])
{
  if (vector) return vector + i;
  for (PetscInt k = 0; k < n; k++) room[k] = number;
  return room;
}

/* y = start + the sum of m derivatives times weight[0], and of each of so many estimates, the sum of derivatives times
   its weight, sums over its tolerance: added up in sums. finite: y and the estimates are numbers. */
void SlipAdamsSum(PetscInt n, const PetscReal start[], PetscInt m, const PetscReal *const rate[],
                  const PetscReal weight[][SLIP_ADAMS_NODES], PetscInt estimates, const SlipAdamsTolerance *tolerance,
                  PetscReal y[], SlipAdamsSums *sums)
{
  PetscReal e[3][CHUNK], room[2][CHUNK], all[CHUNK] = {0}, most[3][CHUNK] = {{0}}, squares[3][CHUNK] = {{0}};

  *sums = (SlipAdamsSums){.finite = PETSC_TRUE};
  for (PetscInt i = 0; i < n; i += CHUNK) {
    const PetscInt here = PetscMin(CHUNK, n - i);

    for (PetscInt k = 0; k < here; k++) y[i + k] = start[i + k];
    for (PetscInt k = 0; k < 3 && estimates; k++)
      for (PetscInt j = 0; j < here; j++) e[k][j] = 0;
    for (PetscInt j = 0; j < m; j += AT_ONCE) {
      const PetscReal *r[AT_ONCE];
      PetscReal w[4][AT_ONCE] = {{0}};

      for (PetscInt l = 0; l < AT_ONCE; l++) {
        r[l] = rate[PetscMin(j + l, m - 1)] + i; /* beyond the last one with the weight 0 */
        for (PetscInt k = 0; k < estimates + 1 && j + l < m; k++) w[k][l] = weight[k][j + l];
      }
      if (estimates)
        AddFour(here, r[0], r[1], r[2], r[3], (const PetscReal(*)[AT_ONCE])w, y + i, e[0], e[1], e[2]);
      else
        AddFourAlone(here, r[0], r[1], r[2], r[3], (const PetscReal(*)[AT_ONCE])w, y + i);
    }
    AddNumbers(here, y + i, all);
    for (PetscInt k = 0; k < estimates; k++) {
      if (tolerance->inverse)
        WeighFixed(here, tolerance->inverse + i, e[k]);
      else
        sums->count[k] += Weigh(here, Tolerance(tolerance->absolutes, tolerance->absolute, i, here, room[0]),
                                Tolerance(tolerance->relatives, tolerance->relative, i, here, room[1]), y + i, e[k]);
      Gather(here, e[k], most[k], squares[k]);
    }
  }
  for (PetscInt i = 0; i < CHUNK; i++) {
    if (PetscIsInfOrNanReal(all[i])) sums->finite = PETSC_FALSE;
    for (PetscInt k = 0; k < estimates; k++) {
      sums->most[k] = PetscMax(sums->most[k], most[k][i]);
      sums->squares[k] += squares[k][i];
    }
  }
  /* a norm that is no number does not pass for one */
  for (PetscInt k = 0; k < estimates; k++)
    if (PetscIsInfOrNanReal(sums->squares[k])) sums->most[k] = PETSC_MAX_REAL;
}

/* Of vectors of tolerances without relative ones, inverse is kept until they change. */
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
