/* Can all metadata of an HDF5 file be read?

   HDF5 takes a block of metadata whose checksum is wrong for one that another process is writing where the file is open
   for SWMR, and reads it 100 times, after twice the time before each: for ever. A file that is damaged must be known as
   such before it is written in this mode. */
#include <slipstep/private/slipsys.h>

/* H5Lvisit(): header of an object and, of a dataset, the index of its chunks, which its storage is the sum of; 1: it
   cannot be read */
static herr_t SlipH5ReadObject(hid_t location, const char *name, const H5L_info_t *info, void *ctx)
{
  const hid_t id = H5Oopen(location, name, H5P_DEFAULT);
  PetscBool good = id >= 0 ? PETSC_TRUE : PETSC_FALSE;

  (void)info;
  if (good && H5Iget_type(id) == H5I_DATASET) {
    (void)H5Dget_storage_size(id); /* 0 also when it fails */
    if (H5Eget_num(H5E_DEFAULT) != 0) good = PETSC_FALSE;
  }
  if (id >= 0 && H5Oclose(id) < 0) good = PETSC_FALSE;
  if (good) return 0;
  (void)PetscStrncpy((char *)ctx, name, PETSC_MAX_PATH_LEN);
  return 1;
}

/* Of a file that is not open for SWMR; object: name of the first that cannot be read, as far as it has one */
PetscBool SlipH5IsWhole(hid_t id, char object[PETSC_MAX_PATH_LEN])
{
  object[0] = '\0';
  return H5Lvisit(id, H5_INDEX_NAME, H5_ITER_NATIVE, SlipH5ReadObject, object) == 0 ? PETSC_TRUE : PETSC_FALSE;
}
