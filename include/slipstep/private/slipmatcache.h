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
PETSC_INTERN PetscErrorCode SlipCacheLoadRoot(Mat K, PetscReal **root, PetscBool *found);
PETSC_INTERN PetscErrorCode SlipCacheSaveRoot(Mat K, PetscReal root[]);
