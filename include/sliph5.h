/* Serial HDF5 with errors that name the file and the dataset. Call on one rank only (rank 0) and broadcast. */
#pragma once
#include <petscsys.h>
#include <hdf5.h>

/* A file open for reading or writing, with its name for messages. */
typedef struct {
  hid_t id;
  char name[PETSC_MAX_PATH_LEN];
  char target[PETSC_MAX_PATH_LEN];   /* writing: final name, taken at SlipH5Close(), links resolved; "": reading */
  char source[64];                   /* for messages: " (-option)" that named the file, or "" */
  int fd;                            /* writing: a descriptor of our own, which holds the lock */
  PetscBool live;                    /* writing: it is target.part, which others may read while it grows */
  int failed;                        /* writing: errno of a write that failed, after which there is none; 0 */
  PetscInt64 ahead;                  /* bytes that may be written before the next flush ends */
  PetscInt64 end;                    /* live: length of the file as its superblock says it, 0 before that [bytes] */
  int first;                         /* of SlipH5Kind */
  PetscErrorCode (*last)(void *ctx); /* NULL, or appends rows that are collected, when an error ends the program */
  void *ctx;
  PetscLogDouble flushed, cost; /* when the last flush ended, how long it took [s] */
} SlipH5;

/* How an output file is named and protected: options prefix and option that name it, without dash; the option by which
   an unfinished one is continued. Each may be NULL. */
typedef struct {
  const char *prefix, *option, *restart;
  const char *discard; /* the option by which one that is there is thrown away; NULL: option_overwrite */
  int first;           /* rows of a series from before a run: they are no result */
  PetscBool growing;   /* rows will be appended: it is to be readable all the time, and never lost */
  PetscBool overwrite; /* rows of an unfinished one that is there may go */
  PetscInt block;      /* bytes before those of HDF5, for something else: 0, or a power of two from 512 on */
} SlipH5Kind;

/* Rows for a series: entries data[0], data[stride], ... */
typedef struct {
  const char *path;
  const PetscReal *data;
  PetscInt stride;
} SlipH5Rows;

/* Names of the dimensions of the datasets of a group, see SlipH5NameDimensions() */
typedef struct {
  const char *row;         /* of the first dimension, NULL: none */
  PetscInt n;              /* axes, at most 4 */
  const char *const *axis; /* of those after it [n] */
  const char *rest;        /* of those that remain, NULL: component */
} SlipH5Axes;

/* How the numbers of a series are stored */
typedef struct {
  PetscBool integer; /* 64-bit integers instead of doubles */
  PetscBool single;  /* single precision instead of doubles */
  PetscInt deflate;  /* level of compression, 1 to 9, with bytes shuffled; 0: none */
} SlipH5Storage;

PETSC_EXTERN PetscErrorCode SlipH5OpenRead(const char file[],
                                           SlipH5 *h); /* PETSC_ERR_FILE_OPEN: missing, truncated or not HDF5 */
/* Likewise, and errors name the option that named the file: its prefix, or NULL, and its name without dash. */
PETSC_EXTERN PetscErrorCode SlipH5OpenReadOption(const char prefix[], const char option[], const char file[],
                                                 SlipH5 *h);
/* Collective: errors of opening it; for objects that read the file of an option later */
PETSC_EXTERN PetscErrorCode SlipH5CheckRead(MPI_Comm comm, const char prefix[], const char option[], const char file[]);
PETSC_EXTERN PetscErrorCode SlipH5Create(const char file[], SlipH5 *h); /* opens file.part.new */
PETSC_EXTERN PetscErrorCode SlipH5CreateKind(const SlipH5Kind *kind, const char file[], SlipH5 *h);
/* Writes to a copy of the file from, which takes the name of file at the end; NULL: file.part or, without one, file */
PETSC_EXTERN PetscErrorCode SlipH5CreateCopy(const SlipH5Kind *kind, const char from[], const char file[], SlipH5 *h);
PETSC_EXTERN PetscErrorCode SlipH5Close(SlipH5 *h);   /* writing: renames into place */
PETSC_EXTERN PetscErrorCode SlipH5Abandon(SlipH5 *h); /* writing: what is live stays as file.part */
PETSC_EXTERN void SlipH5AbandonAll(void);             /* that this process writes, before an error ends it */
PETSC_EXTERN PetscErrorCode SlipH5CheckCreate(const char file[]); /* errors of SlipH5Create(), nothing is left */
PETSC_EXTERN PetscErrorCode SlipH5CheckCreateKind(const SlipH5Kind *kind, const char file[]);
/* A growing file whose layout is there becomes file.part: from now on only rows and values of attributes change, and
   attributes of groups made by SlipH5GroupOfNumbers() are added. */
PETSC_EXTERN PetscErrorCode SlipH5Live(SlipH5 *h);
PETSC_EXTERN PetscErrorCode SlipH5Flush(SlipH5 *h);
PETSC_EXTERN PetscErrorCode SlipH5FlushIsDue(SlipH5 *h, PetscBool *due);
PETSC_EXTERN PetscErrorCode SlipH5Sync(SlipH5 *h); /* flush, and wait for the disk */

PETSC_EXTERN PetscErrorCode SlipH5Has(SlipH5 *h, const char path[], PetscBool *has); /* group or dataset */
PETSC_EXTERN PetscErrorCode SlipH5HasAttribute(SlipH5 *h, const char path[], const char attr[], PetscBool *has);
PETSC_EXTERN PetscErrorCode SlipH5Group(SlipH5 *h, const char path[]); /* create, with parents; may exist */
PETSC_EXTERN PetscErrorCode SlipH5GroupOfNumbers(SlipH5 *h, const char path[]);
PETSC_EXTERN PetscErrorCode SlipH5RemoveGroup(SlipH5 *h, const char path[]); /* need not be there */
PETSC_EXTERN PetscErrorCode SlipH5CountMembers(SlipH5 *h, const char path[], PetscInt *n);

/* Reading: allocates *data (PetscFree). ndim must equal rank of the dataset (<= 4); dims returned. Any HDF5 number
   type. */
PETSC_EXTERN PetscErrorCode SlipH5GetRank(SlipH5 *h, const char path[], PetscInt *ndim);
PETSC_EXTERN PetscErrorCode SlipH5GetSize(SlipH5 *h, const char path[], PetscInt dim, PetscInt *size);
PETSC_EXTERN PetscErrorCode SlipH5ReadReal(SlipH5 *h, const char path[], PetscInt ndim, PetscInt dims[],
                                           PetscReal **data);
/* Likewise, where the shape is known: want [ndim], -1 for any size; what: of that shape, for messages, or NULL. */
PETSC_EXTERN PetscErrorCode SlipH5ReadRealSized(SlipH5 *h, const char path[], PetscInt ndim, const PetscInt want[],
                                                const char what[], PetscInt dims[], PetscReal **data);
PETSC_EXTERN PetscErrorCode SlipH5ReadStrings(SlipH5 *h, const char path[], PetscInt *n,
                                              char ***strings); /* free with SlipH5FreeStrings */
PETSC_EXTERN PetscErrorCode SlipH5FreeStrings(PetscInt n, char ***strings);
PETSC_EXTERN PetscErrorCode SlipH5ReadAttrReal(SlipH5 *h, const char path[], const char attr[], PetscReal *value);
PETSC_EXTERN PetscErrorCode SlipH5ReadAttrInt(SlipH5 *h, const char path[], const char attr[], PetscInt *value);
PETSC_EXTERN PetscErrorCode SlipH5ReadAttrString(SlipH5 *h, const char path[], const char attr[], char value[],
                                                 size_t len);

/* Inputs: errors for what nothing reads, with the nearest known name, and for other units than those expected. */
PETSC_EXTERN PetscErrorCode SlipH5CheckNames(SlipH5 *h, const char names[]);
PETSC_EXTERN PetscErrorCode SlipH5CheckAttributes(SlipH5 *h, const char path[], const char names[]);
PETSC_EXTERN PetscErrorCode SlipH5CheckUnits(SlipH5 *h, const char path[], const char unit[], PetscBool *has);

/* Writing. path's parents are created; units may be NULL. */
PETSC_EXTERN PetscErrorCode SlipH5WriteReal(SlipH5 *h, const char path[], PetscInt ndim, const PetscInt dims[],
                                            const PetscReal data[], const char units[]);
PETSC_EXTERN PetscErrorCode SlipH5WriteFloat(SlipH5 *h, const char path[], PetscInt ndim, const PetscInt dims[],
                                             const float data[], const char units[]);
PETSC_EXTERN PetscErrorCode SlipH5WriteInt(SlipH5 *h, const char path[], PetscInt ndim, const PetscInt dims[],
                                           const PetscInt data[], const char units[]);
PETSC_EXTERN PetscErrorCode SlipH5WriteStrings(SlipH5 *h, const char path[], PetscInt n, const char *const strings[]);
PETSC_EXTERN PetscErrorCode SlipH5WriteAttrReal(SlipH5 *h, const char path[], const char attr[], PetscReal value);
PETSC_EXTERN PetscErrorCode SlipH5WriteAttrInt(SlipH5 *h, const char path[], const char attr[], PetscInt value);
PETSC_EXTERN PetscErrorCode SlipH5WriteAttrInts(SlipH5 *h, const char path[], const char attr[], PetscInt n,
                                                const PetscInt values[]);
PETSC_EXTERN PetscErrorCode SlipH5WriteAttrString(SlipH5 *h, const char path[], const char attr[], const char value[]);
/* Extendable datasets: first dimension grows. integer chooses int64 storage, else double; row has prod(dims) entries of
   PetscReal. ndim counts the fixed dimensions (0: a scalar a row). */
PETSC_EXTERN PetscErrorCode SlipH5CreateSeries(SlipH5 *h, const char path[], PetscInt ndim, const PetscInt dims[],
                                               PetscBool integer, const char units[]);
PETSC_EXTERN PetscErrorCode SlipH5CreateStoredSeries(SlipH5 *h, const char path[], PetscInt ndim, const PetscInt dims[],
                                                     const SlipH5Storage *storage, const char units[]);
PETSC_EXTERN PetscErrorCode SlipH5GetStorage(SlipH5 *h, const char path[], SlipH5Storage *storage);
PETSC_EXTERN PetscErrorCode SlipH5CreateView(SlipH5 *h, const char path[], const char series[], PetscInt entry,
                                             const char units[]);
PETSC_EXTERN PetscErrorCode SlipH5Append(SlipH5 *h, const char path[], PetscInt rows, const PetscReal data[]);
PETSC_EXTERN PetscErrorCode SlipH5AppendAll(SlipH5 *h, PetscInt n, const SlipH5Rows series[], PetscInt rows);
PETSC_EXTERN PetscErrorCode SlipH5NameDimensions(SlipH5 *h, const char group[], const SlipH5Axes *axes);
PETSC_EXTERN PetscErrorCode SlipH5CountAxes(SlipH5 *h, const char group[], PetscInt *n);
PETSC_EXTERN PetscErrorCode SlipH5MakeDimension(SlipH5 *h, const char path[], PetscInt n);
PETSC_EXTERN PetscErrorCode SlipH5Link(SlipH5 *h, const char path[], const char name[]);
PETSC_EXTERN PetscErrorCode SlipH5AppendZeros(SlipH5 *h, const char path[], PetscInt rows);
PETSC_EXTERN PetscErrorCode SlipH5SetRows(SlipH5 *h, const char path[], PetscInt rows); /* fewer than there are */
