/* Reads datasets and attributes of HDF5 files, with errors that state what was expected, and checks first what HDF5
   does not. */
#define _POSIX_C_SOURCE 200809L
#include <slipstep/private/sliph5.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define SLIP_H5_MAX_NUMBER 16     /* bytes of a number */
#define SLIP_H5_MAX_TEXT 1048576  /* limit for lists of strings (bytes, entries), string attributes (bytes) */
#define SLIP_H5_UNWRITTEN 1048576 /* limit of bytes of a dataset of any shape with only fill values */
#define SLIP_H5_DEFLATE 1032      /* largest ratio by which deflate can compress (zlib, Technical Details) */

static PetscErrorCode SlipH5OpenDataset(SlipH5 *h, const char path[], hid_t *set)
{
  PetscBool has;

  PetscFunctionBegin;
  PetscCall(SlipH5Has(h, path, &has));
  PetscCheck(has, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED, "%s has no dataset %s%s", h->name, path, h->source);
  *set = H5Dopen2(h->id, path, H5P_DEFAULT);
  PetscCheck(*set >= 0, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED, "%s in %s is not a dataset%s", path, h->name,
             h->source);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SlipH5OpenAttribute(SlipH5 *h, const char path[], const char attr[], hid_t *id)
{
  PetscBool has;

  PetscFunctionBegin;
  PetscCall(SlipH5Has(h, path, &has));
  PetscCheck(has, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED, "%s has no group or dataset %s%s", h->name, path,
             h->source);
  *id = H5Aopen_by_name(h->id, path, attr, H5P_DEFAULT, H5P_DEFAULT);
  PetscCheck(*id >= 0, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED, "%s has no attribute %s on %s%s", h->name, attr,
             path, h->source);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static H5T_class_t SlipH5TypeClass(hid_t type)
{
  const H5T_class_t c = H5Tget_class(type);

  H5Tclose(type);
  return c;
}

/* The size must be one that numbers have, too: a damaged type may have 0 bytes, gigabytes that HDF5 would allocate, or
   bits outside of it. Closes the type. */
static PetscBool SlipH5IsNumber(hid_t type)
{
  const size_t size = H5Tget_size(type), bits = H5Tget_precision(type); /* 0: an enumeration without numbers */
  const H5T_class_t c = SlipH5TypeClass(type);

  return (c == H5T_INTEGER || c == H5T_FLOAT || c == H5T_ENUM) && size && size <= SLIP_H5_MAX_NUMBER && bits &&
             bits <= 8 * size
           ? PETSC_TRUE
           : PETSC_FALSE;
}

/* Describes a shape, as "3, 4", with "any" for a size below 0 */
static void SlipH5DescribeShape(PetscInt rank, const PetscInt64 shape[], char text[], size_t len)
{
  size_t used = 0;

  text[0] = '\0';
  for (PetscInt d = 0; d < rank && used < len; d++) {
    const char *comma = d ? ", " : "";

    if (shape[d] < 0)
      used += (size_t)snprintf(text + used, len - used, "%sany", comma);
    else
      used += (size_t)snprintf(text + used, len - used, "%s%lld", comma, (long long)shape[d]);
  }
}

/* Checks type and shape of an open dataset before anything of it is read; sizes have 64 bits, whatever PetscInt is. */
static PetscErrorCode SlipH5CheckShape(SlipH5 *h, const char path[], hid_t set, PetscInt ndim, const PetscInt want[],
                                       const char what[], PetscInt dims[], size_t *n)
{
  const hid_t space = H5Dget_space(set), type = H5Dget_type(set);
  const int rank = H5Sget_simple_extent_ndims(space);
  const hsize_t stored = H5Dget_storage_size(set);
  const size_t size = H5Tget_size(type);
  const PetscBool is_number = SlipH5IsNumber(type);
  hsize_t extent[H5S_MAX_RANK] = {0};
  PetscInt64 shape[SLIP_H5_MAX_DIM], wanted[SLIP_H5_MAX_DIM];
  char found[128], expected[128];
  PetscBool fits = PETSC_TRUE, known = PETSC_TRUE;

  PetscFunctionBegin;
  if (rank >= 0) H5Sget_simple_extent_dims(space, extent, NULL);
  H5Sclose(space);
  PetscCheck(is_number, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED, "%s in %s does not hold numbers%s", path, h->name,
             h->source);
  PetscCheck(rank >= 0 && rank <= SLIP_H5_MAX_DIM, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
             "%s in %s has %d dimensions, expected %" PetscInt_FMT "%s", path, h->name, rank, ndim, h->source);
  for (int d = 0; d < rank; d++) shape[d] = extent[d] > INT64_MAX ? INT64_MAX : (PetscInt64)extent[d];
  SlipH5DescribeShape(rank, shape, found, sizeof(found));
  PetscCheck(rank == (int)ndim, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
             "%s in %s has shape [%s], expected %" PetscInt_FMT " dimension%s%s", path, h->name, found, ndim,
             ndim == 1 ? "" : "s", h->source);
  *n = 1;
  for (PetscInt d = 0; d < ndim; d++) {
    wanted[d] = want ? want[d] : -1;
    known = known && wanted[d] >= 0 ? PETSC_TRUE : PETSC_FALSE;
    fits = fits && (wanted[d] < 0 || shape[d] == wanted[d]) ? PETSC_TRUE : PETSC_FALSE;
  }
  SlipH5DescribeShape(ndim, wanted, expected, sizeof(expected));
  PetscCheck(fits, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED, "%s in %s has shape [%s], expected [%s]%s%s%s", path,
             h->name, found, expected, what ? ", " : "", what ? what : "", h->source);
  for (PetscInt d = 0; d < ndim; d++) {
    PetscCheck(shape[d] <= PETSC_MAX_INT && (!shape[d] || *n <= SIZE_MAX / sizeof(PetscReal) / (size_t)shape[d]),
               PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
               "%s in %s has shape [%s], more entries than a PetscInt of %d bits can count%s", path, h->name, found,
               (int)(8 * sizeof(PetscInt)), h->source);
    dims[d] = (PetscInt)shape[d];
    *n *= (size_t)shape[d];
  }
  PetscCheck(known || *n <= (SLIP_H5_UNWRITTEN + SLIP_H5_DEFLATE * stored) / size, PETSC_COMM_SELF,
             PETSC_ERR_FILE_UNEXPECTED,
             "%s in %s has shape [%s], but the file has only %llu bytes of it: damaged, or never written%s", path,
             h->name, found, (unsigned long long)stored, h->source);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets the number of dimensions of a dataset. Errors: PETSC_ERR_FILE_UNEXPECTED when it is missing. */
PetscErrorCode SlipH5GetRank(SlipH5 *h, const char path[], PetscInt *ndim)
{
  hid_t set = H5I_INVALID_HID, space;

  PetscFunctionBegin;
  PetscCall(SlipH5OpenDataset(h, path, &set));
  space = H5Dget_space(set);
  *ndim = H5Sget_simple_extent_ndims(space);
  H5Sclose(space);
  H5Dclose(set);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets the size of one dimension of a dataset, if the shape decides what is read. size: -1 if the dataset has fewer
   dimensions, or more entries than PetscInt can hold. Errors: PETSC_ERR_FILE_UNEXPECTED when it is missing. */
PetscErrorCode SlipH5GetSize(SlipH5 *h, const char path[], PetscInt dim, PetscInt *size)
{
  hsize_t extent[H5S_MAX_RANK] = {0};
  hid_t set = H5I_INVALID_HID, space;

  PetscFunctionBegin;
  PetscCall(SlipH5OpenDataset(h, path, &set));
  space = H5Dget_space(set);
  *size = -1;
  if (dim < H5Sget_simple_extent_ndims(space)) {
    H5Sget_simple_extent_dims(space, extent, NULL);
    if (extent[dim] <= (hsize_t)PETSC_MAX_INT) *size = (PetscInt)extent[dim];
  }
  H5Sclose(space);
  H5Dclose(set);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipH5ReadRealSized - reads a dataset of numbers whose shape is known, at least in part

  Not collective.

  Input Parameters:
+ h    - file
. path - dataset
. ndim - number of dimensions it must have, 0 (scalar) to 4
. want - the shape it must have [ndim], -1 for any size; NULL: any shape
- what - for messages, the meaning of that shape, such as "one for each observation", or NULL

  Output Parameters:
+ dims - its shape [ndim]
- data - its values, row-major, in the units of the dataset; free with PetscFree()

  Level: developer

  Note:
  The shape is checked before values are read: a shape that is partly unknown must be backed by bytes of the file.

  Errors: PETSC_ERR_FILE_UNEXPECTED if it is missing, is not numeric, has another shape, or one that the file is too
  small for; PETSC_ERR_FILE_READ if its values cannot be read.

.seealso: SlipH5ReadReal(), SlipH5ReadStrings()
@*/
PetscErrorCode SlipH5ReadRealSized(SlipH5 *h, const char path[], PetscInt ndim, const PetscInt want[],
                                   const char what[], PetscInt dims[], PetscReal **data)
{
  hid_t set;
  size_t n;
  herr_t err;
  PetscErrorCode ierr;

  PetscFunctionBegin;
  *data = NULL;
  PetscCheck(ndim >= 0 && ndim <= SLIP_H5_MAX_DIM, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
             "%" PetscInt_FMT " dimensions, expected 0 to %d", ndim, SLIP_H5_MAX_DIM);
  PetscCall(SlipH5OpenDataset(h, path, &set));
  ierr = SlipH5CheckShape(h, path, set, ndim, want, what, dims, &n);
  if (!ierr) ierr = PetscMalloc1(PetscMax(n, 1), data);
  if (ierr) H5Dclose(set);
  PetscCall(ierr);
  err = n ? H5Dread(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, *data) : 0;
  H5Dclose(set);
  if (err < 0) PetscCall(PetscFree(*data));
  PetscCheck(err >= 0, PETSC_COMM_SELF, PETSC_ERR_FILE_READ, "cannot read %s in %s: damaged file?%s", path, h->name,
             h->source);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads a dataset of numbers of any shape. ndim: number of dimensions it must have, 0 (scalar) to 4; dims: its shape
   [ndim]; data: its values, row-major, in the units of the dataset; free with PetscFree(). Errors: those of
   SlipH5ReadRealSized(). */
PetscErrorCode SlipH5ReadReal(SlipH5 *h, const char path[], PetscInt ndim, PetscInt dims[], PetscReal **data)
{
  PetscFunctionBegin;
  PetscCall(SlipH5ReadRealSized(h, path, ndim, NULL, NULL, dims, data));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipH5ReadPiece(SlipH5 *h, const char path[], PetscInt N, PetscInt start, PetscInt n, PetscReal data[])
{
  const hsize_t first = (hsize_t)start, count = (hsize_t)n;
  const hid_t set = H5Dopen2(h->id, path, H5P_DEFAULT), space = H5Dget_space(set);
  hsize_t found = 0;
  hid_t memory;
  herr_t err;

  PetscFunctionBegin;
  if (H5Sget_simple_extent_ndims(space) == 1) H5Sget_simple_extent_dims(space, &found, NULL);
  memory = H5Screate_simple(1, &count, NULL);
  err = H5Sselect_hyperslab(space, H5S_SELECT_SET, &first, NULL, &count, NULL);
  if (err >= 0 && found == (hsize_t)N) err = H5Dread(set, H5T_NATIVE_DOUBLE, memory, space, H5P_DEFAULT, data);
  H5Sclose(memory);
  H5Sclose(space);
  H5Dclose(set);
  PetscCheck(found == (hsize_t)N, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
             "%s has no dataset %s of %" PetscInt_FMT " numbers%s", h->name, path, N, h->source);
  PetscCheck(err >= 0, PETSC_COMM_SELF, PETSC_ERR_FILE_READ, "cannot read %s in %s%s", path, h->name, h->source);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- strings of variable length ---- */

/* Checks that references of a file to strings of variable length are valid.

   A file has 16 bytes for each such string: its length, and a place in a heap. HDF5 1.10 does not check them: it copies
   the string from the heap to a buffer of the length in the reference, and loops for ever in a heap with a free piece
   of 0 bytes. So both are checked before HDF5 reads a string. HDF5 file format specification, III.E and IV.B. */

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
static PetscErrorCode SlipH5StringsAreWhole(hid_t id, PetscInt n, PetscInt64 most, PetscBool *whole)
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

/* Memory type for strings stored as `type`: the same character set, variable or fixed length, null-terminated. */
static hid_t SlipH5StringType(hid_t type, PetscBool *variable, size_t *len)
{
  const hid_t mem = H5Tcopy(H5T_C_S1);

  *variable = H5Tis_variable_str(type) > 0 ? PETSC_TRUE : PETSC_FALSE;
  *len = H5Tget_size(type) + 1;
  H5Tset_size(mem, *variable ? H5T_VARIABLE : *len);
  H5Tset_cset(mem, H5Tget_cset(type));
  return mem;
}

static PetscErrorCode SlipH5ReadStringsOf(hid_t set, hid_t space, PetscInt n, char **strings, herr_t *err)
{
  const hid_t type = H5Dget_type(set);
  PetscBool variable;
  size_t len;
  hid_t mem = SlipH5StringType(type, &variable, &len);

  PetscFunctionBegin;
  H5Tclose(type);
  if (variable) {
    PetscBool whole;
    char **raw;

    PetscCall(PetscCalloc1(PetscMax(n, 1), &raw));
    PetscCall(SlipH5StringsAreWhole(set, n, SLIP_H5_MAX_TEXT, &whole)); /* many entries may refer to one long string */
    *err = whole ? 0 : -1;
    if (whole) *err = H5Dread(set, mem, H5S_ALL, H5S_ALL, H5P_DEFAULT, raw);
    for (PetscInt i = 0; i < n && *err >= 0; i++) PetscCall(PetscStrallocpy(raw[i] ? raw[i] : "", &strings[i]));
    if (*err >= 0) H5Dvlen_reclaim(mem, space, H5P_DEFAULT, raw);
    PetscCall(PetscFree(raw));
  } else {
    char *raw;

    PetscCall(PetscCalloc1(PetscMax((size_t)n * len, 1), &raw));
    *err = H5Dread(set, mem, H5S_ALL, H5S_ALL, H5P_DEFAULT, raw);
    for (PetscInt i = 0; i < n && *err >= 0; i++) PetscCall(PetscStrallocpy(raw + (size_t)i * len, &strings[i]));
    PetscCall(PetscFree(raw));
  }
  H5Tclose(mem);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads a one-dimensional dataset of strings, of fixed or variable length. strings: the strings; free with
   SlipH5FreeStrings(). Errors: PETSC_ERR_FILE_UNEXPECTED if it is missing, has no strings or more than one dimension;
   PETSC_ERR_FILE_READ if the text is not in the file, for example because it is damaged. */
PetscErrorCode SlipH5ReadStrings(SlipH5 *h, const char path[], PetscInt *n, char ***strings)
{
  hid_t set, space, id;
  hsize_t shape = 0;
  size_t size;
  int rank;
  herr_t err = 0;
  H5T_class_t type;

  PetscFunctionBegin;
  *n = 0;
  *strings = NULL;
  PetscCall(SlipH5OpenDataset(h, path, &set));
  id = H5Dget_type(set);
  size = H5Tget_size(id);
  type = SlipH5TypeClass(id);
  space = H5Dget_space(set);
  rank = H5Sget_simple_extent_ndims(space);
  if (type != H5T_STRING || rank != 1 || !size) {
    H5Sclose(space);
    H5Dclose(set);
    SETERRQ(PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED, "%s in %s is not a list of strings%s", path, h->name,
            h->source);
  }
  H5Sget_simple_extent_dims(space, &shape, NULL);
  if (shape > SLIP_H5_MAX_TEXT / size) {
    H5Sclose(space);
    H5Dclose(set);
    SETERRQ(PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED, "%s in %s has %llu strings of %zu bytes, expected at most %d%s",
            path, h->name, (unsigned long long)shape, size, SLIP_H5_MAX_TEXT, h->source);
  }
  *n = (PetscInt)shape;
  PetscCall(PetscCalloc1(PetscMax(*n, 1), strings));
  PetscCall(SlipH5ReadStringsOf(set, space, *n, *strings, &err));
  H5Sclose(space);
  H5Dclose(set);
  if (err < 0) PetscCall(SlipH5FreeStrings(*n, strings));
  PetscCheck(err >= 0, PETSC_COMM_SELF, PETSC_ERR_FILE_READ,
             "cannot read %s in %s, expected strings of at most %d bytes together: damaged file?%s", path, h->name,
             SLIP_H5_MAX_TEXT, h->source);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Frees the output of SlipH5ReadStrings(). strings: the strings, set to NULL. */
PetscErrorCode SlipH5FreeStrings(PetscInt n, char ***strings)
{
  PetscFunctionBegin;
  if (*strings) {
    for (PetscInt i = 0; i < n; i++) PetscCall(PetscFree((*strings)[i]));
  }
  PetscCall(PetscFree(*strings));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipH5ReadAttrReal - reads a scalar (or one-entry) attribute as a real number

  Not collective.

  Input Parameters:
+ h    - file
. path - group or dataset
- attr - name of the attribute

  Output Parameter:
. value - the number, in the unit it was written in

  Level: developer

  Errors: PETSC_ERR_FILE_UNEXPECTED when it is missing or not one number.

.seealso: SlipH5ReadAttrInt(), SlipH5ReadAttrString()
@*/
PetscErrorCode SlipH5ReadAttrReal(SlipH5 *h, const char path[], const char attr[], PetscReal *value)
{
  hid_t id, space;
  hssize_t n;
  herr_t err = -1;
  PetscBool number;

  PetscFunctionBegin;
  PetscCall(SlipH5OpenAttribute(h, path, attr, &id));
  number = SlipH5IsNumber(H5Aget_type(id));
  space = H5Aget_space(id);
  n = H5Sget_simple_extent_npoints(space);
  H5Sclose(space);
  if (n == 1 && number) err = H5Aread(id, H5T_NATIVE_DOUBLE, value);
  H5Aclose(id);
  PetscCheck(err >= 0, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED, "attribute %s of %s in %s is not one number%s", attr,
             path, h->name, h->source);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads a scalar (or one-entry) attribute as an integer. h, path: file, and group or dataset. Errors:
   PETSC_ERR_FILE_UNEXPECTED when it is missing or not one integer in the range of PetscInt. */
PetscErrorCode SlipH5ReadAttrInt(SlipH5 *h, const char path[], const char attr[], PetscInt *value)
{
  PetscReal real;

  PetscFunctionBegin;
  PetscCall(SlipH5ReadAttrReal(h, path, attr, &real));
  PetscCheck(real == PetscFloorReal(real) && PetscAbsReal(real) <= (PetscReal)PETSC_MAX_INT, PETSC_COMM_SELF,
             PETSC_ERR_FILE_UNEXPECTED, "attribute %s of %s in %s is %g, expected an integer%s", attr, path, h->name,
             (double)real, h->source);
  *value = (PetscInt)real;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads a string attribute, of fixed or variable length. len: size of value; a longer string is an error. Errors:
   PETSC_ERR_FILE_UNEXPECTED if it is missing, not one string, or too long; PETSC_ERR_FILE_READ if the text is not in
   the file, for example because it is damaged. */
PetscErrorCode SlipH5ReadAttrString(SlipH5 *h, const char path[], const char attr[], char value[], size_t len)
{
  hid_t id, type, space, mem;
  PetscBool variable, good = PETSC_FALSE, whole = PETSC_TRUE;
  size_t size, length = 0;

  PetscFunctionBegin;
  value[0] = '\0';
  PetscCall(SlipH5OpenAttribute(h, path, attr, &id));
  type = H5Aget_type(id);
  space = H5Aget_space(id);
  if (H5Tget_class(type) == H5T_STRING && H5Sget_simple_extent_npoints(space) == 1 &&
      H5Tget_size(type) <= SLIP_H5_MAX_TEXT) {
    char *raw = NULL;

    mem = SlipH5StringType(type, &variable, &size);
    if (variable)
      PetscCall(SlipH5StringsAreWhole(id, 1, SLIP_H5_MAX_TEXT, &whole));
    else
      PetscCall(PetscCalloc1(size, &raw));
    good = whole && H5Aread(id, mem, variable ? (void *)&raw : (void *)raw) >= 0 ? PETSC_TRUE : PETSC_FALSE;
    if (good) {
      length = raw ? strlen(raw) : 0;
      PetscCall(PetscStrncpy(value, raw ? raw : "", len));
      if (variable) H5Dvlen_reclaim(mem, space, H5P_DEFAULT, &raw);
    }
    if (!variable) PetscCall(PetscFree(raw));
    H5Tclose(mem);
  }
  H5Sclose(space);
  H5Tclose(type);
  H5Aclose(id);
  PetscCheck(whole, PETSC_COMM_SELF, PETSC_ERR_FILE_READ,
             "cannot read attribute %s of %s in %s, expected a string of at most %d bytes: damaged file?%s", attr, path,
             h->name, SLIP_H5_MAX_TEXT, h->source);
  PetscCheck(good, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED, "attribute %s of %s in %s is not one string%s", attr,
             path, h->name, h->source);
  PetscCheck(length < len, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
             "attribute %s of %s in %s has %zu characters, expected fewer than %zu%s", attr, path, h->name, length, len,
             h->source);
  PetscFunctionReturn(PETSC_SUCCESS);
}
