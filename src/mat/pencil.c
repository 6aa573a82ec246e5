/*
  Transforms along strike of a grid whose rows of cells are spread over the ranks, and the transpose that gives each
  rank some wavenumbers at all depths. One plan serves every row, so that results do not depend on the number of ranks.
*/
#include <slipmat.h>
#include <fftw3-mpi.h>
#include <slipstep/private/slipcompat.h>
#include <slipstep/private/slipmat.h>

struct _n_SlipPencilPlans {
  fftw_plan forward, backward, transpose, transpose_back;
};

/* How FFTW spreads a table of tuples of reals, [rows][columns], and its transpose. */
SlipLayout SlipLayoutOf(MPI_Comm comm, PetscInt rows, PetscInt columns, PetscInt tuple)
{
  const ptrdiff_t n[2] = {rows, columns};
  ptrdiff_t r, r0, c, c0, size;

  fftw_mpi_init(); /* may be called again and again */
  size = fftw_mpi_local_size_many_transposed(2, n, tuple, FFTW_MPI_DEFAULT_BLOCK, FFTW_MPI_DEFAULT_BLOCK, comm, &r, &r0,
                                             &c, &c0);
  return (SlipLayout){(PetscInt)r, (PetscInt)r0, (PetscInt)c, (PetscInt)c0, (size_t)size};
}

/* Aligned, zero, free with fftw_free(). */
PetscErrorCode SlipAllocate(size_t count, PetscReal **a)
{
  PetscFunctionBegin;
  *a = fftw_alloc_real(PetscMax(count, 1));
  PetscCheck(*a, PETSC_COMM_SELF, PETSC_ERR_MEM, "No memory for %zu numbers", count);
  for (size_t i = 0; i < count; i++) (*a)[i] = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Out of place, once; a [rows][columns][tuple] to b [columns][rows][tuple]. Collective. */
PetscErrorCode SlipTranspose(MPI_Comm comm, PetscInt rows, PetscInt columns, PetscInt tuple, PetscReal a[],
                             PetscReal b[])
{
  const ptrdiff_t block = FFTW_MPI_DEFAULT_BLOCK;
  fftw_plan plan = fftw_mpi_plan_many_transpose(rows, columns, tuple, block, block, a, b, comm, FFTW_ESTIMATE);

  PetscFunctionBegin;
  PetscCheck(plan, comm, PETSC_ERR_LIB, "FFTW cannot plan a transpose");
  fftw_execute(plan);
  fftw_destroy_plan(plan);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* For fields [nz][nx] and transforms of length period. Collective. */
PetscErrorCode SlipPencilCreate(MPI_Comm comm, PetscInt nx, PetscInt nz, PetscInt period, SlipPencil *pencil)
{
  const PetscInt nk = period / 2 + 1;
  const ptrdiff_t block = FFTW_MPI_DEFAULT_BLOCK;
  struct _n_SlipPencilPlans *plans;
  SlipPencil p;

  PetscFunctionBegin;
  PetscCall(PetscNew(&p));
  PetscCall(PetscNew(&plans));
  p->plans = plans;
  p->nx = nx;
  p->nz = nz;
  p->period = period;
  p->layout = SlipLayoutOf(comm, nz, nk, 2);
  PetscCall(SlipAllocate((size_t)period, &p->row));
  PetscCall(SlipAllocate(PetscMax(p->layout.size, (size_t)period + 2), &p->by_depth)); /* plans want one row */
  PetscCall(SlipAllocate(p->layout.size, &p->by_wave));
  plans->forward = fftw_plan_dft_r2c_1d((int)period, p->row, (fftw_complex *)p->by_depth, FFTW_ESTIMATE);
  plans->backward = fftw_plan_dft_c2r_1d((int)period, (fftw_complex *)p->by_depth, p->row, FFTW_ESTIMATE);
  plans->transpose =
    fftw_mpi_plan_many_transpose(nz, nk, 2, block, block, p->by_depth, p->by_wave, comm, FFTW_ESTIMATE);
  plans->transpose_back =
    fftw_mpi_plan_many_transpose(nk, nz, 2, block, block, p->by_wave, p->by_depth, comm, FFTW_ESTIMATE);
  PetscCheck(plans->forward && plans->backward && plans->transpose && plans->transpose_back, comm, PETSC_ERR_LIB,
             "FFTW cannot plan transforms of length %" PetscInt_FMT, period);
  *pencil = p;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipPencilDestroy(SlipPencil *pencil)
{
  SlipPencil p = *pencil;

  PetscFunctionBegin;
  if (!p) PetscFunctionReturn(PETSC_SUCCESS);
  fftw_destroy_plan(p->plans->forward);
  fftw_destroy_plan(p->plans->backward);
  fftw_destroy_plan(p->plans->transpose);
  fftw_destroy_plan(p->plans->transpose_back);
  fftw_free(p->row);
  fftw_free(p->by_depth);
  fftw_free(p->by_wave);
  PetscCall(PetscFree(p->plans));
  PetscCall(PetscFree(p));
  *pencil = NULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* This rank's rows x to its wavenumbers, by_wave. Collective. */
void SlipPencilForward(SlipPencil p, const PetscReal x[])
{
  const PetscInt nx = p->nx, nk = p->period / 2 + 1;

  for (PetscInt ix = nx; ix < p->period; ix++) p->row[ix] = 0;
  for (PetscInt iz = 0; iz < p->layout.rows; iz++) {
    for (PetscInt ix = 0; ix < nx; ix++) p->row[ix] = x[(size_t)iz * nx + ix];
    fftw_execute_dft_r2c(p->plans->forward, p->row, (fftw_complex *)(p->by_depth + (size_t)iz * 2 * nk));
  }
  fftw_execute(p->plans->transpose);
}

/* And back, times factor / period. Collective. */
void SlipPencilBackward(SlipPencil p, PetscReal factor, PetscReal y[])
{
  const PetscInt nx = p->nx, nk = p->period / 2 + 1;
  const PetscReal scale = factor / (PetscReal)p->period;

  fftw_execute(p->plans->transpose_back);
  for (PetscInt iz = 0; iz < p->layout.rows; iz++) {
    fftw_execute_dft_c2r(p->plans->backward, (fftw_complex *)(p->by_depth + (size_t)iz * 2 * nk), p->row);
    for (PetscInt ix = 0; ix < nx; ix++) y[(size_t)iz * nx + ix] = scale * p->row[ix];
  }
}

PetscReal SlipPencilBytes(SlipPencil p)
{
  return (PetscReal)sizeof(PetscReal) * (PetscReal)(2 * p->layout.size + (size_t)p->period);
}
