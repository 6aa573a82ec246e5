/*
  Low-rank approximation of a block from some of its rows and columns: adaptive cross approximation with partial
  pivoting (Bebendorf 2000, Numer. Math. 86), then truncation by the singular values of U V' (QR of both factors).

  The pivoting can end too early where a block has parts that decouple. The end is therefore confirmed in unused rows:
  if their residual is not small, pivoting continues with the worst of them.

  Entries may form tuples, as those of vectors do: a row then costs as much as all rows of its tuple, and so does a
  column. All rows of a tuple become pivots, and columns of a computed tuple are used unless others are much larger.
*/
#include <petscmat.h>
#include <petscblaslapack.h>
#include <float.h>
#include <slipcompat.h>
#include <slipstep/private/slipmathmatrix.h>

#define CROSS_CHECKS 4     /* rows in which the end is confirmed */
#define CROSS_SEARCH 0.3   /* share of the tolerance at which the search ends */
#define CROSS_TRUNCATE 0.5 /* share of the tolerance for truncation */
#define CROSS_ROUND 0.2    /* share of the tolerance for rounding to single precision */
#define CROSS_TILE 512     /* numbers of a column that stay in the cache while all columns are read */
#define CROSS_KNOWN 0.5    /* size over the largest entry's that suffices for a pivot in a computed column */

typedef struct {
  SlipEntriesFn entries;
  void *ctx;
  PetscInt m, n, rank, capacity;
  PetscInt tuple[2];     /* numbers of rows and of columns in a tuple */
  PetscInt at[2];        /* tuples of rows and of columns whose entries are stored; -1: none */
  PetscReal *known[2];   /* entries of these, [n][tuple[0]] and [tuple[1]][m] */
  PetscReal *U, *V;      /* [m * capacity], [n * capacity] */
  PetscReal *f, *dot[2]; /* [capacity] work: factors of columns, and products of a row and of a column with them */
  PetscBool *used;       /* [m] rows that were pivots */
  PetscReal norm2;       /* square of the Frobenius norm of U V' */
} Cross;

typedef PetscReal Four __attribute__((vector_size(4 * sizeof(PetscReal)), aligned(sizeof(PetscReal)), may_alias));

SLIP_VECTOR_PART PetscReal DotOf(PetscInt n, const PetscReal a[], const PetscReal b[])
{
  Four sum[2] = {{0}, {0}};
  PetscReal rest = 0;
  PetscInt i = 0;

  for (; i + 8 <= n; i += 8) {
    sum[0] += *(const Four *)(a + i) * *(const Four *)(b + i);
    sum[1] += *(const Four *)(a + i + 4) * *(const Four *)(b + i + 4);
  }
  for (; i < n; i++) rest += a[i] * b[i];
  sum[0] += sum[1];
  return ((sum[0][0] + sum[0][1]) + (sum[0][2] + sum[0][3])) + rest;
}

/* Computes x -= A f for columns A [n * rank], and their products with the result in dot [rank] unless that is NULL. */
SLIP_VECTOR static void Subtract(PetscInt n, PetscInt rank, const PetscReal A[], const PetscReal f[],
                                 PetscReal x[restrict], PetscReal dot[])
{
  for (PetscInt r = 0; r < rank && dot; r++) dot[r] = 0;
  for (PetscInt start = 0; start < n; start += CROSS_TILE) {
    const PetscInt count = PetscMin(CROSS_TILE, n - start);
    const PetscReal *a = A + start;
    PetscReal *to = x + start;
    PetscInt r = 0;

    for (; r + 4 <= rank; r += 4) {
      const PetscReal *a0 = a + (size_t)r * n, *a1 = a0 + n, *a2 = a1 + n, *a3 = a2 + n;

      for (PetscInt k = 0; k < count; k++)
        to[k] -= (f[r] * a0[k] + f[r + 1] * a1[k]) + (f[r + 2] * a2[k] + f[r + 3] * a3[k]);
    }
    for (; r < rank; r++)
      for (PetscInt k = 0; k < count; k++) to[k] -= f[r] * a[(size_t)r * n + k];
    for (r = 0; r < rank && dot; r++) dot[r] += DotOf(count, a + (size_t)r * n, to);
  }
}

SLIP_VECTOR static PetscReal Dot(size_t n, const PetscReal a[], const PetscReal b[])
{
  PetscReal sum = 0;

  for (size_t i = 0; i < n; i += CROSS_TILE) sum += DotOf((PetscInt)PetscMin(CROSS_TILE, n - i), a + i, b + i);
  return sum;
}

/* Computes the residual's row i in v [n], and its products with V's columns in dot unless that is NULL. *j is its
   largest entry in magnitude, or one nearly as large in a stored column. */
static void ResidualRow(Cross *c, PetscInt i, PetscReal v[], PetscReal dot[], PetscInt *j)
{
  const PetscInt rows = c->tuple[0], columns = c->tuple[1], best = c->at[1] * columns;

  if (c->at[0] != i / rows) {
    c->at[0] = i / rows;
    (*c->entries)(c->ctx, c->at[0], 1, 0, c->n / columns, c->known[0]);
  }
  for (PetscInt k = 0; k < c->n; k++) v[k] = c->known[0][k * rows + i % rows];
  for (PetscInt r = 0; r < c->rank; r++) c->f[r] = c->U[(size_t)r * c->m + i];
  Subtract(c->n, c->rank, c->V, c->f, v, dot);
  *j = 0;
  for (PetscInt k = 1; k < c->n; k++)
    if (PetscAbsReal(v[k]) > PetscAbsReal(v[*j])) *j = k;
  if (columns == 1 || best < 0) return;
  for (PetscInt k = best; k < best + columns; k++)
    if (PetscAbsReal(v[k]) >= CROSS_KNOWN * PetscAbsReal(v[*j])) {
      *j = k;
      return;
    }
}

static PetscErrorCode Grow(Cross *c)
{
  PetscReal *U, *V;

  PetscFunctionBegin;
  if (c->rank < c->capacity) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(2 * (size_t)c->capacity * c->m, &U));
  PetscCall(PetscMalloc1(2 * (size_t)c->capacity * c->n, &V));
  PetscCall(PetscArraycpy(U, c->U, (size_t)c->capacity * c->m));
  PetscCall(PetscArraycpy(V, c->V, (size_t)c->capacity * c->n));
  PetscCall(PetscFree(c->U));
  PetscCall(PetscFree(c->V));
  PetscCall(PetscFree3(c->f, c->dot[0], c->dot[1]));
  c->U = U;
  c->V = V;
  c->capacity *= 2;
  PetscCall(PetscMalloc3(c->capacity, &c->f, c->capacity, &c->dot[0], c->capacity, &c->dot[1]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the cross through row i, whose residual is in V's next column and its products in dot[0], and column j; *size
   is the norm of the cross. */
static void AddCross(Cross *c, PetscInt i, PetscInt j, PetscReal *size)
{
  PetscReal *u = c->U + (size_t)c->rank * c->m, *v = c->V + (size_t)c->rank * c->n;
  const PetscReal pivot = v[j];
  const PetscInt columns = c->tuple[1];
  PetscReal u2, v2;

  for (PetscInt k = 0; k < c->n; k++) v[k] /= pivot;
  if (c->at[1] != j / columns) {
    c->at[1] = j / columns;
    (*c->entries)(c->ctx, 0, c->m / c->tuple[0], c->at[1], 1, c->known[1]);
  }
  for (PetscInt k = 0; k < c->m; k++) u[k] = c->known[1][(size_t)(j % columns) * c->m + k];
  for (PetscInt r = 0; r < c->rank; r++) c->f[r] = c->V[(size_t)r * c->n + j];
  Subtract(c->m, c->rank, c->U, c->f, u, c->dot[1]);
  u2 = Dot((size_t)c->m, u, u);
  v2 = Dot((size_t)c->n, v, v);
  for (PetscInt r = 0; r < c->rank; r++) c->norm2 += 2 * c->dot[1][r] * (c->dot[0][r] / pivot);
  c->norm2 += u2 * v2;
  c->used[i] = PETSC_TRUE;
  c->rank++;
  *size = PetscSqrtReal(u2 * v2);
}

/* Returns the next row: that of the newest column's largest entry among unused rows; -1 if all are used. */
static PetscInt NextRow(const Cross *c)
{
  const PetscReal *u = c->U + (size_t)(c->rank - 1) * c->m;
  PetscInt best = -1;

  for (PetscInt i = 0; i < c->m; i++)
    if (!c->used[i] && (best < 0 || PetscAbsReal(u[i]) > PetscAbsReal(u[best]))) best = i;
  return best;
}

/* Returns the worst of some unused rows; -1 if their residual, scaled to the whole block, is within the tolerance. */
static PetscInt WorstRow(Cross *c, PetscReal tolerance, PetscReal v[])
{
  const PetscInt stride = PetscMax(1, c->m / CROSS_CHECKS), rows = c->tuple[0];
  PetscReal worst2 = PetscSqr(tolerance) * PetscMax(c->norm2, 0) / (PetscReal)c->m;
  PetscInt worst = -1, j;

  for (PetscInt check = stride / 2; check < c->m; check += stride)
    for (PetscInt i = check / rows * rows; i < check / rows * rows + rows; i++) {
      PetscReal r2;

      if (c->used[i]) continue;
      ResidualRow(c, i, v, NULL, &j);
      r2 = Dot((size_t)c->n, v, v);
      if (r2 <= worst2) continue;
      worst = i;
      worst2 = r2;
    }
  return worst;
}

static PetscErrorCode Run(Cross *c, PetscReal tolerance, PetscInt max, PetscBool *found)
{
  const PetscInt rows = c->tuple[0];
  PetscInt row = 0, j;

  PetscFunctionBegin;
  *found = PETSC_TRUE;
  while (row >= 0) {
    PetscBool small = PETSC_TRUE;

    for (PetscInt r = 0; r < rows; r++) {
      const PetscInt i = row / rows * rows + (row + r) % rows;
      PetscReal *v, size = 0;

      if (c->used[i]) continue;
      if (c->rank >= max) {
        *found = PETSC_FALSE;
        PetscFunctionReturn(PETSC_SUCCESS);
      }
      PetscCall(Grow(c));
      v = c->V + (size_t)c->rank * c->n;
      ResidualRow(c, i, v, c->dot[0], &j);
      c->used[i] = PETSC_TRUE;
      if (v[j] == 0) continue;
      AddCross(c, i, j, &size);
      if (size > tolerance * PetscSqrtReal(PetscMax(c->norm2, 0))) small = PETSC_FALSE;
    }
    PetscCall(Grow(c)); /* room for the check's row */
    row = small ? WorstRow(c, tolerance, c->V + (size_t)c->rank * c->n) : NextRow(c);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Truncates U V' in place with an error of at most tolerance times its norm. */
static PetscErrorCode Recompress(PetscInt m, PetscInt n, PetscReal tolerance, PetscInt *rank, PetscInt *head,
                                 PetscReal U[], PetscReal V[])
{
  const PetscInt k = *rank;
  const size_t kk = (size_t)k * k;
  const PetscScalar one = 1, zero = 0;
  PetscReal *R, *Q, *C, *s, *left, *right, *work, *X, *Y, total = 0, tail = 0, bound;
  PetscBLASInt bk, bm, bn, br, lwork, info;
  PetscInt r = k;

  PetscFunctionBegin;
  *head = k;
  if (!k || k > PetscMin(m, n)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscBLASIntCast(k, &bk));
  PetscCall(PetscBLASIntCast(m, &bm));
  PetscCall(PetscBLASIntCast(n, &bn));
  lwork = 10 * bk;
  PetscCall(PetscMalloc7(kk, &R, kk, &Q, kk, &C, k, &s, kk, &left, kk, &right, lwork, &work));
  PetscCall(PetscMalloc2((size_t)m * k, &X, (size_t)n * k, &Y));
  PetscCall(SlipOrthonormalise(bm, bk, U, R));
  PetscCall(SlipOrthonormalise(bn, bk, V, Q));
  PetscCallBLAS("BLASgemm", BLASgemm_("N", "T", &bk, &bk, &bk, &one, R, &bk, Q, &bk, &zero, C, &bk));
  PetscCallBLAS("LAPACKgesvd", LAPACKgesvd_("A", "A", &bk, &bk, C, &bk, s, left, &bk, right, &bk, work, &lwork, &info));
  PetscCheck(!info, PETSC_COMM_SELF, PETSC_ERR_LIB, "LAPACK gesvd: info %d", (int)info);
  for (PetscInt i = 0; i < k; i++) total += s[i] * s[i];
  bound = total * PetscSqr(CROSS_ROUND * tolerance / FLT_EPSILON);
  while (r > 0 && tail + s[r - 1] * s[r - 1] <= PetscSqr(CROSS_TRUNCATE * tolerance) * total) {
    r--;
    tail += s[r] * s[r];
  }
  /* with orthonormal factors, one of them times s, rounding of each factor to single precision changes the block by at
     most half an epsilon of the root of the sum of the terms' s^2 */
  for (*head = r, tail = 0; *head > 0 && tail + s[*head - 1] * s[*head - 1] <= bound;) {
    (*head)--;
    tail += s[*head] * s[*head];
  }
  for (PetscInt j = 0; j < r; j++)
    for (PetscInt i = 0; i < k; i++) left[(size_t)j * k + i] *= s[j];
  PetscCall(PetscBLASIntCast(r, &br));
  if (r) {
    PetscCallBLAS("BLASgemm", BLASgemm_("N", "N", &bm, &br, &bk, &one, U, &bm, left, &bk, &zero, X, &bm));
    PetscCallBLAS("BLASgemm", BLASgemm_("N", "T", &bn, &br, &bk, &one, V, &bn, right, &bk, &zero, Y, &bn));
  }
  PetscCall(PetscArraycpy(U, X, (size_t)m * r));
  PetscCall(PetscArraycpy(V, Y, (size_t)n * r));
  PetscCall(PetscFree2(X, Y));
  PetscCall(PetscFree7(R, Q, C, s, left, right, work));
  *rank = r;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipCrossApproximate(SlipEntriesFn entries, void *ctx, PetscInt row_tuples, PetscInt rows,
                                    PetscInt column_tuples, PetscInt columns, PetscReal tolerance, PetscInt max,
                                    PetscInt *rank, PetscInt *head, PetscReal **U, PetscReal **V, PetscBool *found)
{
  const PetscInt m = row_tuples * rows, n = column_tuples * columns;
  Cross c = {.entries = entries, .ctx = ctx, .m = m, .n = n, .capacity = 16, .tuple = {rows, columns}, .at = {-1, -1}};

  PetscFunctionBegin;
  PetscCall(PetscMalloc2(rows * n, &c.known[0], columns * m, &c.known[1]));
  PetscCall(PetscMalloc1((size_t)c.capacity * m, &c.U));
  PetscCall(PetscMalloc1((size_t)c.capacity * n, &c.V));
  PetscCall(PetscMalloc3(c.capacity, &c.f, c.capacity, &c.dot[0], c.capacity, &c.dot[1]));
  PetscCall(PetscCalloc1(m, &c.used));
  PetscCall(Run(&c, CROSS_SEARCH * tolerance, max, found));
  PetscCall(PetscFree(c.used));
  PetscCall(PetscFree3(c.f, c.dot[0], c.dot[1]));
  PetscCall(PetscFree2(c.known[0], c.known[1]));
  if (!*found) {
    PetscCall(PetscFree(c.U));
    PetscCall(PetscFree(c.V));
  } else
    PetscCall(Recompress(m, n, tolerance, &c.rank, head, c.U, c.V));
  *rank = c.rank;
  *U = c.U;
  *V = c.V;
  PetscFunctionReturn(PETSC_SUCCESS);
}

void SlipCrossSplit(PetscInt m, PetscInt n, PetscReal share, PetscInt most, PetscReal A[], PetscInt *terms,
                    PetscReal U[], PetscReal V[], PetscBool *found)
{
  const size_t all = (size_t)m * n;
  const PetscReal limit = PetscSqr(share) * Dot(all, A, A);

  for (*terms = 0; !(*found = (PetscBool)(Dot(all, A, A) <= limit)) && *terms < most; ++*terms) {
    PetscReal *u = U + (size_t)*terms * m, *v = V + (size_t)*terms * n;
    size_t pivot = 0;

    for (size_t k = 1; k < all; k++)
      if (PetscAbsReal(A[k]) > PetscAbsReal(A[pivot])) pivot = k;
    for (PetscInt i = 0; i < m; i++) u[i] = A[pivot / (size_t)m * m + i];
    for (PetscInt j = 0; j < n; j++) v[j] = A[(size_t)j * m + pivot % (size_t)m] / A[pivot];
    for (PetscInt j = 0; j < n; j++)
      for (PetscInt i = 0; i < m; i++) A[(size_t)j * m + i] -= u[i] * v[j];
  }
}
