/* What elastic offers to the other rooms and to the trainer, and not to users */
#pragma once
#include <slipelastic.h>
#include <slipstep/rooms/slipsys.h>

PETSC_EXTERN PetscErrorCode SlipElasticInitializePackage(void); /* creation routines call it; later calls do nothing */
PETSC_EXTERN PetscErrorCode SlipElasticListTypes(char names[], size_t len); /* "|static|...|" */
PETSC_EXTERN PetscErrorCode SlipElasticScale(SlipElastic el, PetscReal factor);
PETSC_EXTERN PetscErrorCode SlipElasticViscous(SlipElastic el, Vec v, PetscReal tolerance, Vec stress);
PETSC_EXTERN PetscErrorCode SlipElasticApplyStage(SlipElastic el, Vec x, Vec y);
PETSC_EXTERN PetscErrorCode SlipElasticForget(SlipElastic el);
PETSC_EXTERN PetscErrorCode SlipElasticStore(SlipElastic el, Vec x, Vec kx);
PETSC_EXTERN PetscErrorCode SlipElasticStoreStage(SlipElastic el, Vec x, Vec bx);
PETSC_EXTERN PetscErrorCode SlipElasticStoreSum(SlipElastic el, Vec y, PetscInt n, const PetscReal a[], const Vec x[]);
PETSC_EXTERN PetscErrorCode SlipElasticApply(SlipElastic el, Vec x, Vec shear,
                                             Vec normal); /* K x, Kn x: of slow slip */
PETSC_EXTERN PetscErrorCode SlipElasticIsIndefinite(SlipElastic el, PetscInt products, Vec b, Vec x, PetscBool *is);
PETSC_EXTERN PetscErrorCode SlipElasticGetDiagonals(SlipElastic el, Vec *k, Vec *h); /* of K and df/dv, borrowed */
PETSC_EXTERN PetscErrorCode SlipElasticGetImpedance(SlipElastic el, PetscReal *eta);
PETSC_EXTERN PetscErrorCode SlipElasticGetPower(SlipElastic el, PetscReal t, Vec u, Vec v, PetscReal *lost);
PETSC_EXTERN PetscErrorCode SlipElasticGetFrequency(SlipElastic el, PetscReal *omega);
PETSC_EXTERN PetscErrorCode SlipElasticGetFoundFrequency(SlipElastic el, PetscReal *omega);
PETSC_EXTERN PetscErrorCode SlipElasticRests(SlipElastic el, PetscBool *rests);
PETSC_EXTERN PetscErrorCode SlipElasticLoads(SlipElastic el, PetscBool *loads);
PETSC_EXTERN PetscErrorCode SlipElasticGetShortestStep(SlipElastic el, PetscReal *step);
PETSC_EXTERN PetscErrorCode SlipElasticGetImages(SlipElastic el, PetscReal *first, PetscReal *last);
PETSC_EXTERN PetscErrorCode SlipElasticRemembers(SlipElastic el, PetscBool *remembers);
PETSC_EXTERN PetscErrorCode SlipElasticAccept(SlipElastic el, PetscReal t, Vec u, PetscBool first);
PETSC_EXTERN PetscErrorCode SlipElasticAdvance(SlipElastic el, PetscReal t, Vec u);
PETSC_EXTERN PetscErrorCode SlipElasticRollBack(SlipElastic el);
PETSC_EXTERN PetscErrorCode SlipElasticVisit(SlipElastic el, SlipState state);
