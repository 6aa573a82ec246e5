/* Checks the names of all files that a fault's run reads and writes, before one is opened. */
#define _XOPEN_SOURCE 700 /* realpath() */
#include <slipstep/private/sliprun.h>
#include <slipstep/rooms/slipsys.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/* ---- names that refer to one file ---- */

#define SLIP_FILE_ENDINGS 8
typedef struct {
  char option[96];               /* option that names it, with its dash */
  char name[PETSC_MAX_PATH_LEN]; /* "": no file */
  const char
    *endings[SLIP_FILE_ENDINGS + 1]; /* what the run appends to the name: "" for the file itself; ended by NULL */
  PetscBool written;                 /* or only read */
  PetscInt family;                   /* files of one family may be the same file; 0: none */
} SlipNamedFile;

/* The file that a name refers to, one of several */
typedef struct {
  PetscInt owner;
  char path[PETSC_MAX_PATH_LEN]; /* without links and dots, as far as its folder exists */
  PetscBool exists;
  dev_t device;
  ino_t number;
} SlipFilePlace;

/* Finds the file NAME + ENDING and resolves links. */
static PetscErrorCode SlipFileFind(const SlipNamedFile *f, const char ending[], SlipFilePlace *place)
{
  char target[PETSC_MAX_PATH_LEN], folder[PETSC_MAX_PATH_LEN], source[128], *slash, *real;
  struct stat info;

  PetscFunctionBegin;
  PetscCall(PetscSNPrintf(source, sizeof(source), " (%s)", f->option));
  PetscCall(SlipH5Follow(f->name, source, target));
  PetscCall(PetscStrlcat(target, ending, sizeof(target)));
  PetscCall(PetscStrncpy(folder, target, sizeof(folder)));
  slash = strrchr(folder, '/');
  if (slash) slash[slash == folder ? 1 : 0] = '\0';
  real = realpath(slash ? folder : ".", NULL);
  slash = strrchr(target, '/');
  if (real)
    PetscCall(PetscSNPrintf(place->path, sizeof(place->path), "%s/%s", strcmp(real, "/") ? real : "",
                            slash ? slash + 1 : target));
  else
    PetscCall(PetscStrncpy(place->path, target, sizeof(place->path)));
  free(real);
  place->exists = stat(target, &info) ? PETSC_FALSE : PETSC_TRUE;
  if (place->exists) place->device = info.st_dev;
  if (place->exists) place->number = info.st_ino;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscBool SlipFileIsSame(const SlipFilePlace *a, const SlipFilePlace *b)
{
  if (!strcmp(a->path, b->path)) return PETSC_TRUE;
  return a->exists && b->exists && a->device == b->device && a->number == b->number ? PETSC_TRUE : PETSC_FALSE;
}

static PetscErrorCode SlipFilesCompare(PetscInt n, const SlipNamedFile file[])
{
  const SlipNamedFile *pair[2] = {NULL, NULL};
  char path[PETSC_MAX_PATH_LEN] = "";
  SlipFilePlace *place;
  PetscInt m = 0;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(n * SLIP_FILE_ENDINGS, &place));
  for (PetscInt i = 0; i < n; i++)
    for (PetscInt e = 0; e < SLIP_FILE_ENDINGS && file[i].name[0] && file[i].endings[e]; e++, m++) {
      place[m].owner = i;
      PetscCall(SlipFileFind(&file[i], file[i].endings[e], &place[m]));
      for (PetscInt k = 0; k < m && !pair[0]; k++) {
        const SlipNamedFile *a = &file[place[k].owner], *b = &file[i];

        if (a == b || !(a->written || b->written) || (a->family && a->family == b->family)) continue;
        if (!SlipFileIsSame(&place[k], &place[m])) continue;
        pair[0] = a;
        pair[1] = b;
        PetscCall(PetscStrncpy(path, place[m].path, PETSC_MAX_PATH_LEN));
      }
    }
  PetscCall(PetscFree(place));
  PetscCheck(!pair[0], PETSC_COMM_SELF, PETSC_ERR_FILE_OPEN,
             "%s %s and %s %s are of one file, %s: expected names that differ", pair[0]->option, pair[0]->name,
             pair[1]->option, pair[1]->name, path);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Collective; rank 0 checks. PETSC_ERR_FILE_OPEN if two names, one of them an output, refer to the same file. */
static PetscErrorCode SlipFilesCheckNames(MPI_Comm comm, PetscInt n, const SlipNamedFile file[])
{
  PetscErrorCode ierr = PETSC_SUCCESS;
  PetscMPIInt rank;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  if (!rank) ierr = SlipFilesCompare(n, file);
  PetscCall(SlipErrorBcast(comm, ierr));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the files of a run ---- */

/* Files of one family may be the same: a run may continue from the checkpoint that it writes. */
#define FAMILY_STATE 1

/* Endings of a file that is written. Locks beside it protect temporary files (h5output.c); the checkpoint before stays.
   */
#define GROWING "", ".part", ".part.new"

/* Options that are no strings of the fault: those of viewers, TYPE:FILE[:FORMAT], and others that are only looked up
   here, after the report of unused options */
#define A_VIEWER FAULT_NUM_STRINGS
#define ANOTHER (FAULT_NUM_STRINGS + 1)

/* Options of files, and the endings that the run adds to a name */
static const struct {
  const char *option;
  PetscInt id;
  PetscBool written;
  PetscInt family;
  const char *endings[SLIP_FILE_ENDINGS + 1];
} SlipFaultFiles[] = {
  {"fault_mesh", FAULT_MESH, PETSC_FALSE, 0, {""}},
  {"fault_parameters", FAULT_PARAMETERS, PETSC_FALSE, 0, {""}},
  {"fault_stiffness_file", FAULT_STIFFNESS_FILE, PETSC_FALSE, 0, {""}},
  {"fault_pore_pressure", FAULT_PORE_PRESSURE, PETSC_FALSE, 0, {""}},
  {"fault_stress_history", FAULT_STRESS_HISTORY, PETSC_FALSE, 0, {""}},
  {"fault_wells", FAULT_WELLS, PETSC_FALSE, 0, {""}},
  {"fault_stations", FAULT_STATIONS, PETSC_FALSE, 0, {""}}, /* or a list without a file */
  {"fault_surface_stations", FAULT_SURFACE_STATIONS, PETSC_FALSE, 0, {""}},
  {"fault_tolerances", FAULT_TOLERANCES, PETSC_FALSE, 0, {""}},
  {"fault_estimates", FAULT_ESTIMATES, PETSC_FALSE, 0, {""}},
  {"ts_adapt_rl_policy", ANOTHER, PETSC_FALSE, 0, {""}},
  {"fault_stop_file", FAULT_STOP_FILE, PETSC_FALSE, 0, {""}},
  {"fault_restart", FAULT_RESTART, PETSC_FALSE, FAMILY_STATE, {"", ".previous"}},
  {"fault_output", FAULT_OUTPUT, PETSC_TRUE, 0, {GROWING, ".xdmf2", ".part.xdmf2"}},
  {"fault_catalogue", FAULT_CATALOGUE, PETSC_TRUE, 0, {GROWING}},
  {"fault_checkpoint", FAULT_CHECKPOINT, PETSC_TRUE, FAMILY_STATE, {"", ".previous", ".part.new"}},
  {"fault_stiffness_view", A_VIEWER, PETSC_TRUE, 0, {""}},
  {"fault_view", A_VIEWER, PETSC_TRUE, 0, {""}},
  {"log_view", A_VIEWER, PETSC_TRUE, 0, {""}},
};
enum { NUM_FILES = PETSC_STATIC_ARRAY_LENGTH(SlipFaultFiles) };

/* Gets the file of a viewer, TYPE:FILE[:FORMAT], or "". */
static PetscErrorCode ViewedFile(char value[], char file[PETSC_MAX_PATH_LEN])
{
  char *begin = strchr(value, ':'), *end;

  PetscFunctionBegin;
  file[0] = '\0';
  if (!begin) PetscFunctionReturn(PETSC_SUCCESS);
  end = strchr(begin + 1, ':');
  if (end) *end = '\0';
  PetscCall(PetscStrncpy(file, begin + 1, PETSC_MAX_PATH_LEN));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reports PETSC_ERR_FILE_OPEN when two options name one file that one of them writes. Collective. */
PetscErrorCode SlipFaultCheckFileNames(SlipFault fault)
{
  SlipNamedFile *file;

  PetscFunctionBegin;
  PetscCall(PetscCalloc1(NUM_FILES, &file));
  for (PetscInt i = 0; i < (PetscInt)NUM_FILES; i++) {
    const char *option = SlipFaultFiles[i].option;
    char *dataset = NULL;

    PetscCall(PetscSNPrintf(file[i].option, sizeof(file[i].option), "-%s%s",
                            strncmp(option, "fault_", 6) ? "" : SlipFaultPrefix(fault), option));
    if (SlipFaultFiles[i].id < FAULT_NUM_STRINGS)
      PetscCall(PetscStrncpy(file[i].name, fault->options.text[SlipFaultFiles[i].id], sizeof(file[i].name)));
    else if (SlipFaultFiles[i].id == A_VIEWER || fault->setup) {
      char value[PETSC_MAX_PATH_LEN] = "", name[96];

      PetscCall(PetscSNPrintf(name, sizeof(name), "-%s", option));
      PetscCall(PetscOptionsGetString(((PetscObject)fault)->options,
                                      strncmp(option, "fault_", 6) ? NULL : ((PetscObject)fault)->prefix, name, value,
                                      sizeof(value), NULL));
      if (SlipFaultFiles[i].id == A_VIEWER)
        PetscCall(ViewedFile(value, file[i].name));
      else
        PetscCall(PetscStrncpy(file[i].name, value, PETSC_MAX_PATH_LEN));
    }
    if (SlipFaultFiles[i].id == FAULT_STIFFNESS_FILE) dataset = strstr(file[i].name, ":/");
    if (dataset) *dataset = '\0';
    file[i].written = SlipFaultFiles[i].written;
    file[i].family = SlipFaultFiles[i].family;
    for (PetscInt e = 0; e < SLIP_FILE_ENDINGS; e++) file[i].endings[e] = SlipFaultFiles[i].endings[e];
  }
  PetscCall(SlipFilesCheckNames(fault->comm, NUM_FILES, file));
  PetscCall(PetscFree(file));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets the file that an option of a run in a sweep writes, or ""; a view may be appended to a file. */
static PetscErrorCode FileOfRun(PetscOptions options, PetscInt row, char file[PETSC_MAX_PATH_LEN])
{
  char name[96], value[PETSC_MAX_PATH_LEN] = "", *append;

  PetscFunctionBegin;
  file[0] = '\0';
  if (!SlipFaultFiles[row].written || strncmp(SlipFaultFiles[row].option, "fault_", 6))
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscSNPrintf(name, sizeof(name), "-%s", SlipFaultFiles[row].option));
  PetscCall(PetscOptionsGetString(options, NULL, name, value, sizeof(value), NULL));
  append = strstr(value, ":append");
  if (SlipFaultFiles[row].id != A_VIEWER)
    PetscCall(PetscStrncpy(file, value, PETSC_MAX_PATH_LEN));
  else if (!append)
    PetscCall(ViewedFile(value, file));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipFaultCheckSweepFiles - refuses runs of which one would overwrite a file of another one

  Collective; before the first run of a sweep

  Input Parameters:
+ comm    - the processes
. n       - number of runs
. options - [n] the options of each run, with -fault_output, -fault_catalogue, -fault_checkpoint and viewers of files
- line    - [n] number of the line that each comes from, for the message

  Level: advanced

  Note:
  A run that continues (-fault_restart) from the checkpoint of an earlier one may continue its files.

  Errors: PETSC_ERR_FILE_OPEN, with both lines, when two runs write one file; links and endings that runs add are
  included

.seealso: SlipFaultSetFromOptions(), SlipFaultOutputStart()
@*/
PetscErrorCode SlipFaultCheckSweepFiles(MPI_Comm comm, PetscInt n, const PetscOptions options[], const PetscInt line[])
{
  SlipNamedFile *file;
  PetscInt m = 0, *family;

  PetscFunctionBegin;
  PetscCall(PetscCalloc1(n * NUM_FILES, &file));
  PetscCall(PetscMalloc1(n, &family));
  for (PetscInt k = 0; k < n; k++) {
    char restart[PETSC_MAX_PATH_LEN] = "", checkpoint[PETSC_MAX_PATH_LEN];
    PetscBool same;

    family[k] = k + 1; /* an earlier run from whose checkpoint this one continues may write the same files */
    PetscCall(PetscOptionsGetString(options[k], NULL, "-fault_restart", restart, sizeof(restart), NULL));
    for (PetscInt j = 0; j < k && restart[0]; j++) {
      checkpoint[0] = '\0';
      PetscCall(PetscOptionsGetString(options[j], NULL, "-fault_checkpoint", checkpoint, sizeof(checkpoint), NULL));
      PetscCall(PetscStrcmp(restart, checkpoint, &same));
      if (same) family[k] = family[j];
    }
    for (PetscInt i = 0; i < (PetscInt)NUM_FILES; i++) {
      PetscCall(FileOfRun(options[k], i, file[m].name));
      if (!file[m].name[0]) continue;
      PetscCall(PetscSNPrintf(file[m].option, sizeof(file[m].option), "line %" PetscInt_FMT " of -fault_sweep: -%s",
                              line[k], SlipFaultFiles[i].option));
      file[m].written = PETSC_TRUE;
      file[m].family = family[k];
      for (PetscInt e = 0; e < SLIP_FILE_ENDINGS; e++) file[m].endings[e] = SlipFaultFiles[i].endings[e];
      m++;
    }
  }
  PetscCall(SlipFilesCheckNames(comm, m, file));
  PetscCall(PetscFree(family));
  PetscCall(PetscFree(file));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultFindEarlier(SlipFault fault, const char file[], const char what[], PetscBool say,
                                    char found[PETSC_MAX_PATH_LEN + 8])
{
  char target[PETSC_MAX_PATH_LEN] = "", part[PETSC_MAX_PATH_LEN + 8];
  PetscBool exists[2] = {PETSC_FALSE, PETSC_FALSE};
  PetscErrorCode ierr = PETSC_SUCCESS;
  PetscMPIInt rank;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(fault->comm, &rank));
  if (!rank) ierr = SlipH5Follow(file, "", target);
  PetscCall(SlipErrorBcast(fault->comm, ierr));
  PetscCall(PetscSNPrintf(part, sizeof(part), "%s.part", target));
  if (!rank) {
    PetscCall(PetscTestFile(part, 'r', &exists[0]));
    PetscCall(PetscTestFile(file, 'r', &exists[1]));
  }
  PetscCallMPI(MPI_Bcast(exists, 2, MPIU_BOOL, 0, fault->comm));
  PetscCall(PetscStrncpy(found, exists[0] ? part : exists[1] ? file : "", PETSC_MAX_PATH_LEN + 8));
  if (!found[0] && say)
    PetscCall(PetscPrintf(fault->comm, "Neither %s nor %s is there: the %s begins here\n", part, file, what));
  PetscFunctionReturn(PETSC_SUCCESS);
}
