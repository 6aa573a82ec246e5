/* The columns of /series of a run of a fault: means and sums over its cells, moments of each fault, and volumes and
   wells of pore fluid. */
#include <slipstep/private/sliprunfiles.h>
#include <string.h>

static const SlipOutputColumn SeriesColumns[] = {
  {"mean_slip_rate", "m/s", PETSC_FALSE},   {"max_slip_rate", "m/s", PETSC_FALSE},
  {"mean_slip", "m", PETSC_FALSE},          {"mean_displacement", "m", PETSC_FALSE},
  {"sliding_fraction", "1", PETSC_FALSE},   {"kinetic_energy", "J/m^2", PETSC_FALSE},
  {"elastic_energy", "J/m^2", PETSC_FALSE}, {"viscous_power", "W/m^2", PETSC_FALSE},
  {"friction_power", "W/m^2", PETSC_FALSE}, {"loading_power", "W/m^2", PETSC_FALSE},
  {"moment_rate", "N m/s", PETSC_FALSE},    {"moment", "N m", PETSC_FALSE},
};
enum {
  SERIES_MOMENT = PETSC_STATIC_ARRAY_LENGTH(SeriesColumns) - 1, /* the last two have a number for each fault */
  SERIES_MOMENT_RATE = SERIES_MOMENT - 1
};

/* Of a fault in which pore fluid diffuses: volumes since the start, of which the first is the sum of the others; and,
   where it has wells, a number for each of them */
static const SlipOutputColumn FluidColumns[] = {
  {"injected_volume", "m^3", PETSC_FALSE}, {"stored_volume", "m^3", PETSC_FALSE}, {"leaked_volume", "m^3", PETSC_FALSE},
  {"border_volume", "m^3", PETSC_FALSE},   {"well_pressure", "Pa", PETSC_FALSE},  {"well_rate", "m^3/s", PETSC_FALSE}};
enum { SERIES_VOLUMES = 4, SERIES_FLUID = PETSC_STATIC_ARRAY_LENGTH(FluidColumns) };

/* Computes for each fault G times the sums over area of slip rate along the rake [N m/s] and of slip since the start [N
   m], which the integrator computes from the rates within steps. One fault has its sums already; several cost a
   reduction. */
static PetscErrorCode Moments(SlipFault fault, PetscReal t, Vec w, PetscReal rate[], PetscReal moment[])
{
  const PetscInt n = fault->mesh.faults;
  const PetscReal unit = fault->options.value[FAULT_SHEAR_MODULUS] * fault->mesh.area,
                  start = fault->critical.start_share;
  const SlipFaultSums *sums;

  PetscFunctionBegin;
  if (n == 1) {
    PetscCall(SlipFaultGetSums(fault, t, w, &sums));
    t += fault->loads.origin;
    rate[0] = sums->sum[SUM_V];
    moment[0] = sums->sum[SUM_U] + t * sums->sum[SUM_VINF] - start * fault->critical.mean_uc * (PetscReal)fault->mesh.N;
  } else {
    PetscCall((*fault->cell_ops->moments)(fault, t, w, rate, moment));
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, rate, (PetscMPIInt)n, MPIU_REAL, MPIU_SUM, fault->comm));
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, moment, (PetscMPIInt)n, MPIU_REAL, MPIU_SUM, fault->comm));
  }
  for (PetscInt k = 0; k < n; k++) {
    rate[k] *= unit;
    moment[k] *= unit;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SlipFaultOutputSeries(TS ts, PetscReal t, Vec w, Vec r, PetscReal row[], void *ctx)
{
  SlipFault fault = (SlipFault)ctx;
  SlipFaultObservables o;

  PetscFunctionBegin;
  (void)ts;
  if (!r && fault->friction.law->always_slides) PetscCall((*fault->cell_ops->traction)(fault, t, w, &r));
  PetscCall(SlipFaultGetObservables(fault, t, w, r, &o));
  {
    const PetscReal values[] = {o.mean_slip_rate,   o.max_slip_rate, o.mean_slip, o.mean_displacement,
                                o.sliding_fraction, o.kinetic,       o.elastic,   o.viscous_power,
                                o.friction_power,   o.loading_power};

    PetscCall(PetscArraycpy(row, values, SERIES_MOMENT_RATE));
    row += SERIES_MOMENT_RATE;
    PetscCall(Moments(fault, t, w, row, row + fault->mesh.faults));
    row += 2 * fault->mesh.faults;
  }
  if (fault->kind.flows) {
    PetscReal volume[FLUID_NUM_VOLUMES];

    PetscCall(SlipFaultFluidVolumes(fault, t, volume, &row[1]));
    row[0] = volume[FLUID_INJECTED];
    row[2] = volume[FLUID_LEAKED];
    row[3] = volume[FLUID_BORDER];
    row += SERIES_VOLUMES;
    if (fault->loads.nwells) PetscCall(SlipFaultFluidWells(fault, t, row + fault->loads.nwells, row));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SlipFaultOutputSides(void *ctx, PetscInt *n)
{
  PetscFunctionBegin;
  *n = ((SlipFault)ctx)->balance.sides;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates the output of the run. Collective. */
PetscErrorCode SlipFaultSeriesCreate(SlipFault fault, TS ts)
{
  SlipOutputColumn column[PETSC_STATIC_ARRAY_LENGTH(SeriesColumns) + SERIES_FLUID];
  PetscInt ncolumns = PETSC_STATIC_ARRAY_LENGTH(SeriesColumns);

  PetscFunctionBegin;
  PetscCall(PetscArraycpy(column, SeriesColumns, ncolumns));
  PetscCall(PetscArraycpy(column + ncolumns, FluidColumns, SERIES_FLUID));
  if (fault->kind.flows) ncolumns += fault->loads.nwells ? SERIES_FLUID : SERIES_VOLUMES;
  PetscCall(SlipOutputCreate(ts, fault->options.text[FAULT_OUTPUT], ncolumns, column, SlipFaultOutputSeries, fault,
                             &fault->run->file));
  fault->run->file->sides = SlipFaultOutputSides;
  fault->run->file->entries[1 + SERIES_MOMENT_RATE] = fault->run->file->entries[1 + SERIES_MOMENT] = fault->mesh.faults;
  for (PetscInt k = SERIES_MOMENT + 1 + SERIES_VOLUMES; k < ncolumns; k++)
    fault->run->file->entries[1 + k] = fault->loads.nwells;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* On rank 0: writes of which faults and wells the numbers in a row are. */
PetscErrorCode SlipFaultSeriesName(SlipFault fault, SlipH5 *h)
{
  PetscFunctionBegin;
  PetscCall(SlipH5WriteAttrInts(h, "/series/moment_rate", "faults", fault->mesh.faults, fault->mesh.labels));
  PetscCall(SlipH5WriteAttrInts(h, "/series/moment", "faults", fault->mesh.faults, fault->mesh.labels));
  for (int k = 0; k < 2 && fault->kind.flows && fault->loads.nwells; k++) {
    const char *const well[] = {"/series/well_pressure", "/series/well_rate"};
    char *names;
    size_t room = 1;

    for (PetscInt j = 0; j < fault->loads.nwells; j++) room += strlen(fault->loads.wells[j].name) + 1;
    PetscCall(PetscCalloc1(room, &names));
    for (PetscInt j = 0; j < fault->loads.nwells; j++) {
      if (j) PetscCall(PetscStrlcat(names, ";", room));
      PetscCall(PetscStrlcat(names, fault->loads.wells[j].name, room));
    }
    PetscCall(SlipH5WriteAttrString(h, well[k], "wells", names));
    PetscCall(PetscFree(names));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
