/* What a fault knows of its medium, and the critical state that that and its strength make. */
#pragma once
#include <slipfault.h>
#include <slipelastic.h>

typedef struct {
  PetscReal mass;    /* rho Ly [kg/m^2] */
  PetscReal tstar;   /* Ly sqrt(rho/G) [s] */
  PetscReal scaling; /* factor that K was multiplied with */
  uint64_t read;     /* hash of the entries of -fault_stiffness_file as they were read; the same on all ranks */
  Vec vinf;          /* loading rate [m/s] */
} SlipFaultOperators;

/* The critical state, and the means by which observations are made dimensionless */
typedef struct {
  PetscBool known;       /* else uc and what follows of it is zero: the start is given, and no solve with K needed */
  Vec uc;                /* K^-1 q(0): displacement at the instability, positive [m] */
  PetscReal start_share; /* displacement of the start over uc; 0 without stress, or where it is given */
  PetscReal mean_dc;     /* mean d_c [m] */
  PetscReal mean_uc;     /* mean uc [m] */
  PetscReal mean_q0;     /* mean strength at the start [Pa] */
  PetscReal mean_drop;   /* mean of q(0) - q after all weakening [Pa] */
  PetscReal drop_slip;   /* mean uc times mean strength drop over mean q0: slip that the drop implies [m] */
  PetscReal energy;      /* uc' K uc [Pa m], the sum over all cells */
  PetscReal weakening;   /* uc (-dq/ds) uc at the start [Pa m], likewise */
  PetscReal inertia;     /* uc M uc [kg], likewise, over the mean area */
} SlipFaultCritical;

/* operators.c: K of the mesh or of a file, its scaling, H and B */
PETSC_EXTERN PetscErrorCode SlipFaultMediumCreate(SlipFault fault);
PETSC_EXTERN PetscErrorCode SlipFaultStiffnessSetUp(SlipFault fault);
/* critical.c: uc, and what observables are measured in; x = K^-1 b from the guess x */
PETSC_EXTERN PetscErrorCode SlipFaultCriticalSetUp(SlipFault fault);
