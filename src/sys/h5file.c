/* Opens HDF5 files for reading, queries their content, lists the files that this process writes, and puts their bytes
   on the disk.

   HDF5 writes the metadata of a file opened for single-writer-multiple-reader access (SWMR) in an order in which every
   state on disk is a valid file, whenever the process is killed. But it marks the file as being written, so that only
   SWMR readers open it, also after a kill, and it writes the file's length last; both are in the superblock. Therefore
   the driver is HDF5's own with two functions replaced: one writes the superblock without the mark and with the length
   of the file, and the other does not change this length until the file is closed. In a test, plain readers opened all
   of 6684 states between any two writes of two such files, one of them compressed (test_h5.c growing()).

   After a failed write nothing more is written. HDF5 does not get the error: it could not close the file, and its
   clean-up at the end would crash or never end. Writers check SlipH5.failed (test_output_whole.py limited()). */
#define _GNU_SOURCE /* fallocate() */
#include <slipstep/private/sliph5.h>
#include <slipstep/private/slipwork.h>
#include <slipstep/rooms/slipsys.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#if H5_VERSION_GE(1, 13, 0)
  #include <H5FDdevelop.h>
#endif

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

/* Checks that an output is not a file that an option names for reading. source: option that names it, for the message.
   Errors: PETSC_ERR_FILE_OPEN when SlipH5OpenReadOption() has opened it in this process. */
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

/* Creates a group and its parents unless they exist. numbers: attributes can be added after SlipH5Live(). All are then
   in the header of the group, whose changes SWMR writes in a safe order; from nine on they would move to a heap, whose
   changes it does not. Errors: PETSC_ERR_FILE_WRITE when the group cannot be created. */
PetscErrorCode SlipH5Group(SlipH5 *h, const char path[], PetscBool numbers)
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

/* ---- files that this process writes ---- */

/* An entry may remain without its SlipH5, after an error that a program survives; it is then not found any more. */
typedef struct SlipH5Entry {
  SlipH5 *h;
  dev_t device;
  ino_t inode;
  struct SlipH5Entry *next;
} SlipH5Entry;
static SlipH5Entry *written = NULL;

SlipH5 *SlipH5Written(int i)
{
  const SlipH5Entry *entry = written;

  while (entry && i--) entry = entry->next;
  return entry ? entry->h : NULL;
}

/* While files are open for writing, exceeding the limit of the file size (RLIMIT_FSIZE) becomes an error of the write.
   By default a signal ends the process, also by handlers of OpenCL compilers, which MPI may load when it looks for
   devices. The previous handler is restored when all files are closed, unless another one was installed meanwhile. */
static struct sigaction limit_before;
static PetscBool limit_ours = PETSC_FALSE;

static void SlipH5IgnoreLimitSignal(void)
{
  struct sigaction now, ignore = {.sa_handler = SIG_IGN};

  if (sigaction(SIGXFSZ, NULL, &now) || now.sa_handler == SIG_IGN) return;
  sigemptyset(&ignore.sa_mask);
  if (sigaction(SIGXFSZ, &ignore, NULL)) return;
  limit_before = now;
  limit_ours = PETSC_TRUE;
}

PetscErrorCode SlipH5Enlist(SlipH5 *h)
{
  struct stat info;
  SlipH5Entry *entry;

  PetscFunctionBegin;
  PetscCheck(!fstat(h->fd, &info), PETSC_COMM_SELF, PETSC_ERR_FILE_OPEN, "cannot create %s: %s%s", h->name,
             strerror(errno), h->source);
  PetscCall(PetscNew(&entry));
  *entry = (SlipH5Entry){h, info.st_dev, info.st_ino, written};
  written = entry;
  SlipH5IgnoreLimitSignal();
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Releases the lock and the temporary file. */
void SlipH5Release(SlipH5 *h, PetscBool keep)
{
  struct sigaction now;

  for (SlipH5Entry **at = &written, *entry; (entry = *at);) {
    if (entry->h != h) {
      at = &entry->next;
      continue;
    }
    *at = entry->next;
    (void)PetscFree(entry);
  }
  if (h->fd >= 0 && !keep) unlink(h->name);
  if (h->fd >= 0) close(h->fd);
  h->fd = -1;
  h->id = -1;
  if (written) return;
  if (limit_ours && !sigaction(SIGXFSZ, NULL, &now) && now.sa_handler == SIG_IGN)
    (void)sigaction(SIGXFSZ, &limit_before, NULL);
  limit_ours = PETSC_FALSE;
}

/* Closes a file in HDF5; after a failed write nothing more is written. Returns 0 or errno. */
int SlipH5CloseId(SlipH5 *h)
{
  if (h->id > 0 && H5Fclose(h->id) < 0 && !h->failed) h->failed = EIO;
  h->id = -1;
  return h->failed;
}

PetscErrorCode SlipH5WriteFailed(SlipH5 *h, int reason, const char format[], ...)
{
  char what[2 * PETSC_MAX_PATH_LEN];
  va_list args;

  PetscFunctionBegin;
  va_start(args, format);
  (void)vsnprintf(what, sizeof(what), format, args);
  va_end(args);
  if (!reason) reason = h->failed;
  if (!h->failed && !(h->live && reason)) h->failed = reason ? reason : EIO;
  if (h->id > 0 && !h->failed) (void)H5Fflush(h->id, H5F_SCOPE_LOCAL);
  (void)SlipH5CloseId(h);
  SlipH5Release(h, h->live);
  SETERRQ(PETSC_COMM_SELF, PETSC_ERR_FILE_WRITE, "cannot write %s: %s%s%s", what,
          reason ? strerror(reason) : "HDF5 gives no reason",
          h->live ? "; the file keeps the whole rows before it" : "", h->source);
}

/* ---- the superblock ---- */

/* Space for the index of chunks and for HDF5's own blocks [bytes] */
#define SLIP_H5_SLACK 65536
/* Largest ratio of the space that a growing file needs next time to that of this time */
#define SLIP_H5_NEXT 4

/* Version 3 of the superblock, with addresses of 8 bytes: HDF5 file format specification, II.A */
enum { SUPERBLOCK = 48, SUPERBLOCK_FLAGS = 11, SUPERBLOCK_END = 28, SUPERBLOCK_SUM = 44 };

static uint32_t SlipRotate(uint32_t x, int k)
{
  return (x << k) | (x >> (32 - k));
}

/* Bob Jenkins' lookup3, hashlittle(), which checksums HDF5's metadata; n > 0 */
static uint32_t SlipLookup3(const unsigned char data[], size_t n)
{
  static const int mix[] = {4, 6, 8, 16, 19, 4}, last[] = {14, 11, 25, 16, 4, 14, 24};
  uint32_t x[3];

  x[0] = x[1] = x[2] = 0xdeadbeef + (uint32_t)n;
  for (;; data += 12, n -= 12) {
    for (size_t i = 0; i < 12 && i < n; i++) x[i / 4] += (uint32_t)data[i] << (8 * (i % 4));
    if (n <= 12) break;
    for (int k = 0; k < 6; k++) {
      uint32_t *a = &x[k % 3], *b = &x[(k + 1) % 3], *c = &x[(k + 2) % 3];

      *a = (*a - *c) ^ SlipRotate(*c, mix[k]);
      *c += *b;
    }
  }
  for (int k = 0; k < 7; k++) {
    uint32_t *c = &x[(k + 2) % 3], *b = &x[(k + 1) % 3];

    *c = (*c ^ *b) - SlipRotate(*b, last[k]);
  }
  return x[2];
}

/* Builds the superblock of a file with this end as every reader accepts it; false: older formats have no flags */
static PetscBool SlipH5Superblock(unsigned char block[SUPERBLOCK], uint64_t end)
{
  uint32_t sum;

  if (memcmp(block, "\211HDF\r\n\032\n\003\010", 10)) return PETSC_FALSE;
  block[SUPERBLOCK_FLAGS] = 0;
  for (int i = 0; i < 8; i++) block[SUPERBLOCK_END + i] = (unsigned char)(end >> (8 * i));
  sum = SlipLookup3(block, SUPERBLOCK_SUM);
  for (int i = 0; i < 4; i++) block[SUPERBLOCK_SUM + i] = (unsigned char)(sum >> (8 * i));
  return PETSC_TRUE;
}

/* Writes this end of the file to its superblock. The file is extended first if it is shorter, and gets the length
   afterwards. Returns 0 or errno. */
static int SlipH5SetEnd(SlipH5 *h, off_t end, off_t length)
{
  unsigned char block[SUPERBLOCK];
  struct stat info;

  errno = 0;
  if (fstat(h->fd, &info) || (info.st_size < end && ftruncate(h->fd, end)) ||
      pread(h->fd, block, SUPERBLOCK, 0) != SUPERBLOCK ||
      (SlipH5Superblock(block, (uint64_t)end) && pwrite(h->fd, block, SUPERBLOCK, 0) != SUPERBLOCK))
    return errno ? errno : EIO;
  h->end = end;
  if (ftruncate(h->fd, length) && length <= end) return errno; /* optional: limits of the file size may forbid it */
  return 0;
}

/* ---- the driver ---- */

static const H5FD_class_t *sec2; /* HDF5's own driver of files */

/* The SlipH5 that HDF5 has open; NULL: it was released */
static SlipH5 *SlipH5DriverFile(H5FD_t *file)
{
  const SlipH5Entry *entry = written;
  struct stat info;
  void *handle;

  if ((*sec2->get_handle)(file, H5P_DEFAULT, &handle) < 0 || fstat(*(int *)handle, &info)) return NULL;
  while (entry && (entry->device != info.st_dev || entry->inode != info.st_ino)) entry = entry->next;
  return entry ? entry->h : NULL;
}

static herr_t SlipH5DriverWrite(H5FD_t *file, H5FD_mem_t type, hid_t dxpl, haddr_t addr, size_t size, const void *data)
{
  SlipH5 *h = SlipH5DriverFile(file);
  unsigned char block[SUPERBLOCK];
  struct stat info;

  errno = 0;
  if (h && !h->failed && !addr && size >= SUPERBLOCK && !fstat(h->fd, &info)) {
    memcpy(block, data, SUPERBLOCK);
    if (SlipH5Superblock(block, (uint64_t)(h->end ? h->end : info.st_size))) {
      if ((*sec2->write)(file, type, dxpl, 0, SUPERBLOCK, block) < 0) h->failed = errno ? errno : EIO;
      addr = SUPERBLOCK;
      size -= SUPERBLOCK;
      data = (const char *)data + SUPERBLOCK;
    }
  }
  if (h && !h->failed && size && (*sec2->write)(file, type, dxpl, addr, size, data) < 0)
    h->failed = errno ? errno : EIO;
  return 0;
}

static herr_t SlipH5DriverTruncate(H5FD_t *file, hid_t dxpl, hbool_t closing)
{
  SlipH5 *h = SlipH5DriverFile(file);

  (void)dxpl;
  if (h && !h->failed && closing) {
    const off_t end = (off_t)(*sec2->get_eoa)(file, H5FD_MEM_DEFAULT);

    h->failed = SlipH5SetEnd(h, end, end);
  }
  return 0;
}

/* Makes HDF5 access registered files by this driver. */
void SlipH5SetDriver(hid_t access)
{
  static H5FD_class_t ours;
  static hid_t id = H5I_INVALID_HID;
  H5FD_t *any;

  H5Pset_fapl_sec2(access);
  if (id < 0 && (any = H5FDopen("/dev/null", H5F_ACC_RDONLY, access, HADDR_UNDEF))) {
    sec2 = any->cls;
    ours = *sec2;
    ours.name = "slipstep";
#if H5_VERSION_GE(1, 13, 0)
    ours.value = (H5FD_class_value_t)512; /* the first value that is not reserved */
#endif
    ours.terminate = NULL;
    ours.write = SlipH5DriverWrite;
    ours.truncate = SlipH5DriverTruncate;
    id = H5FDregister(&ours);
    H5FDclose(any);
  }
  H5Pset_driver(access, id, NULL);
}

/* ---- disk space ---- */

/*
  Allocates the disk space for the next write before HDF5 begins: a full disk is then detected while the file is whole,
  and HDF5 never meets it. If a file system cannot reserve space, the checks of each write detect it. A growing file
  also gets that length, so that its superblock covers what the next flush writes, and length for the next time: readers
  get the length of a file before they read its superblock, whose end must not exceed it by then. Returns 0 or errno.
*/
int SlipH5MakeRoom(SlipH5 *h, PetscInt64 bytes)
{
  struct stat info;
  hsize_t size;
  off_t begin, end;

  if (h->fd < 0) return 0;
  SlipH5IgnoreLimitSignal(); /* a handler may have been installed after the file was opened */
  errno = 0;
  if (H5Fget_filesize(h->id, &size) < 0 || fstat(h->fd, &info)) return errno ? errno : EIO;
  h->ahead += bytes;
  begin = h->end ? (off_t)h->end : info.st_size;
  end = (off_t)size + (off_t)h->ahead + SLIP_H5_SLACK;
  if (end <= begin) return 0;
#if defined(__linux__)
  {
    int failed;

    do failed = fallocate(h->fd, FALLOC_FL_KEEP_SIZE, begin, end - begin);
    while (failed && errno == EINTR);
    if (failed && (errno == ENOSPC || errno == EDQUOT || errno == EFBIG || errno == EIO)) return errno;
  }
#endif
  return h->live ? SlipH5SetEnd(h, end, end + SLIP_H5_NEXT * (end - begin) + SLIP_H5_SLACK) : 0;
}
