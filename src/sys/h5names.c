/* Finds content of an HDF5 input that no code reads: unknown names of datasets and attributes, and unexpected units. */
#include <slipstep/rooms/sliph5.h>
#include <slipcompat.h>
#include <slipstep/private/slipsys.h>
#include <ctype.h>
#include <stdio.h>
#include <string.h>

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

/* Raises an error if the root of a file has unknown datasets or groups. names: known names, separated by blanks.
   Errors: PETSC_ERR_FILE_UNEXPECTED, with the name and the nearest known one. */
PetscErrorCode SlipH5CheckNames(SlipH5 *h, const char names[])
{
  char name[256], hint[SLIP_HINT_LENGTH];

  PetscFunctionBegin;
  for (hsize_t i = 0;
       H5Lget_name_by_idx(h->id, "/", H5_INDEX_NAME, H5_ITER_INC, i, name, sizeof(name), H5P_DEFAULT) >= 0; i++) {
    if (SlipH5IsAmong(name, names)) continue;
    PetscCall(SlipSuggestName(name, names, hint));
    SETERRQ(PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED, "%s holds /%s, which nothing reads, expected some of %s%s%s",
            h->name, name, names, h->source, hint);
  }
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
