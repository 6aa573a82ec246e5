/* A matrix of the rows of normal stress in a stiffness with opening. */
#include <petsc/private/petscimpl.h> /* methods */
#include <slipstep/rooms/slipmat.h>
#include <slipstep/rooms/slipcells.h>
#include <slipcompat.h>
#include <slipstep/private/sliploops.h>
#include <slipstep/private/slipsys.h>
#include <slipstep/private/slipmatcommon.h>

typedef struct {
  Mat S;       /* referenced */
  Vec product; /* S u */
  Vec weights; /* weights of S's rows, borrowed from S; NULL: 1 */
  Vec there;   /* their copy on the device; NULL: none */
} NormalRows;

/* n_i = f_(3 i + 2) / w_i */
static PetscErrorCode Take(const NormalRows *r, Vec f, Vec n)
{
  const PetscReal weighted = r->weights ? 1 : 0;
  PetscInt m;

  PetscFunctionBegin;
  PetscCall(VecGetLocalSize(n, &m));
  PetscCall(
    SlipLoopRun(SLIP_LOOP_TAKE_THIRD, m, &weighted, (const Vec[]){f, r->there ? r->there : r->weights, n}, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode NormalRowsMult(Mat Kn, Vec u, Vec n)
{
  NormalRows *r;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(Kn, &r));
  PetscCall(MatMult(r->S, u, r->product));
  PetscCall(Take(r, r->product, n));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* MatSlipStiffnessMultBoth() of this type: it takes one product if K is the matrix of Kn's rows. */
static PetscErrorCode NormalRowsMultBoth(Mat K, Mat Kn, Vec u, Vec f, Vec n)
{
  NormalRows *r;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(Kn, &r));
  PetscCall(MatMult(K, u, f));
  if (K == r->S)
    PetscCall(Take(r, f, n));
  else
    PetscCall(MatMult(Kn, u, n));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Puts the matrix on the device; S is there as well. */
static PetscErrorCode NormalRowsDevice(Mat Kn, PetscBool use, PetscReal *bytes)
{
  PetscReal own;
  PetscBool there;
  NormalRows *r;
  VecType type;
  PetscInt m;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(Kn, &r));
  PetscCall(MatGetLocalSize(Kn, &m, NULL));
  PetscCall(MatGetVecType(r->S, &type));
  PetscCall(PetscStrcmp(type, VECSLIPOPENCL, &there));
  PetscCall(SlipMatDeviceBytes(r->S, &own));
  if (there) own = 0;
  *bytes = own + (PetscReal)sizeof(PetscReal) * (PetscReal)m * (r->weights ? 6 : 3);
  if (!use) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipMatUseDevice(r->S));
  PetscCall(VecDestroy(&r->product));
  PetscCall(MatCreateVecs(r->S, NULL, &r->product));
  if (r->weights) PetscCall(SlipVecCopyThere(r->weights, &r->there));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode NormalRowsDestroy(Mat Kn)
{
  NormalRows *r;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(Kn, &r));
  PetscCall(VecDestroy(&r->product));
  PetscCall(VecDestroy(&r->there));
  PetscCall(MatDestroy(&r->S));
  PetscCall(PetscFree(r));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates the matrix of the change of normal stress from a stiffness with slip and opening. S: stiffness of cells that
   open, 3 N x 3 N, of MatCreateSlipCellVectorStiffness() or MatCreateSlipDippingVectorStiffness(), of which Kn takes a
   reference; Kn: matrix [Pa/m], N x 3 N: every third row of S over its weight, the compression of a cell by slip and
   opening of all. Its product takes one product with S, and so does MatSlipStiffnessMultBoth(). MatScale() of S scales
   both. Errors: PETSC_ERR_ARG_SIZ for an S whose rows here are no multiple of 3. */
PetscErrorCode MatCreateSlipNormalRows(Mat S, Mat *Kn)
{
  const SlipShellOps ops = {
    .mult = NormalRowsMult, .destroy = NormalRowsDestroy, .device = NormalRowsDevice, .unsymmetric = PETSC_TRUE};
  NormalRows *r;
  PetscInt m, M;

  PetscFunctionBegin;
  PetscValidHeaderSpecific(S, MAT_CLASSID, 1);
  PetscAssertPointer(Kn, 2);
  PetscCall(MatGetLocalSize(S, &m, NULL));
  PetscCall(MatGetSize(S, &M, NULL));
  PetscCheck(m % 3 == 0, PETSC_COMM_SELF, PETSC_ERR_ARG_SIZ,
             "The stiffness has %" PetscInt_FMT " rows here, expected three a cell", m);
  PetscCall(PetscNew(&r));
  r->S = S;
  PetscCall(PetscObjectReference((PetscObject)S));
  PetscCall(MatCreateVecs(S, NULL, &r->product));
  PetscCall(MatSlipGetWeights(S, &r->weights));
  PetscCall(SlipShellCreateOfSize(PetscObjectComm((PetscObject)S), m / 3, m, M / 3, M, "slipnormalrows", &ops, r, Kn));
  PetscCall(PetscObjectComposeFunction((PetscObject)*Kn, "MatSlipStiffnessMultBoth_C", NormalRowsMultBoth));
  PetscFunctionReturn(PETSC_SUCCESS);
}
