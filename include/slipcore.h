/* Pure functions on arrays and scalars: rules that the integrator, the solvers, the controllers and the trainer share. */
#pragma once
#include <petscsys.h>
#include <stdint.h>

/* ---- cone.c ---- */
/* Where x - rho g lies: inside the shrinkage interval (sticking), beyond it (sliding one way or the other), or on a row
   that has no bound and therefore always "slides". */
typedef enum {
  SLIP_REGION_NEGATIVE = -1,
  SLIP_REGION_STICK = 0,
  SLIP_REGION_POSITIVE = 1,
  SLIP_REGION_FREE = 2
} SlipRegion;

PETSC_INTERN PetscReal SlipConeShrink(PetscReal p, PetscReal k);
PETSC_INTERN PetscReal SlipConeClip(PetscReal r, PetscReal q);
PETSC_INTERN SlipRegion SlipConeRegion(PetscReal x, PetscReal g, PetscReal rho, PetscReal wq);
PETSC_INTERN void SlipConeNatural(PetscInt n, PetscReal omega, const PetscReal x[], const PetscReal g[],
                                  const PetscReal q[], const PetscReal rho[], PetscReal F[], PetscReal mask[]);
PETSC_INTERN void SlipConeSlope(PetscInt n, PetscReal omega, const PetscReal x[], const PetscReal g[],
                                const PetscReal q[], const PetscReal dq[], const PetscReal rho[], PetscReal slope[]);
PETSC_INTERN PetscReal SlipConeInconsistency(PetscInt n, PetscReal omega, const PetscReal x[], const PetscReal g[],
                                             const PetscReal q[], const PetscReal rho[]);
PETSC_INTERN PetscReal SlipConeReaction(PetscReal omega, PetscReal x, PetscReal g, PetscReal q);

/* ---- hash.c ---- */
#define SLIP_HASH_START UINT64_C(14695981039346656037)
PETSC_EXTERN uint64_t SlipHashBytes(uint64_t hash, const void *data, size_t n);
PETSC_EXTERN uint64_t SlipHashReals(uint64_t hash, const PetscReal a[], size_t n);
