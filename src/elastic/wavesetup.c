/* The set-up of the medium "waves": which grids it accepts, its kernels, its description, and how it is destroyed. */
#define _GNU_SOURCE /* madvise() */
#include <slipstep/private/slipwavespace.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <slipstep/private/slipwork.h>

#define ALIASES 100  /* ratio of the tolerance of aliases to that of other wavenumbers: smooth slip has few aliases */
#define FORGOTTEN 40 /* exp(-40) is below the rounding of a number */

/* Allocates zeros, which free() frees. Large arrays lie in large pages where the system has them: the speed of memory
   limits loops over whole arrays, and large pages save 6 % of the time of a rupture. */
PetscErrorCode SlipWavesAllocate(size_t count, float **a)
{
  const size_t large = (size_t)2 << 20, page = count * sizeof(float) < large ? 64 : large,
               bytes = (PetscMax(count, 1) * sizeof(float) + page - 1) / page * page;

  PetscFunctionBegin;
  *a = (float *)aligned_alloc(page, bytes);
  PetscCheck(*a, PETSC_COMM_SELF, PETSC_ERR_MEM, "No memory for %zu numbers", count);
#if defined(MADV_HUGEPAGE)
  if (page == large) (void)madvise(*a, bytes, MADV_HUGEPAGE);
#endif
  memset(*a, 0, bytes);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prepares z before a step that is shorter than the memory: allocates it, and sets it to steady slip where slip was. */
PetscErrorCode SlipWavesBegin(SlipWaves *w)
{
  SlipWavePast *past = &w->past;

  PetscFunctionBegin;
  for (PetscInt m = 0; m < w->kernels; m++)
    if (!past->z[m]) PetscCall(SlipWavesAllocate(SlipWaveMemorySize(&w->memory[m]), &past->z[m]));
  if (!past->steady) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt m = 0; m < w->kernels; m++)
    SlipWaveMemorySteady(&w->memory[m], SlipWavesPart(w, past->now, m), past->z[m]);
  past->steady = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Checks that the medium "waves" supports the grid and the rock. */
static PetscErrorCode Check(SlipElastic el, const SlipElasticRock *rock)
{
  const MPI_Comm comm = PetscObjectComm((PetscObject)el);
  const char *prefix = ((PetscObject)el)->prefix ? ((PetscObject)el)->prefix : "";
  const SlipElasticGrid *g = rock->grid;

  PetscFunctionBegin;
  PetscCheck(
    g, comm, PETSC_ERR_SUP,
    "-%sfault_medium waves is of one plane with equal cells: expected a uniform grid without -%sfault_mesh and "
    "-%sfault_stiffness_file",
    prefix, prefix, prefix);
  PetscCheck(
    !rock->inertia && !strcmp(rock->viscosity, "radiation") && rock->across == 0 && !el->Kn, comm, PETSC_ERR_SUP,
    "-%sfault_medium waves: expected radiation damping, and neither inertia, opening, nor slip that changes normal "
    "stress",
    prefix);
  if (g->nx == 1) {
    const PetscReal depth = g->size[1] * (PetscReal)g->nz;

    PetscCheck(
      g->size[0] >= SLIP_WAVE_ENDLESS * depth, comm, PETSC_ERR_SUP,
      "-%sfault_medium waves of one column of cells is an antiplane line: expected -%sfault_length_x of at least "
      "%g times -%sfault_length_z, not %g m",
      prefix, prefix, (double)SLIP_WAVE_ENDLESS, prefix, (double)g->size[0]);
    PetscCheck(rock->components == 1, comm, PETSC_ERR_SUP,
               "-%sfault_medium waves of an antiplane line: expected -%sfault_slip_components 1", prefix, prefix);
    PetscCheck(
      g->full_space || g->depth_top == 0, comm, PETSC_ERR_SUP,
      "-%sfault_medium waves of a line reaches the ground or has none: expected -%sfault_depth_top 0, not %g m, "
      "or -%sfault_kernel full_space",
      prefix, prefix, (double)g->depth_top, prefix);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCheck(g->full_space || g->mirror, comm, PETSC_ERR_SUP,
             "-%sfault_medium waves of a plane: expected one without ground, or -%sfault_kernel mirror", prefix,
             prefix);
  PetscCheck(!g->mirror || g->depth_top == 0, comm, PETSC_ERR_SUP,
             "-%sfault_kernel mirror with -%sfault_medium waves is of planes up to the ground: expected "
             "-%sfault_depth_top 0, not %g m",
             prefix, prefix, prefix, (double)g->depth_top);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets up the kernels: of a plane those of mode II and mode III, of a line those of k and of 2 pi/dx -+ k (waves.c). */
static PetscErrorCode SetUpKernels(SlipWaves *w, PetscReal ratio, PetscReal tolerance)
{
  const SlipWaveSpace s = w->space;
  const PetscReal dx = s->grid.size[1], all = 2 * (PetscReal)PETSC_PI / dx;

  PetscFunctionBegin;
  w->kernels = s->line ? SLIP_WAVE_KERNELS : 2;
  PetscCall(PetscMalloc1((size_t)s->modes * s->stride, &w->stiffness));
  for (PetscInt m = 0; m < w->kernels; m++) {
    const SlipWaveMode mode = s->line || m == 1 ? SLIP_WAVE_ANTIPLANE : SLIP_WAVE_INPLANE;

    PetscCall(SlipWaveMemoryCreate(s, mode, s->line ? 0 : m, ratio, w->cs,
                                   s->line && m ? PetscMin(ALIASES * tolerance, 0.1) : tolerance, &w->memory[m]));
    for (PetscInt i = 0; i < s->stride && !s->line; i++)
      w->stiffness[m * s->stride + i] = w->eta * w->cs * s->k[i] * SlipWaveStatic(mode, ratio);
  }
  for (PetscInt i = 0; i < s->stride && s->line; i++) {
    const PetscReal k = s->k[i], half = k * dx / 2;
    const PetscReal share = half > 0 ? PetscSinReal(half) / half : 1,
                    amplitude = (1 - share) / (1 / (all - k) - 1 / (all + k));

    w->stiffness[i] = w->eta * w->cs * k * share;
    w->memory[0].weight[i] = share;
    if (half == 0) { /* k = 0 has no aliases */
      w->memory[1].weight[i] = w->memory[2].weight[i] = 0;
      continue;
    }
    w->memory[1].k[i] = all - k;
    w->memory[1].weight[i] = amplitude / (all - k);
    w->memory[2].k[i] = all + k;
    w->memory[2].weight[i] = -amplitude / (all + k);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipWavesSetUp(SlipElastic el, const SlipElasticRock *rock)
{
  const PetscReal ratio = PetscSqrtReal(2 * (1 - rock->poisson_ratio) / (1 - 2 * rock->poisson_ratio));
  PetscReal slowest = PETSC_MAX_REAL, k = PETSC_MAX_REAL;
  SlipWaves *w;

  PetscFunctionBegin;
  PetscCall(SlipElasticGetData(el, &w));
  PetscCall(Check(el, rock));
  w->eta = rock->impedance;
  w->cs = PetscSqrtReal(rock->shear_modulus / rock->density);
  w->cp = ratio * w->cs;
  PetscCall(SlipWaveSpaceCreate(el->K, rock, &w->space));
  SlipWorkAdd(SLIP_WORK_WAVE, (PetscReal)w->space->stride);
  PetscCall(SlipWaveImagesCreate(w->space, rock, &w->images));
  PetscCall(SetUpKernels(w, ratio, rock->waves_tolerance));
  w->past.steady = PETSC_TRUE;
  PetscCall(SlipAllocate(SlipWavesSums(w), &w->past.now));
  PetscReal **const spectra[] = {&w->past.slip, &w->slip, &w->rate, &w->stress, &w->m};
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(spectra); i++)
    PetscCall(SlipAllocate(SlipWavesNumbers(w), spectra[i]));
  PetscCall(SlipAllocate(SlipWavesSums(w), &w->next));
  PetscCall(MatCreateVecs(el->K, &w->last, &w->answer));
  /* the length of the memory, after which the slowest exponential of the longest wave has decayed */
  for (PetscInt m = 0; m < w->kernels; m++)
    for (PetscInt j = 0; j < w->memory[m].poles.n; j++) slowest = PetscMin(slowest, -w->memory[m].poles.s[2 * j]);
  for (PetscInt i = 0; i < w->space->n; i++)
    if (w->space->k[i] > 0) k = PetscMin(k, w->space->k[i]);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &k, 1, MPIU_REAL, MPIU_MIN, w->space->comm));
  w->longest = FORGOTTEN / (slowest * k * w->cs);
  w->least = w->space->line ? w->space->grid.size[1] / (2 * w->cs)
                            : PetscMin(w->space->grid.size[0], w->space->grid.size[1]) / (3 * w->cs);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Periods beyond which S waves of images do not matter: they decay at least as one over their distance */
#define FAR_PERIODS 10

/* Computes when waves of images arrive: the first are P waves (on lines S waves) across the gap to the next image. */
PetscErrorCode SlipWavesImages(SlipElastic el, PetscReal *first, PetscReal *last)
{
  SlipWaves *w;

  PetscFunctionBegin;
  PetscCall(SlipElasticGetData(el, &w));
  {
    const SlipWaveSpace s = w->space;
    const PetscReal sides = s->mirror && s->line ? 2 : 1, *const size = s->grid.size,
                    x = (PetscReal)(s->length[0] - s->grid.nx) * size[0],
                    z = sides * (PetscReal)(s->length[1] - SlipWaveSpaceRows(s)) * size[1],
                    period = PetscMax(s->line ? 0 : (PetscReal)s->length[0] * size[0],
                                      sides * (PetscReal)s->length[1] * size[1]);

    *first = s->line ? z / w->cs : PetscMin(x, z) / w->cp;
    *last = FAR_PERIODS * period / w->cs;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipWavesView(SlipElastic el, PetscViewer viewer)
{
  PetscReal bytes = 0, first, last;
  SlipWaves *w;

  PetscFunctionBegin;
  PetscCall(SlipElasticGetData(el, &w));
  PetscCall(SlipWavesImages(el, &first, &last));
  for (PetscInt m = 0; m < w->kernels; m++)
    bytes += (PetscReal)sizeof(float) *
             (PetscReal)(SlipWaveMemorySize(&w->memory[m]) + (size_t)2 * w->memory[m].poles.n * w->space->stride);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &bytes, 1, MPIU_REAL, MPIU_SUM, w->space->comm));
  PetscCall(PetscViewerASCIIPrintf(
    viewer, "waves: %s, period %" PetscInt_FMT " x %" PetscInt_FMT " cells, shortest step %.3g s, memory %.3g MB\n",
    w->space->line     ? (w->space->mirror ? "antiplane line up to the ground" : "antiplane line in a full space")
    : w->space->mirror ? "plane up to the ground, for which the image of slip stands: an approximation"
                       : "plane in a full space",
    w->space->length[0], w->space->length[1], (double)w->least, (double)bytes / 1e6));
  PetscCall(PetscViewerASCIIPrintf(viewer, "  waves of periodic images come %.3g s after slip\n", (double)first));
  for (PetscInt m = 0; m < w->space->modes; m++)
    PetscCall(PetscViewerASCIIPrintf(viewer, "  mode %s: %" PetscInt_FMT " exponentials, error %.1e\n",
                                     w->memory[m].mode == SLIP_WAVE_INPLANE ? "II" : "III", w->memory[m].poles.n,
                                     (double)w->memory[m].poles.error));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipWavesDestroy(SlipElastic el)
{
  SlipWaves *w;

  PetscFunctionBegin;
  PetscCall(SlipElasticGetData(el, &w));
  for (int m = 0; m < SLIP_WAVE_KERNELS; m++) free(w->past.z[m]);
  fftw_free(w->past.now);
  fftw_free(w->past.slip);
  for (int i = 0; i < SLIP_WAVE_TABLES; i++)
    for (int m = 0; m < SLIP_WAVE_KERNELS; m++) {
      free(w->table[i].E[m]);
      fftw_free(w->table[i].step[m]);
    }
  fftw_free(w->next);
  fftw_free(w->slip);
  fftw_free(w->rate);
  fftw_free(w->stress);
  fftw_free(w->m);
  PetscCall(PetscFree(w->stiffness));
  for (PetscInt m = 0; m < w->kernels; m++) PetscCall(SlipWaveMemoryDestroy(&w->memory[m]));
  PetscCall(SlipWaveImagesDestroy(&w->images));
  PetscCall(SlipWaveSpaceDestroy(&w->space));
  PetscCall(VecDestroy(&w->last));
  PetscCall(VecDestroy(&w->answer));
  PetscCall(PetscFree(w));
  PetscFunctionReturn(PETSC_SUCCESS);
}
