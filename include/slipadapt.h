/* Step-size controllers (TSAdapt types) and the table of observations. */
#pragma once
#include <petscts.h>
#include <slippolicy.h>
#include <slipts.h>

#define TSADAPTRL "rl"
#define TSADAPTHEURISTIC "heuristic"
#define TSADAPTLAPUSTA "lapusta"
#define TSADAPTPI "pi"

PETSC_EXTERN PetscErrorCode SlipAdaptInitializePackage(void); /* called by what creates objects; again does nothing */
PETSC_EXTERN PetscErrorCode SlipAdaptSetNorm(TSAdapt adapt, NormType type);
PETSC_EXTERN PetscErrorCode TSAdaptPISetFilter(TSAdapt adapt, const char name[]);
/* A type, and after a colon its named filter: "pi:fault_history" */
PETSC_EXTERN PetscErrorCode SlipAdaptSetController(TSAdapt adapt, const char name[]);
PETSC_EXTERN PetscErrorCode SlipAdaptGetController(TSAdapt adapt, char name[], size_t len);
PETSC_EXTERN PetscErrorCode TSAdaptRLSetPolicy(TSAdapt adapt, SlipPolicy policy);
PETSC_EXTERN PetscErrorCode TSAdaptRLSetPolicyFile(TSAdapt adapt, const char file[]);
PETSC_EXTERN PetscErrorCode TSAdaptRLGetPolicy(TSAdapt adapt, SlipPolicy *policy);

/* The accuracy dial: the relative error of the run that the user wants, in the bounds below. */
#define TSADAPTRL_ACCURACY_MIN 1e-4
#define TSADAPTRL_ACCURACY_MAX 1e-1
#define TSADAPTRL_ACCURACY_DEFAULT 1e-2
PETSC_EXTERN PetscErrorCode TSAdaptRLSetAccuracy(TSAdapt adapt, PetscReal accuracy);
PETSC_EXTERN PetscErrorCode TSAdaptRLSetDefaultAccuracy(TSAdapt adapt, PetscReal accuracy);
PETSC_EXTERN PetscErrorCode TSAdaptRLIsChosen(TSAdapt adapt, PetscBool *chosen);
PETSC_EXTERN PetscErrorCode TSAdaptRLHasActor(TSAdapt adapt, PetscBool *has);
PETSC_EXTERN PetscErrorCode TSAdaptRLGetAccuracy(TSAdapt adapt, PetscReal *accuracy);
/* Which error that is: "history", the largest of all; "final_slip"; "event_time". */
PETSC_EXTERN PetscErrorCode TSAdaptRLSetMeasure(TSAdapt adapt, const char measure[]);
PETSC_EXTERN PetscErrorCode TSAdaptRLGetMeasure(TSAdapt adapt, const char *measure[]);

/* How often the policy chose, how often outside of its training range, failed attempts, steps halved. */
PETSC_EXTERN PetscErrorCode TSAdaptRLGetCounts(TSAdapt adapt, PetscInt *decisions, PetscInt *outside,
                                               PetscInt *failures, PetscInt *halvings);

/* Runs unlike those of the training go on by the classical controller of their problem, unless strict. */
PETSC_EXTERN PetscErrorCode TSAdaptRLSetStrict(TSAdapt adapt, PetscBool strict);
PETSC_EXTERN PetscErrorCode TSAdaptRLGetHandover(TSAdapt adapt, PetscBool *handed, PetscReal *time);
PETSC_EXTERN PetscErrorCode TSAdaptRLGetHandoverStep(TSAdapt adapt, PetscInt *steps);
PETSC_EXTERN PetscErrorCode TSAdaptRLGetFallback(TSAdapt adapt, TSAdaptType *type);

/* A trainer sits where the policy would: called once before the first step (last == NULL) and once after every attempt,
   with the observation vector named in names; returns the next step [s]. guarded is true when a guard rail will
   override its choice. */
typedef PetscErrorCode (*TSAdaptRLActorFn)(TSAdapt adapt, TS ts, PetscInt n, const PetscReal obs[],
                                           const SlipAttempt *last, PetscBool guarded, PetscReal *h, void *ctx);
PETSC_EXTERN PetscErrorCode TSAdaptRLSetActor(TSAdapt adapt, PetscInt n, const char *const names[], PetscReal dt_min,
                                              PetscReal dt_max, TSAdaptRLActorFn fn, void *ctx);

/* The table of observations: one row each. A problem supplies its own by TSSetSlipProblem(). */
PETSC_EXTERN PetscErrorCode SlipObservationView(PetscViewer viewer); /* prints the table: name and meaning */
