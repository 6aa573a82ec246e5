/* What fault offers to the other rooms and to the trainer, and not to users */
#pragma once
#include <slipfault.h>
#include <slipstep/rooms/slipmat.h>
#include <slipstep/rooms/slipcore.h>
#include <slipstep/rooms/slipsnes.h>
#include <slipstep/rooms/slipts.h>
#include <slipstep/rooms/slipsys.h>
#include <slipstep/rooms/slipoutput.h>

PETSC_EXTERN PetscErrorCode SlipFaultInitializePackage(void); /* creation routines call it; later calls do nothing */
PETSC_EXTERN PetscErrorCode SlipFaultSetInertia(SlipFault fault, PetscBool inertia);
PETSC_EXTERN PetscErrorCode SlipFaultReference(SlipFault fault);
PETSC_EXTERN PetscErrorCode SlipFaultFindTolerance(const char kind[], const char controller[], PetscReal accuracy,
                                                   PetscReal *rtol);
PETSC_EXTERN PetscErrorCode SlipFaultGetFrictionOf(SlipFault fault, PetscReal t, Vec w, SlipFrictionCells *friction);
PETSC_EXTERN PetscErrorCode SlipFaultGetTimeScale(SlipFault fault, PetscReal *tstar); /* T* = Ly sqrt(rho/G) [s] */
PETSC_EXTERN PetscErrorCode SlipFaultDeclareOptions(void);
