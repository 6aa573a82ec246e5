/* Predicts what the stiffness of a mesh takes, before anything is assembled: for -fault_plan on several numbers of
   processes, and for -fault_view on those of the run. */
#include <slipstep/private/sliprun.h>
#include <slipstep/private/slipfaultoperators.h>

/* Time of a product over the memory of K [s/B], which is read at some 7 GB/s: measured with 52 to 1,160 MB, 0.9 to 1.1
   of the times on one and two processes; matrices that fit into a cache take down to half of it */
#define BYTE_TIME 1.35e-10

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

static PetscReal Bytes(const SlipCellsForecast *f)
{
  return f->bytes + (PetscReal)sizeof(PetscReal) * f->touched;
}

static PetscReal Exchanged(const SlipCellsForecast *f)
{
  return (PetscReal)sizeof(PetscReal) * f->foreign;
}

static PetscReal Flops(const SlipCellsForecast *f)
{
  return f->flops;
}

static PetscReal Seconds(const SlipCellsForecast *f)
{
  return f->seconds;
}

static PetscReal Product(const SlipCellsForecast *f)
{
  return BYTE_TIME * Bytes(f);
}

/* Predicts for `size` processes the matrices one by one, f [*matrices][size] (PetscFree()), or their sums, f [size]. */
static PetscErrorCode Forecast(SlipFault fault, PetscMPIInt size, PetscBool sums, PetscInt *matrices,
                               SlipCellsForecast **f)
{
  PetscFunctionBegin;
  *matrices = fault->kind.coupled ? 2 : 1;
  PetscCall(PetscMalloc1(*matrices * size, f));
  PetscCall(SlipFaultMeshForecast(fault, size, *f));
  for (PetscMPIInt r = 0; r < size && sums && *matrices > 1; r++) {
    SlipCellsForecast *all = *f + r, *more = *f + size + r;

    all->blocks += more->blocks;
    all->bytes += more->bytes;
    all->flops += more->flops;
    all->touched += more->touched;
    all->foreign += more->foreign;
    all->seconds += more->seconds;
    all->machine = PetscMax(all->machine, more->machine); /* one after the other */
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prints the row of a number of processes. */
static PetscErrorCode Row(SlipFault fault, PetscMPIInt size, PetscViewer viewer)
{
  SlipCellsForecast *f;
  PetscReal mean[5], most[5], machine;
  PetscInt matrices;

  PetscFunctionBegin;
  PetscCall(Forecast(fault, size, PETSC_TRUE, &matrices, &f));
  most[0] = Largest(size, f, Bytes, &mean[0]);
  most[1] = Largest(size, f, Exchanged, &mean[1]);
  most[2] = Largest(size, f, Flops, &mean[2]);
  most[3] = Largest(size, f, Seconds, &mean[3]);
  most[4] = Largest(size, f, Product, &mean[4]);
  machine = f[0].machine + SlipSharedMachineBytes(fault->mesh.shared);
  PetscCall(PetscFree(f));
  PetscCall(PetscViewerASCIIPrintf(
    viewer, "%6d %9.1f %9.1f %9.1f %9.1f %9.1f %9.2f %9.1f %9.3f\n", (int)size, (double)(1e-6 * mean[0]),
    (double)(1e-6 * most[0]), (double)(1e-6 * machine), (double)(1e-3 * mean[1]), (double)(1e-3 * most[1]),
    (double)(mean[2] > 0 ? most[2] / mean[2] : 1), (double)most[3], (double)(1e3 * most[4])));
  PetscFunctionReturn(PETSC_SUCCESS);
}

#define PROCESSES_MOST 64 /* of the table for -fault_view, which has a row for each */

/* Prints for -fault_view what each process will store, exchange and compute of each matrix of a mesh, before it is
   assembled. Collective. */
PetscErrorCode SlipFaultForecastView(SlipFault fault)
{
  PetscViewer viewer = fault->options.viewer;
  SlipCellsForecast *f;
  PetscMPIInt size;
  PetscInt matrices;

  PetscFunctionBegin;
  if (!viewer || fault->mesh.kind == &SlipFaultMeshGrid || fault->options.text[FAULT_STIFFNESS_FILE][0])
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCallMPI(MPI_Comm_size(fault->comm, &size));
  PetscCall(Forecast(fault, size, PETSC_FALSE, &matrices, &f));
  PetscCall(PetscViewerASCIIPrintf(
    viewer, "before assembly, expected (and %.1f MB of the mesh on a machine):\n%6s %6s %9s %9s %11s %13s %13s %13s\n",
    (double)(1e-6 * (f[0].machine + SlipSharedMachineBytes(fault->mesh.shared))), "matrix", "rank", "cells", "blocks",
    "memory [MB]", "exchange [kB]", "assembly [s]", "product [ms]"));
  for (PetscInt k = 0; k < matrices; k++)
    for (PetscMPIInt r = 0; r < PetscMin(size, PROCESSES_MOST); r++) {
      const SlipCellsForecast *own = f + (size_t)k * size + r;

      PetscCall(PetscViewerASCIIPrintf(viewer, "%6s %6d %9.0f %9.0f %11.2f %13.1f %13.3f %13.3f\n", k ? "Kn" : "K",
                                       (int)r, (double)own->cells, (double)own->blocks, (double)(1e-6 * Bytes(own)),
                                       (double)(1e-3 * Exchanged(own)), (double)own->seconds,
                                       (double)(1e3 * Product(own))));
    }
  if (size > PROCESSES_MOST)
    PetscCall(PetscViewerASCIIPrintf(viewer, "  and %d more processes\n", (int)size - PROCESSES_MOST));
  PetscCall(PetscFree(f));
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
