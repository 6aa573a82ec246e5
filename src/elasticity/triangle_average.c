/*
  Stress drop of a triangle averaged over another one or itself: the force on it over its area.

  Without a free surface the force is that of triangle_loops.c, to rounding. The part of the surface is smooth except on
  the image lines of the source's edges, above the ground. It is integrated over the smaller of both triangles, which is
  divided into parts that are small enough for their distance from those lines. The force is therefore bitwise the same
  when both triangles are exchanged.

  Where both triangles have an edge on the ground they are next to that edge's image. Slip does not end there: without a
  surface, the stress of the source and of its mirror image with the same jump is smooth, and so is the part of the
  surface less the stress of that mirror image. The force of the mirror image is added in closed form. The rest is
  proportional to 1/distance from a vertex on the ground, from which edges go down: lines from such a vertex are
  integrated in their distance from it.

  Edges that two triangles share have a core, as in average.c.
*/
#include <slipcompat.h>
#include <slipstep/private/sliptriangle.h>

#define MOST_NODES 6
#define NODES_FROM 2
/* Number of nodes in either direction of a part, by its distance d, in its radii, from the next line or from the other
   triangle: degrees above 2 n - 2 are neglected, d^(1 - 2 n) of the value and 1e-8. */
static const struct {
  PetscReal distance;
  int n;
} Rule[] = {{6, 6}, {14, 5}, {40, 4}, {400, 3}, {PETSC_MAX_REAL, 2}};
static const PetscReal Node[MOST_NODES - NODES_FROM + 1][2][MOST_NODES] = {
  {{0.21132486540518713, 0.78867513459481287}, {0.5, 0.5}},
  {{0.11270166537925830, 0.5, 0.88729833462074170}, {0.27777777777777778, 0.44444444444444444, 0.27777777777777778}},
  {{0.069431844202973714, 0.33000947820757187, 0.66999052179242813, 0.93056815579702629},
   {0.17392742256872692, 0.32607257743127307, 0.32607257743127307, 0.17392742256872692}},
  {{0.046910077030668004, 0.23076534494715845, 0.5, 0.76923465505284155, 0.953089922969332},
   {0.11846344252809454, 0.23931433524968324, 0.28444444444444444, 0.23931433524968324, 0.11846344252809454}},
  {{0.033765242898423987, 0.16939530676686775, 0.38069040695840155, 0.61930959304159845, 0.83060469323313225,
    0.96623475710157601},
   {0.085662246189585178, 0.18038078652406930, 0.23395696728634552, 0.23395696728634552, 0.18038078652406930,
    0.085662246189585178}},
};
#define SPLIT 2.5  /* a part nearer to a line, in its radii, is divided */
#define DEEPEST 10 /* most divisions */
#define FAR                                                                                                            \
  8 /* a triangle so many of its radii away from the other one is integrated by quadrature, with the direct part */

/* A triangle that slips, or that has virtual slips on which the other one's stress does work */
typedef struct {
  PetscReal vertices[9], normal[3];
  PetscInt n; /* number of slips */
  PetscReal slip[3][3];
  SlipTriangleLoop loop;
  PetscReal middle[3], radius;
  PetscBool trace; /* an edge is on the ground */
} Side;

/* An integral over a receiver of the stress of a source, less that of the source's mirror image without a surface */
typedef struct {
  const Side *receiver;
  SlipTriangle source[2];
  PetscReal slip[2][3][3]; /* slips of source and image */
  PetscInt nsources, nslips, n;
  PetscReal nu;
  PetscReal at[SLIP_LANES][3], weight[SLIP_LANES], sum[9]; /* [receiver's slips][source's] */
  PetscReal line[3][2][3]; /* images of the other one's edges, on which the stress is infinite */
  PetscInt nlines;
  PetscReal touch;
} Integral;

/* Sets up a triangle; direction [n] are those of the cell's directions along which it slips. */
static void SideOf(const SlipTriangleCell *cell, PetscInt n, const PetscInt direction[], PetscBool full_space, Side *s)
{
  const PetscReal *v = cell->vertices;
  PetscReal normal[3], square;
  PetscInt ground = 0;

  s->n = n;
  s->radius = 0;
  s->loop.full_space = full_space;
  square = SlipTriangleNormal(v, normal);
  s->loop.area = 0.5 * PetscSqrtReal(SlipDot(normal, normal));
  s->loop.least = 2 * s->loop.area / PetscSqrtReal(square);
  for (int k = 0; k < 3; k++) {
    const int from = SlipDot(normal, cell->directions + 6) < 0 ? 2 - k : k;

    for (int i = 0; i < 3; i++) s->loop.vertices[3 * k + i] = v[3 * from + i];
    for (int i = 0; i < 3; i++) s->vertices[3 * k + i] = v[3 * k + i];
    s->normal[k] = s->loop.normal[k] = cell->directions[6 + k];
    for (PetscInt i = 0; i < n; i++) s->slip[i][k] = cell->directions[3 * direction[i] + k];
    s->middle[k] = (v[k] + v[3 + k] + v[6 + k]) / 3;
    ground += !full_space && v[3 * k + 2] <= SLIP_TOUCH * s->loop.least;
  }
  for (int k = 0; k < 3; k++) {
    PetscReal r[3];

    for (int i = 0; i < 3; i++) r[i] = v[3 * k + i] - s->middle[i];
    s->radius = PetscMax(s->radius, PetscSqrtReal(SlipDot(r, r)));
  }
  s->trace = (PetscBool)(ground == 2);
}

/* Adds a source, as it is or mirrored at the ground, with its hanging wall in the other's. */
static void AddSource(Integral *w, const Side *s, PetscBool full_space, PetscBool mirrored)
{
  const PetscReal down = mirrored ? -1 : 1, normal[3] = {s->normal[0], s->normal[1], down * s->normal[2]};
  const PetscInt j = w->nsources++;
  PetscReal vertices[9];

  for (int i = 0; i < 9; i++) vertices[i] = (i % 3 == 2 ? down : 1) * s->vertices[i];
  SlipTriangleOf_Private(w->nu, full_space, vertices, normal, &w->source[j]);
  w->nslips = s->n;
  for (PetscInt i = 0; i < 3 * s->n; i++) w->slip[j][i / 3][i % 3] = s->slip[i / 3][i % 3];
}

/* Subtracts the tractions along the receiver's slips at the collected points. */
static void Flush(Integral *w)
{
  const PetscReal *normal = w->receiver->normal;

  for (PetscInt j = 0; j < w->nsources && w->n; j++) {
    const SlipTriangle *all[3][SLIP_LANES], *const *const of[3] = {all[0], all[1], all[2]};
    PetscReal gradient[3][9 * SLIP_LANES], *const out[3] = {gradient[0], gradient[1], gradient[2]}, s[6];
    SlipTriangle source[3];
    SlipTrianglePoints p;

    p.n = w->n;
    for (PetscInt m = 0; m < w->nslips; m++) {
      source[m] = w->source[j];
      SlipTriangleSetSlip_Private(&source[m], w->slip[j][m]);
      for (PetscInt k = 0; k < w->n; k++) all[m][k] = &source[m];
    }
    for (PetscInt k = 0; k < w->n; k++) SlipTrianglePointOf_Private(all[0][k], w->at[k], k, &p);
    SlipTriangleFields_Private(w->nslips, of, &p, PETSC_TRUE, out);
    for (PetscInt m = 0; m < w->nslips; m++)
      for (PetscInt k = 0; k < w->n; k++) {
        SlipTurnOut(all[m][k]->strike, PETSC_TRUE, gradient[m] + 9 * k);
        SlipStressOf(1, w->nu, gradient[m] + 9 * k, s);
        for (PetscInt l = 0; l < w->receiver->n; l++) {
          const PetscReal *a = w->receiver->slip[l];

          w->sum[l * w->nslips + m] += (j ? 1 : -1) * w->weight[k] *
                                       (a[0] * (s[0] * normal[0] + s[3] * normal[1] + s[4] * normal[2]) +
                                        a[1] * (s[3] * normal[0] + s[1] * normal[1] + s[5] * normal[2]) +
                                        a[2] * (s[4] * normal[0] + s[5] * normal[1] + s[2] * normal[2]));
        }
      }
  }
  w->n = 0;
}

/* Adds the nodes of a part: n lines from the first vertex, with n nodes each. */
static void Leaf(Integral *w, PetscReal v[3][3], int n)
{
  const PetscReal *node = Node[n - NODES_FROM][0], *weight = Node[n - NODES_FROM][1];
  PetscReal e[2][3], normal[3], area;

  for (int l = 0; l < 3; l++) {
    e[0][l] = v[1][l] - v[0][l];
    e[1][l] = v[2][l] - v[1][l];
  }
  SlipCross(e[0], e[1], normal);
  area = PetscSqrtReal(SlipDot(normal, normal)); /* twice the area */
  for (int i = 0; i < n; i++)
    for (int j = 0; j < n; j++) {
      for (int l = 0; l < 3; l++) w->at[w->n][l] = v[0][l] + node[i] * (e[0][l] + node[j] * e[1][l]);
      w->weight[w->n++] = weight[i] * weight[j] * node[i] * area;
      if (w->n == SLIP_LANES) Flush(w);
    }
}

static PetscReal FromLines(const Integral *w, const PetscReal at[3])
{
  PetscReal least = PETSC_MAX_REAL;

  for (PetscInt k = 0; k < w->nlines; k++) {
    PetscReal d[3], r[3], along;

    for (int i = 0; i < 3; i++) {
      d[i] = w->line[k][1][i] - w->line[k][0][i];
      r[i] = at[i] - w->line[k][0][i];
    }
    along = SlipDot(d, r) / SlipDot(d, d);
    along = PetscMin(1, PetscMax(0, along));
    for (int i = 0; i < 3; i++) r[i] -= along * d[i];
    least = PetscMin(least, SlipDot(r, r));
  }
  return PetscSqrtReal(least);
}

/* Returns the distance of the nearest end of a line that is not the point itself. */
static PetscReal FromOtherEnds(const Integral *w, const PetscReal at[3])
{
  PetscReal least = PETSC_MAX_REAL;

  for (PetscInt k = 0; k < w->nlines; k++)
    for (int j = 0; j < 2; j++) {
      PetscReal r[3], square;

      for (int i = 0; i < 3; i++) r[i] = w->line[k][j][i] - at[i];
      square = SlipDot(r, r);
      if (square > w->touch * w->touch) least = PetscMin(least, square);
    }
  return PetscSqrtReal(least);
}

static void Part(Integral *w, const PetscReal a[3], const PetscReal b[3], const PetscReal c[3], int depth);

static void Middle(const PetscReal a[3], const PetscReal b[3], PetscReal m[3])
{
  for (int i = 0; i < 3; i++) m[i] = 0.5 * (a[i] + b[i]);
}

static void Quarters(Integral *w, PetscReal v[3][3], int depth)
{
  PetscReal m[3][3];

  for (int k = 0; k < 3; k++) Middle(v[k], v[(k + 1) % 3], m[k]);
  for (int k = 0; k < 3; k++) Part(w, v[k], m[k], m[(k + 2) % 3], depth + 1);
  Part(w, m[0], m[1], m[2], depth + 1);
}

/* Integrates a part whose vertex 0 is on a line's end: from there the integrand is 1/distance times a function of the
   angle, except for the terms of other ends. */
static void Fan(Integral *w, PetscReal v[3][3], int depth)
{
  PetscReal m[3], side[3], along[3], length;

  Middle(v[1], v[2], m);
  for (int i = 0; i < 3; i++) {
    side[i] = 0.5 * (v[2][i] - v[1][i]);
    along[i] = m[i] - v[0][i];
  }
  length = PetscSqrtReal(SlipDot(along, along));
  if (depth == DEEPEST)
    Leaf(w, v, MOST_NODES);
  else if (FromOtherEnds(w, v[0]) < 1.9 * length)
    Quarters(w, v, depth);
  else if (FromLines(w, m) < SPLIT * PetscSqrtReal(SlipDot(side, side))) {
    Part(w, v[0], v[1], m, depth + 1);
    Part(w, v[0], m, v[2], depth + 1);
  } else
    Leaf(w, v, MOST_NODES);
}

static void Part(Integral *w, const PetscReal a[3], const PetscReal b[3], const PetscReal c[3], int depth)
{
  PetscReal v[3][3], m[3], middle[3], radius = 0, distance;
  PetscInt ends = 0, first = 0, other = 0;

  for (int i = 0; i < 3; i++) {
    v[0][i] = a[i];
    v[1][i] = b[i];
    v[2][i] = c[i];
    middle[i] = (a[i] + b[i] + c[i]) / 3;
  }
  for (int k = 0; k < 3; k++) {
    PetscReal r[3];

    for (int i = 0; i < 3; i++) r[i] = v[k][i] - middle[i];
    radius = PetscMax(radius, PetscSqrtReal(SlipDot(r, r)));
    if (v[k][2] > w->touch || FromLines(w, v[k]) > w->touch) continue;
    if (!ends++)
      first = k;
    else
      other = k;
  }
  if (ends) {
    const PetscInt second = (first + 1) % 3, third = (first + 2) % 3;
    PetscReal fan[3][3];

    if (ends > 1) {
      const PetscInt rest = 3 - first - other;

      Middle(v[first], v[other], m);
      Part(w, v[first], m, v[rest], depth + 1);
      Part(w, m, v[other], v[rest], depth + 1);
      return;
    }
    for (int i = 0; i < 3; i++) {
      fan[0][i] = v[first][i];
      fan[1][i] = v[second][i];
      fan[2][i] = v[third][i];
    }
    Fan(w, fan, depth);
    return;
  }
  distance = FromLines(w, middle);
  if (distance >= SPLIT * radius || depth == DEEPEST) {
    int k = 0;

    while (distance > Rule[k].distance * radius) k++;
    Leaf(w, v, Rule[k].n);
    return;
  }
  Quarters(w, v, depth);
}

/* Integrates the part of the free surface over the smaller triangle; force: [its slips][slips of the larger one]. */
static void Surface(PetscReal nu, const Side *small, const Side *large, PetscReal core, PetscReal force[])
{
  const PetscBool both = (PetscBool)(small->trace && large->trace);
  const PetscInt n = small->n * large->n;
  Integral w = {.receiver = small, .nu = nu};

  w.touch = SLIP_TOUCH * PetscMin(small->loop.least, large->loop.least);
  for (int k = 0; k < 3; k++) {
    const PetscReal *end[2] = {large->vertices + 3 * k, large->vertices + 3 * ((k + 1) % 3)};

    if (both && end[0][2] <= w.touch && end[1][2] <= w.touch) continue;
    for (int j = 0; j < 2; j++)
      for (int i = 0; i < 3; i++) w.line[w.nlines][j][i] = i == 2 ? -end[j][i] : end[j][i];
    w.nlines++;
  }
  AddSource(&w, large, PETSC_FALSE, PETSC_FALSE);
  w.source[0].image_only = PETSC_TRUE;
  if (both) AddSource(&w, large, PETSC_TRUE, PETSC_TRUE);
  Part(&w, small->vertices, small->vertices + 3, small->vertices + 6, 0);
  Flush(&w);
  for (PetscInt k = 0; k < n; k++) force[k] += w.sum[k];
  if (both) {
    SlipTriangleLoop image = large->loop;
    PetscReal mirrored[9];

    for (int k = 0; k < 3; k++)
      for (int i = 0; i < 3; i++) image.vertices[3 * k + i] = (i == 2 ? -1 : 1) * large->loop.vertices[3 * (2 - k) + i];
    SlipTriangleLoops(nu, &small->loop, small->n, small->slip, &image, large->n, large->slip, core, mirrored);
    for (PetscInt k = 0; k < n; k++) force[k] += mirrored[k] / (4 * PETSC_PI);
  }
}

/* Orders both triangles, whichever is first. */
static PetscBool Larger(const Side *a, const Side *b)
{
  if (a->loop.area != b->loop.area) return (PetscBool)(a->loop.area > b->loop.area);
  for (int i = 0; i < 9; i++)
    if (a->vertices[i] != b->vertices[i]) return (PetscBool)(a->vertices[i] > b->vertices[i]);
  return PETSC_FALSE;
}

/* Computes the force over G, [slips of the smaller one][slips of the larger one]. */
static void Force(PetscReal nu, PetscBool full_space, const Side *small, const Side *large, PetscReal core,
                  PetscReal force[9])
{
  PetscReal apart[3], distance;

  for (int i = 0; i < 3; i++) apart[i] = small->middle[i] - large->middle[i];
  distance = PetscSqrtReal(SlipDot(apart, apart)) - large->radius;
  if (distance > FAR * small->radius) {
    Integral w = {.receiver = small, .nu = nu};
    PetscReal v[3][3];
    int k = 0;

    for (int i = 0; i < 9; i++) v[i / 3][i % 3] = small->vertices[i];
    AddSource(&w, large, full_space, PETSC_FALSE);
    while (distance > Rule[k].distance * small->radius) k++;
    Leaf(&w, v, Rule[k].n);
    Flush(&w);
    for (int i = 0; i < 9; i++) force[i] = w.sum[i];
    return;
  }
  SlipTriangleLoops(nu, &small->loop, small->n, small->slip, &large->loop, large->n, large->slip, core, force);
  for (PetscInt i = 0; i < small->n * large->n; i++) force[i] /= 4 * PETSC_PI;
  if (!full_space) Surface(nu, small, large, core, force);
}

/*
  SlipTriangleAverage - computes averages over the receiver of the stress drop, for unit slip along the first direction
  of the source and, of 2 or 3 slips, along the second and across it: [2][1] along the first of the receiver's
  directions and normal, for several slips [3][slips] along both and normal; core: core of edges that both share, over
  the smaller of their heights on them
*/
void SlipTriangleAverage(PetscReal G, PetscReal nu, PetscBool full_space, PetscInt slips,
                         const SlipTriangleCell *receiver, const SlipTriangleCell *source, PetscReal core,
                         PetscReal average[])
{
  static const PetscInt all[3] = {0, 1, 2}, scalar[2] = {0, 2};
  const PetscInt rows = slips > 1 ? 3 : 2, *directions = slips > 1 ? all : scalar;
  PetscBool turned;
  PetscReal force[9];
  Side to, from;

  SideOf(receiver, rows, directions, full_space, &to);
  SideOf(source, slips, directions, full_space, &from);
  turned = Larger(&to, &from);
  Force(nu, full_space, turned ? &from : &to, turned ? &to : &from, core, force);
  for (PetscInt i = 0; i < rows; i++)
    for (PetscInt j = 0; j < slips; j++)
      average[slips * i + j] = G / to.loop.area * force[turned ? rows * j + i : slips * i + j];
}

/*
  SlipTriangleAverageEdge - computes the change of a cell's average on itself if its edge from vertex k to the next one
  has ratio times the core along share of it: [slips][slips], in the plane, and across it for 3 slips
*/
void SlipTriangleAverageEdge(PetscReal G, PetscReal nu, PetscInt slips, const SlipTriangleCell *cell, PetscInt k,
                             PetscReal share, PetscReal ratio, PetscReal edge[])
{
  const PetscReal *d = cell->directions;
  SlipTriangleLoop loop;
  PetscReal normal[3];

  SlipTriangleNormal(cell->vertices, normal);
  for (int i = 0; i < 9; i++) loop.vertices[i] = cell->vertices[i];
  loop.area = 0.5 * PetscSqrtReal(SlipDot(normal, normal));
  for (PetscInt i = 0; i < slips; i++)
    for (PetscInt j = 0; j < slips; j++)
      edge[slips * i + j] =
        G / (4 * PETSC_PI * loop.area) * SlipTriangleLoopEdge(nu, &loop, d + 3 * i, d + 3 * j, k, share, ratio);
}
