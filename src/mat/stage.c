/* The stage operator B(theta) = (mass / theta) I + H + theta K as a shell matrix. */
#include <slipmat.h>
#include <slipstep/private/slipcompat.h>
#include <slipstep/private/slipmat.h>

typedef struct {
  Mat K, H;           /* stiffness and viscosity, referenced */
  PetscReal mass;     /* [kg/m^2] */
  PetscReal theta;    /* [s] */
  PetscBool assemble; /* both operands are dense and small enough for B to be formed at each theta */
  Mat assembled;      /* B as MATDENSE, or NULL */
  PetscReal assembled_theta;
  Vec work;
} SlipStageContext;

/* At or below this size forming B (two passes over N^2 numbers) is repaid by the first few products. */
#define SLIP_STAGE_ASSEMBLE_MAX 1024

static PetscErrorCode StageAssemble(Mat B, SlipStageContext *s)
{
  PetscFunctionBegin;
  if (s->assembled && s->assembled_theta == s->theta) PetscFunctionReturn(PETSC_SUCCESS);
  if (!s->assembled) PetscCall(MatDuplicate(s->K, MAT_DO_NOT_COPY_VALUES, &s->assembled));
  PetscCall(MatCopy(s->H, s->assembled, SAME_NONZERO_PATTERN));
  PetscCall(MatAXPY(s->assembled, s->theta, s->K, SAME_NONZERO_PATTERN));
  PetscCall(MatShift(s->assembled, s->mass / s->theta));
  s->assembled_theta = s->theta;
  (void)B;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode StageMult(Mat B, Vec x, Vec y)
{
  SlipStageContext *s;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(B, &s));
  PetscCheck(s->theta > 0, PetscObjectComm((PetscObject)B), PETSC_ERR_ORDER, "Call MatSlipStageSetTheta() first");
  if (s->assemble) {
    PetscCall(StageAssemble(B, s));
    PetscCall(MatMult(s->assembled, x, y));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(MatMult(s->K, x, y));
  PetscCall(MatMult(s->H, x, s->work));
  PetscCall(VecAXPBYPCZ(y, s->mass / s->theta, 1, s->theta, x, s->work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode StageGetDiagonal(Mat B, Vec d)
{
  SlipStageContext *s;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(B, &s));
  PetscCheck(s->theta > 0, PetscObjectComm((PetscObject)B), PETSC_ERR_ORDER, "Call MatSlipStageSetTheta() first");
  PetscCall(MatGetDiagonal(s->K, d));
  PetscCall(MatGetDiagonal(s->H, s->work));
  PetscCall(VecAXPBY(d, 1, s->theta, s->work));
  PetscCall(VecShift(d, s->mass / s->theta));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode StageDestroy(Mat B)
{
  SlipStageContext *s;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(B, &s));
  PetscCall(MatDestroy(&s->K));
  PetscCall(MatDestroy(&s->H));
  PetscCall(MatDestroy(&s->assembled));
  PetscCall(VecDestroy(&s->work));
  PetscCall(PetscFree(s));
  PetscCall(PetscObjectComposeFunction((PetscObject)B, "MatConvert_slipstage_dense_C", NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  MatCreateSlipStage - the operator of an implicit stage, B(theta) = (mass / theta) I + H + theta K

  Collective

  Input Parameters:
+ K    - stiffness [Pa/m]
. H    - viscosity [Pa s/m] with the same distribution
- mass - inertia per unit area [kg/m^2], positive

  Output Parameter:
. B - matrix of type "slipstage" [Pa s/m]; set theta before using it

  Note: K and H are referenced and must not change while B lives.

  Errors: PETSC_ERR_ARG_SIZ when the sizes of K and H differ, PETSC_ERR_ARG_OUTOFRANGE for the mass

  Level: beginner

.seealso: MatSlipStageSetTheta(), MatCreateSlipStiffness(), MatCreateSlipViscosity(), PCSLIPSTAGE
@*/
PetscErrorCode MatCreateSlipStage(Mat K, Mat H, PetscReal mass, Mat *B)
{
  MPI_Comm comm = PetscObjectComm((PetscObject)K);
  SlipStageContext *s;
  PetscInt m, N, mH, NH;
  PetscBool denseK, denseH;

  PetscFunctionBegin;
  PetscCheck(mass > 0 && PetscIsNormalReal(mass), comm, PETSC_ERR_ARG_OUTOFRANGE,
             "Inertia per unit area must be positive and finite, not %g kg/m^2", (double)mass);
  PetscCall(MatGetSize(K, &N, NULL));
  PetscCall(MatGetLocalSize(K, &m, NULL));
  PetscCall(MatGetSize(H, &NH, NULL));
  PetscCall(MatGetLocalSize(H, &mH, NULL));
  PetscCheck(N == NH, comm, PETSC_ERR_ARG_SIZ, "K has %" PetscInt_FMT " rows, H has %" PetscInt_FMT, N, NH);
  PetscCheck(m == mH, PETSC_COMM_SELF, PETSC_ERR_ARG_SIZ, "K has %" PetscInt_FMT " local rows, H has %" PetscInt_FMT, m,
             mH);
  PetscCall(PetscNew(&s));
  PetscCall(PetscObjectReference((PetscObject)K));
  PetscCall(PetscObjectReference((PetscObject)H));
  s->K = K;
  s->H = H;
  s->mass = mass;
  PetscCall(PetscObjectTypeCompareAny((PetscObject)K, &denseK, MATSEQDENSE, MATMPIDENSE, ""));
  PetscCall(PetscObjectTypeCompareAny((PetscObject)H, &denseH, MATSEQDENSE, MATMPIDENSE, ""));
  s->assemble = (PetscBool)(denseK && denseH && N <= SLIP_STAGE_ASSEMBLE_MAX);
  PetscCall(MatCreateVecs(K, NULL, &s->work));
  PetscCall(MatCreateShell(comm, m, m, N, N, s, B));
  PetscCall(MatShellSetManageScalingShifts(*B));
  PetscCall(MatShellSetOperation(*B, MATOP_MULT, SlipMatShellFn(StageMult)));
  PetscCall(MatShellSetOperation(*B, MATOP_MULT_TRANSPOSE, SlipMatShellFn(StageMult)));
  PetscCall(MatShellSetOperation(*B, MATOP_GET_DIAGONAL, SlipMatShellFn(StageGetDiagonal)));
  PetscCall(MatShellSetOperation(*B, MATOP_DESTROY, SlipMatShellFn(StageDestroy)));
  PetscCall(SlipShellFinish(*B, "slipstage"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode StageContext(Mat B, SlipStageContext **s)
{
  MatType type;
  PetscBool match;

  PetscFunctionBegin;
  PetscCall(MatGetType(B, &type));
  PetscCall(PetscObjectTypeCompare((PetscObject)B, "slipstage", &match));
  PetscCheck(match, PetscObjectComm((PetscObject)B), PETSC_ERR_ARG_WRONG,
             "Matrix is a \"%s\", expected a \"slipstage\"", type);
  PetscCall(MatShellGetContext(B, s));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  MatSlipStageSetTheta - set the theta of the stage operator; the same value again costs nothing

  Logically collective

  Input Parameters:
+ B     - matrix of MatCreateSlipStage()
- theta - [s], positive

  Level: intermediate

.seealso: MatCreateSlipStage(), MatSlipStageGetTheta()
@*/
PetscErrorCode MatSlipStageSetTheta(Mat B, PetscReal theta)
{
  SlipStageContext *s;

  PetscFunctionBegin;
  PetscCall(StageContext(B, &s));
  PetscCheck(theta > 0 && PetscIsNormalReal(theta), PetscObjectComm((PetscObject)B), PETSC_ERR_ARG_OUTOFRANGE,
             "theta must be positive and finite, not %g s", (double)theta);
  if (s->theta != theta) {
    s->theta = theta;
    PetscCall(MatAssemblyBegin(B, MAT_FINAL_ASSEMBLY)); /* tells solvers that B has changed */
    PetscCall(MatAssemblyEnd(B, MAT_FINAL_ASSEMBLY));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  MatSlipStageGetTheta - the theta [s] of the stage operator, 0 when it was never set

  Not collective

  Level: intermediate

.seealso: MatSlipStageSetTheta()
@*/
PetscErrorCode MatSlipStageGetTheta(Mat B, PetscReal *theta)
{
  SlipStageContext *s;

  PetscFunctionBegin;
  PetscCall(StageContext(B, &s));
  *theta = s->theta;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipStageGetOperators(Mat B, Mat *K, Mat *H, PetscReal *mass)
{
  SlipStageContext *s;

  PetscFunctionBegin;
  PetscCall(StageContext(B, &s));
  *K = s->K;
  *H = s->H;
  *mass = s->mass;
  PetscFunctionReturn(PETSC_SUCCESS);
}
