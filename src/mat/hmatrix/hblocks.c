/*
  Blocks of a hierarchical matrix in the order in which products read them. Memory limits the speed of products, so that
  the bytes of a block matter: numbers are in single precision where rounding changes the matrix by less than the
  tolerance, and all arithmetic is in double precision (Amestoy et al. 2022, IMA J. Numer. Anal. 43; Kriemann 2023,
  arXiv 2308.10960). Rounding leaves the matrix linear and symmetric, as Krylov methods need.

  A block is a sum of terms u v' and of the rest. The first terms are in double precision. The rest is terms in single
  precision, or a full matrix in single or, without terms, in double precision.

  BLAS has no products of mixed precision, and would read a block twice if it also represents its transpose.
*/
#include <petscmat.h>
#include <slipcompat.h>
#include <slipstep/private/slipmathmatrix.h>

/* Columns begin at multiples of so many rows, with zeros after the last row. */
#define PAD SLIP_HBLOCK_PAD

static inline __attribute__((always_inline)) PetscInt Padded(PetscInt m)
{
  return (m + PAD - 1) / PAD * PAD;
}

/* Four numbers at any address, in double or in single precision. Each is converted by itself, because the compiler
   splits a conversion of vectors before it knows the processor, which takes 1.7 times as long (measured). */
typedef PetscReal Four __attribute__((vector_size(4 * sizeof(PetscReal)), aligned(sizeof(PetscReal)), may_alias));
#define FOUR(p) (*(Four *)(p))
#define FOUR_SINGLE(p)                                                                                                 \
  (Four)                                                                                                               \
  {                                                                                                                    \
    (p)[0], (p)[1], (p)[2], (p)[3]                                                                                     \
  }

static inline __attribute__((always_inline)) PetscReal Sum(Four a)
{
  return (a[0] + a[1]) + (a[2] + a[3]);
}

#define ROW(offset) (single ? FOUR_SINGLE(s + i + (offset)) : FOUR(a + i + (offset)))

/* Products() with four columns of A from number `at` on. With two or three columns the last one is read again and
   counts as 0, because single columns would wait for their sums. */
static inline __attribute__((always_inline)) void ApplyFour(PetscBool single, PetscBool sums, PetscBool dots,
                                                            PetscInt columns, PetscInt m, const void *A, size_t at,
                                                            const PetscReal t[], PetscReal y[], const PetscReal x[],
                                                            PetscReal z[])
{
  const size_t second = (size_t)m, third = (columns > 2 ? 2 : 1) * second, fourth = (size_t)(columns - 1) * second;
  const PetscReal *a = (const PetscReal *)A + at;
  const PetscReal f[4] = {sums ? t[0] : 0, sums ? t[1] : 0, sums && columns > 2 ? t[2] : 0,
                          sums && columns > 3 ? t[3] : 0};
  const float *s = (const float *)A + at;
  Four p = {0}, q = {0}, r = {0}, u = {0};

  for (PetscInt i = 0; i < m; i += PAD) {
    const Four c0 = ROW(0), c1 = ROW(second), c2 = ROW(third), c3 = ROW(fourth);

    if (sums) FOUR(y + i) = (FOUR(y + i) + c0 * f[0] + c1 * f[1]) + (c2 * f[2] + c3 * f[3]);
    if (dots) {
      const Four v = FOUR(x + i);

      p += c0 * v;
      q += c1 * v;
      r += c2 * v;
      u += c3 * v;
    }
  }
  if (dots) {
    z[0] = Sum(p);
    z[1] = Sum(q);
    z[2] = Sum(r);
    z[3] = Sum(u);
  }
}

static inline __attribute__((always_inline)) void ApplyOne(PetscBool single, PetscBool sums, PetscBool dots, PetscInt m,
                                                           const void *A, size_t at, const PetscReal t[], PetscReal y[],
                                                           const PetscReal x[], PetscReal z[])
{
  const PetscReal *a = (const PetscReal *)A + at, f = sums ? t[0] : 0;
  const float *s = (const float *)A + at;
  Four p = {0};

  for (PetscInt i = 0; i < m; i += PAD) {
    const Four c0 = ROW(0);

    if (sums) FOUR(y + i) += c0 * f;
    if (dots) p += c0 * FOUR(x + i);
  }
  if (dots) z[0] = Sum(p);
}

/* Computes y += A t if sums is set, and z := A' x, which has room for n + ROOM numbers, if dots is set; A [m * n] is
   column-major, m is a multiple of PAD, and A is read once. */
#define ROOM 2
static inline __attribute__((always_inline)) void Products(PetscBool single, PetscBool sums, PetscBool dots, PetscInt m,
                                                           PetscInt n, const void *A, const PetscReal t[],
                                                           PetscReal y[], const PetscReal x[], PetscReal z[])
{
  PetscInt j = 0;

  for (; j + 4 <= n; j += 4)
    ApplyFour(single, sums, dots, 4, m, A, (size_t)j * m, sums ? t + j : NULL, y, x, dots ? z + j : NULL);
  if (j + 1 < n)
    ApplyFour(single, sums, dots, n - j, m, A, (size_t)j * m, sums ? t + j : NULL, y, x, dots ? z + j : NULL);
  else if (j < n)
    ApplyOne(single, sums, dots, m, A, (size_t)j * m, sums ? t + j : NULL, y, x, dots ? z + j : NULL);
}

/* Applies terms u v' in one precision; t [2 (n + ROOM)] is work. */
static inline __attribute__((always_inline)) void ApplyTerms(PetscBool single, PetscInt terms, const SlipHBlock *k,
                                                             const void *U, const void *V, PetscBool both,
                                                             const PetscReal x[], PetscReal y[], PetscReal t[])
{
  const PetscInt m = Padded(k->m), n = Padded(k->n);
  PetscReal *s = t + terms + ROOM;

  if (both) {
    Products(single, PETSC_FALSE, PETSC_TRUE, m, terms, U, NULL, NULL, x + k->row, s);
    Products(single, PETSC_TRUE, PETSC_TRUE, n, terms, V, s, y + k->column, x + k->column, t);
  } else
    Products(single, PETSC_FALSE, PETSC_TRUE, n, terms, V, NULL, NULL, x + k->column, t);
  Products(single, PETSC_TRUE, PETSC_FALSE, m, terms, U, t, y + k->row, NULL, NULL);
}

/* Applies the rest in one precision; t [n + ROOM] is work. */
static inline __attribute__((always_inline)) void ApplyFull(PetscBool single, const SlipHBlock *k, const void *A,
                                                            PetscBool both, const PetscReal x[], PetscReal y[],
                                                            PetscReal t[])
{
  const PetscInt m = Padded(k->m), n = k->n;

  if (!both) {
    Products(single, PETSC_TRUE, PETSC_FALSE, m, n, A, x + k->column, y + k->row, NULL, NULL);
    return;
  }
  Products(single, PETSC_TRUE, PETSC_TRUE, m, n, A, x + k->column, y + k->row, x + k->row, t);
  for (PetscInt j = 0; j < n; j++) y[k->column + j] += t[j];
}

/*
  SlipHBlocksApply - computes y += (each block and, off the diagonal and unless whole, its transpose) x

  x and y are in the order of the blocks' rows and columns, with SLIP_HBLOCK_PAD numbers after the last one, zeros in x;
  t has room for SlipHBlockWork() of each block
*/
SLIP_VECTOR void SlipHBlocksApply(PetscInt nblocks, const SlipHBlock block[], PetscBool whole, const PetscReal x[],
                                  PetscReal y[], PetscReal t[])
{
  for (PetscInt b = 0; b < nblocks; b++) {
    const SlipHBlock *k = &block[b];
    const size_t m = (size_t)Padded(k->m), n = (size_t)Padded(k->n);
    const PetscBool both = (PetscBool)(!whole && k->row != k->column);
    const PetscReal *U = k->data, *V = U + k->head * m, *rest = V + k->head * n;
    const float *u = (const float *)rest;

    if (k->head) ApplyTerms(PETSC_FALSE, k->head, k, U, V, both, x, y, t);
    if (k->rank >= 0)
      ApplyTerms(PETSC_TRUE, k->rank - k->head, k, u, u + (k->rank - k->head) * m, both, x, y, t);
    else if (k->single)
      ApplyFull(PETSC_TRUE, k, rest, both, x, y, t);
    else
      ApplyFull(PETSC_FALSE, k, rest, both, x, y, t);
  }
}

/* Returns how many numbers products with a block need as work. */
PetscInt SlipHBlockWork(const SlipHBlock *k)
{
  return PetscMax(2 * (PetscMax(k->rank, k->head) + ROOM), k->rank < 0 ? k->n + ROOM : 0);
}

/* Returns how many multiplications and additions a product with a block takes, without its transpose. */
PetscLogDouble SlipHBlockFlops(const SlipHBlock *k)
{
  const PetscLogDouble m = (PetscLogDouble)k->m, n = (PetscLogDouble)k->n;

  return 2 * (k->rank < 0 ? m * n + k->head * (m + n) : k->rank * (m + n));
}

/* Counts the numbers in double and in single precision. */
static void Count(const SlipHBlock *k, size_t count[2])
{
  const size_t m = (size_t)Padded(k->m), n = (size_t)Padded(k->n);
  const size_t rest = k->rank < 0 ? m * (size_t)k->n : (size_t)(k->rank - k->head) * (m + n);
  const PetscBool single = (PetscBool)(k->rank >= 0 || k->single);

  count[0] = (size_t)k->head * (m + n) + (single ? 0 : rest);
  count[1] = single ? rest : 0;
}

PetscReal SlipHBlockBytes(const SlipHBlock *k)
{
  size_t count[2];

  Count(k, count);
  return (PetscReal)(sizeof(PetscReal) * count[0] + sizeof(float) * count[1]);
}

/* Copies A [m * n] to padded columns in one precision or the other, and moves *at behind them. */
static void Put(PetscBool single, PetscInt m, PetscInt n, const PetscReal A[], void **at)
{
  const size_t padded = (size_t)Padded(m), all = padded * (size_t)n;
  PetscReal *a = (PetscReal *)*at;
  float *s = (float *)*at;

  for (size_t k = 0; k < all; k++) {
    const size_t i = k % padded, j = k / padded;
    const PetscReal value = i < (size_t)m ? A[j * (size_t)m + i] : 0;

    if (single)
      s[k] = (float)value;
    else
      a[k] = value;
  }
  *at = single ? (void *)(s + all) : (void *)(a + all);
}

/*
  SlipHBlockStore - stores a block's numbers in its own memory, data (PetscFree())

  k has the block's place, size and kind; U [m * rank] and V [n * rank] are its terms, or the head terms of a full
  block, whose rest is A [m * n]
*/
PetscErrorCode SlipHBlockStore(SlipHBlock *k, const PetscReal U[], const PetscReal V[], const PetscReal A[])
{
  const PetscInt head = k->head, tail = k->rank - head;
  size_t count[2];
  void *at;

  PetscFunctionBegin;
  Count(k, count);
  PetscCall(PetscMalloc1(count[0] + (count[1] + 1) / 2, &k->data));
  at = k->data;
  Put(PETSC_FALSE, k->m, head, U, &at);
  Put(PETSC_FALSE, k->n, head, V, &at);
  if (k->rank < 0)
    Put(k->single, k->m, k->n, A, &at);
  else {
    Put(PETSC_TRUE, k->m, tail, U + (size_t)head * k->m, &at);
    Put(PETSC_TRUE, k->n, tail, V + (size_t)head * k->n, &at);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
