/*
  Checks the triangles of a file: it refuses bad triangles, removes unused vertices, merges vertices at one place, and
  refuses equal triangles. SlipCellsCheck() checks relations of cells that do not depend on their shape.
*/
#include <slipstep/private/slipmesh.h>
#include <slipstep/private/slipelasticity.h>
#include <stdlib.h>
#include <string.h>

/* Triangles with a smaller height, over their longest side, are refused. The stress of a cell's slip on itself is
   proportional to the reciprocal of its height: the largest entry of K, and with it the work of steps and solvers,
   would be a hundred times that of its neighbours, for a cell whose slip hardly matters. */
#define NEEDLE 0.01
/* Vertices that are nearer to each other, over the shortest side of any triangle, are merged: files with seven digits
   are as accurate. */
#define SAME_PLACE 1e-6

static PetscInt VertexNumber(const SlipFaultMeshFile *m, PetscInt v)
{
  return m->vertex_number ? m->vertex_number[v] : v;
}

static PetscInt Number(const SlipFaultMeshFile *m, PetscInt i)
{
  return m->number ? m->number[i] : i;
}

static PetscReal Distance(const SlipFaultMeshFile *m, PetscInt a, PetscInt b)
{
  const PetscReal *p = m->vertex + 3 * (size_t)a, *q = m->vertex + 3 * (size_t)b;

  return PetscSqrtReal(PetscSqr(p[0] - q[0]) + PetscSqr(p[1] - q[1]) + PetscSqr(p[2] - q[2]));
}

/* Leaves vertices v with place[v] == v, in order; replaces others by vertex place[v], or removes them if it is -1. */
static PetscErrorCode RemoveOtherVertices(SlipFaultMeshFile *m, PetscInt place[])
{
  PetscInt kept = 0, *to;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(PetscMax(m->nvertices, 1), &to));
  if (!m->vertex_number) {
    PetscCall(PetscMalloc1(PetscMax(m->nvertices, 1), &m->vertex_number));
    for (PetscInt v = 0; v < m->nvertices; v++) m->vertex_number[v] = v;
  }
  for (PetscInt v = 0; v < m->nvertices; v++) {
    if (place[v] != v) continue;
    for (int k = 0; k < 3; k++) m->vertex[3 * (size_t)kept + k] = m->vertex[3 * (size_t)v + k];
    m->vertex_number[kept] = m->vertex_number[v];
    to[v] = kept++;
  }
  for (size_t c = 0; c < (size_t)m->sides * (size_t)m->n; c++) m->corner[c] = to[place[m->corner[c]]];
  m->nvertices = kept;
  PetscCall(PetscFree(to));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Checks that corners are vertices, and removes vertices that are no corners. */
PetscErrorCode SlipFaultMeshUseVertices(const char source[], SlipFaultMeshFile *m)
{
  PetscInt *place;

  PetscFunctionBegin;
  for (size_t c = 0; c < (size_t)m->sides * (size_t)m->n; c++)
    PetscCheck(m->corner[c] >= 0 && m->corner[c] < m->nvertices, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
               "%s: triangle %" PetscInt_FMT " has the vertex %" PetscInt_FMT ", expected 0 to %" PetscInt_FMT, source,
               Number(m, (PetscInt)(c / (size_t)m->sides)), m->corner[c], m->nvertices - 1);
  PetscCall(PetscMalloc1(PetscMax(m->nvertices, 1), &place));
  for (PetscInt v = 0; v < m->nvertices; v++) place[v] = -1;
  for (size_t c = 0; c < (size_t)m->sides * (size_t)m->n; c++) place[m->corner[c]] = m->corner[c];
  PetscCall(RemoveOtherVertices(m, place));
  PetscCall(PetscFree(place));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- one by one ---- */

/* Checks each triangle; shortest is the shortest side of any [m]. */
static PetscErrorCode CheckEach(const char source[], PetscBool full_space, const SlipFaultMeshFile *m,
                                PetscReal *shortest)
{
  PetscFunctionBegin;
  *shortest = PETSC_MAX_REAL;
  for (PetscInt i = 0; i < m->n; i++) {
    const PetscInt *c = m->corner + 3 * (size_t)i, number = Number(m, i);
    PetscReal longest = 0, height;

    for (int k = 0; k < 3; k++) {
      const PetscInt a = c[k], b = c[(k + 1) % 3];
      const PetscReal side = Distance(m, a, b);

      PetscCheck(a != b, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
                 "%s: triangle %" PetscInt_FMT " has the vertex %" PetscInt_FMT " twice, expected three", source,
                 number, VertexNumber(m, a));
      PetscCheck(side > 0, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
                 "%s: vertices %" PetscInt_FMT " and %" PetscInt_FMT " of triangle %" PetscInt_FMT
                 " are in one place, expected a triangle with an area",
                 source, VertexNumber(m, a), VertexNumber(m, b), number);
      longest = PetscMax(longest, side);
      *shortest = PetscMin(*shortest, side);
    }
    {
      const PetscReal *p[3] = {m->vertex + 3 * (size_t)c[0], m->vertex + 3 * (size_t)c[1],
                               m->vertex + 3 * (size_t)c[2]};
      PetscReal normal[3];

      for (int k = 0; k < 3; k++) {
        const int x = (k + 1) % 3, y = (k + 2) % 3;

        normal[k] = (p[1][x] - p[0][x]) * (p[2][y] - p[0][y]) - (p[1][y] - p[0][y]) * (p[2][x] - p[0][x]);
      }
      height = PetscSqrtReal(PetscSqr(normal[0]) + PetscSqr(normal[1]) + PetscSqr(normal[2])) / longest;
    }
    PetscCheck(
      height >= NEEDLE * longest, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
      "%s: triangle %" PetscInt_FMT
      " is a needle, with a height of %.6g m on a side of %.6g m: expected at least %.3g of the side, as stress goes "
      "with its reciprocal. convert_mesh.py --repair takes such triangles away",
      source, number, (double)height, (double)longest, NEEDLE);
    for (int k = 0; k < 3; k++)
      PetscCheck(
        full_space || m->vertex[3 * (size_t)c[k] + 2] >= -SLIP_TOUCH * height, PETSC_COMM_SELF,
        PETSC_ERR_FILE_UNEXPECTED,
        "%s: vertex %" PetscInt_FMT " of triangle %" PetscInt_FMT
        " is %.6g m above the ground, expected below it or on it: convert_mesh.py --clip, --shift or --flatten "
        "brings topography there; if z is %s says so",
        source, VertexNumber(m, c[k]), number, (double)-m->vertex[3 * (size_t)c[k] + 2],
        m->upward ? "downward, -fault_mesh_frame end or ned" : "upward, -fault_mesh_frame enu");
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- vertices at one place ---- */

/* Merges vertices. Groups of vertices that are near along all axes are split until nothing changes; those near to the
   first of their group are replaced by it. */
static PetscErrorCode Merge(SlipFaultMeshFile *m, PetscReal near)
{
  const PetscInt n = m->nvertices;
  SlipFaultItem *item;
  PetscInt *place, groups = 0;

  PetscFunctionBegin;
  PetscCall(PetscMalloc2(n, &item, n, &place));
  for (PetscInt v = 0; v < n; v++) item[v] = (SlipFaultItem){0, 0, v};
  for (PetscInt before = -1; groups != before;) {
    before = groups;
    for (int k = 0; k < 3; k++) {
      for (PetscInt i = 0; i < n; i++) item[i].key = m->vertex[3 * (size_t)item[i].cell + k];
      SlipFaultSplit(n, item, near);
    }
    groups = item[n - 1].group;
  }
  for (PetscInt first = 0, end; first < n; first = end) {
    for (end = first; end < n && item[end].group == item[first].group; end++) place[item[end].cell] = item[end].cell;
    for (PetscInt i = first; i < end; i++)
      for (PetscInt j = i + 1; j < end && place[item[i].cell] == item[i].cell; j++) {
        PetscInt *of = &place[item[j].cell];

        if (*of == item[j].cell && Distance(m, item[i].cell, item[j].cell) <= near) *of = item[i].cell;
      }
  }
  PetscCall(RemoveOtherVertices(m, place));
  PetscCall(PetscFree2(item, place));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- equal triangles ---- */

typedef struct {
  PetscInt corner[3], triangle; /* ascending */
} Sorted;

static int CompareSorted(const void *a, const void *b)
{
  const Sorted *p = (const Sorted *)a, *q = (const Sorted *)b;

  for (int k = 0; k < 3; k++)
    if (p->corner[k] != q->corner[k]) return p->corner[k] < q->corner[k] ? -1 : 1;
  return p->triangle < q->triangle ? -1 : p->triangle > q->triangle;
}

PetscErrorCode SlipFaultTrianglesCheck(const char source[], PetscBool full_space, SlipFaultMeshFile *m)
{
  PetscReal shortest;
  Sorted *all;

  PetscFunctionBegin;
  PetscCall(CheckEach(source, full_space, m, &shortest));
  PetscCall(Merge(m, SAME_PLACE * shortest));
  PetscCall(PetscMalloc1(m->n, &all));
  for (PetscInt i = 0; i < m->n; i++) {
    PetscInt c[3];

    for (int k = 0; k < 3; k++) c[k] = m->corner[3 * (size_t)i + k];
    PetscCall(PetscSortInt(3, c));
    all[i] = (Sorted){{c[0], c[1], c[2]}, i};
  }
  qsort(all, (size_t)m->n, sizeof(*all), CompareSorted);
  for (PetscInt i = 1; i < m->n; i++)
    PetscCheck(memcmp(all[i].corner, all[i - 1].corner, sizeof(all[i].corner)), PETSC_COMM_SELF,
               PETSC_ERR_FILE_UNEXPECTED,
               "%s: triangles %" PetscInt_FMT " and %" PetscInt_FMT " have the same vertices, expected each once",
               source, Number(m, all[i - 1].triangle), Number(m, all[i].triangle));
  PetscCall(PetscFree(all));
  PetscFunctionReturn(PETSC_SUCCESS);
}
