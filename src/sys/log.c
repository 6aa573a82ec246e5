/* Events and stages of -log_view; products of any Mat are logged as events of their own, and counted. */
#include <slipstep/rooms/slipsys.h>
#include <slipstep/private/slipsys.h>
#include <slipstep/private/slipwork.h>
#include <petscts.h>

PetscLogStage SLIP_STAGE_SETUP, SLIP_STAGE_RUN, SLIP_STAGE_OUTPUT;
PetscLogEvent SLIP_StiffnessSetUp, SLIP_StiffnessMult, SLIP_ViscositySetUp, SLIP_ViscosityMult, SLIP_StageMult;
PetscLogEvent SLIP_PCSetUp, SLIP_PCApply, SLIP_Direct, SLIP_Cells, SLIP_Cone, SLIP_Policy, SLIP_Observe, SLIP_Output;

/* One row per event; each is assigned to the most similar class of PETSc, by which -log_exclude excludes events. */
static const struct {
  const char *name;
  const PetscClassId *classid;
  PetscLogEvent *event;
} Events[] = {
  {"SlipKSetUp", &MAT_CLASSID, &SLIP_StiffnessSetUp},  {"SlipKMult", &MAT_CLASSID, &SLIP_StiffnessMult},
  {"SlipHSetUp", &MAT_CLASSID, &SLIP_ViscositySetUp},  {"SlipHMult", &MAT_CLASSID, &SLIP_ViscosityMult},
  {"SlipBMult", &MAT_CLASSID, &SLIP_StageMult},        {"SlipPCSetUp", &PC_CLASSID, &SLIP_PCSetUp},
  {"SlipPCApply", &PC_CLASSID, &SLIP_PCApply},         {"SlipCone", &SNES_CLASSID, &SLIP_Cone},
  {"SlipPolicy", &TSADAPT_CLASSID, &SLIP_Policy},      {"SlipObserve", &TSADAPT_CLASSID, &SLIP_Observe},
  {"SlipDirect", &SNES_CLASSID, &SLIP_Direct},         {"SlipCells", &TS_CLASSID, &SLIP_Cells},
  {"SlipOutput", &PETSC_VIEWER_CLASSID, &SLIP_Output},
};

/* One row per stage. */
static const struct {
  const char *name;
  PetscLogStage *stage;
} Stages[] = {
  {"Slip set-up", &SLIP_STAGE_SETUP},
  {"Slip run", &SLIP_STAGE_RUN},
  {"Slip output", &SLIP_STAGE_OUTPUT},
};

static PetscErrorCode Register_Log(void)
{
  PetscFunctionBegin;
  PetscCall(PCInitializePackage());
  PetscCall(MatInitializePackage());
  PetscCall(SNESInitializePackage());
  PetscCall(TSInitializePackage());
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(Events); i++)
    PetscCall(PetscLogEventRegister(Events[i].name, *Events[i].classid, Events[i].event));
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(Stages); i++)
    PetscCall(PetscLogStageRegister(Stages[i].name, Stages[i].stage));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipLogRegister(void)
{
  return SlipRegisterOnce(Register_Log);
}

/* The product of a matrix before logging was added */
typedef struct {
  PetscErrorCode (*mult)(Mat, Vec, Vec);
  PetscLogEvent event;
  PetscBool made; /* H whose products consist of those with K */
  PetscBool dense;
} Product;

static PetscErrorCode LoggedMult(Mat A, Vec x, Vec y)
{
  const SlipProducts before = SlipProductsNow();
  Product *product;
  PetscLogDouble begin, end;

  PetscFunctionBegin;
  PetscCall(SlipObjectQueryData((PetscObject)A, "SlipProduct", &product));
  PetscCall(PetscLogEventBegin(product->event, A, x, y, 0));
  SlipWorkBegin(SLIP_SHARE_PRODUCTS);
  SlipWorkAdd(SLIP_WORK_PRODUCT, 1);
  PetscCall(PetscGetFlops(&begin));
  PetscCall((*product->mult)(A, x, y));
  PetscCall(PetscGetFlops(&end));
  if (product->dense) SlipWorkLogged(SLIP_WORK_DENSE, end - begin);
  SlipWorkEnd();
  PetscCall(PetscLogEventEnd(product->event, A, x, y, 0));
  if (product->event == SLIP_ViscosityMult)
    SlipProductsAdd((SlipProducts){.h = 1, .all = product->made ? 0 : 1});
  else if (SlipProductsNow().k == before.k)
    SlipProductsAdd((SlipProducts){.k = 1, .all = 1});
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Logs every product with A as the event, in addition to PETSc's MatMult, whatever its type, and counts it: users then
  see K, H and B separately even if two of them have the same type. Further calls do nothing.
*/
PetscErrorCode SlipLogProducts(Mat A, PetscLogEvent event)
{
  Product *product;
  SlipMatFn *mult = NULL;
  MatType type;

  PetscFunctionBegin;
  PetscCall(SlipObjectQueryData((PetscObject)A, "SlipProduct", &product));
  if (product) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MatGetType(A, &type));
  PetscCall(MatGetOperation(A, MATOP_MULT, &mult));
  PetscCheck(mult, PetscObjectComm((PetscObject)A), PETSC_ERR_SUP, "A matrix of type %s has no product", type);
  PetscCall(PetscNew(&product));
  product->mult = (PetscErrorCode(*)(Mat, Vec, Vec))mult;
  product->event = event;
  PetscCall(PetscStrcmp(type, "sliplanczos", &product->made));
  PetscCall(PetscObjectTypeCompareAny((PetscObject)A, &product->dense, MATSEQDENSE, MATMPIDENSE, ""));
  PetscCall(SlipObjectComposeData((PetscObject)A, "SlipProduct", product, SlipContainerDestroyDefault));
  PetscCall(MatSetOperation(A, MATOP_MULT, SlipMatShellFn(LoggedMult)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Replaces MATOP_MULT of A, and returns the previous function in *before; products are logged as before. */
PetscErrorCode SlipLogProductsReplace(Mat A, PetscErrorCode (*mult)(Mat, Vec, Vec),
                                      PetscErrorCode (**before)(Mat, Vec, Vec))
{
  SlipMatFn *old = NULL;
  Product *product;

  PetscFunctionBegin;
  PetscCall(SlipObjectQueryData((PetscObject)A, "SlipProduct", &product));
  if (product) {
    *before = product->mult;
    product->mult = mult;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(MatGetOperation(A, MATOP_MULT, &old));
  *before = (PetscErrorCode(*)(Mat, Vec, Vec))old;
  PetscCall(MatSetOperation(A, MATOP_MULT, SlipMatShellFn(mult)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets whether products with A are counted. */
PetscErrorCode SlipLogsProducts(Mat A, PetscBool *counted)
{
  const Product *product;

  PetscFunctionBegin;
  PetscCall(SlipObjectQueryData((PetscObject)A, "SlipProduct", &product));
  *counted = product ? PETSC_TRUE : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipLogOutputBegin(void)
{
  PetscFunctionBegin;
  PetscCall(PetscLogStagePush(SLIP_STAGE_OUTPUT));
  PetscCall(PetscLogEventBegin(SLIP_Output, 0, 0, 0, 0));
  PetscCall(SlipProductsPush(SLIP_PRODUCTS_LOOK));
  SlipWorkAdd(SLIP_WORK_PIECE, 1);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipLogOutputEnd(void)
{
  PetscFunctionBegin;
  PetscCall(SlipProductsPop());
  PetscCall(PetscLogEventEnd(SLIP_Output, 0, 0, 0, 0));
  PetscCall(PetscLogStagePop());
  PetscFunctionReturn(PETSC_SUCCESS);
}
