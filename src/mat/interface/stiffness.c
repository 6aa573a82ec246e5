/* MatCreateSlipStiffness() and its table of types; the stiffness from explicit entries. */
#include <petsc/private/petscimpl.h> /* prefix, methods */
#include <slipstep/rooms/slipmat.h>
#include <slipstep/rooms/slipsys.h>
#include <petscblaslapack.h>
#include <slipcompat.h>
#include <slipstep/private/slipmatinterface.h>

/* Up to this many cells a dense product is as fast as one by FFT (measured), and forming B is cheap. */
#define SLIP_DENSE_MAX 256

/* Creates the reference: a MATDENSE filled from the nx nz (nz + 1) / 2 distinct kernel values. */
static PetscErrorCode StiffnessCreate_Dense(MPI_Comm comm, const SlipGrid *g, Mat *K)
{
  const PetscInt nx = g->nx, nz = g->nz, N = nx * nz;
  PetscReal *kernel;
  PetscScalar *a;
  PetscInt rstart, rend, lda;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1((size_t)nx * nz * nz, &kernel));
  for (PetscInt d = 0; d < nx; d++) SlipGridKernel(g, d, kernel + (size_t)d * nz * nz);
  PetscCall(MatCreateDense(comm, PETSC_DECIDE, PETSC_DECIDE, N, N, NULL, K));
  PetscCall(MatGetOwnershipRange(*K, &rstart, &rend));
  PetscCall(MatDenseGetLDA(*K, &lda));
  PetscCall(MatDenseGetArrayWrite(*K, &a));
  for (PetscInt j = 0; j < N; j++)
    for (PetscInt i = rstart; i < rend; i++) {
      const PetscInt d = PetscAbsInt(i % nx - j % nx);

      a[(size_t)j * lda + (i - rstart)] = kernel[((size_t)d * nz + i / nx) * nz + j / nx];
      if (i == j && g->kernel.average == SLIP_AVERAGE_WHOLE)
        a[(size_t)j * lda + (i - rstart)] += SlipGridBorder(g, i % nx, i / nx);
    }
  PetscCall(MatDenseRestoreArrayWrite(*K, &a));
  PetscCall(MatAssemblyBegin(*K, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(*K, MAT_FINAL_ASSEMBLY));
  PetscCall(PetscFree(kernel));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* One row per type of stiffness. */
static const struct {
  const char *name;
  PetscErrorCode (*create)(MPI_Comm, const SlipGrid *, Mat *);
} SlipStiffnessTypes[] = {
  {"dense", StiffnessCreate_Dense},
  {"fft", SlipStiffnessCreate_FFT},
};

/*@C
  MatCreateSlipStiffness - creates the stiffness of a uniform grid of cells on a vertical strike-slip plane

  Collective

  Input Parameters:
+ comm - communicator
. grid - cells, extents [m] and kernel
- type - "dense" (MATDENSE), "fft" (products by fast Fourier transforms, exact) or "auto"

  Output Parameter:
. K - symmetric N x N matrix [Pa/m], N = nx * nz, rows distributed by PETSC_DECIDE

  Notes:
  Entry (i, j) is the stress drop at the centre of cell i for unit slip on cell j. Collocation at centres is not exactly
  symmetric below a free surface; K is the symmetric part. If grid->kernel.average is set, entry (i, j) is the average
  over cell i of SlipKernelAverage(), which is symmetric: SLIP_AVERAGE_CELL has the core SLIP_CORE_CELL at all edges,
  SLIP_AVERAGE_WHOLE has SLIP_CORE_INNER, and SLIP_CORE_BORDER at edges of the grid other than the free surface. The
  viscosities "spectral" and "toeplitz" do not support the latter, nor a K below a free surface whose kernel's type has
  no surface(). MatScale(), MatGetDiagonal() and conversion to MATDENSE work on every type.

  Errors: PETSC_ERR_ARG_OUTOFRANGE for a bad grid, those of SlipKernelCheck(), PETSC_ERR_SUP for a kernel without
  SLIP_EVEN_STRIKE, PETSC_ERR_ARG_UNKNOWN_TYPE for an unknown type

  Level: beginner

.seealso: MatSlipStiffnessSetFromOptions(), SlipKernelHalfSpace(), MatCreateSlipStiffnessFromEntries(),
          MatCreateSlipViscosity()
@*/
PetscErrorCode MatCreateSlipStiffness(MPI_Comm comm, const SlipGrid *grid, const char *type, Mat *K)
{
  const PetscInt ntypes = (PetscInt)PETSC_STATIC_ARRAY_LENGTH(SlipStiffnessTypes);
  PetscInt k;
  PetscBool match = PETSC_FALSE, automatic;

  PetscFunctionBegin;
  PetscCall(SlipMatInitializePackage());
  PetscCall(SlipGridCheck(comm, grid));
  PetscCall(PetscStrcmp(type, "auto", &match));
  automatic = match;
  if (match) type = grid->nx * grid->nz > SLIP_DENSE_MAX ? "fft" : "dense";
  for (k = 0; k < ntypes; k++) {
    PetscCall(PetscStrcmp(type, SlipStiffnessTypes[k].name, &match));
    if (match) break;
  }
  PetscCheck(match, comm, PETSC_ERR_ARG_UNKNOWN_TYPE, "Unknown type of stiffness \"%s\"; known: dense, fft, auto",
             type);
  PetscCall(PetscLogEventBegin(SLIP_StiffnessSetUp, 0, 0, 0, 0));
  PetscCall(SlipStiffnessTypes[k].create(comm, grid, K));
  PetscCall(PetscLogEventEnd(SLIP_StiffnessSetUp, 0, 0, 0, 0));
  PetscCall(SlipLogProducts(*K, SLIP_StiffnessMult));
  if (automatic)
    PetscCall(SlipNote(*K, "SlipWhy", "auto: a uniform grid of %s %d cells",
                       grid->nx * grid->nz > SLIP_DENSE_MAX ? "more than" : "at most", SLIP_DENSE_MAX));
  else
    PetscCall(SlipNote(*K, "SlipWhy", "%s as asked", type));
  /* Other matrices transform the grid's kernel, which does not have the terms of cells at the border. */
  if (grid->kernel.average != SLIP_AVERAGE_WHOLE && SlipKernelTransforms(&grid->kernel))
    PetscCall(SlipGridCompose(*K, grid));
  PetscCall(MatSetOption(*K, MAT_SYMMETRIC, PETSC_TRUE));
  PetscCall(MatSetOption(*K, MAT_SPD, PETSC_TRUE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  MatSlipStiffnessSetDepth - sets how products by transforms along strike treat depth

  Logically collective

  Input Parameters:
+ K    - stiffness; ignored unless it is of type "fft"
- type - "blocks" (a dense block per wavenumber), "transform" (as along strike) or "auto" (the faster one; default)

  Options Database Key:
. -mat_slipfft_depth <auto> - the same, for MatSlipStiffnessSetFromOptions()

  Errors: PETSC_ERR_ARG_UNKNOWN_TYPE; PETSC_ERR_ORDER after the first product

  Level: advanced

.seealso: MatCreateSlipStiffness(), MatSlipStiffnessSetShare(), MatSlipStiffnessSetFromOptions()
@*/
PetscErrorCode MatSlipStiffnessSetDepth(Mat K, const char type[])
{
  PetscFunctionBegin;
  PetscTryMethod(K, "MatSlipStiffnessSetDepth_C", (Mat, const char[]), (K, type));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  MatSlipStiffnessSetFromOptions - reads the options of a stiffness, with its prefix

  Collective

  Input Parameter:
. K - stiffness that has not been used yet

  Options Database Keys:
+ -mat_slipfft_depth <auto> - MatSlipStiffnessSetDepth(): blocks, transform, or the faster one
- -mat_slip_share <auto>    - MatSlipStiffnessSetShare(): spread wavenumbers over the ranks

  Level: intermediate

.seealso: MatCreateSlipStiffness(), MatSetOptionsPrefix()
@*/
PetscErrorCode MatSlipStiffnessSetFromOptions(Mat K)
{
  char depth[64] = "auto";
  PetscBool share = PETSC_FALSE, set_depth, set_share;

  PetscFunctionBegin;
  PetscObjectOptionsBegin((PetscObject)K);
  PetscCall(PetscOptionsString("-mat_slipfft_depth",
                               "In depth: dense blocks per wavenumber (blocks), transforms as along strike "
                               "(transform), or the faster one (auto)",
                               "MatSlipStiffnessSetDepth", depth, depth, sizeof(depth), &set_depth));
  PetscCall(PetscOptionsBool("-mat_slip_share", "Spread wavenumbers over the ranks (default: more than 30 cells deep)",
                             "MatSlipStiffnessSetShare", share, &share, &set_share));
  PetscOptionsEnd();
  if (set_depth) PetscCall(MatSlipStiffnessSetDepth(K, depth));
  if (set_share) PetscCall(MatSlipStiffnessSetShare(K, share));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The error in the entries of a stiffness, which rank 0 broadcasts */
typedef struct {
  enum { ENTRIES_GOOD, ENTRIES_MISSING, ENTRIES_NOT_FINITE, ENTRIES_NOT_SYMMETRIC, ENTRIES_NOT_POSITIVE } what;
  PetscInt i, j;
  PetscReal value, other;
} SlipEntriesFault;

/* Checks that entries are finite, and symmetric relative to the largest entry, as far entries are small. */
static void CheckFiniteAndSymmetric(PetscInt N, const PetscReal *e, SlipEntriesFault *fault)
{
  PetscReal largest = 0;

  for (size_t k = 0; k < (size_t)N * N; k++) {
    if (PetscIsInfOrNanReal(e[k])) {
      *fault = (SlipEntriesFault){ENTRIES_NOT_FINITE, (PetscInt)(k / N), (PetscInt)(k % N), e[k], 0};
      return;
    }
    largest = PetscMax(largest, PetscAbsReal(e[k]));
  }
  for (PetscInt i = 0; i < N; i++)
    for (PetscInt j = 0; j < i; j++) {
      const PetscReal lower = e[(size_t)i * N + j], upper = e[(size_t)j * N + i];

      if (PetscAbsReal(lower - upper) > 1e-8 * largest) {
        *fault = (SlipEntriesFault){ENTRIES_NOT_SYMMETRIC, i, j, lower, upper};
        return;
      }
    }
}

/* On rank 0, checks the entries, computes the symmetric part, and tests it by a Cholesky factorisation. */
static PetscErrorCode CheckEntries(PetscInt N, const PetscReal *e, PetscReal **symmetric, SlipEntriesFault *fault)
{
  PetscReal *factor;
  PetscBLASInt bn, info;

  PetscFunctionBegin;
  *fault = (SlipEntriesFault){ENTRIES_GOOD, 0, 0, 0, 0};
  if (!e) {
    fault->what = ENTRIES_MISSING;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  CheckFiniteAndSymmetric(N, e, fault);
  if (fault->what != ENTRIES_GOOD) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1((size_t)N * N, symmetric));
  PetscCall(PetscMalloc1((size_t)N * N, &factor));
  for (PetscInt i = 0; i < N; i++)
    for (PetscInt j = 0; j < N; j++)
      (*symmetric)[(size_t)i * N + j] = 0.5 * (e[(size_t)i * N + j] + e[(size_t)j * N + i]);
  PetscCall(PetscArraycpy(factor, *symmetric, (size_t)N * N));
  PetscCall(PetscBLASIntCast(N, &bn));
  PetscCallBLAS("LAPACKpotrf", LAPACKpotrf_("L", &bn, factor, &bn, &info));
  if (info) *fault = (SlipEntriesFault){ENTRIES_NOT_POSITIVE, info, info, 0, 0};
  PetscCall(PetscFree(factor));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  MatCreateSlipStiffnessFromEntries - creates a stiffness from given entries of a matrix

  Collective

  Input Parameters:
+ comm    - communicator
. N       - number of cells
. entries - N * N entries [Pa/m], row-major, on rank 0; ignored elsewhere
- source  - their source (file and dataset), for error messages

  Output Parameter:
. K - the symmetric part as MATDENSE, rows distributed by PETSC_DECIDE

  Errors: PETSC_ERR_ARG_WRONG when an entry is not finite, entries (i, j) and (j, i) differ by more than 1e-8 of the
  largest entry, or the matrix is not positive definite (Cholesky); the message names source and the entry

  Level: intermediate

.seealso: MatCreateSlipStiffness()
@*/
PetscErrorCode MatCreateSlipStiffnessFromEntries(MPI_Comm comm, PetscInt N, const PetscReal *entries,
                                                 const char *source, Mat *K)
{
  SlipEntriesFault f;
  PetscReal *symmetric = NULL;
  PetscMPIInt rank;

  PetscFunctionBegin;
  PetscCheck(N > 0, comm, PETSC_ERR_ARG_OUTOFRANGE, "%s: a stiffness needs at least one row, not %" PetscInt_FMT,
             source, N);
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  if (rank == 0) PetscCall(CheckEntries(N, entries, &symmetric, &f));
  PetscCallMPI(MPI_Bcast(&f, (int)sizeof(f), MPI_BYTE, 0, comm));
  if (f.what != ENTRIES_GOOD) PetscCall(PetscFree(symmetric));
  PetscCheck(f.what != ENTRIES_MISSING, comm, PETSC_ERR_ARG_NULL, "%s: rank 0 must pass the entries of the stiffness",
             source);
  PetscCheck(f.what != ENTRIES_NOT_FINITE, comm, PETSC_ERR_ARG_WRONG,
             "%s: entry (%" PetscInt_FMT ", %" PetscInt_FMT ") of the stiffness is %g, expected a finite number",
             source, f.i, f.j, (double)f.value);
  PetscCheck(f.what != ENTRIES_NOT_SYMMETRIC, comm, PETSC_ERR_ARG_WRONG,
             "%s: the stiffness is not symmetric to 1e-8 of its largest entry: (%" PetscInt_FMT ", %" PetscInt_FMT
             ") is %.12g but its transpose is %.12g",
             source, f.i, f.j, (double)f.value, (double)f.other);
  PetscCheck(f.what != ENTRIES_NOT_POSITIVE, comm, PETSC_ERR_ARG_WRONG,
             "%s: the stiffness is not positive definite: its leading minor of order %" PetscInt_FMT
             " is not positive (wrong sign or unit?)",
             source, f.i);
  PetscCall(SlipDenseScatter(comm, PETSC_DECIDE, N, symmetric, K));
  PetscCall(PetscFree(symmetric));
  PetscCall(SlipLogProducts(*K, SLIP_StiffnessMult));
  PetscCall(SlipNote(*K, "SlipWhy", "the entries of %s", source));
  PetscCall(MatSetOption(*K, MAT_SPD, PETSC_TRUE));
  PetscFunctionReturn(PETSC_SUCCESS);
}
