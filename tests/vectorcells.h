/* The cells of tests of slip as a vector: two planes of rectangles, and the triangles that these are cut into. */
#pragma once
#include "unit.h"
#include "cells.h"
#include "triangles.h"
#include <math.h>

enum { NX = 7, NZ = 5, N = 2 * NX * NZ, T = 2 * N };

static PetscReal rectangle_data[8 * N], triangle_data[TRIANGLE_COLUMNS * T];

static inline SlipCell CellOf(const SlipCells *c, PetscInt i)
{
  return (SlipCell){.rectangle = {c->x[i], c->y[i], c->z[i], c->length[i], c->width[i], c->strike[i], c->dip[i]},
                    .rake = c->rake[i],
                    .vertices = c->vertices ? c->vertices + 9 * i : NULL};
}

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
