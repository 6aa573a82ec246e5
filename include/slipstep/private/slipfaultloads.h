/* The loads of a fault: shear load and effective normal stress as functions of time */
#pragma once
#include <slipstep/rooms/slipfault.h>

/* The point source of -fault_injection */
typedef struct {
  PetscReal *distance2;                  /* [n] squared distance of the cells from it [m^2]; NULL: there is none */
  PetscReal pressure, diffusivity, stop; /* [Pa], [m^2/s], [s] */
  PetscReal time;                        /* smallest distance2/(4 D) [s] */
} SlipFaultSource;

typedef struct {
  SlipFault fault;                                    /* the fault with these loads */
  PetscInt n;                                         /* its cells on this process */
  const PetscReal *weight, *traction, *rate, *normal; /* [n] borrowed: area over mean area, T0, dT/dt, normal stress */
  PetscReal origin;                                   /* origin of the times (TSGetSlipOrigin()) [s] */
  PetscBool shears;                                   /* there is a T0 or a dT/dt, or cells open */
  PetscBool grows;                                    /* there is a dT/dt */
  PetscBool pressed;                                  /* there is a pore pressure */
  PetscInt rows;                                      /* of -fault_pore_pressure */
  PetscReal *times, *record;                          /* [rows] [s], [rows][n] [Pa] */
  PetscReal soft;                                     /* stiffness of the fault as a whole [Pa/m]; 0: not computed */
  SlipFaultSource source;
  SlipFaultPressureFn function; /* of SlipFaultSetPressureFunction(), with its context and its [n] values */
  void *ctx;
  PetscReal *own;
  PetscBool opened;          /* the message that cells have no strength was printed */
  Vec drive, hold;           /* at rest: rate of the load, K v_inf + w dT/dt [Pa/s]; H v_inf [Pa] */
  PetscBool drives;          /* drive is not 0 everywhere */
  Vec pull;                  /* K v_inf [Pa/s]; NULL until SlipFaultRestSetUp() */
  PetscReal fastest_healing; /* largest 1/t_h [1/s] */
} SlipFaultLoads;

/* The loads at a time; zero before the first SlipLoadsEvaluate() */
typedef struct {
  PetscReal time, origin; /* [s] */
  Vec shear; /* w (T0 + t dT/dt) with the weights w [Pa], of cells that open followed by -w bare; NULL: always zero */
  const PetscReal *stress; /* [n] effective normal stress before any slip, at least 0 [Pa] */
  const PetscReal *bare;   /* [n] the same without the lower bound */
  PetscReal *own;          /* [2][n] both, unless they are those of the field */
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
