/* The output of a run: growing tables in memory that are appended to the file in blocks, and the results at its end */
#pragma once
#include <slipstep/rooms/slipoutput.h>
#include <slipstep/rooms/sliph5.h>
#include <slipstep/rooms/slipts.h>
#include <slipstep/private/slipclock.h>
#include <slipstep/private/slipsys.h>

/* A group of series with one row per event, stored until there are SLIP_TABLE_ROWS rows, or SLIP_TABLE_NUMBERS numbers
   if rows are long */
#define SLIP_TABLE_ROWS 256
#define SLIP_TABLE_NUMBERS 262144
#define SLIP_TABLE_COLUMNS 40
#define SLIP_TABLE_TIMES 3
#define SLIP_TABLE_ALL (SLIP_TABLE_COLUMNS + SLIP_TABLE_TIMES)
typedef struct {
  char group[64];
  /* Before SlipTableCreate(): columns of times of the TS with this clock, borrowed. The file has times of the run and,
     for long runs, another column X_rest for each of them, with what exceeds the precision of a double. */
  const SlipClock *clock; /* NULL: there are none */
  const PetscInt *times;
  PetscInt ntimes;
  PetscInt wide[SLIP_TABLE_COLUMNS]; /* fixed dimensions of a column */
  PetscBool rests;                   /* there are such columns, after all others */
  SlipOutputColumn column[SLIP_TABLE_ALL];
  char rest[SLIP_TABLE_TIMES][32]; /* names of those */
  PetscInt ncolumns, nrows;
  PetscInt entries[SLIP_TABLE_ALL]; /* numbers of a column in a row */
  PetscInt first[SLIP_TABLE_ALL];   /* index of the first of them in a row */
  PetscInt written;                 /* rows in the file */
  PetscInt room;                    /* rows in memory */
  PetscReal *value;                 /* numbers of these rows, one column after the other */
} SlipTable;

/* entries [ncolumns], or NULL: numbers of a column in a row, whose dataset is [n, entries]; 0: one, and [n]; -m: m
   vectors of 3, and [n, m, 3]. rows >= 0: the table exists, and is truncated to so many */
PETSC_INTERN PetscErrorCode SlipTableCreate(SlipTable *t, SlipH5 *h, const char group[], PetscInt ncolumns,
                                            const SlipOutputColumn column[], const PetscInt entries[], PetscInt rows);
/* *has: the file needs a series X_rest, because the run is long or the series exists; it is created if necessary. wide,
   dims: see SlipH5CreateSeries(); rows: see above. Rows from before the run became long are zero. */
PETSC_INTERN PetscErrorCode SlipTableRest(const SlipClock *clock, SlipH5 *h, const char path[], PetscInt wide,
                                          const PetscInt dims[], PetscInt rows, PetscBool *has);
PETSC_INTERN PetscErrorCode SlipTableAdd(SlipTable *t, SlipH5 *h, const PetscReal row[]);
PETSC_INTERN PetscErrorCode SlipTableFlush(SlipTable *t, SlipH5 *h);
PETSC_INTERN PetscErrorCode SlipTableDestroy(SlipTable *t);

#define SLIP_OUTPUT_NUMBERS 48
#define SLIP_OUTPUT_NAME 64
typedef struct {
  char name[SLIP_OUTPUT_NAME], label[SLIP_OUTPUT_NAME], unit[2 * SLIP_OUTPUT_NAME];
  PetscReal value;
} SlipOutputNumber;

typedef struct {
  PetscBool implicit;                                             /* the members after rejected are set */
  PetscInt accepted, rejected, solves, explicits, newton, linear; /* explicits: attempts */
  PetscReal wall_setup, wall_solve;                               /* [s] */
} SlipOutputTotals;

/* The name by which the TS stores its output */
#define SLIP_OUTPUT_KEY "SlipOutput"

/* attempts.c: attempts of integrators other than TSBATHE */
typedef struct {
  SlipAttempt last;        /* the newest */
  PetscBool judged;        /* it was accepted, and its row is to be written */
  PetscReal time, origin;  /* at the end of the last step, and the origin [s] */
  PetscInt newton, linear; /* of the TS, at the last row */
  PetscInt sides;          /* right-hand sides, likewise */
  SlipProducts cost;       /* likewise */
  PetscLogDouble begin;    /* time of that, or of the start of the step [s] */
} SlipOutputAttempts;

struct _n_SlipOutput {
  TS ts;                  /* borrowed */
  const SlipClock *clock; /* of ts */
  PetscContainer box;     /* attaches this output to ts */
  MPI_Comm comm;
  PetscMPIInt rank;
  PetscBool wanted, begun; /* there will be a file; it exists */
  char name[PETSC_MAX_PATH_LEN], prefix[SLIP_OUTPUT_NAME], option[SLIP_OUTPUT_NAME], restart[SLIP_OUTPUT_NAME];
  SlipH5Kind kind;                                         /* with those strings */
  PetscErrorCode (*layout)(SlipOutput output, void *ctx);  /* collective: adds data of the problem to a new file */
  PetscErrorCode (*flushed)(SlipOutput output, void *ctx); /* rank 0, or NULL: called after each flush */
  void *flushed_ctx;
  PetscErrorCode (*sides)(void *ctx, PetscInt *n); /* counts right-hand sides of a problem, or NULL */
  PetscBool moving_only;                           /* rows of series use the reaction only if a cell moves */
  PetscBool resumed;                               /* the file is that of an earlier run, truncated to these rows */
  PetscInt resume_steps, resume_series;
  PetscBool start_known;                       /* and it has rows, including the start of the run */
  Vec reaction;                                /* of SlipOutputReaction() */
  PetscLogDouble begin;                        /* when the output was created */
  PetscReal wall, setup_before, solve_before;  /* of earlier runs that this one continues [s] */
  SlipOutputColumn column[SLIP_TABLE_COLUMNS]; /* of series */
  PetscInt entries[SLIP_TABLE_COLUMNS];        /* of theirs, see SlipTableCreate() */
  PetscInt ncolumns;
  PetscReal *numbers; /* a row of series */
  SlipH5 file;        /* rank 0 */
  SlipTable steps, series;
  SlipOutputAttempts attempts;
  PetscInt nmore;
  SlipTable *more; /* of SlipOutputAddTable(), with as many rows as series */
  SlipOutputRowFn row;
  void *ctx;
  PetscBool started; /* TSSolve() has begun, and its last step */
  PetscInt last_step;
  PetscBool policy_known; /* /run names the policy */
  PetscBool closed;       /* the run has ended: no rows are added, and totals are its counts */
  SlipOutputTotals totals;
  PetscInt nresults, nrun;
  SlipOutputNumber result[SLIP_OUTPUT_NUMBERS], run[SLIP_OUTPUT_NUMBERS];
};

/* Ends the run, whatever the TS does before SlipOutputFinish(): there are no further rows, and its counts are final. */
PETSC_INTERN PetscErrorCode SlipOutputClose(SlipOutput output);
/* Collective: creates the file unless it exists, at the start of TSSolve(). */
PETSC_INTERN PetscErrorCode SlipOutputBegin(SlipOutput output);
/* For problems that write more than series: gets the file on rank 0; NULL elsewhere, or if there is none. */
PETSC_INTERN SlipH5 *SlipOutputFile(SlipOutput output);
/* Rank 0: writes all rows to the file; adds a row, and writes collected rows to disk from time to time. */
PETSC_INTERN PetscErrorCode SlipOutputFlush(SlipOutput output);
PETSC_INTERN PetscErrorCode SlipOutputRow(SlipOutput output, SlipTable *table, const PetscReal row[]);
/* attempts.c. Start: called once for a TS; Step: called when a step has ended, or TSSolve() begins */
PETSC_INTERN PetscErrorCode SlipOutputAttemptsStart(TS ts);
PETSC_INTERN PetscErrorCode SlipOutputAttemptsStep(SlipOutput output, PetscInt step, PetscReal time);
/* Rank 0: writes the end of the file. */
PETSC_INTERN PetscErrorCode SlipOutputFinishFile(SlipOutput output, const SlipOutputTotals *totals);
