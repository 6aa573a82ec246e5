/* The cells of tests of slip as a vector: two planes of rectangles, and the triangles that these are cut into. */
#pragma once
#include "unit.h"
#include "cells.h"
#include "triangles.h"
#include <math.h>

enum { NX = 7, NZ = 5, N = 2 * NX * NZ, T = 2 * N };

static PetscReal rectangle_data[8 * N], triangle_data[TRIANGLE_COLUMNS * T];

/* Along the rake, and its parts along strike and up dip */
static inline void PartsOf(PetscReal rake, PetscReal part[2])
{
  part[0] = PetscCosReal(rake * PETSC_PI / 180);
  part[1] = PetscSinReal(rake * PETSC_PI / 180);
}

/* The two planes with rakes that vary by more, as rectangles and as triangles with a kernel for vectors, and with the
   one for rakes */
static inline void Meshes(SlipCells vectors[2], SlipCells scalars[2])
{
  scalars[0] = TwoDippingPlanes(NX, NZ, rectangle_data);
  for (PetscInt e = 0; e < N; e++) ((PetscReal *)scalars[0].rake)[e] = 37.0 * (PetscReal)e - 200;
  scalars[1] = TrianglesOf(&scalars[0], triangle_data);
  for (int k = 0; k < 2; k++) {
    vectors[k] = scalars[k];
    vectors[k].kernel.type = k ? &SlipKernelTriangleVector : &SlipKernelDippingVector;
    vectors[k].rake = NULL;
  }
}

/* Of dense S [2 n][2 n] and Kn [n][2 n], the largest difference of P' S P and Kn P from those of slip along the rakes,
   S[1] and Kn[1], over the largest entry of the latter's stiffness */
static inline PetscReal ProjectedDifference(Mat S[2], Mat Kn[2], const PetscReal rake[])
{
  const PetscScalar *a[2] = {MatRead(S[0]), MatRead(S[1])}, *b[2] = {MatRead(Kn[0]), MatRead(Kn[1])};
  PetscReal most = 0, worst = 0;
  PetscInt n;

  ok(MatGetSize(S[1], &n, NULL));
  for (PetscInt j = 0; j < n; j++)
    for (PetscInt i = 0; i < n; i++) {
      PetscReal p[2], q[2], shear = 0, normal = 0;

      PartsOf(rake[i], p);
      PartsOf(rake[j], q);
      for (int l = 0; l < 2; l++) {
        for (int k = 0; k < 2; k++) shear += p[k] * q[l] * a[0][(2 * j + l) * 2 * n + 2 * i + k];
        normal += q[l] * b[0][(2 * j + l) * n + i];
      }
      most = PetscMax(most, PetscAbsReal(a[1][j * n + i]));
      worst = PetscMax(worst, PetscAbsReal(shear - a[1][j * n + i]));
      worst = PetscMax(worst, PetscAbsReal(normal - b[1][j * n + i]));
    }
  return worst / most;
}
