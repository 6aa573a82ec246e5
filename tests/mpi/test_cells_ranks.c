/* Hierarchical stiffness and Lanczos' viscosity on several ranks against dense ones. Exit code 0: good. */
#include "ranks.h"
#include "cells.h"
#include "products.h"

enum { NX = 36, NZ = 20, N = 2 * NX * NZ };

static PetscReal data[5 * N];

static PetscErrorCode Compare(const char what[], Mat A, Mat B, PetscReal tolerance)
{
  PetscReal error, *a;
  PetscInt start, end;
  Vec x;

  PetscFunctionBeginUser;
  PetscCall(MatCreateVecs(B, &x, NULL));
  PetscCall(VecGetOwnershipRange(x, &start, &end));
  PetscCall(VecGetArrayWrite(x, &a));
  for (PetscInt i = start; i < end; i++) a[i - start] = PetscSinReal((PetscReal)(i * i));
  PetscCall(VecRestoreArrayWrite(x, &a));
  PetscCall(ProductDistance(A, B, x, &error));
  PetscCheck(error <= tolerance, PETSC_COMM_WORLD, PETSC_ERR_PLIB, "%s differs by %g, expected at most %g", what,
             (double)error, (double)tolerance);
  PetscCall(VecDestroy(&x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Storage to 1e-6 of each low-rank block, so products to that, and the root likewise, as its condition is about 50. */
static PetscErrorCode Run(void)
{
  const SlipCells cells = TwoGradedFaults(NX, NZ, 1, data);
  Mat dense, hmat, root, lanczos, *const all[] = {&dense, &hmat, &root, &lanczos};

  PetscFunctionBeginUser;
  PetscCall(MatCreateSlipCellStiffness(PETSC_COMM_WORLD, &cells, "dense", 0.5, &dense));
  PetscCall(MatCreateSlipCellStiffness(PETSC_COMM_WORLD, &cells, "hmat", 1e-6, &hmat));
  PetscCall(MatView(hmat, PETSC_VIEWER_STDOUT_WORLD));
  PetscCall(Compare("hierarchical stiffness", hmat, dense, 1e-6));
  PetscCall(MatCreateSlipViscosity(dense, 7e6, 0.25, "lanczos", &root));
  PetscCall(MatCreateSlipViscosity(hmat, 7e6, 0.25, "lanczos", &lanczos));
  PetscCall(Compare("viscosity", lanczos, root, 1e-5));
  PetscCall(MatView(lanczos, PETSC_VIEWER_STDOUT_WORLD));
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(all); i++) PetscCall(MatDestroy(all[i]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

SLIP_RANKS(Run)
