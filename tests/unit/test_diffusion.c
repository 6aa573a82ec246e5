/* Fluid that diffuses in the cells of a fault, against closed forms. */
#include "unit.h"
#include "tempdir.h"
#include "cells.h"
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

/* Rows of columns x y z length width; 997 is prime, so that their order has nothing to do with places. */
static void WriteList(const char file[], PetscInt n, PetscReal row[][5])
{
  PetscReal *column;
  SlipCells cells;

  ok(PetscMalloc1(5 * n, &column));
  for (PetscInt k = 0; k < n; k++)
    for (int c = 0; c < 5; c++) column[c * n + k] = row[997 * k % n][c];
  cells = CellsOfColumns(n, column);
  ok(WriteCells(file, &cells));
  ok(PetscFree(column));
}

/* Cells along strike are half as long and wide where refined() */
static void Rows(PetscInt n, const char file[], PetscBool (*refined)(PetscReal x, PetscReal z))
{
  const PetscReal h = 2 * HALF / (PetscReal)n;
  PetscReal(*row)[5];
  PetscInt rows = 0;

  ok(PetscMalloc1(4 * n * n, &row));
  for (PetscInt k = 0; k < n * n; k++) {
    const PetscReal x = h * ((PetscReal)(k % n) + 0.5), z = h * ((PetscReal)(k / n) + 0.5);
    const int parts = refined && refined(x, z) ? 2 : 1;

    for (int q = 0; q < parts * parts; q++) {
      const PetscReal size = h / parts, shift = parts == 2 ? 0.5 * size : 0;
      const PetscReal cell[5] = {x + (q % 2 ? shift : -shift), 0, DEPTH + z + (q / 2 ? shift : -shift), size, size};

      memcpy(row[rows++], cell, sizeof(cell));
    }
  }
  WriteList(file, rows, row);
  ok(PetscFree(row));
}

static void List(PetscInt n, const char file[], PetscReal extent[MESH_REALS])
{
  (void)extent;
  Rows(n, file, NULL);
}

static PetscBool Corner(PetscReal x, PetscReal z)
{
  return x > HALF && z < HALF ? PETSC_TRUE : PETSC_FALSE;
}

static void Refined(PetscInt n, const char file[], PetscReal extent[MESH_REALS])
{
  (void)extent;
  Rows(n, file, Corner);
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
    const PetscInt n = 32 << level;
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
  Spreads(Refined, 1);
  Spreads(Refined, 0.1);
  Spreads(Grid, 1);
  Spreads(Triangles, 1);
  Spreads(Grid, 0.1);
  Spreads(Triangles, 0.1);
}

/* A list of the grid's cells in another order gives its pressures to the tolerance of the solver, 1e-9 of the largest
   change; one step */
static void list_of_a_grid(void **state)
{
  const FluidRock rock = {2e-10, 1e-10, 3e-11, 2e4};
  const PetscInt n = 23;
  PetscReal *p;
  Fluid f[2];

  ok(PetscMalloc1(n * n, &p));
  for (int k = 0; k < 2; k++) {
    PetscReal most = 0;

    Make(k ? List : Grid, n, &rock, &f[k]);
    assert_int_equal(n * n, f[k].mesh.N);
    for (PetscInt i = 0; i < n * n; i++) {
      const PetscInt row = SlipFaultMeshRow(&f[k].mesh, i), e = k ? 997 * row % (n * n) : row;

      f[k].source[i] = e == 200 ? 1e-3 : e == 403 ? -3e-4 : 0;
    }
    ok(FluidStep(&f[k], 1e6));
    for (PetscInt i = 0; i < n * n; i++) {
      const PetscInt row = SlipFaultMeshRow(&f[k].mesh, i), e = k ? 997 * row % (n * n) : row;

      most = PetscMax(most, PetscAbsReal(f[k].p[i]));
      if (k) AssertNear(f[k].p[i], p[e], 1e-9 * 1e6);
      p[e] = f[k].p[i];
    }
    assert_true(most > 1e6);
    ok(FluidDestroy(&f[k]));
  }
  ok(PetscFree(p));
}

SLIP_TESTS(list_of_a_grid, spreads)
