/* Creates the state vector of a fault and fills it with the start. */
#include <slipstep/private/slipfault.h>

/*@
  SlipFaultCreateState - creates a vector for the state w of block size 3, (v [m/s], u [m], s [m]) per cell

  The block size is 5, (v, v, u, u, s), where slip has two components, and larger where the law has several states s.

  Collective; after SlipFaultSetUp().

  Input Parameter:
. fault - the fault

  Output Parameter:
. w - vector of zeros, of global size 3 N, or 5 N, or more; the caller destroys it

  Level: beginner

  Notes:
  Cell e = iz * nx + ix is entry e. The cells of a mesh are numbered process by process instead.

  Errors: PETSC_ERR_ORDER before SlipFaultSetUp()

.seealso: SlipFaultSetInitialState()
@*/
PetscErrorCode SlipFaultCreateState(SlipFault fault, Vec *w)
{
  PetscFunctionBegin;
  SlipFaultCheckSetUp(fault, 1);
  PetscAssertPointer(w, 2);
  PetscCall(VecCreate(fault->comm, w));
  PetscCall(VecSetSizes(*w, fault->layout.block * fault->mesh.n, fault->layout.block * fault->mesh.N));
  PetscCall(VecSetBlockSize(*w, fault->layout.block));
  PetscCall(VecSetType(*w, fault->device.device ? VECSLIPOPENCL : VECSTANDARD));
  PetscCall(VecZeroEntries(*w));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipFaultSetInitialState - sets the initial state that -fault_initial selects

  Collective. "critical": v = 0, s = 0, u = -(1 + perturbation) K^-1 q(0), so that -K u slightly exceeds the strength
  everywhere; "rest" and "traction": all zero. The shear stress is T0 - K u, T0 the field initial_traction.

  With rate-and-state friction u = 0. "rate" takes v and theta from the fields initial_rate and initial_state, and
  computes T0 as what balances them, sigma mu + H (v - v_inf). "traction" takes T0 as given, and v follows from theta,
  or theta from v where initial_state is not given. initial_rate is by default the loading rate, and with "rate" a
  thousandth of that in cells that weaken with the rate: if all cells slid at the loading rate, in the state that is
  steady there, the start would be an unstable equilibrium.

  Input Parameters:
+ fault - the fault
- w     - state of SlipFaultCreateState(); overwritten

  Options Database Keys:
+ -fault_initial <auto,critical,rest,traction,rate> - selects the start; auto: rate with smooth friction, else critical
. -fault_initial_perturbation <1e-5>      - relative excess of the critical start, dimensionless
. -fault_initial_traction <T0>            - shear stress of "traction" [Pa], or a field of -fault_parameters
- -fault_initial_unstable <no>            - allows "traction" to exceed the strength: the fault begins to slip at once.
                                            A line says where, and how many such cells are outside of their largest
                                            patch

  Level: beginner

  Errors: PETSC_ERR_ORDER before SlipFaultSetUp(); PETSC_ERR_ARG_OUTOFRANGE, with number and place of the cells, when
  "traction" exceeds the strength

.seealso: SlipFaultCreateState()
@*/
PetscErrorCode SlipFaultSetInitialState(SlipFault fault, Vec w)
{
  PetscBool critical, traction;
  PetscReal *a;
  const PetscReal *uc;

  PetscFunctionBegin;
  SlipFaultCheckSetUp(fault, 1);
  PetscValidHeaderSpecific(w, VEC_CLASSID, 2);
  PetscCall(PetscStrcmp(fault->kind.initial, "critical", &critical));
  PetscCall(PetscStrcmp(fault->kind.initial, "traction", &traction));
  PetscCall(VecZeroEntries(w));
  if (fault->friction.law->always_slides) {
    PetscCall(SlipFaultBalanceStart(fault, w));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (traction) PetscCall(SlipFaultCheckTraction(fault));
  if (!critical) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecGetArray(w, &a));
  PetscCall(VecGetArrayRead(fault->critical.uc, &uc));
  for (PetscInt i = 0, c = fault->layout.components; i < fault->mesh.n; i++)
    for (PetscInt k = 0; k < c; k++)
      a[SlipFaultDisplacementAt(fault, i) + k] = fault->critical.start_share * uc[c * i + k];
  PetscCall(VecRestoreArrayRead(fault->critical.uc, &uc));
  PetscCall(VecRestoreArray(w, &a));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes a vector of cells with the slip [m] of the state w at t, or its magnitude for two components: s, or where s
   is the state of friction, the displacement since the start plus that of the loading. */
PetscErrorCode SlipFaultGetSlip(SlipFault fault, PetscReal t, Vec w, Vec slip)
{
  const PetscReal *vinf = fault->fields.cell[FIELD_LOADING_RATE], *a, *uc;
  const PetscBool state = fault->kind.heals || fault->friction.law->nstates ? PETSC_TRUE : PETSC_FALSE;
  const PetscInt c = fault->layout.components;
  PetscReal *s;
  const SlipArrays arrays[] = {{w, .read = &a}, {fault->critical.uc, .read = &uc}, {slip, .write = &s}};

  PetscFunctionBegin;
  t += fault->loads.origin;
  PetscCall(SlipArraysGet(3, arrays));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    PetscReal u[3] = {0, 0, 0};

    s[i] = a[SlipFaultStateAt(fault, i)];
    if (!state) continue;
    for (PetscInt k = 0; k < c; k++)
      u[k] = a[SlipFaultDisplacementAt(fault, i) + k] - fault->critical.start_share * uc[c * i + k] +
             t * (vinf[i] * SlipFaultAlong(fault, i)[k]);
    s[i] = c == 1 ? u[0] : SlipFaultLength(fault, u);
  }
  PetscCall(SlipArraysRestore(3, arrays));
  PetscFunctionReturn(PETSC_SUCCESS);
}
