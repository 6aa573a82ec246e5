/* Converts quadrilaterals of a file that are rectangles with two level sides to rows of a list of cells. */
#include <slipstep/private/slipmesh.h>
#include <slipstep/rooms/slipelasticity.h>

/* Largest distance of a corner from that of a rectangle, over the shorter side: large coordinates in single precision
   are as accurate. Rows that overlap by more are refused later. */
#define RECTANGLE_ROUNDING 1e-4

static PetscReal Dot(const PetscReal a[3], const PetscReal b[3])
{
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Converts a quadrilateral with the corners p [4], in order around it, to a row. */
static PetscErrorCode Row(const char source[], PetscInt number, const PetscReal *const p[4],
                          PetscReal row[MESH_COLUMNS])
{
  PetscReal side[2][3], last[3], length[2], lean[2], triangle[9], angles[2] = {0, 0}, near;
  int level;

  PetscFunctionBegin;
  for (int k = 0; k < 3; k++) {
    row[k] = (p[0][k] + p[1][k] + p[2][k] + p[3][k]) / 4;
    side[0][k] = 0.5 * (p[1][k] - p[0][k] + p[2][k] - p[3][k]);
    side[1][k] = 0.5 * (p[3][k] - p[0][k] + p[2][k] - p[1][k]);
    last[k] = 0.5 * (p[0][k] + p[2][k] - p[1][k] - p[3][k]);
    for (int v = 0; v < 3; v++) triangle[3 * v + k] = p[v][k];
  }
  for (int s = 0; s < 2; s++) {
    length[s] = PetscSqrtReal(Dot(side[s], side[s]));
    lean[s] = PetscAbsReal(side[s][2]) / length[s];
  }
  near = RECTANGLE_ROUNDING * PetscMin(length[0], length[1]);
  PetscCheck(near > 0 && Dot(last, last) <= PetscSqr(near) &&
               PetscAbsReal(Dot(side[0], side[1])) <= near * PetscMax(length[0], length[1]),
             PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
             "%s: element %" PetscInt_FMT " is a quadrilateral but no rectangle, expected rectangles or triangles",
             source, number);
  level = lean[0] <= lean[1] ? 0 : 1;
  PetscCheck(lean[level] <= RECTANGLE_ROUNDING && lean[1 - level] > RECTANGLE_ROUNDING, PETSC_COMM_SELF,
             PETSC_ERR_FILE_UNEXPECTED,
             "%s: element %" PetscInt_FMT
             " is a rectangle %s, expected two sides along the strike and two that go down, or triangles",
             source, number, lean[1 - level] > RECTANGLE_ROUNDING ? "without level sides" : "that lies level");
  PetscCall(SlipTriangleDirections(triangle, NULL, angles, NULL));
  row[3] = length[level];
  row[4] = length[1 - level];
  row[5] = angles[0];
  row[6] = PetscMin(angles[1], 90);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultMeshRectangles(const char source[], SlipFaultMeshFile *m)
{
  PetscFunctionBegin;
  m->columns = MESH_COLUMNS;
  PetscCall(PetscMalloc1(MESH_COLUMNS * (size_t)m->n, &m->rows));
  for (PetscInt i = 0; i < m->n; i++) {
    const PetscReal *p[4];

    for (int k = 0; k < 4; k++) p[k] = m->vertex + 3 * (size_t)m->corner[4 * (size_t)i + k];
    PetscCall(Row(source, m->number ? m->number[i] : i, p, m->rows + MESH_COLUMNS * (size_t)i));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
