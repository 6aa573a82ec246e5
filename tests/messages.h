/* For cmocka tests of error messages: PetscPushErrorHandler(Record, NULL) first. */
#pragma once
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <petscsys.h>
#include <stdio.h>
#include <string.h>

static char message[4096]; /* of the last error, where it was raised */

static inline PetscErrorCode Record(MPI_Comm comm, int line, const char *fun, const char *src, PetscErrorCode n,
                                    PetscErrorType p, const char *mess, void *ctx)
{
  (void)comm, (void)line, (void)fun, (void)src, (void)ctx;
  if (p == PETSC_ERROR_INITIAL) snprintf(message, sizeof(message), "%s", mess);
  return n;
}

#define ok(call) assert_int_equal(0, (int)(call))
#define fails(call, want)                                                                                              \
  do {                                                                                                                 \
    message[0] = 0;                                                                                                    \
    assert_int_not_equal(0, (int)(call));                                                                              \
    if (!strstr(message, want)) fail_msg("expected \"%s\" in \"%s\"", want, message);                                  \
  } while (0)
