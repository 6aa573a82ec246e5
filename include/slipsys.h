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

/* Of the library that a program runs with, which need not be the one whose headers it was compiled against. */
PETSC_EXTERN PetscErrorCode SlipStepGetVersion(char version[], size_t len);
PETSC_EXTERN PetscErrorCode SlipStepGetVersionNumber(PetscInt *major, PetscInt *minor, PetscInt *patch);

PETSC_EXTERN PetscErrorCode SlipStepInitializePackage(void);
/* Stages of -log_view: programs push those of set-up and run, the library that of output inside them. */
PETSC_EXTERN PetscLogStage SLIP_STAGE_SETUP, SLIP_STAGE_RUN, SLIP_STAGE_OUTPUT;

/* Products with stiffness and viscosity, by which runs are compared; SlipProductsGet() says what counts. */
typedef struct {
  PetscInt k;     /* with K or Kn, those inside of products with H included */
  PetscInt h;     /* with H */
  PetscInt pc;    /* applications of the preconditioner that cost about as much as a product */
  PetscInt all;   /* with K or H, those that are formed at once counted once */
  PetscReal cost; /* of these and of all else that was done: processor time by fixed prices [s] */
} SlipProducts;
PETSC_EXTERN PetscErrorCode SlipProductsGet(SlipProducts *products);

/* Entry point that PETSc calls for -dll_prepend libslipstep.so */
PETSC_EXTERN PetscErrorCode PetscDLLibraryRegister_slipstep(void);

/* Programs: PetscInitialize() with SlipErrorHandlerPush(), -version, and -help of our options alone. */
PETSC_EXTERN PetscErrorCode SlipProgramInitialize(int *argc, char ***argv, const char program[], const char help[]);
/* Programs: errors end with one line on stderr ("program: error: message") unless -slip_traceback is given. */
PETSC_EXTERN PetscErrorCode SlipErrorHandlerPush(const char program[]);
/* Exit code of a program whose run has not reached its end, without an error; beside it 1 is an error, and 128 and more
   a signal. */
#define SLIP_EXIT_INCOMPLETE 3
/* Before TSSetFromOptions(): what PETSc would refuse without naming the option. */
PETSC_EXTERN PetscErrorCode SlipCheckSolverOptions(TS ts);
PETSC_EXTERN PetscErrorCode SlipCheckNumberOption(MPI_Comm comm, PetscOptions options, const char prefix[],
                                                  const char option[], PetscBool whole, PetscBool *set,
                                                  PetscReal *value);
PETSC_EXTERN PetscErrorCode SlipCheckFiniteOption(MPI_Comm comm, const char option[]);
PETSC_EXTERN PetscErrorCode SlipCheckBoolOption(MPI_Comm comm, PetscOptions options, const char prefix[],
                                                const char option[]);
/* Integers that PetscInt does not hold, which PETSc reads as what is left of them */
PETSC_EXTERN PetscErrorCode SlipCheckInteger(MPI_Comm comm, const char name[], const char text[]);
PETSC_EXTERN PetscErrorCode SlipCheckIntegerOption(MPI_Comm comm, PetscOptions options, const char prefix[],
                                                   const char option[]);
PETSC_EXTERN PetscErrorCode SlipCheckIntegers(MPI_Comm comm, PetscOptions options);
/* A warning where a number looks as if it were in another unit */
PETSC_EXTERN PetscErrorCode SlipWarnOfUnit(const char what[], PetscReal value, const char unit[], PetscReal least,
                                           PetscReal most, const char small[], const char large[]);
/* 90s, 10min, 12h, 20d, 100y in options that are times become seconds. */
PETSC_EXTERN PetscErrorCode SlipDeclareTimes(const char names[]);
PETSC_EXTERN PetscErrorCode SlipExpandTimes(PetscOptions options);
PETSC_EXTERN PetscErrorCode SlipCheckLinearOptions(MPI_Comm comm, PetscOptions options, const char prefix[]);
/* Programs: the names, with blanks between, of the options with a prefix that is theirs (without dashes; "word*" for
   all that begin so). */
PETSC_EXTERN PetscErrorCode SlipDeclareOptions(const char prefix[], const char names[]);
/* Programs, first of all: an option with a prefix of ours that is not known, or a word that is no option's, ends
   them. */
PETSC_EXTERN PetscErrorCode SlipCheckOptionNames(void);
PETSC_EXTERN PetscErrorCode SlipCheckOptionWords(PetscInt n, const char *const words[], const char where[]);
PETSC_EXTERN PetscErrorCode SlipCheckOwnOptions(MPI_Comm comm, PetscOptions options, const char prefix[]);
/* Programs, before the solve: a warning for each option that nothing has read, an error for one that is nearly
   known. */
PETSC_EXTERN PetscErrorCode SlipCheckUnusedOptions(void);
/* A warning for each option that nothing has read: most often they are mistyped. */
PETSC_EXTERN PetscErrorCode SlipWarnOfUnusedOptions(void);
/* One line on stderr, "program: warning: ...", from the process that calls it. */
PETSC_EXTERN PetscErrorCode SlipWarning(const char format[], ...);
PETSC_EXTERN PetscErrorCode SlipWarningsTake(char **text);
PETSC_EXTERN PetscErrorCode SlipWarningsKeep(PetscBool keep, PetscBool say);
/* What rank 0 did alone failed there: fail on every rank. */
PETSC_EXTERN PetscErrorCode SlipErrorBcast(MPI_Comm comm, PetscErrorCode code);
/* Programs: SIGTERM, SIGINT, SIGUSR1 and SIGXCPU ask for the end of the run after the step in work, a second one ends
   it at once. */
PETSC_EXTERN PetscErrorCode SlipSignalsPush(void);
PETSC_EXTERN PetscErrorCode SlipSignalsPop(void);
PETSC_EXTERN PetscErrorCode SlipSignalsCaught(int *number); /* 0: none */

/* What a run remembers from one step to the next, in a checkpoint that is written or read. Who remembers something
   visits it by the same calls in both directions: they write it, or put what was written in its place. Collective;
   numbers are the same on all ranks, names are those of a group of the object's own. */
typedef struct _n_SlipState *SlipState;
PETSC_EXTERN PetscBool SlipStateIsLoading(SlipState state);
PETSC_EXTERN PetscErrorCode SlipStateReal(SlipState state, const char name[], PetscInt n, PetscReal x[]);
PETSC_EXTERN PetscErrorCode SlipStateInt(SlipState state, const char name[], PetscInt n, PetscInt x[]);
PETSC_EXTERN PetscErrorCode SlipStateBool(SlipState state, const char name[], PetscBool *x);
PETSC_EXTERN PetscErrorCode SlipStateVec(SlipState state, const char name[], Vec x);
