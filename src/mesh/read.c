/* Reads the HDF5 file of -fault_mesh: /cells, a row per rectangle, or /vertices and /triangles, and /fault, the number
   of the fault of each cell. */
#include <slipstep/private/slipmesh.h>
#include <slipstep/private/slipelasticity.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#define MESH_DATASET "/cells"
#define MESH_LABELS "/fault"
#define MESH_NAMES "x y z length width"
#define MESH_ALL_NAMES MESH_NAMES " strike dip"
#define MESH_VERTICES "/vertices"
#define MESH_TRIANGLES "/triangles"

/* Axes and unit of the numbers in the file, from options */
typedef struct {
  PetscBool framed, east, up; /* an option gives the axes; the first is east; the last is upward */
  PetscReal unit;             /* unit [m] */
  PetscBool known;            /* an option gives the unit */
} Ways;

/* Converts the file's vertices to metres north, east and down, and checks that they can be that. */
static PetscErrorCode TakeVertices(const char source[], const Ways *ways, PetscBool gmsh, SlipFaultMeshFile *m)
{
  static const char *const name[] = {"x", "y", "z"};
  static const PetscReal limit[] = {MESH_MAX_REACH, MESH_MAX_REACH, MESH_MAX_DEPTH};
  const PetscBool east = ways->framed ? ways->east : gmsh, up = ways->framed ? ways->up : gmsh;

  PetscFunctionBegin;
  m->upward = up;
  for (PetscInt i = 0; i < m->nvertices; i++) {
    PetscReal *v = m->vertex + 3 * (size_t)i;

    for (int k = 0; k < 3; k++) {
      v[k] *= ways->unit;
      PetscCheck(PetscAbsReal(v[k]) <= limit[k], PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
                 "%s: vertex %" PetscInt_FMT " has %s = %.6g m, expected a number of metres of a fault, at most %.6g",
                 source, m->vertex_number ? m->vertex_number[i] : i, name[k], (double)v[k], (double)limit[k]);
    }
    if (east) {
      const PetscReal x = v[0];

      v[0] = v[1];
      v[1] = x;
    }
    if (up) v[2] = 0 - v[2];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads /cells and its attributes; the shape determines what the columns are. */
static PetscErrorCode ReadCells(SlipH5 *h, SlipFaultMeshFile *m)
{
  const char *names;
  PetscInt want[2] = {-1, MESH_VERTICAL_COLUMNS}, dims[2];
  char columns[128];
  PetscBool has, same;

  PetscFunctionBegin;
  PetscCall(SlipH5Has(h, MESH_DATASET, &has));
  if (has) {
    PetscCall(SlipH5CheckAttributes(h, MESH_DATASET, "columns units"));
    PetscCall(SlipH5CheckUnits(h, MESH_DATASET, "m", &m->metres));
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
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads integers that have a limit. */
static PetscErrorCode ReadWhole(SlipH5 *h, const char path[], PetscInt ndim, const PetscInt want[], const char shape[],
                                const char what[], PetscInt dims[], PetscInt **whole)
{
  PetscReal *number;
  size_t n = 1;

  PetscFunctionBegin;
  PetscCall(SlipH5ReadRealSized(h, path, ndim, want, shape, dims, &number));
  for (PetscInt k = 0; k < ndim; k++) n *= (size_t)dims[k];
  PetscCall(PetscMalloc1(n, whole));
  for (size_t i = 0; i < n; i++) {
    const size_t row = ndim > 1 ? i / (size_t)dims[1] : i;

    PetscCheck(number[i] == PetscFloorReal(number[i]) && PetscAbsReal(number[i]) <= MESH_MAX_LABEL, PETSC_COMM_SELF,
               PETSC_ERR_FILE_UNEXPECTED, "%s%s: row %zu of %s is %g, expected %s, a whole number of at most %g",
               h->name, h->source, row, path, (double)number[i], what, MESH_MAX_LABEL);
    (*whole)[i] = (PetscInt)number[i];
  }
  PetscCall(PetscFree(number));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadTriangles(SlipH5 *h, SlipFaultMeshFile *m)
{
  const PetscInt want[2] = {-1, 3};
  PetscInt dims[2];
  PetscBool has;

  PetscFunctionBegin;
  PetscCall(SlipH5CheckAttributes(h, MESH_VERTICES, "columns units"));
  PetscCall(SlipH5CheckUnits(h, MESH_VERTICES, "m", &m->metres));
  PetscCall(SlipH5CheckAttributes(h, MESH_TRIANGLES, "units"));
  PetscCall(SlipH5CheckUnits(h, MESH_TRIANGLES, "", &has));
  PetscCall(SlipH5ReadRealSized(h, MESH_VERTICES, 2, want, "with the columns x y z", dims, &m->vertex));
  m->nvertices = dims[0];
  m->sides = 3;
  PetscCall(ReadWhole(h, MESH_TRIANGLES, 2, want, "three numbers of rows of " MESH_VERTICES " for each", "a vertex",
                      dims, &m->corner));
  m->n = dims[0];
  PetscCheck(m->n > 0, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
             MESH_TRIANGLES " in %s has no rows, expected one for each cell%s", h->name, h->source);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadLabels(SlipH5 *h, SlipFaultMeshFile *m)
{
  PetscInt dims[1];
  PetscBool has;

  PetscFunctionBegin;
  PetscCall(SlipH5Has(h, MESH_LABELS, &has));
  if (!has) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipH5CheckAttributes(h, MESH_LABELS, "units names"));
  PetscCall(SlipH5CheckUnits(h, MESH_LABELS, "", &has));
  PetscCall(
    ReadWhole(h, MESH_LABELS, 1, &m->n,
              m->triangles ? "one label for each row of " MESH_TRIANGLES : "one label for each row of " MESH_DATASET,
              "the fault's label", dims, &m->label));
  PetscCall(SlipH5HasAttribute(h, MESH_LABELS, "names", &has));
  if (!has) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscCalloc1(MESH_MAX_NAMES, &m->names));
  PetscCall(SlipH5ReadAttrString(h, MESH_LABELS, "names", m->names, MESH_MAX_NAMES));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds out from its first words or its name whether it is a file of Gmsh. */
static PetscErrorCode IsGmsh(const char name[], PetscBool *gmsh)
{
  static const char begin[] = "$MeshFormat";
  char text[sizeof(begin)] = "";
  FILE *file = fopen(name, "rb");
  size_t got = 0;

  PetscFunctionBegin;
  PetscCall(PetscStrendswith(name, ".msh", gmsh));
  if (!file) PetscFunctionReturn(PETSC_SUCCESS);
  got = fread(text, 1, sizeof(begin) - 1, file);
  (void)fclose(file);
  if (got == sizeof(begin) - 1 && !strcmp(text, begin)) *gmsh = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Refuses files of other kinds, and names the script that converts them. */
static PetscErrorCode CheckHDF5(const char name[], const char source[])
{
  const char *dot = strrchr(name, '.'), *slash = strrchr(name, '/');
  const int stem = (int)(dot && (!slash || dot > slash) ? (size_t)(dot - name) : strlen(name));
  FILE *file = fopen(name, "rb");
  PetscBool h5;
  SlipH5 quiet;

  PetscFunctionBegin;
  if (!file) PetscFunctionReturn(PETSC_SUCCESS); /* opening it prints the error */
  (void)fclose(file);
  PetscCall(SlipH5Clear(NULL, NULL, &quiet)); /* otherwise HDF5 prints errors for folders */
  PetscCall(PetscStrendswith(name, ".h5", &h5));
  PetscCheck(h5 || H5Fis_hdf5(name) > 0, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
             "%s is not an HDF5 file, nor .msh of Gmsh: STL, GOCAD .ts, RSQSim .flt and others are converted by "
             "convert_mesh.py %s %.*s.h5",
             source, name, stem, name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultMeshRead(const SlipFaultMeshOptions *o, SlipFaultMeshFile *m)
{
  static const char *const column[] = {"x", "y", "z", "length", "width"};
  static const PetscReal limit[] = {MESH_MAX_REACH, MESH_MAX_REACH, MESH_MAX_DEPTH, MESH_MAX_REACH, MESH_MAX_DEPTH};
  const char *name = o->file, *prefix = o->prefix;
  char source[PETSC_MAX_PATH_LEN + 64];
  PetscBool gmsh, cells, vertices;
  Ways ways;
  SlipH5 h;

  PetscFunctionBegin;
  *m = (SlipFaultMeshFile){.n = 0};
  (void)snprintf(source, sizeof(source), "%s (-%sfault_mesh)", name, prefix);
  ways.framed = strcmp(o->frame, "auto") ? PETSC_TRUE : PETSC_FALSE;
  ways.east = o->frame[0] == 'e' ? PETSC_TRUE : PETSC_FALSE; /* enu, end */
  ways.up = strcmp(o->frame, "enu") ? PETSC_FALSE : PETSC_TRUE;
  ways.unit = strcmp(o->unit, "km") ? 1 : 1000;
  ways.known = strcmp(o->unit, "auto") ? PETSC_TRUE : PETSC_FALSE;
  PetscCall(IsGmsh(name, &gmsh));
  if (gmsh)
    PetscCall(SlipFaultMeshReadGmsh(name, source, m));
  else {
    PetscCall(CheckHDF5(name, source));
    PetscCall(SlipH5OpenReadOption(o->prefix, "fault_mesh", o->file, &h));
    PetscCall(SlipH5Has(&h, MESH_TRIANGLES, &m->triangles));
    PetscCall(SlipH5Has(&h, MESH_VERTICES, &vertices));
    PetscCall(SlipH5Has(&h, MESH_DATASET, &cells));
    PetscCheck(vertices == m->triangles, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
               "%s%s holds %s but no %s, expected both", h.name, h.source, vertices ? MESH_VERTICES : MESH_TRIANGLES,
               vertices ? MESH_TRIANGLES : MESH_VERTICES);
    PetscCheck(!cells || !m->triangles, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
               "%s%s holds " MESH_DATASET " and " MESH_TRIANGLES ", expected rectangles or triangles", h.name,
               h.source);
    if (cells || m->triangles) PetscCall(SlipH5CheckNames(&h, o->fields));
    PetscCall((m->triangles ? ReadTriangles : ReadCells)(&h, m));
    PetscCall(ReadLabels(&h, m));
    PetscCall(SlipH5Close(&h));
  }
  if (m->sides) {
    PetscCall(SlipFaultMeshUseVertices(source, m));
    PetscCall(TakeVertices(source, &ways, gmsh, m));
  } else {
    PetscCheck(!ways.east, PETSC_COMM_SELF, PETSC_ERR_ARG_INCOMP,
               "%s holds " MESH_DATASET ", whose frame is x north, y east, z down: expected -%sfault_mesh_frame ned",
               source, prefix);
    for (PetscInt i = 0; i < m->n && ways.unit != 1; i++)
      for (PetscInt k = 0; k < MESH_VERTICAL_COLUMNS; k++) m->rows[(size_t)i * m->columns + k] *= ways.unit;
    for (PetscInt i = 0; i < m->n; i++) /* SlipCellsCheck() refuses cells for which no stiffness can be computed */
      for (PetscInt k = 0; k < MESH_VERTICAL_COLUMNS; k++) {
        const PetscReal number = m->rows[(size_t)i * m->columns + k];

        PetscCheck(!(PetscAbsReal(number) > limit[k]), PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
                   "%s: row %" PetscInt_FMT " of " MESH_DATASET
                   " has %s = %.6g, expected metres of a fault, at most %.6g",
                   source, i, column[k], (double)number, (double)limit[k]);
      }
  }
  PetscCall(SlipFaultMeshCheckUnit(prefix, source, m->metres || ways.known ? PETSC_TRUE : PETSC_FALSE, ways.framed, m));
  if (m->sides == 4) PetscCall(SlipFaultMeshRectangles(source, m));
  if (!m->triangles) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipFaultTrianglesCheck(source, o->triangles.full_space, m));
  PetscCall(SlipFaultTrianglesOrient(source, m));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultMeshFileDestroy(SlipFaultMeshFile *m)
{
  PetscFunctionBegin;
  PetscCall(PetscFree(m->rows));
  PetscCall(PetscFree(m->vertex));
  PetscCall(PetscFree(m->corner));
  PetscCall(PetscFree(m->number));
  PetscCall(PetscFree(m->label));
  PetscCall(PetscFree(m->vertex_number));
  PetscCall(PetscFree(m->names));
  PetscFunctionReturn(PETSC_SUCCESS);
}
