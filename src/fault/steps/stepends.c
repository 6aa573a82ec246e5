/* Finds where steps end: at corners of records of pressure and stress, and where a cell stops; and how long they are
   under tides.

   A step that passes a corner uses a load without one. The pressure that its stages do not see differs from the
   record by at most the distance of the record from its chord between the ends of the step. Slip under friction follows
   a load without adding up its errors: a stress error d at any times leaves a slip error of d over the stiffness of the
   fault. So a step passes corners while mu times that distance is small against the stress that corresponds to the
   wanted error of slip (SlipFaultLoadTolerance()), and else ends at the last corner up to which this holds. Steps end
   at the corners of large jumps, and of records of few corners, to the rounding of time; a record that samples a smooth
   curve costs as much as the curve. */
#include <slipstep/private/slipfault.h>

/* The inputs and work arrays of the search for corners between t and end that a step may pass. Loads are the pressure
   of the cells [n], less normal stress, and where a record has shear that too. */
typedef struct {
  SlipFault fault;
  PetscReal t, end;
  PetscInt first, m;
  PetscReal *tolerance, *start, *there; /* [m] of loads, at t, at a corner [Pa] */
  PetscReal *low, *high;                /* [m] slopes of chords from t that miss no corner by more [Pa/s] */
} Chord;

/* Returns the time of corner k, or the end after the last corner. */
static PetscReal TimeOf(const Chord *c, PetscInt k)
{
  const SlipFaultLoads *loads = &c->fault->loads;

  return k < loads->ncorners && loads->corners[k] < c->end ? loads->corners[k] : c->end;
}

static void LoadsAt(const Chord *c, PetscReal t, PetscReal x[])
{
  const SlipFaultLoads *loads = &c->fault->loads;

  for (PetscInt i = 0; i < c->m; i++) x[i] = 0;
  if (loads->rows) SlipLoadsAddRecord(loads, t, x);
  SlipLoadsAddTerms(loads, t, PETSC_TRUE, NULL, c->m > loads->n ? x + loads->n : NULL, x);
}

/* Finds the last corner, or the end, to which a chord satisfies the tolerance at all corners before it, for all ranks.
   The bounds of its slope narrow at each corner, load by load. */
static PetscErrorCode Last(Chord *c, PetscInt *last)
{
  PetscInt k = c->first;
  PetscBool misses = PETSC_FALSE;

  PetscFunctionBegin;
  for (PetscReal time = c->t; !misses && time < c->end; k++) {
    const PetscReal length = TimeOf(c, k) - c->t;

    time = TimeOf(c, k);
    LoadsAt(c, time, c->there);
    for (PetscInt i = 0; i < c->m; i++) {
      const PetscReal rise = c->there[i] - c->start[i];
      const PetscReal high = (rise + c->tolerance[i]) / length, low = (rise - c->tolerance[i]) / length;

      if (k > c->first && (rise > c->high[i] * length || rise < c->low[i] * length)) misses = PETSC_TRUE;
      c->high[i] = k > c->first ? PetscMin(c->high[i], high) : high;
      c->low[i] = k > c->first ? PetscMax(c->low[i], low) : low;
    }
  }
  *last = misses ? k - 2 : k - 1;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, last, 1, MPIU_INT, MPI_MIN, c->fault->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscBool RecordsShear(const SlipFaultLoads *loads)
{
  for (PetscInt k = 0; k < loads->nterms; k++)
    if (loads->terms[k].rows && loads->terms[k].shear) return PETSC_TRUE;
  return PETSC_FALSE;
}

/*
  SlipFaultNextCorner - SlipStepOps.corner: finds the next corner at which a step from t must end

  Collective. t: start of the step of ts, from its solution. PETSC_MAX_REAL: it may end anywhere. Constant steps, and
  runs without error control, end at every corner.
*/
PetscErrorCode SlipFaultNextCorner(TS ts, PetscReal t, PetscReal *next, void *ctx)
{
  SlipFault fault = (SlipFault)ctx;
  const SlipFaultLoads *loads = &fault->loads;
  const PetscInt n = loads->n, c = fault->layout.components, m = RecordsShear(loads) ? (1 + c) * n : n;
  Chord chord = {.fault = fault, .t = t, .first = SlipLoadsCornerAfter(loads, t), .m = m};
  PetscReal h, relative, stop;
  PetscInt last;
  Vec w;

  PetscFunctionBegin;
  PetscCall(SlipFaultReportOpening(fault, t));
  *next = SlipLoadsNextCorner(loads, t);
  PetscCall(TSGetTimeStep(ts, &h));
  if (t + h <= *next || chord.first == loads->ncorners || *next < loads->corners[chord.first])
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipFaultStepsError(fault, ts, &relative));
  if (relative <= 0) PetscFunctionReturn(PETSC_SUCCESS);
  stop = SlipLoadsNextEnd(loads, *next);
  chord.end = PetscMin(t + h, stop);
  PetscCall(PetscCalloc5(m, &chord.tolerance, m, &chord.start, m, &chord.there, m, &chord.low, m, &chord.high));
  PetscCall(TSGetSolution(ts, &w));
  PetscCall(SlipFaultLoadTolerance(fault, relative, t, w, chord.tolerance, m > n ? chord.there : NULL));
  for (PetscInt i = n; i < m; i++) chord.tolerance[i] = chord.there[(i - n) / c];
  LoadsAt(&chord, t, chord.start);
  PetscCall(Last(&chord, &last));
  *next = TimeOf(&chord, last) < chord.end ? loads->corners[last] : stop;
  PetscCall(PetscFree5(chord.tolerance, chord.start, chord.there, chord.low, chord.high));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the periods of courses ----

   Error estimates see a tide, or the rise of a nucleation, only in steps that are short against it: longer ones see its
   values at a few points, which may be the same phase again and again. Steps of an eighth of the period are seen, and
   the estimate then limits them further where it must. A tide whose stress is within the tolerance for loads above may
   be passed, which is told. */
static const PetscReal of_period = 0.125;

/* Finds whether the stress of a term exceeds the tolerances in some cell. Collective. */
static PetscErrorCode Matters(SlipFault fault, const SlipLoadTerm *term, const PetscReal pressure[],
                              const PetscReal shear[], PetscBool *does)
{
  const PetscInt c = fault->layout.components;
  PetscBool mine = PETSC_FALSE;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    if (term->shear && SlipFaultLength(fault, term->shear + c * i) > shear[i]) mine = PETSC_TRUE;
    if (term->normal && PetscAbsReal(term->normal[i]) > pressure[i]) mine = PETSC_TRUE;
  }
  PetscCallMPI(MPI_Allreduce(&mine, does, 1, MPIU_BOOL, MPI_LOR, fault->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TellOfPeriods(SlipFault fault, const SlipLoadTerm *term, PetscReal h, PetscBool constant)
{
  PetscMPIInt rank;

  PetscFunctionBegin;
  if (fault->loads.passed) PetscFunctionReturn(PETSC_SUCCESS);
  fault->loads.passed = PETSC_TRUE;
  PetscCallMPI(MPI_Comm_rank(fault->comm, &rank));
  if (rank) PetscFunctionReturn(PETSC_SUCCESS);
  if (constant)
    PetscCall(SlipWarning("the constant steps of %.6g s are longer than an eighth of the %s: expected shorter ones, or "
                          "another -ts_adapt_type than none",
                          (double)h, term->name));
  else
    PetscCall(
      SlipWarning("the stress of the %s is below what errors of the run may be: steps pass its periods. A lower "
                  "-%sfault_accuracy or -ts_rtol resolves them",
                  term->name, SlipFaultPrefix(fault)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Shortens the next step of ts to what courses allow; before each step. Collective. */
PetscErrorCode SlipFaultLimitStep(SlipFault fault, TS ts)
{
  const SlipFaultLoads *loads = &fault->loads;
  PetscReal t, h, relative, *pressure, *shear;
  Vec w;

  PetscFunctionBegin;
  PetscCall(TSGetTime(ts, &t));
  PetscCall(TSGetTimeStep(ts, &h));
  if (h <= of_period * SlipLoadsScale(loads, t)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipFaultStepsError(fault, ts, &relative));
  PetscCall(TSGetSolution(ts, &w));
  PetscCall(PetscMalloc2(loads->n, &pressure, loads->n, &shear));
  if (relative > 0) PetscCall(SlipFaultLoadTolerance(fault, relative, t, w, pressure, shear));
  for (PetscInt k = 0; k < loads->nterms; k++) {
    const SlipLoadTerm *term = &loads->terms[k];
    const PetscReal longest = of_period * term->course->scale(term, t);
    PetscBool matters = PETSC_FALSE;

    if (h <= longest) continue;
    if (relative > 0) PetscCall(Matters(fault, term, pressure, shear, &matters));
    if (matters)
      h = longest;
    else
      PetscCall(TellOfPeriods(fault, term, h, relative > 0 ? PETSC_FALSE : PETSC_TRUE));
  }
  PetscCall(PetscFree2(pressure, shear));
  PetscCall(TSSetTimeStep(ts, h));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- where a cell stops ----

   Finds where in a step the cell stops that has most of the slip rate. With inertia its acceleration jumps there. A
   step across the jump has an error of slip that grows with the square of the step and depends on the place of the stop
   in it. A step in which the cell turns back has an error of its rate that grows with the step, and later steps do not
   correct it. Steps that end at the stop have neither error. Of many sliding cells some stop in every step and matter
   little: the error estimate covers them. */

/* The least share of the sum of all slip rates; and the remaining slip up to the stop, over d_c and the relative
   tolerance, below which the stop does not matter */
static const PetscReal least_share = 0.5, least_slip = 0.03;

/* Returns the root of v in (0, h] on the parabola through v0 with the slope k0 and through vm at x; at most x when vm
   is beyond the root. */
static PetscReal Root(PetscReal v0, PetscReal k0, PetscReal vm, PetscReal x, PetscReal h)
{
  const PetscReal c = (vm - v0 - k0 * x) / (x * x);
  PetscReal root, square = k0 * k0 - 4 * c * v0;

  if (vm <= 0) return k0 < 0 ? PetscMin(-v0 / k0, x) : x;
  root = square >= 0 ? 2 * v0 / (-k0 + PetscSqrtReal(square)) : h;
  return root > x && root < h ? root : h;
}

/* Returns the component of x along v, whose length is size. */
static PetscReal Component(SlipFault fault, const PetscReal v[], PetscReal size, const PetscReal x[])
{
  return fault->layout.components == 1 ? (v[0] < 0 ? -x[0] : x[0]) : SlipFaultDot(fault, v, x) / size;
}

/*
  SlipFaultStop - finds how long after the start of a step h [s] the cell with most of the slip rate stops;
  PETSC_MAX_REAL if it does not

  Collective. state: states at the shares 0, share and 1 of the step; k0: the derivative at its start. A stop before
  which slip is small against rtol d_c does not count.
*/
PetscErrorCode SlipFaultStop(SlipFault fault, PetscReal h, PetscReal rtol, PetscReal share, const Vec state[3], Vec k0,
                             PetscReal *stop)
{
  const PetscReal *a, *b, *c, *d, *slip = fault->fields.cell[FIELD_FRICTION_SLIP];
  const SlipArrays arrays[] = {
    {state[0], .read = &a}, {state[1], .read = &b}, {state[2], .read = &c}, {k0, .read = &d}};
  PetscReal sum = 0;

  PetscFunctionBegin;
  *stop = PETSC_MAX_REAL;
  PetscCall(SlipArraysGet(4, arrays));
  for (PetscInt i = 0; i < fault->mesh.n; i++) sum += fault->mesh.weight[i] * SlipFaultSpeed(fault, a, i);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPIU_REAL, MPIU_SUM, fault->comm));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    const PetscInt k = SlipFaultRateAt(fault, i);
    const PetscReal v0 = SlipFaultSpeed(fault, a, i);
    PetscReal root;

    if (v0 == 0 || Component(fault, a + k, v0, c + k) > 0 || fault->mesh.weight[i] * v0 < least_share * sum) continue;
    root = Root(v0, Component(fault, a + k, v0, d + k), Component(fault, a + k, v0, b + k), share * h, h);
    if (v0 * root > least_slip * rtol * slip[i]) *stop = PetscMin(*stop, root);
  }
  PetscCall(SlipArraysRestore(4, arrays));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, stop, 1, MPIU_REAL, MPIU_MIN, fault->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}
