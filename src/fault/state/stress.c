/* Computes the elastic shear stress of a fault, its energy and the power of loading. Only this file combines what acts
   on a cell besides friction and viscosity. */
#include <slipstep/private/slipfault.h>
#include <slipstep/private/slipsys.h>

/* Gets the shear load at t, times weights, or NULL for none. It is borrowed until the next call for another time, and
   is on the device where rates are balanced there. */
PetscErrorCode SlipFaultGetShear(SlipFault fault, PetscReal t, Vec *shear)
{
  PetscFunctionBegin;
  *shear = NULL;
  if (!fault->loads.shears) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall((*fault->cell_ops->shear)(fault, t, shear));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipFaultStress - computes the elastic shear stress on each cell

  Collective; after SlipFaultSetUp()

  Input Parameters:
+ fault - the fault
. t     - time of the state [s]
- w     - state, of SlipFaultCreateState()

  Output Parameter:
. T - shear stress [Pa], a number for each cell and component of slip in the distribution of the state, positive where
      it drives slip forward

  Level: intermediate

  Notes:
  T = T0 + t dT/dt + S - K u, per area of the cell itself, also on meshes, where rows of K are weighted by area; T0 and
  dT/dt are the fields initial_traction and stressing_rate, S(t) the stresses in time. It costs a product with K.
  Friction and viscosity are not part of it.

.seealso: SlipFaultGetObservables(), SlipFaultGetOperators()
@*/
PetscErrorCode SlipFaultStress(SlipFault fault, PetscReal t, Vec w, Vec T)
{
  PetscReal *a;
  Vec u, shear;

  PetscFunctionBegin;
  SlipFaultCheckSetUp(fault, 1);
  PetscValidHeaderSpecific(w, VEC_CLASSID, 3);
  PetscValidHeaderSpecific(T, VEC_CLASSID, 4);
  PetscCall(SlipFaultGetWork(fault, &u));
  PetscCall(SlipFaultForce(fault, t, w, u, T));
  PetscCall(SlipFaultRestoreWork(fault, &u));
  PetscCall(SlipFaultGetShear(fault, t, &shear));
  if (shear) PetscCall(VecAXPY(T, -1, shear));
  PetscCall(VecGetArray(T, &a));
  for (PetscInt i = 0, c = fault->layout.components; i < fault->mesh.n; i++)
    for (PetscInt k = 0; k < c; k++) a[c * i + k] /= -fault->mesh.weight[i];
  PetscCall(VecRestoreArray(T, &a));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sums w p x, p: pore pressure at t, x: opening of each cell, or its rate; 0 where cells do not open. */
static PetscErrorCode PressureTimes(SlipFault fault, PetscReal t, Vec x, PetscInt first, PetscInt block, PetscReal *sum)
{
  const SlipFaultLoad *load;
  const PetscReal *a;

  PetscFunctionBegin;
  *sum = 0;
  if (!SlipFaultOpens(fault)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipFaultGetLoad(fault, t, &load));
  PetscCall(VecGetArrayRead(x, &a));
  for (PetscInt i = 0; i < fault->mesh.n; i++)
    *sum += fault->mesh.weight[i] * (fault->loads.normal[i] - load->bare[i]) * a[block * i + first + 2];
  PetscCall(VecRestoreArrayRead(x, &a));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 1, MPIU_REAL, MPIU_SUM, fault->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sums x S, S: shear load of the terms at t, times weights. */
static PetscErrorCode TermsTimes(SlipFault fault, PetscReal t, Vec x, PetscInt first, PetscInt block, PetscReal *sum)
{
  const PetscReal *a;

  PetscFunctionBegin;
  *sum = 0;
  if (!fault->loads.nterms) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecGetArrayRead(x, &a));
  *sum = SlipLoadsTermsTimes(&fault->loads, t, a, first, block);
  PetscCall(VecRestoreArrayRead(x, &a));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 1, MPIU_REAL, MPIU_SUM, fault->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes u f(u)/2 plus the other energy of the medium, minus u T, of the whole fault [J]; T: the shear load, and
   where cells open -sigma0. It costs a product with K. Collective. */
PetscErrorCode SlipFaultElasticEnergy(SlipFault fault, PetscReal t, Vec w, PetscReal *energy)
{
  PetscReal work = 0, stored, pressure;
  Vec u, force, shear;

  PetscFunctionBegin;
  PetscCall(SlipFaultGetShear(fault, t, &shear));
  PetscCall(SlipFaultGetWork(fault, &u));
  PetscCall(SlipFaultGetWork(fault, &force));
  PetscCall(SlipFaultForce(fault, t, w, u, force));
  PetscCall(SlipElasticGetEnergy(fault->medium, t, u, &stored));
  PetscCall(VecDot(u, force, energy));
  if (shear) PetscCall(VecDot(u, shear, &work));
  PetscCall(PressureTimes(fault, t, u, 0, 3, &pressure));
  PetscCall(SlipFaultRestoreWork(fault, &force));
  PetscCall(SlipFaultRestoreWork(fault, &u));
  *energy = (0.5 * *energy + stored - work + pressure) * fault->mesh.area;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes u S of the terms S [J], see SlipFaultLoadingPower(). Collective. */
PetscErrorCode SlipFaultTermsEnergy(SlipFault fault, PetscReal t, Vec w, PetscReal *energy)
{
  PetscFunctionBegin;
  PetscCall(TermsTimes(fault, t, w, fault->layout.displacement, fault->layout.block, energy));
  *energy *= fault->mesh.area;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the power of loading, v_inf (T - f(u, t)) - u dT/dt + v S, S the terms, and where cells open p v_n [W]. As
   K v_inf + dT/dt is computed once, it costs no product, unless f is not K u. The power of the terms is v S: unlike -u
   dS/dt it has no jumps at their corners, and the same value in both steps there. Less the change of u S it is the
   work that belongs to SlipFaultElasticEnergy(). Collective. */
PetscErrorCode SlipFaultLoadingPower(SlipFault fault, PetscReal t, Vec w, PetscReal *power)
{
  PetscReal work = 0, pressure, more, slow, terms, plates;
  Vec u, force, shear;
  PetscBool rests;

  PetscFunctionBegin;
  *power = 0;
  if (!fault->kind.driven) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipFaultGetShear(fault, t, &shear));
  PetscCall(SlipFaultRestSetUp(fault));
  if (!fault->kind.loaded && !fault->loads.drives && !fault->loads.nterms && !SlipFaultOpens(fault))
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipFaultGetWork(fault, &u));
  PetscCall(SlipFaultGetWork(fault, &force));
  PetscCall(SlipFaultGetDisplacement(fault, w, u));
  PetscCall(SlipElasticRests(fault->medium, &rests));
  PetscCall(VecDot(fault->loads.drive, u, power));
  if (!rests && fault->kind.loaded) { /* plus v_inf (f - K u) */
    PetscCall(SlipFaultForce(fault, t, w, u, force));
    PetscCall(VecDot(fault->operators.vinf, force, &more));
    PetscCall(VecDot(fault->loads.pull, u, &slow));
    *power += more - slow;
  }
  PetscCall(SlipFaultRestoreWork(fault, &force));
  PetscCall(SlipFaultRestoreWork(fault, &u));
  if (shear) PetscCall(VecDot(fault->operators.vinf, shear, &work));
  PetscCall(PressureTimes(fault, t, w, fault->layout.rate, fault->layout.block, &pressure));
  PetscCall(TermsTimes(fault, t, w, fault->layout.rate, fault->layout.block, &terms));
  PetscCall(TermsTimes(fault, t, fault->operators.vinf, 0, fault->layout.components, &plates));
  *power = (work - plates - *power + terms + pressure) * fault->mesh.area;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  SlipFaultReportOpening - warns once that cells have opened, as their pressure exceeds their normal stress, and that
  they have no strength

  Collective; for times that the run has reached, not for those of an attempt or of a search for an onset.
*/
PetscErrorCode SlipFaultReportOpening(SlipFault fault, PetscReal t)
{
  PetscInt opened = 0;
  PetscMPIInt rank;

  PetscFunctionBegin;
  if (fault->loads.opened || !fault->loads.pressed || SlipFaultOpens(fault)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall((*fault->cell_ops->opened)(fault, t, &opened));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &opened, 1, MPIU_INT, MPI_SUM, fault->comm));
  if (!opened) PetscFunctionReturn(PETSC_SUCCESS);
  fault->loads.opened = PETSC_TRUE;
  PetscCallMPI(MPI_Comm_rank(fault->comm, &rank));
  if (!rank)
    PetscCall(SlipWarning(
      "at %.6g s %s the normal stress in %" PetscInt_FMT " cells: they open, without strength%s (printed once)",
      (double)t, fault->loads.nterms ? "pore pressure and stresses in time exceed" : "the pore pressure exceeds",
      opened,
      fault->fluid.on ? ". For less pressure expected lower rates or pressures of wells, or a larger "
                        "-fault_permeability or -fault_pore_compressibility"
                      : ""));
  PetscFunctionReturn(PETSC_SUCCESS);
}
