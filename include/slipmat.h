/* Stiffness K, viscosity H and stage operator B of a frictional fault as PETSc Mats. Nothing here knows the fault. */
#pragma once
#include <petscmat.h>
#include <petscpc.h>
#include <slipelasticity.h>

/* A uniform grid of nx * nz rectangular cells on a vertical strike-slip plane; cell e = iz * nx + ix (x fastest). */
typedef struct {
  PetscInt nx, nz;     /* number of cells along strike and in depth */
  PetscReal length_x;  /* extent along strike [m] */
  PetscReal length_z;  /* extent in depth [m] */
  PetscReal depth_top; /* depth of the upper edge [m], >= 0; 0 touches the free surface */
  SlipKernel kernel;   /* with SLIP_EVEN_STRIKE */
} SlipGrid;

/* ---- stiffness ----
   type: "dense", "fft" or "auto". The symmetric part (K + K')/2 is used.
   The matrix has N = nx * nz rows; the row distribution is PETSc's default one (PETSC_DECIDE) at every rank count.
   Its diagonal is available through MatGetDiagonal and it converts to MATDENSE for checking. */
PETSC_EXTERN PetscErrorCode MatCreateSlipStiffness(MPI_Comm comm, const SlipGrid *grid, const char *type, Mat *K);
/* A grid of any dip: length_z is along the dip, from the depth depth_top on. */
typedef struct {
  SlipGrid grid;         /* with a kernel that has a row of normal stress, such as SlipKernelDipping */
  PetscReal dip;         /* [deg] */
  const PetscReal *rake; /* [nx * nz] of slip and shear stress [deg]; of vectors of slip not read; not kept */
  PetscReal tolerance;   /* of "hmat": relative error of each low-rank block, in (0, 1); 0: 1e-8 */
} SlipDippingGrid;
/* type: "dense", "fft", "hmat" or "auto". Its stiffness, and unless Kn is NULL what slip does to normal stress:
   compression at the centre of cell i for unit slip on cell j [Pa/m], not symmetric. */
PETSC_EXTERN PetscErrorCode MatCreateSlipDippingStiffness(MPI_Comm comm, const SlipDippingGrid *grid, const char *type,
                                                          Mat *K, Mat *Kn);
/* of a uniform grid of any dip, type dense, hmat, fft, auto, as MatCreateSlipDippingStiffness() (whose rakes do not
   count), for slip and shear traction as vectors: rows and columns 2 i and 2 i + 1 are along strike and up dip of cell
   i; Kn is N x 2 N */
PETSC_EXTERN PetscErrorCode MatCreateSlipDippingVectorStiffness(MPI_Comm comm, const SlipDippingGrid *grid,
                                                                const char *type, Mat *S, Mat *Kn);
/* Of a stiffness with opening, 3 N x 3 N, the N x 3 N rows of normal stress */
PETSC_EXTERN PetscErrorCode MatCreateSlipNormalRows(Mat S, Mat *Kn);
/* f = K u and n = Kn u, with what both need of u computed once; Kn as made with K, or any other. */
PETSC_EXTERN PetscErrorCode MatSlipStiffnessMultBoth(Mat K, Mat Kn, Vec u, Vec f, Vec n);
/* From explicit entries: row-major N*N on rank 0 (NULL elsewhere), checked for symmetry (1e-8 relative) and positive
   definiteness; source names the file and dataset in error messages. */
PETSC_EXTERN PetscErrorCode MatCreateSlipStiffnessFromEntries(MPI_Comm comm, PetscInt N, const PetscReal *entries,
                                                              const char *source, Mat *K);
/* Keep what is expensive to set up for K in files of this existing directory; "" for none. */

/* How products by transforms are formed; before the first product. */
PETSC_EXTERN PetscErrorCode MatSlipStiffnessSetDepth(Mat K, const char type[]); /* "auto", "blocks" or "transform" */
PETSC_EXTERN PetscErrorCode MatSlipStiffnessSetShare(Mat K, PetscBool share);   /* wavenumbers among the ranks */
PETSC_EXTERN PetscErrorCode MatSlipStiffnessSetFromOptions(Mat K);

PETSC_EXTERN PetscErrorCode SlipMatInitializePackage(void); /* called by what creates objects; again does nothing */
/* Memory that a matrix holds [bytes]: most on one process, and on all; -1 where a type does not know. */
PETSC_EXTERN PetscErrorCode MatSlipGetMemory(Mat A, PetscReal *most, PetscReal *all);
/* How its type was chosen, in words; borrowed, "" when there is nothing to tell. */
PETSC_EXTERN PetscErrorCode MatSlipGetNotes(Mat A, const char **why);

/* ---- viscosity ---- H = 2 zeta M (M^-1 K)^(1/2), M = mass * I, mass [kg/m^2]; H [Pa s/m].
   type: "sqrtm" (exact matrix square root), "spectral" (per-wavenumber square root, uniform grids only), "lanczos"
   (exact, by Lanczos' method in each product), "toeplitz" (cheap and a few per cent off along the edges of a uniform
   grid, for Jacobians), "none" (zero). */
PETSC_EXTERN PetscErrorCode MatCreateSlipRadiation(Mat K, PetscReal eta, Mat *H);
PETSC_EXTERN PetscErrorCode MatCreateSlipRadiationOpening(Mat K, PetscReal eta, PetscReal across, Mat *H);
PETSC_EXTERN PetscErrorCode MatCreateSlipViscosity(Mat K, PetscReal mass, PetscReal zeta, const char *type, Mat *H);

/* ---- stage operator ---- B(theta) = (mass/theta) I + H + theta K   [Pa s/m], theta [s].
   MatMult caches what depends on theta; setting the same theta again is free. */
PETSC_EXTERN PetscErrorCode MatCreateSlipStage(Mat K, Mat H, PetscReal mass, Mat *B);
PETSC_EXTERN PetscErrorCode MatSlipStageSetTheta(Mat B, PetscReal theta);
PETSC_EXTERN PetscErrorCode MatSlipStageGetTheta(Mat B, PetscReal *theta);
/* "auto", "exact" or "approximate": what the next one gives; before a solver is set up with B. */
PETSC_EXTERN PetscErrorCode MatSlipStageSetJacobian(Mat B, const char type[]);
PETSC_EXTERN PetscErrorCode MatSlipStageSetFromOptions(Mat B);
/* A borrowed stage operator at B's theta with a cheap viscosity, for the matrix of an inexact Newton method; B itself
   where that is cheap already. */
PETSC_EXTERN PetscErrorCode MatSlipStageGetApproximation(Mat B, Mat *A);

/* PC type for the Jacobian restricted to the sliding set, see slipsnes.h (MATSLIPJACOBIAN); registered with
   PCRegister. */
#define PCSLIPSTAGE "slipstage"
