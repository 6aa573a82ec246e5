/* Datasets that show a part of another one (HDF5's virtual datasets), so that the file stores the numbers only once */
#include <slipstep/private/slipsys.h>

/* Creates a dataset that shows one entry of each row of a series of vectors. path: of the dataset, [rows, 3], whose
   group exists; it has as many rows as the series, also while that grows; series: path of an existing series [rows,
   entries, 3]. Programs with HDF5 1.10 or later read it as any other dataset. It takes about 500 bytes. Errors:
   PETSC_ERR_FILE_WRITE when there is no such series, the path exists or cannot be written. */
PetscErrorCode SlipH5CreateView(SlipH5 *h, const char path[], const char series[], PetscInt entry, const char units[])
{
  const hsize_t grows = H5S_UNLIMITED, none[3] = {0, 0, 0}, from[3] = {0, (hsize_t)entry, 0}, rows[3] = {grows, 1, 1},
                inner[2] = {1, 3}, outer[3] = {1, 1, 3}, limit[2] = {grows, 3}, empty[2] = {0, 3};
  const hid_t all = H5Dopen2(h->id, series, H5P_DEFAULT), source = all < 0 ? -1 : H5Dget_space(all),
              space = H5Screate_simple(2, empty, limit), dcpl = H5Pcreate(H5P_DATASET_CREATE);
  hid_t set = -1;

  PetscFunctionBegin;
  if (source >= 0 && H5Sget_simple_extent_ndims(source) == 3 &&
      H5Sselect_hyperslab(space, H5S_SELECT_SET, none, NULL, rows, inner) >= 0 &&
      H5Sselect_hyperslab(source, H5S_SELECT_SET, from, NULL, rows, outer) >= 0 &&
      H5Pset_virtual(dcpl, space, ".", series, source) >= 0)
    set = H5Dcreate2(h->id, path, H5T_IEEE_F64LE, space, H5P_DEFAULT, dcpl, H5P_DEFAULT);
  H5Pclose(dcpl);
  H5Sclose(space);
  if (source >= 0) H5Sclose(source);
  if (all >= 0) H5Dclose(all);
  if (set < 0 || H5Dclose(set) < 0) PetscCall(SlipH5WriteFailed(h, 0, "dataset %s to %s", path, h->name));
  PetscCall(SlipH5WriteAttrString(h, path, "units", units));
  PetscFunctionReturn(PETSC_SUCCESS);
}
