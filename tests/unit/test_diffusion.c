/* Fluid that diffuses in the cells of a fault, against closed forms. */
#include "unit.h"
#include "tempdir.h"
#include "cells.h"
#include "diffusion.h"
#include <slipstep/private/slipfaultloads.h>

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
  ok(FluidTriangles(file, n, n, 0.5, Plane));
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
  const int levels = ratio < 1 ? 2 : LEVELS;
  PetscReal error[LEVELS];

  for (int level = 0; level < levels; level++) {
    const PetscInt n = (ratio < 1 ? 48 : 32) << level;
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
  for (int level = 1; level < levels; level++) AssertLess(error[level], error[level - 1] / 3.5);
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

/* A point source of a rate in the middle that began at time 0 (Theis 1935) */
typedef struct {
  PetscReal rate, mobility, diffusivity, time, at[2]; /* [m^3/s], [m^3/(Pa s)], [m^2/s], [s], along and down [m] */
} Well;

static PetscReal Theis(const PetscReal at[3], const void *ctx)
{
  const Well *w = (const Well *)ctx;
  const PetscReal square = PetscSqr(at[0] - w->at[0]) + PetscSqr(at[2] - w->at[1]);

  return w->rate / (4 * PETSC_PI * w->mobility) * SlipExponentialIntegral(square / (4 * w->diffusivity * w->time));
}

/* The cell that holds a point, by the least distance of centres */
static PetscInt CellAt(const Fluid *f, PetscReal x, PetscReal z, SlipFaultCell *found)
{
  PetscReal least = PETSC_MAX_REAL;
  PetscInt at = 0;

  for (PetscInt i = 0; i < f->mesh.n; i++) {
    SlipFaultCell cell;
    PetscReal square;

    f->mesh.kind->cell(&f->mesh, SlipFaultMeshRow(&f->mesh, i), &cell);
    square = PetscSqr(cell.centre[0] - x) + PetscSqr(cell.centre[2] - z);
    if (square >= least) continue;
    least = square;
    at = i;
    *found = cell;
  }
  return at;
}

/* Where a Theis well is farther than 150 m the error falls by four with h and dt. The centre of the cell that the fluid
   enters is that of the well: the mean over a square, and over a triangle, of a source differs from the point by h^2,
   and the border, 900 m away, sees exp(-20) of it. */
static void theis(void **state)
{
  Maker *const maker[] = {Grid, Refined, Triangles};

  for (size_t m = 0; m < PETSC_STATIC_ARRAY_LENGTH(maker); m++) {
    const FluidRock rock = {1e-10, 1e-10, 1e-10, NAN};
    PetscReal error[LEVELS];

    for (int level = 0; level < LEVELS; level++) {
      const PetscInt n = 30 << level, steps = n / 2;
      Well well = {1e-3, 1e-10, 1, 1e4, {0, 0}};
      PetscReal sum = 0, norm = 0;
      SlipFaultCell cell;
      Fluid f;
      PetscInt at;

      Make(maker[m], n, &rock, &f);
      at = CellAt(&f, HALF - 1, DEPTH + HALF + 1, &cell);
      f.source[at] = well.rate;
      well.at[0] = cell.centre[0];
      well.at[1] = cell.centre[2];
      for (PetscInt k = 0; k < steps; k++) ok(FluidStep(&f, well.time / (PetscReal)steps));
      for (PetscInt i = 0; i < f.mesh.n; i++) {
        PetscReal mean;

        f.mesh.kind->cell(&f.mesh, SlipFaultMeshRow(&f.mesh, i), &cell);
        if (PetscHypotReal(cell.centre[0] - HALF, cell.centre[2] - DEPTH - HALF) < 150) continue;
        mean = FluidMean(&cell, Theis, &well);
        sum += f.storage[i] * PetscSqr(f.p[i] - mean);
        norm += f.storage[i] * PetscSqr(mean);
      }
      error[level] = sqrt(sum / norm);
      ok(FluidDestroy(&f));
    }
    assert_true(error[2] < error[0] / 12);
  }
}

/* Half planes of n x n cells of side h that meet in one vertical edge at the middle of the square */
static void Fan(const char file[], PetscInt planes, const PetscReal strike[], PetscInt n)
{
  const PetscReal h = HALF / (PetscReal)n;
  const PetscInt rows = 2 * planes * n * n;
  PetscReal *column;
  SlipCells cells;

  ok(PetscMalloc1(8 * rows, &column));
  for (PetscInt r = 0; r < rows; r++) { /* plane by plane, n along by 2 n down */
    const PetscInt q = r % (2 * n * n);
    const PetscReal along = h * ((PetscReal)(q % n) + 0.5), a = strike[r / (2 * n * n)] * PETSC_PI / 180;
    const PetscReal row[8] = {
      along * cos(a), along * sin(a), DEPTH + h * ((PetscReal)(q / n) + 0.5), h, h, a * 180 / PETSC_PI, 90, 0};

    for (int c = 0; c < 8; c++) column[c * rows + r] = row[c];
  }
  cells = DippingCellsOfColumns(rows, column);
  ok(WriteCells(file, &cells));
  ok(PetscFree(column));
}

/* A Gaussian on the first of some half planes, 300 m from their edge: with m planes, (2 - m)/m of it comes back from
   the
   edge and 2/m goes on in each of the others, as p and the fluxes there show; two planes are one that is folded. Order
   as above. */
static void Folded(PetscInt planes, const PetscReal strike[])
{
  const FluidRock rock = {2e-10, 1e-10, 1e-10, NAN};
  const PetscReal end = 3e4, place = 300, share = 2.0 / (PetscReal)planes;
  PetscReal error[2];

  for (int level = 0; level < 2; level++) {
    const PetscInt n = 20 << level, steps = n;
    char dir[TEMPDIR_LENGTH], file[TEMPDIR_FILE];
    PetscReal sum = 0, norm = 0, other = 0, stored[2];
    Fluid f;

    assert_int_equal(0, TempDirFile("diffusion", "mesh.h5", dir, file));
    Fan(file, planes, strike, n);
    ok(FluidCreate(PETSC_COMM_SELF, file, square, &rock, &f));
    assert_int_equal(0, TempDirRemove(dir));
    assert_int_equal(2 * planes * n * n, f.mesh.n);
    for (int late = 0; late < 2; late++) {
      const PetscReal variance = 100 * 100 + late * 2 * rock.along / rock.storage * end;
      const Gauss g = {variance, variance, rock.storage};

      for (PetscInt k = 0; k < steps && late; k++) ok(FluidStep(&f, end / (PetscReal)steps));
      ok(FluidStored(&f, &stored[late]));
      for (PetscInt i = 0; i < f.mesh.n; i++) {
        const PetscInt row = SlipFaultMeshRow(&f.mesh, i);
        SlipFaultCell cell;
        PetscReal mean, along;

        f.mesh.kind->cell(&f.mesh, row, &cell);
        along = PetscHypotReal(cell.centre[0], cell.centre[1]);
        cell = (SlipFaultCell){.centre = {HALF + along + place, 0, cell.centre[2]},
                               .size = {cell.size[0], cell.size[1]},
                               .direction = {{1, 0, 0}, {0, 0, 1}, {0, 1, 0}}};
        mean = FluidMean(&cell, Gaussian, &g) * (row < 2 * n * n ? share - 1 : share);
        cell.centre[0] -= 2 * place;
        if (row < 2 * n * n) mean += FluidMean(&cell, Gaussian, &g);
        if (!late) f.p[i] = mean;
        sum += late * f.storage[i] * PetscSqr(f.p[i] - mean);
        norm += late * f.storage[i] * PetscSqr(mean);
        if (row >= 2 * n * n) other += late * f.storage[i] * f.p[i];
      }
      if (!late) ok(FluidStored(&f, &stored[0]));
    }
    error[level] = sqrt(sum / norm);
    assert_true(other > 0.03 * stored[1]);
    AssertNear(stored[1], stored[0], 1e-12 * stored[0]);
    ok(FluidDestroy(&f));
  }
  assert_true(error[1] < error[0] / 3.5);
}

static void faults_that_meet(void **state)
{
  Folded(2, (const PetscReal[]){0, 130});
  Folded(3, (const PetscReal[]){0, 130, 250});
  Folded(4, (const PetscReal[]){0, 90, 180, 270});
}

/* sin(pi x/L) sin(pi z/L) in the middle, and the exponential of its time: a plane whose border is at p = 0 */
static PetscReal Sine(const PetscReal at[3], const void *ctx)
{
  return *(const PetscReal *)ctx * sin(PETSC_PI * at[0] / (2 * HALF)) * sin(PETSC_PI * (at[2] - DEPTH) / (2 * HALF));
}

/* Relative error of the fluxes at the centres, which are those of the last stage, at the end of the step */
static PetscReal FluxError(const Fluid *f, PetscReal mobility, PetscReal size)
{
  const PetscReal k = PETSC_PI / (2 * HALF);
  PetscReal *flux, sum = 0, norm = 0;

  ok(PetscMalloc1(2 * f->mesh.n, &flux));
  ok(SlipDiffusionFlow(f->d, NULL, flux));
  for (PetscInt i = 0; i < f->mesh.n; i++) {
    SlipFaultCell c;

    f->mesh.kind->cell(&f->mesh, SlipFaultMeshRow(&f->mesh, i), &c);
    for (int j = 0; j < 2; j++) {
      const PetscReal x = k * c.centre[0], z = k * (c.centre[2] - DEPTH), *d = c.direction[j];
      const PetscReal exact = -mobility * size * k * (d[0] * cos(x) * sin(z) + d[2] * sin(x) * cos(z));

      sum += PetscSqr(flux[2 * i + j] - exact);
      norm += PetscSqr(exact);
    }
  }
  ok(PetscFree(flux));
  return sqrt(sum / norm);
}

/* Fluid leaves through an open border as the first term of the Fourier series says. The flux at the border is told for
   the last stage only: its integral is tested with the volume in tests/mpi. */
static void open_border(void **state)
{
  Maker *const maker[] = {Grid, Triangles};
  const FluidRock rock = {1e-10, 1e-10, 1e-10, 0};
  const PetscReal end = 2e5;

  for (size_t m = 0; m < PETSC_STATIC_ARRAY_LENGTH(maker); m++) {
    PetscReal error[LEVELS];

    for (int level = 0; level < LEVELS; level++) {
      const PetscInt n = 10 << level;
      PetscReal size = 1e6;
      Fluid f;

      Make(maker[m], n, &rock, &f);
      for (PetscInt i = 0; i < f.mesh.n; i++) {
        SlipFaultCell cell;

        f.mesh.kind->cell(&f.mesh, SlipFaultMeshRow(&f.mesh, i), &cell);
        f.p[i] = FluidMean(&cell, Sine, &size);
      }
      for (PetscInt k = 0; k < n; k++) ok(FluidStep(&f, end / (PetscReal)n));
      size *= exp(-2 * PetscSqr(PETSC_PI / (2 * HALF)) * end);
      error[level] = Error(&f, Sine, &size);
      AssertLess(FluxError(&f, rock.along, size), (m ? 0.04 : 0.01) * 20 / (PetscReal)n);
      ok(FluidDestroy(&f));
    }
    for (int level = 1; level < LEVELS; level++) assert_true(error[level] < error[level - 1] / 3.5);
  }
}

/* Steady pressure around a well in the middle line of the square with an open border, as a series in x whose terms fall
   with the distance |z - z0| */
static PetscReal Steady(PetscReal x, PetscReal z, PetscReal x0, PetscReal z0)
{
  const PetscReal side = 2 * HALF, low = PetscMin(z, z0), high = PetscMax(z, z0);
  PetscReal sum = 0;

  for (int m = 1; m < 4000; m++) {
    const PetscReal k = m * PETSC_PI / side; /* sinh sinh/sinh without overflow */
    const PetscReal fall =
      exp(-k * (high - low)) * (1 - exp(-2 * k * low)) * (1 - exp(-2 * k * (side - high))) / (1 - exp(-2 * k * side));

    sum += sin(k * x0) * sin(k * x) * fall / (k * side);
  }
  return sum;
}

/* A doublet, steady after one large step: far from the wells the error is that of h^2, and in a well's cell the
   pressure
   is that at Peaceman's radius, within 2e-3 Q/(2 pi T) on a grid of squares and 0.3 on shaken
   triangles, three times by how much the logarithm of the radius scatters. */
static void doublet(void **state)
{
  Maker *const maker[] = {Grid, Triangles};
  const FluidRock rock = {1e-10, 1e-10, 1e-10, 0};
  const PetscReal rate = 1e-3;

  for (int m = 0; m < 2; m++) {
    PetscReal error[2];

    for (int level = 0; level < 2; level++) {
      const PetscInt n = 41 + 40 * level;
      SlipFaultCell cell[2], c;
      PetscReal *radius, sum = 0, norm = 0;
      PetscInt at[2];
      Fluid f;

      Make(maker[m], n, &rock, &f);
      ok(PetscMalloc1(f.mesh.n, &radius));
      ok(SlipDiffusionRadius(f.d, radius));
      for (int k = 0; k < 2; k++) at[k] = CellAt(&f, k ? 1300 : 700, DEPTH + HALF, &cell[k]);
      for (PetscInt i = 0; i < f.mesh.n; i++) f.work[i] = 0;
      for (int k = 0; k < 2; k++) f.work[at[k]] = (k ? -1e12 : 1e12) * rate;
      ok(SlipDiffusionSolve(f.d, 1e12, f.work, f.p));
      for (PetscInt i = 0; i < f.mesh.n; i++) {
        PetscReal exact = 0;

        f.mesh.kind->cell(&f.mesh, SlipFaultMeshRow(&f.mesh, i), &c);
        if (PetscAbsReal(c.centre[2] - DEPTH - HALF) < 200 || i % 7) continue;
        for (int k = 0; k < 2; k++)
          exact += (k ? -1 : 1) * rate / rock.along *
                   Steady(c.centre[0], c.centre[2] - DEPTH, cell[k].centre[0], cell[k].centre[2] - DEPTH);
        sum += PetscSqr(f.p[i] - exact);
        norm += PetscSqr(exact);
      }
      error[level] = sqrt(sum / norm);
      for (int k = 0; k < 2; k++) {
        PetscReal exact = 0;

        for (int q = 0; q < 2; q++)
          exact += (q ? -1 : 1) * rate / rock.along *
                   Steady(cell[k].centre[0], cell[k].centre[2] - DEPTH + radius[at[k]], cell[q].centre[0],
                          cell[q].centre[2] - DEPTH);
        AssertNear(f.p[at[k]], exact, (m ? 0.3 : 2e-3) * rate / (2 * PETSC_PI * rock.along));
      }
      ok(PetscFree(radius));
      ok(FluidDestroy(&f));
    }
    assert_true(error[1] < error[0] / 3);
  }
}

/* A closed fault and a step so large that storage is 1e-10 of what could flow: all pressures become their mean, to the
   rounding of the fluxes, 1e10 times 1e-16 (1e-5 on triangles that are shaken), and the volume stays. */
static void closed_border(void **state)
{
  const FluidRock rock = {1e-10, 1e-10, 1e-10, NAN};
  Maker *const maker[] = {Grid, Refined, Triangles};

  for (size_t m = 0; m < PETSC_STATIC_ARRAY_LENGTH(maker); m++) {
    PetscReal stored[2], whole = 0;
    Fluid f;

    Make(maker[m], 30, &rock, &f);
    for (PetscInt i = 0; i < f.mesh.n; i++) {
      f.p[i] = i % 3 ? 1e6 : 4e6;
      f.work[i] = f.storage[i] * f.p[i];
      whole += f.storage[i];
    }
    ok(FluidStored(&f, &stored[0]));
    ok(SlipDiffusionSolve(f.d, 5e12, f.work, f.p));
    ok(FluidStored(&f, &stored[1]));
    AssertNear(stored[1], stored[0], 1e-12 * stored[0]);
    for (PetscInt i = 0; i < f.mesh.n; i++) AssertNear(f.p[i], stored[0] / whole, 1e-4 * stored[0] / whole);
    ok(FluidDestroy(&f));
  }
}

static void errors(void **state)
{
  FluidRock rock = {1e-10, 1e-10, 1e-10, NAN};
  Fluid f;

  Make(Grid, 4, &rock, &f);
  rock.storage = 0;
  fails(FluidSet(&f, &rock), "storage > 0");
  rock.storage = 1e-10;
  rock.down = -1e-10;
  fails(FluidSet(&f, &rock), "no other one negative");
  rock.down = NAN;
  fails(FluidSet(&f, &rock), "finite");
  f.p[3] = NAN;
  fails(SlipDiffusionSolve(f.d, 1, f.p, f.p), "not finite");
  fails(SlipDiffusionSolve(f.d, 0, f.p, f.p), "more than 0");
  ok(FluidDestroy(&f));
}

SLIP_TESTS(list_of_a_grid, spreads, theis, faults_that_meet, open_border, doublet, closed_border, errors)
