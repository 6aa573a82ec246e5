/* Inside the fault: its tables (parameters, choices, friction laws, observables) and its data. */
#pragma once
#include <petsc/private/petscimpl.h>
#include <slipfault.h>
#include <slipcells.h>
#include <slipcore.h>
#include <slipsys.h>
#include <slipoutput.h>
#include <sliph5.h>
#include <slipcompat.h>
#include <slipstep/private/slipoutput.h>
#include <slipstep/private/slipcheckpoint.h>
#include <slipstep/private/slipstate.h>
#include <slipstep/private/slipsys.h>

/* ---- parameters ---- */
/* What can be metres of a fault: along strike the Earth's circumference, which coordinates of a map keep to as well; in
   depth more than the 700 km below which no rock breaks. */
#define FAULT_MAX_REACH 4e7
#define FAULT_MAX_DEPTH 1e6

/* Reference absolute tolerance of u and s, and over T* of v: 1e-6 in units of 0.1 mm [m]. */
#define SLIP_FAULT_ATOL 1e-10
typedef enum {
  FAULT_NX,
  FAULT_NZ,
  FAULT_LENGTH_X,
  FAULT_LENGTH_Z,
  FAULT_DEPTH_TOP,
  FAULT_THICKNESS,
  FAULT_SHEAR_MODULUS,
  FAULT_POISSON_RATIO,
  FAULT_DENSITY,
  FAULT_DAMPING_RATIO,
  FAULT_LOADING_RATE,
  FAULT_NORMAL_STRESS,
  FAULT_NORMAL_STRESS_GRADIENT,
  FAULT_FRICTION_RESIDUAL,
  FAULT_FRICTION_DROP,
  FAULT_FRICTION_SLIP,
  FAULT_FRICTION_RATE,
  FAULT_FRICTION_A,
  FAULT_FRICTION_B,
  FAULT_FRICTION_REFERENCE,
  FAULT_FRICTION_REFERENCE_RATE,
  FAULT_HEALING_TIME,
  FAULT_INITIAL_TRACTION,
  FAULT_INITIAL_RATE,
  FAULT_INITIAL_STATE,
  FAULT_CREEP,
  FAULT_STRESSING_RATE,
  FAULT_INJECTION_PRESSURE,
  FAULT_INJECTION_DIFFUSIVITY,
  FAULT_INJECTION_STOP,
  FAULT_INITIAL_PERTURBATION,
  FAULT_VELOCITY_SCALE,
  FAULT_OUTPUT_INTERVAL,
  FAULT_OUTPUT_SLIP_INTERVAL,
  FAULT_OUTPUT_TIME_INTERVAL,
  FAULT_OUTPUT_RATE_CHANGE,
  FAULT_OUTPUT_COMPRESSION,
  FAULT_HMAT_TOLERANCE,
  FAULT_KRYLOV_TOLERANCE,
  FAULT_RATE_TOLERANCE,
  FAULT_CHECKPOINT_INTERVAL,
  FAULT_RESTART_DT,
  FAULT_WALL_LIMIT,
  FAULT_EVENT_RATE,
  FAULT_NUM_REALS
} SlipFaultRealId;

typedef struct {
  const char *name; /* option without "fault_" */
  PetscReal value;  /* default; NaN: derived when not given */
  const char *unit; /* "" for numbers */
  PetscReal lower, upper;
  PetscBool open;    /* lower bound excluded (the upper one always is) */
  PetscBool integer; /* whole numbers only */
  const char *help;
} SlipFaultReal;
PETSC_EXTERN const SlipFaultReal SlipFaultReals[FAULT_NUM_REALS];

typedef enum {
  FAULT_FRICTION_LAW,
  FAULT_STATE_LAW,
  FAULT_KERNEL,
  FAULT_INITIAL,
  FAULT_OPERATOR,
  FAULT_VISCOSITY,
  FAULT_STIFFNESS_AVERAGE,
  FAULT_STIFFNESS_FILE,
  FAULT_STIFFNESS_SCALING,
  FAULT_CACHE_DIR,
  FAULT_PARAMETERS,
  FAULT_MESH,
  FAULT_PORE_PRESSURE,
  FAULT_INJECTION,
  FAULT_OUTPUT,
  FAULT_OUTPUT_FIELDS,
  FAULT_OUTPUT_PRECISION,
  FAULT_STATIONS,
  FAULT_CATALOGUE,
  FAULT_CHECKPOINT,
  FAULT_RESTART,
  FAULT_NUM_STRINGS
} SlipFaultStringId;

typedef struct {
  const char *name;
  const char *value;   /* default */
  const char *choices; /* "|a|b|", or NULL for a file name or list */
  const char *help;
} SlipFaultString;
PETSC_EXTERN const SlipFaultString SlipFaultStrings[FAULT_NUM_STRINGS];

/* Per-cell fields, in the order of the enumeration above. */
typedef enum {
  FIELD_NORMAL_STRESS,
  FIELD_FRICTION_RESIDUAL,
  FIELD_FRICTION_DROP,
  FIELD_FRICTION_SLIP,
  FIELD_FRICTION_RATE,
  FIELD_LOADING_RATE,
  FIELD_HEALING_TIME,
  FIELD_INITIAL_TRACTION,
  FIELD_STRESSING_RATE,
  FIELD_FRICTION_A,
  FIELD_FRICTION_B,
  FIELD_FRICTION_REFERENCE,
  FIELD_INITIAL_RATE,
  FIELD_INITIAL_STATE,
  FIELD_CREEP,
  FAULT_NUM_FIELDS
} SlipFaultFieldId;
PETSC_EXTERN const SlipFaultRealId SlipFaultFields[FAULT_NUM_FIELDS]; /* the parameter each field replaces */

/* Shear load and pore pressure in time; what is of the time `time` is made by SlipFaultLoadAt() */
typedef struct {
  PetscBool known;              /* the following is of this time */
  PetscReal time;               /* [s] */
  PetscBool shears;             /* there is an initial traction or a stressing rate */
  PetscBool pressed;            /* there is a pore pressure */
  Vec shear;                    /* w (T0 + t dT/dt), w the weights [Pa] */
  PetscReal *stress;            /* [n] effective normal stress, at least 0 [Pa]; NULL: that of the field */
  Vec drive, hold;              /* of a fault at rest: rate of its load, K v_inf + w dT/dt [Pa/s], and H v_inf [Pa] */
  Vec diagonal[2];              /* of K and H */
  PetscInt rows;                /* of -fault_pore_pressure */
  PetscReal *times, *record;    /* [rows] [s], [rows][n] [Pa] */
  PetscReal *distance2;         /* [n] of the cells from -fault_injection, squared [m^2]; NULL: none */
  PetscReal fastest_healing;    /* largest 1/t_h [1/s] */
  PetscReal diffusion_time;     /* least distance2/(4 D) [s] */
  SlipFaultPressureFn function; /* of SlipFaultSetPressureFunction(), with its context and [n] values of it */
  void *ctx;
  PetscReal *own;
  PetscBool opened; /* it was said that cells are without strength */
} SlipFaultLoads;

/* Which state vector sums belong to, and how it was then */
typedef struct {
  PetscObjectId id;
  PetscObjectState state;
} SlipFaultMoment;

/* ---- sums over the cells that observables are made of ---- */
typedef enum {
  SUM_V,
  SUM_ABS_V,
  SUM_V2,
  SUM_U,
  SUM_S,
  SUM_SLIDING,
  SUM_U_KU,    /* sum u K u */
  SUM_V_KU,    /* sum v K u */
  SUM_VINF_KU, /* sum v_inf K u */
  SUM_VINF,
  SUM_U_T,       /* sum u T, T the shear load */
  SUM_LOADING_T, /* sum v_inf T - u dT/dt */
  SUM_STRENGTH,
  SUM_WEAKENING, /* what the strength still exceeds its residual by */
  SUM_PUSH,      /* what the elastic force along the motion exceeds the strength by */
  FAULT_NUM_SUMS
} SlipFaultSumId;

typedef struct {
  PetscReal sum[FAULT_NUM_SUMS];
  PetscReal max_v; /* max |v| [m/s] */
  SlipFaultMoment moment;
} SlipFaultSums;

/* What the integrator's last attempt says: its local error and the derivative of the rate at its end. */
typedef enum {
  ESTIMATE_SLIP_ERROR, /* sum |e_s| */
  ESTIMATE_GROWTH,     /* sum of d|v|/dt over sliding cells */
  FAULT_NUM_ESTIMATES
} SlipFaultEstimateId;

typedef struct {
  PetscBool known;
  PetscReal sum[FAULT_NUM_ESTIMATES]; /* weighted by area */
} SlipFaultEstimates;

/* Of the rate, or where all rest of the critical displacement: sums x K x, x (-dq/ds) x and x M x. */
typedef enum { MODE_STIFFNESS, MODE_WEAKENING, MODE_INERTIA, FAULT_NUM_MODE } SlipFaultModeId;

typedef struct {
  PetscReal sum[FAULT_NUM_MODE];
  SlipFaultMoment moment;
} SlipFaultMode;

/* balance.c */
typedef struct {
  PetscReal eta;      /* radiation damping [Pa s/m] */
  PetscReal rtol;     /* that the tolerances were made of */
  PetscBool known;    /* rate is that of the last right-hand side */
  PetscReal time;     /* of it [s] */
  Vec F;              /* its rates, borrowed from the TS */
  Vec first;          /* those of the first step of a run that goes on from a checkpoint; NULL: to be computed */
  Vec u, rate, force; /* its displacement [m], slip rate [m/s], and K u [Pa] */
  PetscReal stiffest; /* largest eigenvalue of K [Pa/m]; 0: nobody has asked */
  PetscBool *creeps;  /* [n] cells that slip at the loading rate; NULL: none */
  PetscReal *kept;    /* what constants point to; NULL where the normal stress changes */
  SlipRateAndStateConstants constants;
} SlipFaultBalance;

typedef struct _n_SlipFaultOutput *SlipFaultOutput;
typedef struct _n_SlipFaultCatalogue *SlipFaultCatalogue;

/* ---- progress.c: what a run prints while it goes ---- */
typedef struct {
  PetscBool wanted;             /* -fault_progress */
  PetscBool repetition;         /* what runs is that of -fault_check_error */
  PetscInt wait;                /* steps until rank 0 is asked again whether a line is due */
  PetscReal start;              /* model time at the start of the run, or where it goes on [s] */
  PetscLogDouble setup;         /* when the set-up began [s]; 0: it did not */
  PetscLogDouble begin;         /* when the run began [s]; 0: it did not */
  PetscLogDouble printed, step; /* when the last line and the last step were [s] */
} SlipFaultProgress;

/* ---- errors of a run; formulas in slipestimate.c, courseestimate.c and slipcheck.c ---- */
typedef struct {
  PetscInt n, size; /* nodes, room for */
  SlipCourseNode *node;
} SlipFaultCourse;

/* What local errors change of the timing of a run; [2]: signed, and by magnitudes */
typedef struct {
  PetscReal excess[2];    /* kinetic energy at equal slip, carried to now [J/m^2] */
  PetscReal vigour;       /* sum of M v^2 at the end of the last step [J/m^2] */
  PetscReal early[2];     /* by how much the run is ahead [s] */
  PetscReal rate;         /* largest sum of slip rates so far [m/s] */
  PetscReal shift[2];     /* early at that time [s] */
  PetscReal acceleration; /* mean, at the end of the last step [m/s^2] */
  PetscReal bend;         /* largest error of a cubic between the ends of a step [m] */
} SlipFaultTiming;

typedef struct {
  PetscObjectId id;  /* of the TS that has the monitor */
  PetscBool known;   /* every accepted step so far had an error estimate */
  PetscReal moving;  /* share of the slip that is on cells which still slide, at the end of the last step */
  PetscReal decay;   /* of changes of the energy [1/s] */
  PetscReal work[2]; /* changes of the energy by local errors, carried to now, and by their magnitudes [J/m^2] */
  PetscReal slip[2]; /* errors of the mean slip that have become final, likewise [m] */
  PetscReal sum;     /* of the slip at the end of the last step [m] */
  PetscReal late;    /* what of it was made in steps in which cells came to rest [m] */
  SlipFaultTiming timing;
  SlipFaultCourse course; /* the start and the ends of accepted steps */
  /* -fault_check_error */
  SlipFaultCourse fine; /* of the repetition, and ends of parts of steps */
  Vec start;            /* state of the start */
  PetscReal start_time; /* [s] */
  PetscReal start_step; /* [s] */
  PetscBool off;        /* the repetition is no run to estimate */
} SlipFaultRunError;

struct _p_SlipFault {
  PETSCHEADER(int);
  MPI_Comm comm; /* of the header, for short */

  /* ---- what the user chose ---- */
  PetscReal value[FAULT_NUM_REALS];
  char text[FAULT_NUM_STRINGS][PETSC_MAX_PATH_LEN];
  PetscReal *given[FAULT_NUM_FIELDS]; /* of SlipFaultSetField(): all cells, [nx nz]; NULL: the scalar parameter */
  PetscInt ngiven[FAULT_NUM_FIELDS];
  PetscBool check_error;      /* -fault_check_error */
  PetscBool output_overwrite; /* -fault_output_overwrite */
  PetscBool output_xdmf;      /* -fault_output_xdmf */
  PetscBool interval_given;   /* output_interval was set */
  PetscBool catalogue_maps;   /* -fault_catalogue_maps */
  PetscViewer viewer;         /* -fault_view */
  PetscViewerFormat format;
  PetscViewer stiffness_viewer; /* -fault_stiffness_view */
  PetscViewerFormat stiffness_format;

  PetscBool setup; /* SlipFaultSetUp() was called: what follows is valid */

  /* ---- cells ---- */
  PetscInt N, n, start; /* all, of this rank, the first of this rank */
  SlipCells mesh;       /* of -fault_mesh in the file's order, owned; n = 0 for a grid */
  PetscInt *order;      /* [N] row of the file for each cell of a mesh; NULL for a grid */
  PetscReal *weight; /* [n] area over the mean area: rows of K, H and B are multiplied by it, and so is the strength */
  PetscReal *field[FAULT_NUM_FIELDS];   /* [n] parameters cell by cell */
  const char *source[FAULT_NUM_FIELDS]; /* where they come from, for views; NULL: the scalar parameters */
  PetscBool loaded;                     /* some v_inf is not zero */
  PetscBool inertia;                    /* -fault_inertia */
  PetscBool inertia_given;              /* else the law decides */
  PetscBool initial_unstable;           /* -fault_initial_unstable */
  PetscBool heals;                      /* some healing time is not never */
  PetscBool slip_law;                   /* -fault_state_law slip */
  PetscBool driven;   /* by loading, stressing, pressure or healing, or without inertia: quiet times without end */
  PetscReal *healing; /* [n] 1/t_h [1/s]; NULL: 0 */
  SlipFaultLoads loads;

  /* ---- operators, and what is derived from the parameters ---- */
  const SlipFrictionLaw *law;
  Mat K, H, B;       /* stiffness after scaling [Pa/m], viscosity [Pa s/m], stage operator */
  PetscReal mass;    /* rho Ly [kg/m^2] */
  PetscReal tstar;   /* Ly sqrt(rho/G) [s] */
  PetscReal scaling; /* factor that K was multiplied with */
  Vec vinf;          /* loading rate [m/s] */
  Vec work[3];

  /* ---- the critical state, and the means by which observations are made dimensionless ---- */
  PetscBool has_critical;       /* else what follows of uc is zero: the start is given, and no solve with K needed */
  Vec uc;                       /* K^-1 q(0): displacement at the instability, positive [m] */
  PetscReal mean_dc;            /* mean d_c [m] */
  PetscReal mean_uc;            /* mean uc [m] */
  PetscReal mean_q0;            /* mean strength at the start [Pa] */
  PetscReal mean_drop;          /* mean of q(0) - q after all weakening [Pa] */
  PetscReal drop_slip;          /* mean uc times mean strength drop over mean q0: slip that the drop implies [m] */
  PetscReal critical_energy;    /* uc' K uc [Pa m], the sum over all cells */
  PetscReal critical_weakening; /* uc (-dq/ds) uc at the start [Pa m], likewise */
  PetscReal critical_inertia;   /* uc M uc [kg], likewise, over the mean area */

  /* ---- the stage being solved: u = u0 + theta v, s = s0 + theta |v|, B v = c + omega r ---- */
  SlipConstraint con;
  PetscReal theta;
  Vec c, u0, s0;

  SlipProblemOps problem; /* what its TS tells controllers */

  /* ---- of a smooth law: the slip rates of the state asked about last ---- */
  SlipFaultBalance balance;

  /* ---- what is known of the state and of the run ---- */
  SlipFaultSums sums;
  SlipFaultMode mode;
  SlipFaultEstimates estimates;
  SlipFaultOutput output;
  SlipFaultCatalogue catalogue; /* NULL: none */
  PetscInt events;              /* of the run so far, as the catalogue counts them; -1: nobody does */
  SlipFaultRunError run_error;
  SlipFaultProgress progress;
};

/* The fault of argument arg has been set up. */
#define SlipFaultCheckSetUp(fault, arg)                                                                                \
  do {                                                                                                                 \
    PetscValidHeaderSpecific(fault, SLIP_FAULT_CLASSID, arg);                                                          \
    PetscCheck((fault)->setup, (fault)->comm, PETSC_ERR_ORDER, "call SlipFaultSetUp() first");                         \
  } while (0)

/* For messages: "-%sfault_nx" has the options prefix between dash and name. */
static inline const char *SlipFaultPrefix(SlipFault fault)
{
  const char *prefix = ((PetscObject)fault)->prefix;

  return prefix ? prefix : "";
}

PETSC_EXTERN PetscErrorCode SlipFaultCellsSetUp(SlipFault fault); /* fields and distribution */
PETSC_EXTERN PetscErrorCode SlipFaultFieldNames(char names[], size_t len);
PETSC_EXTERN PetscErrorCode SlipFaultStiffnessSetUp(SlipFault fault); /* K, its scaling, H, B */
PETSC_EXTERN PetscErrorCode SlipFaultCriticalSetUp(SlipFault fault);  /* uc and what observables are measured in */
PETSC_EXTERN PetscErrorCode SlipFaultMeshSetUp(SlipFault fault);      /* cells of -fault_mesh */
PETSC_EXTERN PetscErrorCode SlipFaultAverage(SlipFault fault, SlipAverage *average); /* that was chosen */
PETSC_EXTERN PetscErrorCode SlipFaultMeshStiffness(SlipFault fault, PetscBool *done);
PETSC_EXTERN PetscErrorCode SlipFaultGatherCreate(SlipFault fault, Vec x, VecScatter *scatter, Vec *x0);
PETSC_EXTERN PetscErrorCode SlipFaultMeshWrite(SlipFault fault, SlipH5 *h);
PETSC_EXTERN PetscErrorCode SlipFaultWeightsSetUp(SlipFault fault);
PETSC_EXTERN PetscErrorCode SlipFaultWeightedSum(SlipFault fault, Vec x, PetscReal *sum);
PETSC_EXTERN PetscErrorCode SlipFaultSolveStiffness(SlipFault fault, Vec b, Vec x);
PETSC_EXTERN PetscReal SlipFaultMeanArea(SlipFault fault); /* of a cell [m^2] */
PETSC_EXTERN PetscErrorCode SlipFaultPlaceOf(SlipFault fault, PetscInt e, PetscReal centre[3], PetscReal size[2]);
PETSC_EXTERN PetscErrorCode SlipFaultCellCentre(SlipFault fault, PetscInt e, PetscReal *x, PetscReal *z);
PETSC_EXTERN PetscErrorCode SlipFaultConstraintCreate(SlipFault fault);
PETSC_EXTERN PetscErrorCode SlipFaultConstraintStage(SlipFault fault, const SlipStage *stage);
PETSC_EXTERN PetscErrorCode SlipFaultConstraintResidual(SlipFault fault, Vec x, Vec g);
PETSC_EXTERN PetscErrorCode SlipFaultConstraintLift(SlipFault fault, Vec x, Vec w);
PETSC_EXTERN PetscErrorCode SlipFaultSmooth(SlipFault fault, PetscReal t, Vec w, Vec F);
PETSC_EXTERN PetscErrorCode SlipFaultStrength(SlipFault fault, PetscReal t, Vec w, Vec q);
PETSC_EXTERN PetscErrorCode SlipFaultStartShare(SlipFault fault, PetscReal *share); /* state.c */
/* loads.c */
PETSC_EXTERN PetscErrorCode SlipFaultLoadsSetUp(SlipFault fault);
PETSC_EXTERN PetscErrorCode SlipFaultLoadsDestroy(SlipFault fault);
PETSC_EXTERN PetscErrorCode SlipFaultLoadAt(SlipFault fault, PetscReal t);
PETSC_EXTERN PetscErrorCode SlipFaultReportOpening(SlipFault fault, PetscReal t);
PETSC_EXTERN PetscErrorCode SlipFaultNextCorner(SlipFault fault, PetscReal t, PetscReal *next);
PETSC_EXTERN PetscErrorCode SlipFaultPressureScale(SlipFault fault, PetscReal t, PetscReal duration, PetscReal *scale);
PETSC_EXTERN PetscReal SlipExponentialIntegral(PetscReal x);
/* rest.c */
PETSC_EXTERN PetscErrorCode SlipFaultRestSetUp(SlipFault fault);
PETSC_EXTERN PetscErrorCode SlipFaultRest(SlipFault fault, PetscReal t, PetscReal limit, Vec w, Vec half, Vec after,
                                          PetscReal *end, PetscReal *h);
/* balance.c: faults whose cells always slide */
PETSC_EXTERN PetscErrorCode SlipFaultChooseDefaults(SlipFault fault);
PETSC_EXTERN PetscErrorCode SlipFaultBalanceSetUp(SlipFault fault);
PETSC_EXTERN PetscErrorCode SlipFaultBalanceStart(SlipFault fault, Vec w);
PETSC_EXTERN PetscErrorCode SlipFaultRates(SlipFault fault, PetscReal t, Vec w, Vec F); /* fault->balance.rate, and F */
PETSC_EXTERN PetscErrorCode SlipFaultPutRates(SlipFault fault, Vec w);
/* explicit.c */
PETSC_EXTERN PetscErrorCode SlipFaultExplicitConfigure(SlipFault fault, TS ts);
PETSC_EXTERN PetscErrorCode SlipFaultExplicitState(SlipFault fault, SlipState s, TS ts);
PETSC_EXTERN PetscErrorCode SlipFaultFirstStep(SlipFault fault, PetscReal *step); /* of smooth laws [s] */
PETSC_EXTERN PetscErrorCode SlipFaultBalanceDestroy(SlipFault fault);
PETSC_EXTERN PetscBool SlipFaultHasField(SlipFault fault, PetscInt field); /* its law reads it */
PETSC_EXTERN PetscErrorCode SlipFaultSmoothTraction(SlipFault fault, PetscReal t, Vec w,
                                                    Vec r);                           /* -q sign(v), weighted */
PETSC_EXTERN PetscReal SlipFaultShownState(SlipFault fault, PetscInt i, PetscReal s); /* as outputs have it */
PETSC_EXTERN const char *SlipFaultStateUnit(SlipFault fault);
/* tolerance.c */
PETSC_EXTERN PetscErrorCode SlipFaultSwing(SlipFault fault, Vec w, PetscReal *ratio);
PETSC_EXTERN PetscErrorCode SlipFaultErrorNorm(SlipFault fault, PetscReal rtol, PetscReal h, Vec e, Vec w0, Vec w1,
                                               PetscReal *E);
PETSC_EXTERN PetscErrorCode SlipFaultGetSums(SlipFault fault, Vec w, const SlipFaultSums **sums);
PETSC_EXTERN PetscErrorCode SlipFaultObserve(SlipFault fault, Vec w, PetscInt n, const PetscInt row[],
                                             PetscReal value[]);
PETSC_EXTERN PetscErrorCode SlipFaultRunErrorStart(SlipFault fault, TS ts);
PETSC_EXTERN PetscErrorCode SlipFaultRunErrorReport(SlipFault fault, TS ts, SlipOutput run, PetscReal mean_slip);
PETSC_EXTERN PetscErrorCode SlipFaultRunErrorDestroy(SlipFault fault);
PETSC_EXTERN PetscErrorCode SlipFaultCourseAdd(SlipFault fault, SlipFaultCourse *course, PetscReal time, Vec w);
PETSC_EXTERN PetscErrorCode SlipFaultCourseStart(SlipFault fault, TS ts);
PETSC_EXTERN PetscErrorCode SlipFaultCourseState(SlipFault fault, SlipState s);
PETSC_EXTERN PetscErrorCode SlipFaultTimingStep(SlipFault fault, TS ts, const SlipAttempt *attempt, Vec w, Vec e,
                                                PetscReal scale);
PETSC_EXTERN PetscErrorCode SlipFaultCheckStart(SlipFault fault, TS ts);
PETSC_EXTERN PetscErrorCode SlipFaultCheckError(SlipFault fault, TS ts, SlipOutput run, PetscReal error[],
                                                PetscReal *final, PetscInt *solves);
PETSC_EXTERN PetscErrorCode SlipFaultKeepEstimates(SlipFault fault, Vec w, Vec error, Vec derivative);
PETSC_EXTERN PetscErrorCode SlipFaultRestTime(SlipFault fault, PetscReal t, Vec w, PetscReal *rest);
PETSC_EXTERN PetscErrorCode SlipFaultOutputDestroy(SlipFaultOutput *output);

PETSC_EXTERN PetscErrorCode SlipFaultProgressStart(SlipFault fault, TS ts); /* collective */
/* Rank 0 prints what the set-up begins with, where it is long: on a terminal, or after a second. */
PETSC_EXTERN PetscErrorCode SlipFaultProgressSetUp(SlipFault fault, const char what[]);
PETSC_EXTERN PetscErrorCode SlipFaultProgressSetUpEnd(SlipFault fault);
PETSC_EXTERN PetscBool SlipFaultProgressDue(PetscBool terminal, PetscReal elapsed, PetscReal since);
/* A time in fitting units: "12.5 s", "3.2 h", "113.4 years" */
PETSC_EXTERN void SlipFaultTimeText(PetscReal seconds, char text[], size_t len);
/* Sums over the cells: power[0] of (v - v_inf) H (v - v_inf), [1] of v_inf H (v - v_inf), [2] of -v r, or q |v|. */
PETSC_EXTERN PetscErrorCode SlipFaultGetPowers(SlipFault fault, Vec w, Vec r, PetscReal power[3]);

/* ---- stress.c: elastic stress and energy, and what loading does ---- */
PETSC_EXTERN PetscErrorCode SlipFaultElasticEnergy(SlipFault fault, PetscReal t, Vec w, PetscReal *energy); /* [J] */
PETSC_EXTERN PetscErrorCode SlipFaultLoadingPower(SlipFault fault, PetscReal t, Vec w, PetscReal *power);   /* [W] */

/* ---- output.c, outputfile.c: what the output of a fault adds to that of any run: its mesh and its fields ---- */
/* Fields of /fields: components of the state, but traction, the reaction; and slip of a fault that heals, which is not s */
typedef enum {
  OUTPUT_SLIP_RATE,
  OUTPUT_DISPLACEMENT,
  OUTPUT_SLIP,
  OUTPUT_TRACTION,
  OUTPUT_STATE,
  OUTPUT_NUM_FIELDS
} SlipOutputFieldId;

/* stations.c: points whose cells are recorded at every accepted step */
typedef struct {
  PetscReal x, z;      /* asked for [m] */
  PetscReal centre[3]; /* x, y, z of the cell's centre [m] */
  PetscInt cell;       /* in the order of the file or grid */
  PetscInt local;      /* number among this rank's cells, -1: of another rank */
  PetscReal u0;        /* displacement at the start [m] */
} SlipFaultStation;

typedef struct {
  PetscInt n;
  SlipFaultStation *station;
  PetscBool known; /* a checkpoint says where they began */
  PetscReal start; /* time of the start [s] */
  PetscReal *row;  /* [5 n] */
} SlipFaultStations;

/* xdmf.c: what makes the output open in ParaView; rank 0 */
typedef struct {
  PetscBool wanted;
  char target[PETSC_MAX_PATH_LEN]; /* the output's final name */
  PetscInt n, size;                /* entries of /fields, room for */
  PetscReal *time;                 /* theirs [s] */
  PetscInt written;                /* entries in the file */
  int failed;                      /* errno of the last attempt to write it, or 0 */
  PetscLogDouble last, cost;       /* when that was, and how long it took [s] */
} SlipFaultXdmf;

/* outputwhen.c: what decides about the next entry of /fields */
typedef struct {
  PetscBool known;      /* there was an entry, or a checkpoint that remembers it */
  PetscReal time;       /* of the last accepted step [s] */
  PetscReal entry_time; /* of the newest entry [s] */
  PetscReal entry_rate; /* largest slip rate then [m/s] */
  Vec entry_u;          /* displacement then [m]; NULL without -fault_output_slip_interval */
} SlipFaultWhen;

struct _n_SlipFaultOutput {
  SlipFault fault; /* borrowed */
  PetscMPIInt rank;
  SlipOutput run; /* the file, /run, /steps, /series, /result and the summary */
  PetscBool wanted[OUTPUT_NUM_FIELDS];
  const char *name[OUTPUT_NUM_FIELDS]; /* of the fields */
  PetscBool resumed, started;          /* goes on in the file of an earlier run; TSSolve() has said where it starts */
  PetscInt nfields;                    /* entries of /fields */
  PetscInt last_field_step;            /* step of the newest of them */
  Vec w0, r0;                          /* state and reaction gathered on rank 0 */
  Vec traction;
  Vec shown;         /* state as /fields have it, where that is not w */
  Vec start0, vinf0; /* rank 0, of a fault that heals: displacement of the start [m] and loading rate [m/s] */
  SlipFaultMoment traction_moment; /* of the state that traction is of */
  VecScatter gather_w, gather_r;
  SlipFaultStations stations;
  SlipFaultWhen when;
  SlipFaultXdmf xdmf;
};

PETSC_EXTERN PetscErrorCode SlipFaultOutputCreateRun(SlipFaultOutput out, TS ts); /* collective, no file as yet */
PETSC_EXTERN PetscErrorCode SlipFaultOutputFields(SlipFaultOutput out, PetscReal time, Vec w);
/* Collective: out->traction of a state, the static one, weighted by area */
PETSC_EXTERN PetscErrorCode SlipFaultOutputTraction(SlipFaultOutput out, PetscReal time, Vec w);
PETSC_EXTERN PetscErrorCode SlipFaultOutputState(SlipFault fault, SlipState s); /* collective: what it remembers */

PETSC_EXTERN PetscErrorCode SlipFaultStationsSetUp(SlipFaultOutput out);
PETSC_EXTERN PetscErrorCode SlipFaultStationsLayout(SlipFaultOutput out); /* rank 0: groups, or cut */
PETSC_EXTERN PetscErrorCode SlipFaultStationsStart(SlipFaultOutput out, PetscReal time, Vec w);
PETSC_EXTERN PetscErrorCode SlipFaultStationsRow(SlipFaultOutput out, PetscReal time, Vec w);
PETSC_EXTERN PetscErrorCode SlipFaultStationsDestroy(SlipFaultOutput out);

/* Rank 0: what the output needs for it, before it is live; an entry; the output is flushed, for the last time or
   not; the output has its final name */
PETSC_EXTERN PetscErrorCode SlipFaultXdmfLayout(SlipFaultOutput out);
PETSC_EXTERN PetscErrorCode SlipFaultXdmfAdd(SlipFaultOutput out, PetscReal time);
PETSC_EXTERN PetscErrorCode SlipFaultXdmfFlushed(SlipFaultOutput out, PetscBool last);
PETSC_EXTERN PetscErrorCode SlipFaultXdmfFinish(SlipFaultOutput out);

PETSC_EXTERN PetscErrorCode SlipFaultOutputWhenCheck(SlipFault fault);
PETSC_EXTERN PetscErrorCode SlipFaultOutputIsDue(SlipFaultOutput out, PetscInt step, PetscReal time, Vec w,
                                                 PetscBool *due);
PETSC_EXTERN PetscErrorCode SlipFaultOutputWasWritten(SlipFaultOutput out, PetscReal time, Vec w);
PETSC_EXTERN PetscErrorCode SlipFaultOutputSize(SlipFaultOutput out, TS ts); /* prints it */
/* Shape of a field in a file, [Nz, Nx], or [n] for a mesh: number of dimensions */
PETSC_EXTERN PetscInt SlipFaultFieldShape(SlipFault fault, PetscInt dims[2]);
PETSC_EXTERN PetscErrorCode SlipFaultWriteAxes(SlipFault fault, SlipH5 *h); /* rank 0: centres of the cells */

/* ---- catalogue.c, cataloguefile.c: events, a row each ---- */
typedef enum { WORK_RADIATED, WORK_DISSIPATED, WORK_LOADING, FAULT_NUM_WORKS } SlipFaultWorkId;

/* The event under way */
typedef struct {
  PetscReal onset;                 /* [s] */
  PetscReal elastic, kinetic;      /* energies at the onset [J] */
  PetscReal work[FAULT_NUM_WORKS]; /* since then [J] */
  PetscReal peak;                  /* largest slip rate so far [m/s] */
  PetscReal time[2], rate[2];      /* ends of the last two steps [s], largest slip rates there [m/s] */
  PetscInt cell;                   /* hypocentre, as the file numbers cells */
  PetscInt steps;
} SlipFaultEvent;

typedef enum {
  EVENT_ONSET,
  EVENT_END,
  EVENT_X,
  EVENT_Y,
  EVENT_Z,
  EVENT_CELL,
  EVENT_AREA,
  EVENT_MEAN_SLIP,
  EVENT_MAX_SLIP,
  EVENT_DIRECTION,
  EVENT_MOMENT,
  EVENT_MAGNITUDE,
  EVENT_STRESS_DROP,
  EVENT_PEAK_SLIP_RATE,
  EVENT_ELASTIC_ENERGY,
  EVENT_KINETIC_ENERGY,
  EVENT_DISSIPATED_ENERGY,
  EVENT_RADIATED_ENERGY,
  EVENT_LOADING_WORK,
  EVENT_LEDGER,
  EVENT_STEPS,
  EVENT_NUM_COLUMNS
} SlipEventColumn;

struct _n_SlipFaultCatalogue {
  SlipFault fault; /* borrowed */
  PetscMPIInt rank;
  PetscBool maps;           /* slip and rupture time of each cell as well */
  PetscBool begun, resumed; /* the file is there; it is that of an earlier run, cut */
  PetscBool started;        /* TSSolve() has said where it starts */
  SlipH5Kind kind;
  SlipH5 file;                      /* rank 0 */
  PetscBool unflushed;              /* rows that are not on the disk */
  SlipTable table;                  /* rank 0: the columns */
  PetscReal last_end;               /* of the newest row [s] */
  PetscBool active;                 /* an event is under way */
  SlipFaultEvent event;             /* and how far it is */
  Vec u0, stress0;                  /* displacement [m] and shear stress [Pa] at its onset */
  Vec rupture;                      /* when each cell exceeded the rate, after the onset [s]; -1: not yet */
  Vec before;                       /* with other integrators than TSBATHE: state of the step before, else NULL */
  PetscReal time_before;            /* its time [s] */
  Vec cut, stress, slip;            /* work: state within a step, shear stress [Pa], slip of the event [m] */
  PetscBool power_known;            /* that of the end of the last step is */
  PetscReal power[FAULT_NUM_WORKS]; /* [W] */
  VecScatter gather;                /* maps, on rank 0 */
  Vec map[2];
};

PETSC_EXTERN PetscErrorCode SlipFaultCatalogueStart(SlipFault fault, TS ts);
PETSC_EXTERN PetscErrorCode SlipFaultCatalogueState(SlipFault fault, SlipState s);
PETSC_EXTERN PetscErrorCode SlipFaultCatalogueFinish(SlipFault fault, SlipOutput run);
PETSC_EXTERN PetscErrorCode SlipFaultCatalogueDestroy(SlipFaultCatalogue *catalogue);
/* The file; collective */
PETSC_EXTERN PetscErrorCode SlipCatalogueBegin(SlipFaultCatalogue cat); /* unless it is there */
PETSC_EXTERN PetscErrorCode SlipCatalogueFlush(SlipFaultCatalogue cat); /* when it is due */
PETSC_EXTERN PetscErrorCode SlipCatalogueSync(SlipFaultCatalogue cat);
PETSC_EXTERN PetscErrorCode SlipCatalogueClose(SlipFaultCatalogue cat, PetscBool complete);
PETSC_EXTERN PetscErrorCode SlipCatalogueAdd(SlipFaultCatalogue cat, const PetscReal row[]);
