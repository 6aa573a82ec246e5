/* What the output of a fault adds to that of any run (slipoutput.h): its mesh and its fields. */
#pragma once
#include <slipstep/private/slipfaultimpl.h>
#include <slipstep/private/slipoutput.h>

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
  SlipOutput run; /* the file, /run, /steps, /series, /result and the summary */
  SlipH5 *file;   /* rank 0: that of run; NULL without a file */
  PetscBool wanted[OUTPUT_NUM_FIELDS];
  PetscInt last_field_step; /* step of the newest entry of /fields */
  Vec w0, r0;               /* state and reaction gathered on rank 0 */
  VecScatter gather_w, gather_r;
};

PETSC_EXTERN PetscErrorCode SlipFaultOutputOpen(SlipFaultOutput out, TS ts); /* collective: the file, empty tables */
PETSC_EXTERN PetscErrorCode SlipFaultOutputMesh(SlipFaultOutput out);        /* collective: per-element parameters */
PETSC_EXTERN PetscErrorCode SlipFaultOutputFields(SlipFaultOutput out, PetscReal time, Vec w, Vec r);
