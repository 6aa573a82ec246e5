/* A mesh of the kind "grid": nx times nz equal cells of one plane, in rows iz nx + ix. Its upper edge begins at
   x = y = 0. */
#include <slipstep/private/slipmesh.h>
#include <slipstep/private/slipelasticity.h>
#include <slipstep/private/slipmatcells.h>

static PetscErrorCode Create_Grid(SlipFaultMesh *mesh, const SlipFaultMeshOptions *o, SlipFaultMeshFile *file)
{
  const PetscReal *const e = mesh->extent;
  const char *prefix = o->prefix;
  PetscReal sine, cosine, bottom, side;

  PetscFunctionBegin;
  (void)file;
  PetscCall(PetscArraycpy(mesh->extent, o->extent, MESH_REALS));
  PetscCheck((PetscReal)o->block * e[MESH_NX] * e[MESH_NZ] < (PetscReal)PETSC_MAX_INT, o->comm,
             PETSC_ERR_ARG_OUTOFRANGE, "-%sfault_nx %g times -%sfault_nz %g is more than this build's integers hold",
             prefix, (double)e[MESH_NX], prefix, (double)e[MESH_NZ]);
  mesh->ndim = 2;
  mesh->dims[0] = (PetscInt)e[MESH_NZ];
  mesh->dims[1] = (PetscInt)e[MESH_NX];
  mesh->N = mesh->dims[0] * mesh->dims[1];
  mesh->n = PETSC_DECIDE;
  mesh->npoints = (mesh->dims[0] + 1) * (mesh->dims[1] + 1);
  mesh->planes = 1;
  mesh->dips = e[MESH_DIP] != 90 ? PETSC_TRUE : PETSC_FALSE;
  mesh->area = e[MESH_LENGTH_X] * e[MESH_LENGTH_Z] / (PetscReal)mesh->N;
  SlipDegrees(e[MESH_DIP], &sine, &cosine);
  bottom = e[MESH_DEPTH_TOP] + sine * e[MESH_LENGTH_Z] / mesh->dims[0];
  side = PetscMin(e[MESH_LENGTH_X] / mesh->dims[1], e[MESH_LENGTH_Z] / mesh->dims[0]);
  PetscCheck(o->rectangles.full_space || bottom >= SLIP_GROUND * side, o->comm, PETSC_ERR_ARG_OUTOFRANGE,
             "the upper cells lie on the ground, with their lower edges %.6g m deep: expected a larger -%sfault_dip, "
             "which is %.6g, or -%sfault_depth_top",
             (double)bottom, prefix, (double)e[MESH_DIP], prefix);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes a point that is `along` cells along strike and `down` cells along dip from the corner. */
static void Point(const SlipFaultMesh *mesh, PetscReal along, PetscReal down, PetscReal at[3])
{
  const PetscReal *const e = mesh->extent;
  const PetscReal s = along * e[MESH_LENGTH_X] / mesh->dims[1], d = down * e[MESH_LENGTH_Z] / mesh->dims[0];
  PetscReal strike[2], dip[2];

  SlipDegrees(e[MESH_STRIKE], &strike[1], &strike[0]);
  SlipDegrees(e[MESH_DIP], &dip[1], &dip[0]);
  at[0] = strike[0] * s - strike[1] * (dip[0] * d);
  at[1] = strike[1] * s + strike[0] * (dip[0] * d);
  at[2] = e[MESH_DEPTH_TOP] + dip[1] * d;
}

static void Cell_Grid(const SlipFaultMesh *mesh, PetscInt row, SlipFaultCell *cell)
{
  const PetscInt nz = mesh->dims[0], nx = mesh->dims[1];
  const PetscReal *const e = mesh->extent;

  *cell = (SlipFaultCell){.size = {e[MESH_LENGTH_X] / nx, e[MESH_LENGTH_Z] / nz}};
  Point(mesh, (PetscReal)(row % nx) + 0.5, (PetscReal)(row / nx) + 0.5, cell->centre);
  SlipFaultCellDirections(e[MESH_STRIKE], e[MESH_DIP], cell);
}

/* Creates the stiffness: from cells for hierarchical storage, otherwise from the grid. */
static PetscErrorCode Stiffness_Grid(const SlipFaultMesh *mesh, const SlipFaultStiffness *s, Mat *K, Mat *Kn)
{
  SlipGrid grid = {.kernel = s->kernel,
                   .nx = mesh->dims[1],
                   .nz = mesh->dims[0],
                   .length_x = mesh->extent[MESH_LENGTH_X],
                   .length_z = mesh->extent[MESH_LENGTH_Z],
                   .depth_top = mesh->extent[MESH_DEPTH_TOP]};
  SlipDippingGrid dipping = {.grid = grid, .dip = mesh->extent[MESH_DIP], .tolerance = s->tolerance};
  PetscBool hmat;
  PetscReal *rake;

  PetscFunctionBegin;
  if (s->dipping) {
    PetscCall(PetscMalloc1(mesh->N, &rake));
    PetscCall(SlipFaultGatherAll(mesh, s->rake, rake));
    dipping.rake = rake;
    if (s->kernel.type->components > 1)
      PetscCall(MatCreateSlipDippingVectorStiffness(mesh->comm, &dipping, s->type, K, Kn));
    else
      PetscCall(MatCreateSlipDippingStiffness(mesh->comm, &dipping, s->type, K, Kn));
    PetscCall(PetscFree(rake));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(PetscStrcmp(s->type, "hmat", &hmat));
  if (hmat) {
    PetscReal *column[5];
    SlipCells cells;

    PetscInt start, end;

    PetscCall(SlipFaultCellsCreate(mesh->shared, &s->kernel, mesh->N, 5, &cells, column));
    SlipSharedSlice(mesh->shared, column[0], mesh->N, &start, &end);
    for (PetscInt e = start; e < end; e++) { /* this kernel's x is along the strike */
      const PetscReal value[5] = {((PetscReal)(e % grid.nx) + 0.5) * grid.length_x / grid.nx, 0,
                                  grid.depth_top + ((PetscReal)(e / grid.nx) + 0.5) * grid.length_z / grid.nz,
                                  grid.length_x / grid.nx, grid.length_z / grid.nz};

      for (PetscInt k = 0; k < 5; k++) column[k][e] = value[k];
    }
    PetscCall(SlipSharedReady(mesh->shared));
    PetscCall(MatCreateSlipCellStiffness(mesh->comm, &cells, s->type, s->tolerance, K));
    PetscCall(SlipSharedFree(mesh->shared, &column[0]));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(MatCreateSlipStiffness(mesh->comm, &grid, s->type, K));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes the two axes: along the strike, and down the dip with the depths there. */
static PetscErrorCode Write_Grid(const SlipFaultMesh *mesh, SlipH5 *h)
{
  const PetscInt nz = mesh->dims[0], nx = mesh->dims[1];
  const PetscReal *const e = mesh->extent;
  PetscReal *x, *z, *down;
  SlipFaultCell cell;

  PetscFunctionBegin;
  PetscCall(PetscMalloc3(nx, &x, nz, &z, nz, &down));
  for (PetscInt i = 0; i < nx; i++) x[i] = ((PetscReal)i + 0.5) * e[MESH_LENGTH_X] / nx;
  for (PetscInt i = 0; i < nz; i++) {
    Cell_Grid(mesh, i * nx, &cell);
    z[i] = cell.centre[2];
    down[i] = ((PetscReal)i + 0.5) * e[MESH_LENGTH_Z] / nz;
  }
  PetscCall(SlipH5WriteReal(h, "/mesh/x", 1, &nx, x, "m"));
  PetscCall(SlipH5WriteReal(h, "/mesh/z", 1, &nz, z, "m"));
  if (mesh->dips) PetscCall(SlipH5WriteReal(h, "/mesh/down_dip", 1, &nz, down, "m"));
  PetscCall(SlipH5WriteAttrInt(h, "/mesh", "nx", nx));
  PetscCall(SlipH5WriteAttrInt(h, "/mesh", "nz", nz));
  PetscCall(SlipH5WriteAttrReal(h, "/mesh", "strike", e[MESH_STRIKE]));
  PetscCall(SlipH5WriteAttrReal(h, "/mesh", "dip", e[MESH_DIP]));
  PetscCall(PetscFree3(x, z, down));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lists corners, which cells share, so that fields can be drawn smoothly. */
static PetscErrorCode Corners_Grid(const SlipFaultMesh *mesh, PetscReal points[], PetscInt corners[])
{
  const PetscInt nz = mesh->dims[0], nx = mesh->dims[1];
  PetscReal *p = points;

  PetscFunctionBegin;
  for (PetscInt j = 0; j <= nz; j++)
    for (PetscInt i = 0; i <= nx; i++) {
      Point(mesh, (PetscReal)i, (PetscReal)j, p);
      p += 3;
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

/* Returns no digest, because the parameters determine the mesh. */
static PetscErrorCode Digest_Grid(const SlipFaultMesh *mesh, char text[], size_t len)
{
  PetscFunctionBegin;
  (void)mesh;
  PetscCall(PetscStrncpy(text, "no mesh", len));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const SlipFaultMeshKind SlipFaultMeshGrid = {Create_Grid, Cell_Grid, Stiffness_Grid, Write_Grid, Corners_Grid,
                                             Digest_Grid, 4};
