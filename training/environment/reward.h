/* What an attempted step is worth: rows of a table, chosen by -train_reward. */
#pragma once
#include <slipstep/rooms.h>

/* Everything a reward may use. Costs are those of -train_cost: Newton iterations or wall seconds. */
typedef struct {
  const SlipAttempt *attempt;
  PetscReal dt_min, dt_max;           /* bounds of the action [s] */
  PetscReal cost, cost_min, cost_max; /* of the attempt; running extrema over successful ones, this one included */
  PetscReal alpha;                    /* weight of the error, -train_alpha */
  PetscReal effect; /* weighted errors that the step leaves in the exact continuation, see Problem.judge_step */
} RewardInput;

typedef struct {
  const char *name, *meaning;
  PetscBool needs_continuation; /* effect */
  PetscReal (*value)(const RewardInput *in);
} Reward;

PETSC_INTERN PetscErrorCode RewardFind(const char name[], const Reward **row);
