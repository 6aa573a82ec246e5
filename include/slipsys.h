/* Initialisation, registration and version of the SlipStep library. */
#pragma once
#include <petscts.h>
#include <slipcompat.h>

#define SLIPSTEP_VERSION_MAJOR 0
#define SLIPSTEP_VERSION_MINOR 5
#define SLIPSTEP_VERSION_PATCH 0
#define SLIPSTEP_VERSION                                                                                               \
  PetscStringize(SLIPSTEP_VERSION_MAJOR) "." PetscStringize(SLIPSTEP_VERSION_MINOR) "." PetscStringize(                \
    SLIPSTEP_VERSION_PATCH)

/* Version of the library that a program runs with, which may differ from that of the headers it was compiled with */
PETSC_EXTERN PetscErrorCode SlipStepGetVersion(char version[], size_t len);
PETSC_EXTERN PetscErrorCode SlipStepGetVersionNumber(PetscInt *major, PetscInt *minor, PetscInt *patch);

PETSC_EXTERN PetscErrorCode SlipStepInitializePackage(void);
/* Stages of -log_view: programs push those of set-up and run; the library pushes that of output inside of them. */
PETSC_EXTERN PetscLogStage SLIP_STAGE_SETUP, SLIP_STAGE_RUN, SLIP_STAGE_OUTPUT;

/* Products with stiffness and viscosity, the measure for comparisons of runs; SlipProductsGet() defines what counts. */
typedef struct {
  PetscInt k;     /* with K or Kn, including those inside of products with H */
  PetscInt h;     /* with H */
  PetscInt pc;    /* applications of the preconditioner, each about as costly as a product */
  PetscInt all;   /* with K or H; products formed together count once */
  PetscReal cost; /* of these and all other work: processor time by fixed prices [s] */
} SlipProducts;
PETSC_EXTERN PetscErrorCode SlipProductsGet(SlipProducts *products);

/* Function that PETSc calls for -dll_prepend libslipstep.so */
PETSC_EXTERN PetscErrorCode PetscDLLibraryRegister_slipstep(void);

/* Programs: calls PetscInitialize() and SlipErrorHandlerPush(), and handles -version and a -help with only our options.
   */
PETSC_EXTERN PetscErrorCode SlipProgramInitialize(int *argc, char ***argv, const char program[], const char help[]);
/* Programs: errors end with one line on stderr ("program: error: message") unless -slip_traceback is given. */
PETSC_EXTERN PetscErrorCode SlipErrorHandlerPush(const char program[]);
/* Exit code of a program whose run ended early without an error; 1 means an error, and 128 and more a signal. */
#define SLIP_EXIT_INCOMPLETE 3
/* Raises errors, before TSSetFromOptions(), for values that PETSc would refuse without naming the option. */
PETSC_EXTERN PetscErrorCode SlipCheckSolverOptions(TS ts);
PETSC_EXTERN PetscErrorCode SlipCheckFiniteOption(MPI_Comm comm, const char option[]);
/* Prints a warning if a number looks as if it were in another unit. */
PETSC_EXTERN PetscErrorCode SlipWarnOfUnit(const char what[], PetscReal value, const char unit[], PetscReal least,
                                           PetscReal most, const char small[], const char large[]);
/* Converts 90s, 10min, 12h, 20d, 100y in options that are times to seconds. */
PETSC_EXTERN PetscErrorCode SlipDeclareTimes(const char names[]);
PETSC_EXTERN PetscErrorCode SlipExpandTimes(PetscOptions options);
/* Programs: declares the names, separated by blanks, of their own options with a prefix (without dashes; "word*" for
   all that begin so). */
PETSC_EXTERN PetscErrorCode SlipDeclareOptions(const char prefix[], const char names[]);
/* Programs, at the start: an unknown option with one of our prefixes, or a word that belongs to no option, is an
   error. */
PETSC_EXTERN PetscErrorCode SlipCheckOptionNames(void);
PETSC_EXTERN PetscErrorCode SlipCheckOptionWords(PetscInt n, const char *const words[], const char where[]);
PETSC_EXTERN PetscErrorCode SlipCheckOwnOptions(MPI_Comm comm, PetscOptions options, const char prefix[]);
/* Programs, before the solve: warns of unused options, and raises an error for one that resembles a known option. */
PETSC_EXTERN PetscErrorCode SlipCheckUnusedOptions(void);
/* Prints a warning for each unused option, which is most often mistyped. */
PETSC_EXTERN PetscErrorCode SlipWarnOfUnusedOptions(void);
PETSC_EXTERN PetscErrorCode SlipWarningsKeep(PetscBool keep, PetscBool say);
/* Raises an error on every rank if rank 0 failed in what it did alone. */
PETSC_EXTERN PetscErrorCode SlipErrorBcast(MPI_Comm comm, PetscErrorCode code);
/* Programs: SIGTERM, SIGINT, SIGUSR1 and SIGXCPU end the run after the current step; a second one ends it at once. */
PETSC_EXTERN PetscErrorCode SlipSignalsPush(void);
PETSC_EXTERN PetscErrorCode SlipSignalsPop(void);

/* Data that a run needs from one step to the next, in a checkpoint that is written or read. Each object visits its data
   by the same calls in both directions, which write the data or replace them by what was written. Collective; numbers
   are the same on all ranks, and names are unique within a group of the object. */
typedef struct _n_SlipState *SlipState;
PETSC_EXTERN PetscBool SlipStateIsLoading(SlipState state);
PETSC_EXTERN PetscErrorCode SlipStateReal(SlipState state, const char name[], PetscInt n, PetscReal x[]);
PETSC_EXTERN PetscErrorCode SlipStateInt(SlipState state, const char name[], PetscInt n, PetscInt x[]);
PETSC_EXTERN PetscErrorCode SlipStateBool(SlipState state, const char name[], PetscBool *x);
PETSC_EXTERN PetscErrorCode SlipStateVec(SlipState state, const char name[], Vec x);
