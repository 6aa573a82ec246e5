/* Finds where in a step the cell stops that has most of the slip rate. With inertia its acceleration jumps there. A
   step across the jump has an error of slip that grows with the square of the step and depends on the place of the stop
   in it. A step in which the cell turns back has an error of its rate that grows with the step, and later steps do not
   correct it. Steps that end at the stop have neither error. Of many sliding cells some stop in every step and matter
   little: the error estimate covers them. */
#include <slipstep/private/slipfault.h>

/* The least share of the sum of all slip rates; and the remaining slip up to the stop, over d_c and the relative
   tolerance, below which the stop does not matter */
static const PetscReal least_share = 0.5, least_slip = 0.03;

/* Returns the root of v in (0, h] on the parabola through v0 with the slope k0 and through vm at x; at most x when vm
   is beyond the root. */
static PetscReal Root(PetscReal v0, PetscReal k0, PetscReal vm, PetscReal x, PetscReal h)
{
  const PetscReal c = (vm - v0 - k0 * x) / (x * x);
  PetscReal root, square = k0 * k0 - 4 * c * v0;

  if (vm <= 0) return k0 < 0 ? PetscMin(-v0 / k0, x) : x;
  root = square >= 0 ? 2 * v0 / (-k0 + PetscSqrtReal(square)) : h;
  return root > x && root < h ? root : h;
}

/* Returns the component of x along v, whose length is size. */
static PetscReal Component(SlipFault fault, const PetscReal v[], PetscReal size, const PetscReal x[])
{
  return fault->layout.components == 1 ? (v[0] < 0 ? -x[0] : x[0]) : SlipFaultDot(fault, v, x) / size;
}

/*
  SlipFaultStop - finds how long after the start of a step h [s] the cell with most of the slip rate stops;
  PETSC_MAX_REAL if it does not

  Collective. state: states at the shares 0, share and 1 of the step; k0: the derivative at its start. A stop before
  which slip is small against rtol d_c does not count.
*/
PetscErrorCode SlipFaultStop(SlipFault fault, PetscReal h, PetscReal rtol, PetscReal share, const Vec state[3], Vec k0,
                             PetscReal *stop)
{
  const PetscReal *a, *b, *c, *d, *slip = fault->fields.cell[FIELD_FRICTION_SLIP];
  const SlipArrays arrays[] = {
    {state[0], .read = &a}, {state[1], .read = &b}, {state[2], .read = &c}, {k0, .read = &d}};
  PetscReal sum = 0;

  PetscFunctionBegin;
  *stop = PETSC_MAX_REAL;
  PetscCall(SlipArraysGet(4, arrays));
  for (PetscInt i = 0; i < fault->mesh.n; i++) sum += fault->mesh.weight[i] * SlipFaultSpeed(fault, a, i);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPIU_REAL, MPIU_SUM, fault->comm));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    const PetscInt k = SlipFaultRateAt(fault, i);
    const PetscReal v0 = SlipFaultSpeed(fault, a, i);
    PetscReal root;

    if (v0 == 0 || Component(fault, a + k, v0, c + k) > 0 || fault->mesh.weight[i] * v0 < least_share * sum) continue;
    root = Root(v0, Component(fault, a + k, v0, d + k), Component(fault, a + k, v0, b + k), share * h, h);
    if (v0 * root > least_slip * rtol * slip[i]) *stop = PetscMin(*stop, root);
  }
  PetscCall(SlipArraysRestore(4, arrays));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, stop, 1, MPIU_REAL, MPIU_MIN, fault->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}
