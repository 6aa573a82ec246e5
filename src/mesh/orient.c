/*
  Chooses which side of a surface of triangles is the hanging wall. Normals agree across every edge that two triangles
  of one fault share, so that a surface which passes through the vertical has one hanging wall, and the mean normal of
  the surface, weighted by area, points upward. At edges of three or more triangles faults branch: each of the surfaces
  there is oriented by itself.
*/
#include <slipstep/private/slipmesh.h>
#include <slipstep/private/slipelasticity.h>

/* Smallest angle between two triangles at an edge [deg]. Below it the surface is folded back on itself: centres would
   be a hundredth of a cell from each other, and the rows of K nearly equal. */
#define FOLD 1.0
/* Without labels each connected piece is a fault. More pieces than this are parts of one fault, as in files whose
   triangles share no vertices. */
#define MOST_PIECES 21
/* A surface whose mean is vertical, or strikes north, within this angle [rad] counts as such in the choice of the
   hanging wall: the error of coordinates in single precision is smaller. */
#define VERTICAL 1e-3

typedef struct {
  PetscInt low, top, triangle; /* vertices, ascending */
  PetscBool forward;           /* the triangle goes from low to top */
} Edge;

/* Returns the corner after e around its triangle. */
static PetscInt Next(PetscInt e)
{
  return e - e % 3 + (e + 1) % 3;
}

/* Finds the sides of all triangles, ascending by low, top and triangle: distributes them by low, and sorts the few of
   each vertex. qsort() would take twice the memory. */
static PetscErrorCode Edges(const SlipFaultMeshFile *m, Edge edge[])
{
  PetscInt *end; /* one past the sides of each low vertex so far */
  PetscInt first = 0;

  PetscFunctionBegin;
  PetscCall(PetscCalloc1(m->nvertices + 1, &end));
  for (PetscInt e = 0; e < 3 * m->n; e++) end[PetscMin(m->corner[e], m->corner[Next(e)]) + 1]++;
  for (PetscInt v = 0; v < m->nvertices; v++) end[v + 1] += end[v];
  for (PetscInt e = 0; e < 3 * m->n; e++) {
    const PetscInt a = m->corner[e], b = m->corner[Next(e)];

    edge[end[PetscMin(a, b)]++] = (Edge){PetscMin(a, b), PetscMax(a, b), e / 3, a < b ? PETSC_TRUE : PETSC_FALSE};
  }
  for (PetscInt v = 0; v < m->nvertices; first = end[v++])
    for (PetscInt i = first + 1; i < end[v]; i++) {
      const Edge own = edge[i];
      PetscInt k = i;

      for (; k > first && edge[k - 1].top > own.top; k--) edge[k] = edge[k - 1];
      edge[k] = own;
    }
  PetscCall(PetscFree(end));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static const PetscReal *Vertex(const SlipFaultMeshFile *m, PetscInt v)
{
  return m->vertex + 3 * (size_t)v;
}

static PetscInt Number(const SlipFaultMeshFile *m, PetscInt i)
{
  return m->number ? m->number[i] : i;
}

static PetscReal Dot(const PetscReal a[3], const PetscReal b[3])
{
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Returns one past the last triangle at edge k. */
static PetscInt End(const SlipFaultMeshFile *m, const Edge edge[], PetscInt k)
{
  PetscInt end = k;

  while (end < 3 * m->n && edge[end].low == edge[k].low && edge[end].top == edge[k].top) end++;
  return end;
}

/* ---- folds ---- */

/* Computes the unit vector in the triangle across the edge towards its third vertex. */
static void Inward(const SlipFaultMeshFile *m, const Edge *e, PetscReal u[3])
{
  const PetscInt *c = m->corner + 3 * (size_t)e->triangle;
  const PetscReal *from = Vertex(m, e->low), *to = Vertex(m, e->top), *third = from;
  PetscReal along[3], length2, share;

  for (int k = 0; k < 3; k++)
    if (c[k] != e->low && c[k] != e->top) third = Vertex(m, c[k]);
  for (int k = 0; k < 3; k++) {
    along[k] = to[k] - from[k];
    u[k] = third[k] - from[k];
  }
  length2 = Dot(along, along);
  share = Dot(u, along) / length2;
  for (int k = 0; k < 3; k++) u[k] -= share * along[k];
  length2 = Dot(u, u);
  for (int k = 0; k < 3; k++) u[k] /= PetscSqrtReal(length2);
}

static PetscErrorCode CheckFolds(const char source[], const SlipFaultMeshFile *m, const Edge edge[])
{
  PetscFunctionBegin;
  for (PetscInt first = 0, end; first < 3 * m->n; first = end) {
    end = End(m, edge, first);
    for (PetscInt i = first; i < end; i++)
      for (PetscInt j = i + 1; j < end; j++) {
        PetscReal u[3], v[3], angle;

        Inward(m, &edge[i], u);
        Inward(m, &edge[j], v);
        for (int k = 0; k < 3; k++) v[k] -= u[k];
        angle = 2 * PetscAsinReal(PetscMin(1, 0.5 * PetscSqrtReal(Dot(v, v)))) * 180 / PETSC_PI;
        PetscCheck(
          angle >= FOLD, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
          "%s: triangles %" PetscInt_FMT " and %" PetscInt_FMT
          " share an edge with an angle of %.3g degrees between them, expected at least %.3g: one is folded back on "
          "the other, which convert_mesh.py --repair undoes",
          source, Number(m, edge[i].triangle), Number(m, edge[j].triangle), (double)angle, FOLD);
      }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- surfaces ---- */

/* The triangle across side k of triangle i, [3 n], or -1, and whether the vertices of both go around in one sense */
typedef struct {
  PetscInt triangle;
  PetscBool same;
} Across;

/* Computes twice the area times the normal around which the vertices go. */
static void Normal(const SlipFaultMeshFile *m, PetscInt i, PetscReal normal[3])
{
  const PetscInt *c = m->corner + 3 * (size_t)i;
  const PetscReal *p = Vertex(m, c[0]), *q = Vertex(m, c[1]), *r = Vertex(m, c[2]);

  for (int k = 0; k < 3; k++) {
    const int x = (k + 1) % 3, y = (k + 2) % 3;

    normal[k] = (q[x] - p[x]) * (r[y] - p[y]) - (q[y] - p[y]) * (r[x] - p[x]);
  }
}

/* Finds the *n triangles of the surface of queue[0], turns them as the first one, and adds up their normals. turned
   [all]: -1 for triangles that are in no surface yet */
static PetscErrorCode Spread(const char source[], const SlipFaultMeshFile *m, const Across across[], PetscInt turned[],
                             PetscInt queue[], PetscInt *n, PetscReal sum[4])
{
  PetscFunctionBegin;
  *n = 1;
  turned[queue[0]] = 0;
  for (int k = 0; k < 4; k++) sum[k] = 0;
  for (PetscInt head = 0; head < *n; head++) {
    const PetscInt i = queue[head];
    PetscReal normal[3];

    Normal(m, i, normal);
    for (int k = 0; k < 3; k++) sum[k] += (turned[i] ? -1 : 1) * normal[k];
    sum[3] += PetscSqrtReal(Dot(normal, normal));
    for (int k = 0; k < 3; k++) {
      const Across *a = &across[3 * i + k];
      const PetscInt as = a->same ? turned[i] : 1 - turned[i];

      if (a->triangle < 0) continue;
      PetscCheck(
        turned[a->triangle] < 0 || turned[a->triangle] == as, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
        "%s: triangles %" PetscInt_FMT " and %" PetscInt_FMT
        " are of a surface with one side only, which has no hanging wall: expected one that can be oriented, or "
        "/fault with labels that cut it",
        source, Number(m, i), Number(m, a->triangle));
      if (turned[a->triangle] >= 0) continue;
      turned[a->triangle] = as;
      queue[(*n)++] = a->triangle;
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Orders corners so that they go around the normals into the hanging walls. */
static PetscErrorCode Orient(const char source[], SlipFaultMeshFile *m, const Across across[])
{
  PetscInt *turned, *queue;

  PetscFunctionBegin;
  PetscCall(PetscMalloc2(m->n, &turned, m->n, &queue));
  for (PetscInt i = 0; i < m->n; i++) turned[i] = -1;
  for (PetscInt first = 0; first < m->n; first++) {
    PetscReal sum[4], normal[3];
    PetscInt n, over;

    if (turned[first] >= 0) continue;
    queue[0] = first;
    PetscCall(Spread(source, m, across, turned, queue, &n, sum));
    /* the sum is 0 for a surface around the vertical, such as a ring of dikes: its first triangle decides */
    if (PetscSqrtReal(Dot(sum, sum)) < 1e-9 * sum[3]) Normal(m, first, sum);
    for (int k = 0; k < 3; k++) normal[k] = sum[k] / PetscSqrtReal(Dot(sum, sum));
    if (PetscAbsReal(normal[2]) < VERTICAL) normal[2] = 0;
    if (normal[2] == 0 && PetscAbsReal(normal[0]) < VERTICAL) normal[0] = 0;
    over = SlipHangingWall(normal) ? 0 : 1;
    for (PetscInt k = 0; k < n; k++) {
      PetscInt *c = m->corner + 3 * (size_t)queue[k], second = c[1];

      if (turned[queue[k]] == over) continue;
      c[1] = c[2];
      c[2] = second;
    }
  }
  PetscCall(PetscFree2(turned, queue));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- pieces ---- */

static PetscInt Root(PetscInt of[], PetscInt i)
{
  while (of[i] != i) i = of[i] = of[of[i]];
  return i;
}

/* Labels the pieces that edges connect, in the order of the file; if there are many, all are one fault. */
static PetscErrorCode LabelPieces(SlipFaultMeshFile *m, const Edge edge[])
{
  PetscInt *of, pieces = 0;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(m->n, &of));
  PetscCall(PetscMalloc1(m->n, &m->label));
  for (PetscInt i = 0; i < m->n; i++) of[i] = i;
  for (PetscInt k = 1; k < 3 * m->n; k++) {
    const Edge *a = &edge[k - 1], *b = &edge[k];
    PetscInt p, q;

    if (a->low != b->low || a->top != b->top) continue;
    p = Root(of, a->triangle);
    q = Root(of, b->triangle);
    of[PetscMax(p, q)] = PetscMin(p, q);
  }
  for (PetscInt i = 0; i < m->n; i++) { /* the root of a piece is its first triangle */
    const PetscInt root = Root(of, i);

    m->label[i] = root == i ? pieces++ : m->label[root];
  }
  if (pieces > MOST_PIECES) PetscCall(PetscArrayzero(m->label, m->n));
  PetscCall(PetscFree(of));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultTrianglesOrient(const char source[], SlipFaultMeshFile *m)
{
  Across *across;
  Edge *edge;
  PetscInt *filled;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(3 * (size_t)m->n, &edge));
  PetscCall(Edges(m, edge));
  PetscCall(CheckFolds(source, m, edge));
  PetscCall(PetscMalloc1(3 * (size_t)m->n, &across));
  PetscCall(PetscCalloc1(m->n, &filled));
  for (PetscInt first = 0, end; first < 3 * m->n; first = end) {
    const Edge *a = &edge[first], *b = a + 1;

    end = End(m, edge, first);
    if (end - first != 2 || (m->label && m->label[a->triangle] != m->label[b->triangle])) continue;
    for (int k = 0; k < 2; k++) {
      const Edge *own = k ? b : a, *other = k ? a : b;

      across[3 * own->triangle + filled[own->triangle]++] =
        (Across){other->triangle, a->forward != b->forward ? PETSC_TRUE : PETSC_FALSE};
    }
  }
  for (PetscInt i = 0; i < m->n; i++)
    while (filled[i] < 3) across[3 * i + filled[i]++] = (Across){-1, PETSC_TRUE};
  PetscCall(PetscFree(filled));
  PetscCall(Orient(source, m, across));
  PetscCall(PetscFree(across));
  if (!m->label) PetscCall(LabelPieces(m, edge));
  PetscCall(PetscFree(edge));
  PetscFunctionReturn(PETSC_SUCCESS);
}
