/* The cells of a matrix: every combination of the options that makes sense. */
#include "evaluate.h"
#include <slipcompat.h>
#include <stdio.h>

/* Of entries that a list has twice, the first counts. */
static PetscErrorCode AddCase(const Problem *p, PetscReal size, PetscInt mesh, EvaluateMatrix *m)
{
  ProblemCase *c;
  PetscBool same;

  PetscFunctionBegin;
  PetscCall(PetscRealloc(sizeof(*c) * (size_t)(m->ncases + 1), &m->cases));
  c = &m->cases[m->ncases++];
  c->problem = p;
  c->size = size;
  c->mesh = mesh;
  if (mesh)
    snprintf(c->name, sizeof(c->name), "%s_%gkm_%dx%d", p->name, (double)size, (int)mesh, (int)mesh);
  else
    PetscCall(PetscStrncpy(c->name, p->name, sizeof(c->name)));
  for (PetscInt i = 0; i < m->ncases - 1; i++) {
    PetscCall(PetscStrcmp(m->cases[i].name, c->name, &same));
    if (same) m->ncases--;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Of one Bathe solve on one process, in units of about half a microsecond: it grows as N^1.3 with the number of
   cells. */
PetscReal EvaluateSolveWeight(const ProblemCase *c)
{
  return c->mesh ? PetscPowReal((PetscReal)(c->mesh * c->mesh), (PetscReal)1.3) : (PetscReal)40;
}

static PetscErrorCode AddCell(const EvaluateOptions *o, EvaluateMatrix *m, PetscInt instance, EvaluateCell cell)
{
  const ProblemCase *c = &m->cases[instance];
  const PetscReal each = cell.error == TSBATHE_ERROR_DOUBLING ? 3 : 1;
  PetscReal solves; /* a guess for the time left, nothing else */
  char how[EVALUATE_NAME];
  PetscBool same;

  PetscFunctionBegin;
  cell.instance = instance;
  if (cell.accuracy > 0)
    snprintf(how, sizeof(how), "rl_%.64s@%g", cell.policy->name, (double)cell.accuracy);
  else if (cell.policy)
    PetscCall(PetscSNPrintf(how, sizeof(how), "rl_%s", cell.policy->name));
  else if (cell.steps)
    PetscCall(PetscSNPrintf(how, sizeof(how), "none_%" PetscInt_FMT, cell.steps));
  else
    snprintf(how, sizeof(how), "%s_x%g", cell.controller, (double)cell.tolerance); /* PETSc's would write 1 as "1." */
  PetscCall(PetscSNPrintf(cell.path, sizeof(cell.path), "/cells/%s/%s_%s_%s", c->name, how, TSBatheErrors[cell.error],
                          TSBatheReactionTypes[cell.reaction]));
  for (PetscInt i = 0; i < m->ncells; i++) {
    PetscCall(PetscStrcmp(m->cells[i].path, cell.path, &same));
    if (same) PetscFunctionReturn(PETSC_SUCCESS);
  }
  solves = cell.steps    ? (PetscReal)cell.steps
           : cell.policy ? 25 * each
                         : (c->mesh ? 130 : 3000) * each * PetscPowReal(cell.tolerance, -1 / (PetscReal)3);
  cell.weight = solves * EvaluateSolveWeight(c) * (PetscReal)o->repetitions;
  PetscCall(PetscRealloc(sizeof(cell) * (size_t)(m->ncells + 1), &m->cells));
  m->cells[m->ncells++] = cell;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Constant steps need no estimate. Policies run with the tolerances they know. */
static PetscErrorCode AddController(const EvaluateOptions *o, EvaluateMatrix *m, PetscInt instance,
                                    const char controller[], TSBatheReactionType reaction)
{
  EvaluateCell cell = {.controller = controller, .reaction = reaction, .tolerance = 1, .error = TSBATHE_ERROR_NONE};
  PetscBool none, learned, fits;

  PetscFunctionBegin;
  PetscCall(PetscStrcmp(controller, TSADAPTNONE, &none));
  PetscCall(PetscStrcmp(controller, TSADAPTRL, &learned));
  for (PetscInt i = 0; none && i < o->nsteps; i++) {
    cell.steps = o->steps[i];
    PetscCall(AddCell(o, m, instance, cell));
  }
  for (PetscInt e = 0; !none && e < o->nerrors; e++) {
    cell.error = o->errors[e];
    for (PetscInt i = 0; learned && i < o->npolicies; i++) {
      cell.policy = &o->policies[i];
      PetscCall(PetscStrcmp(cell.policy->problem, m->cases[instance].problem->name, &fits));
      if (!fits && cell.policy->problem[0]) continue;
      for (PetscInt k = 0; k <= (cell.policy->dial ? o->naccuracies : 0); k++) {
        cell.accuracy = k ? o->accuracies[k - 1] : 0;
        PetscCall(AddCell(o, m, instance, cell));
      }
    }
    if (cell.error == TSBATHE_ERROR_NONE) continue;
    for (PetscInt i = 0; !learned && i < o->ntolerances; i++) {
      cell.tolerance = o->tolerances[i];
      PetscCall(AddCell(o, m, instance, cell));
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EvaluateMatrixCreate(const EvaluateOptions *o, EvaluateMatrix *m)
{
  PetscFunctionBegin;
  PetscCall(PetscMemzero(m, sizeof(*m)));
  for (PetscInt p = 0; p < o->nproblems; p++) {
    if (!o->problems[p]->evaluation->meshes) PetscCall(AddCase(o->problems[p], 0, 0, m));
    for (PetscInt k = 0; o->problems[p]->evaluation->meshes && k < o->nmeshes; k++)
      for (PetscInt s = 0; s < o->nsizes; s++) PetscCall(AddCase(o->problems[p], o->sizes[s], o->meshes[k], m));
  }
  for (PetscInt i = 0; i < m->ncases; i++)
    for (PetscInt k = 0; k < o->ncontrollers; k++)
      for (PetscInt r = 0; r < o->nreactions; r++)
        PetscCall(AddController(o, m, i, o->controllers[k], o->reactions[r]));
  PetscCheck(m->ncells, PETSC_COMM_WORLD, PETSC_ERR_ARG_WRONG,
             "the matrix has no cells: -evaluate_controllers and -evaluate_errors leave nothing to run");
  PetscFunctionReturn(PETSC_SUCCESS);
}
