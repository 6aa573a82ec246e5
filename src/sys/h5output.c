/* Writing HDF5 files so that nothing is lost.

   A file is made as FILE.part.new, under a lock of its own, and takes FILE's place when it is complete and on the disk.
   One that grows for the length of a run becomes FILE.part as soon as its layout is there: from then on every reader
   may open it, after a kill too, and it holds whole rows (h5space.c). A write that fails ends it: the file keeps the
   rows that are there. */
#define _GNU_SOURCE /* F_OFD_SETLK */
#include <slipstep/private/slipsys.h>
#include <slipsys.h>
#include <errno.h>
#include <fcntl.h>
#include <petsctime.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* Wall time between two flushes [s]: such that they take a hundredth of it, within these bounds */
#define SLIP_H5_FLUSH_MIN 0.1
#define SLIP_H5_FLUSH_MAX 10.0

/* ---- names and locks ---- */

/* The file that a name stands for: symbolic links are followed, also to a file that is not there yet. */
static PetscErrorCode SlipH5Follow(const char file[], const char source[], char target[PETSC_MAX_PATH_LEN])
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

/* Locks of an open file description, where there are any, hold until it is closed and do not depend on what else the
   process opens. */
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

/* Opens a file beside the target for writing: no link, nothing special, and locked; -1 when it is not there. */
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

/* H5Lvisit(): the rows of the longest series. /fields has the start of a run as well, which is no result. */
static herr_t SlipH5Longest(hid_t location, const char *name, const H5L_info_t *info, void *ctx)
{
  const hid_t id = H5Oopen(location, name, H5P_DEFAULT);
  hsize_t shape[H5S_MAX_RANK], limit[H5S_MAX_RANK], *rows = (hsize_t *)ctx;

  (void)info;
  if (H5Iget_type(id) == H5I_DATASET && strncmp(name, "fields/", 7)) {
    const hid_t space = H5Dget_space(id);

    if (H5Sget_simple_extent_dims(space, shape, limit) > 0 && limit[0] == H5S_UNLIMITED)
      *rows = PetscMax(*rows, shape[0]);
    H5Sclose(space);
  }
  H5Oclose(id);
  return 0;
}

static hsize_t SlipH5MostRows(hid_t id)
{
  hsize_t rows = 0;

  return H5Lvisit(id, H5_INDEX_NAME, H5_ITER_NATIVE, SlipH5Longest, &rows) < 0 ? 1 : rows;
}

/* An unfinished file with rows stays, unless told otherwise; so does one that cannot be read. */
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
  if (id < 0) id = H5Fopen(part, H5F_ACC_RDONLY | H5F_ACC_SWMR_READ, H5P_DEFAULT);
  if (id >= 0) {
    rows = SlipH5MostRows(id);
    H5Fclose(id);
    if (!rows) PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (kind->restart)
    PetscCall(PetscSNPrintf(advice, sizeof(advice), "continue it with -%s%s CHECKPOINT, ", prefix, kind->restart));
  PetscCall(PetscStrlcat(advice, "rename it", sizeof(advice)));
  if (kind->option) {
    char name[128];

    PetscCall(PetscSNPrintf(name, sizeof(name), ", or throw it away with -%s%s_overwrite", prefix, kind->option));
    PetscCall(PetscStrlcat(advice, name, sizeof(advice)));
  }
  PetscCheck(id >= 0, PETSC_COMM_SELF, PETSC_ERR_FILE_OPEN, "%s is there, and cannot be read: %s%s", part, advice,
             h->source);
  SETERRQ(PETSC_COMM_SELF, PETSC_ERR_FILE_OPEN, "%s holds %llu rows of an unfinished run: %s%s", part,
          (unsigned long long)rows, advice, h->source);
}

/* The names of an output file, which may replace a file of HDF5 that is no input; its temporary file is opened. */
static PetscErrorCode SlipH5Claim(const SlipH5Kind *kind, const char file[], SlipH5 *h)
{
  struct stat info;

  PetscFunctionBegin;
  PetscCall(SlipH5Clear(kind->prefix, kind->option, h));
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

static PetscBool SlipH5End(void);

/* Access properties: nobody's lock but ours; for a file that grows the format that SWMR needs, which HDF5 1.10 reads, and
   no metadata on disk before a flush. */
static hid_t SlipH5Access(PetscBool growing)
{
  const hid_t access = H5Pcreate(H5P_FILE_ACCESS);
  H5AC_cache_config_t cache = {.version = H5AC__CURR_CACHE_CONFIG_VERSION};

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
  H5Pget_mdc_config(access, &cache);
  cache.evictions_enabled = 0;
  cache.incr_mode = H5C_incr__off;
  cache.flash_incr_mode = H5C_flash_incr__off;
  cache.decr_mode = H5C_decr__off;
  H5Pset_mdc_config(access, &cache);
  return access;
}

/*@C
  SlipH5CreateKind - start writing an HDF5 file

  Not collective: call on one rank.

  Input Parameters:
+ kind - by which option it is named, and whether it grows
- file - final name, taken at SlipH5Close(); links are followed

  Output Parameter:
. h - the open file

  Level: developer

  Notes:
  The content is in file.part.new, and in file.part from SlipH5Live() on.

  Errors: PETSC_ERR_FILE_OPEN when file is a directory or something special, an input of this program or of another
  format, when file.part.new cannot be created, when another program is writing it, and when it grows and there is a
  file.part with rows.

.seealso: SlipH5Create(), SlipH5Live(), SlipH5Close()
@*/
PetscErrorCode SlipH5CreateKind(const SlipH5Kind *kind, const char file[], SlipH5 *h)
{
  hid_t access;
  int reason;

  PetscFunctionBegin;
  PetscCall(SlipH5Claim(kind, file, h));
  access = SlipH5Access(kind->growing);
  errno = 0;
  h->id = H5Fcreate(h->name, H5F_ACC_TRUNC, H5P_DEFAULT, access);
  reason = errno;
  H5Pclose(access);
  if (h->id < 0) {
    SlipH5Release(h, PETSC_FALSE);
    PetscCall(SlipH5Refuse(h, h->name, reason ? reason : EIO));
  }
  SlipH5Enlist(h);
  SlipErrorAtEnd(SlipH5End);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* 0, or errno */
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

/*@C
  SlipH5CreateCopy - start writing an HDF5 file that begins as the copy of another

  Not collective: call on one rank.

  Input Parameters:
+ kind - by which option it is named, and whether it grows
. from - the file to copy, NULL for file.part or, when there is none, file
- file - final name, taken at SlipH5Close()

  Output Parameter:
. h - the open file

  Level: developer

  Errors: those of SlipH5CreateKind(), except that rows of a file.part do not count, and PETSC_ERR_FILE_WRITE when it
  cannot be copied

.seealso: SlipH5CreateKind(), SlipH5SetRows()
@*/
PetscErrorCode SlipH5CreateCopy(const SlipH5Kind *kind, const char from[], const char file[], SlipH5 *h)
{
  char part[PETSC_MAX_PATH_LEN];
  SlipH5Kind claim = *kind;
  hid_t properties;
  int reason;

  PetscFunctionBegin;
  claim.overwrite = PETSC_TRUE;
  PetscCall(SlipH5Claim(&claim, file, h));
  PetscCall(PetscSNPrintf(part, sizeof(part), "%s.part", h->target));
  if (!from) from = access(part, F_OK) ? h->target : part;
  reason = SlipH5CopyBytes(from, h->fd);
  if (!reason) reason = SlipH5MakeReadable(h->fd);
  if (reason) {
    SlipH5Release(h, PETSC_FALSE);
    SETERRQ(PETSC_COMM_SELF, PETSC_ERR_FILE_WRITE, "cannot copy %s to %s: %s%s", from, h->name, strerror(reason),
            h->source);
  }
  properties = SlipH5Access(kind->growing);
  h->id = H5Fopen(h->name, H5F_ACC_RDWR, properties);
  H5Pclose(properties);
  if (h->id < 0) {
    SlipH5Release(h, PETSC_FALSE);
    SETERRQ(PETSC_COMM_SELF, PETSC_ERR_FILE_OPEN, "%s is damaged%s", from, h->source);
  }
  SlipH5Enlist(h);
  SlipErrorAtEnd(SlipH5End);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipH5Create - SlipH5CreateKind() of a file that no option names and that is written in one go

  Not collective: call on one rank.

  Input Parameter:
. file - final name, taken at SlipH5Close()

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

/*@C
  SlipH5CheckCreateKind - would SlipH5CreateKind() work? For files that are written after something long

  Not collective.

  Input Parameters:
+ kind - by which option it is named, and whether it grows
- file - final name; an empty one is no file and no error

  Level: developer

  Errors: those of SlipH5CreateKind(), and PETSC_ERR_FILE_OPEN when an option of this program has file as its input

.seealso: SlipH5CheckCreate(), SlipH5CreateKind()
@*/
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

/*@C
  SlipH5CheckCreate - SlipH5CheckCreateKind() of a file that no option names

  Not collective.

  Input Parameter:
. file - final name; an empty one is no file and no error

  Level: developer

  Errors: those of SlipH5CheckCreateKind()

.seealso: SlipH5CheckCreateKind(), SlipH5Create()
@*/
PetscErrorCode SlipH5CheckCreate(const char file[])
{
  const SlipH5Kind kind = {0};

  PetscFunctionBegin;
  PetscCall(SlipH5CheckCreateKind(&kind, file));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- writing ---- */

/*@C
  SlipH5Live - let a growing file be read from now on, as file.part

  Not collective.

  Input Parameter:
. h - a growing file, with all its groups, series and attributes

  Level: developer

  Notes:
  Its attribute "complete" is 0 until SlipH5Close(). Nothing can be added any more but rows, and attributes of groups
  made by SlipH5GroupOfNumbers().

  Errors: PETSC_ERR_FILE_WRITE when the file cannot be written

.seealso: SlipH5CreateKind(), SlipH5AppendAll(), SlipH5FlushIsDue()
@*/
PetscErrorCode SlipH5Live(SlipH5 *h)
{
  char part[PETSC_MAX_PATH_LEN];
  int reason;

  PetscFunctionBegin;
  PetscCall(SlipH5WriteAttrInt(h, "/", "complete", 0));
  PetscCall(SlipH5Flush(h));
  errno = 0;
  if (H5Fstart_swmr_write(h->id) < 0) PetscCall(SlipH5WriteFailed(h, errno, PETSC_FALSE, "%s", h->name));
  h->live = PETSC_TRUE;
  reason = SlipH5MakeReadable(h->fd);
  PetscCall(PetscSNPrintf(part, sizeof(part), "%s.part", h->target));
  if (!reason && rename(h->name, part)) reason = errno;
  if (reason) PetscCall(SlipH5WriteFailed(h, reason, PETSC_TRUE, "%s", h->name));
  PetscCall(PetscStrncpy(h->name, part, sizeof(h->name)));
  PetscCall(PetscTime(&h->flushed));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipH5Flush - bring what was written so far to the file

  Not collective.

  Input Parameter:
. h - file

  Level: developer

  Errors: PETSC_ERR_FILE_WRITE when the file cannot be written

.seealso: SlipH5FlushIsDue(), SlipH5Sync(), SlipH5Close()
@*/
PetscErrorCode SlipH5Flush(SlipH5 *h)
{
  PetscLogDouble begin;
  int reason = 0;

  PetscFunctionBegin;
  PetscCall(PetscTime(&begin));
  reason = SlipH5MakeRoom(h, 0);
  if (reason) PetscCall(SlipH5WriteFailed(h, reason, PETSC_TRUE, "%s", h->name));
  if (h->live) reason = SlipH5MakeReadable(h->fd);
  errno = 0;
  if (!reason && H5Fflush(h->id, H5F_SCOPE_LOCAL) < 0) {
    reason = errno;
    PetscCall(SlipH5WriteFailed(h, reason, PETSC_FALSE, "%s", h->name));
  }
  if (!reason && h->live) reason = SlipH5MakeReadable(h->fd);
  if (reason) PetscCall(SlipH5WriteFailed(h, reason, PETSC_FALSE, "%s", h->name));
  h->ahead = 0;
  PetscCall(PetscTime(&h->flushed));
  h->cost = h->flushed - begin;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipH5FlushIsDue - has enough time passed since the last flush? Flushes are to take a hundredth of the wall time

  Not collective.

  Input Parameter:
. h - file

  Output Parameter:
. due - after a hundred times the last flush, not before 0.1 s and at the latest after 10 s

  Level: developer

.seealso: SlipH5Flush()
@*/
PetscErrorCode SlipH5FlushIsDue(SlipH5 *h, PetscBool *due)
{
  PetscLogDouble now;

  PetscFunctionBegin;
  PetscCall(PetscTime(&now));
  *due = now - h->flushed > PetscClipInterval(100 * h->cost, SLIP_H5_FLUSH_MIN, SLIP_H5_FLUSH_MAX) ? PETSC_TRUE
                                                                                                   : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipH5Sync - SlipH5Flush(), and wait until the disk has it

  Not collective.

  Input Parameter:
. h - file

  Level: developer

  Errors: PETSC_ERR_FILE_WRITE when the file cannot be written

.seealso: SlipH5Flush()
@*/
PetscErrorCode SlipH5Sync(SlipH5 *h)
{
  PetscFunctionBegin;
  PetscCall(SlipH5Flush(h));
  if (fsync(h->fd) && errno != EINVAL) PetscCall(SlipH5WriteFailed(h, errno, PETSC_FALSE, "%s", h->name));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipH5Abandon - close a file that is not complete: one that was written in one go is removed, a growing one stays as
  file.part

  Not collective. A file that is not open is left alone.

  Input Parameter:
. h - file

  Level: developer

  Errors: PETSC_ERR_FILE_WRITE when the last rows of a growing file cannot be written

.seealso: SlipH5Close()
@*/
PetscErrorCode SlipH5Abandon(SlipH5 *h)
{
  PetscFunctionBegin;
  if (h->id <= 0) PetscFunctionReturn(PETSC_SUCCESS);
  if (h->live)
    PetscCall(SlipH5Flush(h));
  else if (h->target[0])
    SlipH5CloseNowhere(h);
  if (h->live || !h->target[0]) (void)SlipH5CloseId(h->id);
  if (h->live) (void)SlipH5Trim(h->fd);
  SlipH5Release(h, h->live);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipH5AbandonAll - SlipH5Abandon() for every file that this process writes, when an error ends the program

  Not collective.

  Level: developer

  Note:
  A growing file without rows is removed as well. No error is raised.

.seealso: SlipH5Abandon(), SlipErrorHandlerPush()
@*/
void SlipH5AbandonAll(void)
{
  static PetscBool busy = PETSC_FALSE;

  if (busy) return; /* an error in what follows */
  busy = PETSC_TRUE;
  for (int i = 0; i < SLIP_H5_WRITTEN; i++) {
    SlipH5 *h = SlipH5Written(i);

    if (!h) continue;
    if (h->live && h->last) (void)(*h->last)(h->ctx);
    if (h->id > 0 && h->live && !SlipH5MostRows(h->id)) {
      SlipH5CloseNowhere(h);
      SlipH5Release(h, PETSC_FALSE);
    } else
      (void)SlipH5Abandon(h);
  }
  busy = PETSC_FALSE;
}

/* Before an error ends the program: may it use exit()? */
static PetscBool SlipH5End(void)
{
  SlipH5AbandonAll();
  return SlipH5IsStuck() ? PETSC_FALSE : PETSC_TRUE;
}

/*@C
  SlipH5Close - close a file; one that was written is complete now, and takes its final name when the disk has it

  Not collective. Closing twice does nothing.

  Input/Output Parameter:
. h - file

  Level: developer

  Errors: PETSC_ERR_FILE_WRITE when the file cannot be written or renamed

.seealso: SlipH5Create(), SlipH5Abandon()
@*/
PetscErrorCode SlipH5Close(SlipH5 *h)
{
  int reason = 0;

  PetscFunctionBegin;
  if (h->id <= 0) PetscFunctionReturn(PETSC_SUCCESS);
  if (!h->target[0]) {
    (void)H5Fclose(h->id);
    h->id = -1;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(SlipH5Flush(h)); /* all that is before "complete" */
  if (h->live) PetscCall(SlipH5WriteAttrInt(h, "/", "complete", 1));
  PetscCall(SlipH5Flush(h)); /* what follows is the superblock alone */
  reason = SlipH5CloseId(h->id);
  h->id = -1;
  if (!reason) reason = SlipH5Trim(h->fd);
  if (!reason && fsync(h->fd) && errno != EINVAL) reason = errno;
  if (!reason && rename(h->name, h->target)) reason = errno;
  SlipH5Release(h, reason && !h->live ? PETSC_FALSE : PETSC_TRUE);
  if (reason) PetscCall(SlipH5WriteFailed(h, reason, PETSC_TRUE, "%s", h->target));
  PetscFunctionReturn(PETSC_SUCCESS);
}
