/* The constraint of a linear system B x - load in r, |r| <= q, for problems of tests; a context that starts with a
   LinearSystem passes these operations on. */
#pragma once
#include <slipstep/rooms.h>
#include <slipcompat.h>

typedef struct {
  Mat B;
  Vec load;
  PetscReal q;       /* LinearBound()'s, the same in all rows */
  PetscInt products; /* with B, of residuals */
} LinearSystem;

static inline PetscErrorCode LinearResidual(SlipConstraint con, Vec x, Vec g, void *ctx)
{
  LinearSystem *s = (LinearSystem *)ctx;

  s->products++;
  PetscCall(MatMult(s->B, x, g));
  return VecAXPY(g, -1, s->load);
}

static inline PetscErrorCode LinearJacobian(SlipConstraint con, Vec x, Mat *B, void *ctx)
{
  *B = ((LinearSystem *)ctx)->B;
  return PETSC_SUCCESS;
}

static inline PetscErrorCode LinearBound(SlipConstraint con, Vec x, Vec q, Vec dq, void *ctx)
{
  PetscCall(VecSet(q, ((LinearSystem *)ctx)->q));
  if (dq) PetscCall(VecZeroEntries(dq));
  return PETSC_SUCCESS;
}

/* A solver of the type for stages of a constraint, with linear systems of up to so many rows direct, others by Krylov's
   methods */
static inline PetscErrorCode CreateSolver(SlipConstraint con, SNESType type, const char direct_max[], SNES *snes)
{
  PetscCall(PetscOptionsSetValue(NULL, "-snes_slip_direct_max", direct_max));
  PetscCall(SNESCreate(PetscObjectComm((PetscObject)con), snes));
  PetscCall(SNESSetType(*snes, type));
  PetscCall(SNESSetSlipConstraint(*snes, con));
  PetscCall(SNESSetFromOptions(*snes));
  return PetscOptionsClearValue(NULL, "-snes_slip_direct_max");
}
