/* Pure functions for waves that slip on a plane radiates: kernels of one wavenumber, fitted by sums of exponentials. */
#pragma once
#include <petscsys.h>

/* Slip at the rate V(t) with the wavenumber k on a plane in a full space meets three stresses: the static one, the
   impedance G/(2 cs) times V, and that of waves under way, (G k/2) int W(k cs t') V(t - t') dt'. */
typedef enum {
  SLIP_WAVE_ANTIPLANE, /* mode III: slip perpendicular to the wave vector */
  SLIP_WAVE_INPLANE    /* mode II: slip parallel to the wave vector */
} SlipWaveMode;

/* W(T) = Re sum_j a_j exp(s_j T) for T >= 0; every s_j has Re s_j < 0 and Im s_j >= 0 */
typedef struct {
  PetscInt n;
  PetscReal *s, *a; /* [n][2] real and imaginary parts */
  PetscReal error;  /* largest error of W at the sampled T, from 0 to SLIP_WAVE_LONGEST */
} SlipWavePoles;
#define SLIP_WAVE_LONGEST 1000
#define SLIP_WAVE_MOST_POLES 64
#define SLIP_WAVE_FINEST 1e-8 /* smallest tolerance of W */

/* W(0), the static stiffness of the mode over G k/2; ratio is cp/cs, on which mode III does not depend */
PETSC_EXTERN PetscReal SlipWaveStatic(SlipWaveMode mode, PetscReal ratio);
PETSC_EXTERN PetscErrorCode SlipWaveKernel(SlipWaveMode mode, PetscReal ratio, PetscInt n, const PetscReal T[],
                                           PetscReal W[]);
PETSC_EXTERN PetscErrorCode SlipWavePolesCreate(SlipWaveMode mode, PetscReal ratio, PetscReal tolerance,
                                                SlipWavePoles *poles);
PETSC_EXTERN PetscReal SlipWavePolesEvaluate(const SlipWavePoles *p, PetscReal T);
PETSC_EXTERN PetscErrorCode SlipWavePolesDestroy(SlipWavePoles *p);
