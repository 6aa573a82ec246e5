/* -train_family: a user's own faults, drawn as a file of options with ranges says. */
#pragma once
#include "common/random.h"
#include <slipstep/rooms.h>
#include <slipcompat.h>

enum { FAMILY_MAX_LINES = 64, FAMILY_MAX_CHOICES = 8, FAMILY_NAME = 64, FAMILY_WORD = 256, FAMILY_TRIES = 50 };

/* Fields that vary over a drawn mesh of faults that begin at their instability */
enum { DRAW_NORMAL_STRESS = 0, DRAW_FRICTION_SLIP = 3, DRAW_FIELDS = 4 };
PETSC_INTERN const char *const EpisodeFieldNames[DRAW_FIELDS];

/* -fault_NAME, -spread_FIELD or a name of the table in family.c, and what it can be: a number, a range or choices; a
   switch without value has the choice "yes". */
typedef struct {
  char name[FAMILY_NAME]; /* "fault_length_x" */
  PetscInt number;        /* of the line in the file, from 1 */
  PetscReal low, high;    /* of numbers; drawn log-uniformly when both are positive */
  PetscInt nchoices;      /* 0: a number */
  char choice[FAMILY_MAX_CHOICES][FAMILY_WORD];
} FamilyLine;

typedef struct {
  char file[PETSC_MAX_PATH_LEN];
  const char *problem, *describes; /* -train_problem of the runs it describes, and what these are */
  PetscBool stress;                /* its faults begin under a given stress, not at their instability */
  PetscInt n;
  FamilyLine line[FAMILY_MAX_LINES];
} Family;

/* -train_family between PetscOptionsBegin() and PetscOptionsEnd(); family: to be freed; NULL without it */
PETSC_INTERN PetscErrorCode FamilyOption(SlipOptionItems PetscOptionsObject, Family **family);
/* On every rank. An error names the file, the line, the option and what was expected. */
PETSC_INTERN PetscErrorCode FamilyRead(MPI_Comm comm, const char file[], Family *family);
/* The line of a name; NULL: none */
PETSC_INTERN const FamilyLine *FamilyFind(const Family *family, const char name[]);
PETSC_INTERN PetscReal FamilyDraw(const FamilyLine *line, Random *random);
/* The number of a line; without one other */
PETSC_INTERN PetscReal FamilyNumber(const Family *family, const char name[], PetscReal other, Random *random);
PETSC_INTERN const char *FamilyChoose(const FamilyLine *line, Random *random);
/* A switch by yes or no, or a choice of the fault, by its name without "fault_" */
PETSC_INTERN PetscErrorCode FamilySetWord(SlipFault fault, const char name[], const char word[]);
