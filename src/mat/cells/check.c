/* What cells of an irregular mesh may not be: above the ground, or more in each other than edges are. */
#include <slipsys.h>
#include <slipstep/private/slipelasticity.h>
#include <slipstep/private/slipmatcells.h>
#include <math.h>

/* So far, as a share of the smaller cell's smaller side, may a cell reach beyond the line in which it meets another one's plane:
   what strikes and dips of two decimals leave is ten times less. */
#define CROSS_TOUCH 1e-3
#define CHECK_LEAF 16 /* cells in a leaf of the tree that is searched for neighbours */

static PetscErrorCode CheckRow(MPI_Comm comm, const SlipCells *c, PetscInt i, const char source[])
{
  const SlipCell cell = SlipCellsGet(c, i);
  const SlipDippingRectangle *r = &cell.rectangle;
  const PetscReal value[8] = {r->x, r->y, r->z, r->length, r->width, r->strike, r->dip, cell.rake};
  static const char *const name[8] = {"x", "y", "z", "length", "width", "strike", "dip", "rake"};
  static const char *const unit[8] = {"m", "m", "m", "m", "m", "degrees", "degrees", "degrees"};
  PetscReal sine, cosine;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < 8; k++) {
    PetscCheck(isfinite(value[k]), comm, PETSC_ERR_ARG_OUTOFRANGE,
               "%s: row %" PetscInt_FMT " has %s = %.6g %s, expected a finite number", source, i, name[k],
               (double)value[k], unit[k]);
    PetscCheck(k < 3 || k > 4 || value[k] > 0, comm, PETSC_ERR_ARG_OUTOFRANGE,
               "%s: row %" PetscInt_FMT " has %s = %.6g m, expected > 0", source, i, name[k], (double)value[k]);
  }
  PetscCheck(PetscAbsReal(r->strike) <= 360, comm, PETSC_ERR_ARG_OUTOFRANGE,
             "%s: row %" PetscInt_FMT " has strike = %.6g degrees, expected -360 to 360", source, i, (double)r->strike);
  PetscCheck(r->dip > 0 && r->dip <= 90, comm, PETSC_ERR_ARG_OUTOFRANGE,
             "%s: row %" PetscInt_FMT " has dip = %.6g degrees, expected > 0 and at most 90", source, i,
             (double)r->dip);
  SlipDegrees(r->dip, &sine, &cosine);
  PetscCheck(c->kernel.full_space || r->z - 0.5 * r->width * sine >= -SLIP_TOUCH * PetscMin(r->length, r->width), comm,
             PETSC_ERR_ARG_OUTOFRANGE,
             "%s: the cell of row %" PetscInt_FMT
             " reaches above the surface: its centre at depth %.6g m, its width %.6g m, its dip %.6g degrees",
             source, i, (double)r->z, (double)r->width, (double)r->dip);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- two cells ---- */

/* A cell as a rectangle in space */
typedef struct {
  PetscReal at[3];                 /* its centre from that of the first one [m] */
  PetscReal side[2][3], across[3]; /* directions along strike and dip, and across */
  PetscReal half[2];               /* of its extents [m] */
} Plate;

static PetscReal Dot(const PetscReal a[3], const PetscReal b[3])
{
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static Plate PlateOf(const SlipCells *c, PetscInt i, PetscInt from)
{
  Plate p = {{c->x[i] - c->x[from], c->y[i] - c->y[from], c->z[i] - c->z[from]},
             {{1, 0, 0}, {0, 0, -1}},
             {0, 1, 0},
             {0.5 * c->length[i], 0.5 * c->width[i]}};
  PetscReal d[9];

  if (!c->strike && !c->dip) return p;
  SlipPlaneDirections(c->strike ? c->strike[i] : 0, c->dip ? c->dip[i] : 90, 0, d);
  for (int k = 0; k < 3; k++) {
    p.side[0][k] = d[k];
    p.side[1][k] = d[3 + k];
    p.across[k] = d[6 + k];
  }
  return p;
}

/* Half of its extent in a direction */
static PetscReal Extent(const Plate *p, const PetscReal u[3])
{
  return p->half[0] * PetscAbsReal(Dot(p->side[0], u)) + p->half[1] * PetscAbsReal(Dot(p->side[1], u));
}

/* Is all of p in the plane of q? */
static PetscBool Lies(const Plate *p, const Plate *q, PetscReal touch)
{
  const PetscReal between[3] = {p->at[0] - q->at[0], p->at[1] - q->at[1], p->at[2] - q->at[2]};

  return PetscAbsReal(Dot(between, q->across)) + Extent(p, q->across) <= touch ? PETSC_TRUE : PETSC_FALSE;
}

/* In one plane: do they share more than an edge, seen along all of their sides? */
static PetscBool Overlap(const Plate *p, const Plate *q, PetscReal touch)
{
  const PetscReal between[3] = {p->at[0] - q->at[0], p->at[1] - q->at[1], p->at[2] - q->at[2]};

  for (int k = 0; k < 4; k++) {
    const PetscReal *u = k < 2 ? p->side[k] : q->side[k - 2];

    if (!(PetscAbsReal(Dot(between, u)) < Extent(p, u) + Extent(q, u) - touch)) return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

/* The ends of the line in which p meets the plane of q, where p reaches further than deep to both sides of that line */
static PetscBool Chord(const Plate *p, const Plate *q, PetscReal deep, PetscReal ends[2][3])
{
  const PetscReal slope[2] = {Dot(p->side[0], q->across), Dot(p->side[1], q->across)};
  const PetscReal steep = PetscSqrtReal(PetscSqr(slope[0]) + PetscSqr(slope[1])); /* the sine of the angle between */
  const PetscReal height = Dot(p->at, q->across) - Dot(q->at, q->across), reach = Extent(p, q->across);
  PetscReal foot[2], along[2], low = PETSC_MIN_REAL, top = PETSC_MAX_REAL;

  if (PetscAbsReal(height) >= reach - deep * steep) return PETSC_FALSE;
  for (int k = 0; k < 2; k++) {
    foot[k] = -height * slope[k] / PetscSqr(steep);
    along[k] = (k ? 1 : -1) * slope[1 - k] / steep;
  }
  for (int k = 0; k < 2; k++) {
    if (along[k] == 0) continue;
    low = PetscMax(low, -foot[k] / along[k] - p->half[k] / PetscAbsReal(along[k]));
    top = PetscMin(top, -foot[k] / along[k] + p->half[k] / PetscAbsReal(along[k]));
  }
  for (int e = 0; e < 2; e++)
    for (int i = 0; i < 3; i++)
      ends[e][i] = p->at[i] + (foot[0] + (e ? top : low) * along[0]) * p->side[0][i] +
                   (foot[1] + (e ? top : low) * along[1]) * p->side[1][i];
  return low < top ? PETSC_TRUE : PETSC_FALSE;
}

/* Do the lines in which each meets the other one's plane, which are one, have a part in common? */
static PetscBool Cross(const Plate *p, const Plate *q, PetscReal deep)
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
  PetscReal *half; /* of each cell's box, three */
  PetscReal near;  /* boxes this far apart hold no cells that overlap */
  PetscInt rows[2];
  PetscBool cross;
} Search;

static PetscBool Apart(const Search *s, PetscInt i, PetscInt j)
{
  const PetscReal d[3] = {s->c->x[i] - s->c->x[j], s->c->y[i] - s->c->y[j], s->c->z[i] - s->c->z[j]};

  for (int k = 0; k < 3; k++)
    if (PetscAbsReal(d[k]) > s->half[3 * i + k] + s->half[3 * j + k] + s->near) return PETSC_TRUE;
  return PETSC_FALSE;
}

static void TryPair(Search *s, PetscInt i, PetscInt j)
{
  const SlipCells *c = s->c;
  const PetscReal side = PetscMin(PetscMin(c->length[i], c->width[i]), PetscMin(c->length[j], c->width[j]));
  const PetscReal touch = SLIP_TOUCH * side;
  Plate p, q;
  PetscBool one;

  if (Apart(s, i, j)) return;
  p = PlateOf(c, i, i);
  q = PlateOf(c, j, i);
  one =
    Lies(&p, &q, touch) || Lies(&q, &p, touch) ? PETSC_TRUE : PETSC_FALSE; /* whose line of intersection is rounding */
  if (one ? !Overlap(&p, &q, touch) : !Cross(&p, &q, CROSS_TOUCH * side)) return;
  s->rows[0] = PetscMin(i, j);
  s->rows[1] = PetscMax(i, j);
  s->cross = (PetscBool)!one;
}

/* The pairs of cells of two clusters, or of one */
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

/* Two rows that overlap or cross, the first that a tree of the cells leads to; -1 when none do */
static PetscErrorCode FindMeeting(const SlipCells *c, PetscInt rows[2], PetscBool *cross)
{
  Search s = {.c = c, .rows = {-1, -1}};

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(3 * (size_t)c->n, &s.half));
  for (PetscInt i = 0; i < c->n; i++) {
    SlipCellsReach(c, i, s.half + 3 * i);
    s.near = PetscMax(s.near, SLIP_TOUCH * PetscMin(c->length[i], c->width[i]));
  }
  PetscCall(SlipClusterTreeCreate(c, CHECK_LEAF, &s.tree));
  TryClusters(&s, 0, 0);
  PetscCall(SlipClusterTreeDestroy(&s.tree));
  PetscCall(PetscFree(s.half));
  rows[0] = s.rows[0];
  rows[1] = s.rows[1];
  *cross = s.cross;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipCellsCheck - refuse a mesh that no stiffness can be computed for

  Not collective, but every process of comm must pass the same cells

  Input Parameters:
+ comm   - communicator of the error messages
. cells  - the cells
- source - where they come from, for the messages

  Note: cells may touch along edges, at any angle, and the edge of one may end inside of another one, as where faults branch

  Errors: PETSC_ERR_ARG_OUTOFRANGE for no cells, rows (counted from 0) with numbers that are not finite, extents that
  are not positive, strikes outside of [-360, 360] and dips outside of (0, 90] degrees, cells above the surface, pairs of rows that
  overlap on one plane or cross; those of SlipKernelCheck()

  Level: intermediate

.seealso: MatCreateSlipCellStiffness()
@*/
PetscErrorCode SlipCellsCheck(MPI_Comm comm, const SlipCells *c, const char source[])
{
  PetscInt rows[2];
  PetscBool cross;

  PetscFunctionBegin;
  PetscCheck(c->n > 0, comm, PETSC_ERR_ARG_OUTOFRANGE, "%s: a mesh needs at least one cell, not %" PetscInt_FMT, source,
             c->n);
  PetscCall(SlipKernelCheck(comm, &c->kernel));
  for (PetscInt i = 0; i < c->n; i++) PetscCall(CheckRow(comm, c, i, source));
  PetscCall(FindMeeting(c, rows, &cross));
  PetscCheck(rows[0] < 0 || cross, comm, PETSC_ERR_ARG_OUTOFRANGE,
             "%s: the cells of rows %" PetscInt_FMT " and %" PetscInt_FMT " overlap", source, rows[0], rows[1]);
  PetscCheck(rows[0] < 0, comm, PETSC_ERR_ARG_OUTOFRANGE,
             "%s: the cells of rows %" PetscInt_FMT " and %" PetscInt_FMT
             " cross: planes that cross must be cut at their line of intersection, so that cells end there",
             source, rows[0], rows[1]);
  PetscFunctionReturn(PETSC_SUCCESS);
}
