/* Computes normal stress that changes with slip: sigma = max(sigma0 - p + Kn (u - u0), 0), and 0 for open cells;
   without Kn only the pressure in shear zones changes it (pressurisation.c). u is
   the displacement relative to the far field, which loading by backslip leaves as it is. u0 is that of the start, which
   is not 0 where elastic stress is critical there: sigma0 is the normal stress before any slip. */
#include <slipstep/private/slipfault.h>
#include <slipstep/rooms/slipelasticity.h>
#include <slipstep/private/slipsys.h>

/* Finds whether every rake is the same multiple of 180 degrees, so that the vertical kernel holds. */
static PetscErrorCode AlongStrike(SlipFault fault, PetscBool *along)
{
  const PetscReal *rake = fault->fields.cell[FIELD_RAKE];
  PetscReal bounds[2] = {PETSC_MIN_REAL, PETSC_MIN_REAL}; /* largest and minus least */

  PetscFunctionBegin;
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    bounds[0] = PetscMax(bounds[0], rake[i]);
    bounds[1] = PetscMax(bounds[1], -rake[i]);
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, bounds, 2, MPIU_REAL, MPIU_MAX, fault->comm));
  *along = bounds[0] == -bounds[1] && bounds[0] == 180 * PetscFloorReal(bounds[0] / 180) ? PETSC_TRUE : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Chooses the kernel, and whether normal stress follows slip; after the fields are set. */
PetscErrorCode SlipFaultChooseCoupling(SlipFault fault)
{
  const char *file = fault->options.text[FAULT_STIFFNESS_FILE];
  const PetscBool vectors = fault->layout.components > 1 ? PETSC_TRUE : PETSC_FALSE, opens = SlipFaultOpens(fault);
  PetscBool along, yes, no;

  PetscFunctionBegin;
  PetscCall(PetscStrcmp(fault->options.text[FAULT_NORMAL_COUPLING], "yes", &yes));
  PetscCall(PetscStrcmp(fault->options.text[FAULT_NORMAL_COUPLING], "no", &no));
  if (vectors) /* by symmetry, slip of any direction in a vertical plane does not change its normal stress */
    along = fault->mesh.planes == 1 ? PETSC_TRUE : PETSC_FALSE;
  else
    PetscCall(AlongStrike(fault, &along));
  fault->kind.oblique = fault->mesh.dips || !along ? PETSC_TRUE : PETSC_FALSE;
  /* -fault_medium waves has one plane without a free surface, whose normal stress does not change by symmetry either */
  fault->kind.coupled =
    !file[0] && !no && (yes || opens || (fault->kind.oblique && !fault->kind.waves)) ? PETSC_TRUE : PETSC_FALSE;
  fault->kind.dipping =
    !file[0] && (yes || vectors || fault->kind.oblique || fault->mesh.cells.vertices) ? PETSC_TRUE : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets up the vectors of the coupling; after the operators and the critical state. */
PetscErrorCode SlipFaultCouplingSetUp(SlipFault fault)
{
  SlipFaultCoupling *c = &fault->coupling;

  PetscFunctionBegin;
  if (SlipFaultNormalFollows(fault)) PetscCall(PetscMalloc1(PetscMax(fault->mesh.n, 1), &c->stress));
  if (!fault->kind.coupled) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecDuplicate(fault->critical.uc, &c->u));
  PetscCall(SlipFaultCellVector(fault, &c->rise));
  PetscCall(SlipFaultCellVector(fault, &c->drive));
  PetscCall(VecDuplicate(fault->cells, &c->factor));
  PetscCall(SlipElasticApply(fault->medium, fault->operators.vinf, NULL, c->drive));
  if (SlipFaultOpens(fault))
    PetscCall(PetscMalloc2(PetscMax(fault->mesh.n, 1), &c->one, PetscMax(fault->mesh.n, 1), &c->pull));
  for (PetscInt i = 0; i < fault->mesh.n && c->one; i++) c->one[i] = 1;
  if (fault->critical.start_share == 0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipFaultCellVector(fault, &c->start));
  PetscCall(VecCopy(fault->critical.uc, c->u));
  PetscCall(VecScale(c->u, fault->critical.start_share));
  PetscCall(SlipElasticApply(fault->medium, c->u, NULL, c->start));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultCouplingDestroy(SlipFault fault)
{
  SlipFaultCoupling *c = &fault->coupling;

  PetscFunctionBegin;
  PetscCall(VecDestroy(&c->u));
  PetscCall(VecDestroy(&c->rise));
  PetscCall(VecDestroy(&c->drive));
  PetscCall(VecDestroy(&c->factor));
  PetscCall(VecDestroy(&c->start));
  PetscCall(PetscFree(c->stress));
  PetscCall(PetscFree2(c->one, c->pull));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets the friction of a stage with u = u0 + theta x at its end, under the normal stress there. Collective. */
PetscErrorCode SlipFaultCoupledBound(SlipFault fault, Vec x, SlipFrictionCells *friction)
{
  SlipFaultCoupling *c = &fault->coupling;

  PetscFunctionBegin;
  if (fault->kind.coupled) {
    PetscCall(VecWAXPY(c->u, fault->stage.theta, x, fault->stage.u0));
    PetscCall(SlipElasticForce(fault->medium, fault->stage.time, c->u, NULL, NULL, c->rise));
  }
  c->balanced = PETSC_FALSE;
  PetscCall(SlipFaultCoupledFriction(fault, fault->stage.time, 0, friction));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes c->stress from Kn u in c->rise at t, after a further rest of the length rest. It replaces that of the cached
   state. Where there are shear zones it is the stress without their pressure, and may be negative. Collective. */
PetscErrorCode SlipFaultCoupledFriction(SlipFault fault, PetscReal t, PetscReal rest, SlipFrictionCells *friction)
{
  SlipFaultCoupling *c = &fault->coupling;
  const SlipFaultLoad *load;
  const PetscReal *rise, *drive, *u, *start = NULL;
  const SlipArrays arrays[] = {
    {c->rise, .read = &rise}, {c->drive, .read = &drive}, {c->u, .read = &u}, {c->start, .read = &start}};
  const int n = c->start ? 4 : 3;

  PetscFunctionBegin;
  PetscCall(SlipFaultGetLoad(fault, t, &load));
  if (!fault->kind.coupled) {
    PetscCall(PetscArraycpy(c->stress, load->bare, fault->mesh.n));
    c->moment = (SlipFaultMoment){0};
    *friction = SlipFaultCellFriction(fault, c->stress);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(SlipArraysGet(n, arrays));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    const PetscReal pressed = load->bare[i] + rise[i] - (start ? start[i] : 0) - rest * drive[i];

    c->stress[i] = fault->zone.presses ? pressed : PetscMax(pressed, 0);
    if (!c->pull) continue;
    c->pull[i] = -pressed;
    if (u[3 * i + 2] > 0) c->stress[i] = 0;
  }
  PetscCall(SlipArraysRestore(n, arrays));
  c->moment = (SlipFaultMoment){0};
  *friction = SlipFaultCellFriction(fault, c->stress);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets the friction of the cells of this process in a state, whose slip may have changed normal stress. t: time of the
   state [s]; w: state, of SlipFaultCreateState(); friction: as from SlipFaultGetFriction(), with the normal stress
   sigma0 - p + Kn (u - u0), u0: that of the start; valid until the next call for another state or time. Where slip does
   not change normal stress, it is that of SlipFaultGetFriction(). Else it costs a product with Kn, unless the state is
   that of the last call, or of the last right-hand side. */
PetscErrorCode SlipFaultGetFrictionOf(SlipFault fault, PetscReal t, Vec w, SlipFrictionCells *friction)
{
  SlipFaultCoupling *c = &fault->coupling;
  SlipFaultMoment now;
  PetscBool same;

  PetscFunctionBegin;
  if (!SlipFaultNormalFollows(fault)) {
    PetscCall(SlipFaultGetFriction(fault, t, friction));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(SlipFaultStateUnchanged(fault, t, w, &c->moment, &now, &same));
  if (same) {
    *friction = SlipFaultCellFriction(fault, c->stress);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (fault->kind.coupled) {
    PetscCall(SlipFaultGetDisplacement(fault, w, c->u));
    if (c->balanced) PetscCall(SlipFaultDisplacementUnchanged(fault, t, c->u, &c->balanced));
    if (!c->balanced) PetscCall(SlipElasticForce(fault->medium, t, c->u, NULL, NULL, c->rise));
  }
  PetscCall(SlipFaultCoupledFriction(fault, t, 0, friction));
  if (fault->zone.presses) PetscCall(SlipFaultZoneOfState(fault, t, w, c->stress));
  c->moment = now;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- results and messages ---- */

/* Least normal stress so far [Pa], largest opening [m], and the cells that had no normal stress or were open */
typedef struct {
  PetscReal least, widest;
  Vec bare; /* 1 in those cells */
  PetscInt cells;
} Clamping;

static PetscErrorCode CouplingCreate(SlipFault fault, TS ts, PetscBool *wanted, void **ctx)
{
  Clamping *c;

  PetscFunctionBegin;
  (void)ts;
  *wanted = fault->kind.coupled;
  if (!*wanted) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscNew(&c));
  *ctx = c;
  c->least = PETSC_MAX_REAL;
  PetscCall(SlipFaultCellVector(fault, &c->bare));
  PetscCall(VecZeroEntries(c->bare));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Warns once of the cells that have lost their normal stress in this step, and names the lowest one. */
static PetscErrorCode SayBare(SlipFault fault, PetscReal time, PetscInt row, PetscInt cells)
{
  PetscMPIInt rank;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(fault->comm, &rank));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &row, 1, MPIU_INT, MPI_MIN, fault->comm));
  if (SlipFaultOpens(fault)) {
    PetscCall(PetscPrintf(fault->comm,
                          "At %.6g s %" PetscInt_FMT " cells open, first cell %" PetscInt_FMT " (printed once)\n",
                          (double)time, cells, row));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (!rank)
    PetscCall(SlipWarning("at %.6g s slip has taken the normal stress of %" PetscInt_FMT
                          " cells, first of cell %" PetscInt_FMT
                          ": they have no strength while they have none (printed once; the summary counts)",
                          (double)time, cells, row));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode CouplingStep(SlipFault fault, TS ts, PetscInt step, PetscReal time, Vec w, void *ctx)
{
  Clamping *c = (Clamping *)ctx;
  SlipFrictionCells friction;
  PetscInt row = PETSC_MAX_INT, cells = 0, before = c->cells, more;
  PetscReal least;
  const PetscReal *a;
  PetscReal *bare;

  PetscFunctionBegin;
  (void)ts;
  (void)step;
  PetscCall((*fault->cell_ops->bare)(fault, time, w, c->bare, &more, &least));
  c->least = PetscMin(c->least, least);
  if (!more) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipFaultGetFrictionOf(fault, time, w, &friction));
  PetscCall(VecGetArrayRead(w, &a));
  PetscCall(VecGetArray(c->bare, &bare));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    const PetscReal open = SlipFaultAcross(fault, a + SlipFaultDisplacementAt(fault, i));

    c->least = PetscMin(c->least, friction.stress[i]);
    c->widest = PetscMax(c->widest, open);
    if (friction.stress[i] > 0 || (SlipFaultOpens(fault) && open == 0)) continue;
    row = PetscMin(row, SlipFaultMeshRow(&fault->mesh, i));
    if (bare[i] == 0) cells++;
    bare[i] = 1;
  }
  PetscCall(VecRestoreArray(c->bare, &bare));
  PetscCall(VecRestoreArrayRead(w, &a));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &cells, 1, MPIU_INT, MPI_SUM, fault->comm));
  c->cells += cells;
  if (!before && c->cells) PetscCall(SayBare(fault, time, row, c->cells));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode CouplingVisit(SlipFault fault, SlipState state, void *ctx)
{
  Clamping *c = (Clamping *)ctx;
  PetscBool has;

  PetscFunctionBegin;
  PetscCall(SlipStateHas(state, "coupling", &has));
  if (!has) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipStateGroup(state, "coupling"));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &c->least, 1, MPIU_REAL, MPIU_MIN, fault->comm));
  PetscCall(SlipStateReal(state, "least_normal_stress", 1, &c->least));
  PetscCall(SlipStateInt(state, "cells_without_stress", 1, &c->cells));
  if (SlipFaultOpens(fault)) {
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &c->widest, 1, MPIU_REAL, MPIU_MAX, fault->comm));
    PetscCall(SlipStateReal(state, "largest_opening", 1, &c->widest));
  }
  PetscCall(SlipStateVec(state, "without_stress", c->bare));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode CouplingFinish(SlipFault fault, TS ts, SlipOutput output, void *ctx)
{
  Clamping *c = (Clamping *)ctx;
  PetscReal least;

  PetscFunctionBegin;
  (void)ts;
  PetscCallMPI(MPI_Allreduce(&c->least, &least, 1, MPIU_REAL, MPIU_MIN, fault->comm));
  if (least == PETSC_MAX_REAL) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipOutputAddResult(output, "least_normal_stress", "least normal stress",
                                "Pa, effective, as slip has changed it", least));
  PetscCall(SlipOutputAddResult(output, "cells_without_stress",
                                SlipFaultOpens(fault) ? "cells that opened" : "cells without it", "at some time",
                                (PetscReal)c->cells));
  if (!SlipFaultOpens(fault)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &c->widest, 1, MPIU_REAL, MPIU_MAX, fault->comm));
  PetscCall(SlipOutputAddResult(output, "largest_opening", "largest opening", "m", c->widest));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode CouplingDestroy(void **ctx)
{
  Clamping *c = (Clamping *)*ctx;

  PetscFunctionBegin;
  PetscCall(VecDestroy(&c->bare));
  PetscCall(PetscFree(*ctx));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const SlipFaultObserver SlipFaultCouplingObserver = {.name = "coupling",
                                                     .create = CouplingCreate,
                                                     .step = CouplingStep,
                                                     .visit = CouplingVisit,
                                                     .finish = CouplingFinish,
                                                     .destroy = CouplingDestroy};
