/*
  A directory of files that keep what is expensive to set up: the low-rank part of the exact viscosity of a uniform grid.

  It is kept for unit factors of K and H, so that one file serves every thickness, density, damping and scaling. Its
  name holds a hash of all that it depends on, which the file repeats in words. Files are written under a name of their
  own and renamed, so that runs at the same time neither see half a file nor disturb each other.
*/
#include <slipmat.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>
#include <slipstep/private/slipcompat.h>
#include <slipstep/private/sliph5.h>
#include <slipstep/private/slipmat.h>

#define FORMAT "slipstep-viscosity-cache"
#define VERSION 1 /* of the file and of the method */

static const char *const Groups[2] = {"/even", "/odd"};

/* Fowler, Noll & Vo's 64-bit hash, continued from hash. */
static uint64_t Hash(uint64_t hash, const void *data, size_t bytes)
{
  const unsigned char *b = (const unsigned char *)data;

  for (size_t i = 0; i < bytes; i++) hash = (hash ^ b[i]) * 1099511628211ULL;
  return hash;
}
#define HASH_START 14695981039346656037ULL

/* All that the low-rank part depends on, in words; entries of the kernel stand for the code that computes it. */
static PetscErrorCode KeyOf(const SlipGrid *g, PetscReal tolerance, PetscBool dense, char key[], size_t len)
{
  int written;

  PetscFunctionBegin;
  written = snprintf(
    key, len,
    "version %d, nx %lld, nz %lld, length_x %.17g m, length_z %.17g m, depth_top %.17g m, shear_modulus %.17g "
    "Pa, poisson_ratio %.17g, %s, tolerance %.17g, %s, kernel %.17g %.17g %.17g",
    VERSION, (long long)g->nx, (long long)g->nz, (double)g->length_x, (double)g->length_z, (double)g->depth_top,
    (double)g->shear_modulus, (double)g->poisson_ratio, g->full_space ? "full space" : "half space", (double)tolerance,
    dense ? "dense" : "sketch", (double)SlipGridEntry(g, 0, 0, 0), (double)SlipGridEntry(g, g->nx - 1, 0, g->nz - 1),
    (double)SlipGridEntry(g, g->nx / 2, g->nz - 1, g->nz / 2));
  PetscCheck(written > 0 && (size_t)written < len, PETSC_COMM_SELF, PETSC_ERR_PLIB, "Key of the cache is too long");
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode NameOf(const char dir[], const char key[], char name[], size_t len)
{
  PetscFunctionBegin;
  PetscCall(
    PetscSNPrintf(name, len, "%s/viscosity-%016llx.h5", dir, (unsigned long long)Hash(HASH_START, key, strlen(key))));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void ChecksumOf(const SlipLowRank m[2], char text[17])
{
  uint64_t hash = HASH_START;

  for (PetscInt parity = 0; parity < 2; parity++) {
    hash = Hash(hash, m[parity].lambda, (size_t)m[parity].rank * sizeof(PetscReal));
    hash = Hash(hash, m[parity].W, (size_t)m[parity].rank * (size_t)m[parity].n * sizeof(PetscReal));
  }
  (void)snprintf(text, 17, "%016llx", (unsigned long long)hash);
}

static PetscErrorCode CheckFinite(const SlipH5 *h, const char group[], const SlipLowRank *m)
{
  PetscFunctionBegin;
  for (PetscInt k = 0; k < m->rank; k++)
    PetscCheck(!PetscIsInfOrNanReal(m->lambda[k]), PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
               "%s in %s holds a number that is not finite", group, h->name);
  for (size_t i = 0; i < (size_t)m->n * m->rank; i++)
    PetscCheck(!PetscIsInfOrNanReal(m->W[i]), PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
               "%s in %s holds a number that is not finite", group, h->name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadParity(SlipH5 *h, const char group[], SlipLowRank *m)
{
  char path[64];
  PetscInt count[1], shape[2];

  PetscFunctionBegin;
  PetscCall(PetscSNPrintf(path, sizeof(path), "%s/values", group));
  PetscCall(SlipH5ReadReal(h, path, 1, count, &m->lambda));
  PetscCall(PetscSNPrintf(path, sizeof(path), "%s/vectors", group));
  PetscCall(SlipH5ReadReal(h, path, 2, shape, &m->W));
  PetscCheck(shape[0] == count[0] && shape[1] == m->n, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
             "%s in %s has shape [%" PetscInt_FMT ", %" PetscInt_FMT "], expected [%" PetscInt_FMT ", %" PetscInt_FMT
             "]",
             path, h->name, shape[0], shape[1], count[0], m->n);
  m->rank = count[0];
  PetscCall(CheckFinite(h, group, m));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The open file into m, whose n are set. */
static PetscErrorCode ReadOpen(SlipH5 *h, const char key[], SlipLowRank m[2])
{
  char text[1024], sum[17];

  PetscFunctionBegin;
  PetscCall(SlipH5ReadAttrString(h, "/", "format", text, sizeof(text)));
  PetscCheck(!strcmp(text, FORMAT), PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED, "%s is a \"%s\", expected a \"%s\"",
             h->name, text, FORMAT);
  PetscCall(SlipH5ReadAttrString(h, "/", "key", text, sizeof(text)));
  PetscCheck(!strcmp(text, key), PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED, "%s is of \"%s\", expected \"%s\"",
             h->name, text, key);
  for (PetscInt parity = 0; parity < 2; parity++)
    if (m[parity].n) PetscCall(ReadParity(h, Groups[parity], &m[parity]));
  ChecksumOf(m, sum);
  PetscCall(SlipH5ReadAttrString(h, "/", "checksum", text, sizeof(text)));
  PetscCheck(!strcmp(text, sum), PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
             "%s is damaged: its checksum is %s, not %s", h->name, sum, text);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadFile(const char name[], const char key[], SlipLowRank m[2])
{
  PetscErrorCode code;
  SlipH5 h;

  PetscFunctionBegin;
  PetscCall(SlipH5OpenRead(name, &h));
  code = ReadOpen(&h, key, m);
  PetscCall(SlipH5Close(&h));
  PetscCall(code);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode WriteParity(SlipH5 *h, const char group[], const SlipLowRank *m)
{
  const PetscInt shape[2] = {m->rank, m->n};
  char path[64];

  PetscFunctionBegin;
  PetscCall(PetscSNPrintf(path, sizeof(path), "%s/values", group));
  PetscCall(SlipH5WriteReal(h, path, 1, shape, m->lambda, "sqrt(Pa/m)"));
  PetscCall(PetscSNPrintf(path, sizeof(path), "%s/vectors", group));
  PetscCall(SlipH5WriteReal(h, path, 2, shape, m->W, "1"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode WriteFile(const char name[], const char key[], const SlipLowRank m[2])
{
  char own[PETSC_MAX_PATH_LEN], host[64], sum[17];
  PetscErrorCode code;
  SlipH5 h;

  PetscFunctionBegin;
  PetscCall(PetscGetHostName(host, sizeof(host)));
  PetscCall(PetscSNPrintf(own, sizeof(own), "%s.%s.%ld", name, host, (long)getpid()));
  PetscCall(SlipH5Create(own, &h));
  ChecksumOf(m, sum);
  code = SlipH5WriteAttrString(&h, "/", "format", FORMAT);
  if (!code) code = SlipH5WriteAttrString(&h, "/", "key", key);
  if (!code) code = SlipH5WriteAttrString(&h, "/", "checksum", sum);
  for (PetscInt parity = 0; parity < 2; parity++)
    if (!code && m[parity].n) code = WriteParity(&h, Groups[parity], &m[parity]);
  if (code) h.target[0] = '\0'; /* do not rename what is not complete */
  if (!code)
    code = SlipH5Close(&h);
  else
    (void)SlipH5Close(&h);
  if (code) (void)remove(h.name);
  PetscCall(code);
  PetscCheck(!rename(own, name), PETSC_COMM_SELF, PETSC_ERR_FILE_WRITE, "cannot rename %s to %s", own, name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Keeps the message of the first error; ctx is its char[1024]. */
static PetscErrorCode KeepMessage(MPI_Comm comm, int line, const char *function, const char *file, PetscErrorCode code,
                                  PetscErrorType type, const char *message, void *ctx)
{
  (void)comm;
  (void)line;
  (void)function;
  (void)file;
  if (type == PETSC_ERROR_INITIAL && message) (void)PetscStrncpy((char *)ctx, message, 1024);
  return code;
}

/*@
  MatSlipStiffnessSetCacheDir - keep what is expensive to set up for a stiffness in files of a directory

  Logically collective

  Input Parameters:
+ K   - stiffness of MatCreateSlipStiffness()
- dir - an existing directory that can be written to; "" for none

  Notes:
  MatCreateSlipViscosity() of type "sqrtm" for a stiffness of type "fft" looks there first. A file that is damaged or
  belongs to another grid is reported, and replaced. Runs at the same time may share the directory.

  Errors: PETSC_ERR_FILE_OPEN when dir is not a directory that can be written to

  Level: intermediate

.seealso: MatCreateSlipViscosity()
@*/
PetscErrorCode MatSlipStiffnessSetCacheDir(Mat K, const char dir[])
{
  MPI_Comm comm = PetscObjectComm((PetscObject)K);
  PetscContainer container;
  PetscMPIInt rank, good = 1;
  char *copy;

  PetscFunctionBegin;
  if (!dir[0]) {
    PetscCall(PetscObjectCompose((PetscObject)K, "SlipCacheDir", NULL));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  if (!rank) {
    PetscBool is_dir;

    PetscCall(PetscTestDirectory(dir, 'w', &is_dir));
    good = is_dir ? 1 : 0;
  }
  PetscCallMPI(MPI_Bcast(&good, 1, MPI_INT, 0, comm));
  PetscCheck(good, comm, PETSC_ERR_FILE_OPEN,
             "cache directory %s (-fault_cache_dir): no such directory, or it cannot be written to", dir);
  PetscCall(PetscStrallocpy(dir, &copy));
  PetscCall(PetscContainerCreate(comm, &container));
  PetscCall(PetscContainerSetPointer(container, copy));
  PetscCall(SlipContainerSetDestroy(container, SlipContainerDestroyDefault));
  PetscCall(PetscObjectCompose((PetscObject)K, "SlipCacheDir", (PetscObject)container));
  PetscCall(PetscContainerDestroy(&container));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode DirOf(Mat K, const char **dir)
{
  PetscContainer container;
  void *pointer = NULL;

  PetscFunctionBegin;
  PetscCall(PetscObjectQuery((PetscObject)K, "SlipCacheDir", (PetscObject *)&container));
  if (container) PetscCall(PetscContainerGetPointer(container, &pointer));
  *dir = (const char *)pointer;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Rank 0 reads m (n set) for unit factors when the cache of K has it; every rank learns whether. Collective. */
PetscErrorCode SlipCacheLoad(Mat K, const SlipGrid *g, PetscReal tolerance, PetscBool dense, SlipLowRank m[2],
                             PetscBool *found)
{
  MPI_Comm comm = PetscObjectComm((PetscObject)K);
  char key[1024], name[PETSC_MAX_PATH_LEN], message[1024] = "";
  const char *dir;
  PetscMPIInt rank, state = 0;
  PetscBool exists;

  PetscFunctionBegin;
  *found = PETSC_FALSE;
  PetscCall(DirOf(K, &dir));
  if (!dir) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  if (!rank) {
    PetscCall(KeyOf(g, tolerance, dense, key, sizeof(key)));
    PetscCall(NameOf(dir, key, name, sizeof(name)));
    PetscCall(PetscTestFile(name, '\0', &exists));
    if (exists) {
      PetscErrorCode code;

      PetscCall(PetscPushErrorHandler(KeepMessage, message));
      code = ReadFile(name, key, m);
      PetscCall(PetscPopErrorHandler());
      state = code ? 0 : 1;
    }
    for (PetscInt parity = 0; parity < 2 && !state; parity++) {
      PetscCall(PetscFree(m[parity].W));
      PetscCall(PetscFree(m[parity].lambda));
      m[parity].rank = 0;
    }
    if (exists && !state)
      PetscCall(PetscFPrintf(PETSC_COMM_SELF, stderr, "cache: %s; it will be built anew\n", message));
  }
  PetscCallMPI(MPI_Bcast(&state, 1, MPI_INT, 0, comm));
  *found = state ? PETSC_TRUE : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Rank 0 writes m, which all its ranks have, for unit factors. A failure is reported and does not stop the run. */
PetscErrorCode SlipCacheSave(Mat K, const SlipGrid *g, PetscReal tolerance, PetscBool dense, const SlipLowRank m[2])
{
  char key[1024], name[PETSC_MAX_PATH_LEN], message[1024] = "";
  const char *dir;
  PetscErrorCode code;
  PetscMPIInt rank;

  PetscFunctionBegin;
  PetscCall(DirOf(K, &dir));
  PetscCallMPI(MPI_Comm_rank(PetscObjectComm((PetscObject)K), &rank));
  if (!dir || rank) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt parity = 0; parity < 2; parity++)
    if (m[parity].n && !m[parity].rank) PetscFunctionReturn(PETSC_SUCCESS); /* nothing worth keeping */
  PetscCall(KeyOf(g, tolerance, dense, key, sizeof(key)));
  PetscCall(NameOf(dir, key, name, sizeof(name)));
  PetscCall(PetscPushErrorHandler(KeepMessage, message));
  code = WriteFile(name, key, m);
  PetscCall(PetscPopErrorHandler());
  if (code) PetscCall(PetscFPrintf(PETSC_COMM_SELF, stderr, "cache: %s; nothing was kept\n", message));
  PetscFunctionReturn(PETSC_SUCCESS);
}
