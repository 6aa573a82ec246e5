/* Threads of BLAS. The BLAS of a program is known only when it runs (Debian selects it by update-alternatives), so that
   its function is looked up by name; PetscBLASSetNumThreads() of PETSc 3.20 and later uses that of PETSc's
   configuration. */
#define _GNU_SOURCE /* RTLD_DEFAULT */
#include <slipstep/rooms/slipblas.h>
#include <dlfcn.h>
#include <string.h>

/* Sets how many threads BLAS may use in this process. */
void SlipBLASSetNumThreads(int n)
{
  /* functions of OpenBLAS, MKL and BLIS; that of BLIS has a dim_t argument */
  static const char *const names[] = {"openblas_set_num_threads", "MKL_Set_Num_Threads", "bli_thread_set_num_threads"};

  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(names); i++) {
    void *symbol = dlsym(RTLD_DEFAULT, names[i]);
    void (*set)(long);

    if (!symbol) continue;
    memcpy(&set, &symbol, sizeof(set)); /* ISO C has no conversion for this */
    set((long)n);
  }
}
