/* Heat and pore pressure of the shear zone of each cell, and dilatancy, which change the effective normal stress */
#pragma once
#include <slipstep/rooms/slipfault.h>
#include <slipstep/rooms/slipcore.h>

typedef struct {
  PetscBool on, dilates;  /* there is a shear zone or dilatancy; there is dilatancy */
  PetscBool presses;      /* pressure changes the normal stress; else temperature is all that is computed */
  SlipShearZone sums;     /* of its kernels; n = 0: there is no shear zone */
  PetscReal storage, run; /* beta [1/Pa] and 1/t_p [1/s] of dilatancy */
  /* The history, in two slots as in slipelastic.h: the time and the numbers of the cells that pressurisation.c lists */
  PetscBool known, trial;
  PetscReal time[2]; /* [s] */
  Vec past[2];
  PetscInt block; /* numbers per cell */
  /* The way from a slot to a time: weights, and the pressure over Lambda that needs nothing of its end */
  PetscBool weighed;
  PetscInt slot;
  PetscReal to;                                                    /* [s] */
  SlipShearZoneWeights *weights, pressure, temperature, dilatancy; /* [sums.n]; their sums over Lambda; of dilatancy */
  PetscReal *share;                                                /* [sums.n] of each memory of the slot in pressure */
  PetscReal *left;                                                 /* [n] [K] */
} SlipFaultZone;

/* Why estimates of errors do not hold where it changes strength */
#define SLIP_ZONE_UNCALIBRATED "not calibrated where slip changes the pore pressure"

PETSC_INTERN PetscErrorCode SlipFaultZoneSetUp(SlipFault fault);
PETSC_INTERN PetscErrorCode SlipFaultZoneDestroy(SlipFault fault);
PETSC_INTERN PetscErrorCode SlipFaultZoneView(SlipFault fault, PetscViewer viewer);
/* The history: what SlipElasticAccept() and its like do for the medium, with the friction of the state, and times that
   count from another origin */
PETSC_INTERN PetscErrorCode SlipFaultZoneAccept(SlipFault fault, PetscReal t, Vec w, const SlipFrictionCells *friction);
PETSC_INTERN void SlipFaultZoneForget(SlipFault fault);
PETSC_INTERN PetscErrorCode SlipFaultZoneAdvance(SlipFault fault, PetscReal t, Vec w,
                                                 const SlipFrictionCells *friction);
PETSC_INTERN PetscErrorCode SlipFaultZoneRollBack(SlipFault fault);
PETSC_INTERN PetscErrorCode SlipFaultZoneVisit(SlipFault fault, SlipState state);
PETSC_INTERN void SlipFaultZoneOrigin(SlipFault fault, PetscReal by);
/* These subtract the pressure from the normal stress [n] without it, which may be negative; the result is at least 0 */
PETSC_INTERN PetscErrorCode SlipFaultZoneOfState(SlipFault fault, PetscReal t, Vec w, PetscReal stress[]);
PETSC_INTERN PetscErrorCode SlipFaultZoneOfBalance(SlipFault fault, PetscReal t, const PetscReal a[],
                                                   const PetscReal tau[], PetscReal stress[]);
PETSC_INTERN PetscErrorCode SlipFaultZoneOfStage(SlipFault fault, Vec u0, const PetscReal v[], PetscReal stress[],
                                                 PetscReal q[], PetscReal dq[]);
/* The norm of the error that steps from the history to the state w at t have in pressure */
PETSC_INTERN PetscErrorCode SlipFaultZoneError(SlipFault fault, PetscReal rtol, PetscReal t, Vec w, Vec rate,
                                               PetscReal *E);
/* Temperature rise [K] and pressure [Pa] [n] of these cells of this process (NULL: all) in a state; either may be NULL.
   Cells < 0, which are elsewhere, are left out */
PETSC_INTERN PetscErrorCode SlipFaultZoneValues(SlipFault fault, PetscReal t, Vec w, const SlipFrictionCells *friction,
                                                PetscInt n, const PetscInt cells[], PetscReal temperature[],
                                                PetscReal pressure[]);
