/* Declarations of BLAS and LAPACK routines that PETSc does not declare, under the names that PETSc's BLAS uses
   (underscores, capitals, suffixes of 64-bit integers). */
#pragma once
#include <petscsys.h>
#include <petscblaslapack.h>

#if defined(PETSC_BLASLAPACK_CAPS)
  #define SLIP_BLAS_FLOAT(x, X) PETSC_PASTE3(S, X, PETSC_BLASLAPACK_SUFFIX_)
#else
  #define SLIP_BLAS_FLOAT(x, X) PETSC_PASTE3(s, x, PETSC_BLASLAPACK_SUFFIX_)
#endif
#define SLIP_sgemv SLIP_BLAS_FLOAT(gemv, GEMV)
#define SLIP_sgemm SLIP_BLAS_FLOAT(gemm, GEMM)
#define SLIP_dsyr PETSCBLAS(syr, SYR)
#define SLIP_dstev PETSCBLAS(stev, STEV)
#define SLIP_dsyevd PETSCBLAS(syevd, SYEVD)

extern void SLIP_sgemv(const char *trans, const PetscBLASInt *m, const PetscBLASInt *n, const float *alpha,
                       const float *a, const PetscBLASInt *lda, const float *x, const PetscBLASInt *incx,
                       const float *beta, float *y, const PetscBLASInt *incy);
extern void SLIP_sgemm(const char *transa, const char *transb, const PetscBLASInt *m, const PetscBLASInt *n,
                       const PetscBLASInt *k, const float *alpha, const float *a, const PetscBLASInt *lda,
                       const float *b, const PetscBLASInt *ldb, const float *beta, float *c, const PetscBLASInt *ldc);
extern void SLIP_dsyr(const char *uplo, const PetscBLASInt *n, const double *alpha, const double *x,
                      const PetscBLASInt *incx, double *a, const PetscBLASInt *lda);
extern void SLIP_dstev(const char *jobz, const PetscBLASInt *n, double *d, double *e, double *z,
                       const PetscBLASInt *ldz, double *work, PetscBLASInt *info);
extern void SLIP_dsyevd(const char *jobz, const char *uplo, const PetscBLASInt *n, double *a, const PetscBLASInt *lda,
                        double *w, double *work, const PetscBLASInt *lwork, PetscBLASInt *iwork,
                        const PetscBLASInt *liwork, PetscBLASInt *info);

/* Sets how many threads BLAS may use in this process, if its BLAS has a function for that. */
PETSC_EXTERN void SlipBLASSetNumThreads(int n);
