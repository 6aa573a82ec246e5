/* How HDF5 files are written to the disk.

   HDF5 keeps the metadata of a file opened for single-writer-multiple-reader access (SWMR) in an order in which every
   state on disk is a valid file, at whatever moment the process is killed; but it marks the file as being written, so
   that others than SWMR readers refuse it, also after a kill, and writes its length last. Both are in the superblock.
   So we write by HDF5's own driver with two functions replaced: one writes the superblock without the mark and with the
   length of the file, the other leaves this length alone until the file is closed. Of 6684 states between any two
   writes of two such files, one compressed, plain readers then open all (test_h5.c growing()).

   A write that fails is the last one. HDF5 is not told of it: it could not close the file, and its clean-up at the end
   of the program crashes or does not end where it cannot. Who writes asks SlipH5.failed (test_output_whole.py
   limited()). */
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

/* Room for the index of chunks and for HDF5's own blocks [bytes] */
#define SLIP_H5_SLACK 65536
/* How many times more than this time a growing file may need the next time */
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

/* The superblock as every reader takes it, of a file with this end; false: older formats have no flags */
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

/* Lets the superblock say this end of the file, which grows before that where it is shorter, and has the length after
   that. 0, or errno */
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
  if (ftruncate(h->fd, length) && length <= end) return errno; /* beyond the end it is a wish: of a limit of sizes */
  return 0;
}

/* ---- the driver ---- */

static const H5FD_class_t *sec2; /* HDF5's own driver of files */

/* The file of ours that HDF5 has open; NULL: it was released */
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

/* Access by this driver to files that are enlisted */
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
    ours.value = (H5FD_class_value_t)512; /* the first that nobody has reserved */
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
  Takes the disk space of what is to be written before HDF5 begins: a full disk is then found out while the file is
  whole, and HDF5 meets none. File systems that cannot reserve leave it to the checks of each write. A growing file also
  gets that length, so that its superblock covers what the next flush writes, and length for the next time: readers look
  at the length of a file before they read its superblock, which must not have grown beyond it by then. 0, or errno
*/
int SlipH5MakeRoom(SlipH5 *h, PetscInt64 bytes)
{
  struct stat info;
  hsize_t size;
  off_t begin, end;

  if (h->fd < 0) return 0;
  SlipH5IgnoreLimitSignal(); /* of a handler that came after the file */
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
