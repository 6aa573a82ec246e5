/* Stiffness K, viscosity H and stage operator B of a frictional fault as PETSc Mats, independent of the fault object */
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
   type: "dense", "fft" or "auto". The matrix is the symmetric part (K + K')/2 with N = nx * nz rows; their
   distribution is PETSc's default one (PETSC_DECIDE) at every rank count. MatGetDiagonal() gives the diagonal, and
   conversion to MATDENSE all entries, for checks. */
PETSC_EXTERN PetscErrorCode MatCreateSlipStiffness(MPI_Comm comm, const SlipGrid *grid, const char *type, Mat *K);
/* A grid of any dip: length_z is along the dip, and starts at the depth depth_top. */
typedef struct {
  SlipGrid grid;         /* with a kernel that has a row of normal stress, such as SlipKernelDipping */
  PetscReal dip;         /* [deg] */
  const PetscReal *rake; /* [nx * nz] of slip and shear stress [deg], used during creation; vectors of slip ignore it */
  PetscReal tolerance;   /* of "hmat": relative error of each low-rank block, in (0, 1); 0: 1e-8 */
} SlipDippingGrid;
/* type: "dense", "fft", "hmat" or "auto". Creates the stiffness and, unless Kn is NULL, the effect of slip on normal
   stress: compression at the centre of cell i for unit slip on cell j [Pa/m], not symmetric. */
PETSC_EXTERN PetscErrorCode MatCreateSlipDippingStiffness(MPI_Comm comm, const SlipDippingGrid *grid, const char *type,
                                                          Mat *K, Mat *Kn);
/* The same, without rakes, for slip and shear traction as vectors: rows and columns 2 i and 2 i + 1 are along strike
   and up dip of cell i; Kn is N x 2 N. */
PETSC_EXTERN PetscErrorCode MatCreateSlipDippingVectorStiffness(MPI_Comm comm, const SlipDippingGrid *grid,
                                                                const char *type, Mat *S, Mat *Kn);
/* Creates a stiffness from explicit entries: row-major N*N on rank 0 (NULL elsewhere), checked for symmetry (1e-8
   relative) and positive definiteness; source names the file and dataset in error messages. */
PETSC_EXTERN PetscErrorCode MatCreateSlipStiffnessFromEntries(MPI_Comm comm, PetscInt N, const PetscReal *entries,
                                                              const char *source, Mat *K);

/* Sets how products by transforms are computed, before the first product. */
PETSC_EXTERN PetscErrorCode MatSlipStiffnessSetDepth(Mat K, const char type[]); /* "auto", "blocks" or "transform" */
PETSC_EXTERN PetscErrorCode MatSlipStiffnessSetFromOptions(Mat K);

/* Memory of a matrix [bytes]: largest on one process, and in total; -1 if the type does not report it. */
PETSC_EXTERN PetscErrorCode MatSlipGetMemory(Mat A, PetscReal *most, PetscReal *all);

/* ---- viscosity ---- H = 2 zeta M (M^-1 K)^(1/2), M = mass * I, mass [kg/m^2]; H [Pa s/m]. type: "sqrtm" (exact matrix
   square root), "spectral" (square root per wavenumber, uniform grids only), "lanczos" (exact, by Lanczos' method in
   each product), "toeplitz" (cheap, with errors of a few per cent along the edges of a uniform grid, for Jacobians),
   "none" (zero). */
PETSC_EXTERN PetscErrorCode MatCreateSlipRadiation(Mat K, PetscReal eta, Mat *H);
PETSC_EXTERN PetscErrorCode MatCreateSlipViscosity(Mat K, PetscReal mass, PetscReal zeta, const char *type, Mat *H);

/* ---- stage operator ---- B(theta) = (mass/theta) I + H + theta K   [Pa s/m], theta [s]. MatMult() caches what depends
   on theta; setting the same theta again costs nothing. */
PETSC_EXTERN PetscErrorCode MatCreateSlipStage(Mat K, Mat H, PetscReal mass, Mat *B);
PETSC_EXTERN PetscErrorCode MatSlipStageSetTheta(Mat B, PetscReal theta);
PETSC_EXTERN PetscErrorCode MatSlipStageGetTheta(Mat B, PetscReal *theta);

/* PC type for the Jacobian restricted to the sliding set, see slipsnes.h (MATSLIPJACOBIAN) */
#define PCSLIPSTAGE "slipstage"
