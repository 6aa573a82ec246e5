/* Internal header of src/mat: the square root of a stiffness, by every method */
#pragma once
#include <slipstep/private/slipmatcells.h>
#include <slipstep/private/slipmatgrid.h>
#include <slipstep/private/slipstate.h>

/* Largest memory of viscosities as blocks; beyond it Lanczos' method is used, which needs none. */
#define SLIP_MEMORY_MAX 2e9

/* ---- denseroot.c ---- */
/* Square roots of the weights of S's rows, and their inverses; both NULL without weights */
PETSC_INTERN PetscErrorCode SlipRootWeights(Mat S, Vec *root, Vec *inverse);
PETSC_INTERN PetscErrorCode SlipViscosityCreate_DenseRoot(Mat S, PetscReal factor, Mat *H);

/* ---- lanczos.c ---- */
PETSC_INTERN PetscErrorCode SlipViscosityCreate_Lanczos(Mat K, PetscReal factor, Mat *H);

/* c = T^(1/2) e_1 of a tridiagonal matrix (pure) */
PETSC_INTERN PetscErrorCode SlipRootOfTridiagonal(PetscInt m, const PetscReal alpha[], const PetscReal beta[],
                                                  PetscReal c[], PetscReal *lowest);
/* Checks the coefficients of a Lanczos process while it runs; initialise to zero. last [m]: those of the last check */
typedef struct {
  PetscInt before;         /* steps at the last check */
  PetscReal steps, change; /* since the check before */
} SlipRootLooks;
PETSC_INTERN PetscReal SlipRootError(SlipRootLooks *looks, PetscInt m, const PetscReal c[], PetscReal last[],
                                     PetscReal *size);

/* ---- recycled.c: products of a solver's iterates by linear combination of earlier ones; initialise to zero ---- */
/* y = H x with an error in the 2-norm of at most the larger of allowed and relative |H x| */
typedef PetscErrorCode (*SlipProductFn)(void *ctx, Vec x, PetscReal allowed, PetscReal relative, Vec y);
#define SLIP_RECYCLED_MAX 20
typedef struct {
  PetscInt n;
  Vec q[SLIP_RECYCLED_MAX], image[SLIP_RECYCLED_MAX]; /* the first n: orthonormal directions and H times them */
  PetscReal error[SLIP_RECYCLED_MAX];                 /* of the images, in the 2-norm */
  PetscReal least;                                    /* relative error of the next products, if above the tolerance */
  PetscReal loose;    /* relative error for an iterate far from all others; 0: the tolerance */
  PetscReal wanted;   /* allowed error in the 2-norm, if larger [Pa] */
  PetscBool loosened; /* the last product used `loose` */
  PetscReal noise;    /* approximate error of the last product in the 2-norm */
  Vec rest;
} SlipRecycled;
PETSC_INTERN PetscErrorCode SlipRecycledMult(SlipRecycled *c, PetscReal tolerance, SlipProductFn product, void *ctx,
                                             Vec x, Vec y);
PETSC_INTERN PetscErrorCode SlipRecycledReset(SlipRecycled *c);
PETSC_INTERN PetscErrorCode SlipRecycledState(SlipRecycled *c, Mat H,
                                              SlipState s); /* for checkpoints, of the products with H */

/* sketch.c: the error of the spectral root, without dense matrices */
PETSC_INTERN PetscErrorCode SlipSketchCorrection(SlipCirculant strike, const PetscReal blocks[], PetscReal square,
                                                 PetscReal tolerance, PetscInt parity, PetscReal *smallest,
                                                 PetscReal *error, SlipLowRank *m);

PETSC_INTERN PetscErrorCode SlipLanczosGetRecycled(Mat H, SlipRecycled **known); /* lanczos.c; NULL for other types */
typedef PetscErrorCode (*SlipRootFn)(Mat K, PetscReal factor, PetscReal tolerance, Mat *H);
PETSC_INTERN PetscErrorCode SlipLanczosFactorise(Mat H, SlipRootFn create, PetscReal tolerance, PetscReal set_up);
PETSC_INTERN PetscErrorCode SlipLanczosGetNow(Mat H, Mat *now);

/* ---- types of stiffness and viscosity that are not MATDENSE ---- */
PETSC_INTERN PetscErrorCode SlipViscosityCreate_Plane(Mat K, PetscReal factor, Mat *H);
PETSC_INTERN PetscErrorCode SlipViscosityCreate_SpectralBlocks(Mat K, PetscReal factor, Mat *H);
PETSC_INTERN PetscErrorCode SlipViscosityCreate_Spectral(Mat K, PetscReal factor, Mat *H);
PETSC_INTERN PetscErrorCode SlipViscosityCreate_SpectralExact(Mat K, PetscReal factor, Mat *H);
PETSC_INTERN PetscErrorCode SlipViscosityCreate_Sketch(Mat K, PetscReal factor, PetscReal tolerance, Mat *H);
PETSC_INTERN PetscErrorCode SlipSpectralState(Mat H, SlipState s); /* for checkpoints */
/* The two parts of a "slipspectral" viscosity, for the stage operator. */
PETSC_INTERN PetscErrorCode SlipSpectralGetBlocks(Mat H, SlipCirculant *strike, const PetscReal **blocks);
PETSC_INTERN PetscErrorCode SlipSpectralAddCorrection(Mat H, PetscReal cutoff, const PetscReal x[], PetscReal y[]);

typedef struct {
  Mat K; /* referenced: owns strike */
  SlipCirculant strike;
  PetscReal *blocks; /* [nk][nz][nz] [Pa s/m] */
  SlipLowRank correction[2];
  PetscReal *half_x, *half_y; /* scratch */
  PetscReal *y;               /* [N] */
  SlipGather gather;
  PetscReal tolerance;    /* of the exact root; 0 without a low-rank part */
  SlipRecycled increment; /* if there is one */
  Vec diagonal;           /* NULL until used, because it reads the whole low-rank part across its storage order */
} SlipSpectral;

/* The rows of cells on which this process works: all of them, or its share */
PETSC_INTERN void SlipSpectralRows(SlipSpectral *c, PetscInt *start, PetscInt *rows);
/* Creates the blocks of factor * sqrt(scale * K), which the caller frees. */
PETSC_INTERN PetscErrorCode SlipSpectralRootBlocks(SlipCirculant strike, PetscReal factor, PetscReal scale,
                                                   PetscReal **blocks);
/* Computes the largest eigenvalue of the part in blocks. Collective. */
PETSC_INTERN PetscErrorCode SlipSpectralNorm(MPI_Comm comm, SlipSpectral *c, PetscReal factor, PetscReal scale,
                                             PetscReal *norm);

/* ---- radiation.c ---- */
PETSC_INTERN PetscErrorCode SlipRadiationGet(Mat H, PetscReal *eta);
