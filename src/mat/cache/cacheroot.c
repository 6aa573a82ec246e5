/*
  The square root of a dense stiffness in the cache (cache.c), for unit factors, so that one file serves every
  thickness, density, damping and scaling. A dense matrix may come from anywhere, a grid, a mesh or a file, so
  the key is a fingerprint of its entries, taken when the cache is set and so before any scaling: what a root is good
  for is then certain, and the same on every number of ranks, where the scaling factor may differ in its last bits.
*/
#include <slipcore.h>
#include <slipmat.h>
#include <slipcells.h>
#include <stdio.h>
#include <slipstep/private/slipsys.h>
#include <slipstep/private/slipmatcache.h>

/* From this many rows on a root takes a second and more, and reading it a tenth of that. */
#define SLIP_CACHE_ROOT_MIN 1500

typedef struct {
  uint64_t hash;
  PetscReal first; /* entry (0, 0) at that time, which shows later scaling */
} Fingerprint;

/* Sum over the rows of a hash of each with its number and weight, so that it does not matter which rank has which. */
static PetscErrorCode HashOf(Mat K, uint64_t *hash)
{
  const PetscScalar *a, *w = NULL;
  PetscReal *row;
  PetscInt start, end, N, lda;
  Vec weights;

  PetscFunctionBegin;
  *hash = 0;
  PetscCall(MatGetSize(K, NULL, &N));
  PetscCall(MatGetOwnershipRange(K, &start, &end));
  PetscCall(MatSlipGetWeights(K, &weights));
  if (weights) PetscCall(VecGetArrayRead(weights, &w));
  PetscCall(PetscMalloc1(N + 2, &row));
  PetscCall(MatDenseGetLDA(K, &lda));
  PetscCall(MatDenseGetArrayRead(K, &a));
  for (PetscInt i = 0; i < end - start; i++) {
    row[0] = (PetscReal)(start + i);
    row[1] = w ? PetscRealPart(w[i]) : 1;
    for (PetscInt j = 0; j < N; j++) row[2 + j] = PetscRealPart(a[(size_t)j * lda + i]);
    *hash += SlipHashReals(SLIP_HASH_START, row, (size_t)N + 2);
  }
  PetscCall(MatDenseRestoreArrayRead(K, &a));
  if (weights) PetscCall(VecRestoreArrayRead(weights, &w));
  PetscCall(PetscFree(row));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, hash, 1, MPI_UINT64_T, MPI_SUM, PetscObjectComm((PetscObject)K)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Fingerprint of a dense K whose root is worth keeping; of others, none. Collective. */
static PetscErrorCode SlipFingerprintCompose(Mat K)
{
  Fingerprint *f;
  PetscBool dense;
  PetscInt N;

  PetscFunctionBegin;
  PetscCall(PetscObjectTypeCompareAny((PetscObject)K, &dense, MATSEQDENSE, MATMPIDENSE, ""));
  PetscCall(MatGetSize(K, &N, NULL));
  if (!dense || N < SLIP_CACHE_ROOT_MIN) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscNew(&f));
  PetscCall(HashOf(K, &f->hash));
  PetscCall(SlipFirstEntry(K, &f->first));
  PetscCall(SlipObjectComposeData((PetscObject)K, "SlipFingerprint", f, SlipContainerDestroyDefault));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  MatSlipStiffnessSetCacheDir - keep what is expensive to set up for a stiffness in files of a directory

  Logically collective

  Input Parameters:
+ K   - stiffness of MatCreateSlipStiffness() or one of its sisters
- dir - an existing directory; "" for none

  Notes:
  MatCreateSlipViscosity() of type "sqrtm" looks there first for the root of a dense stiffness of at least 1500 rows.
  Other roots are set up in less than a second, or not at all, and are not kept. A file that is damaged or belongs to
  another stiffness is reported, and replaced. One in a directory that cannot be written to is used; a new one then gives
  a warning. Runs at the same time may share the directory. Call it before MatScale():
  the scale may then differ from run to run.

  Errors: PETSC_ERR_FILE_OPEN when dir is not a directory that can be read

  Level: intermediate

.seealso: MatCreateSlipViscosity()
@*/
PetscErrorCode MatSlipStiffnessSetCacheDir(Mat K, const char dir[])
{
  MPI_Comm comm = PetscObjectComm((PetscObject)K);
  PetscMPIInt rank;
  PetscBool good;
  char *copy;

  PetscFunctionBegin;
  if (!dir[0]) {
    PetscCall(PetscObjectCompose((PetscObject)K, "SlipCacheDir", NULL));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  if (!rank)
    PetscCall(PetscTestDirectory(dir, 'r', &good)); /* what cannot be written is a warning when it comes to it */
  PetscCallMPI(MPI_Bcast(&good, 1, MPIU_BOOL, 0, comm));
  PetscCheck(good, comm, PETSC_ERR_FILE_OPEN, "cache directory %s: no such directory, or it cannot be read", dir);
  PetscCall(PetscStrallocpy(dir, &copy));
  PetscCall(SlipObjectComposeData((PetscObject)K, "SlipCacheDir", copy, SlipContainerDestroyDefault));
  PetscCall(SlipFingerprintCompose(K));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The key of K's root; empty when it has no cache or is not worth it. *unit: root of K over the root that is kept;
   item: where it is kept. */
static PetscErrorCode KeyOf(Mat K, char key[], size_t len, PetscReal *unit, SlipCacheItem *item)
{
  const Fingerprint *f;
  PetscReal now;
  PetscInt N;

  PetscFunctionBegin;
  key[0] = '\0';
  *unit = 1;
  PetscCall(MatGetSize(K, &N, NULL));
  *item = (SlipCacheItem){"/root", "sqrt(Pa/m)", 2, {N, N}, NULL};
  PetscCall(SlipObjectQueryData((PetscObject)K, "SlipFingerprint", &f));
  if (!f) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipFirstEntry(K, &now));
  *unit = PetscSqrtReal(now / f->first);
  (void)snprintf(key, len,
                 "version %d, dense root, rows %lld, fingerprint of the entries %016llx, first entry %.17g Pa/m",
                 SLIP_CACHE_VERSION, (long long)N, (unsigned long long)f->hash, (double)f->first);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void ScaleRoot(const SlipCacheItem *item, PetscReal factor, PetscReal root[])
{
  const size_t n = (size_t)item->dims[0] * (size_t)item->dims[1];

  for (size_t k = 0; root && k < n; k++) root[k] *= factor;
}

/*
  root [N * N], on rank 0 only, = sqrt(K) (weighted: of D^-1 K D^-1) when the cache of K has it; every rank learns
  whether. Collective.
*/
PetscErrorCode SlipCacheLoadRoot(Mat K, PetscReal **root, PetscBool *found)
{
  SlipCacheItem item;
  char key[256];
  PetscReal unit;

  PetscFunctionBegin;
  *root = NULL;
  *found = PETSC_FALSE;
  PetscCall(KeyOf(K, key, sizeof(key), &unit, &item));
  if (!key[0]) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipCacheRead(K, "root", key, 1, &item, found));
  *root = item.data; /* rank 0's */
  ScaleRoot(&item, unit, *root);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Keeps the root that rank 0 has computed, which goes through the units that it is kept in, so that a run rounds alike
   whether it computed or read it. Collective. */
PetscErrorCode SlipCacheSaveRoot(Mat K, PetscReal root[])
{
  SlipCacheItem item;
  char key[256];
  PetscReal unit;

  PetscFunctionBegin;
  PetscCall(KeyOf(K, key, sizeof(key), &unit, &item));
  if (!key[0]) PetscFunctionReturn(PETSC_SUCCESS);
  item.data = root;
  ScaleRoot(&item, 1 / unit, root);
  PetscCall(SlipCacheWrite(K, "root", key, 1, &item));
  ScaleRoot(&item, unit, root);
  PetscFunctionReturn(PETSC_SUCCESS);
}
