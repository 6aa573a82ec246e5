/* Computes the pressure of pore fluid that diffuses in the cells of a fault:

      C dp/dt = - outflow of (k w/eta) grad p through sides + wells + source - leak p,

   p: in excess of the hydrostatic pressure, C = porosity compressibility w A, w: aperture, A: area. The operator is
   SlipDiffusion (src/fluid), the permeability a law of core/permeability.c.

   A step of the diffusion is an implicit Runge-Kutta step of two stages and order 2 (SDIRK, Alexander 1977) with the
   permeability at the end of each stage: where steps are long, the pressure around a well follows the permeability at
   once, and with that of the middle of a step it would be of order 1. Its third derivative gives the error, and that
   the next step. Pressure within a step is the parabola through its ends and the first stage; volumes follow by the
   same weights, so that mass is exact at any time. Steps begin at the history (fluidhistory.c), and end where wells
   change. */
#include <slipstep/private/slipfault.h>
#include <slipstep/private/slipfaultfluid.h>
#include <slipstep/private/slipfaultwells.h>
#include <slipstep/private/slipwork.h>
#include <math.h>

#define ERROR_CONSTANT 0.0404401145198802970 /* |1/6 - 3 SLIP_FLUID_GAMMA^2 + 2 SLIP_FLUID_GAMMA^3|, of h^3 d3p/dt3 */
#define SAFETY 0.8
#define GROWTH 5
#define LEAST_SHARE 0.05
#define MOST_REJECTIONS 100
#define SMALL_PRESSURE 1e-4 /* of the normal stress: errors below the tolerance of it do not matter */
/* Of the error that the tolerance allows the solver leaves this share: less than the estimate of the error, from third
   differences, would feel */
#define SOLVER_SHARE 1e-6

/* ---- set-up ---- */

static PetscErrorCode CreateNode(PetscInt n, SlipFluidNode *node)
{
  PetscFunctionBegin;
  PetscCall(PetscCalloc4(n + 1, &node->pressure, n + 1, &node->rate, n + 1, &node->state, n + 1, &node->onset));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void CopyNode(PetscInt n, const SlipFluidNode *from, SlipFluidNode *to)
{
  for (PetscInt i = 0; i < n; i++) {
    to->pressure[i] = from->pressure[i];
    to->rate[i] = from->rate[i];
    to->state[i] = from->state[i];
    to->onset[i] = from->onset[i];
  }
  for (int k = 0; k < FLUID_NUM_VOLUMES; k++) to->volume[k] = from->volume[k];
  to->time = from->time;
  to->next = from->next;
  to->fresh = from->fresh;
}

/* Sets the coefficients of the cells, those of the operator at the start, and what follows of them. */
static PetscErrorCode SetUpCells(SlipFault fault)
{
  SlipFaultFluid *f = &fault->fluid;
  const SlipFaultMesh *mesh = &fault->mesh;
  const PetscReal *const *cell = (const PetscReal *const *)fault->fields.cell;
  PetscReal least = PETSC_MAX_REAL;
  PetscBool open;

  PetscFunctionBegin;
  PetscCall(PetscStrcmp(fault->options.text[FAULT_FLUID_BORDER], "open", &open));
  for (PetscInt i = 0; i < mesh->n; i++) {
    const PetscReal area = mesh->weight[i] * mesh->area, w = cell[FIELD_APERTURE][i];

    f->storage[i] = cell[FIELD_POROSITY][i] * cell[FIELD_PORE_COMPRESSIBILITY][i] * w * area;
    f->unit[i] = w / fault->options.value[FAULT_FLUID_VISCOSITY];
    f->leak[i] = cell[FIELD_LEAKOFF][i] * area;
    f->source[i] = cell[FIELD_FLUID_SOURCE][i] * area;
    f->work[FLUID_WORK_ALONG][i] = cell[FIELD_PERMEABILITY][i] * f->unit[i];
    f->work[FLUID_WORK_DOWN][i] = f->work[FLUID_WORK_ALONG][i] * cell[FIELD_PERMEABILITY_RATIO][i];
    f->border[i] = cell[FIELD_BORDER_PRESSURE][i];
    if (open && PetscIsNanReal(f->border[i])) f->border[i] = 0;
    least = PetscMin(least, f->storage[i] / (4 * PetscMax(f->work[FLUID_WORK_ALONG][i], f->work[FLUID_WORK_DOWN][i])));
  }
  PetscCallMPI(MPI_Allreduce(&least, &f->first, 1, MPIU_REAL, MPIU_MIN, fault->comm));
  PetscCall(SlipDiffusionSet(f->diffusion, &(SlipDiffusionCells){.storage = f->storage,
                                                                 .along = f->work[FLUID_WORK_ALONG],
                                                                 .down = f->work[FLUID_WORK_DOWN],
                                                                 .border = f->border}));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the indices of wells: the rate is (k w/eta) index (p_well - p) (Peaceman 1978). */
static PetscErrorCode SetUpWells(SlipFault fault)
{
  SlipFaultFluid *f = &fault->fluid;
  PetscReal *radius = f->work[FLUID_WORK_RAISED];

  PetscFunctionBegin;
  PetscCall(SlipDiffusionRadius(f->diffusion, radius));
  PetscCall(PetscMalloc1(fault->loads.nwells + 1, &f->index));
  for (PetscInt k = 0; k < fault->loads.nwells; k++) {
    const SlipFaultWell *well = &fault->loads.wells[k];
    PetscReal index = 0;

    if (well->spread == 0 && well->ncells) {
      const PetscInt i = well->cell[0];

      index = 2 * PETSC_PI * PetscSqrtReal(fault->fields.cell[FIELD_PERMEABILITY_RATIO][i]) /
              PetscLogReal(radius[i] / well->radius);
    }
    PetscCall(SlipAllreduceLargest(fault->comm, 1, &index));
    PetscCheck(well->spread > 0 || (index > 0 && isfinite(index)), fault->comm, PETSC_ERR_ARG_OUTOFRANGE,
               "%s (-%sfault_wells): the well %s has the radius %g m, which is larger than a fifth of its cell: "
               "expected a smaller radius, or larger cells",
               fault->options.text[FAULT_WELLS], SlipFaultPrefix(fault), well->name, (double)well->radius);
    f->index[k] = index;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultFluidSetUp(SlipFault fault)
{
  SlipFaultFluid *f = &fault->fluid;
  const PetscInt n = fault->mesh.n;
  PetscInt row = PETSC_MAX_INT, dilates = 0, leaks = 0;
  SlipFluidDrive *drive;

  PetscFunctionBegin;
  f->on = fault->kind.flows;
  if (!f->on) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt i = 0; i < n; i++)
    if (fault->fields.cell[FIELD_PERMEABILITY][i] == 0) row = PetscMin(row, SlipFaultMeshRow(&fault->mesh, i));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &row, 1, MPIU_INT, MPI_MIN, fault->comm));
  PetscCheck(row == PETSC_MAX_INT, fault->comm, PETSC_ERR_ARG_OUTOFRANGE,
             "permeability is 0 in cell %" PetscInt_FMT ", expected more than 0 m^2 in all cells, or 0 in all", row);
  f->law = SlipPermeabilityFind(fault->options.text[FAULT_PERMEABILITY_LAW]);
  f->stressed = f->law->value ? PETSC_TRUE : PETSC_FALSE;
  for (PetscInt i = 0; i < n; i++) dilates |= fault->fields.cell[FIELD_DILATANCY][i] != 0;
  PetscCallMPI(MPI_Allreduce(&dilates, &f->dilates, 1, MPIU_INT, MPI_MAX, fault->comm));
  for (PetscInt i = 0; i < n; i++) leaks |= fault->fields.cell[FIELD_CARTER_LEAKOFF][i] != 0;
  PetscCallMPI(MPI_Allreduce(&leaks, &f->leaks, 1, MPIU_INT, MPI_MAX, fault->comm));
  f->follows = f->law->evolve || (f->stressed && fault->kind.coupled) || f->dilates ? PETSC_TRUE : PETSC_FALSE;
  PetscCall(SlipDiffusionCreate(&fault->mesh, SlipFaultPrefix(fault), &f->diffusion));
  if (f->follows) PetscCall(SlipDiffusionMost(f->diffusion, &f->most));
  f->block = FLUID_DISPLACEMENT + fault->layout.components + f->most;
  for (int k = 0; k < 3; k++) PetscCall(PetscCalloc1(f->most * n + 1, &f->sides[k]));
  for (int k = 0; k < FLUID_NUM_WORK; k++) PetscCall(PetscCalloc1(n + 1, &f->work[k]));
  PetscCall(PetscCalloc5(n + 1, &f->storage, n + 1, &f->unit, n + 1, &f->leak, n + 1, &f->source, n + 1, &f->border));
  for (int k = 0; k < 2; k++) {
    PetscCall(VecCreate(fault->comm, &f->past[k].cells));
    PetscCall(VecSetSizes(f->past[k].cells, f->block * n, PETSC_DETERMINE));
    PetscCall(VecSetType(f->past[k].cells, VECSTANDARD));
    PetscCall(CreateNode(n, &f->path[k].before));
    PetscCall(CreateNode(n, &f->path[k].from));
    PetscCall(CreateNode(n, &f->path[k].to));
    PetscCall(PetscCalloc1(n + 1, &f->path[k].middle));
    PetscCall(PetscCalloc1(n + 1, &f->path[k].middle_before)); /* they change places */
    drive = &f->path[k].drive;
    PetscCall(PetscCalloc6(n + 1, &drive->speed, n + 1, &drive->curve, n + 1, &drive->extra, n + 1, &drive->extra_rate,
                           n + 1, &drive->dilation, n + 1, &drive->swelling));
  }
  PetscCall(PetscCalloc1(fault->layout.components * n + 1, &f->reached));
  PetscCall(SetUpCells(fault));
  PetscCall(SetUpWells(fault));
  PetscCall(SlipFaultFluidStart(fault, 0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultFluidDestroy(SlipFault fault)
{
  SlipFaultFluid *f = &fault->fluid;

  PetscFunctionBegin;
  if (!f->on) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipDiffusionDestroy(&f->diffusion));
  PetscCall(SlipDiffusionDestroy(&f->shown));
  for (int k = 0; k < FLUID_NUM_WORK; k++) PetscCall(PetscFree(f->work[k]));
  PetscCall(PetscFree5(f->storage, f->unit, f->leak, f->source, f->border));
  PetscCall(PetscFree(f->index));
  PetscCall(PetscFree(f->reached));
  for (int k = 0; k < 3; k++) PetscCall(PetscFree(f->sides[k]));
  for (int k = 0; k < 2; k++) {
    SlipFluidNode *const node[] = {&f->path[k].before, &f->path[k].from, &f->path[k].to};
    SlipFluidDrive *drive = &f->path[k].drive;

    PetscCall(VecDestroy(&f->past[k].cells));
    for (int j = 0; j < 3; j++) PetscCall(PetscFree4(node[j]->pressure, node[j]->rate, node[j]->state, node[j]->onset));
    PetscCall(PetscFree(f->path[k].middle));
    PetscCall(PetscFree(f->path[k].middle_before));
    PetscCall(
      PetscFree6(drive->speed, drive->curve, drive->extra, drive->extra_rate, drive->dilation, drive->swelling));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The volume by which the pores of cell i grow as psi = ln(V0 theta/d_c) rises by 1 [m^3] (Segall and Rice 1995) */
PetscReal SlipFaultFluidPores(SlipFault fault, PetscInt i)
{
  return fault->fluid.dilates ? -fault->fields.cell[FIELD_DILATANCY][i] * fault->fields.cell[FIELD_APERTURE][i] *
                                  fault->mesh.weight[i] * fault->mesh.area
                              : 0;
}

/* ---- one step of the diffusion ---- */

/* Sets inflow [m^3/s] and what leaves per pressure from t on, at the conductances along. */
static void Inflow(SlipFault fault, PetscReal t, const PetscReal along[], PetscReal sink[], PetscReal inflow[])
{
  const SlipFaultFluid *f = &fault->fluid;

  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    sink[i] = f->work[FLUID_WORK_LEAK][i];
    inflow[i] = f->source[i];
  }
  for (PetscInt k = 0; k < fault->loads.nwells; k++) {
    const SlipFaultWell *well = &fault->loads.wells[k];
    const PetscReal value = SlipFaultWellValue(well, t);

    for (PetscInt j = 0; j < well->ncells; j++) {
      const PetscInt i = well->cell[j];
      const PetscReal index = f->index[k] * along[i];

      if (!well->pressure)
        inflow[i] += well->share[j] * value;
      else if (SlipFaultWellHolds(well, t)) {
        sink[i] += index;
        inflow[i] += index * value;
      }
    }
  }
}

/* The rates at which volumes change at the pressures y of the last solve [m^3/s] */
static PetscErrorCode VolumeRates(SlipFault fault, const PetscReal y[], PetscReal rate[])
{
  const SlipFaultFluid *f = &fault->fluid;
  PetscReal border;

  PetscFunctionBegin;
  rate[FLUID_INJECTED] = rate[FLUID_LEAKED] = 0;
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    const PetscReal leak = f->work[FLUID_WORK_LEAK][i];

    rate[FLUID_INJECTED] += f->work[FLUID_WORK_INFLOW][i] - (f->work[FLUID_WORK_SINK][i] - leak) * y[i];
    rate[FLUID_LEAKED] += leak * y[i];
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, rate, 2, MPIU_REAL, MPIU_SUM, fault->comm));
  PetscCall(SlipDiffusionFlow(f->diffusion, &border, NULL));
  rate[FLUID_BORDER] = border;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the coefficients of the operator for steps from t on; work[FLUID_WORK_ALONG] has the permeability. Collective.
 */
PetscErrorCode SlipFluidSetOperator(SlipFault fault, PetscReal t)
{
  SlipFaultFluid *f = &fault->fluid;
  PetscReal *along = f->work[FLUID_WORK_ALONG], *down = f->work[FLUID_WORK_DOWN];

  PetscFunctionBegin;
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    along[i] *= f->unit[i];
    down[i] = along[i] * fault->fields.cell[FIELD_PERMEABILITY_RATIO][i];
  }
  Inflow(fault, t, along, f->work[FLUID_WORK_SINK], f->work[FLUID_WORK_INFLOW]);
  PetscCall(SlipDiffusionSet(
    f->diffusion,
    &(SlipDiffusionCells){
      .storage = f->storage, .along = along, .down = down, .sink = f->work[FLUID_WORK_SINK], .border = f->border}));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets y1 and y2 to the pressures that are expected at the first stage and the end of a step of length h: for a
   corrected path those of the step that it corrects, which is known then. */
static PetscBool Expect(SlipFault fault, const SlipFluidPath *path, PetscReal h, PetscReal y1[], PetscReal y2[])
{
  const SlipFluidPath *first = &fault->fluid.path[0];
  const SlipFluidNode *from = &path->from;
  const PetscBool known =
    path != first && first->stepped && first->from.time == from->time && first->to.time == from->time + h ? PETSC_TRUE
                                                                                                          : PETSC_FALSE;

  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    const PetscReal p = from->pressure[i], rate = from->fresh ? 0 : from->rate[i];

    y1[i] = p + (known ? first->middle[i] - first->from.pressure[i] : SLIP_FLUID_GAMMA * h * rate);
    y2[i] = p + (known ? first->to.pressure[i] - first->from.pressure[i] : h * rate);
  }
  return known;
}

/* Gives the solver of stage k, 0 or 1, the pressures of sides that are known: of the same step (known), of the history,
   of the stage before. */
static PetscErrorCode Begin(SlipFault fault, const SlipFluidPath *path, int k, PetscBool known)
{
  SlipFaultFluid *f = &fault->fluid;
  const PetscReal *past;

  PetscFunctionBegin;
  if (!f->most) PetscFunctionReturn(PETSC_SUCCESS);
  if (known)
    PetscCall(SlipDiffusionBegin(f->diffusion, f->most, f->sides[k], NULL));
  else if (k)
    PetscCall(SlipDiffusionBegin(f->diffusion, 0, NULL, path->middle));
  else if (path->from.time == path->start && !path->from.fresh) {
    PetscCall(VecGetArrayRead(f->past[path->slot].cells, &past));
    PetscCall(SlipDiffusionBegin(f->diffusion, f->block, past + f->block - f->most, path->from.pressure));
    PetscCall(VecRestoreArrayRead(f->past[path->slot].cells, &past));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Solves for stage k, 0 or 1, of a step that ends at `end`; y: what is expected there, and then its pressures. already
   [n]: by how much the stages before have raised the pressure. Sets the rates of volumes [m^3/s]. */
static PetscErrorCode Stage(SlipFault fault, const SlipFluidPath *path, int k, PetscReal own, PetscReal end,
                            const PetscReal state[], const PetscReal already[], PetscReal y[], PetscReal rate[])
{
  SlipFaultFluid *f = &fault->fluid;
  PetscReal *along = f->work[FLUID_WORK_ALONG], *b = f->work[FLUID_WORK_RIGHT], pores = 0;

  PetscFunctionBegin;
  PetscCall(SlipFluidPermeability(fault, path, end, state, y, along));
  PetscCall(SlipFluidSetOperator(fault, path->from.time));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    const PetscReal growth = path->drive.dilation[i] + 2 * path->drive.swelling[i] * (end - path->start);

    pores += growth;
    b[i] = f->storage[i] * (path->from.pressure[i] + (already ? already[i] : 0)) +
           own * (f->work[FLUID_WORK_INFLOW][i] - growth);
  }
  PetscCall(SlipDiffusionSolve(f->diffusion, own, b, y));
  if (f->most && path == &f->path[0]) PetscCall(SlipDiffusionKeep(f->diffusion, f->most, f->sides[k]));
  PetscCall(VolumeRates(fault, y, rate));
  if (f->dilates) PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &pores, 1, MPIU_REAL, MPIU_SUM, fault->comm));
  rate[FLUID_PORES] = pores;
  f->solves++;
  SlipWorkAdd(SLIP_WORK_DIFFUSION, (PetscReal)fault->mesh.n);
  if (f->law->evolve || f->law->value) SlipWorkAdd(SLIP_WORK_ASSEMBLY, (PetscReal)fault->mesh.n);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes path->to and what is between from its start, h later, and the error over what the tolerance allows. */
static PetscErrorCode Step(SlipFault fault, SlipFluidPath *path, PetscReal h, PetscReal *E)
{
  SlipFaultFluid *f = &fault->fluid;
  const SlipFluidNode *from = &path->from;
  SlipFluidNode *to = &path->to;
  const PetscInt n = fault->mesh.n;
  const PetscReal own = SLIP_FLUID_GAMMA * h, other = (1 - SLIP_FLUID_GAMMA) * h;
  PetscReal *p = from->pressure, *y1 = path->middle, *y2 = to->pressure, *already = f->work[FLUID_WORK_RAISED];
  PetscReal rate[2][FLUID_NUM_VOLUMES], largest[2] = {0, 0}, size = 0;
  PetscBool known, reached = PETSC_FALSE;

  PetscFunctionBegin;
  SlipFluidEvolve(fault, path, own, other, f->work[FLUID_WORK_STATE]);
  known = Expect(fault, path, h, y1, y2);
  PetscCall(PetscArraycpy(to->onset, known ? f->path[0].to.onset : from->onset, n));
  for (PetscInt i = 0; i < n; i++)
    size = SlipLarger(size, PetscMax(PetscAbsReal(p[i]), SMALL_PRESSURE * fault->fields.cell[FIELD_NORMAL_STRESS][i]));
  PetscCall(SlipAllreduceLargest(fault->comm, 1, &size));
  size *= SOLVER_SHARE * fault->options.value[FAULT_FLUID_TOLERANCE];
  if (!f->follows || (path == &f->path[0] && from->time == path->start)) PetscCall(SlipDiffusionRenew(f->diffusion));
  for (int pass = 0; pass < (reached || (f->stressed && !known) ? 2 : 1); pass++) {
    PetscCall(Begin(fault, path, 0, known || pass > 0 ? PETSC_TRUE : PETSC_FALSE));
    /* the error of the first stage counts (1 - gamma)/gamma times in the second one */
    PetscCall(SlipDiffusionAccuracy(f->diffusion, known ? PetscMax(size, f->allowed / 10) : size));
    SlipFluidLeak(fault, from->time, h, 0, to->onset);
    PetscCall(Stage(fault, path, 0, own, from->time + own, f->work[FLUID_WORK_STATE], NULL, y1, rate[0]));
    for (PetscInt i = 0; i < n; i++) {
      already[i] = other / own * (y1[i] - p[i]);
      if (!known && pass == 0) y2[i] = y1[i] + already[i];
    }
    PetscCall(Begin(fault, path, 1, known || pass > 0 ? PETSC_TRUE : PETSC_FALSE));
    PetscCall(SlipDiffusionAccuracy(f->diffusion, known ? PetscMax(size, f->allowed) : size));
    SlipFluidLeak(fault, from->time, h, 1, to->onset);
    PetscCall(Stage(fault, path, 1, own, from->time + h, to->state, already, y2, rate[1]));
    if (pass == 0) PetscCall(SlipFluidReached(fault, from, h, to, &reached));
  }
  for (PetscInt i = 0; i < n; i++) {
    const PetscReal first = (y1[i] - p[i]) / own, last = (y2[i] - p[i] - other * first) / own;
    const PetscReal bend = (last - first) / (1 - SLIP_FLUID_GAMMA) - (first - from->rate[i]) / SLIP_FLUID_GAMMA;

    to->rate[i] = last;
    largest[0] = SlipLarger(
      largest[0], PetscAbsReal(from->fresh ? own * (last - first) : 2 * (PetscReal)ERROR_CONSTANT * h * bend));
    largest[1] = SlipLarger(largest[1],
                            PetscMax(PetscAbsReal(y2[i]), SMALL_PRESSURE * fault->fields.cell[FIELD_NORMAL_STRESS][i]));
  }
  PetscCall(SlipAllreduceLargest(fault->comm, 2, largest));
  *E = largest[0] > 0 ? largest[0] / (fault->options.value[FAULT_FLUID_TOLERANCE] * largest[1]) : 0;
  for (int k = 0; k < FLUID_NUM_VOLUMES; k++) {
    path->between[k] = from->volume[k] + own * rate[0][k];
    to->volume[k] = from->volume[k] + other * rate[0][k] + own * rate[1][k];
  }
  f->steps++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the way to a time ---- */

/* Lengths of steps that nothing else bounds are those of a geometric sequence, so that factorisations serve again. */
static PetscReal Rounded(const SlipFaultFluid *f, PetscReal h)
{
  if (f->follows || !(h > f->first)) return h;
  return f->first * PetscPowReal(2, PetscFloorReal(2 * PetscLogReal(h / f->first) / PetscLogReal(2)) / 2);
}

/* Makes one step from path->from. until: it ends there at the latest. */
static PetscErrorCode StepOnce(SlipFault fault, SlipFluidPath *path, PetscReal until)
{
  SlipFaultFluid *f = &fault->fluid;
  const PetscReal change = (*fault->fluid.change)(&fault->loads, path->from.time), end = PetscMin(until, change);
  const PetscReal room = end - path->from.time, wanted = path->from.next;
  PetscReal h = wanted > room * (1 - 1e-9) ? room : wanted > room / 2 ? room / 2 : wanted, E;
  PetscBool lands = h == room ? PETSC_TRUE : PETSC_FALSE, cut = h < wanted ? PETSC_TRUE : PETSC_FALSE;

  PetscFunctionBegin;
  for (PetscInt k = 0;; k++) {
    PetscCall(Step(fault, path, h, &E));
    if (E <= 1) break;
    PetscCheck(k < MOST_REJECTIONS && path->from.time + h > path->from.time && E == E, fault->comm,
               PETSC_ERR_NOT_CONVERGED,
               "the diffusion of -%sfault_permeability at %.9g s finds no step short enough for "
               "-%sfault_fluid_tolerance %g, down to %g s",
               SlipFaultPrefix(fault), (double)path->from.time, SlipFaultPrefix(fault),
               (double)fault->options.value[FAULT_FLUID_TOLERANCE], (double)h);
    h *= PetscMax(SAFETY * PetscPowReal(E, (PetscReal)-1 / (path->from.fresh ? 2 : 3)), LEAST_SHARE);
    h = Rounded(f, h);
    lands = cut = PETSC_FALSE;
  }
  path->to.time = lands ? end : path->from.time + h;
  path->to.fresh = lands && end == change ? PETSC_TRUE : PETSC_FALSE;
  path->to.next = Rounded(f, h * PetscMin(E > 0 ? SAFETY * PetscPowReal(E, (PetscReal)-1 / 3) : GROWTH, GROWTH));
  if (cut) path->to.next = PetscMax(path->to.next, wanted);
  if (path->to.fresh) path->to.next = f->first;
  path->stepped = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Extends the path so that its last step contains t; ends: so that it ends there. Collective. */
PetscErrorCode SlipFluidWalk(SlipFault fault, SlipFluidPath *path, PetscReal t, PetscBool ends)
{
  PetscFunctionBegin;
  while (path->stepped ? t > path->to.time : t > path->from.time) {
    if (path->stepped) {
      const SlipFluidNode node = path->before;
      PetscReal *const middle = path->middle_before;

      path->before = path->from;
      path->from = node;
      path->middle_before = path->middle;
      path->middle = middle;
      PetscCall(PetscArraycpy(path->between_before, path->between, FLUID_NUM_VOLUMES));
      CopyNode(fault->mesh.n, &path->to, &path->from);
      path->kept = PETSC_TRUE;
    }
    path->stepped = PETSC_FALSE;
    /* what slip drives is wanted at the end of an attempt, and both paths must have the same steps */
    PetscCall(StepOnce(fault, path, ends || fault->fluid.follows ? t : PETSC_MAX_REAL));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Begins a path from the history in a slot. */
PetscErrorCode SlipFluidBegin(SlipFault fault, SlipFluidPath *path, PetscInt slot)
{
  SlipFaultFluid *f = &fault->fluid;
  const SlipFluidDrive *drive = &path->drive;
  SlipFluidNode *from = &path->from;
  const PetscReal *a;

  PetscFunctionBegin;
  from->time = path->start = f->past[slot].time;
  from->next = f->past[slot].next;
  from->fresh = f->past[slot].fresh;
  PetscCall(PetscArraycpy(from->volume, f->past[slot].volume, FLUID_NUM_VOLUMES));
  PetscCall(VecGetArrayRead(f->past[slot].cells, &a));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    const PetscReal *b = a + f->block * i;

    from->pressure[i] = b[FLUID_PRESSURE];
    from->rate[i] = b[FLUID_RATE];
    from->state[i] = b[FLUID_STATE];
    from->onset[i] = b[FLUID_ONSET];
    drive->speed[i] = b[FLUID_SPEED];
    drive->extra[i] = b[FLUID_EXTRA];
    drive->extra_rate[i] = b[FLUID_EXTRA_RATE];
    drive->dilation[i] = SlipFaultFluidPores(fault, i) * b[FLUID_PSI_RATE];
    drive->curve[i] = b[FLUID_CURVE];
    drive->swelling[i] = 0;
  }
  PetscCall(VecRestoreArrayRead(f->past[slot].cells, &a));
  path->slot = slot;
  path->begun = PETSC_TRUE;
  path->stepped = path->kept = PETSC_FALSE;
  path->target = from->time;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Extends the path of the history to t, and gets the place of t in it. Collective. */
PetscErrorCode SlipFluidReach(SlipFault fault, PetscReal t, SlipFluidPlace *place)
{
  SlipFaultFluid *f = &fault->fluid;
  SlipFluidPath *path = &f->path[0];
  const PetscInt slot = f->trial && t < f->past[1].time ? 0 : 1;
  PetscReal s;

  PetscFunctionBegin;
  if (!path->begun || path->slot != slot || t < (path->kept ? path->before.time : path->from.time) ||
      (f->follows && path->stepped && t > path->to.time)) /* the steps to t must not depend on what was asked before */
    PetscCall(SlipFluidBegin(fault, path, slot));
  if (!path->stepped && t > path->from.time) path->target = t;
  PetscCall(SlipFluidWalk(fault, path, t, PETSC_FALSE));
  if (t < path->from.time && path->kept)
    *place = (SlipFluidPlace){&path->before, &path->from, path->middle_before, path->between_before, {1, 0, 0}, 0};
  else
    *place = (SlipFluidPlace){&path->from, path->stepped ? &path->to : NULL, path->middle, path->between, {1, 0, 0}, 0};
  if (!place->to || t <= place->from->time) PetscFunctionReturn(PETSC_SUCCESS);
  place->share = s = PetscMin((t - place->from->time) / (place->to->time - place->from->time), 1);
  place->weight[0] = (s - SLIP_FLUID_GAMMA) * (s - 1) / SLIP_FLUID_GAMMA;
  place->weight[1] = s * (s - 1) / (SLIP_FLUID_GAMMA * (SLIP_FLUID_GAMMA - 1));
  place->weight[2] = s * (s - SLIP_FLUID_GAMMA) / (1 - SLIP_FLUID_GAMMA);
  if (s < 1) PetscFunctionReturn(PETSC_SUCCESS);
  place->weight[0] = place->weight[1] = 0;
  place->weight[2] = 1;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Forgets what was computed from the history, because it has changed. */
void SlipFluidForget(SlipFault fault)
{
  fault->fluid.path[0].begun = PETSC_FALSE;
  fault->known.load.time = (PetscReal)NAN;
  fault->coupling.moment = (SlipFaultMoment){0};
  fault->balance.put++;
}

/* Writes the fluid at a node to slot 1, without what drives it. */
PetscErrorCode SlipFluidPutNode(SlipFault fault, const SlipFluidNode *node)
{
  SlipFaultFluid *f = &fault->fluid;
  PetscReal *a;

  PetscFunctionBegin;
  PetscCall(VecGetArray(f->past[1].cells, &a));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    PetscReal *b = a + f->block * i;

    b[FLUID_PRESSURE] = node->pressure[i];
    b[FLUID_RATE] = node->rate[i];
    b[FLUID_STATE] = node->state[i];
    b[FLUID_ONSET] = node->onset[i];
  }
  PetscCall(VecRestoreArray(f->past[1].cells, &a));
  f->past[1].time = node->time;
  f->past[1].next = node->next;
  f->past[1].fresh = node->fresh;
  PetscCall(PetscArraycpy(f->past[1].volume, node->volume, FLUID_NUM_VOLUMES));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the history to the start of a run at t. */
PetscErrorCode SlipFaultFluidStart(SlipFault fault, PetscReal t)
{
  SlipFaultFluid *f = &fault->fluid;
  SlipFluidNode *node = &f->path[1].from;

  PetscFunctionBegin;
  PetscCall(PetscArraycpy(node->pressure, fault->fields.cell[FIELD_FLUID_PRESSURE], fault->mesh.n));
  PetscCall(PetscArraycpy(node->state, fault->fields.cell[FIELD_PERMEABILITY], fault->mesh.n));
  PetscCall(PetscArrayzero(node->rate, fault->mesh.n));
  for (PetscInt i = 0; i < fault->mesh.n; i++) node->onset[i] = PETSC_MAX_REAL;
  PetscCall(PetscArrayzero(node->volume, FLUID_NUM_VOLUMES));
  node->time = t;
  node->next = f->first;
  node->fresh = PETSC_TRUE;
  PetscCall(VecZeroEntries(f->past[1].cells));
  PetscCall(SlipFluidPutNode(fault, node));
  f->trial = f->computed = PETSC_FALSE;
  SlipFluidForget(fault);
  PetscFunctionReturn(PETSC_SUCCESS);
}
