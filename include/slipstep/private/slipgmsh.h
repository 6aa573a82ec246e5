/* A .msh file of Gmsh in memory, read sequentially, with numbers as text or in binary. Errors of every function name
   the file, the section and the line, or the byte in binary parts. */
#pragma once
#include <petscsys.h>

typedef struct {
  const char *source; /* beginning of messages */
  char *text;         /* ends with a 0 */
  size_t size, at;    /* length of the file, and position [bytes] */
  PetscBool binary;   /* numbers of sections are binary */
  char section[64];   /* its name, "" between sections */
} SlipGmsh;

PETSC_INTERN PetscErrorCode SlipGmshOpen(const char name[], const char source[], SlipGmsh *g);
PETSC_INTERN PetscErrorCode SlipGmshClose(SlipGmsh *g);
/* Position for messages */
PETSC_INTERN const char *SlipGmshPlace(const SlipGmsh *g, char text[], size_t len);
/* Finds the next section, "" at the end of the file. End requires the end of the section; skip goes to it. */
PETSC_INTERN PetscErrorCode SlipGmshBegin(SlipGmsh *g);
PETSC_INTERN PetscErrorCode SlipGmshEnd(SlipGmsh *g);
PETSC_INTERN PetscErrorCode SlipGmshSkip(SlipGmsh *g);
/* Reads n integers, as text or of 4 or 8 bytes each, or n real numbers. */
PETSC_INTERN PetscErrorCode SlipGmshInts(SlipGmsh *g, PetscInt n, size_t bytes, PetscInt64 number[]);
PETSC_INTERN PetscErrorCode SlipGmshReals(SlipGmsh *g, PetscInt n, PetscReal number[]);
/* Checks that `count` items of at least `bytes` bytes fit into the rest of the file. */
PETSC_INTERN PetscErrorCode SlipGmshFits(const SlipGmsh *g, PetscInt64 count, size_t bytes, const char what[]);
PETSC_INTERN PetscErrorCode SlipGmshLine(SlipGmsh *g); /* goes to the start of the next line */
/* Reads text between quotation marks, cut to len - 1 characters. */
PETSC_INTERN PetscErrorCode SlipGmshQuoted(SlipGmsh *g, char text[], size_t len);
