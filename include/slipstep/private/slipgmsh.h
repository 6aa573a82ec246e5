/* A .msh file of Gmsh in memory, read from its begin to its end, numbers as text or as bytes. Every function says what
   is wrong by the file, the section and the line, or in bytes the place. */
#pragma once
#include <petscsys.h>

typedef struct {
  const char *source; /* what messages begin with */
  char *text;         /* a 0 behind its end */
  size_t size, at;    /* of the file, and where reading is [bytes] */
  PetscBool binary;   /* numbers of sections are bytes */
  char section[64];   /* its name, "" between sections */
} SlipGmsh;

PETSC_INTERN PetscErrorCode SlipGmshOpen(const char name[], const char source[], SlipGmsh *g);
PETSC_INTERN PetscErrorCode SlipGmshClose(SlipGmsh *g);
/* Where reading is, for messages */
PETSC_INTERN const char *SlipGmshPlace(const SlipGmsh *g, char text[], size_t len);
/* The next section, "" at the end of the file; its end, which must follow; all up to its end */
PETSC_INTERN PetscErrorCode SlipGmshBegin(SlipGmsh *g);
PETSC_INTERN PetscErrorCode SlipGmshEnd(SlipGmsh *g);
PETSC_INTERN PetscErrorCode SlipGmshSkip(SlipGmsh *g);
/* n numbers that are whole, as text or of so many bytes each (4 or 8), and real ones */
PETSC_INTERN PetscErrorCode SlipGmshInts(SlipGmsh *g, PetscInt n, size_t bytes, PetscInt64 number[]);
PETSC_INTERN PetscErrorCode SlipGmshReals(SlipGmsh *g, PetscInt n, PetscReal number[]);
/* A number of items of at least so many bytes each that are to follow, and fit into the rest of the file */
PETSC_INTERN PetscErrorCode SlipGmshFits(const SlipGmsh *g, PetscInt64 count, size_t bytes, const char what[]);
PETSC_INTERN PetscErrorCode SlipGmshLine(SlipGmsh *g); /* to the begin of the next line */
/* Text between two quotation marks, cut to len - 1 characters */
PETSC_INTERN PetscErrorCode SlipGmshQuoted(SlipGmsh *g, char text[], size_t len);
