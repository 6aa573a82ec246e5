/* A mesh of the kind "list": rectangular cells of parallel vertical planes in any order, from -fault_mesh. */
#include <slipstep/private/slipfault.h>
#include <slipstep/private/slipmatcells.h>
#include <inttypes.h>
#include <stdio.h>

#define MESH_DATASET "/cells"
#define MESH_COLUMNS "x y z length width"
enum { MESH_NUM_COLUMNS = 5 };
/* [m] No natural fault ends above this depth, and all do in kilometres: a smaller one, as in a laboratory, says that its
   units are metres. */
#define MESH_SHALLOW 100

/* Can rows [n][5] be metres? What no stiffness can be computed for is refused by SlipCellsCheck(). */
static PetscErrorCode SlipFaultMeshCheckMetres(const SlipH5 *h, PetscInt n, const PetscReal rows[], PetscBool metres)
{
  static const char *const name[] = {"x", "y", "z", "length", "width"};
  static const PetscReal limit[] = {FAULT_MAX_REACH, FAULT_MAX_REACH, FAULT_MAX_DEPTH, FAULT_MAX_REACH,
                                    FAULT_MAX_DEPTH};
  PetscReal deepest = 0;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < n; i++) {
    const PetscReal *row = rows + (size_t)i * MESH_NUM_COLUMNS;

    for (PetscInt k = 0; k < MESH_NUM_COLUMNS; k++)
      PetscCheck(!(PetscAbsReal(row[k]) > limit[k]), PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
                 "%s%s: row %" PetscInt_FMT " of " MESH_DATASET
                 " has %s = %.6g, expected metres of a fault, at most %.6g",
                 h->name, h->source, i, name[k], (double)row[k], (double)limit[k]);
    deepest = PetscMax(deepest, row[2] + 0.5 * row[4]);
  }
  PetscCheck(
    metres || !(deepest < MESH_SHALLOW), PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
    "%s%s: the cells reach down to %.6g m, as if they were in kilometres: expected metres. A fault so small says so "
    "by the attribute units = \"m\" of " MESH_DATASET,
    h->name, h->source, (double)deepest);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Rank 0: rows [n][5] of the file. */
static PetscErrorCode SlipFaultMeshRead(SlipFault fault, PetscInt *n, PetscReal **rows)
{
  SlipH5 h;
  const PetscInt want[2] = {-1, MESH_NUM_COLUMNS};
  PetscInt dims[2];
  char columns[128] = MESH_COLUMNS;
  PetscBool has, same, metres = PETSC_FALSE;

  PetscFunctionBegin;
  PetscCall(SlipH5OpenReadOption(SlipFaultPrefix(fault), "fault_mesh", fault->options.text[FAULT_MESH], &h));
  PetscCall(SlipH5Has(&h, MESH_DATASET, &has));
  if (has) {
    PetscCall(SlipH5CheckNames(&h, SlipFaultFieldNames()));
    PetscCall(SlipH5CheckAttributes(&h, MESH_DATASET, "columns units"));
    PetscCall(SlipH5CheckUnits(&h, MESH_DATASET, "m", &metres));
  }
  PetscCall(SlipH5ReadRealSized(&h, MESH_DATASET, 2, want, "with the columns " MESH_COLUMNS, dims, rows));
  PetscCheck(dims[0] > 0, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
             MESH_DATASET " in %s has no rows, expected one for each cell%s", h.name, h.source);
  PetscCall(SlipH5HasAttribute(&h, MESH_DATASET, "columns", &has));
  if (has) PetscCall(SlipH5ReadAttrString(&h, MESH_DATASET, "columns", columns, sizeof(columns)));
  PetscCall(PetscStrcmp(columns, MESH_COLUMNS, &same));
  PetscCheck(same, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
             "%s%s: the columns of " MESH_DATASET " are \"%s\", expected \"" MESH_COLUMNS "\"", h.name, h.source,
             columns);
  PetscCall(SlipFaultMeshCheckMetres(&h, dims[0], *rows, metres));
  PetscCall(SlipH5Close(&h));
  *n = dims[0];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* n cells without numbers, which go into the columns x, y, z, length, width; cells->x owns the memory of all. */
PetscErrorCode SlipFaultCellsCreate(SlipFault fault, PetscInt n, SlipCells *cells, PetscReal *column[5])
{
  PetscReal *data;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(MESH_NUM_COLUMNS * (size_t)n, &data));
  for (PetscInt k = 0; k < MESH_NUM_COLUMNS; k++) column[k] = data + (size_t)k * n;
  *cells = (SlipCells){.n = n, .x = column[0], .y = column[1], .z = column[2], .length = column[3], .width = column[4]};
  PetscCall(SlipFaultKernel(fault, &cells->kernel));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The extents of all cells; as parameters of a grid, a list counts as one row of n cells. */
static void Extents_List(SlipFaultMesh *mesh)
{
  const SlipCells *c = &mesh->cells;
  PetscReal low[2] = {PETSC_MAX_REAL, PETSC_MAX_REAL}, top[2] = {PETSC_MIN_REAL, PETSC_MIN_REAL};

  for (PetscInt i = 0; i < c->n; i++) {
    low[0] = PetscMin(low[0], c->x[i] - 0.5 * c->length[i]);
    top[0] = PetscMax(top[0], c->x[i] + 0.5 * c->length[i]);
    low[1] = PetscMin(low[1], c->z[i] - 0.5 * c->width[i]);
    top[1] = PetscMax(top[1], c->z[i] + 0.5 * c->width[i]);
  }
  mesh->extent[FAULT_NX] = (PetscReal)c->n;
  mesh->extent[FAULT_NZ] = 1;
  mesh->extent[FAULT_LENGTH_X] = top[0] - low[0];
  mesh->extent[FAULT_LENGTH_Z] = top[1] - low[1];
  mesh->extent[FAULT_DEPTH_TOP] = PetscMax(low[1], 0);
}

/* Cells of one plane have the very same y, as the file's; planes are numbered as they come. */
static PetscErrorCode Planes_List(SlipFaultMesh *mesh)
{
  const SlipCells *c = &mesh->cells;
  PetscInt *first; /* row of each plane */

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(c->n, &mesh->plane));
  PetscCall(PetscMalloc1(c->n, &first));
  mesh->planes = 0;
  for (PetscInt i = 0; i < c->n; i++) {
    PetscInt p = 0;

    while (p < mesh->planes && c->y[first[p]] != c->y[i]) p++;
    if (p == mesh->planes) first[mesh->planes++] = i;
    mesh->plane[i] = p;
  }
  PetscCall(PetscFree(first));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Create_List(SlipFault fault)
{
  SlipFaultMesh *mesh = &fault->mesh;
  const char *file = fault->options.text[FAULT_MESH];
  const char *prefix = SlipFaultPrefix(fault);
  char source[PETSC_MAX_PATH_LEN + 64];
  PetscReal *rows = NULL, *column[MESH_NUM_COLUMNS];
  PetscErrorCode ierr = PETSC_SUCCESS;
  PetscMPIInt rank;
  PetscInt n = 0;

  PetscFunctionBegin;
  PetscCheck(!fault->options.text[FAULT_STIFFNESS_FILE][0], fault->comm, PETSC_ERR_ARG_INCOMP,
             "-%sfault_stiffness_file %s and -%sfault_mesh %s exclude each other", prefix,
             fault->options.text[FAULT_STIFFNESS_FILE], prefix, file);
  PetscCallMPI(MPI_Comm_rank(fault->comm, &rank));
  if (!rank) ierr = SlipFaultMeshRead(fault, &n, &rows);
  PetscCall(SlipErrorBcast(fault->comm, ierr));
  PetscCallMPI(MPI_Bcast(&n, 1, MPIU_INT, 0, fault->comm));
  PetscCall(SlipFaultCellsCreate(fault, n, &mesh->cells, column));
  for (PetscInt k = 0; k < MESH_NUM_COLUMNS; k++) {
    for (PetscInt i = 0; !rank && i < n; i++) column[k][i] = rows[(size_t)i * MESH_NUM_COLUMNS + k];
    PetscCallMPI(MPI_Bcast(column[k], (PetscMPIInt)n, MPIU_REAL, 0, fault->comm));
  }
  PetscCall(PetscFree(rows));
  PetscCall(PetscSNPrintf(source, sizeof(source), "%s (-%sfault_mesh)", file, prefix));
  PetscCall(SlipCellsCheck(fault->comm, &mesh->cells, source));
  Extents_List(mesh);
  PetscCall(Planes_List(mesh));
  PetscCall(SlipCellsPartition(fault->comm, &mesh->cells, fault->options.text[FAULT_OPERATOR], &mesh->order,
                               &mesh->cells.nlocal));
  mesh->cells.order = mesh->order;
  mesh->N = n;
  mesh->n = mesh->cells.nlocal;
  mesh->ndim = 1;
  mesh->dims[0] = mesh->dims[1] = n;
  mesh->npoints = 4 * n;
  mesh->unit = 2 * SlipCellsUnit(&mesh->cells);
  mesh->area = 1 / mesh->unit;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void Cell_List(const SlipFaultMesh *mesh, PetscInt row, SlipFaultCell *cell)
{
  const SlipCells *c = &mesh->cells;

  *cell = (SlipFaultCell){{c->x[row], c->y[row], c->z[row]},
                          {c->length[row], c->width[row]},
                          {{1, 0, 0}, {0, 0, 1}, {0, 1, 0}},
                          mesh->plane[row]};
}

static PetscErrorCode Stiffness_List(SlipFault fault, Mat *K, Mat *Kn)
{
  const char *type = fault->options.text[FAULT_OPERATOR];
  PetscBool fft;

  PetscFunctionBegin;
  PetscCall(PetscStrcmp(type, "fft", &fft));
  PetscCheck(!fft, fault->comm, PETSC_ERR_ARG_INCOMP,
             "-%sfault_operator fft needs a uniform grid, but -%sfault_mesh %s is an irregular one: expected dense, "
             "hmat or auto",
             SlipFaultPrefix(fault), SlipFaultPrefix(fault), fault->options.text[FAULT_MESH]);
  PetscCall(SlipFaultKernel(fault, &fault->mesh.cells.kernel));
  PetscCall(
    MatCreateSlipCellStiffness(fault->comm, &fault->mesh.cells, type, fault->options.value[FAULT_HMAT_TOLERANCE], K));
  if (Kn)
    PetscCall(MatCreateSlipCellNormalStiffness(fault->comm, &fault->mesh.cells, type,
                                               fault->options.value[FAULT_HMAT_TOLERANCE], Kn));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Write_List(const SlipFaultMesh *mesh, SlipH5 *h)
{
  const SlipCells *c = &mesh->cells;

  PetscFunctionBegin;
  PetscCall(SlipH5WriteReal(h, "/mesh/x", 1, &c->n, c->x, "m"));
  PetscCall(SlipH5WriteReal(h, "/mesh/y", 1, &c->n, c->y, "m"));
  PetscCall(SlipH5WriteReal(h, "/mesh/z", 1, &c->n, c->z, "m"));
  PetscCall(SlipH5WriteReal(h, "/mesh/length", 1, &c->n, c->length, "m"));
  PetscCall(SlipH5WriteReal(h, "/mesh/width", 1, &c->n, c->width, "m"));
  PetscCall(SlipH5WriteAttrInt(h, "/mesh", "cells", c->n));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Cells need not meet at corners: none is shared. */
static PetscErrorCode Corners_List(const SlipFaultMesh *mesh, PetscReal points[], PetscInt corners[])
{
  static const PetscReal side[4][2] = {{-0.5, -0.5}, {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}}; /* of size[] */

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

static PetscErrorCode Digest_List(const SlipFaultMesh *mesh, char text[], size_t len)
{
  const SlipCells *c = &mesh->cells;
  const PetscReal *const numbers[] = {c->x, c->y, c->z, c->length, c->width};
  uint64_t hash = SLIP_HASH_START;

  PetscFunctionBegin;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(numbers); k++) hash = SlipHashReals(hash, numbers[k], (size_t)c->n);
  (void)snprintf(text, len, "of %lld cells, %016" PRIx64, (long long)c->n, hash);
  PetscFunctionReturn(PETSC_SUCCESS);
}

const SlipFaultMeshKind SlipFaultMeshList = {Create_List, Cell_List,    Stiffness_List,
                                             Write_List,  Corners_List, Digest_List};
