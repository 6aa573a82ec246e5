/* What is known of a state: sums over its cells, observations, energies and powers, kept for the moment that they were
   computed of. */
#pragma once
#include <slipfault.h>
#include <slipcore.h>
#include <slipstep/private/slipfaultloads.h>

/* All that what was computed of a state depends on: the vector and how it was then, the load, and the slip rates, which
   TSRK is not told of when they are put into its solution */
typedef struct {
  PetscObjectId id;
  PetscObjectState state;
  PetscReal time;   /* of the load, 0 where it is always the same [s] */
  PetscInt64 rates; /* how often rates were put into states */
} SlipFaultMoment;

/* ---- sums over the cells that observables are made of ---- */
typedef enum {
  SUM_V,
  SUM_ABS_V,
  SUM_V2,
  SUM_U,
  SUM_S,
  SUM_SLIDING,
  SUM_U_KU,    /* sum u K u */
  SUM_V_KU,    /* sum v K u */
  SUM_VINF_KU, /* sum v_inf K u */
  SUM_VINF,
  SUM_U_T,       /* sum u T, T the shear load */
  SUM_LOADING_T, /* sum v_inf T - u dT/dt */
  SUM_STRENGTH,
  SUM_WEAKENING, /* what the strength still exceeds its residual by */
  SUM_PUSH,      /* what the elastic force along the motion exceeds the strength by */
  FAULT_NUM_SUMS
} SlipFaultSumId;

typedef struct {
  PetscReal sum[FAULT_NUM_SUMS];
  PetscReal max_v; /* max |v| [m/s] */
  SlipFaultMoment moment;
} SlipFaultSums;

/* What the integrator's last attempt says: its local error and the derivative of the rate at its end. */
typedef enum {
  ESTIMATE_SLIP_ERROR, /* sum |e_s| */
  ESTIMATE_GROWTH,     /* sum of d|v|/dt over sliding cells */
  FAULT_NUM_ESTIMATES
} SlipFaultEstimateId;

typedef struct {
  PetscBool known;
  PetscReal sum[FAULT_NUM_ESTIMATES]; /* weighted by area */
} SlipFaultEstimates;

/* Of the rate, or where all rest of the critical displacement: sums x K x, x (-dq/ds) x and x M x. */
typedef enum { MODE_STIFFNESS, MODE_WEAKENING, MODE_INERTIA, FAULT_NUM_MODE } SlipFaultModeId;

typedef struct {
  PetscReal sum[FAULT_NUM_MODE];
  SlipFaultMoment moment;
} SlipFaultMode;

/* Of SlipElasticGetPower() */
typedef struct {
  PetscReal power;
  SlipFaultMoment moment;
} SlipFaultLost;

/* Of SlipFaultGetPowers() of friction that sticks, which the catalogue and the series ask for at the end of a step */
typedef struct {
  PetscReal power[3];
  SlipFaultMoment moment;
} SlipFaultPowers;

/* stepvalues.c: each of the moment beside it */
typedef struct {
  Vec traction;   /* static, weighted by area */
  PetscReal rate; /* largest |v| [m/s] */
  SlipFaultMoment traction_moment, rate_moment;
} SlipFaultStepValues;

/* coupling.c: the normal stress of the state asked about last, where slip changes it */
typedef struct {
  Vec u, rise;        /* its displacement [m] and Kn u [Pa]; NULL where slip does not */
  Vec drive;          /* Kn v_inf, by which the stress of a fault at rest falls [Pa/s] */
  Vec start;          /* Kn u of the start, which changes nothing [Pa]; NULL: 0 */
  Vec factor;         /* of a stage: theta dq/dsigma at the rates that its bound was asked about last */
  PetscReal *stress;  /* [n] effective normal stress, at least 0 [Pa] */
  PetscReal *one;     /* [n] where cells open: 1, the pressure over itself; else NULL */
  PetscReal *pull;    /* [n] likewise: what pulls cells that are closed apart [Pa] */
  PetscBool balanced; /* rise is that of the last right-hand side */
  SlipFaultMoment moment;
} SlipFaultCoupling;

/* faultobserve.c: what is known of the state asked about last */
typedef struct {
  SlipFaultLoad load; /* that of the time asked about last */
  SlipFaultSums sums;
  SlipFaultMode mode;
  SlipFaultLost lost;
  SlipFaultPowers powers;
  SlipFaultEstimates estimates;
  SlipFaultStepValues step;
  PetscReal step_limit, solve_cost; /* of the integrator, as SlipFaultNumbers has them */
} SlipFaultKnown;

/* faultobserve.c. Is what is known of a moment that of the state w of now, with the load of time t? */
PETSC_EXTERN PetscErrorCode SlipFaultStateUnchanged(SlipFault fault, PetscReal t, Vec w, const SlipFaultMoment *known,
                                                    SlipFaultMoment *now, PetscBool *same);
/* The fastest relaxation of stress by a cell's own slip [1/s], of the rates of the last right-hand side; 0: of no
   explicit problem */
PETSC_INTERN PetscErrorCode SlipFaultDrift(TS ts, PetscReal h, Vec w0, Vec F, Vec w1, void *fault);
PETSC_INTERN PetscErrorCode SlipFaultSlipStep(TS ts, PetscReal t, Vec w, PetscReal *longest, void *fault);
PETSC_INTERN PetscErrorCode SlipFaultShortestStep(TS ts, PetscReal *step, void *fault);
PETSC_INTERN PetscErrorCode SlipFaultWaits(TS ts, PetscReal t, Vec w, PetscBool *waits, void *fault);
PETSC_INTERN PetscErrorCode SlipFaultRefuseLearnedWaves(SlipFault fault, TS ts); /* an error */
PETSC_EXTERN PetscErrorCode SlipFaultRelaxation(TS ts, Vec w, PetscReal *relaxation, void *fault);
/* The largest eigenvalue of K over the weights, once a run [Pa/m] */
PETSC_INTERN PetscErrorCode SlipFaultLargestEigenvalue(SlipFault fault, PetscReal *largest);
PETSC_EXTERN PetscErrorCode SlipFaultGetSums(SlipFault fault, PetscReal t, Vec w, const SlipFaultSums **sums);
PETSC_EXTERN PetscErrorCode SlipFaultObserve(SlipFault fault, PetscReal t, Vec w, PetscInt n, const PetscInt row[],
                                             PetscReal value[]);
/* explicitkick.c: of the explicit step that led to w: its inner rate and K times that; found: there was one, and it
   moved */
PETSC_INTERN PetscErrorCode SlipFaultInnerRate(SlipFault fault, PetscReal t, Vec w, Vec x, Vec kx, Vec nx,
                                               PetscBool *found);
PETSC_EXTERN PetscErrorCode SlipFaultKeepEstimates(SlipFault fault, Vec w, Vec error, Vec derivative);

/* Sums over the cells: power[0] of (v - v_inf) H (v - v_inf), [1] of v_inf H (v - v_inf), [2] of -v r, or q |v|;
   friction [faults]: the last for each fault, or NULL. */
PETSC_EXTERN PetscErrorCode SlipFaultGetPowers(SlipFault fault, PetscReal t, Vec w, Vec r, PetscReal power[3],
                                               PetscReal friction[]);

/* ---- stress.c: elastic stress and energy, and what loading does ---- */
PETSC_EXTERN PetscErrorCode SlipFaultElasticEnergy(SlipFault fault, PetscReal t, Vec w, PetscReal *energy); /* [J] */
PETSC_EXTERN PetscErrorCode SlipFaultLoadingPower(SlipFault fault, PetscReal t, Vec w, PetscReal *power);   /* [W] */

/* stepvalues.c: what several need of the end of a step, computed once for a state w and a time. Collective,
   borrowed. */
PETSC_INTERN PetscErrorCode SlipFaultStepTraction(SlipFault fault, PetscReal time, Vec w, Vec *traction);
PETSC_INTERN PetscErrorCode SlipFaultStepRate(SlipFault fault, PetscReal time, Vec w, PetscReal *largest);
PETSC_INTERN PetscErrorCode SlipFaultStepValuesDestroy(SlipFault fault);
/* The static traction of any state, weighted by area */
PETSC_INTERN PetscErrorCode SlipFaultTraction(SlipFault fault, PetscReal time, Vec w, Vec r);
