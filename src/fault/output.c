/* Output of a fault: what it adds to that of any run, by a monitor of its fields. */
#include <slipstep/private/slipfaultrecord.h>

PetscErrorCode SlipFaultOutputDestroy(SlipFaultOutput *output)
{
  SlipFaultOutput out = *output;

  PetscFunctionBegin;
  if (!out) PetscFunctionReturn(PETSC_SUCCESS);
  if (out->run) { /* it did not finish */
    PetscCall(SlipOutputDestroy(&out->run));
    PetscCall(SlipFaultXdmfFlushed(out, PETSC_TRUE));
  }
  PetscCall(PetscFree(out->xdmf.time));
  PetscCall(VecScatterDestroy(&out->gather_w));
  PetscCall(VecScatterDestroy(&out->gather_r));
  PetscCall(VecDestroy(&out->w0));
  PetscCall(VecDestroy(&out->r0));
  PetscCall(VecDestroy(&out->p0));
  PetscCall(VecDestroy(&out->pressure));
  PetscCall(VecDestroy(&out->start0));
  PetscCall(VecDestroy(&out->shown));
  PetscCall(VecDestroy(&out->vinf0));
  PetscCall(VecDestroy(&out->when.entry_u));
  PetscCall(PetscFree(*output));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* What the start is to slip, rates and stations; of a run that goes on, its checkpoint knows */
static PetscErrorCode SlipFaultOutputBegin(SlipFaultOutput out, PetscReal time, Vec w)
{
  PetscFunctionBegin;
  if (!out->resumed || !out->when.known) PetscCall(SlipFaultOutputWasWritten(out, time, w));
  out->when.time = time;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* TSMonitor: /fields for the start and the steps after which they are due; the start of a run that is continued is
   in the file. */
static PetscErrorCode SlipFaultFieldMonitor(TS ts, PetscInt step, PetscReal time, Vec w, void *ctx)
{
  SlipFault fault = (SlipFault)ctx;
  SlipFaultOutput out = fault->run.output;
  PetscBool due;

  PetscFunctionBegin;
  (void)ts;
  if (step < 0 || !out) PetscFunctionReturn(PETSC_SUCCESS);
  if (!out->started) {
    due = !out->resumed ? PETSC_TRUE : PETSC_FALSE;
    PetscCall(SlipFaultOutputBegin(out, time, w));
  } else if (step == out->last_field_step)
    due = PETSC_FALSE;
  else
    PetscCall(SlipFaultOutputIsDue(out, step, time, w, &due));
  out->started = PETSC_TRUE;
  if (!due) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipFaultOutputFields(out, time, w));
  PetscCall(SlipFaultOutputWasWritten(out, time, w));
  out->last_field_step = step;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipFaultOutputStart - open -fault_output and -fault_catalogue and attach the monitors that write them, and the one that
  estimates the slip's error

  Collective; after TSSetFromOptions(), before TSSolve().

  Input Parameters:
+ fault - the fault
- ts    - the TS that it configured

  Options Database Keys:
+ -fault_output <F.h5>          - file for the run
. -fault_output_size <1e8>      - what its fields take at most where no other option says when they are written [bytes]
. -fault_catalogue <F.h5>       - file for its events, a row each; every one is also a line on standard output
. -fault_event_rate <1e-3>      - slip rate of a cell from which on an event lasts, until all are below a tenth [m/s]
- -fault_catalogue_maps <no>    - slip and rupture time of every cell as well

  Level: intermediate

  Errors: PETSC_ERR_FILE_OPEN when a file cannot be created, PETSC_ERR_ARG_UNKNOWN_TYPE for an unknown field,
  PETSC_ERR_ARG_INCOMP for the pore pressure of a fault that has none, PETSC_ERR_SUP for a catalogue with another integrator
  than TSBATHE unless friction is smooth.

  Notes:
  The content goes to FILE.part, made at the start of TSSolve(), which takes FILE's name in SlipFaultOutputFinish(): a run
  that fails leaves an older FILE as it was. FILE.part can be read all the time, see SlipOutputCreate(). slipfault.h
  describes the layout.

.seealso: SlipFaultOutputResume(), SlipFaultOutputFinish()
@*/
PetscErrorCode SlipFaultOutputStart(SlipFault fault, TS ts)
{
  PetscErrorCode ierr = PETSC_SUCCESS;
  SlipFaultOutput out;
  SlipH5Kind kind;
  Vec w;

  PetscFunctionBegin;
  SlipFaultCheckSetUp(fault, 1);
  PetscValidHeaderSpecific(ts, TS_CLASSID, 2);
  PetscCall(SlipFaultCheckFileNames(fault)); /* as SlipFaultSetString() may have set them */
  fault->balance.sides = 0;
  PetscCall(SlipLogGetProducts(&fault->run.products));
  PetscCall(SlipFaultReportSteps(fault, ts));
  PetscCall(SlipFaultRunErrorStart(fault, ts));
  PetscCall(SlipFaultProgressStart(fault, ts));
  PetscCall(SlipFaultOutputWhenCheck(fault));
  PetscCall(SlipFaultCatalogueStart(fault, ts));
  PetscCall(SlipFaultResolutionPrint(fault));
  PetscCheck(!fault->run.output, fault->comm, PETSC_ERR_ORDER, "the output of the last run was not finished");
  PetscCall(SlipFaultObserversCreate(fault, ts)); /* before the monitor that writes /series */
  if (!fault->options.text[FAULT_OUTPUT][0]) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscNew(&out));
  fault->run.output = out;
  out->fault = fault;
  out->ts = ts;
  PetscCallMPI(MPI_Comm_rank(fault->comm, &out->rank));
  kind = (SlipH5Kind){.prefix = SlipFaultPrefix(fault), .option = "fault_output"};
  if (!out->rank) ierr = SlipH5CheckCreateKind(&kind, fault->options.text[FAULT_OUTPUT]);
  PetscCall(SlipErrorBcast(fault->comm, ierr));
  PetscCall(SlipFaultOutputCreateRun(out, ts));
  PetscCall(SlipFaultOutputSize(out, ts));
  PetscCall(SlipFaultCreateState(fault, &w));
  PetscCall(SlipFaultGatherCreate(fault, w, &out->gather_w, &out->w0));
  PetscCall(SlipFaultGatherCreate(fault, fault->critical.uc, &out->gather_r, &out->r0));
  PetscCall(VecDestroy(&w));
  PetscCall(TSMonitorSet(ts, SlipFaultFieldMonitor, fault, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipFaultOutputSync - bring all rows of the output to the disk, and count them, for a checkpoint

  Collective

  Input Parameter:
. fault - the fault

  Output Parameter:
. rows - of /steps, /series and /fields that the file has now; 0 where there is no -fault_output

  Level: advanced

  Errors: PETSC_ERR_FILE_WRITE when the rows cannot be written

.seealso: SlipFaultOutputResume(), SlipOutputSync()
@*/
PetscErrorCode SlipFaultOutputSync(SlipFault fault, PetscInt rows[3])
{
  SlipFaultOutput out = fault->run.output;

  PetscFunctionBegin;
  PetscValidHeaderSpecific(fault, SLIP_FAULT_CLASSID, 1);
  rows[0] = rows[1] = rows[2] = 0;
  if (!out) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipOutputSync(out->run, &rows[0], &rows[1]));
  rows[2] = out->nfields;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipFaultOutputResume - go on in the -fault_output of an earlier run

  Collective; after SlipFaultOutputStart(), before TSSolve()

  Input Parameters:
+ fault - the fault
- rows  - of /steps, /series and /fields to keep, as SlipFaultOutputSync() counted them

  Level: advanced

  Notes:
  Without -fault_output nothing is done. SlipOutputResume() says which file that is and what becomes of it. Fields are the
  same as before: -fault_output_fields must name those of the file.

  Errors: those of SlipOutputResume()

.seealso: SlipFaultOutputSync(), SlipOutputResume()
@*/
PetscErrorCode SlipFaultOutputResume(SlipFault fault, const PetscInt rows[3])
{
  SlipFaultOutput out = fault->run.output;

  PetscFunctionBegin;
  PetscValidHeaderSpecific(fault, SLIP_FAULT_CLASSID, 1);
  if (!out) PetscFunctionReturn(PETSC_SUCCESS);
  out->resumed = PETSC_TRUE;
  out->nfields = rows[2];
  PetscCall(SlipOutputResume(out->run, rows[0], rows[1]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SlipFaultOutputLastFields(SlipFaultOutput out, TS ts)
{
  PetscInt step;
  PetscReal time;
  Vec w;

  PetscFunctionBegin;
  PetscCall(TSGetStepNumber(ts, &step));
  if (step == out->last_field_step) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(TSGetTime(ts, &time));
  PetscCall(TSGetSolution(ts, &w));
  PetscCall(SlipFaultOutputFields(out, time, w));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipFaultOutputFinish - print the summary of a run and complete its output file

  Collective; after TSSolve().

  Input Parameters:
+ fault      - the fault
. ts         - the TS that was solved
. wall_setup - wall time of set-up [s]
- wall_solve - wall time of TSSolve() [s]

  Options Database Key:
. -fault_check_error - repeat the run with every step computed in four parts, for a Richardson estimate of its errors;
                       five times the Bathe solves of the run more; with TSBATHE only

  Level: intermediate

  Notes:
  Attributes of /result, where friction weakens and there are several cells: least_resolution, the cells in the least
  cohesive zone (in the least length of nucleation where there is none), and cells_fail_alone, the share of the cells that
  weaken which can fail by themselves.

  When the fault rests at the end, the summary has an estimate of the error that `TSAdaptRLGetMeasure()` names (of the
  history with controllers that have no measure), which nine in ten runs stay below and for which
  `SlipFaultOutputStart()` must have been called, or the reason why it is unknown. A policy that observes log_accuracy
  has its dial judged by it: likely met, or unknown; the check says met or not met. Attributes of /result, X being slip
  (the final mean slip), history and event_time: X_error_estimate, X_error_measure (the estimate before its
  calibration), slip_error_signed (the first variation, computed minus exact), accuracy_requested,
  slip_error_estimate_met (of the run's measure: 1 or -1), and with the check X_error_check, slip_error_check_signed,
  slip_error_check_met (of the run's measure: 1 or 0), check_error_final, check_error_history, check_error_shift,
  check_error_peak, check_error_field, check_solves.

.seealso: SlipFaultOutputStart(), TSAdaptRLSetMeasure()
@*/
PetscErrorCode SlipFaultOutputFinish(SlipFault fault, TS ts, PetscReal wall_setup, PetscReal wall_solve)
{
  SlipFaultOutput out = fault->run.output;
  SlipFaultObservables obs;
  SlipOutput run = NULL;
  PetscInt products;
  PetscReal t;
  Vec w;

  PetscFunctionBegin;
  SlipFaultCheckSetUp(fault, 1);
  PetscValidHeaderSpecific(ts, TS_CLASSID, 2);
  PetscCall(SlipLogGetProducts(&products));
  PetscCall(TSGetSolution(ts, &w));
  PetscCall(TSGetTime(ts, &t));
  PetscCall(SlipFaultGetObservables(fault, t, w, NULL, &obs));
  if (out) {
    PetscCall(SlipOutputBegin(out->run));
    PetscCall(SlipFaultOutputLastFields(out, ts));
    run = out->run;
    out->run = NULL;
  } else
    PetscCall(SlipOutputCreate(ts, NULL, 0, NULL, NULL, NULL, &run));
  if (fault->problem.any_integrator)
    PetscCall(SlipOutputAddResult(run, "right_hand_sides", "right-hand sides", NULL, fault->balance.sides));
  PetscCall(SlipOutputAddResult(run, "products", "products with K", NULL, products - fault->run.products));
  PetscCall(SlipOutputAddResult(run, "mean_slip", "final mean slip", "m", obs.mean_slip));
  PetscCall(SlipFaultResolutionResult(fault, run));
  PetscCall(SlipFaultCatalogueFinish(fault, run));
  PetscCall(SlipFaultObserversFinish(fault, ts, run));
  PetscCall(SlipFaultRunErrorReport(fault, ts, run, obs.mean_slip));
  PetscCall(SlipOutputFinish(&run, wall_setup, wall_solve));
  if (out && !out->rank) PetscCall(SlipFaultXdmfFinish(out));
  PetscCall(SlipFaultObserversDestroy(fault));
  PetscCall(SlipFaultOutputDestroy(&fault->run.output));
  PetscFunctionReturn(PETSC_SUCCESS);
}
