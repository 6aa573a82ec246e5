/* Which controller and tolerance a run takes that names none. */
#include <slipadapt.h>
#include <slipstep/private/slipfault.h>

#define SLIP_FAULT_RTOL 1e-3    /* reference tolerance, as SLIP_FAULT_ATOL */
#define SLIP_SEQUENCE_RTOL 1e-4 /* of events that follow each other */

/*
  Controller and tolerance of a run that names none, by measurement (tests/benchmarks/README.md). One event from the
  instability has those of the study. Ruptures from a given stress: pi, which rejects next to nothing where cells break
  one by one. Events that follow each other: dsp, for the fewest solves, at the tolerance that loses the fewest of them;
  but under a pore pressure alone heuristic, as filters reject good steps where the error was near 0 before, as after the
  corners of a record, and with smooth friction, whose events pi finds nine times as inexactly at equal -ts_rtol.
*/
void SlipFaultChooseSteps(SlipFault fault, PetscBool is_explicit)
{
  const PetscBool smooth = fault->friction.law->always_slides, events = (PetscBool)(fault->kind.sequence && !smooth);
  const PetscBool classical = (PetscBool)(fault->critical.known || fault->loads.pressed || smooth);

  fault->problem.controller = events ? TSADAPTDSP : classical ? TSADAPTHEURISTIC : TSADAPTPI;
  if (is_explicit) fault->problem.controller = NULL; /* the integrator's */
  fault->kind.rtol = events ? SLIP_SEQUENCE_RTOL : SLIP_FAULT_RTOL;
}

/* Says what of a run that is not the study's its options leave to the fault. */
PetscErrorCode SlipFaultReportSteps(SlipFault fault, TS ts)
{
  const char *prefix;
  PetscBool bathe, type, rtol;
  PetscOptions options = ((PetscObject)ts)->options;

  PetscFunctionBegin;
  PetscCall(TSGetOptionsPrefix(ts, &prefix));
  PetscCall(PetscObjectTypeCompare((PetscObject)ts, TSBATHE, &bathe));
  PetscCall(PetscOptionsHasName(options, prefix, "-ts_adapt_type", &type));
  PetscCall(PetscOptionsHasName(options, prefix, "-ts_rtol", &rtol));
  if (!bathe || (type && rtol) || (!fault->kind.sequence && !fault->loads.pressed && fault->critical.known))
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscPrintf(fault->comm, "%-24s ", "steps:"));
  if (!type) PetscCall(PetscPrintf(fault->comm, "-ts_adapt_type %s%s", fault->problem.controller, rtol ? "" : " "));
  if (!rtol) PetscCall(PetscPrintf(fault->comm, "-ts_rtol %g", (double)fault->kind.rtol));
  PetscCall(PetscPrintf(fault->comm, ", the default for %s\n",
                        fault->friction.law->always_slides ? "rate-and-state friction"
                        : fault->kind.sequence             ? "a fault that is loaded or heals"
                        : fault->loads.pressed             ? "a fault under a pore pressure"
                                                           : "a rupture from a given stress"));
  PetscFunctionReturn(PETSC_SUCCESS);
}
