/* Sets the parameters of each cell: uniform values, or those of -fault_parameters. */
#include <slipstep/private/slipfault.h>
#include <slipstep/private/slipfaultregional.h>
#include <math.h>
#include <stdio.h>

/* Takes this process's share of the values [N] of all cells; those of a mesh are in the order of its file. */
static void SlipFaultTakeField(SlipFault fault, PetscInt f, const char source[], const PetscReal values[])
{
  fault->fields.source[f] = source;
  for (PetscInt i = 0; i < fault->mesh.n; i++) fault->fields.cell[f][i] = values[SlipFaultMeshRow(&fault->mesh, i)];
}

/* Lists the datasets at the root of an input file, which may serve several inputs: fields, cells and their faults,
   stiffness; slip and points of `elastic`; /model, where slipstep convert stores the rest of a slip model. */
const char *SlipFaultFieldNames(void)
{
  static char names[FAULT_MAX_NAMES];
  const SlipParameter *p;
  size_t k = 0;

  for (PetscInt f = 0; (p = SlipFaultFieldRow(f)); f++)
    k += (size_t)snprintf(names + k, sizeof(names) - k, "%s ", p->name);
  (void)snprintf(names + k, sizeof(names) - k,
                 "cells fault stiffness vertices triangles slip points hanging_wall model");
  return names;
}

/* Checks that a field's values are in the bounds of its parameter, and normal stress is positive. source: their origin
   */
static PetscErrorCode SlipFaultCheckField(SlipFault fault, const char source[], PetscInt f, const PetscReal data[])
{
  SlipParameter p = *SlipFaultFieldRow(f);
  const PetscInt nx = fault->mesh.dims[1];
  char bounds[128];

  PetscFunctionBegin;
  if (f == FIELD_NORMAL_STRESS) p.open = PETSC_TRUE;
  SlipParameterBounds(&p, PETSC_TRUE, bounds, sizeof(bounds));
  for (PetscInt e = 0; e < fault->mesh.N; e++)
    PetscCheck(SlipParameterHolds(&p, data[e]) || (f == FIELD_BORDER_PRESSURE && PetscIsNanReal(data[e])),
               PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
               "%s: /%s[%" PetscInt_FMT ", %" PetscInt_FMT "] is %.6g, expected %s", source, p.name, e / nx, e % nx,
               (double)data[e], bounds);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* On rank 0: reads values [N] (PetscFree()) of a field from the open file, and checks them. */
static PetscErrorCode SlipFaultReadField(SlipFault fault, SlipH5 *h, PetscInt f, PetscReal **values)
{
  const SlipFaultMesh *mesh = &fault->mesh;
  const SlipParameter *p = SlipFaultFieldRow(f);
  char path[64], source[PETSC_MAX_PATH_LEN + 64];
  PetscInt dims[2];
  PetscBool flg;

  PetscFunctionBegin;
  (void)snprintf(source, sizeof(source), "%s%s", h->name, h->source);
  PetscCall(PetscSNPrintf(path, sizeof(path), "/%s", p->name));
  PetscCall(SlipH5CheckUnits(h, path, p->unit, &flg));
  PetscCall(SlipH5ReadRealSized(h, path, mesh->ndim, mesh->dims,
                                mesh->ndim == 1 ? "one for each cell of -fault_mesh" : "Nz x Nx", dims, values));
  PetscCall(SlipFaultCheckField(fault, source, f, *values));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* On rank 0: finds which fields the open file has. */
static PetscErrorCode SlipFaultFindFields(SlipH5 *h, PetscInt has[])
{
  const char *names = SlipFaultFieldNames();
  const SlipParameter *p;
  PetscInt found = 0;

  PetscFunctionBegin;
  PetscCall(SlipH5CheckNames(h, names));
  for (PetscInt f = 0; (p = SlipFaultFieldRow(f)); f++) {
    char path[64];
    PetscBool flg;

    PetscCall(PetscSNPrintf(path, sizeof(path), "/%s", p->name));
    PetscCall(SlipH5Has(h, path, &flg));
    has[f] = flg ? 1 : 0;
    found += has[f];
  }
  PetscCheck(found, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED, "%s%s holds none of the fields %s", h->name, h->source,
             names);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Loads the fields of -fault_parameters: rank 0 reads one after the other and sends it to the owners of the cells. */
static PetscErrorCode SlipFaultLoadFields(SlipFault fault)
{
  SlipH5 h = {0};
  PetscReal *values;
  PetscInt has[FAULT_MAX_FIELDS] = {0}, nfields = FAULT_NUM_FIELDS;
  PetscErrorCode ierr = PETSC_SUCCESS;
  PetscMPIInt rank;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(fault->comm, &rank));
  while (SlipFaultFieldRow(nfields)) nfields++;
  if (!rank)
    ierr = SlipH5OpenReadOption(SlipFaultPrefix(fault), "fault_parameters", fault->options.text[FAULT_PARAMETERS], &h);
  PetscCall(SlipErrorBcast(fault->comm, ierr));
  if (!rank) ierr = SlipFaultFindFields(&h, has);
  if (ierr) (void)SlipH5Close(&h);
  PetscCall(SlipErrorBcast(fault->comm, ierr));
  PetscCallMPI(MPI_Bcast(has, (PetscMPIInt)nfields, MPIU_INT, 0, fault->comm));
  for (PetscInt f = 0; f < nfields; f++) {
    if (!has[f]) continue;
    values = NULL;
    if (!rank) ierr = SlipFaultReadField(fault, &h, f, &values);
    if (ierr) (void)SlipH5Close(&h);
    PetscCall(SlipErrorBcast(fault->comm, ierr));
    PetscCall(SlipFaultScatterFirst(&fault->mesh, values, fault->fields.cell[f]));
    PetscCall(PetscFree(values));
    fault->fields.source[f] = fault->options.text[FAULT_PARAMETERS];
  }
  if (!rank) PetscCall(SlipH5Close(&h));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipFaultSetField - sets a parameter cell by cell

  Logically collective; before SlipFaultSetUp().

  Input Parameters:
+ fault  - the fault
. name   - "normal_stress", "friction_residual", "friction_drop", "friction_slip", "friction_rate", "loading_rate",
           "healing_time", "initial_traction", "stressing_rate", "friction_a", "friction_b", "friction_alpha",
           "friction_reference", "initial_rate", "initial_state", "creep", "rake", "thermal_pressurisation",
           "dilatancy", "permeability", "permeability_ratio", "permeability_maximum", "porosity",
           "pore_compressibility", "aperture", "leakoff", "carter_leakoff", "border_pressure" (NaN: none),
           "fluid_source", "fluid_pressure", or a parameter that a law of SlipFaultRegisterFrictionLaw() brings
. n      - number of cells, nx nz (of all ranks), or cells of a mesh
- values - [n] in the unit of the parameter, by cells iz nx + ix, or by rows of the mesh's file; the same on every
           rank; the fault copies them

  Level: intermediate

  Notes:
  A dataset of -fault_parameters overrides the field, which overrides -fault_regional_stress, which overrides the
  scalar parameter. The gradient of normal stress is not added to normal stress that is set this way.

  Errors: PETSC_ERR_ARG_UNKNOWN_TYPE for a name without a field; at SlipFaultSetUp() PETSC_ERR_ARG_SIZ for another
  number of cells, PETSC_ERR_ARG_OUTOFRANGE for values out of bounds

.seealso: SlipFaultSetReal()
@*/
PetscErrorCode SlipFaultSetField(SlipFault fault, const char name[], PetscInt n, const PetscReal values[])
{
  const PetscInt f = SlipFaultFindField(name);

  PetscFunctionBegin;
  PetscValidHeaderSpecific(fault, SLIP_FAULT_CLASSID, 1);
  PetscCheck(!fault->setup, fault->comm, PETSC_ERR_ORDER, "call SlipFaultSetField() before SlipFaultSetUp()");
  PetscCheck(f >= 0, fault->comm, PETSC_ERR_ARG_UNKNOWN_TYPE, "a fault has no field \"%s\"; expected one of %s", name,
             SlipFaultFieldNames());
  PetscCall(PetscFree(fault->fields.given[f]));
  PetscCall(PetscMalloc1(PetscMax(n, 1), &fault->fields.given[f]));
  PetscCall(PetscArraycpy(fault->fields.given[f], values, n));
  fault->fields.ngiven[f] = n;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Refuses cells without an evolution effect under the law whose state is what friction follows, in units of b. */
static PetscErrorCode CheckEvolution(SlipFault fault)
{
  PetscInt count = 0;

  PetscFunctionBegin;
  if (fault->friction.law->rate != SlipStrongRate) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt i = 0; i < fault->mesh.n; i++) count += fault->fields.cell[FIELD_FRICTION_B][i] == 0;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &count, 1, MPIU_INT, MPI_SUM, fault->comm));
  PetscCheck(!count, fault->comm, PETSC_ERR_ARG_OUTOFRANGE,
             "-%sfault_friction_b is 0 in %" PetscInt_FMT " of %" PetscInt_FMT
             " cells, expected a number > 0 with -%sfault_friction_law %s",
             SlipFaultPrefix(fault), count, fault->mesh.N, SlipFaultPrefix(fault), fault->friction.law->name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultCellsSetUp(SlipFault fault)
{
  const char *prefix = SlipFaultPrefix(fault);
  const SlipParameter *p;
  const PetscReal *own[FAULT_MAX_OWN];
  PetscReal low = PETSC_MAX_REAL, value, gradient;
  PetscInt n = 0, any[2] = {0};

  PetscFunctionBegin;
  /* scalar parameters fill the fields first, then SlipFaultSetField() and the file override them */
  for (PetscInt f = 0; (p = SlipFaultFieldRow(f)); f++) {
    PetscCall(PetscMalloc1(PetscMax(fault->mesh.n, 1), &fault->fields.cell[f]));
    PetscCall(SlipFaultGetReal(fault, p->name, &value));
    for (PetscInt i = 0; i < fault->mesh.n; i++) fault->fields.cell[f][i] = value;
  }
  PetscCall(SlipFaultGetReal(fault, "normal_stress_gradient", &gradient));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    SlipFaultCell cell;

    fault->mesh.kind->cell(&fault->mesh, SlipFaultMeshRow(&fault->mesh, i), &cell);
    fault->fields.cell[FIELD_NORMAL_STRESS][i] += gradient * cell.centre[2];
  }
  for (PetscInt f = 0; (p = SlipFaultFieldRow(f)); f++) {
    if (!fault->fields.given[f]) continue;
    PetscCheck(fault->fields.ngiven[f] == fault->mesh.N, fault->comm, PETSC_ERR_ARG_SIZ,
               "SlipFaultSetField(): %s was given for %" PetscInt_FMT " cells, expected %" PetscInt_FMT, p->name,
               fault->fields.ngiven[f], fault->mesh.N);
    PetscCall(SlipFaultCheckField(fault, "SlipFaultSetField()", f, fault->fields.given[f]));
    SlipFaultTakeField(fault, f, "SlipFaultSetField()", fault->fields.given[f]);
  }
  if (fault->options.text[FAULT_PARAMETERS][0]) PetscCall(SlipFaultLoadFields(fault));
  PetscCall(SlipFaultRegionalSetUp(fault));

  /* the law's own parameters cell by cell, and room for its cached values */
  for (PetscInt f = FAULT_NUM_FIELDS; SlipFaultFieldRow(f); f++)
    if (SlipFaultHasField(fault, f)) own[n++] = fault->fields.cell[f];
  PetscCall(PetscMalloc1(PetscMax(fault->mesh.n * n, 1), &fault->friction.own));
  for (PetscInt i = 0; i < fault->mesh.n; i++)
    for (PetscInt k = 0; k < n; k++) fault->friction.own[i * n + k] = own[k][i];
  fault->friction.nown = n;
  if (fault->friction.law->remembers) {
    PetscCall(PetscMalloc1(4 * fault->mesh.n + 1, &fault->friction.known));
    for (PetscInt i = 0; i < 4 * fault->mesh.n; i++) fault->friction.known[i] = (PetscReal)NAN;
  }

  PetscCall(CheckEvolution(fault));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    low = PetscMin(low, fault->fields.cell[FIELD_NORMAL_STRESS][i]);
    any[0] |= fault->fields.cell[FIELD_LOADING_RATE][i] != 0;
    any[1] |= fault->fields.cell[FIELD_PERMEABILITY][i] != 0;
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &low, 1, MPIU_REAL, MPIU_MIN, fault->comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, any, 2, MPIU_INT, MPI_MAX, fault->comm));
  PetscCheck(low > 0, fault->comm, PETSC_ERR_ARG_OUTOFRANGE,
             "the least effective normal stress is %.6g Pa, expected > 0: raise -%sfault_normal_stress or "
             "-%sfault_normal_stress_gradient",
             (double)low, prefix, prefix);
  fault->kind.loaded = any[0] ? PETSC_TRUE : PETSC_FALSE;
  fault->kind.flows = any[1] ? PETSC_TRUE : PETSC_FALSE;
  PetscCall(SlipFaultComponentsSetUp(fault));
  PetscCall(SlipFaultChooseCoupling(fault));
  PetscFunctionReturn(PETSC_SUCCESS);
}
