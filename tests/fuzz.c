/*
  Reads damaged files, for fuzz.py: fuzz KIND reads names of files on standard input and prints a line for each,

    name TAB end TAB wall time [s] TAB memory [kB] TAB content or message

  end: accepted, with a hash of the content where the file has a checksum; refused, with the first error; signal N; exit
  N (of a sanitizer). Each is read by a process of its own, forked from one that has initialised everything, so that
  thousands take a minute. fuzz KIND -make FILE writes the file that mutants are made of, where the library has to.
*/
#define _GNU_SOURCE
#include <slipstep/rooms.h>
#include <slipstep/rooms/sliph5.h>
#include <slipstep/private/slippolicy.h>
#include <slipstep/private/sliprun.h>
#include <slipstep/private/slipsys.h>
#include <execinfo.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

enum { timeout = 200, initial = 1 };          /* [s] of a child; its exit code when a file was refused */
static const long most = 1536L * 1024 * 1024; /* bytes that a child may have resident; fuzz.py allows less */

static char message[512]; /* of the first error, and the content of what was accepted */

static PetscErrorCode Keep(MPI_Comm comm, int line, const char *function, const char *file, PetscErrorCode code,
                           PetscErrorType type, const char *text, void *ctx)
{
  if (type == PETSC_ERROR_INITIAL && !message[0]) snprintf(message, sizeof(message), "%s", text ? text : "no message");
  return code;
}

static PetscErrorCode ReadPolicy(const char file[])
{
  const char *hash;
  SlipPolicy p;
  PetscBool has;
  SlipH5 h;

  PetscCall(SlipPolicyCreate(PETSC_COMM_SELF, &p));
  PetscCall(SlipPolicyLoad(p, file));
  PetscCall(SlipPolicyGetHash(p, &hash));
  PetscCall(SlipH5OpenRead(file, &h));
  PetscCall(SlipH5HasAttribute(&h, "/", "checksum", &has));
  PetscCall(SlipH5Close(&h));
  snprintf(message, sizeof(message), "%s", has ? hash : "none");
  return SlipPolicyDestroy(&p);
}

static PetscErrorCode MakePolicy(const char file[])
{
  const char *const names[] = {"energy", "step"};
  const PetscReal scale[] = {0.5, 2}, offset[] = {0.25, -1}, min[] = {0, -1}, max[] = {1, 1};
  const PetscReal w0[] = {1, -2, 0.5, 0.25, -3, 1}, b0[] = {0.1, -0.2, 0.3}, w1[] = {0.7, -1.1, 0.4}, b1[] = {0.05};
  SlipPolicy p;

  PetscCall(SlipPolicyCreate(PETSC_COMM_SELF, &p));
  PetscCall(SlipPolicySetObservations(p, 2, names, scale, offset));
  PetscCall(SlipPolicyAddLayer(p, 2, 3, w0, b0, SLIP_ACTIVATION_TANH));
  PetscCall(SlipPolicyAddLayer(p, 3, 1, w1, b1, SLIP_ACTIVATION_HARDTANH2));
  PetscCall(SlipPolicySetAction(p, -1, 1, 1e-3, "T*", 0.2, "t_max", PETSC_FALSE));
  PetscCall(SlipPolicySetRange(p, min, max));
  PetscCall(SlipPolicySetAttribute(p, "algorithm", "by hand"));
  PetscCall(SlipPolicySetAttribute(p, "alpha", "0.1"));
  PetscCall(SlipPolicySetAttribute(p, "created", "2026-11-22T00:00:00Z")); /* the same file every time */
  PetscCall(SlipPolicyStore(p, file));
  return SlipPolicyDestroy(&p);
}

/* A fault of 3 x 2 cells, set up with one option that names the file. */
static PetscErrorCode ReadOfFault(const char option[], const char file[])
{
  SlipFault fault;

  PetscCall(SlipFaultCreate(PETSC_COMM_SELF, &fault));
  PetscCall(SlipFaultSetReal(fault, "nx", 3));
  PetscCall(SlipFaultSetReal(fault, "nz", 2));
  PetscCall(SlipFaultSetString(fault, option, file));
  PetscCall(SlipFaultSetUp(fault));
  return SlipFaultDestroy(&fault);
}

static PetscErrorCode ReadMesh(const char file[])
{
  return ReadOfFault("mesh", file);
}

static PetscErrorCode ReadParameters(const char file[])
{
  return ReadOfFault("parameters", file);
}

static PetscErrorCode ReadStiffness(const char file[])
{
  return ReadOfFault("stiffness_file", file);
}

static PetscErrorCode ReadHistory(const char file[])
{
  return ReadOfFault("stress_history", file);
}

static PetscErrorCode ReadTolerances(const char file[])
{
  SlipFaultTolerances t;

  return SlipFaultTolerancesRead(PETSC_COMM_SELF, NULL, file, "event", &t);
}

static PetscErrorCode ReadEstimates(const char file[])
{
  const char *const measures[NUM_ESTIMATES] = {"history", "final_slip", "event_time"};
  SlipFaultCalibration c;

  return SlipFaultCalibrationRead(PETSC_COMM_SELF, NULL, file, measures, &c);
}

static const struct {
  const char *name;
  PetscErrorCode (*read)(const char file[]);
  PetscErrorCode (*make)(const char file[]); /* NULL: fuzz.py writes it */
} Kinds[] = {
  {"policy", ReadPolicy, MakePolicy}, {"mesh", ReadMesh, NULL},       {"parameters", ReadParameters, NULL},
  {"stiffness", ReadStiffness, NULL}, {"history", ReadHistory, NULL}, {"tolerances", ReadTolerances, NULL},
  {"estimates", ReadEstimates, NULL},
};

/* Where it crashed, or hung, for fuzz.py to tell our code from HDF5; PETSc has taken the handlers of sanitizers, which
   report bad accesses by themselves. */
static void Crash(int signal)
{
  void *frame[64];
  struct sigaction again = {.sa_handler = SIG_DFL};
  int n;

  sigaction(SIGALRM, &again, NULL);
  alarm(2);
  n = backtrace(frame, 64);
  backtrace_symbols_fd(frame, n, STDERR_FILENO);
  (void)!write(STDERR_FILENO, "crash\n", 6);
  _exit(128 + signal);
}

static void Child(size_t kind, const char file[], int out)
{
  struct sigaction hang = {.sa_handler = Crash, .sa_flags = (int)SA_NODEFER};
  PetscErrorCode code;

  sigaction(SIGALRM, &hang, NULL); /* within itself too, where the report hangs */
  alarm(timeout);
  signal(SIGSEGV, Crash);
  signal(SIGBUS, Crash);
  signal(SIGFPE, Crash);
  signal(SIGABRT, Crash);
  (void)PetscPushErrorHandler(Keep, NULL);
  code = Kinds[kind].read(file);
  for (char *c = message; *c; c++)
    if ((unsigned char)*c < ' ') *c = '?';
  (void)!write(out, message, strlen(message));
  _exit(code ? initial : 0);
}

/* Until the child has something to say or ends: one that takes far too much memory is killed before it takes that of
   others. */
static void Guard(pid_t child, int said)
{
  struct pollfd ready = {.fd = said, .events = POLLIN};
  char name[64];

  snprintf(name, sizeof(name), "/proc/%d/statm", (int)child);
  while (!poll(&ready, 1, 20)) {
    FILE *f = fopen(name, "r");
    long size = 0, resident = 0;

    if (f && fscanf(f, "%ld %ld", &size, &resident) == 2 && resident > most / sysconf(_SC_PAGESIZE))
      kill(child, SIGKILL);
    if (f) fclose(f);
  }
}

static PetscErrorCode Report(size_t kind, const char file[])
{
  char text[512] = "";
  struct rusage used;
  struct timeval begin, end;
  int status, ends[2];
  ssize_t n;
  pid_t child;

  PetscCheck(!pipe(ends), PETSC_COMM_SELF, PETSC_ERR_SYS, "no pipe");
  gettimeofday(&begin, NULL);
  child = fork();
  if (!child) {
    close(ends[0]);
    Child(kind, file, ends[1]);
  }
  close(ends[1]);
  Guard(child, ends[0]);
  n = read(ends[0], text, sizeof(text) - 1);
  text[n > 0 ? n : 0] = '\0';
  close(ends[0]);
  PetscCheck(wait4(child, &status, 0, &used) == child, PETSC_COMM_SELF, PETSC_ERR_SYS, "no child");
  gettimeofday(&end, NULL);
  printf("%s\t", file);
  if (WIFSIGNALED(status))
    printf("signal %d", WTERMSIG(status));
  else if (WEXITSTATUS(status) > initial)
    printf("exit %d", WEXITSTATUS(status));
  else
    printf("%s", WEXITSTATUS(status) ? "refused" : "accepted");
  printf("\t%.2f\t%ld\t%s\n", (double)(end.tv_sec - begin.tv_sec) + 1e-6 * (double)(end.tv_usec - begin.tv_usec),
         used.ru_maxrss, text);
  fflush(stdout);
  return PETSC_SUCCESS;
}

int main(int argc, char **argv)
{
  char file[PETSC_MAX_PATH_LEN];
  size_t kind = 0;
  void *frame;

  PetscCall(PetscInitialize(NULL, NULL, NULL, NULL));
  PetscCall(SlipStepInitializePackage());
  PetscCall(PetscPopSignalHandler());
  (void)backtrace(&frame, 1); /* loads what it needs while that is safe */
  while (kind < sizeof(Kinds) / sizeof(*Kinds) && (argc < 2 || strcmp(argv[1], Kinds[kind].name))) kind++;
  PetscCheck(kind < sizeof(Kinds) / sizeof(*Kinds), PETSC_COMM_SELF, PETSC_ERR_ARG_WRONG,
             "expected fuzz KIND, with a row of its table");
  if (argc == 4 && Kinds[kind].make) PetscCall(Kinds[kind].make(argv[3]));
  while (argc == 2 && fgets(file, sizeof(file), stdin)) {
    file[strcspn(file, "\n")] = '\0';
    PetscCall(Report(kind, file));
  }
  return PetscFinalize();
}
