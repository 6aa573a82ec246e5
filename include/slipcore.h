/* Pure functions on arrays and scalars: rules that the integrator, the solvers, the controllers and the trainer share.
   None knows an object of PETSc, so that a loop without objects follows the same rules. */
#pragma once
#include <petscsys.h>
#include <stdint.h>

/* ---- friction.c: laws, and what makes of them the strength of a stage ---- */
/* Of one cell. A law that needs more adds a member here and an array to SlipFrictionCells. */
typedef struct {
  PetscReal residual; /* mu_d */
  PetscReal drop;     /* dmu */
  PetscReal slip;     /* d_c [m] */
  PetscReal rate;     /* v_c [m/s] */
} SlipFriction;

/* mu(s, v) and its derivatives with respect to s [1/m] and v [s/m]; s >= 0 cumulative slip [m], v = |slip rate|
   [m/s]. */
typedef void (*SlipFrictionFn)(const SlipFriction *p, PetscReal s, PetscReal v, PetscReal *mu, PetscReal *dmu_ds,
                               PetscReal *dmu_dv);
typedef struct {
  const char *name;
  SlipFrictionFn eval;
  const char *formula;
} SlipFrictionLaw;
PETSC_EXTERN const SlipFrictionLaw SlipFrictionLaws[]; /* ends with a NULL name */
PETSC_EXTERN PetscErrorCode SlipFrictionFind(const char name[], const SlipFrictionLaw **law);

/* Of many cells; borrowed arrays [n]. */
typedef struct {
  const SlipFrictionLaw *law;
  const PetscReal *residual, *drop, *slip, *rate;
  const PetscReal *stress; /* effective normal stress [Pa] */
  const PetscReal *weight; /* of the cells' rows; NULL: 1 */
} SlipFrictionCells;

PETSC_EXTERN void SlipFrictionEvaluate(const SlipFrictionCells *f, PetscInt i, PetscReal s, PetscReal v, PetscReal *mu,
                                       PetscReal *dmu_ds, PetscReal *dmu_dv);
PETSC_EXTERN PetscReal SlipFrictionWeakest(const SlipFrictionCells *f, PetscInt i);
PETSC_EXTERN void SlipFrictionStrength(const SlipFrictionCells *f, PetscInt n, PetscReal theta, PetscInt stride,
                                       const PetscReal s0[], const PetscReal v[], PetscReal q[], PetscReal dq[]);
PETSC_EXTERN void SlipFrictionStateRate(const SlipFrictionCells *f, PetscInt n, PetscInt stride, const PetscReal s[],
                                        const PetscReal v[], PetscReal ds[]);
PETSC_EXTERN void SlipFrictionStateAdvance(const SlipFrictionCells *f, PetscInt n, PetscReal theta,
                                           const PetscReal s0[], const PetscReal v[], PetscInt stride, PetscReal s[]);

/* ---- cone.c ---- */
/* Where x - rho g lies: inside the shrinkage interval (sticking), beyond it (sliding one way or the other), or on a row
   that has no bound and therefore always "slides". */
typedef enum {
  SLIP_REGION_NEGATIVE = -1,
  SLIP_REGION_STICK = 0,
  SLIP_REGION_POSITIVE = 1,
  SLIP_REGION_FREE = 2
} SlipRegion;

PETSC_EXTERN PetscReal SlipConeShrink(PetscReal p, PetscReal k);
PETSC_EXTERN PetscReal SlipConeClip(PetscReal r, PetscReal q);
PETSC_EXTERN SlipRegion SlipConeRegion(PetscReal x, PetscReal g, PetscReal rho, PetscReal wq);
PETSC_EXTERN PetscReal SlipConeNatural(PetscInt n, PetscReal omega, const PetscReal x[], const PetscReal g[],
                                       const PetscReal q[], const PetscReal dq[], const PetscReal rho[], PetscReal F[],
                                       PetscReal mask[], PetscReal slope[]);
PETSC_EXTERN PetscReal SlipConeReaction(PetscReal omega, PetscReal x, PetscReal g, PetscReal q);
PETSC_EXTERN void SlipConeFinish(PetscInt n, PetscReal omega, const PetscReal g[], const PetscReal q[],
                                 const PetscReal rho[], PetscReal x[], PetscReal r[]);
PETSC_EXTERN void SlipConeProject(PetscInt n, PetscReal omega, const PetscReal x[], const PetscReal g[],
                                  const PetscReal q[], const PetscReal rho[], PetscReal x1[]);
PETSC_EXTERN void SlipConeChanges(PetscInt n, const PetscReal x[], const PetscReal x1[], const PetscReal g[],
                                  const PetscReal g1[], const PetscReal rho[], PetscReal sum[2]);
PETSC_EXTERN PetscBool SlipConeAdaptStep(PetscInt trial, const PetscReal sum[2], PetscReal *factor);
PETSC_EXTERN PetscBool SlipConeStopTurning(PetscInt n, const PetscReal q[], const PetscReal from[], PetscReal to[]);

/* ---- search.c: numbers and decisions of the semismooth Newton method ---- */
#define SLIP_SEARCH_RTOL 1e-10     /* natural residual over the characteristic traction */
#define SLIP_SEARCH_ROUNDING 1e-15 /* relative residual that summation errors leave */
enum {
  SLIP_SEARCH_MAX_IT = 50,
  SLIP_SEARCH_MEMORY = 5,      /* merits that a new one is compared with */
  SLIP_SEARCH_HALVINGS = 4,    /* of a step that does not lower them */
  SLIP_SEARCH_DOUBLINGS = 40,  /* of a step that left out the slope of the bound */
  SLIP_SEARCH_PROJECTIONS = 20 /* projection steps when stuck */
};

typedef struct {
  PetscReal recent[SLIP_SEARCH_MEMORY]; /* merits */
  PetscInt stalls;                      /* steps in a row without enough decrease */
} SlipSearch;

PETSC_EXTERN void SlipSearchForget(SlipSearch *search, PetscReal merit);
PETSC_EXTERN void SlipSearchRemember(SlipSearch *search, PetscInt it, PetscReal merit);
PETSC_EXTERN PetscBool SlipSearchAccepts(const SlipSearch *search, PetscReal lambda, PetscReal merit);
PETSC_EXTERN PetscBool SlipSearchSuffices(PetscReal last, PetscReal merit);
PETSC_EXTERN PetscBool SlipSearchStuck(SlipSearch *search, PetscBool stalled, PetscReal merit);
PETSC_EXTERN PetscBool SlipSearchOvershoots(PetscReal last_push, PetscReal push);
PETSC_EXTERN PetscBool SlipSearchPolished(PetscReal last, PetscReal norm, PetscReal step, PetscReal size);

/* ---- bathe.c: numbers of the composite step ---- */
/* The split gamma is in (0, 1); A dw/dt = F_s + r */
typedef struct {
  PetscReal a1, a0, b; /* stage 2: A w2 = a1 A w1 - a0 A w0 + b h (F_s(w2) + r2) */
  PetscReal weight[3]; /* of the derivatives k at t, t + gamma h, t + h: w2 = w0 + h sum weight_i k_i */
  PetscReal error[3];  /* e = h sum error_i k_i, to third order */
} SlipBathe;

PETSC_EXTERN void SlipBatheCoefficients(PetscReal gamma, SlipBathe *c);
PETSC_EXTERN void SlipBatheThetas(PetscReal gamma, PetscReal h, PetscReal theta[2]);

/* ---- hash.c ---- */
#define SLIP_HASH_START UINT64_C(14695981039346656037)
PETSC_EXTERN uint64_t SlipHashBytes(uint64_t hash, const void *data, size_t n);
PETSC_EXTERN uint64_t SlipHashReals(uint64_t hash, const PetscReal a[], size_t n);
