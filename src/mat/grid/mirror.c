/*
  Operators of a uniform grid commute with the mirror x -> -x, so that they separate into two blocks of half the size,
  one for even and one for odd fields. A row of nx cells has the orthonormal basis (e_i +- e_j) / sqrt 2, j = nx - 1 -
  i, i < nx / 2, and the middle cell alone (even) if nx is odd. Blocks are row-major with index iz * hx + ix, where hx
  is half the cells of a row.
*/
#include <slipstep/rooms/slipmat.h>
#include <slipcompat.h>
#include <slipstep/private/slipmatgrid.h>

PetscInt SlipMirrorWidth(PetscInt nx, PetscInt parity)
{
  return parity ? nx / 2 : (nx + 1) / 2;
}

/* Computes the even (parity 0) or odd (1) block of scale * K from kernel[d * nz * nz + iz * nz + jz] of
   SlipGridKernel(). */
void SlipMirrorSplit(PetscInt nx, PetscInt nz, const PetscReal kernel[], PetscReal scale, PetscInt parity,
                     PetscReal block[])
{
  const PetscInt hx = SlipMirrorWidth(nx, parity), n = hx * nz;
  const size_t zz = (size_t)nz * nz;

  for (PetscInt r = 0; r < n; r++)
    for (PetscInt c = 0; c < n; c++) {
      const PetscInt rx = r % hx, cx = c % hx, mx = nx - 1 - cx;
      const PetscReal *pair = kernel + (size_t)(r / hx) * nz + c / hx;
      const PetscReal near = pair[(size_t)PetscAbsInt(rx - cx) * zz], far = pair[(size_t)(mx - rx) * zz];
      const PetscReal weight =
        scale * (2 * rx + 1 == nx ? PETSC_SQRT2 / 2 : 1) * (2 * cx + 1 == nx ? PETSC_SQRT2 / 2 : 1);

      block[(size_t)r * n + c] = weight * (parity ? near - far : near + far);
    }
}

/* Computes the whole matrix A, row-major N * N, from its two blocks. */
void SlipMirrorMerge(PetscInt nx, PetscInt nz, const PetscReal even[], const PetscReal odd[], PetscReal A[])
{
  const PetscInt N = nx * nz, he = SlipMirrorWidth(nx, 0), ho = SlipMirrorWidth(nx, 1);

  for (PetscInt i = 0; i < N; i++)
    for (PetscInt j = 0; j < N; j++) {
      const PetscInt mi = nx - 1 - i % nx, mj = nx - 1 - j % nx;
      const PetscInt ri = PetscMin(i % nx, mi), rj = PetscMin(j % nx, mj);
      const PetscReal e = even[(size_t)(i / nx * he + ri) * (he * nz) + j / nx * he + rj];
      const PetscReal weight = (2 * ri + 1 == nx ? PETSC_SQRT2 : 1) * (2 * rj + 1 == nx ? PETSC_SQRT2 : 1);
      PetscReal o = 0;

      if (ri < ho && rj < ho) o = odd[(size_t)(i / nx * ho + ri) * (ho * nz) + j / nx * ho + rj];
      A[(size_t)i * N + j] = 0.5 * (weight * e + ((i % nx == ri) == (j % nx == rj) ? o : -o));
    }
}

static PetscReal FoldWeight(PetscInt ix, PetscInt nx)
{
  return 2 * ix + 1 == nx ? 0.5 : PETSC_SQRT2 / 2;
}

/* Computes half [nz][hx], the coefficients of the even or odd part of the field x [nz][nx]. */
void SlipMirrorFold(PetscInt nx, PetscInt nz, PetscInt parity, const PetscReal x[], PetscReal half[])
{
  const PetscInt hx = SlipMirrorWidth(nx, parity);
  const PetscReal sign = parity ? -1 : 1;

  for (PetscInt iz = 0; iz < nz; iz++)
    for (PetscInt ix = 0; ix < hx; ix++)
      half[iz * hx + ix] = FoldWeight(ix, nx) * (x[iz * nx + ix] + sign * x[iz * nx + nx - 1 - ix]);
}

/* Adds the field with these coefficients to x. */
void SlipMirrorUnfold(PetscInt nx, PetscInt nz, PetscInt parity, const PetscReal half[], PetscReal x[])
{
  const PetscInt hx = SlipMirrorWidth(nx, parity);
  const PetscReal sign = parity ? -1 : 1;

  for (PetscInt iz = 0; iz < nz; iz++)
    for (PetscInt ix = 0; ix < hx; ix++) {
      const PetscReal value = FoldWeight(ix, nx) * half[iz * hx + ix];

      x[iz * nx + ix] += value;
      x[iz * nx + nx - 1 - ix] += sign * value;
    }
}
