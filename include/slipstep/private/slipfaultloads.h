/* What loads and unclamps a fault: shear load and effective normal stress as a function of time. */
#pragma once
#include <slipfault.h>

/* The point source of -fault_injection */
typedef struct {
  PetscReal *distance2;                  /* [n] of the cells from it, squared [m^2]; NULL: there is none */
  PetscReal pressure, diffusivity, stop; /* [Pa], [m^2/s], [s] */
  PetscReal time;                        /* least distance2/(4 D) [s] */
} SlipFaultSource;

typedef struct {
  SlipFault fault;                                    /* that they are of */
  PetscInt n;                                         /* its cells of this process */
  const PetscReal *weight, *traction, *rate, *normal; /* [n] borrowed: area over mean area, T0, dT/dt, normal stress */
  PetscReal origin;                                   /* what times count from (TSGetSlipOrigin()) [s] */
  PetscBool shears;                                   /* there is a T0 or a dT/dt, or cells open */
  PetscBool grows;                                    /* there is a dT/dt */
  PetscBool pressed;                                  /* there is a pore pressure */
  PetscInt rows;                                      /* of -fault_pore_pressure */
  PetscReal *times, *record;                          /* [rows] [s], [rows][n] [Pa] */
  PetscReal soft; /* stiffness of the fault as a whole [Pa/m]; 0: nobody has asked */
  SlipFaultSource source;
  SlipFaultPressureFn function; /* of SlipFaultSetPressureFunction(), with its context and [n] values of it */
  void *ctx;
  PetscReal *own;
  PetscBool opened;          /* it was said that cells are without strength */
  Vec drive, hold;           /* of a fault at rest: rate of its load, K v_inf + w dT/dt [Pa/s], and H v_inf [Pa] */
  PetscBool drives;          /* drive is not 0 everywhere */
  Vec pull;                  /* K v_inf [Pa/s]; NULL until SlipFaultRestSetUp() */
  PetscReal fastest_healing; /* largest 1/t_h [1/s] */
} SlipFaultLoads;

/* What acts at a time; zero before the first SlipLoadsEvaluate() */
typedef struct {
  PetscReal time, origin; /* [s] */
  Vec shear; /* w (T0 + t dT/dt), w the weights [Pa], of cells that open -w bare behind it; NULL: none at any time */
  const PetscReal *stress; /* [n] effective normal stress before any slip, at least 0 [Pa] */
  const PetscReal *bare;   /* [n] the same where it may be less than 0 */
  PetscReal *own;          /* [2][n] both, where they are not that of the field */
} SlipFaultLoad;

static inline PetscBool SlipLoadsVary(const SlipFaultLoads *loads)
{
  return loads->shears || loads->pressed ? PETSC_TRUE : PETSC_FALSE;
}

PETSC_EXTERN PetscErrorCode SlipLoadsEvaluate(const SlipFaultLoads *loads, PetscReal t, SlipFaultLoad *out);
PETSC_EXTERN PetscErrorCode SlipLoadDestroy(SlipFaultLoad *load);
PETSC_EXTERN PetscErrorCode SlipLoadsPressure(const SlipFaultLoads *loads, PetscReal t, PetscReal p[]); /* [n] [Pa] */
PETSC_INTERN PetscErrorCode SlipLoadsOwnPressure(const SlipFaultLoads *loads, PetscReal t);             /* loads->own */
PETSC_INTERN PetscInt SlipLoadsInterval(const SlipFaultLoads *loads, PetscReal t, PetscReal *share);
PETSC_INTERN void SlipLoadsAddRecord(const SlipFaultLoads *loads, PetscReal t, PetscReal p[]);
PETSC_INTERN PetscInt SlipLoadsRowAfter(const SlipFaultLoads *loads, PetscReal t);
PETSC_EXTERN PetscReal SlipLoadsNextCorner(const SlipFaultLoads *loads, PetscReal t);
PETSC_EXTERN PetscReal SlipLoadsPressureScale(const SlipFaultLoads *loads, PetscReal t, PetscReal duration);
PETSC_EXTERN PetscReal SlipExponentialIntegral(PetscReal x);
