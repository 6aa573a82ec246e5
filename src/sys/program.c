/* The start of a program: PetscInitialize() with errors of one line, -version, and -help with only our options */
#define _POSIX_C_SOURCE 200809L /* setenv() */
#include <slipstep/rooms/slipsys.h>
#include <slipcompat.h>
#include <slipstep/rooms/slipblas.h>
#include <slipstep/private/slipsys.h>
#include <hdf5.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

/* ---- -version ---- */

/* With -version prints the versions of all libraries, on one process, and ends the program. PETSc is not initialised,
   because it would print its own. */
static void SlipProgramShowVersion(int *argc, char ***argv, const char program[])
{
  static const char *const names[] = {"-version", "--version", "-slipstep_version"};
  PetscBool wanted = PETSC_FALSE;
  PetscInt major = 0, minor = 0, patch = 0;
  unsigned h5[3] = {0, 0, 0};
  char mpi[MPI_MAX_LIBRARY_VERSION_STRING] = "";
  int rank = 0, len = 0;

  for (int i = 1; i < *argc; i++)
    for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(names); k++)
      if (!strcmp((*argv)[i], names[k])) wanted = PETSC_TRUE;
  if (!wanted) return;
  if (MPI_Init(argc, argv)) exit(EXIT_FAILURE);
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Get_library_version(mpi, &len);
  mpi[strcspn(mpi, "\n")] = '\0';
  if (!rank && !PetscGetVersionNumber(&major, &minor, &patch, NULL) && H5get_libversion(&h5[0], &h5[1], &h5[2]) >= 0)
    printf("%s of SlipStep %s\nPETSc %d.%d.%d\nMPI: %s\nHDF5 %u.%u.%u\n", program, SLIPSTEP_VERSION, (int)major,
           (int)minor, (int)patch, mpi, h5[0], h5[1], h5[2]);
  fflush(stdout);
  MPI_Finalize();
  exit(EXIT_SUCCESS);
}

/* ---- -help PROGRAM ---- */

/* Help is printed line by line, without unlisted options of PETSc, and without headings that then have none. */
static struct {
  char line[4096], heading[4096];
  PetscBool shown; /* the last option was printed */
} SlipHelp;

/* The name of the option in a line "  -name: ..." or "  -name <now ...", else NULL */
static const char *SlipHelpOption(const char line[], char name[], size_t len)
{
  const char *dash = line + strspn(line, " ");
  size_t n;

  if (dash[0] != '-' || dash[1] == '-') return NULL;
  n = strcspn(dash + 1, ": <\n");
  if (!n || n >= len) return NULL;
  memcpy(name, dash + 1, n);
  name[n] = '\0';
  return name;
}

static void SlipHelpLine(const char line[])
{
  char name[128];

  if (SlipHelpOption(line, name, sizeof(name))) {
    SlipHelp.shown = SlipIsHelpOption(name);
    if (!SlipHelp.shown) return;
    fputs(SlipHelp.heading, stdout);
    SlipHelp.heading[0] = '\0';
    fputs(line, stdout);
  } else if (!strncmp(line, "    ", 4)) { /* continuation of an option */
    if (SlipHelp.shown) fputs(line, stdout);
  } else if (line[0] != '-' && line[0] != '\n')
    (void)snprintf(SlipHelp.heading, sizeof(SlipHelp.heading), "%s", line);
}

static PetscErrorCode (*print)(FILE *, const char[], va_list); /* PETSc's own function */

/* Replaces PetscVFPrintf, by which PETSc prints help in pieces of lines */
static PetscErrorCode SlipHelpPrint(FILE *file, const char format[], va_list args)
{
  const size_t size = sizeof(SlipHelp.line), before = strlen(SlipHelp.line);
  char *end;

  PetscFunctionBegin;
  if (file != stdout) {
    PetscCall((*print)(file, format, args));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(PetscVSNPrintf(SlipHelp.line + before, size - before, format, NULL, args));
  while ((end = strchr(SlipHelp.line, '\n'))) {
    char rest[sizeof(SlipHelp.line)];

    (void)snprintf(rest, sizeof(rest), "%s", end + 1);
    end[1] = '\0';
    SlipHelpLine(SlipHelp.line);
    (void)snprintf(SlipHelp.line, size, "%s", rest);
  }
  if (strlen(SlipHelp.line) > size / 2) SlipHelp.line[0] = '\0'; /* longer than any line of options */
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Removes the program's name after -help, which PETSc would refuse there. */
static PetscBool SlipProgramTakeHelp(int *argc, char **argv, const char program[], const char file[])
{
  for (int i = 1; i + 1 < *argc; i++) {
    if (strcmp(argv[i], "-help") || (strcmp(argv[i + 1], program) && strcmp(argv[i + 1], file))) continue;
    for (int k = i + 1; k < *argc; k++) argv[k] = argv[k + 1];
    (*argc)--;
    return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* Help may be piped to a pager that quits early. PETSc's handler turns this into a long error, and only an option
   disables it before PetscInitialize(), which prints most of the help. */
static void SlipProgramLeavePagers(int argc, char **argv)
{
  const char *options = getenv("PETSC_OPTIONS");
  char more[4096];

  for (int i = 1; i < argc; i++) {
    if (strcmp(argv[i], "-help") && strcmp(argv[i], "-h")) continue;
    if (snprintf(more, sizeof(more), "%s -no_signal_handler", options ? options : "") < (int)sizeof(more))
      (void)setenv("PETSC_OPTIONS", more, 1);
    return;
  }
}

/* ---- options before a file of options ---- */

/* PETSc reads -options_file at its position: values in the file replace earlier ones. No option has been read yet. */
static PetscErrorCode SlipProgramWarnOfFiles(int argc, char **argv)
{
  PetscInt n;
  char **names, **values;
  int last = 0;

  PetscFunctionBegin;
  for (int i = 1; i < argc; i++)
    if (!strcasecmp(argv[i], "-options_file")) last = i;
  PetscCall(PetscOptionsLeftGet(NULL, &n, &names, &values));
  for (int i = 1; i < last; i++) {
    PetscBool key, more, again = PETSC_FALSE;
    const char *value = "";

    PetscCall(PetscOptionsValidKey(argv[i], &key));
    if (!key || !strcasecmp(argv[i], "-options_file")) continue;
    for (int k = i + 1; k < argc; k++)
      if (!strcasecmp(argv[k], argv[i])) again = PETSC_TRUE; /* the last one takes effect */
    PetscCall(PetscOptionsValidKey(argv[i + 1], &more));
    if (!more) value = argv[i + 1];
    for (PetscInt k = 0; k < n && !again; k++)
      if (!strcasecmp(names[k], argv[i] + 1) && strcmp(values[k] ? values[k] : "", value))
        PetscCall(SlipWarning(
          "%s %s has no effect: it stands before -options_file, whose %s %s replaces it. Give it behind the "
          "file",
          argv[i], value, argv[i], values[k] ? values[k] : ""));
  }
  PetscCall(PetscOptionsLeftRestore(NULL, &n, &names, &values));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the beginning ---- */

/* Sets one BLAS thread per rank unless the user has chosen a number: our blocks are too small for more, which would
   only cost processor time. */
static void SlipProgramLimitBLAS(void)
{
  static const char *const said[] = {"OPENBLAS_NUM_THREADS", "GOTO_NUM_THREADS", "MKL_NUM_THREADS", "BLIS_NUM_THREADS",
                                     "OMP_NUM_THREADS"};

  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(said); i++)
    if (getenv(said[i])) return;
  SlipBLASSetNumThreads(1);
}

/*@C
  SlipProgramInitialize - calls PetscInitialize() for a program of SlipStep: errors end it with one line, -version
  prints the versions of all libraries, and -help with the program's name prints only the options of SlipStep

  Collective on MPI_COMM_WORLD; replaces PetscInitialize().

  Input Parameters:
+ argc    - of main()
. argv    - of main()
. program - its name
- help    - description, for -help

  Options Database Keys:
+ -version        - print the versions of SlipStep, PETSc, MPI and HDF5, and end with exit code 0; also --version
. -help           - print all options, those of PETSc as well
- -help <program> - print those of SlipStep, also with its file name, and the few of PETSc that every run needs

  Level: intermediate

  Notes:
  Each process has one BLAS thread, unless OPENBLAS_NUM_THREADS, MKL_NUM_THREADS, BLIS_NUM_THREADS or OMP_NUM_THREADS
  sets another number.

  It calls SlipErrorHandlerPush(). An unreadable file of -options_file is one line of error, too, and there is a warning
  for each option before it that has another value in the file, because PETSc uses that of the file. SIGPIPE is handled
  as before PetscInitialize(): a program whose output is not read any more ends without a message.

.seealso: SlipErrorHandlerPush(), SlipStepInitializePackage(), SlipCheckOptionNames()
@*/
PetscErrorCode SlipProgramInitialize(int *argc, char ***argv, const char program[], const char help[])
{
  static char text[8192]; /* PETSc stores the pointer until it prints the text */
  const char *path = *argc > 0 ? (*argv)[0] : program, *slash = strrchr(path, '/');
  const char *file = slash ? slash + 1 : path; /* such as slipstep-fault */
  struct sigaction pipes;
  PetscBool own;

  PetscFunctionBegin;
  SlipProgramShowVersion(argc, argv, program);
  SlipProgramLeavePagers(*argc, *argv);
  own = SlipProgramTakeHelp(argc, *argv, program, file);
  PetscCall(SlipErrorHandlerBegin());
  if (own) {
    print = PetscVFPrintf;
    PetscVFPrintf = SlipHelpPrint;
  }
  (void)snprintf(text, sizeof(text),
                 "%s -help %s prints the options of SlipStep alone, %s -help those of PETSc as well. -options_file F "
                 "reads options from a file, -version prints the version.\n\n%s",
                 file, file, file, help);
  (void)sigaction(SIGPIPE, NULL, &pipes);
  /* Open MPI's hwloc would load the drivers of OpenCL, which takes a third of the start and changes signal handlers. */
  (void)setenv("HWLOC_COMPONENTS", "-opencl", 0);
  PetscCall(PetscInitialize(argc, argv, NULL, text));
  SlipProgramLimitBLAS();
  (void)sigaction(SIGPIPE, &pipes, NULL); /* a program ends quietly if its output is not read to the end, as by head */
  if (own && !PetscGlobalRank) fputs(text, stdout);
  PetscCall(SlipErrorHandlerPush(program));
  PetscCall(SlipCheckIntegers(PETSC_COMM_WORLD, NULL));
  if (!PetscGlobalRank) PetscCall(SlipProgramWarnOfFiles(*argc, *argv));
  PetscFunctionReturn(PETSC_SUCCESS);
}
