/* Times with units: values of options, such as 100y, are converted to seconds in the database before any code reads
   them; messages show times in the unit that fits. */
#include <slipstep/rooms/slipsys.h>
#include <slipcompat.h>
#include <slipstep/private/slipsys.h>
#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

enum { SLIP_MAX_TIMES = 16 };

/* m is not a unit: it could be minutes, months or metres. */
static const struct {
  const char *name, *word;
  PetscReal seconds, end; /* times below end [s] are shown in this unit */
} SlipTimeUnits[] = {{"s", "s", 1, 120},
                     {"min", "min", 60, 120 * 60},
                     {"h", "h", 3600, 48 * 3600},
                     {"d", "days", 86400, 2 * 365.25 * 86400},
                     {"y", "years", 365.25 * 86400, PETSC_MAX_REAL}};

static const char SlipSolverTimes[] = "ts_dt ts_time_step ts_init_time ts_max_time ts_adapt_dt_min ts_adapt_dt_max";
static const char *SlipTimes[SLIP_MAX_TIMES]; /* names of options, separated by blanks */
static int SlipNumTimes;

static PetscErrorCode SlipForgetTimes(void)
{
  SlipNumTimes = 0;
  return PETSC_SUCCESS;
}

/*@C
  SlipDeclareTimes - declares options that are times, which may have a unit from then on

  Not collective.

  Input Parameter:
. names - without dashes, separated by blanks, each valid with any prefix or none; not copied

  Level: developer

  Errors: PETSC_ERR_PLIB for too many lists

.seealso: SlipExpandTimes(), SlipDeclareOptions()
@*/
PetscErrorCode SlipDeclareTimes(const char names[])
{
  PetscFunctionBegin;
  for (int i = 0; i < SlipNumTimes; i++)
    if (SlipTimes[i] == names) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCheck(SlipNumTimes < SLIP_MAX_TIMES, PETSC_COMM_SELF, PETSC_ERR_PLIB, "more than %d lists of times",
             SLIP_MAX_TIMES);
  if (!SlipNumTimes) PetscCall(PetscRegisterFinalize(SlipForgetTimes));
  SlipTimes[SlipNumTimes++] = names;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* True if the name is in a list, with or without a prefix */
static PetscBool SlipIsListed(const char name[], const char names[])
{
  const size_t n = strlen(name);
  char each[SLIP_NAME_LENGTH];

  while (SlipNextName("", &names, each)) {
    const size_t len = strlen(each);

    if (n >= len && !strcasecmp(name + n - len, each) && (n == len || name[n - len - 1] == '_')) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

PetscBool SlipIsTimeOption(const char name[])
{
  if (SlipIsListed(name, SlipSolverTimes)) return PETSC_TRUE;
  for (int i = 0; i < SlipNumTimes; i++)
    if (SlipIsListed(name, SlipTimes[i])) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* Converts "1.5h" to seconds; false for a text without a unit, or without a number before it */
static PetscBool SlipParseTime(const char text[], PetscReal *seconds)
{
  char *unit;
  const double number = strtod(text, &unit);

  if (unit == text || !isdigit((unsigned char)text[strspn(text, "+-.")])) return PETSC_FALSE;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(SlipTimeUnits); k++) {
    *seconds = (PetscReal)number * SlipTimeUnits[k].seconds;
    if (!strcmp(unit, SlipTimeUnits[k].name)) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* Writes a list of times, separated by commas, in seconds; false where none has a unit. */
static PetscBool SlipParseTimes(const char list[], char text[], size_t len)
{
  PetscBool any = PETSC_FALSE;
  PetscReal seconds;
  size_t used = 0;

  text[0] = '\0';
  for (const char *c = list; c; c = strchr(c, ',') ? strchr(c, ',') + 1 : NULL) {
    char one[64] = "";

    (void)snprintf(one, sizeof(one), "%.*s", (int)strcspn(c, ","), c);
    if (SlipParseTime(one, &seconds)) {
      any = PETSC_TRUE;
      (void)snprintf(one, sizeof(one), "%.17g", (double)seconds);
    }
    used += (size_t)snprintf(text + used, len - used, "%s%s", c == list ? "" : ",", one);
    if (used >= len) return PETSC_FALSE;
  }
  return any;
}

/*@C
  SlipExpandTimes - replaces times with a unit in the options database by their seconds: 90s, 10min, 12h, 20d, 100y; a
  year has 365.25 days

  Not collective; SlipFaultSetFromOptions() and SlipCheckSolverOptions() call it, before anything is read.

  Input Parameter:
. options - the database, NULL for the global one

  Level: developer

  Notes:
  Times are the options of PETSc's TS (-ts_max_time, -ts_dt, -ts_init_time, -ts_adapt_dt_min and _max) and the numbers
  of a fault in seconds, or lists of them, with any prefix. A value that is not a number with one of these units is not
  changed, and the code that reads it raises the error.

.seealso: SlipCheckSolverOptions(), SlipFaultSetFromOptions()
@*/
PetscErrorCode SlipExpandTimes(PetscOptions options)
{
  PetscInt n;
  char **names, **values, option[256], text[512];

  PetscFunctionBegin;
  PetscCall(PetscOptionsLeftGet(options, &n, &names, &values));
  for (PetscInt i = 0; i < n; i++) {
    if (!values[i] || !SlipIsTimeOption(names[i]) || !SlipParseTimes(values[i], text, sizeof(text))) continue;
    (void)snprintf(option, sizeof(option), "-%s", names[i]);
    PetscCall(PetscOptionsSetValue(options, option, text));
  }
  PetscCall(PetscOptionsLeftRestore(options, &n, &names, &values));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void SlipTimeText(PetscReal seconds, int digits, char text[], size_t len)
{
  size_t k = 0;

  while (k + 1 < PETSC_STATIC_ARRAY_LENGTH(SlipTimeUnits) && PetscAbsReal(seconds) >= SlipTimeUnits[k].end) k++;
  (void)snprintf(text, len, "%.*g %s", digits, (double)(seconds / SlipTimeUnits[k].seconds), SlipTimeUnits[k].word);
}
