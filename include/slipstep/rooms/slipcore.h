/* Pure functions on arrays and scalars: rules that the integrator, the solvers, the controllers and the trainer share.
   None uses an object of PETSc, so that a loop without such objects follows the same rules. */
#pragma once
#include <slipcore.h>
#include <slipstep/rooms/slipformulas.h>
#include <stdint.h>

PETSC_EXTERN PetscErrorCode SlipFrictionCheck(const SlipFrictionLaw *law);
PETSC_EXTERN const SlipFrictionLaw *SlipFrictionNext(const SlipFrictionLaw *law); /* NULL: the first; NULL at the end */
PETSC_EXTERN PetscInt SlipFrictionStates(const SlipFrictionLaw *law);
PETSC_EXTERN const char *SlipFrictionStateName(const SlipFrictionLaw *law, PetscInt k);
PETSC_EXTERN const char *SlipFrictionStateUnit(const SlipFrictionLaw *law, PetscInt k);
PETSC_EXTERN PetscReal SlipFrictionExcess(const SlipFrictionCells *f, PetscInt i, const PetscReal s[], PetscReal v);
PETSC_EXTERN PetscReal SlipFrictionWeakest(const SlipFrictionCells *f, PetscInt i);
PETSC_EXTERN void SlipFrictionStage(const SlipFrictionCells *f, PetscInt i, PetscReal theta, const PetscReal s0[],
                                    PetscReal v, PetscReal *mu, PetscReal dmu_ds[], PetscReal *dmu_dv,
                                    PetscReal ds_dv[]);
PETSC_EXTERN void SlipFrictionStateRate(const SlipFrictionCells *f, PetscInt n, PetscInt stride, const PetscReal s[],
                                        PetscInt rates, const PetscReal v[], PetscReal ds[]);
PETSC_EXTERN void SlipFrictionStateRateOf(const SlipFrictionCells *f, PetscInt i, const PetscReal s[], PetscReal v,
                                          PetscReal ds[]);
PETSC_EXTERN void SlipFrictionStateAdvance(const SlipFrictionCells *f, PetscInt n, PetscReal theta,
                                           const PetscReal s0[], const PetscReal v[], PetscInt stride, PetscReal s[]);
PETSC_EXTERN void SlipFrictionStateAtRest(const SlipFrictionCells *f, PetscInt i, const PetscReal s0[], PetscReal t,
                                          PetscReal s[]);
PETSC_EXTERN PetscReal SlipFrictionShown(const SlipFrictionCells *f, PetscInt i, PetscInt k, PetscReal s);
PETSC_EXTERN PetscReal SlipFrictionOfShown(const SlipFrictionCells *f, PetscInt i, PetscInt k, PetscReal shown);
PETSC_EXTERN PetscReal SlipFrictionStressGain(const SlipFrictionCells *f, PetscInt i, PetscReal theta,
                                              const PetscReal s0[], PetscReal v);
PETSC_EXTERN PetscReal SlipFrictionDirect(const SlipFrictionCells *f, PetscInt i);
PETSC_EXTERN void SlipFrictionSteady(const SlipFrictionCells *f, PetscInt i, PetscReal v, PetscReal s[]);
PETSC_EXTERN void SlipFrictionWeakening(const SlipFrictionCells *f, PetscInt i, PetscReal v, PetscReal *fall,
                                        PetscReal *critical);
PETSC_EXTERN void SlipFrictionStateOf(const SlipFrictionCells *f, PetscInt i, PetscInt k, PetscReal mu, PetscReal v,
                                      PetscReal s[]);
/* One cell in a stage of a law that always slides: the diagonal D [Pa s/m] of the stage operator, the weight of the
   reaction, theta [s], and the states at the start */
typedef struct {
  PetscReal diagonal, omega, theta;
  const PetscReal *s0;
} SlipFrictionStageCell;
PETSC_EXTERN PetscReal SlipFrictionStageRate(const SlipFrictionCells *f, PetscInt i, const SlipFrictionStageCell *c,
                                             PetscReal load, PetscReal guess, PetscBool *stable);
PETSC_EXTERN PetscReal SlipFrictionKick(const SlipFrictionCells *f, PetscInt i, const SlipFrictionStageCell *c,
                                        PetscReal load, PetscReal guess, PetscBool *ok);
PETSC_EXTERN void SlipFrictionStateDrift(const SlipFrictionCells *f, PetscInt n, PetscReal h, const PetscReal v[],
                                         PetscInt stride, PetscReal s[], PetscReal work[]);
PETSC_EXTERN void SlipFrictionAdvanceOwn(const SlipFrictionLaw *law, const SlipFriction *p, PetscReal theta,
                                         const PetscReal s0[], PetscReal rate, PetscReal s[], PetscReal ds[]);
PETSC_EXTERN void SlipFrictionInstability(const SlipFrictionLaw *law, const SlipFriction *p, PetscReal v,
                                          PetscReal *fall, PetscReal *critical);
PETSC_EXTERN PetscBool SlipRateAndStateDrift(const SlipFrictionCells *f, PetscInt n, PetscReal h, const PetscReal v[],
                                             PetscInt stride, PetscReal s[]);
PETSC_EXTERN void SlipRateAndStateSteady(const SlipFriction *p, PetscReal v, PetscReal s[]);
PETSC_EXTERN PetscReal SlipFrictionBalanceOne(const SlipFrictionLaw *law, const SlipFriction *p, const PetscReal s[],
                                              PetscReal sigma, PetscReal eta, PetscReal tau);
PETSC_EXTERN PetscReal SlipRateAndStateShift(PetscReal alpha, PetscReal b, PetscReal stress, PetscReal start);
enum { SLIP_RATE_AND_STATE_KEPT = 4 };
PETSC_EXTERN void SlipRateAndStateKeep(const SlipFrictionCells *f, PetscInt n, PetscReal eta, PetscReal kept[]);
/* strongweakening.c */
PETSC_EXTERN const SlipParameter SlipStrongParameters[];
PETSC_EXTERN void SlipStrongRate(const SlipFriction *p, const PetscReal s[], PetscReal v, PetscReal rate[],
                                 PetscReal drate_ds[], PetscReal drate_dv[]);
PETSC_EXTERN void SlipStrongSteady(const SlipFriction *p, PetscReal v, PetscReal s[]);
PETSC_EXTERN PetscBool SlipStrongDrift(const SlipFrictionCells *f, PetscInt n, PetscReal h, const PetscReal v[],
                                       PetscInt stride, PetscReal s[]);
PETSC_EXTERN PetscReal SlipStrongRupture(const SlipFriction *p);
PETSC_EXTERN SlipFrictionBalanceFn SlipStrongBalance;
PETSC_EXTERN SlipFrictionBalanceFn SlipRateAndStateBalance, SlipExponentialWeakeningBalance, SlipFrictionBalance;
PETSC_EXTERN SlipFrictionValues SlipRateAndStateValues, SlipExponentialWeakeningValues;
/* Explicit steps let a cell slip once stress exceeds its strength by this fraction. Stress decays exponentially when an
   event ends, and below the rounding of products with K a cell would never come to rest. */
#define SLIP_FRICTION_HOLD 1e-12
/* SlipFrictionStrength() of exponential slip weakening for theta > 0, vectorised */
PETSC_EXTERN void SlipExponentialWeakeningStrength(const SlipFrictionCells *f, PetscInt n, PetscReal theta,
                                                   PetscInt stride, const PetscReal s0[], PetscInt rates,
                                                   const PetscReal v[], PetscReal q[], PetscReal dq[]);

/* ---- adamsweights.c ---- */
enum { SLIP_ADAMS_NODES = 10, SLIP_ADAMS_CORRECTIONS = 7 };
PETSC_EXTERN void SlipAdamsWeights(PetscInt n, const PetscReal node[], PetscReal weight[]);
PETSC_EXTERN PetscReal SlipAdamsReach(PetscInt k, PetscInt m);
PETSC_EXTERN const PetscReal (*SlipAdamsFactors(PetscInt k, PetscInt m))[2];

/* ---- lag.c ---- */
#define SLIP_LAG_MARGIN (PetscReal)0.97 /* explicit steps use this fraction of the stable step */
PETSC_EXTERN PetscReal SlipLagLimit(PetscReal zeta, PetscReal weight);
PETSC_EXTERN PetscReal SlipLagWeight(PetscReal h, PetscReal h1, PetscReal h2, PetscReal omega, PetscReal zeta);

/* ---- rkcweights.c ---- */
enum { SLIP_RKC_MOST = 200 };
typedef struct {
  PetscReal one, two;    /* weights of the previous stage and of the one before that */
  PetscReal rate, start; /* weights of the rates of the previous stage and of the start of the step */
  PetscReal share;       /* time of the stage as a fraction of the step */
} SlipRKCStage;
PETSC_EXTERN PetscReal SlipRKCStages(PetscReal hrho);
PETSC_EXTERN PetscReal SlipRKCLongest(PetscInt stages);
PETSC_EXTERN void SlipRKCCoefficients(PetscInt s, SlipRKCStage c[]); /* [s + 1], the first unused */

/* ---- cone.c ---- */
PETSC_EXTERN void SlipConeNatural(PetscInt n, PetscReal omega, const PetscReal x[], const PetscReal g[],
                                  const PetscReal q[], const PetscReal dq[], const PetscReal rho[], PetscReal F[],
                                  PetscReal mask[], PetscReal slope[]);
PETSC_EXTERN void SlipConeSmooth(PetscInt n, PetscReal omega, const PetscReal x[], const PetscReal g[],
                                 const PetscReal q[], const PetscReal dq[], const PetscReal mask[], PetscReal F[],
                                 PetscReal slope[]);
PETSC_EXTERN void SlipConeFinish(PetscInt n, PetscReal omega, const PetscReal g[], const PetscReal q[],
                                 const PetscReal rho[], PetscReal x[], PetscReal r[]);
PETSC_EXTERN void SlipConeProject(PetscInt n, PetscReal omega, const PetscReal x[], const PetscReal g[],
                                  const PetscReal q[], const PetscReal rho[], PetscReal x1[]);
PETSC_EXTERN void SlipConeChanges(PetscInt n, const PetscReal x[], const PetscReal x1[], const PetscReal g[],
                                  const PetscReal g1[], const PetscReal rho[], PetscReal sum[2]);
PETSC_EXTERN PetscBool SlipConeAdaptStep(PetscInt trial, const PetscReal sum[2], PetscReal *factor);
PETSC_EXTERN PetscBool SlipConeStopTurning(PetscInt n, const PetscReal q[], const PetscReal from[], PetscReal to[]);

/* The same for cells with two components of slip, n cells: x, g, F, mask, rho, normal, slope and r have c numbers per
   cell side by side, of which the first two are used. */
PETSC_EXTERN void SlipDiskNatural(PetscInt n, PetscInt c, PetscReal omega, const PetscReal x[], const PetscReal g[],
                                  const PetscReal q[], const PetscReal rho[], PetscReal F[], PetscReal mask[],
                                  PetscReal normal[], PetscReal hold[]);
PETSC_EXTERN void SlipDiskSmooth(PetscInt n, PetscInt c, PetscReal omega, const PetscReal x[], const PetscReal g[],
                                 const PetscReal q[], const PetscReal dq[], const PetscReal mask[], PetscReal F[],
                                 PetscReal normal[], PetscReal hold[]);
PETSC_EXTERN void SlipDiskSlope(PetscInt n, PetscInt c, PetscReal omega, const PetscReal x[], const PetscReal dq[],
                                const PetscReal normal[], const PetscReal hold[], PetscReal slope[], PetscReal cross[]);
PETSC_EXTERN void SlipDiskHold(PetscInt n, PetscInt c, const PetscReal normal[], const PetscReal hold[],
                               const PetscReal x[], PetscReal y[]);
PETSC_EXTERN void SlipDiskReaction(PetscReal omega, const PetscReal x[2], const PetscReal g[2], PetscReal q,
                                   PetscReal r[2]);
PETSC_EXTERN void SlipDiskFinish(PetscInt n, PetscInt c, PetscReal omega, const PetscReal g[], const PetscReal q[],
                                 const PetscReal rho[], PetscReal x[], PetscReal r[]);
PETSC_EXTERN void SlipDiskProject(PetscInt n, PetscInt c, PetscReal omega, const PetscReal x[], const PetscReal g[],
                                  const PetscReal q[], const PetscReal rho[], PetscReal x1[]);
PETSC_EXTERN PetscBool SlipDiskStopTurning(PetscInt n, PetscInt c, const PetscReal q[], const PetscReal from[],
                                           PetscReal to[]);

/* Contact normal to the plane of a cell, in the third of its three numbers: r >= 0, x >= 0, x r = 0 (contact.c) */
PETSC_EXTERN void SlipContactPressure(PetscInt n, PetscReal omega, const PetscReal x[], const PetscReal g[],
                                      const PetscReal rho[], PetscReal p[]);
PETSC_EXTERN void SlipContactNatural(PetscInt n, const PetscReal x[], const PetscReal g[], const PetscReal rho[],
                                     PetscReal F[], PetscReal mask[]);
PETSC_EXTERN void SlipContactFinish(PetscInt n, PetscReal omega, const PetscReal g[], const PetscReal rho[],
                                    PetscReal x[], PetscReal r[]);
PETSC_EXTERN void SlipContactProject(PetscInt n, const PetscReal x[], const PetscReal g[], const PetscReal rho[],
                                     PetscReal x1[]);

/* ---- numbers and decisions of the semismooth Newton method, for the SNES type and the trainer's loop: when a step is
   accepted, shortened, lengthened or replaced by projections, and when rounding prevents a better solution */
#define SLIP_SEARCH_RTOL 1e-10     /* natural residual over the characteristic traction */
#define SLIP_SEARCH_ROUNDING 1e-15 /* relative residual left by summation errors */
enum {
  SLIP_SEARCH_MAX_IT = 50,
  SLIP_SEARCH_MEMORY = 5,      /* merits that a new one is compared with */
  SLIP_SEARCH_HALVINGS = 4,    /* of a step that does not lower the merit */
  SLIP_SEARCH_DOUBLINGS = 40,  /* of a step that ignored the slope of the bound */
  SLIP_SEARCH_PROJECTIONS = 20 /* projection steps when Newton steps stall */
};

typedef struct {
  PetscReal recent[SLIP_SEARCH_MEMORY]; /* merits */
  PetscInt stalls;                      /* steps in a row without enough decrease */
} SlipSearch;

/* Sets all stored merits to this one */
static inline void SlipSearchForget(SlipSearch *search, PetscReal merit)
{
  for (PetscInt i = 0; i < SLIP_SEARCH_MEMORY; i++) search->recent[i] = merit;
}

/* The newest merit replaces the oldest. */
static inline void SlipSearchRemember(SlipSearch *search, PetscInt it, PetscReal merit)
{
  search->recent[it % SLIP_SEARCH_MEMORY] = merit;
}

/* A step lambda dx is accepted if its merit is no worse than the worst of the recent ones. */
static inline PetscBool SlipSearchAccepts(const SlipSearch *search, PetscReal lambda, PetscReal merit)
{
  PetscReal limit = 0.0;

  for (PetscInt i = 0; i < SLIP_SEARCH_MEMORY; i++) limit = PetscMax(limit, search->recent[i]);
  return merit < (1.0 - 1e-4 * lambda) * limit ? PETSC_TRUE : PETSC_FALSE;
}

/* True if the full step lowers the merit so much that the step without reversing cells (SlipConeStopTurning()) need not
   be tried. Cells seldom reverse when they come to rest, and sets of cells that reverse together in one step and back
   in the next shrink only by a few cells in each. */
static inline PetscBool SlipSearchSuffices(PetscReal last, PetscReal merit)
{
  return merit <= 0.1 * last ? PETSC_TRUE : PETSC_FALSE;
}

/* Counts stalled steps in a row; projections help against cycling sets of cells if slopes of the bound are small. */
static inline PetscBool SlipSearchStuck(SlipSearch *search, PetscBool stalled, PetscReal merit)
{
  search->stalls = stalled ? search->stalls + 1 : 0;
  return search->stalls >= 3 && !PetscIsInfOrNanReal(merit) ? PETSC_TRUE : PETSC_FALSE;
}

/* A step without the slope of the bound is doubled while the balance of the sliding cells along it, which is negative,
   keeps its sign; otherwise an instability that has hardly begun would take hundreds of steps to grow. Of the last two
   points the one with the better balance is used; true if that is the shorter step. */
static inline PetscBool SlipSearchOvershoots(PetscReal last_push, PetscReal push)
{
  return push > -last_push ? PETSC_TRUE : PETSC_FALSE;
}

/* Newton steps beyond the tolerance end when the residual no longer halves, or when the step is below rounding. */
static inline PetscBool SlipSearchPolished(PetscReal last, PetscReal norm, PetscReal step, PetscReal size)
{
  return norm > 0.5 * last || step <= 1e-11 * size ? PETSC_TRUE : PETSC_FALSE;
}

/* ---- batheweights.c: numbers of the composite step ---- */
/* The split gamma is in (0, 1); A dw/dt = F_s + r. A stage from base is A (w - base) = theta h (F_s(w) + ...). */
typedef struct {
  PetscReal gamma; /* fraction of the step at which stage 1 ends */
  PetscReal theta[2];
  PetscReal a1, a0;    /* stage 2: base = a1 w1 - a0 w0 */
  PetscReal weight[3]; /* of the derivatives k at t, t + gamma h, t + h: w2 = w0 + h sum weight_i k_i */
  PetscReal error[3];  /* e = h sum error_i k_i, of third order */
  PetscReal divisor;   /* the same as one difference: e = h/divisor ((1 - gamma) k0 - k1 + gamma k2) */
} SlipBathe;

/* k2 = (w2 - a1 w1 + a0 w0)/theta, where theta [s] is that of stage 2 */
static inline PetscReal SlipBatheEndRate(const SlipBathe *c, PetscReal theta, PetscReal w0, PetscReal w1, PetscReal w2)
{
  return (w2 - c->a1 * w1 + c->a0 * w0) / theta;
}

PETSC_EXTERN void SlipBatheSetUp(PetscReal gamma, SlipBathe *c);
PETSC_EXTERN void SlipBatheSetUpBackward(SlipBathe *c);
PETSC_EXTERN PetscReal SlipBatheRoundError(PetscReal error); /* rounds an estimate to its significant digits */

/* ---- methodcosts.c: chooses explicit or implicit steps by moving means of the cost of attempts ---- */
typedef struct {
  PetscReal step;  /* products per explicit step */
  PetscReal solve; /* measured products of implicit solves over those that SlipMethodSolve() predicts where this is 1 */
} SlipMethodCosts;
PETSC_EXTERN void SlipMethodSetUp(SlipMethodCosts *costs); /* before any attempt */
PETSC_EXTERN PetscReal SlipMethodSolve(const SlipMethodCosts *costs, PetscReal x);
PETSC_EXTERN PetscBool SlipMethodIsExplicit(const SlipMethodCosts *c, PetscReal h, PetscReal limit, PetscBool switched);
PETSC_EXTERN void SlipMethodLearn(SlipMethodCosts *c, PetscBool is_explicit, PetscReal h, PetscReal limit,
                                  PetscReal products);

/* ---- event.c: numbers of a catalogue of events ---- */
PETSC_EXTERN PetscReal SlipEventCrossing(PetscReal slow, PetscReal fast, PetscReal bound);
PETSC_EXTERN PetscReal SlipEventRate(PetscReal a, PetscReal b, PetscReal share);
PETSC_EXTERN PetscReal SlipEventPeak(const PetscReal t[3], const PetscReal y[3]);
PETSC_EXTERN PetscReal SlipEventMagnitude(PetscReal moment);

/* ---- observation.c: what a policy may observe ---- */
/* Numbers of any run. dt, error and residual are those of the last attempt. */
typedef struct {
  PetscBool started;   /* at least one attempt was made */
  PetscBool converged; /* the last attempt converged */
  PetscReal error;     /* its weighted error estimate E */
  PetscReal residual;  /* sum of its final relative residuals */
  PetscReal dt;        /* its step [s] */
  PetscInt failures;   /* attempts in a row that did not converge */
  PetscReal time;      /* of the state that is observed [s] */
  PetscReal max_time;  /* [s]; PETSC_MAX_REAL: none */
  PetscReal tstar;     /* T* [s] */
  PetscReal accuracy;  /* wanted relative error of the run's result */
  PetscReal dt_min;    /* bounds of the steps that can be chosen [s] */
  PetscReal dt_max;
  /* of the state, for problems without such rows: 2-norm, mean, one entry; the same and the largest at the start */
  PetscReal norm, mean, component;
  PetscReal norm0, max0, component0;
  /* of the attempts so far, by SlipRunAttempt() */
  PetscReal order;      /* power of h in the error estimate, 1/q; 0: unknown */
  PetscBool accepted;   /* the last attempt was accepted */
  PetscReal dt_before;  /* step of the accepted attempt before the last one [s]; 0: there was none */
  PetscInt rejected;    /* converged attempts in a row that were rejected */
  PetscReal rejections; /* recent fraction of rejected attempts */
} SlipRunNumbers;

/* Numbers of a fault; means are over the cells. */
typedef struct {
  /* constant throughout a run */
  PetscReal tstar;           /* T* [s] */
  PetscReal velocity_scale;  /* estimated maximum of the mean rate [m/s] */
  PetscReal mean_dc;         /* d_c [m] */
  PetscReal mean_uc;         /* displacement at the instability [m] */
  PetscReal mean_q0;         /* strength at the start [Pa] */
  PetscReal mean_drop;       /* largest possible weakening [Pa] */
  PetscReal drop_slip;       /* corresponding slip D [m] */
  PetscReal critical_energy; /* uc' K uc [Pa m], a sum */
  PetscReal mass;            /* per area [kg/m^2] */
  PetscReal damping_ratio;
  /* quotients of uc at the start: uc' K uc and the weakening uc' (-dq/ds) uc, both over uc' M uc [1/s^2] */
  PetscReal critical_stiffness, critical_weakening;
  /* of the state */
  PetscReal velocity, rate, peak; /* v, |v|, the largest |v| [m/s] */
  PetscReal total_rate;           /* sum of |v| [m/s] */
  PetscReal displacement, slip;   /* u, s [m] */
  PetscReal sliding;              /* fraction of cells with v != 0 */
  PetscReal energy, kinetic;      /* u' K u, v' M v [Pa m], sums */
  PetscReal power;                /* v' K u [Pa m/s], a sum */
  PetscReal strength, weakening;  /* strength, and the part that it can still lose [Pa] */
  PetscReal push;                 /* excess of the elastic force along the motion over the strength [Pa] */
  /* like critical_stiffness and critical_weakening, for v, or for uc if all cells rest [1/s^2] */
  PetscReal mode_stiffness, mode_weakening;
  PetscReal relaxation; /* largest eigenvalue of K times largest dv/dstress [1/s]; 0: unknown */
  PetscBool estimated;  /* the last attempt estimated the following */
  PetscReal slip_error; /* |error of s| [m] */
  PetscReal growth;     /* sum of d|v|/dt of sliding cells [m/s^2] */
  /* of the integrator */
  PetscReal step_limit; /* longest stable explicit step [s]; PETSC_MAX_REAL: any is stable, 0: none exists */
  PetscReal solve_cost; /* products of an implicit solve of that step over those of an explicit step */
} SlipFaultNumbers;

enum {
  SLIP_READS_STATE = 1,      /* the solution: cached over a failed attempt; rows of the problem take precedence */
  SLIP_READS_ERROR = 2,      /* the error estimate */
  SLIP_READS_RESIDUAL = 4,   /* the residuals */
  SLIP_READS_ESTIMATES = 8,  /* slip_error and growth */
  SLIP_READS_MODE = 16,      /* mode_stiffness, mode_weakening: cost a product with K unless steps are explicit */
  SLIP_READS_ATTEMPTS = 32,  /* the attempts so far */
  SLIP_READS_STIFFNESS = 64, /* relaxation: needs no product with K, unlike other numbers of the state */
  SLIP_READS_METHOD = 128    /* step_limit and solve_cost */
};

/* A row: what it reads (above), its formula and its meaning */
typedef struct {
  const char *name;
  PetscInt reads;
  PetscReal (*run)(const SlipRunNumbers *);     /* NULL: not defined for any run */
  PetscReal (*fault)(const SlipFaultNumbers *); /* NULL: not defined for a fault */
  const char *meaning;
} SlipObservation;
PETSC_EXTERN const SlipObservation SlipObservations[]; /* ends with a NULL name */

#define SLIP_OBSERVES_ACCURACY "log_accuracy" /* the row that reads the wanted accuracy */

/* One value that a policy names */
typedef struct {
  char name[64];
  size_t change; /* length of the prefix "change_", of a value minus its value at the previous accepted step; else 0 */
  const SlipObservation *row; /* NULL: only the problem defines it */
  PetscInt component;         /* k of state_k */
  PetscInt own;               /* number of the problem's own row, -1: none */
  PetscBool has_base;         /* base is set */
  PetscReal base;             /* the value at the accepted step before */
  PetscReal value;            /* last value */
} SlipObserved;

PETSC_EXTERN PetscInt SlipObservationFind(const char name[], PetscInt *component);
PETSC_EXTERN void SlipObservedSet(SlipObserved *seen, const char name[]);
PETSC_EXTERN PetscBool SlipObservedOfState(const SlipObserved *seen);
PETSC_EXTERN PetscBool SlipObservedOfRun(const SlipObserved *seen);
PETSC_EXTERN PetscReal SlipObservedTake(SlipObserved *seen, PetscReal now);
PETSC_EXTERN void SlipRunAttempt(SlipRunNumbers *run, PetscReal h, PetscBool converged, PetscBool accepted);

/* ---- course.c: the distance between two slip histories ---- */
/* The end of an accepted step: mean slip and mean |slip rate| over the cells */
typedef struct {
  PetscReal time, slip, rate; /* [s], [m], [m/s] */
} SlipCourseNode;

/* Errors of a run relative to a reference run */
typedef enum {
  SLIP_ERROR_FINAL,   /* final mean slip */
  SLIP_ERROR_HISTORY, /* largest difference of mean slip at equal times, over the final mean slip of the reference */
  SLIP_ERROR_SHIFT,   /* of the time of half the slip, over the reference's time from 10 to 90 % of it */
  SLIP_ERROR_PEAK,    /* largest mean rate */
  SLIP_ERROR_FIELD,   /* RMS over the area of the error of the final slip, over the RMS of that slip */
  SLIP_NUM_ERRORS
} SlipErrorKind;

PETSC_EXTERN PetscReal SlipCourseTime(PetscInt n, const SlipCourseNode c[], PetscReal share);
PETSC_EXTERN PetscReal SlipCoursePeak(PetscInt n, const SlipCourseNode c[]);
PETSC_EXTERN void SlipCourseCompare(PetscInt n, const SlipCourseNode run[], PetscInt m,
                                    const SlipCourseNode reference[], PetscReal error[]);
PETSC_EXTERN PetscReal SlipCourseLevy(PetscInt n, const SlipCourseNode run[], PetscInt m,
                                      const SlipCourseNode reference[]);

/* The error that -ts_adapt_rl_measure selects: the largest of the errors, each times its share */
typedef struct {
  const char *name;
  PetscReal share[SLIP_NUM_ERRORS];
  const char *meaning;
} SlipMeasure;
PETSC_EXTERN const SlipMeasure SlipMeasures[]; /* ends with a NULL name; the first is the default */
PETSC_EXTERN const SlipMeasure *SlipMeasureFind(const char name[]);
PETSC_EXTERN PetscReal SlipMeasureOf(const SlipMeasure *measure, const PetscReal error[]);

/* ---- control.c: how controllers choose steps ---- */
PETSC_EXTERN PetscReal SlipControlHeuristic(PetscReal E, PetscReal q, PetscReal growth);
PETSC_EXTERN PetscReal SlipControlCeiling(PetscReal E, PetscReal ceiling, PetscReal q);

/* A digital filter: h_new = h E_n^(-q/g1) E_(n-1)^(-q/g2) (h_(n-1)/h_(n-2))^(-kappa). */
typedef struct {
  const char *name;
  PetscReal g1, g2, kappa; /* PETSC_INFINITY omits a factor */
  PetscReal r_min, r_max;  /* smaller ratios of steps reject the step, larger ones are limited */
} SlipFilter;
enum { SLIP_NUM_FILTERS = 8 };
PETSC_EXTERN const SlipFilter SlipFilters[SLIP_NUM_FILTERS];

typedef struct {
  PetscReal error;  /* E_(n-1); 1 at the start */
  PetscReal h_last; /* last accepted step [s]; 0 at the start */
} SlipFilterMemory; /* the history of a filter */
PETSC_EXTERN PetscReal SlipControlFilter(const SlipFilter *filter, SlipFilterMemory *memory, PetscReal q, PetscReal E,
                                         PetscReal h, PetscBool always, PetscBool *accept);

enum { SLIP_MAX_FAILURES = 3 }; /* in a row, before steps are halved; the default of an option */
PETSC_EXTERN PetscBool SlipControlHalve(PetscInt failures, PetscInt max_failures, PetscReal *h);
PETSC_EXTERN PetscReal SlipControlShrink(PetscReal h, PetscReal next, PetscInt rejected);
PETSC_EXTERN PetscReal SlipControlRest(PetscReal h, PetscReal limit, PetscReal rest, PetscReal left);
PETSC_EXTERN PetscReal SlipControlMatch(PetscReal h, PetscReal left);
PETSC_EXTERN PetscBool SlipControlAtEnd(PetscReal t, PetscReal end);
PETSC_EXTERN PetscReal SlipControlEnd(PetscReal h, PetscReal t, PetscReal end);

/* ---- shearzone.c: heat and pore pressure in the middle of a shear zone, as sums of exponentials ---- */
typedef struct {
  PetscReal width, diffusivity[2], capacity; /* w [m], of heat and of fluid [m^2/s], rho c [J/(m^3 K)] */
  PetscReal share[2];                        /* of both diffusivities in pressure */
  PetscReal age;                             /* oldest heat whose diffusion is right [s] */
  PetscReal error[2];                        /* largest relative errors up to there, of temperature and of pressure */
  PetscInt n;                                /* numbers that a cell remembers */
  PetscReal *rate;                           /* [n] [1/s] */
  PetscReal *temperature, *pressure; /* [n] their shares in temperature, and in pressure over Lambda [K m^2/J] */
} SlipShearZone;
typedef struct {
  PetscReal left, start, heat, curve; /* dimensionless, [s], dimensionless, [s] */
} SlipShearZoneWeights;
PETSC_EXTERN PetscErrorCode SlipShearZoneCreate(PetscReal tolerance, PetscReal age, SlipShearZone *zone);
PETSC_EXTERN PetscErrorCode SlipShearZoneDestroy(SlipShearZone *zone);
PETSC_EXTERN void SlipShearZoneKernel(const SlipShearZone *zone, PetscReal t, PetscReal kernel[2]);
PETSC_EXTERN void SlipShearZoneStep(PetscReal rate, PetscReal h, SlipShearZoneWeights *weights);

/* ---- permeability.c ---- */
PETSC_EXTERN const SlipPermeabilityLaw SlipPermeabilityLaws[]; /* ends with a NULL name */
PETSC_EXTERN const SlipPermeabilityLaw *SlipPermeabilityNext(const SlipPermeabilityLaw *law); /* as SlipFrictionNext */
PETSC_EXTERN const SlipPermeabilityLaw *SlipPermeabilityFind(const char name[]);              /* NULL: none */
PETSC_EXTERN PetscErrorCode SlipPermeabilityRegister(const SlipPermeabilityLaw *law);
PETSC_EXTERN PetscReal SlipPermeabilityEvolve(const SlipPermeabilityLaw *law, const SlipPermeability *c, PetscReal x,
                                              PetscReal slip, PetscReal h);
PETSC_EXTERN PetscReal SlipPermeabilityValue(const SlipPermeabilityLaw *law, const SlipPermeability *c, PetscReal x,
                                             PetscReal stress);

/* ---- hash.c: FNV-1a hashes of policies and of the content of caches ---- */
#define SLIP_HASH_START UINT64_C(14695981039346656037)
PETSC_EXTERN uint64_t SlipHashBytes(uint64_t hash, const void *data, size_t n);
PETSC_EXTERN uint64_t SlipHashReals(uint64_t hash, const PetscReal a[], size_t n);
