/* See libraryepisode.h. */
#include "libraryepisode.h"
#include <slipcompat.h>

typedef struct {
  const LibraryEpisodes *problem;
  void *own; /* what the problem has of it */
} LibraryEpisode;

PetscErrorCode LibraryCreate(const CMAOptions *o, uint64_t seed, PetscInt side, void **episode)
{
  LibraryEpisode *e;

  PetscFunctionBegin;
  (void)side;
  PetscCall(PetscNew(&e));
  e->problem = o->problem->cma->library;
  PetscCall(PetscCalloc(e->problem->size, &e->own));
  PetscCall((*e->problem->create)(o, seed, e->own));
  *episode = e;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LibraryDestroy(void **episode)
{
  LibraryEpisode *e = (LibraryEpisode *)*episode;

  PetscFunctionBegin;
  PetscCall((*e->problem->destroy)(e->own));
  PetscCall(PetscFree(e->own));
  PetscCall(PetscFree(*episode));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode RunUnder(LibraryEpisode *e, SlipPolicy policy, TSAdaptType type, PetscReal setting,
                               EpisodeResult *r)
{
  PetscFunctionBegin;
  *r = (EpisodeResult){.done = 1};
  PetscCall((*e->problem->run)(e->own, policy, type, setting, r));
  if (r->error < 0) {
    r->error = e->problem->worst;
    r->done = 0;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LibraryRun(void *episode, SlipPolicy policy, PetscReal accuracy, EpisodeResult *r)
{
  LibraryEpisode *e = (LibraryEpisode *)episode;
  const LibraryEpisodes *p = e->problem;

  PetscFunctionBegin;
  PetscCall(RunUnder(e, policy, NULL, accuracy, r));
  r->cost = p->lost;
  if (r->done == 1)
    r->cost = PetscLogReal((PetscReal)r->solves / r->usual) +
              p->steep * PetscLogReal(PetscClipInterval(r->error / (p->free * accuracy), (PetscReal)1, p->worst));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LibraryClassical(void *episode, TSAdaptType type, PetscReal rtol, EpisodeResult *r)
{
  return RunUnder((LibraryEpisode *)episode, NULL, type, rtol, r);
}

PetscErrorCode LibrarySay(const CMAScore *score, char text[], size_t len)
{
  PetscFunctionBegin;
  PetscCall(PetscSNPrintf(text, len, "cost %7.4f  dial kept %3.0f %%  solves %6.1f  error/dial %6.3f",
                          (double)score->cost, 100 * (double)score->within, (double)score->solves,
                          (double)score->error));
  PetscFunctionReturn(PETSC_SUCCESS);
}
