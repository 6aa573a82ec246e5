/* A small seeded random generator: xoshiro256++ (Blackman & Vigna 2021) seeded by splitmix64; normals by Box-Muller.
   The whole state is this struct, so a checkpoint that stores it continues the same stream bit by bit. */
#pragma once
#include <petscsys.h>
#include <stdint.h>

typedef struct {
  uint64_t s[4];
  double spare;       /* second normal of the last Box-Muller pair */
  uint64_t has_spare; /* 1 when spare is to be returned next */
} Random;

PETSC_INTERN void RandomSeed(Random *r, uint64_t seed);
PETSC_INTERN double RandomUniform(Random *r);                      /* [0, 1) */
PETSC_INTERN double RandomNormal(Random *r);                       /* N(0, 1) */
PETSC_INTERN uint64_t RandomIndex(Random *r, uint64_t n);          /* 0 .. n-1 */
PETSC_INTERN double RandomLog(Random *r, double low, double high); /* log-uniform in [low, high] */
/* Seeds of the k-th of a stream of things that are drawn, of all trainings with one seed: by counting, streams being a
   million apart, or by hashing */
PETSC_INTERN uint64_t RandomStream(PetscInt seed, PetscInt stream, PetscInt64 k);
PETSC_INTERN uint64_t RandomStreamHashed(PetscInt seed, PetscInt stream, PetscInt64 k);
