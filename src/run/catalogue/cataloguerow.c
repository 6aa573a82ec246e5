/* Computes the numbers of an event: those of its row, and of several faults those of each. The energy that friction
   dissipates is a sum over cells, and so are moment, area, slip and stress drop. Elastic and radiated energy depend on
   the interactions of all cells, so that a fault has no share of its own. */
#include <slipstep/private/sliprunfiles.h>
#include <slipstep/private/slipelasticity.h>
#include <slipstep/private/slipsys.h>
#include <math.h>

/* Of several cells that are the fastest to this relative difference, the one with the least number is used: so the
   result does not depend on rounding or on the number of ranks. */
#define EVENT_TIE 1e-6

PetscErrorCode SlipCatalogueEnergies(SlipFault fault, PetscReal t, Vec w, PetscReal *elastic, PetscReal *kinetic)
{
  const PetscReal *a;
  PetscReal sum = 0;

  PetscFunctionBegin;
  PetscCall(SlipFaultElasticEnergy(fault, t, w, elastic));
  PetscCall(VecGetArrayRead(w, &a));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    const PetscReal *v = a + SlipFaultRateAt(fault, i);

    sum += fault->mesh.weight[i] * (SlipFaultDot(fault, v, v) + PetscSqr(SlipFaultAcross(fault, v)));
  }
  PetscCall(VecRestoreArrayRead(w, &a));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPIU_REAL, MPIU_SUM, fault->comm));
  *kinetic = fault->kind.inertia ? 0.5 * fault->operators.mass * fault->mesh.area * sum : 0; /* M v.v/2 */
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- hypocentres ---- */

PetscErrorCode SlipCatalogueFastest(SlipFault fault, Vec w, PetscInt n, const PetscInt group[], const PetscReal max[],
                                    PetscInt cell[])
{
  const PetscReal *a;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < n; k++) cell[k] = fault->mesh.N;
  PetscCall(VecGetArrayRead(w, &a));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    const PetscInt row = SlipFaultMeshRow(&fault->mesh, i), k = group ? group[row] : 0;

    if (SlipFaultSpeed(fault, a, i) >= max[k] * (1 - EVENT_TIE)) cell[k] = PetscMin(cell[k], row);
  }
  PetscCall(VecRestoreArrayRead(w, &a));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, cell, (PetscMPIInt)n, MPIU_INT, MPI_MIN, fault->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the hypocentres of the faults that broke in a step of this length, which ended in w: the cell that exceeded the
   rate first, of several at once the fastest. This costs three reductions until all faults have broken, and then none.
   Collective. */
PetscErrorCode SlipCatalogueHypocentres(SlipFaultCatalogue cat, PetscReal dt, Vec w)
{
  SlipFault fault = cat->fault;
  const SlipFaultMesh *mesh = &fault->mesh;
  const PetscReal *a, *t;
  const SlipArrays arrays[] = {{w, .read = &a}, {cat->rupture, .read = &t}};
  PetscReal *first, *max;
  PetscInt *cell, n = 0;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < mesh->faults && cat->hypocentre; k++) n += cat->hypocentre[k] < 0 ? 1 : 0;
  if (!n) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscCalloc3(mesh->faults, &first, mesh->faults, &max, mesh->faults, &cell));
  for (PetscInt k = 0; k < mesh->faults; k++) {
    first[k] = PETSC_MAX_REAL;
    cell[k] = mesh->N;
  }
  PetscCall(SlipArraysGet(2, arrays));
  for (int pass = 0; pass < 3; pass++) {
    for (PetscInt i = 0; i < mesh->n; i++) {
      const PetscInt row = SlipFaultMeshRow(mesh, i), k = SlipFaultMeshFaultOf(mesh, row);
      const PetscReal speed = SlipFaultSpeed(fault, a, i);

      if (t[i] < 0 || (pass && t[i] > first[k] + EVENT_TIE * dt)) continue;
      if (pass == 0) first[k] = PetscMin(first[k], t[i]);
      if (pass == 1) max[k] = PetscMax(max[k], speed);
      if (pass == 2 && speed >= max[k] * (1 - EVENT_TIE)) cell[k] = PetscMin(cell[k], row);
    }
    if (pass < 2)
      PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, pass ? max : first, (PetscMPIInt)mesh->faults, MPIU_REAL,
                                 pass ? MPIU_MAX : MPIU_MIN, fault->comm));
  }
  PetscCall(SlipArraysRestore(2, arrays));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, cell, (PetscMPIInt)mesh->faults, MPIU_INT, MPI_MIN, fault->comm));
  if (!cat->event.steps) cell[SlipFaultMeshFaultOf(mesh, cat->event.cell)] = cat->event.cell;
  for (PetscInt k = 0; k < mesh->faults; k++)
    if (cat->hypocentre[k] < 0 && cell[k] < mesh->N) cat->hypocentre[k] = cell[k];
  PetscCall(PetscFree3(first, max, cell));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the cell of a fault at rest whose stress exceeds its strength most in the state w. It slips first, however long
   the step in which this appears. *first does not change where there is none. Collective. */
PetscErrorCode SlipCatalogueFirstToSlip(SlipFaultCatalogue cat, PetscReal t, Vec w, PetscInt *first)
{
  SlipFault fault = cat->fault;
  const PetscReal tiny = 1e-9; /* over the strength: the rounding of both */
  const PetscReal *stress, *strength;
  const SlipArrays arrays[] = {{cat->stress, .read = &stress}, {fault->cells, .read = &strength}};
  const PetscInt c = fault->layout.components;
  PetscReal most = 0;
  PetscInt cell = fault->mesh.N;

  PetscFunctionBegin;
  PetscCall(SlipFaultStress(fault, t, w, cat->stress));
  PetscCall(SlipFaultStrength(fault, t, w, fault->cells));
  PetscCall(SlipArraysGet(2, arrays));
  for (int pass = 0; pass < 2; pass++) {
    for (PetscInt i = 0; i < fault->mesh.n; i++) {
      const PetscReal bound = strength[i] / fault->mesh.weight[i],
                      excess = SlipFaultLength(fault, stress + c * i) - bound;

      if (excess <= tiny * bound) continue;
      if (!pass) most = PetscMax(most, excess);
      if (pass && excess >= most * (1 - EVENT_TIE)) cell = PetscMin(cell, SlipFaultMeshRow(&fault->mesh, i));
    }
    if (!pass) PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPIU_REAL, MPIU_MAX, fault->comm));
  }
  PetscCall(SlipArraysRestore(2, arrays));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &cell, 1, MPIU_INT, MPI_MIN, fault->comm));
  if (cell < fault->mesh.N) *first = cell;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- sums ---- */

/* Sums over the cells, areas over their mean: of slip; of the ruptured cells of area, slip and stress drop; and of
   their second components */
enum { SUM_SLIP, SUM_AREA, SUM_BROKEN, SUM_DROP, SUM_SLIP_UP, SUM_BROKEN_UP, SUM_DROP_UP, NUM_SUMS };
/* and of the two components of their slip, along strike and up dip; of all cells the stress at the onset times slip */
enum { SUM_ALONG = NUM_SUMS, SUM_UP, SUM_WORK, NUM_ALL_SUMS };

/* Returns the radiated over the available energy; work: that of the stress at the onset. Minus the released energy it
   is half the static stress drop times slip, whatever waves are still present. */
static PetscReal RadiatedEfficiency(const PetscReal row[], PetscReal work)
{
  const PetscReal available = work + row[EVENT_ELASTIC_ENERGY] - row[EVENT_LOADING_WORK];

  return available > 0 ? row[EVENT_RADIATED_ENERGY] / available : (PetscReal)NAN;
}

/* Computes the slip of the event up to the state w at t; sum [NUM_ALL_SUMS], followed by NUM_SUMS for each of several
   faults; the largest slip forward and backward; for several faults the least time of rupture of each. */
static PetscErrorCode SumUp(SlipFaultCatalogue cat, PetscReal t, Vec w, PetscReal sum[], PetscReal largest[2],
                            PetscReal first[])
{
  SlipFault fault = cat->fault;
  const PetscInt faults = cat->hypocentre ? fault->mesh.faults : 0;
  const PetscInt components = fault->layout.components,
                 up = fault->layout.plane - 1; /* without a second component: the first */
  const PetscReal time = t - cat->event.onset, *a, *u0, *stress0, *stress, *rupture, *vinf;
  PetscReal *slip;
  const SlipArrays arrays[] = {{w, .read = &a},
                               {cat->u0, .read = &u0},
                               {cat->stress0, .read = &stress0},
                               {cat->stress, .read = &stress},
                               {cat->rupture, .read = &rupture},
                               {fault->operators.vinf, .read = &vinf},
                               {cat->slip, .write = &slip}};

  PetscFunctionBegin;
  PetscCall(SlipFaultStress(fault, t, w, cat->stress));
  PetscCall(PetscArrayzero(sum, NUM_ALL_SUMS + NUM_SUMS * faults));
  largest[0] = largest[1] = 0;
  for (PetscInt k = 0; k < faults; k++) first[k] = PETSC_MAX_REAL;
  PetscCall(SlipArraysGet(7, arrays));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    const PetscInt k = SlipFaultMeshFaultOf(&fault->mesh, SlipFaultMeshRow(&fault->mesh, i));
    const PetscReal weight = fault->mesh.weight[i], broke = rupture[i] < 0 ? 0 : weight, both = components > 1 ? 1 : 0;
    const PetscInt first_of = components * i, second_of = first_of + up;
    PetscReal sine, cosine;

    for (PetscInt j = 0; j < components; j++)
      slip[first_of + j] = a[SlipFaultDisplacementAt(fault, i) + j] - u0[first_of + j] + vinf[first_of + j] * time;
    {
      const PetscReal share[NUM_SUMS] = {[SUM_SLIP] = weight * slip[first_of],
                                         [SUM_AREA] = broke,
                                         [SUM_BROKEN] = broke * slip[first_of],
                                         [SUM_DROP] = broke * (stress0[first_of] - stress[first_of]),
                                         [SUM_SLIP_UP] = both * weight * slip[second_of],
                                         [SUM_BROKEN_UP] = both * broke * slip[second_of],
                                         [SUM_DROP_UP] = both * broke * (stress0[second_of] - stress[second_of])};

      for (PetscInt c = 0; c < NUM_SUMS; c++) {
        sum[c] += share[c];
        if (faults) sum[NUM_ALL_SUMS + NUM_SUMS * k + c] += share[c];
      }
    }
    for (PetscInt j = 0; j < fault->layout.plane; j++)
      sum[SUM_WORK] += weight * slip[first_of + j] * stress0[first_of + j];
    largest[0] = PetscMax(largest[0], components == 1 ? slip[i] : SlipFaultLength(fault, slip + first_of));
    largest[1] = PetscMax(largest[1], -slip[first_of]);
    if (rupture[i] < 0) continue;
    if (components == 1) {
      SlipDegrees(fault->fields.cell[FIELD_RAKE][i], &sine, &cosine);
      sum[SUM_ALONG] += weight * slip[i] * cosine;
      sum[SUM_UP] += weight * slip[i] * sine;
    } else {
      sum[SUM_ALONG] += weight * slip[first_of];
      sum[SUM_UP] += weight * slip[second_of];
    }
    if (faults) first[k] = PetscMin(first[k], rupture[i]);
  }
  PetscCall(SlipArraysRestore(7, arrays));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, (PetscMPIInt)(NUM_ALL_SUMS + NUM_SUMS * faults), MPIU_REAL, MPIU_SUM,
                             fault->comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, largest, 2, MPIU_REAL, MPIU_MAX, fault->comm));
  if (faults) PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, first, (PetscMPIInt)faults, MPIU_REAL, MPIU_MIN, fault->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the rupture speed ---- */

/* Computes the distances [m] of all cells from the place where the event began: the mean place of the ruptured cells,
   with the largest weights for the earliest; mean: mean time of rupture. Collective. */
static PetscErrorCode Distances(const SlipFaultMesh *mesh, const PetscReal rupture[], PetscReal *mean, PetscReal far[])
{
  enum { X, Y, Z, WEIGHT, NUM };
  const PetscReal early = 0.1; /* over the mean time: a time later by this has the weight 1/e */
  PetscReal sum[2] = {0, 0}, centre[NUM] = {0};
  SlipFaultCell cell;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < mesh->n; i++) {
    if (rupture[i] < 0) continue;
    sum[0] += mesh->weight[i];
    sum[1] += mesh->weight[i] * rupture[i];
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 2, MPIU_REAL, MPIU_SUM, mesh->comm));
  *mean = sum[1] / sum[0];
  if (!(*mean > 0)) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt i = 0; i < mesh->n; i++) {
    const PetscReal w = rupture[i] < 0 ? 0 : mesh->weight[i] * PetscExpReal(-rupture[i] / (early * *mean));

    mesh->kind->cell(mesh, SlipFaultMeshRow(mesh, i), &cell);
    for (int k = X; k <= Z; k++) centre[k] += w * cell.centre[k];
    centre[WEIGHT] += w;
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, centre, NUM, MPIU_REAL, MPIU_SUM, mesh->comm));
  for (PetscInt i = 0; i < mesh->n; i++) {
    PetscReal d[3];

    mesh->kind->cell(mesh, SlipFaultMeshRow(mesh, i), &cell);
    for (int k = X; k <= Z; k++) d[k] = cell.centre[k] - centre[k] / centre[WEIGHT];
    far[i] = hypot(hypot(d[0], d[1]), d[2]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the speed from the straight line of rupture times over these distances with the least sum of absolute errors,
   over the area. Cells that reach the rate long before the front, in a nucleation, or after it, as slip spreads after
   an event, do not turn this line, as they would that of least squares. The weights are the inverse errors of the line
   before (Schlossmacher 1973), with errors of at least a share of the mean time. Unknown where later is not farther.
   Collective. */
static PetscErrorCode RuptureSpeed(SlipFaultCatalogue cat, PetscReal *speed)
{
  enum { AREA, FAR, TIME, FAR_FAR, FAR_TIME, NUM, PASSES = 30 }; /* the same number on any number of ranks */
  const PetscReal small = 1e-3;                                  /* errors over the mean time */
  const SlipFaultMesh *mesh = &cat->fault->mesh;
  const PetscReal *rupture;
  PetscReal *far, intercept = 0, slope = 0, mean = 0;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(mesh->n, &far));
  PetscCall(VecGetArrayRead(cat->rupture, &rupture));
  PetscCall(Distances(mesh, rupture, &mean, far));
  for (int pass = 0; pass < PASSES && mean > 0; pass++) {
    PetscReal sum[NUM] = {0};

    for (PetscInt i = 0; i < mesh->n; i++) {
      const PetscReal off = PetscAbsReal(rupture[i] - intercept - slope * far[i]);
      const PetscReal w = mesh->weight[i] / (pass ? PetscMax(off, small * mean) : 1);

      if (rupture[i] < 0) continue;
      sum[AREA] += w;
      sum[FAR] += w * far[i];
      sum[TIME] += w * rupture[i];
      sum[FAR_FAR] += w * far[i] * far[i];
      sum[FAR_TIME] += w * far[i] * rupture[i];
    }
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, NUM, MPIU_REAL, MPIU_SUM, mesh->comm));
    slope = (sum[AREA] * sum[FAR_TIME] - sum[FAR] * sum[TIME]) / (sum[AREA] * sum[FAR_FAR] - PetscSqr(sum[FAR]));
    intercept = (sum[TIME] - slope * sum[FAR]) / sum[AREA];
  }
  PetscCall(VecRestoreArrayRead(cat->rupture, &rupture));
  PetscCall(PetscFree(far));
  *speed = slope > 0 ? 1 / slope : (PetscReal)NAN;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the row ---- */

/* Returns sums along the event's direction; with one component, times the sign of its slip. */
static PetscReal AlongEvent(const PetscReal direction[2], const PetscReal sum[], PetscInt first, PetscInt second)
{
  return direction[0] * sum[first] + direction[1] * sum[second];
}

/* Fills in the numbers of each fault. Means over ruptured cells are unknown where none ruptured. along: unit vector of
   the event's slip, or its sign for one component */
static void FillFaults(SlipFaultCatalogue cat, const PetscReal along[2], const PetscReal sums[],
                       const PetscReal first[])
{
  const SlipFault fault = cat->fault;
  const PetscInt faults = fault->mesh.faults;
  const PetscReal area = fault->mesh.area, unknown = (PetscReal)NAN;

  for (PetscInt k = 0; k < faults && cat->hypocentre; k++) {
    const PetscReal *sum = sums + NUM_SUMS * k, *const work = cat->work + FAULT_NUM_WORKS;
    const PetscBool broke = cat->hypocentre[k] >= 0 ? PETSC_TRUE : PETSC_FALSE;
    const PetscReal value[] = {[EVENT_FAULT_MOMENT - EVENT_NUM_COLUMNS] = fault->options.value[FAULT_SHEAR_MODULUS] *
                                                                          area *
                                                                          AlongEvent(along, sum, SUM_SLIP, SUM_SLIP_UP),
                               [EVENT_FAULT_AREA - EVENT_NUM_COLUMNS] = area * sum[SUM_AREA],
                               [EVENT_FAULT_MEAN_SLIP - EVENT_NUM_COLUMNS] =
                                 broke ? AlongEvent(along, sum, SUM_BROKEN, SUM_BROKEN_UP) / sum[SUM_AREA] : unknown,
                               [EVENT_FAULT_STRESS_DROP - EVENT_NUM_COLUMNS] =
                                 broke ? AlongEvent(along, sum, SUM_DROP, SUM_DROP_UP) / sum[SUM_AREA] : unknown,
                               [EVENT_FAULT_ONSET - EVENT_NUM_COLUMNS] = broke ? cat->event.onset + first[k] : unknown,
                               [EVENT_FAULT_CELL - EVENT_NUM_COLUMNS] = (PetscReal)cat->hypocentre[k],
                               [EVENT_FAULT_DISSIPATED_ENERGY - EVENT_NUM_COLUMNS] = work[k]};

    for (PetscInt c = 0; c < EVENT_ALL_COLUMNS - EVENT_NUM_COLUMNS; c++)
      cat->row[EVENT_NUM_COLUMNS + c * faults + k] = value[c];
  }
}

/* Returns the rake of a slip with these components [degrees], in (-180, 180]; a zero may have either sign. */
static PetscReal Rake(PetscReal along, PetscReal up)
{
  const PetscReal rake = PetscAtan2Real(up, along) * 180 / PETSC_PI;

  return rake <= -180 ? 180 : rake;
}

PetscErrorCode SlipCatalogueFillRow(SlipFaultCatalogue cat, PetscReal end, Vec w)
{
  SlipFault fault = cat->fault;
  const SlipFaultEvent *e = &cat->event;
  const PetscReal area = fault->mesh.area, *const work = cat->work;
  PetscReal *const row = cat->row, *sum, *first, largest[2], elastic, kinetic, terms, along[2] = {1, 0};
  SlipFaultCell cell;

  PetscFunctionBegin;
  PetscCall(PetscMalloc2(NUM_ALL_SUMS + NUM_SUMS * fault->mesh.faults, &sum, fault->mesh.faults, &first));
  PetscCall(SumUp(cat, end, w, sum, largest, first));
  PetscCall(SlipCatalogueEnergies(fault, end, w, &elastic, &kinetic));
  PetscCall(SlipFaultTermsEnergy(fault, end, w, &terms));
  fault->mesh.kind->cell(&fault->mesh, e->cell, &cell);
  if (fault->layout.components == 1) {
    along[0] = sum[SUM_BROKEN] < 0 ? -1 : 1;
    PetscCall(VecScale(cat->slip, along[0]));
  } else {
    const PetscReal length = hypot(sum[SUM_BROKEN], sum[SUM_BROKEN_UP]);

    if (length > 0) {
      along[0] = sum[SUM_BROKEN] / length;
      along[1] = sum[SUM_BROKEN_UP] / length;
    }
  }
  row[EVENT_ONSET] = e->onset;
  row[EVENT_END] = end;
  row[EVENT_X] = cell.centre[0];
  row[EVENT_Y] = cell.centre[1];
  row[EVENT_Z] = cell.centre[2];
  row[EVENT_CELL] = (PetscReal)e->cell;
  row[EVENT_AREA] = area * sum[SUM_AREA];
  row[EVENT_MEAN_SLIP] = AlongEvent(along, sum, SUM_BROKEN, SUM_BROKEN_UP) / sum[SUM_AREA];
  row[EVENT_MAX_SLIP] = largest[fault->layout.components > 1 || along[0] > 0 ? 0 : 1];
  row[EVENT_DIRECTION] = fault->layout.components > 1 ? 1 : along[0];
  row[EVENT_MOMENT] =
    fault->options.value[FAULT_SHEAR_MODULUS] * area *
    (fault->layout.components == 1 ? PetscAbsReal(sum[SUM_SLIP]) : hypot(sum[SUM_SLIP], sum[SUM_SLIP_UP]));
  row[EVENT_MAGNITUDE] = SlipEventMagnitude(row[EVENT_MOMENT]);
  row[EVENT_STRESS_DROP] = AlongEvent(along, sum, SUM_DROP, SUM_DROP_UP) / sum[SUM_AREA];
  row[EVENT_PEAK_SLIP_RATE] = e->peak;
  row[EVENT_ELASTIC_ENERGY] = elastic - e->elastic;
  row[EVENT_KINETIC_ENERGY] = kinetic - e->kinetic;
  row[EVENT_DISSIPATED_ENERGY] = work[WORK_DISSIPATED];
  row[EVENT_RADIATED_ENERGY] = work[WORK_RADIATED];
  row[EVENT_LOADING_WORK] = work[WORK_LOADING] - terms;
  row[EVENT_ENERGY_RESIDUAL] = (row[EVENT_ELASTIC_ENERGY] + row[EVENT_KINETIC_ENERGY] + work[WORK_DISSIPATED] +
                                work[WORK_RADIATED] - row[EVENT_LOADING_WORK]) /
                               PetscAbsReal(row[EVENT_ELASTIC_ENERGY]);
  row[EVENT_STEPS] = (PetscReal)e->steps;
  row[EVENT_FAULT] = (PetscReal)fault->mesh.labels[SlipFaultMeshFaultOf(&fault->mesh, e->cell)];
  row[EVENT_RAKE] = Rake(sum[SUM_ALONG], sum[SUM_UP]);
  PetscCall(RuptureSpeed(cat, &row[EVENT_RUPTURE_SPEED]));
  row[EVENT_RADIATED_EFFICIENCY] = RadiatedEfficiency(row, area * sum[SUM_WORK]);
  row[EVENT_GOES_ON] = 0;
  row[EVENT_IMAGES] = e->images ? 1 : 0;
  FillFaults(cat, along, sum + NUM_ALL_SUMS, first);
  if (fault->kind.flows) {
    PetscReal *const last = row + cat->nrow - EVENT_FLUID_COLUMNS;

    last[0] = (PetscReal)NAN; /* without wells */
    for (PetscInt k = 0; k < fault->loads.nwells; k++) {
      const PetscReal *at = fault->loads.wells[k].place, *o = cell.centre;
      const PetscReal distance =
        PetscSqrtReal(PetscSqr(at[0] - o[0]) + PetscSqr(at[1] - o[1]) + PetscSqr(at[2] - o[2]));

      last[0] = k ? PetscMin(last[0], distance) : distance;
    }
    last[1] = e->pressure;
  }
  PetscCall(PetscFree2(sum, first));
  PetscFunctionReturn(PETSC_SUCCESS);
}
