/* What the learners share, see learner.h. */
#include "learner.h"
#include <slipcompat.h>

void LearnerShape(PetscInt nets, PetscInt in, PetscInt hidden, const PetscInt width[], PetscInt out, DenseShape *s)
{
  PetscInt size[LEARNER_MAX_HIDDEN + 2] = {in};

  for (PetscInt l = 0; l < hidden; ++l) size[l + 1] = width[l];
  size[hidden + 1] = out;
  DenseShapeInit(s, nets, out ? hidden + 1 : hidden, size, out ? PETSC_FALSE : PETSC_TRUE);
}

PetscErrorCode LearnerCheckOptions(const LearnerOptions *o)
{
  PetscFunctionBegin;
  PetscCheck(o->critics > 0 && o->batch > 0, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
             "Critics %" PetscInt_FMT ", batch %" PetscInt_FMT ": both must be positive", o->critics, o->batch);
  PetscCheck(o->actor_layers > 0 && o->actor_layers <= LEARNER_MAX_HIDDEN && o->critic_layers > 0 &&
               o->critic_layers <= LEARNER_MAX_HIDDEN,
             PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
             "%" PetscInt_FMT " hidden layers of the actor and %" PetscInt_FMT " of the critics, expected 1 to %d",
             o->actor_layers, o->critic_layers, LEARNER_MAX_HIDDEN);
  PetscFunctionReturn(PETSC_SUCCESS);
}
