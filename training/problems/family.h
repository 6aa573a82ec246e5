/* -train_family: a user's own faults, drawn as a file of options with ranges says. */
#pragma once
#include "common/random.h"
#include <slipstep.h>
#include <slipcompat.h>

enum { FAMILY_MAX_LINES = 48, FAMILY_MAX_CHOICES = 8, FAMILY_NAME = 64 };

/* Fields that vary over a drawn mesh */
enum { DRAW_NORMAL_STRESS = 0, DRAW_FRICTION_SLIP = 3, DRAW_FIELDS = 4 };
PETSC_INTERN const char *const EpisodeFieldNames[DRAW_FIELDS];

/* -fault_NAME, -spread_FIELD or -margin, and what it can be: a number, a range or choices. */
typedef struct {
  char name[FAMILY_NAME]; /* "fault_length_x" */
  PetscReal low, high;    /* of numbers; drawn log-uniformly when both are positive */
  PetscInt nchoices;      /* 0: a number */
  char choice[FAMILY_MAX_CHOICES][FAMILY_NAME];
} FamilyLine;

typedef struct {
  char file[PETSC_MAX_PATH_LEN];
  PetscInt n;
  FamilyLine line[FAMILY_MAX_LINES];
} Family;

/* -train_family between PetscOptionsBegin() and PetscOptionsEnd(), allowed with the problem fault_dial; family:
   a Family, to be freed; NULL without it */
PETSC_INTERN PetscErrorCode FamilyOption(SlipOptionItems PetscOptionsObject, PetscBool allowed, void **family);
/* On every rank. An error names the file, the line and what was expected. */
PETSC_INTERN PetscErrorCode FamilyRead(MPI_Comm comm, const char file[], Family *family);
/* The line of a name; NULL: none */
PETSC_INTERN const FamilyLine *FamilyFind(const Family *family, const char name[]);
PETSC_INTERN PetscReal FamilyDraw(const FamilyLine *line, Random *random);
PETSC_INTERN const char *FamilyChoose(const FamilyLine *line, Random *random);
