/* The few routines of BLAS that training uses, in the C interface's order and by its names, on the BLAS of PETSc: that
   has not always a C interface. A row-major matrix is the transpose of a column-major one, as in the interface itself,
   so that the numbers are the same to the last bit. */
#pragma once
#include <petscsys.h>
#include <slipstep/rooms/slipblas.h>

enum { CblasRowMajor = 101 };
typedef enum { CblasNoTrans = 111, CblasTrans = 112 } RowTranspose;
enum { CblasUpper = 121 };

/* C (m, n) = alpha A B + beta C */
#define DEFINE_ROW_GEMM(name, Real, gemm)                                                                              \
  static inline void name(int order, RowTranspose ta, RowTranspose tb, PetscBLASInt m, PetscBLASInt n, PetscBLASInt k, \
                          Real alpha, const Real *A, PetscBLASInt lda, const Real *B, PetscBLASInt ldb, Real beta,     \
                          Real *C, PetscBLASInt ldc)                                                                   \
  {                                                                                                                    \
    (void)order;                                                                                                       \
    gemm(tb == CblasTrans ? "T" : "N", ta == CblasTrans ? "T" : "N", &n, &m, &k, &alpha, B, &ldb, A, &lda, &beta, C,   \
         &ldc);                                                                                                        \
  }
/* y = alpha A x + beta y with A (m, n) or its transpose */
#define DEFINE_ROW_GEMV(name, Real, gemv)                                                                              \
  static inline void name(int order, RowTranspose t, PetscBLASInt m, PetscBLASInt n, Real alpha, const Real *A,        \
                          PetscBLASInt lda, const Real *x, PetscBLASInt incx, Real beta, Real *y, PetscBLASInt incy)   \
  {                                                                                                                    \
    (void)order;                                                                                                       \
    gemv(t == CblasTrans ? "N" : "T", &n, &m, &alpha, A, &lda, x, &incx, &beta, y, &incy);                             \
  }
DEFINE_ROW_GEMM(cblas_dgemm, double, BLASgemm_)
DEFINE_ROW_GEMM(cblas_sgemm, float, SLIP_sgemm)
DEFINE_ROW_GEMV(cblas_dgemv, double, BLASgemv_)
DEFINE_ROW_GEMV(cblas_sgemv, float, SLIP_sgemv)

static inline void cblas_dsyr(int order, int upper, PetscBLASInt n, double alpha, const double *x, PetscBLASInt incx,
                              double *A, PetscBLASInt lda)
{
  (void)order;
  SLIP_dsyr(upper == CblasUpper ? "L" : "U", &n, &alpha, x, &incx, A, &lda);
}

static inline void cblas_daxpy(PetscBLASInt n, double alpha, const double *x, PetscBLASInt incx, double *y,
                               PetscBLASInt incy)
{
  BLASaxpy_(&n, &alpha, x, &incx, y, &incy);
}

static inline void cblas_dscal(PetscBLASInt n, double alpha, double *x, PetscBLASInt incx)
{
  BLASscal_(&n, &alpha, x, &incx);
}

static inline double cblas_ddot(PetscBLASInt n, const double *x, PetscBLASInt incx, const double *y, PetscBLASInt incy)
{
  return BLASdot_(&n, x, &incx, y, &incy);
}

static inline double cblas_dnrm2(PetscBLASInt n, const double *x, PetscBLASInt incx)
{
  return BLASnrm2_(&n, x, &incx);
}
