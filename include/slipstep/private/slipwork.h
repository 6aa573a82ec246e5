/* The cost of a run and the distribution of its time: kinds of work, which are counted where they occur */
#pragma once
#include <petscsys.h>

/* Shares of the time of a run. All work during set-up or output belongs to these two. */
typedef enum {
  SLIP_SHARE_SETUP,
  SLIP_SHARE_PRODUCTS,
  SLIP_SHARE_DIRECT,
  SLIP_SHARE_CELLS,
  SLIP_SHARE_OBSERVATION,
  SLIP_SHARE_OUTPUT,
  SLIP_SHARES
} SlipShare;
PETSC_INTERN const char *const SlipShareNames[SLIP_SHARES];

/* Kinds of work, each with its share; src/sys/workprices.h has the price of a unit. */
#define SLIP_WORK_LIST(ROW)                                                                                            \
  ROW(RUN, SETUP)            /* runs: the process, PETSc's start and end, opening and closing of files */              \
  ROW(READ, SETUP)           /* files that are read */                                                                 \
  ROW(KERNEL, SETUP)         /* pairs of cells of a grid, by distance and depths */                                    \
  ROW(PAIR, SETUP)           /* pairs of cells of a mesh */                                                            \
  ROW(DIPPING_PAIR, SETUP)   /* pairs of dipping rectangles of a mesh */                                               \
  ROW(TRIANGLE_PAIR, SETUP)  /* pairs of triangles of a mesh */                                                        \
  ROW(MATRIX, SETUP)         /* flops of products of matrices */                                                       \
  ROW(EIGEN, SETUP)          /* eigenproblems: their rows cubed */                                                     \
  ROW(FIT, SETUP)            /* fits of kernels of waves */                                                            \
  ROW(WAVE, SETUP)           /* wavenumbers of waves */                                                                \
  ROW(PRODUCT, PRODUCTS)     /* products and applications of the preconditioner, of any size */                        \
  ROW(TRANSFORM, PRODUCTS)   /* flops of transforms */                                                                 \
  ROW(BLOCK, PRODUCTS)       /* flops of dense blocks, one per wavenumber */                                           \
  ROW(DENSE, PRODUCTS)       /* flops of dense products */                                                             \
  ROW(HIERARCHY, PRODUCTS)   /* flops of hierarchical products and of low-rank parts */                                \
  ROW(MEMORY, PRODUCTS)      /* numbers in the memory of waves, per step */                                            \
  ROW(DECAY, PRODUCTS)       /* their decay factors, for a step of another length */                                   \
  ROW(PACK, DIRECT)          /* entries of K in direct solves */                                                       \
  ROW(FACTOR, DIRECT)        /* flops of their factorisations */                                                       \
  ROW(ATTEMPT, CELLS)        /* attempts of our integrators that solve no stages */                                    \
  ROW(RATE, CELLS)           /* right-hand sides, of any size */                                                       \
  ROW(EVALUATION, CELLS)     /* other evaluations of friction, of any size */                                          \
  ROW(STRENGTH, CELLS)       /* cells in right-hand sides and other evaluations */                                     \
  ROW(BALANCE, CELLS)        /* the same for friction that always slides */                                            \
  ROW(SOURCE, CELLS)         /* cells whose pressure by a source is evaluated */                                       \
  ROW(DIFFUSION, CELLS)      /* cells in solves of the diffusion of pore fluid */                                      \
  ROW(ASSEMBLY, CELLS)       /* cells in its matrices, where permeability changes */                                   \
  ROW(VECTOR, CELLS)         /* flops of vectors, as PETSc counts them */                                              \
  ROW(OBSERVED, OBSERVATION) /* numbers of observed states */                                                          \
  ROW(PIECE, OUTPUT)         /* pieces of output */                                                                    \
  ROW(NUMBER, OUTPUT)        /* written numbers */                                                                     \
  ROW(FILE, OUTPUT)          /* created files */
#define SLIP_WORK_NAME(name, share) SLIP_WORK_##name,
typedef enum { SLIP_WORK_LIST(SLIP_WORK_NAME) SLIP_WORKS } SlipWork;
#undef SLIP_WORK_NAME
PETSC_INTERN const char *const SlipWorkNames[SLIP_WORKS];

PETSC_INTERN void SlipWorkAdd(SlipWork work, PetscReal units);
PETSC_INTERN void SlipWorkCells(PetscInt n, PetscInt components, PetscBool always_slides); /* evaluations of friction */
PETSC_INTERN PetscErrorCode SlipWorkFlops(SlipWork work, PetscLogDouble flops);            /* and logs them */
PETSC_INTERN void SlipWorkLogged(SlipWork work, PetscLogDouble flops);                     /* they are logged already */
/* Assigns the work since the last call to the present user and share. */
PETSC_INTERN void SlipWorkTake(void);
/* Leaves out flops that PETSc has counted since the last SlipWorkTake(): they are in the price of another kind. */
PETSC_INTERN void SlipWorkSkip(void);
/* From Begin to End, work of a run belongs to this share. */
PETSC_INTERN void SlipWorkBegin(SlipShare share);
PETSC_INTERN void SlipWorkEnd(void);
/* From now on work belongs to the set-up, or to a run, whatever an error has left unfinished. */
PETSC_INTERN void SlipWorkPrepare(void);
PETSC_INTERN void SlipWorkReset(void);
/* Checkpoints, which depend on a clock, and the reading of a restart are not counted. */
PETSC_INTERN void SlipWorkPause(PetscBool pause);
/* Measures the time of shares from now on, by reading a clock at each change; the time before is that of set-up. */
PETSC_INTERN void SlipWorkMeasure(void);

/* Totals of this process so far */
typedef struct {
  PetscReal units[SLIP_WORKS][SLIP_SHARES];
  PetscReal cost[SLIP_SHARES];    /* by prices [s] */
  PetscReal seconds[SLIP_SHARES]; /* processor time, if it is measured [s] */
} SlipWorkTotals;
PETSC_INTERN SlipWorkTotals SlipWorkGet(void);
PETSC_INTERN PetscReal SlipProcessorTime(void); /* of this process, of all its threads [s] */
