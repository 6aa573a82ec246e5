/* Writes a file with the cells of a fault, for programs that compute fields for them. */
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
  SlipFaultWriteCells - writes positions, areas and directions of the cells of a fault to a file

  Collective; calls SlipFaultSetUpMesh()

  Input Parameters:
+ fault - the fault
- file  - HDF5 file; /x, /y, /z [m], /area [m^2], /strike, /dip [degrees] and /fault as in SlipFaultGetGeometry(), each
          in the shape of fields of -fault_parameters: [Nz][Nx] for a grid, [N] for a mesh. An existing file is
          replaced.

  Options Database Key:
. -fault_cells FILE - writes it in the program fault, which then ends

  Level: intermediate

  Errors: those of SlipFaultSetUpMesh(), and of a file that cannot be written

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
