/* The file of -fault_pore_pressure. */
#pragma once
#include <slipstep/rooms/sliph5.h>
#include <slipcompat.h>

/* pressure: of rows times, by dims [rows, Nz, Nx] or [rows, N] */
static inline PetscErrorCode WriteRecord(const char file[], PetscInt rows, const PetscReal times[], PetscInt ndim,
                                         const PetscInt dims[], const PetscReal pressure[])
{
  SlipH5 h;

  PetscCall(SlipH5Create(file, &h));
  PetscCall(SlipH5WriteReal(&h, "/time", 1, &rows, times, "s"));
  PetscCall(SlipH5WriteReal(&h, "/pressure", ndim, dims, pressure, "Pa"));
  return SlipH5Close(&h);
}
