/* Reports the stress at the start: the range of the effective normal stress, which decides a result and may differ from
   what the user intended, and where the shear stress exceeds the strength. Such an excess is an error, or with
   -fault_initial_unstable it is reported: in how many cells, where, by how much, and how many of them are outside of
   the largest patch. Slip should begin in a patch. Other cells that start above their strength slip at once as well,
   with a stress drop that nobody chose. */
#include <slipstep/private/slipfault.h>
#include <slipstep/rooms/slipsys.h>
#include <stdio.h>

/* On rank 0: the cells above their strength, by row, each with the number of a cell of its patch */
typedef struct {
  const SlipFaultMesh *mesh;
  PetscInt *patch; /* [N]; -1: the cell is at most at its strength */
} Patches;

static PetscInt Root(Patches *p, PetscInt row)
{
  while (p->patch[row] != row) row = p->patch[row] = p->patch[p->patch[row]];
  return row;
}

static void Join(Patches *p, PetscInt a, PetscInt b)
{
  p->patch[Root(p, a)] = Root(p, b);
}

/* Joins cells that share a corner. */
static PetscErrorCode JoinAtCorners(Patches *p)
{
  const SlipFaultMesh *mesh = p->mesh;
  const PetscInt sides = mesh->kind->sides;
  PetscInt *corners, *first; /* the first cell at a point */
  PetscReal *points;

  PetscFunctionBegin;
  PetscCall(
    PetscMalloc3(3 * (size_t)mesh->npoints, &points, (size_t)sides * (size_t)mesh->N, &corners, mesh->npoints, &first));
  PetscCall(mesh->kind->corners(mesh, points, corners));
  for (PetscInt k = 0; k < mesh->npoints; k++) first[k] = -1;
  for (PetscInt row = 0; row < mesh->N; row++) {
    if (p->patch[row] < 0) continue;
    for (PetscInt k = 0; k < sides; k++) {
      const PetscInt at = corners[sides * row + k];

      if (first[at] >= 0)
        Join(p, row, first[at]);
      else
        first[at] = row;
    }
  }
  PetscCall(PetscFree3(points, corners, first));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns whether two rectangles of any size touch: they are apart by no more than half of both along the strike and
   the dip of one, and off its plane by no more than half of the shorter sides. */
static PetscBool Touch(const SlipFaultCell *a, const SlipFaultCell *b)
{
  const PetscReal room = 1 + PETSC_SQRT_MACHINE_EPSILON;
  const PetscReal half[3] = {0.5 * (a->size[0] + b->size[0]), 0.5 * (a->size[1] + b->size[1]),
                             0.5 * (PetscMin(a->size[0], a->size[1]) + PetscMin(b->size[0], b->size[1]))};

  for (int k = 0; k < 3; k++) {
    PetscReal apart = 0;

    for (int i = 0; i < 3; i++) apart += (b->centre[i] - a->centre[i]) * a->direction[k][i];
    if (PetscAbsReal(apart) > room * half[k]) return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

/* Joins touching rectangles of a list, which need not share corners: compares each with the near ones before it in the
   order of x. */
static PetscErrorCode JoinWhereTheyTouch(Patches *p)
{
  const SlipFaultMesh *mesh = p->mesh;
  SlipFaultCell *cell;
  PetscReal *x, reach = 0;
  PetscInt *order, n = 0;

  PetscFunctionBegin;
  PetscCall(PetscMalloc3(mesh->N, &cell, mesh->N, &x, mesh->N, &order));
  for (PetscInt row = 0; row < mesh->N; row++) {
    mesh->kind->cell(mesh, row, &cell[row]);
    if (p->patch[row] < 0) continue;
    x[n] = cell[row].centre[0];
    order[n++] = row;
    reach = PetscMax(reach, hypot(cell[row].size[0], cell[row].size[1]));
  }
  PetscCall(PetscSortRealWithArrayInt(n, x, order));
  for (PetscInt i = 0; i < n; i++)
    for (PetscInt j = i - 1; j >= 0 && x[i] - x[j] <= reach; j--)
      if (Touch(&cell[order[i]], &cell[order[j]])) Join(p, order[i], order[j]);
  PetscCall(PetscFree3(cell, x, order));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* On rank 0: counts the cells with above [N] > 0, by row, that are outside of the largest patch. */
static PetscErrorCode OutsideOfPatch(const SlipFaultMesh *mesh, const PetscReal above[], PetscInt *outside)
{
  Patches p = {.mesh = mesh};
  PetscInt *size, largest = 0;

  PetscFunctionBegin;
  *outside = 0;
  PetscCall(PetscMalloc1(mesh->N, &p.patch));
  PetscCall(PetscCalloc1(mesh->N, &size));
  for (PetscInt row = 0; row < mesh->N; row++) p.patch[row] = above[row] > 0 ? row : -1;
  if (mesh->npoints < mesh->kind->sides * mesh->N || mesh->kind->sides == 3)
    PetscCall(JoinAtCorners(&p));
  else
    PetscCall(JoinWhereTheyTouch(&p));
  for (PetscInt row = 0; row < mesh->N; row++) {
    if (p.patch[row] < 0) continue;
    (*outside)++;
    size[Root(&p, row)]++;
  }
  for (PetscInt row = 0; row < mesh->N; row++) largest = PetscMax(largest, size[row]);
  *outside -= largest;
  PetscCall(PetscFree(size));
  PetscCall(PetscFree(p.patch));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prints where the stress exceeds the strength, as text describes. Collective. */
static PetscErrorCode SayIt(SlipFault fault, const PetscReal above[], const char text[])
{
  PetscReal *all;
  PetscInt outside = 0;
  PetscMPIInt rank;
  PetscErrorCode ierr = PETSC_SUCCESS;
  PetscBool help;

  PetscFunctionBegin;
  PetscCall(PetscOptionsHasHelp(NULL, &help));
  if (help || !fault->options.reports || fault->options.text[FAULT_RESTART][0]) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCallMPI(MPI_Comm_rank(fault->comm, &rank));
  PetscCall(PetscMalloc1(rank ? 0 : fault->mesh.N, &all));
  PetscCall(SlipFaultGatherFirst(&fault->mesh, above, all));
  if (!rank) ierr = OutsideOfPatch(&fault->mesh, all, &outside);
  PetscCall(SlipErrorBcast(fault->comm, ierr));
  PetscCall(PetscFree(all));
  if (rank) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscPrintf(PETSC_COMM_SELF,
                        "%-24s the stress exceeds the strength %s; %" PetscInt_FMT
                        " of them (%.3g %% of all cells) are outside of the largest patch\n",
                        "start:", text, outside, 100 * (double)outside / (double)fault->mesh.N));
  if (outside)
    PetscCall(SlipWarning(
      "%" PetscInt_FMT
      " cells (%.3g %% of all) outside of the patch where most of them begin to slip start above their "
      "strength, too: -%sfault_initial_unstable lets all of these slip at once. Lower -%sfault_initial_traction there, "
      "unless this is meant",
      outside, 100 * (double)outside / (double)fault->mesh.N, SlipFaultPrefix(fault), SlipFaultPrefix(fault)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Refuses cells that start above their strength, unless an option allows them. Collective. */
PetscErrorCode SlipFaultCheckTraction(SlipFault fault)
{
  const PetscReal tiny = 10 * PETSC_MACHINE_EPSILON;
  const SlipFaultLoads *loads = &fault->loads;
  SlipFrictionCells friction;
  PetscReal *shear;
  PetscReal box[4] = {-PETSC_MAX_REAL, -PETSC_MAX_REAL, -PETSC_MAX_REAL, -PETSC_MAX_REAL}, most = 0, *above;
  const char *prefix = SlipFaultPrefix(fault);
  PetscInt count = 0;
  char text[256];

  PetscFunctionBegin;
  PetscCall(SlipFaultGetFriction(fault, 0, &friction));
  PetscCall(PetscCalloc1(PetscMax(fault->mesh.n, 1), &above));
  PetscCall(PetscCalloc1(fault->layout.components * fault->mesh.n + 1, &shear));
  SlipLoadsAddTerms(loads, 0, PETSC_FALSE, NULL, shear, NULL);
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    PetscReal *x = shear + fault->layout.components * i, load = PetscAbsReal(loads->traction[i]), mu, ds, dv;
    SlipFaultCell cell;

    if (loads->nterms) {
      for (PetscInt k = 0; k < fault->layout.components; k++) x[k] += loads->traction[i] * SlipFaultAlong(fault, i)[k];
      load = SlipFaultLength(fault, x);
    }
    SlipFrictionEvaluate(&friction, i, NULL, 0, &mu, &ds, &dv);
    if (load <= mu * friction.stress[i] * (1 + tiny)) continue;
    count++;
    above[i] = load - mu * friction.stress[i];
    fault->mesh.kind->cell(&fault->mesh, SlipFaultMeshRow(&fault->mesh, i), &cell);
    box[0] = PetscMax(box[0], -cell.centre[0]);
    box[1] = PetscMax(box[1], cell.centre[0]);
    box[2] = PetscMax(box[2], -cell.centre[2]);
    box[3] = PetscMax(box[3], cell.centre[2]);
    most = PetscMax(most, above[i]);
  }
  PetscCall(PetscFree(shear));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &count, 1, MPIU_INT, MPI_SUM, fault->comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, box, 4, MPIU_REAL, MPIU_MAX, fault->comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPIU_REAL, MPIU_MAX, fault->comm));
  (void)snprintf(text, sizeof(text),
                 "in %lld of %lld cells, at x %.6g to %.6g m and z %.6g to %.6g m, by up to %.6g Pa", (long long)count,
                 (long long)fault->mesh.N, (double)-box[0], (double)box[1], (double)-box[2], (double)box[3],
                 (double)most);
  if (count && fault->options.initial_unstable) PetscCall(SayIt(fault, above, text));
  PetscCall(PetscFree(above));
  PetscCheck(!count || fault->options.initial_unstable, fault->comm, PETSC_ERR_ARG_OUTOFRANGE,
             "-%sfault_initial traction exceeds the strength %s: expected at most the strength, or "
             "-%sfault_initial_unstable when slip is to begin there at once",
             prefix, text, prefix);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prints a line before the run with the effective normal stress at the start. Collective. */
PetscErrorCode SlipFaultStressPrint(SlipFault fault)
{
  const SlipFaultLoad *load;
  PetscReal range[2] = {-PETSC_MAX_REAL, -PETSC_MAX_REAL}; /* minus the least, the largest */
  char text[96];

  PetscFunctionBegin;
  if (!fault->options.progress) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipFaultGetLoad(fault, 0, &load));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    range[0] = PetscMax(range[0], -load->stress[i]);
    range[1] = PetscMax(range[1], load->stress[i]);
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, range, 2, MPIU_REAL, MPIU_MAX, fault->comm));
  if (-range[0] == range[1])
    (void)snprintf(text, sizeof(text), "%.6g Pa", (double)range[1]);
  else
    (void)snprintf(text, sizeof(text), "%.6g to %.6g Pa", -(double)range[0], (double)range[1]);
  PetscCall(PetscPrintf(fault->comm, "%-24s %s, effective, at the start\n", "normal stress:", text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Warns that radiation limits explicit steps even in the slowest slip. */
PetscErrorCode SlipFaultWarnOfSlowSlip(SlipFault fault, TS ts)
{
  PetscMPIInt rank;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(fault->comm, &rank));
  if (!fault->problem.steps.any_integrator || fault->friction.law->always_slides || rank || !fault->options.reports ||
      !(fault->kind.sequence || fault->loads.pressed))
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipWarning("-ts_type %s skips only rest: while any cell slips, however slowly, its steps are seconds to "
                        "minutes. For slip of days and years expected bathe",
                        ((PetscObject)ts)->type_name));
  PetscFunctionReturn(PETSC_SUCCESS);
}
