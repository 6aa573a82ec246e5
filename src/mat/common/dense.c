/* Whole matrices on one rank: transfer to and from a parallel Mat, and their symmetric eigenproblem. */
#include <slipstep/rooms/slipmat.h>
#include <slipstep/rooms/slipblas.h>
#include <slipcompat.h>
#include <slipstep/private/slipmatcommon.h>
#include <slipstep/private/slipwork.h>

/* Largest number of entries in a message, because MPI counts are int */
#define SLIP_CHUNK 100000000

/* Sends count entries in pieces from one rank to another; a no-op on the others. */
static PetscErrorCode Transfer(MPI_Comm comm, PetscMPIInt from, PetscMPIInt to, PetscReal *data, size_t count)
{
  PetscMPIInt rank;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  for (size_t start = 0; start < count; start += SLIP_CHUNK) {
    const int n = (int)PetscMin(count - start, (size_t)SLIP_CHUNK);

    if (rank == from) PetscCallMPI(MPI_Send(data + start, n, MPIU_REAL, to, 0, comm));
    if (rank == to) PetscCallMPI(MPI_Recv(data + start, n, MPIU_REAL, from, 0, comm, MPI_STATUS_IGNORE));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipDenseGather(Mat A, PetscReal **entries)
{
  MPI_Comm comm = PetscObjectComm((PetscObject)A);
  PetscMPIInt rank, size;
  PetscInt N, m, lda;
  const PetscInt *ranges;
  PetscReal *rows;
  const PetscScalar *a;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCallMPI(MPI_Comm_size(comm, &size));
  PetscCall(MatGetSize(A, &N, NULL));
  PetscCall(MatGetLocalSize(A, &m, NULL));
  PetscCall(MatGetOwnershipRanges(A, &ranges));
  PetscCall(PetscMalloc1((size_t)(rank ? m : N) * (size_t)N, &rows));
  PetscCall(MatDenseGetLDA(A, &lda));
  PetscCall(MatDenseGetArrayRead(A, &a));
  for (PetscInt i = 0; i < m; i++)
    for (PetscInt j = 0; j < N; j++) rows[(size_t)i * N + j] = PetscRealPart(a[(size_t)j * lda + i]);
  PetscCall(MatDenseRestoreArrayRead(A, &a));
  for (PetscMPIInt r = 1; r < size; r++)
    PetscCall(
      Transfer(comm, r, 0, rank ? rows : rows + (size_t)ranges[r] * N, (size_t)(ranges[r + 1] - ranges[r]) * N));
  if (rank) PetscCall(PetscFree(rows));
  *entries = rows;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates a parallel matrix from entries on rank 0; nlocal: rows of this rank, or PETSC_DECIDE. */
PetscErrorCode SlipDenseScatter(MPI_Comm comm, PetscInt nlocal, PetscInt N, const PetscReal *entries, Mat *A)
{
  PetscMPIInt rank, size;
  PetscInt m, lda;
  const PetscInt *ranges;
  PetscReal *rows = (PetscReal *)entries;
  PetscScalar *a;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCallMPI(MPI_Comm_size(comm, &size));
  PetscCall(MatCreateDense(comm, nlocal, nlocal, N, N, NULL, A));
  PetscCall(MatGetLocalSize(*A, &m, NULL));
  PetscCall(MatGetOwnershipRanges(*A, &ranges));
  if (rank) PetscCall(PetscMalloc1((size_t)m * (size_t)N, &rows));
  for (PetscMPIInt r = 1; r < size; r++)
    PetscCall(
      Transfer(comm, 0, r, rank ? rows : rows + (size_t)ranges[r] * N, (size_t)(ranges[r + 1] - ranges[r]) * N));
  PetscCall(MatDenseGetLDA(*A, &lda));
  PetscCall(MatDenseGetArrayWrite(*A, &a));
  for (PetscInt j = 0; j < N; j++)
    for (PetscInt i = 0; i < m; i++) a[(size_t)j * lda + i] = rows[(size_t)i * N + j];
  PetscCall(MatDenseRestoreArrayWrite(*A, &a));
  if (rank) PetscCall(PetscFree(rows));
  PetscCall(MatAssemblyBegin(*A, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(*A, MAT_FINAL_ASSEMBLY));
  PetscCall(MatSetOption(*A, MAT_SYMMETRIC, PETSC_TRUE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

#define SLIP_EIGEN_MOST 32766 /* 1 + 6 n + 2 n^2 < 2^31 */
/* Replaces A (symmetric, n * n) by its orthonormal eigenvectors: column k (contiguous) for eigenvalue k, ascending */
PetscErrorCode SlipDenseEigen(PetscInt n, PetscReal A[], PetscReal eigenvalues[], PetscInt *info)
{
  PetscBLASInt bn, lwork = -1, liwork = -1, isize, binfo;
  PetscBLASInt *iwork;
  PetscReal size, *work;

  PetscFunctionBegin;
  PetscCall(PetscBLASIntCast(n, &bn));
  PetscCheck(sizeof(PetscBLASInt) > 4 || n <= SLIP_EIGEN_MOST, PETSC_COMM_SELF, PETSC_ERR_SUP,
             "LAPACK's integers do not count the work for eigenvectors of %" PetscInt_FMT " rows, expected at most %d",
             n, SLIP_EIGEN_MOST);
  SLIP_dsyevd("V", "U", &bn, A, &bn, eigenvalues, &size, &lwork, &isize, &liwork, &binfo);
  lwork = (PetscBLASInt)size;
  liwork = isize;
  PetscCall(PetscMalloc2(lwork, &work, liwork, &iwork));
  SLIP_dsyevd("V", "U", &bn, A, &bn, eigenvalues, work, &lwork, iwork, &liwork, &binfo);
  PetscCall(PetscFree2(work, iwork));
  SlipWorkAdd(SLIP_WORK_EIGEN, (PetscReal)n * (PetscReal)n * (PetscReal)n);
  *info = binfo;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipDenseSqrt(PetscInt n, PetscReal A[], PetscReal *smallest, PetscInt *info)
{
  const PetscScalar one = 1, zero = 0;
  const size_t nn = (size_t)n * (size_t)n;
  PetscBLASInt bn;
  PetscReal *w, *scaled;

  PetscFunctionBegin;
  PetscCall(PetscBLASIntCast(n, &bn));
  PetscCall(PetscMalloc2(n, &w, nn, &scaled));
  PetscCall(SlipDenseEigen(n, A, w, info));
  *smallest = w[0];
  if (*info == 0 && w[0] > 0) {
    for (PetscInt k = 0; k < n; k++) {
      const PetscReal s = PetscPowReal(w[k], 0.25);

      for (PetscInt i = 0; i < n; i++) scaled[(size_t)k * n + i] = s * A[(size_t)k * n + i];
    }
    PetscCallBLAS("BLASsyrk", BLASsyrk_("U", "N", &bn, &bn, &one, scaled, &bn, &zero, A, &bn));
    for (PetscInt j = 0; j < n; j++)
      for (PetscInt i = 0; i < j; i++) A[(size_t)i * n + j] = A[(size_t)j * n + i];
  }
  PetscCall(PetscFree2(w, scaled));
  PetscFunctionReturn(PETSC_SUCCESS);
}
