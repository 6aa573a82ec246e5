/* Lets Python and other languages set options of a fault by name and read texts and arrays of all cells. */
#include <slipstep/private/slipfault.h>
#include <math.h>
#include <string.h>

/*@C
  SlipFaultSetBool - sets a parameter of a fault that is yes or no

  Logically collective; before SlipFaultSetUp() (inertia and initial_unstable) or SlipFaultOutputStart()

  Input Parameters:
+ fault - the fault
. name  - "inertia", "initial_unstable", "check_error", "output_overwrite", "output_xdmf", "progress" or
          "catalogue_maps": the option's name without "fault_"
- value - the new value

  Level: intermediate

  Errors: PETSC_ERR_ARG_UNKNOWN_TYPE for an unknown name, PETSC_ERR_ARG_WRONGSTATE after SlipFaultSetUp()

.seealso: SlipFaultSetReal(), SlipFaultSetString(), SlipFaultSetInertia()
@*/
PetscErrorCode SlipFaultSetBool(SlipFault fault, const char name[], PetscBool value)
{
  PetscBool same;

  PetscFunctionBegin;
  PetscValidHeaderSpecific(fault, SLIP_FAULT_CLASSID, 1);
  PetscCall(PetscStrcmp(name, "inertia", &same));
  if (same) {
    PetscCall(SlipFaultSetInertia(fault, value));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  for (PetscInt i = 0; i < FAULT_NUM_SWITCHES; i++) {
    const SlipFaultSwitch *p = &SlipFaultSwitches[i];

    PetscCall(PetscStrcmp(name, p->name, &same));
    if (!same) continue;
    PetscCheck(!fault->meshed || p->part == SLIP_PART_OUTPUT, fault->comm, PETSC_ERR_ARG_WRONGSTATE,
               "%s must be set before SlipFaultSetUp() and SlipFaultSetUpMesh()", name);
    *(PetscBool *)((char *)fault + p->offset) = value;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  SETERRQ(fault->comm, PETSC_ERR_ARG_UNKNOWN_TYPE, "a fault has no switch \"%s\"", name);
}

/*@C
  SlipFaultGetString - gets a text parameter of a fault, which names a choice or a file

  Not collective

  Input Parameters:
+ fault - the fault
. name  - the option's name without "fault_", for example "catalogue"
- len   - size of value [characters, with the final zero]

  Output Parameter:
. value - "" for a file that was not named; cut where it is too long

  Level: intermediate

  Errors: PETSC_ERR_ARG_UNKNOWN_TYPE for an unknown name

.seealso: SlipFaultSetString(), SlipFaultGetReal()
@*/
PetscErrorCode SlipFaultGetString(SlipFault fault, const char name[], char value[], size_t len)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(fault, SLIP_FAULT_CLASSID, 1);
  for (PetscInt i = 0; i < FAULT_NUM_STRINGS; i++) {
    PetscBool same;

    PetscCall(PetscStrcmp(name, SlipFaultStrings[i].name, &same));
    if (!same) continue;
    PetscCall(PetscStrncpy(value, SlipFaultGetText(fault, i), len));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  SETERRQ(fault->comm, PETSC_ERR_ARG_UNKNOWN_TYPE, "a fault has no choice \"%s\"", name);
}

static PetscErrorCode CheckSize(SlipFault fault, PetscInt n)
{
  PetscFunctionBegin;
  PetscCheck(n == fault->mesh.N, fault->comm, PETSC_ERR_ARG_SIZ,
             "room for %" PetscInt_FMT " cells, expected the %" PetscInt_FMT " of the fault", n, fault->mesh.N);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipFaultGetField - gets a parameter of all cells

  Collective; after SlipFaultSetUp()

  Input Parameters:
+ fault - the fault
. name  - one that SlipFaultSetField() takes, for example "normal_stress"
- n     - number of cells, of all processes

  Output Parameter:
. values - [n] in the unit of the parameter, by cells iz nx + ix, or by rows of the mesh's file; it is the same on every
           process

  Level: intermediate

  Errors: PETSC_ERR_ARG_UNKNOWN_TYPE for a name without a field, PETSC_ERR_ARG_SIZ for another number of cells

.seealso: SlipFaultSetField(), SlipFaultGetCellValues(), SlipFaultGetCentres()
@*/
PetscErrorCode SlipFaultGetField(SlipFault fault, const char name[], PetscInt n, PetscReal values[])
{
  const PetscInt f = SlipFaultFindField(name);

  PetscFunctionBegin;
  SlipFaultCheckSetUp(fault, 1);
  PetscCall(CheckSize(fault, n));
  PetscCheck(f >= 0 && fault->fields.cell[f], fault->comm, PETSC_ERR_ARG_UNKNOWN_TYPE, "a fault has no field \"%s\"",
             name);
  PetscCall(SlipFaultGatherAll(&fault->mesh, fault->fields.cell[f], values));
  PetscFunctionReturn(PETSC_SUCCESS);
}

enum { X, Y, Z, AREA, STRIKE, DIP, LABEL, NUM_GEOMETRY };
const SlipFaultGeometryName SlipFaultGeometryNames[NUM_GEOMETRY + 1] = {[X] = {"x", "m"},
                                                                        [Y] = {"y", "m"},
                                                                        [Z] = {"z", "m"},
                                                                        [AREA] = {"area", "m^2"},
                                                                        [STRIKE] = {"strike", "degrees"},
                                                                        [DIP] = {"dip", "degrees"},
                                                                        [LABEL] = {"fault", "1"},
                                                                        {NULL, NULL}};

static PetscReal Geometry(const SlipFaultMesh *mesh, PetscInt row, PetscInt which)
{
  SlipFaultCell cell;
  PetscReal strike;

  mesh->kind->cell(mesh, row, &cell);
  switch (which) {
  case AREA:
    return cell.size[0] * cell.size[1];
  case STRIKE:
    strike = atan2(cell.direction[0][1], cell.direction[0][0]) * 180 / PETSC_PI;
    return strike < 0 ? strike + 360 : strike;
  case DIP:
    return atan2(cell.direction[1][2], hypot(cell.direction[1][0], cell.direction[1][1])) * 180 / PETSC_PI;
  case LABEL:
    return (PetscReal)(mesh->label ? mesh->label[row] : 0);
  default:
    return cell.centre[which];
  }
}

/*@C
  SlipFaultGetGeometry - gets the positions, areas and directions of the cells

  Not collective; after SlipFaultSetUpMesh() or SlipFaultSetUp()

  Input Parameters:
+ fault - the fault
. name  - "x", "y", "z": the centre [m], north or along strike, east or to the right of it, and down; "area" [m^2];
          "strike", "dip" [degrees] as Aki and Richards define them; "fault": the label of the cell's fault
- n     - number of cells, of all processes

  Output Parameter:
. values - [n] in the order of SlipFaultSetField(), [m], [m^2] or [degrees]

  Level: intermediate

  Errors: PETSC_ERR_ARG_UNKNOWN_TYPE for another name, PETSC_ERR_ARG_SIZ for another number of cells, PETSC_ERR_ORDER
  before the mesh is set up

.seealso: SlipFaultSetUpMesh(), SlipFaultSetField(), SlipFaultGetCentres()
@*/
PetscErrorCode SlipFaultGetGeometry(SlipFault fault, const char name[], PetscInt n, PetscReal values[])
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(fault, SLIP_FAULT_CLASSID, 1);
  PetscCheck(fault->meshed, fault->comm, PETSC_ERR_ORDER, "call SlipFaultSetUpMesh() or SlipFaultSetUp() first");
  PetscCall(CheckSize(fault, n));
  for (PetscInt k = 0; k < NUM_GEOMETRY; k++) {
    if (strcmp(name, SlipFaultGeometryNames[k].name)) continue;
    for (PetscInt e = 0; e < n; e++) values[e] = Geometry(&fault->mesh, e, k);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  SETERRQ(fault->comm, PETSC_ERR_ARG_UNKNOWN_TYPE, "cells have no \"%s\"; expected x, y, z, area, strike, dip or fault",
          name);
}

/*@
  SlipFaultGetCentres - gets the centres of the cells

  Not collective; after SlipFaultSetUpMesh() or SlipFaultSetUp()

  Input Parameters:
+ fault - the fault
- n     - number of cells, of all processes

  Output Parameters:
+ x - [n] centres along strike [m]
. y - [n] across the strike, 0 for a grid [m]
- z - [n] depths [m]

  Level: intermediate

  Note:
  Cells are in the order of SlipFaultGetField().

  Errors: PETSC_ERR_ARG_SIZ for another number of cells

.seealso: SlipFaultGetField(), SlipFaultGetGeometry()
@*/
PetscErrorCode SlipFaultGetCentres(SlipFault fault, PetscInt n, PetscReal x[], PetscReal y[], PetscReal z[])
{
  PetscFunctionBegin;
  PetscCall(SlipFaultGetGeometry(fault, "x", n, x));
  PetscCall(SlipFaultGetGeometry(fault, "y", n, y));
  PetscCall(SlipFaultGetGeometry(fault, "z", n, z));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gathers component j of the cells, which have "each" numbers apiece, into column j of values, whose rows are cells. */
static PetscErrorCode GatherComponent(SlipFault fault, PetscInt each, PetscInt j, const PetscReal local[],
                                      PetscReal values[])
{
  PetscReal *mine, *all;

  PetscFunctionBegin;
  if (each == 1) {
    PetscCall(SlipFaultGatherAll(&fault->mesh, local, values));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(PetscMalloc2(fault->mesh.n + 1, &mine, fault->mesh.N, &all));
  for (PetscInt i = 0; i < fault->mesh.n; i++) mine[i] = local[each * i + j];
  PetscCall(SlipFaultGatherAll(&fault->mesh, mine, all));
  for (PetscInt i = 0; i < fault->mesh.N; i++) values[each * i + j] = all[i];
  PetscCall(PetscFree2(mine, all));
  PetscFunctionReturn(PETSC_SUCCESS);
}

enum { RATE, DISPLACEMENT, SLIP, STATE, NORMAL, OPENING, TRACTION, STRESS, COUNT };

/* Finds which of these values, or which state of friction, the name means, and how many numbers a cell has of it. */
static PetscErrorCode FindValues(SlipFault fault, const char name[], PetscInt *k, PetscInt *state, PetscInt *each)
{
  static const char *const names[COUNT] = {"slip_rate",     "displacement", "slip",     NULL,
                                           "normal_stress", "opening",      "traction", "stress"};
  char states[SLIP_MAX_STATES * FAULT_MAX_NAME] = "";
  PetscBool same = PETSC_FALSE;

  PetscFunctionBegin;
  for (*state = 0; *state < fault->layout.states && !same; ++*state) {
    const char *const one = SlipFrictionStateName(fault->friction.law, *state);

    PetscCall(PetscStrcmp(name, one, &same));
    PetscCall(PetscStrlcat(states, one, sizeof(states)));
    PetscCall(PetscStrlcat(states, ", ", sizeof(states)));
  }
  --*state;
  *k = STATE + 1;
  if (!same)
    for (*k = 0; *k < COUNT && !same; ++*k) PetscCall(PetscStrcmp(name, names[*k] ? names[*k] : "", &same));
  --*k;
  PetscCheck(
    same && name[0], fault->comm, PETSC_ERR_ARG_UNKNOWN_TYPE,
    "a state has no \"%s\", expected slip_rate, displacement, slip, %snormal_stress, opening, traction or stress", name,
    states);
  *each = *k == STATE || *k == NORMAL || *k == OPENING ? 1 : fault->layout.plane;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipFaultGetCellComponents - gets how many numbers of SlipFaultGetCellValues() a cell has

  Not collective; after SlipFaultSetUp()

  Input Parameters:
+ fault - the fault
- name  - one of the names of SlipFaultGetCellValues()

  Output Parameter:
. n - 1; with two components of slip 2, but for states, normal stress and opening

  Level: intermediate

  Errors: PETSC_ERR_ARG_UNKNOWN_TYPE for another name

.seealso: SlipFaultGetCellValues()
@*/
PetscErrorCode SlipFaultGetCellComponents(SlipFault fault, const char name[], PetscInt *n)
{
  PetscInt k, state;

  PetscFunctionBegin;
  SlipFaultCheckSetUp(fault, 1);
  PetscAssertPointer(n, 3);
  PetscCall(FindValues(fault, name, &k, &state, n));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipFaultGetCellValues - gets the values of a state in all cells

  Collective; after SlipFaultSetUp(), for the traction after SlipFaultConfigureTS()

  Input Parameters:
+ fault - the fault
. t     - time of the state [s]
. w     - state, of SlipFaultCreateState()
. name  - "slip_rate" [m/s], "displacement" [m] relative to the far field, "slip" [m] since the start, "state" (where a
          law has several states, the name of one), "traction" [Pa] as in output files, "normal_stress" [Pa], effective,
          "opening" [m], 0 where cells cannot open, or "stress" [Pa], the elastic shear stress of SlipFaultStress()
- n     - number of cells, of all processes

  Output Parameter:
. values - [n], or with two components of slip [n][2] but for state, normal stress and opening; in the unit of the name,
           in the order of SlipFaultGetField(), the same on every process

  Level: intermediate

  Notes:
  Where slip has two components, heals or has a state of its law's own, it is computed from the displacement and that of
  the far field since time 0.

  Errors: PETSC_ERR_ARG_UNKNOWN_TYPE for another name, PETSC_ERR_ARG_SIZ for another number of cells

.seealso: SlipFaultGetCellComponents(), SlipFaultGetField(), SlipFaultStress()
@*/
PetscErrorCode SlipFaultGetCellValues(SlipFault fault, PetscReal t, Vec w, const char name[], PetscInt n,
                                      PetscReal values[])
{
  const PetscInt c = fault->layout.components;
  const PetscReal *a, *u;
  PetscReal *local;
  SlipFrictionCells friction;
  PetscInt k, state, each;
  Vec T;

  PetscFunctionBegin;
  SlipFaultCheckSetUp(fault, 1);
  PetscValidHeaderSpecific(w, VEC_CLASSID, 3);
  PetscCall(CheckSize(fault, n));
  PetscCall(FindValues(fault, name, &k, &state, &each));
  PetscCall(VecDuplicate(fault->critical.uc, &T));
  if (k == STRESS) PetscCall(SlipFaultStress(fault, t, w, T));
  if (k == TRACTION) PetscCall(SlipFaultTraction(fault, t, w, T));
  PetscCall(SlipFaultGetFrictionOf(fault, t, w, &friction));
  PetscCall(PetscMalloc1(PetscMax(each * fault->mesh.n, 1), &local));
  PetscCall(VecGetArrayRead(k >= TRACTION ? T : w, &a));
  PetscCall(VecGetArrayRead(fault->critical.uc, &u));
  for (PetscInt i = 0; i < fault->mesh.n; i++)
    for (PetscInt j = 0; j < each; j++) {
      PetscReal *value = local + each * i + j;

      if (k == STRESS)
        *value = a[c * i + j];
      else if (k == TRACTION)
        *value = a[c * i + j] / fault->mesh.weight[i];
      else if (k == NORMAL)
        *value = friction.stress[i];
      else if (k == OPENING)
        *value = SlipFaultAcross(fault, a + SlipFaultDisplacementAt(fault, i));
      else if (k == STATE)
        *value = SlipFrictionShown(&friction, i, state, a[SlipFaultStateAt(fault, i) + state]);
      else if (k == SLIP && (each == 2 || fault->kind.heals || fault->friction.law->nstates))
        *value = a[SlipFaultDisplacementAt(fault, i) + j] - fault->critical.start_share * u[c * i + j] +
                 (fault->loads.origin + t) * (fault->fields.cell[FIELD_LOADING_RATE][i] * SlipFaultAlong(fault, i)[j]);
      else
        *value = a[k == RATE           ? SlipFaultRateAt(fault, i) + j
                   : k == DISPLACEMENT ? SlipFaultDisplacementAt(fault, i) + j
                                       : SlipFaultStateAt(fault, i)];
    }
  PetscCall(VecRestoreArrayRead(fault->critical.uc, &u));
  PetscCall(VecRestoreArrayRead(k >= TRACTION ? T : w, &a));
  PetscCall(VecDestroy(&T));
  for (PetscInt j = 0; j < each; j++) PetscCall(GatherComponent(fault, each, j, local, values));
  PetscCall(PetscFree(local));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipFaultGetLabels - gets the labels of the faults of a mesh, in the order in which output files number the faults

  Not collective; after SlipFaultSetUp()

  Input Parameters:
+ fault - the fault
- size  - room in label

  Output Parameters:
+ n     - number of faults
- label - [n] as far as there is room, ascending: the values of /fault in the file of -fault_mesh, else the numbers of
          the planes in the file, from 0; for a grid, or for more than 21 planes, only 0; NULL: only n is wanted

  Level: intermediate

  Errors: PETSC_ERR_ORDER before SlipFaultSetUp()

.seealso: SlipFaultGetEvents(), SlipFaultGetCentres()
@*/
PetscErrorCode SlipFaultGetLabels(SlipFault fault, PetscInt size, PetscInt *n, PetscInt label[])
{
  PetscFunctionBegin;
  SlipFaultCheckSetUp(fault, 1);
  PetscAssertPointer(n, 3);
  *n = fault->mesh.faults;
  if (label) PetscCall(PetscArraycpy(label, fault->mesh.labels, PetscMin(size, *n)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipFaultGetEvents - gets a column of the catalogue of a run

  Collective; after SlipFaultOutputFinish()

  Input Parameters:
+ fault  - the fault
. column - "onset", "moment", ...: a dataset of -fault_catalogue
- size   - room in values

  Output Parameters:
+ n      - number of events; for a column with a number for each of several faults, such as "fault_moment", it is
           events times faults
- values - [n], one event after the other, as far as there is room, in SI units; the same on every process; NULL: only n
           is wanted

  Level: intermediate

  Errors: PETSC_ERR_ORDER without -fault_catalogue; an error of reading where the file or the column cannot be read

.seealso: SlipFaultOutputFinish(), SlipFaultSetString(), SlipFaultGetLabels()
@*/
PetscErrorCode SlipFaultGetEvents(SlipFault fault, const char column[], PetscInt size, PetscInt *n, PetscReal values[])
{
  const char *file = fault->options.text[FAULT_CATALOGUE];
  PetscErrorCode ierr = PETSC_SUCCESS;
  PetscReal *data = NULL;
  PetscInt ndim, dims[2] = {0, 1};
  PetscMPIInt rank;
  char path[64];
  SlipH5 h;

  PetscFunctionBegin;
  PetscValidHeaderSpecific(fault, SLIP_FAULT_CLASSID, 1);
  PetscCheck(file[0], fault->comm, PETSC_ERR_ORDER, "there are no events without -%sfault_catalogue",
             SlipFaultPrefix(fault));
  PetscCallMPI(MPI_Comm_rank(fault->comm, &rank));
  PetscCall(PetscSNPrintf(path, sizeof(path), "/%s", column));
  *n = 0;
  if (!rank) {
    ierr = SlipH5OpenReadOption(SlipFaultPrefix(fault), "fault_catalogue", file, &h);
    if (!ierr) {
      ierr = SlipH5GetRank(&h, path, &ndim);
      if (!ierr) ierr = SlipH5ReadReal(&h, path, ndim == 2 ? 2 : 1, dims, &data);
      PetscCall(SlipH5Close(&h));
    }
    *n = dims[0] * dims[1];
  }
  PetscCall(SlipErrorBcast(fault->comm, ierr));
  PetscCallMPI(MPI_Bcast(n, 1, MPIU_INT, 0, fault->comm));
  if (values) {
    if (!rank) PetscCall(PetscArraycpy(values, data, PetscMin(size, *n)));
    PetscCallMPI(MPI_Bcast(values, (PetscMPIInt)PetscMin(size, *n), MPIU_REAL, 0, fault->comm));
  }
  PetscCall(PetscFree(data));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets whether the fault has inertia. inertia: PETSC_TRUE (the default unless cells always slide), or PETSC_FALSE: M =
   0, the quasi-dynamic balance H (v - v_inf) + K u = T + tau, in which H, still made with M = rho Ly or radiation
   damping, limits slip rates. Option -fault_inertia <yes,no>: sets the same. Errors: PETSC_ERR_ORDER after
   SlipFaultSetUp(); there, PETSC_ERR_ARG_INCOMP without inertia and viscosity. */
PetscErrorCode SlipFaultSetInertia(SlipFault fault, PetscBool inertia)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(fault, SLIP_FAULT_CLASSID, 1);
  PetscCheck(!fault->meshed, fault->comm, PETSC_ERR_ORDER,
             "call SlipFaultSetInertia() before SlipFaultSetUp() and SlipFaultSetUpMesh()");
  fault->options.inertia = inertia;
  fault->options.inertia_given = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipFaultGetOperators - gets stiffness, viscosity and mass of the fault

  Not collective; after SlipFaultSetUp()

  Input Parameter:
. fault - the fault

  Output Parameters (each may be NULL):
+ K    - stiffness after scaling, N x N [Pa/m], borrowed
. H    - viscosity, N x N [Pa s/m], borrowed
- mass - rho Ly [kg/m^2]

  Level: intermediate

  Errors: PETSC_ERR_ORDER before SlipFaultSetUp()

.seealso: SlipFaultSetUp()
@*/
PetscErrorCode SlipFaultGetOperators(SlipFault fault, Mat *K, Mat *H, PetscReal *mass)
{
  PetscFunctionBegin;
  SlipFaultCheckSetUp(fault, 1);
  PetscCall(SlipElasticGetMatrices(fault->medium, K, NULL, H));
  if (mass) *mass = fault->operators.mass;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets T* = Ly sqrt(rho/G) [s], the time of a shear wave across the mobilised thickness. tstar: T* [s]. Errors:
   PETSC_ERR_ORDER before SlipFaultSetUp(). */
PetscErrorCode SlipFaultGetTimeScale(SlipFault fault, PetscReal *tstar)
{
  PetscFunctionBegin;
  SlipFaultCheckSetUp(fault, 1);
  PetscAssertPointer(tstar, 2);
  *tstar = fault->operators.tstar;
  PetscFunctionReturn(PETSC_SUCCESS);
}
