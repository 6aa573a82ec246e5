/* Which cells are joined by sides, one body of fluid each; and which cells meet others without a common side, so that
   no fluid flows between them: faults that cross within their cells, or meet where their sides do not. */
#include <slipstep/private/slipfluid.h>
#include <math.h>
#include <slipstep/private/slipsys.h>

/* Distance below which points touch, over the shortest side of a cell, as in meet.c; cells that have less than ten
   times that in common touch at points */
#define TOUCH_ROUNDING 1e-3
#define PARALLEL 1e-6 /* sine of the angle between planes */

static PetscInt Root(PetscInt of[], PetscInt e)
{
  while (of[e] != e) e = of[e] = of[of[e]];
  return e;
}

typedef struct {
  PetscInt n;
  PetscReal x[4][3], normal[3], low[3], high[3], near;
} Flat;

static PetscReal Dot(const PetscReal a[3], const PetscReal b[3])
{
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void Cross(const PetscReal a[3], const PetscReal b[3], PetscReal c[3])
{
  for (int i = 0; i < 3; i++) c[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

static PetscReal Unit(PetscReal a[3])
{
  const PetscReal length = PetscSqrtReal(Dot(a, a));

  for (int i = 0; i < 3 && length > 0; i++) a[i] /= length;
  return length;
}

static void Shape(PetscInt n, const PetscReal points[], const PetscInt corners[], Flat *f)
{
  PetscReal side[2][3], shortest = PETSC_MAX_REAL;

  f->n = n;
  for (int i = 0; i < 3; i++) f->low[i] = PETSC_MAX_REAL, f->high[i] = -PETSC_MAX_REAL;
  for (PetscInt k = 0; k < n; k++)
    for (int i = 0; i < 3; i++) {
      f->x[k][i] = points[3 * (size_t)corners[k] + (size_t)i];
      f->low[i] = PetscMin(f->low[i], f->x[k][i]);
      f->high[i] = PetscMax(f->high[i], f->x[k][i]);
    }
  for (PetscInt k = 0; k < n; k++) {
    for (int i = 0; i < 3; i++) side[k % 2][i] = f->x[(k + 1) % n][i] - f->x[k][i];
    shortest = PetscMin(shortest, PetscSqrtReal(Dot(side[k % 2], side[k % 2])));
    if (k == 1) Cross(side[0], side[1], f->normal);
  }
  (void)Unit(f->normal);
  f->near = TOUCH_ROUNDING * shortest;
}

/* The part of a cell that is in the plane of another, along a direction in that plane; false: none */
static PetscBool InPlane(const Flat *a, const Flat *plane, PetscReal near, const PetscReal way[3], PetscReal part[2])
{
  PetscReal d[4], s[4];

  part[0] = PETSC_MAX_REAL;
  part[1] = -PETSC_MAX_REAL;
  for (PetscInt k = 0; k < a->n; k++) {
    PetscReal from[3];

    for (int i = 0; i < 3; i++) from[i] = a->x[k][i] - plane->x[0][i];
    d[k] = Dot(from, plane->normal);
    if (PetscAbsReal(d[k]) <= near) d[k] = 0;
    s[k] = Dot(from, way);
  }
  for (PetscInt k = 0; k < a->n; k++) {
    const PetscInt l = (k + 1) % a->n;
    PetscReal at;

    if (d[k] == 0)
      at = s[k];
    else if (d[k] * d[l] < 0)
      at = s[k] + (s[l] - s[k]) * d[k] / (d[k] - d[l]);
    else
      continue;
    part[0] = PetscMin(part[0], at);
    part[1] = PetscMax(part[1], at);
  }
  return part[1] >= part[0] ? PETSC_TRUE : PETSC_FALSE;
}

/* Whether two cells in one plane have sides on one line that overlap by more than a length */
static PetscBool SidesOverlap(const Flat *a, const Flat *b, PetscReal near, PetscReal length)
{
  for (PetscInt k = 0; k < a->n; k++) {
    PetscReal way[3], whole;

    for (int i = 0; i < 3; i++) way[i] = a->x[(k + 1) % a->n][i] - a->x[k][i];
    whole = Unit(way);
    for (PetscInt l = 0; l < b->n; l++) {
      PetscReal s[2];
      PetscBool on = PETSC_TRUE;

      for (int end = 0; end < 2; end++) {
        PetscReal from[3];

        for (int i = 0; i < 3; i++) from[i] = b->x[(l + end) % b->n][i] - a->x[k][i];
        s[end] = Dot(from, way);
        if (Dot(from, from) - PetscSqr(s[end]) > PetscSqr(near)) on = PETSC_FALSE;
      }
      if (on && PetscMin(PetscMax(s[0], s[1]), whole) - PetscMax(PetscMin(s[0], s[1]), 0) > length) return PETSC_TRUE;
    }
  }
  return PETSC_FALSE;
}

/* Whether two cells touch or cross along a line (Moeller 1997) */
static PetscBool Meets(const Flat *a, const Flat *b)
{
  const PetscReal near = PetscMin(a->near, b->near);
  PetscReal way[3], p[2], q[2], from[3], shift;

  for (int i = 0; i < 3; i++)
    if (a->low[i] > b->high[i] + near || b->low[i] > a->high[i] + near) return PETSC_FALSE;
  Cross(a->normal, b->normal, way);
  if (Unit(way) < PARALLEL) return SidesOverlap(a, b, near, 10 * near);
  if (!InPlane(a, b, near, way, p) || !InPlane(b, a, near, way, q)) return PETSC_FALSE;
  for (int i = 0; i < 3; i++) from[i] = a->x[0][i] - b->x[0][i];
  shift = Dot(from, way); /* p is measured from b, q from a */
  return PetscMin(p[1], q[1] + shift) - PetscMax(p[0], q[0] + shift) > 10 * near ? PETSC_TRUE : PETSC_FALSE;
}

static PetscBool Share(const SlipFluidWhole *w, PetscInt e, PetscInt g)
{
  for (PetscInt k = w->offset[e]; k < w->offset[e + 1]; k++)
    for (PetscInt l = w->offset[g]; l < w->offset[g + 1]; l++)
      if (w->piece[k] == w->piece[l]) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* Every process computes the same. corners [N][sides] by rows of the mesh; the pieces of w in its order */
PetscErrorCode SlipFluidBodiesFind(const SlipFaultMesh *mesh, const PetscReal points[], const PetscInt corners[],
                                   const SlipFluidWhole *w, SlipFluidBodies *out)
{
  const PetscInt N = mesh->N, ends = mesh->kind->sides;
  PetscInt *body, *first, *order, *met;
  PetscReal *low, from[3], to[3];
  Flat *cell;
  int way = 0;

  PetscFunctionBegin;
  *out = (SlipFluidBodies){0};
  PetscCall(PetscMalloc2(N, &body, w->pieces, &first));
  for (PetscInt p = 0; p < w->pieces; p++) first[p] = -1;
  for (PetscInt e = 0; e < N; e++) {
    body[e] = e;
    for (PetscInt k = w->offset[e]; k < w->offset[e + 1]; k++)
      if (first[w->piece[k]] < 0)
        first[w->piece[k]] = e;
      else
        body[Root(body, e)] = Root(body, first[w->piece[k]]);
  }
  for (PetscInt e = 0; e < N; e++) out->bodies += Root(body, e) == e;
  if (out->bodies > 1 || mesh->faults > 1) { /* pairs whose boxes overlap, in the order of their lower ends */
    PetscCall(PetscMalloc4(N, &cell, N, &low, N, &order, N, &met));
    for (int i = 0; i < 3; i++) from[i] = PETSC_MAX_REAL, to[i] = -PETSC_MAX_REAL;
    for (PetscInt e = 0; e < N; e++) {
      Shape(ends, points, corners + ends * (size_t)SlipFaultMeshRowOf(mesh, e), &cell[e]);
      for (int i = 0; i < 3; i++) {
        from[i] = PetscMin(from[i], cell[e].low[i]);
        to[i] = PetscMax(to[i], cell[e].high[i]);
      }
    }
    for (int i = 1; i < 3; i++)
      if (to[i] - from[i] > to[way] - from[way]) way = i;
    for (PetscInt e = 0; e < N; e++) {
      order[e] = e;
      met[e] = 0;
      low[e] = cell[e].low[way];
      body[e] = Root(body, e);
    }
    PetscCall(PetscSortRealWithArrayInt(N, low, order));
    for (PetscInt k = 0; k < N; k++) {
      const PetscInt e = order[k], fault = SlipFaultMeshFaultOf(mesh, SlipFaultMeshRowOf(mesh, e));

      for (PetscInt l = k + 1; l < N && low[l] <= cell[e].high[way] + cell[e].near; l++) {
        const PetscInt g = order[l], other = SlipFaultMeshFaultOf(mesh, SlipFaultMeshRowOf(mesh, g));

        if ((body[e] == body[g] && fault == other) || !Meets(&cell[e], &cell[g]) || Share(w, e, g)) continue;
        if (!out->apart) {
          out->fault[0] = PetscMin(fault, other);
          out->fault[1] = PetscMax(fault, other);
        }
        out->apart += !met[e] + !met[g];
        met[e] = met[g] = 1;
      }
    }
    PetscCall(PetscFree4(cell, low, order, met));
  }
  PetscCall(PetscFree2(body, first));
  PetscFunctionReturn(PETSC_SUCCESS);
}
