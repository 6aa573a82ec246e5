/* Serial HDF5 with errors that name the file and the dataset. Only rank 0 calls it, and broadcasts what it read. */
#pragma once
#include <petscsys.h>
#include <hdf5.h>

/* A file that is open for reading or writing, with its name for messages */
typedef struct {
  hid_t id;
  char name[PETSC_MAX_PATH_LEN];
  char target[PETSC_MAX_PATH_LEN];   /* writing: the final name after SlipH5Close(), with links resolved; "": reading */
  char source[64];                   /* for messages: " (-option)" that named the file, or "" */
  int fd;                            /* writing: a separate descriptor, which holds the lock */
  PetscBool live;                    /* writing: the file is target.part, which others may read while it grows */
  int failed;                        /* writing: errno of a failed write, after which none follows; else 0 */
  PetscInt64 ahead;                  /* bytes that may be written before the next flush ends */
  PetscInt64 end;                    /* live: length of the file by its superblock, 0 before that [bytes] */
  int first;                         /* that of SlipH5Kind */
  PetscErrorCode (*last)(void *ctx); /* NULL, or a function that appends collected rows if an error ends the program */
  void *ctx;
  PetscLogDouble flushed, cost; /* time of the last flush and its duration [s] */
} SlipH5;

/* Opens likewise; errors name the option that gave the file: its prefix, or NULL, and its name without dash. */
PETSC_EXTERN PetscErrorCode SlipH5OpenReadOption(const char prefix[], const char option[], const char file[],
                                                 SlipH5 *h);
/* Collective: raises the errors of opening a file, for objects that read the file of an option later. */
PETSC_EXTERN PetscErrorCode SlipH5Create(const char file[], SlipH5 *h); /* opens file.part.new */
/* Writes to a copy of `from`, which is renamed to `file` at the end; NULL: copies file.part or, without one, file. */
PETSC_EXTERN PetscErrorCode SlipH5Close(SlipH5 *h); /* writing: renames to the final name */

PETSC_EXTERN PetscErrorCode SlipH5Has(SlipH5 *h, const char path[], PetscBool *has); /* group or dataset */
PETSC_EXTERN PetscErrorCode SlipH5HasAttribute(SlipH5 *h, const char path[], const char attr[], PetscBool *has);

/* Reads a dataset of known shape: want [ndim], -1 for any size; what: what has that shape, for messages, or NULL. */
PETSC_EXTERN PetscErrorCode SlipH5ReadRealSized(SlipH5 *h, const char path[], PetscInt ndim, const PetscInt want[],
                                                const char what[], PetscInt dims[], PetscReal **data);
PETSC_EXTERN PetscErrorCode SlipH5ReadAttrReal(SlipH5 *h, const char path[], const char attr[], PetscReal *value);

/* Writing creates the parents of path; units may be NULL. */
PETSC_EXTERN PetscErrorCode SlipH5WriteReal(SlipH5 *h, const char path[], PetscInt ndim, const PetscInt dims[],
                                            const PetscReal data[], const char units[]);
