/* Internal header of the medium "waves": fields on a plane or a line by wavenumbers, their memory, images of the fault,
   and the data of the medium */
#pragma once
#include <slipstep/rooms/slipwaves.h>
#include <slipstep/private/slipelastic.h>
#include <slipstep/private/slipmatgrid.h>

/* ---- wavespace.c ---- */

/* A spectrum is [modes][parts][stride] numbers, of which the first n are used: the wavenumbers of this process */
typedef struct _n_SlipWaveSpace *SlipWaveSpace;
struct _n_SlipWaveSpace {
  MPI_Comm comm;
  SlipElasticGrid grid;
  PetscInt components;
  PetscBool line;   /* antiplane, infinite along strike: one cell there */
  PetscBool mirror; /* it reaches the free surface, for which its image stands; spectra of a line are real then */
  PetscInt modes;   /* II and III of planes, III of lines */
  PetscInt parts;   /* 1 where spectra are real, 2 of other lines, 4 of planes: complex, of kz and of -kz down dip */
  PetscInt n, stride;
  PetscInt half;        /* wavenumbers down dip of a plane, of one sign */
  PetscInt length[2];   /* period in cells along strike and down dip; of a mirrored line including the mirror */
  PetscReal *k;         /* [stride] wavenumber, 0 beyond n [1/m] */
  PetscReal *share;     /* [stride] weight of products of two spectra in that of their fields, summed over all cells */
  PetscReal *ex, *ez;   /* [n], [2][n] its direction, on planes */
  PetscReal *ux, *uz;   /* [rows of cells of this process] of slip with one component on a plane */
  PetscReal *real[2];   /* fields along strike and down dip, of the same */
  PetscReal *column[2]; /* [waves along strike][length[1]] complex */
  fftw_plan plan[2][2]; /* forward and backward; of a line [0] */
  PetscReal *line_real, *line_wave; /* [padded], [waves of all processes] of a line */
  PetscMPIInt *counts, *starts;     /* of the waves of all processes, of a line */
  SlipTransposedFFT pencil;
  SlipGather gather;
};
/* Rows of cells, with those of the image of a plane */
static inline PetscInt SlipWaveSpaceRows(SlipWaveSpace s)
{
  return (s->mirror && !s->line ? 2 : 1) * s->grid.nz;
}
PETSC_INTERN PetscErrorCode SlipWaveSpaceCreate(Mat K, const SlipElasticRock *rock, SlipWaveSpace *space);
PETSC_INTERN PetscErrorCode SlipWaveSpaceForward(SlipWaveSpace space, Vec u, PetscReal spectrum[]);
PETSC_INTERN PetscErrorCode SlipWaveSpaceBackward(SlipWaveSpace space, const PetscReal spectrum[], Vec u);
PETSC_INTERN PetscErrorCode SlipWaveSpaceDestroy(SlipWaveSpace *space);

/* ---- wavememory.c: memory of one kernel; z_j is s_j times the integral of exp(s_j k cs t') V(t - t') k cs dt' ---- */
#define SLIP_WAVE_BLOCK 32 /* wavenumbers whose poles are adjacent in memory */
typedef struct {
  SlipWavePoles poles;
  SlipWaveMode mode;
  PetscInt field; /* index of its field in a spectrum */
  PetscInt parts, n, stride;
  PetscReal *k;      /* [stride] 1/m; 0: nothing is stored */
  PetscReal *weight; /* [stride] of its sum in the stress */
  PetscReal cs;
  PetscReal *b; /* [poles][2] amplitudes over s */
} SlipWaveMemory;
PETSC_INTERN PetscErrorCode SlipWaveMemoryCreate(SlipWaveSpace space, SlipWaveMode mode, PetscInt field,
                                                 PetscReal ratio, PetscReal cs, PetscReal tolerance, SlipWaveMemory *m);
PETSC_INTERN PetscErrorCode SlipWaveMemoryDestroy(SlipWaveMemory *m);
PETSC_INTERN size_t SlipWaveMemorySize(const SlipWaveMemory *m); /* of z: [blocks][poles][parts][2][block] */
/* For a step h: exponentials [blocks][poles][2][block], and the effect of slip at the constant rate 1 there [stride] */
PETSC_INTERN void SlipWaveMemoryTable(const SlipWaveMemory *m, PetscReal h, float E[], PetscReal step[]);
/* Computes the sum of Re b z, now and after a step without slip: next [parts][stride]. */
PETSC_INTERN void SlipWaveMemoryNext(const SlipWaveMemory *m, const float E[], const float z[], PetscReal next[]);
/* Computes z after a step with the rates V [parts][stride]. */
PETSC_INTERN void SlipWaveMemoryAdvance(const SlipWaveMemory *m, const float E[], const PetscReal V[], float z[],
                                        PetscReal now[], PetscReal next[]);
PETSC_INTERN void SlipWaveMemorySteady(const SlipWaveMemory *m, const PetscReal V[], float z[]);

/* ---- waveimages.c: the fault's periodic images, whose static stress is subtracted once their waves arrive ---- */
typedef struct _n_SlipWaveImages *SlipWaveImages;
PETSC_INTERN PetscErrorCode SlipWaveImagesCreate(SlipWaveSpace space, const SlipElasticRock *rock,
                                                 SlipWaveImages *images);
PETSC_INTERN PetscErrorCode SlipWaveImagesDestroy(SlipWaveImages *images);
/* Sets the displacement u for the functions below, until the next call. */
PETSC_INTERN PetscErrorCode SlipWaveImagesSet(SlipWaveImages images, Vec u);
/* Records that the fault had it at t, and discards data of later times. */
PETSC_INTERN PetscErrorCode SlipWaveImagesAdd(SlipWaveImages images, PetscReal t);
PETSC_INTERN PetscErrorCode SlipWaveImagesStart(SlipWaveImages images);
/* Computes v times the effect of images at t minus that without delay; v NULL: it is u; result on process 0. */
PETSC_INTERN PetscErrorCode SlipWaveImagesWork(SlipWaveImages images, PetscReal t, PetscBool steady, Vec v,
                                               PetscReal *work);
/* f -= effect of images at t in the periodic stiffness */
PETSC_INTERN PetscErrorCode SlipWaveImagesSubtract(SlipWaveImages images, PetscReal t, PetscBool steady, Vec f);
PETSC_INTERN PetscErrorCode SlipWaveImagesVisit(SlipWaveImages images, SlipState state);

/* ---- waves.c, wavesetup.c, wavestate.c ---- */

enum { SLIP_WAVE_TABLES = 4, SLIP_WAVE_KERNELS = 3 }; /* stored tables for recent steps; kernels of a line */

/* Table for a step h */
typedef struct {
  PetscReal h; /* [s]; 0: none */
  PetscInt used;
  float *E[SLIP_WAVE_KERNELS]; /* of each kernel */
  PetscReal *step[SLIP_WAVE_KERNELS];
} SlipWaveTable;

/* Memory at the start of the step */
typedef struct {
  float *z[SLIP_WAVE_KERNELS]; /* SlipWaveMemorySize(); not allocated while slip is steady */
  PetscReal *now;              /* [kernels][parts][stride] sum of Re b z */
  PetscReal *slip;             /* spectrum of u */
  PetscBool steady;            /* all z are those of the rate `now` */
} SlipWavePast;

typedef struct {
  SlipWaveSpace space;
  SlipWaveImages images;
  PetscInt kernels;
  SlipWaveMemory memory[SLIP_WAVE_KERNELS];
  PetscReal *stiffness;              /* [modes][stride] of the periodic K [Pa/m] */
  PetscReal cp;                      /* of P waves [m/s] */
  PetscReal eta, cs, least, longest; /* G/(2 cs), smallest step, time after which memory is 0 [s] */
  SlipWaveTable table[SLIP_WAVE_TABLES];
  PetscInt clock;
  SlipWavePast past;
  PetscReal *next;  /* like `now`, after next_h without slip; */
  PetscReal next_h; /* 0: invalid */
  PetscReal *m;     /* spectrum of m/eta, of `slip` at m_h after the start */
  PetscReal m_h;
  PetscBool m_known;
  PetscReal *slip, *rate, *stress; /* spectra, work space */
  Vec last;                        /* whose spectrum `slip` is */
  PetscBool known;
  Vec answer; /* stress by it without a rate at answer_t */
  PetscReal answer_t;
  PetscBool answered;
} SlipWaves;

/* Number of entries of a spectrum, and of the sums of all kernels */
static inline size_t SlipWavesNumbers(const SlipWaves *w)
{
  return (size_t)w->space->modes * w->space->parts * w->space->stride;
}
static inline size_t SlipWavesSums(const SlipWaves *w)
{
  return (size_t)w->kernels * w->space->parts * w->space->stride;
}
/* The part of a field in a spectrum, or of a kernel in the memory */
static inline PetscReal *SlipWavesPart(const SlipWaves *w, PetscReal numbers[], PetscInt k)
{
  return numbers + (size_t)k * w->space->parts * w->space->stride;
}
PETSC_INTERN PetscErrorCode SlipWavesAllocate(size_t count, float **a); /* zero, free with free() */
PETSC_INTERN PetscErrorCode SlipWavesBegin(SlipWaves *w);
PETSC_INTERN PetscErrorCode SlipWavesSetUp(SlipElastic el, const SlipElasticRock *rock);
PETSC_INTERN PetscErrorCode SlipWavesView(SlipElastic el, PetscViewer viewer);
PETSC_INTERN PetscErrorCode SlipWavesImages(SlipElastic el, PetscReal *first, PetscReal *last);
PETSC_INTERN PetscErrorCode SlipWavesDestroy(SlipElastic el);
PETSC_INTERN PetscErrorCode SlipWavesVisit(SlipElastic el, SlipState state);
