/* SlipPolicy: a small network that maps an observation to a step size. Its HDF5 file:
     /              attributes: format "slipstep-policy", version 1, and the trainer's notes, text or numbers:
                    algorithm, problem, alpha, training_steps, seed, library_version, created, moving_dt_max (below),
                    ...; and checksum, SlipPolicyGetHash() of all the rest, compared when the file is read (older files
                    have none)
     /observation   names [n] (strings, in the network's order), scale [n], offset [n]
     /layers/0, 1.. weight [out, in], bias [out]; attribute activation: linear, relu, tanh or hardtanh2 (to [-2, 2])
     /action        attributes low, high, squash ("tanh"), dt_min, dt_max, dt_min_unit, dt_max_unit ("s", "T*",
     "t_max"; both "h": times the last attempt's step),
                    spacing ("linear", also when absent, or "log")
     /range         minimum [n], maximum [n] of each observation in training; may be absent */
#pragma once
#include <petscsys.h>

/* A policy; a PETSc object. */
typedef struct _p_SlipPolicy *SlipPolicy;
PETSC_EXTERN PetscClassId SLIP_POLICY_CLASSID;

/* The activation of a layer, in the order of SlipActivations[]; hardtanh2 clips to [-2, 2]. */
typedef enum {
  SLIP_ACTIVATION_LINEAR,
  SLIP_ACTIVATION_RELU,
  SLIP_ACTIVATION_TANH,
  SLIP_ACTIVATION_HARDTANH2
} SlipActivation;
PETSC_EXTERN const char *const SlipActivations[];

PETSC_EXTERN PetscErrorCode SlipPolicyCreate(MPI_Comm comm, SlipPolicy *policy);
PETSC_EXTERN PetscErrorCode SlipPolicyLoad(SlipPolicy policy, const char file[]);
/* Finds the library's policy for a problem ("fault", ...) in SLIPSTEP_POLICY_DIR, the installation or the source. */
PETSC_EXTERN PetscErrorCode SlipPolicyFindDefault(MPI_Comm comm, const char problem[], char file[], size_t len,
                                                  PetscBool *found);
PETSC_EXTERN PetscErrorCode SlipPolicyStore(SlipPolicy policy, const char file[]); /* via a temporary file and rename */
PETSC_EXTERN PetscErrorCode SlipPolicyView(SlipPolicy p, PetscViewer viewer);
PETSC_EXTERN PetscErrorCode SlipPolicyDestroy(SlipPolicy *policy);

/* Functions that build a policy in memory, for trainers; they copy arrays. weight is row-major [out][in]. */
PETSC_EXTERN PetscErrorCode SlipPolicySetObservations(SlipPolicy p, PetscInt n, const char *const names[],
                                                      const PetscReal scale[], const PetscReal offset[]);
PETSC_EXTERN PetscErrorCode SlipPolicyAddLayer(SlipPolicy p, PetscInt in, PetscInt out, const PetscReal weight[],
                                               const PetscReal bias[], SlipActivation activation);
/* h = dt_min + (a - low)/(high - low) (dt_max - dt_min), or with log_spacing dt_min (dt_max/dt_min)^((a - low)/(high -
   low)); a = tanh of the last layer. Units "s", "T*", "t_max" or "h". File: /action attributes, spacing "linear"
   (default when absent) or "log". */
PETSC_EXTERN PetscErrorCode SlipPolicySetAction(SlipPolicy p, PetscReal low, PetscReal high, PetscReal dt_min,
                                                const char dt_min_unit[], PetscReal dt_max, const char dt_max_unit[],
                                                PetscBool log_spacing);
PETSC_EXTERN PetscErrorCode SlipPolicySetRange(SlipPolicy p, const PetscReal min[], const PetscReal max[]);
/* algorithm, problem, alpha, training_steps, seed, ... */
PETSC_EXTERN PetscErrorCode SlipPolicyGetAttribute(SlipPolicy p, const char name[], const char **value); /* borrowed */
PETSC_EXTERN PetscErrorCode SlipPolicySetAttribute(SlipPolicy p, const char name[], const char value[]);

/* Attribute: the longest step [T*] while any cell moves. If a policy has it, a step at rest (SlipProblemOps of
   slipts.h) ends where the rest ends, whatever the network computes. */
#define SLIP_POLICY_MOVING_DT_MAX "moving_dt_max"
/* Attributes: with the wanted accuracy a the run has the tolerance -ts_rtol = factor a^power */
#define SLIP_POLICY_RTOL_FACTOR "rtol_factor"
#define SLIP_POLICY_RTOL_POWER "rtol_power"
/* Attributes of a policy in units of h: the first step is factor a^power T*, and hold is the number of attempts after a
   failed solve in which the step does not grow */
#define SLIP_POLICY_FIRST_STEP_FACTOR "first_step_factor"
#define SLIP_POLICY_FIRST_STEP_POWER "first_step_power"
#define SLIP_POLICY_HOLD "hold"
/* Attribute of such a policy: attempts with a larger error estimate are rejected; the default is 1 */
#define SLIP_POLICY_CEILING "error_ceiling"
/* Attribute: the name of an observation; every step is multiplied by ten to its power, so that the action has the unit
   of a time that the problem computes at every state. */
#define SLIP_POLICY_STEP_FACTOR "step_factor"
/* Attribute: the error that the wanted accuracy bounds, see TSAdaptRLSetMeasure(); the default is final_slip */
#define SLIP_POLICY_MEASURE "measure"
/* Attribute of a policy whose training has not ended: why its accuracy is not reliable */
#define SLIP_POLICY_UNFINISHED "unfinished"
PETSC_EXTERN PetscErrorCode SlipPolicyGetObservations(SlipPolicy p, PetscInt *n, const char *const *names[]);
/* of the training; NULL: unknown */
PETSC_EXTERN PetscErrorCode SlipPolicyGetStepBounds(SlipPolicy p, PetscReal tstar, PetscReal tmax, PetscReal *dt_min,
                                                    PetscReal *dt_max); /* [s] */
/* Evaluates the network without allocation or communication. obs [n] is unscaled; the network gets obs * scale +
   offset. action is in [low, high]; outside counts the observations outside the training range (NULL is allowed). */
PETSC_EXTERN PetscErrorCode SlipPolicyEvaluate(SlipPolicy p, const PetscReal obs[], PetscReal *action,
                                               PetscInt *outside);
PETSC_EXTERN PetscErrorCode SlipPolicyActionToStep(SlipPolicy p, PetscReal action, PetscReal tstar, PetscReal tmax,
                                                   PetscReal *h); /* [s] */
/* Both, and the step factor is applied */
PETSC_EXTERN PetscErrorCode SlipPolicyChoose(SlipPolicy p, const PetscReal obs[], PetscReal tstar, PetscReal tmax,
                                             PetscReal *h, PetscInt *outside);
