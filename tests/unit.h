/* What the cmocka tests share: ok() and fails() around calls that return an error code, main(), and a rock. */
#pragma once
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <stdio.h>
#include <string.h>
#include "objects.h"

/* The kernel of vertical strike-slip cells in a rock */
#define ROCK(nu, full_space, average)                                                                                  \
  {                                                                                                                    \
    &SlipKernelStrikeSlip, 30e9, nu, full_space, average, NULL                                                         \
  }

static char message[4096], raised[256]; /* of the last error, and where it was raised */

/* The error handler of the tests: PETSc's own would print a trace of the errors that a test asks for. */
static inline PetscErrorCode Record(MPI_Comm comm, int line, const char *fun, const char *src, PetscErrorCode n,
                                    PetscErrorType p, const char *mess, void *ctx)
{
  if (p == PETSC_ERROR_INITIAL) {
    snprintf(message, sizeof(message), "%s", mess ? mess : "");
    snprintf(raised, sizeof(raised), "%s() at %s:%d", fun, src, line);
  }
  return n;
}

#define ok(...)                                                                                                        \
  do {                                                                                                                 \
    const int code = (int)(__VA_ARGS__);                                                                               \
    if (code) fail_msg("%s: error %d in %s: %s", #__VA_ARGS__, code, raised, message);                                 \
  } while (0)
#define fails(call, want)                                                                                              \
  do {                                                                                                                 \
    message[0] = 0;                                                                                                    \
    assert_int_not_equal(0, (int)(call));                                                                              \
    if (!strstr(message, want)) fail_msg("expected \"%s\" in \"%s\"", want, message);                                  \
  } while (0)

static inline void AssertNear(PetscReal value, PetscReal reference, PetscReal allowed)
{
  if (!(PetscAbsReal(value - reference) <= allowed))
    fail_msg("%.15g, expected %.15g, off by %g", (double)value, (double)reference, (double)(value - reference));
}

#define AssertLess(a, b) AssertOrder(a, b, #a " < " #b)
static inline void AssertOrder(PetscReal a, PetscReal b, const char claim[])
{
  if (!(a < b)) fail_msg("%s: %.15g and %.15g", claim, (double)a, (double)b);
}

/* Vectors, in this norm; value becomes the difference. */
static inline void AssertVecNear(Vec value, Vec reference, NormType norm, PetscReal allowed)
{
  PetscReal error;

  ok(VecAXPY(value, -1, reference));
  ok(VecNorm(value, norm, &error));
  if (!(error <= allowed)) fail_msg("off by %g, expected at most %g", (double)error, (double)allowed);
}

/* To a share of the reference's norm */
static inline void AssertVecClose(Vec value, Vec reference, NormType norm, PetscReal share)
{
  PetscReal size;

  ok(VecNorm(reference, norm, &size));
  AssertVecNear(value, reference, norm, share * size);
}

/* A TS of a type, from 0 to end, which it meets, with the first step dt */
static inline TS MakeTS(TSType type, PetscReal dt, PetscReal end)
{
  TS ts;

  ok(TSCreate(PETSC_COMM_SELF, &ts));
  ok(TSSetType(ts, type));
  ok(TSSetTimeStep(ts, dt));
  ok(TSSetMaxTime(ts, end));
  ok(TSSetMaxSteps(ts, 1000000));
  ok(TSSetExactFinalTime(ts, TS_EXACTFINALTIME_MATCHSTEP));
  return ts;
}

static inline void SetAdapt(TS ts, TSAdaptType type)
{
  TSAdapt adapt;

  ok(TSGetAdapt(ts, &adapt));
  ok(TSAdaptSetType(adapt, type));
}

#define VecsDuplicate(...) ok(DuplicateVecs(__VA_ARGS__))
#define ObjectsDestroy(...) ok(DestroyObjects(__VA_ARGS__))

/* main() of a program of these tests, between PETSc's start and end; _WITH: setup and teardown of the group. */
#define SLIP_TESTS(...) SLIP_TESTS_WITH(NULL, NULL, __VA_ARGS__)
#define SLIP_TESTS_WITH(setup, teardown, ...)                                                                          \
  int main(int argc, char **argv)                                                                                      \
  {                                                                                                                    \
    const CMUnitTestFunction tests[] = {__VA_ARGS__};                                                                  \
    return RunTests(argc, argv, sizeof(tests) / sizeof(*tests), tests, (char[]){#__VA_ARGS__}, setup, teardown);       \
  }

/* names: of the tests, with commas between; they are cut in place. Returns main()'s exit code. */
static inline int RunTests(int argc, char **argv, size_t n, const CMUnitTestFunction function[], char names[],
                           CMFixtureFunction setup, CMFixtureFunction teardown)
{
  struct CMUnitTest tests[32] = {{0}};
  int failed;

  if (n > sizeof(tests) / sizeof(*tests)) return 1;
  for (size_t i = 0; i < n; i++) {
    tests[i].name = strtok(i ? NULL : names, ", ");
    tests[i].test_func = function[i];
  }
  if (PetscInitialize(&argc, &argv, NULL, NULL) || SlipStepInitializePackage()) return 1;
  if (PetscPushErrorHandler(Record, NULL)) return 1;
  failed = _cmocka_run_group_tests("tests", tests, n, setup, teardown);
  if (PetscPopErrorHandler()) return 1;
  return PetscFinalize() || failed;
}
