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

/* The file of -fault_mesh, of seven columns where cells have strikes and dips, and with the faults' labels, or NULL; one process */
static inline PetscErrorCode WriteLabelledCells(const char file[], const SlipCells *c, const PetscReal label[])
{
  const PetscInt columns = c->dip ? 7 : 5, dims[2] = {c->n, columns};
  PetscReal *rows;
  SlipH5 h;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(columns * c->n, &rows));
  for (PetscInt i = 0; i < c->n; i++) {
    const PetscReal row[7] = {
      c->x[i], c->y[i], c->z[i], c->length[i], c->width[i], c->dip ? c->strike[i] : 0, c->dip ? c->dip[i] : 90};

    PetscCall(PetscArraycpy(rows + columns * i, row, columns));
  }
  PetscCall(SlipH5Create(file, &h));
  PetscCall(SlipH5WriteReal(&h, "/cells", 2, dims, rows, "m"));
  PetscCall(
    SlipH5WriteAttrString(&h, "/cells", "columns", c->dip ? "x y z length width strike dip" : "x y z length width"));
  if (label) PetscCall(SlipH5WriteReal(&h, "/fault", 1, dims, label, NULL));
  PetscCall(SlipH5Close(&h));
  PetscCall(PetscFree(rows));
  PetscFunctionReturn(0);
}

static inline PetscErrorCode WriteCells(const char file[], const SlipCells *c)
{
  PetscFunctionBeginUser;
  PetscCall(WriteLabelledCells(file, c, NULL));
  PetscFunctionReturn(0);
}
