/* Visits the state of a run, see slipstate.h: each object has a group, in which numbers are attributes, and arrays and
   vectors are datasets. Rank 0 transfers vectors in pieces. */
#include <petsc/private/petscimpl.h> /* type_name */
#include <slipstep/private/sliph5.h>
#include <slipstep/private/slipstate.h>
#include <slipstep/private/slipsys.h>
#include <slipstep/rooms/slipsys.h>
#include <string.h>

#define SLIP_STATE_PIECE 1048576 /* entries of a vector in the memory of rank 0 at a time */

/*@
  SlipStateIsLoading - gets whether a checkpoint is read or written

  Not collective

  Input Parameter:
. state - the checkpoint

  Level: advanced

.seealso: SlipStateReal(), SlipFaultRegisterObserver()
@*/
PetscBool SlipStateIsLoading(SlipState s)
{
  return s->loading;
}

PetscErrorCode SlipStateGroup(SlipState s, const char name[])
{
  PetscErrorCode ierr = PETSC_SUCCESS;

  PetscFunctionBegin;
  PetscCall(PetscSNPrintf(s->group, sizeof(s->group), "/%s", name));
  if (!s->rank && !s->loading) ierr = SlipH5Group(&s->file, s->group, PETSC_FALSE);
  PetscCall(SlipErrorBcast(s->comm, ierr));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipStateHas(SlipState s, const char group[], PetscBool *has)
{
  PetscErrorCode ierr = PETSC_SUCCESS;
  char path[64];

  PetscFunctionBegin;
  *has = PETSC_TRUE;
  if (!s->loading) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscSNPrintf(path, sizeof(path), "/%s", group));
  if (!s->rank) ierr = SlipH5Has(&s->file, path, has);
  PetscCall(SlipErrorBcast(s->comm, ierr));
  PetscCallMPI(MPI_Bcast(has, 1, MPIU_BOOL, 0, s->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Checks whether the group has a number or text of this name; true when writing. */
PetscErrorCode SlipStateHasValue(SlipState s, const char name[], PetscBool *has)
{
  PetscErrorCode ierr = PETSC_SUCCESS;

  PetscFunctionBegin;
  *has = PETSC_TRUE;
  if (!s->loading) PetscFunctionReturn(PETSC_SUCCESS);
  if (!s->rank) ierr = SlipH5HasAttribute(&s->file, s->group, name, has);
  PetscCall(SlipErrorBcast(s->comm, ierr));
  PetscCallMPI(MPI_Bcast(has, 1, MPIU_BOOL, 0, s->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SlipStatePath(SlipState s, const char name[], char path[], size_t len)
{
  PetscFunctionBegin;
  PetscCall(PetscSNPrintf(path, len, "%s/%s", s->group, name));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Rank 0: reads or writes n > 1 numbers as a dataset. */
static PetscErrorCode SlipStateArray(SlipState s, const char name[], PetscInt n, PetscReal x[])
{
  PetscReal *data = NULL;
  PetscInt dims;
  char path[128];

  PetscFunctionBegin;
  PetscCall(SlipStatePath(s, name, path, sizeof(path)));
  if (!s->loading) {
    PetscCall(SlipH5WriteReal(&s->file, path, 1, &n, x, NULL));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(SlipH5ReadReal(&s->file, path, 1, &dims, &data));
  if (dims == n) PetscCall(PetscArraycpy(x, data, n));
  PetscCall(PetscFree(data));
  PetscCheck(dims == n, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
             "%s in %s has %" PetscInt_FMT " numbers, expected %" PetscInt_FMT "%s", path, s->file.name, dims, n,
             s->file.source);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipStateReal - writes numbers to a checkpoint, or reads them

  Collective

  Input Parameters:
+ state - the checkpoint
. name  - name of an attribute for one number, of a dataset for several
. n     - number of numbers
- x     - the numbers [n], in SI units, the same on all ranks; reading stores those of the file here

  Level: advanced

  Errors: PETSC_ERR_FILE_WRITE; PETSC_ERR_FILE_READ and PETSC_ERR_FILE_UNEXPECTED when the file has no such numbers

.seealso: SlipStateInt(), SlipStateVec(), SlipFaultRegisterObserver()
@*/
PetscErrorCode SlipStateReal(SlipState s, const char name[], PetscInt n, PetscReal x[])
{
  PetscErrorCode ierr = PETSC_SUCCESS;

  PetscFunctionBegin;
  if (!s->rank) {
    if (n != 1)
      ierr = SlipStateArray(s, name, n, x);
    else
      ierr = s->loading ? SlipH5ReadAttrReal(&s->file, s->group, name, x)
                        : SlipH5WriteAttrReal(&s->file, s->group, name, *x);
  }
  PetscCall(SlipErrorBcast(s->comm, ierr));
  if (s->loading) PetscCallMPI(MPI_Bcast(x, (PetscMPIInt)n, MPIU_REAL, 0, s->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipStateInt - writes integers to a checkpoint, or reads them

  Collective

  Input Parameters:
+ state - the checkpoint
. name  - name of an attribute for one number, of a dataset for several
. n     - number of integers
- x     - the integers [n], the same on all ranks, at most 2^53 if n > 1; reading stores those of the file here

  Level: advanced

  Errors: those of SlipStateReal()

.seealso: SlipStateReal(), SlipStateBool()
@*/
PetscErrorCode SlipStateInt(SlipState s, const char name[], PetscInt n, PetscInt x[])
{
  PetscErrorCode ierr = PETSC_SUCCESS;
  PetscReal *real;

  PetscFunctionBegin;
  if (n != 1) { /* doubles represent integers up to 2^53 */
    PetscCall(PetscMalloc1(n, &real));
    for (PetscInt i = 0; i < n; i++) real[i] = (PetscReal)x[i];
    PetscCall(SlipStateReal(s, name, n, real));
    for (PetscInt i = 0; i < n; i++) x[i] = (PetscInt)real[i];
    PetscCall(PetscFree(real));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (!s->rank)
    ierr =
      s->loading ? SlipH5ReadAttrInt(&s->file, s->group, name, x) : SlipH5WriteAttrInt(&s->file, s->group, name, *x);
  PetscCall(SlipErrorBcast(s->comm, ierr));
  if (s->loading) PetscCallMPI(MPI_Bcast(x, 1, MPIU_INT, 0, s->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipStateProducts(SlipState s, const char name[], SlipProducts *p)
{
  PetscInt x[] = {p->k, p->h, p->pc, p->all};
  char of[64];

  PetscFunctionBegin;
  PetscCall(PetscSNPrintf(of, sizeof(of), "%s_cost", name));
  PetscCall(SlipStateInt(s, name, PETSC_STATIC_ARRAY_LENGTH(x), x));
  PetscCall(SlipStateReal(s, of, 1, &p->cost));
  *p = (SlipProducts){x[0], x[1], x[2], x[3], p->cost};
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipStateCount(SlipState s, const char name[], PetscInt most, PetscInt *n)
{
  PetscFunctionBegin;
  PetscCall(SlipStateInt(s, name, 1, n));
  PetscCheck(*n >= 0 && *n <= most, s->comm, PETSC_ERR_FILE_UNEXPECTED,
             "%s/%s in %s is %" PetscInt_FMT ", expected 0 to %" PetscInt_FMT "%s", s->group, name, s->file.name, *n,
             most, s->file.source);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipStateBool - writes a boolean to a checkpoint, or reads it

  Collective

  Input Parameters:
+ state - the checkpoint
. name  - name of an attribute, 0 or 1
- x     - the boolean, the same on all ranks; reading stores that of the file here

  Level: advanced

  Errors: those of SlipStateReal()

.seealso: SlipStateInt()
@*/
PetscErrorCode SlipStateBool(SlipState s, const char name[], PetscBool *x)
{
  PetscInt number = *x ? 1 : 0;

  PetscFunctionBegin;
  PetscCall(SlipStateInt(s, name, 1, &number));
  *x = number ? PETSC_TRUE : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipStateString(SlipState s, const char name[], char x[], size_t len)
{
  PetscErrorCode ierr = PETSC_SUCCESS;

  PetscFunctionBegin;
  if (!s->rank)
    ierr = s->loading ? SlipH5ReadAttrString(&s->file, s->group, name, x, len)
                      : SlipH5WriteAttrString(&s->file, s->group, name, x);
  PetscCall(SlipErrorBcast(s->comm, ierr));
  if (s->loading) PetscCallMPI(MPI_Bcast(x, (PetscMPIInt)len, MPI_CHAR, 0, s->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipStateSame(SlipState s, const char name[], const char x[], PetscBool *same)
{
  char text[PETSC_MAX_PATH_LEN] = "";

  PetscFunctionBegin;
  PetscCall(PetscStrncpy(text, x, sizeof(text)));
  PetscCall(SlipStateString(s, name, text, sizeof(text)));
  PetscCall(PetscStrcmp(text, x, same));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipStateObject(SlipState s, const char name[], PetscObject object)
{
  PetscErrorCode (*visit)(PetscObject, SlipState) = NULL;
  PetscBool same;

  PetscFunctionBegin;
  PetscCall(SlipStateGroup(s, name));
  PetscCall(SlipStateSame(s, "type", object && object->type_name ? object->type_name : "none", &same));
  if (object) PetscCall(PetscObjectQueryFunction(object, SLIP_STATE_METHOD, &visit));
  if (same && visit) PetscCall((*visit)(object, s));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- vectors ---- */

/* Rank 0: reads or writes the entries start to start + n of a vector of N. */
static PetscErrorCode SlipStatePiece(SlipState s, const char path[], PetscInt N, PetscInt start, PetscInt n,
                                     PetscReal a[])
{
  PetscFunctionBegin;
  if (s->loading)
    PetscCall(SlipH5ReadPiece(&s->file, path, N, start, n, a));
  else
    PetscCall(SlipH5WritePiece(&s->file, path, N, start, n, a));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads or writes a vector rank by rank, in pieces between each rank and rank 0; after an earlier failure on rank 0 no
   file is accessed. buffer: that of rank 0 */
static PetscErrorCode SlipStateTransfer(SlipState s, const char path[], PetscErrorCode *failed, Vec x,
                                        PetscReal buffer[])
{
  const PetscInt *range;
  const PetscReal *read;
  PetscReal *a;
  PetscMPIInt size;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_size(s->comm, &size));
  PetscCall(VecGetOwnershipRanges(x, &range));
  if (s->loading)
    PetscCall(VecGetArrayWrite(x, &a));
  else {
    PetscCall(VecGetArrayRead(x, &read)); /* does not change the object state of x, by which others detect changes */
    a = (PetscReal *)read;
  }
  for (PetscMPIInt p = 0; p < size; p++)
    for (PetscInt i = range[p]; i < range[p + 1]; i += SLIP_STATE_PIECE) {
      const PetscInt n = PetscMin(SLIP_STATE_PIECE, range[p + 1] - i);
      const PetscMPIInt count = (PetscMPIInt)n;
      PetscReal *piece = s->rank == p ? a + (i - range[p]) : buffer;

      if (s->rank == p && p && !s->loading) PetscCallMPI(MPI_Send(piece, count, MPIU_REAL, 0, 0, s->comm));
      if (!s->rank && p && !s->loading)
        PetscCallMPI(MPI_Recv(piece, count, MPIU_REAL, p, 0, s->comm, MPI_STATUS_IGNORE));
      if (!s->rank && !*failed) *failed = SlipStatePiece(s, path, range[size], i, n, piece);
      if (!s->rank && p && s->loading) PetscCallMPI(MPI_Send(piece, count, MPIU_REAL, p, 0, s->comm));
      if (s->rank == p && p && s->loading)
        PetscCallMPI(MPI_Recv(piece, count, MPIU_REAL, 0, 0, s->comm, MPI_STATUS_IGNORE));
    }
  if (s->loading)
    PetscCall(VecRestoreArrayWrite(x, &a));
  else
    PetscCall(VecRestoreArrayRead(x, &read));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads a vector whose cells had other numbers: rank 0 scatters each entry to its place. */
static PetscErrorCode SlipStateScatter(SlipState s, const char path[], PetscErrorCode *failed, Vec x,
                                       PetscReal buffer[])
{
  PetscInt N, block, *index = NULL;

  PetscFunctionBegin;
  PetscCall(VecGetSize(x, &N));
  block = N / s->cells;
  if (!s->rank) PetscCall(PetscMalloc1(SLIP_STATE_PIECE, &index));
  for (PetscInt i = 0; i < N; i += SLIP_STATE_PIECE) {
    const PetscInt n = PetscMin(SLIP_STATE_PIECE, N - i);

    if (!s->rank && !*failed) *failed = SlipStatePiece(s, path, N, i, n, buffer);
    if (!s->rank && !*failed) {
      for (PetscInt k = 0; k < n; k++) index[k] = s->place[(i + k) / block] * block + (i + k) % block;
      PetscCall(VecSetValues(x, n, index, buffer, INSERT_VALUES));
    }
    PetscCall(VecAssemblyBegin(x));
    PetscCall(VecAssemblyEnd(x));
  }
  PetscCall(PetscFree(index));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipStateVec - writes a vector to a checkpoint, or reads it

  Collective

  Input Parameters:
+ state - the checkpoint
. name  - name of a dataset
- x     - the vector; reading stores the entries of the file here, each at the present place of its cell, whatever the
          number of ranks

  Level: advanced

  Errors: those of SlipStateReal()

.seealso: SlipStateReal(), SlipFaultCreateState()
@*/
PetscErrorCode SlipStateVec(SlipState s, const char name[], Vec x)
{
  PetscErrorCode failed = PETSC_SUCCESS;
  PetscReal *buffer = NULL;
  PetscInt N, moved = 0;
  char path[128];

  PetscFunctionBegin;
  PetscCall(VecGetSize(x, &N));
  PetscCall(SlipStatePath(s, name, path, sizeof(path)));
  if (!s->rank) {
    PetscCall(PetscMalloc1(SLIP_STATE_PIECE, &buffer));
    moved = s->place ? 1 : 0;
  }
  PetscCallMPI(MPI_Bcast(&moved, 1, MPIU_INT, 0, s->comm));
  if (moved && N % s->cells == 0)
    PetscCall(SlipStateScatter(s, path, &failed, x, buffer));
  else
    PetscCall(SlipStateTransfer(s, path, &failed, x, buffer));
  PetscCall(PetscFree(buffer));
  PetscCall(SlipErrorBcast(s->comm, failed));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipStateVecs(SlipState s, const char name[], PetscInt n, const Vec x[])
{
  char each[64];

  PetscFunctionBegin;
  for (PetscInt j = 0; j < n; j++) {
    PetscCall(PetscSNPrintf(each, sizeof(each), "%s_%" PetscInt_FMT, name, j));
    PetscCall(SlipStateVec(s, each, x[j]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
