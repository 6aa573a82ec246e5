/* Episodes that are runs of the library itself, under a policy or a classical controller: what CMA-ES needs of them, and what a run
   costs. A problem's row names its table of these and the functions here. */
#pragma once
#include "environment/cmaproblem.h"

struct _LibraryEpisodes {
  size_t size; /* of an episode */
  PetscErrorCode (*create)(const CMAOptions *o, uint64_t seed, void *e);
  PetscErrorCode (*destroy)(void *e);
  /* Under the policy with its dial at the setting; without one under a controller of the type with the tolerance setting. It sets
     what the run took and its errors; a negative error: the run did not end. */
  PetscErrorCode (*run)(void *e, SlipPolicy policy, TSAdaptType type, PetscReal setting, EpisodeResult *r);
  PetscReal lost;  /* cost of a run that did not end */
  PetscReal free;  /* errors up to this share of the dial cost nothing, */
  PetscReal steep; /* larger ones this power of them, */
  PetscReal worst; /* up to so many times that; the error of a run that did not end */
};

PETSC_INTERN PetscErrorCode LibraryCreate(const CMAOptions *o, uint64_t seed, PetscInt side, void **episode);
PETSC_INTERN PetscErrorCode LibraryDestroy(void **episode);
/* The cost: logarithm of the solves over the usual ones, and of what the error is beyond the dial */
PETSC_INTERN PetscErrorCode LibraryRun(void *episode, SlipPolicy policy, PetscReal accuracy, EpisodeResult *r);
PETSC_INTERN PetscErrorCode LibraryClassical(void *episode, TSAdaptType type, PetscReal rtol, EpisodeResult *r);
PETSC_INTERN PetscErrorCode LibrarySay(const CMAScore *score, char text[], size_t len);
/* What the rows of these problems have in common, besides the dial */
#define LIBRARY_EPISODES                                                                                               \
  .seed = RandomStreamHashed, .first = 1, .start_counts = PETSC_TRUE, .measure = "history", .create = LibraryCreate,   \
  .destroy = LibraryDestroy, .run = LibraryRun
