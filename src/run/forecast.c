/* What the stiffness of a mesh takes, before it is assembled: each process' share of each matrix, for -fault_view. */
#include <slipstep/private/sliprun.h>
#include <slipstep/private/slipfaultoperators.h>

/* Time of a product over the memory of K [s/B], which is read at some 7 GB/s: measured with 52 to 1,160 MB, 0.9 to 1.1
   of the times on one and two processes; matrices that fit into a cache take down to half of it */
#define BYTE_TIME 1.35e-10

PetscReal SlipForecastBytes(const SlipCellsForecast *f)
{
  return f->bytes + (PetscReal)sizeof(PetscReal) * f->touched;
}

PetscReal SlipForecastExchanged(const SlipCellsForecast *f)
{
  return (PetscReal)sizeof(PetscReal) * f->foreign;
}

PetscReal SlipForecastProduct(const SlipCellsForecast *f)
{
  return BYTE_TIME * SlipForecastBytes(f);
}

/* Predicts for `size` processes the matrices one by one, f [*matrices][size] (PetscFree()), or their sums, f [size]. */
PetscErrorCode SlipFaultForecast(SlipFault fault, PetscMPIInt size, PetscBool sums, PetscInt *matrices,
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
  PetscCall(SlipFaultForecast(fault, size, PETSC_FALSE, &matrices, &f));
  PetscCall(PetscViewerASCIIPrintf(
    viewer, "before assembly, expected (and %.1f MB of the mesh on a machine):\n%6s %6s %9s %9s %11s %13s %13s %13s\n",
    (double)(1e-6 * (f[0].machine + SlipSharedMachineBytes(fault->mesh.shared))), "matrix", "rank", "cells", "blocks",
    "memory [MB]", "exchange [kB]", "assembly [s]", "product [ms]"));
  for (PetscInt k = 0; k < matrices; k++)
    for (PetscMPIInt r = 0; r < PetscMin(size, PROCESSES_MOST); r++) {
      const SlipCellsForecast *own = f + (size_t)k * size + r;

      PetscCall(PetscViewerASCIIPrintf(
        viewer, "%6s %6d %9.0f %9.0f %11.2f %13.1f %13.3f %13.3f\n", k ? "Kn" : "K", (int)r, (double)own->cells,
        (double)own->blocks, (double)(1e-6 * SlipForecastBytes(own)), (double)(1e-3 * SlipForecastExchanged(own)),
        (double)own->seconds, (double)(1e3 * SlipForecastProduct(own))));
    }
  if (size > PROCESSES_MOST)
    PetscCall(PetscViewerASCIIPrintf(viewer, "  and %d more processes\n", (int)size - PROCESSES_MOST));
  PetscCall(PetscFree(f));
  PetscFunctionReturn(PETSC_SUCCESS);
}
