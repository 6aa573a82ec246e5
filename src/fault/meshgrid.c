/* A mesh of the kind "grid": nx times nz equal cells of one vertical plane; row iz nx + ix. */
#include <slipstep/private/slipfault.h>
#include <slipstep/private/slipmatcells.h>

static PetscErrorCode Create_Grid(SlipFault fault)
{
  SlipFaultMesh *mesh = &fault->mesh;
  const PetscReal *const e = mesh->extent;
  const char *prefix = SlipFaultPrefix(fault);

  PetscFunctionBegin;
  PetscCall(PetscArraycpy(mesh->extent, fault->options.value, FAULT_DEPTH_TOP + 1));
  PetscCheck((PetscReal)fault->layout.block * e[FAULT_NX] * e[FAULT_NZ] < (PetscReal)PETSC_MAX_INT, fault->comm,
             PETSC_ERR_ARG_OUTOFRANGE, "-%sfault_nx %g times -%sfault_nz %g is more than this build's integers hold",
             prefix, (double)e[FAULT_NX], prefix, (double)e[FAULT_NZ]);
  mesh->ndim = 2;
  mesh->dims[0] = (PetscInt)e[FAULT_NZ];
  mesh->dims[1] = (PetscInt)e[FAULT_NX];
  mesh->N = mesh->dims[0] * mesh->dims[1];
  mesh->n = PETSC_DECIDE;
  mesh->npoints = (mesh->dims[0] + 1) * (mesh->dims[1] + 1);
  mesh->planes = 1;
  mesh->area = e[FAULT_LENGTH_X] * e[FAULT_LENGTH_Z] / (PetscReal)mesh->N;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void Cell_Grid(const SlipFaultMesh *mesh, PetscInt row, SlipFaultCell *cell)
{
  const PetscInt nz = mesh->dims[0], nx = mesh->dims[1];
  const PetscReal *const e = mesh->extent;

  *cell = (SlipFaultCell){
    {((row % nx) + 0.5) * e[FAULT_LENGTH_X] / nx, 0, e[FAULT_DEPTH_TOP] + ((row / nx) + 0.5) * e[FAULT_LENGTH_Z] / nz},
    {e[FAULT_LENGTH_X] / nx, e[FAULT_LENGTH_Z] / nz},
    {{1, 0, 0}, {0, 0, 1}, {0, 1, 0}},
    0};
}

/* Of cells in hierarchical storage, else of the grid */
static PetscErrorCode Stiffness_Grid(SlipFault fault, Mat *K)
{
  const SlipFaultMesh *mesh = &fault->mesh;
  const char *type = fault->options.text[FAULT_OPERATOR];
  SlipGrid grid = {.nx = mesh->dims[1],
                   .nz = mesh->dims[0],
                   .length_x = mesh->extent[FAULT_LENGTH_X],
                   .length_z = mesh->extent[FAULT_LENGTH_Z],
                   .depth_top = mesh->extent[FAULT_DEPTH_TOP]};
  PetscBool hmat;

  PetscFunctionBegin;
  PetscCall(PetscStrcmp(type, "hmat", &hmat));
  if (hmat) {
    PetscReal *column[5];
    SlipCells cells;

    PetscCall(SlipFaultCellsCreate(fault, mesh->N, &cells, column));
    for (PetscInt e = 0; e < mesh->N; e++) {
      SlipFaultCell cell;

      Cell_Grid(mesh, e, &cell);
      for (PetscInt k = 0; k < 5; k++) column[k][e] = k < 3 ? cell.centre[k] : cell.size[k - 3];
    }
    PetscCall(MatCreateSlipCellStiffness(fault->comm, &cells, type, fault->options.value[FAULT_HMAT_TOLERANCE], K));
    PetscCall(SlipCellsDestroy(&cells));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(SlipFaultKernel(fault, &grid.kernel));
  PetscCall(MatCreateSlipStiffness(fault->comm, &grid, type, K));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The two axes */
static PetscErrorCode Write_Grid(const SlipFaultMesh *mesh, SlipH5 *h)
{
  const PetscInt nz = mesh->dims[0], nx = mesh->dims[1];
  PetscReal *x, *z;
  SlipFaultCell cell;

  PetscFunctionBegin;
  PetscCall(PetscMalloc2(nx, &x, nz, &z));
  for (PetscInt i = 0; i < nx; i++) {
    Cell_Grid(mesh, i, &cell);
    x[i] = cell.centre[0];
  }
  for (PetscInt i = 0; i < nz; i++) {
    Cell_Grid(mesh, i * nx, &cell);
    z[i] = cell.centre[2];
  }
  PetscCall(SlipH5WriteReal(h, "/mesh/x", 1, &nx, x, "m"));
  PetscCall(SlipH5WriteReal(h, "/mesh/z", 1, &nz, z, "m"));
  PetscCall(SlipH5WriteAttrInt(h, "/mesh", "nx", nx));
  PetscCall(SlipH5WriteAttrInt(h, "/mesh", "nz", nz));
  PetscCall(PetscFree2(x, z));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Cells share corners, so that fields can be drawn smoothly. */
static PetscErrorCode Corners_Grid(const SlipFaultMesh *mesh, PetscReal points[], PetscInt corners[])
{
  const PetscInt nz = mesh->dims[0], nx = mesh->dims[1];
  const PetscReal *const e = mesh->extent;
  PetscReal *p = points;

  PetscFunctionBegin;
  for (PetscInt j = 0; j <= nz; j++)
    for (PetscInt i = 0; i <= nx; i++) {
      *p++ = i * e[FAULT_LENGTH_X] / nx;
      *p++ = 0;
      *p++ = e[FAULT_DEPTH_TOP] + j * e[FAULT_LENGTH_Z] / nz;
    }
  for (PetscInt row = 0; row < mesh->N; row++) {
    const PetscInt first = row / nx * (nx + 1) + row % nx;

    corners[4 * row] = first;
    corners[4 * row + 1] = first + 1;
    corners[4 * row + 2] = first + nx + 2;
    corners[4 * row + 3] = first + nx + 1;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The parameters say it all. */
static PetscErrorCode Digest_Grid(const SlipFaultMesh *mesh, char text[], size_t len)
{
  PetscFunctionBegin;
  (void)mesh;
  PetscCall(PetscStrncpy(text, "no mesh", len));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const SlipFaultMeshKind SlipFaultMeshGrid = {Create_Grid, Cell_Grid,    Stiffness_Grid,
                                             Write_Grid,  Corners_Grid, Digest_Grid};
