/* Irregular meshes: checks, hierarchical against dense storage, weights, Lanczos' viscosity, and whole runs. */
#include "operators.h"
#include "products.h"
#include <math.h>
#include "cells.h"
#include "faultstart.h"

enum { MAX = 4000 };

/* Cells in static memory. */
typedef struct {
  PetscInt n;
  PetscReal x[MAX], y[MAX], z[MAX], length[MAX], width[MAX];
} Mesh;

static void Add(Mesh *m, PetscReal x, PetscReal y, PetscReal z, PetscReal length, PetscReal width)
{
  assert_true(m->n < MAX);
  m->x[m->n] = x;
  m->y[m->n] = y;
  m->z[m->n] = z;
  m->length[m->n] = length;
  m->width[m->n++] = width;
}

/* nx * nz cells of growing width and of lengths that alternate by the factor ratio. */
static void AddPlane(Mesh *m, PetscInt nx, PetscInt nz, PetscReal ratio, PetscReal y)
{
  PetscReal top = 0;

  for (PetscInt k = 0; k < nz; k++) {
    const PetscReal width = 100 * (1 + (ratio - 1) * k / nz);
    PetscReal left = 0;

    for (PetscInt i = 0; i < nx; i++) {
      const PetscReal length = 100 * (1 + (ratio - 1) * PetscAbsReal(2 * i - nx + 1.0) / nx);

      Add(m, left + 0.5 * length, y, top + 0.5 * width, length, width);
      left += length;
    }
    top += width;
  }
}

static SlipCells CellsOf(const Mesh *m)
{
  return (SlipCells){.n = m->n,
                     .x = m->x,
                     .y = m->y,
                     .z = m->z,
                     .length = m->length,
                     .width = m->width,
                     .kernel = ROCK(0.3, PETSC_FALSE, SLIP_AVERAGE_CENTRE)};
}

static Mat Stiffness(const Mesh *m, const char *type, PetscReal tolerance)
{
  const SlipCells cells = CellsOf(m);
  Mat S;

  ok(MatCreateSlipCellStiffness(PETSC_COMM_SELF, &cells, type, tolerance, &S));
  return S;
}

static PetscReal EntryOf(Mat A, PetscInt i)
{
  PetscScalar value;

  ok(MatGetValues(A, 1, &i, 1, &i, &value));
  return value;
}

static PetscReal Distance(Mat A, Mat B, Vec x)
{
  PetscReal distance;

  ok(ProductDistance(A, B, x, &distance));
  return distance;
}

/* Pseudorandom in (-1, 1), or a smooth hump. */
static Vec TestVector(Mat A, const Mesh *m, PetscBool smooth)
{
  Vec x;
  PetscReal *a, top = 0;
  PetscInt seed = 1;

  ok(MatCreateVecs(A, &x, NULL));
  ok(VecGetArrayWrite(x, &a));
  for (PetscInt i = 0; i < m->n; i++) top = PetscMax(top, m->x[i]);
  for (PetscInt i = 0; i < m->n; i++) {
    seed = (seed * 1103 + 12345) % 65536;
    a[i] = smooth ? sin(PETSC_PI * m->x[i] / top) * (1 + m->z[i] / top) : seed / 32768.0 - 1;
  }
  ok(VecRestoreArrayWrite(x, &a));
  return x;
}

/* The error of the whole in the Frobenius norm is at most the tolerance, as it is for every low-rank block; products
   with random and with smooth slip, whose stress is about a tenth of a random one's, are within ten tolerances. */
static void hierarchical_to_the_tolerance(void **state)
{
  static Mesh mesh;
  const PetscReal tolerances[] = {1e-4, 1e-8, 1e-11}, share[] = {0.2, 0.35, 0.46};
  Mat dense;

  AddPlane(&mesh, 40, 20, 4, 0);
  AddPlane(&mesh, 30, 15, 2, 150);
  dense = Stiffness(&mesh, "dense", 0.5);
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(tolerances); k++) {
    Mat H = Stiffness(&mesh, "hmat", tolerances[k]), whole, transpose;
    PetscReal norm, error, most, all;
    Vec d, e;

    ok(MatScale(H, 2));
    ok(MatScale(H, 0.5));
    for (int smooth = 0; smooth < 2; smooth++) {
      Vec x = TestVector(H, &mesh, (PetscBool)smooth);

      AssertLess(Distance(H, dense, x), 10 * tolerances[k]);
      ok(VecDestroy(&x));
    }
    ok(MatConvert(H, MATDENSE, MAT_INITIAL_MATRIX, &whole));
    ok(MatNorm(dense, NORM_FROBENIUS, &norm));
    ok(MatAXPY(whole, -1, dense, SAME_NONZERO_PATTERN));
    ok(MatNorm(whole, NORM_FROBENIUS, &error));
    AssertLess(error, tolerances[k] * norm);
    AssertLess(0, error); /* some blocks are of low rank */
    ok(MatConvert(H, MATDENSE, MAT_INITIAL_MATRIX, &transpose));
    ok(MatTranspose(transpose, MAT_INPLACE_MATRIX, &transpose));
    ok(MatAXPY(whole, 1, dense, SAME_NONZERO_PATTERN));
    ok(MatAXPY(whole, -1, transpose, SAME_NONZERO_PATTERN));
    ok(MatNorm(whole, NORM_FROBENIUS, &error));
    AssertLess(error, 1e-15 * norm); /* whatever its precision */
    ok(MatSlipGetMemory(H, &most, &all));
    AssertLess(all, share[k] * 8 * mesh.n * mesh.n); /* all in double precision: 0.28, 0.41, 0.48 */
    ok(MatCreateVecs(H, &d, &e));
    ok(MatGetDiagonal(H, d));
    ok(MatGetDiagonal(dense, e));
    AssertVecNear(d, e, NORM_INFINITY, 1e-15 * norm);
    ObjectsDestroy(&d, &e, &whole, &transpose, &H);
  }
  ok(MatDestroy(&dense));
}

/* Cells of a uniform grid give the grid's stiffness; the kernel on one plane is the same, so rounding only. */
static void uniform_cells_are_the_grid(void **state)
{
  static Mesh mesh;
  const SlipGrid grid = {
    .nx = 9, .nz = 7, .length_x = 900, .length_z = 700, .kernel = ROCK(0.3, PETSC_FALSE, SLIP_AVERAGE_CENTRE)};
  Mat K, S;
  Vec weights;

  AddPlane(&mesh, 9, 7, 1, 0);
  S = Stiffness(&mesh, "dense", 0.5);
  ok(MatCreateSlipStiffness(PETSC_COMM_SELF, &grid, "dense", &K));
  ok(MatSlipGetWeights(S, &weights));
  assert_null(weights);
  assert_true(MatDistance(S, K) < 1e-12);
  ObjectsDestroy(&S, &K);
}

static void all_forms_agree(SlipCells cells, SlipAverage average, SlipGrid *grid)
{
  Mat dense, hmat, K = NULL;
  PetscReal error;

  cells.kernel.average = average;
  ok(MatCreateSlipCellStiffness(PETSC_COMM_SELF, &cells, "dense", 0.5, &dense));
  ok(MatCreateSlipCellStiffness(PETSC_COMM_SELF, &cells, "hmat", 1e-8, &hmat));
  error = MatDistance(hmat, dense);
  assert_true(error > 0 && error < 1e-8);
  if (grid) {
    grid->kernel.average = average;
    ok(MatCreateSlipStiffness(PETSC_COMM_SELF, grid, "dense", &K));
    AssertLess(MatDistance(K, dense), 1e-12);
  }
  ObjectsDestroy(&dense, &hmat, &K);
}

/* Averages over cells: hierarchical is dense to its tolerance; a mesh that is the grid has the grid's stiffness, whose
   border is found from the cells. */
static void averages_of_cells(void **state)
{
  static Mesh uniform, graded;
  SlipGrid grid = {
    .nx = 25, .nz = 20, .length_x = 2500, .length_z = 2000, .kernel = ROCK(0.3, PETSC_FALSE, SLIP_AVERAGE_CENTRE)};

  AddPlane(&uniform, 25, 20, 1, 0);
  all_forms_agree(CellsOf(&uniform), SLIP_AVERAGE_CELL, &grid);
  all_forms_agree(CellsOf(&uniform), SLIP_AVERAGE_WHOLE, &grid);
  AddPlane(&graded, 30, 20, 4, 0);
  AddPlane(&graded, 20, 15, 2, 150);
  all_forms_agree(CellsOf(&graded), SLIP_AVERAGE_CELL, NULL);
  all_forms_agree(CellsOf(&graded), SLIP_AVERAGE_WHOLE, NULL);
}

/* The stress of uniform slip on a mesh is that of the whole rectangle, averaged over its cells, whatever they are, but
   for the border's core: large cells beside small ones share parts of their edges. */
static void uneven_cells_leave_nothing_between(void **state)
{
  static Mesh mesh;
  const PetscReal h = 100;
  SlipCells cells;
  Mat S;
  Vec one, force;
  const PetscScalar *f;
  PetscReal unit;

  Add(&mesh, 2 * h, 0, 12 * h, 4 * h, 4 * h); /* one large cell, 4 x 4 small ones beside it, and a frame of cells */
  for (int i = 0; i < 4; i++)
    for (int k = 0; k < 4; k++) Add(&mesh, (4.5 + i) * h, 0, (10.5 + k) * h, h, h);
  Add(&mesh, 4 * h, 0, 8 * h, 8 * h, 4 * h);
  Add(&mesh, 4 * h, 0, 16 * h, 8 * h, 4 * h);
  Add(&mesh, -2 * h, 0, 12 * h, 4 * h, 12 * h);
  Add(&mesh, 10 * h, 0, 12 * h, 4 * h, 12 * h);
  cells = CellsOf(&mesh);
  cells.kernel.average = SLIP_AVERAGE_WHOLE;
  ok(MatCreateSlipCellStiffness(PETSC_COMM_SELF, &cells, "dense", 0.5, &S));
  ok(MatCreateVecs(S, &one, &force));
  ok(VecSet(one, 1));
  ok(MatMult(S, one, force));
  f = VecRead(force);
  unit = mesh.n / (16 * 12 * h * h);
  for (PetscInt i = 0; i < 17; i++) {
    const SlipRectangle whole = {4 * h, 0, 12 * h, 16 * h, 12 * h};
    const SlipRectangle cell = {mesh.x[i], 0, mesh.z[i], mesh.length[i], mesh.width[i]};
    const PetscReal core[2] = {1, 1};
    const PetscReal expected =
      unit * cell.length * cell.width * SlipKernelAverage(30e9, 0.3, &cell, &whole, core, PETSC_FALSE);

    assert_true(PetscAbsReal(f[i] - expected) < 1e-12 * EntryOf(S, i));
  }
  ObjectsDestroy(&one, &force, &S);
}

static void bad_cells_are_refused(void **state)
{
  static const PetscReal bad[][5] = {
    {50, 0, 150, 0, 100},        {50, 0, 150, 100, -1}, {50, 0, 40, 100, 100},    {NAN, 0, 150, 100, 100},
    {50, 0, 150, 100, INFINITY}, {99, 0, 50, 100, 100}, {50, 1e-9, 99, 100, 100},
  };

  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(bad); k++) {
    static Mesh mesh;
    SlipCells cells;

    mesh.n = 0;
    AddPlane(&mesh, 3, 1, 1, 0);
    cells = CellsOf(&mesh);
    ok(SlipCellsCheck(PETSC_COMM_SELF, &cells, "mesh"));
    Add(&mesh, bad[k][0], bad[k][1], bad[k][2], bad[k][3], bad[k][4]);
    cells = CellsOf(&mesh);
    assert_int_equal(PETSC_ERR_ARG_OUTOFRANGE, (int)SlipCellsCheck(PETSC_COMM_SELF, &cells, "mesh"));
  }
}

/* ---- whole runs ---- */

static void WriteMesh(const char file[], const Mesh *m)
{
  const SlipCells cells = CellsOf(m);

  ok(WriteCells(file, &cells));
}

/* Mean slip and steps of 10 s; file may be NULL for the grid of 9 x 7 cells of 100 m. */
static void RunFault(const char file[], const char type[], const char scaling[], PetscReal *slip, PetscInt *steps)
{
  SlipFault fault;
  SlipFaultObservables o;
  TS ts;
  Vec w;

  ok(SlipFaultCreate(PETSC_COMM_SELF, &fault));
  if (file)
    ok(SlipFaultSetString(fault, "mesh", file));
  else
    ok(FaultSetReals(fault, {"nx", 9}, {"nz", 7}, {"length_x", 900}, {"length_z", 700}));
  ok(FaultSetStrings(fault, {"operator", type}, {"stiffness_scaling", scaling}));
  ok(FaultSetReals(fault, {"thickness", 900}, {"friction_slip", 0.02}));
  ok(FaultStart(fault, TSADAPTHEURISTIC, 0, 10, &w, &ts));
  ok(TSSetTolerances(ts, PETSC_DEFAULT, NULL, 1e-3, NULL));
  ok(TSSolve(ts, w));
  ok(SlipFaultGetObservables(fault, 10, w, NULL, &o));
  *slip = o.mean_slip;
  ok(TSGetStepNumber(ts, steps));
  ObjectsDestroy(&w, &ts, &fault);
}

static void Near(PetscReal value, PetscReal expected, PetscReal tolerance)
{
  if (!(PetscAbsReal(value - expected) <= tolerance * PetscAbsReal(expected)))
    print_error("%.15g, expected %.15g\n", (double)value, (double)expected);
  assert_true(PetscAbsReal(value - expected) <= tolerance * PetscAbsReal(expected));
}

/* The same steps and final slip to 1e-6: the operators differ by rounding and the tolerance of low-rank blocks. */
static void run_on_uniform_cells_is_the_grids(void **state)
{
  static Mesh mesh;
  PetscReal slip[4];
  PetscInt steps[4];

  AddPlane(&mesh, 9, 7, 1, 0);
  WriteMesh("test_cells_uniform.h5", &mesh);
  RunFault(NULL, "dense", "mean_slip", &slip[0], &steps[0]);
  RunFault("test_cells_uniform.h5", "dense", "mean_slip", &slip[1], &steps[1]);
  RunFault("test_cells_uniform.h5", "hmat", "mean_slip", &slip[2], &steps[2]);
  RunFault(NULL, "hmat", "mean_slip", &slip[3], &steps[3]);
  assert_true(slip[0] > 0);
  for (int k = 1; k < 4; k++) {
    Near(slip[k], slip[0], 1e-6);
    assert_int_equal(steps[0], steps[k]);
  }
  remove("test_cells_uniform.h5");
}

/* Two faults so far apart that stress from one, falling like 1/y^3, is below (900 / 1e6)^3 = 1e-9 on the other slip as
   each alone; 200 m apart they do not. Without the scaling of K, which is of the whole. */
static void distant_faults_decouple(void **state)
{
  static Mesh one, far, near;
  PetscReal slip[3];
  PetscInt steps[3];

  AddPlane(&one, 6, 5, 2, 0);
  AddPlane(&far, 6, 5, 2, 0);
  AddPlane(&far, 6, 5, 2, 1e6);
  AddPlane(&near, 6, 5, 2, 0);
  AddPlane(&near, 6, 5, 2, 200);
  WriteMesh("test_cells_one.h5", &one);
  WriteMesh("test_cells_far.h5", &far);
  WriteMesh("test_cells_near.h5", &near);
  RunFault("test_cells_one.h5", "dense", "none", &slip[0], &steps[0]);
  RunFault("test_cells_far.h5", "dense", "none", &slip[1], &steps[1]);
  RunFault("test_cells_near.h5", "dense", "none", &slip[2], &steps[2]);
  assert_true(slip[0] > 0);
  Near(slip[1], slip[0], 1e-6);
  assert_int_equal(steps[0], steps[1]);
  assert_true(PetscAbsReal(slip[2] / slip[0] - 1) > 1e-2);
  remove("test_cells_one.h5");
  remove("test_cells_far.h5");
  remove("test_cells_near.h5");
}

SLIP_TESTS(hierarchical_to_the_tolerance, uniform_cells_are_the_grid, averages_of_cells,
           uneven_cells_leave_nothing_between, bad_cells_are_refused, run_on_uniform_cells_is_the_grids,
           distant_faults_decouple)
