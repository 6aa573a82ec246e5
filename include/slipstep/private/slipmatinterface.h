/* Internal: the creators of all our matrices, which use all folders of src/mat */
#pragma once
#include <slipstep/private/slipmathmatrix.h>
#include <slipstep/private/slipmatstage.h>

/* cost [n]: cost of each cell's row in a stiffness of this type, in any unit; cellstiffness.c */
PETSC_INTERN PetscErrorCode SlipCellsCosts(const SlipCells *cells, const char type[], PetscReal cost[]);
/* Adds the forecast of K, or if whole of Kn, in a type; cellstiffness.c. order [n], count [size]: cells of each
   process, one after the other; forecast [size] */
PETSC_INTERN PetscErrorCode SlipCellsForecastOfType(const SlipCells *cells, const char type[], PetscBool whole,
                                                    PetscReal tolerance, PetscMPIInt size, const PetscInt order[],
                                                    const PetscInt count[], SlipCellsForecast forecast[]);
