/* SlipConstraint: a set-valued reaction that a problem describes by a table of operations. */
#include <slipsys.h>
#include <slipstep/private/slipsnes.h>
#include <slipcore.h>

PetscClassId SLIP_CONSTRAINT_CLASSID = 0;

/*@C
  SlipConstraintCreate - wrap a problem's set-valued reaction for the cone solvers and TSBATHE

  Collective

  Input Parameters:
+ comm             - the communicator
. ops              - the problem's operations (copied); stage, residual, jacobian and bound are required by the SNES
                     types, all of them by TSBATHE
. ctx              - passed to every operation
- reduced_template - a vector with the layout of the reduced unknowns x (its values are not used)

  Output Parameter:
. con - the constraint

  Level: intermediate

  Errors: PETSC_ERR_ARG_WRONG when residual, jacobian or bound is missing

.seealso: SlipConstraintDestroy(), SNESSetSlipConstraint(), TSBatheSetConstraint()
@*/
PetscErrorCode SlipConstraintCreate(MPI_Comm comm, const SlipConstraintOps *ops, void *ctx, Vec reduced_template,
                                    SlipConstraint *con)
{
  SlipConstraint c;

  PetscFunctionBegin;
  PetscAssertPointer(ops, 2);
  PetscValidHeaderSpecific(reduced_template, VEC_CLASSID, 4);
  PetscAssertPointer(con, 5);
  PetscCheck(ops->residual && ops->jacobian && ops->bound, comm, PETSC_ERR_ARG_WRONG,
             "SlipConstraintOps must supply residual, jacobian and bound");
  PetscCall(SlipStepInitializePackage());
  PetscCall(PetscHeaderCreate(c, SLIP_CONSTRAINT_CLASSID, "SlipConstraint", "Set-valued reaction", "SNES", comm,
                              SlipConstraintDestroy, NULL));
  c->ops[0] = *ops;
  c->ctx = ctx;
  c->omega = 1.0;
  c->scale = 1.0;
  c->worst = -1;
  PetscCall(VecDuplicate(reduced_template, &c->x));
  *con = c;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipConstraintDestroy - give up a reference to a constraint

  Collective

  Input Parameter:
. con - the constraint, set to NULL

  Level: intermediate

.seealso: SlipConstraintCreate()
@*/
PetscErrorCode SlipConstraintDestroy(SlipConstraint *con)
{
  PetscFunctionBegin;
  if (!*con) PetscFunctionReturn(PETSC_SUCCESS);
  PetscValidHeaderSpecific(*con, SLIP_CONSTRAINT_CLASSID, 1);
  if (--((PetscObject)*con)->refct > 0) {
    *con = NULL;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(VecDestroy(&(*con)->x));
  PetscCall(VecDestroy(&(*con)->r));
  PetscCall(VecDestroy(&(*con)->g));
  PetscCall(VecDestroy(&(*con)->q));
  PetscCall(VecDestroy(&(*con)->dq));
  PetscCall(VecDestroy(&(*con)->F));
  PetscCall(VecDestroy(&(*con)->mask));
  PetscCall(VecDestroy(&(*con)->slope));
  PetscCall(VecDestroy(&(*con)->rho));
  PetscCall(PetscHeaderDestroy(con));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipConstraintGetContext - the context that was given to SlipConstraintCreate()

  Not collective

  Input Parameter:
. con - the constraint

  Output Parameter:
. ctx - address of a pointer that receives the context

  Level: intermediate

.seealso: SlipConstraintCreate()
@*/
PetscErrorCode SlipConstraintGetContext(SlipConstraint con, void *ctx)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(con, SLIP_CONSTRAINT_CLASSID, 1);
  *(void **)ctx = con->ctx;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The problem's operations, for TSBATHE; checks that all that a time step needs are there */
PetscErrorCode SlipConstraintGetOps(SlipConstraint con, const SlipConstraintOps **ops)
{
  PetscFunctionBegin;
  PetscCheck(
    con->ops->stage && con->ops->reduce && con->ops->lift && con->ops->smooth && con->ops->add_reaction &&
      con->ops->solve_mass && con->ops->bound_state,
    PetscObjectComm((PetscObject)con), PETSC_ERR_ARG_WRONG,
    "TSBATHE needs every operation of SlipConstraintOps: stage, reduce, lift, smooth, add_reaction, solve_mass "
    "and bound_state are not all set");
  *ops = con->ops;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A new vector with the layout of the reduced unknowns, zero */
PetscErrorCode SlipConstraintCreateReduced(SlipConstraint con, Vec *x)
{
  PetscFunctionBegin;
  PetscCall(VecDuplicate(con->x, x));
  PetscCall(VecZeroEntries(*x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipConstraintInitialReaction - the reaction at the start of a run

  Collective

  Input Parameters:
+ con - the constraint; its operations smooth, reduce, add_reaction, bound_state are used
. t   - the time [s]
- w   - the full state

  Output Parameter:
. r - reduced: the static balance -F_s projected on [-q, q] where x = 0, -q sign(x) where x != 0

  Level: intermediate

  Errors: PETSC_ERR_ARG_WRONG when the problem has no operation smooth, reduce or bound_state

.seealso: SlipConstraintCreate(), TSBatheSetInitialReaction()
@*/
PetscErrorCode SlipConstraintInitialReaction(SlipConstraint con, PetscReal t, Vec w, Vec r)
{
  Vec Fs, force;
  PetscInt n;
  const PetscScalar *x, *q, *f;
  PetscScalar *rr;

  PetscFunctionBegin;
  PetscValidHeaderSpecific(con, SLIP_CONSTRAINT_CLASSID, 1);
  PetscCheck(con->ops->smooth && con->ops->reduce && con->ops->bound_state, PetscObjectComm((PetscObject)con),
             PETSC_ERR_ARG_WRONG, "SlipConstraintOps must supply smooth, reduce and bound_state");
  PetscCall(SlipConstraintSetUpWork(con));
  PetscCall(VecDuplicate(w, &Fs));
  PetscCall(VecDuplicate(r, &force));
  PetscCall((*con->ops->smooth)(con, t, w, Fs, con->ctx));
  PetscCall((*con->ops->reduce)(con, Fs, force, con->ctx)); /* the reduced rows of F_s are those that r enters */
  PetscCall((*con->ops->reduce)(con, w, con->x, con->ctx));
  PetscCall((*con->ops->bound_state)(con, t, w, con->q, con->ctx));
  PetscCall(VecGetLocalSize(r, &n));
  PetscCall(VecGetArrayRead(con->x, &x));
  PetscCall(VecGetArrayRead(con->q, &q));
  PetscCall(VecGetArrayRead(force, &f));
  PetscCall(VecGetArray(r, &rr));
  for (PetscInt i = 0; i < n; i++)
    rr[i] = SlipConeReaction(1.0, PetscRealPart(x[i]), -PetscRealPart(f[i]), PetscRealPart(q[i]));
  PetscCall(VecRestoreArray(r, &rr));
  PetscCall(VecRestoreArrayRead(force, &f));
  PetscCall(VecRestoreArrayRead(con->q, &q));
  PetscCall(VecRestoreArrayRead(con->x, &x));
  PetscCall(VecDestroy(&Fs));
  PetscCall(VecDestroy(&force));
  PetscFunctionReturn(PETSC_SUCCESS);
}
