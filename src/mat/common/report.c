/* What views print about operators: how a type was chosen, and how much memory it takes. */
#include <slipstep/rooms/slipmat.h>
#include <slipcompat.h>
#include <slipstep/private/slipmatcommon.h>

/* Fills the result of MatGetInfo() for a shell matrix that stores so many bytes on this process. Collective. */
PetscErrorCode SlipInfoFill(Mat A, PetscReal bytes, MatInfoType flag, MatInfo *info)
{
  PetscReal value = bytes;

  PetscFunctionBegin;
  PetscCall(PetscMemzero(info, sizeof(*info)));
  if (flag != MAT_LOCAL)
    PetscCallMPI(MPI_Allreduce(&bytes, &value, 1, MPIU_REAL, flag == MAT_GLOBAL_MAX ? MPIU_MAX : MPIU_SUM,
                               PetscObjectComm((PetscObject)A)));
  info->block_size = 1;
  info->memory = (PetscLogDouble)value;
  info->nz_used = info->nz_allocated = (PetscLogDouble)value / (PetscLogDouble)sizeof(PetscReal);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  MatSlipGetMemory - gets the memory of a matrix, the most on one process and the sum over all

  Collective

  Input Parameter:
. A - stiffness, viscosity or stage operator, or a dense matrix

  Output Parameters:
+ most - memory on the process that has the most [bytes]; -1 if this type of matrix does not report it
- all  - memory on all processes [bytes]; -1 likewise

  Level: intermediate

.seealso: MatGetInfo(), SlipFaultView()
@*/
PetscErrorCode MatSlipGetMemory(Mat A, PetscReal *most, PetscReal *all)
{
  MPI_Comm comm = PetscObjectComm((PetscObject)A);
  PetscBool dense, constant, known;
  PetscReal bytes = 0;
  PetscInt m, N;
  MatInfo info;

  PetscFunctionBegin;
  *most = *all = -1;
  PetscCall(MatGetSize(A, NULL, &N));
  PetscCall(MatGetLocalSize(A, &m, NULL));
  PetscCall(PetscObjectTypeCompareAny((PetscObject)A, &dense, MATSEQDENSE, MATMPIDENSE, ""));
  PetscCall(PetscObjectTypeCompare((PetscObject)A, MATCONSTANTDIAGONAL, &constant));
  PetscCall(MatHasOperation(A, MATOP_GETINFO, &known));
  if (dense)
    bytes = (PetscReal)sizeof(PetscScalar) * (PetscReal)m * (PetscReal)N;
  else if (!constant) {
    if (!known) PetscFunctionReturn(PETSC_SUCCESS);
    PetscCall(MatGetInfo(A, MAT_LOCAL, &info));
    bytes = (PetscReal)info.memory;
  }
  PetscCallMPI(MPI_Allreduce(&bytes, most, 1, MPIU_REAL, MPIU_MAX, comm));
  PetscCallMPI(MPI_Allreduce(&bytes, all, 1, MPIU_REAL, MPIU_SUM, comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets a text about how the type of a matrix was chosen. A: stiffness or viscosity; why: "auto: ..." or the given type;
   borrowed, "" if there is no note. */
PetscErrorCode MatSlipGetNotes(Mat A, const char **why)
{
  PetscFunctionBegin;
  PetscCall(SlipObjectQueryData((PetscObject)A, "SlipWhy", why));
  if (!*why) *why = "";
  PetscFunctionReturn(PETSC_SUCCESS);
}
