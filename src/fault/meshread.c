/* The file of -fault_mesh: /cells, a row for each rectangle, and /fault, which names the fault of each. */
#include <slipstep/private/slipfault.h>
#include <slipstep/private/slipelasticity.h>
#include <math.h>

#define MESH_DATASET "/cells"
#define MESH_LABELS "/fault"
#define MESH_NAMES "x y z length width"
#define MESH_ALL_NAMES MESH_NAMES " strike dip"
/* [m] No natural fault ends above this depth, and all do in kilometres: a smaller one, as in a laboratory, says that its
   units are metres. */
#define MESH_SHALLOW 100
/* What every PetscInt holds, and single precision nearly does */
#define MESH_MAX_LABEL 1e9

/* Can rows be metres and degrees? What no stiffness can be computed for is refused by SlipCellsCheck(). */
static PetscErrorCode CheckUnits(const SlipH5 *h, const SlipFaultMeshRows *m, PetscBool metres)
{
  static const char *const name[MESH_COLUMNS] = {"x", "y", "z", "length", "width", "strike", "dip"};
  static const PetscReal limit[] = {FAULT_MAX_REACH, FAULT_MAX_REACH, FAULT_MAX_DEPTH, FAULT_MAX_REACH,
                                    FAULT_MAX_DEPTH};
  PetscReal deepest = 0;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < m->n; i++) {
    const PetscReal *row = m->rows + (size_t)i * m->columns;
    PetscReal sine = 1, cosine;

    for (PetscInt k = 0; k < MESH_VERTICAL_COLUMNS; k++)
      PetscCheck(!(PetscAbsReal(row[k]) > limit[k]), PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
                 "%s%s: row %" PetscInt_FMT " of " MESH_DATASET
                 " has %s = %.6g, expected metres of a fault, at most %.6g",
                 h->name, h->source, i, name[k], (double)row[k], (double)limit[k]);
    if (m->columns == MESH_COLUMNS) SlipDegrees(row[6], &sine, &cosine);
    deepest = PetscMax(deepest, row[2] + 0.5 * row[4] * sine);
  }
  PetscCheck(
    metres || !(deepest < MESH_SHALLOW), PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
    "%s%s: the cells reach down to %.6g m, as if they were in kilometres: expected metres. A fault so small says so "
    "by the attribute units = \"m\" of " MESH_DATASET,
    h->name, h->source, (double)deepest);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Its shape, which says what its columns are, and the attributes */
static PetscErrorCode ReadCells(SlipH5 *h, SlipFaultMeshRows *m)
{
  const char *names;
  PetscInt want[2] = {-1, MESH_VERTICAL_COLUMNS}, dims[2];
  char columns[128];
  PetscBool has, same, metres = PETSC_FALSE;

  PetscFunctionBegin;
  PetscCall(SlipH5Has(h, MESH_DATASET, &has));
  if (has) {
    PetscCall(SlipH5CheckNames(h, SlipFaultFieldNames()));
    PetscCall(SlipH5CheckAttributes(h, MESH_DATASET, "columns units"));
    PetscCall(SlipH5CheckUnits(h, MESH_DATASET, "m", &metres));
  }
  PetscCall(SlipH5GetSize(h, MESH_DATASET, 1, &m->columns));
  if (m->columns == MESH_COLUMNS) want[1] = MESH_COLUMNS;
  m->columns = want[1];
  names = m->columns == MESH_COLUMNS ? MESH_ALL_NAMES : MESH_NAMES;
  PetscCall(SlipH5ReadRealSized(
    h, MESH_DATASET, 2, want, "with the columns " MESH_NAMES ", or [any, 7], with strike dip besides", dims, &m->rows));
  m->n = dims[0];
  PetscCheck(m->n > 0, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
             MESH_DATASET " in %s has no rows, expected one for each cell%s", h->name, h->source);
  PetscCall(PetscStrncpy(columns, names, sizeof(columns)));
  PetscCall(SlipH5HasAttribute(h, MESH_DATASET, "columns", &has));
  if (has) PetscCall(SlipH5ReadAttrString(h, MESH_DATASET, "columns", columns, sizeof(columns)));
  PetscCall(PetscStrcmp(columns, names, &same));
  PetscCheck(same, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
             "%s%s: the columns of " MESH_DATASET " are \"%s\", expected \"%s\"", h->name, h->source, columns, names);
  PetscCall(CheckUnits(h, m, metres));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadLabels(SlipH5 *h, SlipFaultMeshRows *m)
{
  PetscInt dims[1];
  PetscReal *label;
  PetscBool has;

  PetscFunctionBegin;
  PetscCall(SlipH5Has(h, MESH_LABELS, &has));
  if (!has) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipH5CheckAttributes(h, MESH_LABELS, "units"));
  PetscCall(SlipH5CheckUnits(h, MESH_LABELS, "", &has));
  PetscCall(SlipH5ReadRealSized(h, MESH_LABELS, 1, &m->n, "one label for each row of " MESH_DATASET, dims, &label));
  PetscCall(PetscMalloc1(m->n, &m->label));
  for (PetscInt i = 0; i < m->n; i++) {
    const PetscReal l = label[i];

    PetscCheck(l == PetscFloorReal(l) && PetscAbsReal(l) <= MESH_MAX_LABEL, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
               "%s%s: row %" PetscInt_FMT " of " MESH_LABELS " is %g, expected the fault's label, a whole number of at "
               "most %g",
               h->name, h->source, i, (double)l, MESH_MAX_LABEL);
    m->label[i] = (PetscInt)l;
  }
  PetscCall(PetscFree(label));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultMeshRead(SlipFault fault, SlipFaultMeshRows *m)
{
  SlipH5 h;

  PetscFunctionBegin;
  *m = (SlipFaultMeshRows){.n = 0};
  PetscCall(SlipH5OpenReadOption(SlipFaultPrefix(fault), "fault_mesh", fault->options.text[FAULT_MESH], &h));
  PetscCall(ReadCells(&h, m));
  PetscCall(ReadLabels(&h, m));
  PetscCall(SlipH5Close(&h));
  PetscFunctionReturn(PETSC_SUCCESS);
}
