/*
  The difference between sqrt(K) and its spectral approximation. It is large only near the fault's two ends and has low
  numerical rank; it is stored as W diag(lambda) W' for each parity under the mirror x -> -x (viscosity/sketch.c).
*/
#include <slipstep/rooms/slipmat.h>
#include <slipstep/rooms/slipblas.h>
#include <slipcompat.h>
#include <slipstep/private/slipmatcommon.h>
#include <slipstep/private/slipwork.h>

/* Fills a with uniform numbers in (-1, 1) by a linear congruential generator (Knuth's MMIX constants). */
void SlipRandomFill(size_t count, PetscReal a[], uint64_t *state)
{
  for (size_t i = 0; i < count; i++) {
    *state = *state * 6364136223846793005ULL + 1442695040888963407ULL;
    a[i] = (PetscReal)(*state >> 11) / 4503599627370496.0 - 1.0;
  }
}

/* Orthonormalises the columns of Y (n x r, column-major, r <= n) in place, by its QR factorisation; R [r * r]: its
   triangle, or NULL. */
PetscErrorCode SlipOrthonormalise(PetscBLASInt n, PetscBLASInt r, PetscReal Y[], PetscReal R[])
{
  PetscBLASInt info, lwork = 64 * r;
  PetscReal *tau, *work;

  PetscFunctionBegin;
  PetscCall(PetscMalloc2(r, &tau, lwork, &work));
  PetscCallBLAS("LAPACKgeqrf", LAPACKgeqrf_(&n, &r, Y, &n, tau, work, &lwork, &info));
  PetscCheck(!info, PETSC_COMM_SELF, PETSC_ERR_LIB, "LAPACK geqrf failed (info %d)", (int)info);
  for (PetscInt j = 0; j < r && R; j++)
    for (PetscInt i = 0; i < r; i++) R[(size_t)j * r + i] = i <= j ? Y[(size_t)j * n + i] : 0;
  PetscCallBLAS("LAPACKorgqr", LAPACKorgqr_(&n, &r, &r, Y, &n, tau, work, &lwork, &info));
  PetscCheck(!info, PETSC_COMM_SELF, PETSC_ERR_LIB, "LAPACK orgqr failed (info %d)", (int)info);
  PetscCall(PetscFree2(tau, work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sorts eigenpairs by decreasing |lambda| and copies those above cutoff from Q (n x r) to W (n x rank). */
PetscErrorCode SlipLowRankSelect(PetscInt n, PetscInt r, const PetscReal Q[], const PetscReal values[],
                                 PetscReal cutoff, SlipLowRank *m)
{
  PetscReal *size;
  PetscInt *order;

  PetscFunctionBegin;
  PetscCall(PetscMalloc2(r, &size, r, &order));
  for (PetscInt k = 0; k < r; k++) {
    size[k] = -PetscAbsReal(values[k]);
    order[k] = k;
  }
  PetscCall(PetscSortRealWithPermutation(r, size, order));
  for (m->rank = 0; m->rank < r && PetscAbsReal(values[order[m->rank]]) > cutoff;) m->rank++;
  PetscCall(PetscMalloc1((size_t)n * m->rank, &m->W));
  PetscCall(PetscMalloc1(m->rank, &m->lambda));
  for (PetscInt k = 0; k < m->rank; k++) {
    PetscCall(PetscArraycpy(m->W + (size_t)k * n, Q + (size_t)order[k] * n, n));
    m->lambda[k] = values[order[k]];
  }
  PetscCall(PetscFree2(size, order));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Stores terms with |lambda| <= limit in single precision: memory limits the speed of products, and a rounding of 1e-7
   of a term that is 4e-6 of the whole is below 1e-12. */
PetscErrorCode SlipLowRankDemote(SlipLowRank *m, PetscReal limit)
{
  const size_t n = (size_t)m->n;
  PetscReal *head;

  PetscFunctionBegin;
  for (m->head = 0; m->head < m->rank && PetscAbsReal(m->lambda[m->head]) > limit;) m->head++;
  PetscCall(PetscMalloc1(n * m->head, &head));
  PetscCall(PetscMalloc1(n * (m->rank - m->head), &m->tail));
  PetscCall(PetscArraycpy(head, m->W, n * m->head));
  for (size_t i = 0; i < n * (m->rank - m->head); i++) m->tail[i] = (float)m->W[n * m->head + i];
  PetscCall(PetscFree(m->W));
  m->W = head;
  PetscCall(PetscMalloc1(m->rank, &m->t));
  PetscCall(PetscMalloc2(m->rank, &m->t32, n, &m->x32));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipLowRankDestroy(SlipLowRank *m)
{
  PetscFunctionBegin;
  PetscCall(PetscFree(m->W));
  PetscCall(PetscFree(m->tail));
  PetscCall(PetscFree(m->lambda));
  PetscCall(PetscFree(m->t));
  PetscCall(PetscFree2(m->t32, m->x32));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Products with tall matrices are divided into pieces of 8,192 entries: OpenBLAS starts threads from 9,216, which cost
   more than they save at these sizes, and a hundred times more if another process uses a core. */
#define ROWS_PER_PIECE 1024
#define COLUMNS_PER_PIECE 8

/* Computes y += A x ("N") or y += A' x ("T"), where A is n x r with column stride n, in either precision. */
#define DEFINE_TALL_GEMV(Name, Number, gemv)                                                                           \
  static void Name(const char *trans, PetscInt n, PetscInt r, const Number A[], const Number x[], Number y[])          \
  {                                                                                                                    \
    const Number one = 1;                                                                                              \
    const PetscBLASInt stride = (PetscBLASInt)n, inc = 1;                                                              \
    const PetscBool transposed = (PetscBool)(*trans == 'T');                                                           \
                                                                                                                       \
    for (PetscInt i = 0; i < n; i += ROWS_PER_PIECE)                                                                   \
      for (PetscInt k = 0; k < r; k += COLUMNS_PER_PIECE) {                                                            \
        const PetscBLASInt rows = (PetscBLASInt)PetscMin(ROWS_PER_PIECE, n - i);                                       \
        const PetscBLASInt columns = (PetscBLASInt)PetscMin(COLUMNS_PER_PIECE, r - k);                                 \
                                                                                                                       \
        gemv(trans, &rows, &columns, &one, A + (size_t)k * n + i, &stride, transposed ? x + i : x + k, &inc, &one,     \
             transposed ? y + k : y + i, &inc);                                                                        \
      }                                                                                                                \
  }

DEFINE_TALL_GEMV(TallGemv, PetscReal, BLASgemv_)
DEFINE_TALL_GEMV(TallGemvSingle, float, SLIP_sgemv)

/* Computes t = W' x for the first r terms of the tail; x is scaled to its largest entry so that single precision
   neither overflows nor underflows. */
static void TailForward(SlipLowRank *m, PetscInt r, const PetscReal x[])
{
  const PetscInt n = m->n;
  PetscReal size = 0;

  for (PetscInt i = 0; i < n; i++) size = PetscMax(size, PetscAbsReal(x[i]));
  for (PetscInt k = 0; k < r; k++) m->t32[k] = 0;
  for (PetscInt i = 0; i < n && size > 0; i++) m->x32[i] = (float)(x[i] / size);
  if (size > 0) TallGemvSingle("T", n, r, m->tail, m->x32, m->t32);
  for (PetscInt k = 0; k < r; k++) m->t[m->head + k] = size * (PetscReal)m->t32[k];
}

/* Computes y += W t for the same terms, with t scaled in the same way. */
static void TailBackward(SlipLowRank *m, PetscInt r, PetscReal y[])
{
  const PetscInt n = m->n;
  const PetscReal *t = m->t + m->head;
  PetscReal size = 0;

  for (PetscInt k = 0; k < r; k++) size = PetscMax(size, PetscAbsReal(t[k]));
  if (!(size > 0)) return;
  for (PetscInt k = 0; k < r; k++) m->t32[k] = (float)(t[k] / size);
  for (PetscInt i = 0; i < n; i++) m->x32[i] = 0;
  TallGemvSingle("N", n, r, m->tail, m->t32, m->x32);
  for (PetscInt i = 0; i < n; i++) y[i] += size * (PetscReal)m->x32[i];
}

/* Computes y += W lambda W' x without terms |lambda| <= cutoff; the ranks of comm share the rows of W. Collective. */
PetscErrorCode SlipLowRankApply(SlipLowRank *m, MPI_Comm comm, PetscReal cutoff, const PetscReal x[], PetscReal y[])
{
  PetscMPIInt size;
  PetscInt rank = m->rank, head;

  PetscFunctionBegin;
  while (rank > 0 && PetscAbsReal(m->lambda[rank - 1]) <= cutoff) rank--;
  head = PetscMin(rank, m->head);
  for (PetscInt k = 0; k < head; k++) m->t[k] = 0;
  TallGemv("T", m->n, head, m->W, x, m->t);
  if (rank > head) TailForward(m, rank - head, x);
  PetscCallMPI(MPI_Comm_size(comm, &size));
  if (size > 1) PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, m->t, (int)rank, MPIU_REAL, MPI_SUM, comm));
  for (PetscInt k = 0; k < rank; k++) m->t[k] *= m->lambda[k];
  TallGemv("N", m->n, head, m->W, m->t, y);
  if (rank > head) TailBackward(m, rank - head, y);
  PetscCall(SlipWorkFlops(SLIP_WORK_HIERARCHY, 4.0 * (PetscLogDouble)m->n * (PetscLogDouble)rank));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns diagonal entry i. */
PetscReal SlipLowRankDiagonal(const SlipLowRank *m, PetscInt i)
{
  PetscReal sum = 0;

  for (PetscInt k = 0; k < m->rank; k++) {
    const PetscReal w = k < m->head ? m->W[(size_t)k * m->n + i] : (PetscReal)m->tail[(size_t)(k - m->head) * m->n + i];

    sum += m->lambda[k] * w * w;
  }
  return sum;
}
