/* Random ordinary differential equations on plain arrays, and runs of them under a step-size controller: what the
   general policy ode.h5 is trained on (train -train_algorithm cmaes -train_problem ode). */
#pragma once
#include "common/random.h"
#include <slipstep/rooms.h>
#include <slipstep/rooms/slipcore.h>

enum { ODE_MAX_N = 6, ODE_MAX_PARAMETERS = 64, ODE_MAX_STAGES = 7 };

/* ---- odefamily.c: y' = f(t, y) of n components, 0 <= t <= end ---- */
typedef struct _Ode Ode;
typedef void (*OdeFn)(const Ode *ode, double t, const double y[], double dy[]);
struct _Ode {
  const char *kind;
  PetscInt n;
  OdeFn f;
  double end; /* all times in one unit that drops out: nothing of what a policy is told has a dimension */
  double y0[ODE_MAX_N];
  double p[ODE_MAX_PARAMETERS];
};

PETSC_INTERN const PetscInt OdeKinds; /* number of families */
PETSC_INTERN void OdeDraw(Random *random, PetscInt kind, Ode *ode);

/* ---- odepairs.c: methods with an embedded error estimate ---- */
typedef enum {
  ODE_BS32,  /* Bogacki and Shampine (1989) */
  ODE_DP54,  /* Dormand and Prince (1980) */
  ODE_BATHE, /* the composite step of src/core/batheweights.c, with Newton's method */
  ODE_PAIRS
} OdePair;

typedef struct {
  const Ode *ode;
  OdePair pair;
  double tol;                           /* relative, and absolute for states of order one */
  double t, y[ODE_MAX_N], k[ODE_MAX_N]; /* state, and f there */
  double y1[ODE_MAX_N], k1[ODE_MAX_N];  /* after the attempt */
  double E;                             /* its error estimate in units of the tolerances */
  PetscInt work;                        /* evaluations of f, and solves with a matrix */
} OdeStepper;

PETSC_INTERN double OdeOrder(OdePair pair); /* the power of h that E goes with */
PETSC_INTERN void OdeStepperStart(const Ode *ode, OdePair pair, double tol, OdeStepper *s);
PETSC_INTERN PetscBool OdeAttempt(OdeStepper *s, double h); /* no: the nonlinear solve did not converge */
PETSC_INTERN void OdeAccept(OdeStepper *s, double h);

/* ---- oderun.c ---- */
typedef struct {
  PetscInt work, steps, rejected, failed;
  double error; /* root mean square over time, components in units of their largest value */
  PetscBool done;
} OdeResult;

typedef struct {
  Ode ode;
  OdePair pair;
  double tol, first;       /* tolerance, first step */
  PetscInt n;              /* points of the reference */
  double *t, *y, *k;       /* [n], [n][ode.n]: times, states, derivatives */
  double scale[ODE_MAX_N]; /* largest values */
  double basic[2];         /* ln work = basic[0] + basic[1] ln error of the controller basic */
  PetscInt limit;          /* of attempts */
} OdeEpisode;

/* The episode of a seed, drawn again until basic has a usual number of steps and an error that follows the tolerance */
PETSC_INTERN PetscErrorCode OdeEpisodeCreate(uint64_t seed, OdeEpisode *e);
PETSC_INTERN PetscErrorCode OdeEpisodeDestroy(OdeEpisode *e);
/* policy NULL: PETSc's TSADAPTBASIC */
PETSC_INTERN PetscErrorCode OdeEpisodeRun(const OdeEpisode *e, SlipPolicy policy, double tol, OdeResult *r);
/* Logarithm of the work over what basic needs for the same error; bounded */
PETSC_INTERN double OdeEpisodeCost(const OdeEpisode *e, const OdeResult *r);
