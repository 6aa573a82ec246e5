/* A fault of irregular cells, -fault_mesh: its file, its stiffness, and the weights of its rows. */
#include <slipstep/private/slipfault.h>
#include <slipstep/private/slipmatcells.h>

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
  char columns[128] = MESH_COLUMNS, names[256];
  PetscBool has, same, metres = PETSC_FALSE;

  PetscFunctionBegin;
  PetscCall(SlipH5OpenReadOption(SlipFaultPrefix(fault), "fault_mesh", fault->options.text[FAULT_MESH], &h));
  PetscCall(SlipFaultFieldNames(names, sizeof(names)));
  PetscCall(SlipH5Has(&h, MESH_DATASET, &has));
  if (has) {
    PetscCall(SlipH5CheckNames(&h, names));
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

/* cells->x owns the memory of all five columns. */
static PetscErrorCode SlipFaultCellsCreate(SlipFault fault, PetscInt n, SlipCells *cells, PetscReal *column[])
{
  PetscReal *data;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(MESH_NUM_COLUMNS * (size_t)n, &data));
  for (PetscInt k = 0; k < MESH_NUM_COLUMNS; k++) column[k] = data + (size_t)k * n;
  *cells = (SlipCells){.n = n,
                       .x = column[0],
                       .y = column[1],
                       .z = column[2],
                       .length = column[3],
                       .width = column[4],
                       .shear_modulus = fault->options.value[FAULT_SHEAR_MODULUS],
                       .poisson_ratio = fault->options.value[FAULT_POISSON_RATIO]};
  PetscCall(PetscStrcmp(fault->options.text[FAULT_KERNEL], "full_space", &cells->full_space));
  PetscCall(SlipFaultAverage(fault, &cells->average));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The extents of all cells take the place of the grid's; a mesh counts as one row of n cells. */
static void SlipFaultMeshExtents(SlipFault fault)
{
  const SlipCells *c = &fault->mesh.cells;
  PetscReal low[2] = {PETSC_MAX_REAL, PETSC_MAX_REAL}, top[2] = {PETSC_MIN_REAL, PETSC_MIN_REAL};

  for (PetscInt i = 0; i < c->n; i++) {
    low[0] = PetscMin(low[0], c->x[i] - 0.5 * c->length[i]);
    top[0] = PetscMax(top[0], c->x[i] + 0.5 * c->length[i]);
    low[1] = PetscMin(low[1], c->z[i] - 0.5 * c->width[i]);
    top[1] = PetscMax(top[1], c->z[i] + 0.5 * c->width[i]);
  }
  fault->options.value[FAULT_NX] = (PetscReal)c->n;
  fault->options.value[FAULT_NZ] = 1;
  fault->options.value[FAULT_LENGTH_X] = top[0] - low[0];
  fault->options.value[FAULT_LENGTH_Z] = top[1] - low[1];
  fault->options.value[FAULT_DEPTH_TOP] = PetscMax(low[1], 0);
}

/* Collective: the cells of -fault_mesh on every process, checked. */
PetscErrorCode SlipFaultMeshSetUp(SlipFault fault)
{
  const char *file = fault->options.text[FAULT_MESH];
  const char *prefix = SlipFaultPrefix(fault);
  char source[PETSC_MAX_PATH_LEN + 64];
  PetscReal *rows = NULL, *column[MESH_NUM_COLUMNS];
  PetscErrorCode ierr = PETSC_SUCCESS;
  PetscMPIInt rank;
  PetscInt n = 0;

  PetscFunctionBegin;
  if (!file[0]) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCheck(!fault->options.text[FAULT_STIFFNESS_FILE][0], fault->comm, PETSC_ERR_ARG_INCOMP,
             "-%sfault_stiffness_file %s and -%sfault_mesh %s exclude each other", prefix,
             fault->options.text[FAULT_STIFFNESS_FILE], prefix, file);
  PetscCallMPI(MPI_Comm_rank(fault->comm, &rank));
  if (!rank) ierr = SlipFaultMeshRead(fault, &n, &rows);
  PetscCall(SlipErrorBcast(fault->comm, ierr));
  PetscCallMPI(MPI_Bcast(&n, 1, MPIU_INT, 0, fault->comm));
  PetscCall(SlipFaultCellsCreate(fault, n, &fault->mesh.cells, column));
  for (PetscInt k = 0; k < MESH_NUM_COLUMNS; k++) {
    for (PetscInt i = 0; !rank && i < n; i++) column[k][i] = rows[(size_t)i * MESH_NUM_COLUMNS + k];
    PetscCallMPI(MPI_Bcast(column[k], (PetscMPIInt)n, MPIU_REAL, 0, fault->comm));
  }
  PetscCall(PetscFree(rows));
  PetscCall(PetscSNPrintf(source, sizeof(source), "%s (-%sfault_mesh)", file, prefix));
  PetscCall(SlipCellsCheck(fault->comm, &fault->mesh.cells, source));
  SlipFaultMeshExtents(fault);
  PetscCall(SlipCellsPartition(fault->comm, &fault->mesh.cells, fault->options.text[FAULT_OPERATOR], &fault->mesh.order,
                               &fault->mesh.cells.nlocal));
  fault->mesh.cells.order = fault->mesh.order;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The grid's cells as cells, for hierarchical storage. */
static PetscErrorCode SlipFaultCellsOfGrid(SlipFault fault, SlipCells *cells)
{
  const PetscReal a = fault->options.value[FAULT_LENGTH_X] / fault->options.value[FAULT_NX];
  const PetscReal b = fault->options.value[FAULT_LENGTH_Z] / fault->options.value[FAULT_NZ];
  PetscReal *column[MESH_NUM_COLUMNS];

  PetscFunctionBegin;
  PetscCall(SlipFaultCellsCreate(fault, fault->mesh.N, cells, column));
  for (PetscInt e = 0; e < fault->mesh.N; e++) {
    PetscCall(SlipFaultCellCentre(fault, e, &column[0][e], &column[2][e]));
    column[1][e] = 0;
    column[3][e] = a;
    column[4][e] = b;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Collective: K of the mesh, or of the grid in hierarchical storage; done is false when it is neither. */
PetscErrorCode SlipFaultMeshStiffness(SlipFault fault, PetscBool *done)
{
  const char *type = fault->options.text[FAULT_OPERATOR];
  SlipCells cells = fault->mesh.cells;
  PetscBool fft, hmat;

  PetscFunctionBegin;
  PetscCall(PetscStrcmp(type, "fft", &fft));
  PetscCall(PetscStrcmp(type, "hmat", &hmat));
  *done = cells.n || hmat ? PETSC_TRUE : PETSC_FALSE;
  if (!*done) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCheck(!cells.n || !fft, fault->comm, PETSC_ERR_ARG_INCOMP,
             "-%sfault_operator fft needs a uniform grid, but -%sfault_mesh %s is an irregular one: expected dense, "
             "hmat or auto",
             SlipFaultPrefix(fault), SlipFaultPrefix(fault), fault->options.text[FAULT_MESH]);
  if (!fault->mesh.cells.n) PetscCall(SlipFaultCellsOfGrid(fault, &cells));
  PetscCall(MatCreateSlipCellStiffness(fault->comm, &cells, type, fault->options.value[FAULT_HMAT_TOLERANCE],
                                       &fault->operators.K));
  if (!fault->mesh.cells.n) PetscCall(SlipCellsDestroy(&cells));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Weights of the rows from the areas of the cells, 1 on a grid. */
PetscErrorCode SlipFaultWeightsSetUp(SlipFault fault)
{
  const SlipCells *c = &fault->mesh.cells;
  const PetscReal unit = c->n ? 2 * SlipCellsUnit(c) : 0;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(PetscMax(fault->mesh.n, 1), &fault->mesh.weight));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    const PetscInt e = c->n ? SlipCellsAt(c, fault->mesh.start + i) : 0;

    fault->mesh.weight[i] = c->n ? c->length[e] * c->width[e] * unit : 1;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sum of the weighted values of a reduced vector, collective. */
PetscErrorCode SlipFaultWeightedSum(SlipFault fault, Vec x, PetscReal *sum)
{
  const PetscReal *a;

  PetscFunctionBegin;
  *sum = 0;
  PetscCall(VecGetArrayRead(x, &a));
  for (PetscInt i = 0; i < fault->mesh.n; i++) *sum += fault->mesh.weight[i] * a[i];
  PetscCall(VecRestoreArrayRead(x, &a));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 1, MPIU_REAL, MPIU_SUM, fault->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* For gathering vectors like x, one or more numbers for each cell, on rank 0 in the order of the file or grid. */
PetscErrorCode SlipFaultGatherCreate(SlipFault fault, Vec x, VecScatter *scatter, Vec *x0)
{
  PetscMPIInt rank;
  PetscInt size, block, n, *cell;
  IS from;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(fault->comm, &rank));
  PetscCall(VecGetSize(x, &size));
  block = size / fault->mesh.N;
  n = rank ? 0 : fault->mesh.N;
  PetscCall(PetscMalloc1(n, &cell));
  for (PetscInt e = 0; e < n; e++) cell[fault->mesh.order ? fault->mesh.order[e] : e] = e;
  PetscCall(ISCreateBlock(fault->comm, block, n, cell, PETSC_OWN_POINTER, &from));
  PetscCall(VecCreateSeq(PETSC_COMM_SELF, n * block, x0));
  PetscCall(VecScatterCreate(x, from, *x0, NULL, scatter));
  PetscCall(ISDestroy(&from));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Rank 0: the cells, in place of a grid's axes. */
PetscErrorCode SlipFaultMeshWrite(SlipFault fault, SlipH5 *h)
{
  const SlipCells *c = &fault->mesh.cells;

  PetscFunctionBegin;
  PetscCall(SlipH5WriteReal(h, "/mesh/x", 1, &c->n, c->x, "m"));
  PetscCall(SlipH5WriteReal(h, "/mesh/y", 1, &c->n, c->y, "m"));
  PetscCall(SlipH5WriteReal(h, "/mesh/z", 1, &c->n, c->z, "m"));
  PetscCall(SlipH5WriteReal(h, "/mesh/length", 1, &c->n, c->length, "m"));
  PetscCall(SlipH5WriteReal(h, "/mesh/width", 1, &c->n, c->width, "m"));
  PetscCall(SlipH5WriteAttrInt(h, "/mesh", "cells", c->n));
  PetscFunctionReturn(PETSC_SUCCESS);
}
