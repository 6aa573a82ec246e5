/* How large the local error of a step may be, for faults that rest and creep for years between events.

   What such runs are about are the times and the slips of events. A slip is right when it is so against d_c, in which
   strength changes; a slip rate against the largest one of the fault now, 1e-9 m/s or 1 m/s. Each cell counts by itself,
   as an event begins in a few of them. */
#include <slipstep/private/slipfault.h>
#include <slipstep/private/slipsys.h>

/* Wanted errors in units of the relative tolerance: of the slip and the state over d_c, and of the slip rate over the
   largest one, which the next steps forget unless it grows */
static const PetscReal of_slip = 1, of_rate = 10;

/*
  SlipFaultErrorNorm - the largest of the cells' errors over the wanted ones

  Collective. e: local error of a step from w0 to w1.
*/
PetscErrorCode SlipFaultErrorNorm(SlipFault fault, PetscReal rtol, Vec e, Vec w0, Vec w1, PetscReal *E)
{
  const PetscReal *a, *b, *c, *vinf = fault->field[FIELD_LOADING_RATE], *slip = fault->field[FIELD_FRICTION_SLIP];
  PetscReal largest[3] = {0, 0, 0}, fastest, tolerance = 0; /* error of slips over d_c, of rates, rate */
  const SlipArrays arrays[] = {{e, .read = &a}, {w0, .read = &b}, {w1, .read = &c}};

  PetscFunctionBegin;
  if (!PetscIsNanReal(fault->value[FAULT_RATE_TOLERANCE])) tolerance = fault->value[FAULT_RATE_TOLERANCE];
  PetscCall(SlipArraysGet(3, arrays));
  for (PetscInt i = 0; i < fault->n; i++) {
    const PetscReal error = PetscMax(PetscAbsReal(a[3 * i + 1]), PetscAbsReal(a[3 * i + 2]));
    const PetscReal rate = PetscMax(PetscAbsReal(b[3 * i]), PetscAbsReal(c[3 * i]));

    if (!(error / slip[i] <= largest[0])) largest[0] = error / slip[i]; /* takes what is no number */
    if (!(PetscAbsReal(a[3 * i]) <= largest[1])) largest[1] = PetscAbsReal(a[3 * i]);
    largest[2] = PetscMax(largest[2], PetscMax(rate, PetscAbsReal(vinf[i])));
  }
  PetscCall(SlipArraysRestore(3, arrays));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, largest, 3, MPIU_REAL, MPIU_MAX, fault->comm));
  fastest = of_rate * rtol * largest[2] + tolerance;
  *E = PetscMax(largest[0] / (of_slip * rtol), fastest > 0 ? largest[1] / fastest : 0);
  PetscFunctionReturn(PETSC_SUCCESS);
}
