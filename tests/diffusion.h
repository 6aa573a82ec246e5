/* Meshes on which fluid diffuses, steps of second order, and errors of cells' means. */
#pragma once
#include <slipstep/private/slipmesh.h>
#include <slipstep/rooms/slipfluid.h>
#include <slipstep/rooms/sliph5.h>
#include "objects.h"
#include <math.h>

/* A fault with equal storage and mobility per area: diffusivity along strike is along/storage */
typedef struct {
  PetscReal storage, along, down; /* [m/Pa], [m^3/(Pa s)] */
  PetscReal border;               /* pressure there [Pa]; NaN: closed */
} FluidRock;

typedef struct {
  SlipFaultMesh mesh;
  SlipDiffusion d;
  PetscReal *storage, *source, *p, *work; /* [n] of cells [m^3/Pa], [m^3/s], [Pa] */
} Fluid;

/* file: "" for a grid of these cells and lengths whose upper edge begins at x = y = 0 in this depth */
static inline PetscErrorCode FluidMesh(MPI_Comm comm, const char file[], const PetscReal extent[MESH_REALS],
                                       SlipFaultMesh *mesh)
{
  const SlipFaultMeshOptions o = {.comm = comm,
                                  .prefix = "",
                                  .file = file,
                                  .frame = "",
                                  .unit = "m",
                                  .type = "hmat",
                                  .fields = "cells vertices triangles fault",
                                  .extent = extent,
                                  .rectangles = {&SlipKernelDipping, 30e9, 0.25, PETSC_TRUE, SLIP_AVERAGE_CENTRE, NULL},
                                  .triangles = {&SlipKernelTriangle, 30e9, 0.25, PETSC_TRUE, SLIP_AVERAGE_CENTRE, NULL},
                                  .block = 3};

  PetscCall(PetscMemzero(mesh, sizeof(*mesh)));
  return SlipFaultMeshCreate(&o, mesh);
}

static inline PetscErrorCode FluidSet(Fluid *f, const FluidRock *rock)
{
  const PetscInt n = f->mesh.n;
  PetscReal *c;
  SlipDiffusionCells cells;

  PetscCall(PetscMalloc1(3 * n, &c));
  for (PetscInt i = 0; i < n; i++) {
    SlipFaultCell cell;

    f->mesh.kind->cell(&f->mesh, SlipFaultMeshRow(&f->mesh, i), &cell);
    f->storage[i] = rock->storage * cell.size[0] * cell.size[1];
    c[i] = rock->along;
    c[n + i] = rock->down;
    c[2 * n + i] = rock->border;
  }
  cells = (SlipDiffusionCells){.storage = f->storage, .along = c, .down = c + n, .border = c + 2 * n};
  PetscCall(SlipDiffusionSet(f->d, &cells));
  return PetscFree(c);
}

static inline PetscErrorCode FluidCreate(MPI_Comm comm, const char file[], const PetscReal extent[MESH_REALS],
                                         const FluidRock *rock, Fluid *f)
{
  PetscCall(FluidMesh(comm, file, extent, &f->mesh));
  PetscCall(SlipDiffusionCreate(&f->mesh, "", &f->d));
  PetscCall(PetscCalloc4(f->mesh.n, &f->storage, f->mesh.n, &f->source, f->mesh.n, &f->p, 2 * f->mesh.n, &f->work));
  return FluidSet(f, rock);
}

static inline PetscErrorCode FluidDestroy(Fluid *f)
{
  PetscCall(SlipDiffusionDestroy(&f->d));
  PetscCall(PetscFree4(f->storage, f->source, f->p, f->work));
  return SlipFaultMeshDestroy(&f->mesh);
}

/* One step of the second order SDIRK method, with gamma = 1 - 1/sqrt(2) */
static inline PetscErrorCode FluidStep(Fluid *f, PetscReal dt)
{
  const PetscReal gamma = 1 - PetscSqrtReal(0.5);
  const PetscInt n = f->mesh.n;
  PetscReal *b = f->work, *y = f->work + n;

  PetscCall(PetscArraycpy(y, f->p, n));
  for (PetscInt i = 0; i < n; i++) b[i] = f->storage[i] * f->p[i] + gamma * dt * f->source[i];
  PetscCall(SlipDiffusionSolve(f->d, gamma * dt, b, y));
  for (PetscInt i = 0; i < n; i++)
    b[i] = f->storage[i] * (f->p[i] + (1 - gamma) / gamma * (y[i] - f->p[i])) + gamma * dt * f->source[i];
  PetscCall(SlipDiffusionSolve(f->d, gamma * dt, b, y));
  return PetscArraycpy(f->p, y, n);
}

/* Volume stored at a pressure in all cells of all processes [m^3] */
static inline PetscErrorCode FluidStored(const Fluid *f, PetscReal *stored)
{
  *stored = 0;
  for (PetscInt i = 0; i < f->mesh.n; i++) *stored += f->storage[i] * f->p[i];
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, stored, 1, MPIU_REAL, MPIU_SUM, f->mesh.comm));
  return PETSC_SUCCESS;
}

/* Mean of a function over a cell: 3 x 3 points of Gauss-Legendre on rectangles; on triangles the 7 points of Radon,
   exact to degree 5 */
static inline PetscReal FluidMean(const SlipFaultCell *c, PetscReal (*f)(const PetscReal at[3], const void *ctx),
                                  const void *ctx)
{
  const PetscReal q = sqrt(0.6), root = sqrt(15.0);
  PetscReal sum = 0;

  if (!c->vertices) {
    for (int i = 0; i < 9; i++) {
      const PetscReal s = q * (i % 3 - 1), t = q * (i / 3 - 1);
      PetscReal at[3];

      for (int k = 0; k < 3; k++)
        at[k] = c->centre[k] + 0.5 * (s * c->size[0] * c->direction[0][k] + t * c->size[1] * c->direction[1][k]);
      sum += (i % 3 == 1 ? 8 : 5) * (i / 3 == 1 ? 8 : 5) / 324.0 * f(at, ctx);
    }
    return sum;
  }
  sum = 9.0 / 40 * f(c->centre, ctx);
  for (int i = 0; i < 6; i++) {
    const PetscReal a = (6 + (i < 3 ? root : -root)) / 21, w = (155 + (i < 3 ? root : -root)) / 1200;
    PetscReal at[3];

    for (int k = 0; k < 3; k++) at[k] = a * 3 * c->centre[k] + (1 - 3 * a) * c->vertices[3 * (i % 3) + k];
    sum += w * f(at, ctx);
  }
  return sum;
}

/* Triangles of a plane or of several that one formula places: nx x nz squares of the parameters (0 .. 1) x (0 .. 1),
   each
   cut in two, whose inner vertices are moved by up to shake/2 of a square */
static inline PetscErrorCode FluidTriangles(const char file[], PetscInt nx, PetscInt nz, PetscReal shake,
                                            void (*place)(const PetscReal from[2], PetscReal to[3]))
{
  const PetscInt vertices[2] = {(nx + 1) * (nz + 1), 3}, triangles[2] = {2 * nx * nz, 3};
  uint64_t last = 33;
  PetscReal *vertex;
  PetscInt *corner;
  SlipH5 h;

  PetscCall(PetscMalloc2(3 * vertices[0], &vertex, 3 * triangles[0], &corner));
  for (PetscInt v = 0; v < vertices[0]; v++) {
    const PetscInt i = v % (nx + 1), k = v / (nx + 1);
    PetscReal at[2] = {(PetscReal)i / nx, (PetscReal)k / nz};

    for (int j = 0; j < 2; j++) {
      last = last * 6364136223846793005u + 1442695040888963407u;
      if (i > 0 && i < nx && k > 0 && k < nz)
        at[j] += shake * ((PetscReal)(last >> 11) / 9007199254740992.0 - 0.5) / (j ? nz : nx);
    }
    place(at, vertex + 3 * v);
  }
  for (PetscInt q = 0; q < nx * nz; q++) {
    const PetscInt i = q % nx, k = q / nx, a = k * (nx + 1) + i, b = a + 1, c = a + nx + 1, e = c + 1;
    const PetscInt odd[6] = {a, b, e, a, e, c}, even[6] = {a, b, c, b, e, c};

    PetscCall(PetscArraycpy(corner + 6 * q, (i + k) % 2 ? odd : even, 6));
  }
  PetscCall(SlipH5Create(file, &h));
  PetscCall(SlipH5WriteReal(&h, "/vertices", 2, vertices, vertex, "m"));
  PetscCall(SlipH5WriteInt(&h, "/triangles", 2, triangles, corner, NULL));
  PetscCall(SlipH5Close(&h));
  return PetscFree2(vertex, corner);
}
