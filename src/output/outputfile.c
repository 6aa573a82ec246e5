/* The file of a run: its tables, and how they grow. */
#include <slipstep/private/slipoutput.h>
#include <slipstep/private/slipsys.h>
#include <slipcompat.h>
#include <slipsys.h>

static const SlipOutputColumn StepColumns[] = {
  {.name = "time", .unit = "s"},
  {.name = "dt", .unit = "s"},
  {.name = "accepted", .integer = PETSC_TRUE},
  {.name = "error", .unit = "1"},
  {.name = "converged", .integer = PETSC_TRUE},
  {.name = "newton_iterations", .integer = PETSC_TRUE},
  {.name = "linear_iterations", .integer = PETSC_TRUE},
  {.name = "solves", .integer = PETSC_TRUE},
  {.name = "right_hand_sides", .integer = PETSC_TRUE},
  {.name = "residual", .unit = "1"},
  {.name = "reason", .integer = PETSC_TRUE},
  {.name = "wall", .unit = "s"},
};

SlipH5 *SlipOutputFile(SlipOutput out)
{
  return out->begun && !out->rank ? &out->file : NULL;
}

/* Rank 0: the file with /run, /result and the tables; its layout is complete when the problem has added to it. */
static PetscErrorCode SlipOutputOpen(SlipOutput out)
{
  SlipH5 *h = &out->file;

  PetscFunctionBegin;
  if (out->resumed)
    PetscCall(SlipH5CreateCopy(&out->kind, NULL, out->name, h));
  else
    PetscCall(SlipH5CreateKind(&out->kind, out->name, h));
  PetscCall(SlipOutputRun(out));
  PetscCall(SlipTableCreate(&out->steps, h, "/steps", PETSC_STATIC_ARRAY_LENGTH(StepColumns), StepColumns, NULL,
                            out->resumed ? out->resume_steps : -1));
  PetscCall(SlipTableCreate(&out->series, h, "/series", out->ncolumns, out->column, out->entries,
                            out->resumed ? out->resume_series : -1));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipOutputAddTable(SlipOutput out, const char group[], PetscInt n, const SlipOutputColumn column[])
{
  PetscFunctionBegin;
  PetscCall(PetscRealloc((size_t)(out->nmore + 1) * sizeof(*out->more), &out->more));
  PetscCall(SlipTableCreate(&out->more[out->nmore], &out->file, group, n, column, NULL,
                            out->resumed ? out->resume_series : -1));
  out->nmore++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipOutputAddRow(SlipOutput out, PetscInt k, const PetscReal row[])
{
  PetscFunctionBegin;
  PetscCall(SlipTableAdd(&out->more[k], &out->file, row));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Rank 0: the rows before an error that ends the program */
static PetscErrorCode SlipOutputLast(void *ctx)
{
  SlipOutput out = (SlipOutput)ctx;

  PetscFunctionBegin;
  PetscCall(SlipTableFlush(&out->steps, &out->file));
  PetscCall(SlipTableFlush(&out->series, &out->file));
  for (PetscInt k = 0; k < out->nmore; k++) PetscCall(SlipTableFlush(&out->more[k], &out->file));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipOutputBegin(SlipOutput out)
{
  PetscErrorCode ierr = PETSC_SUCCESS;

  PetscFunctionBegin;
  if (!out->wanted || out->begun) PetscFunctionReturn(PETSC_SUCCESS);
  if (!out->rank) ierr = SlipOutputOpen(out);
  PetscCall(SlipErrorBcast(out->comm, ierr));
  out->begun = PETSC_TRUE;
  if (out->layout) PetscCall((*out->layout)(out, out->ctx));
  if (!out->rank) ierr = SlipH5Live(&out->file);
  PetscCall(SlipErrorBcast(out->comm, ierr));
  out->file.last = SlipOutputLast;
  out->file.ctx = out;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Rank 0, as the next: all rows to the file */
PetscErrorCode SlipOutputFlush(SlipOutput out)
{
  PetscFunctionBegin;
  PetscCall(SlipOutputLast(out));
  if (!out->policy_known) PetscCall(SlipOutputPolicy(out));
  PetscCall(SlipOutputWall(out));
  PetscCall(SlipH5Flush(&out->file));
  if (out->flushed) PetscCall((*out->flushed)(out, out->ctx));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A row, and what was collected to disk from time to time */
PetscErrorCode SlipOutputRow(SlipOutput out, SlipTable *table, const PetscReal row[])
{
  PetscBool due;

  PetscFunctionBegin;
  PetscCall(SlipTableAdd(table, &out->file, row));
  PetscCall(SlipH5FlushIsDue(&out->file, &due));
  if (due) PetscCall(SlipOutputFlush(out));
  PetscFunctionReturn(PETSC_SUCCESS);
}
