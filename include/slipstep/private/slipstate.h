/* The state of a run in a file: what objects remember from one step to the next, written and read by one function each,
   so that the two directions cannot differ. */
#pragma once
#include <petscvec.h>
#include <slipcompat.h>
#include <slipsys.h>

/* An object that has a memory composes this with a function (object, SlipState); the object's type is checked
   before. */
#define SLIP_STATE_METHOD "SlipState_C"

/* ---- statefile.c: files with a checksum, of which the one before is kept as FILE.previous ---- */
PETSC_INTERN PetscErrorCode SlipStateCreate(MPI_Comm comm, const char file[], SlipState *state);
/* source: option that names the file, for messages. A damaged or missing file gives way to the one before, with a
   warning. */
PETSC_INTERN PetscErrorCode SlipStateOpen(MPI_Comm comm, const char file[], const char source[], SlipState *state);
PETSC_INTERN PetscErrorCode SlipStateClose(SlipState *state); /* writing: puts the file in its place */
/* Errors, which name the option, when the file is there and is no state, or cannot be written. *exists: it is there */
PETSC_INTERN PetscErrorCode SlipStateCheckCreate(MPI_Comm comm, const char prefix[], const char option[],
                                                 const char file[], PetscBool *exists);
/* Before vectors of cells whose numbers depend on the number of ranks: order [cells] are their rows in the mesh's
   file */
PETSC_INTERN PetscErrorCode SlipStateCells(SlipState state, PetscInt cells, const PetscInt order[]);

/* ---- statevisit.c: visiting; numbers and vectors in slipsys.h ---- */
PETSC_INTERN PetscErrorCode SlipStateGroup(SlipState state, const char name[]); /* what follows belongs to it */
/* *has: the file has, or is to have, such a group */
PETSC_INTERN PetscErrorCode SlipStateHas(SlipState state, const char group[], PetscBool *has);
PETSC_INTERN PetscErrorCode SlipStateHasValue(SlipState state, const char name[], PetscBool *has);
PETSC_INTERN PetscErrorCode SlipStateString(SlipState state, const char name[], char x[], size_t len);
PETSC_INTERN PetscErrorCode SlipStateCount(SlipState state, const char name[], PetscInt most,
                                           PetscInt *n); /* 0 to most */
PETSC_INTERN PetscErrorCode SlipStateProducts(SlipState state, const char name[], SlipProducts *products);
PETSC_INTERN PetscErrorCode SlipStateVecs(SlipState state, const char name[], PetscInt n,
                                          const Vec x[]); /* name_0, ... */
/* *same: what is visited now is what was written, as x says. Its type, for example; what differs is left out. */
PETSC_INTERN PetscErrorCode SlipStateSame(SlipState state, const char name[], const char x[], PetscBool *same);
/* What the object remembers, if it does, in a group of that name with its type. */
PETSC_INTERN PetscErrorCode SlipStateObject(SlipState state, const char name[], PetscObject object);

/* Inside statevisit.c and statefile.c */
#include <sliph5.h>
struct _n_SlipState {
  MPI_Comm comm;
  PetscMPIInt rank;
  PetscBool loading;
  SlipH5 file;     /* rank 0 */
  char group[64];  /* path of what is being visited */
  PetscInt cells;  /* of place */
  PetscInt *place; /* rank 0, loading: cell of now for each cell of the file; NULL: the same */
};
