/* A run of a fault and its observers: their common data, the progress, and the errors of the run */
#pragma once
#include <slipstep/private/slipfault.h>
#include <slipstep/rooms/slipcore.h>
#include <slipstep/rooms/slipoutput.h>
#include <slipstep/rooms/slipts.h>
#include <slipstep/private/slipstate.h>
#include <slipstep/private/slipwork.h>

typedef struct _n_SlipFaultCatalogue *SlipFaultCatalogue;

/* ---- progress.c: lines that a run prints ---- */
typedef struct {
  PetscBool repetition;              /* the run is the repetition of -fault_check_error */
  PetscInt wait;                     /* steps until rank 0 checks again whether a line is due */
  PetscReal start;                   /* model time at the start or continuation of the run [s] */
  PetscLogDouble setup;              /* wall time when the set-up began [s]; 0: it did not */
  PetscLogDouble begin;              /* wall time when the run began [s]; 0: it did not */
  PetscLogDouble printed, step;      /* wall times of the last line and the last step [s] */
  PetscBool fast;                    /* there is an event now */
  PetscInt onsets;                   /* number of events so far */
  PetscLogDouble first, newest;      /* wall times of the first and the newest of them [s] */
  PetscReal first_time, newest_time; /* in the model [s] */
} SlipFaultProgress;

/* ---- errors of a run; formulas in slipestimate.c, courseestimate.c and slipcheck.c ---- */
typedef struct {
  PetscInt n, size; /* number of nodes, allocated nodes */
  SlipCourseNode *node;
} SlipFaultCourse;

/* Effect of local errors on the timing of a run; [2]: signed, and in magnitude */
typedef struct {
  PetscReal excess[2];    /* kinetic energy at equal slip, propagated to now [J/m^2] */
  PetscReal vigour;       /* sum of M v^2 at the end of the last step [J/m^2] */
  PetscReal early[2];     /* by how much the run is ahead [s] */
  PetscReal rate;         /* largest sum of slip rates so far [m/s] */
  PetscReal shift[2];     /* early at that time [s] */
  PetscReal acceleration; /* mean, at the end of the last step [m/s^2] */
  PetscReal bend;         /* largest error of a cubic inside a step [m] */
} SlipFaultTiming;

/* In the order of SlipMeasures */
typedef enum { ESTIMATE_HISTORY, ESTIMATE_FINAL, ESTIMATE_TIME, NUM_ESTIMATES } SlipFaultEstimate;

/* estimatefile.c: factors from estimates to errors, from a file; formulas in slipestimate.c */
enum { CALIBRATION_MOST = 32 };
typedef struct {
  PetscInt n; /* classes of accepted steps, 0: the file has none */
  struct {
    PetscReal steps; /* upper bound; infinite in the last class */
    PetscReal factor[NUM_ESTIMATES];
  } row[CALIBRATION_MOST];
} SlipFaultFactors;
typedef struct {
  PetscInt least;               /* fewest accepted steps with an estimate */
  PetscReal floor, late;        /* of the final slip */
  PetscReal shift_floor;        /* of the time of the event */
  PetscReal history_final;      /* fraction of the final slip's error in that of the history */
  SlipFaultFactors of_all;      /* for runs without a table of their own */
  SlipFaultFactors of_explicit; /* for runs with mostly explicit steps */
} SlipFaultCalibration;
/* Collective. file "": that of the library, or of SLIPSTEP_POLICY_DIR; measure [NUM_ESTIMATES]: names of its columns */
PETSC_EXTERN PetscErrorCode SlipFaultCalibrationRead(MPI_Comm comm, const char prefix[], const char file[],
                                                     const char *const measure[], SlipFaultCalibration *c);

typedef struct {
  PetscObjectId id;        /* of the TS with the monitor */
  PetscBool recorded;      /* the slip history is recorded */
  PetscBool known;         /* every accepted step so far had an error estimate */
  PetscInt explicit_steps; /* accepted steps so far that were explicit */
  PetscReal moving;        /* fraction of slip on cells that still slide, at the end of the last step */
  PetscReal decay;         /* of changes of the energy [1/s] */
  PetscReal work[2];       /* changes of the energy by local errors, propagated to now, and their magnitudes [J/m^2] */
  PetscReal slip[2];       /* final errors of the mean slip, likewise [m] */
  PetscReal sum;           /* of the slip at the end of the last step [m] */
  PetscReal late;          /* part of it from steps in which cells came to rest [m] */
  SlipFaultTiming timing;
  SlipFaultCalibration calibration;
  SlipFaultCourse course; /* the start and the ends of accepted steps */
  /* -fault_check_error */
  SlipFaultCourse fine; /* that of the repetition, with ends of parts of steps */
  Vec start;            /* state of the start */
  PetscReal start_time; /* [s] */
  PetscReal start_step; /* [s] */
  PetscBool off;        /* the repetition itself is not estimated */
} SlipFaultRunError;

/* A run and its observers */
typedef struct _n_SlipFaultRun {
  SlipOutput file;                 /* /run, /steps, /series, and data of observers; NULL: none */
  struct _n_SlipFaultWatch *watch; /* [nwatch] of observers.c */
  PetscInt nwatch;
  PetscBool started;                        /* the observers have got the start of TSSolve() */
  PetscBool idle;                           /* it continues from a checkpoint without a step left: nothing is written */
  PetscInt step;                            /* the last one that observers have got */
  PetscBool complete;                       /* the file has its final name */
  PetscInt entries;                         /* of /fields */
  PetscReal entry_time;                     /* of the newest [s] */
  SlipFaultCatalogue catalogue;             /* borrowed, for SlipFaultGetEvents(); NULL: none */
  SlipProducts before[SLIP_PRODUCTS_USERS]; /* of this process: before the run, before the set-up */
  PetscReal prepared;                       /* cost of the work between them [s] */
  PetscReal time; /* processor time of this process before the run, minus that of earlier processes of the run [s] */
  SlipWorkTotals work;   /* of this process, before the run */
  PetscInt64 traffic[3]; /* of this process with a device, before the run */
  PetscInt events;       /* of the run so far, by the catalogue; -1: not counted */
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

/* Rank 0 prints what the set-up begins with if that takes long: on a terminal, or after a second. */
PETSC_EXTERN PetscErrorCode SlipFaultProgressSetUp(SlipFault fault, const char what[]);
PETSC_EXTERN PetscErrorCode SlipFaultProgressSetUpEnd(SlipFault fault);
PETSC_EXTERN PetscBool SlipFaultProgressDue(PetscBool terminal, PetscReal elapsed, PetscReal since);
PETSC_EXTERN void SlipFaultProgressSee(SlipFaultProgress *p, PetscLogDouble now, PetscReal time, PetscReal rate,
                                       PetscReal bound);
PETSC_EXTERN PetscReal SlipFaultProgressLeft(const SlipFaultProgress *p, PetscBool driven, PetscLogDouble now,
                                             PetscReal time, PetscReal end);

PETSC_INTERN PetscErrorCode SlipFaultViewTimes(SlipFault fault); /* faultview.c */
/* ---- forecast.c ---- */
PETSC_INTERN PetscErrorCode SlipFaultForecastView(SlipFault fault);
PETSC_INTERN PetscErrorCode SlipFaultForecast(SlipFault fault, PetscMPIInt size, PetscBool sums, PetscInt *matrices,
                                              SlipCellsForecast **f);
PETSC_INTERN PetscReal SlipForecastBytes(const SlipCellsForecast *f);     /* of the matrix and of vectors */
PETSC_INTERN PetscReal SlipForecastExchanged(const SlipCellsForecast *f); /* bytes of a product */
PETSC_INTERN PetscReal SlipForecastProduct(const SlipCellsForecast *f);   /* processor time [s] */

/* Observers: one row each in the table of observers.c, with a context that is private to one file */
/* samerun.c: the first part; raises an error if the checkpoint is of another run */
PETSC_INTERN PetscErrorCode SlipFaultVisitRun(SlipFault fault, SlipState state, TS ts);
PETSC_INTERN PetscErrorCode SlipFaultObserversVisit(SlipFault fault, SlipState state); /* a part of a checkpoint */
PETSC_INTERN PetscErrorCode SlipFaultObserversDestroy(SlipFault fault);

/* runfiles.c. Collective: finds the file of an earlier run to continue, FILE.part or FILE; "": there is none, and a
   message says so */
PETSC_INTERN PetscErrorCode SlipFaultFindEarlier(SlipFault fault, const char file[], const char what[], PetscBool say,
                                                 char found[PETSC_MAX_PATH_LEN + 8]);
