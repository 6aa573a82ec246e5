/* The disk space and the superblock of an HDF5 file that grows.

   HDF5 keeps the metadata of a file opened for single-writer-multiple-reader access (SWMR) in an order in which every
   state on disk is a valid file, at whatever moment the process is killed; but it marks the file as being written, so
   that others than SWMR readers refuse it, also after a kill, and writes its length last. Both are in the superblock,
   whose 48 bytes we therefore write ourselves, around every flush. Of 792 states between any two writes of such a
   file, plain readers then open all, and 178 fewer with the old length. */
#define _GNU_SOURCE /* fallocate() */
#include <slipstep/private/slipsys.h>
#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

/* Room for the index of chunks and for HDF5's own blocks [bytes] */
#define SLIP_H5_SLACK 65536

/* Version 3 of the superblock, with addresses of 8 bytes: HDF5 file format specification, II.A */
enum { SUPERBLOCK = 48, SUPERBLOCK_VERSION = 8, SUPERBLOCK_FLAGS = 11, SUPERBLOCK_END = 28, SUPERBLOCK_SUM = 44 };

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

/* Every reader may open the file, whose metadata may be anywhere in it: flags off, end of the file as it is. */
int SlipH5MakeReadable(int fd)
{
  unsigned char block[SUPERBLOCK];
  struct stat info;
  uint32_t sum;

  if (fstat(fd, &info)) return errno;
  if (pread(fd, block, SUPERBLOCK, 0) != SUPERBLOCK) return errno ? errno : EIO;
  if (memcmp(block, "\211HDF\r\n\032\n\003\010", 10)) return 0; /* older formats have no flags */
  block[SUPERBLOCK_FLAGS] = 0;
  for (int i = 0; i < 8; i++) block[SUPERBLOCK_END + i] = (unsigned char)((uint64_t)info.st_size >> (8 * i));
  sum = SlipLookup3(block, SUPERBLOCK_SUM);
  for (int i = 0; i < 4; i++) block[SUPERBLOCK_SUM + i] = (unsigned char)(sum >> (8 * i));
  return pwrite(fd, block, SUPERBLOCK, 0) == SUPERBLOCK ? 0 : errno ? errno : EIO;
}

/* Gives back what SlipH5MakeRoom() took too much; the file is closed for HDF5. */
int SlipH5Trim(int fd)
{
  unsigned char block[SUPERBLOCK];
  struct stat info;
  uint64_t end = 0;

  if (fstat(fd, &info)) return errno;
  if (pread(fd, block, SUPERBLOCK, 0) != SUPERBLOCK) return errno ? errno : EIO;
  for (int i = 0; i < 8; i++) end |= (uint64_t)block[SUPERBLOCK_END + i] << (8 * i);
  if (block[SUPERBLOCK_VERSION] != 3 || end > (uint64_t)info.st_size) end = (uint64_t)info.st_size;
  return ftruncate(fd, (off_t)end) ? errno : 0;
}

/* May bytes up to this end be written, as far as RLIMIT_FSIZE goes? */
static PetscBool SlipH5LimitAllows(off_t end)
{
  struct rlimit limit;

  return getrlimit(RLIMIT_FSIZE, &limit) || limit.rlim_cur == RLIM_INFINITY || (rlim_t)end <= limit.rlim_cur
           ? PETSC_TRUE
           : PETSC_FALSE;
}

/* The limit was lowered below the length of the file: what is in its reserved space cannot be written either. */
PetscBool SlipH5IsBeyondLimit(int fd)
{
  struct stat info;

  return fd >= 0 && !fstat(fd, &info) && !SlipH5LimitAllows(info.st_size) ? PETSC_TRUE : PETSC_FALSE;
}

/*
  Takes the disk space of what is to be written before HDF5 begins: a full disk is then found out while the file is
  whole, and HDF5 meets none. File systems that cannot reserve leave it to the checks of each write. A growing file
  also gets that length, so that SlipH5MakeReadable() covers what the next flush writes.
*/
int SlipH5MakeRoom(SlipH5 *h, PetscInt64 bytes)
{
  struct stat info;
  hsize_t size;
  off_t end;

  if (h->fd < 0) return 0;
  errno = 0;
  if (H5Fget_filesize(h->id, &size) < 0 || fstat(h->fd, &info)) return errno ? errno : EIO;
  h->ahead += bytes;
  end = (off_t)size + (off_t)h->ahead + SLIP_H5_SLACK;
  if (!SlipH5LimitAllows(end)) return EFBIG; /* also within the file: the limit is that of now */
  if (end <= info.st_size) return 0;
#if defined(__linux__)
  {
    int failed;

    do failed = fallocate(h->fd, h->live ? 0 : FALLOC_FL_KEEP_SIZE, info.st_size, end - info.st_size);
    while (failed && errno == EINTR);
    if (!failed) return 0;
    if (errno == ENOSPC || errno == EDQUOT || errno == EFBIG || errno == EIO) return errno;
  }
#endif
  return h->live && ftruncate(h->fd, end) ? errno : 0;
}
