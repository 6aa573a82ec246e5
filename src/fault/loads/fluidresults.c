/* What is said of the pore fluid of fluid.c: its set-up, cells that lack a common side, and results of the run. */
#include <slipstep/private/slipfault.h>
#include <slipstep/private/slipfaultfluid.h>
#include <slipstep/private/slipsys.h>

/* Warns of cells between which no fluid flows although they meet. */
PetscErrorCode SlipFaultFluidWarn(SlipFault fault)
{
  PetscInt bodies, apart, faults[2];
  PetscMPIInt rank;

  PetscFunctionBegin;
  if (!fault->fluid.on) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipDiffusionBodies(fault->fluid.diffusion, &bodies, &apart, faults));
  PetscCallMPI(MPI_Comm_rank(fault->comm, &rank));
  if (!apart || rank || !fault->options.reports) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipWarning("no fluid flows between %" PetscInt_FMT " cells that touch or cross cells of another fault, or "
                        "of another part of theirs, without a side in common, as of the faults %" PetscInt_FMT
                        " and %" PetscInt_FMT ": expected a mesh whose cells have their sides where faults meet",
                        apart, fault->mesh.labels[faults[0]], fault->mesh.labels[faults[1]]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultFluidView(SlipFault fault, PetscViewer viewer)
{
  SlipFaultFluid *f = &fault->fluid;

  PetscFunctionBegin;
  if (!f->on) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(
    PetscViewerASCIIPrintf(viewer,
                           "pore fluid: permeability law %s, %s; first step of the diffusion %.4g s, %" PetscInt_FMT
                           " wells; %" PetscInt_FMT " steps and %" PetscInt_FMT " solves so far\n",
                           f->law->name, f->follows ? "which slip changes" : "which slip does not change",
                           (double)f->first, fault->loads.nwells, f->steps, f->solves));
  PetscCall(SlipDiffusionView(f->diffusion, viewer));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Largest pressure so far [Pa] */
static PetscErrorCode FluidCreate(SlipFault fault, TS ts, PetscBool *wanted, void **ctx)
{
  PetscReal *highest;

  PetscFunctionBegin;
  (void)ts;
  *wanted = fault->fluid.on;
  if (!*wanted) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscNew(&highest));
  *highest = -PETSC_MAX_REAL;
  *ctx = highest;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FluidStep(SlipFault fault, TS ts, PetscInt step, PetscReal time, Vec w, void *ctx)
{
  PetscReal *highest = (PetscReal *)ctx, *p = fault->fluid.work[FLUID_WORK_OWN];

  PetscFunctionBegin;
  (void)ts, (void)step, (void)w;
  PetscCall(SlipFluidPressureAt(fault, time, p));
  for (PetscInt i = 0; i < fault->mesh.n; i++) *highest = PetscMax(*highest, p[i]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Warns of wells that change after the run. */
static PetscErrorCode FluidStart(SlipFault fault, TS ts, PetscReal time, Vec w, void *ctx)
{
  PetscReal last = 0, end;
  PetscMPIInt rank;

  PetscFunctionBegin;
  PetscCall(FluidStep(fault, ts, 0, time, w, ctx));
  for (PetscInt k = 0; k < fault->loads.nwells; k++)
    last = PetscMax(last, fault->loads.wells[k].time[fault->loads.wells[k].rows - 1]);
  PetscCall(TSGetMaxTime(ts, &end));
  PetscCallMPI(MPI_Comm_rank(fault->comm, &rank));
  if (last > end && !rank && fault->options.reports)
    PetscCall(SlipWarning("the run ends at %.6g s (-ts_max_time), before the last change of -fault_wells, at %.6g s",
                          (double)end, (double)last));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FluidVisit(SlipFault fault, SlipState state, void *ctx)
{
  PetscBool has;

  PetscFunctionBegin;
  PetscCall(SlipStateHas(state, "fluid_results", &has));
  if (!has) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipStateGroup(state, "fluid_results"));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, ctx, 1, MPIU_REAL, MPIU_MAX, fault->comm));
  PetscCall(SlipStateReal(state, "largest_pressure", 1, (PetscReal *)ctx));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FluidFinish(SlipFault fault, TS ts, SlipOutput output, void *ctx)
{
  PetscReal volume[FLUID_NUM_VOLUMES], stored, t;

  PetscFunctionBegin;
  PetscCall(TSGetTime(ts, &t));
  PetscCall(SlipFaultFluidVolumes(fault, t, volume, &stored));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, ctx, 1, MPIU_REAL, MPIU_MAX, fault->comm));
  PetscCall(SlipOutputAddResult(output, "injected_volume", "injected fluid", "m^3", volume[FLUID_INJECTED]));
  PetscCall(SlipOutputAddResult(output, "stored_volume", "stored", "m^3", stored));
  PetscCall(SlipOutputAddResult(output, "leaked_volume", "lost into the rock", "m^3", volume[FLUID_LEAKED]));
  PetscCall(SlipOutputAddResult(output, "border_volume", "left through the border", "m^3", volume[FLUID_BORDER]));
  PetscCall(SlipOutputAddResult(output, "largest_pressure", "largest fluid pressure", "Pa, in excess of hydrostatic",
                                *(PetscReal *)ctx));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FluidEnd(void **ctx)
{
  PetscFunctionBegin;
  PetscCall(PetscFree(*ctx));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const SlipFaultObserver SlipFaultFluidObserver = {.name = "fluid",
                                                  .create = FluidCreate,
                                                  .start = FluidStart,
                                                  .step = FluidStep,
                                                  .visit = FluidVisit,
                                                  .finish = FluidFinish,
                                                  .destroy = FluidEnd};
