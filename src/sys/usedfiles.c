/* Checks that no file is used twice among all files that a run reads and writes. */
#define _XOPEN_SOURCE 700 /* realpath() */
#include <slipstep/private/slipsys.h>
#include <slipstep/rooms/slipsys.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

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
PetscErrorCode SlipFilesCheckNames(MPI_Comm comm, PetscInt n, const SlipNamedFile file[])
{
  PetscErrorCode ierr = PETSC_SUCCESS;
  PetscMPIInt rank;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  if (!rank) ierr = SlipFilesCompare(n, file);
  PetscCall(SlipErrorBcast(comm, ierr));
  PetscFunctionReturn(PETSC_SUCCESS);
}
