/* Writes datasets and growing series to HDF5 files. */
#include <slipstep/private/sliph5.h>
#include <string.h>

#define SLIP_H5_CHUNK 65536   /* wanted size of a series' chunk [bytes] */
#define SLIP_H5_MAX_CHUNK 256 /* largest number of rows per chunk */
#define SLIP_H5_CACHE 1048576 /* size of HDF5's default cache of a dataset's chunks [bytes] */

/* Creates a dataset and its parent groups. */
static hid_t SlipH5Dataset(SlipH5 *h, const char path[], hid_t type, hid_t space, hid_t dcpl)
{
  const hid_t lcpl = H5Pcreate(H5P_LINK_CREATE);
  hid_t set;

  H5Pset_create_intermediate_group(lcpl, 1);
  set = H5Dcreate2(h->id, path, type, space, lcpl, dcpl, H5P_DEFAULT);
  H5Pclose(lcpl);
  return set;
}

static PetscErrorCode SlipH5Write(SlipH5 *h, const char path[], PetscInt ndim, const PetscInt dims[], hid_t file_type,
                                  hid_t mem_type, const void *data, const char units[])
{
  hsize_t shape[SLIP_H5_MAX_DIM] = {0}, n = 1;
  hid_t space, set;
  herr_t err = -1;
  int reason;

  PetscFunctionBegin;
  PetscCheck(ndim >= 0 && ndim <= SLIP_H5_MAX_DIM, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
             "%" PetscInt_FMT " dimensions, expected 0 to %d", ndim, SLIP_H5_MAX_DIM);
  for (PetscInt d = 0; d < ndim; d++) n *= shape[d] = (hsize_t)dims[d];
  reason = SlipH5MakeRoom(h, (PetscInt64)(n * H5Tget_size(file_type)));
  if (reason) PetscCall(SlipH5WriteFailed(h, reason, "dataset %s to %s", path, h->name));
  space = ndim ? H5Screate_simple((int)ndim, shape, NULL) : H5Screate(H5S_SCALAR);
  set = SlipH5Dataset(h, path, file_type, space, H5P_DEFAULT);
  H5Sclose(space);
  PetscCheck(set >= 0 || h->failed, PETSC_COMM_SELF, PETSC_ERR_FILE_WRITE, "cannot write dataset %s to %s", path,
             h->name);
  if (set >= 0) err = n ? H5Dwrite(set, mem_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data) : 0;
  if (set >= 0 && H5Dclose(set) < 0) err = -1;
  if (err < 0 || h->failed) PetscCall(SlipH5WriteFailed(h, 0, "dataset %s to %s", path, h->name));
  if (units) PetscCall(SlipH5WriteAttrString(h, path, "units", units));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipH5WritePiece(SlipH5 *h, const char path[], PetscInt N, PetscInt start, PetscInt n,
                                const PetscReal data[])
{
  const hsize_t size = (hsize_t)N, first = (hsize_t)start, count = (hsize_t)n;
  const int reason = start ? 0 : SlipH5MakeRoom(h, (PetscInt64)(size * sizeof(PetscReal)));
  hid_t space, memory, set;
  herr_t err;

  PetscFunctionBegin;
  if (reason) PetscCall(SlipH5WriteFailed(h, reason, "dataset %s to %s", path, h->name));
  space = H5Screate_simple(1, &size, NULL);
  set = start ? H5Dopen2(h->id, path, H5P_DEFAULT) : SlipH5Dataset(h, path, H5T_IEEE_F64LE, space, H5P_DEFAULT);
  memory = H5Screate_simple(1, &count, NULL);
  err = H5Sselect_hyperslab(space, H5S_SELECT_SET, &first, NULL, &count, NULL);
  if (err >= 0) err = H5Dwrite(set, H5T_NATIVE_DOUBLE, memory, space, H5P_DEFAULT, data);
  H5Sclose(memory);
  H5Sclose(space);
  if (set >= 0 && H5Dclose(set) < 0) err = -1;
  if (err < 0 || h->failed) PetscCall(SlipH5WriteFailed(h, 0, "dataset %s to %s", path, h->name));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipH5WriteReal - writes an array of real numbers as a new dataset of doubles

  Not collective.

  Input Parameters:
+ h     - file
. path  - dataset, whose parents are created
. ndim  - number of dimensions, 0 to 4
. dims  - shape [ndim]
. data  - values, row-major, in the units below
- units - attribute "units", or NULL

  Level: developer

  Errors: PETSC_ERR_FILE_WRITE when the path exists or the disk is full.

.seealso: SlipH5WriteFloat(), SlipH5WriteInt(), SlipH5CreateSeries()
@*/
PetscErrorCode SlipH5WriteReal(SlipH5 *h, const char path[], PetscInt ndim, const PetscInt dims[],
                               const PetscReal data[], const char units[])
{
  PetscFunctionBegin;
  PetscCall(SlipH5Write(h, path, ndim, dims, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, data, units));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes an array in single precision; see SlipH5WriteReal(). */
PetscErrorCode SlipH5WriteFloat(SlipH5 *h, const char path[], PetscInt ndim, const PetscInt dims[], const float data[],
                                const char units[])
{
  PetscFunctionBegin;
  PetscCall(SlipH5Write(h, path, ndim, dims, H5T_IEEE_F32LE, H5T_NATIVE_FLOAT, data, units));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes an array of integers, stored in 64 bits; see SlipH5WriteReal(). data: integers, row-major, whatever width
   PetscInt has. */
PetscErrorCode SlipH5WriteInt(SlipH5 *h, const char path[], PetscInt ndim, const PetscInt dims[], const PetscInt data[],
                              const char units[])
{
  PetscFunctionBegin;
  PetscCall(SlipH5Write(h, path, ndim, dims, H5T_STD_I64LE, SlipH5PetscInt(), data, units));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes a list of strings (variable length, UTF-8). path: dataset, whose parents are created. */
PetscErrorCode SlipH5WriteStrings(SlipH5 *h, const char path[], PetscInt n, const char *const strings[])
{
  const hid_t type = H5Tcopy(H5T_C_S1);
  PetscErrorCode ierr;

  PetscFunctionBegin;
  H5Tset_size(type, H5T_VARIABLE);
  H5Tset_cset(type, H5T_CSET_UTF8);
  ierr = SlipH5Write(h, path, 1, &n, type, type, strings, NULL);
  H5Tclose(type);
  PetscCall(ierr);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates a dataset whose first dimension grows by SlipH5AppendAll(). path: dataset, whose parents are created; ndim:
   number of fixed dimensions, 0 (a row is one number) to 3; dims: the fixed dimensions [ndim]; storage: type of the
   numbers, and whether they are compressed, NULL for doubles; units: attribute "units", or NULL. A compressed chunk has
   one row, so that it is written once: another row would change its compressed size and move it, and a file that is
   read while it grows cannot reuse the old place. A chunk is not larger than HDF5's cache, for readers of a part.
   Errors: PETSC_ERR_ARG_OUTOFRANGE for another number of dimensions or a dimension of length 0, PETSC_ERR_SUP when this
   HDF5 cannot compress, PETSC_ERR_FILE_WRITE if the path exists or cannot be written. */
PetscErrorCode SlipH5CreateSeries(SlipH5 *h, const char path[], PetscInt ndim, const PetscInt dims[],
                                  const SlipH5Storage *storage, const char units[])
{
  const PetscBool integer = storage && storage->integer, single = storage && storage->single;
  const PetscInt deflate = storage ? storage->deflate : 0;
  const hid_t type = integer ? H5T_STD_I64LE : single ? H5T_IEEE_F32LE : H5T_IEEE_F64LE;
  hsize_t shape[SLIP_H5_MAX_DIM] = {0}, limit[SLIP_H5_MAX_DIM], chunk[SLIP_H5_MAX_DIM], row = 1, bytes;
  hid_t space, dcpl, set;

  PetscFunctionBegin;
  PetscCheck(ndim >= 0 && ndim < SLIP_H5_MAX_DIM, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
             "%" PetscInt_FMT " fixed dimensions, expected 0 to %d", ndim, SLIP_H5_MAX_DIM - 1);
  for (PetscInt d = 0; d < ndim; d++) row *= shape[d + 1] = limit[d + 1] = chunk[d + 1] = (hsize_t)dims[d];
  PetscCheck(row > 0, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE, "a fixed dimension of %s is zero", path);
  PetscCheck(!deflate || H5Zfilter_avail(H5Z_FILTER_DEFLATE) > 0, PETSC_COMM_SELF, PETSC_ERR_SUP,
             "%s cannot be compressed: this HDF5 has no zlib", path);
  limit[0] = H5S_UNLIMITED;
  bytes = row * H5Tget_size(type);
  chunk[0] = deflate ? 1 : PetscMax(1, PetscMin(SLIP_H5_MAX_CHUNK, SLIP_H5_CHUNK / bytes));
  if (deflate && ndim && bytes > SLIP_H5_CACHE) chunk[1] = PetscMax(1, SLIP_H5_CACHE / (bytes / chunk[1]));
  space = H5Screate_simple((int)ndim + 1, shape, limit);
  dcpl = H5Pcreate(H5P_DATASET_CREATE);
  H5Pset_chunk(dcpl, (int)ndim + 1, chunk);
  if (deflate) {
    H5Pset_shuffle(dcpl);
    H5Pset_deflate(dcpl, (unsigned)deflate);
  }
  set = SlipH5Dataset(h, path, type, space, dcpl);
  H5Pclose(dcpl);
  H5Sclose(space);
  PetscCheck(set >= 0, PETSC_COMM_SELF, PETSC_ERR_FILE_WRITE, "cannot create dataset %s in %s", path, h->name);
  PetscCheck(H5Dclose(set) >= 0, PETSC_COMM_SELF, PETSC_ERR_FILE_WRITE, "cannot create dataset %s in %s", path,
             h->name);
  if (units) PetscCall(SlipH5WriteAttrString(h, path, "units", units));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets how the numbers of a dataset are stored. storage: see SlipH5CreateSeries(). Errors:
   PETSC_ERR_FILE_UNEXPECTED when there is no such dataset. */
PetscErrorCode SlipH5GetStorage(SlipH5 *h, const char path[], SlipH5Storage *storage)
{
  const hid_t set = H5Dopen2(h->id, path, H5P_DEFAULT);
  unsigned level[1] = {0}, flags;
  size_t n = 1;
  hid_t type, dcpl;

  PetscFunctionBegin;
  PetscCheck(set >= 0, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED, "%s has no dataset %s%s", h->name, path, h->source);
  type = H5Dget_type(set);
  dcpl = H5Dget_create_plist(set);
  storage->integer = H5Tget_class(type) == H5T_INTEGER ? PETSC_TRUE : PETSC_FALSE;
  storage->single = !storage->integer && H5Tget_size(type) == sizeof(float) ? PETSC_TRUE : PETSC_FALSE;
  for (int i = 0; i < H5Pget_nfilters(dcpl); i++) {
    n = 1;
    if (H5Pget_filter2(dcpl, (unsigned)i, &flags, &n, level, 0, NULL, NULL) == H5Z_FILTER_DEFLATE) break;
    level[0] = 0;
  }
  storage->deflate = (PetscInt)level[0];
  H5Pclose(dcpl);
  H5Tclose(type);
  H5Dclose(set);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Opens a series, and gets its shape and that of its chunks. */
static PetscErrorCode SlipH5OpenSeries(SlipH5 *h, const char path[], hid_t *set, int *rank, hsize_t shape[],
                                       hsize_t chunk[])
{
  hid_t space, dcpl;

  PetscFunctionBegin;
  *set = H5Dopen2(h->id, path, H5P_DEFAULT);
  PetscCheck(*set >= 0, PETSC_COMM_SELF, PETSC_ERR_FILE_WRITE, "no dataset %s in %s to append to", path, h->name);
  space = H5Dget_space(*set);
  dcpl = H5Dget_create_plist(*set);
  *rank = H5Sget_simple_extent_ndims(space);
  if (*rank < 1 || *rank > SLIP_H5_MAX_DIM || H5Pget_chunk(dcpl, *rank, chunk) != *rank ||
      H5Sget_simple_extent_dims(space, shape, NULL) != *rank)
    *rank = -1;
  H5Pclose(dcpl);
  H5Sclose(space);
  if (*rank < 0) H5Dclose(*set);
  PetscCheck(*rank >= 0, PETSC_COMM_SELF, PETSC_ERR_FILE_WRITE, "%s in %s is no series", path, h->name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Appends rows. Numbers with a stride are first copied to contiguous memory: HDF5 would copy them one by one. */
static herr_t SlipH5AppendRows(hid_t set, int rank, hsize_t shape[], hsize_t rows, const SlipH5Rows *series)
{
  const size_t stride = (size_t)series->stride;
  hsize_t start[SLIP_H5_MAX_DIM] = {0}, count[SLIP_H5_MAX_DIM], n = rows;
  double *together = NULL;
  hid_t space, mem;
  herr_t err;

  for (int d = 0; d < rank; d++) count[d] = shape[d];
  for (int d = 1; d < rank; d++) n *= shape[d];
  count[0] = rows;
  start[0] = shape[0];
  shape[0] += rows;
  if (stride != 1 && !(together = malloc((size_t)n * sizeof(*together)))) return -1;
  for (size_t i = 0; i < (size_t)n && together; i++) together[i] = series->data[stride * i];
  if (H5Dset_extent(set, shape) < 0) {
    free(together);
    return -1;
  }
  space = H5Dget_space(set);
  mem = H5Screate_simple(1, &n, NULL);
  err = H5Sselect_hyperslab(space, H5S_SELECT_SET, start, NULL, count, NULL);
  if (err >= 0) err = H5Dwrite(set, H5T_NATIVE_DOUBLE, mem, space, H5P_DEFAULT, together ? together : series->data);
  if (H5Sclose(mem) < 0 || H5Sclose(space) < 0) err = -1;
  free(together);
  return err;
}

/* Appends rows to several series: to all of them or, if the disk is full, to none. series: made by
   SlipH5CreateSeries(), each with its rows: rows times the product of its fixed dimensions, row-major, in its units.
   Errors: PETSC_ERR_FILE_WRITE if a series does not exist or the rows cannot be written: the file is then closed, with
   the rows before them. */
PetscErrorCode SlipH5AppendAll(SlipH5 *h, PetscInt n, const SlipH5Rows series[], PetscInt rows)
{
  struct {
    hid_t set;
    int rank;
    hsize_t shape[SLIP_H5_MAX_DIM];
  } * open;
  hsize_t chunk[SLIP_H5_MAX_DIM], row;
  PetscInt64 room = 0;
  PetscInt i, last;
  herr_t err = 0;
  int reason;

  PetscFunctionBegin;
  if (rows <= 0 || n <= 0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(n, &open));
  for (i = 0; i < n; i++) {
    hsize_t *shape = open[i].shape, bytes = sizeof(PetscReal), chunks, parts = 1;

    PetscCall(SlipH5OpenSeries(h, series[i].path, &open[i].set, &open[i].rank, shape, chunk));
    for (int d = 0; d < open[i].rank; d++) bytes *= chunk[d];
    for (int d = 1; d < open[i].rank; d++) parts *= (shape[d] + chunk[d] - 1) / chunk[d];
    chunks = (shape[0] + (hsize_t)rows + chunk[0] - 1) / chunk[0] - (shape[0] + chunk[0] - 1) / chunk[0];
    /* space for the index, whose blocks grow as the square root of the number of chunks; compression never takes more,
       as HDF5 does not compress chunks that would grow */
    if (chunks)
      room += (PetscInt64)(chunks * parts * (bytes + 64)) + 512 +
              64 * (PetscInt64)PetscSqrtReal((PetscReal)(parts * (shape[0] / chunk[0])));
  }
  last = 0;
  row = open[0].shape[0];
  reason = SlipH5MakeRoom(h, room);
  for (i = 0; i < n; i++) { /* every series is closed, also after a failure */
    if (!reason && err >= 0 && !h->failed) {
      last = i;
      row = open[i].shape[0];
      err = SlipH5AppendRows(open[i].set, open[i].rank, open[i].shape, (hsize_t)rows, &series[i]);
    }
    if (H5Dclose(open[i].set) < 0) err = -1;
  }
  PetscCall(PetscFree(open));
  if (reason || err < 0 || h->failed)
    PetscCall(
      SlipH5WriteFailed(h, reason, "row %llu of %s to %s", (unsigned long long)row, series[last].path, h->name));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Appends rows of zeros to a new series without writing them; the file must not be live. path: dataset made by
   SlipH5CreateSeries(), without rows. Errors: PETSC_ERR_FILE_WRITE when there is no such series. */
PetscErrorCode SlipH5AppendZeros(SlipH5 *h, const char path[], PetscInt rows)
{
  hsize_t shape[SLIP_H5_MAX_DIM], chunk[SLIP_H5_MAX_DIM];
  hid_t set;
  herr_t err = 0;
  int rank;

  PetscFunctionBegin;
  PetscCall(SlipH5OpenSeries(h, path, &set, &rank, shape, chunk));
  shape[0] = (hsize_t)PetscMax(rows, 0);
  if (rows > 0) err = H5Dset_extent(set, shape); /* the fill value of HDF5 is 0 */
  if (H5Dclose(set) < 0) err = -1;
  if (err < 0 || h->failed) PetscCall(SlipH5WriteFailed(h, 0, "%s to %s", path, h->name));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Truncates a series; the file must not be live. path: dataset made by SlipH5CreateSeries(); rows: number of remaining
   rows, at most the present number. Errors: PETSC_ERR_FILE_WRITE when there is no such series,
   PETSC_ERR_FILE_UNEXPECTED when it has fewer rows. */
PetscErrorCode SlipH5SetRows(SlipH5 *h, const char path[], PetscInt rows)
{
  hsize_t shape[SLIP_H5_MAX_DIM], chunk[SLIP_H5_MAX_DIM], found;
  hid_t set;
  herr_t err = 0;
  int rank;

  PetscFunctionBegin;
  PetscCall(SlipH5OpenSeries(h, path, &set, &rank, shape, chunk));
  found = shape[0];
  shape[0] = (hsize_t)rows;
  if (found > shape[0]) err = H5Dset_extent(set, shape);
  if (H5Dclose(set) < 0) err = -1;
  PetscCheck(found >= shape[0], PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
             "%s in %s has %llu rows, expected %" PetscInt_FMT " or more%s", path, h->name, (unsigned long long)found,
             rows, h->source);
  if (err < 0 || h->failed) PetscCall(SlipH5WriteFailed(h, 0, "%s to %s", path, h->name));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates a dataset that shows one entry of each row of a series of vectors. path: of the dataset, [rows, 3], whose
   group exists; it has as many rows as the series, also while that grows; series: path of an existing series [rows,
   entries, 3]. Programs with HDF5 1.10 or later read it as any other dataset. It takes about 500 bytes. Errors:
   PETSC_ERR_FILE_WRITE when there is no such series, the path exists or cannot be written. */
PetscErrorCode SlipH5CreateView(SlipH5 *h, const char path[], const char series[], PetscInt entry, const char units[])
{
  const hsize_t grows = H5S_UNLIMITED, none[3] = {0, 0, 0}, from[3] = {0, (hsize_t)entry, 0}, rows[3] = {grows, 1, 1},
                inner[2] = {1, 3}, outer[3] = {1, 1, 3}, limit[2] = {grows, 3}, empty[2] = {0, 3};
  const hid_t all = H5Dopen2(h->id, series, H5P_DEFAULT), source = all < 0 ? -1 : H5Dget_space(all),
              space = H5Screate_simple(2, empty, limit), dcpl = H5Pcreate(H5P_DATASET_CREATE);
  hid_t set = -1;

  PetscFunctionBegin;
  if (source >= 0 && H5Sget_simple_extent_ndims(source) == 3 &&
      H5Sselect_hyperslab(space, H5S_SELECT_SET, none, NULL, rows, inner) >= 0 &&
      H5Sselect_hyperslab(source, H5S_SELECT_SET, from, NULL, rows, outer) >= 0 &&
      H5Pset_virtual(dcpl, space, ".", series, source) >= 0)
    set = H5Dcreate2(h->id, path, H5T_IEEE_F64LE, space, H5P_DEFAULT, dcpl, H5P_DEFAULT);
  H5Pclose(dcpl);
  H5Sclose(space);
  if (source >= 0) H5Sclose(source);
  if (all >= 0) H5Dclose(all);
  if (set < 0 || H5Dclose(set) < 0) PetscCall(SlipH5WriteFailed(h, 0, "dataset %s to %s", path, h->name));
  PetscCall(SlipH5WriteAttrString(h, path, "units", units));
  PetscFunctionReturn(PETSC_SUCCESS);
}
