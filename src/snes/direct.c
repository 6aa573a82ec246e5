/* Dense direct solve on the sliding set (Cholesky unless the operator is known not to be symmetric), the fastest method
   while that set is small: every rank gathers and factors the block, so that all ranks have the same bits and need no
   further communication. */
#include <slipstep/private/slipsnes.h>
#include <slipstep/private/slipsys.h>
#include <petscblaslapack.h>
#include <slipstep/private/slipwork.h>

/* The largest number of rows whose square is a 32-bit integer, as MPI and LAPACK need */
#define SLIP_DIRECT_MOST 46340

/* Gets B as scale times a dense matrix with stored local rows plus a diagonal: B itself and NULL, or the result of its
   function "MatSlipGetDense_C" (Mat, Mat *, PetscReal *, Vec *). */
static PetscErrorCode SlipGetDense(Mat B, Mat *dense, PetscReal *scale, Vec *diagonal)
{
  PetscBool flg;
  PetscErrorCode (*f)(Mat, Mat *, PetscReal *, Vec *);

  PetscFunctionBegin;
  *dense = NULL;
  *diagonal = NULL;
  *scale = 1.0;
  PetscCall(PetscObjectTypeCompareAny((PetscObject)B, &flg, MATSEQDENSE, MATMPIDENSE, ""));
  if (flg)
    *dense = B;
  else {
    PetscCall(PetscObjectQueryFunction((PetscObject)B, "MatSlipGetDense_C", &f));
    if (f) PetscCall((*f)(B, dense, scale, diagonal));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lists the local and global indices of the sliding cells, with counts and displacements per rank. */
static PetscErrorCode SlipSlidingSet(Vec mask, PetscInt *nloc, PetscInt **loc, PetscMPIInt **counts,
                                     PetscMPIInt **displs, PetscInt **glob)
{
  MPI_Comm comm = PetscObjectComm((PetscObject)mask);
  PetscMPIInt size, mine;
  PetscInt n, rstart, k = 0;
  const PetscScalar *m;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_size(comm, &size));
  PetscCall(VecGetLocalSize(mask, &n));
  PetscCall(VecGetOwnershipRange(mask, &rstart, NULL));
  PetscCall(PetscMalloc3(n, loc, size, counts, size, displs));
  PetscCall(VecGetArrayRead(mask, &m));
  for (PetscInt i = 0; i < n; i++)
    if (m[i] != 0.0) (*loc)[k++] = rstart + i;
  PetscCall(VecRestoreArrayRead(mask, &m));
  *nloc = k;
  PetscCall(PetscMPIIntCast(k, &mine));
  PetscCallMPI(MPI_Allgather(&mine, 1, MPI_INT, *counts, 1, MPI_INT, comm));
  (*displs)[0] = 0;
  for (PetscMPIInt p = 1; p < size; p++) (*displs)[p] = (*displs)[p - 1] + (*counts)[p - 1];
  PetscCall(PetscMalloc1((*displs)[size - 1] + (*counts)[size - 1], glob));
  PetscCallMPI(MPI_Allgatherv(*loc, mine, MPIU_INT, *glob, *counts, *displs, MPIU_INT, comm));
  for (PetscInt i = 0; i < k; i++) (*loc)[i] -= rstart;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds row_i C_ij to the rows of J_ss owned here; both rows of a cell with two components take the one row of C. With
   stride 3, C is scale times every third row of the dense matrix; as normal rows do not slide, no diagonal is added. */
static PetscErrorCode SlipPackCoupling(Mat C, PetscReal scale, PetscInt stride, Vec row, PetscInt nloc,
                                       const PetscInt loc[], PetscInt n, const PetscInt glob[], PetscScalar rows[])
{
  Mat local;
  const PetscInt last = stride - 1;
  PetscInt lda, cells, c;
  const PetscScalar *a, *f;

  PetscFunctionBegin;
  PetscCall(MatDenseGetLocalMatrix(C, &local));
  PetscCall(MatDenseGetLDA(local, &lda));
  PetscCall(MatDenseGetArrayRead(local, &a));
  PetscCall(VecGetLocalSize(row, &c));
  PetscCall(MatGetLocalSize(C, &cells, NULL));
  c = cells ? stride * c / cells : 1;
  PetscCall(VecGetArrayRead(row, &f));
  for (PetscInt j = 0; j < n; j++)
    for (PetscInt i = 0; i < nloc; i++)
      rows[i * n + j] += f[loc[i]] * scale * a[stride * (loc[i] / c) + last + (size_t)lda * glob[j]];
  PetscCall(VecRestoreArrayRead(row, &f));
  PetscCall(MatDenseRestoreArrayRead(local, &a));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Packs the rows of J_ss owned here, n entries each, their right-hand sides, and the diagonal of B in them. */
static PetscErrorCode SlipPackRows(Mat dense, PetscReal scale, Vec diagonal, Vec slope, Vec rhs, PetscInt nloc,
                                   const PetscInt loc[], PetscInt n, const PetscInt glob[], PetscInt first,
                                   PetscScalar rows[], PetscScalar b[], PetscScalar own[])
{
  Mat local;
  PetscInt lda;
  const PetscScalar *a, *d, *f, *more = NULL;
  const SlipArrays arrays[] = {{slope, .read = &d}, {rhs, .read = &f}, {diagonal, .read = &more}};

  PetscFunctionBegin;
  PetscCall(MatDenseGetLocalMatrix(dense, &local));
  PetscCall(MatDenseGetLDA(local, &lda));
  PetscCall(MatDenseGetArrayRead(local, &a));
  PetscCall(SlipArraysGet(3, arrays));
  for (PetscInt j = 0; j < n; j++)
    for (PetscInt i = 0; i < nloc; i++) rows[i * n + j] = scale * a[loc[i] + (size_t)lda * glob[j]];
  for (PetscInt i = 0; i < nloc; i++) {
    own[i] = rows[i * n + first + i] + (more ? more[loc[i]] : 0.0);
    rows[i * n + first + i] += d[loc[i]] + (more ? more[loc[i]] : 0.0);
    b[i] = f[loc[i]];
  }
  PetscCall(SlipArraysRestore(3, arrays));
  PetscCall(MatDenseRestoreArrayRead(local, &a));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the off-diagonal entries of the slope. A cell's components in its plane slide both or not: they are adjacent. */
static PetscErrorCode SlipPackCross(Vec cross, PetscInt block, PetscInt nloc, const PetscInt loc[], PetscInt n,
                                    PetscInt first, PetscScalar rows[])
{
  const PetscScalar *c;

  PetscFunctionBegin;
  PetscCall(VecGetArrayRead(cross, &c));
  for (PetscInt i = 0; i < nloc; i++) {
    const PetscInt k = loc[i] % block;

    if (k < 2) rows[i * n + first + (k ? i - 1 : i + 1)] += c[loc[i] / block];
  }
  PetscCall(VecRestoreArrayRead(cross, &c));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns whether all eigenvalues of A have a positive real part; it overwrites A. */
static PetscErrorCode SlipIsStable(PetscInt n, PetscScalar A[], PetscBool *stable)
{
  PetscBLASInt nb, one = 1, info, size;
  PetscScalar *work, *real, *imaginary;

  PetscFunctionBegin;
  PetscCall(PetscBLASIntCast(n, &nb));
  PetscCall(PetscBLASIntCast(34 * n, &size)); /* for gehrd's blocks of 32 */
  PetscCall(PetscMalloc3(n, &real, n, &imaginary, size, &work));
  LAPACKgeev_("N", "N", &nb, A, &nb, real, imaginary, NULL, &one, NULL, &one, work, &size, &info);
  PetscCheck(info >= 0, PETSC_COMM_SELF, PETSC_ERR_LIB, "geev: argument %d is wrong", (int)-info);
  *stable = info == 0 ? PETSC_TRUE : PETSC_FALSE;
  for (PetscInt i = 0; i < n; i++)
    if (!(real[i] > 0.0)) *stable = PETSC_FALSE;
  PetscCall(PetscFree3(real, imaginary, work));
  PetscCall(SlipWorkFlops(SLIP_WORK_FACTOR, 20.0 * (PetscLogDouble)n * n * n)); /* its time is 30 times LU's */
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Solves by LU for a matrix A, stored by rows, that is known not to be symmetric; D > 0 is the diagonal of B. The real
   parts of the eigenvalues of D^-1 A, which do not depend on the units of rows, must be positive, as they are in a
   short stage. A real eigenvalue passes zero where the stage loses its only solution, as a mode that grows does; a pair
   passes the imaginary axis where a mode oscillates with growing amplitude within the stage. A positive symmetric part
   proves that none has, at half the cost of LU, and almost all stable matrices pass this test. A negative determinant
   proves that one or three have; two leave it positive, and only eigenvalues, at 30 times the cost of LU, show it. */
static PetscErrorCode SlipSolveGeneral(PetscInt n, PetscScalar A[], const PetscScalar D[], PetscScalar b[],
                                       PetscBool *pd)
{
  PetscBLASInt nb, one = 1, info, *pivot;
  PetscScalar *W;
  PetscBool positive = PETSC_FALSE, negative = PETSC_FALSE;

  PetscFunctionBegin;
  PetscCall(PetscBLASIntCast(n, &nb));
  PetscCall(PetscMalloc2(n, &pivot, (size_t)n * n, &W));
  for (PetscInt i = 0; i < n; i++)
    for (PetscInt j = 0; j <= i; j++) W[i * n + j] = 0.5 * (A[i * n + j] + A[j * n + i]);
  LAPACKpotrf_("U", &nb, W, &nb, &info); /* "U" of columns is the lower half of rows */
  PetscCheck(info >= 0, PETSC_COMM_SELF, PETSC_ERR_LIB, "potrf: argument %d is wrong", (int)-info);
  positive = info == 0 ? PETSC_TRUE : PETSC_FALSE;
  PetscCall(SlipWorkFlops(SLIP_WORK_FACTOR, (PetscLogDouble)n * n * n / 3.0));
  for (PetscInt i = 0; i < n && !positive; i++)
    for (PetscInt j = 0; j < n; j++) W[i * n + j] = A[i * n + j] / D[i];
  LAPACKgetrf_(&nb, &nb, A, &nb, pivot, &info);
  PetscCheck(info >= 0, PETSC_COMM_SELF, PETSC_ERR_LIB, "getrf: argument %d is wrong", (int)-info);
  *pd = info == 0 ? PETSC_TRUE : PETSC_FALSE;
  for (PetscInt i = 0; i < n && !positive; i++)
    if ((PetscRealPart(A[(size_t)i * n + i]) < 0.0) != (pivot[i] != i + 1)) negative = (PetscBool)!negative;
  if (negative) *pd = PETSC_FALSE;
  if (*pd && !positive) PetscCall(SlipIsStable(n, W, pd));
  if (*pd) LAPACKgetrs_("T", &nb, &one, A, &nb, pivot, b, &nb, &info);
  PetscCall(PetscFree2(pivot, W));
  PetscCall(SlipWorkFlops(SLIP_WORK_FACTOR, 2.0 * (PetscLogDouble)n * n * n / 3.0 + 2.0 * n * n));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gathers A and b on every rank, and D if A is not symmetric (else NULL); each rank factors and solves. */
static PetscErrorCode SlipGatherSolve(MPI_Comm comm, PetscInt n, PetscInt nloc, const PetscScalar rows[],
                                      const PetscScalar mine[], const PetscScalar diagonal[],
                                      const PetscMPIInt counts[], const PetscMPIInt displs[], PetscScalar A[],
                                      PetscScalar b[], PetscScalar D[], PetscBool *pd)
{
  PetscBLASInt nb, one = 1, info;
  PetscMPIInt size, *cnt, *dsp;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_size(comm, &size));
  PetscCall(PetscMalloc2(size, &cnt, size, &dsp));
  for (PetscMPIInt p = 0; p < size; p++) {
    cnt[p] = counts[p] * (PetscMPIInt)n;
    dsp[p] = displs[p] * (PetscMPIInt)n;
  }
  PetscCallMPI(MPI_Allgatherv(rows, (PetscMPIInt)(nloc * n), MPIU_SCALAR, A, cnt, dsp, MPIU_SCALAR, comm));
  PetscCallMPI(MPI_Allgatherv(mine, (PetscMPIInt)nloc, MPIU_SCALAR, b, counts, displs, MPIU_SCALAR, comm));
  PetscCall(PetscFree2(cnt, dsp));
  if (!D) {
    PetscCall(PetscBLASIntCast(n, &nb));
    LAPACKpotrf_("L", &nb, A, &nb, &info);
    PetscCheck(info >= 0, PETSC_COMM_SELF, PETSC_ERR_LIB, "potrf: argument %d is wrong", (int)-info);
    *pd = info == 0 ? PETSC_TRUE : PETSC_FALSE;
    if (*pd) LAPACKpotrs_("L", &nb, &one, A, &nb, b, &nb, &info);
    PetscCall(SlipWorkFlops(SLIP_WORK_FACTOR, (PetscLogDouble)n * n * n / 3.0 + 2.0 * n * n));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCallMPI(MPI_Allgatherv(diagonal, (PetscMPIInt)nloc, MPIU_SCALAR, D, counts, displs, MPIU_SCALAR, comm));
  PetscCall(SlipSolveGeneral(n, A, D, b, pd));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Solves (B + slope) dx = rhs on the rows where mask is 1; dx is 0 elsewhere. B counts as symmetric unless it is known
   not to be (MAT_SYMMETRIC). See slipsnes.h (private). */
PetscErrorCode SlipDirectSolve(Mat B, Mat C, Vec row, Vec mask, Vec slope, Vec cross, Vec rhs, Vec dx, PetscInt max,
                               PetscBool *done, PetscBool *pd)
{
  MPI_Comm comm = PetscObjectComm((PetscObject)mask);
  Mat dense;
  Vec diagonal;
  PetscReal sum, scale;
  PetscInt n, nloc = 0, block, cells, *loc, *glob;
  PetscMPIInt *counts, *displs, rank;
  PetscScalar *rows, *A, *b, *D, *mine, *own, *y;
  PetscBool told, symmetric;

  PetscFunctionBegin;
  *done = PETSC_FALSE;
  *pd = PETSC_TRUE;
  PetscCall(VecNorm(mask, NORM_1, &sum));
  n = (PetscInt)(sum + 0.5);
  if (n > PetscMin(max, SLIP_DIRECT_MOST)) PetscFunctionReturn(PETSC_SUCCESS);
  if (C) PetscCall(PetscObjectTypeCompareAny((PetscObject)C, &told, MATSEQDENSE, MATMPIDENSE, ""));
  if (C && !told) PetscFunctionReturn(PETSC_SUCCESS);
  if (!n) {
    PetscCall(VecZeroEntries(dx));
    *done = PETSC_TRUE;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(SlipGetDense(B, &dense, &scale, &diagonal));
  if (!dense) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscLogEventBegin(SLIP_Direct, mask, 0, 0, 0));
  SlipWorkBegin(SLIP_SHARE_DIRECT);
  SlipWorkAdd(SLIP_WORK_PACK, (PetscReal)n * (PetscReal)n);
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCall(SlipSlidingSet(mask, &nloc, &loc, &counts, &displs, &glob));
  PetscCall(PetscMalloc6(nloc * n, &rows, nloc, &mine, nloc, &own, n * n, &A, n, &b, n, &D));
  PetscCall(SlipPackRows(dense, scale, diagonal, slope, rhs, nloc, loc, n, glob, displs[rank], rows, mine, own));
  if (cross) {
    PetscCall(VecGetLocalSize(mask, &block));
    PetscCall(VecGetLocalSize(cross, &cells));
    PetscCall(SlipPackCross(cross, block / PetscMax(cells, 1), nloc, loc, n, displs[rank], rows));
  }
  if (C)
    PetscCall(SlipPackCoupling(C, 1, 1, row, nloc, loc, n, glob, rows));
  else if (row)
    PetscCall(SlipPackCoupling(dense, scale, 3, row, nloc, loc, n, glob, rows));
  PetscCall(MatIsSymmetricKnown(dense, &told, &symmetric));
  PetscCall(
    SlipGatherSolve(comm, n, nloc, rows, mine, own, counts, displs, A, b, !row && (!told || symmetric) ? NULL : D, pd));
  if (*pd) {
    PetscCall(VecZeroEntries(dx));
    PetscCall(VecGetArray(dx, &y));
    for (PetscInt i = 0; i < nloc; i++) y[loc[i]] = b[displs[rank] + i];
    PetscCall(VecRestoreArray(dx, &y));
  }
  PetscCall(PetscFree6(rows, mine, own, A, b, D));
  PetscCall(PetscFree(glob));
  PetscCall(PetscFree3(loc, counts, displs));
  SlipWorkEnd();
  PetscCall(PetscLogEventEnd(SLIP_Direct, mask, 0, 0, 0));
  *done = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}
