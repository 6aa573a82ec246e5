/* Registers the cone solvers with PETSc, and creates the constraint object that programs pass to them. */
#include <slipstep/private/slipsnes.h>
#include <slipstep/private/slipmatstage.h>
#include <slipstep/private/slipsys.h>

PetscClassId SLIP_CONSTRAINT_CLASSID = 0;

static PetscErrorCode Register_SNES(void)
{
  PetscFunctionBegin;
  PetscCall(SlipMatInitializePackage());
  PetscCall(PetscClassIdRegister("Slip constraint", &SLIP_CONSTRAINT_CLASSID));
  PetscCall(SNESRegister(SNESSEMISMOOTH, SNESCreate_Semismooth));
  PetscCall(SNESRegister(SNESPROJECTION, SNESCreate_Projection));
  PetscCall(KSPRegister(KSPSLIPCG, KSPCreate_SlipCG));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Registers the class of constraints, the SNES types, and the classes that they use. */
PetscErrorCode SlipSNESInitializePackage(void)
{
  return SlipRegisterOnce(Register_SNES);
}

/*@C
  SlipConstraintCreate - creates an object of a problem's set-valued reaction for the cone solvers and TSBATHE

  Collective

  Input Parameters:
+ comm             - the communicator
. ops              - the problem's operations (copied); the SNES types need stage, residual, jacobian and bound,
                     TSBATHE needs all, and TSMOREAU also needs explicit_ops
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
  PetscCall(SlipSNESInitializePackage());
  PetscCall(PetscHeaderCreate(c, SLIP_CONSTRAINT_CLASSID, "SlipConstraint", "Set-valued reaction", "SNES", comm,
                              SlipConstraintDestroy, NULL));
  c->ops[0] = *ops;
  c->ctx = ctx;
  c->omega = 1.0;
  c->scale = 1.0;
  c->worst = -1;
  c->components = 1;
  PetscCall(VecDuplicate(reduced_template, &c->x));
  *con = c;
  PetscFunctionReturn(PETSC_SUCCESS);
}
