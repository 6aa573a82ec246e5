/* Private: the creators of all our matrices, on top of the rooms of src/mat. */
#pragma once
#include <slipstep/private/slipmathmatrix.h>
#include <slipstep/private/slipmatstage.h>

/* cost [n]: what the row of each cell takes in a stiffness of this type, in any unit; cellstiffness.c */
PETSC_INTERN PetscErrorCode SlipCellsCosts(const SlipCells *cells, const char type[], PetscReal cost[]);
