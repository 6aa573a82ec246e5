/* Predicts for -fault_plan what a mesh takes on several numbers of processes, before anything is assembled. */
#include <slipstep/private/sliprun.h>
#include <slipstep/private/slipfaultoperators.h>

/* Returns the largest and the mean of a number of all processes. */
static PetscReal Largest(PetscMPIInt size, const SlipCellsForecast f[], PetscReal (*number)(const SlipCellsForecast *),
                         PetscReal *mean)
{
  PetscReal most = 0;

  *mean = 0;
  for (PetscMPIInt r = 0; r < size; r++) {
    most = PetscMax(most, (*number)(&f[r]));
    *mean += (*number)(&f[r]) / (PetscReal)size;
  }
  return most;
}

static PetscReal Flops(const SlipCellsForecast *f)
{
  return f->flops;
}

static PetscReal Seconds(const SlipCellsForecast *f)
{
  return f->seconds;
}

/* Prints the row of a number of processes. */
static PetscErrorCode Row(SlipFault fault, PetscMPIInt size, PetscViewer viewer)
{
  SlipCellsForecast *f;
  PetscReal mean[5], most[5], machine;
  PetscInt matrices;

  PetscFunctionBegin;
  PetscCall(SlipFaultForecast(fault, size, PETSC_TRUE, &matrices, &f));
  most[0] = Largest(size, f, SlipForecastBytes, &mean[0]);
  most[1] = Largest(size, f, SlipForecastExchanged, &mean[1]);
  most[2] = Largest(size, f, Flops, &mean[2]);
  most[3] = Largest(size, f, Seconds, &mean[3]);
  most[4] = Largest(size, f, SlipForecastProduct, &mean[4]);
  machine = f[0].machine + SlipSharedMachineBytes(fault->mesh.shared);
  PetscCall(PetscFree(f));
  PetscCall(PetscViewerASCIIPrintf(
    viewer, "%6d %9.1f %9.1f %9.1f %9.1f %9.1f %9.2f %9.1f %9.3f\n", (int)size, (double)(1e-6 * mean[0]),
    (double)(1e-6 * most[0]), (double)(1e-6 * machine), (double)(1e-3 * mean[1]), (double)(1e-3 * most[1]),
    (double)(mean[2] > 0 ? most[2] / mean[2] : 1), (double)most[3], (double)(1e3 * most[4])));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipFaultPlan - prints what the stiffness of a mesh will take on several numbers of processes: memory, exchange,
  balance of the work, and processor time of assembly and of a product, without assembling it

  Collective

  Input Parameters:
+ fault  - the fault, after SlipFaultSetFromOptions(); its cells and fields are set up
. n      - how many numbers of processes
. size   - [n] the numbers of processes, each at least 1
- viewer - an ASCII viewer, NULL for standard output

  Level: intermediate

  Notes:
  Memory is that of K and Kn, on all processes the mean and the largest, and of the mesh on each machine, with what its
  processes hold together while they assemble [MB]. Exchanged are the bytes that a process receives before a product,
  and sends after it [kB]. Work is the largest over the mean. Times are processor times of the busiest process: of
  assembly by entries that are timed on this processor, of products by the memory that they read, without the network.

  Errors: PETSC_ERR_SUP for grids, whose stiffness is a transform; PETSC_ERR_ARG_OUTOFRANGE for more processes than
  cells

.seealso: SlipFaultView(), SlipFaultSetUp()
@*/
PetscErrorCode SlipFaultPlan(SlipFault fault, PetscInt n, const PetscInt size[], PetscViewer viewer)
{
  PetscReal tolerance;
  char why[128];

  PetscFunctionBegin;
  PetscValidHeaderSpecific(fault, SLIP_FAULT_CLASSID, 1);
  if (!viewer) PetscCall(PetscViewerASCIIGetStdout(fault->comm, &viewer));
  PetscValidHeaderSpecific(viewer, PETSC_VIEWER_CLASSID, 4);
  PetscCall(SlipFaultSetUpMesh(fault));
  PetscCheck(fault->mesh.kind != &SlipFaultMeshGrid, fault->comm, PETSC_ERR_SUP,
             "-%sfault_plan is of meshes: expected -%sfault_mesh. The stiffness of a grid is a transform, whose memory "
             "-%sfault_view prints",
             SlipFaultPrefix(fault), SlipFaultPrefix(fault), SlipFaultPrefix(fault));
  PetscCall(SlipFaultCellsSetUp(fault));
  for (PetscInt i = 0; i < n; i++)
    PetscCheck(size[i] >= 1 && size[i] <= fault->mesh.N, fault->comm, PETSC_ERR_ARG_OUTOFRANGE,
               "-%sfault_plan %" PetscInt_FMT
               ": expected numbers of processes from 1 to that of the cells, %" PetscInt_FMT,
               SlipFaultPrefix(fault), size[i], fault->mesh.N);
  PetscCall(SlipFaultHmatTolerance(fault, &tolerance, why, sizeof(why)));
  PetscCall(PetscViewerASCIIPrintf(viewer,
                                   "plan of %" PetscInt_FMT " cells, relative tolerance %g (%s)%s: processor time, "
                                   "without the network\n",
                                   fault->mesh.N, (double)tolerance, why, fault->kind.coupled ? ", K and Kn" : ""));
  PetscCall(PetscViewerASCIIPrintf(viewer, "%6s %9s %9s %9s %9s %9s %9s %9s %9s\n", "", "stiffness", "", "mesh",
                                   "exchange", "", "work", "assembly", "product"));
  PetscCall(PetscViewerASCIIPrintf(viewer, "%6s %9s %9s %9s %9s %9s %9s %9s %9s\n", "ranks", "mean [MB]", "most",
                                   "machine", "mean [kB]", "most", "most/mean", "[s]", "[ms]"));
  for (PetscInt i = 0; i < n; i++) PetscCall(Row(fault, (PetscMPIInt)size[i], viewer));
  PetscFunctionReturn(PETSC_SUCCESS);
}
