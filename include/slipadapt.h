/* Step-size controllers (TSAdapt types) and the table of observations. */
#pragma once
#include <petscts.h>
#include <slippolicy.h>
#include <slipts.h>

#define TSADAPTRL "rl"
#define TSADAPTHEURISTIC "heuristic"
#define TSADAPTLAPUSTA "lapusta"
#define TSADAPTPI "pi"

PETSC_EXTERN PetscErrorCode TSAdaptPISetFilter(TSAdapt adapt, const char name[]);
/* The name is a type, and after a colon one of its filters: "pi:fault_history". */
PETSC_EXTERN PetscErrorCode SlipAdaptSetController(TSAdapt adapt, const char name[]);
PETSC_EXTERN PetscErrorCode SlipAdaptGetController(TSAdapt adapt, char name[], size_t len);
PETSC_EXTERN PetscErrorCode TSAdaptRLSetPolicy(TSAdapt adapt, SlipPolicy policy);
PETSC_EXTERN PetscErrorCode TSAdaptRLSetPolicyFile(TSAdapt adapt, const char file[]);
PETSC_EXTERN PetscErrorCode TSAdaptRLGetPolicy(TSAdapt adapt, SlipPolicy *policy);

/* The wanted accuracy is the relative error that the run may have, within these bounds. */
#define TSADAPTRL_ACCURACY_MIN 1e-4
#define TSADAPTRL_ACCURACY_MAX 1e-1
#define TSADAPTRL_ACCURACY_DEFAULT 1e-2
PETSC_EXTERN PetscErrorCode TSAdaptRLSetAccuracy(TSAdapt adapt, PetscReal accuracy);
PETSC_EXTERN PetscErrorCode TSAdaptRLGetAccuracy(TSAdapt adapt, PetscReal *accuracy);
/* Which error the accuracy bounds: "history" (the largest of all), "final_slip" or "event_time" */
PETSC_EXTERN PetscErrorCode TSAdaptRLSetMeasure(TSAdapt adapt, const char measure[]);

/* Counts the decisions of the policy, those outside of its training range, failed attempts and halved steps. */
PETSC_EXTERN PetscErrorCode TSAdaptRLGetCounts(TSAdapt adapt, PetscInt *decisions, PetscInt *outside,
                                               PetscInt *failures, PetscInt *halvings);

/* A run unlike those of the training continues with the classical controller of its problem, unless strict is set. */
PETSC_EXTERN PetscErrorCode TSAdaptRLSetStrict(TSAdapt adapt, PetscBool strict);
PETSC_EXTERN PetscErrorCode TSAdaptRLGetHandover(TSAdapt adapt, PetscBool *handed, PetscReal *time);

/* A trainer replaces the policy: called once before the first step (last == NULL) and once after every attempt, with
   the observations that names lists, it returns the next step [s]. guarded is true if a guard rail will override it. */
typedef PetscErrorCode (*TSAdaptRLActorFn)(TSAdapt adapt, TS ts, PetscInt n, const PetscReal obs[],
                                           const SlipAttempt *last, PetscBool guarded, PetscReal *h, void *ctx);
PETSC_EXTERN PetscErrorCode TSAdaptRLSetActor(TSAdapt adapt, PetscInt n, const char *const names[], PetscReal dt_min,
                                              PetscReal dt_max, TSAdaptRLActorFn fn, void *ctx);

/* The table of observations has one row for each; a problem adds rows of its own by TSSetSlipProblem(). */
PETSC_EXTERN PetscErrorCode SlipObservationView(PetscViewer viewer); /* prints the table: name and meaning */
