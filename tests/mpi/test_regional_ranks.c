/* The stress of a region on all ranks against each rank alone: the same bits in every cell of a grid and of rectangles,
   and the same words about tension, whichever rank has the cells. */
#include "ranks.h"
#include "cells.h"
#include "faultstart.h"
#include <slipstep/private/slipfault.h>
#include <string.h>
#include <unistd.h>

enum { NX = 7, NZ = 5, N = 2 * NX * NZ };
static const char *const field[] = {"normal_stress", "initial_traction", "rake"};
static char said[1024];

static PetscErrorCode Record(MPI_Comm comm, int line, const char *fun, const char *src, PetscErrorCode n,
                             PetscErrorType p, const char *mess, void *ctx)
{
  if (p == PETSC_ERROR_INITIAL) (void)snprintf(said, sizeof(said), "%s", mess);
  return n;
}

/* Fields [3][n], or in case of an error what it says */
static PetscErrorCode Resolve(MPI_Comm comm, const char mesh[], const char stress[], PetscInt n, PetscReal value[])
{
  PetscErrorCode ierr;
  SlipFault fault;

  PetscCall(SlipFaultCreate(comm, &fault));
  PetscCall(FaultSetReals(fault, {"nx", NX}, {"nz", 2 * NZ}, {"slip_components", 2}, {"dip", 55}, {"strike", 20}));
  if (mesh) PetscCall(SlipFaultSetString(fault, "mesh", mesh));
  PetscCall(
    FaultSetStrings(fault, {"regional_stress", stress}, {"regional_stress_gradient", "1e3,9e3,2e4,3e3,-2e3,0"}));
  said[0] = '\0';
  PetscCall(PetscPushErrorHandler(Record, NULL));
  ierr = SlipFaultSetUp(fault);
  PetscCall(PetscPopErrorHandler());
  for (int k = 0; k < 3 && !ierr; k++) PetscCall(SlipFaultGetField(fault, field[k], n, value + n * k));
  return SlipFaultDestroy(&fault);
}

static PetscErrorCode Compare(const char mesh[], const char stress[], PetscBool tension)
{
  static PetscReal alone[3 * N], all[3 * N];
  char words[sizeof(said)];

  PetscCall(Resolve(PETSC_COMM_SELF, mesh, stress, N, alone));
  PetscCall(PetscStrncpy(words, said, sizeof(words)));
  PetscCall(Resolve(PETSC_COMM_WORLD, mesh, stress, N, all));
  Check(!strcmp(words, said), "all ranks say \"%s\", one \"%s\"", said, words);
  Check((strstr(said, "is not positive in") != NULL) == tension, "\"%s\"", said);
  for (int i = 0; i < 3 * N && !tension; i++)
    Check(alone[i] == all[i], "%s of cell %d is %.17g on all ranks, %.17g on one", field[i / N], i % N, (double)all[i],
          (double)alone[i]);
  return PETSC_SUCCESS;
}

static PetscErrorCode Run(void)
{
  static PetscReal numbers[8 * N];
  const SlipCells cells = TwoDippingPlanes(NX, NZ, numbers);
  const char file[] = "test_regional_ranks.h5";
  PetscMPIInt rank;

  PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
  if (!rank) PetscCall(WriteCells(file, &cells));
  PetscCallMPI(MPI_Barrier(PETSC_COMM_WORLD));
  for (int k = 0; k < 2; k++) {
    PetscCall(Compare(k ? file : NULL, "9e7,1.2e8,1.4e8,-2e7,1e7,-5e6", PETSC_FALSE));
    PetscCall(Compare(k ? file : NULL, "-1e7,-9e6,-2e7,0,0,0", PETSC_TRUE));
  }
  PetscCallMPI(MPI_Barrier(PETSC_COMM_WORLD));
  if (!rank) (void)unlink(file);
  return PETSC_SUCCESS;
}

SLIP_RANKS(Run)
