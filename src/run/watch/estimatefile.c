/* Reads the calibration of estimated errors from a file (training/policies/README.md): rank 0 reads, and all ranks get
   its numbers and its errors. */
#include <slipstep/private/sliprun.h>
#include <slipstep/private/slippolicy.h>
#include <math.h>
#include <string.h>

#define ESTIMATES_FORMAT "slipstep-estimates"
#define ESTIMATES_VERSION 1

/* Finds the column of each estimate. */
static PetscErrorCode FindColumns(SlipH5 *h, const char *const measure[], PetscInt column[NUM_ESTIMATES])
{
  char **names;
  PetscInt n, missing = -1;

  PetscFunctionBegin;
  PetscCall(SlipH5ReadStrings(h, "/measures", &n, &names));
  for (PetscInt k = 0; k < NUM_ESTIMATES; k++) {
    column[k] = -1;
    for (PetscInt i = 0; i < PetscMin(n, NUM_ESTIMATES); i++)
      if (!strcmp(names[i], measure[k])) column[k] = i;
    if (column[k] < 0) missing = k;
  }
  PetscCall(SlipH5FreeStrings(n, &names));
  PetscCheck(missing < 0, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
             "%s: /measures has no \"%s\" among the first %d; expected a name for each column of /factor%s", h->name,
             measure[PetscMax(missing, 0)], (int)NUM_ESTIMATES, h->source);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads GROUP/steps and GROUP/factor. */
static PetscErrorCode ReadFactors(SlipH5 *h, const char group[], const PetscInt column[], SlipFaultFactors *f)
{
  PetscInt want[2] = {0, NUM_ESTIMATES}, dims[2];
  PetscReal *steps, *factor = NULL;
  PetscErrorCode ierr;
  char path[64];

  PetscFunctionBegin;
  PetscCall(PetscSNPrintf(path, sizeof(path), "%s/steps", group));
  PetscCall(SlipH5ReadReal(h, path, 1, want, &steps));
  PetscCall(PetscSNPrintf(path, sizeof(path), "%s/factor", group));
  ierr = SlipH5ReadRealSized(h, path, 2, want, "a row a number of steps, a column a measure", dims, &factor);
  if (!ierr && want[0] >= 1 && want[0] <= CALIBRATION_MOST) f->n = want[0];
  for (PetscInt i = 0; i < f->n; i++) {
    f->row[i].steps = steps[i];
    for (PetscInt k = 0; k < NUM_ESTIMATES; k++) f->row[i].factor[k] = factor[i * NUM_ESTIMATES + column[k]];
  }
  PetscCall(PetscFree(steps));
  PetscCall(PetscFree(factor));
  PetscCall(ierr);
  PetscCheck(f->n, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
             "%s: %s/steps has %" PetscInt_FMT " numbers, expected 1 to %d%s", h->name, group, want[0],
             (int)CALIBRATION_MOST, h->source);
  for (PetscInt i = 0; i < f->n; i++) {
    const PetscReal steps = f->row[i].steps;

    PetscCheck((i + 1 < f->n ? isfinite(steps) && (!i || steps > f->row[i - 1].steps) : steps == INFINITY),
               PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
               "%s: number %" PetscInt_FMT " of %s/steps is %g; expected numbers that rise, and infinity at the end%s",
               h->name, i, group, (double)steps, h->source);
    for (PetscInt k = 0; k < NUM_ESTIMATES; k++)
      PetscCheck(isfinite(f->row[i].factor[k]) && f->row[i].factor[k] > 0, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
                 "%s: a number in row %" PetscInt_FMT " of %s/factor is %g; expected numbers > 0%s", h->name, i, group,
                 (double)f->row[i].factor[k], h->source);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads all numbers. Files of SlipStep 0.4 and older have none for explicit steps. */
static PetscErrorCode ReadNumbers(SlipH5 *h, const char *const measure[], SlipFaultCalibration *c)
{
  PetscInt column[NUM_ESTIMATES];
  PetscBool has;
  const struct {
    const char *name;
    PetscReal *value;
  } row[] = {{"final_slip_floor", &c->floor},
             {"final_slip_late", &c->late},
             {"event_time_floor", &c->shift_floor},
             {"history_final", &c->history_final}};

  PetscFunctionBegin;
  PetscCall(SlipPolicyCheckFormat(h, ESTIMATES_FORMAT, ESTIMATES_VERSION));
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(row); i++) {
    PetscCall(SlipH5ReadAttrReal(h, "/factor", row[i].name, row[i].value));
    PetscCheck(isfinite(*row[i].value) && *row[i].value >= 0, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
               "%s: attribute %s of /factor is %g; expected a number >= 0%s", h->name, row[i].name,
               (double)*row[i].value, h->source);
  }
  PetscCall(SlipH5ReadAttrInt(h, "/factor", "least_steps", &c->least));
  PetscCall(FindColumns(h, measure, column));
  PetscCall(ReadFactors(h, "", column, &c->of_all));
  PetscCall(SlipH5Has(h, "/explicit", &has));
  if (has) PetscCall(ReadFactors(h, "/explicit", column, &c->of_explicit));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadFile(const char prefix[], const char file[], const char *const measure[],
                               SlipFaultCalibration *c)
{
  SlipH5 h;
  PetscErrorCode ierr;

  PetscFunctionBegin;
  if (file[0])
    PetscCall(SlipH5OpenReadOption(prefix, "fault_estimates", file, &h));
  else
    PetscCall(SlipPolicyOpenData("estimates.h5", "the factors of estimated errors", &h));
  ierr = ReadNumbers(&h, measure, c);
  PetscCall(SlipH5Close(&h));
  PetscCall(ierr);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultCalibrationRead(MPI_Comm comm, const char prefix[], const char file[],
                                        const char *const measure[], SlipFaultCalibration *c)
{
  PetscErrorCode ierr = PETSC_SUCCESS;
  PetscMPIInt rank;

  PetscFunctionBegin;
  PetscCall(PetscMemzero(c, sizeof(*c)));
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  if (!rank) ierr = ReadFile(prefix, file, measure, c);
  PetscCall(SlipErrorBcast(comm, ierr));
  PetscCallMPI(MPI_Bcast(c, (PetscMPIInt)sizeof(*c), MPI_BYTE, 0, comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}
