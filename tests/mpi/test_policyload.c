/* A policy on several ranks: rank 0 reads, all evaluate the same numbers, and a bad file is an error on every rank. */
#include "ranks.h"
#include <unistd.h>

static PetscErrorCode Make(const char file[])
{
  const char *const names[1] = {"energy"};
  const PetscReal one = 1, w = 0.3, b = -0.1, zero = 0;
  SlipPolicy p;

  PetscCall(SlipPolicyCreate(PETSC_COMM_WORLD, &p));
  PetscCall(SlipPolicySetObservations(p, 1, names, &one, &zero));
  PetscCall(SlipPolicyAddLayer(p, 1, 1, &w, &b, SLIP_ACTIVATION_TANH));
  PetscCall(SlipPolicySetAction(p, -1, 1, 0.1, "s", 6, "s", PETSC_FALSE));
  PetscCall(SlipPolicyStore(p, file));
  return SlipPolicyDestroy(&p);
}

static PetscErrorCode CheckSame(const char file[])
{
  const PetscReal obs = 0.7;
  SlipPolicy p;
  PetscReal a, ends[2];
  const char *hash;
  char hash0[32] = "";

  PetscCall(SlipPolicyCreate(PETSC_COMM_WORLD, &p));
  PetscCall(SlipPolicyLoad(p, file));
  PetscCall(SlipPolicyEvaluate(p, &obs, &a, NULL));
  ends[0] = a;
  ends[1] = -a;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, ends, 2, MPIU_REAL, MPIU_MAX, PETSC_COMM_WORLD));
  Check(ends[0] == a && ends[1] == -a, "ranks disagree on the action");
  PetscCall(SlipPolicyGetHash(p, &hash));
  PetscCall(PetscStrncpy(hash0, hash, sizeof(hash0)));
  PetscCallMPI(MPI_Bcast(hash0, (PetscMPIInt)sizeof(hash0), MPI_CHAR, 0, PETSC_COMM_WORLD));
  Check(!strcmp(hash, hash0), "ranks disagree on the hash");
  return SlipPolicyDestroy(&p);
}

/* Every rank returns the same code; a hang would end in the test's time limit. */
static PetscErrorCode CheckError(void)
{
  SlipPolicy p;
  int codes[2], code;

  PetscCall(SlipPolicyCreate(PETSC_COMM_WORLD, &p));
  PetscCall(PetscPushErrorHandler(PetscReturnErrorHandler, NULL));
  code = (int)SlipPolicyLoad(p, "no_such_policy.h5");
  PetscCall(PetscPopErrorHandler());
  codes[0] = code;
  codes[1] = -code;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, codes, 2, MPI_INT, MPI_MAX, PETSC_COMM_WORLD));
  Check(code == PETSC_ERR_FILE_OPEN && codes[0] == code && codes[1] == -code,
        "a missing file gives error %d here, from %d to %d over the ranks; expected %d", code, -codes[1], codes[0],
        PETSC_ERR_FILE_OPEN);
  return SlipPolicyDestroy(&p);
}

static PetscErrorCode Run(void)
{
  char file[64];
  PetscMPIInt rank, size;

  PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
  PetscCallMPI(MPI_Comm_size(PETSC_COMM_WORLD, &size));
  PetscCall(PetscSNPrintf(file, sizeof(file), "test_policyload_%d.h5", size));
  PetscCall(Make(file));
  PetscCall(CheckSame(file));
  PetscCall(CheckError());
  if (!rank) unlink(file);
  return PETSC_SUCCESS;
}

SLIP_RANKS(Run)
