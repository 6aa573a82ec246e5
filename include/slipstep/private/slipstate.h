/* The state of a run in a file: one function per object both writes and reads the data that it needs from one step to
   the next, so that the two directions cannot differ. */
#pragma once
#include <petscvec.h>
#include <slipcompat.h>
#include <slipstep/rooms/slipsys.h>

/* An object with a memory composes this name with a function (object, SlipState), called after a check of its type. */
#define SLIP_STATE_METHOD "SlipState_C"

/* ---- statefile.c: files with a checksum; the previous one is retained as FILE.previous ---- */
PETSC_INTERN PetscErrorCode SlipStateCreate(MPI_Comm comm, const char file[], SlipState *state);
/* source: option that names the file, for messages. A warning is printed if the previous file replaces a damaged
   one. */
PETSC_INTERN PetscErrorCode SlipStateOpen(MPI_Comm comm, const char file[], const char source[], SlipState *state);
PETSC_INTERN PetscErrorCode SlipStateClose(SlipState *state); /* writing: renames the file to its final name */
/* Raises errors that name the option, if the file exists and is no state, or cannot be written. *exists: it exists */
PETSC_INTERN PetscErrorCode SlipStateCheckCreate(MPI_Comm comm, const char prefix[], const char option[],
                                                 const char file[], PetscBool *exists);
/* To be called before vectors of cells whose numbers depend on the number of ranks: order [cells] has their rows in the
   mesh's file. */
PETSC_INTERN PetscErrorCode SlipStateCells(SlipState state, PetscInt cells, const PetscInt order[]);

/* ---- statevisit.c: visiting; numbers and vectors in slipsys.h ---- */
PETSC_INTERN PetscErrorCode SlipStateGroup(SlipState state, const char name[]); /* the following data belong to it */
/* *has: the file has, or will have, such a group */
PETSC_INTERN PetscErrorCode SlipStateHas(SlipState state, const char group[], PetscBool *has);
PETSC_INTERN PetscErrorCode SlipStateHasValue(SlipState state, const char name[], PetscBool *has);
PETSC_INTERN PetscErrorCode SlipStateString(SlipState state, const char name[], char x[], size_t len);
PETSC_INTERN PetscErrorCode SlipStateCount(SlipState state, const char name[], PetscInt most,
                                           PetscInt *n); /* 0 to most */
PETSC_INTERN PetscErrorCode SlipStateProducts(SlipState state, const char name[], SlipProducts *products);
PETSC_INTERN PetscErrorCode SlipStateVecs(SlipState state, const char name[], PetscInt n,
                                          const Vec x[]); /* name_0, ... */
/* *same: the text x is the one that was written, for example a type; otherwise its data are skipped. */
PETSC_INTERN PetscErrorCode SlipStateSame(SlipState state, const char name[], const char x[], PetscBool *same);
/* Visits the data of an object that has a memory, in a group of that name with its type. */
PETSC_INTERN PetscErrorCode SlipStateObject(SlipState state, const char name[], PetscObject object);

/* Inside statevisit.c and statefile.c */
#include <slipstep/rooms/sliph5.h>
struct _n_SlipState {
  MPI_Comm comm;
  PetscMPIInt rank;
  PetscBool loading;
  SlipH5 file;     /* rank 0 */
  char group[64];  /* path of the present group */
  PetscInt cells;  /* number of entries of place */
  PetscInt *place; /* rank 0, loading: present number of each cell of the file; NULL: the same */
};
