/* Options as rows of a table, see options.h. */
#include "options.h"
#include <slipsys.h>

PetscErrorCode OptionsNumbers(SlipOptionItems PetscOptionsObject, size_t n, const NumberOption row[])
{
  PetscFunctionBegin;
  for (size_t i = 0; i < n; ++i) {
    const NumberOption *o = &row[i];
    char limit[32] = "";
    PetscBool given;
    PetscReal x;

    if (o->text)
      PetscCall(SlipCheckNumberOption(PETSC_COMM_WORLD, NULL, NULL, o->name, o->integer ? PETSC_TRUE : PETSC_FALSE,
                                      &given, &x));
    if (o->integer && o->text) PetscCall(PetscOptionsInt(o->name, o->text, NULL, *o->integer, o->integer, NULL));
    x = o->integer ? (PetscReal)*o->integer : *o->real;
    if (o->real && o->text) PetscCall(PetscOptionsReal(o->name, o->text, NULL, x, &x, NULL));
    if (o->real) *o->real = x;
    PetscCheck(!o->exclusive || (x > o->low && !PetscIsInfReal(x)), PETSC_COMM_WORLD, PETSC_ERR_ARG_OUTOFRANGE,
               "%s is %.6g, expected a number > %.6g", o->name, (double)x, (double)o->low);
    if (o->high < PETSC_MAX_REAL) (void)snprintf(limit, sizeof(limit), " and <= %.6g", (double)o->high);
    PetscCheck(x >= o->low && x <= o->high, PETSC_COMM_WORLD, PETSC_ERR_ARG_OUTOFRANGE,
               "%s is %.6g, expected a number >= %.6g%s", o->name, (double)x, (double)o->low, limit);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode OptionCheckChoice(const char option[], const char value[], const char *const known[])
{
  char list[128] = "";
  PetscBool same;

  PetscFunctionBegin;
  for (PetscInt i = 0; known[i]; ++i) {
    PetscCall(PetscStrcmp(value, known[i], &same));
    if (same) PetscFunctionReturn(PETSC_SUCCESS);
    PetscCall(PetscStrlcat(list, " ", sizeof(list)));
    PetscCall(PetscStrlcat(list, known[i], sizeof(list)));
  }
  SETERRQ(PETSC_COMM_WORLD, PETSC_ERR_ARG_UNKNOWN_TYPE, "%s %s is not known; expected one of:%s", option, value, list);
}
