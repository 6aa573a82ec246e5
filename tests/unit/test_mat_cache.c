/* The cache of the exact viscosity: what is read is what was built, and files that cannot be right are replaced. */
#define _XOPEN_SOURCE 700 /* truncate */
#include "unit.h"
#include <dirent.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>
#include "tempdir.h"

#define MASS (2500.0 * 3000.0)
#define ZETA (0.8 / 3)

/* Dense roots are kept from 1500 rows on. */
static const SlipGrid Dense = {38, 40, 3000.0, 2600.0, 0.0, ROCK(0.25, PETSC_FALSE, SLIP_AVERAGE_CENTRE)};

/* Name of the only file in dir; the test fails when there are none or more. */
static void OnlyFile(const char dir[], char name[PETSC_MAX_PATH_LEN])
{
  DIR *d = opendir(dir);
  int count = 0;

  assert_non_null(d);
  for (struct dirent *e = readdir(d); e; e = readdir(d)) {
    if (e->d_name[0] == '.') continue;
    snprintf(name, PETSC_MAX_PATH_LEN, "%s/%.255s", dir, e->d_name);
    count++;
  }
  closedir(d);
  assert_int_equal(count, 1);
}

static ino_t InodeOf(const char name[])
{
  struct stat info;

  assert_int_equal(stat(name, &info), 0);
  return info.st_ino;
}

/* H as MATDENSE for a stiffness scaled by scale; dir may be "". */
static Mat Viscosity(const SlipGrid *grid, const char dir[], PetscReal scale, PetscReal mass)
{
  Mat K, H, dense;

  ok(MatCreateSlipStiffness(PETSC_COMM_SELF, grid, "dense", &K));
  ok(MatSlipStiffnessSetCacheDir(K, dir));
  ok(MatScale(K, scale));
  ok(MatCreateSlipViscosity(K, mass, ZETA, "sqrtm", &H));
  ok(MatConvert(H, MATDENSE, MAT_INITIAL_MATRIX, &dense));
  ObjectsDestroy(&H, &K);
  return dense;
}

/* Frobenius distance relative to B; destroys A. */
static PetscReal Distance(Mat A, Mat B)
{
  PetscReal error, norm;

  ok(MatNorm(B, NORM_FROBENIUS, &norm));
  ok(MatAXPY(A, -1, B, SAME_NONZERO_PATTERN));
  ok(MatNorm(A, NORM_FROBENIUS, &error));
  ok(MatDestroy(&A));
  return error / norm;
}

/* Flips the bits of one byte at this share of the file. */
static void Damage(const char name[], double where)
{
  FILE *f = fopen(name, "r+b");
  long at;
  int byte;

  assert_non_null(f);
  fseek(f, 0, SEEK_END);
  at = (long)(where * (double)ftell(f));
  fseek(f, at, SEEK_SET);
  byte = fgetc(f);
  fseek(f, at, SEEK_SET);
  fputc(byte ^ 0xff, f);
  fclose(f);
}

/* A dense root in the same way: units cost it a rounding, and a root that is computed differs from another by a few. */
static void test_dense_root(void **state)
{
  char dir[TEMPDIR_LENGTH], name[PETSC_MAX_PATH_LEN];
  Mat plain = Viscosity(&Dense, "", 1.3, MASS), built, other;
  ino_t inode;

  (void)state;
  assert_int_equal(TempDirMake("slipcache", dir), 0);
  built = Viscosity(&Dense, dir, 1.3, MASS);
  OnlyFile(dir, name);
  inode = InodeOf(name);
  assert_true(Distance(Viscosity(&Dense, dir, 1.3, MASS), built) == 0);
  assert_true(Distance(built, plain) < 1e-14);
  other = Viscosity(&Dense, "", 0.4, 3 * MASS);
  /* two roots by eigenvectors: each is exact to 1e-16 sqrt(N) of its norm or a little more */
  assert_true(Distance(Viscosity(&Dense, dir, 0.4, 3 * MASS), other) < 1e-13);
  OnlyFile(dir, name);
  assert_true(InodeOf(name) == inode);
  ObjectsDestroy(&plain, &other);
  assert_int_equal(unlink(name), 0);
  assert_int_equal(rmdir(dir), 0);
}

/* H of a row of n cells of two widths, whose rows are weighted; its stiffness is scaled after the cache is set. */
static Mat CellViscosity(PetscInt n, PetscReal width, const char dir[])
{
  SlipCells cells = {.n = n, .kernel = ROCK(0.25, PETSC_TRUE, SLIP_AVERAGE_CENTRE)};
  PetscReal *a;
  Mat K, H;

  ok(PetscMalloc1(5 * n, &a));
  for (PetscInt i = 0; i < n; i++) {
    const PetscReal column[5] = {100.0 * (PetscReal)i, 0, 1000, 100, i % 2 ? 100 : width};

    for (PetscInt k = 0; k < 5; k++) a[k * n + i] = column[k];
  }
  cells.x = a;
  cells.y = a + n;
  cells.z = a + 2 * n;
  cells.length = a + 3 * n;
  cells.width = a + 4 * n;
  ok(MatCreateSlipCellStiffness(PETSC_COMM_SELF, &cells, "dense", 1e-8, &K));
  ok(MatSlipStiffnessSetCacheDir(K, dir));
  ok(MatScale(K, 1.7));
  ok(MatCreateSlipViscosity(K, MASS, ZETA, "sqrtm", &H));
  ok(MatDestroy(&K));
  ok(PetscFree(a));
  return H;
}

static void test_dense_root_of_cells(void **state)
{
  char dir[TEMPDIR_LENGTH], name[PETSC_MAX_PATH_LEN], first[PETSC_MAX_PATH_LEN];
  Mat built, other;
  ino_t inode;

  (void)state;
  assert_int_equal(TempDirMake("slipcache", dir), 0);
  built = CellViscosity(1500, 60, dir);
  OnlyFile(dir, first);
  inode = InodeOf(first);
  assert_true(Distance(CellViscosity(1500, 60, dir), built) == 0);
  OnlyFile(dir, name);
  assert_true(InodeOf(name) == inode);
  other = CellViscosity(1500, 61, dir); /* one that differs only a little has a file of its own */
  assert_true(Distance(built, other) > 1e-4);
  ok(MatDestroy(&other));
  assert_int_equal(unlink(first), 0);
  OnlyFile(dir, name);
  assert_int_equal(unlink(name), 0);
  other = CellViscosity(1499, 60, dir); /* not worth keeping */
  ok(MatDestroy(&other));
  assert_int_equal(rmdir(dir), 0);
}

/* A byte of the data, a short file, no HDF5 at all, the file of another grid: the result is right and the file new. */
static void CheckBadFiles(const SlipGrid *grid)
{
  SlipGrid deeper = *grid;
  char dir[TEMPDIR_LENGTH], other_dir[TEMPDIR_LENGTH], name[PETSC_MAX_PATH_LEN], other[PETSC_MAX_PATH_LEN];
  Mat plain = Viscosity(grid, "", 1, MASS), mat;

  deeper.depth_top = 100;
  assert_int_equal(TempDirMake("slipcache", dir), 0);
  assert_int_equal(TempDirMake("slipcache", other_dir), 0);
  mat = Viscosity(&deeper, other_dir, 1, MASS);
  OnlyFile(other_dir, other);
  ok(MatDestroy(&mat));
  mat = Viscosity(grid, dir, 1, MASS);
  ok(MatDestroy(&mat));
  for (int k = 0; k < 4; k++) {
    ino_t inode;
    FILE *f;

    OnlyFile(dir, name);
    if (k == 0) Damage(name, 0.6);
    if (k == 1) assert_int_equal(truncate(name, 4096), 0);
    if (k == 2) {
      f = fopen(name, "w");
      assert_non_null(f);
      fputs("not a cache", f);
      fclose(f);
    }
    if (k == 3) assert_int_equal(rename(other, name), 0);
    inode = InodeOf(name);
    assert_true(Distance(Viscosity(grid, dir, 1, MASS), plain) == 0);
    OnlyFile(dir, name);
    assert_true(InodeOf(name) != inode);
  }
  ok(MatDestroy(&plain));
  assert_int_equal(unlink(name), 0);
  assert_int_equal(rmdir(dir), 0);
  assert_int_equal(rmdir(other_dir), 0);
}

static void test_bad_files_are_replaced(void **state)
{
  (void)state;
  CheckBadFiles(&Dense);
}

static void test_no_directory(void **state)
{
  PetscErrorCode code;
  Mat K;

  (void)state;
  ok(MatCreateSlipStiffness(PETSC_COMM_SELF, &Dense, "dense", &K));
  ok(PetscPushErrorHandler(PetscReturnErrorHandler, NULL));
  code = MatSlipStiffnessSetCacheDir(K, "no/such/directory");
  ok(PetscPopErrorHandler());
  assert_int_equal(code, PETSC_ERR_FILE_OPEN);
  ok(MatDestroy(&K));
}

SLIP_TESTS(test_dense_root, test_dense_root_of_cells, test_bad_files_are_replaced, test_no_directory)
