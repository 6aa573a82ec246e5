/* Errors and warnings of programs: one line for the user; and an error of rank 0 as one of every rank. The name of the
   program is PETSc's. */
#include <slipsys.h>
#include <slipcompat.h>
#include <slipstep/private/slipsys.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SLIP_ABORT_WAIT 5.0 /* time that other ranks leave rank 0 to print and abort [s] */
#define SLIP_SPEAK_WAIT 1.0 /* time that other ranks leave rank 0 to report an error that all ranks meet alone [s] */

/* "program: kind: message" on stderr, after what is on its way to stdout; in one piece, or mpirun's own lines come
   between. */
static void SlipSpeak(const char kind[], const char format[], va_list args)
{
  char path[PETSC_MAX_PATH_LEN] = "slipstep", message[2 * PETSC_MAX_PATH_LEN];
  const char *slash;

  (void)PetscGetProgramName(path, sizeof(path));
  slash = strrchr(path, '/');
  (void)vsnprintf(message, sizeof(message), format, args);
  fflush(stdout);
  fprintf(stderr, "%s: %s: %s\n", slash ? slash + 1 : path, kind, message);
  fflush(stderr);
}

static void (*at_end)(void) = NULL;

void SlipErrorAtEnd(void (*end)(void))
{
  at_end = end;
}

enum { LINES = 8192 };       /* bytes */
static char warnings[LINES]; /* those of this process, a line each */
static char kept[LINES];     /* those that nobody has seen yet */
static PetscBool keeping = PETSC_FALSE;

static void SlipSay(const char kind[], const char format[], ...)
{
  va_list args;

  va_start(args, format);
  SlipSpeak(kind, format, args);
  va_end(args);
}

/* On a communicator all of whose ranks fail alike, rank 0 speaks; on a rank's own it speaks itself. */
static PetscErrorCode SlipErrorHandler(MPI_Comm comm, int line, const char *function, const char *file,
                                       PetscErrorCode code, PetscErrorType type, const char *message, void *ctx)
{
  static PetscBool ending = PETSC_FALSE; /* an error in the clean-up after an error is no news */
  int world = 1, here = 0, size = 1, rank = 0;
  const char *general = NULL;

  (void)line;
  (void)function;
  (void)file;
  (void)ctx;
  if (type == PETSC_ERROR_REPEAT || ending) return code;
  ending = PETSC_TRUE;
  (void)SlipSignalsPop(); /* MPI_Abort() ends the other ranks by a signal that would only be noted */
  MPI_Comm_size(MPI_COMM_WORLD, &world);
  MPI_Comm_rank(MPI_COMM_WORLD, &here);
  if (comm != MPI_COMM_NULL && comm != 0) {
    MPI_Comm_size(comm, &size);
    MPI_Comm_rank(comm, &rank);
  }
  if (size == 1 || !rank) {
    if (here) PetscSleep(SLIP_SPEAK_WAIT * here);
    if (!message || !message[0]) PetscErrorMessage(code, &general, NULL);
    SlipSay("error", "%s", general ? general : message && message[0] ? message : "unknown");
  } else
    PetscSleep(SLIP_ABORT_WAIT);
  if (at_end) (*at_end)();
  if (world == 1) exit(EXIT_FAILURE); /* nobody to wait for, and MPI_Abort() is talkative */
  MPI_Abort(MPI_COMM_WORLD, (int)code);
  return code;
}

static PetscBool begun = PETSC_FALSE; /* the handler has been there since before PetscInitialize() */

/* The handler for errors of PetscInitialize() itself. PETSc forgets it with the program: memory of this time is not its
   own debugging allocator's to free. */
PetscErrorCode SlipErrorHandlerBegin(void)
{
  PetscFunctionBegin;
  if (!begun) PetscCall(PetscPushErrorHandler(SlipErrorHandler, NULL));
  begun = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* PETSc calls the first step -ts_time_step from 3.25 on, and warns of -ts_dt: both names do with every version. */
static PetscErrorCode SlipRenameStep(void)
{
  const char *const given = "-" SLIP_TS_DT_OTHER, *const known = "-" SLIP_TS_DT;
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
. program - its name, given to PetscSetProgramName()

  Options Database Key:
. -slip_traceback - keep PETSc's traceback instead

  Level: intermediate

  Notes:
  For programs of one's own: the library itself only raises errors, as PETSc does. The handler prints the message of the
  error as it was raised, and ends the program with a failure.

  Programs then take both -ts_dt and -ts_time_step, as PETSc calls it from 3.25 on, with every version.

.seealso: SlipProgramInitialize(), SlipCheckSolverOptions(), SlipErrorBcast()
@*/
PetscErrorCode SlipErrorHandlerPush(const char program[])
{
  PetscBool traceback = PETSC_FALSE;

  PetscFunctionBegin;
  PetscCall(SlipRenameStep());
  PetscCall(PetscSetProgramName(program));
  PetscCall(SlipCheckBoolOption(PETSC_COMM_WORLD, NULL, NULL, "-slip_traceback"));
  PetscOptionsBegin(PETSC_COMM_WORLD, NULL, "SlipStep", "Sys");
  PetscCall(PetscOptionsBool("-slip_traceback", "Show where an error happened, for reports of bugs (default no)",
                             "SlipErrorHandlerPush", traceback, &traceback, NULL));
  PetscOptionsEnd();
  if (traceback && !begun) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscPushErrorHandler(traceback ? PetscTraceBackErrorHandler : SlipErrorHandler, NULL));
  PetscCall(PetscRegisterFinalize(PetscPopErrorHandler)); /* PETSc does not free its stack of handlers */
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A line more, cut where it must be; whether it was not */
static PetscBool Append(char lines[LINES], const char format[], va_list args)
{
  const size_t n = strlen(lines), room = LINES - n - 1;
  int length = 0;

  if (room < 2) return PETSC_FALSE;
  length = vsnprintf(lines + n, room, format, args);
  strcat(lines, "\n");
  return length >= 0 && (size_t)length < room ? PETSC_TRUE : PETSC_FALSE;
}

/*@C
  SlipWarning - one line on stderr, "program: warning: message"

  Not collective: every process that calls it prints, unless SlipWarningsKeep() says otherwise.

  Input Parameters:
+ format - as of printf()
- ...    - what it is filled with

  Level: developer

.seealso: SlipErrorHandlerPush()
@*/
PetscErrorCode SlipWarning(const char format[], ...)
{
  va_list args;
  PetscBool room = keeping;

  PetscFunctionBegin;
  va_start(args, format);
  if (keeping) room = Append(kept, format, args);
  va_end(args);
  va_start(args, format);
  if (!room) SlipSpeak("warning", format, args);
  va_end(args);
  va_start(args, format);
  (void)Append(warnings, format, args);
  va_end(args);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipWarnOfUnit - a warning where a number looks as if it were in another unit

  Not collective: every process that calls it prints.

  Input Parameters:
+ what  - what has the value, with its verb, as "-fault_normal_stress is"
. value - in its unit; 0 and NaN are plausible
. unit  - of the number, "" for none
. least - the least magnitude that is plausible [unit]
. most  - the largest one [unit]
. small - the unit that a smaller magnitude looks like
- large - the unit that a larger one looks like

  Level: developer

.seealso: SlipWarning()
@*/
PetscErrorCode SlipWarnOfUnit(const char what[], PetscReal value, const char unit[], PetscReal least, PetscReal most,
                              const char small[], const char large[])
{
  const PetscReal x = PetscAbsReal(value);

  PetscFunctionBegin;
  if (x == 0 || isnan(x) || (x >= least && x <= most)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipWarning("%s %.6g%s%s: is it given in %s? Expected %g to %g%s%s%s", what, (double)value,
                        unit[0] ? " " : "", unit, x < least ? small : large, (double)least, (double)most,
                        unit[0] ? " " : "", unit, unit[0] ? "" : ", without unit"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipWarningsTake - the warnings of this process since the last call, for a report of a run

  Not collective.

  Output Parameter:
. text - a line for each warning, cut after 8 kB; PetscFree() it

  Level: developer

.seealso: SlipWarning(), SlipWarningsKeep()
@*/
PetscErrorCode SlipWarningsTake(char **text)
{
  PetscFunctionBegin;
  PetscCall(PetscStrallocpy(warnings, text));
  warnings[0] = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipWarningsKeep - let warnings of this process wait, without a line on stderr, for who shows those of a run's report

  Not collective.

  Input Parameters:
+ keep - PETSC_FALSE: print them again
- say  - print those that were kept, as where there is no report; else they are forgotten

  Level: developer

  Note: what there is no room for, 8 kB, is printed at once.

.seealso: SlipWarning(), SlipWarningsTake()
@*/
PetscErrorCode SlipWarningsKeep(PetscBool keep, PetscBool say)
{
  PetscFunctionBegin;
  keeping = PETSC_FALSE;
  for (char *end, *line = kept; say && (end = strchr(line, '\n')); line = end + 1) {
    *end = 0;
    SlipSay("warning", "%s", line);
  }
  kept[0] = 0;
  keeping = keep;
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
