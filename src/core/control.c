/* Rules by which a controller sizes steps, on plain numbers: the TSAdapt types and the trainer's loops without objects
   follow the same. */
#include <slipcompat.h>
#include <slipcore.h>

/* ---- from an error estimate E; q: the reciprocal of the power of h that it goes with ---- */

/* The heuristic's ratio of steps, min(growth, E^-q) */
PetscReal SlipControlHeuristic(PetscReal E, PetscReal q, PetscReal growth)
{
  return E > 0 ? PetscMin(growth, PetscPowReal(E, -q)) : growth;
}

/* The same after a step whose error exceeds a ceiling; a tenth at least is taken off each time, nine at most. */
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

/* The ratio of steps of a filter within its limits, after a step h; the memory moves when the step is accepted. The
   errors before may not speak for a step whose own error asks for less than the least ratio: after one without error,
   of a block that has stuck, the filter's ratio is large whatever this error is. Nor against one with E <= 1: after
   refused steps it may be as small as that. */
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
  /* Where the cap acted, remember the error that would have asked for the cap: otherwise one step without error (a
     fault at rest) would vouch for the next one, however wrong that is. */
  memory->error = r > used ? E * PetscPowReal(r / used, filter->g1 / q) : E;
  memory->h_last = h;
  return used;
}

/* ---- round a learned policy ---- */

/* A policy may answer the same observation with the same failing step for ever: after too many failed attempts in a row
   the step is halved, and yes is returned, until one converges. */
PetscBool SlipControlHalve(PetscInt failures, PetscInt max_failures, PetscReal *h)
{
  if (failures < max_failures) return PETSC_FALSE;
  *h *= 0.5;
  return PETSC_TRUE;
}

/* After a rejected attempt at h a tenth of it at least is taken off, whatever the policy says, and half when the one
   before was rejected too: ten in a row end a run of PETSc's. rejected: attempts in a row. */
PetscReal SlipControlShrink(PetscReal h, PetscReal next, PetscInt rejected)
{
  return PetscMin(next, (PetscReal)(rejected > 1 ? 0.5 : 0.9) * h);
}

/* What rests needs no steps. limit: the longest step while anything moves [s]; rest: for how long the state stays
   exactly at rest [s], 0 when it moves; left: to the end of the run [s]. */
PetscReal SlipControlRest(PetscReal h, PetscReal limit, PetscReal rest, PetscReal left)
{
  return rest > 0 ? PetscMax(PetscMin(rest, left), limit) : PetscMin(h, limit);
}

/* PETSc's matching of the final time (TS_EXACTFINALTIME_MATCHSTEP, TSAdaptChoose()) with its default factors: the last
   two steps are halves of what is left. */
PetscReal SlipControlMatch(PetscReal h, PetscReal left)
{
  if (left <= 0) return h;
  if ((PetscReal)1.01 * h > left) return left;
  return 2 * h > left ? (PetscReal)0.5 * left : h;
}

/* Does rounding alone tell a time from the end of a run? */
PetscBool SlipControlAtEnd(PetscReal t, PetscReal end)
{
  return PetscAbsReal(end - t) <= 4 * PETSC_MACHINE_EPSILON * PetscAbsReal(end) ? PETSC_TRUE : PETSC_FALSE;
}

/* A step h = end - t, rounded, may end beyond the end when the sum t + h is rounded, too: the longest one that does
   not. Where t is more than half of the end neither is. */
PetscReal SlipControlEnd(PetscReal h, PetscReal t, PetscReal end)
{
  while (t + h > end && SlipControlAtEnd(t + h, end)) h -= (PetscReal)0.5 * PETSC_MACHINE_EPSILON * h;
  return h;
}
