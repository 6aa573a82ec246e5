/* MatCreateSlipViscosity(): H = 2 zeta sqrt(mass) K^(1/2), the matrix square root. */
#include <slipstep/rooms/slipmat.h>
#include <slipcompat.h>
#include <slipstep/private/slipsys.h>
#include <slipstep/private/slipmatinterface.h>

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

/* Number of rows up to which a hierarchical stiffness has a dense root; above, Lanczos' method applies the root. */
#define SLIP_ROOT_DENSE_MAX 800
/* The same number for averages over the cells of a grid, whose products by transforms are cheaper */
#define SLIP_ROOT_AVERAGE_MAX 1000

/* Creates the root in a way that fits the stiffness: spectral plus low rank or Lanczos' method for an FFT, Lanczos'
   method for many cells of hierarchical storage or of averages, otherwise a dense root. */
static PetscErrorCode ViscosityCreate_Sqrtm(Mat K, PetscReal factor, Mat *H)
{
  const SlipGrid *grid;
  PetscBool fft, hmat;
  PetscInt N;

  PetscFunctionBegin;
  PetscCall(MatGetSize(K, &N, NULL));
  PetscCall(PetscObjectTypeCompareAny((PetscObject)K, &fft, "slipfft", "slipdippingfft", ""));
  PetscCall(PetscObjectTypeCompare((PetscObject)K, "sliphmat", &hmat));
  PetscCall(SlipGridOf(K, &grid));
  if (fft && grid)
    PetscCall(SlipViscosityCreate_SpectralExact(K, factor, H));
  else if ((fft && N > SLIP_ROOT_AVERAGE_MAX) || (hmat && N > SLIP_ROOT_DENSE_MAX))
    PetscCall(SlipViscosityCreate_Lanczos(K, factor, H));
  else
    PetscCall(SlipViscosityCreate_DenseRoot(K, factor, H));
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
  MatCreateSlipViscosity - creates the viscosity H = 2 zeta M (M^-1 K)^(1/2), M = mass * I, with one damping ratio for
  all modes of K

  Collective

  Input Parameters:
+ K    - stiffness [Pa/m], N x N
. mass - inertia per unit area, density times mobilised thickness [kg/m^2], positive
. zeta - damping ratio, zero or positive, dimensionless
- type - "sqrtm" (the exact matrix square root), "spectral" (square root per wavenumber along strike of the periodic
         problem; uniform grids only), "lanczos" (the exact root by Lanczos' method in each product; any stiffness, no
         set-up), "toeplitz" (the root on an endless plane, with errors of a few per cent along the fault's edges;
         uniform grids only) or "none" (zero)

  Output Parameter:
. H - symmetric N x N matrix [Pa s/m] with K's distribution and K's prefix for options

  Options Database Keys:
+ -mat_slipsqrtm_setup <auto>     - exact root on a uniform grid: sketch (a low-rank part is set up), lanczos (no
                                    set-up), or auto (lanczos, and up to 10000 cells sketch after as much work as its
                                    set-up takes)
. -mat_slipsqrtm_tolerance        - relative error of its products: 1e-10 by sketch, 1e-8 by lanczos
- -mat_slipspectral_type <auto>   - spectral: blocks, lanczos, or by size

  Note: this function reads these options, with K's prefix, because they choose the type of the matrix; call
  MatSetOptionsPrefix() for K before. MatSlipViscositySetFromOptions() reads the tolerance again, with H's prefix.

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
  const char *prefix;
  PetscInt k;
  PetscBool match = PETSC_FALSE, dense, lanczos;
  MatType stiffness;

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
  PetscCall(MatGetOptionsPrefix(K, &prefix));
  PetscCall(MatSetOptionsPrefix(*H, prefix));
  if (factor > 0) PetscCall(SlipLogProducts(*H, SLIP_ViscosityMult));
  PetscCall(PetscStrcmp(type, "sqrtm", &match));
  if (match) {
    PetscCall(MatGetType(K, &stiffness));
    PetscCall(PetscObjectTypeCompareAny((PetscObject)*H, &dense, MATSEQDENSE, MATMPIDENSE, ""));
    PetscCall(PetscObjectTypeCompare((PetscObject)*H, "sliplanczos", &lanczos));
    PetscCall(SlipNote(*H, "SlipWhy", "sqrtm, %s, as the stiffness is %s",
                       dense     ? "dense"
                       : lanczos ? "by Lanczos' method in each product"
                                 : "spectral plus what that misses",
                       stiffness));
  } else
    PetscCall(SlipNote(*H, "SlipWhy", "%s as asked", type));
  PetscCall(SlipViscosityComposeFactor(*H, factor));
  PetscFunctionReturn(PETSC_SUCCESS);
}
