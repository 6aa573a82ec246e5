/* Prints for -fault_view a fault's parameters, its operators and their memory, and the times of the parts of a run. */
#include <slipstep/private/sliprun.h>
#include <stdio.h>

static PetscErrorCode ViewOperators(SlipFault fault, PetscViewer viewer)
{
  PetscInt least = fault->mesh.n, most = fault->mesh.n;
  PetscMPIInt size;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_size(fault->comm, &size));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &least, 1, MPIU_INT, MPI_MIN, fault->comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPIU_INT, MPI_MAX, fault->comm));
  PetscCall(PetscViewerASCIIPrintf(
    viewer, "cells: %" PetscInt_FMT " on %d ranks, %" PetscInt_FMT " to %" PetscInt_FMT " on each\n", fault->mesh.N,
    (int)size, least, most));
  PetscCall(SlipElasticView(fault->medium, fault->operators.tstar, viewer));
  PetscCall(SlipFaultDeviceView(fault, viewer));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prints the values of a parameter in use: least, mean (by area) and largest of all cells that have one, and their
   origin unless it is the scalar of this name. */
static PetscErrorCode ViewField(SlipFault fault, const char name[], const char unit[], const PetscReal x[],
                                const char from[], PetscViewer viewer)
{
  PetscReal range[2] = {PETSC_MAX_REAL, PETSC_MAX_REAL}, sums[2] = {0, 0}; /* least, and least of the negative */
  char text[128];

  PetscFunctionBegin;
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    if (PetscIsNanReal(x[i])) continue;
    range[0] = PetscMin(range[0], x[i]);
    range[1] = PetscMin(range[1], -x[i]);
    sums[0] += fault->mesh.weight[i] * x[i];
    sums[1] += fault->mesh.weight[i];
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, range, 2, MPIU_REAL, MPIU_MIN, fault->comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sums, 2, MPIU_REAL, MPIU_SUM, fault->comm));
  if (range[0] == PETSC_MAX_REAL)
    (void)snprintf(text, sizeof(text), "none");
  else if (range[0] == -range[1])
    (void)snprintf(text, sizeof(text), "%g", (double)range[0]);
  else
    (void)snprintf(text, sizeof(text), "least %g, mean %g, largest %g", (double)range[0], (double)(sums[0] / sums[1]),
                   (double)-range[1]);
  PetscCall(PetscViewerASCIIPrintf(viewer, "%s: %s %s%s%s%s\n", name, text, unit, from ? " (from " : "",
                                   from ? from : "", from ? ")" : ""));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prints at the end of a run with -fault_view the processor time of this process in each share of the work, its cost by
   counts of work, and in detail these counts. Collective. */
PetscErrorCode SlipFaultViewTimes(SlipFault fault)
{
  const SlipWorkTotals now = SlipWorkGet(), *before = &fault->run->work;
  PetscViewer viewer = fault->options.viewer;
  PetscReal seconds = 0, cost = 0;

  PetscFunctionBegin;
  if (!viewer) PetscFunctionReturn(PETSC_SUCCESS);
  for (int i = 0; i < SLIP_SHARES; i++) {
    seconds += now.seconds[i] - before->seconds[i];
    cost += now.cost[i] - before->cost[i];
  }
  PetscCall(PetscViewerASCIIPrintf(viewer, "where the time of the run went: processor time [s], and cost [s]\n"));
  for (int i = 0; i < SLIP_SHARES; i++) {
    const PetscReal s = now.seconds[i] - before->seconds[i], c = now.cost[i] - before->cost[i];

    PetscCall(PetscViewerASCIIPrintf(viewer, "  %-14s %11.4f %6.2f %% %11.4f %6.2f %%\n", SlipShareNames[i], (double)s,
                                     (double)(100 * s / seconds), (double)c, (double)(100 * c / cost)));
  }
  PetscCall(PetscViewerASCIIPrintf(viewer, "  %-14s %11.4f          %11.4f\n", "all", (double)seconds, (double)cost));
  for (int i = 0; i < SLIP_WORKS && fault->options.format == PETSC_VIEWER_ASCII_INFO_DETAIL; i++) {
    PetscCall(PetscViewerASCIIPrintf(viewer, "  work %s:", SlipWorkNames[i]));
    for (int k = 0; k < SLIP_SHARES; k++)
      PetscCall(PetscViewerASCIIPrintf(viewer, " %.17g", (double)(now.units[i][k] - before->units[i][k])));
    PetscCall(PetscViewerASCIIPrintf(viewer, "\n"));
  }
  PetscCall(PetscViewerFlush(viewer));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipFaultView - prints the fault's parameters with their units; after SlipFaultSetUp() also its operators, and of each
  field the least, mean and largest value in use

  Collective.

  Input Parameters:
+ fault  - the fault
- viewer - an ASCII viewer, NULL for standard output

  Notes:
  After SlipFaultSetUp() it prints also whether there is inertia, and how many cells a cohesive zone has.

  For K, H, the stage operator B and its preconditioner it prints the type and why it was chosen, the memory on the rank
  with the most and in all, the compression against a dense matrix, and ranks of low-rank blocks.

  Level: intermediate

  Errors: PETSC_ERR_SUP for a viewer that writes no text

.seealso: SlipFaultSetFromOptions(), MatSlipGetMemory()
@*/
PetscErrorCode SlipFaultView(SlipFault fault, PetscViewer viewer)
{
  const SlipParameter *p;
  PetscBool ascii;
  char number[32], why[96];
  PetscReal value;

  PetscFunctionBegin;
  PetscValidHeaderSpecific(fault, SLIP_FAULT_CLASSID, 1);
  if (!viewer) PetscCall(PetscViewerASCIIGetStdout(fault->comm, &viewer));
  PetscValidHeaderSpecific(viewer, PETSC_VIEWER_CLASSID, 2);
  PetscCheckSameComm(fault, 1, viewer, 2);
  PetscCall(PetscObjectTypeCompare((PetscObject)viewer, PETSCVIEWERASCII, &ascii));
  PetscCheck(ascii, fault->comm, PETSC_ERR_SUP, "-%sfault_view writes text: expected an ASCII viewer",
             SlipFaultPrefix(fault));
  PetscCall(PetscObjectPrintClassNamePrefixType((PetscObject)fault, viewer));
  PetscCall(PetscViewerASCIIPushTab(viewer));
  for (PetscInt i = 0; (p = SlipFaultRealRow(i)); i++) {
    const PetscInt field = SlipFaultFieldOf(i);

    if (fault->setup && field >= 0 && !SlipFaultHasField(fault, field)) continue;
    if (fault->setup && field >= 0) {
      PetscCall(ViewField(fault, p->name, p->unit, fault->fields.cell[field], fault->fields.source[field], viewer));
      continue;
    }
    if (fault->setup && i == FAULT_NORMAL_STRESS_GRADIENT) continue; /* part of the normal stress, or replaced */
    PetscCall(SlipFaultGetReal(fault, p->name, &value));
    (void)snprintf(number, sizeof(number), "%g", (double)value);
    why[0] = '\0';
    if (i == FAULT_HMAT_TOLERANCE) PetscCall(SlipFaultHmatTolerance(fault, &value, why, sizeof(why)));
    PetscCall(PetscViewerASCIIPrintf(viewer, "%s: %s %s%s%s%s\n", p->name, number, p->unit, why[0] ? "(" : "", why,
                                     why[0] ? ")" : ""));
  }
  if (fault->setup && fault->fields.tendency)
    PetscCall(ViewField(fault, "slip_tendency", "", fault->fields.tendency, fault->fields.regional, viewer));
  for (PetscInt i = 0; i < FAULT_NUM_STRINGS; i++)
    PetscCall(PetscViewerASCIIPrintf(viewer, "%s: %s\n", SlipFaultStrings[i].name,
                                     fault->options.text[i][0] ? SlipFaultGetText(fault, i) : "(none)"));
  if (fault->setup) {
    PetscCall(PetscViewerASCIIPrintf(viewer, "time scale T*: %g s\n", (double)fault->operators.tstar));
    PetscCall(PetscViewerASCIIPrintf(viewer, "stiffness was multiplied by %.6g\n", (double)fault->operators.scaling));
    PetscCall(PetscViewerASCIIPrintf(viewer, "inertia: %s\n", fault->kind.inertia ? "yes" : "no"));
    PetscCall(PetscViewerASCIIPrintf(viewer, "friction: %s\n", fault->friction.law->formula));
    if (fault->resolution.known) {
      char text[256];

      PetscCall(SlipFaultResolutionText(fault, text, sizeof(text)));
      PetscCall(PetscViewerASCIIPrintf(viewer, "resolution: %s\n", text));
    }
    PetscCall(SlipLoadsTermsView(&fault->loads, viewer));
    PetscCall(SlipFaultWellsView(fault, viewer));
    PetscCall(SlipFaultZoneView(fault, viewer));
    PetscCall(SlipFaultFluidView(fault, viewer));
    PetscCall(ViewOperators(fault, viewer));
  }
  PetscCall(PetscViewerASCIIPopTab(viewer));
  PetscFunctionReturn(PETSC_SUCCESS);
}
