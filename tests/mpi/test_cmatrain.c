/* Training by CMA-ES: the same weights on one rank and on all of them, and after a resumed checkpoint. */
#include "ranks.h"
#include "cmaes/cmatrain.h"
#include <string.h>

static PetscErrorCode Options(const char extra[], CMAOptions *o)
{
  PetscCall(PetscOptionsClear(NULL));
  PetscCall(PetscOptionsInsertString(
    NULL, "-train_singles 6 -train_meshes 2 -train_mesh_side 2 -train_batch_singles 4 "
          "-train_batch_meshes 1 -train_validation 2 -train_calibration 2 -train_validation_interval 2 "
          "-train_population 6 -train_hidden 3 -train_sigma 0.05 -train_seed 4"));
  PetscCall(PetscOptionsInsertString(NULL, extra));
  return CMAOptionsSet(PETSC_COMM_WORLD, NULL, o);
}

/* mean and best [2 n], to be freed */
static PetscErrorCode Train(MPI_Comm comm, const char extra[], PetscInt *n, double **result)
{
  CMAOptions o;
  CMATrainer t;

  PetscCall(Options(extra, &o));
  PetscCall(CMATrainerCreate(comm, &o, &t));
  PetscCall(CMATrainerRun(&t));
  *n = t.es.n;
  PetscCall(PetscMalloc1(2 * t.es.n, result));
  PetscCall(PetscArraycpy(*result, t.es.mean, t.es.n));
  PetscCall(PetscArraycpy(*result + t.es.n, t.best, t.es.n));
  PetscCall(CMATrainerDestroy(&t));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Compare(PetscInt n, const double a[], const double b[], const char what[])
{
  Check(!memcmp(a, b, 2 * (size_t)n * sizeof(*a)), "other weights %s", what);
  return PETSC_SUCCESS;
}

static PetscErrorCode Run(void)
{
  double *all, *alone, *resumed;
  PetscMPIInt size;
  PetscInt n;
  char file[64], extra[256];

  PetscCallMPI(MPI_Comm_size(PETSC_COMM_WORLD, &size));
  PetscCall(PetscSNPrintf(file, sizeof(file), "test_cmatrain.%d.h5", size));
  PetscCall(Train(PETSC_COMM_WORLD, "-train_generations 4", &n, &all));
  Check(all[0] != 0, "nothing was learnt");
  PetscCall(Train(PETSC_COMM_SELF, "-train_generations 4", &n, &alone));
  PetscCall(Compare(n, all, alone, "on one rank"));
  PetscCall(PetscSNPrintf(extra, sizeof(extra), "-train_generations 2 -train_checkpoint %s", file));
  PetscCall(Train(PETSC_COMM_WORLD, extra, &n, &resumed));
  PetscCall(PetscFree(resumed));
  PetscCallMPI(MPI_Barrier(PETSC_COMM_WORLD));
  PetscCall(PetscSNPrintf(extra, sizeof(extra), "-train_generations 4 -train_resume %s", file));
  PetscCall(Train(PETSC_COMM_WORLD, extra, &n, &resumed));
  PetscCall(Compare(n, all, resumed, "after -train_resume"));
  PetscCallMPI(MPI_Barrier(PETSC_COMM_WORLD));
  if (!PetscGlobalRank) (void)remove(file);
  PetscCall(PetscFree(all));
  PetscCall(PetscFree(alone));
  return PetscFree(resumed);
}

SLIP_RANKS(Run)
