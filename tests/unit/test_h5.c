/* HDF5 helpers: what is written is read back bit for bit; broken files are refused by name. */
#define _GNU_SOURCE /* RTLD_NEXT */
#include "unit.h"
#include <slipstep/rooms/sliph5.h>
#include <dlfcn.h>
#include <signal.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

static char file[256];

static PetscErrorCode append(SlipH5 *h, const char path[], PetscInt rows, const PetscReal data[])
{
  const SlipH5Rows series = {path, data, 1};

  return SlipH5AppendAll(h, 1, &series, rows);
}

static void round_trip(void **state)
{
  const PetscReal a[6] = {0.1, -2.5, 3e300, 4, 5e-300, 6};
  const float f[2] = {0.25f, 1e-3f};
  const PetscInt d[2] = {2, 3}, i[3] = {-7, 0, 123456}, two = 2, three = 3;
  const char *const names[2] = {"velocity", "energy"};
  SlipH5 h;
  PetscInt dims[4], n;
  PetscReal *x, y;
  char **s, text[32];
  PetscBool has;

  ok(SlipH5Create(file, &h));
  ok(SlipH5WriteReal(&h, "/mesh/a", 2, d, a, "Pa"));
  ok(SlipH5WriteFloat(&h, "/f", 1, &two, f, NULL));
  ok(SlipH5WriteInt(&h, "/deep/er/i", 1, &three, i, NULL));
  ok(SlipH5WriteStrings(&h, "/names", 2, names));
  ok(SlipH5WriteAttrReal(&h, "/run", "pi", 3.14159));
  ok(SlipH5WriteAttrInt(&h, "/", "version", 1));
  ok(SlipH5WriteAttrString(&h, "/", "format", "old"));
  ok(SlipH5WriteAttrString(&h, "/", "format", "slipstep-policy")); /* replaces */
  ok(SlipH5WriteReal(&h, "/scalar", 0, NULL, a, NULL));
  assert_int_not_equal(0, access(file, F_OK)); /* only FILE.part exists until the close */
  ok(SlipH5Flush(&h));
  ok(SlipH5Close(&h));
  ok(SlipH5Close(&h));

  ok(SlipH5OpenRead(file, &h));
  ok(SlipH5ReadReal(&h, "/mesh/a", 2, dims, &x));
  assert_int_equal(2, dims[0]);
  assert_int_equal(3, dims[1]);
  assert_memory_equal(a, x, sizeof(a));
  PetscFree(x);
  ok(SlipH5ReadReal(&h, "/f", 1, dims, &x));
  assert_true(x[0] == 0.25 && x[1] == (PetscReal)1e-3f);
  PetscFree(x);
  ok(SlipH5ReadReal(&h, "/deep/er/i", 1, dims, &x));
  assert_true(x[0] == -7 && x[1] == 0 && x[2] == 123456);
  PetscFree(x);
  ok(SlipH5ReadReal(&h, "/scalar", 0, dims, &x));
  assert_true(x[0] == a[0]);
  PetscFree(x);
  ok(SlipH5ReadStrings(&h, "/names", &n, &s));
  assert_int_equal(2, n);
  assert_string_equal("velocity", s[0]);
  assert_string_equal("energy", s[1]);
  ok(SlipH5FreeStrings(n, &s));
  ok(SlipH5ReadAttrReal(&h, "/run", "pi", &y));
  assert_true(y == 3.14159);
  ok(SlipH5ReadAttrInt(&h, "/", "version", &n));
  assert_int_equal(1, n);
  ok(SlipH5ReadAttrString(&h, "/", "format", text, sizeof(text)));
  assert_string_equal("slipstep-policy", text);
  ok(SlipH5ReadAttrString(&h, "/mesh/a", "units", text, sizeof(text)));
  assert_string_equal("Pa", text);
  ok(SlipH5Has(&h, "/deep/er", &has));
  assert_true(has);
  ok(SlipH5Has(&h, "/shallow/er", &has));
  assert_false(has);
  ok(SlipH5Has(&h, "/", &has));
  assert_true(has);
  ok(SlipH5HasAttribute(&h, "/", "version", &has));
  assert_true(has);
  ok(SlipH5HasAttribute(&h, "/mesh", "version", &has));
  assert_false(has);
  fails(SlipH5ReadReal(&h, "/none", 1, dims, &x), "no dataset /none");
  fails(SlipH5ReadReal(&h, "/mesh/a", 1, dims, &x), "has shape [2, 3], expected 1 dimension");
  fails(SlipH5ReadReal(&h, "/names", 1, dims, &x), "does not hold numbers");
  fails(SlipH5ReadStrings(&h, "/f", &n, &s), "not a list of strings");
  fails(SlipH5ReadAttrReal(&h, "/", "format", &y), "not one number");
  fails(SlipH5ReadAttrInt(&h, "/run", "pi", &n), "expected an integer");
  fails(SlipH5ReadAttrString(&h, "/", "format", text, 4), "expected fewer than 4");
  fails(SlipH5ReadAttrReal(&h, "/", "absent", &y), "no attribute absent");
  ok(SlipH5Close(&h));
}

static void series(void **state)
{
  const PetscInt d[2] = {2, 2};
  const PetscReal a[8] = {1, 2, 3, 4, 5, 6, 7, 8}, t[3] = {0.5, 1.5, 2.5}, k[2] = {3, -4};
  SlipH5 h;
  PetscInt dims[3];
  PetscReal *x;

  ok(SlipH5Create(file, &h));
  ok(SlipH5CreateSeries(&h, "/fields/a", 2, d, NULL, "m"));
  ok(SlipH5CreateSeries(&h, "/steps/t", 0, NULL, NULL, "s"));
  ok(SlipH5CreateSeries(&h, "/steps/k", 0, NULL, &(SlipH5Storage){.integer = PETSC_TRUE}, NULL));
  ok(append(&h, "/fields/a", 1, a));
  ok(append(&h, "/fields/a", 1, a + 4));
  ok(append(&h, "/steps/t", 2, t));
  ok(append(&h, "/steps/t", 1, t + 2));
  ok(append(&h, "/steps/k", 2, k));
  fails(append(&h, "/steps/none", 1, t), "no dataset /steps/none");
  ok(SlipH5Close(&h));
  ok(SlipH5OpenRead(file, &h));
  ok(SlipH5ReadReal(&h, "/fields/a", 3, dims, &x));
  assert_true(dims[0] == 2 && dims[1] == 2 && dims[2] == 2);
  assert_memory_equal(a, x, sizeof(a));
  PetscFree(x);
  ok(SlipH5ReadReal(&h, "/steps/t", 1, dims, &x));
  assert_memory_equal(t, x, sizeof(t));
  PetscFree(x);
  ok(SlipH5ReadReal(&h, "/steps/k", 1, dims, &x));
  assert_memory_equal(k, x, sizeof(k));
  PetscFree(x);
  ok(SlipH5Close(&h));
}

/* Values that single precision holds come back as they were, from one chunk a row or, of 2 MB, from several; and the
   storage is what was asked for. */
static void stored_series(void **state)
{
  const SlipH5Storage want[] = {{.single = PETSC_TRUE}, {.deflate = 1}, {.single = PETSC_TRUE, .deflate = 9}};
  const PetscInt small[2] = {2, 3}, large[2] = {511, 513};

  for (size_t k = 0; k < sizeof(want) / sizeof(want[0]); k++) {
    for (int big = 0; big < 2; big++) {
      const PetscInt *d = big ? large : small, n = d[0] * d[1], rows = 3;
      SlipH5 h;
      SlipH5Storage found;
      PetscInt dims[3];
      PetscReal *a, *x;

      ok(PetscMalloc1(rows * n, &a));
      for (PetscInt i = 0; i < rows * n; i++) a[i] = (PetscReal)(i % 8191) / 64;
      ok(SlipH5Create(file, &h));
      ok(SlipH5CreateSeries(&h, "/fields/a", 2, d, &want[k], "m"));
      for (PetscInt row = 0; row < rows; row++) ok(append(&h, "/fields/a", 1, a + row * n));
      ok(SlipH5Close(&h));
      ok(SlipH5OpenRead(file, &h));
      ok(SlipH5ReadReal(&h, "/fields/a", 3, dims, &x));
      assert_true(dims[0] == rows && dims[1] == d[0] && dims[2] == d[1]);
      assert_memory_equal(a, x, rows * n * sizeof(*a));
      ok(SlipH5GetStorage(&h, "/fields/a", &found));
      assert_true(found.single == want[k].single && found.deflate == want[k].deflate && !found.integer);
      ok(SlipH5Close(&h));
      ok(PetscFree(a));
      ok(PetscFree(x));
    }
  }
}

/* What HDF5 and the library call to write: it looks at the file after each write. */
static const char *watched = NULL;
static int states = 0, refused = 0, shrunk = 0, sudden = 0;
static uint64_t last_end = 0, last_size = 0;

ssize_t pwrite64(int fd, const void *data, size_t n, off_t at);
ssize_t pwrite64(int fd, const void *data, size_t n, off_t at)
{
  static ssize_t (*real)(int, const void *, size_t, off_t) = NULL;
  unsigned char block[48];
  struct stat info;
  uint64_t end = 0;
  ssize_t done;
  FILE *f;

  if (!real) *(void **)&real = dlsym(RTLD_NEXT, "pwrite64");
  done = (*real)(fd, data, n, at);
  f = watched ? fopen(watched, "rb") : NULL;
  if (!f) return done;
  if (fread(block, 1, sizeof(block), f) != sizeof(block) || fstat(fileno(f), &info)) info.st_size = 0;
  for (int i = 0; i < 8; i++) end |= (uint64_t)block[28 + i] << (8 * i);
  states++;
  if (block[11] || end > (uint64_t)info.st_size) refused++;
  if (end < last_end) shrunk++;
  if (last_size && end > last_size) sudden++;
  last_end = end;
  last_size = (uint64_t)info.st_size;
  fclose(f);
  return done;
}

ssize_t pwrite(int fd, const void *data, size_t n, off_t at)
{
  return pwrite64(fd, data, n, at);
}

/* Every reader may open a growing file after each write to it: there is no mark of a writer, the file has the length
   that its superblock says, and had it a write earlier already, as readers look at the length first. It is cut to what
   is needed at the end. */
static void growing(void **state)
{
  const SlipH5Kind kind = {.growing = PETSC_TRUE};
  const PetscInt wide = 500;
  PetscReal row[500] = {0};
  char part[300];
  SlipH5 h, reader;

  ok(SlipH5CreateKind(&kind, file, &h));
  ok(SlipH5CreateSeries(&h, "/x", 1, &wide, NULL, "m"));
  PetscSNPrintf(part, sizeof(part), "%s.part", file);
  watched = part;
  ok(SlipH5Live(&h));
  for (PetscInt i = 0; i < 300; i++) {
    ok(append(&h, "/x", 1, row));
    if (i % 50 == 0) ok(SlipH5Flush(&h));
  }
  assert_true(states > 100);
  ok(SlipH5OpenRead(part, &reader));
  ok(SlipH5Close(&reader));
  ok(SlipH5Close(&h));
  watched = NULL;
  assert_int_equal(0, refused);
  assert_int_equal(1, shrunk);
  assert_int_equal(0, sudden);
}

/* As those of compilers for OpenCL, which MPI loads with their drivers */
static void Kill(int number)
{
  signal(number, SIG_DFL);
  raise(number);
}

/* Where a program has not begun with SlipProgramInitialize(), a limit of the size of files is an error and no signal,
   whoever handles it, before the file or since it was opened, who then has it back; and the rows that were appended
   before are kept, also those that no flush has brought to the disk. */
static void Full(void (*before_file)(int), void (*since)(int))
{
  const SlipH5Kind kind = {.growing = PETSC_TRUE};
  const PetscInt wide = 500;
  PetscReal row[500] = {0}, *x;
  PetscInt dims[4], rows = 0;
  PetscErrorCode ierr = PETSC_SUCCESS;
  struct rlimit before, limit;
  char part[300];
  SlipH5 h;

  signal(SIGXFSZ, before_file);
  PetscSNPrintf(part, sizeof(part), "%s.part", file);
  getrlimit(RLIMIT_FSIZE, &before);
  limit = before;
  limit.rlim_cur = 1000000;
  ok(SlipH5CreateKind(&kind, file, &h));
  ok(SlipH5CreateSeries(&h, "/x", 1, &wide, NULL, "m"));
  ok(SlipH5Live(&h));
  if (since) signal(SIGXFSZ, since);
  setrlimit(RLIMIT_FSIZE, &limit);
  while (!ierr && rows < 1000) {
    row[499] = (PetscReal)++rows;
    ierr = append(&h, "/x", 1, row);
  }
  setrlimit(RLIMIT_FSIZE, &before);
  assert_int_equal(PETSC_ERR_FILE_WRITE, ierr);
  assert_true(rows > 100);
  ok(SlipH5OpenRead(part, &h));
  ok(SlipH5ReadReal(&h, "/x", 2, dims, &x));
  ok(SlipH5Close(&h));
  assert_int_equal(rows - 1, dims[0]);
  for (PetscInt i = 0; i < dims[0]; i++) assert_true(x[500 * i + 499] == (PetscReal)(i + 1));
  PetscFree(x);
  unlink(part);
  assert_true(signal(SIGXFSZ, SIG_DFL) == (since ? since : before_file));
}

static void full(void **state)
{
  Full(SIG_DFL, NULL);
  Full(Kill, NULL);
  Full(SIG_DFL, Kill);
  Full(SIG_IGN, NULL);
}

/* However many files are written at a time, each gets what is written to it. */
static void many(void **state)
{
  enum { FILES = 20 };
  SlipH5 h[FILES];
  char name[FILES][300];
  PetscInt n;

  for (int i = 0; i < FILES; i++) {
    PetscSNPrintf(name[i], sizeof(name[i]), "%s.%d", file, i);
    ok(SlipH5Create(name[i], &h[i]));
  }
  for (int i = 0; i < FILES; i++) ok(SlipH5WriteAttrInt(&h[i], "/", "number", i));
  for (int i = 0; i < FILES; i++) ok(SlipH5Close(&h[i]));
  for (int i = 0; i < FILES; i++) {
    ok(SlipH5OpenRead(name[i], &h[i]));
    ok(SlipH5ReadAttrInt(&h[i], "/", "number", &n));
    ok(SlipH5Close(&h[i]));
    unlink(name[i]);
    assert_int_equal(i, n);
  }
}

static void broken_files(void **state)
{
  SlipH5 h;
  PetscReal x = 1;
  PetscInt one = 1;
  FILE *f;

  unlink(file);
  fails(SlipH5OpenRead(file, &h), file);
  fails(SlipH5Create("no/such/directory/out.h5", &h), "no/such/directory/out.h5.part");
  fails(SlipH5Create(".", &h), "is a directory");
  f = fopen(file, "w");
  fputs("not an HDF5 file", f);
  fclose(f);
  fails(SlipH5OpenRead(file, &h), "is not an HDF5 file");
  fails(SlipH5Create(file, &h), "it is there and is not an HDF5 file");
  unlink(file);
  ok(SlipH5Create(file, &h));
  ok(SlipH5WriteReal(&h, "/a", 1, &one, &x, NULL));
  ok(SlipH5Close(&h));
  assert_int_equal(0, truncate(file, 1000));
  fails(SlipH5OpenRead(file, &h), "truncated");
  unlink(file);
}

/* Datasets that the file only claims to hold, and others that nobody reads: refused by their shape, before reading. */
static void sizes(void **state)
{
  const hsize_t wide[2] = {3, 1000000000}, long_[1] = {(hsize_t)1 << 40}, deep[6] = {1, 1, 1, 1, 1, 1},
                chunk[2] = {3, 8};
  const hsize_t many[1] = {3000000}, some[2] = {100, 100};
  const PetscInt want[2] = {-1, 5}, exact[2] = {100, 100};
  const hid_t dcpl = H5Pcreate(H5P_DATASET_CREATE), text = H5Tcopy(H5T_C_S1), pair = H5Tcreate(H5T_COMPOUND, 16);
  const hid_t vast = H5Tcopy(H5T_IEEE_F64LE); /* a number of a megabyte, which HDF5 would convert */
  const double fill = 0.25;
  const struct {
    const char *path, *refusal;
    hid_t type;
    int rank;
    const hsize_t *shape;
  } set[] = {
    {"/wide", "has shape [3, 1000000000], but the file has only 0 bytes of it", H5T_IEEE_F64LE, 2, wide},
    {"/long",
     sizeof(PetscInt) == 4 ? "has shape [1099511627776], more entries than a PetscInt of 32 bits"
                           : "has shape [1099511627776], but the file has only 0 bytes of it",
     H5T_STD_I8LE, 1, long_},
    {"/deep", "has 6 dimensions, expected 1", H5T_IEEE_F64LE, 6, deep},
    {"/text", "has 3000000 strings of 4 bytes, expected at most", text, 1, many},
    {"/pair", "does not hold numbers", pair, 1, chunk},
    {"/vast", "does not hold numbers", vast, 1, chunk},
  };
  int made[sizeof(set) / sizeof(*set)];
  char **strings, value[16];
  PetscInt dims[4], n;
  PetscReal *x;
  hid_t space, id;
  SlipH5 h;

  ok(SlipH5Create(file, &h));
  H5Tset_size(text, 4);
  H5Tset_size(vast, 1 << 20);
  H5Tinsert(pair, "a", 0, H5T_NATIVE_DOUBLE);
  for (size_t k = 0; k < sizeof(set) / sizeof(*set); k++) {
    const hid_t chunks = H5Pcreate(H5P_DATASET_CREATE);

    if (set[k].rank < 3) H5Pset_chunk(chunks, set[k].rank, chunk);
    space = H5Screate_simple(set[k].rank, set[k].shape, NULL);
    id = H5Dcreate2(h.id, set[k].path, set[k].type, space, H5P_DEFAULT, chunks, H5P_DEFAULT);
    made[k] = id >= 0;
    assert_true(made[k] || set[k].type == vast); /* HDF5 1.14 makes none of that type */
    if (made[k]) H5Dclose(id);
    H5Sclose(space);
    H5Pclose(chunks);
  }
  /* a fill value is a field, where the shape is known */
  H5Pset_fill_value(dcpl, H5T_NATIVE_DOUBLE, &fill);
  space = H5Screate_simple(2, some, NULL);
  H5Dclose(H5Dcreate2(h.id, "/uniform", H5T_IEEE_F64LE, space, H5P_DEFAULT, dcpl, H5P_DEFAULT));
  H5Sclose(space);
  space = H5Screate_simple(2, chunk, NULL);
  H5Aclose(H5Acreate2(h.id, "field", H5T_IEEE_F64LE, space, H5P_DEFAULT, H5P_DEFAULT));
  H5Sclose(space);
  space = H5Screate(H5S_NULL);
  H5Dclose(H5Dcreate2(h.id, "/nothing", H5T_IEEE_F64LE, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
  H5Aclose(H5Acreate2(h.id, "none", text, space, H5P_DEFAULT, H5P_DEFAULT));
  H5Sclose(space);
  ok(SlipH5Close(&h));

  ok(SlipH5OpenRead(file, &h));
  for (size_t k = 0; k < sizeof(set) / sizeof(*set); k++) {
    if (!made[k]) continue;
    if (set[k].type == text)
      fails(SlipH5ReadStrings(&h, set[k].path, &n, &strings), set[k].refusal);
    else
      fails(SlipH5ReadReal(&h, set[k].path, set[k].rank == 6 ? 1 : set[k].rank, dims, &x), set[k].refusal);
    assert_non_null(strstr(message, file));
    assert_non_null(strstr(message, set[k].path));
  }
  fails(SlipH5ReadRealSized(&h, "/wide", 2, want, "with five columns", dims, &x),
        "has shape [3, 1000000000], expected [any, 5], with five columns");
  fails(SlipH5ReadReal(&h, "/nothing", 2, dims, &x), "has shape [], expected 2 dimensions");
  fails(SlipH5ReadAttrReal(&h, "/", "field", x), "attribute field of / in");
  fails(SlipH5ReadAttrString(&h, "/", "none", value, sizeof(value)), "attribute none of / in");
  fails(SlipH5ReadAttrString(&h, "/", "field", value, sizeof(value)), "is not one string");
  ok(SlipH5ReadRealSized(&h, "/uniform", 2, exact, NULL, dims, &x));
  assert_true(dims[0] == 100 && x[9999] == fill);
  ok(PetscFree(x));
  ok(SlipH5ReadReal(&h, "/uniform", 2, dims, &x)); /* 80 kB may be fill values only */
  ok(PetscFree(x));
  ok(SlipH5Close(&h));
  H5Tclose(vast);
  H5Tclose(pair);
  H5Tclose(text);
  H5Pclose(dcpl);
}

static int NameFile(void **state)
{
  snprintf(file, sizeof(file), "test_h5_%d.h5", (int)getpid());
  return 0;
}

static int RemoveFile(void **state)
{
  unlink(file);
  return 0;
}

SLIP_TESTS_WITH(NameFile, RemoveFile, round_trip, series, stored_series, sizes, growing, full, many, broken_files)
