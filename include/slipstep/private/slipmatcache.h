/* Private to src/mat: what is expensive to set up, kept in files of a directory. */
#pragma once
#include <slipstep/private/slipmatcells.h>
#include <slipstep/private/slipmatgrid.h>

/* ---- cache.c: files of a directory; collective ---- */
#define SLIP_CACHE_VERSION 2 /* of the files and of the methods; part of every key */
typedef struct {
  const char *path, *units;
  PetscInt ndim, dims[2]; /* reading: -1 for any */
  PetscReal *data;        /* rank 0 */
} SlipCacheItem;
PETSC_INTERN PetscErrorCode SlipCacheRead(Mat K, const char kind[], const char key[], PetscInt n, SlipCacheItem item[],
                                          PetscBool *found);
PETSC_INTERN PetscErrorCode SlipCacheWrite(Mat K, const char kind[], const char key[], PetscInt n,
                                           const SlipCacheItem item[]);

/* cacheroot.c: the root of a dense stiffness; root [N * N] is rank 0's */
PETSC_INTERN PetscErrorCode SlipFingerprintCompose(Mat K);
PETSC_INTERN PetscErrorCode SlipCacheLoadRoot(Mat K, PetscReal **root, PetscBool *found);
PETSC_INTERN PetscErrorCode SlipCacheSaveRoot(Mat K, PetscReal root[]);
/* The low-rank part in files, for unit factors; m[parity].n must be set. */
PETSC_INTERN PetscErrorCode SlipCacheLoad(Mat K, const SlipGrid *grid, PetscReal tolerance, PetscBool dense,
                                          SlipLowRank m[2], PetscBool *found);
PETSC_INTERN PetscErrorCode SlipCacheSave(Mat K, const SlipGrid *grid, PetscReal tolerance, PetscBool dense,
                                          const SlipLowRank m[2]);
PETSC_INTERN PetscErrorCode SlipLowRankDemote(SlipLowRank *m, PetscReal limit);
PETSC_INTERN PetscErrorCode SlipLowRankDestroy(SlipLowRank *m);
PETSC_INTERN PetscErrorCode SlipLowRankApply(SlipLowRank *m, MPI_Comm comm, PetscReal cutoff, const PetscReal x[],
                                             PetscReal y[]);
PETSC_INTERN PetscReal SlipLowRankDiagonal(const SlipLowRank *m, PetscInt i);
