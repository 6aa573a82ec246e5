/* The output of a run: growing tables in memory that are appended in blocks, and the numbers of its end. */
#pragma once
#include <slipoutput.h>
#include <sliph5.h>
#include <slipts.h>
#include <slipstep/private/slipclock.h>
#include <slipstep/private/slipsys.h>

/* A group of series with one row per event, kept until SLIP_TABLE_ROWS rows are there, of wide ones so many that they
   have these numbers. */
#define SLIP_TABLE_ROWS 256
#define SLIP_TABLE_NUMBERS 262144
#define SLIP_TABLE_COLUMNS 40
#define SLIP_TABLE_TIMES 3
#define SLIP_TABLE_ALL (SLIP_TABLE_COLUMNS + SLIP_TABLE_TIMES)
typedef struct {
  char group[64];
  /* Before SlipTableCreate(): columns whose numbers in rows are times of the TS with this clock, borrowed; the file has
     times of the run, and of long runs for each of these columns another one, X_rest, of what their double leaves */
  const SlipClock *clock; /* NULL: there are none */
  const PetscInt *times;
  PetscInt ntimes;
  PetscInt wide[SLIP_TABLE_COLUMNS]; /* fixed dimensions of a column */
  PetscBool rests;                   /* there are such columns, behind the others */
  SlipOutputColumn column[SLIP_TABLE_ALL];
  char rest[SLIP_TABLE_TIMES][32]; /* names of those */
  PetscInt ncolumns, nrows;
  PetscInt entries[SLIP_TABLE_ALL]; /* numbers of a column in a row */
  PetscInt first[SLIP_TABLE_ALL];   /* of them, in a row */
  PetscInt written;                 /* rows in the file */
  PetscInt room;                    /* rows that are kept */
  PetscReal *value;                 /* of so many rows, one column after the other */
} SlipTable;

/* entries [ncolumns], or NULL: a row has so many numbers in a column, whose dataset is [n, entries]; 0: one, and [n];
   -m: m vectors of 3, and [n, m, 3]. rows >= 0: the table is there, and is cut to so many */
PETSC_INTERN PetscErrorCode SlipTableCreate(SlipTable *t, SlipH5 *h, const char group[], PetscInt ncolumns,
                                            const SlipOutputColumn column[], const PetscInt entries[], PetscInt rows);
/* *has: a series X_rest belongs to those of a file, as the run is long, or as it is there already; made unless it is.
   wide, dims: of SlipH5CreateSeries(); rows: as above. A run that has become long has zeros in its rows of before. */
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
  PetscBool implicit;                                             /* what follows rejected is there */
  PetscInt accepted, rejected, solves, explicits, newton, linear; /* explicits: attempts */
  PetscReal wall_setup, wall_solve;                               /* [s] */
} SlipOutputTotals;

/* By this name the TS knows its output */
#define SLIP_OUTPUT_KEY "SlipOutput"

/* attempts.c: attempts of integrators other than TSBATHE */
typedef struct {
  SlipAttempt last;        /* the newest */
  PetscBool judged;        /* it was accepted, and its row is to be written */
  PetscReal time, origin;  /* at the end of the last step, and what it counts from [s] */
  PetscInt newton, linear; /* of the TS, at the last row */
  PetscInt sides;          /* right-hand sides, likewise */
  SlipProducts cost;       /* likewise */
  PetscLogDouble begin;    /* when that was, or when the step began [s] */
} SlipOutputAttempts;

struct _n_SlipOutput {
  TS ts;                  /* borrowed */
  const SlipClock *clock; /* of ts */
  PetscContainer box;     /* by which ts knows this output */
  MPI_Comm comm;
  PetscMPIInt rank;
  PetscBool wanted, begun; /* there is to be a file; it is there */
  char name[PETSC_MAX_PATH_LEN], prefix[SLIP_OUTPUT_NAME], option[SLIP_OUTPUT_NAME], restart[SLIP_OUTPUT_NAME];
  SlipH5Kind kind;                                         /* with those strings */
  PetscErrorCode (*layout)(SlipOutput output, void *ctx);  /* collective: what the problem adds to a new file */
  PetscErrorCode (*flushed)(SlipOutput output, void *ctx); /* rank 0, or NULL: what is done when the file was flushed */
  void *flushed_ctx;
  PetscErrorCode (*sides)(void *ctx, PetscInt *n); /* right-hand sides of a problem that counts them, or NULL */
  PetscBool moving_only;                           /* the rows of series use the reaction only where something moves */
  PetscBool resumed;                               /* the file is that of an earlier run, cut to these rows */
  PetscInt resume_steps, resume_series;
  PetscBool start_known;                       /* and it has rows, so the start of the run */
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
  PetscBool started; /* TSSolve() has begun, and its last step is */
  PetscInt last_step;
  PetscBool policy_known; /* /run names the policy */
  PetscBool closed;       /* the run is over: rows are taken no more, and totals are its counts */
  SlipOutputTotals totals;
  PetscInt nresults, nrun;
  SlipOutputNumber result[SLIP_OUTPUT_NUMBERS], run[SLIP_OUTPUT_NUMBERS];
};

/* The run is over, whatever the TS does before SlipOutputFinish(): no further rows, and its counts as they are now. */
PETSC_INTERN PetscErrorCode SlipOutputClose(SlipOutput output);
/* Collective: make the file unless it is there, at the start of TSSolve(). */
PETSC_INTERN PetscErrorCode SlipOutputBegin(SlipOutput output);
/* For problems that write more than series: the file, to be used on rank 0 alone; NULL when there is none or
   elsewhere. */
PETSC_INTERN SlipH5 *SlipOutputFile(SlipOutput output);
/* Rank 0: all rows to the file; a row, and what was collected to disk from time to time */
PETSC_INTERN PetscErrorCode SlipOutputFlush(SlipOutput output);
PETSC_INTERN PetscErrorCode SlipOutputRow(SlipOutput output, SlipTable *table, const PetscReal row[]);
/* attempts.c. Start: for a TS, once; Step: when a step has ended, or TSSolve() begins */
PETSC_INTERN PetscErrorCode SlipOutputAttemptsStart(TS ts);
PETSC_INTERN PetscErrorCode SlipOutputAttemptsStep(SlipOutput output, PetscInt step, PetscReal time);
/* Rank 0: attributes of /run that are known at the start, and the end of the file */
PETSC_INTERN PetscErrorCode SlipOutputRun(SlipOutput output);
PETSC_INTERN PetscErrorCode SlipOutputPolicy(SlipOutput output);
PETSC_INTERN PetscErrorCode SlipOutputWall(SlipOutput output);
PETSC_INTERN PetscErrorCode SlipOutputFinishFile(SlipOutput output, const SlipOutputTotals *totals);
