/* Internal: the creators of all our matrices, which use all folders of src/mat */
#pragma once
#include <slipstep/private/slipmathmatrix.h>
#include <slipstep/private/slipmatstage.h>

/* cost [n]: cost of each cell's row in a stiffness of this type, in any unit; cellstiffness.c */
PETSC_INTERN PetscErrorCode SlipCellsCosts(const SlipCells *cells, const char type[], PetscReal cost[]);
