/* Writes attributes to HDF5 files, including live ones. */
#include <slipstep/private/slipsys.h>
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
  if (!has) PetscCall(SlipH5Group(h, path));
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
