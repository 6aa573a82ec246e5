/* Hierarchical stiffness and Lanczos' viscosity on several ranks against dense ones. Exit code 0: good. */
#include "ranks.h"
#include "cells.h"

enum { NX = 36, NZ = 20, N = 2 * NX * NZ };

static PetscReal data[5 * N];

static PetscErrorCode Compare(const char what[], Mat A, Mat B, PetscReal tolerance)
{
  PetscReal norm, error, *a;
  PetscInt start, end;
  Vec x, y, z;

  PetscFunctionBeginUser;
  PetscCall(MatCreateVecs(B, &x, &y));
  PetscCall(VecDuplicate(y, &z));
  PetscCall(VecGetOwnershipRange(x, &start, &end));
  PetscCall(VecGetArrayWrite(x, &a));
  for (PetscInt i = start; i < end; i++) a[i - start] = PetscSinReal((PetscReal)(i * i));
  PetscCall(VecRestoreArrayWrite(x, &a));
  PetscCall(MatMult(A, x, y));
  PetscCall(MatMult(B, x, z));
  PetscCall(VecNorm(z, NORM_2, &norm));
  PetscCall(VecAXPY(y, -1, z));
  PetscCall(VecNorm(y, NORM_2, &error));
  PetscCheck(error <= tolerance * norm, PETSC_COMM_WORLD, PETSC_ERR_PLIB, "%s differs by %g, expected at most %g", what,
             (double)(error / norm), (double)tolerance);
  PetscCall(VecDestroy(&x));
  PetscCall(VecDestroy(&y));
  PetscCall(VecDestroy(&z));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Storage to 1e-6 of each low-rank block, so products to that, and the root likewise, as its condition is about 50. */
static PetscErrorCode Run(void)
{
  const SlipCells cells = TwoGradedFaults(NX, NZ, 1, data);
  Mat dense, hmat, root, lanczos;

  PetscFunctionBeginUser;
  PetscCall(MatCreateSlipCellStiffness(PETSC_COMM_WORLD, &cells, "dense", 0.5, &dense));
  PetscCall(MatCreateSlipCellStiffness(PETSC_COMM_WORLD, &cells, "hmat", 1e-6, &hmat));
  PetscCall(MatView(hmat, PETSC_VIEWER_STDOUT_WORLD));
  PetscCall(Compare("hierarchical stiffness", hmat, dense, 1e-6));
  PetscCall(MatCreateSlipViscosity(dense, 7e6, 0.25, "lanczos", &root));
  PetscCall(MatCreateSlipViscosity(hmat, 7e6, 0.25, "lanczos", &lanczos));
  PetscCall(Compare("viscosity", lanczos, root, 1e-5));
  PetscCall(MatView(lanczos, PETSC_VIEWER_STDOUT_WORLD));
  PetscCall(MatDestroy(&dense));
  PetscCall(MatDestroy(&hmat));
  PetscCall(MatDestroy(&root));
  PetscCall(MatDestroy(&lanczos));
  PetscFunctionReturn(PETSC_SUCCESS);
}

int main(int argc, char **argv)
{
  return RunOnRanks(argc, argv, Run);
}
