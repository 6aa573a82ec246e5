/*
  Reads the file of -fault_mesh in the formats 2.2 and 4.1 of Gmsh, text or binary: triangles or quadrilaterals of
  physical surfaces, which are faults.

  DMPlexCreateFromFile() reads such files too. But it takes the elements of the highest dimension, so that faults in a
  meshed volume would have to be found by labels; it renumbers elements and nodes, so that messages could not name those
  of the file; and it accesses memory beyond its arrays where a damaged file names a node that does not exist.
*/
#include <slipstep/private/slipmesh.h>
#include <slipstep/private/slipgmsh.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Kinds of elements by their number in files: number of nodes, and dimension; 0 nodes: no kind has this number */
static const struct {
  PetscInt nodes, dim;
} Elements[] = {{0, 0},  {2, 1},  {3, 2},  {4, 2},  {4, 3}, {8, 3}, {6, 3},  {5, 3},  {3, 1},  {6, 2}, {9, 2},
                {10, 3}, {27, 3}, {18, 3}, {14, 3}, {1, 0}, {8, 2}, {20, 3}, {15, 3}, {13, 3}, {9, 2}, {10, 2},
                {12, 2}, {15, 2}, {15, 2}, {21, 2}, {4, 1}, {5, 1}, {6, 1},  {20, 3}, {35, 3}, {56, 3}};
enum { GMSH_TRIANGLE = 2, GMSH_QUADRILATERAL = 3, GMSH_KINDS = PETSC_STATIC_ARRAY_LENGTH(Elements) };

typedef struct {
  PetscInt64 tag;
  PetscInt where; /* place of a node, or physical group of a surface */
  PetscInt other; /* second group of a surface, or 0 */
} Tagged;

typedef struct {
  PetscInt64 tag, node[4];
  PetscInt sides, physical; /* number of sides, physical group; 0: none */
} Facet;

typedef struct {
  SlipGmsh g;
  PetscBool four; /* version 4.1; otherwise 2.2 */
  PetscInt nnodes, nsurfaces, nfacets, room;
  PetscReal *x;           /* [nnodes][3] */
  Tagged *node, *surface; /* in the order of ascending tags */
  Facet *facet;
  PetscInt volumes; /* number of volume elements */
  PetscBool nodes, elements, physical;
  char *names;
} Gmsh;

#define Fail(...) SETERRQ(PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED, __VA_ARGS__)

static int Compare(const void *a, const void *b)
{
  const Tagged *p = (const Tagged *)a, *q = (const Tagged *)b;

  if (p->tag != q->tag) return p->tag < q->tag ? -1 : 1;
  return p->where < q->where ? -1 : p->where > q->where;
}

static const Tagged *Find(PetscInt n, const Tagged all[], PetscInt64 tag)
{
  PetscInt low = 0, top = n;

  while (low < top) {
    const PetscInt middle = (low + top) / 2;

    if (all[middle].tag < tag)
      low = middle + 1;
    else
      top = middle;
  }
  return low < n && all[low].tag == tag ? &all[low] : NULL;
}

/* ---- what comes before nodes and elements ---- */

static PetscErrorCode ReadFormat(Gmsh *f)
{
  SlipGmsh *g = &f->g;
  PetscInt64 kind[2];
  PetscReal version;

  PetscFunctionBegin;
  PetscCall(SlipGmshReals(g, 1, &version));
  PetscCall(SlipGmshInts(g, 2, sizeof(int), kind));
  f->four = PetscAbsReal(version - 4.1) < 1e-6 ? PETSC_TRUE : PETSC_FALSE;
  if (!f->four && PetscAbsReal(version - 2.2) > 1e-6)
    Fail("%s is of version %.6g of the format, expected 2.2 or 4.1, as gmsh -format msh41 writes", g->source,
         (double)version);
  if ((kind[0] != 0 && kind[0] != 1) || kind[1] != sizeof(double))
    Fail("%s has $MeshFormat %.6g %lld %lld, expected 0 or 1 and 8 after the version", g->source, (double)version,
         (long long)kind[0], (long long)kind[1]);
  if (kind[0]) {
    PetscInt64 one;

    PetscCall(SlipGmshLine(g));
    g->binary = PETSC_TRUE;
    PetscCall(SlipGmshInts(g, 1, sizeof(int), &one));
    if (one != 1)
      Fail("%s: the number 1 in $MeshFormat is %lld here: expected a file in this machine's order of bytes", g->source,
           (long long)one);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads dimension, tag and name of each group, which are text in every file, and stores those of surfaces. */
static PetscErrorCode ReadNames(Gmsh *f)
{
  SlipGmsh *g = &f->g;
  const PetscBool binary = g->binary;
  PetscInt64 n, group[2];
  char name[256];

  PetscFunctionBegin;
  g->binary = PETSC_FALSE;
  PetscCall(SlipGmshInts(g, 1, 0, &n));
  PetscCall(SlipGmshFits(g, n, 6, "names"));
  PetscCall(PetscFree(f->names));
  PetscCall(PetscCalloc1(MESH_MAX_NAMES, &f->names));
  for (PetscInt64 i = 0; i < n; i++) {
    const size_t used = strlen(f->names);

    PetscCall(SlipGmshInts(g, 2, 0, group));
    PetscCall(SlipGmshQuoted(g, name, sizeof(name)));
    if (group[0] == 2 && used + sizeof(name) + 32 < MESH_MAX_NAMES)
      (void)snprintf(f->names + used, MESH_MAX_NAMES - used, "%s%lld %s", used ? "; " : "", (long long)group[1], name);
  }
  g->binary = binary;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads the points, curves, surfaces and volumes of the model with boxes, physical groups and bounds (version 4.1), and
   stores the groups of surfaces. */
static PetscErrorCode ReadEntities(Gmsh *f)
{
  SlipGmsh *g = &f->g;
  PetscInt64 count[4], tag, groups, bounds, group;
  PetscReal box[6];

  PetscFunctionBegin;
  PetscCall(SlipGmshInts(g, 4, 8, count));
  for (int dim = 0; dim < 4; dim++) {
    PetscCall(SlipGmshFits(g, count[dim], g->binary ? 4 : 2, "entities"));
    if (dim == 2) {
      PetscCall(PetscFree(f->surface));
      PetscCall(PetscMalloc1(PetscMax(count[2], 1), &f->surface));
    }
    for (PetscInt64 i = 0; i < count[dim]; i++) {
      PetscInt physical[2] = {0, 0};

      PetscCall(SlipGmshInts(g, 1, sizeof(int), &tag));
      PetscCall(SlipGmshReals(g, dim ? 6 : 3, box));
      PetscCall(SlipGmshInts(g, 1, 8, &groups));
      PetscCall(SlipGmshFits(g, groups, g->binary ? sizeof(int) : 2, "groups"));
      for (PetscInt64 k = 0; k < groups; k++) {
        PetscCall(SlipGmshInts(g, 1, sizeof(int), &group));
        if (group < 0) group = -group; /* a negative group is of the reversed surface */
        if (k < 2) physical[k] = (PetscInt)group;
      }
      if (dim) PetscCall(SlipGmshInts(g, 1, 8, &bounds));
      if (dim) PetscCall(SlipGmshFits(g, bounds, g->binary ? sizeof(int) : 2, "bounds"));
      for (PetscInt64 k = 0; dim && k < bounds; k++) PetscCall(SlipGmshInts(g, 1, sizeof(int), &group));
      if (dim == 2) f->surface[f->nsurfaces++] = (Tagged){tag, physical[0], physical[1]};
    }
  }
  qsort(f->surface, (size_t)f->nsurfaces, sizeof(*f->surface), Compare);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- nodes ---- */

static PetscErrorCode NodesCreate(Gmsh *f, PetscInt64 n)
{
  PetscFunctionBegin;
  PetscCall(SlipGmshFits(&f->g, n, f->g.binary ? 32 : 8, "nodes"));
  PetscCall(PetscFree(f->node));
  PetscCall(PetscFree(f->x));
  PetscCall(PetscMalloc1(PetscMax(n, 1), &f->node));
  PetscCall(PetscMalloc1(3 * (size_t)PetscMax(n, 1), &f->x));
  f->nnodes = (PetscInt)n;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads all nodes. Tags and coordinates are separate in each block of 4.1, and beside each other in 2.2. */
static PetscErrorCode ReadNodes(Gmsh *f)
{
  SlipGmsh *g = &f->g;
  const PetscBool binary = g->binary;
  PetscInt64 head[4], block[3];
  PetscInt filled = 0;

  PetscFunctionBegin;
  if (f->four) {
    PetscCall(SlipGmshInts(g, 4, 8, head));
    PetscCall(NodesCreate(f, head[1]));
    PetscCall(SlipGmshFits(g, head[0], g->binary ? 20 : 8, "blocks of nodes"));
    for (PetscInt64 b = 0; b < head[0]; b++) {
      PetscInt64 n;

      PetscCall(SlipGmshInts(g, 3, sizeof(int), block));
      PetscCall(SlipGmshInts(g, 1, 8, &n));
      if (n < 0 || n > f->nnodes - filled)
        Fail("%s: $Nodes has more nodes in its blocks than the %" PetscInt_FMT " that it begins with", g->source,
             f->nnodes);
      for (PetscInt i = filled; i < filled + (PetscInt)n; i++) {
        PetscCall(SlipGmshInts(g, 1, 8, &f->node[i].tag));
        f->node[i].where = i;
      }
      for (PetscInt i = filled; i < filled + (PetscInt)n; i++) {
        PetscReal place[3];

        PetscCall(SlipGmshReals(g, 3, f->x + 3 * (size_t)i));
        if (block[2]) PetscCall(SlipGmshReals(g, PetscMin(3, PetscMax(0, (PetscInt)block[0])), place));
      }
      filled += (PetscInt)n;
    }
  } else {
    g->binary = PETSC_FALSE;
    PetscCall(SlipGmshInts(g, 1, 0, head));
    if (binary) PetscCall(SlipGmshLine(g));
    g->binary = binary;
    PetscCall(NodesCreate(f, head[0]));
    for (; filled < f->nnodes; filled++) {
      PetscCall(SlipGmshInts(g, 1, sizeof(int), &f->node[filled].tag));
      PetscCall(SlipGmshReals(g, 3, f->x + 3 * (size_t)filled));
      f->node[filled].where = filled;
    }
  }
  if (filled != f->nnodes)
    Fail("%s: $Nodes has %" PetscInt_FMT " nodes in its blocks, expected the %" PetscInt_FMT " that it begins with",
         g->source, filled, f->nnodes);
  qsort(f->node, (size_t)f->nnodes, sizeof(*f->node), Compare);
  for (PetscInt i = 0; i < f->nnodes; i++) {
    const PetscInt64 tag = f->node[i].tag;

    if (tag < 1 || tag > PETSC_MAX_INT || (i && tag == f->node[i - 1].tag))
      Fail("%s: $Nodes has the node %lld%s, expected numbers from 1 on, each once", g->source, (long long)tag,
           i && tag == f->node[i - 1].tag ? " twice" : "");
  }
  f->nodes = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- elements ---- */

/* Stores an element if it is of a surface; others are of the rest of the model. */
static PetscErrorCode Add(Gmsh *f, PetscInt64 kind, PetscInt64 tag, PetscInt64 physical, const PetscInt64 node[])
{
  PetscFunctionBegin;
  if (Elements[kind].dim == 3) f->volumes++;
  if (Elements[kind].dim != 2) PetscFunctionReturn(PETSC_SUCCESS);
  if (tag < 1 || tag > PETSC_MAX_INT)
    Fail("%s: $Elements has the element %lld, expected numbers from 1 on", f->g.source, (long long)tag);
  if (kind != GMSH_TRIANGLE && kind != GMSH_QUADRILATERAL)
    Fail("%s: element %lld is of the type %lld, of %" PetscInt_FMT
         " nodes: expected triangles of 3, as of Mesh.ElementOrder = 1, or rectangles of 4",
         f->g.source, (long long)tag, (long long)kind, Elements[kind].nodes);
  if (physical < 0) physical = -physical;
  if (physical > (PetscInt64)MESH_MAX_LABEL)
    Fail("%s: element %lld is of the physical group %lld, expected a number of at most %g", f->g.source, (long long)tag,
         (long long)physical, MESH_MAX_LABEL);
  if (f->nfacets == f->room) {
    f->room = 2 * f->room + 256;
    PetscCall(PetscRealloc((size_t)f->room * sizeof(*f->facet), &f->facet));
  }
  f->facet[f->nfacets] = (Facet){.tag = tag, .sides = Elements[kind].nodes, .physical = (PetscInt)physical};
  for (PetscInt k = 0; k < Elements[kind].nodes; k++) f->facet[f->nfacets].node[k] = node[k];
  f->nfacets++;
  f->physical = f->physical || physical ? PETSC_TRUE : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode CheckKind(const Gmsh *f, PetscInt64 kind)
{
  char place[96];

  PetscFunctionBegin;
  if (kind < 1 || kind >= GMSH_KINDS || !Elements[kind].nodes)
    Fail("%s: %s: elements of the type %lld, expected 1 to %d", f->g.source, SlipGmshPlace(&f->g, place, sizeof(place)),
         (long long)kind, (int)GMSH_KINDS - 1);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads the elements of 2.2. Each has a number, a kind, tags, the first of which is the physical group, and nodes; in
   binary files kind and number of tags precede many elements. */
static PetscErrorCode ReadElementsOld(Gmsh *f)
{
  SlipGmsh *g = &f->g;
  const PetscBool binary = g->binary;
  PetscInt64 n, head[3] = {0}, left = 0, node[64];

  PetscFunctionBegin;
  g->binary = PETSC_FALSE;
  PetscCall(SlipGmshInts(g, 1, 0, &n));
  if (binary) PetscCall(SlipGmshLine(g));
  g->binary = binary;
  PetscCall(SlipGmshFits(g, n, binary ? 8 : 6, "elements"));
  for (PetscInt64 i = 0; i < n; i++) {
    PetscInt64 tag, physical = 0, other;

    if (binary && !left) {
      PetscCall(SlipGmshInts(g, 3, sizeof(int), head));
      left = head[1];
      if (left < 1 || left > n - i)
        Fail("%s: $Elements has a block of %lld elements, expected 1 to %lld", g->source, (long long)left,
             (long long)(n - i));
    }
    PetscCall(SlipGmshInts(g, 1, sizeof(int), &tag));
    if (!binary) {
      PetscCall(SlipGmshInts(g, 1, 0, &head[0]));
      PetscCall(SlipGmshInts(g, 1, 0, &head[2]));
    }
    left--;
    PetscCall(CheckKind(f, head[0]));
    PetscCall(SlipGmshFits(g, head[2], binary ? sizeof(int) : 2, "tags"));
    for (PetscInt64 k = 0; k < head[2]; k++) PetscCall(SlipGmshInts(g, 1, sizeof(int), k ? &other : &physical));
    PetscCall(SlipGmshInts(g, Elements[head[0]].nodes, sizeof(int), node));
    PetscCall(Add(f, head[0], tag, physical, node));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns number and name of a physical group as in the file. */
static const char *GroupOf(const Gmsh *f, PetscInt group, char text[], size_t len)
{
  char key[32];
  const char *at = f->names;
  const size_t n = (size_t)snprintf(key, sizeof(key), "%" PetscInt_FMT " ", group);

  while (at && strncmp(at, key, n)) {
    at = strstr(at, "; ");
    if (at) at += 2;
  }
  if (at)
    (void)snprintf(text, len, "%" PetscInt_FMT " \"%.*s\"", group, (int)strcspn(at + n, ";"), at + n);
  else
    (void)snprintf(text, len, "%" PetscInt_FMT, group);
  return text;
}

static PetscErrorCode FailOfGroups(const Gmsh *f, const char what[], PetscInt64 tag, PetscInt one, PetscInt other)
{
  char name[2][300];

  PetscFunctionBegin;
  Fail("%s: %s %lld is of several physical groups, %s and %s, expected one: a triangle is of one fault", f->g.source,
       what, (long long)tag, GroupOf(f, one, name[0], sizeof(name[0])), GroupOf(f, other, name[1], sizeof(name[1])));
}

/* Reads the elements of 4.1: blocks of one kind on one entity of the model, which has the physical groups. */
static PetscErrorCode ReadElements(Gmsh *f)
{
  SlipGmsh *g = &f->g;
  PetscInt64 head[4], block[3], n, tag, node[64];

  PetscFunctionBegin;
  PetscCall(SlipGmshInts(g, 4, 8, head));
  PetscCall(SlipGmshFits(g, head[0], g->binary ? 20 : 8, "blocks of elements"));
  for (PetscInt64 b = 0; b < head[0]; b++) {
    const Tagged *surface;
    PetscInt physical;

    PetscCall(SlipGmshInts(g, 3, sizeof(int), block));
    PetscCall(SlipGmshInts(g, 1, 8, &n));
    PetscCall(CheckKind(f, block[2]));
    PetscCall(SlipGmshFits(g, n, g->binary ? 16 : 4, "elements"));
    surface = block[0] == 2 ? Find(f->nsurfaces, f->surface, block[1]) : NULL;
    physical = surface ? surface->where : 0;
    if (surface && surface->other) PetscCall(FailOfGroups(f, "surface", block[1], physical, surface->other));
    for (PetscInt64 i = 0; i < n; i++) {
      PetscCall(SlipGmshInts(g, 1, 8, &tag));
      PetscCall(SlipGmshInts(g, Elements[block[2]].nodes, 8, node));
      PetscCall(Add(f, block[2], tag, physical, node));
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- all of it ---- */

static PetscErrorCode ReadSections(Gmsh *f)
{
  SlipGmsh *g = &f->g;
  PetscBool format = PETSC_FALSE;

  PetscFunctionBegin;
  while (!f->nodes || !f->elements) {
    const char *name = g->section;

    PetscCall(SlipGmshBegin(g));
    if (!name[0])
      Fail("%s ends without %s, expected a mesh of Gmsh", g->source,
           !format    ? "$MeshFormat"
           : f->nodes ? "$Elements"
                      : "$Nodes");
    if (!format && strcmp(name, "MeshFormat") && strcmp(name, "Comments"))
      Fail("%s has $%.40s before $MeshFormat, expected a mesh of Gmsh", g->source, name);
    if (!strcmp(name, "MeshFormat")) {
      PetscCall(ReadFormat(f));
      format = PETSC_TRUE;
    } else if (!strcmp(name, "PhysicalNames"))
      PetscCall(ReadNames(f));
    else if (!strcmp(name, "Entities") && f->four)
      PetscCall(ReadEntities(f));
    else if (!strcmp(name, "Nodes"))
      PetscCall(ReadNodes(f));
    else if (!strcmp(name, "Elements")) {
      PetscCall((f->four ? ReadElements : ReadElementsOld)(f));
      f->elements = PETSC_TRUE;
    } else if (!strcmp(name, "PartitionedEntities"))
      Fail("%s is partitioned, expected the whole mesh without parts", g->source);
    else {
      PetscCall(SlipGmshSkip(g));
      continue;
    }
    PetscCall(SlipGmshEnd(g));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

typedef struct {
  PetscInt64 node[4]; /* ascending */
  const Facet *facet;
} Sorted;

static int CompareSorted(const void *a, const void *b)
{
  const Sorted *p = (const Sorted *)a, *q = (const Sorted *)b;

  for (int k = 0; k < 4; k++)
    if (p->node[k] != q->node[k]) return p->node[k] < q->node[k] ? -1 : 1;
  return p->facet->tag < q->facet->tag ? -1 : p->facet->tag > q->facet->tag;
}

/* Refuses a surface of several physical groups, whose elements 2.2 repeats for each group. */
static PetscErrorCode CheckGroups(const Gmsh *f)
{
  Sorted *all;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(PetscMax(f->nfacets, 1), &all));
  for (PetscInt i = 0; i < f->nfacets; i++) {
    const Facet *own = &f->facet[i];

    all[i] = (Sorted){{own->node[0], own->node[1], own->node[2], own->sides == 4 ? own->node[3] : -1}, own};
    for (int k = 1; k < 4; k++)
      for (int j = k; j > 0 && all[i].node[j] < all[i].node[j - 1]; j--) {
        const PetscInt64 low = all[i].node[j];

        all[i].node[j] = all[i].node[j - 1];
        all[i].node[j - 1] = low;
      }
  }
  qsort(all, (size_t)f->nfacets, sizeof(*all), CompareSorted);
  for (PetscInt i = 1; i < f->nfacets; i++) {
    const Facet *a = all[i - 1].facet, *b = all[i].facet;

    if (!memcmp(all[i].node, all[i - 1].node, sizeof(all[i].node)) && a->physical && b->physical &&
        a->physical != b->physical)
      PetscCall(FailOfGroups(f, "element", a->tag, a->physical, b->physical));
  }
  PetscCall(PetscFree(all));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes a mesh of the facets of physical surfaces, or of all facets where there are none. */
static PetscErrorCode TakeFacets(const Gmsh *f, SlipFaultMeshFile *m)
{
  PetscFunctionBegin;
  if (f->volumes && !f->physical)
    Fail("%s has volumes and no physical surface, expected one for each fault: the surfaces of volumes are none",
         f->g.source);
  for (PetscInt i = 0; i < f->nfacets; i++) m->n += !f->physical || f->facet[i].physical ? 1 : 0;
  if (!m->n) Fail("%s has no triangles, expected some", f->g.source);
  PetscCall(PetscMalloc1(4 * (size_t)m->n, &m->corner));
  PetscCall(PetscMalloc1(m->n, &m->number));
  if (f->physical) PetscCall(PetscMalloc1(m->n, &m->label));
  m->n = 0;
  for (PetscInt i = 0; i < f->nfacets; i++) {
    const Facet *own = &f->facet[i];

    if (f->physical && !own->physical) continue;
    if (!m->n) m->sides = own->sides;
    if (own->sides != m->sides)
      Fail("%s: element %lld has %" PetscInt_FMT " sides and element %" PetscInt_FMT " %" PetscInt_FMT
           ", expected triangles or rectangles alone",
           f->g.source, (long long)own->tag, own->sides, m->number[0], m->sides);
    for (PetscInt k = 0; k < own->sides; k++) {
      const Tagged *node = Find(f->nnodes, f->node, own->node[k]);

      if (!node)
        Fail("%s: element %lld has the node %lld, which $Nodes does not have", f->g.source, (long long)own->tag,
             (long long)own->node[k]);
      m->corner[m->sides * (size_t)m->n + (size_t)k] = (PetscInt)(node - f->node);
    }
    m->number[m->n] = (PetscInt)own->tag;
    if (m->label) m->label[m->n] = own->physical;
    m->n++;
  }
  m->triangles = m->sides == 3 ? PETSC_TRUE : PETSC_FALSE;
  m->nvertices = f->nnodes;
  PetscCall(PetscMalloc1(3 * (size_t)f->nnodes, &m->vertex));
  PetscCall(PetscMalloc1(f->nnodes, &m->vertex_number));
  for (PetscInt v = 0; v < f->nnodes; v++) {
    PetscCall(PetscArraycpy(m->vertex + 3 * (size_t)v, f->x + 3 * (size_t)f->node[v].where, 3));
    m->vertex_number[v] = (PetscInt)f->node[v].tag;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultMeshReadGmsh(const char name[], const char source[], SlipFaultMeshFile *m)
{
  Gmsh f = {.nnodes = 0};

  PetscFunctionBegin;
  PetscCall(SlipGmshOpen(name, source, &f.g));
  PetscCall(ReadSections(&f));
  PetscCall(CheckGroups(&f));
  PetscCall(TakeFacets(&f, m));
  m->names = f.physical ? f.names : NULL;
  if (!f.physical) PetscCall(PetscFree(f.names));
  PetscCall(SlipGmshClose(&f.g));
  PetscCall(PetscFree(f.x));
  PetscCall(PetscFree(f.node));
  PetscCall(PetscFree(f.surface));
  PetscCall(PetscFree(f.facet));
  PetscFunctionReturn(PETSC_SUCCESS);
}
