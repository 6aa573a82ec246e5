/*
  The exact root on a uniform grid. Either sketches (sketch.c) find its difference to the root per wavenumber once, as a
  low-rank part for each mirror parity, or each product uses Lanczos' method, without set-up (lanczos.c).

  The cheaper one depends on the number of products, which is not known at the start of a run. A run therefore begins
  with Lanczos' method, and sets up the low-rank part once the method has taken as long as the set-up.
*/
#include <slipcompat.h>
#include <slipstep/private/sliploops.h>
#include <slipstep/private/slipmatviscosity.h>

/* Most cells for which sketches are made in a run: their low-rank part takes 67 MB there, and the set-up 0.5 GB */
#define SLIP_SQRT_SKETCH_MAX 10000
/* Processor time of the set-up of sketches is about N nz (nz EACH + ROW) [s], from 0.019 s at 20 x 20 over 0.37 s at
   50 x 50 to 4.4 s at 100 x 100 cells of a core of an AMD EPYC: within 1.3 of the clock from 400 to 10,000 cells. */
#define SLIP_SQRT_EACH 4e-8
#define SLIP_SQRT_ROW 1.6e-6
/* Terms below this share of the norm are stored in single precision, whose rounding, 3e-13 of the norm, depends on the
   distribution of rows over ranks. */
#define SLIP_SQRT_SINGLE 4e-6
#define SLIP_SQRT_TOL 1e-10 /* of products, relative to the norm */

/* Broadcasts the low-rank part from the rank `root`. */
static PetscErrorCode BroadcastCorrection(MPI_Comm comm, PetscMPIInt root, SlipLowRank *m)
{
  PetscMPIInt rank;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCallMPI(MPI_Bcast(&m->rank, 1, MPIU_INT, root, comm));
  if (rank != root) {
    PetscCall(PetscMalloc1((size_t)m->n * m->rank, &m->W));
    PetscCall(PetscMalloc1(m->rank, &m->lambda));
  }
  for (PetscInt k = 0; k < m->rank; k++)
    PetscCallMPI(MPI_Bcast(m->W + (size_t)k * m->n, (int)m->n, MPIU_REAL, root, comm));
  PetscCallMPI(MPI_Bcast(m->lambda, (int)m->rank, MPIU_REAL, root, comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the low-rank part, one parity per rank, or both on a single rank, and broadcasts it. */
static PetscErrorCode BuildCorrection(MPI_Comm comm, SlipSpectral *c, PetscReal factor, PetscReal scale,
                                      PetscReal tolerance)
{
  PetscReal bad[2] = {-PETSC_MAX_REAL, 0}; /* minus the smallest eigenvalue; error */
  PetscMPIInt rank, size;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCallMPI(MPI_Comm_size(comm, &size));
  for (PetscInt parity = 0; parity < 2; parity++) {
    SlipLowRank *m = &c->correction[parity];
    PetscReal smallest = PETSC_MAX_REAL, error = 0, *blocks = c->blocks;
    SlipCirculant whole = c->strike;
    const SlipGrid *g;

    if (!m->n || rank != parity % size) continue;
    if (SlipCirculantPencil(c->strike)) {
      SlipCirculantGet(c->strike, &g, NULL, NULL, NULL);
      PetscCall(SlipCirculantCreate(PETSC_COMM_SELF, g, &whole));
      PetscCall(SlipSpectralRootBlocks(whole, factor, scale, &blocks));
    }
    PetscCall(SlipSketchCorrection(whole, blocks, factor * factor * scale, tolerance, parity, &smallest, &error, m));
    if (whole != c->strike) {
      PetscCall(PetscFree(blocks));
      PetscCall(SlipCirculantDestroy(&whole));
    }
    bad[0] = PetscMax(bad[0], -smallest);
    bad[1] = PetscMax(bad[1], error);
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, bad, 2, MPIU_REAL, MPI_MAX, comm));
  PetscCheck(bad[0] < 0, comm, PETSC_ERR_ARG_WRONG,
             "The stiffness has no real square root: an eigenvalue is not positive");
  PetscCheck(bad[1] <= tolerance, comm, PETSC_ERR_NOT_CONVERGED,
             "The exact root was found to %g only, not to -mat_slipsqrtm_tolerance %g", (double)bad[1],
             (double)tolerance);
  for (PetscInt parity = 0; parity < 2; parity++)
    if (c->correction[parity].n)
      PetscCall(BroadcastCorrection(comm, (PetscMPIInt)(parity % size), &c->correction[parity]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates the viscosity as spectral plus low rank, with a tolerance relative to the norm. */
PetscErrorCode SlipViscosityCreate_Sketch(Mat K, PetscReal factor, PetscReal tolerance, Mat *H)
{
  MPI_Comm comm = PetscObjectComm((PetscObject)K);
  const SlipGrid *g;
  PetscReal norm = 0, scale;
  PetscInt start, rows;
  SlipSpectral *c;

  PetscFunctionBegin;
  PetscCall(SlipGridOf(K, &g));
  PetscCall(SlipViscosityCreate_SpectralBlocks(K, factor, H));
  if (factor == 0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MatShellGetContext(*H, &c));
  PetscCall(SlipGridScale(K, &scale));
  for (PetscInt parity = 0; parity < 2; parity++) c->correction[parity].n = SlipMirrorWidth(g->nx, parity) * g->nz;
  PetscCall(BuildCorrection(comm, c, factor, scale, tolerance));
  c->tolerance = tolerance;
  PetscCall(SlipSpectralNorm(comm, c, factor, scale, &norm));
  for (PetscInt parity = 0; parity < 2; parity++) {
    const PetscInt width = SlipMirrorWidth(g->nx, parity); /* coefficients of a row of cells */
    SlipLowRank *m = &c->correction[parity];
    PetscReal *W;

    if (!m->n) continue;
    if (SlipCirculantPencil(c->strike)) { /* other ranks' rows go */
      SlipSpectralRows(c, &start, &rows);
      PetscCall(PetscMalloc1((size_t)rows * width * m->rank, &W));
      for (PetscInt k = 0; k < m->rank; k++)
        PetscCall(PetscArraycpy(W + (size_t)k * rows * width, m->W + (size_t)k * m->n + start * width, rows * width));
      PetscCall(PetscFree(m->W));
      m->W = W;
      m->n = rows * width;
    }
    PetscCall(SlipLowRankDemote(m, SLIP_SQRT_SINGLE * norm));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates the exact root, spectral plus low rank or by Lanczos' method; its options have K's prefix. */
PetscErrorCode SlipViscosityCreate_SpectralExact(Mat K, PetscReal factor, Mat *H)
{
  MPI_Comm comm = PetscObjectComm((PetscObject)K);
  const char *const choices[] = {"auto", "sketch", "lanczos"};
  const char *prefix;
  char setup[64] = "auto";
  PetscReal tolerance = SLIP_SQRT_TOL, cells, set_up;
  const SlipGrid *g;
  VecType vectors;
  PetscInt choice;
  PetscBool known, device, sketch;

  PetscFunctionBegin;
  PetscCall(SlipGridOf(K, &g));
  cells = (PetscReal)(g->nx * g->nz);
  PetscCall(MatGetOptionsPrefix(K, &prefix));
  PetscOptionsBegin(comm, prefix, "Viscosity by the exact matrix square root", "Mat");
  PetscCall(PetscOptionsString("-mat_slipsqrtm_setup",
                               "Low-rank part by random sketches (sketch), none and Lanczos' method in each product "
                               "(lanczos), or that first and sketches once it has taken as long as their set-up "
                               "(auto, up to 10000 cells)",
                               "MatCreateSlipViscosity", setup, setup, sizeof(setup), NULL));
  PetscCall(PetscOptionsReal("-mat_slipsqrtm_tolerance",
                             "Error of a product over the norm of the viscosity (sketch, 1e-10) or over the product "
                             "(lanczos, 1e-8)",
                             "MatCreateSlipViscosity", tolerance, &tolerance, NULL));
  PetscOptionsEnd();
  PetscCall(PetscEListFind(3, choices, setup, &choice, &known));
  PetscCheck(known, comm, PETSC_ERR_ARG_UNKNOWN_TYPE,
             "-%smat_slipsqrtm_setup is \"%s\", expected auto, sketch or lanczos", prefix ? prefix : "", setup);
  PetscCall(MatGetVecType(K, &vectors));
  PetscCall(PetscStrcmp(vectors, VECSLIPOPENCL, &device)); /* it has no low-rank parts */
  sketch = (PetscBool)(choice == 1 || (choice == 0 && !device && factor > 0 && cells <= SLIP_SQRT_SKETCH_MAX));
  PetscCheck(!sketch || (tolerance >= 1e-12 && tolerance < 1), comm, PETSC_ERR_ARG_OUTOFRANGE,
             "-%smat_slipsqrtm_tolerance must lie in [1e-12, 1), not %g", prefix ? prefix : "", (double)tolerance);
  if (choice == 1) {
    PetscCall(SlipViscosityCreate_Sketch(K, factor, tolerance, H));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(SlipViscosityCreate_Lanczos(K, factor, H));
  set_up = cells * (PetscReal)g->nz * ((PetscReal)g->nz * SLIP_SQRT_EACH + SLIP_SQRT_ROW);
  if (sketch) PetscCall(SlipLanczosFactorise(*H, SlipViscosityCreate_Sketch, tolerance, set_up));
  PetscFunctionReturn(PETSC_SUCCESS);
}
