/* A mesh of the kind "list": rectangular cells of planes with any strike and dip, in any order, from -fault_mesh. */
#include <slipstep/private/slipmesh.h>
#include <slipstep/private/slipelasticity.h>
#include <slipstep/private/slipmatcells.h>
#include <inttypes.h>
#include <stdio.h>

/* Allocates n cells in shared, whose columns are x, y, z, length, width and, if there are seven, strike and dip, one
   after the other. */
PetscErrorCode SlipFaultCellsCreate(SlipShared shared, const SlipKernel *kernel, PetscInt n, PetscInt columns,
                                    SlipCells *cells, PetscReal *column[])
{
  PetscReal *data;

  PetscFunctionBegin;
  PetscCall(SlipSharedMalloc1(shared, columns * (size_t)n, &data));
  for (PetscInt k = 0; k < columns; k++) column[k] = data + (size_t)k * n;
  *cells = (SlipCells){.n = n, .x = column[0], .y = column[1], .z = column[2], .length = column[3], .width = column[4]};
  if (columns == MESH_COLUMNS) {
    cells->strike = column[5];
    cells->dip = column[6];
  }
  cells->kernel = *kernel;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets mesh->dips. If all cells are vertical and strike north, the list becomes one of five columns, with bitwise the
   same results. */
static void Directions(SlipFaultMesh *mesh)
{
  SlipCells *c = &mesh->cells;
  PetscBool vertical = PETSC_TRUE, one = PETSC_TRUE, north = PETSC_TRUE;

  mesh->dips = PETSC_FALSE;
  if (!c->dip) return;
  for (PetscInt i = 0; i < c->n; i++) {
    vertical = vertical && c->dip[i] == 90 ? PETSC_TRUE : PETSC_FALSE;
    one = one && c->strike[i] == c->strike[0] ? PETSC_TRUE : PETSC_FALSE;
    north = north && c->strike[i] == 0 ? PETSC_TRUE : PETSC_FALSE;
  }
  mesh->dips = vertical && one ? PETSC_FALSE : PETSC_TRUE;
  if (vertical && north) c->strike = c->dip = NULL;
}

/* Computes strike and dip of the whole: those of all cells if they are equal, else their means over the area. */
void SlipFaultCellsDirection(const SlipCells *c, PetscReal *strike, PetscReal *dip)
{
  PetscReal sum[2] = {0, 0}, area = 0, dips = 0;
  PetscBool one[2] = {PETSC_TRUE, PETSC_TRUE};

  *strike = 0;
  *dip = 90;
  if (!c->dip) return;
  for (PetscInt i = 0; i < c->n; i++) {
    const PetscReal a = c->length[i] * c->width[i];
    PetscReal sine, cosine;

    SlipDegrees(c->strike[i], &sine, &cosine);
    sum[0] += a * cosine;
    sum[1] += a * sine;
    dips += a * c->dip[i];
    area += a;
    one[0] = one[0] && c->strike[i] == c->strike[0] ? PETSC_TRUE : PETSC_FALSE;
    one[1] = one[1] && c->dip[i] == c->dip[0] ? PETSC_TRUE : PETSC_FALSE;
  }
  /* strikes that cancel have no mean, such as those of a vertical plane with 0 in some rows and 180 in others */
  *strike = one[0] || PetscHypotReal(sum[0], sum[1]) < 1e-3 * area ? c->strike[0]
                                                                   : PetscAtan2Real(sum[1], sum[0]) * 180 / PETSC_PI;
  *dip = one[1] ? c->dip[0] : dips / area;
}

/* Computes the extents of all cells along the strike of the whole and down its dip. In the parameters of a grid, a list
   counts as one row of n cells. */
static void Extents_List(SlipFaultMesh *mesh)
{
  const SlipCells *c = &mesh->cells;
  PetscReal low[2] = {PETSC_MAX_REAL, PETSC_MAX_REAL}, top[2] = {PETSC_MIN_REAL, PETSC_MIN_REAL};
  PetscReal strike, dip, along[2], sine, cosine;

  SlipFaultCellsDirection(c, &strike, &dip);
  SlipDegrees(strike, &along[1], &along[0]);
  for (PetscInt i = 0; i < c->n; i++) {
    const PetscReal at = c->x[i] * along[0] + c->y[i] * along[1];
    PetscReal half[2] = {0.5 * c->length[i], 0.5 * c->width[i]};

    if (c->dip) {
      SlipFaultCell cell;
      const PetscReal *s = cell.direction[0], *d = cell.direction[1];

      SlipFaultCellDirections(c->strike[i], c->dip[i], &cell);
      half[0] = half[0] * PetscAbsReal(s[0] * along[0] + s[1] * along[1]) +
                half[1] * PetscAbsReal(d[0] * along[0] + d[1] * along[1]);
      half[1] *= d[2];
    }
    low[0] = PetscMin(low[0], at - half[0]);
    top[0] = PetscMax(top[0], at + half[0]);
    low[1] = PetscMin(low[1], c->z[i] - half[1]);
    top[1] = PetscMax(top[1], c->z[i] + half[1]);
  }
  SlipDegrees(dip, &sine, &cosine);
  mesh->extent[MESH_NX] = (PetscReal)c->n;
  mesh->extent[MESH_NZ] = 1;
  mesh->extent[MESH_LENGTH_X] = top[0] - low[0];
  mesh->extent[MESH_LENGTH_Z] = (top[1] - low[1]) / sine;
  mesh->extent[MESH_DEPTH_TOP] = PetscMax(low[1], 0);
  mesh->extent[MESH_STRIKE] = strike;
  mesh->extent[MESH_DIP] = dip;
}

/* Distributes the cells over processes and computes the mean cell. */
PetscErrorCode SlipFaultCellsShare(SlipFaultMesh *mesh, const char type[])
{
  PetscFunctionBegin;
  mesh->N = mesh->cells.n;
  PetscCall(SlipCellsPartition(mesh->comm, &mesh->cells, type, mesh->shared, &mesh->order, &mesh->cells.nlocal));
  mesh->cells.order = mesh->order;
  mesh->n = mesh->cells.nlocal;
  mesh->ndim = 1;
  mesh->dims[0] = mesh->dims[1] = mesh->N;
  mesh->unit = 2 * SlipCellsUnit(&mesh->cells);
  mesh->area = 1 / mesh->unit;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Create_List(SlipFaultMesh *mesh, const SlipFaultMeshOptions *o, SlipFaultMeshFile *file)
{
  PetscInt sizes[3] = {file->n, file->columns, file->label ? 1 : 0};
  char source[PETSC_MAX_PATH_LEN + 64];
  PetscReal *column[MESH_COLUMNS];
  PetscMPIInt rank;

  PetscFunctionBegin;
  /* broadcast what rank 0 has read: columns, and labels if the file names faults */
  PetscCallMPI(MPI_Comm_rank(mesh->comm, &rank));
  PetscCallMPI(MPI_Bcast(sizes, 3, MPIU_INT, 0, mesh->comm));
  PetscCall(SlipFaultCellsCreate(mesh->shared, &o->rectangles, sizes[0], sizes[1], &mesh->cells, column));
  mesh->cells.kernel.average = SLIP_AVERAGE_CENTRE; /* the option's own check refuses others later */
  for (PetscInt k = 0; k < sizes[1]; k++) {
    for (PetscInt i = 0; !rank && i < file->n; i++) column[k][i] = file->rows[(size_t)i * file->columns + k];
  }
  PetscCall(SlipSharedBcast(mesh->shared, column[0], sizes[0] * sizes[1], MPIU_REAL));
  mesh->labelled = sizes[2] ? PETSC_TRUE : PETSC_FALSE;
  PetscCall(SlipSharedMalloc1(mesh->shared, sizes[0], &mesh->label));
  if (file->label) PetscCall(PetscArraycpy(mesh->label, file->label, file->n));
  if (mesh->labelled) PetscCall(SlipSharedBcast(mesh->shared, mesh->label, sizes[0], MPIU_INT));
  PetscCall(PetscSNPrintf(source, sizeof(source), "%s (-%sfault_mesh)", o->file, o->prefix));
  mesh->cells.number = file->number; /* numbers of the file, on the rank that prints errors */
  PetscCall(SlipCellsCheck(mesh->comm, &mesh->cells, source));
  mesh->cells.number = NULL;
  Directions(mesh);
  Extents_List(mesh);
  PetscCall(SlipFaultMeshPlanes(mesh));
  PetscCall(SlipFaultCellsShare(mesh, o->type));
  mesh->npoints = 4 * mesh->N;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void Cell_List(const SlipFaultMesh *mesh, PetscInt row, SlipFaultCell *cell)
{
  const SlipCells *c = &mesh->cells;

  *cell = (SlipFaultCell){{c->x[row], c->y[row], c->z[row]},
                          {c->length[row], c->width[row]},
                          {{1, 0, 0}, {0, 0, 1}, {0, 1, 0}},
                          mesh->plane[row],
                          NULL};
  if (c->dip) SlipFaultCellDirections(c->strike[row], c->dip[row], cell);
}

/* Prepares the kernel's cells. data [2 n], shared, has what the kernel needs besides the file's columns or instead of
   them: x along the strike for vertical planes of one strike, the rakes for all others. */
static PetscErrorCode KernelCells(const SlipFaultMesh *mesh, const SlipFaultStiffness *s, SlipCells *cells,
                                  PetscReal data[])
{
  const SlipCells *c = &mesh->cells;
  PetscReal along[2], *x = data, *y = data + c->n;
  PetscInt start, end;

  PetscFunctionBegin;
  *cells = *c;
  cells->kernel = s->kernel;
  if (s->dipping) {
    PetscCall(SlipFaultGatherFirst(mesh, s->rake, data));
    PetscCall(SlipSharedBcast(mesh->shared, data, mesh->N, MPIU_REAL));
    cells->rake = data;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (!c->dip) PetscFunctionReturn(PETSC_SUCCESS);
  SlipDegrees(c->strike[0], &along[1], &along[0]);
  SlipSharedSlice(mesh->shared, data, c->n, &start, &end);
  for (PetscInt i = start; i < end; i++) {
    x[i] = along[0] * c->x[i] + along[1] * c->y[i];
    y[i] = along[0] * c->y[i] - along[1] * c->x[i];
  }
  PetscCall(SlipSharedReady(mesh->shared));
  cells->x = x;
  cells->y = y;
  cells->strike = cells->dip = NULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultCellsStiffness(const SlipFaultMesh *mesh, const SlipFaultStiffness *s, Mat *K, Mat *Kn)
{
  SlipCells cells;
  PetscReal *data;

  PetscFunctionBegin;
  PetscCall(SlipSharedMalloc1(mesh->shared, 2 * mesh->N, &data));
  PetscCall(KernelCells(mesh, s, &cells, data));
  if (s->kernel.type->components > 1)
    PetscCall(MatCreateSlipCellVectorStiffness(mesh->comm, &cells, s->type, s->tolerance, K, Kn));
  else {
    PetscCall(MatCreateSlipCellStiffness(mesh->comm, &cells, s->type, s->tolerance, K));
    if (Kn) PetscCall(MatCreateSlipCellNormalStiffness(mesh->comm, &cells, s->type, s->tolerance, Kn));
  }
  PetscCall(SlipSharedFree(mesh->shared, &data));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Predicts K, and if normal Kn, for size processes; the first process computes it. */
PetscErrorCode SlipFaultCellsForecast(const SlipFaultMesh *mesh, const SlipFaultStiffness *s, PetscBool normal,
                                      PetscMPIInt size, SlipCellsForecast forecast[])
{
  PetscErrorCode ierr = PETSC_SUCCESS;
  PetscMPIInt rank;
  SlipCells cells;
  PetscReal *data;

  PetscFunctionBegin;
  PetscCall(SlipSharedMalloc1(mesh->shared, 2 * mesh->N, &data));
  PetscCall(KernelCells(mesh, s, &cells, data));
  PetscCallMPI(MPI_Comm_rank(mesh->comm, &rank));
  if (!rank) ierr = SlipCellsForecasts(&cells, s->type, s->tolerance, normal, size, forecast);
  PetscCall(SlipErrorBcast(mesh->comm, ierr));
  PetscCallMPI(MPI_Bcast(forecast, (normal ? 2 : 1) * size * (PetscMPIInt)(sizeof(*forecast) / sizeof(PetscReal)),
                         MPIU_REAL, 0, mesh->comm));
  PetscCall(SlipSharedFree(mesh->shared, &data));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultCellsWrite(const SlipFaultMesh *mesh, SlipH5 *h)
{
  const SlipCells *c = &mesh->cells;

  PetscFunctionBegin;
  PetscCall(SlipH5WriteReal(h, "/mesh/x", 1, &c->n, c->x, "m"));
  PetscCall(SlipH5WriteReal(h, "/mesh/y", 1, &c->n, c->y, "m"));
  PetscCall(SlipH5WriteReal(h, "/mesh/z", 1, &c->n, c->z, "m"));
  PetscCall(SlipH5WriteReal(h, "/mesh/length", 1, &c->n, c->length, "m"));
  PetscCall(SlipH5WriteReal(h, "/mesh/width", 1, &c->n, c->width, "m"));
  if (c->dip) {
    PetscCall(SlipH5WriteReal(h, "/mesh/strike", 1, &c->n, c->strike, "degrees"));
    PetscCall(SlipH5WriteReal(h, "/mesh/dip", 1, &c->n, c->dip, "degrees"));
  }
  if (c->dip || mesh->labelled) PetscCall(SlipH5WriteInt(h, "/mesh/fault", 1, &c->n, mesh->label, NULL));
  if (mesh->names) PetscCall(SlipH5WriteAttrString(h, "/mesh/fault", "names", mesh->names));
  PetscCall(SlipH5WriteAttrInt(h, "/mesh", "cells", c->n));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lists corners, which cells do not share because they need not meet there. */
static PetscErrorCode Corners_List(const SlipFaultMesh *mesh, PetscReal points[], PetscInt corners[])
{
  static const PetscReal side[4][2] = {{-0.5, -0.5}, {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}}; /* relative to size[] */

  PetscFunctionBegin;
  for (PetscInt e = 0; e < 4 * mesh->N; e++) {
    const PetscReal *s = side[e % 4];
    SlipFaultCell cell;

    Cell_List(mesh, e / 4, &cell);
    for (PetscInt k = 0; k < 3; k++)
      points[3 * e + k] =
        cell.centre[k] + s[0] * cell.size[0] * cell.direction[0][k] + s[1] * cell.size[1] * cell.direction[1][k];
    corners[e] = e;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultCellsDigest(const SlipFaultMesh *mesh, char text[], size_t len)
{
  const SlipCells *c = &mesh->cells;
  const PetscReal *const numbers[] = {c->x, c->y, c->z, c->length, c->width, c->strike, c->dip};
  uint64_t hash = SLIP_HASH_START;

  PetscFunctionBegin;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(numbers) && numbers[k]; k++)
    hash = SlipHashReals(hash, numbers[k], (size_t)c->n);
  if (c->vertices) hash = SlipHashReals(hash, c->vertices, 9 * (size_t)c->n);
  for (PetscInt i = 0; i < c->n && mesh->labelled; i++) {
    const PetscReal label = (PetscReal)mesh->label[i];

    hash = SlipHashReals(hash, &label, 1);
  }
  (void)snprintf(text, len, "of %lld cells, %016" PRIx64, (long long)c->n, hash);
  PetscFunctionReturn(PETSC_SUCCESS);
}

const SlipFaultMeshKind SlipFaultMeshList = {
  Create_List, Cell_List, SlipFaultCellsStiffness, SlipFaultCellsWrite, Corners_List, SlipFaultCellsDigest, 4};
