/*
  Checks the unit of numbers in a mesh file. Few files state it: the formats of Gmsh and STL cannot. The unit of an
  option or an attribute is used. Without one, numbers are metres if they cannot be kilometres, and otherwise the file
  is refused with a message about the option: a fault in the wrong unit would be a thousand times smaller, and would
  run. Degrees, and heights in another unit than the rest, are always refused.
*/
#include <slipstep/private/slipmesh.h>
#include <slipstep/private/slipelasticity.h>

/* Limits of depth, extent and cell size of a fault [km]: earthquakes end at 700 km, plates at 10,000 km. Larger numbers
   are metres. */
#define KM_DEEPEST 800.0
#define KM_ACROSS 10000.0
#define KM_CELL 300.0
/* Limits for depths and horizontal coordinates of one unit: no fault is so many times deeper than long, or so many
   times deeper than it is across, or so many times longer than deep. km beside m, or degrees beside km, differ by 100
   and more. */
#define TALL 20.0
#define BURIED 500.0
#define SHALLOW 300.0
/* Degrees beside lengths are detected for any unit: one degree is 111 km, so that cells are so many times higher than
   wide, and the fault is farther from the origin than it is across, as most places are from 0 degrees. */
#define DEGREES_STEEP 3.0
#define DEGREES_FAR 1.5

/* The numbers of all cells */
typedef struct {
  PetscReal low[3], top[3], area;
  PetscInt n, steep;                        /* number of cells, and of cells that are far higher than wide */
  PetscReal across, deep, high, side, away; /* horizontal extent, |z|, extent of z, mean cell, centre to origin */
} Numbers;

static void Include(Numbers *s, const PetscReal low[3], const PetscReal top[3], PetscReal area)
{
  for (int k = 0; k < 3; k++) {
    s->low[k] = PetscMin(s->low[k], low[k]);
    s->top[k] = PetscMax(s->top[k], top[k]);
  }
  s->area += area;
  s->n++;
  s->steep += top[2] - low[2] > DEGREES_STEEP * PetscMax(top[0] - low[0], top[1] - low[1]) ? 1 : 0;
}

static void IncludeRow(Numbers *s, const PetscReal row[], PetscInt columns)
{
  PetscReal low[3], top[3], along[2] = {1, 0}, sine = 1, cosine = 0;

  if (columns == MESH_COLUMNS) {
    SlipDegrees(row[5], &along[1], &along[0]);
    SlipDegrees(row[6], &sine, &cosine);
  }
  for (int k = 0; k < 3; k++) {
    const PetscReal half = k < 2
                             ? 0.5 * (PetscAbsReal(along[k]) * row[3] + PetscAbsReal(along[1 - k] * cosine) * row[4])
                             : 0.5 * sine * row[4];

    low[k] = row[k] - half;
    top[k] = row[k] + half;
  }
  Include(s, low, top, row[3] * row[4]);
}

static void IncludeCorners(Numbers *s, const SlipFaultMeshFile *m, PetscInt i)
{
  const PetscInt *corner = m->corner + (size_t)m->sides * (size_t)i;
  const PetscReal *p[3];
  PetscReal low[3], top[3], area = 0;

  for (int k = 0; k < 3; k++) p[k] = m->vertex + 3 * (size_t)corner[k];
  for (int k = 0; k < 3; k++) {
    const int x = (k + 1) % 3, y = (k + 2) % 3;

    low[k] = top[k] = p[0][k];
    for (PetscInt v = 1; v < m->sides; v++) {
      low[k] = PetscMin(low[k], m->vertex[3 * (size_t)corner[v] + k]);
      top[k] = PetscMax(top[k], m->vertex[3 * (size_t)corner[v] + k]);
    }
    area += PetscSqr((p[1][x] - p[0][x]) * (p[2][y] - p[0][y]) - (p[1][y] - p[0][y]) * (p[2][x] - p[0][x]));
  }
  Include(s, low, top, PetscSqrtReal(area)); /* twice a triangle's area: side is that of two triangles' square */
}

static Numbers NumbersOf(const SlipFaultMeshFile *m)
{
  Numbers s = {.low = {PETSC_MAX_REAL, PETSC_MAX_REAL, PETSC_MAX_REAL},
               .top = {PETSC_MIN_REAL, PETSC_MIN_REAL, PETSC_MIN_REAL}};

  for (PetscInt i = 0; i < m->n; i++) {
    if (m->sides)
      IncludeCorners(&s, m, i);
    else
      IncludeRow(&s, m->rows + (size_t)i * m->columns, m->columns);
  }
  s.across = PetscHypotReal(s.top[0] - s.low[0], s.top[1] - s.low[1]);
  s.away = 0.5 * PetscHypotReal(s.top[0] + s.low[0], s.top[1] + s.low[1]);
  s.deep = PetscMax(PetscAbsReal(s.low[2]), PetscAbsReal(s.top[2]));
  s.high = s.top[2] - s.low[2];
  s.side = PetscSqrtReal(s.area / PetscMax(s.n, 1));
  return s;
}

/* Returns whether x and y can be longitude and latitude in either order, if this many units are a degree. */
static PetscBool InDegrees(const Numbers *s, PetscReal degree)
{
  PetscReal largest[2];

  for (int k = 0; k < 2; k++) largest[k] = PetscMax(PetscAbsReal(s->low[k]), PetscAbsReal(s->top[k])) / degree;
  return PetscMin(largest[0], largest[1]) <= 90 && PetscMax(largest[0], largest[1]) <= 360 ? PETSC_TRUE : PETSC_FALSE;
}

/*
  SlipFaultMeshCheckUnit - refuses numbers of a file that are no lengths, and those whose unit is not certain

  unit, frame: an option or an attribute of the file gives it. Numbers given in kilometres are converted to metres
  before, so that degrees are looked for in both units.
*/
PetscErrorCode SlipFaultMeshCheckUnit(const char prefix[], const char source[], PetscBool unit, PetscBool frame,
                                      const SlipFaultMeshFile *m)
{
  const Numbers s = NumbersOf(m);
  const PetscBool degrees = InDegrees(&s, 1), far = s.away > DEGREES_FAR * s.across ? PETSC_TRUE : PETSC_FALSE;
  const double one = degrees ? 1 : 1000;

  PetscFunctionBegin;
  if (!(s.across < PETSC_MAX_REAL && s.high < PETSC_MAX_REAL)) PetscFunctionReturn(PETSC_SUCCESS); /* refused later */
  PetscCheck((unit && frame) || !far || !InDegrees(&s, 1000) || s.deep <= s.across || 2 * s.steep <= s.n,
             PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
             "%s: horizontal coordinates from %.6g to %.6g and from %.6g to %.6g, beside depths to %.6g, look like "
             "latitudes and longitudes: expected lengths, as of a map projection. If they are lengths, say so by "
             "-%sfault_mesh_unit and -%sfault_mesh_frame",
             source, s.low[0] / one, s.top[0] / one, s.low[1] / one, s.top[1] / one, s.deep / one, prefix, prefix);
  if (unit || s.deep == 0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCheck(
    s.high <= TALL * s.across && s.deep <= BURIED * s.across && SHALLOW * s.deep >= s.across, PETSC_COMM_SELF,
    PETSC_ERR_FILE_UNEXPECTED,
    "%s: %.6g across in x and y, and depths from %.6g to %.6g, do not look like one unit of length, as where x and "
    "y are in degrees or kilometres and z in metres: expected one for all. If they are, say so by "
    "-%sfault_mesh_unit m or km",
    source, (double)s.across, (double)s.low[2], (double)s.top[2], prefix);
  PetscCheck(
    s.deep > KM_DEEPEST || s.across > KM_ACROSS || s.side > KM_CELL, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
    "%s: a fault that is %.4g across and reaches down to %.4g, in cells of %.3g, may be one of metres or one "
    "of kilometres%s, and nothing says which: expected -%sfault_mesh_unit m or km, or in HDF5 the attribute "
    "units = \"m\"",
    source, (double)s.across, (double)s.deep, (double)s.side,
    degrees && s.away > s.across ? ", or x and y are degrees, which a map projection makes lengths" : "", prefix);
  PetscFunctionReturn(PETSC_SUCCESS);
}
