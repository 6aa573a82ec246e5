/* SlipPolicy: forward pass against formulas written out here, files back and forth, and every kind of broken file. */
#include "unit.h"
#include <sliph5.h>
#include <petsctime.h>
#include <math.h>
#include <unistd.h>

static char file[256], part[300];

/* Sums of a few products of numbers below 100 round to within 1e-13, and tanh has slope at most 1. */
#define TOLERANCE 1e-12

static const char *const names[2] = {"energy", "step"};
static const PetscReal scale[2] = {0.5, 2}, offset[2] = {0.25, -1};
static const PetscReal w0[3][2] = {{1, -2}, {0.5, 0.25}, {-3, 1}}, b0[3] = {0.1, -0.2, 0.3};
static const PetscReal w1[1][3] = {{0.7, -1.1, 0.4}}, b1[1] = {0.05};
static const PetscReal low = -1, high = 1;

static void make(SlipActivation hidden, SlipActivation last, PetscBool log_spacing, SlipPolicy *p)
{
  ok(SlipPolicyCreate(PETSC_COMM_SELF, p));
  ok(SlipPolicySetObservations(*p, 2, names, scale, offset));
  ok(SlipPolicyAddLayer(*p, 2, 3, &w0[0][0], b0, hidden));
  ok(SlipPolicyAddLayer(*p, 3, 1, &w1[0][0], b1, last));
  ok(SlipPolicySetAction(*p, low, high, 1e-3, "T*", 0.2, "t_max", log_spacing));
  ok(SlipPolicySetAttribute(*p, "algorithm", "by hand"));
  ok(SlipPolicySetAttribute(*p, "alpha", "0.1"));
}

static double activate(SlipActivation kind, double y)
{
  if (kind == SLIP_ACTIVATION_RELU) return fmax(y, 0);
  if (kind == SLIP_ACTIVATION_TANH) return tanh(y);
  if (kind == SLIP_ACTIVATION_HARDTANH2) return fmin(fmax(y, -2), 2);
  return y;
}

/* The network written out, in row order and without any of the library's arrays. */
static double expected(SlipActivation hidden, SlipActivation last, const double obs[2])
{
  const double x0 = obs[0] * 0.5 + 0.25, x1 = obs[1] * 2 - 1;
  const double h0 = activate(hidden, 1 * x0 - 2 * x1 + 0.1), h1 = activate(hidden, 0.5 * x0 + 0.25 * x1 - 0.2);
  const double h2 = activate(hidden, -3 * x0 + 1 * x1 + 0.3);

  return tanh(activate(last, 0.7 * h0 - 1.1 * h1 + 0.4 * h2 + 0.05));
}

static void forward(void **state)
{
  const PetscReal obs[4][2] = {{0, 0}, {1, -0.5}, {-8, 3}, {20, 7}};

  (void)state;
  for (int hidden = SLIP_ACTIVATION_LINEAR; hidden <= SLIP_ACTIVATION_HARDTANH2; hidden++)
    for (int last = SLIP_ACTIVATION_LINEAR; last <= SLIP_ACTIVATION_HARDTANH2; last++) {
      SlipPolicy p;

      make((SlipActivation)hidden, (SlipActivation)last, PETSC_FALSE, &p);
      for (int k = 0; k < 4; k++) {
        PetscReal a;

        ok(SlipPolicyEvaluate(p, obs[k], &a, NULL));
        assert_true(fabs(a - expected((SlipActivation)hidden, (SlipActivation)last, obs[k])) < TOLERANCE);
      }
      ok(SlipPolicyDestroy(&p));
    }
}

static void steps(void **state)
{
  SlipPolicy p;
  PetscReal h, min, max;

  (void)state;
  make(SLIP_ACTIVATION_RELU, SLIP_ACTIVATION_LINEAR, PETSC_FALSE, &p);
  ok(SlipPolicyGetStepBounds(p, 2, 30, &min, &max)); /* 1e-3 T* and 0.2 t_max */
  assert_true(fabs(min - 2e-3) < TOLERANCE && fabs(max - 6) < TOLERANCE);
  ok(SlipPolicyActionToStep(p, 0.5, 2, 30, &h)); /* x = 3/4 */
  assert_true(fabs(h - (2e-3 + 0.75 * (6 - 2e-3))) < TOLERANCE);
  ok(SlipPolicyActionToStep(p, 7, 2, 30, &h)); /* clipped */
  assert_true(fabs(h - 6) < TOLERANCE);
  fails(SlipPolicyActionToStep(p, NAN, 2, 30, &h), "finite");
  fails(SlipPolicyGetStepBounds(p, 2, 0.01, &min, &max), "dt_min < dt_max");
  ok(SlipPolicyDestroy(&p));
  make(SLIP_ACTIVATION_RELU, SLIP_ACTIVATION_LINEAR, PETSC_TRUE, &p);
  ok(SlipPolicyActionToStep(p, 0, 2, 30, &h)); /* the geometric mean of the bounds */
  assert_true(fabs(h - sqrt(2e-3 * 6)) < TOLERANCE);
  ok(SlipPolicyDestroy(&p));
}

static void range(void **state)
{
  const PetscReal min[2] = {0, -1}, max[2] = {1, 1}, in[2] = {1.05, -1.1}, out[2] = {1.2, 5}, nan[2] = {NAN, 0};
  SlipPolicy p;
  PetscReal a;
  PetscInt outside;

  (void)state;
  make(SLIP_ACTIVATION_TANH, SLIP_ACTIVATION_LINEAR, PETSC_FALSE, &p);
  ok(SlipPolicyEvaluate(p, out, &a, &outside));
  assert_int_equal(0, outside); /* no range known */
  ok(SlipPolicySetRange(p, min, max));
  ok(SlipPolicyEvaluate(p, in, &a, &outside));
  assert_int_equal(0, outside); /* within a tenth of the width */
  ok(SlipPolicyEvaluate(p, out, &a, &outside));
  assert_int_equal(2, outside);
  ok(SlipPolicyEvaluate(p, nan, &a, &outside));
  assert_int_equal(1, outside);
  ok(SlipPolicyDestroy(&p));
}

static void round_trip(void **state)
{
  const PetscReal min[2] = {0, -1}, max[2] = {1, 1}, obs[2] = {0.3, 0.9};
  const char *hash, *loaded, *text;
  const char *const *seen;
  char before[32];
  SlipPolicy p, q;
  PetscReal a, b, h, g;
  PetscInt n;

  (void)state;
  make(SLIP_ACTIVATION_TANH, SLIP_ACTIVATION_HARDTANH2, PETSC_TRUE, &p);
  ok(SlipPolicySetRange(p, min, max));
  ok(SlipPolicyStore(p, file));
  assert_int_not_equal(0, access(part, F_OK));
  ok(SlipPolicyCreate(PETSC_COMM_SELF, &q));
  ok(SlipPolicyLoad(q, file));
  ok(SlipPolicyGetHash(p, &hash));
  snprintf(before, sizeof(before), "%s", hash);
  ok(SlipPolicyGetHash(q, &hash));
  assert_string_equal(before, hash);
  assert_int_equal(16, strlen(hash));
  ok(SlipPolicyGetFile(q, &loaded));
  assert_string_equal(file, loaded);
  ok(SlipPolicyGetObservations(q, &n, &seen));
  assert_int_equal(2, n);
  assert_string_equal("energy", seen[0]);
  assert_string_equal("step", seen[1]);
  ok(SlipPolicyEvaluate(p, obs, &a, NULL));
  ok(SlipPolicyEvaluate(q, obs, &b, NULL));
  assert_true(a == b); /* doubles are stored as doubles */
  ok(SlipPolicyActionToStep(p, a, 2, 30, &h));
  ok(SlipPolicyActionToStep(q, b, 2, 30, &g));
  assert_true(h == g);
  ok(SlipPolicyGetAttribute(q, "algorithm", &text));
  assert_string_equal(text, "by hand");
  ok(SlipPolicyGetAttribute(q, "no such", &text));
  assert_null(text);
  ok(SlipPolicySetAttribute(q, "alpha", "0.2"));
  ok(SlipPolicyGetHash(q, &hash));
  assert_string_not_equal(before, hash);
  ok(SlipPolicyDestroy(&p));
  ok(SlipPolicyDestroy(&q));
}

/* ---- broken files: each entry spoils one thing in a good file ---- */

static void attribute(SlipH5 *h, const char *path, const char *name, const char *value)
{
  H5Adelete_by_name(h->id, path, name, H5P_DEFAULT);
  if (value) ok(SlipH5WriteAttrString(h, path, name, value));
}

static void number(SlipH5 *h, const char *path, const char *name, PetscReal value)
{
  H5Adelete_by_name(h->id, path, name, H5P_DEFAULT);
  ok(SlipH5WriteAttrReal(h, path, name, value));
}

static void dataset(SlipH5 *h, const char *path, PetscInt ndim, PetscInt rows, PetscInt columns, PetscReal value)
{
  const PetscInt dims[2] = {rows, columns};
  PetscReal data[64];

  for (int i = 0; i < 64; i++) data[i] = value;
  H5Ldelete(h->id, path, H5P_DEFAULT);
  ok(SlipH5WriteReal(h, path, ndim, dims, data, NULL));
}

static void no_format(SlipH5 *h)
{
  attribute(h, "/", "format", NULL);
}
static void other_format(SlipH5 *h)
{
  attribute(h, "/", "format", "slipstep-run");
}
static void other_version(SlipH5 *h)
{
  ok(SlipH5WriteAttrInt(h, "/", "version", 2));
}
static void no_names(SlipH5 *h)
{
  H5Ldelete(h->id, "/observation/names", H5P_DEFAULT);
}
static void long_scale(SlipH5 *h)
{
  dataset(h, "/observation/scale", 1, 3, 0, 1);
}
static void zero_scale(SlipH5 *h)
{
  dataset(h, "/observation/scale", 1, 2, 0, 0);
}
static void nan_offset(SlipH5 *h)
{
  dataset(h, "/observation/offset", 1, 2, 0, NAN);
}
static void no_layers(SlipH5 *h)
{
  H5Ldelete(h->id, "/layers", H5P_DEFAULT);
}
static void gap(SlipH5 *h)
{
  H5Lmove(h->id, "/layers/1", h->id, "/layers/2", H5P_DEFAULT, H5P_DEFAULT);
}
static void flat_weight(SlipH5 *h)
{
  dataset(h, "/layers/0/weight", 1, 6, 0, 1);
}
static void no_bias(SlipH5 *h)
{
  H5Ldelete(h->id, "/layers/1/bias", H5P_DEFAULT);
}
static void short_bias(SlipH5 *h)
{
  dataset(h, "/layers/0/bias", 1, 2, 0, 1);
}
static void wide_input(SlipH5 *h)
{
  dataset(h, "/layers/0/weight", 2, 3, 4, 1);
}
static void broken_chain(SlipH5 *h)
{
  dataset(h, "/layers/1/weight", 2, 1, 5, 1);
}
static void nan_weight(SlipH5 *h)
{
  dataset(h, "/layers/1/weight", 2, 1, 3, NAN);
}
static void infinite_bias(SlipH5 *h)
{
  dataset(h, "/layers/0/bias", 1, 3, 0, INFINITY);
}
static void other_activation(SlipH5 *h)
{
  attribute(h, "/layers/0", "activation", "gelu");
}
static void no_activation(SlipH5 *h)
{
  attribute(h, "/layers/0", "activation", NULL);
}
static void no_action(SlipH5 *h)
{
  H5Ldelete(h->id, "/action", H5P_DEFAULT);
}
static void high_below_low(SlipH5 *h)
{
  number(h, "/action", "high", -1);
}
static void other_squash(SlipH5 *h)
{
  attribute(h, "/action", "squash", "sigmoid");
}
static void other_unit(SlipH5 *h)
{
  attribute(h, "/action", "dt_max_unit", "ms");
}
static void other_spacing(SlipH5 *h)
{
  attribute(h, "/action", "spacing", "cubic");
}
static void infinite_step(SlipH5 *h)
{
  number(h, "/action", "dt_max", INFINITY);
}
static void range_short(SlipH5 *h)
{
  dataset(h, "/range/minimum", 1, 1, 0, 0);
}

static void two_outputs(SlipH5 *h)
{
  dataset(h, "/layers/1/weight", 2, 2, 3, 1);
  dataset(h, "/layers/1/bias", 1, 2, 0, 1);
}

static void steps_reversed(SlipH5 *h)
{
  attribute(h, "/action", "dt_min_unit", "t_max");
  number(h, "/action", "dt_min", 0.3);
}

static void text_weight(SlipH5 *h)
{
  const char *const text[1] = {"heavy"};

  H5Ldelete(h->id, "/layers/0/weight", H5P_DEFAULT);
  ok(SlipH5WriteStrings(h, "/layers/0/weight", 1, text));
}

static const struct {
  void (*spoil)(SlipH5 *);
  const char *want;
} Broken[] = {
  {no_format, "no attribute format"},
  {other_format, "attribute format of / is \"slipstep-run\""},
  {other_version, "attribute version of / is 2; this library reads version 1"},
  {no_names, "/observation/names"},
  {long_scale, "/observation/scale has 3 entries; expected 2"},
  {zero_scale, "/observation/scale is 0 at entry 0 (energy)"},
  {nan_offset, "/observation/offset has the value nan"},
  {no_layers, "no group /layers/0"},
  {gap, "there is no /layers/1"},
  {flat_weight, "/layers/0/weight"},
  {text_weight, "/layers/0/weight"},
  {no_bias, "/layers/1/bias"},
  {short_bias, "/layers/0/bias has 2 entries; expected 3"},
  {wide_input, "/layers/0/weight has shape [3, 4]; expected 2 columns"},
  {broken_chain, "/layers/1/weight has shape [1, 5]; expected 3 columns"},
  {two_outputs, "/layers/1/weight has 2 rows; expected 1"},
  {nan_weight, "/layers/1/weight has the value nan"},
  {infinite_bias, "/layers/0/bias has the value inf"},
  {other_activation, "attribute activation of /layers/0 is \"gelu\""},
  {no_activation, "no attribute activation on /layers/0"},
  {no_action, "/action"},
  {high_below_low, "low = -1. and high = -1.; expected low < high"},
  {other_squash, "squash of /action is \"sigmoid\""},
  {other_unit, "dt_max_unit of /action is \"ms\""},
  {other_spacing, "spacing of /action is \"cubic\""},
  {infinite_step, "/action"},
  {steps_reversed, "dt_min = 0.3 t_max and dt_max = 0.2 t_max"},
  {range_short, "/range/minimum has 1 entries; expected 2"},
};

static void broken_files(void **state)
{
  const PetscReal min[2] = {0, -1}, max[2] = {1, 1}, obs[2] = {0.3, 0.9};
  SlipPolicy good, p;
  PetscReal a, b;

  (void)state;
  make(SLIP_ACTIVATION_RELU, SLIP_ACTIVATION_LINEAR, PETSC_FALSE, &good);
  ok(SlipPolicySetRange(good, min, max));
  ok(SlipPolicyEvaluate(good, obs, &a, NULL));
  ok(SlipPolicyStore(good, file));
  ok(SlipPolicyCreate(PETSC_COMM_SELF, &p));
  ok(SlipPolicyLoad(p, file));
  for (size_t k = 0; k < sizeof(Broken) / sizeof(*Broken); k++) {
    SlipH5 h;

    ok(SlipPolicyStore(good, file));
    snprintf(h.name, sizeof(h.name), "%s", file);
    h.id = H5Fopen(file, H5F_ACC_RDWR, H5P_DEFAULT);
    assert_true(h.id >= 0);
    H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
    Broken[k].spoil(&h);
    H5Fclose(h.id);
    fails(SlipPolicyLoad(p, file), Broken[k].want);
    assert_non_null(strstr(message, file)); /* every message names the file */
    ok(SlipPolicyEvaluate(p, obs, &b, NULL));
    assert_true(a == b); /* and the policy is still the one it was */
  }
  ok(SlipPolicyDestroy(&p));
  ok(SlipPolicyDestroy(&good));
}

static void no_file(void **state)
{
  SlipPolicy p;
  FILE *f;

  (void)state;
  ok(SlipPolicyCreate(PETSC_COMM_SELF, &p));
  fails(SlipPolicyLoad(p, "no_such_policy.h5"), "no_such_policy.h5");
  f = fopen(file, "w");
  fputs("no policy", f);
  fclose(f);
  fails(SlipPolicyLoad(p, file), "not an HDF5 file");
  fails(SlipPolicyStore(p, file), "no observations");
  ok(SlipPolicyDestroy(&p));
  make(SLIP_ACTIVATION_RELU, SLIP_ACTIVATION_LINEAR, PETSC_FALSE, &p);
  fails(SlipPolicyStore(p, "no/such/directory/policy.h5"), "no/such/directory/policy.h5");
  ok(SlipPolicyDestroy(&p));
}

/* Not asserted: machines differ. The target is 5 microseconds. */
static void benchmark(void **state)
{
  enum { N = 6, H = 64, RUNS = 20000 };
  static PetscReal w[H * H], b[H];
  const char *const six[N] = {"a", "b", "c", "d", "e", "f"};
  const PetscReal one[N] = {1, 1, 1, 1, 1, 1}, zero[N] = {0};
  const SlipActivation kinds[2] = {SLIP_ACTIVATION_RELU, SLIP_ACTIVATION_TANH};

  (void)state;
  for (int i = 0; i < H * H; i++) w[i] = sin(i + 1.0) / 8;
  for (int i = 0; i < H; i++) b[i] = cos(i + 1.0) / 8;
  for (int k = 0; k < 2; k++) {
    PetscLogDouble start, end;
    PetscReal a, obs[N] = {1, 0.1, 0, 1, 0.01, 0.2};
    SlipPolicy p;

    ok(SlipPolicyCreate(PETSC_COMM_SELF, &p));
    ok(SlipPolicySetObservations(p, N, six, one, zero));
    ok(SlipPolicyAddLayer(p, N, H, w, b, kinds[k]));
    ok(SlipPolicyAddLayer(p, H, H, w, b, kinds[k]));
    ok(SlipPolicyAddLayer(p, H, 1, w, b, SLIP_ACTIVATION_HARDTANH2));
    ok(SlipPolicySetAction(p, -1, 1, 1e-6, "T*", 6, "s", PETSC_FALSE));
    ok(PetscTime(&start));
    for (int i = 0; i < RUNS; i++) {
      ok(SlipPolicyEvaluate(p, obs, &a, NULL));
      obs[5] = a;
    }
    ok(PetscTime(&end));
    printf("benchmark: 6-64-64-1 %s policy, %.2f microseconds an evaluation\n", k ? "tanh" : "relu",
           (end - start) / RUNS * 1e6);
    ok(SlipPolicyDestroy(&p));
  }
}

static int NameFile(void **state)
{
  (void)state;
  snprintf(file, sizeof(file), "test_policy_%d.h5", (int)getpid());
  snprintf(part, sizeof(part), "%s.part", file);
  return 0;
}

static int RemoveFile(void **state)
{
  (void)state;
  unlink(file);
  return 0;
}

int main(int argc, char **argv)
{
  static const struct CMUnitTest tests[] = {
    cmocka_unit_test(forward),      cmocka_unit_test(steps),   cmocka_unit_test(range),    cmocka_unit_test(round_trip),
    cmocka_unit_test(broken_files), cmocka_unit_test(no_file), cmocka_unit_test(benchmark)};

  return RunTests(argc, argv, tests, NameFile, RemoveFile);
}
