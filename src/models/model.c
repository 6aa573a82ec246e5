/* Implements what all small models share: creation, set-up and destruction, options, and the TS. */
#include <slipstep/rooms/slipmodels.h>
#include <slipstep/rooms/slipsys.h>
#include <slipstep/rooms/slipadapt.h>
#include <slipcompat.h>
#include <string.h>

const char *const SlipModelCases[] = {"training", "evaluation", "SlipModelCase", "", NULL};

/*@C
  SlipModelCreate - creates a small model with the parameters of one of the study's settings

  Not collective.

  Input Parameters:
+ ops     - its functions: &SlipSlidingModeOps, &SlipCircuitOps, or a table of the caller's
- setting - SLIP_MODEL_TRAINING or SLIP_MODEL_EVALUATION

  Output Parameter:
. model - the model; its parameters are those of SlipSlidingMode or SlipCircuit, to which it may be cast

  Level: beginner

.seealso: SlipModelSetFromOptions(), SlipModelSetUp(), SlipModelDestroy()
@*/
PetscErrorCode SlipModelCreate(const SlipModelOps *ops, SlipModelCase setting, SlipModel *model)
{
  void *memory;

  PetscFunctionBegin;
  PetscCall(PetscMalloc(ops->size, &memory));
  PetscCall(PetscMemzero(memory, ops->size));
  *model = (SlipModel)memory;
  (*model)->ops = ops;
  (*model)->setting = setting;
  PetscCall((*ops->set_case)(*model, setting));
  PetscCall(SlipModelSetUp(*model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipModelDestroy - destroys a small model; a TS that integrates it must be destroyed before

  Not collective.

  Input Parameter:
. model - the model, set to NULL

  Level: beginner

.seealso: SlipModelCreate()
@*/
PetscErrorCode SlipModelDestroy(SlipModel *model)
{
  PetscFunctionBegin;
  PetscCall(PetscFree(*model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipModelSetFromOptions - sets parameters of a small model from the options database

  Collective on PETSC_COMM_WORLD.

  Input Parameter:
. model - the model; its parameters are replaced by those of its setting and of the options

  Options Database Keys:
+ -sliding_mode_case <training, evaluation> - setting whose values the options below replace
. -sliding_mode_gain - bound k of the reaction [1/s]
. -sliding_mode_amplitude - amplitude D of the disturbance [1/s]
. -sliding_mode_frequency - angular frequency omega of the disturbance [rad/s]
. -sliding_mode_start - start w(0)
. -circuit_case <training, evaluation> - setting whose values the options below replace
. -circuit_c1, -circuit_c2 - capacities [F]
. -circuit_r - resistance [Ohm]
. -circuit_l - inductance [H]
. -circuit_m - current of the diode [A]
. -circuit_start - V1 [V], V2 [V], i [A] at the start
- -circuit_unit <amplitude, start> - unit of the states in observations of policies

  Level: beginner

  Errors: PETSC_ERR_ARG_OUTOFRANGE and PETSC_ERR_ARG_SIZ, with the option and the expected value

.seealso: SlipModelCreate(), SlipModelSetUp()
@*/
PetscErrorCode SlipModelSetFromOptions(SlipModel model)
{
  static const char *const numbers[] = {"-sliding_mode_gain",
                                        "-sliding_mode_amplitude",
                                        "-sliding_mode_frequency",
                                        "-sliding_mode_start",
                                        "-circuit_c1",
                                        "-circuit_c2",
                                        "-circuit_r",
                                        "-circuit_l",
                                        "-circuit_m"};

  PetscFunctionBegin;
  PetscCall(SlipCheckFiniteOption(PETSC_COMM_WORLD, "-ts_max_time"));
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(numbers); i++)
    if (!strncmp(numbers[i] + 1, model->ops->name, strlen(model->ops->name)))
      PetscCall(SlipCheckFiniteOption(PETSC_COMM_WORLD, numbers[i]));
  PetscCall((*model->ops->set_from_options)(model));
  PetscCall(SlipModelSetUp(model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Checks the parameters of a small model and computes the numbers that follow from them. Errors:
   PETSC_ERR_ARG_OUTOFRANGE, with the parameter's option and the expected value. */
PetscErrorCode SlipModelSetUp(SlipModel model)
{
  PetscFunctionBegin;
  PetscCall((*model->ops->setup)(model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Bound(PetscReal t, const PetscReal w[], PetscReal q[], PetscReal dq[], void *ctx)
{
  PetscFunctionBegin;
  (void)t, (void)w;
  (void)dq; /* zero already */
  q[0] = ((SlipModel)ctx)->bound;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the row of a name in a small model's table of observations. name: name of an observation, such as "energy".
   Returns the number of the row in model->ops->observations, -1 when there is none. */
PetscInt SlipModelFindObservation(SlipModel model, const char name[])
{
  const SlipModelObservation *rows = model->ops->observations;

  for (PetscInt i = 0; rows && rows[i].name; i++)
    if (!strcmp(name, rows[i].name)) return i;
  return -1;
}

static PetscErrorCode Find_Model(TS ts, const char name[], PetscInt *row, void *ctx)
{
  PetscFunctionBegin;
  (void)ts;
  *row = SlipModelFindObservation((SlipModel)ctx, name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Observe_Model(TS ts, PetscReal t, PetscInt n, const PetscInt row[], PetscReal value[], void *ctx)
{
  SlipModel model = (SlipModel)ctx;
  Vec w;
  const PetscScalar *a;

  PetscFunctionBegin;
  PetscCall(TSGetSolution(ts, &w));
  PetscCall(VecGetArrayRead(w, &a));
  for (PetscInt i = 0; i < n; i++) {
    const SlipModelObservation *o = &model->ops->observations[row[i]];

    value[i] = (*o->value)(model, t, a, o->k);
  }
  PetscCall(VecRestoreArrayRead(w, &a));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TimeScale_Model(TS ts, PetscReal *tstar, void *ctx)
{
  PetscFunctionBegin;
  (void)ts;
  *tstar = ((SlipModel)ctx)->tstar;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Name_Model(TS ts, const char **name, void *ctx)
{
  PetscFunctionBegin;
  (void)ts;
  *name = ((SlipModel)ctx)->ops->name;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static const SlipProblemOps ModelProblem = {.control = {.name = Name_Model, .time_scale = TimeScale_Model},
                                            .observations = {.find = Find_Model, .observe = Observe_Model}};

/*@C
  SlipModelConfigureTS - makes a TS integrate a small model

  Logically collective; before TSSetFromOptions().

  Input Parameters:
+ model - the model, set up; it must live as long as the TS
- ts    - the TS, on one process; the model becomes its application context

  Notes:
  The function sets the type bathe with implicit steps, the final time, the first step, the study's tolerances, the
  controller heuristic and the limits of its steps: from 1e-9 s. The study's least step of 1e-5 s is for its policies,
  whose files have their own bounds: across an event an error estimate falls as slowly as the step, and controllers that
  satisfy it need less for some starts.

  Level: beginner

.seealso: SlipModelCreateState(), SlipSmallConfigureTS(), TSBATHE
@*/
PetscErrorCode SlipModelConfigureTS(SlipModel model, TS ts)
{
  const PetscInt rows[] = {0};
  const SlipSmall problem = {.n = model->ops->n,
                             .mass = model->mass,
                             .nrows = 1,
                             .rows = rows,
                             .force = model->ops->force,
                             .jacobian = model->ops->jacobian,
                             .bound = Bound,
                             .ctx = model};
  TSAdapt adapt;
  PetscBool bathe;

  PetscFunctionBegin;
  PetscCall(SlipSmallConfigureTS(&problem, ts));
  PetscCall(PetscObjectTypeCompare((PetscObject)ts, TSBATHE, &bathe));
  if (bathe) PetscCall(TSBatheSetMethod(ts, TSBATHE_METHOD_IMPLICIT)); /* as in the study */
  PetscCall(TSSetMaxTime(ts, model->max_time));
  PetscCall(TSSetTimeStep(ts, model->dt));
  PetscCall(TSSetTolerances(ts, model->atol, NULL, model->rtol, NULL));
  PetscCall(TSGetAdapt(ts, &adapt));
  PetscCall(TSAdaptSetType(adapt, TSADAPTHEURISTIC));
  PetscCall(TSAdaptSetStepLimits(adapt, 1e-9, model->dt_max));
  PetscCall(TSSetApplicationContext(ts, model));
  PetscCall(TSSetSlipProblem(ts, &ModelProblem, model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipModelCreateState - creates the vector of a small model's states, at its start

  Not collective.

  Input Parameter:
. model - the model

  Output Parameter:
. w - the states [n]; the caller destroys it

  Level: beginner

.seealso: SlipModelConfigureTS()
@*/
PetscErrorCode SlipModelCreateState(SlipModel model, Vec *w)
{
  PetscScalar *a;

  PetscFunctionBegin;
  PetscCall(VecCreateSeq(PETSC_COMM_SELF, model->ops->n, w));
  PetscCall(VecGetArrayWrite(*w, &a));
  PetscCall(PetscArraycpy(a, model->start, model->ops->n));
  PetscCall(VecRestoreArrayWrite(*w, &a));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipModelEnergy - computes the energy w'A w/2 of a state of a small model, which only the load raises

  Not collective.

  Input Parameters:
+ model - the model, set up
- w     - the states [n]

  Level: intermediate

  Note:
  The energy of the circuit is in J. Two solutions of one model approach each other in this norm of their difference.

.seealso: SlipModelCreate()
@*/
PetscReal SlipModelEnergy(SlipModel model, const PetscReal w[])
{
  PetscReal twice = 0;

  for (PetscInt k = 0; k < model->ops->n; k++) twice += model->mass[k] * PetscSqr(w[k]);
  return 0.5 * twice;
}

/* Computes the exact solution of a small model at equal intervals. dt: the interval [s]; n: number of times 0, dt, ...,
   (n - 1) dt; w: the states [n][states]. */
void SlipModelExactTable(SlipModel model, PetscReal dt, PetscInt n, PetscReal w[])
{
  PetscReal reaction;

  if (model->ops->exact)
    for (PetscInt k = 0; k < n; k++) w[k] = (*model->ops->exact)(model, (PetscReal)k * dt, &reaction);
  else
    (*model->ops->table)(model, dt, n, w);
}
