/* Threads of BLAS in our programs: one, unless the user says how many. */
#define _GNU_SOURCE /* RTLD_DEFAULT, setenv() */
#include "../unit.h"
#include <slipstep/rooms/slipblas.h>
#include <slipstep/rooms/slipsys.h>
#include <dlfcn.h>
#include <stdlib.h>
#include <string.h>

/* SlipProgramInitialize() with two threads before it; PETSc has begun already. */
static int ThreadsOfProgram(void)
{
  void *symbol = dlsym(RTLD_DEFAULT, "openblas_get_num_threads");
  char name[] = "fault", *arguments[] = {name, NULL}, **argv = arguments;
  int argc = 1, (*get)(void);

  if (!symbol) return 0;
  memcpy(&get, &symbol, sizeof(get));
  SlipBLASSetNumThreads(2);
  if ((*get)() != 2) return 0; /* one that was built without threads */
  ok(SlipProgramInitialize(&argc, &argv, "fault", ""));
  return (*get)();
}

static void threads(void **state)
{
  static const char *const said[] = {"OPENBLAS_NUM_THREADS", "GOTO_NUM_THREADS", "MKL_NUM_THREADS", "BLIS_NUM_THREADS",
                                     "OMP_NUM_THREADS"};
  int n;

  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(said); i++) assert_int_equal(unsetenv(said[i]), 0);
  n = ThreadsOfProgram();
  if (!n) skip();
  assert_int_equal(n, 1);
  assert_int_equal(setenv("OPENBLAS_NUM_THREADS", "2", 1), 0);
  assert_int_equal(ThreadsOfProgram(), 2);
  SlipBLASSetNumThreads(1);
}

SLIP_TESTS(threads)
