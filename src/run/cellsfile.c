/* A file with the cells of a fault, for programs that compute fields of them. */
#include <slipstep/private/sliprun.h>

static PetscErrorCode Write(SlipFault fault, const char file[])
{
  const SlipFaultMesh *mesh = &fault->mesh;
  const SlipH5Kind kind = {.prefix = SlipFaultPrefix(fault), .option = "fault_cells", .overwrite = PETSC_TRUE};
  PetscReal *values;
  SlipH5 h;

  PetscFunctionBegin;
  PetscCall(SlipH5CreateKind(&kind, file, &h));
  PetscCall(PetscMalloc1(mesh->N, &values));
  for (const SlipFaultGeometryName *g = SlipFaultGeometryNames; g->name; g++) {
    char path[64];

    PetscCall(PetscSNPrintf(path, sizeof(path), "/%s", g->name));
    PetscCall(SlipFaultGetGeometry(fault, g->name, mesh->N, values));
    PetscCall(SlipH5WriteReal(&h, path, mesh->ndim, mesh->dims, values, g->unit));
  }
  PetscCall(PetscFree(values));
  PetscCall(SlipH5Close(&h));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipFaultWriteCells - write where the cells of a fault are and which way they face

  Collective; calls SlipFaultSetUpMesh()

  Input Parameters:
+ fault - the fault
- file  - HDF5; /x, /y, /z [m], /area [m^2], /strike, /dip [degrees] and /fault as SlipFaultGetGeometry() has them, each
          in the shape that fields of -fault_parameters have: [Nz][Nx] of a grid, [N] of a mesh. One that is there is
          replaced.

  Options Database Key:
. -fault_cells FILE - of the program fault: write it, and end

  Level: intermediate

  Errors: those of SlipFaultSetUpMesh(), and a file that cannot be written

.seealso: SlipFaultGetGeometry(), SlipFaultSetField()
@*/
PetscErrorCode SlipFaultWriteCells(SlipFault fault, const char file[])
{
  PetscErrorCode ierr = PETSC_SUCCESS;
  PetscMPIInt rank;

  PetscFunctionBegin;
  PetscCall(SlipFaultSetUpMesh(fault));
  PetscCallMPI(MPI_Comm_rank(fault->comm, &rank));
  if (!rank) ierr = Write(fault, file);
  PetscCall(SlipErrorBcast(fault->comm, ierr));
  PetscFunctionReturn(PETSC_SUCCESS);
}
