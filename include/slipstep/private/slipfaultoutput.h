/* The output file of a run: tables of its columns, and growing tables in memory that are appended in blocks. */
#pragma once
#include <slipstep/private/slipfaultimpl.h>

/* A group of series with one row per event, kept until SLIP_TABLE_ROWS rows are there. */
#define SLIP_TABLE_ROWS 64
#define SLIP_TABLE_COLUMNS 16
typedef struct {
  const char *name;
  const char *unit;
  PetscBool integer;
} SlipColumn;

typedef struct {
  const char *group;
  const SlipColumn *column;
  PetscInt ncolumns, nrows;
  PetscReal row[SLIP_TABLE_ROWS][SLIP_TABLE_COLUMNS];
} SlipTable;

PETSC_EXTERN PetscErrorCode SlipTableCreate(SlipTable *t, SlipH5 *h, const char group[], PetscInt ncolumns,
                                            const SlipColumn column[]);
PETSC_EXTERN PetscErrorCode SlipTableAdd(SlipTable *t, SlipH5 *h, const PetscReal row[]);
PETSC_EXTERN PetscErrorCode SlipTableFlush(SlipTable *t, SlipH5 *h);

/* Fields of /fields; the first three are components of the state, the last is the reaction. */
typedef enum {
  OUTPUT_SLIP_RATE,
  OUTPUT_DISPLACEMENT,
  OUTPUT_SLIP,
  OUTPUT_TRACTION,
  OUTPUT_NUM_FIELDS
} SlipOutputFieldId;

struct _n_SlipFaultOutput {
  SlipFault fault; /* borrowed */
  PetscMPIInt rank;
  SlipH5 file; /* rank 0 */
  SlipTable steps, series;
  PetscBool wanted[OUTPUT_NUM_FIELDS];
  PetscInt last_field_step; /* step of the newest entry of /fields */
  PetscLogDouble last_flush;
  Vec w0, r0; /* state and reaction gathered on rank 0 */
  VecScatter gather_w, gather_r;
};

PETSC_EXTERN PetscErrorCode SlipFaultOutputOpen(SlipFaultOutput out); /* rank 0: the file, /mesh, empty tables */
PETSC_EXTERN PetscErrorCode SlipFaultOutputMesh(SlipFaultOutput out); /* collective: per-element parameters */
PETSC_EXTERN PetscErrorCode SlipFaultOutputFields(SlipFaultOutput out, PetscReal time, Vec w, Vec r);
