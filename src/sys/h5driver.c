/* HDF5's file driver for what this library writes.

   HDF5 keeps the metadata of a file opened for single-writer-multiple-reader access (SWMR) in an order in which every
   state on disk is a valid file, at whatever moment the process is killed or the disk is full. But it marks the file as
   being written, so that others than SWMR readers refuse it, also after a kill, and writes its length last. Both are in
   the superblock: this driver writes it without the mark, and ahead of metadata that may refer to what is behind the
   length that it says. The file itself is longer in advance, as readers ask for that first. Plain readers then open all
   states between any two writes (test_output_whole.py killed(), read_by_scripts()).

   A write that fails is the last one. HDF5 is not told of it: it could not close the file, and its clean-up at the end of
   the program crashes or does not end where it cannot. Who writes asks SlipH5.failed (test_output_whole.py limited()). */
#define _POSIX_C_SOURCE 200809L
#include <slipstep/private/slipsys.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#if H5_VERSION_GE(1, 13, 0)
  #include <H5FDdevelop.h>
#endif

#define SLIP_H5_AHEAD 262144 /* bytes by which a file is longer than its content while it is written, at least */

/* Version 3 of the superblock, with addresses of 8 bytes: HDF5 file format specification, II.A */
enum { SUPERBLOCK = 48, SUPERBLOCK_FLAGS = 11, SUPERBLOCK_END = 28, SUPERBLOCK_SUM = 44 };

typedef struct {
  H5FD_t base; /* HDF5's own */
  SlipH5 *h;
  haddr_t end, size, said; /* of the content, of the file, and as the superblock says [bytes] */
} SlipH5Driver;

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

/* errno of the first failure is kept, and nothing is written after it */
static void SlipH5DriverPut(SlipH5Driver *d, const void *data, size_t size, haddr_t addr)
{
  const char *at = (const char *)data;

  while (size && !d->h->failed) {
    const ssize_t n = pwrite(d->h->fd, at, size, (off_t)addr);

    if (n < 0 && errno != EINTR) d->h->failed = errno;
    if (n <= 0) continue;
    at += n;
    addr += (haddr_t)n;
    size -= (size_t)n;
  }
}

static herr_t SlipH5DriverRead(H5FD_t *file, H5FD_mem_t type, hid_t dxpl, haddr_t addr, size_t size, void *buffer)
{
  char *at = (char *)buffer;

  (void)type;
  (void)dxpl;
  while (size) {
    const ssize_t n = pread(((SlipH5Driver *)file)->h->fd, at, size, (off_t)addr);

    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return -1;
    if (n == 0) break;
    at += n;
    addr += (haddr_t)n;
    size -= (size_t)n;
  }
  memset(at, 0, size); /* behind the end of the file */
  return 0;
}

/* Writes the superblock as every reader takes it; other blocks and older versions, which have no flags, are left alone. */
static PetscBool SlipH5DriverSuperblock(SlipH5Driver *d, const unsigned char from[])
{
  unsigned char block[SUPERBLOCK];
  uint32_t sum;

  memcpy(block, from, SUPERBLOCK);
  if (memcmp(block, "\211HDF\r\n\032\n\003\010", 10)) return PETSC_FALSE;
  block[SUPERBLOCK_FLAGS] = 0;
  for (int i = 0; i < 8; i++) block[SUPERBLOCK_END + i] = (unsigned char)(d->end >> (8 * i));
  sum = SlipLookup3(block, SUPERBLOCK_SUM);
  for (int i = 0; i < 4; i++) block[SUPERBLOCK_SUM + i] = (unsigned char)(sum >> (8 * i));
  SlipH5DriverPut(d, block, SUPERBLOCK, 0);
  d->said = d->end;
  return PETSC_TRUE;
}

static void SlipH5DriverSayEnd(SlipH5Driver *d)
{
  unsigned char block[SUPERBLOCK];

  if (!d->h->failed && pread(d->h->fd, block, SUPERBLOCK, 0) == SUPERBLOCK) (void)SlipH5DriverSuperblock(d, block);
}

static herr_t SlipH5DriverWrite(H5FD_t *file, H5FD_mem_t type, hid_t dxpl, haddr_t addr, size_t size,
                                const void *buffer)
{
  SlipH5Driver *d = (SlipH5Driver *)file;

  (void)dxpl;
  if (type != H5FD_MEM_DRAW && d->end > d->said) SlipH5DriverSayEnd(d);
  if (addr || size != SUPERBLOCK || !SlipH5DriverSuperblock(d, (const unsigned char *)buffer))
    SlipH5DriverPut(d, buffer, size, addr);
  return 0;
}

static void SlipH5DriverResize(SlipH5Driver *d, haddr_t size)
{
  if (!d->h->failed && ftruncate(d->h->fd, (off_t)size)) d->h->failed = errno;
  d->size = size;
}

static haddr_t SlipH5DriverGetEnd(const H5FD_t *file, H5FD_mem_t type)
{
  (void)type;
  return ((const SlipH5Driver *)file)->end;
}

static herr_t SlipH5DriverSetEnd(H5FD_t *file, H5FD_mem_t type, haddr_t end)
{
  SlipH5Driver *d = (SlipH5Driver *)file;

  (void)type;
  d->end = end;
  if (d->h->failed || end + SLIP_H5_AHEAD <= d->size) return 0;
  if (!ftruncate(d->h->fd, (off_t)(end + 2 * SLIP_H5_AHEAD)))
    d->size = end + 2 * SLIP_H5_AHEAD;
  else if (end > d->size) /* the limit of the file's size is near */
    SlipH5DriverResize(d, end);
  return 0;
}

static haddr_t SlipH5DriverGetSize(const H5FD_t *file, H5FD_mem_t type)
{
  (void)type;
  return ((const SlipH5Driver *)file)->size;
}

static herr_t SlipH5DriverTruncate(H5FD_t *file, hid_t dxpl, hbool_t closing)
{
  SlipH5Driver *d = (SlipH5Driver *)file;

  (void)dxpl;
  if (!closing) return 0;
  SlipH5DriverSayEnd(d);
  SlipH5DriverResize(d, d->end);
  return 0;
}

/* The file is open, and locked, by the descriptor of the SlipH5 that the access properties have. */
static H5FD_t *SlipH5DriverOpen(const char *name, unsigned flags, hid_t access, haddr_t most)
{
  SlipH5Driver *d = (SlipH5Driver *)calloc(1, sizeof(*d));
  struct stat info;

  (void)name;
  (void)most;
  if (!d) return NULL;
  d->h = *(SlipH5 *const *)H5Pget_driver_info(access);
  if (((flags & H5F_ACC_TRUNC) && ftruncate(d->h->fd, 0)) || fstat(d->h->fd, &info)) {
    d->h->failed = errno;
    free(d);
    return NULL;
  }
  d->size = (haddr_t)info.st_size;
  return &d->base;
}

static herr_t SlipH5DriverClose(H5FD_t *file)
{
  free(file);
  return 0;
}

static herr_t SlipH5DriverQuery(const H5FD_t *file, unsigned long *flags)
{
  (void)file;
  *flags =
    H5FD_FEAT_AGGREGATE_METADATA | H5FD_FEAT_AGGREGATE_SMALLDATA | H5FD_FEAT_DATA_SIEVE | H5FD_FEAT_SUPPORTS_SWMR_IO;
  return 0;
}

static const H5FD_class_t SlipH5DriverClass = {
#if H5_VERSION_GE(1, 13, 0)
  .version = H5FD_CLASS_VERSION,
  .value = (H5FD_class_value_t)512, /* the first that nobody has reserved */
#endif
  .name = "slipstep",
  .maxaddr = INT64_MAX,
  .fc_degree = H5F_CLOSE_STRONG,
  .fapl_size = sizeof(SlipH5 *),
  .open = SlipH5DriverOpen,
  .close = SlipH5DriverClose,
  .query = SlipH5DriverQuery,
  .get_eoa = SlipH5DriverGetEnd,
  .set_eoa = SlipH5DriverSetEnd,
  .get_eof = SlipH5DriverGetSize,
  .read = SlipH5DriverRead,
  .write = SlipH5DriverWrite,
  .truncate = SlipH5DriverTruncate,
  .fl_map = H5FD_FLMAP_DICHOTOMY,
};

/* Access by this driver; h stays where it is until the file is closed. */
void SlipH5SetDriver(SlipH5 *h, hid_t access)
{
  static hid_t id = H5I_INVALID_HID;

  if (id < 0) id = H5FDregister(&SlipH5DriverClass);
  H5Pset_driver(access, id, &h);
}
