/* Writes HDF5 files so that no data are lost.

   A file is written as FILE.part.new, with its own lock, and is renamed to FILE when it is complete and on the disk.
   One that grows during a run becomes FILE.part as soon as its layout is complete: from then on every reader may open
   it, also after a kill, and it has whole rows (h5file.c). After a failed write nothing more is written, and the file
   has the rows before it. */
#define _GNU_SOURCE /* F_OFD_SETLK */
#include <slipstep/private/sliph5.h>
#include <slipstep/private/slipsys.h>
#include <slipstep/private/slipwork.h>
#include <slipstep/rooms/slipsys.h>
#include <errno.h>
#include <fcntl.h>
#include <petsctime.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* Wall time between two flushes [s], such that flushes take a hundredth of the time, within these bounds */
#define SLIP_H5_FLUSH_MIN 0.1
#define SLIP_H5_FLUSH_MAX 10.0

/* ---- which file an output may be ---- */

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

static PetscErrorCode SlipH5Refuse(const SlipH5 *h, const char file[], int reason)
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

static hsize_t SlipH5MostRows(hid_t id, int first)
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
static PetscErrorCode SlipH5Claim(const SlipH5Kind *kind, const char file[], SlipH5 *h)
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

/* ---- creating ---- */

/* Access properties: only our own lock; for a growing file the format that SWMR needs, which HDF5 1.10 reads, and no
   metadata on disk before a flush */
static hid_t SlipH5Access(PetscBool growing)
{
  const hid_t access = H5Pcreate(H5P_FILE_ACCESS);
  H5AC_cache_config_t cache = {.version = H5AC__CURR_CACHE_CONFIG_VERSION};

  SlipH5SetDriver(access);
  H5Pset_fclose_degree(access, H5F_CLOSE_STRONG);
#if H5_VERSION_GE(1, 12, 1) || (H5_VERSION_GE(1, 10, 7) && !H5_VERSION_GE(1, 12, 0))
  H5Pset_file_locking(access, 0, 1);
#endif
  if (!growing) return access;
#if H5_VERSION_GE(1, 10, 2)
  H5Pset_libver_bounds(access, H5F_LIBVER_V110, H5F_LIBVER_V110);
#else
  H5Pset_libver_bounds(access, H5F_LIBVER_LATEST, H5F_LIBVER_LATEST);
#endif
  /* The only writer may still read what it wrote: after a failed write the 100 attempts of SWMR, each of which waits
     twice as long as the one before, would not end. HDF5 replaces 1 by its default. */
  H5Pset_metadata_read_attempts(access, 2);
  H5Pget_mdc_config(access, &cache);
  cache.evictions_enabled = 0;
  cache.incr_mode = H5C_incr__off;
  cache.flash_incr_mode = H5C_flash_incr__off;
  cache.decr_mode = H5C_decr__off;
  H5Pset_mdc_config(access, &cache);
  return access;
}

/* Starts writing an HDF5 file. kind: the option that names it, and whether it grows; file: final name, which
   SlipH5Close() gives it; links are followed. The content is in file.part.new, and in file.part from SlipH5Live() on.
   Errors: PETSC_ERR_FILE_OPEN if file is a directory or special file, an input of this program or of another format, if
   file.part.new cannot be created, if another program is writing it, and if it grows and there is a file.part with
   rows. */
PetscErrorCode SlipH5CreateKind(const SlipH5Kind *kind, const char file[], SlipH5 *h)
{
  hid_t access, creation;
  int reason;

  PetscFunctionBegin;
  SlipWorkAdd(SLIP_WORK_FILE, 1);
  PetscCall(SlipH5Claim(kind, file, h));
  PetscCall(SlipH5Enlist(h));
  access = SlipH5Access(kind->growing);
  creation = H5Pcreate(H5P_FILE_CREATE);
  if (kind->block) H5Pset_userblock(creation, (hsize_t)kind->block);
  errno = 0;
  h->id = H5Fcreate(h->name, H5F_ACC_TRUNC, creation, access);
  reason = errno;
  H5Pclose(creation);
  H5Pclose(access);
  if (h->id < 0) {
    SlipH5Release(h, PETSC_FALSE);
    PetscCall(SlipH5Refuse(h, h->name, reason ? reason : EIO));
  }
  SlipErrorAtEnd(SlipH5AbandonAll);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns 0 or errno. */
static int SlipH5CopyBytes(const char from[], int to)
{
  static char buffer[1 << 16];
  const int fd = open(from, O_RDONLY | O_CLOEXEC);
  int reason = fd < 0 || ftruncate(to, 0) || lseek(to, 0, SEEK_SET) < 0 ? errno : 0;
  ssize_t n, m;

  while (!reason && (n = read(fd, buffer, sizeof(buffer))) != 0) {
    if (n < 0) reason = errno;
    for (ssize_t done = 0; !reason && done < n; done += m) {
      m = write(to, buffer + done, (size_t)(n - done));
      if (m < 0) reason = errno;
    }
  }
  if (fd >= 0) close(fd);
  return reason;
}

/* For H5Lvisit(): reads the header of an object and, of a dataset, the index of its chunks, whose sizes its storage
   sums up; 1: it cannot be read, and its name is stored. If a file is open for SWMR, HDF5 assumes that a block of
   metadata with a wrong checksum is being written by another process, and reads it 100 times, doubling the wait each
   time: for ever. A damaged file must therefore be detected before it is opened in this mode. */
static herr_t SlipH5ReadObject(hid_t location, const char *name, const H5L_info_t *info, void *ctx)
{
  const hid_t id = H5Oopen(location, name, H5P_DEFAULT);
  PetscBool good = id >= 0 ? PETSC_TRUE : PETSC_FALSE;

  (void)info;
  if (good && H5Iget_type(id) == H5I_DATASET) {
    (void)H5Dget_storage_size(id); /* also 0 on failure */
    if (H5Eget_num(H5E_DEFAULT) != 0) good = PETSC_FALSE;
  }
  if (id >= 0 && H5Oclose(id) < 0) good = PETSC_FALSE;
  if (good) return 0;
  (void)PetscStrncpy((char *)ctx, name, PETSC_MAX_PATH_LEN);
  return 1;
}

/* Starts writing an HDF5 file that begins as the copy of another. kind: the option that names it, and whether it grows;
   from: the file to copy, NULL for file.part or, if there is none, file; file: final name, which SlipH5Close() gives
   it. Errors: those of SlipH5CreateKind(), except that rows of a file.part are no error, and PETSC_ERR_FILE_WRITE if it
   cannot be copied. */
PetscErrorCode SlipH5CreateCopy(const SlipH5Kind *kind, const char from[], const char file[], SlipH5 *h)
{
  char part[PETSC_MAX_PATH_LEN], object[PETSC_MAX_PATH_LEN] = "";
  SlipH5Kind claim = *kind;
  PetscBool whole;
  hid_t properties;
  int reason;

  PetscFunctionBegin;
  claim.overwrite = PETSC_TRUE;
  PetscCall(SlipH5Claim(&claim, file, h));
  PetscCall(SlipH5Enlist(h));
  PetscCall(PetscSNPrintf(part, sizeof(part), "%s.part", h->target));
  if (!from) from = access(part, F_OK) ? h->target : part;
  reason = SlipH5CopyBytes(from, h->fd);
  if (reason) {
    SlipH5Release(h, PETSC_FALSE);
    SETERRQ(PETSC_COMM_SELF, PETSC_ERR_FILE_WRITE, "cannot copy %s to %s: %s%s", from, h->name, strerror(reason),
            h->source);
  }
  properties = SlipH5Access(kind->growing);
  h->id = H5Fopen(h->name, H5F_ACC_RDWR, properties);
  H5Pclose(properties);
  whole = h->id >= 0 && H5Lvisit(h->id, H5_INDEX_NAME, H5_ITER_NATIVE, SlipH5ReadObject, object) == 0 ? PETSC_TRUE
                                                                                                      : PETSC_FALSE;
  if (!whole) {
    h->failed = ECANCELED;
    (void)SlipH5CloseId(h);
    SlipH5Release(h, PETSC_FALSE);
    SETERRQ(PETSC_COMM_SELF, PETSC_ERR_FILE_OPEN, "%s is damaged%s%s%s: expected a whole file, or none%s", from,
            object[0] ? ": /" : "", object, object[0] ? " cannot be read" : "", h->source);
  }
  SlipErrorAtEnd(SlipH5AbandonAll);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipH5Create - starts writing an HDF5 file that no option names and that does not grow, see SlipH5CreateKind()

  Not collective: call on one rank.

  Input Parameter:
. file - final name, which SlipH5Close() gives it

  Output Parameter:
. h - the open file

  Level: developer

  Errors: those of SlipH5CreateKind()

.seealso: SlipH5OpenRead(), SlipH5Close()
@*/
PetscErrorCode SlipH5Create(const char file[], SlipH5 *h)
{
  const SlipH5Kind kind = {0};

  PetscFunctionBegin;
  PetscCall(SlipH5CreateKind(&kind, file, h));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Checks that SlipH5CreateKind() will succeed, before a long computation. kind: the option that names it, and whether
   it grows; file: final name; an empty one is no file and no error. Errors: those of SlipH5CreateKind(), and
   PETSC_ERR_FILE_OPEN if an option of this program has file as its input. */
PetscErrorCode SlipH5CheckCreateKind(const SlipH5Kind *kind, const char file[])
{
  SlipH5 h;

  PetscFunctionBegin;
  if (!file[0]) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipH5Claim(kind, file, &h));
  SlipH5Release(&h, PETSC_FALSE);
  PetscCall(SlipH5CheckNoInput(h.target, h.source));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- writing ---- */

/* Makes a growing file readable from now on, as file.part. h: a growing file, with all its groups, series and
   attributes. Its attribute "complete" is 0 until SlipH5Close(). From now on only rows can be added, and attributes of
   groups of numbers. Errors: PETSC_ERR_FILE_WRITE when the file cannot be written. */
PetscErrorCode SlipH5Live(SlipH5 *h)
{
  char part[PETSC_MAX_PATH_LEN];

  PetscFunctionBegin;
  PetscCall(SlipH5WriteAttrInt(h, "/", "complete", 0));
  PetscCall(SlipH5Flush(h));
  if (H5Fstart_swmr_write(h->id) < 0) PetscCall(SlipH5WriteFailed(h, 0, "%s", h->name));
  h->live = PETSC_TRUE;
  PetscCall(SlipH5Flush(h));
  PetscCall(PetscSNPrintf(part, sizeof(part), "%s.part", h->target));
  if (rename(h->name, part)) PetscCall(SlipH5WriteFailed(h, errno, "%s", h->name));
  PetscCall(PetscStrncpy(h->name, part, sizeof(h->name)));
  PetscCall(PetscTime(&h->flushed));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes all data so far to the file. Errors: PETSC_ERR_FILE_WRITE when the file cannot be written. */
PetscErrorCode SlipH5Flush(SlipH5 *h)
{
  PetscLogDouble begin;
  int reason;

  PetscFunctionBegin;
  PetscCall(PetscTime(&begin));
  reason = SlipH5MakeRoom(h, 0);
  if (reason) PetscCall(SlipH5WriteFailed(h, reason, "%s", h->name));
  if (H5Fflush(h->id, H5F_SCOPE_LOCAL) < 0 || h->failed) PetscCall(SlipH5WriteFailed(h, 0, "%s", h->name));
  h->ahead = 0;
  PetscCall(PetscTime(&h->flushed));
  h->cost = h->flushed - begin;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Checks whether it is time to flush; flushes should take a hundredth of the wall time. due: after a hundred times the
   last flush, not before 0.1 s and at the latest after 10 s. */
PetscErrorCode SlipH5FlushIsDue(SlipH5 *h, PetscBool *due)
{
  PetscLogDouble now;

  PetscFunctionBegin;
  PetscCall(PetscTime(&now));
  *due = now - h->flushed > PetscClipInterval(100 * h->cost, SLIP_H5_FLUSH_MIN, SLIP_H5_FLUSH_MAX) ? PETSC_TRUE
                                                                                                   : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Flushes, see SlipH5Flush(), and waits for the disk. Errors: PETSC_ERR_FILE_WRITE when the file cannot be written. */
PetscErrorCode SlipH5Sync(SlipH5 *h)
{
  PetscFunctionBegin;
  PetscCall(SlipH5Flush(h));
  if (fsync(h->fd) && errno != EINVAL) PetscCall(SlipH5WriteFailed(h, errno, "%s", h->name));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Closes an incomplete file: a file that does not grow is removed, a growing one remains as file.part. Errors:
   PETSC_ERR_FILE_WRITE when the last rows of a growing file cannot be written. */
PetscErrorCode SlipH5Abandon(SlipH5 *h)
{
  PetscFunctionBegin;
  if (h->id <= 0) PetscFunctionReturn(PETSC_SUCCESS);
  if (h->live)
    PetscCall(SlipH5Flush(h));
  else
    h->failed = ECANCELED;
  (void)SlipH5CloseId(h);
  SlipH5Release(h, h->live);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Calls SlipH5Abandon() for every file that this process writes, when an error ends the program. A growing file without
   rows is removed as well. No error is raised. */
void SlipH5AbandonAll(void)
{
  static PetscBool busy = PETSC_FALSE;
  SlipH5 *h;

  if (busy) return; /* an error in the code below calls this again */
  busy = PETSC_TRUE;
  for (int i = 0; (h = SlipH5Written(i)); i += SlipH5Written(i) == h) {
    if (h->live && h->last) (void)(*h->last)(h->ctx);
    if (h->id > 0 && h->live && !SlipH5MostRows(h->id, h->first)) {
      h->failed = ECANCELED;
      (void)SlipH5CloseId(h);
      SlipH5Release(h, PETSC_FALSE);
    } else
      (void)SlipH5Abandon(h);
  }
  busy = PETSC_FALSE;
}

/* Closes a file in HDF5; it is complete, but still has its temporary name and its lock. */
PetscErrorCode SlipH5CloseBeside(SlipH5 *h)
{
  PetscFunctionBegin;
  PetscCall(SlipH5Flush(h)); /* writes all data before "complete" */
  if (h->live) PetscCall(SlipH5WriteAttrInt(h, "/", "complete", 1));
  PetscCall(SlipH5Flush(h)); /* writes only the superblock */
  if (SlipH5CloseId(h)) PetscCall(SlipH5WriteFailed(h, 0, "%s", h->target));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Syncs the folder of a file, and with it the file's name; file systems that cannot sync a folder return EINVAL.
   Returns 0 or errno. */
static int SlipH5SyncFolder(const char file[])
{
  char folder[PETSC_MAX_PATH_LEN] = ".";
  const char *slash = strrchr(file, '/');
  int fd, reason;

  if (slash) (void)snprintf(folder, sizeof(folder), "%.*s", (int)(slash + 1 - file), file);
  fd = open(folder, O_RDONLY | O_CLOEXEC);
  reason = fd < 0 || (fsync(fd) && errno != EINVAL) ? errno : 0;
  if (fd >= 0) close(fd);
  return reason;
}

/* Renames a file closed by SlipH5CloseBeside() to its final name once it is on the disk. */
PetscErrorCode SlipH5PutInPlace(SlipH5 *h)
{
  int reason = 0;

  PetscFunctionBegin;
  if (fsync(h->fd) && errno != EINVAL) reason = errno;
  if (!reason && rename(h->name, h->target)) reason = errno;
  if (!reason) {
    reason = SlipH5SyncFolder(h->target);
    SlipH5Release(h, PETSC_TRUE);
  }
  if (reason) PetscCall(SlipH5WriteFailed(h, reason, "%s", h->target));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipH5Close - closes a file; one that was written is complete, and gets its final name once it is on the disk

  Not collective. Closing twice does nothing.

  Input/Output Parameter:
. h - file

  Level: developer

  Errors: PETSC_ERR_FILE_WRITE when the file cannot be written or renamed

.seealso: SlipH5Create(), SlipH5Abandon()
@*/
PetscErrorCode SlipH5Close(SlipH5 *h)
{
  PetscFunctionBegin;
  if (h->id <= 0) PetscFunctionReturn(PETSC_SUCCESS);
  if (!h->target[0]) {
    (void)H5Fclose(h->id);
    h->id = -1;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(SlipH5CloseBeside(h));
  PetscCall(SlipH5PutInPlace(h));
  PetscFunctionReturn(PETSC_SUCCESS);
}
