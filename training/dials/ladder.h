/* Drawn episodes of a problem under classical controllers at a ladder of tolerances: what each costs, and how far off
   it is. */
#pragma once
#include "problems/problems.h"
#include "environment/cmaproblem.h"

enum {
  LADDER_PER_DECADE = 4,
  LADDER_RUNGS = 25, /* from 1 to 1e-6 */
  LADDER_BELOW = 3,  /* a controller's runs end after so many tolerances in a row with small errors */
  LADDER_MAX_CONTROLLERS = 16
};

/* A run; solves, or work [us] if the ladder counts this, 0: it was not done, as those at looser tolerances were exact
   enough, or too expensive */
typedef struct {
  PetscInt solves;
  PetscReal error; /* PETSC_MAX_REAL: it did not get to its end */
} LadderRun;

typedef struct {
  const CMAProblem *cma;
  CMAOptions o;
  PetscBool work; /* cost is counted by it, not by solves */
  PetscInt n;
  void **episode; /* [n] */
  PetscInt ncontrollers;
  char *controller[LADDER_MAX_CONTROLLERS]; /* as CMAProblem.classical takes them */
  LadderRun *run;                           /* [n][ncontrollers][LADDER_RUNGS] */
} Ladder;

/* The problem's episodes first to first + n - 1 of a stream; where it has kinds, every other one is a mesh. None has
   run. family: the Family of the draws, the caller's; NULL: the problem's own */
PETSC_INTERN PetscErrorCode LadderCreate(const Problem *problem, void *family, PetscInt seed, PetscInt stream,
                                         PetscInt first, PetscInt n, const char controllers[], Ladder *ladder);
PETSC_INTERN PetscErrorCode LadderDestroy(Ladder *ladder);
/* Climbs from the loosest tolerance until errors stay below least, or a run took more than most solves, 0: no limit.
   cut: that was so; tighter tolerances then count as no better than that run. */
PETSC_INTERN PetscErrorCode LadderClimb(Ladder *ladder, PetscInt episode, PetscInt controller, PetscReal least,
                                        PetscInt most, PetscBool *cut);
/* rtol of a rung, the loosest first */
PETSC_INTERN PetscReal LadderTolerance(PetscInt rung);
/* The cost of a run, in solves or work [us] */
PETSC_INTERN PetscInt LadderCost(const Ladder *ladder, const EpisodeResult *r);
/* A run at any tolerance, its error as above */
PETSC_INTERN PetscErrorCode LadderRunOnce(Ladder *ladder, PetscInt episode, const char controller[], PetscReal rtol,
                                          LadderRun *run);
/* The run at this rung, which is done if it has not been */
PETSC_INTERN PetscErrorCode LadderRunAt(Ladder *ladder, PetscInt episode, PetscInt controller, PetscInt rung,
                                        LadderRun *run);
/* worst [LADDER_RUNGS]: the error that the share within of the episodes keeps at a rung and at every tighter one; 0:
   small */
PETSC_INTERN void LadderWorst(const Ladder *ladder, PetscInt controller, PetscReal within, PetscReal worst[]);
/* The loosest tolerance with worst <= accuracy, between rungs by logarithms; negative: none */
PETSC_INTERN PetscReal LadderLoosest(const PetscReal worst[], PetscReal accuracy);
/* The cheapest run of one episode, chosen afterwards, whose error is at most this as it is at every tighter tolerance
   of its controller; 0: there is none */
PETSC_INTERN PetscInt LadderCheapest(const Ladder *ladder, PetscInt episode, PetscReal error);
/* Share of the episodes that a setting keeps within the accuracy, their mean solves and their median error */
typedef struct {
  PetscReal kept, solves, median;
} LadderScore;
PETSC_INTERN PetscErrorCode LadderScoreSetting(Ladder *ladder, const char controller[], PetscReal rtol,
                                               PetscReal accuracy, LadderScore *score);
PETSC_INTERN void LadderScoreRuns(PetscInt n, const LadderRun run[], PetscReal accuracy, LadderScore *score);

/* -train_algorithm tolerances (tolerances.c): the tolerance of every classical controller at which it keeps an
   accuracy, on drawn episodes of a problem or a user's family: the file of -fault_tolerances. */
#define DIAL_CONTROLLERS "heuristic,pi,dsp,basic,pi:fault_history"
PETSC_INTERN PetscErrorCode TolerancesRun(MPI_Comm comm, PetscInt *failed);
