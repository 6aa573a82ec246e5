/* Whole runs with exact and with approximate Jacobians end alike, on all ranks as on one, whatever solves the linear
   systems. */
#include "ranks.h"
#include "faultstart.h"
#include <math.h>

/* The final mean slip [m] of 10 constant steps through the rupture; options are set for this run alone. */
static PetscErrorCode Run(MPI_Comm comm, const char operator[], const char *const options[], PetscInt *steps,
                          PetscReal *slip)
{
  SlipFault fault;
  SlipFaultObservables obs;
  TS ts;
  Vec w;

  for (int i = 0; options[i]; i += 2) PetscCall(PetscOptionsSetValue(NULL, options[i], options[i + 1]));
  PetscCall(SlipFaultCreate(comm, &fault));
  PetscCall(FaultSetStrings(fault, {"operator", operator}, {"stiffness_scaling", "mean_slip"}));
  PetscCall(FaultSetReals(fault, {"nx", 11}, {"nz", 9}));
  PetscCall(FaultStart(fault, TSADAPTNONE, 1.5, 15, &w, &ts));
  PetscCall(TSBatheSetStageError(ts, 0)); /* solves to rounding */
  PetscCall(TSSetFromOptions(ts));
  PetscCall(TSSolve(ts, w));
  PetscCall(TSGetStepNumber(ts, steps));
  PetscCall(SlipFaultGetObservables(fault, 15, w, NULL, &obs));
  *slip = obs.mean_slip;
  for (int i = 0; options[i]; i += 2) PetscCall(PetscOptionsClearValue(NULL, options[i]));
  return DestroyObjects(&fault, &w, &ts);
}

/* How a run is compared with the one of dense matrices on one rank, and to what. */
static const struct {
  const char *operator, * const options[9];
  PetscReal tolerance;
} Rows[] = {
  /* solves end at residuals of rounding, which the steps amplify: 1e-9, as between rank counts */
  {"dense", {NULL}, 1e-9},
  {"dense", {"-mat_slipstage_jacobian", "approximate", NULL}, 1e-9},
  /* the exact root of transforms is good to 1e-10 of its norm */
  {"fft", {"-mat_slipstage_jacobian", "exact", NULL}, 1e-8},
  {"fft", {"-mat_slipstage_jacobian", "approximate", "-mat_slipfft_depth", "transform", NULL}, 1e-8},
  {"fft", {"-mat_slipsqrtm_setup", "lanczos", NULL}, 1e-8},
  {"fft", {"-mat_slipsqrtm_setup", "lanczos", "-pc_type", "jacobi", NULL}, 1e-8},
  {"fft", {"-mat_slipsqrtm_setup", "lanczos", "-ksp_type", "minres", NULL}, 1e-8},
  {"fft", {"-mat_slipstage_jacobian", "exact", "-pc_type", "none", NULL}, 1e-8},
};

static PetscErrorCode Test(void)
{
  static const char *const none[] = {NULL};
  PetscReal reference, slip;
  PetscInt reference_steps, steps;

  PetscCall(Run(PETSC_COMM_SELF, "dense", none, &reference_steps, &reference));
  Check(reference > 0.1, "the fault hardly slipped");
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(Rows); k++) {
    PetscCall(Run(PETSC_COMM_WORLD, Rows[k].operator, Rows[k].options, &steps, &slip));
    PetscCall(PetscPrintf(PETSC_COMM_WORLD, "%s %s %s: %g\n", Rows[k].operator,
                          Rows[k].options[0] ? Rows[k].options[0] : "", Rows[k].options[0] ? Rows[k].options[1] : "",
                          fabs(slip / reference - 1)));
    Check(steps == reference_steps, "row %d: %d steps, not %d", (int)k, (int)steps, (int)reference_steps);
    Check(fabs(slip - reference) <= Rows[k].tolerance * reference, "row %d: final slip %.15g, not %.15g", (int)k,
          (double)slip, (double)reference);
  }
  return PETSC_SUCCESS;
}

SLIP_RANKS(Test)
