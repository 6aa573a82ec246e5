/* The friction of a fault: its law with the parameters of the cells. */
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
                             .slip_law = fault->friction.slip_law,
                             .own = fault->friction.own,
                             .nown = fault->friction.nown};
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

/*@
  SlipFaultGetFriction - the friction of the cells of this process, for SlipFrictionStrength() and its like

  Collective; after SlipFaultSetUp()

  Input Parameters:
+ fault - the fault
- t     - time of the effective normal stress [s], which a pore pressure changes

  Output Parameter:
. friction - law and parameters, borrowed arrays in the order of the state; the effective normal stress [Pa] counts with
             the weights of the cells, area over mean area, and is valid until the fault is asked about another time

  Level: advanced

.seealso: SlipFaultGetOperators(), SlipFrictionStrength()
@*/
PetscErrorCode SlipFaultGetFriction(SlipFault fault, PetscReal t, SlipFrictionCells *friction)
{
  const SlipFaultLoad *load;

  PetscFunctionBegin;
  PetscCall(SlipFaultGetLoad(fault, t, &load));
  *friction = SlipFaultCellFriction(fault, load->stress);
  PetscFunctionReturn(PETSC_SUCCESS);
}
