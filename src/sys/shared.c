/*
  Arrays that the processes of a machine hold once: the cells of a mesh, their order, and the clusters of a matrix,
  which each process reads in all parts while it computes its blocks. A thousand processes on eight machines then take
  the memory of eight meshes.

  The memory is POSIX's. The name of a segment is removed as soon as all have it, so that nothing is left of a process
  that is killed, and its pages are allocated at once, so that a full file system is found here: the array is then one
  for each process. MPI's windows (Open MPI 4.1) make the other processes wait for ever in that case. Where a process is
  alone on its machine, arrays are those of PetscMalloc().
*/
#define _POSIX_C_SOURCE 200809L /* posix_fallocate() */
#include <slipstep/private/slipsys.h>
#include <slipcompat.h>
#include <fcntl.h>
#if defined(__GLIBC__)
  #include <malloc.h>
#endif
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

typedef struct {
  void *data;
  size_t bytes;
  PetscBool shared; /* by the processes of the machine */
} Array;

struct _SlipShared {
  MPI_Comm machine;       /* the processes of this machine */
  MPI_Comm first;         /* the first process of each machine; MPI_COMM_NULL on others */
  PetscMPIInt rank, size; /* on this machine */
  PetscInt n, capacity;
  Array *array;
};

/* Creates an owner of arrays. Collective, as are all functions here but those that return a value,
   SlipSharedSlice() and SlipSharedFree(). */
PetscErrorCode SlipSharedCreate(MPI_Comm comm, SlipShared *shared)
{
  SlipShared s;
  PetscMPIInt rank;

  PetscFunctionBegin;
  PetscCall(PetscNew(&s));
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCallMPI(MPI_Comm_split_type(comm, MPI_COMM_TYPE_SHARED, rank, MPI_INFO_NULL, &s->machine));
  PetscCallMPI(MPI_Comm_rank(s->machine, &s->rank));
  PetscCallMPI(MPI_Comm_size(s->machine, &s->size));
  PetscCallMPI(MPI_Comm_split(comm, s->rank ? MPI_UNDEFINED : 0, rank, &s->first));
  *shared = s;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Maps the segment of a name, which the first process creates, or returns NULL. */
static void *Map(const char name[], PetscBool create, size_t bytes)
{
  struct rlimit most; /* beyond it a signal would end the process */
  void *data = MAP_FAILED;
  int file;

  if (create && (getrlimit(RLIMIT_FSIZE, &most) || most.rlim_cur < (rlim_t)bytes)) return NULL;
  file = shm_open(name, create ? O_RDWR | O_CREAT | O_EXCL : O_RDWR, 0600);
  if (file < 0) return NULL;
  if (!create || !posix_fallocate(file, 0, (off_t)bytes))
    data = mmap(NULL, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
  (void)close(file);
  if (create && data == MAP_FAILED) (void)shm_unlink(name);
  return data == MAP_FAILED ? NULL : data;
}

/* Maps a new segment on all processes of the machine, or returns NULL on all. */
static PetscErrorCode Share(SlipShared s, size_t bytes, void **data)
{
  static int count = 0;
  char name[64] = "";
  struct timespec now;
  int all;

  PetscFunctionBegin;
  *data = NULL;
  if (!s->rank) {
    (void)clock_gettime(CLOCK_MONOTONIC, &now);
    (void)snprintf(name, sizeof(name), "/slipstep-%ld-%lx-%d", (long)getpid(), (unsigned long)now.tv_nsec, count++);
    *data = Map(name, PETSC_TRUE, bytes);
    if (!*data) name[0] = 0;
  }
  PetscCallMPI(MPI_Bcast(name, sizeof(name), MPI_CHAR, 0, s->machine));
  if (s->rank && name[0]) *data = Map(name, PETSC_FALSE, bytes);
  all = *data ? 1 : 0;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &all, 1, MPI_INT, MPI_MIN, s->machine));
  if (!s->rank && name[0]) (void)shm_unlink(name);
  if (!all && *data) (void)munmap(*data, bytes);
  if (!all) *data = NULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Warns once that processes hold arrays of their own. */
static PetscErrorCode Warn(SlipShared s, size_t bytes)
{
  static PetscBool warned = PETSC_FALSE;

  PetscFunctionBegin;
  if (!s->rank && !warned)
    PetscCall(SlipWarning("the %d processes of a machine cannot share %.3g MB of memory: each has its own. Expected "
                          "that much room in /dev/shm, which containers limit",
                          (int)s->size, 1e-6 * (double)bytes));
  warned = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Add(SlipShared s, Array a)
{
  PetscFunctionBegin;
  if (s->n == s->capacity) {
    Array *more;

    PetscCall(PetscMalloc1(2 * s->capacity + 8, &more));
    PetscCall(PetscArraycpy(more, s->array, s->n));
    PetscCall(PetscFree(s->array));
    s->array = more;
    s->capacity = 2 * s->capacity + 8;
  }
  s->array[s->n++] = a;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Allocates an array, whose address array points to. Where it cannot be shared each process has its own. */
PetscErrorCode SlipSharedMalloc(SlipShared s, size_t bytes, void *array)
{
  Array a = {.bytes = PetscMax(bytes, 1)};

  PetscFunctionBegin;
  if (s->size > 1) {
    PetscCall(Share(s, a.bytes, &a.data));
    a.shared = a.data ? PETSC_TRUE : PETSC_FALSE;
    if (!a.shared) PetscCall(Warn(s, a.bytes));
  }
  if (!a.shared) PetscCall(PetscMalloc(a.bytes, &a.data));
  PetscCall(Add(s, a));
  *(void **)array = a.data;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static Array *Find(SlipShared s, const void *data)
{
  for (PetscInt i = 0; i < s->n; i++)
    if (s->array[i].data == data) return &s->array[i];
  return NULL;
}

static PetscErrorCode Free(Array *a)
{
  PetscFunctionBegin;
  if (a->shared)
    (void)munmap(a->data, a->bytes);
  else
    PetscCall(PetscFree(a->data));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Frees one array, whose address array points to and becomes NULL; NULL is left. */
PetscErrorCode SlipSharedFree(SlipShared s, void *array)
{
  Array *a = *(void **)array ? Find(s, *(void **)array) : NULL;

  PetscFunctionBegin;
  *(void **)array = NULL;
  if (!a) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Free(a));
  *a = s->array[--s->n];
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipSharedDestroy(SlipShared *shared)
{
  SlipShared s = *shared;

  PetscFunctionBegin;
  if (!s) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt i = 0; i < s->n; i++) PetscCall(Free(&s->array[i]));
  PetscCall(PetscFree(s->array));
  PetscCallMPI(MPI_Comm_free(&s->machine));
  if (s->first != MPI_COMM_NULL) PetscCallMPI(MPI_Comm_free(&s->first));
  PetscCall(PetscFree(*shared));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets which of n items of an array this process computes: start, start + 1 ... end - 1. */
void SlipSharedSlice(SlipShared s, const void *array, PetscInt n, PetscInt *start, PetscInt *end)
{
  const PetscBool all = Find(s, array)->shared ? PETSC_FALSE : PETSC_TRUE;

  *start = all ? 0 : (PetscInt)((PetscInt64)n * s->rank / s->size);
  *end = all ? n : (PetscInt)((PetscInt64)n * (s->rank + 1) / s->size);
}

/* Waits until all processes of the machine have filled their parts of the arrays, which all may read then. */
PetscErrorCode SlipSharedReady(SlipShared s)
{
  PetscFunctionBegin;
  if (s->size > 1) PetscCallMPI(MPI_Barrier(s->machine));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sends n numbers of the first process' array to all others. */
PetscErrorCode SlipSharedBcast(SlipShared s, void *array, PetscInt n, MPI_Datatype type)
{
  PetscMPIInt count;

  PetscFunctionBegin;
  PetscCall(PetscMPIIntCast(n, &count));
  if (s->first != MPI_COMM_NULL) PetscCallMPI(MPI_Bcast(array, count, type, 0, s->first));
  if (s->size > 1 && !Find(s, array)->shared) PetscCallMPI(MPI_Bcast(array, count, type, 0, s->machine));
  PetscCall(SlipSharedReady(s));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Replaces an array of PetscMalloc() that the first process of each machine has computed, of so many bytes there, by
   one that all hold. */
PetscErrorCode SlipSharedMove(SlipShared s, size_t bytes, void *array)
{
  unsigned long size = (unsigned long)bytes;
  void *own = *(void **)array;
  PetscMPIInt count;

  PetscFunctionBegin;
  if (s->size == 1) {
    PetscCall(Add(s, (Array){.data = own, .bytes = bytes}));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCallMPI(MPI_Bcast(&size, 1, MPI_UNSIGNED_LONG, 0, s->machine));
  PetscCall(SlipSharedMalloc(s, size, array));
  if (!s->rank) {
    memcpy(*(void **)array, own, size);
    PetscCall(PetscFree(own));
  }
  if (!Find(s, *(void **)array)->shared) {
    PetscCall(PetscMPIIntCast((PetscInt)size, &count));
    PetscCallMPI(MPI_Bcast(*(void **)array, count, MPI_BYTE, 0, s->machine));
  }
  PetscCall(SlipSharedReady(s));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sends a few values that the first process of each machine has computed to the others there. */
PetscErrorCode SlipSharedValues(SlipShared s, PetscInt n, PetscInt values[])
{
  PetscFunctionBegin;
  PetscCallMPI(MPI_Bcast(values, (PetscMPIInt)n, MPIU_INT, 0, s->machine));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns whether this process is the first of its machine, which computes what SlipSharedMove() moves
   and SlipSharedValues() sends. */
PetscBool SlipSharedFirst(SlipShared s)
{
  return s->rank ? PETSC_FALSE : PETSC_TRUE;
}

/* Gives freed memory back to the system: glibc keeps it, and the first process frees much while others wait. */
void SlipMemoryReturn(void)
{
#if defined(__GLIBC__)
  (void)malloc_trim(0);
#endif
}

/* Returns the memory of the arrays on this machine [B]. */
PetscReal SlipSharedMachineBytes(SlipShared s)
{
  PetscReal bytes = 0;

  for (PetscInt i = 0; i < s->n; i++)
    bytes += (PetscReal)s->array[i].bytes * (s->array[i].shared ? 1 : (PetscReal)s->size);
  return bytes;
}
