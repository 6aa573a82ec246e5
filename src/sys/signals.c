/* Signals that ask a program to stop are recorded, so that the current step can end; a second one ends it at once. */
#define _POSIX_C_SOURCE 200809L
#include <slipstep/rooms/slipsys.h>
#include <slipstep/private/slipsys.h>
#include <signal.h>
#include <time.h>

#define SLIP_SIGNAL_ECHO 0.1 /* a batch system may send one signal twice: within this time it counts once [s] */

static const struct {
  int number;
  const char *name;
} SlipSignals[] = {{SIGTERM, "SIGTERM"}, {SIGINT, "SIGINT"}, {SIGUSR1, "SIGUSR1"}, {SIGXCPU, "SIGXCPU"}};
static struct sigaction SlipSignalsBefore[PETSC_STATIC_ARRAY_LENGTH(SlipSignals)];
static volatile sig_atomic_t SlipSignalCaught = 0;
static struct timespec SlipSignalTime; /* time of the first signal, which the handler writes before it is read */
static PetscBool SlipSignalsPushed = PETSC_FALSE;

/* Calls only functions that POSIX lists as safe in a handler */
static void SlipSignalHandler(int number)
{
  struct timespec now;

  clock_gettime(CLOCK_MONOTONIC, &now);
  if (!SlipSignalCaught) {
    SlipSignalTime = now;
    SlipSignalCaught = number;
    return;
  }
  if ((double)(now.tv_sec - SlipSignalTime.tv_sec) + 1e-9 * (double)(now.tv_nsec - SlipSignalTime.tv_nsec) <
      SLIP_SIGNAL_ECHO)
    return;
  signal(number, SIG_DFL);
  raise(number);
}

/*@
  SlipSignalsPush - makes SIGTERM, SIGINT, SIGUSR1 and SIGXCPU end this process after the current step

  Not collective: call it on every process.

  Level: intermediate

  Notes:
  Users call it in their own programs, after `PetscInitialize()`, whose handlers it replaces; the library itself does
  not. Runs with a checkpoint of `SlipFaultCheckpointStart()` then end after the current step, whichever process got the
  signal. A second signal, at least a tenth of a second later, ends the process at once, as without this function.

  Errors: PETSC_ERR_SYS if the system does not install a handler

.seealso: SlipSignalsPop(), SlipSignalsCaught(), SlipFaultCheckpointStart()
@*/
PetscErrorCode SlipSignalsPush(void)
{
  struct sigaction action = {.sa_handler = SlipSignalHandler, .sa_flags = SA_RESTART};

  PetscFunctionBegin;
  if (SlipSignalsPushed) PetscFunctionReturn(PETSC_SUCCESS);
  SlipSignalCaught = 0;
  sigemptyset(&action.sa_mask); /* the handler cannot interrupt itself */
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(SlipSignals); i++) sigaddset(&action.sa_mask, SlipSignals[i].number);
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(SlipSignals); i++)
    PetscCheck(!sigaction(SlipSignals[i].number, &action, &SlipSignalsBefore[i]), PETSC_COMM_SELF, PETSC_ERR_SYS,
               "cannot catch signal %d", SlipSignals[i].number);
  SlipSignalsPushed = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipSignalsPop - restores the previous handlers of the signals of SlipSignalsPush()

  Not collective

  Level: intermediate

.seealso: SlipSignalsPush()
@*/
PetscErrorCode SlipSignalsPop(void)
{
  PetscFunctionBegin;
  if (!SlipSignalsPushed) PetscFunctionReturn(PETSC_SUCCESS);
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(SlipSignals); i++)
    (void)sigaction(SlipSignals[i].number, &SlipSignalsBefore[i], NULL);
  SlipSignalsPushed = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets the signal that asked this process to stop. number: of the signal, 0 for none. */
PetscErrorCode SlipSignalsCaught(int *number)
{
  PetscFunctionBegin;
  *number = (int)SlipSignalCaught;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Name of a caught signal */
const char *SlipSignalName(int number)
{
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(SlipSignals); i++)
    if (SlipSignals[i].number == number) return SlipSignals[i].name;
  return "a signal";
}
