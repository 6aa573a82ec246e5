/* Ruptures of small faults from a given stress, and runs of them (train -train_algorithm cmaes -train_problem rupture),
   the problem of training/policies/rupture.h5. */
#pragma once
#include "environment/family.h"
#include "common/table.h"
#include <slipstep.h>

/* The course of a run: mean slip and rate, rows of SlipCourseNode, and when each cell broke */
typedef struct {
  Table course;
  PetscInt n;
  PetscReal *broke; /* [n] when its slip passed its d_c, negative: it did not [s] */
  PetscReal *slip;  /* [n] final [m] */
  PetscInt solves, rejected;
  PetscBool good; /* it ended where it was to */
} RuptureRun;

typedef struct {
  SlipFault fault;
  PetscInt n;
  PetscReal *weaken; /* [n] d_c [m] */
  PetscReal end;     /* [s] */
  PetscReal rise;    /* of the reference, from 10 to 90 % of its slip [s] */
  PetscInt usual;    /* solves of the usual controller at a tolerance of a hundredth */
  RuptureRun reference;
} RuptureEpisode;

#define RUPTURE_REFERENCE_RTOL 1e-5 /* of pi */
/* A fault that ruptures, of 72 to 128 cells, or so many times more along either side: draws are repeated until one does. */
PETSC_INTERN PetscErrorCode RuptureEpisodeCreate(uint64_t seed, PetscInt larger, RuptureEpisode *e);
/* Of a family: rupturefamily.c draws the fault, set up, with d_c [n], to be freed, and its duration over the time in which it
   fades; fault: NULL where the draw makes no sense */
PETSC_INTERN PetscErrorCode RuptureEpisodeOfFamily(const Family *family, uint64_t seed, RuptureEpisode *e);
PETSC_INTERN PetscErrorCode RuptureDrawOfFamily(const Family *family, Random *random, SlipFault *fault, PetscInt *n,
                                                PetscReal **weaken, PetscReal *margin);
/* Of a fault that is set up, until end [s] */
PETSC_INTERN PetscErrorCode RuptureEpisodeOfFault(SlipFault fault, PetscReal end, RuptureEpisode *e);
/* Steps dt [n] [s] and one to the end. error: as of RuptureEpisodeRun(), negative where a step fails */
PETSC_INTERN PetscErrorCode RuptureEpisodeRunSteps(RuptureEpisode *e, PetscInt n, const double dt[], PetscReal *error);
PETSC_INTERN PetscErrorCode RuptureEpisodeDestroy(RuptureEpisode *e);
/* Under the policy with the dial at accuracy; without one under a classical controller with the tolerance rtol. errors: of the
   run against the reference; error: the largest by the measure of histories, and of the times at which cells break */
PETSC_INTERN PetscErrorCode RuptureEpisodeRun(RuptureEpisode *e, SlipPolicy policy, PetscReal accuracy,
                                              TSAdaptType type, PetscReal rtol, PetscInt *solves, PetscInt *rejected,
                                              PetscReal errors[], PetscReal *error);
