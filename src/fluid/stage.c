/* Solves an implicit stage of diffusion (diffusion.c): conjugate gradients improve a guess. */
#include <slipstep/private/slipfluid.h>
#include <slipstep/private/slipsys.h>
#include <slipstep/private/slipwork.h>

/* Largest error of a pressure over the largest change of one by the solve, where SlipDiffusionAccuracy() allows no more
 */
#define FLUID_TOLERANCE 1e-9
/* A preconditioner serves other matrices up to this ratio of steps, and until a solve takes this many more iterations
   than the first one did, and twice as many */
#define FLUID_SIMILAR 2.0
enum { FLUID_ITERATIONS = 8, FLUID_PASSES = 8 };

/* Sets the pressures of sides from those of the cells: such that, if these were equal to the sides' on average, the
   fluxes would cancel; or changes those of SlipDiffusionBegin() so, by what the cells' have changed since. */
static PetscErrorCode Guess_SlipDiffusion(SlipDiffusion d, const PetscReal y[])
{
  const SlipFluidSides *s = &d->sides;
  const PetscReal *base = d->begun ? d->base : NULL;
  const Vec sum = base ? d->residual : d->lambda;
  const PetscBool done = d->begun && !base ? PETSC_TRUE : PETSC_FALSE;
  PetscReal *a;
  Vec local;

  PetscFunctionBegin;
  d->begun = PETSC_FALSE;
  if (done) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt i = 0; i < d->n; i++) {
    const PetscReal change = base ? y[i] - base[i] : y[i];

    for (PetscInt k = s->offset[i]; k < s->offset[i + 1]; k++) d->flux[k] = d->t[k] * change;
  }
  PetscCall(SlipDiffusionSum(d, d->flux, sum));
  PetscCall(VecGhostGetLocalForm(sum, &local));
  PetscCall(VecGetArray(local, &a));
  for (PetscInt k = 0; k < s->owned + s->ghosts; k++)
    a[k] = d->held[k] == d->held[k] ? (base ? 0 : d->held[k]) : d->sum[k] > 0 ? a[k] / d->sum[k] : 0;
  PetscCall(VecRestoreArray(local, &a));
  PetscCall(VecGhostRestoreLocalForm(sum, &local));
  if (!base) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecAXPY(d->lambda, 1, sum));
  PetscCall(VecGhostUpdateBegin(d->lambda, INSERT_VALUES, SCATTER_FORWARD));
  PetscCall(VecGhostUpdateEnd(d->lambda, INSERT_VALUES, SCATTER_FORWARD));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes all fluxes; d->residual, what is left of them at the sides for each of the cells there, which is taken from
   the fluxes; and what each cell lacks then [n] [m^3]. */
static PetscErrorCode Lacks_SlipDiffusion(SlipDiffusion d, PetscReal dt, const PetscReal b[], const PetscReal y[],
                                          PetscReal lack[])
{
  const SlipFluidSides *s = &d->sides;
  PetscReal *lambda = d->gathered, *a;
  Vec local;

  PetscFunctionBegin;
  PetscCall(VecGhostGetLocalForm(d->lambda, &local));
  PetscCall(VecGetArray(local, &a));
  for (PetscInt i = 0; i < d->n; i++) {
    const SlipFluidPieces p = SlipFluidPiecesOf(d, i);

    for (PetscInt k = 0; k < p.n; k++) lambda[k] = a[s->piece[s->offset[i] + k]];
    SlipFluidCellFlux(&d->cell[i], &p, y[i], lambda, d->flux + s->offset[i]);
  }
  PetscCall(VecRestoreArray(local, &a));
  PetscCall(VecGhostRestoreLocalForm(d->lambda, &local));
  PetscCall(SlipDiffusionSum(d, d->flux, d->residual));
  PetscCall(VecGhostGetLocalForm(d->residual, &local));
  PetscCall(VecGetArray(local, &a));
  for (PetscInt k = 0; k < s->owned + s->ghosts; k++)
    a[k] = d->held[k] == d->held[k] ? 0 : a[k] / (PetscReal)s->cells[k];
  for (PetscInt i = 0; i < d->n; i++) {
    PetscReal out = 0;

    for (PetscInt k = s->offset[i]; k < s->offset[i + 1]; k++) {
      d->flux[k] -= a[s->piece[k]];
      out += d->flux[k];
    }
    lack[i] = b[i] - d->kept[i] * y[i] - dt * out;
  }
  PetscCall(VecRestoreArray(local, &a));
  PetscCall(VecGhostRestoreLocalForm(d->residual, &local));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Solves for d->step, with the preconditioner of another matrix where it is similar and has been good enough. */
static PetscErrorCode Solve_SlipDiffusion(SlipDiffusion d, PetscReal tolerance, Vec right)
{
  const PetscReal ratio = d->made > 0 ? d->dt / d->made : 0;
  PetscBool keep = d->similar && ratio <= FLUID_SIMILAR && ratio * FLUID_SIMILAR >= 1 ? PETSC_TRUE : PETSC_FALSE;
  KSPConvergedReason reason;

  PetscFunctionBegin;
  if (d->last > 2 * d->first + FLUID_ITERATIONS) keep = PETSC_FALSE;
  if (!keep) {
    PetscCall(KSPSetReusePreconditioner(d->ksp, PETSC_FALSE));
    PetscCall(SlipFluidSolverChoose(d->ksp, d->all, d->mean));
  }
  PetscCall(KSPSetReusePreconditioner(d->ksp, keep));
  PetscCall(KSPSetTolerances(d->ksp, tolerance, 0, PETSC_DEFAULT, PETSC_DEFAULT));
  PetscCall(KSPSolve(d->ksp, right, d->step));
  PetscCall(KSPGetConvergedReason(d->ksp, &reason));
  PetscCheck(reason > 0 || reason == KSP_DIVERGED_ITS, d->comm, PETSC_ERR_NOT_CONVERGED,
             "the diffusion of fluid over %g s: %s, expected another preconditioner (-%spc_type jacobi)", (double)d->dt,
             KSPConvergedReasons[reason], d->prefix);
  PetscCall(KSPGetIterationNumber(d->ksp, &d->last));
  if (keep) PetscFunctionReturn(PETSC_SUCCESS);
  d->first = d->last;
  d->made = d->dt;
  d->similar = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Improves the pressures of cells, whose lack [n] is that of Lacks_SlipDiffusion(). */
static PetscErrorCode ImproveCells_SlipDiffusion(SlipDiffusion d, PetscReal tolerance, const PetscReal lack[],
                                                 PetscReal y[])
{
  const PetscReal *step;
  PetscReal *right;

  PetscFunctionBegin;
  PetscCall(VecGetArray(d->right, &right));
  PetscCall(PetscArraycpy(right, lack, d->n));
  PetscCall(VecRestoreArray(d->right, &right));
  PetscCall(Solve_SlipDiffusion(d, tolerance, d->right));
  PetscCall(VecGetArrayRead(d->step, &step));
  for (PetscInt i = 0; i < d->n; i++) y[i] += step[i];
  PetscCall(VecRestoreArrayRead(d->step, &step));
  PetscCall(Guess_SlipDiffusion(d, y));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Improves the pressures of sides, and of cells with them; lack [n] and d->residual are those of
   Lacks_SlipDiffusion(). */
static PetscErrorCode Improve_SlipDiffusion(SlipDiffusion d, PetscReal dt, PetscReal tolerance, PetscReal lack[],
                                            PetscReal y[])
{
  const SlipFluidSides *s = &d->sides;
  PetscReal *r, *a;
  Vec local;

  PetscFunctionBegin;
  PetscCall(VecGhostGetLocalForm(d->residual, &local));
  PetscCall(VecGetArray(local, &r));
  for (PetscInt i = 0; i < d->n; i++) { /* without what was taken from the fluxes */
    for (PetscInt k = s->offset[i]; k < s->offset[i + 1]; k++) lack[i] -= dt * r[s->piece[k]];
    lack[i] /= d->kept[i] + dt * d->total[i];
    for (PetscInt k = s->offset[i]; k < s->offset[i + 1]; k++) d->flux[k] = dt * (d->t[k] * lack[i] + r[s->piece[k]]);
  }
  PetscCall(VecRestoreArray(local, &r));
  PetscCall(VecGhostRestoreLocalForm(d->residual, &local));
  PetscCall(SlipDiffusionSum(d, d->flux, d->residual));
  PetscCall(VecGetArray(d->residual, &r));
  for (PetscInt k = 0; k < s->owned; k++)
    if (d->held[k] == d->held[k]) r[k] = 0;
  PetscCall(VecRestoreArray(d->residual, &r));
  PetscCall(Solve_SlipDiffusion(d, tolerance, d->residual));
  PetscCall(VecAXPY(d->lambda, 1, d->step));
  PetscCall(VecGhostUpdateBegin(d->lambda, INSERT_VALUES, SCATTER_FORWARD));
  PetscCall(VecGhostUpdateEnd(d->lambda, INSERT_VALUES, SCATTER_FORWARD));
  PetscCall(VecGhostUpdateBegin(d->step, INSERT_VALUES, SCATTER_FORWARD));
  PetscCall(VecGhostUpdateEnd(d->step, INSERT_VALUES, SCATTER_FORWARD));
  PetscCall(VecGhostGetLocalForm(d->step, &local));
  PetscCall(VecGetArray(local, &a));
  for (PetscInt i = 0; i < d->n; i++) {
    PetscReal in = 0;

    for (PetscInt k = s->offset[i]; k < s->offset[i + 1]; k++) in += d->t[k] * a[s->piece[k]];
    y[i] += lack[i] + dt * in / (d->kept[i] + dt * d->total[i]);
  }
  PetscCall(VecRestoreArray(local, &a));
  PetscCall(VecGhostRestoreLocalForm(d->step, &local));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipDiffusionAccuracy(SlipDiffusion d, PetscReal error)
{
  PetscFunctionBegin;
  d->accuracy = error;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipDiffusionRenew(SlipDiffusion d)
{
  PetscFunctionBegin;
  d->similar = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipDiffusionKeep(SlipDiffusion d, PetscInt stride, PetscReal x[])
{
  const SlipFluidSides *s = &d->sides;
  const PetscReal *a;
  Vec local;

  PetscFunctionBegin;
  if (d->other) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecGhostGetLocalForm(d->lambda, &local));
  PetscCall(VecGetArrayRead(local, &a));
  for (PetscInt i = 0; i < d->n; i++)
    for (PetscInt k = s->offset[i]; k < s->offset[i + 1]; k++) x[stride * i + k - s->offset[i]] = a[s->piece[k]];
  PetscCall(VecRestoreArrayRead(local, &a));
  PetscCall(VecGhostRestoreLocalForm(d->lambda, &local));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipDiffusionBegin(SlipDiffusion d, PetscInt stride, const PetscReal x[], const PetscReal y[])
{
  const SlipFluidSides *s = &d->sides;
  PetscReal *a;
  Vec local;

  PetscFunctionBegin;
  if (d->other) PetscFunctionReturn(PETSC_SUCCESS);
  d->begun = PETSC_TRUE;
  d->base = y;
  if (!x) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecGhostGetLocalForm(d->lambda, &local));
  PetscCall(VecGetArray(local, &a));
  for (PetscInt i = 0; i < d->n; i++) /* each piece belongs to a cell of this process */
    for (PetscInt k = s->offset[i]; k < s->offset[i + 1]; k++) a[s->piece[k]] = x[stride * i + k - s->offset[i]];
  PetscCall(VecRestoreArray(local, &a));
  PetscCall(VecGhostRestoreLocalForm(d->lambda, &local));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipDiffusionSolve(SlipDiffusion d, PetscReal dt, const PetscReal b[], PetscReal y[])
{
  PetscReal *start, *lack, tolerance = FLUID_TOLERANCE, allowed;

  PetscFunctionBegin;
  PetscCheck(d->set, d->comm, PETSC_ERR_ORDER, "call SlipDiffusionSet() before SlipDiffusionSolve()");
  PetscCheck(dt > 0 && !PetscIsInfReal(dt), d->comm, PETSC_ERR_ARG_OUTOFRANGE, "a step of %g s: expected more than 0",
             (double)dt);
  SlipWorkTake(); /* whether a factorisation is at hand depends on restarts, and so do flops */
  PetscCall(PetscMalloc2(d->n, &start, d->n, &lack));
  PetscCall(PetscArraycpy(start, y, d->n));
  for (PetscInt i = 0; i < d->n; i++) d->kept[i] = d->cell[i].storage + dt * d->cell[i].sink;
  PetscCall(Guess_SlipDiffusion(d, y));
  for (PetscInt pass = 0;; pass++) {
    PetscReal size[3] = {0, 0, 0}; /* of corrections, of changes, of pressures */

    PetscCall(Lacks_SlipDiffusion(d, dt, b, y, lack));
    for (PetscInt i = 0; i < d->n; i++) {
      size[0] = SlipLarger(size[0], PetscAbsReal(lack[i] / d->kept[i]));
      size[1] = SlipLarger(size[1], PetscAbsReal(y[i] - start[i]));
      size[2] = SlipLarger(size[2], PetscAbsReal(y[i]));
    }
    PetscCall(SlipAllreduceLargest(d->comm, 3, size));
    PetscCheck(!PetscIsInfOrNanReal(size[0]), d->comm, PETSC_ERR_FP,
               "the diffusion of fluid over %g s: pressures or sources are not finite", (double)dt);
    /* enough; or no more than rounding, which iterations do not lessen */
    allowed = PetscMax(FLUID_TOLERANCE * size[1], d->accuracy);
    if (size[0] <= allowed || size[0] <= 4 * PETSC_MACHINE_EPSILON * (1 + dt * d->fastest) * size[2]) break;
    PetscCheck(
      pass < FLUID_PASSES, d->comm, PETSC_ERR_NOT_CONVERGED,
      "the diffusion of fluid over %g s: after %d solves %g Pa of a change of %g Pa are wrong, expected another "
      "preconditioner (-%spc_type jacobi)",
      (double)dt, (int)pass, (double)size[0], (double)size[1], d->prefix);
    if (allowed > 0) tolerance = PetscMax(0.3 * allowed / size[0], 1e-13);
    PetscCall(SlipDiffusionAssemble(d, dt));
    if (d->other)
      PetscCall(ImproveCells_SlipDiffusion(d, PetscMin(tolerance, 0.1), lack, y));
    else
      PetscCall(Improve_SlipDiffusion(d, dt, PetscMin(tolerance, 0.1), lack, y));
  }
  for (PetscInt i = 0; i < d->n; i++) y[i] += lack[i] / d->kept[i];
  PetscCall(PetscFree2(start, lack));
  SlipWorkSkip();
  PetscFunctionReturn(PETSC_SUCCESS);
}
