/* A run of a fault and those who observe it: what they share, how far it is, and what its errors are. */
#pragma once
#include <slipstep/private/slipdevice.h>
#include <slipstep/private/slipfault.h>
#include <slipcore.h>
#include <slipoutput.h>
#include <slipts.h>
#include <slipstep/private/slipstate.h>
#include <slipstep/private/slipwork.h>

typedef struct _n_SlipFaultCatalogue *SlipFaultCatalogue;

/* ---- progress.c: what a run prints while it goes ---- */
typedef struct {
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

/* In the order of SlipMeasures */
typedef enum { ESTIMATE_HISTORY, ESTIMATE_FINAL, ESTIMATE_TIME, NUM_ESTIMATES } SlipFaultEstimate;

/* estimatefile.c: what makes errors of estimates, from a file; formulas in slipestimate.c */
enum { CALIBRATION_MOST = 32 };
typedef struct {
  PetscInt n; /* classes of accepted steps, 0: the file has none */
  struct {
    PetscReal steps; /* at most; of the last infinite */
    PetscReal factor[NUM_ESTIMATES];
  } row[CALIBRATION_MOST];
} SlipFaultFactors;
typedef struct {
  PetscInt least;               /* fewest accepted steps with an estimate */
  PetscReal floor, late;        /* of the final slip */
  PetscReal shift_floor;        /* of the time of the event */
  PetscReal history_final;      /* share of the final slip's in the history's */
  SlipFaultFactors of_all;      /* runs without a table of their own */
  SlipFaultFactors of_explicit; /* runs most of whose steps are explicit */
} SlipFaultCalibration;
/* Collective. file "": the library's, or that of SLIPSTEP_POLICY_DIR; measure [NUM_ESTIMATES]: names of its columns */
PETSC_EXTERN PetscErrorCode SlipFaultCalibrationRead(MPI_Comm comm, const char prefix[], const char file[],
                                                     const char *const measure[], SlipFaultCalibration *c);

typedef struct {
  PetscObjectId id;        /* of the TS that has the monitor */
  PetscBool recorded;      /* the course is */
  PetscBool known;         /* every accepted step so far had an error estimate */
  PetscInt explicit_steps; /* accepted steps so far that were explicit */
  PetscReal moving;        /* share of the slip that is on cells which still slide, at the end of the last step */
  PetscReal decay;         /* of changes of the energy [1/s] */
  PetscReal work[2];       /* changes of the energy by local errors, carried to now, and by their magnitudes [J/m^2] */
  PetscReal slip[2];       /* errors of the mean slip that have become final, likewise [m] */
  PetscReal sum;           /* of the slip at the end of the last step [m] */
  PetscReal late;          /* what of it was made in steps in which cells came to rest [m] */
  SlipFaultTiming timing;
  SlipFaultCalibration calibration;
  SlipFaultCourse course; /* the start and the ends of accepted steps */
  /* -fault_check_error */
  SlipFaultCourse fine; /* of the repetition, and ends of parts of steps */
  Vec start;            /* state of the start */
  PetscReal start_time; /* [s] */
  PetscReal start_step; /* [s] */
  PetscBool off;        /* the repetition is no run to estimate */
} SlipFaultRunError;

/* A run, and those who observe it */
typedef struct _n_SlipFaultRun {
  SlipOutput file;                 /* /run, /steps, /series, and what observers add; NULL: none */
  struct _n_SlipFaultWatch *watch; /* [nwatch] of observers.c */
  PetscInt nwatch;
  PetscBool started;            /* they know what TSSolve() starts from */
  PetscBool idle;               /* it goes on from a checkpoint that leaves no step to take: nothing is written */
  PetscInt step;                /* the last that they were told of */
  PetscBool complete;           /* the file has its name */
  PetscInt entries;             /* of /fields */
  PetscReal entry_time;         /* of the newest [s] */
  SlipFaultCatalogue catalogue; /* borrowed, for SlipFaultGetEvents(); NULL: none */
  SlipProducts before[SLIP_PRODUCTS_USERS]; /* of this process: before the run, and before the set-up */
  PetscReal prepared;                       /* what was done between them costs so much [s] */
  PetscReal time; /* processor time of this process before the run, less that of processes that it goes on from [s] */
  SlipWorkTotals work;       /* of this process, before the run */
  SlipDeviceTraffic traffic; /* of this process, before the run */
  PetscInt events;           /* of the run so far, as the catalogue counts them; -1: nobody does */
  SlipFaultRunError error;
  SlipFaultProgress progress;
} SlipFaultRun;

PETSC_EXTERN PetscErrorCode SlipFaultCourseAdd(SlipFault fault, SlipFaultCourse *course, PetscReal time, Vec w);
PETSC_EXTERN PetscErrorCode SlipFaultCourseState(SlipFault fault, SlipState s);
PETSC_EXTERN PetscErrorCode SlipFaultTimingStep(SlipFault fault, TS ts, const SlipAttempt *attempt, Vec w, Vec e,
                                                PetscReal scale);
PETSC_EXTERN PetscErrorCode SlipFaultCheckStart(SlipFault fault, TS ts);
PETSC_EXTERN PetscErrorCode SlipFaultCheckError(SlipFault fault, TS ts, SlipOutput run, PetscReal error[],
                                                PetscReal *final, PetscInt *solves);

/* Rank 0 prints what the set-up begins with, where it is long: on a terminal, or after a second. */
PETSC_EXTERN PetscErrorCode SlipFaultProgressSetUp(SlipFault fault, const char what[]);
PETSC_EXTERN PetscErrorCode SlipFaultProgressSetUpEnd(SlipFault fault);
PETSC_EXTERN PetscBool SlipFaultProgressDue(PetscBool terminal, PetscReal elapsed, PetscReal since);
PETSC_EXTERN void SlipFaultProgressSee(SlipFaultProgress *p, PetscLogDouble now, PetscReal time, PetscReal rate,
                                       PetscReal bound);
PETSC_EXTERN PetscReal SlipFaultProgressLeft(const SlipFaultProgress *p, PetscBool driven, PetscLogDouble now,
                                             PetscReal time, PetscReal end);

PETSC_INTERN PetscErrorCode SlipFaultViewTimes(SlipFault fault); /* faultview.c */

/* Observers: a row of the table in observers.c each, over a context of its own that no other file knows */
/* samerun.c: the first part; an error where the checkpoint is of another run */
PETSC_INTERN PetscErrorCode SlipFaultClockStart(SlipFault fault, TS ts); /* longtime.c */
PETSC_INTERN PetscErrorCode SlipFaultVisitRun(SlipFault fault, SlipState state, TS ts);
PETSC_INTERN PetscErrorCode SlipFaultObserversVisit(SlipFault fault, SlipState state); /* a checkpoint's part */
PETSC_INTERN PetscErrorCode SlipFaultObserversDestroy(SlipFault fault);

/* runfiles.c. Collective: the file of an earlier run to go on in, FILE.part or FILE; "": there is none, and a line
   says so */
PETSC_INTERN PetscErrorCode SlipFaultFindEarlier(SlipFault fault, const char file[], const char what[], PetscBool say,
                                                 char found[PETSC_MAX_PATH_LEN + 8]);
