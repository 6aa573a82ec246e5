/* Reads the tolerances at which controllers satisfy accuracies from a file (training/policies/README.md): rank 0 reads,
   and all ranks get its numbers and its errors. */
#include <slipstep/private/slipfault.h>
#include <slipstep/private/slippolicy.h>
#include <math.h>
#include <string.h>

#define TOLERANCES_FORMAT "slipstep-tolerances"
#define TOLERANCES_VERSION 2 /* version 1 stored only results of the training runs */

static PetscErrorCode ReadKind(SlipH5 *h, const char kind[], SlipFaultTolerances *t)
{
  char path[3][128], **names = NULL;
  PetscInt want[2], dims[2] = {0, 0}, n;
  PetscReal *accuracy = NULL, *rtol = NULL;
  PetscBool has;
  PetscErrorCode ierr;

  PetscFunctionBegin;
  PetscCall(PetscSNPrintf(path[0], sizeof(path[0]), "/%s", kind));
  PetscCall(SlipH5Has(h, path[0], &has));
  PetscCheck(has, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
             "%s has no group /%s, which has the tolerances of such a run: -ts_rtol sets one%s", h->name, kind,
             h->source);
  PetscCall(PetscSNPrintf(path[0], sizeof(path[0]), "/%s/accuracy", kind));
  PetscCall(PetscSNPrintf(path[1], sizeof(path[1]), "/%s/controllers", kind));
  PetscCall(PetscSNPrintf(path[2], sizeof(path[2]), "/%s/rtol", kind));
  PetscCall(SlipH5ReadStrings(h, path[1], &n, &names));
  ierr = SlipH5ReadReal(h, path[0], 1, dims, &accuracy);
  want[0] = n;
  want[1] = dims[0];
  if (!ierr) ierr = SlipH5ReadRealSized(h, path[2], 2, want, "a row a controller, a column an accuracy", dims, &rtol);
  if (!ierr && n >= 1 && n <= TOLERANCES_MOST && want[1] >= 2 && want[1] <= TOLERANCES_MOST) {
    t->controllers = n;
    t->accuracies = want[1];
    ierr = PetscArraycpy(t->accuracy, accuracy, t->accuracies);
    for (PetscInt c = 0; c < n && !ierr; c++) {
      ierr = PetscStrncpy(t->row[c].controller, names[c], sizeof(t->row[c].controller));
      for (PetscInt a = 0; a < t->accuracies; a++) t->row[c].rtol[a] = rtol[c * t->accuracies + a];
    }
  }
  PetscCall(SlipH5FreeStrings(n, &names));
  PetscCall(PetscFree(accuracy));
  PetscCall(PetscFree(rtol));
  PetscCall(ierr);
  PetscCheck(t->controllers, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
             "%s: %s has shape [%" PetscInt_FMT ", %" PetscInt_FMT "], expected 1 to %d controllers and 2 to %d "
             "accuracies%s",
             h->name, path[2], n, want[1], (int)TOLERANCES_MOST, (int)TOLERANCES_MOST, h->source);
  for (PetscInt a = 0; a < t->accuracies; a++)
    PetscCheck(isfinite(t->accuracy[a]) && t->accuracy[a] > 0 && (!a || t->accuracy[a] < t->accuracy[a - 1]),
               PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
               "%s: number %" PetscInt_FMT " of /%s/accuracy is %g; expected numbers > 0 that fall%s", h->name, a, kind,
               (double)t->accuracy[a], h->source);
  for (PetscInt c = 0; c < t->controllers; c++)
    for (PetscInt a = 0; a < t->accuracies; a++)
      PetscCheck(isfinite(t->row[c].rtol[a]) && t->row[c].rtol[a] >= 0 &&
                   (!a || t->row[c].rtol[a] <= t->row[c].rtol[a - 1]),
                 PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
                 "%s: number %" PetscInt_FMT ", %" PetscInt_FMT
                 " of /%s/rtol is %g; expected numbers >= 0 that do not rise along a row%s",
                 h->name, c, a, kind, (double)t->row[c].rtol[a], h->source);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadFile(const char prefix[], const char file[], const char kind[], SlipFaultTolerances *t)
{
  SlipH5 h;
  PetscErrorCode ierr;

  PetscFunctionBegin;
  if (file[0])
    PetscCall(SlipH5OpenReadOption(prefix, "fault_tolerances", file, &h));
  else
    PetscCall(SlipPolicyOpenData("tolerances.h5", "the tolerances that keep -fault_accuracy (-ts_rtol sets one)", &h));
  ierr = SlipPolicyCheckFormat(&h, TOLERANCES_FORMAT, TOLERANCES_VERSION);
  if (!ierr) ierr = ReadKind(&h, kind, t);
  PetscCall(SlipH5Close(&h));
  PetscCall(ierr);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads the tolerances of a kind of runs. Collective. file "": the library's, or that of SLIPSTEP_POLICY_DIR */
PetscErrorCode SlipFaultTolerancesRead(MPI_Comm comm, const char prefix[], const char file[], const char kind[],
                                       SlipFaultTolerances *t)
{
  PetscErrorCode ierr = PETSC_SUCCESS;
  PetscMPIInt rank;

  PetscFunctionBegin;
  PetscCall(PetscMemzero(t, sizeof(*t)));
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  if (!rank) ierr = ReadFile(prefix, file, kind, t);
  PetscCall(SlipErrorBcast(comm, ierr));
  PetscCallMPI(MPI_Bcast(t, (PetscMPIInt)sizeof(*t), MPI_BYTE, 0, comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Interpolates logarithms between two columns. The result is negative beyond the last accuracy that the controller
   satisfies, by the slope before it, and 0 where it does not satisfy two such columns. */
static PetscReal Interpolate(const SlipFaultTolerances *t, const PetscReal rtol[], PetscReal accuracy)
{
  PetscInt k = 0;
  PetscReal share, found;

  while (k + 2 < t->accuracies && rtol[k + 2] > 0 && accuracy < t->accuracy[k + 1]) k++;
  if (rtol[k + 1] <= 0) return accuracy >= t->accuracy[k] ? rtol[k] : 0;
  share = PetscLogReal(accuracy / t->accuracy[k]) / PetscLogReal(t->accuracy[k + 1] / t->accuracy[k]);
  found = rtol[k] * PetscPowReal(rtol[k + 1] / rtol[k], share);
  return share > 1 ? -found : found;
}

/* Returns the row of a controller. A type without a filter may match with its default one. -1: there is none. */
static PetscInt RowOf(const SlipFaultTolerances *t, const char controller[])
{
  const size_t type = strcspn(controller, ":");

  for (PetscInt i = 0; i < t->controllers; i++)
    if (!strcmp(t->row[i].controller, controller)) return i;
  for (PetscInt i = 0; i < t->controllers; i++)
    if (strlen(t->row[i].controller) == type && !strncmp(t->row[i].controller, controller, type)) return i;
  return -1;
}

/* Returns the tolerance of a controller for an accuracy; 0: there is no such controller. */
PetscReal SlipFaultTolerancesFind(const SlipFaultTolerances *t, const char controller[], PetscReal accuracy)
{
  const PetscInt row = RowOf(t, controller);

  return row < 0 ? 0 : Interpolate(t, t->row[row].rtol, accuracy);
}

/* Returns the accuracy that a tolerance satisfies, the finest one of the file for a tighter tolerance; 0: none is
   established. */
PetscReal SlipFaultTolerancesAccuracy(const SlipFaultTolerances *t, const char controller[], PetscReal rtol)
{
  const PetscInt row = RowOf(t, controller);
  const PetscReal *kept = row < 0 ? NULL : t->row[row].rtol;
  PetscInt k = 0;

  if (row < 0 || rtol <= 0 || rtol > kept[0] * (1 + PETSC_SMALL)) return 0;
  while (k + 1 < t->accuracies && kept[k + 1] > 0 && rtol <= kept[k + 1] * (1 + PETSC_SMALL)) k++;
  if (k + 1 == t->accuracies || kept[k + 1] <= 0) return t->accuracy[k];
  return t->accuracy[k] * PetscPowReal(t->accuracy[k + 1] / t->accuracy[k],
                                       PetscLogReal(rtol / kept[k]) / PetscLogReal(kept[k + 1] / kept[k]));
}
