/* What tests do with PETSc's objects in one call. */
#pragma once
#include <slipstep/rooms.h>
#include <slipcompat.h>

/* Destroys PETSc's objects and ours, of any classes, by their addresses */
#define DestroyObjects(...) DestroyEach(sizeof((void *[]){__VA_ARGS__}) / sizeof(void *), (void *const[]){__VA_ARGS__})
static inline PetscErrorCode DestroyEach(size_t n, void *const each[])
{
  for (size_t i = 0; i < n; i++) PetscCall(PetscObjectDestroy((PetscObject *)each[i]));
  return PETSC_SUCCESS;
}

/* Vectors like v, by their addresses */
#define DuplicateVecs(v, ...)                                                                                          \
  DuplicateEach(v, sizeof((Vec *[]){__VA_ARGS__}) / sizeof(Vec *), (Vec *const[]){__VA_ARGS__})
static inline PetscErrorCode DuplicateEach(Vec v, size_t n, Vec *const each[])
{
  for (size_t i = 0; i < n; i++) PetscCall(VecDuplicate(v, each[i]));
  return PETSC_SUCCESS;
}

/* The numbers of this process, which stay where they are as long as x is */
static inline const PetscScalar *VecRead(Vec x)
{
  const PetscScalar *a, *numbers;

  PetscCallAbort(PETSC_COMM_SELF, VecGetArrayRead(x, &a));
  numbers = a;
  PetscCallAbort(PETSC_COMM_SELF, VecRestoreArrayRead(x, &a));
  return numbers;
}

static inline PetscErrorCode VecAssemble(Vec x)
{
  PetscCall(VecAssemblyBegin(x));
  return VecAssemblyEnd(x);
}

/* Numbers without symmetry, the same however x is distributed */
static inline PetscErrorCode VecFillSines(Vec x)
{
  PetscInt start, end;

  PetscCall(VecGetOwnershipRange(x, &start, &end));
  for (PetscInt i = start; i < end; i++)
    PetscCall(VecSetValue(x, i, PetscSinReal(1 + 0.7 * i + 0.01 * i * i), INSERT_VALUES));
  return VecAssemble(x);
}

static inline PetscErrorCode MatAssemble(Mat A)
{
  PetscCall(MatAssemblyBegin(A, MAT_FINAL_ASSEMBLY));
  return MatAssemblyEnd(A, MAT_FINAL_ASSEMBLY);
}

/* The database holds these alone */
static inline PetscErrorCode SetOptions(const char options[])
{
  PetscCall(PetscOptionsClear(NULL));
  return PetscOptionsInsertString(NULL, options);
}

/* The numbers of a dense matrix, by columns, likewise */
static inline const PetscScalar *MatRead(Mat A)
{
  const PetscScalar *a, *numbers;

  PetscCallAbort(PETSC_COMM_SELF, MatDenseGetArrayRead(A, &a));
  numbers = a;
  PetscCallAbort(PETSC_COMM_SELF, MatDenseRestoreArrayRead(A, &a));
  return numbers;
}
