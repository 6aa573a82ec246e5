/* Cached results for a state: sums over its cells, observations, energies and powers, each with the moment it is for */
#pragma once
#include <slipstep/rooms/slipfault.h>
#include <slipstep/rooms/slipcore.h>
#include <slipstep/private/slipfaultloads.h>

/* All that cached results of a state depend on: the vector and its object state, the load, and the slip rates, as TSRK
   does not notice that they are written into its solution. */
typedef struct {
  PetscObjectId id;
  PetscObjectState state;
  PetscReal time;   /* of the load, 0 if the load is constant [s] */
  PetscInt64 rates; /* how often rates were written into states */
} SlipFaultMoment;

/* ---- sums over the cells, for observables ---- */
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
  SUM_U_T,       /* sum u T, T the shear load without terms */
  SUM_LOADING_T, /* sum v_inf T - u dT/dt, and v times the terms */
  SUM_STRENGTH,
  SUM_WEAKENING, /* excess of the strength over its residual */
  SUM_PUSH,      /* excess of the elastic force along the motion over the strength */
  FAULT_NUM_SUMS
} SlipFaultSumId;

typedef struct {
  PetscReal sum[FAULT_NUM_SUMS];
  PetscReal max_v; /* max |v| [m/s] */
  SlipFaultMoment moment;
} SlipFaultSums;

/* Estimates of the integrator's last attempt: its local error, and the derivative of the rate at its end */
typedef enum {
  ESTIMATE_SLIP_ERROR, /* sum |e_s| */
  ESTIMATE_GROWTH,     /* sum of d|v|/dt over sliding cells */
  FAULT_NUM_ESTIMATES
} SlipFaultEstimateId;

typedef struct {
  PetscBool known;
  PetscReal sum[FAULT_NUM_ESTIMATES]; /* weighted by area */
} SlipFaultEstimates;

/* Sums x K x, x (-dq/ds) x and x M x, where x is the rate, or the critical displacement if all cells rest */
typedef enum { MODE_STIFFNESS, MODE_WEAKENING, MODE_INERTIA, FAULT_NUM_MODE } SlipFaultModeId;

typedef struct {
  PetscReal sum[FAULT_NUM_MODE];
  SlipFaultMoment moment;
} SlipFaultMode;

/* Result of SlipElasticGetPower() */
typedef struct {
  PetscReal power;
  SlipFaultMoment moment;
} SlipFaultLost;

/* Result of SlipFaultGetPowers() for friction that sticks; the catalogue and the series need it at the end of a step */
typedef struct {
  PetscReal power[3];
  SlipFaultMoment moment;
} SlipFaultPowers;

/* stepvalues.c: values with the moments of each */
typedef struct {
  Vec traction;   /* static, weighted by area */
  PetscReal rate; /* largest |v| [m/s] */
  SlipFaultMoment traction_moment, rate_moment;
} SlipFaultStepValues;

/* coupling.c: the normal stress of the last evaluated state, if slip changes it */
typedef struct {
  Vec u, rise;        /* its displacement [m] and Kn u [Pa]; NULL if slip does not change it */
  Vec drive;          /* Kn v_inf, the rate at which the stress of a fault at rest decreases [Pa/s] */
  Vec start;          /* Kn u of the start, which has no effect [Pa]; NULL: 0 */
  Vec factor;         /* of a stage: theta dq/dsigma at the rates of the last bound */
  PetscReal *stress;  /* [n] effective normal stress, at least 0 [Pa] */
  PetscReal *one;     /* [n] if cells open: 1, the pressure over itself; else NULL */
  PetscReal *pull;    /* [n] likewise: the tension on closed cells [Pa] */
  PetscBool balanced; /* rise belongs to the last right-hand side */
  SlipFaultMoment moment;
} SlipFaultCoupling;

/* faultobserve.c: cached results for the last state */
typedef struct {
  SlipFaultLoad load; /* that of the last time */
  SlipFaultSums sums;
  SlipFaultMode mode;
  SlipFaultLost lost;
  SlipFaultPowers powers;
  SlipFaultEstimates estimates;
  SlipFaultStepValues step;
  PetscReal step_limit, solve_cost; /* of the integrator, see SlipFaultNumbers */
} SlipFaultKnown;

/* faultobserve.c. Checks whether the cached moment is that of the state w with the load at time t. */
PETSC_EXTERN PetscErrorCode SlipFaultStateUnchanged(SlipFault fault, PetscReal t, Vec w, const SlipFaultMoment *known,
                                                    SlipFaultMoment *now, PetscBool *same);
/* The fastest relaxation of stress by a cell's own slip [1/s], at the rates of the last right-hand side; 0 if the
   problem is not explicit */
PETSC_INTERN PetscErrorCode SlipFaultDrift(TS ts, PetscReal h, Vec w0, Vec F, Vec w1, void *fault);
PETSC_INTERN PetscErrorCode SlipFaultSlipStep(TS ts, PetscReal t, Vec w, PetscReal *longest, void *fault);
PETSC_INTERN PetscErrorCode SlipFaultShortestStep(TS ts, PetscReal *step, void *fault);
PETSC_INTERN PetscErrorCode SlipFaultWaits(TS ts, PetscReal t, Vec w, PetscBool *waits, void *fault);
PETSC_INTERN PetscErrorCode SlipFaultRefuseControllers(SlipFault fault, TS ts); /* raises an error */
PETSC_EXTERN PetscErrorCode SlipFaultRelaxation(TS ts, Vec w, PetscReal *relaxation, void *fault);
/* Computes the largest eigenvalue of K over the weights, once a run [Pa/m]. */
PETSC_INTERN PetscErrorCode SlipFaultLargestEigenvalue(SlipFault fault, PetscReal *largest);
PETSC_EXTERN PetscErrorCode SlipFaultGetSums(SlipFault fault, PetscReal t, Vec w, const SlipFaultSums **sums);
PETSC_EXTERN PetscErrorCode SlipFaultObserve(SlipFault fault, PetscReal t, Vec w, PetscInt n, const PetscInt row[],
                                             PetscReal value[]);
/* explicitkick.c: gets the inner rate of the explicit step that led to w, and K times it; found: it exists and moves */
PETSC_INTERN PetscErrorCode SlipFaultInnerRate(SlipFault fault, PetscReal t, Vec w, Vec x, Vec kx, Vec nx,
                                               PetscBool *found);
PETSC_EXTERN PetscErrorCode SlipFaultKeepEstimates(SlipFault fault, Vec w, Vec error, Vec derivative);

/* Sums over the cells: power[0] of (v - v_inf) H (v - v_inf), [1] of v_inf H (v - v_inf), [2] of -v r, or q |v|;
   friction [faults]: the last one for each fault, or NULL */
PETSC_EXTERN PetscErrorCode SlipFaultGetPowers(SlipFault fault, PetscReal t, Vec w, Vec r, PetscReal power[3],
                                               PetscReal friction[]);

/* ---- stress.c: elastic stress and energy, and the work of loading ---- */
PETSC_EXTERN PetscErrorCode SlipFaultElasticEnergy(SlipFault fault, PetscReal t, Vec w, PetscReal *energy); /* [J] */
PETSC_INTERN PetscErrorCode SlipFaultTermsEnergy(SlipFault fault, PetscReal t, Vec w, PetscReal *energy);   /* [J] */
PETSC_EXTERN PetscErrorCode SlipFaultLoadingPower(SlipFault fault, PetscReal t, Vec w, PetscReal *power);   /* [W] */

/* stepvalues.c: values at the end of a step, computed once for a state w and a time; collective, borrowed */
PETSC_INTERN PetscErrorCode SlipFaultStepTraction(SlipFault fault, PetscReal time, Vec w, Vec *traction);
PETSC_INTERN PetscErrorCode SlipFaultStepRate(SlipFault fault, PetscReal time, Vec w, PetscReal *largest);
PETSC_INTERN PetscErrorCode SlipFaultStepValuesDestroy(SlipFault fault);
/* Computes the static traction of any state, weighted by area. */
PETSC_INTERN PetscErrorCode SlipFaultTraction(SlipFault fault, PetscReal time, Vec w, Vec r);
