/* Internal header of src/mat: dense and low-rank matrices, and common parts of shell matrices */
#pragma once
#include <slipstep/rooms/slipmat.h>
#include <slipstep/private/slipstate.h>
#include <slipstep/private/slipsys.h>

/* ---- dense.c: whole matrices on one rank; row-major N * N ---- */
PETSC_INTERN PetscErrorCode SlipDenseGather(Mat A,
                                            PetscReal **entries); /* rank 0 allocates (PetscFree), others get NULL */
PETSC_INTERN PetscErrorCode SlipDenseScatter(MPI_Comm comm, PetscInt nlocal, PetscInt N, const PetscReal *entries,
                                             Mat *A); /* nlocal: rows of this rank, or PETSC_DECIDE */
PETSC_INTERN PetscErrorCode SlipDenseEigen(PetscInt n, PetscReal A[], PetscReal eigenvalues[], PetscInt *info);
/* A := sqrt(A) for a symmetric positive definite A; *smallest is its smallest eigenvalue. One process. */
PETSC_INTERN PetscErrorCode SlipDenseSqrt(PetscInt n, PetscReal A[], PetscReal *smallest, PetscInt *info);

/* ---- shell.c ---- */
PETSC_INTERN PetscErrorCode SlipShellReplace(Mat A, Mat dense, MatReuse reuse, Mat *D);
/* Operations of a matrix-free matrix; diagonal, scale, info, view, state (for checkpoints) and device may be NULL.
   device gets the memory that products need on the device [bytes], and copies the data there if it is used;
   device_mult and device_both then replace mult and MatSlipStiffnessMultBoth_C for vectors there, unless they are NULL.
   */
typedef struct {
  PetscErrorCode (*mult)(Mat, Vec, Vec);
  PetscErrorCode (*diagonal)(Mat, Vec);
  PetscErrorCode (*scale)(Mat, PetscScalar);
  PetscErrorCode (*info)(Mat, MatInfoType, MatInfo *);
  PetscErrorCode (*view)(Mat, PetscViewer);
  PetscErrorCode (*destroy)(Mat);
  PetscErrorCode (*state)(Mat, SlipState);
  PetscErrorCode (*device)(Mat, PetscBool use, PetscReal *bytes);
  PetscErrorCode (*device_mult)(Mat, Vec, Vec);
  PetscErrorCode (*device_both)(Mat, Mat, Vec, Vec, Vec);
  PetscBool unsymmetric; /* without products with the transpose */
} SlipShellOps;
PETSC_INTERN PetscErrorCode SlipShellCreateOfSize(MPI_Comm comm, PetscInt m, PetscInt n, PetscInt M, PetscInt N,
                                                  const char type[], const SlipShellOps *ops, void *ctx, Mat *A);
PETSC_INTERN PetscErrorCode SlipShellCreateLike(Mat K, const char type[], const SlipShellOps *ops, void *ctx,
                                                Mat *A); /* rows and ranks as K */
/* matdevice.c: products on the device */
#define SLIP_DEVICE_METHOD "SlipMatDevice_C"
#define SLIP_DEVICE_MULT "SlipMatDeviceMult_C"
#define SLIP_DEVICE_BOTH "SlipMatDeviceBoth_C"
PETSC_EXTERN PetscErrorCode SlipMatUseDevice(Mat A);
PETSC_EXTERN PetscErrorCode SlipMatDeviceBytes(Mat A, PetscReal *bytes);
/* Gets the diagonal of A; on a device it is computed once and stored, in *stored. */
PETSC_INTERN PetscErrorCode SlipMatGetDiagonal(Mat A, Vec *stored, Vec d);
/* Texts of a matrix for -fault_view, attached by name: why its type was chosen, and what the cache did */
PETSC_INTERN PetscErrorCode SlipNote(Mat A, const char name[], const char format[], ...);
/* H = factor sqrt(K); 0 if H is not from MatCreateSlipViscosity() or is zero */
PETSC_INTERN PetscErrorCode SlipViscosityComposeFactor(Mat H, PetscReal factor);
PETSC_INTERN PetscErrorCode SlipViscosityGetFactor(Mat H, PetscReal *factor);
/* report.c: MATOP_GETINFO of a shell matrix calls the first one, so that views show its memory. */
PETSC_INTERN PetscErrorCode SlipInfoFill(Mat A, PetscReal bytes, MatInfoType flag, MatInfo *info);

/* ---- lowrank.c: symmetric low-rank matrices W diag(lambda) W', by decreasing |lambda|; initialise to zero ---- */
typedef struct {
  PetscInt n, rank, head; /* order, number of terms, number of them in double precision */
  PetscReal *W;           /* [n * head], column-major; [n * rank] before SlipLowRankDemote() */
  float *tail;            /* [n * (rank - head)] */
  PetscReal *lambda;      /* [rank] */
  PetscReal *t;           /* scratch [rank] */
  float *t32, *x32;       /* scratch [rank], [n] */
} SlipLowRank;
PETSC_INTERN PetscErrorCode SlipLowRankSelect(PetscInt n, PetscInt r, const PetscReal Q[], const PetscReal values[],
                                              PetscReal cutoff, SlipLowRank *m);
PETSC_INTERN PetscErrorCode SlipOrthonormalise(PetscBLASInt n, PetscBLASInt r, PetscReal Y[], PetscReal R[]);
PETSC_INTERN void SlipRandomFill(size_t count, PetscReal a[], uint64_t *state); /* uniform in (-1, 1) */
PETSC_INTERN PetscErrorCode SlipLowRankDemote(SlipLowRank *m, PetscReal limit);
PETSC_INTERN PetscErrorCode SlipLowRankDestroy(SlipLowRank *m);
PETSC_INTERN PetscErrorCode SlipLowRankApply(SlipLowRank *m, MPI_Comm comm, PetscReal cutoff, const PetscReal x[],
                                             PetscReal y[]);
PETSC_INTERN PetscReal SlipLowRankDiagonal(const SlipLowRank *m, PetscInt i);
