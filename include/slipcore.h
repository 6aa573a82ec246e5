/* Friction laws: parameters, states, the table of laws, and the functions of rate-and-state friction. None uses an
   object of PETSc. */
#pragma once
#include <petscsys.h>

/* The part of a run that an option belongs to, which decides whether a continued run may change its value. Every option
   must have one, else SlipStepInitializePackage() fails. */
typedef enum {
  SLIP_PART_UNSAID,
  SLIP_PART_PROBLEM, /* what is computed: checkpoints store it, and another value is an error */
  SLIP_PART_CONTENT, /* likewise, but compared by content, as the cells of a mesh whatever its file is called */
  SLIP_PART_STEPS,   /* how it is computed: checkpoints store it, and a message announces another value */
  SLIP_PART_RUN,     /* start of a run, its time on a machine, what it continues from: may change */
  SLIP_PART_OUTPUT,  /* what is written and printed: may change as far as a continued file allows it */
  SLIP_NUM_PARTS
} SlipPart;

/* A number that users set by an option or as an argument of a setter, some also cell by cell */
typedef struct {
  const char *name;  /* name of the option without the common prefix */
  PetscReal value;   /* default; NaN: computed if not given */
  const char *unit;  /* "" for numbers */
  PetscReal lower;   /* PETSC_MIN_REAL: no bound */
  PetscReal upper;   /* excluded; PETSC_MAX_REAL: no bound */
  PetscBool open;    /* the lower bound is excluded, too */
  PetscBool integer; /* whole numbers only */
  const char *help;
  SlipPart part; /* for parameters of a friction law always SLIP_PART_PROBLEM */
} SlipParameter;

/* ---- friction.c: friction laws, and the strength of a stage that follows from them ---- */
/* How the state of rate-and-state friction evolves: with time or with slip (Ruina 1983), or with slip, and with time at
   low rates (Kato and Tullis 2001), or with time, squared (Perrin, Rice and Zheng 1995). The choices of
   -fault_state_law in this order, which kernels of devices use */
typedef enum { SLIP_STATE_AGING, SLIP_STATE_SLIP, SLIP_STATE_COMPOSITE, SLIP_STATE_PRZ } SlipStateLaw;
/* Friction parameters of one cell */
typedef struct {
  PetscReal residual;       /* mu_d */
  PetscReal drop;           /* dmu */
  PetscReal slip;           /* d_c [m] */
  PetscReal rate;           /* v_c [m/s] */
  PetscReal healing;        /* 1/t_h [1/s]; 0: the state never heals */
  PetscReal a, b;           /* direct effect and evolution effect of rate-and-state friction */
  PetscReal reference;      /* f_0, its steady friction at the rate V_0 */
  PetscReal reference_rate; /* V_0 [m/s] */
  SlipStateLaw state_law;   /* by which its state evolves */
  PetscReal cutoff_rate;    /* V_c of the composite law [m/s]; others do not read it */
  PetscReal shift;          /* s - psi, the effect of changed normal stress (ratestate.c) */
  const PetscReal *own;     /* parameters that the law declares, in the order of its table */
  const void *ctx;          /* context of the law */
} SlipFriction;

/* A law has the states s[0], s[1], ... that it declares, or else one, the cumulative slip >= 0 [m]. A declared state
   should be scaled like a logarithm, so that a change by 1 matters as much as slip by d_c: steps keep the errors of
   both to the same tolerance. */
enum { SLIP_MAX_STATES = 8 };
/* Computes by how much mu(s, v) exceeds its residual, and the derivatives with respect to each state and to v [s/m]; v
   is |slip rate| [m/s]. */
typedef void (*SlipFrictionFn)(const SlipFriction *p, const PetscReal s[], PetscReal v, PetscReal *excess,
                               PetscReal dmu_ds[], PetscReal *dmu_dv);
/* Computes ds/dt of declared states, and the derivatives with respect to s, [n][n] by rows, 0 if not set, with no
   positive number on the diagonal, and with respect to v. */
typedef void (*SlipStateFn)(const SlipFriction *p, const PetscReal s[], PetscReal v, PetscReal rate[],
                            PetscReal drate_ds[], PetscReal drate_dv[]);
typedef void (*SlipSteadyFn)(const SlipFriction *p, PetscReal v, PetscReal s[]); /* s with ds/dt = 0 at the rate v */
/* Converts a number of a law, for example a state into the value that outputs show */
typedef PetscReal (*SlipFrictionNumberFn)(const SlipFriction *p, PetscReal x);
/* A state that a law declares */
typedef struct {
  const char *name; /* name in datasets and -fault_output_fields; built-in laws call it "state" */
  const char *unit; /* unit of inputs and outputs; NULL: "1" */
  /* The parameter that sets its start if cells always slide: "initial_state", or a parameter of the law whose default
     is NaN; without a number the state starts steady. */
  const char *start;
  SlipFrictionNumberFn shown;    /* value in outputs, from s; NULL: s itself */
  SlipFrictionNumberFn of_shown; /* s from that value */
  PetscReal largest;             /* only far too long steps lead to a larger |s|; 0: no such bound */
} SlipFrictionState;
/* The friction of many cells, defined below */
typedef struct _n_SlipFrictionCells SlipFrictionCells;
/* SlipFrictionBalance() of many cells at once; kept: the numbers of SlipFrictionKeepFn, or NULL */
typedef void SlipFrictionBalanceFn(const SlipFrictionCells *f, const PetscReal kept[], PetscInt n, PetscReal eta,
                                   const PetscReal tau[], PetscInt stride, const PetscReal s[], PetscReal v[],
                                   PetscReal ds[]);
/* Computes kept [nkept n], the parts of the balance that no state changes; eta: radiation damping [Pa s/m]. */
typedef void (*SlipFrictionKeepFn)(const SlipFrictionCells *f, PetscInt n, PetscReal eta, PetscReal kept[]);
/* Computes mu of n cells, which are `stride` apart in s and `rates` apart in v; v may have either sign. */
typedef void SlipFrictionValues(const SlipFrictionCells *f, PetscInt n, PetscInt stride, const PetscReal s[],
                                PetscInt rates, const PetscReal v[], PetscReal mu[]);
/* A row of the table of laws: functions and properties. A comment says what NULL or 0 means where that is allowed. */
typedef struct {
  const char *name;
  SlipFrictionFn eval;
  const char *formula;     /* for -help and messages */
  PetscBool by_rate,       /* mu depends on v */
    remembers;             /* mu depends on one state alone, and caching it is faster than computing it */
  PetscBool always_slides; /* mu is 0 at v = 0 and grows with v, at least if radiation damping is added */
  /* Without declared states, NULL and 0, s is the slip of both signs and ds/dt = |v| - s/t_h. */
  const SlipFrictionState *states; /* [nstates] */
  PetscInt nstates;                /* at most SLIP_MAX_STATES */
  SlipStateFn rate;                /* ds/dt of all states */
  SlipSteadyFn steady;
  const SlipParameter *own;                   /* parameters of the law, ended by a row with a NULL name; NULL: none */
  const void *ctx;                            /* passed in SlipFriction; the members below are for speed */
  PetscReal (*direct)(const SlipFriction *p); /* a, if dmu/dv = a/v to 1e-9 wherever mu > 10 a; NULL: not so */
  SlipFrictionBalanceFn *balance;             /* NULL: Newton's method, cell by cell */
  SlipFrictionKeepFn keep;    /* computes `kept`, which is valid while the normal stress does not change */
  PetscInt nkept;             /* numbers per cell */
  SlipFrictionValues *values; /* NULL: cell by cell; for laws that cache mu, used where no cache is needed */
  /* Computes s of n cells after h [s] at the rates v; false, with s as it was, if there is no closed form. NULL or
     false: a formula of second order, stable at any step */
  PetscBool (*drift)(const SlipFrictionCells *, PetscInt n, PetscReal h, const PetscReal v[], PetscInt stride,
                     PetscReal s[]);
  /* The rate of ruptures, for laws whose friction falls more the faster slip is: the cohesive zone follows from the
     fall there. NULL: friction falls alike at all rates */
  PetscReal (*rupture)(const SlipFriction *p);
  const char *reads; /* friction parameters that it uses, as "residual slip"; messages name others; NULL: any */
} SlipFrictionLaw;
PETSC_EXTERN const SlipFrictionLaw SlipFrictionLaws[]; /* built-in laws, ended by a NULL name */
PETSC_EXTERN PetscErrorCode SlipFrictionFind(const char name[], const SlipFrictionLaw **law);
PETSC_EXTERN PetscErrorCode SlipFrictionRegister(const SlipFrictionLaw *law);

/* ---- permeability of a fault (permeability.c) ---- */
/* Numbers of one cell */
typedef struct {
  PetscReal start, maximum; /* k0 and kmax [m^2] */
  PetscReal slip, healing;  /* L [m], 1/T [1/s] */
  PetscReal stress, normal; /* stress scale s*, and the effective normal stress s0 at fluid pressure 0 [Pa] */
  const void *ctx;          /* of the law */
} SlipPermeability;
/* What a law needs, so that it is an error where it is not given: -fault_permeability_maximum and _slip; _stress */
enum { SLIP_PERMEABILITY_BY_SLIP = 1, SLIP_PERMEABILITY_BY_STRESS = 2 };
/* A row of the table of laws: k = value(k*, effective normal stress), where k* is k0 at the start and evolves */
typedef struct {
  const char *name;
  PetscInt needs; /* the sum of the above */
  /* k* [m^2] of a cell that had x, after h [s] with this much slip >= 0 [m] at a constant rate; NULL: k* = k0 */
  PetscReal (*evolve)(const SlipPermeability *c, PetscReal x, PetscReal slip, PetscReal h);
  /* k [m^2] from k* and the effective normal stress [Pa]; NULL: k = k* */
  PetscReal (*value)(const SlipPermeability *c, PetscReal x, PetscReal stress);
  const void *ctx; /* passed in SlipPermeability */
} SlipPermeabilityLaw;

/* Friction of many cells; the arrays [n] are borrowed. */
struct _n_SlipFrictionCells {
  const SlipFrictionLaw *law;
  const PetscReal *residual, *drop, *slip, *rate;
  const PetscReal *stress;            /* effective normal stress [Pa] */
  const PetscReal *weight;            /* of the rows of the cells; NULL: 1 */
  const PetscReal *healing;           /* NULL: 0 */
  const PetscReal *a, *b, *reference; /* NULL if no law needs them */
  PetscReal reference_rate;           /* [m/s] */
  SlipStateLaw state_law;
  PetscReal cutoff_rate;          /* [m/s] */
  const PetscReal *alpha, *start; /* of ratestate.c, and the normal stress before any change [Pa]; NULL: none */
  const PetscReal *own;           /* [n][nown]; NULL where nown is 0 */
  PetscInt nown;
  PetscReal *known; /* [n][4] cached values of laws that cache mu; NULL or NaN: nothing cached (friction.c) */
};

PETSC_EXTERN void SlipFrictionEvaluate(const SlipFrictionCells *f, PetscInt i, const PetscReal s[], PetscReal v,
                                       PetscReal *mu, PetscReal *dmu_ds, PetscReal *dmu_dv);
PETSC_EXTERN void SlipFrictionStrength(const SlipFrictionCells *f, PetscInt n, PetscReal theta, PetscInt stride,
                                       const PetscReal s0[], PetscInt rates, const PetscReal v[], PetscReal q[],
                                       PetscReal dq[]);
/* ratestate.c */
PETSC_EXTERN void SlipRateAndState(const SlipFriction *p, const PetscReal s[], PetscReal v, PetscReal *mu,
                                   PetscReal dmu_ds[], PetscReal *dmu_dv);
PETSC_EXTERN void SlipRateAndStateRate(const SlipFriction *p, const PetscReal s[], PetscReal v, PetscReal rate[],
                                       PetscReal drate_ds[], PetscReal drate_dv[]);
PETSC_EXTERN PetscReal SlipRateAndStateTheta(const SlipFriction *p, PetscReal s);
PETSC_EXTERN PetscReal SlipRateAndStateOfTheta(const SlipFriction *p, PetscReal theta);
PETSC_EXTERN PetscReal SlipRateAndStateDirect(const SlipFriction *p);
