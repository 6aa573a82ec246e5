/* Inside the fault: its data, and what its files need of each other. Its parameters are in slipfaultparameters.h, what a run
   leaves behind in slipfaultrecord.h. */
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
#include <slipstep/private/slipfaultloads.h>
#include <slipstep/private/slipfaultmesh.h>
#include <slipstep/private/slipfaultoperators.h>
#include <slipstep/private/slipfaultparameters.h>
#include <slipstep/private/slipstate.h>
#include <slipstep/private/slipsys.h>

/* All that what was computed of a state depends on: the vector and how it was then, the load, and the slip rates, which TSRK is not
   told of when they are put into its solution */
typedef struct {
  PetscObjectId id;
  PetscObjectState state;
  PetscReal time;   /* of the load, 0 where it is always the same [s] */
  PetscInt64 rates; /* how often rates were put into states */
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
  PetscInt sides;     /* right-hand sides of the run so far */
  Vec F;              /* its rates, borrowed from the TS */
  Vec first;          /* those of the first step of a run that goes on from a checkpoint; NULL: to be computed */
  Vec u, rate, force; /* its displacement [m], slip rate [m/s], and K u [Pa] */
  PetscInt64 put;     /* how often it was put into a state */
  Vec seen;           /* an attempt's end with its rates, which a controller observes; NULL: none has */
  PetscReal stiffest; /* largest eigenvalue of K [Pa/m]; 0: nobody has asked */
  PetscBool *creeps;  /* [n] cells that slip at the loading rate; NULL: none */
  PetscReal *kept;    /* what the law keeps of each cell; NULL where the normal stress changes */
} SlipFaultBalance;

typedef struct _n_SlipFaultCatalogue *SlipFaultCatalogue;

/* ---- progress.c: what a run prints while it goes ---- */
typedef struct {
  PetscBool wanted;                  /* -fault_progress */
  PetscBool repetition;              /* what runs is that of -fault_check_error */
  PetscInt wait;                     /* steps until rank 0 is asked again whether a line is due */
  PetscReal start;                   /* model time at the start of the run, or where it goes on [s] */
  PetscLogDouble setup;              /* when the set-up began [s]; 0: it did not */
  PetscLogDouble begin;              /* when the run began [s]; 0: it did not */
  PetscLogDouble printed, step;      /* when the last line and the last step were [s] */
  PetscBool fast;                    /* an event is under way */
  PetscInt onsets;                   /* of events so far */
  PetscLogDouble first, newest;      /* when the first and the newest of them were [s] */
  PetscReal first_time, newest_time; /* in the model [s] */
} SlipFaultProgress;

/* ---- resolution.c: the lengths of a rupture against the cells ---- */
typedef struct {
  PetscBool weakens;    /* some cell weakens */
  PetscBool known;      /* it does, and there are several cells: what follows is valid */
  PetscBool zone;       /* the length is that of a cohesive zone, else of nucleation */
  PetscReal least;      /* of length over cell, of all cells that weaken */
  PetscReal length;     /* there [m] */
  PetscReal cell;       /* there [m] */
  PetscReal wanted;     /* what the field asks least to be */
  PetscReal alone;      /* share of the cells that weaken which can fail alone */
  PetscReal nucleation; /* least length of nucleation [m] */
  PetscReal critical;   /* mean of the stiffness below which slip is unstable, of the cells that weaken [Pa/m] */
} SlipFaultResolution;

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
  PetscObjectId id;   /* of the TS that has the monitor */
  PetscBool recorded; /* the course is */
  PetscBool known;    /* every accepted step so far had an error estimate */
  PetscReal moving;   /* share of the slip that is on cells which still slide, at the end of the last step */
  PetscReal decay;    /* of changes of the energy [1/s] */
  PetscReal work[2];  /* changes of the energy by local errors, carried to now, and by their magnitudes [J/m^2] */
  PetscReal slip[2];  /* errors of the mean slip that have become final, likewise [m] */
  PetscReal sum;      /* of the slip at the end of the last step [m] */
  PetscReal late;     /* what of it was made in steps in which cells came to rest [m] */
  SlipFaultTiming timing;
  SlipFaultCourse course; /* the start and the ends of accepted steps */
  /* -fault_check_error */
  SlipFaultCourse fine; /* of the repetition, and ends of parts of steps */
  Vec start;            /* state of the start */
  PetscReal start_time; /* [s] */
  PetscReal start_step; /* [s] */
  PetscBool off;        /* the repetition is no run to estimate */
} SlipFaultRunError;

/* ---- the parts of a fault, each filled by the file that is named, in the order of SlipFaultSetUp() ---- */

/* parameters.c: what the user chose; nothing else writes here */
typedef struct {
  PetscReal value[FAULT_NUM_REALS];
  char text[FAULT_NUM_STRINGS][PETSC_MAX_PATH_LEN];
  PetscBool inertia;          /* -fault_inertia */
  PetscBool inertia_given;    /* else the law decides */
  PetscBool initial_unstable; /* -fault_initial_unstable */
  PetscBool check_error;      /* -fault_check_error */
  PetscBool output_overwrite; /* -fault_output_overwrite */
  PetscBool output_xdmf;      /* -fault_output_xdmf */
  PetscBool interval_given;   /* output_interval was set */
  PetscBool catalogue_maps;   /* -fault_catalogue_maps */
  PetscBool speaks;           /* its options were read: it warns, and prints what it found */
  PetscViewer viewer;         /* -fault_view */
  PetscViewerFormat format;
  PetscViewer stiffness_viewer; /* -fault_stiffness_view */
  PetscViewerFormat stiffness_format;
} SlipFaultOptions;

/* cells.c: parameters cell by cell */
typedef struct {
  PetscReal *given[FAULT_NUM_FIELDS]; /* of SlipFaultSetField(): all cells, [nx nz]; NULL: the scalar parameter */
  PetscInt ngiven[FAULT_NUM_FIELDS];
  PetscReal *cell[FAULT_NUM_FIELDS];    /* [n] */
  const char *source[FAULT_NUM_FIELDS]; /* where they come from, for views; NULL: the scalar parameters */
} SlipFaultCellFields;

/* Where the numbers of a cell are in a state, and in its rates and errors; block numbers a cell */
typedef struct {
  PetscInt block;
  PetscInt rate;         /* slip rate [m/s] */
  PetscInt displacement; /* relative to the far field [m] */
  PetscInt state;        /* of friction: cumulative slip [m], or what the law has in its place */
} SlipFaultLayout;

/* The friction of the cells, but for their normal stress, which the loads know */
typedef struct {
  const SlipFrictionLaw *law;
  PetscBool slip_law; /* -fault_state_law slip */
  PetscReal *healing; /* [n] 1/t_h [1/s]; NULL: 0 */
} SlipFaultFriction;

/* What sort of problem the parameters make */
typedef struct {
  PetscBool loaded;                /* some v_inf is not zero */
  const char *initial, *viscosity; /* the choices, "auto" decided */
  PetscBool inertia;               /* likewise; -fault_inertia */
  PetscBool heals;                 /* some healing time is not never */
  PetscBool sequence;              /* by loading, stressing or healing events may follow each other */
  PetscBool driven; /* by loading, stressing, pressure or healing, or without inertia: quiet times without end */
  PetscReal rtol;   /* the default of -ts_rtol, with the problem's controller */
} SlipFaultKind;

/* constraint.c: the stage being solved: u = u0 + theta v, s = s0 + theta |v|, B v = c + omega r */
typedef struct {
  SlipConstraint con;
  PetscReal time, theta; /* [s] */
  Vec c, u0, s0;
} SlipFaultStage;

/* observe.c: what is known of the state asked about last */
typedef struct {
  SlipFaultLoad load; /* that of the time asked about last */
  SlipFaultSums sums;
  SlipFaultMode mode;
  SlipFaultEstimates estimates;
} SlipFaultKnown;

/* stepvalues.c: each of the moment beside it */
typedef struct {
  Vec traction;   /* static, weighted by area */
  PetscReal rate; /* largest |v| [m/s] */
  SlipFaultMoment traction_moment, rate_moment;
} SlipFaultStepValues;

/* A run, and those who observe it */
typedef struct {
  SlipOutput file;                 /* /run, /steps, /series, and what observers add; NULL: none */
  struct _n_SlipFaultWatch *watch; /* [nwatch] of observers.c */
  PetscInt nwatch;
  PetscBool started; /* they know what TSSolve() starts from */
  PetscInt step;     /* the last that they were told of */
  SlipFaultStepValues values;
  PetscBool complete;           /* the file has its name */
  PetscInt entries;             /* of /fields */
  PetscReal entry_time;         /* of the newest [s] */
  SlipFaultCatalogue catalogue; /* borrowed, for SlipFaultGetEvents(); NULL: none */
  PetscInt products;            /* with K of this process, before the run */
  PetscInt events;              /* of the run so far, as the catalogue counts them; -1: nobody does */
  SlipFaultRunError error;
  SlipFaultProgress progress;
} SlipFaultRun;

struct _p_SlipFault {
  PETSCHEADER(int);
  MPI_Comm comm; /* of the header, for short */
  SlipFaultOptions options;
  PetscBool setup; /* SlipFaultSetUp() was called: what follows is valid */
  SlipFaultMesh mesh;
  SlipFaultLayout layout;
  SlipFaultCellFields fields;
  SlipFaultFriction friction;
  SlipFaultLoads loads;
  SlipFaultKind kind;
  SlipFaultOperators operators;
  SlipFaultCritical critical;
  SlipFaultStage stage;
  SlipFaultBalance balance; /* where all cells slide: the slip rates of the state asked about last */
  SlipFaultResolution resolution;
  SlipProblemOps problem; /* what its TS tells controllers */
  SlipFaultKnown known;
  SlipFaultRun run;
  Vec work[3];
};

/* Entries of cell i of this rank in a state */
static inline PetscInt SlipFaultRateAt(SlipFault fault, PetscInt i)
{
  return fault->layout.block * i + fault->layout.rate;
}

static inline PetscInt SlipFaultDisplacementAt(SlipFault fault, PetscInt i)
{
  return fault->layout.block * i + fault->layout.displacement;
}

static inline PetscInt SlipFaultStateAt(SlipFault fault, PetscInt i)
{
  return fault->layout.block * i + fault->layout.state;
}

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

PETSC_EXTERN PetscErrorCode SlipFaultCellsSetUp(SlipFault fault);        /* fields */
PETSC_INTERN const char *SlipFaultGetText(SlipFault fault, PetscInt id); /* a choice; after set-up without "auto" */
PETSC_EXTERN PetscErrorCode SlipFaultFieldNames(char names[], size_t len);
PETSC_EXTERN PetscErrorCode SlipFaultAverage(SlipFault fault, SlipAverage *average); /* that was chosen */
/* steps.c */
PETSC_INTERN void SlipFaultChooseSteps(SlipFault fault, PetscBool is_explicit);
PETSC_INTERN PetscErrorCode SlipFaultReportSteps(SlipFault fault, TS ts);
PETSC_EXTERN PetscErrorCode SlipFaultConstraintCreate(SlipFault fault);
PETSC_EXTERN PetscErrorCode SlipFaultConstraintStage(SlipFault fault, const SlipStage *stage);
PETSC_EXTERN PetscErrorCode SlipFaultConstraintResidual(SlipFault fault, Vec x, Vec g);
PETSC_EXTERN PetscErrorCode SlipFaultConstraintLift(SlipFault fault, Vec x, Vec w);
PETSC_EXTERN PetscErrorCode SlipFaultSmooth(SlipFault fault, PetscReal t, Vec w, Vec F);
PETSC_EXTERN PetscErrorCode SlipFaultStrength(SlipFault fault, PetscReal t, Vec w, Vec q);
PETSC_EXTERN PetscErrorCode SlipFaultStartShare(SlipFault fault, PetscReal *share); /* state.c */
PETSC_EXTERN PetscErrorCode SlipFaultGetSlip(SlipFault fault, PetscReal t, Vec w, Vec slip);
PETSC_EXTERN PetscErrorCode SlipFaultCheckFileNames(SlipFault fault); /* filenames.c */
/* loads.c */
PETSC_EXTERN PetscErrorCode SlipFaultLoadsSetUp(SlipFault fault);
PETSC_EXTERN PetscErrorCode SlipFaultLoadsDestroy(SlipFault fault);
PETSC_EXTERN PetscErrorCode SlipFaultGetLoad(SlipFault fault, PetscReal t, const SlipFaultLoad **load);
PETSC_EXTERN PetscErrorCode SlipFaultReportOpening(SlipFault fault, PetscReal t);
/* rest.c */
PETSC_EXTERN PetscErrorCode SlipFaultRestSetUp(SlipFault fault);
PETSC_EXTERN PetscErrorCode SlipFaultRest(SlipFault fault, PetscReal t, PetscReal limit, Vec w, Vec half, Vec after,
                                          PetscReal *end, PetscReal *h);
/* balance.c: faults whose cells always slide */
PETSC_EXTERN PetscErrorCode SlipFaultChooseDefaults(SlipFault fault);
PETSC_INTERN SlipFrictionCells SlipFaultCellFriction(SlipFault fault, const PetscReal stress[]);
PETSC_EXTERN PetscErrorCode SlipFaultBalanceSetUp(SlipFault fault);
PETSC_EXTERN PetscErrorCode SlipFaultBalanceStart(SlipFault fault, Vec w);
PETSC_EXTERN PetscErrorCode SlipFaultRates(SlipFault fault, PetscReal t, Vec w, Vec F); /* fault->balance.rate, and F */
PETSC_EXTERN PetscErrorCode SlipFaultPutRates(SlipFault fault, Vec w);
PETSC_EXTERN PetscBool SlipFaultRateWeakens(const SlipFrictionCells *friction, PetscInt i, PetscReal rate);
/* resolution.c */
PETSC_EXTERN PetscErrorCode SlipFaultResolutionSetUp(SlipFault fault);
PETSC_EXTERN PetscErrorCode SlipFaultResolutionText(SlipFault fault, char text[], size_t len); /* for views and lines */
PETSC_EXTERN PetscErrorCode SlipFaultResolutionPrint(SlipFault fault);
PETSC_EXTERN PetscErrorCode SlipFaultResolutionResult(SlipFault fault, SlipOutput run);
PETSC_EXTERN PetscErrorCode SlipFaultResolutionWarn(SlipFault fault);
/* warn.c */
PETSC_EXTERN PetscErrorCode SlipFaultWarn(SlipFault fault);
/* explicit.c */
PETSC_EXTERN PetscErrorCode SlipFaultExplicitConfigure(SlipFault fault, TS ts);
PETSC_EXTERN PetscErrorCode SlipFaultFinishStep(TS ts, PetscReal t, Vec w);
PETSC_EXTERN PetscErrorCode SlipFaultObservedState(SlipFault fault, TS ts, PetscReal t, Vec w, Vec *seen);
PETSC_EXTERN PetscErrorCode SlipFaultExplicitState(SlipFault fault, SlipState s, TS ts);
PETSC_EXTERN PetscErrorCode SlipFaultFirstStep(SlipFault fault, PetscReal *step); /* where all cells slide [s] */
PETSC_EXTERN PetscErrorCode SlipFaultBalanceDestroy(SlipFault fault);
PETSC_EXTERN PetscBool SlipFaultHasField(SlipFault fault, PetscInt field); /* its law reads it */
PETSC_EXTERN PetscErrorCode SlipFaultSmoothTraction(SlipFault fault, PetscReal t, Vec w,
                                                    Vec r);                           /* -q sign(v), weighted */
PETSC_EXTERN PetscReal SlipFaultShownState(SlipFault fault, PetscInt i, PetscReal s); /* as outputs have it */
PETSC_EXTERN const char *SlipFaultStateUnit(SlipFault fault);
/* tolerance.c */
PETSC_EXTERN PetscErrorCode SlipFaultSwing(SlipFault fault, PetscReal t, Vec w, PetscReal *ratio);
PETSC_EXTERN PetscErrorCode SlipFaultErrorNorm(SlipFault fault, PetscReal rtol, PetscReal t, PetscReal h, Vec e, Vec w0,
                                               Vec w1, PetscReal *E);
/* observe.c. Is what is known of a moment that of the state w of now, with the load of time t? */
PETSC_EXTERN PetscErrorCode SlipFaultIsNow(SlipFault fault, PetscReal t, Vec w, const SlipFaultMoment *known,
                                           SlipFaultMoment *now, PetscBool *same);
/* The fastest relaxation of stress by a cell's own slip [1/s], of the rates of the last right-hand side; 0: of no explicit problem */
PETSC_EXTERN PetscErrorCode SlipFaultRelaxation(SlipFault fault, Vec w, PetscReal *relaxation);
PETSC_EXTERN PetscErrorCode SlipFaultGetSums(SlipFault fault, PetscReal t, Vec w, const SlipFaultSums **sums);
PETSC_EXTERN PetscErrorCode SlipFaultObserve(SlipFault fault, PetscReal t, Vec w, PetscInt n, const PetscInt row[],
                                             PetscReal value[]);
PETSC_EXTERN PetscErrorCode SlipFaultCourseAdd(SlipFault fault, SlipFaultCourse *course, PetscReal time, Vec w);
PETSC_EXTERN PetscErrorCode SlipFaultCourseState(SlipFault fault, SlipState s);
PETSC_EXTERN PetscErrorCode SlipFaultTimingStep(SlipFault fault, TS ts, const SlipAttempt *attempt, Vec w, Vec e,
                                                PetscReal scale);
PETSC_EXTERN PetscErrorCode SlipFaultCheckStart(SlipFault fault, TS ts);
PETSC_EXTERN PetscErrorCode SlipFaultCheckError(SlipFault fault, TS ts, SlipOutput run, PetscReal error[],
                                                PetscReal *final, PetscInt *solves);
PETSC_EXTERN PetscErrorCode SlipFaultKeepEstimates(SlipFault fault, Vec w, Vec error, Vec derivative);
PETSC_EXTERN PetscErrorCode SlipFaultRestTime(SlipFault fault, PetscReal t, Vec w, PetscReal *rest);

/* Rank 0 prints what the set-up begins with, where it is long: on a terminal, or after a second. */
PETSC_EXTERN PetscErrorCode SlipFaultProgressSetUp(SlipFault fault, const char what[]);
PETSC_EXTERN PetscErrorCode SlipFaultProgressSetUpEnd(SlipFault fault);
PETSC_EXTERN PetscBool SlipFaultProgressDue(PetscBool terminal, PetscReal elapsed, PetscReal since);
PETSC_EXTERN void SlipFaultProgressSee(SlipFaultProgress *p, PetscLogDouble now, PetscReal time, PetscReal rate,
                                       PetscReal bound);
PETSC_EXTERN PetscReal SlipFaultProgressLeft(const SlipFaultProgress *p, PetscBool driven, PetscLogDouble now,
                                             PetscReal time, PetscReal end);
/* Sums over the cells: power[0] of (v - v_inf) H (v - v_inf), [1] of v_inf H (v - v_inf), [2] of -v r, or q |v|. */
PETSC_EXTERN PetscErrorCode SlipFaultGetPowers(SlipFault fault, PetscReal t, Vec w, Vec r, PetscReal power[3]);

/* ---- stress.c: elastic stress and energy, and what loading does ---- */
PETSC_EXTERN PetscErrorCode SlipFaultElasticEnergy(SlipFault fault, PetscReal t, Vec w, PetscReal *energy); /* [J] */
PETSC_EXTERN PetscErrorCode SlipFaultLoadingPower(SlipFault fault, PetscReal t, Vec w, PetscReal *power);   /* [W] */
