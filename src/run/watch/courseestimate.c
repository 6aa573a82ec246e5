/* Records the course of a run, mean slip over time, and estimates how far local errors shift it.

   For one cell with v, a = dv/dt and s of the exact run, a local error (e_v, e_s) of the state is a step of e_s/v along
   the trajectory, and at equal slip a change of the kinetic energy by M (v e_v - a e_s). Along the slip that change
   decays as exp(-H/M t), like the energy in slipestimate.c, and it makes the run early against the exact one by
       d(early)/dt = (change of M v^2/2) / (M v^2).
   Sums over the cells replace one cell's numbers. In exponential growth the integrand falls as fast as v^2 grows, so
   that errors from the time of small v have had all of their effect when v is largest: the shift of the event is the
   integral up to then. Later v falls, the linear formula grows without bounds, and the final slip has the remaining
   error.

   Between the ends of a step the course is a cubic. A quintic with the accelerations differs from it in the middle by
   h (v0 - v1)/32 + h^2 (a0 + a1)/64. */
#include <slipstep/private/sliprun.h>

/* ---- the course ---- */

/* Adds a node at a time, and removes later ones, which belong to attempts that were rejected. */
PetscErrorCode SlipFaultCourseAdd(SlipFault fault, SlipFaultCourse *course, PetscReal time, Vec w)
{
  PetscReal sum[TIMING_SUMS] = {0};

  PetscFunctionBegin;
  PetscCall((*fault->cell_ops->course)(fault, time, w, sum));
  time += fault->loads.origin;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 2, MPIU_REAL, MPI_SUM, fault->comm));
  while (course->n && course->node[course->n - 1].time >= time) course->n--;
  if (course->n == course->size) {
    course->size = PetscMax(64, 2 * course->size);
    PetscCall(PetscRealloc((size_t)course->size * sizeof(*course->node), &course->node));
  }
  course->node[course->n++] =
    (SlipCourseNode){.time = time, .slip = sum[TIMING_SLIPS] / fault->mesh.N, .rate = sum[TIMING_RATE] / fault->mesh.N};
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Saves or loads a checkpoint's part, in the group of the estimate. */
PetscErrorCode SlipFaultCourseState(SlipFault fault, SlipState s)
{
  SlipFaultCourse *course = &fault->run->error.course;
  SlipFaultTiming *timing = &fault->run->error.timing;

  PetscFunctionBegin;
  PetscCall(SlipStateReal(s, "excess", 2, timing->excess));
  PetscCall(SlipStateReal(s, "vigour", 1, &timing->vigour));
  PetscCall(SlipStateReal(s, "early", 2, timing->early));
  PetscCall(SlipStateReal(s, "largest_rate", 1, &timing->rate));
  PetscCall(SlipStateReal(s, "shift", 2, timing->shift));
  PetscCall(SlipStateReal(s, "acceleration", 1, &timing->acceleration));
  PetscCall(SlipStateReal(s, "bend", 1, &timing->bend));
  PetscCall(SlipStateCount(s, "nodes", PETSC_MAX_INT / 3, &course->n));
  if (course->n > course->size) {
    PetscCall(PetscRealloc((size_t)course->n * sizeof(*course->node), &course->node));
    course->size = course->n;
  }
  if (course->n) PetscCall(SlipStateReal(s, "course", 3 * course->n, &course->node->time));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the estimate ---- */

/* Returns the mean of 1/x over a step in which x changes exponentially from one value to another. */
static PetscReal MeanInverse(PetscReal x0, PetscReal x1)
{
  const PetscReal growth = PetscLogReal(x1 / x0);

  return PetscAbsReal(growth) < 1e-6 ? 1 / x1 : (1 / x0 - 1 / x1) / growth;
}

/* Updates the shift after an accepted step with a local error e, which must be multiplied by scale. */
PetscErrorCode SlipFaultTimingStep(SlipFault fault, TS ts, const SlipAttempt *attempt, Vec w, Vec e, PetscReal scale)
{
  SlipFaultRunError *est = &fault->run->error;
  SlipFaultTiming *timing = &est->timing;
  const PetscReal h = attempt->dt, decay = PetscExpReal(-est->decay * h);
  const SlipCourseNode *last = est->course.n ? &est->course.node[est->course.n - 1] : NULL;
  PetscReal sum[TIMING_SUMS], growth;
  Vec d;

  PetscFunctionBegin;
  PetscCall(TSBatheGetEstimates(ts, NULL, NULL, &d));
  if (!d || !last) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall((*fault->cell_ops->timing)(fault, w, e, d, sum));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, TIMING_SUMS, MPIU_REAL, MPI_SUM, fault->comm));
  growth = sum[TIMING_GROWTH] / fault->mesh.N;
  timing->bend = PetscMax(timing->bend, PetscAbsReal(h * (last->rate - sum[TIMING_RATE] / fault->mesh.N) / 32 +
                                                     h * h * (timing->acceleration + growth) / 64));
  timing->acceleration = growth;
  for (PetscInt k = 0; k < 2; k++) {
    const PetscReal along = scale * sum[TIMING_ALONG], excess = scale * sum[TIMING_EXCESS];

    if (timing->vigour > 0 && sum[TIMING_VIGOUR] > 0)
      timing->early[k] += timing->excess[k] * h * (1 + decay) / 2 * MeanInverse(timing->vigour, sum[TIMING_VIGOUR]);
    if (sum[TIMING_RATE] > 0) timing->early[k] += (k ? PetscAbsReal(along) : along) / sum[TIMING_RATE];
    timing->excess[k] = timing->excess[k] * decay + (k ? PetscAbsReal(excess) : excess);
  }
  timing->vigour = sum[TIMING_VIGOUR];
  if (sum[TIMING_RATE] > timing->rate) {
    timing->rate = sum[TIMING_RATE];
    timing->shift[0] = timing->early[0];
    timing->shift[1] = timing->early[1];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
