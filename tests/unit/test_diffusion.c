/* Fluid that diffuses in the cells of a fault, against closed forms. */
#include "unit.h"
#include "tempdir.h"
#include "diffusion.h"

enum { LEVELS = 3 };
#define HALF 1000.0 /* of a square plane [m] */
#define DEPTH 100.0

static const PetscReal square[MESH_REALS] = {
  [MESH_LENGTH_X] = 2 * HALF, [MESH_LENGTH_Z] = 2 * HALF, [MESH_DEPTH_TOP] = DEPTH, [MESH_STRIKE] = 0, [MESH_DIP] = 90};

static void Plane(const PetscReal from[2], PetscReal to[3])
{
  to[0] = 2 * HALF * from[0];
  to[1] = 0;
  to[2] = DEPTH + 2 * HALF * from[1];
}

typedef void Maker(PetscInt n, const char file[], PetscReal extent[MESH_REALS]);

static void Grid(PetscInt n, const char file[], PetscReal extent[MESH_REALS])
{
  (void)file;
  extent[MESH_NX] = extent[MESH_NZ] = (PetscReal)n;
}

static void Triangles(PetscInt n, const char file[], PetscReal extent[MESH_REALS])
{
  (void)extent;
  ok(FluidTriangles(file, n, n, 0.6, Plane));
}

/* The plane as n x n cells, or twice as many triangles */
static void Make(Maker *maker, PetscInt n, const FluidRock *rock, Fluid *f)
{
  char dir[TEMPDIR_LENGTH], file[TEMPDIR_FILE];
  PetscReal extent[MESH_REALS];

  assert_int_equal(0, TempDirFile("diffusion", "mesh.h5", dir, file));
  memcpy(extent, square, sizeof(extent));
  extent[MESH_NX] = 0;
  maker(n, file, extent);
  ok(FluidCreate(PETSC_COMM_SELF, extent[MESH_NX] > 0 ? "" : file, extent, rock, f));
  assert_int_equal(0, TempDirRemove(dir));
}

/* A Gaussian of unit volume around the middle, with these variances [m^2] */
typedef struct {
  PetscReal along, down, storage;
} Gauss;

static PetscReal Gaussian(const PetscReal at[3], const void *ctx)
{
  const Gauss *g = (const Gauss *)ctx;
  const PetscReal x = at[0] - HALF, z = at[2] - DEPTH - HALF;

  return exp(-0.5 * (x * x / g->along + z * z / g->down)) / (2 * PETSC_PI * sqrt(g->along * g->down) * g->storage);
}

/* Relative error of the means in the square norm */
static PetscReal Error(const Fluid *f, PetscReal (*exact)(const PetscReal at[3], const void *ctx), const void *ctx)
{
  PetscReal error = 0, norm = 0;

  for (PetscInt i = 0; i < f->mesh.n; i++) {
    SlipFaultCell cell;
    PetscReal mean;

    f->mesh.kind->cell(&f->mesh, SlipFaultMeshRow(&f->mesh, i), &cell);
    mean = FluidMean(&cell, exact, ctx);
    error += f->storage[i] * PetscSqr(f->p[i] - mean);
    norm += f->storage[i] * PetscSqr(mean);
  }
  return sqrt(error / norm);
}

/* The error at h, h/2, h/4 with steps in proportion: a method of second order divides it by four, here by 3.5 at least,
   as the cells of the first are a third of the width */
static void Spreads(Maker *maker, PetscReal ratio)
{
  const FluidRock rock = {2e-10, 1e-10, ratio * 1e-10, NAN};
  const PetscReal start = 120 * 120, end = 1e4;
  PetscReal error[LEVELS];

  for (int level = 0; level < LEVELS; level++) {
    const PetscInt n = 40 << level;
    Gauss g = {start, start, rock.storage};
    PetscReal before, after;
    Fluid f;

    Make(maker, n, &rock, &f);
    for (PetscInt i = 0; i < f.mesh.n; i++) {
      SlipFaultCell cell;

      f.mesh.kind->cell(&f.mesh, SlipFaultMeshRow(&f.mesh, i), &cell);
      f.p[i] = FluidMean(&cell, Gaussian, &g);
    }
    ok(FluidStored(&f, &before));
    for (PetscInt k = 0; k < n / 4; k++) ok(FluidStep(&f, end / (PetscReal)(n / 4)));
    ok(FluidStored(&f, &after));
    AssertNear(after, before, 1e-12 * before);
    g.along += 2 * rock.along / rock.storage * end;
    g.down += 2 * rock.down / rock.storage * end;
    error[level] = Error(&f, Gaussian, &g);
    ok(FluidDestroy(&f));
  }
  for (int level = 1; level < LEVELS; level++) assert_true(error[level] < error[level - 1] / 3.5);
}

static void spreads(void **state)
{
  Spreads(Grid, 1);
  Spreads(Triangles, 1);
  Spreads(Grid, 0.1);
  Spreads(Triangles, 0.1);
}

SLIP_TESTS(spreads)
