/* Errors of programs: one clear line for the user, and the same error on every process. */
#include <slipsys.h>
#include <slipstep/private/slipcompat.h>
#include <stdio.h>
#include <stdlib.h>

#define SLIP_ABORT_WAIT 5.0 /* time that other ranks leave rank 0 to print and abort [s] */

static char SlipProgram[64] = "slipstep";

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

static PetscErrorCode SlipErrorHandler(MPI_Comm comm, int line, const char *function, const char *file,
                                       PetscErrorCode code, PetscErrorType type, const char *message, void *ctx)
{
  const char *general = NULL;
  int size = 1;

  (void)line;
  (void)function;
  (void)file;
  (void)ctx;
  if (type == PETSC_ERROR_REPEAT) return code;
  MPI_Comm_size(MPI_COMM_WORLD, &size);
  if (SlipErrorIsMine(comm)) {
    if (!message || !message[0]) PetscErrorMessage(code, &general, NULL);
    fflush(stdout);
    fprintf(stderr, "%s: error: %s\n", SlipProgram, message && message[0] ? message : general ? general : "unknown");
    fflush(stderr);
  } else
    PetscSleep(SLIP_ABORT_WAIT);
  if (size == 1) exit(EXIT_FAILURE); /* nobody to wait for, and MPI_Abort() is talkative */
  MPI_Abort(MPI_COMM_WORLD, (int)code);
  return code;
}

/*@C
  SlipErrorHandlerPush - let errors end this program with one line on stderr, "program: error: message"

  Collective on PETSC_COMM_WORLD.

  Input Parameter:
. program - its name

  Options Database Key:
. -slip_traceback - keep PETSc's traceback instead

  Level: intermediate

.seealso: SlipErrorBcast()
@*/
PetscErrorCode SlipErrorHandlerPush(const char program[])
{
  PetscBool traceback = PETSC_FALSE;

  PetscFunctionBegin;
  PetscCall(PetscStrncpy(SlipProgram, program, sizeof(SlipProgram)));
  PetscOptionsBegin(PETSC_COMM_WORLD, NULL, "SlipStep", "Sys");
  PetscCall(PetscOptionsBool("-slip_traceback", "Show where an error happened, for reports of bugs",
                             "SlipErrorHandlerPush", traceback, &traceback, NULL));
  PetscOptionsEnd();
  if (!traceback) PetscCall(PetscPushErrorHandler(SlipErrorHandler, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipErrorBcast - make an error of rank 0 one of every rank

  Collective.

  Input Parameters:
+ comm - the processes
- code - on rank 0 the error code of what it did alone (already reported there), or PETSC_SUCCESS; ignored elsewhere

  Level: developer

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

/*@
  SlipWarnOfUnusedOptions - name on stderr every option that nothing has read

  Collective on PETSC_COMM_WORLD; at the end of a program.

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
