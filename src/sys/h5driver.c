/* How HDF5 files are written to the disk.

   HDF5 writes the metadata of a file opened for single-writer-multiple-reader access (SWMR) in an order in which every
   state on disk is a valid file, whenever the process is killed. But it marks the file as being written, so that only
   SWMR readers open it, also after a kill, and it writes the file's length last; both are in the superblock. Therefore
   this driver is HDF5's own with two functions replaced: one writes the superblock without the mark and with the length
   of the file, and the other does not change this length until the file is closed. In a test, plain readers opened all
   of 6684 states between any two writes of two such files, one of them compressed (test_h5.c growing()).

   After a failed write nothing more is written. HDF5 does not get the error: it could not close the file, and its
   clean-up at the end would crash or never end. Writers check SlipH5.failed (test_output_whole.py limited()). */
#define _GNU_SOURCE /* fallocate() */
#include <slipstep/private/slipsys.h>
#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#if H5_VERSION_GE(1, 13, 0)
  #include <H5FDdevelop.h>
#endif

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
  struct stat info;
  void *handle;

  return (*sec2->get_handle)(file, H5P_DEFAULT, &handle) < 0 || fstat(*(int *)handle, &info) ? NULL
                                                                                             : SlipH5WrittenAs(&info);
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
