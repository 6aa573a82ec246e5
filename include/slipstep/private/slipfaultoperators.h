/* The operators of a fault, and the critical state that follows from them and the strength */
#pragma once
#include <slipstep/rooms/slipfault.h>
#include <slipstep/rooms/slipelastic.h>

typedef struct {
  PetscReal mass;           /* rho Ly [kg/m^2] */
  PetscReal tstar;          /* Ly sqrt(rho/G) [s] */
  PetscReal scaling;        /* factor by which K was multiplied */
  uint64_t read;            /* hash of the entries read from -fault_stiffness_file, the same on all ranks */
  Vec vinf;                 /* loading rate [m/s] */
  PetscReal hmat_tolerance; /* of the stiffness if it is hierarchical; 0: before set-up */
  char hmat_why[96];        /* where the tolerance is from */
} SlipFaultOperators;

/* The critical state, and the means that make observations dimensionless */
typedef struct {
  PetscBool known;       /* otherwise uc and what follows are 0: the start is given, without a solve with K */
  Vec uc;                /* K^-1 q(0): displacement at the instability, positive [m] */
  PetscReal start_share; /* displacement of the start over uc; 0 without stress, or if it is given */
  PetscReal mean_dc;     /* mean d_c [m] */
  PetscReal mean_uc;     /* mean uc [m] */
  PetscReal mean_q0;     /* mean strength at the start [Pa] */
  PetscReal mean_drop;   /* mean of q(0) - q after all weakening [Pa] */
  PetscReal drop_slip;   /* mean uc times mean strength drop over mean q0: slip that corresponds to the drop [m] */
  PetscReal energy;      /* uc' K uc [Pa m], the sum over all cells */
  PetscReal weakening;   /* uc (-dq/ds) uc at the start [Pa m], likewise */
  PetscReal inertia;     /* uc M uc [kg], likewise, over the mean area */
} SlipFaultCritical;

/* operators.c: K of the mesh or of a file, its scaling, H and B */
PETSC_EXTERN PetscErrorCode SlipFaultMediumCreate(SlipFault fault);
PETSC_EXTERN PetscErrorCode SlipFaultStiffnessSetUp(SlipFault fault);
/* critical.c: computes uc and the units of observables; x = K^-1 b from the guess x */
PETSC_EXTERN PetscErrorCode SlipFaultCriticalSetUp(SlipFault fault);
