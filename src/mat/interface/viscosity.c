/* MatCreateSlipViscosity(): H = 2 zeta sqrt(mass) K^(1/2), the matrix square root. */
#include <slipmat.h>
#include <slipcompat.h>
#include <slipstep/private/slipsys.h>
#include <slipstep/private/slipmatviscosity.h>

static PetscErrorCode ViscosityCreate_None(Mat K, PetscReal factor, Mat *H)
{
  PetscInt m, N;

  PetscFunctionBegin;
  (void)factor;
  PetscCall(MatGetSize(K, &N, NULL));
  PetscCall(MatGetLocalSize(K, &m, NULL));
  PetscCall(MatCreateConstantDiagonal(PetscObjectComm((PetscObject)K), m, m, N, N, 0, H));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* sqrt(scale * K) of a uniform grid, by its mirror blocks. One process. */
static PetscErrorCode SqrtOfGrid(const SlipGrid *g, PetscReal scale, PetscReal root[], PetscReal *smallest,
                                 PetscInt *info)
{
  const PetscInt nx = g->nx, nz = g->nz;
  PetscReal *kernel, *block[2], lowest;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1((size_t)nx * nz * nz, &kernel));
  for (PetscInt d = 0; d < nx; d++) SlipGridKernel(g, d, kernel + (size_t)d * nz * nz);
  *info = 0;
  *smallest = PETSC_MAX_REAL;
  for (PetscInt parity = 0; parity < 2; parity++) {
    const PetscInt n = SlipMirrorWidth(nx, parity) * nz;

    PetscCall(PetscMalloc1((size_t)n * n, &block[parity]));
    SlipMirrorSplit(nx, nz, kernel, scale, parity, block[parity]);
    if (n && !*info && *smallest > 0) {
      PetscCall(SlipDenseSqrt(n, block[parity], &lowest, info));
      *smallest = PetscMin(*smallest, lowest);
    }
  }
  PetscCall(PetscFree(kernel));
  SlipMirrorMerge(nx, nz, block[0], block[1], root);
  PetscCall(PetscFree(block[0]));
  PetscCall(PetscFree(block[1]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Rank 0 computes the root, so that it does not depend on the number of ranks. */
static PetscErrorCode ViscosityCreate_SqrtmDense(Mat K, PetscReal factor, Mat *H)
{
  MPI_Comm comm = PetscObjectComm((PetscObject)K);
  const SlipGrid *grid;
  PetscReal *root = NULL, scale = 1, result[2] = {1, 0};
  PetscMPIInt rank;
  PetscInt N, info = 0;
  PetscBool found;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCall(MatGetSize(K, &N, NULL));
  PetscCall(SlipGridOf(K, &grid));
  PetscCall(SlipCacheLoadRoot(K, &root, &found));
  if (grid)
    PetscCall(SlipGridScale(K, &scale));
  else if (!found)
    PetscCall(SlipDenseGather(K, &root));
  if (rank == 0 && !found) {
    if (grid) PetscCall(PetscMalloc1((size_t)N * N, &root));
    if (grid)
      PetscCall(SqrtOfGrid(grid, scale, root, &result[0], &info));
    else
      PetscCall(SlipDenseSqrt(N, root, &result[0], &info));
    result[1] = (PetscReal)info;
  }
  PetscCallMPI(MPI_Bcast(result, 2, MPIU_REAL, 0, comm));
  if (!found && result[1] == 0 && result[0] > 0) PetscCall(SlipCacheSaveRoot(K, root));
  for (size_t k = 0; !rank && k < (size_t)N * N; k++) root[k] *= factor;
  PetscCheck(result[1] == 0, comm, PETSC_ERR_LIB, "Eigenvalues of the stiffness did not converge (LAPACK info %g)",
             (double)result[1]);
  PetscCheck(result[0] > 0, comm, PETSC_ERR_ARG_WRONG,
             "The stiffness has no real square root: its smallest eigenvalue is %g Pa/m", (double)result[0]);
  PetscCall(SlipDenseScatter(comm, PETSC_DECIDE, N, root, H));
  PetscCall(PetscFree(root));
  PetscCall(MatSetOption(*H, MAT_SPD, PETSC_TRUE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The root takes after the stiffness: dense for a dense one, spectral plus low rank for an FFT. */
static PetscErrorCode ViscosityCreate_Sqrtm(Mat K, PetscReal factor, Mat *H)
{
  PetscBool fft, cells;

  PetscFunctionBegin;
  PetscCall(PetscObjectTypeCompare((PetscObject)K, "slipfft", &fft));
  PetscCall(SlipViscosityIsOfCells(K, &cells));
  if (cells)
    PetscCall(SlipViscosityCreate_Cells(K, factor, H));
  else if (fft)
    PetscCall(SlipViscosityCreate_SpectralExact(K, factor, H));
  else
    PetscCall(ViscosityCreate_SqrtmDense(K, factor, H));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* H remembers its factor, from which a preconditioner knows the viscosity's symbol. */
static PetscErrorCode ComposeFactor(Mat H, PetscReal factor)
{
  PetscReal *copy;

  PetscFunctionBegin;
  PetscCall(PetscNew(&copy));
  *copy = factor;
  PetscCall(SlipObjectComposeData((PetscObject)H, "SlipViscosityFactor", copy, SlipContainerDestroyDefault));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* factor of H = factor * sqrt(K) [sqrt(kg) / m]; 0 when H was not made by MatCreateSlipViscosity() or is zero. */
PetscErrorCode SlipViscosityGetFactor(Mat H, PetscReal *factor)
{
  const PetscReal *composed;

  PetscFunctionBegin;
  PetscCall(SlipObjectQueryData((PetscObject)H, "SlipViscosityFactor", &composed));
  *factor = composed ? *composed : 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* One row per type of viscosity; factor is 2 zeta sqrt(mass). */
static const struct {
  const char *name;
  PetscErrorCode (*create)(Mat K, PetscReal factor, Mat *H);
} SlipViscosityTypes[] = {
  {"sqrtm", ViscosityCreate_Sqrtm},         {"spectral", SlipViscosityCreate_Spectral},
  {"lanczos", SlipViscosityCreate_Lanczos}, {"toeplitz", SlipViscosityCreate_Plane},
  {"none", ViscosityCreate_None},
};

/*@C
  MatCreateSlipViscosity - viscosity H = 2 zeta M (M^-1 K)^(1/2), M = mass * I, that damps every mode of K alike

  Collective

  Input Parameters:
+ K    - stiffness [Pa/m], N x N
. mass - inertia per unit area, density times mobilised thickness [kg/m^2], positive
. zeta - damping ratio, zero or positive, dimensionless
- type - "sqrtm" (the exact matrix square root), "spectral" (square root per wavenumber along strike of the problem made
         periodic; uniform grids only), "lanczos" (the root again, by Lanczos' method in each product; any
         stiffness, no set-up), "toeplitz" (the root on an endless plane, a few per cent off along the fault's edges;
         uniform grids only) or "none" (zero)

  Output Parameter:
. H - symmetric N x N matrix [Pa s/m] with K's distribution

  Errors: PETSC_ERR_ARG_OUTOFRANGE for mass or zeta, PETSC_ERR_ARG_UNKNOWN_TYPE, PETSC_ERR_ARG_WRONG when K has an
  eigenvalue that is not positive

  Level: beginner

.seealso: MatCreateSlipStiffness(), MatCreateSlipStage()
@*/
PetscErrorCode MatCreateSlipViscosity(Mat K, PetscReal mass, PetscReal zeta, const char *type, Mat *H)
{
  MPI_Comm comm = PetscObjectComm((PetscObject)K);
  const PetscInt ntypes = (PetscInt)PETSC_STATIC_ARRAY_LENGTH(SlipViscosityTypes);
  PetscReal factor;
  PetscInt k;
  PetscBool match = PETSC_FALSE;

  PetscFunctionBegin;
  PetscCheck(mass > 0 && PetscIsNormalReal(mass), comm, PETSC_ERR_ARG_OUTOFRANGE,
             "Inertia per unit area must be positive and finite, not %g kg/m^2", (double)mass);
  PetscCheck(zeta >= 0 && !PetscIsInfOrNanReal(zeta), comm, PETSC_ERR_ARG_OUTOFRANGE,
             "Damping ratio must be zero or positive and finite, not %g", (double)zeta);
  for (k = 0; k < ntypes; k++) {
    PetscCall(PetscStrcmp(type, SlipViscosityTypes[k].name, &match));
    if (match) break;
  }
  PetscCheck(match, comm, PETSC_ERR_ARG_UNKNOWN_TYPE,
             "Unknown type of viscosity \"%s\"; known: sqrtm, spectral, lanczos, toeplitz, none", type);
  PetscCall(PetscStrcmp(type, "none", &match));
  factor = match ? 0 : 2 * zeta * PetscSqrtReal(mass);
  PetscCall(PetscLogEventBegin(SLIP_ViscositySetUp, K, 0, 0, 0));
  PetscCall(SlipViscosityTypes[k].create(K, factor, H));
  PetscCall(PetscLogEventEnd(SLIP_ViscositySetUp, K, 0, 0, 0));
  PetscCall(SlipLogProducts(*H, SLIP_ViscosityMult));
  PetscCall(SlipViscosityNote(K, *H, type));
  PetscCall(ComposeFactor(*H, factor));
  PetscFunctionReturn(PETSC_SUCCESS);
}
