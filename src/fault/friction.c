/* The friction of a fault: its law with the parameters of the cells, and laws of others. */
#include <slipstep/private/slipfault.h>

/* Law and parameters of the cells, with this effective normal stress [n] [Pa] (NULL where none is asked for) */
SlipFrictionCells SlipFaultCellFriction(SlipFault fault, const PetscReal stress[])
{
  return (SlipFrictionCells){.law = fault->friction.law,
                             .residual = fault->fields.cell[FIELD_FRICTION_RESIDUAL],
                             .drop = fault->fields.cell[FIELD_FRICTION_DROP],
                             .slip = fault->fields.cell[FIELD_FRICTION_SLIP],
                             .rate = fault->fields.cell[FIELD_FRICTION_RATE],
                             .stress = stress,
                             .weight = fault->mesh.weight,
                             .healing = fault->friction.healing,
                             .a = fault->fields.cell[FIELD_FRICTION_A],
                             .b = fault->fields.cell[FIELD_FRICTION_B],
                             .reference = fault->fields.cell[FIELD_FRICTION_REFERENCE],
                             .reference_rate = fault->options.value[FAULT_FRICTION_REFERENCE_RATE],
                             .slip_law = fault->friction.slip_law};
}

/* What outputs call the state of a cell, for example theta [s] of rate-and-state friction */
PetscReal SlipFaultShownState(SlipFault fault, PetscInt i, PetscReal s)
{
  const SlipFrictionCells friction = SlipFaultCellFriction(fault, NULL);

  return SlipFrictionShown(&friction, i, s);
}

const char *SlipFaultStateUnit(SlipFault fault)
{
  return SlipFrictionStateUnit(fault->friction.law);
}

/* Does the fault's law read this field? */
PetscBool SlipFaultHasField(SlipFault fault, PetscInt field)
{
  return field < FIELD_FRICTION_A || fault->friction.law->always_slides ? PETSC_TRUE : PETSC_FALSE;
}

/*@C
  SlipFaultRegisterFrictionLaw - one more choice of -fault_friction_law

  Not collective, on every process; before the options of a fault are read

  Input Parameter:
. law - its name; mu and its derivatives with respect to the state s and to v = |slip rate| [m/s]; a formula for -help; and,
        for a law with a state of its own, the rate of s with its derivatives and the s that is steady at a rate. Copied;
        strings and context stay the caller's

  Level: advanced

  Notes:
  All functions are pure, of one cell, whose parameters they find in SlipFriction. A law without a state of its own gets the
  slip of both signs as s and gives what mu exceeds -fault_friction_residual by; |tau| <= sigma mu is its bound. A law whose
  cells always slide gives mu itself, 0 at v = 0 and growing with v: without inertia the fault is an explicit problem for TSRK
  and TSADAMS. The rate of s must not grow with s. The field initial_state and the state of outputs are s itself, or what the
  functions shown and of_shown make of it, in state_unit.

  See examples/friction_law.c.

  Errors: PETSC_ERR_ARG_WRONG for a name that is taken and for a law without the functions that it needs

.seealso: SlipFaultSetString(), SlipFaultSetFromOptions()
@*/
PetscErrorCode SlipFaultRegisterFrictionLaw(const SlipFrictionLaw *law)
{
  PetscFunctionBegin;
  PetscAssertPointer(law, 1);
  PetscCall(SlipFrictionRegister(law));
  PetscFunctionReturn(PETSC_SUCCESS);
}
