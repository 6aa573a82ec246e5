/* Options as rows of a table, see options.h. */
#include "options.h"
#include <slipstep/rooms/slipsys.h>

PetscErrorCode OptionsNumbers(SlipOptionItems PetscOptionsObject, size_t n, const NumberOption row[])
{
  PetscFunctionBegin;
  for (size_t i = 0; i < n; ++i) {
    const NumberOption *o = &row[i];
    char limit[32] = "";
    PetscBool given = PETSC_FALSE;
    PetscReal x;

    /* before PETSc reads it, whose own message about NaN names no option from 3.22 on */
    if (o->text)
      PetscCall(SlipCheckNumberOption(PETSC_COMM_WORLD, NULL, NULL, o->name, o->integer ? PETSC_TRUE : PETSC_FALSE,
                                      &given, &x));
    if (!given) x = o->integer ? (PetscReal)*o->integer : *o->real;
    PetscCheck(!o->exclusive || (x > o->low && !PetscIsInfReal(x)), PETSC_COMM_WORLD, PETSC_ERR_ARG_OUTOFRANGE,
               "%s is %.6g, expected a number > %.6g", o->name, (double)x, (double)o->low);
    if (o->high < PETSC_MAX_REAL) (void)snprintf(limit, sizeof(limit), " and <= %.6g", (double)o->high);
    PetscCheck(x >= o->low && x <= o->high, PETSC_COMM_WORLD, PETSC_ERR_ARG_OUTOFRANGE,
               "%s is %.6g, expected a number >= %.6g%s", o->name, (double)x, (double)o->low, limit);
    if (!o->text) continue;
    if (o->integer)
      PetscCall(PetscOptionsInt(o->name, o->text, NULL, *o->integer, o->integer, NULL));
    else
      PetscCall(PetscOptionsReal(o->name, o->text, NULL, *o->real, o->real, NULL));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode OptionFind(const char option[], const char value[], const char *const known[], PetscInt *index)
{
  char list[256] = "";
  PetscBool same;

  PetscFunctionBegin;
  for (PetscInt i = 0; known[i]; ++i) {
    *index = i;
    PetscCall(PetscStrcmp(value, known[i], &same));
    if (same) PetscFunctionReturn(PETSC_SUCCESS);
    PetscCall(TextAdd(list, sizeof(list), " %s", known[i]));
  }
  SETERRQ(PETSC_COMM_WORLD, PETSC_ERR_ARG_UNKNOWN_TYPE, "%s %s does not exist; expected one of:%s", option, value,
          list);
}

PetscErrorCode OptionChoice(SlipOptionItems PetscOptionsObject, const char name[], const char text[],
                            const char *const known[], PetscInt *index)
{
  char value[64];

  PetscFunctionBegin;
  PetscCall(PetscStrncpy(value, known[*index], sizeof(value)));
  PetscCall(PetscOptionsString(name, text, NULL, value, value, sizeof(value), NULL));
  PetscCall(OptionFind(name, value, known, index));
  PetscFunctionReturn(PETSC_SUCCESS);
}
