/* What both kinds of mesh say of their cells: places and corners against each other, planes, extents, and that the user's
   options stay as they were. */
#include "unit.h"
#include "faultstart.h"
#include <slipstep/private/slipfault.h>
#include <math.h>
#include <string.h>
#include "cells.h"
#include "tempdir.h"

enum { NX = 3, NZ = 2, N = 2 * NX * NZ };

/* The centre of a cell is the mean of its corners, which are half its sides away along its directions; both to rounding
   of numbers of at most 1e4 m. */
static void CheckCorners(const SlipFaultMesh *mesh)
{
  PetscReal *points;
  PetscInt *corners;

  ok(PetscMalloc2(3 * mesh->npoints, &points, 4 * mesh->N, &corners));
  ok(mesh->kind->corners(mesh, points, corners));
  for (PetscInt e = 0; e < mesh->N; e++) {
    const PetscReal *const p[4] = {points + 3 * corners[4 * e], points + 3 * corners[4 * e + 1],
                                   points + 3 * corners[4 * e + 2], points + 3 * corners[4 * e + 3]};
    SlipFaultCell cell;

    mesh->kind->cell(mesh, e, &cell);
    for (int k = 0; k < 3; k++) {
      assert_true(fabs((p[0][k] + p[1][k] + p[2][k] + p[3][k]) / 4 - cell.centre[k]) < 1e-10);
      assert_true(fabs(p[1][k] - p[0][k] - cell.size[0] * cell.direction[0][k]) < 1e-10);
      assert_true(fabs(p[2][k] - p[1][k] - cell.size[1] * cell.direction[1][k]) < 1e-10);
    }
  }
  ok(PetscFree2(points, corners));
}

static PetscReal Real(SlipFault fault, const char name[])
{
  PetscReal value;

  ok(SlipFaultGetReal(fault, name, &value));
  return value;
}

static void grid(void **state)
{
  SlipFault fault;
  SlipFaultCell cell;

  (void)state;
  ok(SlipFaultCreate(PETSC_COMM_SELF, &fault));
  ok(FaultSetReals(fault, {"nx", NX}, {"nz", NZ}, {"depth_top", 500}));
  ok(SlipFaultSetUp(fault));
  CheckCorners(&fault->mesh);
  fault->mesh.kind->cell(&fault->mesh, NX + 2, &cell); /* 1000 x 1500 m, below, at the right */
  assert_true(cell.centre[0] == 2500 && cell.centre[1] == 0 && cell.centre[2] == 2750);
  assert_true(fault->mesh.npoints == (NX + 1) * (NZ + 1) && fault->mesh.planes == 1 && fault->mesh.area == 1.5e6);
  assert_true(Real(fault, "nx") == NX && Real(fault, "depth_top") == 500);
  ok(SlipFaultDestroy(&fault));
}

static void list(void **state)
{
  PetscReal numbers[5 * N], left = PETSC_MAX_REAL, right = PETSC_MIN_REAL, area = 0;
  const SlipCells cells = TwoGradedFaults(NX, NZ, 5, numbers);
  char dir[TEMPDIR_LENGTH], file[TEMPDIR_LENGTH + 8], first[96], second[96];
  SlipFault fault;

  (void)state;
  assert_int_equal(0, TempDirMake("mesh", dir));
  snprintf(file, sizeof(file), "%s/mesh.h5", dir);
  ok(WriteCells(file, &cells));
  ok(SlipFaultCreate(PETSC_COMM_SELF, &fault));
  ok(SlipFaultSetString(fault, "mesh", file));
  assert_true(Real(fault, "nx") == 1);
  ok(SlipFaultSetUp(fault));
  CheckCorners(&fault->mesh);
  for (PetscInt e = 0; e < N; e++) {
    SlipFaultCell cell;

    fault->mesh.kind->cell(&fault->mesh, e, &cell);
    assert_true(cell.centre[0] == cells.x[e] && cell.centre[1] == cells.y[e] && cell.centre[2] == cells.z[e]);
    assert_true(cell.size[0] == cells.length[e] && cell.size[1] == cells.width[e]);
    assert_true((cell.plane == 0) == (cells.y[e] == cells.y[0]) && cell.plane < 2);
    left = PetscMin(left, cells.x[e] - 0.5 * cells.length[e]);
    right = PetscMax(right, cells.x[e] + 0.5 * cells.length[e]);
    area += cells.length[e] * cells.width[e];
  }
  assert_int_equal(2, fault->mesh.planes);
  assert_true(fabs(fault->mesh.area * N / area - 1) < 1e-14);
  /* as a grid, the list is one row; the options of a grid keep their values, which do not count */
  assert_true(Real(fault, "nx") == N && Real(fault, "nz") == 1 && Real(fault, "length_x") == right - left);
  assert_true(Real(fault, "thickness") == right - left);
  assert_true(fault->options.value[FAULT_NX] == 1 && fault->options.value[FAULT_LENGTH_X] == 3000);
  /* a restart knows another mesh by one number */
  ok(fault->mesh.kind->digest(&fault->mesh, first, sizeof(first)));
  ((PetscReal *)fault->mesh.cells.z)[N - 1] += 1e-9;
  ok(fault->mesh.kind->digest(&fault->mesh, second, sizeof(second)));
  assert_true(strcmp(first, second) != 0);
  ok(SlipFaultDestroy(&fault));
  assert_int_equal(0, TempDirRemove(dir));
}

SLIP_TESTS(grid, list)
