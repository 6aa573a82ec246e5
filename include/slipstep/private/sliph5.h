/* HDF5 files inside of sys: what h5*.c, statefile.c and statevisit.c share */
#pragma once
#include <slipcompat.h>
#include <slipstep/rooms/sliph5.h>

#define SLIP_H5_MAX_DIM 4 /* dimensions of a dataset */

/* HDF5's type of a PetscInt in memory */
static inline hid_t SlipH5PetscInt(void)
{
  return sizeof(PetscInt) == 8 ? H5T_NATIVE_INT64 : H5T_NATIVE_INT32;
}

/* ---- h5file.c ---- */
PETSC_INTERN PetscErrorCode SlipH5CheckNoInput(const char file[], const char source[]);
/* Raises the error of a write and closes the file. reason: errno of a call of ours, while HDF5 is intact; 0: HDF5 has
   failed, or its driver */
PETSC_INTERN PetscErrorCode SlipH5WriteFailed(SlipH5 *h, int reason, const char format[], ...)
  PETSC_ATTRIBUTE_FORMAT(3, 4);
PETSC_INTERN SlipH5 *SlipH5Written(int i);                  /* the i-th file that this process writes, or NULL */
PETSC_INTERN PetscErrorCode SlipH5Enlist(SlipH5 *h);        /* until it is released */
PETSC_INTERN void SlipH5Release(SlipH5 *h, PetscBool keep); /* closes the descriptor, removes the file unless keep */
PETSC_INTERN int SlipH5CloseId(SlipH5 *h);                  /* 0, or errno */
PETSC_INTERN void SlipH5SetDriver(hid_t access);
PETSC_INTERN int SlipH5MakeRoom(SlipH5 *h, PetscInt64 bytes); /* 0, or errno */

/* ---- h5output.c ---- */
/* The two halves of SlipH5Close() for a file that was written, with other work in between */
PETSC_INTERN PetscErrorCode SlipH5CloseBeside(SlipH5 *h);
PETSC_INTERN PetscErrorCode SlipH5PutInPlace(SlipH5 *h);

/* ---- h5write.c, h5read.c: entries start to start + n of a dataset of N numbers, which the first write creates ---- */
PETSC_INTERN PetscErrorCode SlipH5WritePiece(SlipH5 *h, const char path[], PetscInt N, PetscInt start, PetscInt n,
                                             const PetscReal data[]);
PETSC_INTERN PetscErrorCode SlipH5ReadPiece(SlipH5 *h, const char path[], PetscInt N, PetscInt start, PetscInt n,
                                            PetscReal data[]);
