/* Combines the friction law of a fault with the parameters of its cells. */
#include <slipstep/private/slipfault.h>

/* Returns law and parameters of the cells, with this effective normal stress [n] [Pa] (NULL: not needed). */
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
                             .state_law = fault->friction.state_law,
                             .cutoff_rate = fault->options.value[FAULT_STATE_CUTOFF_RATE],
                             .alpha = fault->friction.follows ? fault->fields.cell[FIELD_FRICTION_ALPHA] : NULL,
                             .start = fault->fields.cell[FIELD_NORMAL_STRESS],
                             .own = fault->friction.own,
                             .nown = fault->friction.nown,
                             .known = fault->friction.known};
}

/* Returns the rate of the first friction state of cell i in the state a [block n] at this slip rate. */
PetscReal SlipFaultFirstStateRate(SlipFault fault, PetscInt i, const PetscReal a[], PetscReal speed)
{
  const SlipFrictionCells friction = SlipFaultCellFriction(fault, NULL);
  PetscReal rate[SLIP_MAX_STATES];

  SlipFrictionStateRateOf(&friction, i, a + SlipFaultStateAt(fault, i), speed, rate);
  return rate[0];
}

/* Returns by how much the friction of cell i changes in an event [Pa], beside which errors of pressure count: a or b
   times the normal stress, or the drop that weakening makes. */
PetscReal SlipFaultFrictionChange(SlipFault fault, PetscInt i)
{
  const PetscReal *const *cell = (const PetscReal *const *)fault->fields.cell;

  return cell[FIELD_NORMAL_STRESS][i] * (fault->friction.law->always_slides
                                           ? PetscMax(cell[FIELD_FRICTION_A][i], cell[FIELD_FRICTION_B][i])
                                           : PetscMax(cell[FIELD_FRICTION_DROP][i], cell[FIELD_FRICTION_RESIDUAL][i]));
}

/* Finds whether the state follows normal stress; after the loads. */
PetscErrorCode SlipFaultFollowSetUp(SlipFault fault)
{
  const PetscReal *alpha = fault->fields.cell[FIELD_FRICTION_ALPHA], *b = fault->fields.cell[FIELD_FRICTION_B];
  const PetscReal *start = fault->fields.cell[FIELD_NORMAL_STRESS];
  PetscInt count[2] = {0, 0};

  PetscFunctionBegin;
  if (fault->friction.law->eval != SlipRateAndState) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    if (alpha[i] == 0) continue;
    count[0]++;
    if (!(b[i] > 0) || !(start[i] > 0)) count[1]++;
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, count, 2, MPIU_INT, MPI_SUM, fault->comm));
  PetscCheck(!count[1], fault->comm, PETSC_ERR_ARG_OUTOFRANGE,
             "-%sfault_friction_alpha is not 0 in %" PetscInt_FMT
             " cells without normal stress or without -%sfault_friction_b, expected both to be positive there",
             SlipFaultPrefix(fault), count[1], SlipFaultPrefix(fault));
  fault->friction.follows = count[0] && (fault->kind.coupled || fault->loads.pressed) ? PETSC_TRUE : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipFaultGetFriction - gets the friction of the cells of this process, for SlipFrictionStrength() and its like

  Collective; after SlipFaultSetUp()

  Input Parameters:
+ fault - the fault
- t     - time of the effective normal stress [s], which a pore pressure changes

  Output Parameter:
. friction - law and parameters, borrowed arrays in the order of the state; strengths multiply the effective normal
             stress [Pa] by the cells' weights, area over mean area; it is valid until the next call for another time

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
