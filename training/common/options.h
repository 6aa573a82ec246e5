/* Options of programs as rows of a table. */
#pragma once
#include <petscsys.h>
#include <slipcompat.h>
#include <string.h>

/* A number in [low, high], or above low where exclusive; high PETSC_MAX_REAL: no limit. */
typedef struct {
  const char *name, *text; /* text: its help, NULL: the number is checked only */
  PetscInt *integer;       /* the default, and where the number goes: one of the two */
  PetscReal *real;
  PetscReal low, high;
  PetscBool exclusive;
} NumberOption;

#define OPTION_INTEGER(name, text, value, low, high)                                                                   \
  {                                                                                                                    \
    name, text, value, NULL, (PetscReal)(low), (PetscReal)(high), PETSC_FALSE                                          \
  }
#define OPTION_REAL(name, text, value, low, high)                                                                      \
  {                                                                                                                    \
    name, text, NULL, value, low, high, PETSC_FALSE                                                                    \
  }
#define OPTION_COUNT(name, text, value)                                                                                \
  {                                                                                                                    \
    name, text, value, NULL, 0, PETSC_MAX_REAL, PETSC_TRUE                                                             \
  }
#define OPTION_POSITIVE(name, text, value)                                                                             \
  {                                                                                                                    \
    name, text, NULL, value, 0, PETSC_MAX_REAL, PETSC_TRUE                                                             \
  }

/* Adds a piece to a text of so many bytes, cut where it is too long */
#define TextAdd(text, len, ...) PetscSNPrintf((text) + strlen(text), (len)-strlen(text), __VA_ARGS__)
/* Between PetscOptionsBegin() and PetscOptionsEnd() */
PETSC_INTERN PetscErrorCode OptionsNumbers(SlipOptionItems PetscOptionsObject, size_t n, const NumberOption row[]);
/* Which of known, which ends with NULL, value is */
PETSC_INTERN PetscErrorCode OptionFind(const char option[], const char value[], const char *const known[],
                                       PetscInt *index);
/* An option whose value is one of known; index: the default's, and that of the choice */
PETSC_INTERN PetscErrorCode OptionChoice(SlipOptionItems PetscOptionsObject, const char name[], const char text[],
                                         const char *const known[], PetscInt *index);
