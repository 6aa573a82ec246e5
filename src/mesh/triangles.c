/* A mesh of the kind "triangles" from -fault_mesh, with corners around the normals into the hanging wall (orient.c).
   The size of a cell is its extent along strike and its area over that. */
#include <slipstep/private/slipmesh.h>
#include <slipstep/private/slipelasticity.h>
#include <slipstep/private/slipmatcells.h>

/* Rounding of an angle over the circle, the same as for strikes and dips in faults.c */
#define ANGLE_ROUNDING 1e-9

/* Describes one triangle [3][3] as a row of a list, with the strike and dip of its hanging wall. */
static PetscErrorCode Describe(const PetscReal v[9], PetscReal row[MESH_COLUMNS])
{
  PetscReal side[3], angles[2], directions[9], low = PETSC_MAX_REAL, top = PETSC_MIN_REAL, area = 0;

  PetscFunctionBegin;
  for (int k = 0; k < 3; k++) {
    const int x = (k + 1) % 3, y = (k + 2) % 3;

    row[k] = (v[k] + v[3 + k] + v[6 + k]) / 3;
    side[k] = (v[3 + x] - v[x]) * (v[6 + y] - v[y]) - (v[3 + y] - v[y]) * (v[6 + x] - v[x]);
    area += PetscSqr(side[k]);
  }
  area = 0.5 * PetscSqrtReal(area);
  PetscCall(SlipTriangleDirections(v, side, angles, directions));
  for (int k = 0; k < 3; k++) {
    const PetscReal *p = v + 3 * k;
    const PetscReal along = (p[0] - v[0]) * directions[0] + (p[1] - v[1]) * directions[1]; /* the strike is level */

    low = PetscMin(low, along);
    top = PetscMax(top, along);
  }
  row[3] = top - low;
  row[4] = area / (top - low);
  row[5] = 0 + angles[0]; /* and not -0 */
  row[6] = angles[1];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Fills mesh->cells; the columns and the vertices [n][3][3] are one array. */
static PetscErrorCode Fill(SlipFaultMesh *mesh)
{
  const PetscInt n = mesh->cells.n;
  PetscReal *data, *vertices, row[MESH_COLUMNS] = {0};
  PetscInt start, end;

  PetscFunctionBegin;
  PetscCall(SlipSharedMalloc1(mesh->shared, (MESH_COLUMNS + 9) * (size_t)n, &data));
  vertices = data + MESH_COLUMNS * (size_t)n;
  SlipSharedSlice(mesh->shared, data, n, &start, &end);
  for (PetscInt i = start; i < end; i++) {
    for (PetscInt k = 0; k < 9; k++)
      vertices[9 * (size_t)i + k] = mesh->vertex[3 * (size_t)mesh->corner[3 * i + k / 3] + k % 3];
    PetscCall(Describe(vertices + 9 * (size_t)i, row));
    for (PetscInt k = 0; k < MESH_COLUMNS; k++) data[(size_t)k * n + i] = row[k];
  }
  PetscCall(SlipSharedReady(mesh->shared));
  mesh->cells = (SlipCells){.n = n,
                            .x = data,
                            .y = data + n,
                            .z = data + 2 * (size_t)n,
                            .length = data + 3 * (size_t)n,
                            .width = data + 4 * (size_t)n,
                            .strike = data + 5 * (size_t)n,
                            .dip = data + 6 * (size_t)n,
                            .vertices = vertices};
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the extents of all vertices along the strike of the whole and down its dip. */
static void Extents(SlipFaultMesh *mesh)
{
  PetscReal strike, dip, low[3] = {PETSC_MAX_REAL, PETSC_MAX_REAL, PETSC_MAX_REAL};
  PetscReal top[2] = {PETSC_MIN_REAL, PETSC_MIN_REAL};
  SlipFaultCell whole;

  SlipFaultCellsDirection(&mesh->cells, &strike, &dip);
  SlipFaultCellDirections(strike, dip, &whole);
  for (PetscInt p = 0; p < mesh->npoints; p++) {
    const PetscReal *v = mesh->vertex + 3 * (size_t)p;

    for (int k = 0; k < 2; k++) {
      const PetscReal *d = whole.direction[k], along = v[0] * d[0] + v[1] * d[1] + v[2] * d[2];

      low[k] = PetscMin(low[k], along);
      top[k] = PetscMax(top[k], along);
    }
    low[2] = PetscMin(low[2], v[2]);
  }
  mesh->extent[MESH_NX] = (PetscReal)mesh->cells.n;
  mesh->extent[MESH_NZ] = 1;
  mesh->extent[MESH_LENGTH_X] = top[0] - low[0];
  mesh->extent[MESH_LENGTH_Z] = top[1] - low[1];
  mesh->extent[MESH_DEPTH_TOP] = PetscMax(low[2], 0);
  mesh->extent[MESH_STRIKE] = strike < 0 ? strike + 360 : 0 + strike;
  mesh->extent[MESH_DIP] = dip;
}

static PetscErrorCode Create_Triangles(SlipFaultMesh *mesh, const SlipFaultMeshOptions *o, SlipFaultMeshFile *file)
{
  const SlipCells *c = &mesh->cells;
  PetscInt sizes[2] = {file->n, file->nvertices};
  char source[PETSC_MAX_PATH_LEN + 64];
  PetscMPIInt rank;

  PetscFunctionBegin;
  /* broadcast what rank 0 has read */
  PetscCallMPI(MPI_Comm_rank(mesh->comm, &rank));
  PetscCallMPI(MPI_Bcast(sizes, 2, MPIU_INT, 0, mesh->comm));
  mesh->cells.n = sizes[0];
  mesh->npoints = sizes[1];
  PetscCall(SlipSharedMalloc1(mesh->shared, 3 * (size_t)mesh->npoints, &mesh->vertex));
  PetscCall(SlipSharedMalloc1(mesh->shared, 3 * (size_t)sizes[0], &mesh->corner));
  PetscCall(SlipSharedMalloc1(mesh->shared, sizes[0], &mesh->label));
  if (!rank) {
    PetscCall(PetscArraycpy(mesh->vertex, file->vertex, 3 * (size_t)sizes[1]));
    PetscCall(PetscArraycpy(mesh->corner, file->corner, 3 * (size_t)sizes[0]));
    PetscCall(PetscArraycpy(mesh->label, file->label, sizes[0]));
    PetscCall(PetscFree(file->vertex));
    PetscCall(PetscFree(file->corner));
    PetscCall(PetscFree(file->label));
    SlipMemoryReturn();
  }
  PetscCall(SlipSharedBcast(mesh->shared, mesh->vertex, 3 * sizes[1], MPIU_REAL));
  PetscCall(SlipSharedBcast(mesh->shared, mesh->corner, 3 * sizes[0], MPIU_INT));
  PetscCall(SlipSharedBcast(mesh->shared, mesh->label, sizes[0], MPIU_INT));
  mesh->labelled = PETSC_TRUE; /* labels are of the file or of its connected pieces */
  PetscCall(Fill(mesh));
  mesh->cells.kernel = o->triangles;
  PetscCall(PetscSNPrintf(source, sizeof(source), "%s (-%sfault_mesh)", o->file, o->prefix));
  mesh->cells.number = file->number;
  PetscCall(SlipCellsCheck(mesh->comm, &mesh->cells, source));
  mesh->cells.number = NULL;
  /* vertical and of one strike, or of both strikes of one plane */
  mesh->dips = PETSC_FALSE;
  for (PetscInt i = 0; i < c->n; i++) {
    const PetscReal turn = PetscAbsReal(c->strike[i] - c->strike[0]) / 180;

    if (PetscAbsReal(c->dip[i] - 90) > 360 * ANGLE_ROUNDING ||
        PetscAbsReal(turn - PetscFloorReal(turn + 0.5)) > 2 * ANGLE_ROUNDING)
      mesh->dips = PETSC_TRUE;
  }
  Extents(mesh);
  PetscCall(SlipFaultMeshPlanes(mesh));
  PetscCall(SlipFaultCellsShare(mesh, o->type));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void Cell_Triangles(const SlipFaultMesh *mesh, PetscInt row, SlipFaultCell *cell)
{
  const SlipCells *c = &mesh->cells;

  *cell = (SlipFaultCell){.centre = {c->x[row], c->y[row], c->z[row]},
                          .size = {c->length[row], c->width[row]},
                          .plane = mesh->plane[row],
                          .vertices = c->vertices + 9 * (size_t)row};
  SlipFaultCellDirections(c->strike[row], c->dip[row], cell);
}

static PetscErrorCode Write_Triangles(const SlipFaultMesh *mesh, SlipH5 *h)
{
  const PetscInt points[2] = {mesh->npoints, 3}, cells[2] = {mesh->N, 3};

  PetscFunctionBegin;
  PetscCall(SlipFaultCellsWrite(mesh, h));
  PetscCall(SlipH5WriteReal(h, "/mesh/vertices", 2, points, mesh->vertex, "m"));
  PetscCall(SlipH5WriteInt(h, "/mesh/triangles", 2, cells, mesh->corner, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Corners_Triangles(const SlipFaultMesh *mesh, PetscReal points[], PetscInt corners[])
{
  PetscFunctionBegin;
  PetscCall(PetscArraycpy(points, mesh->vertex, 3 * (size_t)mesh->npoints));
  PetscCall(PetscArraycpy(corners, mesh->corner, 3 * (size_t)mesh->N));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const SlipFaultMeshKind SlipFaultMeshTriangles = {Create_Triangles,
                                                  Cell_Triangles,
                                                  SlipFaultCellsStiffness,
                                                  Write_Triangles,
                                                  Corners_Triangles,
                                                  SlipFaultCellsDigest,
                                                  3};
