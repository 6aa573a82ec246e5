/* Prints the types of the matrices of a medium and the memory that they need. */
#include <slipstep/private/slipelastic.h>
#include <stdio.h>

/* Writes a number of bytes as "1.5 MB", with C's own printf because PETSc's %g differs from it. */
static void Size(PetscReal bytes, char text[32])
{
  static const char *const units[] = {"B", "kB", "MB", "GB", "TB"};
  int u = 0;

  for (; bytes >= 1000 && u < 4; u++) bytes /= 1000;
  (void)snprintf(text, 32, u ? "%.1f %s" : "%.0f %s", (double)bytes, units[u]);
}

/* Prints the memory of a matrix or preconditioner: most bytes on a rank, all bytes, and their share of a dense one. */
static PetscErrorCode ViewMemory(PetscInt rows, const char what[], PetscReal most, PetscReal all, PetscViewer viewer)
{
  const PetscReal N = (PetscReal)rows, dense = N * N * (PetscReal)sizeof(PetscScalar);
  char one[32], sum[32];

  PetscFunctionBegin;
  if (most < 0) {
    PetscCall(PetscViewerASCIIPrintf(viewer, "memory of %s: not known\n", what));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  Size(most, one);
  Size(all, sum);
  PetscCall(PetscViewerASCIIPrintf(
    viewer, "memory of %s: %.0f bytes (%s) at most on a rank, %s in all, %.2f %% of a dense matrix\n", what,
    (double)most, one, sum, (double)(100 * all / dense)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ViewMatrix(const char what[], const char name[], Mat A, PetscViewer viewer)
{
  const char *why;
  PetscReal most, all;
  SlipMatFn *view = NULL;
  PetscBool ours;
  MatType type;
  PetscInt rows;

  PetscFunctionBegin;
  PetscCall(MatGetType(A, &type));
  PetscCall(MatGetSize(A, &rows, NULL));
  PetscCall(MatSlipGetNotes(A, &why));
  PetscCall(PetscViewerASCIIPrintf(viewer, "%s: %s%s%s%s\n", what, type, why[0] ? " (" : "", why, why[0] ? ")" : ""));
  PetscCall(PetscViewerASCIIPushTab(viewer));
  /* MatView() would print two lines about the object first */
  PetscCall(
    PetscObjectTypeCompareAny((PetscObject)A, &ours, "sliphmat", "slipspectral", "sliplanczos", "slipstage", ""));
  if (ours) PetscCall(MatGetOperation(A, MATOP_VIEW, &view));
  if (view) PetscCall((*(PetscErrorCode(*)(Mat, PetscViewer))view)(A, viewer));
  PetscCall(MatSlipGetMemory(A, &most, &all));
  PetscCall(ViewMemory(rows, name, most, all, viewer));
  PetscCall(PetscViewerASCIIPopTab(viewer));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipElasticView - prints the types of the matrices of a medium and the memory that they need

  Collective; after SlipElasticSetUp()

  Input Parameters:
+ el     - the medium
. theta  - theta of a stage, for which its preconditioner is set up [s]
- viewer - of type ascii

  Level: developer

.seealso: SlipFaultView()
@*/
PetscErrorCode SlipElasticView(SlipElastic el, PetscReal theta, PetscViewer viewer)
{
  const MPI_Comm comm = PetscObjectComm((PetscObject)el);
  PetscErrorCode (*memory)(PC, PetscReal *);
  PetscReal resident, bytes = 0, largest, all, before;
  PetscLogDouble mine;
  PetscInt rows;
  char text[32];
  PC pc;

  PetscFunctionBegin;
  PetscValidHeaderSpecific(el, SLIP_ELASTIC_CLASSID, 1);
  /* The preconditioner of a run's stages for theta and all cells sliding. The stiffness and the viscosity store its
     costly parts, so that the run does not compute them again. */
  PetscCall(MatSlipStageGetTheta(el->B, &before));
  PetscCall(MatSlipStageSetTheta(el->B, theta));
  PetscCall(PCCreate(comm, &pc));
  PetscCall(PCSetType(pc, PCSLIPSTAGE));
  PetscCall(PCSetOperators(pc, el->B, el->B));
  PetscCall(PCSetUp(pc));
  if (before > 0) PetscCall(MatSlipStageSetTheta(el->B, before));
  PetscCall(ViewMatrix("stiffness K", "K", el->K, viewer));
  if (el->Kn) PetscCall(ViewMatrix("normal stress of slip Kn", "Kn, beside K", el->Kn, viewer));
  PetscCall(ViewMatrix("viscosity H", "H", el->H, viewer));
  PetscCall(ViewMatrix("stage operator B", "B, beside K and H", el->B, viewer));
  PetscCall(PetscObjectQueryFunction((PetscObject)pc, "PCSlipGetMemory_C", &memory));
  if (memory) PetscCall((*memory)(pc, &bytes));
  PetscCallMPI(MPI_Allreduce(&bytes, &largest, 1, MPIU_REAL, MPIU_MAX, comm));
  PetscCallMPI(MPI_Allreduce(&bytes, &all, 1, MPIU_REAL, MPIU_SUM, comm));
  PetscCall(PetscViewerASCIIPrintf(viewer, "preconditioner: " PCSLIPSTAGE " unless -pc_type names another\n"));
  PetscCall(PetscViewerASCIIPushTab(viewer));
  PetscCall(MatGetSize(el->K, &rows, NULL));
  PetscCall(ViewMemory(rows, "the preconditioner, beside what it shares with K", memory ? largest : -1, all, viewer));
  PetscCall(PetscViewerASCIIPopTab(viewer));
  PetscCall(PCDestroy(&pc));
  PetscCall(PetscMemoryGetCurrentUsage(&mine));
  resident = (PetscReal)mine;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &resident, 1, MPIU_REAL, MPIU_MAX, comm));
  Size(resident, text);
  PetscCall(PetscViewerASCIIPrintf(viewer, "memory of the process after set-up: %s at most on a rank\n", text));
  if (el->ops->view) PetscCall((*el->ops->view)(el, viewer));
  PetscFunctionReturn(PETSC_SUCCESS);
}
