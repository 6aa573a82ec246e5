/* The fault as a problem to evaluate: square faults of any size and mesh. The other -fault_ options apply to all of
   them. */
#include "problems.h"
#include <slipcompat.h>

#define RTOL 1e-3          /* the study's, whose multiples are its tolerances */
#define DURATION_PER_KM 10 /* [s]: 30 s for the 3 km fault, 50 s for the 5 km one */

static const char *const columns[] = {"mean_slip", "mean_slip_rate", "max_slip_rate"};
static const char *const units[] = {"m", "m/s", "m/s"};

static PetscErrorCode Create(MPI_Comm comm, const ProblemCase *c, void **model)
{
  SlipFault fault;

  PetscFunctionBegin;
  PetscCall(SlipFaultCreate(comm, &fault));
  *model = fault;
  PetscCall(SlipFaultSetReal(fault, "length_x", 1e3 * c->size));
  PetscCall(SlipFaultSetReal(fault, "length_z", 1e3 * c->size));
  PetscCall(SlipFaultSetReal(fault, "nx", (PetscReal)c->mesh));
  PetscCall(SlipFaultSetReal(fault, "nz", (PetscReal)c->mesh));
  PetscCall(SlipFaultSetString(fault, "stiffness_scaling", FAULT_SCALING));
  PetscCall(SlipFaultSetFromOptions(fault));
  PetscCall(SlipFaultSetUp(fault));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Destroy(void **model)
{
  PetscFunctionBegin;
  PetscCall(SlipFaultDestroy((SlipFault *)model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Start(MPI_Comm comm, const ProblemCase *c, void *model, TS *ts, Vec *w)
{
  SlipFault fault = (SlipFault)model;

  PetscFunctionBegin;
  PetscCall(TSCreate(comm, ts));
  PetscCall(SlipFaultConfigureTS(fault, *ts));
  PetscCall(TSSetTolerances(*ts, PETSC_DEFAULT, NULL, (PetscReal)RTOL, NULL));
  PetscCall(TSSetMaxTime(*ts, DURATION_PER_KM * c->size));
  PetscCall(SlipFaultCreateState(fault, w));
  PetscCall(SlipFaultSetInitialState(fault, *w));
  PetscCall(TSSetSolution(*ts, *w));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The cells have equal areas, so plain means are those of the fault. */
static PetscErrorCode Observe(const ProblemCase *c, void *model, PetscReal t, Vec w, Vec r, PetscReal row[])
{
  const PetscScalar *a;
  PetscReal sums[2] = {0, 0}, largest = 0;
  PetscInt n;
  MPI_Comm comm;

  PetscFunctionBegin;
  (void)model, (void)t, (void)r;
  PetscCall(VecGetLocalSize(w, &n));
  PetscCall(VecGetArrayRead(w, &a));
  for (PetscInt i = 0; i < n / 3; i++) {
    sums[0] += a[3 * i + 2];
    sums[1] += a[3 * i];
    largest = PetscMax(largest, PetscAbsReal(a[3 * i]));
  }
  PetscCall(VecRestoreArrayRead(w, &a));
  PetscCall(PetscObjectGetComm((PetscObject)w, &comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sums, 2, MPIU_REAL, MPIU_SUM, comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &largest, 1, MPIU_REAL, MPIU_MAX, comm));
  row[0] = sums[0] / (PetscReal)(c->mesh * c->mesh);
  row[1] = sums[1] / (PetscReal)(c->mesh * c->mesh);
  row[2] = largest;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Slip rate averaged along strike, by depth [mesh] */
static PetscErrorCode Profile(const ProblemCase *c, void *model, Vec w, PetscReal profile[])
{
  const PetscScalar *a;
  PetscInt first, last;
  MPI_Comm comm;

  PetscFunctionBegin;
  (void)model;
  PetscCall(PetscArrayzero(profile, c->mesh));
  PetscCall(VecGetOwnershipRange(w, &first, &last));
  PetscCall(VecGetArrayRead(w, &a));
  for (PetscInt i = 0; i < last - first; i += 3) profile[(first + i) / 3 / c->mesh] += a[i] / (PetscReal)c->mesh;
  PetscCall(VecRestoreArrayRead(w, &a));
  PetscCall(PetscObjectGetComm((PetscObject)w, &comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, profile, (PetscMPIInt)c->mesh, MPIU_REAL, MPIU_SUM, comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const Evaluation EvaluationFault = {.meshes = PETSC_TRUE,
                                    .nstates = 1,
                                    .ncolumns = 3,
                                    .columns = columns,
                                    .units = units,
                                    .rate = 1,
                                    .relative = PETSC_TRUE,
                                    .reference = 4000,
                                    .create = Create,
                                    .destroy = Destroy,
                                    .start = Start,
                                    .observe = Observe,
                                    .profiles = Profile};
