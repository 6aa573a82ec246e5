/* Dimensions with names, as netCDF-4 has them: HDF5's dimension scales, by its high-level library. xarray, ncdump and
   Panoply then show slip(time, z, x). */
#include <slipstep/private/slipsys.h>
#include <hdf5_hl.h>
#include <string.h>

#define SLIP_H5_MAX_DIM 4

/* Axes that are no data of their group: those of fields, which are shared with /mesh, of stations, and that of
   vectors */
static const char *const Axes[] = {"x", "z", "cell", "station", "component"};

static PetscErrorCode Failed(SlipH5 *h, const char path[])
{
  PetscFunctionBegin;
  PetscCall(SlipH5WriteFailed(h, 0, "the dimensions of %s to %s", path, h->name));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipH5MakeDimension - make a dimension that has a name and a length, and no coordinates

  Not collective.

  Input Parameters:
+ h    - file, not live
. path - dataset of the name, whose parents are created; it takes no space, and reads as zeros
- n    - length

  Level: developer

  Notes:
  As netCDF-4 writes what it calls a dimension without variable: ncdump and xarray show the dimension alone.

  Errors: PETSC_ERR_FILE_WRITE when it cannot be written

.seealso: SlipH5NameDimensions()
@*/
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

/* The scale group/name as an open dataset: one that is there, or a dimension of n */
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

/* Does the scale of this name, if it is there, have n entries? */
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

/* Names of the dimensions of a dataset: the row, then those axes that fit, and the last one for what remains */
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

/*@C
  SlipH5NameDimensions - name the dimensions of the datasets of a group, as netCDF-4 does

  Not collective.

  Input Parameters:
+ h     - file, not live, of which no other group has these datasets
. group - absolute path; "/" is the root
- axes  - names of the dimensions

  Level: developer

  Notes:
  The first dimension is the axis row, where there is one; the next ones are those axes that have as many entries, and
  what remains is the axis rest. An axis is a dataset of the group; rest is one of the root where there are no other
  axes, as all data of a table have its rows. One that is not there is made, without coordinates; a rest of another
  length than the first has that in its name. Dimensions that have a name already stay.

  Errors: PETSC_ERR_FILE_WRITE when the disk is full

.seealso: SlipH5CountAxes(), SlipH5Link(), SlipH5Live()
@*/
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
  for (PetscInt i = 0; i < n; i++) { /* those that are there become scales, before they would get some themselves */
    char path[128];
    PetscBool has;

    PetscCall(PetscSNPrintf(path, sizeof(path), "%s/%s", strcmp(group, "/") ? group : "", first[i]));
    PetscCall(SlipH5Has(h, path, &has));
    if (!has) continue;
    PetscCall(OpenScale(h, group, first[i], 0, &scale));
    H5Dclose(scale);
  }
  links = info.nlinks; /* what is made on the way is a scale itself */
  for (hsize_t i = 0; i < links; i++) {
    if (H5Lget_name_by_idx(h->id, group, H5_INDEX_NAME, H5_ITER_INC, i, name, sizeof(name), H5P_DEFAULT) < 0) break;
    PetscCall(NameOf(h, group, name, axes));
    PetscCheck(H5Gget_info_by_name(h->id, group, &info, H5P_DEFAULT) >= 0, PETSC_COMM_SELF, PETSC_ERR_FILE_WRITE,
               "%s has no group %s", h->name, group);
    links = info.nlinks;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipH5CountAxes - number of datasets of a group that are axes alone, not data

  Not collective.

  Input Parameters:
+ h     - file
- group - absolute path

  Output Parameter:
. n - their number; 0 in a file without names of dimensions

  Level: developer

.seealso: SlipH5NameDimensions(), SlipH5CountMembers()
@*/
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

/*@C
  SlipH5Link - give a dataset a second name

  Not collective.

  Input Parameters:
+ h    - file, not live
. path - the dataset, which need not be there
- name - absolute path of the other name

  Level: developer

  Errors: PETSC_ERR_FILE_WRITE when it cannot be written

.seealso: SlipH5NameDimensions()
@*/
PetscErrorCode SlipH5Link(SlipH5 *h, const char path[], const char name[])
{
  PetscBool has;

  PetscFunctionBegin;
  PetscCall(SlipH5Has(h, path, &has));
  if (has && H5Lcreate_hard(h->id, path, h->id, name, H5P_DEFAULT, H5P_DEFAULT) < 0) PetscCall(Failed(h, name));
  PetscFunctionReturn(PETSC_SUCCESS);
}
