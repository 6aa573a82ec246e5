/* Private to src/mat: kernel parts, dense helpers, and what the preconditioner may ask of K, H and B. */
#pragma once
#include <slipmat.h>

/* ---- kernel.c ---- */
PETSC_INTERN void SlipKernelSurface_Private(PetscReal G, PetscReal nu, PetscReal dx, PetscReal depth_sum, PetscReal a,
                                            PetscReal b, PetscReal part[3]);

/* ---- grid.c: the uniform grid behind a stiffness, if it has one ---- */
PETSC_INTERN PetscErrorCode SlipGridCheck(MPI_Comm comm, const SlipGrid *grid);
PETSC_INTERN PetscErrorCode SlipGridCompose(Mat K, const SlipGrid *grid);
PETSC_INTERN PetscErrorCode SlipGridOf(Mat K,
                                       const SlipGrid **grid); /* borrowed; NULL when K is not on a uniform grid */
/* Symmetrised kernel of the grid for all depths, d cells apart along strike: block[iz * nz + jz], unscaled [Pa/m]. */
PETSC_INTERN void SlipGridKernel(const SlipGrid *grid, PetscInt d, PetscReal block[]);

/* What MatScale() has made of a stiffness: K = scale * kernel. Collective. */
PETSC_INTERN PetscErrorCode SlipGridScale(Mat K, PetscReal *scale);

/* ---- mirror.c: even and odd blocks of a grid's operators ---- */
PETSC_INTERN PetscInt SlipMirrorWidth(PetscInt nx, PetscInt parity);
PETSC_INTERN void SlipMirrorSplit(PetscInt nx, PetscInt nz, const PetscReal kernel[], PetscReal scale, PetscInt parity,
                                  PetscReal block[]);
PETSC_INTERN void SlipMirrorMerge(PetscInt nx, PetscInt nz, const PetscReal even[], const PetscReal odd[],
                                  PetscReal A[]);

/* ---- dense.c: whole matrices on one rank; row-major N * N ---- */
PETSC_INTERN PetscErrorCode SlipDenseGather(Mat A,
                                            PetscReal **entries); /* rank 0 allocates (PetscFree), others get NULL */
PETSC_INTERN PetscErrorCode SlipDenseScatter(MPI_Comm comm, PetscInt N, const PetscReal *entries, Mat *A);
PETSC_INTERN PetscErrorCode SlipDenseEigen(PetscInt n, PetscReal A[], PetscReal eigenvalues[], PetscInt *info);
/* A := sqrt(A) for a symmetric positive definite A; *smallest is its smallest eigenvalue. One process. */
PETSC_INTERN PetscErrorCode SlipDenseSqrt(PetscInt n, PetscReal A[], PetscReal *smallest, PetscInt *info);

/* ---- shell.c ---- */
PETSC_INTERN PetscErrorCode SlipShellFinish(Mat A, const char type[]);

/* ---- stage.c: borrowed operands of the stage operator ---- */
PETSC_INTERN PetscErrorCode SlipStageGetOperators(Mat B, Mat *K, Mat *H, PetscReal *mass);
