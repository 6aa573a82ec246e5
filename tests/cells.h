/* Irregular cells that several tests share, and the mesh file of such cells. */
#pragma once
#include <slipstep/rooms.h>
#include <slipstep/rooms/sliph5.h>

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

/* And with strike, dip and rake, data [8][n] */
static inline SlipCells DippingCellsOfColumns(PetscInt n, const PetscReal data[])
{
  SlipCells c = CellsOfColumns(n, data);

  c.strike = data + 5 * (size_t)n;
  c.dip = data + 6 * (size_t)n;
  c.rake = data + 7 * (size_t)n;
  c.kernel.type = &SlipKernelDipping;
  return c;
}

static inline SlipCell CellOf(const SlipCells *c, PetscInt i)
{
  return (SlipCell){.rectangle = {c->x[i], c->y[i], c->z[i], c->length[i], c->width[i], c->strike[i], c->dip[i]},
                    .rake = c->rake[i],
                    .vertices = c->vertices ? c->vertices + 9 * i : NULL};
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

/* The file of -fault_mesh, of seven columns where cells have strikes and dips, and with the faults' labels, or NULL;
   one process */
static inline PetscErrorCode WriteLabelledCells(const char file[], const SlipCells *c, const PetscReal label[])
{
  const PetscInt columns = c->dip ? 7 : 5, dims[2] = {c->n, columns};
  PetscReal *rows;
  SlipH5 h;

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
  return PetscFree(rows);
}

static inline PetscErrorCode WriteCells(const char file[], const SlipCells *c)
{
  return WriteLabelledCells(file, c, NULL);
}

/* Each rectangle of dipping cells with rakes as two triangles, 2 i and 2 i + 1, in data [17][2 n] */
enum { TRIANGLE_COLUMNS = 17 };
static inline SlipCells TrianglesOf(const SlipCells *c, PetscReal data[])
{
  static const int corner[2][2][3] = {{{0, 1, 2}, {0, 2, 3}}, {{0, 1, 3}, {1, 2, 3}}}; /* the diagonals in turn */
  const PetscInt n = 2 * c->n;
  PetscReal *vertices = data + 8 * (size_t)n;
  SlipCells triangles = DippingCellsOfColumns(n, data);

  for (PetscInt i = 0; i < n; i++) {
    const PetscInt cell = i / 2;
    const PetscReal centre[3] = {c->x[cell], c->y[cell], c->z[cell]};
    PetscReal d[9], *v = vertices + 9 * (size_t)i, p[4][3], low = PETSC_MAX_REAL, top = PETSC_MIN_REAL;

    SlipPlaneDirections(c->strike[cell], c->dip[cell], 0, d);
    for (int k = 0; k < 4; k++)
      for (int j = 0; j < 3; j++)
        p[k][j] = centre[j] + (k == 0 || k == 3 ? -0.5 : 0.5) * c->length[cell] * d[j] +
                  (k < 2 ? 0.5 : -0.5) * c->width[cell] * d[3 + j];
    for (int k = 0; k < 3; k++) {
      const PetscReal *q = p[corner[cell % 2][i % 2][k]];
      const PetscReal along = (q[0] - centre[0]) * d[0] + (q[1] - centre[1]) * d[1] + (q[2] - centre[2]) * d[2];

      for (int j = 0; j < 3; j++) v[3 * k + j] = q[j];
      low = PetscMin(low, along);
      top = PetscMax(top, along);
    }
    for (int j = 0; j < 3; j++) data[j * (size_t)n + i] = (v[j] + v[3 + j] + v[6 + j]) / 3;
    data[3 * (size_t)n + i] = top - low;
    data[4 * (size_t)n + i] = 0.5 * c->length[cell] * c->width[cell] / (top - low);
    data[5 * (size_t)n + i] = c->strike[cell];
    data[6 * (size_t)n + i] = c->dip[cell];
    data[7 * (size_t)n + i] = c->rake ? c->rake[cell] : 0;
  }
  triangles.vertices = vertices;
  triangles.kernel = c->kernel;
  triangles.kernel.type = &SlipKernelTriangle;
  return triangles;
}

/* Two planes that meet in an edge, nx cells of 100 m along strike times nz of 80 m each, with rakes that vary; data
   [8][2 nx nz] */
static inline SlipCells TwoDippingPlanes(PetscInt nx, PetscInt nz, PetscReal data[])
{
  const PetscInt n = 2 * nx * nz;

  for (PetscInt e = 0; e < n; e++) {
    const PetscInt plane = e / (nx * nz), i = e % nx, j = e / nx % nz;
    const PetscReal dip = plane ? 35 : 70, a = dip * PETSC_PI / 180, first = 70 * PETSC_PI / 180;
    const PetscReal down = 80 * ((PetscReal)j + 0.5), begin = plane ? 80 * (PetscReal)nz : 0;
    const PetscReal value[8] = {100 * ((PetscReal)i + 0.5),
                                begin * PetscCosReal(first) + down * PetscCosReal(a),
                                200 + begin * PetscSinReal(first) + down * PetscSinReal(a),
                                100,
                                80,
                                0,
                                dip,
                                90 - (PetscReal)(e % 7)};

    for (int k = 0; k < 8; k++) data[k * (size_t)n + e] = value[k];
  }
  return DippingCellsOfColumns(n, data);
}
