/* A fault on all ranks against the same fault on each rank alone: state, observables and output file agree. */
#include "ranks.h"
#include "faultstart.h"
#include <slipstep/rooms/sliph5.h>
#include <math.h>
#include <unistd.h>

#define NX 7
#define NZ 5

typedef struct {
  SlipFaultObservables obs;
  PetscReal energy;
  PetscReal norm; /* of the state */
} Outcome;

static PetscErrorCode SolveFault(MPI_Comm comm, TSBatheMethod method, const char output[], Outcome *out)
{
  const SlipProblemOps *problem;
  void *ctx;
  SlipFault fault;
  PetscInt row;
  TS ts;
  Vec w;

  PetscFunctionBegin;
  PetscCall(SlipFaultCreate(comm, &fault));
  PetscCall(FaultSetReals(fault, {"nx", NX}, {"nz", NZ}, {"loading_rate", 2e-3}, {"output_interval", 40}));
  PetscCall(SlipFaultSetString(fault, "output", output));
  PetscCall(FaultStart(fault, TSADAPTNONE, 0.1, 15, &w, &ts));
  PetscCall(TSBatheSetMethod(ts, method));
  PetscCall(SlipFaultOutputStart(fault, ts));
  PetscCall(TSSolve(ts, w));
  PetscCall(SlipFaultOutputFinish(fault, ts, 0, 0));
  PetscCall(SlipFaultGetObservables(fault, 15, w, NULL, &out->obs));
  PetscCall(TSGetSlipProblem(ts, &problem, &ctx));
  PetscCall(SlipFaultDestroy(&fault)); /* the TS keeps it */
  PetscCall((*problem->observations.find)(ts, "energy", &row, ctx));
  PetscCheck(row >= 0, PETSC_COMM_SELF, PETSC_ERR_PLIB, "the fault does not know its energy");
  PetscCall((*problem->observations.observe)(ts, 15, 1, &row, &out->energy, ctx));
  PetscCall(VecNorm(w, NORM_2, &out->norm));
  PetscCall(VecDestroy(&w));
  PetscCall(TSDestroy(&ts));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sums in another order differ by rounding, which the steps of a run amplify: 1e-9. */
static PetscErrorCode Same(const char what[], PetscReal a, PetscReal b)
{
  PetscFunctionBegin;
  PetscCheck(fabs(a - b) <= 1e-9 * fabs(b), PETSC_COMM_SELF, PETSC_ERR_PLIB,
             "%s is %.15g on all ranks and %.15g on one", what, (double)a, (double)b);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode CheckFile(const char file[], TSBatheMethod method, const Outcome *out)
{
  SlipH5 h;
  PetscInt dims[3], accepted, rejected;
  PetscReal *x, sum = 0, slip;

  PetscFunctionBegin;
  PetscCall(SlipH5OpenRead(file, &h));
  PetscCall(SlipH5ReadReal(&h, "/fields/slip", 3, dims, &x));
  /* the start, steps 40, 80, 120, and the last, 150 */
  PetscCheck(dims[0] == 5 && dims[1] == NZ && dims[2] == NX, PETSC_COMM_SELF, PETSC_ERR_PLIB, "shape of /fields/slip");
  for (PetscInt e = 0; e < NX * NZ; e++) sum += x[4 * NX * NZ + e];
  PetscCall(PetscFree(x));
  PetscCall(Same("mean of the last /fields/slip", sum / (NX * NZ), out->obs.mean_slip));
  PetscCall(SlipH5ReadReal(&h, "/series/mean_slip", 1, dims, &x));
  PetscCheck(dims[0] == 151, PETSC_COMM_SELF, PETSC_ERR_PLIB, "%" PetscInt_FMT " rows in /series", dims[0]);
  PetscCall(Same("last row of /series/mean_slip", x[150], out->obs.mean_slip));
  PetscCall(PetscFree(x));
  PetscCall(SlipH5ReadReal(&h, "/steps/method", 1, dims, &x));
  for (PetscInt i = 0; i < dims[0]; i++)
    PetscCheck(x[i] == (PetscReal)method, PETSC_COMM_SELF, PETSC_ERR_PLIB, "step %d is of method %g", (int)i,
               (double)x[i]);
  PetscCall(PetscFree(x));
  PetscCall(SlipH5ReadReal(&h, "/steps/time", 1, dims, &x));
  PetscCall(SlipH5ReadAttrInt(&h, "/result", "accepted", &accepted));
  PetscCall(SlipH5ReadAttrInt(&h, "/result", "rejected", &rejected));
  PetscCheck(dims[0] == accepted + rejected && accepted == 150, PETSC_COMM_SELF, PETSC_ERR_PLIB,
             "%" PetscInt_FMT " rows in /steps", dims[0]);
  PetscCall(PetscFree(x));
  PetscCall(SlipH5ReadReal(&h, "/mesh/normal_stress", 2, dims, &x));
  PetscCall(Same("normal stress of the last cell", x[NX * NZ - 1], 15e3 * 2700)); /* centre of the deepest row */
  PetscCall(PetscFree(x));
  PetscCall(SlipH5ReadAttrReal(&h, "/result", "mean_slip", &slip));
  PetscCall(Same("/result mean_slip", slip, out->obs.mean_slip));
  PetscCall(SlipH5Close(&h));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* method: of all steps */
static PetscErrorCode TestMethod(TSBatheMethod method)
{
  Outcome all, one;
  PetscMPIInt rank, size;
  char file[64], part[80];

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
  PetscCallMPI(MPI_Comm_size(PETSC_COMM_WORLD, &size));
  PetscCall(PetscSNPrintf(file, sizeof(file), "test_fault_ranks_%d.h5", (int)size));
  PetscCall(PetscSNPrintf(part, sizeof(part), "%s.part", file));
  PetscCall(SolveFault(PETSC_COMM_WORLD, method, file, &all));
  PetscCall(SolveFault(PETSC_COMM_SELF, method, "", &one));
  PetscCall(Same("norm of the state", all.norm, one.norm));
  PetscCall(Same("energy", all.energy, one.energy));
  PetscCall(Same("mean slip", all.obs.mean_slip, one.obs.mean_slip));
  PetscCall(Same("mean displacement", all.obs.mean_displacement, one.obs.mean_displacement));
  PetscCall(Same("mean slip rate", all.obs.mean_slip_rate, one.obs.mean_slip_rate));
  PetscCall(Same("largest slip rate", all.obs.max_slip_rate, one.obs.max_slip_rate));
  PetscCall(Same("sliding fraction", all.obs.sliding_fraction, one.obs.sliding_fraction));
  PetscCall(Same("elastic energy", all.obs.elastic, one.obs.elastic));
  PetscCall(Same("viscous power", all.obs.viscous_power, one.obs.viscous_power));
  PetscCall(Same("loading power", all.obs.loading_power, one.obs.loading_power));
  PetscCheck(all.obs.mean_slip > 0.1, PETSC_COMM_SELF, PETSC_ERR_PLIB, "the fault hardly slipped");
  if (!rank) {
    PetscCheck(access(part, F_OK), PETSC_COMM_SELF, PETSC_ERR_PLIB, "%s was left behind", part);
    PetscCall(CheckFile(file, method, &all));
    unlink(file);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Test(void)
{
  PetscFunctionBegin;
  PetscCall(TestMethod(TSBATHE_METHOD_IMPLICIT));
  PetscCall(TestMethod(TSBATHE_METHOD_EXPLICIT));
  PetscFunctionReturn(PETSC_SUCCESS);
}

SLIP_RANKS(Test)
