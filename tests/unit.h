/* What the cmocka tests share: ok() and fails() around calls that return an error code, and RunTests() for main(). */
#pragma once
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <stdio.h>
#include <string.h>
#include <slipstep.h>
#include <slipcompat.h>

static char message[4096], raised[256]; /* of the last error, and where it was raised */

/* The error handler of RunTests(): PETSc's own would print a trace of the errors that a test asks for. */
static inline PetscErrorCode Record(MPI_Comm comm, int line, const char *fun, const char *src, PetscErrorCode n,
                                    PetscErrorType p, const char *mess, void *ctx)
{
  (void)comm, (void)ctx;
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

/* The tests between PETSc's start and end; returns main()'s exit code. setup and teardown of the group may be NULL. */
#define RunTests(argc, argv, tests, setup, teardown)                                                                   \
  RunGroup(argc, argv, #tests, tests, sizeof(tests) / sizeof((tests)[0]), setup, teardown)
static inline int RunGroup(int argc, char **argv, const char name[], const struct CMUnitTest tests[], size_t n,
                           CMFixtureFunction setup, CMFixtureFunction teardown)
{
  int failed;

  if (PetscInitialize(&argc, &argv, NULL, NULL) || SlipStepInitializePackage()) return 1;
  if (PetscPushErrorHandler(Record, NULL)) return 1;
  failed = _cmocka_run_group_tests(name, tests, n, setup, teardown);
  if (PetscPopErrorHandler()) return 1;
  return PetscFinalize() || failed;
}
