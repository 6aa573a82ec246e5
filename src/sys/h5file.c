/* Opens HDF5 files for reading, and queries their content. */
#include <slipstep/private/slipsys.h>
#include <slipstep/rooms/slipsys.h>
#include <stdio.h>
#include <sys/stat.h>
#include <slipstep/private/slipwork.h>

/* The most recent files that options have named for reading, none of which may be an output */
#define SLIP_H5_INPUTS 32
static struct {
  char name[PETSC_MAX_PATH_LEN], source[64];
} inputs[SLIP_H5_INPUTS];
static PetscInt ninputs;

/* Initialises a SlipH5 without a file, with the option that messages will name. */
PetscErrorCode SlipH5Clear(const char prefix[], const char option[], SlipH5 *h)
{
  PetscFunctionBegin;
  PetscCall(PetscMemzero(h, sizeof(*h)));
  h->id = -1;
  h->fd = -1;
  if (option) PetscCall(PetscSNPrintf(h->source, sizeof(h->source), " (-%s%s)", prefix ? prefix : "", option));
  /* HDF5 would print its own stack of errors, without the names of file and dataset. */
  PetscCheck(H5Eset_auto2(H5E_DEFAULT, NULL, NULL) >= 0, PETSC_COMM_SELF, PETSC_ERR_LIB, "HDF5 cannot be initialised");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipH5OpenReadOption - opens an HDF5 file that an option names for reading

  Not collective: call on one rank and broadcast what was read.

  Input Parameters:
+ prefix - options prefix of the object that reads it, or NULL
. option - name of the option without dash and prefix, for messages; NULL: no option named the file
- file   - its name

  Output Parameter:
. h - the open file

  Level: developer

  Errors: PETSC_ERR_FILE_OPEN if it is missing, cannot be read, is no HDF5 file or is truncated.

.seealso: SlipH5OpenRead(), SlipH5Close()
@*/
PetscErrorCode SlipH5OpenReadOption(const char prefix[], const char option[], const char file[], SlipH5 *h)
{
  FILE *probe;

  PetscFunctionBegin;
  SlipWorkAdd(SLIP_WORK_READ, 1);
  PetscCall(SlipH5Clear(prefix, option, h));
  PetscCall(PetscStrncpy(h->name, file, sizeof(h->name)));
  probe = fopen(file, "rb");
  PetscCheck(probe, PETSC_COMM_SELF, PETSC_ERR_FILE_OPEN, "cannot read %s: no such file, or no permission%s", file,
             h->source);
  fclose(probe);
  PetscCheck(H5Fis_hdf5(file) > 0, PETSC_COMM_SELF, PETSC_ERR_FILE_OPEN, "%s is not an HDF5 file%s", file, h->source);
  h->id = H5Fopen(file, H5F_ACC_RDONLY, H5P_DEFAULT);
  PetscCheck(h->id >= 0, PETSC_COMM_SELF, PETSC_ERR_FILE_OPEN, "%s is an HDF5 file, but truncated or damaged%s", file,
             h->source);
  if (option) {
    PetscInt i = 0;

    while (i < ninputs && strcmp(inputs[i].name, file)) i++;
    if (i == SLIP_H5_INPUTS) i--;
    if (i == ninputs) ninputs++;
    PetscCall(PetscStrncpy(inputs[i].name, file, sizeof(inputs[i].name)));
    PetscCall(PetscStrncpy(inputs[i].source, h->source, sizeof(inputs[i].source)));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Opens an HDF5 file for reading. Errors: those of SlipH5OpenReadOption(). */
PetscErrorCode SlipH5OpenRead(const char file[], SlipH5 *h)
{
  PetscFunctionBegin;
  PetscCall(SlipH5OpenReadOption(NULL, NULL, file, h));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Checks that the HDF5 file that an option names can be read. prefix: options prefix of the object that will read it,
   or NULL; option: name of the option without dash and prefix, for messages. Errors: those of SlipH5OpenReadOption().
   */
PetscErrorCode SlipH5CheckRead(MPI_Comm comm, const char prefix[], const char option[], const char file[])
{
  PetscErrorCode ierr = PETSC_SUCCESS;
  PetscMPIInt rank;
  SlipH5 h;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  if (!rank) {
    ierr = SlipH5OpenReadOption(prefix, option, file, &h);
    if (!ierr) (void)H5Fclose(h.id);
  }
  PetscCall(SlipErrorBcast(comm, ierr));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipH5CheckNoInput - checks that an output is not a file that an option names for reading

  Not collective.

  Input Parameters:
+ file   - the output
- source - option that names it, for the message

  Level: developer

  Errors: PETSC_ERR_FILE_OPEN when SlipH5OpenReadOption() has opened it in this process

.seealso: SlipH5CheckCreateKind()
@*/
PetscErrorCode SlipH5CheckNoInput(const char file[], const char source[])
{
  struct stat output, input;

  PetscFunctionBegin;
  if (stat(file, &output)) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt i = 0; i < ninputs; i++)
    PetscCheck(stat(inputs[i].name, &input) || input.st_dev != output.st_dev || input.st_ino != output.st_ino,
               PETSC_COMM_SELF, PETSC_ERR_FILE_OPEN, "cannot write %s%s: it is read by this run as well%s", file,
               source, inputs[i].source);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipH5Has - checks whether the file has a group or dataset of this path

  Not collective.

  Input Parameters:
+ h    - file
- path - absolute path

  Output Parameter:
. has - whether it exists

  Level: developer

.seealso: SlipH5HasAttribute()
@*/
PetscErrorCode SlipH5Has(SlipH5 *h, const char path[], PetscBool *has)
{
  char part[PETSC_MAX_PATH_LEN];
  size_t len;

  PetscFunctionBegin;
  *has = PETSC_FALSE;
  PetscCall(PetscStrncpy(part, path, sizeof(part)));
  PetscCall(PetscStrlen(part, &len));
  /* H5Lexists() requires that every parent exists, so test the parents first. */
  for (size_t i = 1; i <= len; i++) {
    const char keep = part[i];

    if (keep != '/' && keep != '\0') continue;
    part[i] = '\0';
    if (!(part[0] == '/' && i == 1 && part[1] == '\0') && H5Lexists(h->id, part, H5P_DEFAULT) <= 0)
      PetscFunctionReturn(PETSC_SUCCESS);
    part[i] = keep;
  }
  *has = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipH5HasAttribute - checks whether a group or dataset has an attribute of this name

  Not collective.

  Input Parameters:
+ h, path - file, and an existing group or dataset
- attr    - name of the attribute

  Output Parameter:
. has - whether it exists

  Level: developer

.seealso: SlipH5Has()
@*/
PetscErrorCode SlipH5HasAttribute(SlipH5 *h, const char path[], const char attr[], PetscBool *has)
{
  PetscFunctionBegin;
  PetscCall(SlipH5Has(h, path, has));
  if (*has) *has = H5Aexists_by_name(h->id, path, attr, H5P_DEFAULT) > 0 ? PETSC_TRUE : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SlipH5MakeGroup(SlipH5 *h, const char path[], PetscBool numbers)
{
  PetscBool has;
  hid_t lcpl, gcpl, id;

  PetscFunctionBegin;
  PetscCall(SlipH5Has(h, path, &has));
  if (has) PetscFunctionReturn(PETSC_SUCCESS);
  lcpl = H5Pcreate(H5P_LINK_CREATE);
  gcpl = H5Pcreate(H5P_GROUP_CREATE);
  H5Pset_create_intermediate_group(lcpl, 1);
  if (numbers) H5Pset_attr_phase_change(gcpl, 65535, 0);
  id = H5Gcreate2(h->id, path, lcpl, gcpl, H5P_DEFAULT);
  H5Pclose(gcpl);
  H5Pclose(lcpl);
  PetscCheck(id >= 0 && H5Gclose(id) >= 0, PETSC_COMM_SELF, PETSC_ERR_FILE_WRITE, "cannot create group %s in %s", path,
             h->name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates a group and its parents unless they exist. Errors: PETSC_ERR_FILE_WRITE when the group cannot be created. */
PetscErrorCode SlipH5Group(SlipH5 *h, const char path[])
{
  PetscFunctionBegin;
  PetscCall(SlipH5MakeGroup(h, path, PETSC_FALSE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates a group, as SlipH5Group(), to which attributes can be added after SlipH5Live(). All its attributes are in its
   header, whose changes SWMR writes in a safe order; from nine on they would move to a heap, whose changes it does not.
   */
PetscErrorCode SlipH5GroupOfNumbers(SlipH5 *h, const char path[])
{
  PetscFunctionBegin;
  PetscCall(SlipH5MakeGroup(h, path, PETSC_TRUE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Removes a group and its content, if it exists. Errors: PETSC_ERR_FILE_WRITE when it cannot be removed. */
PetscErrorCode SlipH5RemoveGroup(SlipH5 *h, const char path[])
{
  PetscBool has;

  PetscFunctionBegin;
  PetscCall(SlipH5Has(h, path, &has));
  PetscCheck(!has || H5Ldelete(h->id, path, H5P_DEFAULT) >= 0, PETSC_COMM_SELF, PETSC_ERR_FILE_WRITE,
             "cannot replace %s in %s", path, h->name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets the number of groups and datasets in a group. path: absolute path of the group. Errors:
   PETSC_ERR_FILE_UNEXPECTED when there is no such group. */
PetscErrorCode SlipH5CountMembers(SlipH5 *h, const char path[], PetscInt *n)
{
  H5G_info_t info = {0};

  PetscFunctionBegin;
  PetscCheck(H5Gget_info_by_name(h->id, path, &info, H5P_DEFAULT) >= 0, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
             "%s has no group %s%s", h->name, path, h->source);
  *n = (PetscInt)info.nlinks;
  PetscFunctionReturn(PETSC_SUCCESS);
}
