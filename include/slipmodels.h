/* Small models with one set-valued reaction, on one process:
     A dw/dt = F_s(t, w) + r e_0,   r in -q Sign(w_0),   A diagonal.
   These are the first-order sliding mode controller and the circuit with an ideal Zener diode: parameters, equations,
   observations of policies, exact solutions. Programs, trainer and tests use them. */
#pragma once
#include <slipts.h>

#define SLIP_MODEL_STATES 3 /* of a model at most */

typedef enum { SLIP_MODEL_TRAINING, SLIP_MODEL_EVALUATION } SlipModelCase; /* those of the published study */
PETSC_EXTERN const char *const SlipModelCases[];

/* A small model: SlipSlidingMode, SlipCircuit, or a user's own */
typedef struct _p_SlipModel *SlipModel;

/* A dimensionless observation of a model for policies; k distinguishes rows that share a formula. */
typedef struct {
  const char *name;
  PetscReal (*value)(SlipModel model, PetscReal t, const PetscReal w[], PetscInt k);
  PetscInt k;
} SlipModelObservation;

/* The functions of a model; a user's own model is a table like this. */
typedef struct {
  const char *name;                         /* of the problem, and the prefix of its options */
  PetscInt n;                               /* states */
  const char *const *states, *const *units; /* [n] names; [n + 1] units, the last one of the reaction */
  const char *energy_unit;
  size_t size; /* size of its struct, which begins with a struct _p_SlipModel */
  PetscErrorCode (*set_case)(SlipModel model, SlipModelCase setting); /* all parameters */
  PetscErrorCode (*set_from_options)(SlipModel model);                /* those that options give */
  PetscErrorCode (*setup)(SlipModel model);                           /* check them; set mass, tstar, dt_max, ... */
  PetscErrorCode (*force)(PetscReal t, const PetscReal w[], PetscReal F[], void *model);    /* as in SlipSmall */
  PetscErrorCode (*jacobian)(PetscReal t, const PetscReal w[], PetscReal J[], void *model); /* constant */
  PetscReal (*load)(SlipModel model, PetscReal t);                /* F_s - J w, all in row 0; NULL: zero */
  const SlipModelObservation *observations;                       /* of this model; the last one has no name */
  PetscReal (*exact)(SlipModel model, PetscReal t, PetscReal *r); /* w_0 and reaction at any time; NULL: see table */
  void (*table)(SlipModel model, PetscReal dt, PetscInt n, PetscReal w[]); /* [n][states] at 0, dt, ...; or exact */
} SlipModelOps;

struct _p_SlipModel {
  const SlipModelOps *ops;
  SlipModelCase setting;
  PetscReal start[SLIP_MODEL_STATES]; /* w(0) */
  PetscReal max_time;                 /* [s] */
  /* computed from the parameters by SlipModelSetUp() */
  PetscReal mass[SLIP_MODEL_STATES]; /* diagonal of A */
  PetscReal bound;                   /* q */
  PetscReal tstar;                   /* time scale [s] */
  PetscReal dt, dt_max;              /* first and longest step [s] */
  PetscReal atol, rtol;              /* the study's tolerances */
};

/* dw/dt = D sin(omega t) + r, r in -k Sign(w) */
typedef struct {
  struct _p_SlipModel model;
  PetscReal k, D;  /* gain and disturbance [1/s] */
  PetscReal omega; /* of the disturbance [rad/s] */
} SlipSlidingMode;

/* C1 dV1/dt = (V2 - V1)/R + r,  C2 dV2/dt = (V1 - V2)/R + i,  L di/dt = -V2,  r in -m Sign(V1), w = (V1, V2, i) [V, V,
   A]; its energy decreases at the rate (V1 - V2)^2/R + m |V1|. */
typedef struct {
  struct _p_SlipModel model;
  PetscReal C1, C2, R, L;                 /* [F], [F], [Ohm], [H] */
  PetscReal m;                            /* current of the diode [A] */
  PetscBool unit_start;                   /* policies observe states relative to the start, as in the study's program */
  PetscReal amplitude[SLIP_MODEL_STATES]; /* units of the observed states, by SlipModelSetUp() */
} SlipCircuit;

PETSC_EXTERN const SlipModelOps SlipSlidingModeOps, SlipCircuitOps;

PETSC_EXTERN PetscErrorCode SlipModelCreate(const SlipModelOps *ops, SlipModelCase setting, SlipModel *model);
PETSC_EXTERN PetscErrorCode SlipModelDestroy(SlipModel *model);
PETSC_EXTERN PetscErrorCode SlipModelSetFromOptions(SlipModel model);
PETSC_EXTERN PetscErrorCode SlipModelConfigureTS(SlipModel model, TS ts);
PETSC_EXTERN PetscErrorCode SlipModelCreateState(SlipModel model, Vec *w);
PETSC_EXTERN PetscReal SlipModelEnergy(SlipModel model, const PetscReal w[]);
