/*
  Products of a wavenumber's real block with a complex field of depth. Blocks of all wavenumbers do not fit into fast memory,
  so that a product takes as long as reading them: once each, real and imaginary parts at a time, and half of symmetric ones.
*/
#include <slipmat.h>
#include <stdlib.h>
#include <slipstep/private/slipmatgrid.h>

/* From the start of a line of cache on, which a vector of eight numbers fills; free with free(). */
PetscErrorCode SlipAllocateLines(size_t count, PetscReal **a)
{
  PetscFunctionBegin;
  *a = (PetscReal *)aligned_alloc(64, (count + 7) / 8 * 64);
  PetscCheck(*a, PETSC_COMM_SELF, PETSC_ERR_MEM, "No memory for %zu numbers", count);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* For the machine that the program meets, not only for the one that compiled it */
#if defined(__x86_64__) && defined(__gnu_linux__) && defined(__GNUC__) && !defined(__clang__) &&                       \
  !defined(__SANITIZE_ADDRESS__)
  #define VECTOR __attribute__((target_clones("avx512f", "avx2,fma", "default")))
#else
  #define VECTOR
#endif

/* Eight numbers, wherever they lie */
typedef double Eight __attribute__((vector_size(64), aligned(8), may_alias));
#define EIGHT(p) (*(Eight *)(p))

/* What the next columns need, on its way from memory: a quarter less time than with what the machine foresees by itself
   (measured: 401 blocks of 100 x 100 in 3.1 ms, where reading them takes 2.5 ms, dgemm 4.0 ms and two dgemv 7.3 ms) */
#define AHEAD(p) __builtin_prefetch(p)

/* Of 8 vectors, their sums */
static inline __attribute__((always_inline)) void Sums(const Eight a[8], PetscReal sums[8])
{
  Eight b[4], c[2];

  for (int i = 0; i < 4; i++)
    b[i] = __builtin_shufflevector(a[2 * i], a[2 * i + 1], 0, 8, 2, 10, 4, 12, 6, 14) +
           __builtin_shufflevector(a[2 * i], a[2 * i + 1], 1, 9, 3, 11, 5, 13, 7, 15);
  for (int i = 0; i < 2; i++)
    c[i] = __builtin_shufflevector(b[2 * i], b[2 * i + 1], 0, 1, 8, 9, 4, 5, 12, 13) +
           __builtin_shufflevector(b[2 * i], b[2 * i + 1], 2, 3, 10, 11, 6, 7, 14, 15);
  EIGHT(sums) = __builtin_shufflevector(c[0], c[1], 0, 1, 2, 3, 8, 9, 10, 11) +
                __builtin_shufflevector(c[0], c[1], 4, 5, 6, 7, 12, 13, 14, 15);
}

/* y += A x in two vectors of length n for four columns a of the symmetric A, from j on, which lie apart, in rows i0 to
   i0 + 7, and y += A' x as well for rows from i0 + 8 on, as far as a multiple of 8. */
static inline __attribute__((always_inline)) void FourColumns(PetscInt n, PetscInt i0, PetscInt j, const PetscReal a[],
                                                              PetscInt apart, const PetscReal x[], PetscReal y[])
{
  const PetscReal *x2 = x + n;
  PetscReal *y2 = y + n, sums[8];
  Eight dot[8] = {{0}, {0}, {0}, {0}, {0}, {0}, {0}, {0}};
  Eight y0 = EIGHT(y + i0), y20 = EIGHT(y2 + i0);

  for (int c = 0; c < 4; c++) {
    const Eight entries = EIGHT(a + c * apart + i0);

    y0 += entries * x[j + c];
    y20 += entries * x2[j + c];
  }
  EIGHT(y + i0) = y0;
  EIGHT(y2 + i0) = y20;
  if (i0 + 16 > n) return;
  for (PetscInt i = i0 + 8; i + 8 <= n; i += 8) {
    const Eight xi = EIGHT(x + i), x2i = EIGHT(x2 + i);
    Eight yi = EIGHT(y + i), y2i = EIGHT(y2 + i);

    for (int c = 0; c < 4; c++) {
      const Eight entries = EIGHT(a + c * apart + i);

      AHEAD(a + (4 + c) * apart + i);
      yi += entries * x[j + c];
      y2i += entries * x2[j + c];
      dot[c] += entries * xi;
      dot[4 + c] += entries * x2i;
    }
    EIGHT(y + i) = yi;
    EIGHT(y2 + i) = y2i;
  }
  Sums(dot, sums);
  for (int c = 0; c < 4; c++) {
    y[j + c] += sums[c];
    y2[j + c] += sums[4 + c];
  }
}

/* A column in full: y += A x, and y[j] += A' x for rows below most */
static inline __attribute__((always_inline)) void OneColumn(PetscInt n, PetscInt most, PetscInt j, const PetscReal a[],
                                                            const PetscReal x[], PetscReal y[])
{
  const PetscReal xj = x[j];
  PetscReal sum = 0;

  for (PetscInt i = 0; i < n; i++) y[i] += a[i] * xj;
  for (PetscInt i = 0; i < most; i++) sum += a[i] * x[i];
  y[j] += sum;
}

/* f = A f for n complex numbers f, A [n][n] real and symmetric or half of it; column [4][n] is room for real and imaginary
   parts. Half of A is read, once: blocks of many wavenumbers do not fit into fast memory otherwise. */
VECTOR static void SymmetricProduct(PetscInt n, PetscBool half, const PetscReal A[], PetscReal f[], PetscReal column[])
{
  const PetscInt most = n - n % 8;
  PetscReal *x = column, *x2 = x + n, *y = x2 + n, *y2 = y + n;

  for (PetscInt i = 0; i < n; i++) {
    x[i] = f[2 * i];
    x2[i] = f[2 * i + 1];
    y[i] = y2[i] = 0;
  }
  for (PetscInt j = 0; j < most; j += 4) {
    const PetscInt i0 = j - j % 8, apart = half ? n - i0 : n;

    FourColumns(n, i0, j, half ? A - i0 : A, apart, x, y);
    A += 4 * apart;
  }
  for (PetscInt j = most; j < n; j++, A += n) {
    OneColumn(n, most, j, A, x, y);
    OneColumn(n, most, j, A, x2, y2);
  }
  for (PetscInt i = 0; i < n; i++) {
    f[2 * i] = y[i];
    f[2 * i + 1] = y2[i];
  }
}

/* Half of a symmetric A [n][n] as SlipSymmetricProduct() reads it, one number after the other: columns from the first row of
   their eight on, those left over whole. How many numbers; half may be NULL. */
size_t SlipSymmetricHalf(PetscInt n, const PetscReal A[], PetscReal half[])
{
  size_t count = 0;

  for (PetscInt j = 0; j < n; j++)
    for (PetscInt i = j < n - n % 8 ? j - j % 8 : 0; i < n; i++, count++)
      if (half) half[count] = A[j * n + i];
  return count;
}

/* y += A x in two vectors, of length n and m, for count columns of A [n][m] from j on: each once, all rows at a time */
static inline __attribute__((always_inline)) void Columns(PetscInt m, PetscInt n, PetscInt j, int count,
                                                          const PetscReal A[], const PetscReal x[], PetscReal y[])
{
  const PetscReal *a = A + (size_t)j * m, *x2 = x + n;
  PetscReal *y2 = y + m;
  PetscInt i = 0;

  for (; i + 8 <= m; i += 8) {
    Eight yi = EIGHT(y + i), y2i = EIGHT(y2 + i);

    for (int c = 0; c < count; c++) {
      const Eight entries = EIGHT(a + c * m + i);

      AHEAD(a + (count + c) * m + i);
      yi += entries * x[j + c];
      y2i += entries * x2[j + c];
    }
    EIGHT(y + i) = yi;
    EIGHT(y2 + i) = y2i;
  }
  for (; i < m; i++)
    for (int c = 0; c < count; c++) {
      y[i] += a[c * m + i] * x[j + c];
      y2[i] += a[c * m + i] * x2[j + c];
    }
}

/* g = A f for n complex numbers f and m g, A [n][m] real, one column after the other; column [2][m + n] is room for parts. */
VECTOR static void GeneralProduct(PetscInt m, PetscInt n, const PetscReal A[], const PetscReal f[], PetscReal g[],
                                  PetscReal column[])
{
  PetscReal *x = column, *y = x + 2 * n;
  PetscInt j = 0;

  for (PetscInt i = 0; i < n; i++) {
    x[i] = f[2 * i];
    x[n + i] = f[2 * i + 1];
  }
  for (PetscInt i = 0; i < 2 * m; i++) y[i] = 0;
  for (; j + 8 <= n; j += 8) Columns(m, n, j, 8, A, x, y);
  for (; j < n; j++) Columns(m, n, j, 1, A, x, y);
  for (PetscInt i = 0; i < m; i++) {
    g[2 * i] = y[i];
    g[2 * i + 1] = y[m + i];
  }
}

/* Versions for several machines are of static functions: others would be names of the library. */
void SlipSymmetricProduct(PetscInt n, PetscBool half, const PetscReal A[], PetscReal f[], PetscReal column[])
{
  SymmetricProduct(n, half, A, f, column);
}

void SlipGeneralProduct(PetscInt m, PetscInt n, const PetscReal A[], const PetscReal f[], PetscReal g[],
                        PetscReal column[])
{
  GeneralProduct(m, n, A, f, g, column);
}
