/* See cmaloop.h. Every process holds the same strategy; a population is spread over them, one member's runs staying on
   one process, so that results do not depend on their number. */
#include "cmaloop.h"
#include <slipstep/rooms/slipblas.h>
#include <slipcompat.h>
#include <petsctime.h>
#include <math.h>

PetscErrorCode CMALoopCreate(MPI_Comm comm, PetscInt n, PetscInt population, const double start[], double sigma,
                             CMALoop *l)
{
  PetscFunctionBegin;
  SlipBLASSetNumThreads(1);
  l->comm = comm;
  l->best = l->median = (PetscReal)NAN;
  PetscCall(PetscTime(&l->begin));
  PetscCallMPI(MPI_Comm_rank(comm, &l->rank));
  PetscCallMPI(MPI_Comm_size(comm, &l->size));
  PetscCall(CMAESCreate(n, population, start, sigma, &l->es));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CMALoopDestroy(CMALoop *l)
{
  PetscFunctionBegin;
  PetscCall(CMAESDestroy(&l->es));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CMALoopElapsed(const CMALoop *l, PetscReal *seconds)
{
  PetscLogDouble now;

  PetscFunctionBegin;
  PetscCall(PetscTime(&now));
  *seconds = l->before + (PetscReal)(now - l->begin);
  PetscCallMPI(MPI_Bcast(seconds, 1, MPIU_REAL, 0, l->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CMALoopRun(CMALoop *l, const CMALoopOps *ops, void *ctx)
{
  PetscReal seconds;
  Random random;

  PetscFunctionBegin;
  if (l->start_counts && !l->es.generation) PetscCall((*ops->validate)(ctx));
  PetscCall(CMALoopElapsed(l, &seconds));
  while (l->es.generation < l->generations && (l->minutes <= 0 || seconds < 60 * l->minutes)) {
    RandomSeed(&random, (*l->seed)(l->seeds, l->stream, l->first + l->es.generation));
    if (ops->draw) PetscCall((*ops->draw)(ctx, &random));
    CMAESSetDiagonal(&l->es, l->es.generation < l->diagonal ? PETSC_TRUE : PETSC_FALSE);
    PetscCall(CMAESGeneration(&l->es, l->comm, &random, ops->cost, ctx, &l->best, &l->median));
    if (l->es.generation % l->interval == 0) PetscCall((*ops->validate)(ctx));
    PetscCall(CMALoopElapsed(l, &seconds));
  }
  if (l->es.generation % l->interval) PetscCall((*ops->validate)(ctx));
  PetscCall((*ops->finish)(ctx));
  PetscFunctionReturn(PETSC_SUCCESS);
}
