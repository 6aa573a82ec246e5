/* The work: references first, then cells. Those of coarse meshes and small systems are spread over the processes,
   each taking the next one when it is free; those of fine meshes run on all processes together. */
#include "evaluate.h"
#include "common/queue.h"
#include <slipcompat.h>
#include <petsctime.h>
#include <stdio.h>

/* ---- the cells of a matrix: every combination of the options that makes sense ---- */

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
static PetscReal SolveWeight(const ProblemCase *c)
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
  cell.weight = solves * SolveWeight(c) * (PetscReal)o->repetitions;
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
    cell.error = (TSBatheError)o->errors[e];
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

static PetscErrorCode MatrixCreate(const EvaluateOptions *o, EvaluateMatrix *m)
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
        PetscCall(AddController(o, m, i, o->controllers[k], (TSBatheReactionType)o->reactions[r]));
  PetscCheck(m->ncells, PETSC_COMM_WORLD, PETSC_ERR_ARG_WRONG,
             "the matrix has no cells: -evaluate_controllers and -evaluate_errors leave nothing to run");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- one job ---- */

/* A piece of work: the reference of a case (cell < 0) or a cell. */
typedef struct {
  PetscInt instance, cell;
  PetscReal weight;
} Job;

typedef struct {
  EvaluateOptions *o;
  EvaluateMatrix *m;
  PetscMPIInt rank;
  PetscInt njobs;
  Job *jobs;
  PetscReal total, before,
    done; /* weights, for the time left: of all, of finished jobs before this list, of finished jobs */
  PetscLogDouble begin;
  /* what this process has at hand: one case, set up on one communicator */
  MPI_Comm comm;
  PetscInt instance; /* -1: none */
  void *model;
  EvaluateReference reference;
  PetscReal wall_setup;
} Work;

static PetscErrorCode ReleaseJob(Work *w)
{
  PetscFunctionBegin;
  if (w->instance >= 0 && w->model) PetscCall(w->m->cases[w->instance].problem->evaluation->destroy(&w->model));
  w->model = NULL;
  w->instance = -1;
  PetscCall(EvaluateReferenceClear(&w->reference));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Report(const Work *w, PetscInt index, const char name[], const char what[])
{
  char text[32] = "an unknown time";
  PetscLogDouble now;
  PetscReal left;

  PetscFunctionBegin;
  PetscCall(PetscTime(&now));
  left = (PetscReal)(now - w->begin) * PetscMax(w->total - w->done, 0) / PetscMax(w->done, 1);
  if (w->done >= 0.01 * w->total && left < 100)
    PetscCall(PetscSNPrintf(text, sizeof(text), "%.0f s", (double)left));
  else if (w->done >= 0.01 * w->total)
    PetscCall(PetscSNPrintf(text, sizeof(text), "%.0f min", (double)left / 60));
  printf("[%d/%d] %s: %s; about %s left\n", (int)index + 1, (int)w->njobs, name, what, text);
  fflush(stdout);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode RunReference(Work *w, PetscInt index, PetscBool writes)
{
  const ProblemCase *c = &w->m->cases[w->jobs[index].instance];
  EvaluateReference ref = {0};
  char what[128];

  PetscFunctionBegin;
  PetscCall(EvaluateRunReference(w->o, w->comm, c, w->model, &ref));
  w->done += w->jobs[index].weight;
  if (writes) {
    PetscCall(EvaluateFileWriteReference(w->o, c, &ref));
    if (ref.steps)
      PetscCall(PetscSNPrintf(what, sizeof(what), "%d steps, half as many differ by %.2g, %.1f s", (int)ref.steps,
                              (double)PetscMax(PetscAbsReal(ref.self_final), ref.self_max), (double)ref.wall));
    else
      PetscCall(PetscSNPrintf(what, sizeof(what), "exact solution"));
    PetscCall(Report(w, index, c->name, what));
  }
  PetscCall(EvaluateReferenceClear(&ref));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode RunCell(Work *w, PetscInt index, PetscBool writes)
{
  const ProblemCase *c = &w->m->cases[w->jobs[index].instance];
  EvaluateCell *cell = &w->m->cells[w->jobs[index].cell];
  EvaluateResult r = {.wall_setup = w->wall_setup};
  char what[640];

  PetscFunctionBegin;
  PetscCall(EvaluateRunCell(w->o, w->comm, c, w->model, cell, &w->reference, &r));
  w->done += w->jobs[index].weight;
  if (writes) {
    PetscCall(EvaluateFileWriteCell(w->o, c, cell, &r));
    if (r.converged)
      PetscCall(PetscSNPrintf(what, sizeof(what), "%d solves, error %.3g at the end, %.3g at most, %.3g s",
                              (int)r.solves, (double)PetscAbsReal(r.final_error), (double)r.max_error, (double)r.wall));
    else
      PetscCall(PetscSNPrintf(what, sizeof(what), "FAILED, %s", r.reason));
    PetscCall(Report(w, index, cell->path + 7, what));
  }
  if (!r.converged) PetscCall(ReleaseJob(w)); /* what a failed run has left in there is not known */
  PetscCall(EvaluateResultClear(&r));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* What precedes it in the list is taken for done, as the others work too. Its case is set up unless it is at hand. */
static PetscErrorCode RunJob(Work *w, MPI_Comm comm, PetscInt index)
{
  const PetscBool writes = comm == PETSC_COMM_SELF || !w->rank ? PETSC_TRUE : PETSC_FALSE;
  const Job *job = &w->jobs[index];
  const ProblemCase *c = &w->m->cases[job->instance];
  PetscLogDouble begin, end;

  PetscFunctionBegin;
  w->done = w->before;
  for (PetscInt i = 0; i < index; i++) w->done += w->jobs[i].weight;
  if (w->instance != job->instance || w->comm != comm) {
    PetscCall(ReleaseJob(w));
    w->comm = comm;
    w->instance = job->instance;
    PetscCall(PetscTime(&begin));
    PetscCall(c->problem->evaluation->create(comm, c, &w->model));
    PetscCall(PetscTime(&end));
    w->wall_setup = (PetscReal)(end - begin);
  }
  if (job->cell >= 0 && !w->reference.series.n) PetscCall(EvaluateFileReadReference(w->o, c, &w->reference));
  if (job->cell < 0)
    PetscCall(RunReference(w, index, writes));
  else
    PetscCall(RunCell(w, index, writes));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- all jobs ---- */

static PetscBool IsSpread(const Work *w, const Job *job)
{
  const ProblemCase *c = &w->m->cases[job->instance];

  return !c->problem->evaluation->meshes || c->mesh <= w->o->spread ? PETSC_TRUE : PETSC_FALSE;
}

static PetscErrorCode OutOfTime(const Work *w, PetscBool *out)
{
  PetscLogDouble now;

  PetscFunctionBegin;
  PetscCall(PetscTime(&now));
  *out = w->o->time_limit > 0 && now - w->begin > w->o->time_limit ? PETSC_TRUE : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode WorkThrough(Work *w)
{
  Queue queue;
  PetscInt next = 0;
  PetscBool out;

  PetscFunctionBegin;
  PetscCall(QueueCreate(PETSC_COMM_WORLD, 1, &queue));
  while (PETSC_TRUE) {
    PetscCall(QueueRaise(&queue, 0, 1, &next));
    PetscCall(OutOfTime(w, &out));
    if (next >= w->njobs || out) break;
    if (!IsSpread(w, &w->jobs[next])) continue;
    PetscCall(RunJob(w, PETSC_COMM_SELF, next));
  }
  PetscCall(QueueDestroy(&queue));
  PetscCall(ReleaseJob(w));
  for (PetscInt i = 0; i < w->njobs; i++) {
    if (IsSpread(w, &w->jobs[i])) continue;
    PetscCall(OutOfTime(w, &out));
    PetscCallMPI(MPI_Bcast(&out, 1, MPIU_BOOL, 0, PETSC_COMM_WORLD));
    if (out) break;
    PetscCall(RunJob(w, PETSC_COMM_WORLD, i));
  }
  PetscCall(ReleaseJob(w));
  PetscCallMPI(MPI_Barrier(PETSC_COMM_WORLD));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* What the file holds, as rank 0 sees it. */
static PetscErrorCode Look(const Work *w, PetscBool reference[], EvaluateState cell[])
{
  PetscErrorCode ierr = PETSC_SUCCESS;

  PetscFunctionBegin;
  if (!w->rank) ierr = EvaluateFileKnown(w->o, w->m, reference, cell);
  PetscCall(SlipErrorBcast(PETSC_COMM_WORLD, ierr));
  PetscCallMPI(MPI_Bcast(reference, (PetscMPIInt)w->m->ncases, MPIU_BOOL, 0, PETSC_COMM_WORLD));
  PetscCallMPI(MPI_Bcast(cell, (PetscMPIInt)((size_t)w->m->ncells * sizeof(*cell)), MPI_BYTE, 0, PETSC_COMM_WORLD));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Summary(const Work *w, PetscInt before, const EvaluateState cell[])
{
  PetscInt known = 0, bad = 0;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < w->m->ncells; i++) {
    known += cell[i].known;
    bad += cell[i].known && cell[i].failed;
  }
  PetscCall(PetscPrintf(PETSC_COMM_WORLD,
                        "%s: %" PetscInt_FMT " cells of this matrix, %" PetscInt_FMT " were there, %" PetscInt_FMT
                        " failed, %" PetscInt_FMT " left%s\n",
                        w->o->output, w->m->ncells, before, bad, w->m->ncells - known,
                        known < w->m->ncells ? ": the same command goes on" : ""));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EvaluateWork(EvaluateOptions *o)
{
  EvaluateMatrix matrix, *m = &matrix;
  Work w = {.o = o, .m = m, .instance = -1};
  PetscBool *reference, *needed;
  EvaluateState *cell, *now;
  PetscInt before = 0, outdated = 0;
  PetscErrorCode ierr = PETSC_SUCCESS;

  PetscFunctionBegin;
  PetscCall(MatrixCreate(o, m));
  PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &w.rank));
  PetscCall(PetscTime(&w.begin));
  PetscCall(PetscCalloc5(m->ncases, &reference, m->ncells, &cell, m->ncells, &now, m->ncases, &needed,
                         m->ncases + m->ncells, &w.jobs));
  if (!w.rank) ierr = EvaluateFileCheck(o);
  PetscCall(SlipErrorBcast(PETSC_COMM_WORLD, ierr));
  PetscCall(Look(&w, reference, cell));
  for (PetscInt i = 0; i < m->ncells; i++) {
    if (o->repeat_failed && cell[i].failed) cell[i].known = PETSC_FALSE;
    before += cell[i].known;
    outdated += cell[i].outdated;
    if (!cell[i].known) needed[m->cells[i].instance] = PETSC_TRUE;
    if (!cell[i].known) w.total += m->cells[i].weight;
  }
  if (o->list) {
    for (PetscInt i = 0; i < m->ncells; i++)
      PetscCall(PetscPrintf(PETSC_COMM_WORLD, "%-8s %s\n",
                            cell[i].outdated ? "outdated"
                            : cell[i].failed ? "failed"
                            : cell[i].known  ? "done"
                                             : "missing",
                            m->cells[i].path + 7));
  } else {
    if (outdated)
      PetscCall(PetscPrintf(PETSC_COMM_WORLD,
                            "%s: %" PetscInt_FMT " cells were made with other files of their policies' names and are "
                            "made anew\n",
                            o->output, outdated));
    for (PetscInt i = 0; i < m->ncases; i++) {
      const ProblemCase *c = &m->cases[i];

      if (reference[i] || !needed[i]) continue;
      PetscCheck(
        o->reference_steps, PETSC_COMM_WORLD, PETSC_ERR_ARG_WRONGSTATE,
        "-evaluate_reference_steps is 0, but %s has no reference of %s; expected one there, or a number of steps",
        o->output, c->name);
      w.jobs[w.njobs++] = (Job){i, -1,
                                c->problem->evaluation->exact
                                  ? (PetscReal)1e-3
                                  : (PetscReal)1.5 * (PetscReal)EvaluateReferenceSteps(o, c) * SolveWeight(c)};
    }
    for (PetscInt i = 0; i < w.njobs; i++) w.total += w.jobs[i].weight;
    if (w.njobs) PetscCall(WorkThrough(&w)); /* cells need them */
    for (PetscInt i = 0; i < w.njobs; i++) w.before += w.jobs[i].weight;
    PetscCall(Look(&w, reference, now));
    w.njobs = 0;
    for (PetscInt i = 0; i < m->ncells; i++)
      if (!cell[i].known && reference[m->cells[i].instance])
        w.jobs[w.njobs++] = (Job){m->cells[i].instance, i, m->cells[i].weight};
    if (w.njobs) PetscCall(WorkThrough(&w));
    PetscCall(Look(&w, reference, cell));
    PetscCall(Summary(&w, before, cell));
  }
  PetscCall(PetscFree5(reference, cell, now, needed, w.jobs));
  PetscCall(PetscFree(m->cases));
  PetscCall(PetscFree(m->cells));
  PetscFunctionReturn(PETSC_SUCCESS);
}
