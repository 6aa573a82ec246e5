/* Loops over the items of arrays, and questions about vectors, wherever the arrays are: on the processor, or on a
   device if all of them are there */
#pragma once
#include <petscts.h>

/* The loops of src/device/kernels/loops.cl: name, its arguments in order (n: a number, r: an array that is read, w: one
   that is changed, o: one all of which is written), and how many sums it computes */
/* clang-format off */
#define SLIP_LOOPS(X)                                                                                                  \
  X(CHOOSE, choose, "rrro", 0) X(MASKED_SUM, masked_sum, "rrrro", 0) X(TAKE_THIRD, take_third, "nrro", 0)              \
  X(MARK_STICKING, mark_sticking, "nw", 0) X(DROP_UNMARKED, drop_unmarked, "rw", 0)                                    \
  X(CONE_NATURAL, cone_natural, "nrrrrrwww", 0) X(CONE_FINISH, cone_finish, "nrrrww", 0)                               \
  X(CONE_REACTION, cone_reaction, "rrrw", 0) X(CONE_TURN, cone_turn, "rrw", 1)                                         \
  X(MOREAU_FIRST, moreau_first, "nrrrww", 0) X(MOREAU_SECOND, moreau_second, "nrrrrww", 0)                             \
  X(MOREAU_ERROR, moreau_error, "nnnrrrrrrw", 0)                                                                       \
  X(TAKE_BLOCK, take_block, "nnnro", 0) X(PLACE_BLOCK, place_block, "nnnrw", 0)
/* clang-format on */
#define SLIP_LOOP_PLACE(place, ...) SLIP_LOOP_##place,
typedef enum { SLIP_LOOPS(SLIP_LOOP_PLACE) SLIP_NUM_LOOPS } SlipLoop;

/* Runs a loop with its numbers and vectors, each in the order of its arguments. A vector that the loop does not use may
   be NULL. sum: local sums; NULL: none */
PETSC_INTERN PetscErrorCode SlipLoopRun(SlipLoop loop, PetscInt items, const PetscReal number[], const Vec x[],
                                        PetscReal sum[]);

/* Compares the local entries of two vectors bit by bit; on a device -0 equals 0. */
PETSC_EXTERN PetscErrorCode SlipVecSame(Vec x, Vec y, PetscBool *same);
/* Finds the first block of the largest size, c entries each, of this process, where NaN counts as the largest; size -1:
   there is none, or it is not searched, on a device. */
PETSC_INTERN PetscErrorCode SlipVecLargestBlock(Vec x, PetscInt c, PetscReal *size, PetscInt *block);
/* Finds the largest |v| of this process, of the first c numbers of blocks: that in a plane, of two or more; NaN counts
   as the largest. */
PETSC_INTERN PetscErrorCode SlipVecLargestStart(Vec x, PetscInt block, PetscInt c, PetscReal *largest);
/* Computes TSErrorWeightedNorm() of y and z. */
PETSC_INTERN PetscErrorCode SlipVecWeightedNorm(TS ts, Vec y, Vec z, PetscReal ignore, NormType type, PetscReal *norm);
/* Computes y = start + the sum of m vectors x by weight[0], and the norms of up to three other sums of these, by the
   next weights, over their tolerances, in one pass if y is on a device; done: it is. */
enum { SLIP_SUM_TERMS = 10 };
typedef struct {
  PetscBool finite;
  PetscReal most[3], squares[3]; /* of each estimate: largest ratio to its tolerance, sum of squares, */
  PetscReal count[3];            /* and entries with a tolerance, unless those of inverse */
} SlipVecsSums;
PETSC_INTERN PetscErrorCode SlipVecsSum(Vec start, PetscInt m, const Vec x[], const PetscReal weight[][SLIP_SUM_TERMS],
                                        PetscInt others, Vec absolute, Vec relative, Vec y, SlipVecsSums *sums,
                                        PetscBool *done);
/* Creates a copy of a vector of the processor on the open device. */
#define VECSLIPOPENCL "slipopencl"
PETSC_INTERN PetscErrorCode SlipVecCopyThere(Vec x, Vec *there);
