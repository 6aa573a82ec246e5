/* Numbers in a policy file, and checks of a checkpoint that is resumed. */
#include "files.h"
#include <slipcompat.h>

PetscErrorCode PolicySetNumber(SlipPolicy p, const char name[], const char format[], double value)
{
  char text[64];

  PetscFunctionBegin;
  PetscCall(PetscSNPrintf(text, sizeof(text), format, value));
  PetscCall(SlipPolicySetAttribute(p, name, text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CheckpointCheckFormat(SlipH5 *h, const char format[], const char kind[])
{
  char found[64] = "";
  PetscBool has, same;

  PetscFunctionBegin;
  PetscCall(SlipH5HasAttribute(h, "/", "format", &has));
  if (has) PetscCall(SlipH5ReadAttrString(h, "/", "format", found, sizeof(found)));
  PetscCall(PetscStrcmp(found, format, &same));
  PetscCheck(same, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
             "-train_resume %s is no checkpoint%s (attribute format is \"%s\"); expected a file of -train_checkpoint",
             h->name, kind, found);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CheckpointCheckObservations(SlipH5 *h, PetscInt n, char *const names[])
{
  char **found;
  PetscInt nfound;
  PetscBool same;

  PetscFunctionBegin;
  PetscCall(SlipH5ReadStrings(h, "/observations", &nfound, &found));
  same = n == nfound ? PETSC_TRUE : PETSC_FALSE;
  for (PetscInt i = 0; same && i < n; ++i) PetscCall(PetscStrcmp(found[i], names[i], &same));
  PetscCheck(same, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
             "-train_resume %s was trained on other observations than -train_observations names", h->name);
  PetscCall(SlipH5FreeStrings(nfound, &found));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* data [n], to be freed */
PetscErrorCode CheckpointReadFixed(SlipH5 *h, const char path[], PetscInt n, PetscReal **data)
{
  PetscInt dims[1];

  PetscFunctionBegin;
  PetscCall(SlipH5ReadReal(h, path, 1, dims, data));
  PetscCheck(dims[0] == n, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
             "-train_resume %s: %s has %" PetscInt_FMT " entries, expected %" PetscInt_FMT
             ": it belongs to other networks or observations",
             h->name, path, dims[0], n);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrainCheckFiles(MPI_Comm comm, const char output[], const char log[], const char checkpoint[])
{
  const char *const file[] = {output, log, checkpoint};
  const char *const option[] = {"-train_output", "-train_log", "-train_checkpoint"};
  PetscBool same;

  PetscFunctionBegin;
  for (int i = 1; i < 3; i++)
    for (int j = 0; j < i; j++) {
      PetscCall(PetscStrcmp(file[i], file[j], &same));
      PetscCheck(!same || !file[i][0], comm, PETSC_ERR_ARG_INCOMP, "%s and %s are both %s, expected different files",
                 option[j], option[i], file[i]);
    }
  PetscFunctionReturn(PETSC_SUCCESS);
}
