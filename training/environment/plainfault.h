/* A small fault and its Bathe step on plain arrays: what the library computes with the default integrator (trapezoidal
   reaction, gamma 1/2, embedded error) and the semismooth solver, an order of magnitude faster for a few cells because
   no object is involved. Friction, cone, coefficients and the decisions of the solver are the library's own
   (slipcore.h); the loops over stages and Newton steps are here. Trainers run millions of episodes; a test holds it to
   the library step by step. */
#pragma once
#include "plainpolicy.h"

/* What an explicit step goes on from: f = -K u, then the damping H v+ of the last step's inner rate v+ and that of the
   step before, that of the state, v+ and K v+, [n] each */
enum { PLAIN_MEMORY = 6 };
typedef struct {
  PetscBool known;
  double *f;          /* [PLAIN_MEMORY n] */
  double h, h_before; /* of these steps [s]; 0: there was none */
} PlainMemory;

typedef struct {
  PetscInt n;
  double mass;                /* [kg/m^2] */
  double *K, *H;              /* [n n] Pa/m, Pa s/m */
  SlipFrictionCells friction; /* of the fault, which must live as long */
  SlipBathe bathe;
  SlipFaultNumbers known; /* what is the same throughout a run */
  /* the state, and that at the end of the attempt */
  double *v, *u, *s, *v2, *u2, *s2; /* [n] */
  double *uc;                       /* [n] displacement at the instability [m] */
  double *w1;                       /* of the last attempt: v, u, s of stage 1 [3 n] */
  double slip_error, growth;        /* of the last attempt: sum |e_s| [m], sum of d|v|/dt of sliding cells [m/s^2] */
  double omega;                     /* the largest frequency [1/s], which bounds explicit steps; 0: there are none */
  PlainMemory start, end;
  double *work;
  PetscInt *index; /* [n] */
} PlainFault;

/* From a set-up fault on a grid and its state at the start. */
PETSC_INTERN PetscErrorCode PlainFaultCreate(SlipFault fault, Vec start, PlainFault *p);
PETSC_INTERN PetscErrorCode PlainFaultDestroy(PlainFault *p);
/* y = A x, column by column so that the inner loop vectorises; A is symmetric, so its rows are its columns. */
PETSC_INTERN void PlainMultiply(PetscInt n, const double A[], const double x[], double *restrict y);
PETSC_INTERN void PlainFaultSetState(PlainFault *p, const double w[]); /* w [3 n]: (v, u, s) per cell */
/* One step h [s] from the state into v2, u2, s2; false when a stage did not converge. */
PETSC_INTERN PetscBool PlainFaultAttempt(PlainFault *p, double h);
PETSC_INTERN double PlainFaultLimit(const PlainFault *p); /* the longest stable explicit step [s]; 0: there are none */
PETSC_INTERN void PlainFaultAccept(PlainFault *p);
/* Strength of cell i in the state, and what all weakening would still take from it [Pa] */
PETSC_INTERN double PlainFaultStrength(const PlainFault *p, PetscInt i);
PETSC_INTERN double PlainFaultWeakening(const PlainFault *p, PetscInt i);
/* x K x and x (-dq/ds) x in the state over x M x [1/s^2], x [n]; given: K x [n], or NULL */
PETSC_INTERN void PlainFaultMode(const PlainFault *p, const double x[], const double given[], PetscReal *stiffness,
                                 PetscReal *weakening);

/* ---- runs: under a policy what TSSolve() with TSADAPTRL does, and what the library's observations would say ---- */

typedef struct {
  PetscInt attempts, accepted;
  double products; /* with K and H, of a run whose steps may be explicit: those of implicit ones by what they cost */
} PlainTotals;

/* After each accepted step: its end [s]; the state is p's. */
typedef PetscErrorCode (*PlainWatchFn)(const PlainFault *p, double time, void *ctx);

/* From p's state at time 0 to tmax or max_steps accepted steps or twice as many attempts. costs: steps are explicit,
   and no longer than stable, where that takes fewer products; NULL: all are implicit. */
PETSC_INTERN PetscErrorCode PlainRun(PlainFault *p, PlainPolicy *policy, PetscReal accuracy, PetscReal tmax,
                                     const SlipMethodCosts *costs, PetscInt max_steps, PlainWatchFn fn, void *ctx,
                                     PlainTotals *totals);
