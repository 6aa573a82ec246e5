/* The cache of products with K and H, which known.c uses: pairs of a vector and its products. A pair is found by the
   bits of its vector, so that copies of the vector are found and a vector that has been changed is not. */
#include <slipstep/private/slipelastic.h>
#include <slipstep/private/sliploops.h>

/* K x that follows from the residual of a stage's solve has an error of the forces' rounding over that stage's theta.
   A stage whose theta is so many times longer computes the product anew. (A fault started with steps of a picosecond,
   came to rest and slid on with steps of minutes: no solve had changed the slip rates of the start, and their K x was
   wrong by the rounding over a picosecond.) */
#define LONGER 100

PetscErrorCode SlipElasticFindPair(SlipElastic el, Vec x, SlipElasticPair **pair)
{
  unsigned int same = 0;
  PetscMPIInt size;

  PetscFunctionBegin;
  *pair = NULL;
  PetscCallMPI(MPI_Comm_size(PetscObjectComm((PetscObject)el), &size));
  for (PetscInt k = 0; k < el->npairs; k++) {
    PetscBool here;

    PetscCall(SlipVecSame(x, el->pair[k].x, &here));
    if (here) same |= 1u << k;
    if (here && size == 1) break; /* several processes need all, because the first match must be that of all */
  }
  if (size > 1)
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &same, 1, MPI_UNSIGNED, MPI_BAND, PetscObjectComm((PetscObject)el)));
  for (PetscInt k = 0; k < el->npairs; k++)
    if (same & 1u << k) {
      const SlipElasticPair found = el->pair[k];

      for (; k > 0; k--) el->pair[k] = el->pair[k - 1];
      el->pair[0] = found;
      *pair = &el->pair[0];
      break;
    }
  if (*pair && (*pair)->theta > 0 && el->B) {
    PetscReal theta;

    PetscCall(MatSlipStageGetTheta(el->B, &theta));
    if (theta > LONGER * (*pair)->theta) (*pair)->has[SLIP_ELASTIC_K] = PETSC_FALSE;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipElasticFindImage(SlipElastic el, SlipElasticImage of, Vec x, Vec *image)
{
  SlipElasticPair *pair;

  PetscFunctionBegin;
  *image = NULL;
  if (!el->npairs) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipElasticFindPair(el, x, &pair));
  if (!pair || !pair->has[of]) PetscFunctionReturn(PETSC_SUCCESS);
  *image = pair->image[of];
  if (of == SLIP_ELASTIC_K && pair->theta > 0)
    el->theta = el->theta > 0 ? PetscMin(el->theta, pair->theta) : pair->theta;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipElasticTakePair(SlipElastic el, Vec x, SlipElasticPair **pair)
{
  SlipElasticPair taken;

  PetscFunctionBegin;
  PetscCall(SlipElasticFindPair(el, x, pair));
  if (*pair) PetscFunctionReturn(PETSC_SUCCESS);
  if (el->npairs < SLIP_ELASTIC_PAIRS) el->npairs++;
  taken = el->pair[el->npairs - 1];
  for (PetscInt k = el->npairs - 1; k > 0; k--) el->pair[k] = el->pair[k - 1];
  if (!taken.x) PetscCall(VecDuplicate(x, &taken.x));
  PetscCall(VecCopy(x, taken.x));
  taken.has[SLIP_ELASTIC_K] = taken.has[SLIP_ELASTIC_H] = PETSC_FALSE;
  taken.age = 0;
  taken.theta = 0;
  el->pair[0] = taken;
  *pair = &el->pair[0];
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipElasticSetImage(SlipElasticPair *pair, SlipElasticImage of, Vec image)
{
  PetscFunctionBegin;
  if (!pair->image[of]) PetscCall(VecDuplicate(pair->x, &pair->image[of]));
  PetscCall(VecCopy(image, pair->image[of]));
  pair->has[of] = PETSC_TRUE;
  if (of == SLIP_ELASTIC_K) pair->theta = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipElasticKeepImage(SlipElastic el, SlipElasticImage of, Vec x, Vec image)
{
  SlipElasticPair *pair;

  PetscFunctionBegin;
  if (!el->stage) PetscFunctionReturn(PETSC_SUCCESS); /* only implicit steps use a product again */
  PetscCall(SlipElasticTakePair(el, x, &pair));
  PetscCall(SlipElasticSetImage(pair, of, image));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipElasticDestroyImages(SlipElastic el)
{
  PetscFunctionBegin;
  for (PetscInt k = 0; k < SLIP_ELASTIC_PAIRS; k++) {
    PetscCall(VecDestroy(&el->pair[k].x));
    for (int of = 0; of < 2; of++) PetscCall(VecDestroy(&el->pair[k].image[of]));
  }
  el->npairs = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes the cached products to a checkpoint, or reads them. Collective. */
PetscErrorCode SlipElasticImagesState(SlipElastic el, SlipState state)
{
  static const char *const flag[] = {"pair_%" PetscInt_FMT "_has_stiffness", "pair_%" PetscInt_FMT "_has_viscosity"};
  static const char *const names[] = {"pair_%" PetscInt_FMT "_stiffness", "pair_%" PetscInt_FMT "_viscosity"};
  char name[64];

  PetscFunctionBegin;
  PetscCall(SlipStateGroup(state, "products"));
  PetscCall(SlipStateCount(state, "pairs", SLIP_ELASTIC_PAIRS, &el->npairs));
  for (PetscInt k = 0; k < el->npairs; k++) {
    SlipElasticPair *pair = &el->pair[k];

    if (!pair->x) PetscCall(MatCreateVecs(el->K, &pair->x, NULL));
    PetscCall(PetscSNPrintf(name, sizeof(name), "pair_%" PetscInt_FMT "_slip", k));
    PetscCall(SlipStateVec(state, name, pair->x));
    PetscCall(PetscSNPrintf(name, sizeof(name), "pair_%" PetscInt_FMT "_age", k));
    PetscCall(SlipStateInt(state, name, 1, &pair->age));
    PetscCall(PetscSNPrintf(name, sizeof(name), "pair_%" PetscInt_FMT "_theta", k));
    PetscCall(SlipStateReal(state, name, 1, &pair->theta));
    for (int of = 0; of < 2; of++) {
      PetscCall(PetscSNPrintf(name, sizeof(name), flag[of], k));
      PetscCall(SlipStateBool(state, name, &pair->has[of]));
      if (!pair->has[of]) continue;
      if (!pair->image[of]) PetscCall(VecDuplicate(pair->x, &pair->image[of]));
      PetscCall(PetscSNPrintf(name, sizeof(name), names[of], k));
      PetscCall(SlipStateVec(state, name, pair->image[of]));
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
