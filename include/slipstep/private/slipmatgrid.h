/* Internal header of src/mat: operators of a uniform grid by fast Fourier transforms */
#pragma once
#include <slipstep/private/slipelasticity.h>
#include <slipstep/private/slipmatcommon.h>
#include <fftw3.h>

/* ---- gridvalues.c: the uniform grid behind a stiffness, if it has one ---- */
PETSC_INTERN PetscErrorCode SlipGridCheck(MPI_Comm comm, const SlipGrid *grid);
PETSC_INTERN PetscErrorCode SlipGridCompose(Mat K, const SlipGrid *grid);
PETSC_INTERN PetscErrorCode SlipGridOf(Mat K, const SlipGrid **grid); /* borrowed; NULL if K is not on a uniform grid */
/* Symmetrised kernel of the grid for all depths, d cells apart along strike: block[iz * nz + jz], unscaled [Pa/m]. */
PETSC_INTERN PetscReal SlipGridEntry(const SlipGrid *grid, PetscInt d, PetscInt iz, PetscInt jz);
PETSC_INTERN PetscReal SlipGridBorder(const SlipGrid *grid, PetscInt ix, PetscInt iz); /* part of the diagonal */
PETSC_INTERN void SlipGridKernel(const SlipGrid *grid, PetscInt d, PetscReal block[]);

/* Factor by which MatScale() has scaled a stiffness: K = scale * kernel. Collective. */
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

/* ---- lanes.c: complex transforms of several fields at once ---- */
#define SLIP_LANES 8                 /* fields */
#define SLIP_NUMBER (2 * SLIP_LANES) /* reals of a number: the real parts of all lanes, and the imaginary ones */
typedef struct _n_SlipLanesFFT *SlipLanesFFT;
/* Layout of their numbers: count, and distances in reals of numbers, of fields, and of real and imaginary parts */
typedef struct {
  PetscInt n, step, apart, imaginary;
} SlipLanesFields;
PETSC_INTERN PetscErrorCode SlipLanesFFTCreate(PetscInt n, SlipLanesFFT *fft);
PETSC_INTERN PetscErrorCode SlipLanesFFTDestroy(SlipLanesFFT *fft);
PETSC_INTERN void SlipLanesForward(SlipLanesFFT fft, const SlipLanesFields *g, const PetscReal field[],
                                   PetscReal *room[2]);
PETSC_INTERN void SlipLanesSplit(SlipLanesFFT fft, PetscReal *room[2], PetscInt fields, PetscInt start, PetscInt end,
                                 PetscReal a[], PetscInt na);
PETSC_INTERN void SlipLanesJoin(SlipLanesFFT fft, PetscReal *room[2], PetscInt fields, PetscInt start, PetscInt end,
                                const PetscReal a[], PetscInt na);
PETSC_INTERN void SlipLanesBackward(SlipLanesFFT fft, const SlipLanesFields *g, PetscReal scale, PetscReal *room[2],
                                    PetscReal field[]);

/* ---- transposed_fft.c: transforms along strike, from rows of cells to wavenumbers over the ranks ---- */
typedef struct {
  PetscInt rows, row_start;       /* this rank's rows of a table */
  PetscInt columns, column_start; /* columns of a table, which are rows of its transpose */
  size_t size;                    /* reals to allocate for either */
} SlipLayout;
typedef struct _n_SlipTransposedFFT {
  PetscInt nx, nz, period;
  SlipLayout layout;  /* [nz][nk] complex */
  PetscReal *by_wave; /* [local nk][nz] complex */
  struct _n_SlipTransposedFFTPlans *plans;
} * SlipTransposedFFT;
PETSC_INTERN SlipLayout SlipLayoutOf(MPI_Comm comm, PetscInt rows, PetscInt columns, PetscInt tuple);
PETSC_INTERN PetscErrorCode SlipAllocate(size_t count, PetscReal **a);
PETSC_INTERN PetscErrorCode SlipTranspose(MPI_Comm comm, PetscInt rows, PetscInt columns, PetscInt tuple, PetscReal a[],
                                          PetscReal b[]);
PETSC_INTERN PetscErrorCode SlipTransposedFFTCreate(MPI_Comm comm, PetscInt nx, PetscInt nz, PetscInt period,
                                                    SlipTransposedFFT *p);
PETSC_INTERN PetscErrorCode SlipTransposedFFTDestroy(SlipTransposedFFT *p);
PETSC_INTERN PetscErrorCode SlipTransposedFFTForward(SlipTransposedFFT p, const PetscReal x[]);
PETSC_INTERN PetscReal SlipTransposedFFTBytes(SlipTransposedFFT p);
PETSC_INTERN PetscErrorCode SlipTransposedFFTBackward(SlipTransposedFFT p, PetscReal factor, PetscReal y[]);

/* ---- blocks.c: real blocks of one wavenumber times complex fields ---- */
PETSC_INTERN PetscErrorCode SlipAllocateLines(size_t count, PetscReal **a); /* free() it */
PETSC_INTERN size_t SlipSymmetricHalf(PetscInt n, const PetscReal A[], PetscReal half[]);
PETSC_INTERN void SlipSymmetricProduct(PetscInt n, PetscBool half, const PetscReal A[], PetscReal f[],
                                       PetscReal column[]); /* column [4][n] */
PETSC_INTERN void SlipGeneralProduct(PetscInt m, PetscInt n, const PetscReal A[], const PetscReal f[], PetscReal g[],
                                     PetscReal column[]); /* A [n][m], column [2][m + n] */

/* ---- circulant.c: block-circulant operators of a uniform grid (FFT along strike, nz x nz blocks per wavenumber)
   ---- */
typedef struct _n_SlipCirculant *SlipCirculant;
PETSC_INTERN PetscInt SlipGoodLength(PetscInt n); /* even, at least n, prime factors 2, 3 and 5 */
PETSC_INTERN PetscErrorCode SlipCirculantCreate(MPI_Comm comm, const SlipGrid *grid, SlipCirculant *strike);
PETSC_INTERN PetscErrorCode SlipCirculantDestroy(SlipCirculant *strike);
PETSC_INTERN SlipTransposedFFT SlipCirculantPencil(SlipCirculant s);
PETSC_INTERN PetscErrorCode SlipCirculantOf(Mat K, SlipCirculant *strike); /* borrowed from K; NULL without a grid */
PETSC_INTERN PetscErrorCode SlipCirculantOfGrid(Mat K, const SlipGrid *grid, SlipCirculant *strike); /* not NULL */
PETSC_INTERN void SlipCirculantGet(SlipCirculant s, const SlipGrid **grid, PetscInt *period, PetscInt *nk,
                                   const PetscReal **symbol);
PETSC_INTERN PetscReal SlipCirculantBytes(Mat K); /* of the blocks of K on this process, 0 if there are none */
PETSC_INTERN PetscErrorCode SlipCirculantGetEigen(SlipCirculant s, const PetscReal **values, const PetscReal **vectors);
PETSC_INTERN PetscErrorCode SlipCirculantFormBlocks(SlipCirculant s, const PetscReal f[], PetscReal blocks[]);
PETSC_INTERN PetscErrorCode SlipCirculantApply(SlipCirculant s, PetscReal scale, const PetscReal blocks[],
                                               const PetscReal x[], PetscReal y[]);
PETSC_INTERN PetscErrorCode SlipCirculantApplyStiffness(SlipCirculant s, PetscReal scale, const PetscReal x[],
                                                        PetscReal y[]);
PETSC_INTERN PetscErrorCode SlipCirculantApplyMany(SlipCirculant s, PetscReal scale, const PetscReal blocks[],
                                                   PetscInt parity, PetscInt count, const PetscReal X[], PetscReal Y[]);

/* ---- toeplitz.c: operators of a uniform grid by transforms along strike and in depth, distributed ---- */
typedef struct _n_SlipToeplitz *SlipToeplitz;
typedef struct _n_SlipToeplitzDevice *SlipToeplitzDevice;
/* An operator per pair of wavenumbers; see toeplitz.c. hankel and product may be NULL. */
typedef struct _n_SlipToeplitzSymbol {
  PetscReal *toeplitz;         /* [groups][depth_period / 2 + 1][SLIP_LANES], real since it is even */
  PetscReal *hankel, *product; /* the same, complex: [groups][depth_period / 2 + 1][2][SLIP_LANES] */
  struct _cl_mem *there[3];    /* on the device, [depth_period / 2 + 1][wavenumbers]; NULL until used */
  PetscErrorCode (*there_free)(struct _n_SlipToeplitzSymbol *);
} SlipToeplitzSymbol;
PETSC_INTERN void SlipLanesMultiply(SlipLanesFFT fft, const SlipToeplitzSymbol *symbol, size_t group, PetscInt nz,
                                    const PetscReal z[], PetscReal *room[4], PetscReal field[]);
PETSC_INTERN size_t SlipToeplitzSymbolSize(SlipToeplitz p);
PETSC_INTERN PetscErrorCode SlipToeplitzOf(Mat K, SlipToeplitz *plane); /* borrowed from K; NULL without a grid */
PETSC_INTERN PetscErrorCode SlipToeplitzOfGrid(Mat K, const SlipGrid *grid, SlipToeplitz *plane); /* not NULL */
PETSC_INTERN PetscReal SlipToeplitzBytes(SlipToeplitz plane);                                     /* on this process */
PETSC_INTERN const SlipToeplitzSymbol *SlipToeplitzStiffness(SlipToeplitz plane);
PETSC_INTERN PetscErrorCode SlipToeplitzApply(SlipToeplitz plane, PetscReal scale, const SlipToeplitzSymbol *symbol,
                                              Vec x, Vec y);
/* Multiplies f [nz] complex by depth_period * (operator of this symbol at local wavenumber k), in place, between
   SlipToeplitzForward() and SlipToeplitzBackward(). */
PETSC_INTERN PetscErrorCode SlipToeplitzApplyWave(SlipToeplitz plane, const SlipToeplitzSymbol *symbol, PetscInt k,
                                                  PetscReal f[]);
/* toeplitz_root.c: functions of the full space's kernel, reflected at the free surface */
PETSC_INTERN PetscErrorCode SlipToeplitzGetRoot(SlipToeplitz plane, const SlipToeplitzSymbol **root,
                                                const PetscReal **diagonal);
PETSC_INTERN PetscErrorCode SlipToeplitzGetRootDiagonal(SlipToeplitz plane, PetscReal factor, Vec d);
PETSC_INTERN PetscErrorCode SlipToeplitzCombine(SlipToeplitz plane, PetscReal identity, PetscReal stiffness,
                                                PetscReal root, SlipToeplitzSymbol *sum);
PETSC_INTERN PetscErrorCode SlipToeplitzSymbolDestroy(SlipToeplitzSymbol *symbol);
PETSC_INTERN PetscErrorCode SlipToeplitzGetWaves(SlipToeplitz plane, PetscInt *nk, PetscInt *count,
                                                 const PetscReal **symbol);
PETSC_INTERN PetscErrorCode SlipToeplitzApplyWaves(SlipToeplitz plane, const PetscReal f[], Vec x, Vec y);

struct _n_SlipToeplitz {
  SlipGrid grid;
  MPI_Comm comm;                 /* K's */
  PetscInt period, depth_period; /* padded lengths along strike and in depth, both even */
  SlipTransposedFFT pencil;
  SlipToeplitzSymbol stiffness;
  PetscReal *z;                      /* [nz] depths [m] */
  SlipLanesFFT lanes;                /* of depth_period / 2 */
  PetscReal *room[4];                /* [depth_period / 2] numbers of all lanes */
  PetscReal *column;                 /* [2][depth_period] complex, and their transforms */
  fftw_plan depth[2], depth_back[2]; /* of one and of two columns, of only one wavenumber; NULL until used */
  VecScatter scatter;                /* to this rank's rows of cells; NULL if it owns them */
  Vec rows;
  SlipToeplitzDevice device; /* for vectors on the device; NULL: none yet */
  PetscErrorCode (*device_destroy)(SlipToeplitzDevice *);

  /* functions of the full space's kernel, see toeplitz_root.c */
  PetscErrorCode (*root_destroy)(SlipToeplitz); /* frees the members below; NULL if unused */
  PetscBool image;                              /* fields are even about the free surface */
  PetscInt gap, length;    /* cells between the fault's edge and its image; half the period in depth */
  PetscReal *symbol;       /* [local nk][length + 1], unscaled [Pa/m], >= 0; NULL until used */
  SlipToeplitzSymbol root; /* of the square root of symbol; toeplitz NULL until used */
  PetscReal *diagonal;     /* [nz] of that root */
  PetscReal *line;         /* [length] complex with image, else [2 length], and its transform */
  PetscReal *turn;         /* [length / 2 + 1] complex with image: exp(-i pi k / length) */
  fftw_plan wave[2];       /* there and back */
};

PETSC_INTERN PetscErrorCode SlipToeplitzAllocate(SlipToeplitz p, PetscInt parts, SlipToeplitzSymbol *s);
PETSC_INTERN PetscErrorCode SlipToeplitzSetSymbol(SlipToeplitz p, PetscInt stride, PetscInt parts,
                                                  const PetscReal kernels[], SlipToeplitzSymbol *s);
PETSC_INTERN void SlipToeplitzSymbolOf(SlipToeplitz p, const SlipToeplitzSymbol *s, PetscInt part, PetscInt k,
                                       PetscInt i, PetscReal number[]);
PETSC_INTERN PetscErrorCode SlipToeplitzForward(SlipToeplitz p, Vec x);
PETSC_INTERN PetscErrorCode SlipToeplitzBackward(SlipToeplitz p, PetscReal factor, Vec y);

/* ---- toeplitz_device.c: the same where the vectors are, on the processor or on the device ---- */
PETSC_INTERN PetscReal SlipToeplitzDeviceBytes(PetscInt nx, PetscInt nz);
PETSC_INTERN PetscErrorCode SlipToeplitzDevicePut(SlipToeplitz plane, SlipToeplitzSymbol *symbol);
PETSC_INTERN PetscErrorCode SlipToeplitzMult(SlipToeplitz plane, PetscReal scale, SlipToeplitzSymbol *symbol, Vec x,
                                             Vec y);
/* Computes y = (identity + stiffness K + root K^(1/2)) x, for these three factors. sum: the symbol of that operator,
   which is stored for the next product; here, there: its factors on the processor and on the device, 0 for none */
PETSC_INTERN PetscErrorCode SlipToeplitzMultSum(SlipToeplitz plane, const PetscReal factor[3], SlipToeplitzSymbol *sum,
                                                PetscReal here[3], PetscReal there[3], Vec x, Vec y);
/* 1 / f of the symbol S: f = max(max(g + slope, limit g), smallest), g = identity + root S^(1/2) + stiffness S */
typedef struct {
  PetscReal identity, root, stiffness, slope, limit, smallest;
} SlipToeplitzInverse;
/* Replaces x by its product with 1/f, given also as values [local nk][count] where the processor computes products with
   such vectors. work: another vector */
PETSC_INTERN PetscErrorCode SlipToeplitzInvert(SlipToeplitz plane, const SlipToeplitzInverse *f,
                                               const PetscReal values[], Vec x, Vec work);
PETSC_INTERN PetscBool SlipToeplitzWantsValues(Vec x);

/* ---- blocks_device.c: a block per wavenumber on the device, for vectors there ---- */
typedef struct {
  PetscInt nx, nz, period;
  PetscInt n;                /* fields, the components of slip */
  const PetscReal *share[2]; /* [nx nz] factors of each field if slip has one number per cell; NULL: it has n numbers */
  PetscBool half;            /* blocks of shear are halves by SlipSymmetricHalf(), else whole */
  PetscBool strike;          /* the first field is along strike: compression is imaginary then */
} SlipBlocksShape;
typedef struct _n_SlipBlocksDevice *SlipBlocksDevice;
PETSC_INTERN PetscReal SlipBlocksDeviceBytes(const SlipBlocksShape *shape, PetscBool normal);
PETSC_INTERN PetscErrorCode SlipBlocksDeviceCreate(const SlipBlocksShape *shape, SlipBlocksDevice *device);
PETSC_INTERN PetscErrorCode SlipBlocksDeviceDestroy(SlipBlocksDevice *device);
PETSC_INTERN PetscErrorCode SlipBlocksDevicePutShear(SlipBlocksDevice device, const PetscReal blocks[]);
PETSC_INTERN PetscErrorCode SlipBlocksDevicePutNormal(SlipBlocksDevice device, const PetscReal blocks[]);
PETSC_INTERN PetscErrorCode SlipBlocksDeviceForward(SlipBlocksDevice device, Vec x);
PETSC_INTERN PetscErrorCode SlipBlocksDeviceShear(SlipBlocksDevice device, PetscReal scale, Vec y);
PETSC_INTERN PetscErrorCode SlipBlocksDeviceNormal(SlipBlocksDevice device, PetscReal scale, Vec y);

/* ---- gather.c: all of a distributed vector on every rank, or a pencil's rows of it ---- */
typedef struct {
  VecScatter scatter; /* NULL on one rank */
  Vec all;
  PetscBool rows; /* of a pencil only */
  PetscInt N, start, end;
} SlipGather;
PETSC_INTERN PetscErrorCode SlipGatherCreate(Mat A, SlipTransposedFFT pencil, SlipGather *g);
PETSC_INTERN PetscErrorCode SlipGatherPut(SlipGather *g, const PetscReal array[], Vec y);
PETSC_INTERN PetscErrorCode SlipGatherDestroy(SlipGather *g);
PETSC_INTERN PetscErrorCode SlipGatherGet(SlipGather *g, Vec x, const PetscReal **array);
PETSC_INTERN PetscErrorCode SlipGatherRestore(SlipGather *g, Vec x, const PetscReal **array);

/* ---- memory for views, on this process [bytes] ---- */
PETSC_INTERN PetscReal SlipGatherBytes(const SlipGather *g);

/* With up to so many cells in depth, a block per wavenumber of H is faster than Lanczos' method or transforms. */
#define SLIP_BLOCKS_MAX 60

/* ---- stiffness_fft.c ---- */
PETSC_INTERN PetscErrorCode SlipStiffnessCreate_FFT(MPI_Comm comm, const SlipGrid *grid, Mat *K);

/* ---- dipping_blocks.c: blocks per wavenumber of a dipping plane ---- */
PETSC_INTERN PetscErrorCode SlipDippingOwn(const SlipDippingGrid *grid, PetscInt iz, PetscReal shear[3],
                                           PetscReal normal[3]);
PETSC_INTERN PetscErrorCode SlipDippingBlocks(MPI_Comm comm, const SlipDippingGrid *grid, PetscInt period,
                                              PetscInt nk_local, PetscInt n, const PetscInt component[],
                                              PetscReal **stiffness, PetscReal **normal);
PETSC_INTERN PetscBool SlipDippingSteady(const SlipDippingGrid *grid); /* in depth */
PETSC_INTERN PetscErrorCode SlipDippingSymbol(MPI_Comm comm, const SlipDippingGrid *grid, PetscInt period,
                                              PetscInt nk_local, PetscInt n, const PetscInt component[], PetscInt Q,
                                              PetscReal **symbol);

/* ---- dipping_fft.c; Kn may be NULL ---- */
PETSC_INTERN PetscBool SlipDippingTransforms(const SlipKernel *kernel); /* whether it is supported */
PETSC_INTERN PetscErrorCode SlipDippingCreate_FFT(MPI_Comm comm, const SlipDippingGrid *grid, Mat *K, Mat *Kn);
