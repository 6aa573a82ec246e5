/*
  Transforms along strike of a grid whose rows of cells are spread over the ranks, and the transpose that gives each
  rank some wavenumbers at all depths. One plan serves every row, so that results do not depend on the number of ranks.

  Two rows are transformed at once, as real and imaginary part of one complex row: about half the time of FFTW's real
  transforms, of which less is vector code (lengths 200 to 800, measured). A few pairs are transformed before they are
  transposed, while they are in cache, straight to where this rank's wavenumbers lie or into the message for another
  rank, whose MPI type puts it in place there.
*/
#include <slipmat.h>
#include <fftw3-mpi.h>
#include <slipcompat.h>
#include <slipstep/private/slipmatgrid.h>

/* Rows transformed before they are transposed, even: 8 complex numbers fill two cache lines. */
#define PENCIL_ROWS 8

struct _n_SlipTransposedFFTPlans {
  fftw_plan forward, backward;
  PetscReal *in, *out;    /* [period] complex, a pair of rows: in is zero behind the cells */
  PetscReal *waves;       /* [PENCIL_ROWS / 2][period] complex, transforms of pairs */
  PetscInt *columns;      /* [size + 1], where the wavenumbers of each rank start */
  PetscReal *pieces;      /* messages of this rank's rows, [wavenumbers of the other rank][local nz] complex each */
  MPI_Comm comm;          /* PETSc's own of the ranks, */
  PetscMPIInt size, rank; /* their number and this one, */
  PetscMPIInt tag, n;     /* and its messages each way, one for every other rank */
  MPI_Request *there;     /* persistent, forward: n receives into by_wave, then n sends of pieces */
  MPI_Request *back;      /* n receives into pieces, then n sends from by_wave */
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

/* starts [size + 1] of what is spread over the ranks in their order, count here. Collective. */
static PetscErrorCode StartsOf(MPI_Comm comm, PetscMPIInt size, PetscInt count, PetscInt starts[])
{
  PetscFunctionBegin;
  starts[0] = 0;
  PetscCallMPI(MPI_Allgather(&count, 1, MPIU_INT, starts + 1, 1, MPIU_INT, comm));
  for (PetscMPIInt d = 0; d < size; d++) starts[d + 1] += starts[d];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Persistent messages with every other rank. Those of its rows of by_wave are strided: the type says how. */
static PetscErrorCode PlanMessages(SlipTransposedFFT p)
{
  struct _n_SlipTransposedFFTPlans *s = p->plans;
  const PetscMPIInt n = s->size - 1;
  PetscReal *piece = s->pieces;
  PetscInt *rows;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(s->size + 1, &rows));
  PetscCall(StartsOf(s->comm, s->size, p->layout.rows, rows));
  PetscCall(PetscMalloc2(2 * n, &s->there, 2 * n, &s->back));
  for (PetscMPIInt d = 0; d < s->size; d++) {
    const PetscInt theirs = rows[d + 1] - rows[d];
    PetscReal *waves = p->by_wave + 2 * rows[d];
    MPI_Datatype type;
    PetscMPIInt count;

    if (d == s->rank) continue;
    PetscCall(PetscMPIIntCast(2 * p->layout.rows * (s->columns[d + 1] - s->columns[d]), &count));
    PetscCallMPI(MPI_Type_vector((PetscMPIInt)p->layout.columns, (PetscMPIInt)(2 * theirs), (PetscMPIInt)(2 * p->nz),
                                 MPIU_REAL, &type));
    PetscCallMPI(MPI_Type_commit(&type));
    PetscCallMPI(MPI_Recv_init(waves, 1, type, d, s->tag, s->comm, &s->there[s->n]));
    PetscCallMPI(MPI_Send_init(piece, count, MPIU_REAL, d, s->tag, s->comm, &s->there[n + s->n]));
    PetscCallMPI(MPI_Recv_init(piece, count, MPIU_REAL, d, s->tag, s->comm, &s->back[s->n]));
    PetscCallMPI(MPI_Send_init(waves, 1, type, d, s->tag, s->comm, &s->back[n + s->n]));
    PetscCallMPI(MPI_Type_free(&type));
    piece += count;
    s->n++;
  }
  PetscCall(PetscFree(rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* For fields [nz][nx] and transforms of length period. Collective. */
PetscErrorCode SlipTransposedFFTCreate(MPI_Comm comm, PetscInt nx, PetscInt nz, PetscInt period,
                                       SlipTransposedFFT *pencil)
{
  const PetscInt nk = period / 2 + 1;
  struct _n_SlipTransposedFFTPlans *s;
  SlipTransposedFFT p;

  PetscFunctionBegin;
  PetscCall(PetscNew(&p));
  PetscCall(PetscNew(&s));
  p->plans = s;
  p->nx = nx;
  p->nz = nz;
  p->period = period;
  p->layout = SlipLayoutOf(comm, nz, nk, 2);
  PetscCall(PetscCommDuplicate(comm, &s->comm, &s->tag));
  PetscCallMPI(MPI_Comm_size(s->comm, &s->size));
  PetscCallMPI(MPI_Comm_rank(s->comm, &s->rank));
  PetscCall(PetscMalloc1(s->size + 1, &s->columns));
  PetscCall(StartsOf(s->comm, s->size, p->layout.columns, s->columns));
  PetscCall(SlipAllocate((size_t)2 * period, &s->in));
  PetscCall(SlipAllocate((size_t)2 * period, &s->out));
  PetscCall(SlipAllocate((size_t)PENCIL_ROWS * period, &s->waves));
  PetscCall(SlipAllocate((size_t)2 * nz * p->layout.columns, &p->by_wave));
  PetscCall(SlipAllocate((size_t)2 * p->layout.rows * (nk - p->layout.columns), &s->pieces));
  s->forward =
    fftw_plan_dft_1d((int)period, (fftw_complex *)s->in, (fftw_complex *)s->waves, FFTW_FORWARD, FFTW_ESTIMATE);
  s->backward =
    fftw_plan_dft_1d((int)period, (fftw_complex *)s->waves, (fftw_complex *)s->out, FFTW_BACKWARD, FFTW_ESTIMATE);
  PetscCheck(s->forward && s->backward, comm, PETSC_ERR_LIB, "FFTW cannot plan transforms of length %" PetscInt_FMT,
             period);
  if (s->size > 1) PetscCall(PlanMessages(p));
  *pencil = p;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipTransposedFFTDestroy(SlipTransposedFFT *pencil)
{
  SlipTransposedFFT p = *pencil;
  struct _n_SlipTransposedFFTPlans *s;

  PetscFunctionBegin;
  if (!p) PetscFunctionReturn(PETSC_SUCCESS);
  s = p->plans;
  fftw_destroy_plan(s->forward);
  fftw_destroy_plan(s->backward);
  fftw_free(s->in);
  fftw_free(s->out);
  fftw_free(s->waves);
  fftw_free(s->pieces);
  fftw_free(p->by_wave);
  for (PetscMPIInt i = 0; i < 2 * s->n; i++) {
    PetscCallMPI(MPI_Request_free(&s->there[i]));
    PetscCallMPI(MPI_Request_free(&s->back[i]));
  }
  PetscCall(PetscFree2(s->there, s->back));
  PetscCall(PetscFree(s->columns));
  PetscCall(PetscCommDestroy(&s->comm));
  PetscCall(PetscFree(s));
  PetscCall(PetscFree(p));
  *pencil = NULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Where rows from row on of the wavenumbers of rank d are, and how far apart wavenumbers lie, in reals. */
static PetscReal *RowsOf(SlipTransposedFFT p, PetscMPIInt d, PetscInt row, PetscInt *apart)
{
  const struct _n_SlipTransposedFFTPlans *s = p->plans;
  const PetscInt before = s->columns[d] - (d > s->rank ? p->layout.columns : 0);

  *apart = 2 * (d == s->rank ? p->nz : p->layout.rows);
  if (d == s->rank) return p->by_wave + 2 * (p->layout.row_start + row);
  return s->pieces + 2 * ((size_t)p->layout.rows * before + row);
}

/* a[k][row], na reals from one k to the next, for k in [start, end): the transforms of real rows from those of pairs,
   waves[pair][period], which are X(k) = (Z(k) + Z*(-k))/2 and Y(k) = (Z(k) - Z*(-k))/2i. rows may be odd. */
static void ToColumns(PetscInt rows, PetscInt period, PetscInt start, PetscInt end, const PetscReal waves[],
                      PetscReal a[], PetscInt na)
{
  for (PetscInt k = start; k < end; k++)
    for (PetscInt i = 0; i < rows; i += 2) {
      const PetscReal *z = waves + i * period + 2 * k, *c = waves + i * period + 2 * (k ? period - k : 0);
      PetscReal *to = a + (k - start) * na + 2 * i;

      to[0] = 0.5 * (z[0] + c[0]);
      to[1] = 0.5 * (z[1] - c[1]);
      if (i + 1 == rows) continue;
      to[2] = 0.5 * (z[1] + c[1]);
      to[3] = 0.5 * (c[0] - z[0]);
    }
}

/* And back: Z(k) = X(k) + i Y(k), Z(-k) = X*(k) + i Y*(k) */
static void ToRows(PetscInt rows, PetscInt period, PetscInt start, PetscInt end, const PetscReal a[], PetscInt na,
                   PetscReal waves[])
{
  for (PetscInt k = start; k < end; k++)
    for (PetscInt i = 0; i < rows; i += 2) {
      const PetscReal *x = a + (k - start) * na + 2 * i;
      const PetscReal y[2] = {i + 1 < rows ? x[2] : 0, i + 1 < rows ? x[3] : 0};
      PetscReal *z = waves + i * period + 2 * k, *c = waves + i * period + 2 * (period - k);

      z[0] = x[0] - y[1];
      z[1] = x[1] + y[0];
      if (k == 0) continue;
      c[0] = x[0] + y[1];
      c[1] = y[0] - x[1];
    }
}

/* This rank's rows x to its wavenumbers, by_wave. Collective. */
PetscErrorCode SlipTransposedFFTForward(SlipTransposedFFT p, const PetscReal x[])
{
  const struct _n_SlipTransposedFFTPlans *s = p->plans;
  const PetscInt nx = p->nx;
  PetscInt apart;

  PetscFunctionBegin;
  if (s->n) PetscCallMPI(MPI_Startall(s->n, s->there));
  for (PetscInt iz = 0; iz < p->layout.rows; iz += PENCIL_ROWS) {
    const PetscInt rows = PetscMin(PENCIL_ROWS, p->layout.rows - iz);

    for (PetscInt i = 0; i < rows; i += 2) {
      const PetscReal *first = x + (size_t)(iz + i) * nx, *second = i + 1 < rows ? first + nx : NULL;

      for (PetscInt ix = 0; ix < nx; ix++) {
        s->in[2 * ix] = first[ix];
        s->in[2 * ix + 1] = second ? second[ix] : 0;
      }
      fftw_execute_dft(s->forward, (fftw_complex *)s->in, (fftw_complex *)(s->waves + i * p->period));
    }
    for (PetscMPIInt d = 0; d < s->size; d++) {
      PetscReal *to = RowsOf(p, d, iz, &apart);

      ToColumns(rows, p->period, s->columns[d], s->columns[d + 1], s->waves, to, apart);
    }
  }
  if (s->n) {
    PetscCallMPI(MPI_Startall(s->n, s->there + s->n));
    PetscCallMPI(MPI_Waitall(2 * s->n, s->there, MPI_STATUSES_IGNORE));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* And back, times factor / period. Collective. */
PetscErrorCode SlipTransposedFFTBackward(SlipTransposedFFT p, PetscReal factor, PetscReal y[])
{
  const struct _n_SlipTransposedFFTPlans *s = p->plans;
  const PetscInt nx = p->nx;
  const PetscReal scale = factor / (PetscReal)p->period;
  PetscInt apart;

  PetscFunctionBegin;
  if (s->n) {
    PetscCallMPI(MPI_Startall(2 * s->n, s->back));
    PetscCallMPI(MPI_Waitall(2 * s->n, s->back, MPI_STATUSES_IGNORE));
  }
  for (PetscInt iz = 0; iz < p->layout.rows; iz += PENCIL_ROWS) {
    const PetscInt rows = PetscMin(PENCIL_ROWS, p->layout.rows - iz);

    for (PetscMPIInt d = 0; d < s->size; d++) {
      const PetscReal *from = RowsOf(p, d, iz, &apart);

      ToRows(rows, p->period, s->columns[d], s->columns[d + 1], from, apart, s->waves);
    }
    for (PetscInt i = 0; i < rows; i += 2) {
      PetscReal *first = y + (size_t)(iz + i) * nx, *second = first + nx;

      fftw_execute_dft(s->backward, (fftw_complex *)(s->waves + i * p->period), (fftw_complex *)s->out);
      for (PetscInt ix = 0; ix < nx; ix++) first[ix] = scale * s->out[2 * ix];
      for (PetscInt ix = 0; ix < nx && i + 1 < rows; ix++) second[ix] = scale * s->out[2 * ix + 1];
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscReal SlipTransposedFFTBytes(SlipTransposedFFT p)
{
  const PetscInt nk = p->period / 2 + 1, waves = p->layout.columns;

  return (PetscReal)sizeof(PetscReal) *
         (PetscReal)(2 * (p->nz * waves + p->layout.rows * (nk - waves)) + (PENCIL_ROWS + 4) * p->period);
}
