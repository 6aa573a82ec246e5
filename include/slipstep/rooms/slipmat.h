/* What mat offers to the other rooms and to the trainer, and not to users */
#pragma once
#include <slipmat.h>
#include <slipstep/rooms/slipelasticity.h>

/* Creates the N x 3 N rows of normal stress of a stiffness with opening, which is 3 N x 3 N. */
PETSC_EXTERN PetscErrorCode MatCreateSlipNormalRows(Mat S, Mat *Kn);
/* f = K u and n = Kn u; what both need of u is computed once. Kn was created with K, or is any other. */
PETSC_EXTERN PetscErrorCode MatSlipStiffnessMultBoth(Mat K, Mat Kn, Vec u, Vec f, Vec n);
PETSC_EXTERN PetscErrorCode MatSlipStiffnessSetShare(Mat K, PetscBool share); /* spreads wavenumbers over ranks */
PETSC_EXTERN PetscErrorCode SlipMatInitializePackage(void); /* creation routines call it; later calls do nothing */
/* Why this type was chosen, as text; borrowed, "" if there is nothing to report. */
PETSC_EXTERN PetscErrorCode MatSlipGetNotes(Mat A, const char **why);
PETSC_EXTERN PetscErrorCode MatCreateSlipRadiationOpening(Mat K, PetscReal eta, PetscReal across, Mat *H);
/* "auto", "exact" or "approximate": what MatSlipStageGetApproximation() returns; to be called before solver setup */
PETSC_EXTERN PetscErrorCode MatSlipStageSetJacobian(Mat B, const char type[]);
PETSC_EXTERN PetscErrorCode MatSlipStageSetFromOptions(Mat B);
/* Gets a borrowed stage operator at B's theta with a cheap viscosity, for an inexact Newton method; this is B itself if
   its viscosity is cheap already. */
PETSC_EXTERN PetscErrorCode MatSlipStageGetApproximation(Mat B, Mat *A);
