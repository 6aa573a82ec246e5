/* Attributes, units and names of HDF5 files: writes attributes, also of live files; finds content of an input that no
   code reads; and names dimensions as netCDF-4 does, by dimension scales of HDF5's high-level library. With them
   xarray, ncdump and Panoply show slip(time, z, x). */
#include <slipstep/private/sliph5.h>
#include <slipstep/private/slipsys.h>
#include <ctype.h>
#include <hdf5_hl.h>
#include <string.h>

/* n = 0: a scalar. An existing attribute is replaced, in place if its type is the same, which a live file allows; a
   list cannot change its length. */
static PetscErrorCode SlipH5WriteAttr(SlipH5 *h, const char path[], const char attr[], PetscInt n, hid_t file_type,
                                      hid_t mem_type, const void *value)
{
  const hsize_t size = (hsize_t)n;
  hid_t object, space, type, id = -1;
  herr_t err = -1;
  PetscBool has;

  PetscFunctionBegin;
  PetscCall(SlipH5Has(h, path, &has));
  if (!has) PetscCall(SlipH5Group(h, path, PETSC_FALSE));
  object = H5Oopen(h->id, path, H5P_DEFAULT); /* HDF5 1.10 cannot write what H5Aopen_by_name() opens */
  if (H5Aexists(object, attr) > 0) {
    id = H5Aopen(object, attr, H5P_DEFAULT);
    type = H5Aget_type(id);
    if (H5Tequal(type, file_type) <= 0) {
      H5Aclose(id);
      id = -1;
      H5Adelete(object, attr);
    }
    H5Tclose(type);
  }
  space = n ? H5Screate_simple(1, &size, NULL) : H5Screate(H5S_SCALAR);
  if (id < 0) id = H5Acreate2(object, attr, file_type, space, H5P_DEFAULT, H5P_DEFAULT);
  if (id >= 0) {
    err = H5Awrite(id, mem_type, value);
    if (H5Aclose(id) < 0) err = -1;
  }
  if (H5Oclose(object) < 0) err = -1;
  H5Sclose(space);
  PetscCheck(err >= 0 || h->failed, PETSC_COMM_SELF, PETSC_ERR_FILE_WRITE, "cannot write attribute %s of %s to %s",
             attr, path, h->name);
  if (h->failed) PetscCall(SlipH5WriteFailed(h, 0, "attribute %s of %s to %s", attr, path, h->name));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes a real attribute; the group is created if the path does not exist. value: the number, in a unit that readers
   must know. */
PetscErrorCode SlipH5WriteAttrReal(SlipH5 *h, const char path[], const char attr[], PetscReal value)
{
  PetscFunctionBegin;
  PetscCall(SlipH5WriteAttr(h, path, attr, 0, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, &value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes an integer attribute (64 bits); the group is created if the path does not exist. */
PetscErrorCode SlipH5WriteAttrInt(SlipH5 *h, const char path[], const char attr[], PetscInt value)
{
  PetscFunctionBegin;
  PetscCall(SlipH5WriteAttr(h, path, attr, 0, H5T_STD_I64LE, SlipH5PetscInt(), &value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes a list of integers (64 bits) as an attribute; the group is created if it does not exist. attr: name of the
   attribute, which must not exist with another length; n: number of integers, 1 to 8000: HDF5 has 64 kB for an
   attribute. Errors: PETSC_ERR_FILE_WRITE. */
PetscErrorCode SlipH5WriteAttrInts(SlipH5 *h, const char path[], const char attr[], PetscInt n, const PetscInt values[])
{
  PetscFunctionBegin;
  PetscCall(SlipH5WriteAttr(h, path, attr, n, H5T_STD_I64LE, SlipH5PetscInt(), values));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes a string attribute (fixed length, UTF-8); the group is created if it does not exist. */
PetscErrorCode SlipH5WriteAttrString(SlipH5 *h, const char path[], const char attr[], const char value[])
{
  const hid_t type = H5Tcopy(H5T_C_S1);
  PetscErrorCode ierr;

  PetscFunctionBegin;
  H5Tset_size(type, strlen(value) + 1);
  H5Tset_cset(type, H5T_CSET_UTF8);
  ierr = SlipH5WriteAttr(h, path, attr, 0, type, type, value);
  H5Tclose(type);
  PetscCall(ierr);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- content that nothing reads ---- */

/* True if name is one of names, which blanks separate */
static PetscBool SlipH5IsAmong(const char name[], const char names[])
{
  char each[SLIP_NAME_LENGTH];

  while (SlipNextName("", &names, each))
    if (!strcmp(name, each)) return PETSC_TRUE;
  return PETSC_FALSE;
}

typedef struct {
  char **name;
  PetscInt n, most;
} SlipH5Names;

/* For H5Aiterate2(): stops, with 1, at one attribute too many */
static herr_t SlipH5AddName(hid_t location, const char *name, const H5A_info_t *info, void *ctx)
{
  SlipH5Names *names = (SlipH5Names *)ctx;

  (void)location;
  (void)info;
  if (names->n == names->most) return 1;
  return PetscStrallocpy(name, &names->name[names->n++]) ? -1 : 0;
}

PetscErrorCode SlipH5GetAttributes(SlipH5 *h, PetscInt most, PetscInt *n, char *names[])
{
  SlipH5Names list = {.name = names, .most = most};
  herr_t failed = H5Aexists(h->id, "/"); /* this reads all attributes; if it fails, H5Aiterate2() would crash */

  PetscFunctionBegin;
  if (failed >= 0) failed = H5Aiterate2(h->id, H5_INDEX_NAME, H5_ITER_INC, NULL, SlipH5AddName, &list);
  for (PetscInt k = 0; k < list.n && failed; k++) PetscCall(PetscFree(names[k]));
  PetscCheck(failed <= 0, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
             "%s: / has more than %" PetscInt_FMT " attributes", h->name, most);
  PetscCheck(failed >= 0, PETSC_COMM_SELF, PETSC_ERR_FILE_READ, "%s: cannot list the attributes of /: damaged file?",
             h->name);
  *n = list.n;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipH5IsText(SlipH5 *h, const char path[], const char attr[], PetscBool *text)
{
  const hid_t id = H5Aopen_by_name(h->id, path, attr, H5P_DEFAULT, H5P_DEFAULT), type = H5Aget_type(id);

  PetscFunctionBegin;
  *text = H5Tget_class(type) == H5T_STRING ? PETSC_TRUE : PETSC_FALSE;
  H5Tclose(type);
  H5Aclose(id);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets the name of member k of a group, in the order of names; false where there is none. */
PetscBool SlipH5MemberName(SlipH5 *h, const char group[], PetscInt k, char name[], size_t len)
{
  return H5Lget_name_by_idx(h->id, group, H5_INDEX_NAME, H5_ITER_INC, (hsize_t)k, name, len, H5P_DEFAULT) >= 0
           ? PETSC_TRUE
           : PETSC_FALSE;
}

/* Raises an error if a group has unknown datasets or groups. names: known names, separated by blanks. Errors:
   PETSC_ERR_FILE_UNEXPECTED, with the name and the nearest known one. */
PetscErrorCode SlipH5CheckMembers(SlipH5 *h, const char group[], const char names[])
{
  const char *in = strcmp(group, "/") ? group : "";
  char name[256], hint[SLIP_HINT_LENGTH];

  PetscFunctionBegin;
  for (PetscInt i = 0; SlipH5MemberName(h, group, i, name, sizeof(name)); i++) {
    if (SlipH5IsAmong(name, names)) continue;
    PetscCall(SlipSuggestName(name, names, hint));
    SETERRQ(PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED, "%s holds %s/%s, which nothing reads, expected some of %s%s%s",
            h->name, in, name, names, h->source, hint);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Does so for the root of a file. */
PetscErrorCode SlipH5CheckNames(SlipH5 *h, const char names[])
{
  PetscFunctionBegin;
  PetscCall(SlipH5CheckMembers(h, "/", names));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Raises an error if a dataset has unknown attributes. path: the dataset, which must exist; names: known attributes,
   separated by blanks. Names that begin with a capital or "_" are those of HDF5's and netCDF's conventions, and are
   ignored. Errors: PETSC_ERR_FILE_UNEXPECTED, with the name and the nearest known one. */
PetscErrorCode SlipH5CheckAttributes(SlipH5 *h, const char path[], const char names[])
{
  char name[256], hint[SLIP_HINT_LENGTH];

  PetscFunctionBegin;
  for (hsize_t i = 0;
       H5Aget_name_by_idx(h->id, path, H5_INDEX_NAME, H5_ITER_INC, i, name, sizeof(name), H5P_DEFAULT) >= 0; i++) {
    if (SlipH5IsAmong(name, names) || isupper((unsigned char)name[0]) || name[0] == '_') continue;
    PetscCall(SlipSuggestName(name, names, hint));
    SETERRQ(PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
            "%s of %s has the attribute \"%s\", which nothing reads, expected some of %s%s%s", path, h->name, name,
            names, h->source, hint);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Raises an error if a dataset has other units than those expected. path: the dataset, which must exist; unit: "" for
   numbers without one; has: whether it has units, in the attribute "units". Errors: PETSC_ERR_FILE_UNEXPECTED, with its
   units and those expected. */
PetscErrorCode SlipH5CheckUnits(SlipH5 *h, const char path[], const char unit[], PetscBool *has)
{
  char text[64];

  PetscFunctionBegin;
  PetscCall(SlipH5HasAttribute(h, path, "units", has));
  if (!*has) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipH5ReadAttrString(h, path, "units", text, sizeof(text)));
  PetscCheck(!strcmp(text, unit) || (!unit[0] && (!strcmp(text, "1") || !strcmp(text, "-"))), PETSC_COMM_SELF,
             PETSC_ERR_FILE_UNEXPECTED, "%s of %s has the units \"%s\", expected \"%s\"%s", path, h->name, text,
             unit[0] ? unit : "1", h->source);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- dimensions ---- */

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

/* Gets the number of groups and datasets in a group, without datasets that are only axes, not data. path: absolute path
   of the group. Errors: PETSC_ERR_FILE_UNEXPECTED when there is no such group. */
PetscErrorCode SlipH5CountMembers(SlipH5 *h, const char path[], PetscInt *n)
{
  H5G_info_t info = {0};
  char axis[128];
  PetscBool has;

  PetscFunctionBegin;
  PetscCheck(H5Gget_info_by_name(h->id, path, &info, H5P_DEFAULT) >= 0, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
             "%s has no group %s%s", h->name, path, h->source);
  *n = (PetscInt)info.nlinks;
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(Axes); i++) {
    PetscCall(PetscSNPrintf(axis, sizeof(axis), "%s/%s", path, Axes[i]));
    PetscCall(SlipH5HasAttribute(h, axis, "CLASS", &has));
    if (has) --*n;
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
