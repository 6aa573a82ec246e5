/* What the files of all trainings share: errors that name an option, numbers in a policy, checks of a checkpoint that
   is resumed, learning curves. */
#pragma once
#include <slipstep/rooms.h>
#include <slipstep/rooms/sliph5.h>
#include <slipcompat.h>

/* For PetscPushErrorHandler(): no word on stderr, the first message goes to ctx, char[ERROR_TEXT] */
#define ERROR_TEXT 512
PETSC_INTERN PetscErrorCode ErrorCapture(MPI_Comm comm, int line, const char *function, const char *file,
                                         PetscErrorCode code, PetscErrorType type, const char *message, void *ctx);
PETSC_INTERN PetscErrorCode ErrorOfFile(PetscErrorCode code, const char option[], const char message[]);
/* A call that uses the file of an option: its error names the option as well. */
#define PetscCallFile(option, call)                                                                                    \
  do {                                                                                                                 \
    char text_[ERROR_TEXT] = "";                                                                                       \
    PetscErrorCode code_;                                                                                              \
                                                                                                                       \
    PetscCall(PetscPushErrorHandler(ErrorCapture, text_));                                                             \
    code_ = (call);                                                                                                    \
    PetscCall(PetscPopErrorHandler());                                                                                 \
    PetscCall(ErrorOfFile(code_, option, text_));                                                                      \
  } while (0)

/* -train_output, -train_log, -train_checkpoint and -train_resume, [PETSC_MAX_PATH_LEN] each; text: help of the third */
PETSC_INTERN PetscErrorCode TrainSetFiles(SlipOptionItems PetscOptionsObject, const char text[], char output[],
                                          char log[], char checkpoint[], char resume[]);
/* The learning curve grows: how it is opened; -train_log_overwrite is looked up */
PETSC_INTERN PetscErrorCode CurveKind(SlipH5Kind *kind);
/* Of -train_output, -train_log and -train_checkpoint, which may be empty: three files, not fewer, that rank 0 can
   write. Collective. */
PETSC_INTERN PetscErrorCode TrainCheckFiles(MPI_Comm comm, const char output[], const char log[],
                                            const char checkpoint[]);

PETSC_INTERN PetscErrorCode PolicySetNumber(SlipPolicy p, const char name[], const char format[], double value);

/* One process. kind: of checkpoint, for the message, "" or " of ..." */
PETSC_INTERN PetscErrorCode CheckpointCheckFormat(SlipH5 *h, const char format[], const char kind[]);
PETSC_INTERN PetscErrorCode CheckpointCheckObservations(SlipH5 *h, PetscInt n, char *const names[]);
PETSC_INTERN PetscErrorCode CheckpointReadFixed(SlipH5 *h, const char path[], PetscInt n, PetscReal **data);
/* Likewise, into float or double out[n] that is there, as size says */
PETSC_INTERN PetscErrorCode CheckpointReadArray(SlipH5 *h, const char path[], PetscInt n, size_t size, void *out);

/* A learning curve: one dataset a column, one row at a time. SlipH5Live() when all is created. */
#define CURVE_COLUMNS 16
typedef struct {
  const char *path, *units;
} CurveColumn;
PETSC_INTERN PetscErrorCode CurveCreate(SlipH5 *h, PetscInt n, const CurveColumn column[]);
PETSC_INTERN PetscErrorCode CurveAppend(SlipH5 *h, PetscInt n, const CurveColumn column[], const PetscReal row[]);
