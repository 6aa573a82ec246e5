/* Chooses the preconditioner of conjugate gradients, where the user does not.

   Processor time of a solve [ms], with the matrix of the solve before / with another one; dn: dt k/(S eta dx^2).
   On one core at 2.5 GHz, to an error of 1e-9 of the change, of two wells in a fault at rest.
                                  dn     0.01        1         100       1e4
   100 x 100 cells    ICC              3 /   8    6 /  12   36 /  38   110 / 107
                      Jacobi           2 /   5   12 /  15   61 /  64    71 /  86
                      GAMG             7 /  15   21 /  38   25 /  39    24 /  40
                      CHOLMOD          5 /  37    9 /  36    5 /  35     6 /  35
                      PETSc's Cholesky 6 /  79    5 /  53    4 /  51     4 /  57
                      MUMPS           24 /  59   23 /  60   41 /  73    23 /  78
   300 x 300 cells    ICC             25 /  57   59 /  86  477 / 577  2504 / 2877
                      Jacobi          25 /  50   73 /  86  629 / 709  2670 / 3124
                      GAMG            85 / 149  150 / 234  334 / 405   375 / 508
                      CHOLMOD         75 / 438   58 / 344   76 / 432    65 / 402
                      PETSc's Cholesky 62 /2099  51 /1228   70 /1364    53 / 1511
                      MUMPS          216 / 547  245 / 536  299 / 604   208 / 899
   100,352 triangles  ICC             36 /  59   81 / 122  559 / 587  2144 / 2238
                      GAMG           129 / 175  189 / 300  324 / 382   350 / 438
                      CHOLMOD         68 / 390   66 / 569   63 / 446    58 / 355
                      PETSc's Cholesky 39 / 599  40 / 576   44 / 597    41 / 431
   So: ICC for small steps; else a Cholesky factor on one process, which costs as much as GAMG once and a fifth again,
   as long as its time, which grows as the number of cells to the power of 1.5, is not far more; GAMG otherwise. With
   1,000,000 cells a solve takes 0.7 / 1.0 s at dn = 1 and 3.6 / 4.7 s at 1e3, with as many triangles 0.8 / 1.1 s and
   3.5 / 4.3 s; the first one 10 and 7 s. Set-up takes 2 microseconds a cell, and cells take 0.9 kB (triangles 0.6 kB),
   ICC 0.2 kB more, GAMG 0.5 to 0.7 kB, a factor of 100,000 cells 1.0 to 1.3 kB. */
#include <slipstep/private/slipfluid.h>
#include <slipstep/private/slipsys.h>

/* Steps are small below this mean of dt T/C, which is 8 dn on squares; and meshes are small up to this many cells. */
#define FLUID_SMALL_STEP 80
#define FLUID_SMALL_MESH 300000

PetscErrorCode SlipFluidSolverChoose(KSP ksp, PetscInt cells, PetscReal step)
{
  MPI_Comm comm = PetscObjectComm((PetscObject)ksp);
  const char *prefix;
  PetscMPIInt size;
  PetscBool given, same, small, factor;
  PCType type;
  PC pc;

  PetscFunctionBegin;
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(KSPGetOptionsPrefix(ksp, &prefix));
  PetscCall(SlipHasOption(NULL, prefix, "pc_type", &given));
  PetscCallMPI(MPI_Comm_size(comm, &size));
  small = step <= FLUID_SMALL_STEP ? PETSC_TRUE : PETSC_FALSE;
  factor = !small && size == 1 && cells <= FLUID_SMALL_MESH ? PETSC_TRUE : PETSC_FALSE;
  type = small && size == 1 ? PCICC : small ? PCBJACOBI : factor ? PCCHOLESKY : PCGAMG;
  PetscCall(PetscObjectTypeCompare((PetscObject)pc, type, &same));
  if (given || same) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PCSetType(pc, type));
#if defined(PETSC_HAVE_SUITESPARSE)
  if (factor) PetscCall(PCFactorSetMatSolverType(pc, MATSOLVERCHOLMOD));
#endif
  PetscCall(KSPSetFromOptions(ksp));
  if (small && size > 1) { /* whose blocks have ILU by default */
    KSP *block;
    PC inner;

    PetscCall(PCSetUp(pc)); /* KSPSetUp() would not, after another type */
    PetscCall(PCBJacobiGetSubKSP(pc, NULL, NULL, &block));
    PetscCall(KSPGetPC(block[0], &inner));
    PetscCall(PCSetType(inner, PCICC));
    PetscCall(KSPSetFromOptions(block[0]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
