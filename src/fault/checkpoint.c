/* Checkpoints of a fault's run: which run a file is of, and all that this one remembers. */
#include <slipstep/private/slipfaultobservers.h>
#include <slipstep/private/slipadapt.h>
#include <slipstep/private/slipts.h>
#include <slipstep/private/slipcheckpoint.h>
#include <inttypes.h>
#include <stdio.h>
#include <string.h>

/* Numbers that a solver has computed, such as the critical energy, are the same to this relative difference; on other
   numbers of ranks they differ by rounding. */
#define CHECKPOINT_SAME 1e-6

/* ---- is it the same run? ---- */

typedef struct {
  SlipState s;
  char text[1024]; /* what differs */
} Differences;

static PetscErrorCode Differ(Differences *d, const char format[], const char name[], const char now[],
                             const char then[])
{
  char one[512];

  PetscFunctionBegin;
  (void)snprintf(one, sizeof(one), format, name, now, then);
  PetscCall(PetscStrlcat(d->text, d->text[0] ? "; " : "", sizeof(d->text)));
  PetscCall(PetscStrlcat(d->text, one, sizeof(d->text)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The shortest of these that tells two numbers apart */
static void Numbers(PetscReal x, PetscReal y, const char unit[], char a[64], char b[64])
{
  for (int digits = 6; digits <= 17; digits++) {
    (void)snprintf(a, 64, "%.*g%s%s", digits, (double)x, unit[0] ? " " : "", unit);
    (void)snprintf(b, 64, "%.*g%s%s", digits, (double)y, unit[0] ? " " : "", unit);
    if (strcmp(a, b)) return;
  }
}

/* tolerance: relative, of numbers that were computed */
static PetscErrorCode CompareReal(Differences *d, const char name[], PetscReal now, const char unit[],
                                  PetscReal tolerance)
{
  PetscReal then = now;
  char a[64], b[64];

  PetscFunctionBegin;
  PetscCall(SlipStateReal(d->s, name, 1, &then));
  if (PetscAbsReal(then - now) <= tolerance * PetscAbsReal(now)) PetscFunctionReturn(PETSC_SUCCESS);
  Numbers(now, then, unit, a, b);
  PetscCall(Differ(d, "%s is %s, was %s", name, a, b));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode CompareText(Differences *d, const char name[], const char now[])
{
  char then[PETSC_MAX_PATH_LEN] = "";
  PetscBool same;

  PetscFunctionBegin;
  PetscCall(PetscStrncpy(then, now, sizeof(then)));
  PetscCall(SlipStateString(d->s, name, then, sizeof(then)));
  PetscCall(PetscStrcmp(now, then, &same));
  if (!same) PetscCall(Differ(d, "%s is %s, was %s", name, now, then));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Numbers of the local cells, told apart by a hash that does not depend on who holds them, and described by the least,
   the mean and the largest of them. */
static PetscErrorCode CompareCells(Differences *d, SlipFault fault, const char name[], const char unit[],
                                   const PetscReal x[])
{
  PetscReal range[2] = {PETSC_MAX_REAL, PETSC_MAX_REAL}, sum = 0;
  uint64_t hash = 0;
  char values[96], digest[128], then[128];

  PetscFunctionBegin;
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    const PetscReal entry[] = {(PetscReal)SlipFaultMeshRow(&fault->mesh, i), x[i]};

    hash += SlipHashReals(SLIP_HASH_START, entry, 2);
    range[0] = PetscMin(range[0], x[i]);
    range[1] = PetscMin(range[1], -x[i]);
    sum += x[i];
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &hash, 1, MPI_UINT64_T, MPI_SUM, fault->comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, range, 2, MPIU_REAL, MPIU_MIN, fault->comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPIU_REAL, MPIU_SUM, fault->comm));
  if (range[0] == -range[1])
    (void)snprintf(values, sizeof(values), "%.9g", (double)range[0]);
  else
    (void)snprintf(values, sizeof(values), "%.9g to %.9g, in the mean %.9g", (double)range[0], -(double)range[1],
                   (double)(sum / (PetscReal)fault->mesh.N));
  (void)snprintf(digest, sizeof(digest), "%016" PRIx64 " %s%s%s", hash, values, unit[0] ? " " : "", unit);
  PetscCall(PetscStrncpy(then, digest, sizeof(then)));
  PetscCall(SlipStateString(d->s, name, then, sizeof(then)));
  if (!strncmp(digest, then, 16)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Differ(d, "%s is %s, was %s", name, digest + 17, strlen(then) > 17 ? then + 17 : ""));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The type without what PETSc puts before it on one process or several */
static PetscErrorCode CompareType(Differences *d, const char name[], Mat A)
{
  MatType type;

  PetscFunctionBegin;
  PetscCall(MatGetType(A, &type));
  if (!strncmp(type, "seq", 3) || !strncmp(type, "mpi", 3)) type += 3;
  PetscCall(CompareText(d, name, type));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Parameters that say how a run is computed or written, not of what: they may change. Those that are fields are compared
   cell by cell. */
static PetscBool MayChange(PetscInt id)
{
  static const SlipFaultRealId free_ones[] = {FAULT_OUTPUT_INTERVAL,      FAULT_OUTPUT_SLIP_INTERVAL,
                                              FAULT_OUTPUT_TIME_INTERVAL, FAULT_OUTPUT_RATE_CHANGE,
                                              FAULT_OUTPUT_SIZE,          FAULT_OUTPUT_COMPRESSION,
                                              FAULT_KRYLOV_TOLERANCE,     FAULT_RATE_TOLERANCE,
                                              FAULT_CHECKPOINT_INTERVAL,  FAULT_RESTART_DT,
                                              FAULT_WALL_LIMIT,           FAULT_NORMAL_STRESS_GRADIENT,
                                              FAULT_EVENT_RATE,           FAULT_ACCURACY};

  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(free_ones); i++)
    if (id == (PetscInt)free_ones[i]) return PETSC_TRUE;
  return SlipFaultFieldOf(id) >= 0 ? PETSC_TRUE : PETSC_FALSE;
}

static PetscErrorCode CompareMesh(Differences *d, SlipFault fault)
{
  char digest[64];

  PetscFunctionBegin;
  PetscCall(fault->mesh.kind->digest(&fault->mesh, digest, sizeof(digest)));
  PetscCall(CompareText(d, "mesh", digest));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The entries of -fault_stiffness_file as they were read, whatever the file is called: scaling differs by rounding. A
   stiffness that is computed is known by mesh, kernel and elastic moduli. */
static PetscErrorCode CompareStiffness(Differences *d, SlipFault fault)
{
  char digest[128] = "no entries of a file";

  PetscFunctionBegin;
  if (fault->options.text[FAULT_STIFFNESS_FILE][0])
    (void)snprintf(digest, sizeof(digest), "of %lld x %lld entries of a file, %016" PRIx64, (long long)fault->mesh.N,
                   (long long)fault->mesh.N, fault->operators.read);
  PetscCall(CompareText(d, "stiffness", digest));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The record of -fault_pore_pressure by its content, whatever its file is called; sums of hashes do not depend on who
   holds which cells. A function of SlipFaultSetPressureFunction() is the caller's to keep. */
static PetscErrorCode CompareRecord(Differences *d, SlipFault fault)
{
  const SlipFaultLoads *loads = &fault->loads;
  uint64_t hash = 0;
  char digest[64] = "no record";

  PetscFunctionBegin;
  for (PetscInt i = 0; i < fault->mesh.n && loads->rows; i++) {
    const PetscReal number = (PetscReal)SlipFaultMeshRow(&fault->mesh, i);
    uint64_t cell = SlipHashReals(SLIP_HASH_START, &number, 1);

    cell = SlipHashReals(cell, loads->times, (size_t)loads->rows);
    for (PetscInt k = 0; k < loads->rows; k++)
      cell = SlipHashReals(cell, &loads->record[(size_t)k * fault->mesh.n + i], 1);
    hash += cell;
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &hash, 1, MPI_UINT64_T, MPI_SUM, fault->comm));
  if (loads->rows) (void)snprintf(digest, sizeof(digest), "of %lld times, %016" PRIx64, (long long)loads->rows, hash);
  PetscCall(CompareText(d, "pore_pressure", digest));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Refuses the checkpoint of another run, naming what differs. */
static PetscErrorCode VisitParameters(SlipState s, SlipFault fault)
{
  static const SlipFaultStringId choices[] = {FAULT_FRICTION_LAW, FAULT_STATE_LAW,         FAULT_KERNEL,
                                              FAULT_INITIAL,      FAULT_STIFFNESS_AVERAGE, FAULT_STIFFNESS_SCALING};
  const char *injection = fault->options.text[FAULT_INJECTION];
  Differences d = {.s = s};
  const SlipParameter *p;
  PetscBool cells;
  PetscReal value;

  PetscFunctionBegin;
  PetscCall(SlipStateGroup(s, "parameters"));
  for (PetscInt id = 0; id < FAULT_NUM_REALS; id++) {
    if (MayChange(id)) continue;
    p = SlipFaultRealRow(id);
    PetscCall(SlipFaultGetReal(fault, p->name, &value));
    PetscCall(CompareReal(&d, p->name, value, p->unit, 0));
  }
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(choices); i++)
    PetscCall(CompareText(&d, SlipFaultStrings[choices[i]].name, SlipFaultGetText(fault, choices[i])));
  PetscCall(CompareText(&d, "injection", injection[0] ? injection : "none"));
  PetscCall(CompareText(&d, "inertia", fault->kind.inertia ? "yes" : "no"));
  if (SlipFaultOpens(fault)) PetscCall(CompareText(&d, "opening", "yes"));
  PetscCall(CompareMesh(&d, fault));
  PetscCall(CompareStiffness(&d, fault));
  PetscCall(CompareType(&d, "operator", fault->operators.K));
  PetscCall(CompareType(&d, "viscosity", fault->operators.H));
  cells = d.text[0] ? PETSC_FALSE : PETSC_TRUE; /* as many as they were */
  for (PetscInt f = 0; (p = SlipFaultFieldRow(f)) && cells; f++)
    if (SlipFaultHasField(fault, f)) PetscCall(CompareCells(&d, fault, p->name, p->unit, fault->fields.cell[f]));
  if (cells) PetscCall(CompareRecord(&d, fault));
  if (!d.text[0]) PetscCall(CompareReal(&d, "scaling_of_stiffness", fault->operators.scaling, "", CHECKPOINT_SAME));
  if (!d.text[0]) PetscCall(CompareReal(&d, "critical_energy", fault->critical.energy, "Pa m", CHECKPOINT_SAME));
  PetscCheck(!d.text[0], fault->comm, PETSC_ERR_ARG_INCOMP, "-%sfault_restart %s is the checkpoint of another run: %s",
             SlipFaultPrefix(fault), fault->options.text[FAULT_RESTART], d.text);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the state ---- */

/* Everything: who adds a memory that outlives a step visits it as an observer, or composes SLIP_STATE_METHOD with its object. */
static PetscErrorCode VisitFaultState(SlipState s, TS ts, void *ctx)
{
  SlipFault fault = (SlipFault)ctx;
  char restart[PETSC_MAX_PATH_LEN + 64];
  PetscBool left = PETSC_TRUE;

  PetscFunctionBegin;
  PetscCall(PetscSNPrintf(restart, sizeof(restart), "-%sfault_restart %s", SlipFaultPrefix(fault),
                          fault->options.text[FAULT_RESTART]));
  PetscCall(VisitParameters(s, fault));
  PetscCall(SlipStateCells(s, fault->mesh.N, fault->mesh.order));
  PetscCall(SlipStateTS(s, ts));
  if (SlipStateIsLoading(s)) PetscCall(SlipCheckpointStepsLeft(s, ts, restart, &left));
  fault->run.idle = left ? PETSC_FALSE : PETSC_TRUE;
  PetscCall(SlipFaultExplicitState(fault, s, ts));
  if (SlipStateIsLoading(s) && fault->problem.begin) PetscCall((*fault->problem.begin)(ts, PETSC_FALSE));
  PetscCall(SlipStateAdapt(s, ts));
  PetscCall(SlipStateObject(s, "stiffness", (PetscObject)fault->operators.K));
  PetscCall(SlipStateObject(s, "viscosity", (PetscObject)fault->operators.H));
  PetscCall(SlipStateObject(s, "stage", (PetscObject)fault->operators.B));
  /* Without a step to take nobody watches: files stay as they are. */
  PetscCall(left ? SlipFaultObserversVisit(fault, s) : SlipFaultObserversDestroy(fault));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the run ---- */

/* The step is the checkpoint's, unless another one is asked for by name. */
static PetscErrorCode RestartStep(SlipFault fault, TS ts)
{
  const char *prefix;
  const PetscReal dt = fault->options.value[FAULT_RESTART_DT];
  PetscReal step, least;
  PetscBool given, renamed; /* as PETSc calls it from 3.25 on */

  PetscFunctionBegin;
  PetscCall(TSGetOptionsPrefix(ts, &prefix));
  PetscCall(PetscOptionsHasName(((PetscObject)ts)->options, prefix, "-ts_dt", &given));
  PetscCall(PetscOptionsHasName(((PetscObject)ts)->options, prefix, "-ts_time_step", &renamed));
  if (dt > 0) PetscCall(TSSetTimeStep(ts, dt));
  PetscCall(TSGetTimeStep(ts, &step));
  PetscCheck(
    !SlipStepIsLost(ts, step, &least), fault->comm, PETSC_ERR_ARG_OUTOFRANGE,
    "the next step is %g s at the time of -%sfault_restart %s, %.15g s: expected at least %g s, by -%sfault_restart_dt",
    (double)step, SlipFaultPrefix(fault), fault->options.text[FAULT_RESTART], (double)ts->ptime, (double)least,
    SlipFaultPrefix(fault));
  if ((given || renamed) && dt <= 0)
    PetscCall(PetscPrintf(fault->comm,
                          "The run goes on with the step of its checkpoint, %g s, and not that of -%sts_dt: "
                          "-%sfault_restart_dt would be used\n",
                          (double)step, prefix ? prefix : "", SlipFaultPrefix(fault)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Restart(SlipFault fault, TS ts)
{
  char source[128];
  PetscReal time;
  PetscInt step;
  SlipState s;

  PetscFunctionBegin;
  PetscCall(PetscSNPrintf(source, sizeof(source), "-%sfault_restart", SlipFaultPrefix(fault)));
  PetscCall(SlipStateOpen(fault->comm, fault->options.text[FAULT_RESTART], source, &s));
  PetscCall(VisitFaultState(s, ts, fault));
  PetscCall(SlipStateClose(&s));
  if (fault->run.idle) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(RestartStep(fault, ts));
  PetscCall(TSGetTime(ts, &time));
  PetscCall(TSGetStepNumber(ts, &step));
  PetscCall(PetscPrintf(fault->comm, "The run continues from %s at time %g s after %" PetscInt_FMT " steps\n",
                        fault->options.text[FAULT_RESTART], (double)time, step));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* An older checkpoint is not lost to a run that does not go on from it. */
static PetscErrorCode CheckFile(SlipFault fault)
{
  const char *file = fault->options.text[FAULT_CHECKPOINT], *prefix = SlipFaultPrefix(fault);
  PetscBool exists, same;

  PetscFunctionBegin;
  if (!file[0]) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipStateCheckCreate(fault->comm, prefix, "fault_checkpoint", file, &exists));
  PetscCall(PetscStrcmp(file, fault->options.text[FAULT_RESTART], &same));
  if (fault->options.output_overwrite) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCheck(!exists || same, fault->comm, PETSC_ERR_FILE_OPEN,
             "%s is there already (-%sfault_checkpoint): go on from it with -%sfault_restart %s, or throw it away with "
             "-%sfault_output_overwrite",
             file, prefix, prefix, file, prefix);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipFaultCheckpointStart - continue from -fault_restart, and write checkpoints of the run

  Collective; after SlipFaultOutputStart() with the solution set, before TSSolve().

  Input Parameters:
+ fault - the fault
- ts    - the TS that it configured, of type TSBATHE, or TSRK or TSADAMS with smooth friction

  Options Database Keys:
+ -fault_checkpoint <F.h5>           - file for the state of the run; the one before it stays as F.h5.previous
. -fault_checkpoint_interval <600>   - wall time from one checkpoint to the next [s]
. -fault_restart <F.h5>              - go on from this checkpoint, or from F.h5.previous when it is damaged
. -fault_restart_dt <dt>             - next step of a run that goes on [s]; 0: the checkpoint's
- -fault_wall_limit <S>              - stop in time for the program to end within S seconds

  Level: intermediate

  Notes:
  A run that goes on is the same run: on as many processes with the same bits, on others to rounding. Solver, controller
  and output options may differ from those of the checkpoint; a run with another mesh, parameter or operator is
  refused. The memory of the controller is part of it, that of dsp, which is PETSc's, as well; another controller begins
  without memory. A policy other than the checkpoint's is announced. A larger -ts_max_time lengthens a run that has reached
  its end.

  After `SlipSignalsPush()`, SIGTERM, SIGINT, SIGUSR1 and SIGXCPU stop the run after the step in work, with a checkpoint:
  ask `SlipFaultCheckpointFinish()` after TSSolve().

  Errors: PETSC_ERR_SUP for another TS type, PETSC_ERR_FILE_OPEN when the file is there and is not gone on from or
  cannot be written, PETSC_ERR_ARG_INCOMP for the checkpoint of another run

.seealso: SlipFaultCheckpointFinish(), SlipSignalsPush(), SlipFaultOutputStart()
@*/
PetscErrorCode SlipFaultCheckpointStart(SlipFault fault, TS ts)
{
  const char *prefix = SlipFaultPrefix(fault);
  const SlipCheckpointPlan plan = {.file = fault->options.text[FAULT_CHECKPOINT],
                                   .interval = fault->options.value[FAULT_CHECKPOINT_INTERVAL],
                                   .wall_limit = fault->options.value[FAULT_WALL_LIMIT],
                                   .visit = VisitFaultState,
                                   .ctx = fault};
  SlipCheckpointPlan named = plan;
  char restart[128];
  PetscBool bathe, rk;

  PetscFunctionBegin;
  SlipFaultCheckSetUp(fault, 1);
  PetscValidHeaderSpecific(ts, TS_CLASSID, 2);
  PetscCall(PetscObjectTypeCompare((PetscObject)ts, TSBATHE, &bathe));
  PetscCall(PetscObjectTypeCompareAny((PetscObject)ts, &rk, TSRK, TSADAMS, ""));
  PetscCheck(bathe || (rk && fault->friction.law->always_slides) ||
               (!plan.file[0] && !fault->options.text[FAULT_RESTART][0]),
             fault->comm, PETSC_ERR_SUP,
             "-%sfault_checkpoint and -%sfault_restart work with -ts_type bathe, or rk or adams and rate-and-state "
             "friction, not %s",
             prefix, prefix, ((PetscObject)ts)->type_name);
  PetscCall(CheckFile(fault));
  fault->run.idle = PETSC_FALSE;
  if (fault->options.text[FAULT_RESTART][0]) PetscCall(Restart(fault, ts));
  PetscCall(PetscSNPrintf(restart, sizeof(restart), "-%sfault_restart", prefix));
  named.restart = restart;
  named.option = "fault_checkpoint";
  PetscCall(SlipCheckpointStart(ts, &named));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipFaultCheckpointFinish - the last checkpoint of a run; of one that was stopped before its end, a line on stderr says
                              how to go on

  Collective; after TSSolve(), before SlipFaultOutputFinish().

  Input Parameters:
+ fault - the fault
- ts    - the TS, after SlipFaultCheckpointStart()

  Output Parameter:
. code - what the program should return: 128 plus the number of the signal, 152 (SIGXCPU) for -fault_wall_limit; 0: it
         was not stopped

  Level: intermediate

  Note:
  The output of a run that was stopped ends here, unfinished: call `SlipFaultReportStop()` then in place of
  `SlipFaultOutputFinish()`.

.seealso: SlipFaultCheckpointStart(), SlipFaultReportStop()
@*/
PetscErrorCode SlipFaultCheckpointFinish(SlipFault fault, TS ts, int *code)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(fault, SLIP_FAULT_CLASSID, 1);
  PetscValidHeaderSpecific(ts, TS_CLASSID, 2);
  PetscAssertPointer(code, 3);
  PetscCall(SlipCheckpointFinish(ts, code));
  if (*code) PetscCall(SlipFaultObserversDestroy(fault)); /* files stay unfinished */
  PetscFunctionReturn(PETSC_SUCCESS);
}
