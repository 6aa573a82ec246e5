/* Checkpoints of a fault with fields of its own: whichever processes hold which cells, a run goes on under the same
   fields and the same record of pressure, and not under others. */
#include "ranks.h"
#include "faultstart.h"
#include <math.h>
#include <unistd.h>
#include "cells.h"
#include "record.h"

enum { NX = 3, NZ = 3, N = 2 * NX * NZ, ROWS = 2 };

typedef struct {
  char state[64], mesh[64], record[64];
} Files;

/* What a run has of its own: a field, in the order of the mesh's file, and the pressure at the end of the record */
typedef struct {
  PetscReal drop[N], pressure[N];
} Fields;

static PetscErrorCode WriteFiles(const Files *files, const Fields *fields)
{
  const PetscInt rows = ROWS, dims[2] = {ROWS, N};
  const PetscReal times[ROWS] = {0, 10};
  PetscReal cells[5 * N], pressure[ROWS * N] = {0};
  const SlipCells mesh = TwoGradedFaults(NX, NZ, 5, cells);

  PetscCall(WriteCells(files->mesh, &mesh));
  PetscCall(PetscArraycpy(pressure + N, fields->pressure, N));
  return WriteRecord(files->record, rows, times, 2, dims, pressure);
}

/* Some steps from the start to a checkpoint, or from it; *code: of the error of a checkpoint that is refused */
static PetscErrorCode Run(MPI_Comm comm, const Files *files, PetscBool restart, const Fields *fields,
                          PetscErrorCode *code)
{
  SlipFault fault;
  int ended;
  TS ts;
  Vec w;

  PetscCall(SlipFaultCreate(comm, &fault));
  PetscCall(FaultSetStrings(fault, {"mesh", files->mesh}, {"pore_pressure", files->record}, {"viscosity", "radiation"},
                            {"initial", "rest"}, {restart ? "restart" : "checkpoint", files->state}));
  PetscCall(SlipFaultSetReal(fault, "loading_rate", 1e-3));
  PetscCall(SlipFaultSetField(fault, "friction_drop", N, fields->drop));
  PetscCall(FaultStart(fault, TSADAPTNONE, 0.1, restart ? 2 : 1, &w, &ts));
  PetscCall(TSSetSolution(ts, w));
  if (restart) PetscCall(PetscPushErrorHandler(PetscReturnErrorHandler, NULL));
  *code = SlipFaultCheckpointStart(fault, ts);
  if (restart) PetscCall(PetscPopErrorHandler());
  if (!*code) {
    PetscCall(TSSolve(ts, w));
    PetscCall(SlipFaultCheckpointFinish(fault, ts, &ended));
  }
  return DestroyObjects(&w, &ts, &fault);
}

static PetscErrorCode Expect(MPI_Comm comm, const Files *files, const char what[], const Fields *fields,
                             PetscErrorCode expected)
{
  PetscMPIInt rank, size;
  PetscErrorCode code;

  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCallMPI(MPI_Comm_size(comm, &size));
  if (!rank) PetscCall(WriteFiles(files, fields));
  PetscCallMPI(MPI_Barrier(comm));
  PetscCall(Run(comm, files, PETSC_TRUE, fields, &code));
  Check(code == expected, "%s on %d ranks: error %d, expected %d", what, (int)size, (int)code, (int)expected);
  return PETSC_SUCCESS;
}

static PetscErrorCode Test(void)
{
  const MPI_Comm comms[2] = {PETSC_COMM_WORLD, PETSC_COMM_SELF};
  PetscErrorCode code;
  PetscMPIInt rank, size;
  Fields fields, other;
  Files files;

  PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
  PetscCallMPI(MPI_Comm_size(PETSC_COMM_WORLD, &size));
  for (int i = 0; i < N; i++) {
    fields.drop[i] = 0.1 + 0.001 * i;
    fields.pressure[i] = 1e3 * i;
  }
  for (int k = 0; k < 2; k++) {
    PetscCall(PetscSNPrintf(files.state, sizeof(files.state), "restart_%d.state", (int)size));
    PetscCall(PetscSNPrintf(files.mesh, sizeof(files.mesh), "restart_%d_mesh.h5", (int)size));
    PetscCall(PetscSNPrintf(files.record, sizeof(files.record), "restart_%d_p.h5", (int)size));
    if (!rank) unlink(files.state);
    if (!rank) PetscCall(WriteFiles(&files, &fields));
    PetscCallMPI(MPI_Barrier(PETSC_COMM_WORLD));
    /* written by all, read by all and by one, and the other way round */
    if (!k || !rank) PetscCall(Run(comms[k], &files, PETSC_FALSE, &fields, &code));
    PetscCallMPI(MPI_Barrier(PETSC_COMM_WORLD));
    for (int j = 0; j < 2; j++) {
      if (!j || !rank) {
        PetscCall(Expect(comms[j], &files, "the same", &fields, PETSC_SUCCESS));
        /* the same numbers in other cells, of which least, mean and largest are the same */
        other = fields;
        other.drop[2] = fields.drop[N - 2];
        other.drop[N - 2] = fields.drop[2];
        PetscCall(Expect(comms[j], &files, "two cells of a field exchanged", &other, PETSC_ERR_ARG_INCOMP));
        other = fields;
        other.pressure[2] = fields.pressure[N - 2];
        other.pressure[N - 2] = fields.pressure[2];
        PetscCall(Expect(comms[j], &files, "two cells of the record exchanged", &other, PETSC_ERR_ARG_INCOMP));
        other = fields;
        other.pressure[5] *= 1 + 1e-12;
        PetscCall(Expect(comms[j], &files, "another number in the record", &other, PETSC_ERR_ARG_INCOMP));
      }
      PetscCallMPI(MPI_Barrier(PETSC_COMM_WORLD));
    }
  }
  if (!rank) {
    const char *const names[] = {files.state, files.mesh, files.record};

    for (int k = 0; k < 3; k++) unlink(names[k]);
  }
  return PETSC_SUCCESS;
}

SLIP_RANKS(Test)
