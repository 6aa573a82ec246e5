/*
  Fourier transforms of fields on a plane or on a line. Padding with zeros separates the fault from its periodic images.
  For a line that reaches the free surface the field includes its mirror image: its spectrum is a real cosine transform.
  Each rank has a part of the wavenumbers, and only the transforms need messages.

  On a plane the wavenumbers kz and -kz down dip are parts of one: they have the same k, so that what depends on k, such
  as the tables of exponentials, which are the largest arrays, is computed and stored once.
*/
#include <slipstep/private/slipwavespace.h>
#include <slipstep/private/slipelasticity.h>
#include <slipstep/private/slipwork.h>

static PetscErrorCode Allocate(SlipWaveSpace s)
{
  PetscFunctionBegin;
  s->stride = (s->n + SLIP_WAVE_BLOCK - 1) / SLIP_WAVE_BLOCK * SLIP_WAVE_BLOCK;
  PetscCall(PetscCalloc2(s->stride, &s->k, s->stride, &s->share));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- lines ---- */

static PetscErrorCode SetUpLine(SlipWaveSpace s, PetscReal padding)
{
  PetscInt waves, start;
  PetscMPIInt size, rank;

  PetscFunctionBegin;
  s->parts = s->mirror ? 1 : 2;
  s->modes = 1;
  s->length[0] = 1;
  s->length[1] = SlipGoodLength((PetscInt)PetscCeilReal(padding * (PetscReal)s->grid.nz));
  waves = s->mirror ? s->length[1] : s->length[1] / 2 + 1;
  PetscCallMPI(MPI_Comm_size(s->comm, &size));
  PetscCallMPI(MPI_Comm_rank(s->comm, &rank));
  PetscCall(PetscMalloc2(size, &s->counts, size, &s->starts));
  for (PetscMPIInt r = 0, at = 0; r < size; r++) {
    s->starts[r] = at;
    s->counts[r] = (PetscMPIInt)(waves / size + (r < waves % size ? 1 : 0));
    at += s->counts[r];
  }
  s->n = s->counts[rank];
  start = s->starts[rank];
  PetscCall(Allocate(s));
  for (PetscInt i = 0; i < s->n; i++) {
    const PetscInt all = start + i;

    s->share[i] = (s->mirror ? (all ? 1 : (PetscReal)0.5) : (all && 2 * all < s->length[1] ? 2 : 1)) /
                  ((s->mirror ? 2 : 1) * (PetscReal)s->length[1]);
    s->k[i] =
      (s->mirror ? 1 : 2) * (PetscReal)PETSC_PI * (PetscReal)(start + i) / ((PetscReal)s->length[1] * s->grid.size[1]);
  }
  PetscCall(SlipAllocate((size_t)s->length[1] + 2, &s->line_real));
  PetscCall(SlipAllocate((size_t)s->parts * waves, &s->line_wave));
  if (s->mirror) {
    s->plan[0][0] = fftw_plan_r2r_1d((int)s->length[1], s->line_real, s->line_real, FFTW_REDFT10, FFTW_ESTIMATE);
    s->plan[0][1] = fftw_plan_r2r_1d((int)s->length[1], s->line_real, s->line_real, FFTW_REDFT01, FFTW_ESTIMATE);
  } else {
    s->plan[0][0] = fftw_plan_dft_r2c_1d((int)s->length[1], s->line_real, (fftw_complex *)s->line_real, FFTW_ESTIMATE);
    s->plan[0][1] = fftw_plan_dft_c2r_1d((int)s->length[1], (fftw_complex *)s->line_real, s->line_real, FFTW_ESTIMATE);
  }
  PetscCheck(s->plan[0][0] && s->plan[0][1], s->comm, PETSC_ERR_LIB, "FFTW cannot plan a transform of %" PetscInt_FMT,
             s->length[1]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Counts the floating-point operations of one transform of a field, along strike and in depth. */
static PetscErrorCode Count(SlipWaveSpace s)
{
  const PetscLogDouble P = (PetscLogDouble)s->length[0], Q = (PetscLogDouble)s->length[1];
  const PetscLogDouble rows = s->pencil ? (PetscLogDouble)s->pencil->layout.rows : 0; /* a line has none */
  const PetscLogDouble waves = s->pencil ? (PetscLogDouble)s->pencil->layout.columns : 0.5;

  PetscFunctionBegin;
  PetscCall(SlipWorkFlops(SLIP_WORK_TRANSFORM, 2.5 * rows * P * PetscLog2Real(P) + 5 * waves * Q * PetscLog2Real(Q)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ForwardLine(SlipWaveSpace s, const PetscReal u[], PetscReal spectrum[])
{
  PetscMPIInt rank;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(s->comm, &rank));
  PetscCall(PetscArraycpy(s->line_real, u, s->grid.nz));
  PetscCall(PetscArrayzero(s->line_real + s->grid.nz, s->length[1] + 2 - s->grid.nz));
  fftw_execute(s->plan[0][0]);
  PetscCall(Count(s));
  for (PetscInt p = 0; p < s->parts; p++)
    for (PetscInt i = 0; i < s->n; i++)
      spectrum[p * s->stride + i] = s->line_real[s->parts * (s->starts[rank] + i) + p];
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode BackwardLine(SlipWaveSpace s, const PetscReal spectrum[])
{
  const PetscInt waves = s->mirror ? s->length[1] : s->length[1] / 2 + 1;
  const PetscReal factor = 1 / ((s->mirror ? 2 : 1) * (PetscReal)s->length[1]);

  PetscFunctionBegin;
  for (PetscInt p = 0; p < s->parts; p++)
    PetscCallMPI(MPI_Allgatherv(spectrum + p * s->stride, (PetscMPIInt)s->n, MPIU_REAL, s->line_wave + p * waves,
                                s->counts, s->starts, MPIU_REAL, s->comm));
  for (PetscInt p = 0; p < s->parts; p++)
    for (PetscInt i = 0; i < waves; i++) s->line_real[s->parts * i + p] = factor * s->line_wave[p * waves + i];
  fftw_execute(s->plan[0][1]);
  PetscCall(Count(s));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- planes ---- */

/* The period has the area of the fault times the square of padding, and images are equally far away on all sides. */
static PetscErrorCode SetUpPlane(SlipWaveSpace s, PetscReal padding)
{
  const PetscReal a = s->grid.size[0] * (PetscReal)s->grid.nx, b = s->grid.size[1] * (PetscReal)SlipWaveSpaceRows(s);
  const PetscReal gap = (PetscSqrtReal(PetscSqr(a + b) + 4 * (padding * padding - 1) * a * b) - a - b) / 2;
  PetscInt waves, first, nz;

  PetscFunctionBegin;
  s->parts = 4;
  s->modes = 2;
  s->length[0] = SlipGoodLength((PetscInt)PetscCeilReal((a + gap) / s->grid.size[0]));
  s->length[1] = SlipGoodLength((PetscInt)PetscCeilReal((b + gap) / s->grid.size[1]));
  PetscCall(SlipTransposedFFTCreate(s->comm, s->grid.nx, s->grid.nz, s->length[0], &s->pencil));
  /* size and direction of this process' wavenumbers, [waves along strike][length down dip / 2 + 1], kz and -kz */
  first = s->pencil->layout.column_start;
  nz = s->length[1];
  s->half = nz / 2 + 1;
  s->n = s->pencil->layout.columns * s->half;
  PetscCall(Allocate(s));
  PetscCall(PetscMalloc2(s->n, &s->ex, 2 * s->n, &s->ez));
  for (PetscInt i = 0; i < s->n; i++) {
    const PetscInt jx = first + i / s->half, jz = i % s->half;
    const PetscReal x = 2 * (PetscReal)PETSC_PI * (PetscReal)jx / ((PetscReal)s->length[0] * s->grid.size[0]),
                    z = 2 * (PetscReal)PETSC_PI * (PetscReal)jz / ((PetscReal)nz * s->grid.size[1]), k = hypot(x, z);

    s->k[i] = k;
    s->share[i] = (jx && 2 * jx < s->length[0] ? 2 : 1) / ((PetscReal)s->length[0] * (PetscReal)nz);
    if (s->mirror) s->share[i] /= 2; /* both halves have the same product */
    s->ex[i] = k > 0 ? x / k : 1;
    s->ez[i] = k > 0 ? z / k : 0;
    s->ez[s->n + i] = -s->ez[i];
    if (2 * jx != s->length[0]) continue;
    /* Waves of two cells along strike have x = -x: their direction must have no sign, so that fields stay real. */
    s->ex[i] = x >= z ? 1 : 0;
    s->ez[i] = s->ez[s->n + i] = 1 - s->ex[i];
  }
  waves = s->pencil->layout.columns;
  for (int c = 0; c < 2; c++) {
    const int length = (int)s->length[1];
    fftw_complex *column;

    PetscCall(SlipAllocate((size_t)2 * waves * length, &s->column[c]));
    PetscCall(SlipAllocate((size_t)s->pencil->layout.rows * s->grid.nx, &s->real[c]));
    column = (fftw_complex *)s->column[c];
    for (int back = 0; back < 2 && waves; back++)
      s->plan[c][back] = fftw_plan_many_dft(1, &length, (int)waves, column, NULL, 1, length, column, NULL, 1, length,
                                            back ? FFTW_BACKWARD : FFTW_FORWARD, FFTW_ESTIMATE);
    PetscCheck(!waves || (s->plan[c][0] && s->plan[c][1]), s->comm, PETSC_ERR_LIB, "FFTW cannot plan transforms of %d",
               length);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the directions of slip in the rows of cells that this process transforms, from the rakes of cells. */
static PetscErrorCode SetUpSlip(SlipWaveSpace s, const PetscReal rake[], Vec like)
{
  const PetscReal *a;
  PetscInt n, rows = s->pencil->layout.rows * s->grid.nx;
  PetscReal *x;
  Vec angle;

  PetscFunctionBegin;
  if (s->components > 1) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecDuplicate(like, &angle));
  PetscCall(VecGetLocalSize(angle, &n));
  PetscCall(VecGetArrayWrite(angle, &x));
  for (PetscInt i = 0; i < n; i++) x[i] = rake ? rake[i] : 0;
  PetscCall(VecRestoreArrayWrite(angle, &x));
  PetscCall(PetscMalloc2(rows, &s->ux, rows, &s->uz));
  PetscCall(SlipGatherGet(&s->gather, angle, &a));
  for (PetscInt i = 0; i < rows; i++) {
    PetscReal sine, cosine;

    SlipDegrees(a[i], &sine, &cosine);
    s->ux[i] = cosine;
    s->uz[i] = -sine; /* rows count down dip, and rakes up dip */
  }
  PetscCall(SlipGatherRestore(&s->gather, angle, &a));
  PetscCall(VecDestroy(&angle));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the place in column[] of side 0 or 1, kz or -kz, of wavenumber i; -1: both sides are one, which is side 0. */
static PetscInt PlaceOf(SlipWaveSpace s, PetscInt i, int side)
{
  const PetscInt j = i % s->half, start = i / s->half * s->length[1];

  if (!side) return 2 * (start + j);
  return j && j < s->half - 1 ? 2 * (start + s->length[1] - j) : -1;
}

static PetscErrorCode ForwardPlane(SlipWaveSpace s, const PetscReal u[], PetscReal spectrum[])
{
  const PetscInt rows = s->pencil->layout.rows * s->grid.nx, stride = s->stride;
  const PetscReal *x = s->column[0], *z = s->column[1];
  const PetscInt waves = s->pencil->layout.columns, nz = s->grid.nz, length = s->length[1];

  PetscFunctionBegin;
  for (PetscInt i = 0; i < rows; i++) {
    s->real[0][i] = s->components == 1 ? s->ux[i] * u[i] : u[2 * i];
    s->real[1][i] = s->components == 1 ? s->uz[i] * u[i] : -u[2 * i + 1];
  }
  for (int c = 0; c < 2; c++) {
    PetscCall(SlipTransposedFFTForward(s->pencil, s->real[c]));
    for (PetscInt k = 0; k < waves; k++) {
      PetscReal *column = s->column[c] + 2 * (size_t)k * length;

      PetscCall(PetscArraycpy(column, s->pencil->by_wave + 2 * (size_t)k * nz, 2 * nz));
      PetscCall(PetscArrayzero(column + 2 * nz, 2 * (length - nz)));
      for (PetscInt i = 0; i < 2 * nz && s->mirror && c == 0; i++) /* slip along strike alone */
        column[2 * (length - 1 - i / 2) + i % 2] = column[i];
    }
    if (waves) fftw_execute(s->plan[c][0]);
    PetscCall(Count(s));
  }
  for (int side = 0; side < 2; side++)
    for (PetscInt i = 0; i < s->n; i++) {
      const PetscReal ex = s->ex[i], ez = s->ez[side * s->n + i];
      const PetscInt at = PlaceOf(s, i, side);
      PetscReal *along = spectrum + 2 * side * stride + i, *across = along + 4 * stride;

      for (PetscInt p = 0; p < 2; p++) {
        along[p * stride] = at < 0 ? 0 : ex * x[at + p] + ez * z[at + p];
        across[p * stride] = at < 0 ? 0 : ex * z[at + p] - ez * x[at + p];
      }
    }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Transforms a spectrum to the fields real[]. */
static PetscErrorCode BackwardPlane(SlipWaveSpace s, const PetscReal spectrum[])
{
  const PetscInt stride = s->stride;
  PetscReal *x = s->column[0], *z = s->column[1];
  const PetscInt waves = s->pencil->layout.columns, nz = s->grid.nz, length = s->length[1];

  PetscFunctionBegin;
  for (int side = 0; side < 2; side++)
    for (PetscInt i = 0; i < s->n; i++) {
      const PetscReal ex = s->ex[i], ez = s->ez[side * s->n + i];
      const PetscInt at = PlaceOf(s, i, side);
      const PetscReal *along = spectrum + 2 * side * stride + i, *across = along + 4 * stride;

      for (PetscInt p = 0; p < 2 && at >= 0; p++) {
        x[at + p] = ex * along[p * stride] - ez * across[p * stride];
        z[at + p] = ez * along[p * stride] + ex * across[p * stride];
      }
    }
  for (int c = 0; c < 2; c++) {
    if (waves) fftw_execute(s->plan[c][1]);
    PetscCall(Count(s));
    for (PetscInt k = 0; k < waves; k++)
      PetscCall(PetscArraycpy(s->pencil->by_wave + 2 * (size_t)k * nz, s->column[c] + 2 * (size_t)k * length, 2 * nz));
    PetscCall(SlipTransposedFFTBackward(s->pencil, 1 / (PetscReal)length, s->real[c]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- both ---- */

/* Creates the space. K is the stiffness, whose vectors it transforms. Collective. */
PetscErrorCode SlipWaveSpaceCreate(Mat K, const SlipElasticRock *rock, SlipWaveSpace *space)
{
  SlipWaveSpace s;
  Vec like;

  PetscFunctionBegin;
  PetscCall(PetscNew(&s));
  *space = s;
  s->comm = PetscObjectComm((PetscObject)K);
  s->grid = *rock->grid;
  s->components = rock->components;
  s->line = s->grid.nx == 1 ? PETSC_TRUE : PETSC_FALSE;
  s->mirror = s->line && !s->grid.full_space ? PETSC_TRUE : s->grid.mirror;
  if (s->line)
    PetscCall(SetUpLine(s, rock->waves_padding));
  else
    PetscCall(SetUpPlane(s, rock->waves_padding));
  PetscCall(SlipGatherCreate(K, s->pencil, &s->gather));
  if (s->line) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MatCreateVecs(K, &like, NULL));
  PetscCall(SetUpSlip(s, s->grid.rake, like));
  PetscCall(VecDestroy(&like));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipWaveSpaceForward(SlipWaveSpace s, Vec u, PetscReal spectrum[])
{
  const PetscReal *a;

  PetscFunctionBegin;
  PetscCall(SlipGatherGet(&s->gather, u, &a));
  if (s->line)
    PetscCall(ForwardLine(s, a, spectrum));
  else
    PetscCall(ForwardPlane(s, a, spectrum));
  PetscCall(SlipGatherRestore(&s->gather, u, &a));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipWaveSpaceBackward(SlipWaveSpace s, const PetscReal spectrum[], Vec u)
{
  const PetscInt rows = s->line ? 0 : s->pencil->layout.rows * s->grid.nx;
  PetscReal *out;

  PetscFunctionBegin;
  if (s->line) {
    PetscCall(BackwardLine(s, spectrum));
    PetscCall(SlipGatherPut(&s->gather, s->line_real, u));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(BackwardPlane(s, spectrum));
  PetscCall(PetscMalloc1(s->components * rows, &out));
  for (PetscInt i = 0; i < rows; i++) {
    if (s->components == 1) {
      out[i] = s->ux[i] * s->real[0][i] + s->uz[i] * s->real[1][i];
    } else {
      out[2 * i] = s->real[0][i];
      out[2 * i + 1] = -s->real[1][i];
    }
  }
  PetscCall(SlipGatherPut(&s->gather, out, u));
  PetscCall(PetscFree(out));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipWaveSpaceDestroy(SlipWaveSpace *space)
{
  SlipWaveSpace s = *space;

  PetscFunctionBegin;
  if (!s) PetscFunctionReturn(PETSC_SUCCESS);
  for (int c = 0; c < 2; c++) {
    for (int back = 0; back < 2; back++)
      if (s->plan[c][back]) fftw_destroy_plan(s->plan[c][back]);
    fftw_free(s->column[c]);
    fftw_free(s->real[c]);
  }
  fftw_free(s->line_real);
  fftw_free(s->line_wave);
  PetscCall(PetscFree2(s->counts, s->starts));
  PetscCall(PetscFree2(s->k, s->share));
  PetscCall(PetscFree2(s->ex, s->ez));
  PetscCall(PetscFree2(s->ux, s->uz));
  PetscCall(SlipTransposedFFTDestroy(&s->pencil));
  PetscCall(SlipGatherDestroy(&s->gather));
  PetscCall(PetscFree(s));
  *space = NULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}
