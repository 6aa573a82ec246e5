/* Checks that integers of options fit into PetscInt. PETSc truncates them without a message: with 32-bit integers it
   reads -ts_max_steps 4294967300 as 4. */
#include <slipstep/rooms/slipsys.h>
#include <slipcompat.h>
#include <slipstep/private/slipsys.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

/* Raises an error for integers in a text that overflow PetscInt. comm: the processes that fail together; name: of the
   option, without the dash; text: its value: a number, or several separated by commas, colons or dashes; other texts
   are ignored. Errors: PETSC_ERR_ARG_OUTOFRANGE, with the option, the number and the largest one. */
PetscErrorCode SlipCheckInteger(MPI_Comm comm, const char name[], const char text[])
{
  PetscFunctionBegin;
  for (const char *at = text; *at;) {
    const size_t sign = strspn(at, "+-") ? 1 : 0, digits = strspn(at + sign, "0123456789");
    const char after = at[sign + digits];
    long long value;

    if (digits && (!after || strchr(",:- ", after))) {
      errno = 0;
      value = strtoll(at, NULL, 10);
      PetscCheck(!errno && value >= PETSC_MIN_INT && value <= PETSC_MAX_INT, comm, PETSC_ERR_ARG_OUTOFRANGE,
                 "-%s is %.*s, which is more than this build's integers hold, %" PetscInt_FMT, name,
                 (int)(sign + digits), at, PETSC_MAX_INT);
    }
    at += sign + digits;
    at += strcspn(at, ",:- ");
    if (*at) at++;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Raises an error if the value of an option that is read as an integer, or as a list of them, overflows PetscInt. comm:
   the processes that fail together; options: the database, NULL for the global one; prefix: of the option, NULL for
   none; option: its name, with the dash. Errors: PETSC_ERR_ARG_OUTOFRANGE. */
PetscErrorCode SlipCheckIntegerOption(MPI_Comm comm, PetscOptions options, const char prefix[], const char option[])
{
  char name[128], text[1024];
  PetscBool set;

  PetscFunctionBegin;
  PetscCall(PetscOptionsGetString(options, prefix, option, text, sizeof(text), &set));
  PetscCall(PetscSNPrintf(name, sizeof(name), "%s%s", prefix ? prefix : "", option + 1));
  if (set) PetscCall(SlipCheckInteger(comm, name, text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* True if a name ends with this, ignoring case: the name of an option with or without a prefix */
PetscBool SlipEndsWith(const char name[], const char end[])
{
  const size_t len = strlen(name), tail = strlen(end);

  return len >= tail && !strcasecmp(name + len - tail, end) ? PETSC_TRUE : PETSC_FALSE;
}
