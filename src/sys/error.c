/* Errors of programs: one clear line for the user, and the same error on every process. */
#include <slipsys.h>
#include <slipstep/private/slipsys.h>
#include <slipcompat.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SLIP_ABORT_WAIT 5.0 /* time that other ranks leave rank 0 to print and abort [s] */

#define SLIP_SPEAK_WAIT 1.0 /* time that other ranks leave rank 0 to report an error that all ranks meet alone [s] */

static char SlipProgram[64] = "slipstep";
static char SlipSource[64];                     /* option whose value is at work, or empty */
static char SlipUnfinished[PETSC_MAX_PATH_LEN]; /* file of a run that has not begun, or empty */

/* On a communicator all of whose ranks fail alike, rank 0 speaks; on a rank's own it speaks itself. */
static PetscBool SlipErrorIsMine(MPI_Comm comm)
{
  int size = 1, rank = 0;

  if (comm != MPI_COMM_NULL && comm != 0) {
    MPI_Comm_size(comm, &size);
    MPI_Comm_rank(comm, &rank);
  }
  return size == 1 || !rank ? PETSC_TRUE : PETSC_FALSE;
}

/* PETSc's messages that name no option, by how they begin, and the option that is meant. */
static const struct {
  const char *begins, *option;
} SlipErrorMeant[] = {
  {"Minimum time step", "-ts_adapt_dt_min"},
  {"Maximum time step", "-ts_adapt_dt_max"},
  {"Unknown TS type", "-ts_type"},
  {"Unable to find requested SNES type", "-snes_type"},
  {"Unable to find requested KSP type", "-ksp_type"},
  {"Unable to find requested PC type", "-pc_type"},
};

/* Messages about values that are no numbers quote the value only: find its option. */
static void SlipErrorFindOption(const char message[], char option[], size_t len)
{
  char *all = NULL, value[64], *word, *name = NULL;

  option[0] = '\0';
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(SlipErrorMeant); i++)
    if (!strncmp(message, SlipErrorMeant[i].begins, strlen(SlipErrorMeant[i].begins)))
      snprintf(option, len, "%s", SlipErrorMeant[i].option);
  if (sscanf(message, "Input string %63s has no", value) != 1 || PetscOptionsGetAll(NULL, &all)) return;
  for (word = strtok(all, " "); word; word = strtok(NULL, " ")) {
    if (name && !strcmp(word, value)) snprintf(option, len, "%s", name);
    name = word[0] == '-' ? word : NULL;
  }
  (void)PetscFree(all);
}

/* PETSc from 3.22 on checks the range of every number that it reads, and names the option no more. text: the message
   with the first option that has this value. */
static PetscBool SlipErrorNameBound(const char message[], char text[], size_t len)
{
  char *all = NULL, *word, *name = NULL, *end, value[64], side[16], bound[64], wanted[64] = "";
  double x, y, limit;
  PetscBool found = PETSC_FALSE;

  if (sscanf(message, "Newly set value %63s %15s than allowed bound %63s", value, side, bound) != 3) return PETSC_FALSE;
  x = strtod(value, NULL);
  limit = strtod(bound, NULL);
  if (fabs(limit) < 1e300) snprintf(wanted, sizeof(wanted), " %s %g", strcmp(side, "less") ? "<=" : ">=", limit);
  if (PetscOptionsGetAll(NULL, &all)) return PETSC_FALSE;
  for (word = strtok(all, " "); word && !found; word = strtok(NULL, " ")) {
    y = strtod(word, &end);
    /* printed with six digits */
    if (name && end != word && ((isnan(x) && isnan(y)) || x == y || fabs(x - y) < 1e-5 * fabs(x))) {
      if (!strcmp(name, "-ts_time_step")) name = (char *)"-ts_dt"; /* as it is called here */
      snprintf(text, len, "%s is %s, expected a number%s", name, word, wanted);
      found = PETSC_TRUE;
    }
    name = word[0] == '-' ? word : NULL;
  }
  (void)PetscFree(all);
  return found;
}

/* The line for the user: the message, and the option at work unless the message names one. */
static void SlipErrorSpeak(PetscErrorCode code, const char message[])
{
  const char *general = NULL;
  char found[64] = "", text[256], *option = SlipSource;

  if (!message || !message[0]) PetscErrorMessage(code, &general, NULL);
  if (!message || !message[0]) message = general ? general : "unknown";
  if (SlipErrorNameBound(message, text, sizeof(text))) message = text;
  if (!option[0]) {
    SlipErrorFindOption(message, found, sizeof(found));
    option = found;
  }
  if (strstr(message, option)) option = (char *)"";
  fflush(stdout);
  fprintf(stderr, "%s: error: %s%s%s%s\n", SlipProgram, message, option[0] ? " (" : "", option, option[0] ? ")" : "");
  fflush(stderr);
}

static PetscErrorCode SlipErrorHandler(MPI_Comm comm, int line, const char *function, const char *file,
                                       PetscErrorCode code, PetscErrorType type, const char *message, void *ctx)
{
  int size = 1, rank = 0;

  (void)line;
  (void)function;
  (void)file;
  (void)ctx;
  if (type == PETSC_ERROR_REPEAT) return code;
  MPI_Comm_size(MPI_COMM_WORLD, &size);
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  if (SlipUnfinished[0]) remove(SlipUnfinished);
  if (SlipErrorIsMine(comm)) {
    if (rank) PetscSleep(SLIP_SPEAK_WAIT * rank);
    SlipErrorSpeak(code, message);
  } else
    PetscSleep(SLIP_ABORT_WAIT);
  if (size == 1) exit(EXIT_FAILURE); /* nobody to wait for, and MPI_Abort() is talkative */
  MPI_Abort(MPI_COMM_WORLD, (int)code);
  return code;
}

/* PETSc calls the first step -ts_time_step from 3.25 on, and warns of -ts_dt: both names do with every version. */
static PetscErrorCode SlipRenameStep(void)
{
#if PETSC_VERSION_LT(3, 25, 0)
  const char *const given = "-ts_time_step", *const known = "-ts_dt";
#else
  const char *const given = "-ts_dt", *const known = "-ts_time_step";
#endif
  const char *value;
  char copy[64];
  PetscBool set;

  PetscFunctionBegin;
  PetscCall(PetscOptionsFindPair(NULL, NULL, given, &value, &set));
  if (!set) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscStrncpy(copy, value ? value : "", sizeof(copy)));
  PetscCall(PetscOptionsClearValue(NULL, given));
  PetscCall(PetscOptionsSetValue(NULL, known, copy));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipErrorHandlerPush - let errors end this program with one line on stderr, "program: error: message"

  Collective on PETSC_COMM_WORLD.

  Input Parameter:
. program - its name

  Options Database Key:
. -slip_traceback - keep PETSc's traceback instead

  Note:
  Lets programs take both -ts_dt and -ts_time_step, as PETSc calls it from 3.25 on, with every version.

  Level: intermediate

.seealso: SlipErrorBcast()
@*/
PetscErrorCode SlipErrorHandlerPush(const char program[])
{
  PetscBool traceback = PETSC_FALSE;

  PetscFunctionBegin;
  PetscCall(PetscStrncpy(SlipProgram, program, sizeof(SlipProgram)));
  PetscCall(SlipRenameStep());
  PetscOptionsBegin(PETSC_COMM_WORLD, NULL, "SlipStep", "Sys");
  PetscCall(PetscOptionsBool("-slip_traceback", "Show where an error happened, for reports of bugs",
                             "SlipErrorHandlerPush", traceback, &traceback, NULL));
  PetscOptionsEnd();
  if (traceback) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscPushErrorHandler(SlipErrorHandler, NULL));
  PetscCall(PetscRegisterFinalize(PetscPopErrorHandler)); /* PETSc does not free its stack of handlers */
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipErrorSource - name the option whose value is being used, so that an error from deep below still names it

  Not collective.

  Input Parameter:
. option - with its dash, for example "-fault_parameters"; NULL when its value has been used

  Level: developer

.seealso: SlipErrorHandlerPush(), SlipErrorUnfinished()
@*/
PetscErrorCode SlipErrorSource(const char option[])
{
  PetscFunctionBegin;
  PetscCall(PetscStrncpy(SlipSource, option ? option : "", sizeof(SlipSource)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipErrorUnfinished - have an error remove the file of a run that has not begun

  Not collective.

  Input Parameter:
. file - its name, or NULL: from now on the file is worth keeping, or complete

  Level: developer

.seealso: SlipErrorHandlerPush(), SlipErrorSource()
@*/
PetscErrorCode SlipErrorUnfinished(const char file[])
{
  PetscFunctionBegin;
  PetscCall(PetscStrncpy(SlipUnfinished, file ? file : "", sizeof(SlipUnfinished)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipWarning - one line on stderr, "program: warning: message"

  Not collective: every process that calls it prints.

  Input Parameters:
+ format - as of printf()
- ...    - what it is filled with

  Level: developer

.seealso: SlipErrorHandlerPush()
@*/
PetscErrorCode SlipWarning(const char format[], ...)
{
  va_list args;

  PetscFunctionBegin;
  fflush(stdout);
  fprintf(stderr, "%s: warning: ", SlipProgram);
  va_start(args, format);
  vfprintf(stderr, format, args);
  va_end(args);
  fprintf(stderr, "\n");
  fflush(stderr);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipWarnOfUnusedOptions - name the options that nothing has read: most often they are mistyped

  Collective on PETSC_COMM_WORLD; at the end of a program that called SlipErrorHandlerPush().

  Level: intermediate

.seealso: SlipErrorHandlerPush()
@*/
PetscErrorCode SlipWarnOfUnusedOptions(void)
{
  PetscInt n;
  char **names, **values;

  PetscFunctionBegin;
  PetscCall(PetscOptionsLeftGet(NULL, &n, &names, &values));
  for (PetscInt i = 0; i < n; i++)
    PetscCall(PetscFPrintf(PETSC_COMM_WORLD, PETSC_STDERR, "%s: warning: nothing has read the option -%s\n",
                           SlipProgram, names[i]));
  PetscCall(PetscOptionsLeftRestore(NULL, &n, &names, &values));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipErrorBcast - make an error of rank 0 one of every rank

  Collective.

  Input Parameters:
+ comm - the processes
- code - on rank 0 the error code of what it did alone (already reported there), or PETSC_SUCCESS; ignored elsewhere

  Level: developer

  Errors: the code of rank 0, raised again on every other rank

.seealso: SlipErrorHandlerPush()
@*/
PetscErrorCode SlipErrorBcast(MPI_Comm comm, PetscErrorCode code)
{
  int value = (int)code;
  PetscMPIInt rank;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCallMPI(MPI_Bcast(&value, 1, MPI_INT, 0, comm));
  if (!rank) PetscCall(code);
  PetscCheck(!value, PETSC_COMM_SELF, (PetscErrorCode)value, "rank 0 failed");
  PetscFunctionReturn(PETSC_SUCCESS);
}
