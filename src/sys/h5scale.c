/* Named dimensions, as in netCDF-4: HDF5's dimension scales, by its high-level library. With them xarray, ncdump and
   Panoply show slip(time, z, x). */
#include <slipstep/private/slipsys.h>
#include <hdf5_hl.h>
#include <string.h>

#define SLIP_H5_MAX_DIM 4

/* Axes that are no data of their group: those of fields, which are shared with /mesh, of stations, and of vector
   components */
static const char *const Axes[] = {"x", "z", "cell", "station", "component"};

static PetscErrorCode Failed(SlipH5 *h, const char path[])
{
  PetscFunctionBegin;
  PetscCall(SlipH5WriteFailed(h, 0, "the dimensions of %s to %s", path, h->name));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates a dimension that has a name and a length, and no coordinates. path: dataset of the name, whose parents are
   created; it takes no space, and reads as zeros. The dataset is netCDF-4's dimension without variable: ncdump and
   xarray show only the dimension. Errors: PETSC_ERR_FILE_WRITE when it cannot be written. */
PetscErrorCode SlipH5MakeDimension(SlipH5 *h, const char path[], PetscInt n)
{
  const hsize_t size = (hsize_t)n;
  const hid_t space = H5Screate_simple(1, &size, NULL), lcpl = H5Pcreate(H5P_LINK_CREATE),
              dcpl = H5Pcreate(H5P_DATASET_CREATE);
  char name[64];
  hid_t set;

  PetscFunctionBegin;
  PetscCall(PetscSNPrintf(name, sizeof(name), "This is a netCDF dimension but not a netCDF variable.%10d", (int)n));
  H5Pset_create_intermediate_group(lcpl, 1);
  H5Pset_alloc_time(dcpl, H5D_ALLOC_TIME_LATE);
  set = H5Dcreate2(h->id, path, H5T_IEEE_F32BE, space, lcpl, dcpl, H5P_DEFAULT);
  H5Pclose(dcpl);
  H5Pclose(lcpl);
  H5Sclose(space);
  if (set < 0 || H5DSset_scale(set, name) < 0 || H5Dclose(set) < 0) PetscCall(Failed(h, path));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Opens the scale group/name as a dataset: an existing one, or a new dimension of length n. */
static PetscErrorCode OpenScale(SlipH5 *h, const char group[], const char name[], hsize_t n, hid_t *scale)
{
  char path[128];
  PetscBool has;

  PetscFunctionBegin;
  PetscCall(PetscSNPrintf(path, sizeof(path), "%s/%s", strcmp(group, "/") ? group : "", name));
  PetscCall(SlipH5Has(h, path, &has));
  if (!has) PetscCall(SlipH5MakeDimension(h, path, (PetscInt)n));
  *scale = H5Dopen2(h->id, path, H5P_DEFAULT);
  if (*scale < 0 || (H5DSis_scale(*scale) <= 0 && H5DSset_scale(*scale, name) < 0)) PetscCall(Failed(h, path));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Checks whether the scale of this name, if it exists, has n entries. */
static PetscErrorCode Fits(SlipH5 *h, const char group[], const char name[], hsize_t n, PetscBool *fits)
{
  char path[128];
  PetscBool has;
  PetscInt size;

  PetscFunctionBegin;
  PetscCall(PetscSNPrintf(path, sizeof(path), "%s/%s", strcmp(group, "/") ? group : "", name));
  PetscCall(SlipH5Has(h, path, &has));
  if (has) PetscCall(SlipH5GetSize(h, path, 0, &size));
  *fits = !has || (hsize_t)size == n ? PETSC_TRUE : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Names the dimensions of a dataset: the row, then the axes of matching length, and the last name for all others. */
static PetscErrorCode NameOf(SlipH5 *h, const char group[], const char name[], const SlipH5Axes *axes)
{
  const char *const rest = axes->n ? group : "/";
  hsize_t shape[SLIP_H5_MAX_DIM];
  char path[128], other[64];
  hid_t set, space, scale;
  PetscInt next = 0;
  int rank;

  PetscFunctionBegin;
  PetscCall(PetscSNPrintf(path, sizeof(path), "%s/%s", strcmp(group, "/") ? group : "", name));
  set = H5Dopen2(h->id, path, H5P_DEFAULT);
  if (set < 0) PetscFunctionReturn(PETSC_SUCCESS); /* a group */
  space = H5Dget_space(set);
  rank = H5Sget_simple_extent_ndims(space);
  if (rank < 1 || rank > SLIP_H5_MAX_DIM || H5Sget_simple_extent_dims(space, shape, NULL) != rank) rank = 0;
  H5Sclose(space);
  for (int d = 0; d < rank && H5DSis_scale(set) <= 0; d++) {
    const char *axis = NULL;
    PetscBool fits = PETSC_FALSE;

    if (H5DSget_num_scales(set, (unsigned)d) > 0) continue;
    if (!d && axes->row) axis = axes->row;
    while (!axis && next < axes->n && !fits) {
      PetscCall(Fits(h, group, axes->axis[next], shape[d], &fits));
      if (fits) axis = axes->axis[next];
      next++;
    }
    if (axis)
      PetscCall(OpenScale(h, group, axis, shape[d], &scale));
    else {
      axis = axes->rest ? axes->rest : "component";
      PetscCall(Fits(h, rest, axis, shape[d], &fits));
      if (!fits) PetscCall(PetscSNPrintf(other, sizeof(other), "%s_%d", axis, (int)shape[d]));
      PetscCall(OpenScale(h, rest, fits ? axis : other, shape[d], &scale));
    }
    if (H5DSattach_scale(set, scale, (unsigned)d) < 0) PetscCall(Failed(h, path));
    H5Dclose(scale);
  }
  if (H5Dclose(set) < 0) PetscCall(Failed(h, path));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Names the dimensions of the datasets of a group, as netCDF-4 does. h: file, not live, in which no other group has
   these datasets; group: absolute path; "/" is the root; axes: names of the dimensions. The first dimension is the axis
   row, if there is one; the next ones are the axes of matching length, and all others are the axis rest. An axis is a
   dataset of the group; rest is one of the root if there are no other axes, because all data of a table have its rows.
   A missing axis is created, without coordinates; if rests differ in length, all but the first have the length in their
   names. Dimensions that have a name already are not changed. Errors: PETSC_ERR_FILE_WRITE when the disk is full. */
PetscErrorCode SlipH5NameDimensions(SlipH5 *h, const char group[], const SlipH5Axes *axes)
{
  const char *first[1 + SLIP_H5_MAX_DIM];
  char name[128];
  hsize_t links;
  H5G_info_t info;
  hid_t scale;
  PetscInt n = 0;

  PetscFunctionBegin;
  PetscCheck(H5Gget_info_by_name(h->id, group, &info, H5P_DEFAULT) >= 0, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
             "%s has no group %s", h->name, group);
  if (axes->row) first[n++] = axes->row;
  for (PetscInt i = 0; i < axes->n; i++) first[n++] = axes->axis[i];
  for (PetscInt i = 0; i < n; i++) { /* existing axes become scales before they could get scales themselves */
    char path[128];
    PetscBool has;

    PetscCall(PetscSNPrintf(path, sizeof(path), "%s/%s", strcmp(group, "/") ? group : "", first[i]));
    PetscCall(SlipH5Has(h, path, &has));
    if (!has) continue;
    PetscCall(OpenScale(h, group, first[i], 0, &scale));
    H5Dclose(scale);
  }
  links = info.nlinks; /* datasets created in the loop are scales themselves */
  for (hsize_t i = 0; i < links; i++) {
    if (H5Lget_name_by_idx(h->id, group, H5_INDEX_NAME, H5_ITER_INC, i, name, sizeof(name), H5P_DEFAULT) < 0) break;
    PetscCall(NameOf(h, group, name, axes));
    PetscCheck(H5Gget_info_by_name(h->id, group, &info, H5P_DEFAULT) >= 0, PETSC_COMM_SELF, PETSC_ERR_FILE_WRITE,
               "%s has no group %s", h->name, group);
    links = info.nlinks;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets the number of datasets of a group that are only axes, not data. n: their number; 0 in a file without names of
   dimensions. */
PetscErrorCode SlipH5CountAxes(SlipH5 *h, const char group[], PetscInt *n)
{
  char path[128];
  PetscBool has;

  PetscFunctionBegin;
  *n = 0;
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(Axes); i++) {
    PetscCall(PetscSNPrintf(path, sizeof(path), "%s/%s", group, Axes[i]));
    PetscCall(SlipH5Has(h, path, &has));
    if (!has) continue;
    PetscCall(SlipH5HasAttribute(h, path, "CLASS", &has));
    if (has) ++*n;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gives a dataset a second name. path: the dataset, which need not exist yet; name: absolute path of the other name.
   Errors: PETSC_ERR_FILE_WRITE when it cannot be written. */
PetscErrorCode SlipH5Link(SlipH5 *h, const char path[], const char name[])
{
  PetscBool has;

  PetscFunctionBegin;
  PetscCall(SlipH5Has(h, path, &has));
  if (has && H5Lcreate_hard(h->id, path, h->id, name, H5P_DEFAULT, H5P_DEFAULT) < 0) PetscCall(Failed(h, name));
  PetscFunctionReturn(PETSC_SUCCESS);
}
