/* Private to src/mat: kernel parts, dense helpers, and what the preconditioner may ask of K, H and B. */
#pragma once
#include <slipmat.h>
#include <slipstep/private/sliplog.h>

/* ---- kernel.c ---- */
PETSC_INTERN void SlipKernelSurface_Private(PetscReal G, PetscReal nu, PetscReal dx, PetscReal depth_sum, PetscReal a,
                                            PetscReal b, PetscReal part[3]);

/* ---- grid.c: the uniform grid behind a stiffness, if it has one ---- */
PETSC_INTERN PetscErrorCode SlipGridCheck(MPI_Comm comm, const SlipGrid *grid);
PETSC_INTERN PetscErrorCode SlipGridCompose(Mat K, const SlipGrid *grid);
PETSC_INTERN PetscErrorCode SlipGridOf(Mat K,
                                       const SlipGrid **grid); /* borrowed; NULL when K is not on a uniform grid */
/* Symmetrised kernel of the grid for all depths, d cells apart along strike: block[iz * nz + jz], unscaled [Pa/m]. */
PETSC_INTERN PetscReal SlipGridEntry(const SlipGrid *grid, PetscInt d, PetscInt iz, PetscInt jz);
PETSC_INTERN void SlipGridKernel(const SlipGrid *grid, PetscInt d, PetscReal block[]);

/* What MatScale() has made of a stiffness: K = scale * kernel. Collective. */
PETSC_INTERN PetscErrorCode SlipGridScale(Mat K, PetscReal *scale);

/* ---- mirror.c: even and odd blocks of a grid's operators ---- */
PETSC_INTERN PetscInt SlipMirrorWidth(PetscInt nx, PetscInt parity);
PETSC_INTERN void SlipMirrorSplit(PetscInt nx, PetscInt nz, const PetscReal kernel[], PetscReal scale, PetscInt parity,
                                  PetscReal block[]);
PETSC_INTERN void SlipMirrorMerge(PetscInt nx, PetscInt nz, const PetscReal even[], const PetscReal odd[],
                                  PetscReal A[]);
/* Fields of one parity by their coefficients half[nz][hx]; Unfold adds to x. */
PETSC_INTERN void SlipMirrorFold(PetscInt nx, PetscInt nz, PetscInt parity, const PetscReal x[], PetscReal half[]);
PETSC_INTERN void SlipMirrorUnfold(PetscInt nx, PetscInt nz, PetscInt parity, const PetscReal half[], PetscReal x[]);

/* ---- dense.c: whole matrices on one rank; row-major N * N ---- */
PETSC_INTERN PetscErrorCode SlipDenseGather(Mat A,
                                            PetscReal **entries); /* rank 0 allocates (PetscFree), others get NULL */
PETSC_INTERN PetscErrorCode SlipDenseScatter(MPI_Comm comm, PetscInt nlocal, PetscInt N, const PetscReal *entries,
                                             Mat *A); /* nlocal: rows of this rank, or PETSC_DECIDE */
PETSC_INTERN PetscErrorCode SlipDenseEigen(PetscInt n, PetscReal A[], PetscReal eigenvalues[], PetscInt *info);
/* A := sqrt(A) for a symmetric positive definite A; *smallest is its smallest eigenvalue. One process. */
PETSC_INTERN PetscErrorCode SlipDenseSqrt(PetscInt n, PetscReal A[], PetscReal *smallest, PetscInt *info);

/* ---- shell.c ---- */
PETSC_INTERN PetscErrorCode SlipShellFinish(Mat A, const char type[]);
/* What -fault_view tells of a matrix, kept with it under a name: how its type was chosen, and what the cache did. */
PETSC_INTERN PetscErrorCode SlipNote(Mat A, const char name[], const char format[], ...);
PETSC_INTERN PetscErrorCode SlipNoteGet(Mat A, const char name[], const char **text); /* borrowed; "" for none */
/* report.c: MATOP_GETINFO of a shell matrix fills its answer by the first, so that views know its memory */
PETSC_INTERN PetscErrorCode SlipInfoFill(Mat A, PetscReal bytes, MatInfoType flag, MatInfo *info);
PETSC_INTERN PetscErrorCode SlipViscosityNote(Mat K, Mat H, const char asked[]);

/* ---- stage.c: what the stage operator is made of ---- */
typedef struct {
  Mat K, H;          /* borrowed */
  PetscReal mass;    /* [kg/m^2] */
  PetscReal theta;   /* [s] */
  PetscReal scale;   /* of K against the kernel of its grid; 0 without a grid */
  PetscReal damping; /* H = damping * sqrt(K); 0 when unknown */
} SlipStageParts;
PETSC_INTERN PetscErrorCode SlipStageGetParts(Mat B, SlipStageParts *parts);
PETSC_INTERN PetscErrorCode SlipViscosityGetFactor(Mat H, PetscReal *factor); /* viscosity.c */

/* ---- pencil.c: rows of cells over the ranks, transformed along strike, to wavenumbers over the ranks ---- */
typedef struct {
  PetscInt rows, row_start;       /* this rank's rows of a table */
  PetscInt columns, column_start; /* and of its transpose */
  size_t size;                    /* reals to allocate for either */
} SlipLayout;
typedef struct _n_SlipPencil {
  PetscInt nx, nz, period;
  SlipLayout layout;  /* [nz][nk] complex */
  PetscReal *row;     /* [period] */
  PetscReal *by_wave; /* [local nk][nz] complex */
  struct _n_SlipPencilPlans *plans;
} * SlipPencil;
PETSC_INTERN SlipLayout SlipLayoutOf(MPI_Comm comm, PetscInt rows, PetscInt columns, PetscInt tuple);
PETSC_INTERN PetscErrorCode SlipAllocate(size_t count, PetscReal **a);
PETSC_INTERN PetscErrorCode SlipTranspose(MPI_Comm comm, PetscInt rows, PetscInt columns, PetscInt tuple, PetscReal a[],
                                          PetscReal b[]);
PETSC_INTERN PetscErrorCode SlipPencilCreate(MPI_Comm comm, PetscInt nx, PetscInt nz, PetscInt period, SlipPencil *p);
PETSC_INTERN PetscErrorCode SlipPencilDestroy(SlipPencil *p);
PETSC_INTERN PetscErrorCode SlipPencilForward(SlipPencil p, const PetscReal x[]);
PETSC_INTERN PetscReal SlipPencilBytes(SlipPencil p);
PETSC_INTERN PetscErrorCode SlipPencilBackward(SlipPencil p, PetscReal factor, PetscReal y[]);

/* ---- strike.c: block-circulant operators of a uniform grid (FFT along strike, nz x nz blocks per wavenumber) ---- */
typedef struct _n_SlipStrike *SlipStrike;
PETSC_INTERN PetscInt SlipGoodLength(PetscInt n); /* even, at least n, prime factors 2, 3 and 5 */
PETSC_INTERN PetscErrorCode SlipStrikeCreate(MPI_Comm comm, const SlipGrid *grid, SlipStrike *strike);
PETSC_INTERN PetscErrorCode SlipStrikeDestroy(SlipStrike *strike);
PETSC_INTERN SlipPencil SlipStrikePencil(SlipStrike s);
PETSC_INTERN PetscErrorCode SlipStrikeOf(Mat K, SlipStrike *strike); /* borrowed from K; NULL without a grid */
PETSC_INTERN void SlipStrikeGet(SlipStrike s, const SlipGrid **grid, PetscInt *period, PetscInt *nk,
                                const PetscReal **symbol);
PETSC_INTERN PetscReal SlipStrikeBytes(Mat K); /* of K's engine on this process, 0 while it has none */
PETSC_INTERN PetscErrorCode SlipStrikeGetEigen(SlipStrike s, const PetscReal **values, const PetscReal **vectors);
PETSC_INTERN PetscErrorCode SlipStrikeFormBlocks(SlipStrike s, const PetscReal f[], PetscReal blocks[]);
PETSC_INTERN PetscErrorCode SlipStrikeBlocksToKernel(SlipStrike s, PetscReal blocks[]);
PETSC_INTERN PetscErrorCode SlipStrikeApply(SlipStrike s, PetscReal scale, const PetscReal blocks[],
                                            const PetscReal x[], PetscReal y[]);
PETSC_INTERN PetscErrorCode SlipStrikeApplyMany(SlipStrike s, PetscReal scale, const PetscReal blocks[],
                                                PetscInt parity, PetscInt count, const PetscReal X[], PetscReal Y[]);
PETSC_INTERN PetscErrorCode SlipStrikeApplyFunction(SlipStrike s, const PetscReal f[], const PetscReal x[],
                                                    PetscReal y[]);

/* ---- plane.c: operators of a uniform grid by transforms along strike and in depth, distributed ---- */
typedef struct _n_SlipPlane *SlipPlane;
/* What an operator is per wavenumber pair; see plane.c. hankel and product may be NULL. */
typedef struct {
  PetscReal *toeplitz;         /* [local nk][depth_period / 2 + 1], real since it is even */
  PetscReal *hankel, *product; /* the same, complex */
} SlipPlaneSymbol;
PETSC_INTERN PetscErrorCode SlipPlaneOf(Mat K, SlipPlane *plane); /* borrowed from K; NULL without a grid */
PETSC_INTERN PetscReal SlipPlaneBytes(SlipPlane plane);           /* on this process */
PETSC_INTERN const SlipPlaneSymbol *SlipPlaneStiffness(SlipPlane plane);
PETSC_INTERN PetscErrorCode SlipPlaneApply(SlipPlane plane, PetscReal scale, const SlipPlaneSymbol *symbol, Vec x,
                                           Vec y);
/* f [nz] complex times depth_period * (operator of this symbol at local wavenumber k), in place; for use between
   SlipPlaneForward() and SlipPlaneBackward() */
PETSC_INTERN void SlipPlaneApplyWave(SlipPlane plane, const SlipPlaneSymbol *symbol, PetscInt k, PetscReal f[]);
/* planeroot.c: functions of the full space's kernel, reflected at the free surface */
PETSC_INTERN PetscErrorCode SlipPlaneGetRoot(SlipPlane plane, const SlipPlaneSymbol **root, const PetscReal **diagonal);
PETSC_INTERN PetscErrorCode SlipPlaneCombine(SlipPlane plane, PetscReal identity, PetscReal stiffness, PetscReal root,
                                             SlipPlaneSymbol *sum);
PETSC_INTERN PetscErrorCode SlipPlaneSymbolDestroy(SlipPlaneSymbol *symbol);
PETSC_INTERN PetscErrorCode SlipPlaneGetWaves(SlipPlane plane, PetscInt *nk, PetscInt *count, const PetscReal **symbol);
PETSC_INTERN PetscErrorCode SlipPlaneApplyWaves(SlipPlane plane, const PetscReal f[], Vec x, Vec y);

/* ---- gather.c: the whole of a distributed vector on every rank, or a pencil's rows of it ---- */
typedef struct {
  VecScatter scatter; /* NULL on one rank */
  Vec all;
  PetscBool rows; /* of a pencil only */
  PetscInt N, start, end;
  MPI_Comm comm;
  PetscMPIInt *counts; /* rows of each rank; NULL on one */
} SlipGather;
PETSC_INTERN PetscErrorCode SlipGatherCreate(Mat A, SlipPencil pencil, SlipGather *g);
PETSC_INTERN PetscErrorCode SlipGatherPut(SlipGather *g, const PetscReal array[], Vec y);
PETSC_INTERN PetscErrorCode SlipGatherSum(SlipGather *g, const PetscReal array[], Vec y);
PETSC_INTERN PetscErrorCode SlipGatherDestroy(SlipGather *g);
PETSC_INTERN PetscErrorCode SlipGatherGet(SlipGather *g, Vec x, const PetscReal **array);
PETSC_INTERN PetscErrorCode SlipGatherRestore(SlipGather *g, Vec x, const PetscReal **array);

/* ---- schwarz.c: the stage operator of irregular cells inverted in overlapping parts ---- */
typedef struct _n_SlipSchwarz *SlipSchwarz;
PETSC_INTERN PetscErrorCode SlipSchwarzOf(Mat K, SlipSchwarz *schwarz); /* borrowed from K; NULL without cells */
PETSC_INTERN PetscErrorCode SlipSchwarzSetUp(SlipSchwarz s, const SlipStageParts *stage, PetscReal slope,
                                             PetscReal limit);
PETSC_INTERN PetscErrorCode SlipSchwarzApply(SlipSchwarz s, Vec x); /* in place */

/* ---- what views ask of them, on this process [bytes] ---- */
PETSC_INTERN PetscReal SlipGatherBytes(const SlipGather *g);

/* ---- lowrank.c: symmetric low-rank matrices W diag(lambda) W', ordered by falling |lambda|; zero-initialise ---- */
typedef struct {
  PetscInt n, rank, head; /* order, number of terms, number of them in double precision */
  PetscReal *W;           /* [n * head], column-major; [n * rank] before SlipLowRankDemote() */
  float *tail;            /* [n * (rank - head)] */
  PetscReal *lambda;      /* [rank] */
  PetscReal *t;           /* scratch [rank] */
  float *t32, *x32;       /* scratch [rank], [n] */
} SlipLowRank;
PETSC_INTERN PetscErrorCode SlipLowRankCompress(PetscInt n, const PetscReal D[], PetscReal cutoff, PetscInt guess,
                                                SlipLowRank *m);
PETSC_INTERN PetscErrorCode SlipLowRankSelect(PetscInt n, PetscInt r, const PetscReal Q[], const PetscReal values[],
                                              PetscReal cutoff, SlipLowRank *m);
PETSC_INTERN PetscErrorCode SlipOrthonormalise(PetscBLASInt n, PetscBLASInt r, PetscReal Y[]);
PETSC_INTERN void SlipRandomFill(size_t count, PetscReal a[], uint64_t *state); /* uniform in (-1, 1) */
/* sketch.c: what the spectral root misses, without dense matrices */
PETSC_INTERN PetscErrorCode SlipSketchCorrection(SlipStrike strike, const PetscReal blocks[], PetscReal square,
                                                 PetscReal tolerance, PetscInt parity, PetscReal *smallest,
                                                 PetscReal *error, SlipLowRank *m);
/* ---- cache.c: files of a directory; collective ---- */
#define SLIP_CACHE_VERSION 2 /* of the files and of the methods; part of every key */
typedef struct {
  const char *path, *units;
  PetscInt ndim, dims[2]; /* reading: -1 for any */
  PetscReal *data;        /* rank 0 */
} SlipCacheItem;
#define SLIP_HASH_START 14695981039346656037ULL
PETSC_INTERN uint64_t SlipHashReals(uint64_t hash, const PetscReal a[], size_t n);
PETSC_INTERN PetscErrorCode SlipCacheRead(Mat K, const char kind[], const char key[], PetscInt n, SlipCacheItem item[],
                                          PetscBool *found);
PETSC_INTERN PetscErrorCode SlipCacheWrite(Mat K, const char kind[], const char key[], PetscInt n,
                                           const SlipCacheItem item[]);
/* cacheroot.c: the root of a dense stiffness; root [N * N] is rank 0's */
PETSC_INTERN PetscErrorCode SlipFingerprintCompose(Mat K);
PETSC_INTERN PetscErrorCode SlipCacheLoadRoot(Mat K, PetscReal **root, PetscBool *found);
PETSC_INTERN PetscErrorCode SlipCacheSaveRoot(Mat K, PetscReal root[]);
/* The low-rank part in files, for unit factors; m[parity].n must be set. */
PETSC_INTERN PetscErrorCode SlipCacheLoad(Mat K, const SlipGrid *grid, PetscReal tolerance, PetscBool dense,
                                          SlipLowRank m[2], PetscBool *found);
PETSC_INTERN PetscErrorCode SlipCacheSave(Mat K, const SlipGrid *grid, PetscReal tolerance, PetscBool dense,
                                          const SlipLowRank m[2]);
PETSC_INTERN PetscErrorCode SlipLowRankDemote(SlipLowRank *m, PetscReal limit);
PETSC_INTERN PetscErrorCode SlipLowRankDestroy(SlipLowRank *m);
PETSC_INTERN PetscErrorCode SlipLowRankApply(SlipLowRank *m, MPI_Comm comm, PetscReal cutoff, const PetscReal x[],
                                             PetscReal y[]);
PETSC_INTERN PetscReal SlipLowRankDiagonal(const SlipLowRank *m, PetscInt i);

/* ---- increment.c: products of a solver's iterates from those of the ones before; zero-initialise ---- */
/* y = H x with an error of at most allowed in the 2-norm, or at 0 of what the tolerance allows */
typedef PetscErrorCode (*SlipProductFn)(void *ctx, Vec x, PetscReal allowed, Vec y);
#define SLIP_INCREMENT_MAX 20
typedef struct {
  PetscInt n;
  Vec q[SLIP_INCREMENT_MAX], image[SLIP_INCREMENT_MAX]; /* the first n: orthonormal directions and H of them */
  PetscReal error[SLIP_INCREMENT_MAX];                  /* of the images, in the 2-norm */
  Vec rest;
} SlipIncrement;
PETSC_INTERN PetscErrorCode SlipIncrementMult(SlipIncrement *c, PetscReal tolerance, SlipProductFn product, void *ctx,
                                              Vec x, Vec y);
PETSC_INTERN PetscErrorCode SlipIncrementReset(SlipIncrement *c);

/* ---- correction.c: what a cheap stage operator gets wrong, on directions whose exact products are known ---- */
typedef struct _n_SlipCorrection *SlipCorrection;
PETSC_INTERN PetscErrorCode SlipCorrectionCreate(Mat K, PetscReal mass, PetscReal mean, SlipCorrection *c);
PETSC_INTERN PetscErrorCode SlipCorrectionDestroy(SlipCorrection *c);
PETSC_INTERN PetscErrorCode SlipCorrectionUpdate(SlipCorrection c, const SlipIncrement *known, PetscReal theta,
                                                 PetscBool *changed);
PETSC_INTERN PetscErrorCode SlipCorrectionAdd(SlipCorrection c, Vec x, Vec y);
PETSC_INTERN PetscReal SlipCorrectionVectors(SlipCorrection c);
PETSC_INTERN PetscErrorCode SlipLanczosGetIncrement(Mat H, const SlipIncrement **known); /* lanczos.c */
/* lanczos.c: c = T^(1/2) e_1 of a tridiagonal matrix (pure) */
PETSC_INTERN PetscErrorCode SlipRootOfTridiagonal(PetscInt m, const PetscReal alpha[], const PetscReal beta[],
                                                  PetscReal c[], PetscReal *lowest);

/* Up to this many cells in depth a block per wavenumber is faster than transforms (measured). */
#define SLIP_BLOCKS_MAX 60

/* Bytes up to which viscosities may be kept as blocks and low-rank parts; beyond, Lanczos' method needs none. */
#define SLIP_MEMORY_MAX 2e9

/* ---- types of stiffness and viscosity that are not MATDENSE ---- */
PETSC_INTERN PetscErrorCode SlipStiffnessCreate_FFT(MPI_Comm comm, const SlipGrid *grid, Mat *K);
PETSC_INTERN PetscErrorCode SlipViscosityCreate_Plane(Mat K, PetscReal factor, Mat *H);
PETSC_INTERN PetscErrorCode SlipViscosityCreate_SpectralBlocks(Mat K, PetscReal factor, Mat *H);
PETSC_INTERN PetscErrorCode SlipViscosityCreate_Spectral(Mat K, PetscReal factor, Mat *H);
PETSC_INTERN PetscErrorCode SlipViscosityCreate_SpectralExact(Mat K, PetscReal factor, Mat *H);
/* The two parts of a "slipspectral" viscosity, for the stage operator. */
PETSC_INTERN PetscErrorCode SlipSpectralGetBlocks(Mat H, SlipStrike *strike, const PetscReal **blocks);
PETSC_INTERN PetscErrorCode SlipSpectralAddCorrection(Mat H, PetscReal cutoff, const PetscReal x[], PetscReal y[]);

/* ---- pcslipstage.c ---- */
PETSC_INTERN PetscErrorCode PCCreate_SlipStage(PC pc);
