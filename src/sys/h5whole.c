/* Checks that all metadata of an HDF5 file can be read.

   If a file is open for SWMR, HDF5 assumes that a block of metadata with a wrong checksum is being written by another
   process, and reads it 100 times, doubling the wait each time: for ever. A damaged file must therefore be detected
   before it is opened in this mode. */
#include <slipstep/private/slipsys.h>

/* For H5Lvisit(): reads the header of an object and, of a dataset, the index of its chunks, whose sizes its storage
   sums up; 1: it cannot be read */
static herr_t SlipH5ReadObject(hid_t location, const char *name, const H5L_info_t *info, void *ctx)
{
  const hid_t id = H5Oopen(location, name, H5P_DEFAULT);
  PetscBool good = id >= 0 ? PETSC_TRUE : PETSC_FALSE;

  (void)info;
  if (good && H5Iget_type(id) == H5I_DATASET) {
    (void)H5Dget_storage_size(id); /* also 0 on failure */
    if (H5Eget_num(H5E_DEFAULT) != 0) good = PETSC_FALSE;
  }
  if (id >= 0 && H5Oclose(id) < 0) good = PETSC_FALSE;
  if (good) return 0;
  (void)PetscStrncpy((char *)ctx, name, PETSC_MAX_PATH_LEN);
  return 1;
}

/* The file must not be open for SWMR; object: name of the first unreadable object, as far as it has one */
PetscBool SlipH5IsWhole(hid_t id, char object[PETSC_MAX_PATH_LEN])
{
  object[0] = '\0';
  return H5Lvisit(id, H5_INDEX_NAME, H5_ITER_NATIVE, SlipH5ReadObject, object) == 0 ? PETSC_TRUE : PETSC_FALSE;
}
