/* Sets up the stiffness, from the mesh or a file, its scaling, the viscosity, and the stage operator. */
#include <slipstep/private/slipfault.h>
#include <slipstep/private/slipmatcommon.h>
#include <math.h>

#define SLIP_FAULT_MAX_DENSE 10000 /* cells up to which K is written as a dense matrix */

/* On rank 0: reads the N*N entries of the file, and checks their number and that they are finite. */
static PetscErrorCode SlipFaultReadStiffness(SlipFault fault, PetscReal **entries)
{
  char file[PETSC_MAX_PATH_LEN], dataset[PETSC_MAX_PATH_LEN], *colon;
  SlipH5 h;
  const PetscInt want[2] = {fault->mesh.N, fault->mesh.N};
  const char *prefix = SlipFaultPrefix(fault);
  const size_t N = (size_t)fault->mesh.N;
  PetscInt dims[2];
  PetscBool said;
  PetscErrorCode ierr;

  PetscFunctionBegin;
  /* F.h5:/dataset */
  PetscCall(PetscStrncpy(file, fault->options.text[FAULT_STIFFNESS_FILE], sizeof(file)));
  PetscCall(PetscStrncpy(dataset, "/stiffness", sizeof(file)));
  PetscCall(PetscStrstr(file, ":/", &colon));
  if (colon) {
    PetscCall(PetscStrncpy(dataset, colon + 1, sizeof(file)));
    *colon = '\0';
  }
  PetscCall(SlipH5OpenReadOption(SlipFaultPrefix(fault), "fault_stiffness_file", file, &h));
  ierr = SlipH5CheckUnits(&h, dataset, "Pa/m", &said);
  if (!ierr) ierr = SlipH5ReadRealSized(&h, dataset, 2, want, "N x N with N = nx nz", dims, entries);
  PetscCall(SlipH5Close(&h));
  PetscCall(ierr);
  for (size_t k = 0; k < N * N; k++)
    PetscCheck(isfinite((*entries)[k]), PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
               "%s (-%sfault_stiffness_file): %s[%zu, %zu] is %.6g, expected a finite number", file, prefix, dataset,
               k / N, k % N, (double)(*entries)[k]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SlipFaultLoadStiffness(SlipFault fault, Mat *K)
{
  PetscReal *entries = NULL;
  PetscErrorCode ierr = PETSC_SUCCESS;
  PetscMPIInt rank;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(fault->comm, &rank));
  if (!rank) ierr = SlipFaultReadStiffness(fault, &entries);
  if (!rank && !ierr)
    fault->operators.read = SlipHashReals(SLIP_HASH_START, entries, (size_t)fault->mesh.N * (size_t)fault->mesh.N);
  ierr = SlipErrorBcast(fault->comm, ierr);
  if (!ierr) PetscCallMPI(MPI_Bcast(&fault->operators.read, 1, MPI_UINT64_T, 0, fault->comm));
  if (!ierr)
    ierr = MatCreateSlipStiffnessFromEntries(fault->comm, fault->mesh.N, entries,
                                             fault->options.text[FAULT_STIFFNESS_FILE], K);
  PetscCall(PetscFree(entries));
  PetscCall(ierr);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Scales K such that mean(K^-1 sigma_n) = mean(sigma_n) Ly/G; on return x is K^-1 sigma_n of the scaled K. */
static PetscErrorCode SlipFaultScaleStiffness(SlipFault fault, Vec sigma, Vec x)
{
  PetscReal mean_slip, mean_stress, thickness;
  PetscBool scale;
  Vec along;

  PetscFunctionBegin;
  PetscCall(VecZeroEntries(x));
  PetscCall(SlipElasticSolve(fault->medium, sigma, x));
  PetscCall(PetscStrcmp(fault->options.text[FAULT_STIFFNESS_SCALING], "mean_slip", &scale));
  if (!scale) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipFaultGetReal(fault, "thickness", &thickness));
  PetscCall(SlipFaultWeightedSum(fault, x, &mean_slip));
  if (fault->layout.components == 1)
    PetscCall(VecSum(sigma, &mean_stress));
  else {
    PetscCall(VecDuplicate(sigma, &along));
    PetscCall(SlipFaultFillAlong(fault, NULL, PETSC_FALSE, along));
    PetscCall(VecDot(sigma, along, &mean_stress));
    PetscCall(VecDestroy(&along));
  }
  fault->operators.scaling = mean_slip * fault->options.value[FAULT_SHEAR_MODULUS] / (mean_stress * thickness);
  PetscCall(SlipElasticScale(fault->medium, fault->operators.scaling));
  PetscCall(VecScale(x, 1 / fault->operators.scaling));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SlipFaultViewStiffness(SlipFault fault, Mat K)
{
  const size_t N = (size_t)fault->mesh.N;
  PetscReal *a, *b = NULL;
  Mat dense;

  PetscFunctionBegin;
  if (!fault->options.stiffness_viewer) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCheck(fault->mesh.N <= SLIP_FAULT_MAX_DENSE, fault->comm, PETSC_ERR_ARG_OUTOFRANGE,
             "-%sfault_stiffness_view writes %" PetscInt_FMT " x %" PetscInt_FMT " numbers, expected at most %d cells",
             SlipFaultPrefix(fault), fault->mesh.N, fault->mesh.N, SLIP_FAULT_MAX_DENSE);
  PetscCall(MatConvert(K, MATDENSE, MAT_INITIAL_MATRIX, &dense));
  if (fault->mesh.order) {
    /* rows and columns in the order of the mesh's file */
    PetscCall(SlipDenseGather(dense, &a));
    PetscCall(MatDestroy(&dense));
    if (a) PetscCall(PetscMalloc1(N * N, &b));
    for (size_t i = 0; i < N && a; i++)
      for (size_t j = 0; j < N; j++) b[(size_t)fault->mesh.order[i] * N + (size_t)fault->mesh.order[j]] = a[i * N + j];
    PetscCall(PetscFree(a));
    PetscCall(SlipDenseScatter(fault->comm, PETSC_DECIDE, fault->mesh.N, b, &dense));
    PetscCall(PetscFree(b));
  }
  PetscCall(PetscViewerPushFormat(fault->options.stiffness_viewer, fault->options.stiffness_format));
  PetscCall(MatView(dense, fault->options.stiffness_viewer));
  PetscCall(PetscViewerPopFormat(fault->options.stiffness_viewer));
  PetscCall(MatDestroy(&dense));
  PetscCall(PetscViewerDestroy(&fault->options.stiffness_viewer)); /* closes the file */
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Without inertia no slip rate balances a cell whose strength falls with rate by more than viscosity gains. */
static PetscErrorCode CheckBalance(SlipFault fault)
{
  SlipFrictionCells friction;
  PetscReal worst = 0; /* loss of damping over viscosity */
  const PetscReal *h;
  Vec damping;

  PetscFunctionBegin;
  if (fault->kind.inertia || !fault->friction.law->by_rate || fault->friction.law->always_slides)
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipFaultGetFriction(fault, 0, &friction));
  PetscCall(SlipElasticGetDiagonals(fault->medium, NULL, &damping));
  PetscCall(VecGetArrayRead(damping, &h));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    PetscReal mu, ds, dv;

    SlipFrictionEvaluate(&friction, i, NULL, 0, &mu, &ds, &dv);
    worst = PetscMax(worst, -dv * fault->mesh.weight[i] * fault->fields.cell[FIELD_NORMAL_STRESS][i] /
                              SlipFaultLargest(fault, h, i));
  }
  PetscCall(VecRestoreArrayRead(damping, &h));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &worst, 1, MPIU_REAL, MPIU_MAX, fault->comm));
  PetscCheck(worst < 1, fault->comm, PETSC_ERR_ARG_INCOMP,
             "-%sfault_inertia no: the strength of -%sfault_friction_law %s falls with slip rate %.3g times as fast as "
             "viscosity grows, so that no slip rate is in balance: expected less than 1 times%s",
             SlipFaultPrefix(fault), SlipFaultPrefix(fault), fault->friction.law->name, (double)worst,
             fault->kind.waves ? "" : ", or inertia");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Iterations of conjugate gradients that find a mode without stiffness, on planes up to the ground (measured) */
#define SLIP_OPENING_PRODUCTS 100

/* Refuses an indefinite stiffness. Rock above cells that are wide against their depth bends like a plate: uniform
   opening hardly presses the centre of such a cell, and a little more of it even pulls there, so that cells open by
   themselves. Averages over cells are energies, and positive. */
static PetscErrorCode CheckOpening(SlipFault fault)
{
  const char *prefix = SlipFaultPrefix(fault);
  PetscBool indefinite;
  Vec x, b;
  PetscReal *a;

  PetscFunctionBegin;
  if (!SlipFaultOpens(fault)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipFaultGetWork(fault, &x));
  PetscCall(SlipFaultGetWork(fault, &b));
  PetscCall(VecGetArrayWrite(b, &a));
  for (PetscInt i = 0; i < fault->mesh.n; i++)
    for (PetscInt k = 0; k < 3; k++) {
      const PetscInt number = 3 * SlipFaultMeshRow(&fault->mesh, i) + k;

      a[3 * i + k] = PetscSinReal(2 + (PetscReal)3.7 * (PetscReal)number); /* without symmetry */
    }
  PetscCall(VecRestoreArrayWrite(b, &a));
  PetscCall(SlipElasticIsIndefinite(fault->medium, SLIP_OPENING_PRODUCTS, b, x, &indefinite));
  PetscCall(SlipFaultRestoreWork(fault, &b));
  PetscCall(SlipFaultRestoreWork(fault, &x));
  PetscCheck(
    !indefinite, fault->comm, PETSC_ERR_ARG_INCOMP,
    "-%sfault_opening yes: the stiffness is not positive definite, so cells would open without a load; this happens "
    "where they are wide compared with their depth: expected smaller cells below the ground, or triangles "
    "(-%sfault_mesh) with -%sfault_stiffness_average cell and a dip of 15 degrees at least where they reach it",
    prefix, prefix, prefix);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates the medium; before the loads, as a medium may load the fault. */
PetscErrorCode SlipFaultMediumCreate(SlipFault fault)
{
  PetscFunctionBegin;
  PetscCall(SlipElasticCreate(fault->comm, &fault->medium));
  PetscCall(PetscObjectSetOptionsPrefix((PetscObject)fault->medium, ((PetscObject)fault)->prefix));
  PetscCall(SlipElasticSetType(fault->medium, fault->options.text[FAULT_MEDIUM]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Collects the properties of the rock: impedance G/(2 cs), cs = sqrt(G/rho), and across cells rho cp/2, where cp^2/cs^2
   = 2 (1 - nu)/(1 - 2 nu). */
static SlipElasticRock Rock(SlipFault fault)
{
  const PetscReal *value = fault->options.value, nu = value[FAULT_POISSON_RATIO];
  const PetscReal shear = 0.5 * PetscSqrtReal(value[FAULT_SHEAR_MODULUS] * value[FAULT_DENSITY]);

  return (SlipElasticRock){.shear_modulus = value[FAULT_SHEAR_MODULUS],
                           .poisson_ratio = nu,
                           .density = value[FAULT_DENSITY],
                           .mass = fault->operators.mass,
                           .inertia = fault->kind.inertia,
                           .viscosity = fault->kind.viscosity,
                           .zeta = value[FAULT_DAMPING_RATIO],
                           .impedance = shear,
                           .across = SlipFaultOpens(fault) ? shear * PetscSqrtReal(2 * (1 - nu) / (1 - 2 * nu)) : 0,
                           .tolerance = value[FAULT_KRYLOV_TOLERANCE],
                           .waves_tolerance = value[FAULT_WAVES_TOLERANCE],
                           .waves_padding = value[FAULT_WAVES_PADDING],
                           .components = fault->layout.components,
                           .order = fault->mesh.order};
}

/* Describes the cells of a uniform grid. */
static SlipElasticGrid Grid(SlipFault fault)
{
  const PetscReal *extent = fault->mesh.extent;
  PetscBool full_space, mirror;

  (void)PetscStrcmp(fault->options.text[FAULT_KERNEL], "full_space", &full_space);
  (void)PetscStrcmp(fault->options.text[FAULT_KERNEL], "mirror", &mirror);
  return (SlipElasticGrid){.nx = fault->mesh.dims[1],
                           .nz = fault->mesh.dims[0],
                           .size = {extent[MESH_LENGTH_X] / (PetscReal)PetscMax(fault->mesh.dims[1], 1),
                                    extent[MESH_LENGTH_Z] / (PetscReal)PetscMax(fault->mesh.dims[0], 1)},
                           .depth_top = extent[MESH_DEPTH_TOP],
                           .full_space = full_space,
                           .mirror = mirror,
                           .rake = fault->fields.cell[FIELD_RAKE]};
}

/* Prints which share of a matrix is computed. */
static PetscErrorCode Waited(void *ctx, const char what[], PetscReal share)
{
  SlipFault fault = (SlipFault)ctx;
  char text[64];

  PetscFunctionBegin;
  PetscCall(PetscSNPrintf(text, sizeof(text), "%s, %.0f %%", what, (double)(100 * share)));
  PetscCall((*fault->told)(fault, text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultStiffnessSetUp(SlipFault fault)
{
  SlipElasticRock rock = Rock(fault);
  SlipElasticGrid grid = Grid(fault);
  PetscBool traction, scaled;
  Vec normal;
  Mat K = NULL, Kn = NULL;

  PetscFunctionBegin;
  PetscCall(PetscStrcmp(fault->kind.initial, "traction", &traction));
  PetscCall(PetscStrcmp(fault->options.text[FAULT_STIFFNESS_SCALING], "mean_slip", &scaled));
  fault->critical.known = !(traction || fault->friction.law->always_slides) || scaled ? PETSC_TRUE : PETSC_FALSE;
  PetscCall((*fault->told)(fault, "stiffness K"));
  if (fault->options.text[FAULT_STIFFNESS_FILE][0])
    PetscCall(SlipFaultLoadStiffness(fault, &K));
  else {
    PetscErrorCode error;

    PetscCall(SlipWaitListen(Waited, fault));
    error = SlipFaultMeshStiffness(fault, &K, fault->kind.coupled ? &Kn : NULL);
    PetscCall(SlipWaitListen(NULL, NULL)); /* also after an error, as the fault may be destroyed */
    PetscCall(error);
  }
  PetscCall(MatSetOptionsPrefix(K, ((PetscObject)fault)->prefix)); /* H and B take it over */
  PetscCall(MatSlipStiffnessSetFromOptions(K));
  PetscCall(SlipFaultDeviceOperators(fault, K, Kn));
  PetscCall(MatCreateVecs(K, &fault->critical.uc, &fault->stage.c));
  PetscCall(SlipElasticSetStiffness(fault->medium, K, Kn));
  PetscCall(MatDestroy(&K));
  PetscCall(MatDestroy(&Kn));
  PetscCall(VecDuplicate(fault->critical.uc, &fault->operators.vinf));
  PetscCall(VecDuplicate(fault->critical.uc, &fault->stage.u0));
  PetscCall(VecCreate(fault->comm, &fault->stage.s0));
  PetscCall(VecSetSizes(fault->stage.s0, fault->layout.states * fault->mesh.n, fault->layout.states * fault->mesh.N));
  PetscCall(VecSetType(fault->stage.s0, fault->device.device ? VECSLIPOPENCL : VECSTANDARD));
  PetscCall(CheckOpening(fault));
  PetscCall(SlipFaultFillAlong(fault, fault->fields.cell[FIELD_LOADING_RATE], PETSC_FALSE, fault->operators.vinf));
  PetscCall(SlipFaultGetWork(fault, &normal));
  PetscCall(SlipFaultFillAlong(fault, fault->fields.cell[FIELD_NORMAL_STRESS], PETSC_TRUE, normal));
  PetscCall(VecZeroEntries(fault->critical.uc));
  if (fault->critical.known) {
    PetscCall((*fault->told)(fault, "K^-1 of the normal stress"));
    PetscCall(SlipFaultScaleStiffness(fault, normal, fault->critical.uc));
  }
  PetscCall(SlipFaultRestoreWork(fault, &normal));
  PetscCall(SlipElasticGetMatrices(fault->medium, &K, NULL, NULL));
  PetscCall(SlipFaultViewStiffness(fault, K));
  PetscCall((*fault->told)(fault, "viscosity H"));
  if (fault->mesh.ndim == 2 && !fault->options.text[FAULT_STIFFNESS_FILE][0]) rock.grid = &grid;
  PetscCall(SlipFaultGetWork(fault, &rock.along));
  PetscCall(SlipFaultFillAlong(fault, NULL, PETSC_TRUE, rock.along));
  PetscCall(SlipElasticSetUp(fault->medium, &rock));
  PetscCall(SlipFaultRestoreWork(fault, &rock.along));
  PetscCall(CheckBalance(fault));
  PetscFunctionReturn(PETSC_SUCCESS);
}
