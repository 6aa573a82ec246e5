/* Threads of BLAS. Which BLAS a program has is known when it runs only (Debian chooses by update-alternatives), so that
   its function is looked up by name; PetscBLASSetNumThreads() of PETSc 3.20 and later knows that of its
   configuration. */
#define _GNU_SOURCE /* RTLD_DEFAULT */
#include <slipblas.h>
#include <dlfcn.h>
#include <string.h>

/*@C
  SlipBLASSetNumThreads - say how many threads BLAS may use in this process

  Not collective; does nothing where BLAS is none of OpenBLAS, MKL and BLIS.

  Input Parameter:
. n - the number of threads

  Level: developer

.seealso: SlipStepInitializePackage()
@*/
void SlipBLASSetNumThreads(int n)
{
  /* OpenBLAS, MKL and BLIS; the last takes its dim_t */
  static const char *const names[] = {"openblas_set_num_threads", "MKL_Set_Num_Threads", "bli_thread_set_num_threads"};

  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(names); i++) {
    void *symbol = dlsym(RTLD_DEFAULT, names[i]);
    void (*set)(long);

    if (!symbol) continue;
    memcpy(&set, &symbol, sizeof(set)); /* ISO C knows no conversion */
    set((long)n);
  }
}
