/* Checks the cells of an irregular mesh: they must not be above the free surface, overlap, or cross each other. */
#include <slipstep/rooms/slipsys.h>
#include <slipstep/private/slipelasticity.h>
#include <slipstep/private/slipmatcells.h>
#include <math.h>

/* Largest extent of a cell beyond the line in which it meets another one's plane, over the smaller cell's smaller side:
   strikes and dips with two decimals cause a tenth of that. */
#define CROSS_TOUCH 1e-3
#define CHECK_LEAF 16 /* cells in a leaf of the search tree */

/* Returns the word for a cell in messages. */
static const char *CellWord(const SlipCells *c, PetscBool many)
{
  if (c->vertices) return many ? "triangles" : "triangle";
  return many ? "the cells of rows" : "row";
}

static PetscInt CellNumber(const SlipCells *c, PetscInt i)
{
  return c->number ? c->number[i] : i;
}

/* Returns a triangle's height over its longest side, or a rectangle's shorter side [m]. */
static PetscReal CellSide(const SlipCells *c, PetscInt i)
{
  PetscReal longest = 0;

  if (!c->vertices) return PetscMin(c->length[i], c->width[i]);
  for (int k = 0; k < 3; k++) {
    const PetscReal *a = c->vertices + 9 * (size_t)i + 3 * k, *b = c->vertices + 9 * (size_t)i + 3 * ((k + 1) % 3);

    longest = PetscMax(longest, PetscSqr(a[0] - b[0]) + PetscSqr(a[1] - b[1]) + PetscSqr(a[2] - b[2]));
  }
  return 2 * c->length[i] * c->width[i] / PetscSqrtReal(longest);
}

/* Checks the depth of a cell's lowest point, bottom [m]. */
static PetscErrorCode CheckBottom(MPI_Comm comm, const SlipCells *c, PetscInt i, PetscReal bottom, const char source[])
{
  PetscFunctionBegin;
  PetscCheck(c->kernel.full_space || bottom >= SLIP_GROUND * CellSide(c, i), comm, PETSC_ERR_ARG_OUTOFRANGE,
             "%s: %s %" PetscInt_FMT
             " lies on the ground, with its lowest point %.6g m deep, as in a mesh of two dimensions: expected cells "
             "that go down from there, or lie deeper",
             source, CellWord(c, PETSC_FALSE), CellNumber(c, i), (double)bottom);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode CheckRow(MPI_Comm comm, const SlipCells *c, PetscInt i, const char source[])
{
  const SlipCell cell = SlipCellsGet(c, i);
  const SlipDippingRectangle *r = &cell.rectangle;
  const PetscReal value[8] = {r->x, r->y, r->z, r->length, r->width, r->strike, r->dip, cell.rake};
  static const char *const name[8] = {"x", "y", "z", "length", "width", "strike", "dip", "rake"};
  static const char *const unit[8] = {"m", "m", "m", "m", "m", "degrees", "degrees", "degrees"};
  const char *word = CellWord(c, PETSC_FALSE);
  const PetscInt number = CellNumber(c, i);
  PetscReal sine, cosine, top = 0, bottom = PETSC_MIN_REAL;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < 8; k++) {
    PetscCheck(isfinite(value[k]), comm, PETSC_ERR_ARG_OUTOFRANGE,
               "%s: %s %" PetscInt_FMT " has %s = %.6g %s, expected a finite number", source, word, number, name[k],
               (double)value[k], unit[k]);
    PetscCheck(k < 3 || k > 4 || value[k] > 0, comm, PETSC_ERR_ARG_OUTOFRANGE,
               "%s: %s %" PetscInt_FMT " has %s = %.6g m, expected > 0", source, word, number, name[k],
               (double)value[k]);
  }
  PetscCheck(PetscAbsReal(r->strike) <= 360, comm, PETSC_ERR_ARG_OUTOFRANGE,
             "%s: %s %" PetscInt_FMT " has strike = %.6g degrees, expected -360 to 360", source, word, number,
             (double)r->strike);
  if (cell.vertices) {
    PetscCheck(r->dip >= 0 && r->dip <= 180, comm, PETSC_ERR_ARG_OUTOFRANGE,
               "%s: triangle %" PetscInt_FMT " has dip = %.6g degrees, expected 0 to 180", source, number,
               (double)r->dip);
    for (int k = 0; k < 9; k++)
      PetscCheck(isfinite(cell.vertices[k]), comm, PETSC_ERR_ARG_OUTOFRANGE,
                 "%s: a vertex of triangle %" PetscInt_FMT " has the coordinate %.6g m, expected a finite number",
                 source, number, (double)cell.vertices[k]);
    for (int k = 2; k < 9; k += 3) {
      top = PetscMin(top, cell.vertices[k]);
      bottom = PetscMax(bottom, cell.vertices[k]);
    }
    PetscCheck(c->kernel.full_space || top >= -SLIP_TOUCH * CellSide(c, i), comm, PETSC_ERR_ARG_OUTOFRANGE,
               "%s: triangle %" PetscInt_FMT " reaches above the surface: a vertex at depth %.6g m", source, number,
               (double)top);
    PetscCall(CheckBottom(comm, c, i, bottom, source));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCheck(r->dip > 0 && r->dip <= 90, comm, PETSC_ERR_ARG_OUTOFRANGE,
             "%s: row %" PetscInt_FMT " has dip = %.6g degrees, expected > 0 and at most 90", source, number,
             (double)r->dip);
  SlipDegrees(r->dip, &sine, &cosine);
  PetscCheck(c->kernel.full_space || r->z - 0.5 * r->width * sine >= -SLIP_TOUCH * PetscMin(r->length, r->width), comm,
             PETSC_ERR_ARG_OUTOFRANGE,
             "%s: the cell of row %" PetscInt_FMT
             " reaches above the surface: its centre at depth %.6g m, its width %.6g m, its dip %.6g degrees",
             source, number, (double)r->z, (double)r->width, (double)r->dip);
  PetscCall(CheckBottom(comm, c, i, r->z + 0.5 * r->width * sine, source));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- two cells ---- */

/* A cell as a convex polygon in space */
typedef struct {
  int n;                  /* corners, 3 or 4 */
  PetscReal corner[4][3]; /* corners in order around it, from the centre of the first cell [m] */
  PetscReal side[4][3];   /* directions in the plane across its edges, without opposite ones */
  int sides;
  PetscReal across[3];
} Polygon;

/* Least and largest coordinate along a direction */
typedef struct {
  PetscReal low, top;
} Span;

static PetscReal Dot(const PetscReal a[3], const PetscReal b[3])
{
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void CrossProduct(const PetscReal a[3], const PetscReal b[3], PetscReal c[3])
{
  for (int k = 0; k < 3; k++) c[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

static void Normalise(PetscReal v[3])
{
  const PetscReal length = PetscSqrtReal(Dot(v, v));

  for (int k = 0; k < 3; k++) v[k] /= length;
}

static Polygon TriangleOf(const SlipCells *c, PetscInt i, const PetscReal from[3])
{
  Polygon p = {.n = 3, .sides = 3};
  PetscReal edge[3][3];

  for (int k = 0; k < 9; k++) p.corner[k / 3][k % 3] = c->vertices[9 * (size_t)i + k] - from[k % 3];
  for (int k = 0; k < 9; k++) edge[k / 3][k % 3] = p.corner[(k / 3 + 1) % 3][k % 3] - p.corner[k / 3][k % 3];
  CrossProduct(edge[0], edge[1], p.across);
  Normalise(p.across);
  for (int e = 0; e < 3; e++) {
    CrossProduct(edge[e], p.across, p.side[e]);
    Normalise(p.side[e]);
  }
  return p;
}

static Polygon PolygonOf(const SlipCells *c, PetscInt i, PetscInt from)
{
  static const PetscReal share[4][2] = {{-0.5, -0.5}, {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}};
  const PetscReal origin[3] = {c->x[from], c->y[from], c->z[from]}, centre[3] = {c->x[i], c->y[i], c->z[i]};
  Polygon p = {.n = 4, .side = {{1, 0, 0}, {0, 0, -1}}, .sides = 2, .across = {0, 1, 0}};
  PetscReal d[9];

  if (c->vertices) return TriangleOf(c, i, origin);
  if (c->strike || c->dip) {
    SlipPlaneDirections(c->strike ? c->strike[i] : 0, c->dip ? c->dip[i] : 90, 0, d);
    for (int k = 0; k < 3; k++) {
      p.side[0][k] = d[k];
      p.side[1][k] = d[3 + k];
      p.across[k] = d[6 + k];
    }
  }
  for (int e = 0; e < 4; e++)
    for (int k = 0; k < 3; k++)
      p.corner[e][k] =
        centre[k] - origin[k] + share[e][0] * c->length[i] * p.side[0][k] + share[e][1] * c->width[i] * p.side[1][k];
  return p;
}

static Span SpanOf(const Polygon *p, const PetscReal u[3])
{
  Span s = {PETSC_MAX_REAL, PETSC_MIN_REAL};

  for (int e = 0; e < p->n; e++) {
    s.low = PetscMin(s.low, Dot(p->corner[e], u));
    s.top = PetscMax(s.top, Dot(p->corner[e], u));
  }
  return s;
}

/* Computes the heights of p's corners above the plane of q. */
static Span HeightsOf(const Polygon *p, const Polygon *q)
{
  const PetscReal plane = Dot(q->corner[0], q->across);
  Span s = SpanOf(p, q->across);

  s.low -= plane;
  s.top -= plane;
  return s;
}

/* Returns whether all of p is in the plane of q. */
static PetscBool Lies(const Polygon *p, const Polygon *q, PetscReal touch)
{
  const Span s = HeightsOf(p, q);

  return s.low >= -touch && s.top <= touch ? PETSC_TRUE : PETSC_FALSE;
}

/* Returns whether polygons in one plane share more than an edge, by their extents along all directions across sides. */
static PetscBool Overlap(const Polygon *p, const Polygon *q, PetscReal touch)
{
  for (int k = 0; k < p->sides + q->sides; k++) {
    const PetscReal *u = k < p->sides ? p->side[k] : q->side[k - p->sides];
    const Span a = SpanOf(p, u), b = SpanOf(q, u);

    if (!(a.top - b.low > touch && b.top - a.low > touch)) return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

/* Finds the ends of the line in which p meets the plane of q, if p extends further than deep to both sides of it. */
static PetscBool Chord(const Polygon *p, const Polygon *q, PetscReal deep, PetscReal ends[2][3])
{
  const PetscReal plane = Dot(q->corner[0], q->across);
  const Span heights = HeightsOf(p, q);
  PetscReal line[3];
  int n = 0;

  CrossProduct(p->across, q->across, line);
  deep *= PetscSqrtReal(Dot(line, line)); /* times the sine of the angle between the planes */
  if (heights.top <= deep || heights.low >= -deep) return PETSC_FALSE;
  for (int e = 0; e < p->n && n < 2; e++) {
    const PetscReal *a = p->corner[e], *b = p->corner[(e + 1) % p->n];
    const PetscReal from = Dot(a, q->across) - plane, to = Dot(b, q->across) - plane;

    if ((from > 0) == (to > 0)) continue;
    for (int k = 0; k < 3; k++) ends[n][k] = a[k] + from / (from - to) * (b[k] - a[k]);
    n++;
  }
  return n == 2 ? PETSC_TRUE : PETSC_FALSE;
}

/* Returns whether the parts of the line of intersection of both planes that are in p and in q overlap. */
static PetscBool Cross(const Polygon *p, const Polygon *q, PetscReal deep)
{
  PetscReal a[2][3], b[2][3], direction[3], length, from, to;

  if (!Chord(p, q, deep, a) || !Chord(q, p, deep, b)) return PETSC_FALSE;
  for (int i = 0; i < 3; i++) direction[i] = a[1][i] - a[0][i];
  length = PetscSqrtReal(Dot(direction, direction));
  from = (Dot(b[0], direction) - Dot(a[0], direction)) / length;
  to = (Dot(b[1], direction) - Dot(a[0], direction)) / length;
  return PetscMin(length, PetscMax(from, to)) - PetscMax(0, PetscMin(from, to)) > deep ? PETSC_TRUE : PETSC_FALSE;
}

/* ---- all of them ---- */

typedef struct {
  const SlipCells *c;
  SlipClusterTree tree;
  PetscReal *box; /* box of each cell */
  PetscReal near; /* cells in boxes that are this far apart do not overlap */
  PetscInt rows[2];
  PetscBool cross;
} Search;

static PetscBool Apart(const Search *s, PetscInt i, PetscInt j)
{
  const PetscReal *a = s->box + 6 * (size_t)i, *b = s->box + 6 * (size_t)j;

  for (int k = 0; k < 3; k++)
    if (a[k] - b[3 + k] > s->near || b[k] - a[3 + k] > s->near) return PETSC_TRUE;
  return PETSC_FALSE;
}

static void TryPair(Search *s, PetscInt i, PetscInt j)
{
  const PetscReal side = PetscMin(CellSide(s->c, i), CellSide(s->c, j)), touch = SLIP_TOUCH * side;
  Polygon p, q;
  PetscBool one;

  if (Apart(s, i, j)) return;
  p = PolygonOf(s->c, i, i);
  q = PolygonOf(s->c, j, i);
  one = Lies(&p, &q, touch) || Lies(&q, &p, touch) ? PETSC_TRUE : PETSC_FALSE; /* the line is only rounding */
  if (one ? !Overlap(&p, &q, touch) : !Cross(&p, &q, CROSS_TOUCH * side)) return;
  s->rows[0] = PetscMin(i, j);
  s->rows[1] = PetscMax(i, j);
  s->cross = (PetscBool)!one;
}

/* Checks the pairs of cells of two clusters, or of one. */
static void TryClusters(Search *s, PetscInt a, PetscInt b)
{
  const SlipCluster *p = &s->tree.node[a], *q = &s->tree.node[b];
  const PetscInt *perm = s->tree.perm;

  if (s->rows[0] >= 0 || SlipClusterDistance(p, q) > 2 * s->near) return;
  if (p->child[0] < 0 && q->child[0] < 0) {
    for (PetscInt i = p->start; i < p->end && s->rows[0] < 0; i++)
      for (PetscInt j = a == b ? i + 1 : q->start; j < q->end && s->rows[0] < 0; j++) TryPair(s, perm[i], perm[j]);
    return;
  }
  if (a == b) {
    TryClusters(s, p->child[0], p->child[0]);
    TryClusters(s, p->child[1], p->child[1]);
    TryClusters(s, p->child[0], p->child[1]);
    return;
  }
  for (int k = 0; k < 2; k++) {
    const PetscBool first = p->child[0] >= 0 && (q->child[0] < 0 || p->end - p->start >= q->end - q->start);

    TryClusters(s, first ? p->child[k] : a, first ? b : q->child[k]);
  }
}

/* Refuses a mesh for which no stiffness can be computed, on the first process of comm. source: the source of the cells,
   for messages. Cells may touch along edges, at any angle, and the edge of one may end inside of another one,
   as where faults branch. Errors: PETSC_ERR_ARG_OUTOFRANGE for no cells, rows (numbered from 0, or by cells->number)
   with numbers that are not finite, extents that are not positive, strikes outside of [-360, 360] and dips outside of
   (0, 90] degrees, of triangles [0, 180], cells above the surface, pairs of rows that overlap on one plane or cross;
   PETSC_ERR_ARG_INCOMP for a kernel of triangles without vertices and one of rectangles with them; those of
   SlipKernelCheck(). */
static PetscErrorCode Check(const SlipCells *c, const char source[])
{
  static const SlipKernelType *const ofRectangles[] = {&SlipKernelStrikeSlip, &SlipKernelMirror, &SlipKernelDipping,
                                                       &SlipKernelDippingVector, &SlipKernelDippingOpening};
  static const SlipKernelType *const ofTriangles[] = {&SlipKernelTriangle, &SlipKernelTriangleVector,
                                                      &SlipKernelTriangleOpening};
  const SlipKernelType *type = c->kernel.type;
  PetscBool other = PETSC_FALSE;
  const char *words = CellWord(c, PETSC_TRUE);
  PetscInt rows[2] = {-1, -1};
  Search s = {.c = c, .rows = {-1, -1}};
  PetscBool cross;

  PetscFunctionBegin;
  PetscCheck(c->n > 0, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
             "%s: a mesh needs at least one cell, not %" PetscInt_FMT, source, c->n);
  PetscCall(SlipKernelCheck(PETSC_COMM_SELF, &c->kernel));
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(ofRectangles) && c->vertices; k++)
    other = (PetscBool)(other || type == ofRectangles[k]);
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(ofTriangles) && !c->vertices; k++)
    other = (PetscBool)(other || type == ofTriangles[k]);
  PetscCheck(!other, PETSC_COMM_SELF, PETSC_ERR_ARG_INCOMP, "%s: kernel \"%s\" with %s, expected one for them", source,
             type->name, c->vertices ? "triangles" : "rectangles");
  for (PetscInt i = 0; i < c->n; i++) PetscCall(CheckRow(PETSC_COMM_SELF, c, i, source));
  PetscCall(PetscMalloc1(6 * (size_t)c->n, &s.box));
  for (PetscInt i = 0; i < c->n; i++) {
    SlipCellsBox(c, i, s.box + 6 * (size_t)i);
    s.near = PetscMax(s.near, SLIP_TOUCH * CellSide(c, i));
  }
  PetscCall(SlipClusterTreeCreate(c, CHECK_LEAF, &s.tree));
  TryClusters(&s, 0, 0);
  PetscCall(SlipClusterTreeDestroy(&s.tree));
  PetscCall(PetscFree(s.box));
  SlipMemoryReturn();
  rows[0] = s.rows[0];
  rows[1] = s.rows[1];
  cross = s.cross;
  if (rows[0] < 0) PetscFunctionReturn(PETSC_SUCCESS);
  for (int k = 0; k < 2; k++) rows[k] = CellNumber(c, rows[k]);
  PetscCheck(cross, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE, "%s: %s %" PetscInt_FMT " and %" PetscInt_FMT " overlap",
             source, words, rows[0], rows[1]);
  SETERRQ(PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
          "%s: %s %" PetscInt_FMT " and %" PetscInt_FMT
          " cross: planes that cross must be cut at their line of intersection, so that cells end there",
          source, words, rows[0], rows[1]);
}

/* Collective */
PetscErrorCode SlipCellsCheck(MPI_Comm comm, const SlipCells *c, const char source[])
{
  PetscMPIInt rank;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCall(SlipErrorBcast(comm, rank ? PETSC_SUCCESS : Check(c, source)));
  PetscFunctionReturn(PETSC_SUCCESS);
}
