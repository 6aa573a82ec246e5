/* What the files of all trainings share, see files.h. */
#include "files.h"

PetscErrorCode ErrorCapture(MPI_Comm comm, int line, const char *function, const char *file, PetscErrorCode code,
                            PetscErrorType type, const char *message, void *ctx)
{
  char *text = (char *)ctx;

  (void)comm, (void)line, (void)function, (void)file;
  if (type == PETSC_ERROR_INITIAL && !text[0]) (void)PetscStrncpy(text, message ? message : "no message", ERROR_TEXT);
  return code;
}

PetscErrorCode ErrorOfFile(PetscErrorCode code, const char option[], const char message[])
{
  PetscFunctionBegin;
  if (code && strstr(message, option)) SETERRQ(PETSC_COMM_SELF, code, "%s", message);
  PetscCheck(!code, PETSC_COMM_SELF, code, "%s (%s)", message, option);
  PetscFunctionReturn(PETSC_SUCCESS);
}

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
  PetscCall(SlipH5ReadRealSized(h, path, 1, &n, "else it belongs to other networks or observations", dims, data));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrainSetFiles(SlipOptionItems PetscOptionsObject, const char text[], char output[], char log[],
                             char checkpoint[], char resume[])
{
  const struct {
    const char *name, *text;
    char *value;
  } row[] = {{"-train_output", "Policy file to write (HDF5)", output},
             {"-train_log", "Learning curve to write (HDF5)", log},
             {"-train_resume", "Checkpoint to continue", resume},
             {"-train_checkpoint", text, checkpoint}};
  PetscBool set, overwrite = PETSC_FALSE;

  PetscFunctionBegin;
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(row); ++i) {
    PetscCall(PetscOptionsString(row[i].name, row[i].text, NULL, row[i].value, row[i].value, PETSC_MAX_PATH_LEN, &set));
    PetscCheck(!set || row[i].value[0], PETSC_COMM_WORLD, PETSC_ERR_ARG_WRONG,
               "%s has no value, expected the name of a file", row[i].name);
  }
  PetscCall(PetscOptionsBool("-train_log_overwrite", "Overwrite an unfinished FILE.part of -train_log (default no)",
                             NULL, overwrite, &overwrite, NULL)); /* CurveKind() reads it */
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CurveKind(SlipH5Kind *kind)
{
  PetscFunctionBegin;
  *kind = (SlipH5Kind){.option = "train_log", .growing = PETSC_TRUE};
  PetscCall(PetscOptionsGetBool(NULL, NULL, "-train_log_overwrite", &kind->overwrite, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrainCheckFiles(MPI_Comm comm, const char output[], const char log[], const char checkpoint[])
{
  const char *const file[] = {output, log, checkpoint};
  const char *const option[] = {"-train_output", "-train_log", "-train_checkpoint"};
  PetscErrorCode ierr = PETSC_SUCCESS;
  PetscMPIInt rank;
  PetscBool same;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  for (int i = 1; i < 3; i++)
    for (int j = 0; j < i; j++) {
      PetscCall(PetscStrcmp(file[i], file[j], &same));
      PetscCheck(!same || !file[i][0], comm, PETSC_ERR_ARG_INCOMP, "%s and %s are both %s, expected different files",
                 option[j], option[i], file[i]);
    }
  for (int i = 0; i < 3; i++) {
    SlipH5Kind kind = {.option = option[i] + 1};

    if (i == 1) PetscCall(CurveKind(&kind));
    if (!rank) ierr = SlipH5CheckCreateKind(&kind, file[i]);
    PetscCall(SlipErrorBcast(comm, ierr));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CheckpointReadArray(SlipH5 *h, const char path[], PetscInt n, size_t size, void *out)
{
  PetscReal *data;

  PetscFunctionBegin;
  PetscCall(CheckpointReadFixed(h, path, n, &data));
  for (PetscInt i = 0; i < n; ++i) {
    if (size == sizeof(float))
      ((float *)out)[i] = (float)data[i];
    else
      ((double *)out)[i] = (double)data[i];
  }
  PetscCall(PetscFree(data));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CurveCreate(SlipH5 *h, PetscInt n, const CurveColumn column[])
{
  PetscFunctionBegin;
  for (PetscInt i = 0; i < n; ++i) PetscCall(SlipH5CreateSeries(h, column[i].path, 0, NULL, NULL, column[i].units));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CurveAppend(SlipH5 *h, PetscInt n, const CurveColumn column[], const PetscReal row[])
{
  SlipH5Rows series[CURVE_COLUMNS];
  PetscBool due;

  PetscFunctionBegin;
  PetscCheck(n <= CURVE_COLUMNS, PETSC_COMM_SELF, PETSC_ERR_PLIB, "%" PetscInt_FMT " columns of a curve", n);
  for (PetscInt i = 0; i < n; ++i) series[i] = (SlipH5Rows){column[i].path, &row[i], 1};
  PetscCall(SlipH5AppendAll(h, n, series, 1));
  PetscCall(SlipH5FlushIsDue(h, &due));
  if (due) PetscCall(SlipH5Flush(h));
  PetscFunctionReturn(PETSC_SUCCESS);
}
