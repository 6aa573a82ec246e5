/* Arrays that the processes of a machine hold once, and what happens where the machine cannot share them. Exit code 0:
   good. */
#define _POSIX_C_SOURCE 200809L
#include "ranks.h"
#include <slipstep/private/slipsys.h>
#include <sys/resource.h>

enum { N = 1000 };

/* Fills an array by slices, moves one, sends one from the first process, and reads all of them everywhere. sharing: are
   they expected to be shared? */
static PetscErrorCode Arrays(PetscBool sharing)
{
  SlipShared s;
  PetscInt *slices, *moved = NULL, *sent, start, end, number = 0, *all;
  PetscMPIInt rank, size;
  PetscReal bytes;

  PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
  PetscCallMPI(MPI_Comm_size(PETSC_COMM_WORLD, &size));
  PetscCall(SlipSharedCreate(PETSC_COMM_WORLD, &s));
  PetscCall(SlipSharedMalloc1(s, N, &slices));
  SlipSharedSlice(s, slices, N, &start, &end);
  Check(sharing ? end - start <= N / size + 1 : end - start == N, "a process fills %d numbers", (int)(end - start));
  for (PetscInt i = start; i < end; i++) slices[i] = 7 * i;
  PetscCall(SlipSharedReady(s));
  if (SlipSharedFirst(s)) {
    PetscCall(PetscMalloc1(N, &moved));
    for (PetscInt i = 0; i < N; i++) moved[i] = 11 * i;
    number = 42;
  }
  PetscCall(SlipSharedMove(s, N * sizeof(*moved), &moved));
  PetscCall(SlipSharedValues(s, 1, &number));
  PetscCall(SlipSharedMalloc1(s, N, &sent));
  for (PetscInt i = 0; i < N && !rank; i++) sent[i] = 13 * i;
  PetscCall(SlipSharedBcast(s, sent, N, MPIU_INT));
  Check(number == 42, "a value of the first process is %d", (int)number);
  for (PetscInt i = 0; i < N; i++)
    Check(slices[i] == 7 * i && moved[i] == 11 * i && sent[i] == 13 * i, "number %d is %d, %d, %d", (int)i,
          (int)slices[i], (int)moved[i], (int)sent[i]);
  bytes = SlipSharedMachineBytes(s);
  Check(bytes == 3.0 * N * sizeof(PetscInt) * (sharing ? 1 : size), "%g bytes on the machine", (double)bytes);

  /* what one process writes all read, if it is shared */
  PetscCallMPI(MPI_Barrier(PETSC_COMM_WORLD));
  if (rank == size - 1) slices[3] = -1;
  PetscCallMPI(MPI_Barrier(PETSC_COMM_WORLD));
  Check(slices[3] == (sharing || rank == size - 1 ? -1 : 21), "number 3 is %d", (int)slices[3]);
  all = slices;
  PetscCall(SlipSharedFree(s, &slices));
  Check(all && !slices, "a freed array is not NULL");
  PetscCall(SlipSharedDestroy(&s));
  return SlipSharedDestroy(&s);
}

static PetscErrorCode All(void)
{
  struct rlimit limit;
  rlim_t before;
  PetscMPIInt size;

  PetscCallMPI(MPI_Comm_size(PETSC_COMM_WORLD, &size));
  PetscCall(Arrays(size > 1 ? PETSC_TRUE : PETSC_FALSE));
  /* segments of memory are files: none can be as long as the arrays */
  (void)getrlimit(RLIMIT_FSIZE, &limit);
  before = limit.rlim_cur;
  limit.rlim_cur = 16;
  (void)setrlimit(RLIMIT_FSIZE, &limit);
  PetscCall(Arrays(PETSC_FALSE));
  limit.rlim_cur = before;
  (void)setrlimit(RLIMIT_FSIZE, &limit);
  return PETSC_SUCCESS;
}

SLIP_RANKS(All)
