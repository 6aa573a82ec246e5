/* CMake runs this program to check that the libraries match the headers it is compiled with, and that there is one
   HDF5. */
#define _GNU_SOURCE
#include <petscsys.h>
#include <petscblaslapack.h>
#include <hdf5.h>
#include <stdio.h>
#include <string.h>
#if defined(__linux__)
  #include <dlfcn.h>
  #include <link.h>

typedef struct {
  void *open[8]; /* addresses of H5open() */
  int n;
} Found;

/* Finds libraries by the symbols that they define, whatever their names are. */
static int Look(struct dl_phdr_info *info, size_t size, void *ctx)
{
  Found *found = (Found *)ctx;
  void *library = info->dlpi_name && info->dlpi_name[0] ? dlopen(info->dlpi_name, RTLD_LAZY | RTLD_NOLOAD) : NULL;
  void *open = library ? dlsym(library, "H5open") : NULL;

  (void)size;
  for (int i = 0; i < found->n; i++)
    if (found->open[i] == open) open = NULL;
  if (open && found->n < 8) found->open[found->n++] = open;
  if (library) dlclose(library);
  return 0;
}
#endif

int main(void)
{
  PetscInt major, minor, patch;
  unsigned h5[3];
  const PetscBLASInt two = 2, one = 1;
  const PetscReal x[2] = {3, 4};

  if (PetscGetVersionNumber(&major, &minor, &patch, NULL)) return 1;
  if (major != PETSC_VERSION_MAJOR || minor != PETSC_VERSION_MINOR) {
    printf("PETSc's headers are of version %d.%d, its library of %d.%d", PETSC_VERSION_MAJOR, PETSC_VERSION_MINOR,
           (int)major, (int)minor);
    return 1;
  }
  if (H5get_libversion(&h5[0], &h5[1], &h5[2]) < 0) return 1;
  if (h5[0] != H5_VERS_MAJOR || h5[1] != H5_VERS_MINOR || h5[2] != H5_VERS_RELEASE) {
    printf("HDF5's headers are of version %d.%d.%d, its library of %u.%u.%u", H5_VERS_MAJOR, H5_VERS_MINOR,
           H5_VERS_RELEASE, h5[0], h5[1], h5[2]);
    return 1;
  }
  if (BLASdot_(&two, x, &one, x, &one) != 25) {
    printf("BLAS of PETSc finds that 3^2 + 4^2 is not 25: are its integers of %d bits?", 8 * (int)sizeof(PetscBLASInt));
    return 1;
  }
#if defined(__linux__)
  {
    Found found = {.n = 0};
    Dl_info info;

    dl_iterate_phdr(Look, &found);
    if (found.n > 1) {
      printf("two HDF5 in one program,");
      for (int i = 0; i < found.n; i++)
        if (dladdr(found.open[i], &info)) printf(" %s", info.dli_fname);
      printf(": PETSc was built with another than this");
      return 1;
    }
  }
#endif
  printf("PETSc %d.%d.%d with HDF5 %u.%u.%u", (int)major, (int)minor, (int)patch, h5[0], h5[1], h5[2]);
  return 0;
}
