/* Resolves the stress of a region on the cells: effective normal stress, initial traction, and the slip tendency, shear
   over effective normal stress (Morris et al. 1996). */
#include <slipstep/private/slipfault.h>
#include <slipstep/private/slipfaultregional.h>
#include <slipstep/private/slipelasticity.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

/* Shear stress below this share of the normal stress has no direction, only rounding. */
#define NO_SHEAR 1e-12
/* Rakes are multiples of this [degrees], so that cells of one plane under one shape of stress have the same one. */
#define RAKE_STEP 1e-10

PetscBool SlipFaultHasRegional(SlipFault fault)
{
  const char(*text)[PETSC_MAX_PATH_LEN] = (const char(*)[PETSC_MAX_PATH_LEN])fault->options.text;

  return text[FAULT_REGIONAL_STRESS][0] || text[FAULT_REGIONAL_STRESS_GRADIENT][0] || text[FAULT_REGIONAL_RATIOS][0]
           ? PETSC_TRUE
           : PETSC_FALSE;
}

/* Reads n numbers, separated by commas, of an option. */
static PetscErrorCode ReadNumbers(SlipFault fault, PetscInt id, PetscInt n, const char expected[], PetscReal x[])
{
  PetscBool good;
  PetscInt count;

  PetscFunctionBegin;
  PetscCall(SlipFaultReadNumbers(fault, id, n, x, &count, &good));
  for (PetscInt k = 0; k < n && count == n; k++) good = good && PetscAbsReal(x[k]) <= 1e60 ? PETSC_TRUE : PETSC_FALSE;
  PetscCheck(count == n && good, fault->comm, PETSC_ERR_ARG_WRONG, "-%sfault_%s is \"%s\", expected %s",
             SlipFaultPrefix(fault), SlipFaultStrings[id].name, fault->options.text[id], expected);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes the tensor, per metre of depth, of the ratios of the horizontal stresses to the vertical one. */
static PetscErrorCode ReadRatios(SlipFault fault, PetscReal per[6])
{
  const char expected[] = "two numbers SHmax/Sv,Shmin/Sv, both > 0 and the first one not below the second";
  const PetscReal vertical = fault->options.value[FAULT_DENSITY] * SLIP_GRAVITY;
  PetscReal ratio[2] = {0, 0}, sine, cosine, mean, half;

  PetscFunctionBegin;
  PetscCall(ReadNumbers(fault, FAULT_REGIONAL_RATIOS, 2, expected, ratio));
  PetscCheck(ratio[1] > 0 && ratio[0] >= ratio[1], fault->comm, PETSC_ERR_ARG_OUTOFRANGE,
             "-%sfault_regional_ratios is \"%s\", expected %s", SlipFaultPrefix(fault),
             fault->options.text[FAULT_REGIONAL_RATIOS], expected);
  mean = 0.5 * (ratio[0] + ratio[1]) * vertical;
  half = 0.5 * (ratio[0] - ratio[1]) * vertical;
  SlipDegrees(2 * fault->options.value[FAULT_REGIONAL_AZIMUTH], &sine, &cosine);
  per[0] = mean + half * cosine;
  per[1] = mean - half * cosine;
  per[2] = vertical;
  per[3] = half * sine;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadStress(SlipFault fault, SlipRegionalStress *s)
{
  const char(*text)[PETSC_MAX_PATH_LEN] = (const char(*)[PETSC_MAX_PATH_LEN])fault->options.text;
  PetscReal p[2] = {0, SLIP_WATER_GRADIENT};

  PetscFunctionBegin;
  *s = (SlipRegionalStress){{0}, {0}, 0, 0};
  if (text[FAULT_REGIONAL_STRESS][0])
    PetscCall(ReadNumbers(fault, FAULT_REGIONAL_STRESS, 6,
                          "six numbers of Pa: north-north,east-east,down-down,north-east,north-down,east-down", s->at));
  if (text[FAULT_REGIONAL_STRESS_GRADIENT][0])
    PetscCall(ReadNumbers(fault, FAULT_REGIONAL_STRESS_GRADIENT, 6,
                          "six numbers of Pa/m: north-north,east-east,down-down,north-east,north-down,east-down",
                          s->per));
  if (text[FAULT_REGIONAL_RATIOS][0]) PetscCall(ReadRatios(fault, s->per));
  if (!strcmp(text[FAULT_REGIONAL_PRESSURE], "none"))
    p[1] = 0;
  else if (strcmp(text[FAULT_REGIONAL_PRESSURE], "hydrostatic"))
    PetscCall(
      ReadNumbers(fault, FAULT_REGIONAL_PRESSURE, 2, "hydrostatic, none, or two numbers p,dp/dz of Pa and Pa/m", p));
  s->pressure = p[0];
  s->pressure_per = p[1];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Effective normal stress, and the shear stress that drives slip along strike and up dip, of a cell with directions
   [3][3] along strike, up dip and into the hanging wall. With the stress positive in compression SlipStressTraction(),
   whose stress is positive in tension, gives the shear that drives slip, and minus the normal stress. */
void SlipRegionalResolve(const SlipRegionalStress *s, PetscReal depth, const PetscReal directions[], PetscReal *normal,
                         PetscReal shear[2])
{
  PetscReal stress[6], traction[3];

  for (int k = 0; k < 6; k++) stress[k] = s->at[k] + depth * s->per[k];
  SlipStressTraction(1, stress, directions, traction);
  shear[0] = traction[0];
  shear[1] = traction[1];
  *normal = -traction[2] - (s->pressure + depth * s->pressure_per);
}

/* Sets what a cell has where no field has it; fields [3]: whether these may change. */
static void SetCell(SlipFault fault, PetscInt i, PetscReal normal, const PetscReal shear[2], const PetscBool may[3])
{
  const PetscReal size = hypot(shear[0], shear[1]);
  PetscReal *rake = &fault->fields.cell[FIELD_RAKE][i], sine, cosine;

  if (may[0]) fault->fields.cell[FIELD_NORMAL_STRESS][i] = normal;
  if (may[2] && size > NO_SHEAR * PetscAbsReal(normal)) {
    *rake = atan2(shear[1], shear[0]) * (180 / PETSC_PI);
    *rake = RAKE_STEP * round(*rake / RAKE_STEP);
  }
  SlipDegrees(*rake, &sine, &cosine);
  if (may[1]) fault->fields.cell[FIELD_INITIAL_TRACTION][i] = shear[0] * cosine + shear[1] * sine;
}

/* Refuses cells under tension, by their number, and the row and place of the first one. Collective. */
static PetscErrorCode CheckTension(SlipFault fault, PetscInt count, PetscInt first, PetscReal normal)
{
  const char *prefix = SlipFaultPrefix(fault);
  PetscInt row = first;
  SlipFaultCell cell;
  char place[192];

  PetscFunctionBegin;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &count, 1, MPIU_INT, MPI_SUM, fault->comm));
  if (!count) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &row, 1, MPIU_INT, MPI_MIN, fault->comm));
  if (row != first) normal = PETSC_MAX_REAL;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &normal, 1, MPIU_REAL, MPIU_MIN, fault->comm));
  fault->mesh.kind->cell(&fault->mesh, row, &cell);
  (void)snprintf(place, sizeof(place), "cell %lld at x %.6g, y %.6g, z %.6g m", (long long)row, (double)cell.centre[0],
                 (double)cell.centre[1], (double)cell.centre[2]);
  SETERRQ(fault->comm, PETSC_ERR_ARG_OUTOFRANGE,
          "the effective normal stress by %s is not positive in %" PetscInt_FMT " of %" PetscInt_FMT
          " cells, of which the first is %s with %.6g Pa: expected compression above the pressure of "
          "-%sfault_regional_pressure",
          fault->fields.regional, count, fault->mesh.N, place, (double)normal, prefix);
}

/* Fills the fields; after those of files and of SlipFaultSetField(), which stay. Collective. */
PetscErrorCode SlipFaultRegionalSetUp(SlipFault fault)
{
  static const SlipFaultFieldId field[] = {FIELD_NORMAL_STRESS, FIELD_INITIAL_TRACTION, FIELD_RAKE};
  const char(*text)[PETSC_MAX_PATH_LEN] = (const char(*)[PETSC_MAX_PATH_LEN])fault->options.text;
  const PetscBool vectors = fault->layout.plane > 1 ? PETSC_TRUE : PETSC_FALSE;
  PetscInt tense = 0, first = PETSC_MAX_INT;
  PetscReal there = PETSC_MAX_REAL;
  SlipRegionalStress stress;
  PetscBool may[3];

  PetscFunctionBegin;
  if (!SlipFaultHasRegional(fault)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(ReadStress(fault, &stress));
  fault->fields.regional = text[FAULT_REGIONAL_RATIOS][0]   ? "-fault_regional_ratios"
                           : text[FAULT_REGIONAL_STRESS][0] ? "-fault_regional_stress"
                                                            : "-fault_regional_stress_gradient";
  for (int k = 0; k < 3; k++) may[k] = fault->fields.source[field[k]] ? PETSC_FALSE : PETSC_TRUE;
  PetscCheck(!vectors || !may[1] || may[2], fault->comm, PETSC_ERR_ARG_INCOMP,
             "%s and a field rake (%s) exclude each other with -%sfault_slip_components 2, where the rake is the "
             "direction of the shear stress: expected no rake, or also a field initial_traction",
             fault->fields.regional, fault->fields.source[FIELD_RAKE], SlipFaultPrefix(fault));
  if (!may[1] || (!vectors && strcmp(text[FAULT_REGIONAL_RAKE], "shear"))) may[2] = PETSC_FALSE;
  PetscCall(PetscMalloc1(PetscMax(fault->mesh.n, 1), &fault->fields.tendency));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    const PetscInt row = SlipFaultMeshRow(&fault->mesh, i);
    PetscReal directions[9], normal, shear[2];
    SlipFaultCell cell;

    fault->mesh.kind->cell(&fault->mesh, row, &cell);
    for (int k = 0; k < 3; k++) {
      directions[k] = cell.direction[0][k];
      directions[3 + k] = -cell.direction[1][k];
      directions[6 + k] = cell.direction[2][k];
    }
    SlipRegionalResolve(&stress, cell.centre[2], directions, &normal, shear);
    fault->fields.tendency[i] = hypot(shear[0], shear[1]) / normal;
    SetCell(fault, i, normal, shear, may);
    if (!may[0] || normal > 0) continue;
    tense++;
    if (row < first) there = normal;
    first = PetscMin(first, row);
  }
  for (int k = 0; k < 3; k++)
    if (may[k]) fault->fields.source[field[k]] = fault->fields.regional;
  PetscCall(CheckTension(fault, tense, first, there));
  PetscFunctionReturn(PETSC_SUCCESS);
}
