/* Checks that references of a file to strings of variable length are valid.

   A file has 16 bytes for each such string: its length, and a place in a heap. HDF5 1.10 does not check them: it copies
   the string from the heap to a buffer of the length in the reference, and loops for ever in a heap with a free piece
   of 0 bytes. So both are checked before HDF5 reads a string. HDF5 file format specification, III.E and IV.B. */
#define _POSIX_C_SOURCE 200809L
#include <slipstep/private/slipsys.h>
#include <fcntl.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

typedef struct {
  unsigned char *bytes; /* of the whole heap */
  PetscInt64 at;        /* address in references; 0: none */
  PetscInt64 size, *object;
} SlipH5Heap;

enum { OBJECTS = 65536, LENGTH = 4, INDEX = 4 }; /* indices of a heap; bytes of a reference besides its address */

/* Decodes a number; -1 if it exceeds the range of PetscInt64 */
static PetscInt64 SlipH5Number(const unsigned char bytes[], size_t n)
{
  uint64_t x = 0;

  for (size_t i = n; i-- > 0;) {
    if (x >> 55) return -1;
    x = x << 8 | bytes[i];
  }
  return (PetscInt64)x;
}

/* Finds the sizes of the heap's objects by index, -1: none. Returns false if the heap is damaged. */
static PetscBool SlipH5HeapLoad(int fd, PetscInt64 base, size_t width, SlipH5Heap *heap)
{
  const size_t head = 8 + width; /* bytes of the head of the heap, and of each object */
  unsigned char start[8 + sizeof(hsize_t)];
  struct stat info;

  for (PetscInt i = 0; i < OBJECTS; i++) heap->object[i] = -1;
  if (fstat(fd, &info) || pread(fd, start, head, base + heap->at) != (ssize_t)head || memcmp(start, "GCOL\1", 5))
    return PETSC_FALSE;
  heap->size = SlipH5Number(start + 8, width);
  if (heap->size < 0 || heap->size > (PetscInt64)info.st_size - base - heap->at) return PETSC_FALSE;
  (void)PetscFree(heap->bytes);
  if (PetscMalloc1((size_t)heap->size, &heap->bytes) ||
      pread(fd, heap->bytes, (size_t)heap->size, base + heap->at) != (ssize_t)heap->size)
    return PETSC_FALSE;
  for (PetscInt64 i = (PetscInt64)head, needs; heap->size - i >= (PetscInt64)head; i += needs) {
    const PetscInt64 index = SlipH5Number(heap->bytes + i, 2), size = SlipH5Number(heap->bytes + i + 8, width);

    needs = index ? (PetscInt64)head + (size + 7) / 8 * 8 : size; /* the size of free space includes its head */
    if (size < 0 || needs < (PetscInt64)head || needs > heap->size - i) return PETSC_FALSE;
    heap->object[index] = index ? size : -1;
  }
  return PETSC_TRUE;
}

/* A H5T_conv_t that passes on the bytes of references as they are in the file; HDF5 has no such conversion */
static herr_t SlipH5Reference(hid_t from, hid_t to, H5T_cdata_t *data, size_t n, size_t stride, size_t other, void *buf,
                              void *background, hid_t properties)
{
  (void)n, (void)stride, (void)other, (void)buf, (void)background, (void)properties;
  data->need_bkg = H5T_BKG_NO;
  return data->command == H5T_CONV_INIT && H5Tget_size(from) != H5Tget_size(to) ? -1 : 0;
}

static PetscBool SlipH5ReadReferences(hid_t id, size_t size, unsigned char bytes[])
{
  const char name[] = "reference";
  const hid_t strings = H5Tcopy(H5T_C_S1), raw = H5Tcreate(H5T_OPAQUE, size);
  herr_t err;

  H5Tset_size(strings, H5T_VARIABLE);
  err = H5Tregister(H5T_PERS_SOFT, name, strings, raw, SlipH5Reference);
  if (err >= 0)
    err =
      H5Iget_type(id) == H5I_ATTR ? H5Aread(id, raw, bytes) : H5Dread(id, raw, H5S_ALL, H5S_ALL, H5P_DEFAULT, bytes);
  H5Tunregister(H5T_PERS_SOFT, name, H5I_INVALID_HID, H5I_INVALID_HID, SlipH5Reference);
  H5Tclose(raw);
  H5Tclose(strings);
  return err >= 0 ? PETSC_TRUE : PETSC_FALSE;
}

/* Checks references of a given size to addresses of a given width; total: bytes of the strings */
static PetscBool SlipH5FollowReferences(int fd, PetscInt64 base, size_t address, size_t width, PetscInt n,
                                        const unsigned char bytes[], SlipH5Heap *heap, PetscInt64 *total)
{
  for (PetscInt i = 0; i < n; i++, bytes += LENGTH + address + INDEX) {
    const PetscInt64 length = SlipH5Number(bytes, LENGTH), at = SlipH5Number(bytes + LENGTH, address);
    const PetscInt64 index = SlipH5Number(bytes + LENGTH + address, INDEX);

    if (!at) continue; /* an empty string */
    if (at != heap->at) {
      heap->at = at;
      if (at < 0 || !SlipH5HeapLoad(fd, base, width, heap)) return PETSC_FALSE;
    }
    if (index >= OBJECTS || heap->object[index] != length) return PETSC_FALSE;
    *total += length;
  }
  return PETSC_TRUE;
}

/* Checks whether the n strings of an open dataset or attribute can be read, and have at most so many bytes in total. */
PetscErrorCode SlipH5StringsAreWhole(hid_t id, PetscInt n, PetscInt64 most, PetscBool *whole)
{
  const hid_t file = H5Iget_file_id(id), made = H5Fget_create_plist(file);
  SlipH5Heap heap = {.bytes = NULL};
  char name[PETSC_MAX_PATH_LEN] = "";
  unsigned char *bytes;
  hsize_t base = 0;
  size_t address = 0, width = 0;
  PetscInt64 total = 0;
  int fd;

  PetscFunctionBegin;
  H5Pget_userblock(made, &base);
  H5Pget_sizes(made, &address, &width);
  H5Fget_name(file, name, sizeof(name));
  H5Fflush(file, H5F_SCOPE_LOCAL); /* the file may be open for writing */
  fd = open(name, O_RDONLY | O_CLOEXEC);
  PetscCall(PetscMalloc1(OBJECTS, &heap.object));
  PetscCall(PetscCalloc1(PetscMax(n, 1) * (LENGTH + address + INDEX), &bytes));
  *whole = fd >= 0 && width <= sizeof(hsize_t) && SlipH5ReadReferences(id, LENGTH + address + INDEX, bytes) &&
               SlipH5FollowReferences(fd, (PetscInt64)base, address, width, n, bytes, &heap, &total) && total <= most
             ? PETSC_TRUE
             : PETSC_FALSE;
  PetscCall(PetscFree(bytes));
  PetscCall(PetscFree(heap.bytes));
  PetscCall(PetscFree(heap.object));
  if (fd >= 0) close(fd);
  H5Pclose(made);
  H5Fclose(file);
  PetscFunctionReturn(PETSC_SUCCESS);
}
