/* Errors and warnings of programs, as one line for the user, and errors of rank 0 raised on every rank. The program's
   name is that of PETSc. */
#include <slipstep/rooms/slipsys.h>
#include <slipcompat.h>
#include <slipstep/private/slipsys.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SLIP_ABORT_WAIT 5.0 /* time that other ranks give rank 0 to print and abort [s] */
#define SLIP_SPEAK_WAIT 1.0 /* time that other ranks give rank 0 to report an error that occurs on all ranks [s] */

/* Prints "program: kind: message" on stderr after flushing stdout, in one write, because mpirun's own lines may come
   between several. */
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
static char warnings[LINES]; /* all of this process, one line each */
static char stored[LINES];   /* those that were not shown yet */
static PetscBool storing = PETSC_FALSE;

static void SlipSay(const char kind[], const char format[], ...)
{
  va_list args;

  va_start(args, format);
  SlipSpeak(kind, format, args);
  va_end(args);
}

/* If all ranks of a communicator fail, rank 0 prints the message; an error on one rank is printed by that rank. */
static PetscErrorCode SlipErrorHandler(MPI_Comm comm, int line, const char *function, const char *file,
                                       PetscErrorCode code, PetscErrorType type, const char *message, void *ctx)
{
  static PetscBool ending = PETSC_FALSE; /* errors in the clean-up after an error are not reported */
  int world = 1, here = 0, size = 1, rank = 0;
  const char *general = NULL;

  (void)line;
  (void)function;
  (void)file;
  (void)ctx;
  if (type == PETSC_ERROR_REPEAT || ending) return code;
  ending = PETSC_TRUE;
  (void)SlipSignalsPop(); /* MPI_Abort() ends the other ranks by a signal, which would otherwise only be recorded */
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
  if (world == 1) exit(EXIT_FAILURE); /* there is no other rank, and MPI_Abort() prints more lines */
  MPI_Abort(MPI_COMM_WORLD, (int)code);
  return code;
}

static PetscBool begun = PETSC_FALSE; /* the handler was installed before PetscInitialize() */

/* Installs the handler for errors of PetscInitialize() itself. PETSc drops it at the end of the program: its debugging
   allocator could not free memory of this time. */
PetscErrorCode SlipErrorHandlerBegin(void)
{
  PetscFunctionBegin;
  if (!begun) PetscCall(PetscPushErrorHandler(SlipErrorHandler, NULL));
  begun = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipErrorHandlerPush - makes errors end this program with one line on stderr, "program: error: message"

  Collective on PETSC_COMM_WORLD.

  Input Parameter:
. program - its name, given to PetscSetProgramName()

  Options Database Key:
. -slip_traceback - prints PETSc's traceback instead

  Level: intermediate

  Notes:
  Users call it in their own programs; the library itself only raises errors, as PETSc does. The handler prints the
  message of the error and ends the program with a failure.

  Programs then accept both -ts_dt and -ts_time_step, PETSc's name from 3.25 on, with every version.

.seealso: SlipProgramInitialize(), SlipCheckSolverOptions(), SlipErrorBcast()
@*/
PetscErrorCode SlipErrorHandlerPush(const char program[])
{
  const char *value;
  char copy[64];
  PetscBool set, traceback = PETSC_FALSE;

  PetscFunctionBegin;
  /* PETSc calls the first step -ts_time_step from 3.25 on and warns of -ts_dt; both are valid with every version */
  PetscCall(PetscOptionsFindPair(NULL, NULL, "-" SLIP_TS_DT_OTHER, &value, &set));
  if (set) {
    PetscCall(PetscStrncpy(copy, value ? value : "", sizeof(copy)));
    PetscCall(PetscOptionsClearValue(NULL, "-" SLIP_TS_DT_OTHER));
    PetscCall(PetscOptionsSetValue(NULL, "-" SLIP_TS_DT, copy));
  }
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

/* Appends a line, which is cut if there is not enough room; returns whether it fits */
static PetscBool Append(char lines[LINES], const char format[], va_list args)
{
  const size_t n = strlen(lines), room = LINES - n - 1;
  int length = 0;

  if (room < 2) return PETSC_FALSE;
  length = vsnprintf(lines + n, room, format, args);
  strcat(lines, "\n");
  return length >= 0 && (size_t)length < room ? PETSC_TRUE : PETSC_FALSE;
}

/* Prints one line on stderr, "program: warning: message". format: as of printf(), with its arguments. */
PetscErrorCode SlipWarning(const char format[], ...)
{
  va_list args;
  PetscBool room = storing;

  PetscFunctionBegin;
  va_start(args, format);
  if (storing) room = Append(stored, format, args);
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
  SlipWarnOfUnit - warns of a number that looks as if it were in another unit

  Not collective: every process that calls it prints.

  Input Parameters:
+ what  - subject and verb of the message, such as "-fault_normal_stress is"
. value - in its unit; 0 and NaN are plausible
. unit  - of the number, "" for none
. least - the least plausible magnitude [unit]
. most  - the largest plausible magnitude [unit]
. small - the unit that a smaller magnitude suggests
- large - the unit that a larger magnitude suggests

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

/* Gets the warnings of this process since the last call, for the report of a run. text: a line for each warning, cut
   after 8 kB; PetscFree() it. */
PetscErrorCode SlipWarningsTake(char **text)
{
  PetscFunctionBegin;
  PetscCall(PetscStrallocpy(warnings, text));
  warnings[0] = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipWarningsKeep - stores warnings of this process instead of printing them, for programs that show them in a report

  Not collective.

  Input Parameters:
+ keep - PETSC_FALSE: print them again
- say  - print stored warnings, if there is no report; otherwise they are discarded

  Level: developer

  Note: warnings beyond 8 kB are printed at once.

.seealso: SlipWarning(), SlipWarningsTake()
@*/
PetscErrorCode SlipWarningsKeep(PetscBool keep, PetscBool say)
{
  PetscFunctionBegin;
  storing = PETSC_FALSE;
  for (char *end, *line = stored; say && (end = strchr(line, '\n')); line = end + 1) {
    *end = 0;
    SlipSay("warning", "%s", line);
  }
  stored[0] = 0;
  storing = keep;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipErrorBcast - raises an error of rank 0 on every rank

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
