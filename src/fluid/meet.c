/* Where rectangles of a list meet. Their corners are not shared and their sides need not be equal: corners closer than
   rounding become one point, and a side on which points of other cells lie is cut there, so that a piece of a side is
   told by its two ends. Points are found in a tree of boxes, whose leaves are single points. */
#include <slipstep/private/slipfluid.h>

/* Distance below which points are one, over the shortest side of their cells: that of coordinates of 100 km with seven
   digits, to a cell of 10 m */
#define MEET_ROUNDING 1e-3

/* Corners of all rectangles as a binary tree: node [low, high) is cut at its middle, in the direction in which it is
   longest, into what is at most and what is at least as far there. */
typedef struct {
  const PetscReal *at; /* [n][3] */
  PetscInt n, *item;   /* [n] the points in the order of the tree */
  char *way;           /* [n] the direction at the middle of each node */
} Tree;

static PetscReal Where(const Tree *t, PetscInt k, int way)
{
  return t->at[3 * (size_t)t->item[k] + way];
}

/* Moves the middle of [low, high) to its place and all smaller numbers before it (Hoare 1961). */
static void Select(Tree *t, PetscInt low, PetscInt high, PetscInt middle, int way)
{
  PetscInt left = low, right = high - 1;

  while (left < right) {
    const PetscReal pivot = Where(t, middle, way);
    PetscInt i = left, j = right;

    while (i <= j) {
      while (Where(t, i, way) < pivot) i++;
      while (pivot < Where(t, j, way)) j--;
      if (i <= j) {
        const PetscInt swap = t->item[i];

        t->item[i++] = t->item[j];
        t->item[j--] = swap;
      }
    }
    if (j < middle) left = i;
    if (middle < i) right = j;
  }
}

static void Build(Tree *t, PetscInt low, PetscInt high)
{
  PetscReal from[3] = {PETSC_MAX_REAL, PETSC_MAX_REAL, PETSC_MAX_REAL},
            to[3] = {-PETSC_MAX_REAL, -PETSC_MAX_REAL, -PETSC_MAX_REAL};
  const PetscInt middle = low + (high - low) / 2;
  int way = 0;

  if (high <= low) return;
  for (PetscInt k = low; k < high; k++)
    for (int i = 0; i < 3; i++) {
      from[i] = PetscMin(from[i], Where(t, k, i));
      to[i] = PetscMax(to[i], Where(t, k, i));
    }
  for (int i = 1; i < 3; i++)
    if (to[i] - from[i] > to[way] - from[way]) way = i;
  Select(t, low, high, middle, way);
  t->way[middle] = (char)way;
  Build(t, low, middle);
  Build(t, middle + 1, high);
}

/* Calls use() for each point in a box. */
typedef void Use(PetscInt point, void *ctx);
static void Search(const Tree *t, PetscInt low, PetscInt high, const PetscReal from[3], const PetscReal to[3], Use *use,
                   void *ctx)
{
  while (low < high) {
    const PetscInt middle = low + (high - low) / 2;
    const int way = t->way[middle];
    const PetscReal *p = t->at + 3 * (size_t)t->item[middle];

    if (p[0] >= from[0] && p[0] <= to[0] && p[1] >= from[1] && p[1] <= to[1] && p[2] >= from[2] && p[2] <= to[2])
      use(t->item[middle], ctx);
    if (p[way] >= from[way] && p[way] <= to[way]) Search(t, low, middle, from, to, use, ctx);
    if (p[way] > to[way])
      high = middle;
    else
      low = middle + 1;
  }
}

/* What is looked for: the first of all points near one, or those on the way from it to another */
typedef struct {
  const SlipFluidMeet *meet;
  const PetscReal *at;
  const PetscReal *point; /* from which */
  PetscInt ends[2];       /* points that do not count */
  PetscReal way[3], length, near;
  PetscInt found, size; /* the first one, or how many */
  SlipFluidCut *cut;
} Sought;

static void Nearest(PetscInt p, void *ctx)
{
  Sought *s = (Sought *)ctx;
  const PetscReal *a = s->at + 3 * (size_t)p, *b = s->point;

  if (p < s->found && PetscSqr(a[0] - b[0]) + PetscSqr(a[1] - b[1]) + PetscSqr(a[2] - b[2]) <= PetscSqr(s->near))
    s->found = p;
}

static void Between(PetscInt p, void *ctx)
{
  Sought *s = (Sought *)ctx;
  const PetscReal *a = s->at + 3 * (size_t)p;
  PetscReal along = 0, square = 0;

  if (s->meet->point[p] != p || p == s->ends[0] || p == s->ends[1]) return; /* each point once */
  for (int i = 0; i < 3; i++) along += (a[i] - s->point[i]) * s->way[i];
  for (int i = 0; i < 3; i++) square += PetscSqr(a[i] - s->point[i] - along * s->way[i]);
  if (along <= 0 || along >= s->length || square > PetscSqr(s->near)) return;
  if (s->cut && s->found < s->size) s->cut[s->found] = (SlipFluidCut){p, along / s->length};
  s->found++;
}

static int Order(const void *a, const void *b)
{
  const SlipFluidCut *p = (const SlipFluidCut *)a, *q = (const SlipFluidCut *)b;

  return p->part != q->part ? (p->part > q->part) - (p->part < q->part) : (p->point > q->point) - (p->point < q->point);
}

/* Finds the cuts of side k of the sides of all cells, of which there may be `size`. Returns how many there are. */
static PetscInt Cuts(const Tree *t, const SlipFluidMeet *m, PetscInt k, PetscReal near, PetscInt size,
                     SlipFluidCut cut[])
{
  const PetscInt a = k, b = k % 4 == 3 ? k - 3 : k + 1;
  const PetscReal *p = t->at + 3 * (size_t)a, *q = t->at + 3 * (size_t)b;
  Sought s = {.meet = m, .at = t->at, .point = p, .ends = {m->point[a], m->point[b]}, .near = near, .size = size};
  PetscReal from[3], to[3];

  for (int i = 0; i < 3; i++) s.length += PetscSqr(q[i] - p[i]);
  s.length = PetscSqrtReal(s.length);
  for (int i = 0; i < 3; i++) {
    s.way[i] = (q[i] - p[i]) / s.length;
    from[i] = PetscMin(p[i], q[i]) - near;
    to[i] = PetscMax(p[i], q[i]) + near;
  }
  s.cut = cut;
  Search(t, 0, t->n, from, to, Between, &s);
  if (cut) qsort(cut, (size_t)s.found, sizeof(*cut), Order);
  return s.found;
}

/* points [4 N][3]: the corners of N rectangles */
PetscErrorCode SlipFluidMeetCreate(PetscInt N, const PetscReal points[], SlipFluidMeet *m)
{
  Tree t = {.at = points, .n = 4 * N};
  PetscReal *near;

  PetscFunctionBegin;
  PetscCall(PetscMalloc2(4 * (size_t)N, &m->point, 4 * (size_t)N + 1, &m->first));
  PetscCall(PetscMalloc3(4 * (size_t)N, &t.item, 4 * (size_t)N, &t.way, N, &near));
  for (PetscInt k = 0; k < t.n; k++) t.item[k] = k;
  Build(&t, 0, t.n);
  for (PetscInt e = 0; e < N; e++) {
    const PetscReal *p = points + 12 * (size_t)e;
    PetscReal square[2] = {0, 0};

    for (int i = 0; i < 3; i++) {
      square[0] += PetscSqr(p[3 + i] - p[i]);
      square[1] += PetscSqr(p[9 + i] - p[i]);
    }
    near[e] = MEET_ROUNDING * PetscSqrtReal(PetscMin(square[0], square[1]));
  }
  for (PetscInt k = 0; k < t.n; k++) {
    const PetscReal *p = points + 3 * (size_t)k, d = near[k / 4];
    Sought s = {.at = points, .point = p, .near = d, .found = k};
    const PetscReal from[3] = {p[0] - d, p[1] - d, p[2] - d}, to[3] = {p[0] + d, p[1] + d, p[2] + d};

    Search(&t, 0, t.n, from, to, Nearest, &s);
    m->point[k] = s.found == k ? k : m->point[s.found];
  }
  m->first[0] = 0;
  for (PetscInt k = 0; k < t.n; k++) m->first[k + 1] = m->first[k] + Cuts(&t, m, k, near[k / 4], 0, NULL);
  PetscCall(PetscMalloc1(m->first[t.n], &m->cut));
  for (PetscInt k = 0; k < t.n; k++)
    if (m->first[k + 1] > m->first[k])
      (void)Cuts(&t, m, k, near[k / 4], m->first[k + 1] - m->first[k], m->cut + m->first[k]);
  PetscCall(PetscFree3(t.item, t.way, near));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFluidMeetDestroy(SlipFluidMeet *m)
{
  PetscFunctionBegin;
  PetscCall(PetscFree2(m->point, m->first));
  PetscCall(PetscFree(m->cut));
  PetscFunctionReturn(PETSC_SUCCESS);
}
