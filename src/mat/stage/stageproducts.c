/* Products with the stage operator: fused by transforms or per wavenumber, with an assembled matrix, or by K and H
   separately. */
#include <slipstep/private/slipmatstage.h>

static PetscErrorCode StageMultPlane(SlipStageContext *s, Vec x, Vec y)
{
  const PetscReal factor[] = {s->mass / s->theta, s->theta * s->scale, s->damping * PetscSqrtReal(s->scale)};

  PetscFunctionBegin;
  PetscCall(SlipToeplitzMultSum(s->plane, factor, &s->sum, s->sum_here, s->sum_there, x, y));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipStageMult(Mat B, Vec x, Vec y)
{
  const SlipGrid *g;
  const PetscReal *symbol, *viscosity, *px;
  SlipStageContext *s;
  SlipCirculant same;
  PetscInt nk;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(B, &s));
  PetscCheck(s->theta > 0, PetscObjectComm((PetscObject)B), PETSC_ERR_ORDER, "Call MatSlipStageSetTheta() first");
  if (s->assemble || s->strike || s->plane) SlipProductsAdd((SlipProducts){.k = 1, .h = s->counts ? 1 : 0, .all = 1});
  if (s->assemble) {
    if (!s->assembled || s->assembled_theta != s->theta) {
      if (!s->assembled) PetscCall(MatDuplicate(s->K, MAT_DO_NOT_COPY_VALUES, &s->assembled));
      PetscCall(MatCopy(s->H, s->assembled, SAME_NONZERO_PATTERN));
      PetscCall(MatAXPY(s->assembled, s->theta, s->K, SAME_NONZERO_PATTERN));
      if (s->weights) {
        PetscCall(VecCopy(s->weights, s->work));
        PetscCall(VecScale(s->work, s->mass / s->theta));
        PetscCall(MatDiagonalSet(s->assembled, s->work, ADD_VALUES));
      } else
        PetscCall(MatShift(s->assembled, s->mass / s->theta));
      s->assembled_theta = s->theta;
    }
    PetscCall(MatMult(s->assembled, x, y));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (s->strike) {
    if (s->assembled_theta != s->theta) {
      SlipCirculantGet(s->strike, &g, NULL, &nk, &symbol);
      PetscCall(SlipSpectralGetBlocks(s->H, &same, &viscosity));
      for (size_t i = 0; i < (size_t)nk * g->nz * g->nz; i++)
        s->blocks[i] = viscosity[i] + s->theta * s->scale * symbol[i];
      for (PetscInt k = 0; k < nk; k++)
        for (PetscInt iz = 0; iz < g->nz; iz++) s->blocks[((size_t)k * g->nz + iz) * g->nz + iz] += s->mass / s->theta;
      s->assembled_theta = s->theta;
    }
    PetscCall(SlipGatherGet(&s->gather, x, &px));
    PetscCall(SlipCirculantApply(s->strike, 1, s->blocks, px, s->y));
    PetscCall(SlipSpectralAddCorrection(s->H, 0, px, s->y));
    PetscCall(SlipGatherRestore(&s->gather, x, &px));
    PetscCall(SlipGatherPut(&s->gather, s->y, y));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (s->plane) {
    PetscCall(StageMultPlane(s, x, y));
    if (s->correction) PetscCall(SlipSecantAdd(s->correction, x, y));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(MatMult(s->K, x, y));
  if (s->weights) PetscCall(VecPointwiseMult(s->work, s->weights, x));
  PetscCall(VecAXPBY(y, s->mass / s->theta + s->radiation, s->theta, s->weights ? s->work : x));
  if (s->mean > 0) {
    PetscCall(VecScale(y, s->mean));
    if (s->correction) PetscCall(SlipSecantAdd(s->correction, x, y));
  } else if (!(s->radiation > 0)) {
    PetscCall(MatMult(s->H, x, s->work));
    PetscCall(VecAXPY(y, 1, s->work));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipStageGetDiagonal(Mat B, Vec d)
{
  SlipStageContext *s;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(B, &s));
  PetscCheck(s->theta > 0, PetscObjectComm((PetscObject)B), PETSC_ERR_ORDER, "Call MatSlipStageSetTheta() first");
  PetscCall(SlipMatGetDiagonal(s->K, &s->parts[0], d));
  PetscCall(VecScale(d, s->theta));
  if (s->weights)
    PetscCall(VecAXPY(d, s->mass / s->theta, s->weights));
  else
    PetscCall(VecShift(d, s->mass / s->theta));
  if (s->mean > 0)
    PetscCall(VecScale(d, s->mean));
  else {
    PetscCall(SlipMatGetDiagonal(s->H, &s->parts[1], s->work));
    PetscCall(VecAXPY(d, 1, s->work));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
