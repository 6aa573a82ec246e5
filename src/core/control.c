/* Rules by which controllers compute steps, on plain numbers, for TSAdapt types and the trainer's loops without
   objects */
#include <slipcompat.h>
#include <slipstep/rooms/slipcore.h>

/* ---- rules based on an error estimate E; q is the reciprocal of the power of h to which E is proportional ---- */

/* The heuristic's ratio of steps, min(growth, E^-q) */
PetscReal SlipControlHeuristic(PetscReal E, PetscReal q, PetscReal growth)
{
  return E > 0 ? PetscMin(growth, PetscPowReal(E, -q)) : growth;
}

/* The same after a step whose error exceeds a ceiling; the new step is between 0.1 and 0.9 of the old one. */
PetscReal SlipControlCeiling(PetscReal E, PetscReal ceiling, PetscReal q)
{
  return PetscClipInterval(SlipControlHeuristic(E / ceiling, q, 1), (PetscReal)0.1, (PetscReal)0.9);
}

/* Soederlind (2003), ACM TOMS 29, 1-26, table 1 and section 5; Arevalo et al. (2020) for H211b. */
#define USUAL (PetscReal)0.8, (PetscReal)1.2
const SlipFilter SlipFilters[] = {
  {"elementary", 1, PETSC_INFINITY, 0, USUAL},
  {"PI33", (PetscReal)3 / 2, -3, 0, USUAL},
  {"PI34", (PetscReal)10 / 7, -(PetscReal)10 / 4, 0, USUAL},
  {"PI42", (PetscReal)5 / 3, -5, 0, USUAL},
  {"H211PI", 6, 6, 0, USUAL},
  {"H211b2", 2, 2, 0.5, USUAL},
  {"H211b4", 4, 4, 0.25, USUAL},
  /* tuned by CMA-ES on random faults, 96 single cells and 32 meshes */
  {"fault_history", 0.6373, -8.001, -0.09116, 0.1642, 18.62},
};

/* The ratio of steps of a filter within its limits, after a step h; an accepted step updates the memory. Earlier errors
   must not accept a step whose own error requires less than the smallest ratio: after a step without error, when a
   block has come to rest, the filter's ratio is large whatever this error is. Nor may they reject one with E <= 1,
   because after rejected steps the ratio may be small. */
PetscReal SlipControlFilter(const SlipFilter *filter, SlipFilterMemory *memory, PetscReal q, PetscReal E, PetscReal h,
                            PetscBool always, PetscBool *accept)
{
  const PetscReal last = memory->h_last > 0 ? h / memory->h_last : 1;
  PetscReal r, used, alone;

  E = PetscMax(E, PETSC_SMALL);
  alone = PetscPowReal(E, -q);
  r = PetscPowReal(E, -q / filter->g1) * PetscPowReal(memory->error, -q / filter->g2) *
      PetscPowReal(last, -filter->kappa);
  *accept = alone >= 1 || PetscMin(r, alone) >= filter->r_min || always ? PETSC_TRUE : PETSC_FALSE;
  if (!*accept) return r < filter->r_min ? r : alone;
  used = always ? PetscMin(r, filter->r_max) : PetscClipInterval(r, filter->r_min, filter->r_max);
  /* If the limit acted, store the error that would give the limit; otherwise one step without error (a fault at rest)
     would make the filter accept the next one, however wrong that is. */
  memory->error = r > used ? E * PetscPowReal(r / used, filter->g1 / q) : E;
  memory->h_last = h;
  return used;
}

/* ---- rules around a trained policy ---- */

/* A policy may repeat a failing step for ever for the same observation: after too many failed attempts in a row the
   step is halved, and true returned, until one converges. */
PetscBool SlipControlHalve(PetscInt failures, PetscInt max_failures, PetscReal *h)
{
  if (failures < max_failures) return PETSC_FALSE;
  *h *= 0.5;
  return PETSC_TRUE;
}

/* After a rejected attempt at h the step is at most 0.9 h, whatever the policy chooses, and at most h/2 if the attempt
   before was rejected, too, because PETSc ends a run after ten in a row. rejected: attempts in a row */
PetscReal SlipControlShrink(PetscReal h, PetscReal next, PetscInt rejected)
{
  return PetscMin(next, (PetscReal)(rejected > 1 ? 0.5 : 0.9) * h);
}

/* A state at rest needs no steps. limit: the longest step while any cell moves [s]; rest: how long the state stays
   exactly at rest [s], 0 if it moves; left: time to the end of the run [s] */
PetscReal SlipControlRest(PetscReal h, PetscReal limit, PetscReal rest, PetscReal left)
{
  return rest > 0 ? PetscMax(PetscMin(rest, left), limit) : PetscMin(h, limit);
}

/* PETSc's rule for the final time (TS_EXACTFINALTIME_MATCHSTEP, TSAdaptChoose()) with its default factors: the last two
   steps are halves of the time left. */
PetscReal SlipControlMatch(PetscReal h, PetscReal left)
{
  if (left <= 0) return h;
  if ((PetscReal)1.01 * h > left) return left;
  return 2 * h > left ? (PetscReal)0.5 * left : h;
}

/* True if a time differs from the end of a run only by rounding */
PetscBool SlipControlAtEnd(PetscReal t, PetscReal end)
{
  return PetscAbsReal(end - t) <= 4 * PETSC_MACHINE_EPSILON * PetscAbsReal(end) ? PETSC_TRUE : PETSC_FALSE;
}

/* A step h = end - t, rounded, may end beyond the end if the sum t + h is rounded, too: returns the longest one that
   does not. If t is more than half of the end, neither is rounded. */
PetscReal SlipControlEnd(PetscReal h, PetscReal t, PetscReal end)
{
  while (t + h > end && SlipControlAtEnd(t + h, end)) h -= (PetscReal)0.5 * PETSC_MACHINE_EPSILON * h;
  return h;
}
