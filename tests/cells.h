/* Irregular cells that several tests share, and the mesh file of such cells. */
#pragma once
#include <slipstep.h>
#include <sliph5.h>

/* Cells of a rock by their five columns data [5][n]: x, y, z, length, width */
static inline SlipCells CellsOfColumns(PetscInt n, const PetscReal data[])
{
  return (SlipCells){.n = n,
                     .x = data,
                     .y = data + n,
                     .z = data + 2 * n,
                     .length = data + 3 * n,
                     .width = data + 4 * n,
                     .kernel = {.type = &SlipKernelStrikeSlip, .shear_modulus = 30e9, .poisson_ratio = 0.25}};
}

/* Two parallel faults 300 m apart, nx * nz cells each that grow with depth; n = 2 nx nz cells in data [5][n]. Row k is
   cell k * stride % n of them, one after the other in depth and along strike: a stride prime to n shuffles the rows. */
static inline SlipCells TwoGradedFaults(PetscInt nx, PetscInt nz, PetscInt stride, PetscReal data[])
{
  const PetscInt n = 2 * nx * nz;

  for (PetscInt k = 0; k < n; k++) {
    const PetscInt e = k * stride % n, i = e % nx, j = (e / nx) % nz, plane = e / (nx * nz);
    const PetscReal width = 40 + 4 * j;

    data[k] = 50 * (i + 0.5);
    data[n + k] = 300 * plane;
    data[2 * n + k] = 40 * j + 2 * j * (j - 1) + 0.5 * width;
    data[3 * n + k] = 50;
    data[4 * n + k] = width;
  }
  return CellsOfColumns(n, data);
}

/* The file of -fault_mesh; one process */
static inline PetscErrorCode WriteCells(const char file[], const SlipCells *c)
{
  const PetscInt dims[2] = {c->n, 5};
  PetscReal *rows;
  SlipH5 h;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(5 * c->n, &rows));
  for (PetscInt i = 0; i < c->n; i++) {
    const PetscReal row[5] = {c->x[i], c->y[i], c->z[i], c->length[i], c->width[i]};

    PetscCall(PetscArraycpy(rows + 5 * i, row, 5));
  }
  PetscCall(SlipH5Create(file, &h));
  PetscCall(SlipH5WriteReal(&h, "/cells", 2, dims, rows, "m"));
  PetscCall(SlipH5WriteAttrString(&h, "/cells", "columns", "x y z length width"));
  PetscCall(SlipH5Close(&h));
  PetscCall(PetscFree(rows));
  PetscFunctionReturn(0);
}
