/* Opening and closing HDF5 files: writing goes to FILE.part, which takes FILE's place when it is complete. */
#define _DEFAULT_SOURCE /* flock() */
#include <sliph5.h>
#include <slipsys.h>
#include <slipcompat.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

/* No file open yet, with what its messages will say of it. */
static PetscErrorCode SlipH5Clear(const char prefix[], const char option[], SlipH5 *h)
{
  PetscFunctionBegin;
  PetscCall(PetscMemzero(h, sizeof(*h)));
  h->id = -1;
  if (option) PetscCall(PetscSNPrintf(h->source, sizeof(h->source), " (-%s%s)", prefix ? prefix : "", option));
  /* HDF5 prints its own stack of errors otherwise; ours name the file and the dataset. */
  PetscCheck(H5Eset_auto2(H5E_DEFAULT, NULL, NULL) >= 0, PETSC_COMM_SELF, PETSC_ERR_LIB, "HDF5 cannot be initialised");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipH5OpenReadOption - open an HDF5 file that an option names for reading

  Not collective: call on one rank and broadcast what was read.

  Input Parameters:
+ prefix - options prefix of the object that reads it, or NULL
. option - name of the option without dash and prefix, for messages; NULL: the caller's user has named no option
- file   - its name

  Output Parameter:
. h - the open file

  Level: developer

  Errors: PETSC_ERR_FILE_OPEN when it is missing, cannot be read, is no HDF5 file or is truncated.

.seealso: SlipH5OpenRead(), SlipH5Close()
@*/
PetscErrorCode SlipH5OpenReadOption(const char prefix[], const char option[], const char file[], SlipH5 *h)
{
  FILE *probe;

  PetscFunctionBegin;
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
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipH5OpenRead - open an HDF5 file for reading

  Not collective: call on one rank and broadcast what was read.

  Input Parameter:
. file - its name

  Output Parameter:
. h - the open file

  Level: developer

  Errors: those of SlipH5OpenReadOption().

.seealso: SlipH5OpenReadOption(), SlipH5Create(), SlipH5Close()
@*/
PetscErrorCode SlipH5OpenRead(const char file[], SlipH5 *h)
{
  PetscFunctionBegin;
  PetscCall(SlipH5OpenReadOption(NULL, NULL, file, h));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipH5CheckRead - can the HDF5 file that an option names be read?

  Collective; rank 0 looks.

  Input Parameters:
+ comm   - the processes
. prefix - options prefix of the object that will read it, or NULL
. option - name of the option without dash and prefix, for messages
- file   - name of the file

  Level: developer

  Errors: those of SlipH5OpenReadOption().

.seealso: SlipH5OpenReadOption(), SlipH5CheckCreateOption()
@*/
PetscErrorCode SlipH5CheckRead(MPI_Comm comm, const char prefix[], const char option[], const char file[])
{
  PetscErrorCode ierr = PETSC_SUCCESS;
  PetscMPIInt rank;
  SlipH5 h;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  if (!rank) {
    ierr = SlipH5OpenReadOption(prefix, option, file, &h);
    if (!ierr) PetscCall(SlipH5Close(&h));
  }
  PetscCall(SlipErrorBcast(comm, ierr));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Is another process writing the file? It then holds the lock that HDF5 takes on what it writes; HDF5 itself finds out
   only after it has emptied the file. */
static PetscBool SlipH5IsWritten(const char file[])
{
  const int fd = open(file, O_RDWR);
  PetscBool locked = PETSC_FALSE;

  if (fd < 0) return PETSC_FALSE;
  if (flock(fd, LOCK_EX | LOCK_NB) && errno == EWOULDBLOCK) locked = PETSC_TRUE; /* not where locks are unknown */
  close(fd);
  return locked;
}

/* SlipH5Create() for the file of an option */
static PetscErrorCode SlipH5CreateOption(const char prefix[], const char option[], const char file[], SlipH5 *h)
{
  struct stat info;

  PetscFunctionBegin;
  PetscCall(SlipH5Clear(prefix, option, h));
  PetscCheck(file[0], PETSC_COMM_SELF, PETSC_ERR_FILE_OPEN, "the name of the HDF5 file to write is empty%s", h->source);
  PetscCheck(stat(file, &info) || !S_ISDIR(info.st_mode), PETSC_COMM_SELF, PETSC_ERR_FILE_OPEN,
             "cannot write %s: it is a directory, expected the name of a file%s", file, h->source);
  PetscCall(PetscStrncpy(h->target, file, sizeof(h->target)));
  PetscCall(PetscSNPrintf(h->name, sizeof(h->name), "%s.part", file));
  PetscCheck(!SlipH5IsWritten(h->name), PETSC_COMM_SELF, PETSC_ERR_FILE_OPEN,
             "cannot write %s: another program is writing %s%s", file, h->name, h->source);
  h->id = H5Fcreate(h->name, H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  PetscCheck(h->id >= 0, PETSC_COMM_SELF, PETSC_ERR_FILE_OPEN,
             "cannot create %s: the directory must exist and be writable%s", h->name, h->source);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipH5Create - start writing an HDF5 file

  Not collective: call on one rank.

  Input Parameter:
. file - final name, taken at SlipH5Close(); until then the content is in file.part

  Output Parameter:
. h - the open file

  Level: developer

  Errors: PETSC_ERR_FILE_OPEN when file is a directory, file.part cannot be created, or another program is writing it.

.seealso: SlipH5OpenRead(), SlipH5Close()
@*/
PetscErrorCode SlipH5Create(const char file[], SlipH5 *h)
{
  PetscFunctionBegin;
  PetscCall(SlipH5CreateOption(NULL, NULL, file, h));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipH5CheckCreateOption - would SlipH5Create() work? For files that are written at the end of a long run

  Not collective.

  Input Parameters:
+ prefix - options prefix of the object that writes it, or NULL
. option - name of the option without dash and prefix, for messages, or NULL
- file   - final name; an empty one is no file and no error

  Level: developer

  Errors: those of SlipH5Create().

.seealso: SlipH5CheckCreate(), SlipH5Create()
@*/
PetscErrorCode SlipH5CheckCreateOption(const char prefix[], const char option[], const char file[])
{
  SlipH5 h;

  PetscFunctionBegin;
  if (!file[0]) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipH5CreateOption(prefix, option, file, &h));
  H5Fclose(h.id);
  PetscCheck(!remove(h.name), PETSC_COMM_SELF, PETSC_ERR_FILE_WRITE, "cannot remove %s%s", h.name, h.source);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipH5CheckCreate - SlipH5CheckCreateOption() without an option

  Not collective.

  Input Parameter:
. file - final name; an empty one is no file and no error

  Level: developer

  Errors: those of SlipH5Create().

.seealso: SlipH5CheckCreateOption(), SlipH5Create()
@*/
PetscErrorCode SlipH5CheckCreate(const char file[])
{
  PetscFunctionBegin;
  PetscCall(SlipH5CheckCreateOption(NULL, NULL, file));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipH5Close - close a file; one that was written is renamed into place

  Not collective. Closing twice does nothing.

  Input/Output Parameter:
. h - file

  Level: developer

  Errors: PETSC_ERR_FILE_WRITE when the disk is full or the file cannot be renamed

.seealso: SlipH5Create()
@*/
PetscErrorCode SlipH5Close(SlipH5 *h)
{
  hid_t id = h->id;

  PetscFunctionBegin;
  if (id <= 0) PetscFunctionReturn(PETSC_SUCCESS);
  h->id = -1;
  PetscCheck(H5Fclose(id) >= 0, PETSC_COMM_SELF, PETSC_ERR_FILE_WRITE, "cannot close %s: is the disk full?", h->name);
  if (h->target[0])
    PetscCheck(!rename(h->name, h->target), PETSC_COMM_SELF, PETSC_ERR_FILE_WRITE, "cannot rename %s to %s", h->name,
               h->target);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipH5Flush - bring what was written so far to disk

  Not collective.

  Input Parameter:
. h - file

  Level: developer

  Errors: PETSC_ERR_FILE_WRITE when the file cannot be written

.seealso: SlipH5Close()
@*/
PetscErrorCode SlipH5Flush(SlipH5 *h)
{
  PetscFunctionBegin;
  PetscCheck(H5Fflush(h->id, H5F_SCOPE_LOCAL) >= 0, PETSC_COMM_SELF, PETSC_ERR_FILE_WRITE, "cannot write %s", h->name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipH5Has - does the file hold a group or dataset of this path?

  Not collective.

  Input Parameters:
+ h    - file
- path - absolute path

  Output Parameter:
. has - whether it is there

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
  /* H5Lexists() wants every parent to exist, so test the parents first. */
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
  SlipH5HasAttribute - does a group or dataset carry an attribute of this name?

  Not collective.

  Input Parameters:
+ h, path - file, and a group or dataset that is there
- attr    - name of the attribute

  Output Parameter:
. has - whether it is there

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

/*@C
  SlipH5Group - create a group and its parents; those that exist are left as they are

  Not collective.

  Input Parameters:
+ h    - file
- path - absolute path

  Level: developer

  Errors: PETSC_ERR_FILE_WRITE when the group cannot be created

.seealso: SlipH5Has()
@*/
PetscErrorCode SlipH5Group(SlipH5 *h, const char path[])
{
  PetscBool has;
  hid_t lcpl, id;

  PetscFunctionBegin;
  PetscCall(SlipH5Has(h, path, &has));
  if (has) PetscFunctionReturn(PETSC_SUCCESS);
  lcpl = H5Pcreate(H5P_LINK_CREATE);
  H5Pset_create_intermediate_group(lcpl, 1);
  id = H5Gcreate2(h->id, path, lcpl, H5P_DEFAULT, H5P_DEFAULT);
  H5Pclose(lcpl);
  PetscCheck(id >= 0, PETSC_COMM_SELF, PETSC_ERR_FILE_WRITE, "cannot create group %s in %s", path, h->name);
  H5Gclose(id);
  PetscFunctionReturn(PETSC_SUCCESS);
}
