/* Which file an output may be: resolves links, locks out other programs, and protects files that must not be lost. */
#define _GNU_SOURCE /* F_OFD_SETLK */
#include <slipstep/private/slipsys.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* Resolves symbolic links of a name, also to a file that does not exist yet. */
PetscErrorCode SlipH5Follow(const char file[], const char source[], char target[PETSC_MAX_PATH_LEN])
{
  char link[PETSC_MAX_PATH_LEN], folder[PETSC_MAX_PATH_LEN], *slash;
  ssize_t n;

  PetscFunctionBegin;
  PetscCall(PetscStrncpy(target, file, PETSC_MAX_PATH_LEN));
  for (int depth = 0; (n = readlink(target, link, sizeof(link) - 1)) >= 0; depth++) {
    PetscCheck(depth < 40, PETSC_COMM_SELF, PETSC_ERR_FILE_OPEN, "cannot write %s: %s%s", file, strerror(ELOOP),
               source);
    link[n] = '\0';
    PetscCall(PetscStrncpy(folder, target, sizeof(folder)));
    slash = link[0] == '/' ? NULL : strrchr(folder, '/');
    if (slash) slash[1] = '\0';
    PetscCall(PetscSNPrintf(target, PETSC_MAX_PATH_LEN, "%s%s", slash ? folder : "", link));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Locks of open file descriptions, if the system has any, hold until one is closed, whatever else the process opens. */
static int SlipH5Lock(int fd)
{
  struct flock all = {.l_type = F_WRLCK, .l_whence = SEEK_SET};

#if defined(F_OFD_SETLK)
  if (!fcntl(fd, F_OFD_SETLK, &all)) return 0;
  if (errno != EINVAL) return errno == EACCES ? EAGAIN : errno;
#endif
  return !fcntl(fd, F_SETLK, &all) ? 0 : errno == EACCES ? EAGAIN : errno;
}

PetscErrorCode SlipH5Refuse(const SlipH5 *h, const char file[], int reason)
{
  PetscFunctionBegin;
  PetscCheck(reason != EAGAIN, PETSC_COMM_SELF, PETSC_ERR_FILE_OPEN,
             "cannot write %s: another program is writing %s.part%s", h->target, h->target, h->source);
  SETERRQ(PETSC_COMM_SELF, PETSC_ERR_FILE_OPEN, "cannot create %s: %s%s", file, strerror(reason), h->source);
}

/* Opens a regular file beside the target for writing, not a link, and locks it; -1 if it does not exist. */
static PetscErrorCode SlipH5OpenBeside(const SlipH5 *h, const char file[], int flags, int *fd)
{
  struct stat info, now;
  int reason;

  PetscFunctionBegin;
  *fd = -1;
  if (!lstat(file, &info))
    PetscCheck(S_ISREG(info.st_mode), PETSC_COMM_SELF, PETSC_ERR_FILE_OPEN,
               "cannot write %s: %s is a link or something else than a file, remove it%s", h->target, file, h->source);
  for (int attempt = 0;; attempt++) {
    *fd = open(file, O_RDWR | O_NOFOLLOW | O_CLOEXEC | flags, 0666);
    reason = errno;
    if (*fd < 0 && !(flags & O_CREAT) && reason == ENOENT) PetscFunctionReturn(PETSC_SUCCESS);
    if (*fd < 0) PetscCall(SlipH5Refuse(h, file, reason));
    reason = SlipH5Lock(*fd);
    /* between the two calls another program may have renamed it */
    if (!reason && !lstat(file, &now) && !fstat(*fd, &info) && now.st_dev == info.st_dev && now.st_ino == info.st_ino)
      PetscFunctionReturn(PETSC_SUCCESS);
    close(*fd);
    *fd = -1;
    if (reason && reason != ENOLCK && reason != ENOSYS && reason != EOPNOTSUPP)
      PetscCall(SlipH5Refuse(h, file, reason));
    PetscCheck(attempt < 10, PETSC_COMM_SELF, PETSC_ERR_FILE_OPEN, "cannot lock %s: %s%s", file,
               strerror(reason ? reason : EAGAIN), h->source);
  }
}

/* For H5Lvisit(): finds the number of rows of the longest series */
static herr_t SlipH5VisitSeries(hid_t location, const char *name, const H5L_info_t *info, void *ctx)
{
  const hid_t id = H5Oopen(location, name, H5P_DEFAULT);
  hsize_t *rows = (hsize_t *)ctx;
  hsize_t shape[H5S_MAX_RANK], limit[H5S_MAX_RANK];

  (void)info;
  if (H5Iget_type(id) == H5I_DATASET) {
    const hid_t space = H5Dget_space(id);

    if (H5Sget_simple_extent_dims(space, shape, limit) > 0 && limit[0] == H5S_UNLIMITED)
      *rows = PetscMax(*rows, shape[0]);
    H5Sclose(space);
  }
  H5Oclose(id);
  return 0;
}

hsize_t SlipH5MostRows(hid_t id, int first)
{
  hsize_t rows = 0;

  if (H5Lvisit(id, H5_INDEX_NAME, H5_ITER_NATIVE, SlipH5VisitSeries, &rows) < 0) return 1;
  return rows > (hsize_t)first ? rows - (hsize_t)first : 0;
}

/* An unfinished file with rows is not overwritten unless the options say so; nor is one that cannot be read. */
static PetscErrorCode SlipH5KeepRows(const SlipH5 *h, const SlipH5Kind *kind)
{
  const char *prefix = kind->prefix ? kind->prefix : "";
  char part[PETSC_MAX_PATH_LEN], advice[256] = "";
  hsize_t rows = 0;
  struct stat info;
  hid_t id;
  int fd;

  PetscFunctionBegin;
  PetscCall(PetscSNPrintf(part, sizeof(part), "%s.part", h->target));
  PetscCall(SlipH5OpenBeside(h, part, 0, &fd));
  if (fd < 0) PetscFunctionReturn(PETSC_SUCCESS);
  if (fstat(fd, &info)) info.st_size = 1;
  close(fd);
  if (kind->overwrite || !info.st_size) PetscFunctionReturn(PETSC_SUCCESS);
  id = H5Fopen(part, H5F_ACC_RDONLY, H5P_DEFAULT);
  if (id >= 0) {
    rows = SlipH5MostRows(id, kind->first);
    H5Fclose(id);
    if (!rows) PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (kind->restart)
    PetscCall(PetscSNPrintf(advice, sizeof(advice), "continue it with -%s%s CHECKPOINT, ", prefix, kind->restart));
  PetscCall(PetscStrlcat(advice, "rename it", sizeof(advice)));
  if (kind->option) {
    char name[128];

    PetscCall(PetscSNPrintf(name, sizeof(name), ", or throw it away with -%s%s%s", prefix,
                            kind->discard ? kind->discard : kind->option, kind->discard ? "" : "_overwrite"));
    PetscCall(PetscStrlcat(advice, name, sizeof(advice)));
  }
  PetscCheck(id >= 0, PETSC_COMM_SELF, PETSC_ERR_FILE_OPEN, "%s is there, and cannot be read: %s%s", part, advice,
             h->source);
  SETERRQ(PETSC_COMM_SELF, PETSC_ERR_FILE_OPEN, "%s holds %llu rows of an unfinished run: %s%s", part,
          (unsigned long long)rows, advice, h->source);
}

/* Sets the names of an output file, which may replace an HDF5 file that is no input, and opens its temporary file. */
PetscErrorCode SlipH5Claim(const SlipH5Kind *kind, const char file[], SlipH5 *h)
{
  struct stat info;

  PetscFunctionBegin;
  PetscCall(SlipH5Clear(kind->prefix, kind->option, h));
  h->first = kind->first;
  PetscCheck(file[0], PETSC_COMM_SELF, PETSC_ERR_FILE_OPEN, "the name of the HDF5 file to write is empty%s", h->source);
  PetscCall(SlipH5Follow(file, h->source, h->target));
  if (!stat(h->target, &info)) {
    PetscCheck(!S_ISDIR(info.st_mode), PETSC_COMM_SELF, PETSC_ERR_FILE_OPEN,
               "cannot write %s: it is a directory, expected the name of a file%s", file, h->source);
    PetscCheck(S_ISREG(info.st_mode), PETSC_COMM_SELF, PETSC_ERR_FILE_OPEN,
               "cannot write %s: it is a device, pipe or socket, expected the name of a file%s", file, h->source);
    PetscCheck(!info.st_size || H5Fis_hdf5(h->target) > 0, PETSC_COMM_SELF, PETSC_ERR_FILE_OPEN,
               "cannot write %s: it is there and is not an HDF5 file; expected another name%s", file, h->source);
  }
  if (kind->growing) PetscCall(SlipH5KeepRows(h, kind));
  PetscCall(PetscSNPrintf(h->name, sizeof(h->name), "%s.part.new", h->target));
  PetscCall(SlipH5OpenBeside(h, h->name, O_CREAT, &h->fd));
  PetscFunctionReturn(PETSC_SUCCESS);
}
