/* See ladder.h. */
#include "ladder.h"
#include <slipcompat.h>

static LadderRun *Rungs(const Ladder *l, PetscInt episode, PetscInt controller)
{
  return l->run + (episode * l->ncontrollers + controller) * LADDER_RUNGS;
}

PetscReal LadderTolerance(PetscInt rung)
{
  return PetscPowReal(10, -(PetscReal)rung / LADDER_PER_DECADE);
}

PetscErrorCode LadderCreate(const Problem *problem, void *family, PetscInt seed, PetscInt stream, PetscInt first,
                            PetscInt n, const char controllers[], Ladder *l)
{
  char **names;

  PetscFunctionBegin;
  PetscCheck(problem->cma->classical, PETSC_COMM_SELF, PETSC_ERR_SUP,
             "-train_problem %s has no runs under classical controllers", problem->name);
  *l = (Ladder){.cma = problem->cma, .n = n, .o = {.problem = problem, .family = family}};
  if (l->cma->setup) PetscCall((*l->cma->setup)(&l->o));
  PetscCall(PetscStrToArray(controllers, ',', &l->ncontrollers, &names));
  PetscCheck(l->ncontrollers >= 1 && l->ncontrollers <= LADDER_MAX_CONTROLLERS, PETSC_COMM_SELF,
             PETSC_ERR_ARG_OUTOFRANGE, "controllers %s: expected 1 to %d", controllers, LADDER_MAX_CONTROLLERS);
  for (PetscInt c = 0; c < l->ncontrollers; c++) PetscCall(PetscStrallocpy(names[c], &l->controller[c]));
  PetscCall(PetscStrToArrayDestroy((int)l->ncontrollers, names));
  PetscCall(PetscCalloc2(n, &l->episode, n * l->ncontrollers * LADDER_RUNGS, &l->run));
  for (PetscInt k = 0; k < n; k++)
    PetscCall((*l->cma->create)(&l->o, (*l->cma->seed)(seed, stream, first + k),
                                l->cma->kinds && (first + k) % 2 == 0 ? 1 : l->o.side, &l->episode[k]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LadderDestroy(Ladder *l)
{
  PetscFunctionBegin;
  for (PetscInt k = 0; k < l->n; k++) PetscCall((*l->cma->destroy)(&l->episode[k]));
  for (PetscInt c = 0; c < l->ncontrollers; c++) PetscCall(PetscFree(l->controller[c]));
  for (PetscInt i = 0; i < l->o.nobs; i++) PetscCall(PetscFree(l->o.names[i]));
  PetscCall(PetscFree2(l->episode, l->run));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscInt LadderCost(const Ladder *l, const EpisodeResult *r)
{
  return PetscMax(l->work ? (PetscInt)PetscCeilReal(r->work) : r->solves, 1);
}

PetscErrorCode LadderRunOnce(Ladder *l, PetscInt episode, const char controller[], PetscReal rtol, LadderRun *run)
{
  EpisodeResult r;

  PetscFunctionBegin;
  PetscCall((*l->cma->classical)(l->episode[episode], controller, rtol, &r));
  run->solves = LadderCost(l, &r);
  run->error = r.done < 1 || PetscIsInfOrNanReal(r.error) ? PETSC_MAX_REAL : r.error;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LadderRunAt(Ladder *l, PetscInt episode, PetscInt controller, PetscInt rung, LadderRun *run)
{
  LadderRun *known = &Rungs(l, episode, controller)[rung];

  PetscFunctionBegin;
  if (!known->solves) PetscCall(LadderRunOnce(l, episode, l->controller[controller], LadderTolerance(rung), known));
  *run = *known;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LadderClimb(Ladder *l, PetscInt episode, PetscInt controller, PetscReal least, PetscInt most,
                           PetscBool *cut)
{
  PetscInt below = 0, k = 0;
  LadderRun run = {0, 0};

  PetscFunctionBegin;
  *cut = PETSC_FALSE;
  for (; k < LADDER_RUNGS && below < LADDER_BELOW && !*cut; k++) {
    PetscCall(LadderRunAt(l, episode, controller, k, &run));
    below = run.error < least ? below + 1 : 0;
    *cut = most > 0 && run.solves > most && below < LADDER_BELOW ? PETSC_TRUE : PETSC_FALSE;
  }
  for (; k < LADDER_RUNGS && *cut; k++) Rungs(l, episode, controller)[k] = (LadderRun){0, run.error};
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The value that the share within of them is at most, of x in any order, which is sorted */
static PetscReal Quantile(PetscInt n, PetscReal x[], PetscReal within)
{
  const PetscInt k = (PetscInt)PetscCeilReal(within * (PetscReal)n - PETSC_SMALL);

  if (PetscSortReal(n, x)) return PETSC_MAX_REAL;
  return x[PetscClipInterval(k, 1, n) - 1];
}

void LadderWorst(const Ladder *l, PetscInt controller, PetscReal within, PetscReal worst[])
{
  PetscReal *x;

  if (PetscMalloc1(l->n, &x)) return;
  for (PetscInt k = LADDER_RUNGS - 1; k >= 0; k--) {
    for (PetscInt e = 0; e < l->n; e++) x[e] = Rungs(l, e, controller)[k].error;
    worst[k] = PetscMax(Quantile(l->n, x, within), k + 1 < LADDER_RUNGS ? worst[k + 1] : 0);
  }
  (void)PetscFree(x);
}

PetscReal LadderLoosest(const PetscReal worst[], PetscReal accuracy)
{
  PetscInt k = 0;
  PetscReal share = 0;

  while (k < LADDER_RUNGS && worst[k] > accuracy) k++;
  if (k == LADDER_RUNGS) return -1;
  if (k > 0 && worst[k] > 0)
    share = PetscLogReal(accuracy / worst[k]) / PetscLogReal(PetscMin(worst[k - 1], (PetscReal)1e3) / worst[k]);
  return LadderTolerance(k) * PetscPowReal(10, share / LADDER_PER_DECADE);
}

PetscInt LadderCheapest(const Ladder *l, PetscInt episode, PetscReal error)
{
  PetscInt best = 0;

  for (PetscInt c = 0; c < l->ncontrollers; c++) {
    const LadderRun *run = Rungs(l, episode, c);

    for (PetscInt k = LADDER_RUNGS - 1; k >= 0 && run[k].error <= error; k--)
      if (run[k].solves && (!best || run[k].solves < best)) best = run[k].solves;
  }
  return best;
}

void LadderScoreRuns(PetscInt n, const LadderRun run[], PetscReal accuracy, LadderScore *score)
{
  PetscReal *x;

  *score = (LadderScore){0, 0, 0};
  if (PetscMalloc1(n, &x)) return;
  for (PetscInt e = 0; e < n; e++) {
    x[e] = run[e].error;
    score->kept += run[e].error <= accuracy ? 1 / (PetscReal)n : 0;
    score->solves += (PetscReal)run[e].solves / (PetscReal)n;
  }
  score->median = Quantile(n, x, (PetscReal)0.5);
  (void)PetscFree(x);
}

PetscErrorCode LadderScoreSetting(Ladder *l, const char controller[], PetscReal rtol, PetscReal accuracy,
                                  LadderScore *score)
{
  LadderRun *run;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(l->n, &run));
  for (PetscInt e = 0; e < l->n; e++) PetscCall(LadderRunOnce(l, e, controller, rtol, &run[e]));
  LadderScoreRuns(l->n, run, accuracy, score);
  PetscCall(PetscFree(run));
  PetscFunctionReturn(PETSC_SUCCESS);
}
