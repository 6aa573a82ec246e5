/* What h5 offers to the other rooms and to the trainer, and not to users */
#pragma once
#include <sliph5.h>

/* How an output file is named and protected. prefix and option name the option that gave the file, restart the one that
   continues an unfinished file, without dashes; each may be NULL. */
typedef struct {
  const char *prefix, *option, *restart;
  const char *discard; /* the option that discards an existing file; NULL: option_overwrite */
  int first;           /* number of rows of a series that precede the run and are no result */
  PetscBool growing;   /* rows will be appended: the file must be readable at any time, and never be lost */
  PetscBool overwrite; /* rows of an existing unfinished file may be overwritten */
  PetscInt block;      /* bytes before those of HDF5, for other content: 0, or a power of two from 512 on */
} SlipH5Kind;

/* Rows of a series: the entries data[0], data[stride], ... */
typedef struct {
  const char *path;
  const PetscReal *data;
  PetscInt stride;
} SlipH5Rows;

/* Names of the dimensions of the datasets of a group, see SlipH5NameDimensions() */
typedef struct {
  const char *row;         /* name of the first dimension; NULL: it has none */
  PetscInt n;              /* number of axes, at most 4 */
  const char *const *axis; /* names of the dimensions after it [n] */
  const char *rest;        /* name of all others; NULL: component */
} SlipH5Axes;

/* How the numbers of a series are stored */
typedef struct {
  PetscBool integer; /* stored as 64-bit integers instead of doubles */
  PetscBool single;  /* stored in single precision */
  PetscInt deflate;  /* level of compression, 1 to 9, with shuffled bytes; 0: none */
} SlipH5Storage;

PETSC_EXTERN PetscErrorCode SlipH5OpenRead(const char file[],
                                           SlipH5 *h); /* PETSC_ERR_FILE_OPEN: missing, truncated or not HDF5 */
/* Collective: raises the errors of opening a file, for objects that read the file of an option later. */
PETSC_EXTERN PetscErrorCode SlipH5CheckRead(MPI_Comm comm, const char prefix[], const char option[], const char file[]);
PETSC_EXTERN PetscErrorCode SlipH5CreateKind(const SlipH5Kind *kind, const char file[], SlipH5 *h);
/* Writes to a copy of `from`, which is renamed to `file` at the end; NULL: copies file.part or, without one, file. */
PETSC_EXTERN PetscErrorCode SlipH5CreateCopy(const SlipH5Kind *kind, const char from[], const char file[], SlipH5 *h);
PETSC_EXTERN PetscErrorCode SlipH5Abandon(SlipH5 *h); /* writing: a live file remains as file.part */
PETSC_EXTERN void SlipH5AbandonAll(void);             /* all that this process writes, before an error ends it */
PETSC_EXTERN PetscErrorCode SlipH5CheckCreateKind(const SlipH5Kind *kind, const char file[]); /* leaves no file */
/* Renames a growing file to file.part once its layout is complete. From then on only rows, values of attributes, and
   attributes of groups of numbers change. */
PETSC_EXTERN PetscErrorCode SlipH5Live(SlipH5 *h);
PETSC_EXTERN PetscErrorCode SlipH5Flush(SlipH5 *h);
PETSC_EXTERN PetscErrorCode SlipH5FlushIsDue(SlipH5 *h, PetscBool *due);
PETSC_EXTERN PetscErrorCode SlipH5Sync(SlipH5 *h); /* flushes, and waits for the disk */
/* Creates a group with its parents; it may exist. numbers: attributes may be added to it after SlipH5Live() */
PETSC_EXTERN PetscErrorCode SlipH5Group(SlipH5 *h, const char path[], PetscBool numbers);
PETSC_EXTERN PetscErrorCode SlipH5RemoveGroup(SlipH5 *h, const char path[]);               /* it need not exist */
PETSC_EXTERN PetscErrorCode SlipH5CountMembers(SlipH5 *h, const char path[], PetscInt *n); /* without axes */
/* Reading allocates *data (free it by PetscFree()). ndim must equal the rank of the dataset (<= 4); dims is returned.
   Any HDF5 number type is converted. */
PETSC_EXTERN PetscErrorCode SlipH5GetRank(SlipH5 *h, const char path[], PetscInt *ndim);
PETSC_EXTERN PetscErrorCode SlipH5GetSize(SlipH5 *h, const char path[], PetscInt dim, PetscInt *size);
PETSC_EXTERN PetscErrorCode SlipH5ReadReal(SlipH5 *h, const char path[], PetscInt ndim, PetscInt dims[],
                                           PetscReal **data);
PETSC_EXTERN PetscErrorCode SlipH5ReadStrings(SlipH5 *h, const char path[], PetscInt *n,
                                              char ***strings); /* free with SlipH5FreeStrings */
PETSC_EXTERN PetscErrorCode SlipH5FreeStrings(PetscInt n, char ***strings);
PETSC_EXTERN PetscErrorCode SlipH5ReadAttrInt(SlipH5 *h, const char path[], const char attr[], PetscInt *value);
PETSC_EXTERN PetscErrorCode SlipH5ReadAttrString(SlipH5 *h, const char path[], const char attr[], char value[],
                                                 size_t len);
/* Checks of input files: errors for names that no code reads, with the nearest valid name, and for unexpected units */
PETSC_EXTERN PetscErrorCode SlipH5CheckNames(SlipH5 *h, const char names[]);
PETSC_EXTERN PetscErrorCode SlipH5CheckMembers(SlipH5 *h, const char group[], const char names[]);
PETSC_EXTERN PetscBool SlipH5MemberName(SlipH5 *h, const char group[], PetscInt k, char name[], size_t len);
PETSC_EXTERN PetscErrorCode SlipH5CheckAttributes(SlipH5 *h, const char path[], const char names[]);
PETSC_EXTERN PetscErrorCode SlipH5CheckUnits(SlipH5 *h, const char path[], const char unit[], PetscBool *has);
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
/* Creates a dataset whose first dimension grows; storage NULL: doubles. A row has prod(dims) entries of PetscReal. ndim
   counts the fixed dimensions (0: a row is a scalar). */
PETSC_EXTERN PetscErrorCode SlipH5CreateSeries(SlipH5 *h, const char path[], PetscInt ndim, const PetscInt dims[],
                                               const SlipH5Storage *storage, const char units[]);
PETSC_EXTERN PetscErrorCode SlipH5GetStorage(SlipH5 *h, const char path[], SlipH5Storage *storage);
PETSC_EXTERN PetscErrorCode SlipH5CreateView(SlipH5 *h, const char path[], const char series[], PetscInt entry,
                                             const char units[]);
PETSC_EXTERN PetscErrorCode SlipH5AppendAll(SlipH5 *h, PetscInt n, const SlipH5Rows series[], PetscInt rows);
PETSC_EXTERN PetscErrorCode SlipH5NameDimensions(SlipH5 *h, const char group[], const SlipH5Axes *axes);
PETSC_EXTERN PetscErrorCode SlipH5MakeDimension(SlipH5 *h, const char path[], PetscInt n);
PETSC_EXTERN PetscErrorCode SlipH5Link(SlipH5 *h, const char path[], const char name[]);
PETSC_EXTERN PetscErrorCode SlipH5AppendZeros(SlipH5 *h, const char path[], PetscInt rows);
PETSC_EXTERN PetscErrorCode SlipH5SetRows(SlipH5 *h, const char path[], PetscInt rows); /* fewer than exist */
/* Initialises a SlipH5 without a file, with the option that messages will name, and silences HDF5's own messages. */
PETSC_INTERN PetscErrorCode SlipH5Clear(const char prefix[], const char option[], SlipH5 *h);
/* Resolves symbolic links of a name, also to a file that does not exist yet. */
PETSC_INTERN PetscErrorCode SlipH5Follow(const char file[], const char source[], char target[PETSC_MAX_PATH_LEN]);
/* Gets the names of the root's attributes, to be freed one by one; more than `most` are an error. */
PETSC_INTERN PetscErrorCode SlipH5GetAttributes(SlipH5 *h, PetscInt most, PetscInt *n, char *names[]);
PETSC_INTERN PetscErrorCode SlipH5IsText(SlipH5 *h, const char path[], const char attr[], PetscBool *text);
