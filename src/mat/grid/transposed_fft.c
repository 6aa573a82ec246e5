/*
  Transforms along strike of a grid whose rows of cells are distributed over the ranks, and the transpose after which
  each rank has some wavenumbers at all depths.

  Two rows are transformed at once, as real and imaginary part of one complex row, and as many pairs as there are lanes
  (lanes.c). Results do not depend on the number of ranks unless some rank begins with an odd row: its pairs are others
  then, and rounding depends on both rows of a pair. They are transposed while they are in the cache, directly to the
  place of this rank's wavenumbers or into the message for another rank, where an MPI type puts them in place.
*/
#include <slipstep/rooms/slipmat.h>
#include <fftw3-mpi.h>
#include <stdlib.h>
#include <slipcompat.h>
#include <slipstep/private/slipmatgrid.h>

/* Rows that are transformed before they are transposed */
#define PENCIL_ROWS (2 * SLIP_LANES)

struct _n_SlipTransposedFFTPlans {
  SlipLanesFFT fft;       /* of period / 2 */
  PetscReal *half[2];     /* [period / 2] numbers: even and odd wavenumbers of the pairs of rows */
  PetscReal *rest;        /* [PENCIL_ROWS][nx], the last rows, and zeros */
  PetscInt *columns;      /* [size + 1], starts of each rank's wavenumbers */
  PetscReal *pieces;      /* messages of this rank's rows, [wavenumbers of the other rank][local nz] complex each */
  MPI_Comm comm;          /* PETSc's own communicator of the ranks */
  PetscMPIInt size, rank; /* number of ranks, and this one */
  PetscMPIInt tag, n;     /* tag and number of messages each way, one for every other rank */
  PetscInt reals[2];      /* in messages of this rank's rows, and in those of its wavenumbers */
  MPI_Request *there;     /* persistent, forward: n receives into by_wave, then n sends of pieces */
  MPI_Request *back;      /* n receives into pieces, then n sends from by_wave */
};

/* Returns FFTW's distribution of a table of tuples of reals, [rows][columns], and of its transpose. */
SlipLayout SlipLayoutOf(MPI_Comm comm, PetscInt rows, PetscInt columns, PetscInt tuple)
{
  const ptrdiff_t n[2] = {rows, columns};
  ptrdiff_t r, r0, c, c0, size;

  fftw_mpi_init(); /* may be called repeatedly */
  size = fftw_mpi_local_size_many_transposed(2, n, tuple, FFTW_MPI_DEFAULT_BLOCK, FFTW_MPI_DEFAULT_BLOCK, comm, &r, &r0,
                                             &c, &c0);
  return (SlipLayout){(PetscInt)r, (PetscInt)r0, (PetscInt)c, (PetscInt)c0, (size_t)size};
}

/* Allocates aligned zeros, which fftw_free() frees. */
PetscErrorCode SlipAllocate(size_t count, PetscReal **a)
{
  PetscFunctionBegin;
  *a = fftw_alloc_real(PetscMax(count, 1));
  PetscCheck(*a, PETSC_COMM_SELF, PETSC_ERR_MEM, "No memory for %zu numbers", count);
  for (size_t i = 0; i < count; i++) (*a)[i] = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Transposes once, out of place: a [rows][columns][tuple] to b [columns][rows][tuple]. Collective. */
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

/* Computes starts [size + 1] of a distribution over the ranks in their order, with count items here. Collective. */
static PetscErrorCode StartsOf(MPI_Comm comm, PetscMPIInt size, PetscInt count, PetscInt starts[])
{
  PetscFunctionBegin;
  starts[0] = 0;
  PetscCallMPI(MPI_Allgather(&count, 1, MPIU_INT, starts + 1, 1, MPIU_INT, comm));
  for (PetscMPIInt d = 0; d < size; d++) starts[d + 1] += starts[d];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates persistent messages with every other rank. Rows of by_wave are strided, which an MPI type describes. */
static PetscErrorCode PlanMessages(SlipTransposedFFT p)
{
  struct _n_SlipTransposedFFTPlans *s = p->plans;
  const PetscMPIInt n = s->size - 1;
  PetscReal *piece = s->pieces;
  PetscInt *rows;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(s->size + 1, &rows));
  PetscCall(StartsOf(s->comm, s->size, p->layout.rows, rows));
  s->reals[0] = 2 * p->layout.rows * (p->period / 2 + 1 - p->layout.columns);
  s->reals[1] = 2 * (p->nz - p->layout.rows) * p->layout.columns;
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

/* Creates transforms of length period for fields [nz][nx]. Collective. */
PetscErrorCode SlipTransposedFFTCreate(MPI_Comm comm, PetscInt nx, PetscInt nz, PetscInt period,
                                       SlipTransposedFFT *pencil)
{
  const PetscInt nk = period / 2 + 1;
  struct _n_SlipTransposedFFTPlans *s;
  SlipTransposedFFT p;
  PetscInt waves;

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
  for (int i = 0; i < 2; i++) PetscCall(SlipAllocateLines((size_t)SLIP_LANES * period, &s->half[i]));
  PetscCall(SlipAllocate((size_t)PENCIL_ROWS * nx, &s->rest));
  waves = (p->layout.columns + SLIP_LANES - 1) / SLIP_LANES * SLIP_LANES;
  PetscCall(SlipAllocate((size_t)2 * nz * waves, &p->by_wave));
  PetscCall(SlipAllocate((size_t)2 * p->layout.rows * (nk - p->layout.columns), &s->pieces));
  PetscCall(SlipLanesFFTCreate(period / 2, &s->fft));
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
  PetscCall(SlipLanesFFTDestroy(&s->fft));
  for (int i = 0; i < 2; i++) free(s->half[i]);
  fftw_free(s->rest);
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

/* Returns the place of rows from `row` on of rank d's wavenumbers, and the distance between wavenumbers in reals. */
static PetscReal *RowsOf(SlipTransposedFFT p, PetscMPIInt d, PetscInt row, PetscInt *apart)
{
  const struct _n_SlipTransposedFFTPlans *s = p->plans;
  const PetscInt before = s->columns[d] - (d > s->rank ? p->layout.columns : 0);

  *apart = 2 * (d == s->rank ? p->nz : p->layout.rows);
  if (d == s->rank) return p->by_wave + 2 * (p->layout.row_start + row);
  return s->pieces + 2 * ((size_t)p->layout.rows * before + row);
}

/* Transforms this rank's rows x to its wavenumbers, by_wave. Collective. */
PetscErrorCode SlipTransposedFFTForward(SlipTransposedFFT p, const PetscReal x[])
{
  struct _n_SlipTransposedFFTPlans *s = p->plans;
  const PetscInt nx = p->nx;
  const SlipLanesFields pairs = {.n = nx, .step = 1, .apart = 2 * nx, .imaginary = nx};
  PetscInt apart;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Startall_irecv(s->reals[1], MPIU_REAL, s->n, s->there)); /* PETSc's, which -log_view counts */
  for (PetscInt iz = 0; iz < p->layout.rows; iz += PENCIL_ROWS) {
    const PetscInt rows = PetscMin(PENCIL_ROWS, p->layout.rows - iz);
    const PetscReal *from = x + (size_t)iz * nx;

    if (rows < PENCIL_ROWS) {
      PetscCall(PetscArraycpy(s->rest, from, rows * nx));
      PetscCall(PetscArrayzero(s->rest + rows * nx, (PENCIL_ROWS - rows) * nx));
      from = s->rest;
    }
    SlipLanesForward(s->fft, &pairs, from, s->half);
    for (PetscMPIInt d = 0; d < s->size; d++) {
      PetscReal *to = RowsOf(p, d, iz, &apart);

      SlipLanesSplit(s->fft, s->half, rows, s->columns[d], s->columns[d + 1], to, apart);
    }
  }
  if (s->n) {
    PetscCallMPI(MPI_Startall_isend(s->reals[0], MPIU_REAL, s->n, s->there + s->n));
    PetscCallMPI(MPI_Waitall(2 * s->n, s->there, MPI_STATUSES_IGNORE));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Transforms backward, times factor / period. Collective. */
PetscErrorCode SlipTransposedFFTBackward(SlipTransposedFFT p, PetscReal factor, PetscReal y[])
{
  struct _n_SlipTransposedFFTPlans *s = p->plans;
  const PetscInt nx = p->nx;
  const SlipLanesFields pairs = {.n = nx, .step = 1, .apart = 2 * nx, .imaginary = nx};
  PetscInt apart;

  PetscFunctionBegin;
  if (s->n) {
    PetscCallMPI(MPI_Startall_irecv(s->reals[0], MPIU_REAL, s->n, s->back));
    PetscCallMPI(MPI_Startall_isend(s->reals[1], MPIU_REAL, s->n, s->back + s->n));
    PetscCallMPI(MPI_Waitall(2 * s->n, s->back, MPI_STATUSES_IGNORE));
  }
  for (PetscInt iz = 0; iz < p->layout.rows; iz += PENCIL_ROWS) {
    const PetscInt rows = PetscMin(PENCIL_ROWS, p->layout.rows - iz);
    PetscReal *to = rows < PENCIL_ROWS ? s->rest : y + (size_t)iz * nx;

    for (PetscMPIInt d = 0; d < s->size; d++) {
      const PetscReal *from = RowsOf(p, d, iz, &apart);

      SlipLanesJoin(s->fft, s->half, rows, s->columns[d], s->columns[d + 1], from, apart);
    }
    SlipLanesBackward(s->fft, &pairs, factor / (PetscReal)p->period, s->half, to);
    if (rows < PENCIL_ROWS) PetscCall(PetscArraycpy(y + (size_t)iz * nx, s->rest, rows * nx));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscReal SlipTransposedFFTBytes(SlipTransposedFFT p)
{
  const PetscInt nk = p->period / 2 + 1, waves = p->layout.columns;

  return (PetscReal)sizeof(PetscReal) * (PetscReal)(2 * (p->nz * waves + p->layout.rows * (nk - waves)) +
                                                    3 * SLIP_LANES * p->period + PENCIL_ROWS * p->nx);
}
