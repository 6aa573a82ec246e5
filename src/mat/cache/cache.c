/*
  A directory of files that keep what is expensive to set up (a dense root: cacheroot.c).

  A file's name holds a hash of all that it depends on, which the file repeats in words. Files are written under a name
  of their own and renamed, so that runs at the same time neither see half a file nor disturb each other. A file that
  cannot be used, for whatever reason, is reported and replaced: the cache never decides whether a run succeeds.
*/
#include <slipmat.h>
#include <slipcore.h>
#include <slipsys.h>
#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>
#include <slipstep/private/slipsys.h>
#include <sliph5.h>
#include <slipstep/private/slipmatcache.h>

#define FORMAT "slipstep-viscosity-cache"

/* ---- files; rank 0 only ---- */

static PetscErrorCode NameOf(const char dir[], const char kind[], const char key[], char name[], size_t len)
{
  PetscFunctionBegin;
  PetscCall(PetscSNPrintf(name, len, "%s/%s-%016llx.h5", dir, kind,
                          (unsigned long long)SlipHashBytes(SLIP_HASH_START, key, strlen(key))));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static size_t CountOf(const SlipCacheItem *item)
{
  return (size_t)item->dims[0] * (size_t)(item->ndim > 1 ? item->dims[1] : 1);
}

static void ChecksumOf(PetscInt n, const SlipCacheItem item[], char text[17])
{
  uint64_t hash = SLIP_HASH_START;

  for (PetscInt i = 0; i < n; i++) hash = SlipHashReals(hash, item[i].data, CountOf(&item[i]));
  (void)snprintf(text, 17, "%016llx", (unsigned long long)hash);
}

/* One dataset, of the shape that is known, all of whose numbers are finite. */
static PetscErrorCode ReadItem(SlipH5 *h, SlipCacheItem *item)
{
  PetscInt dims[2] = {1, 1};

  PetscFunctionBegin;
  PetscCall(SlipH5ReadRealSized(h, item->path, item->ndim, item->dims, NULL, dims, &item->data));
  for (PetscInt d = 0; d < item->ndim; d++) item->dims[d] = dims[d];
  for (size_t i = 0; i < CountOf(item); i++)
    PetscCheck(!PetscIsInfOrNanReal(item->data[i]), PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
               "%s in %s holds a number that is not finite", item->path, h->name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadOpen(SlipH5 *h, const char key[], PetscInt n, SlipCacheItem item[])
{
  char text[1024], sum[17];

  PetscFunctionBegin;
  PetscCall(SlipH5ReadAttrString(h, "/", "format", text, sizeof(text)));
  PetscCheck(!strcmp(text, FORMAT), PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED, "%s is a \"%s\", expected a \"%s\"",
             h->name, text, FORMAT);
  PetscCall(SlipH5ReadAttrString(h, "/", "key", text, sizeof(text)));
  PetscCheck(!strcmp(text, key), PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED, "%s is of \"%s\", expected \"%s\"",
             h->name, text, key);
  for (PetscInt i = 0; i < n; i++) PetscCall(ReadItem(h, &item[i]));
  ChecksumOf(n, item, sum);
  PetscCall(SlipH5ReadAttrString(h, "/", "checksum", text, sizeof(text)));
  PetscCheck(!strcmp(text, sum), PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
             "%s is damaged: its checksum is %s, not %s", h->name, sum, text);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode WriteOpen(SlipH5 *h, const char key[], PetscInt n, const SlipCacheItem item[])
{
  char sum[17];

  PetscFunctionBegin;
  ChecksumOf(n, item, sum);
  PetscCall(SlipH5WriteAttrString(h, "/", "format", FORMAT));
  PetscCall(SlipH5WriteAttrString(h, "/", "key", key));
  PetscCall(SlipH5WriteAttrString(h, "/", "checksum", sum));
  for (PetscInt i = 0; i < n; i++)
    PetscCall(SlipH5WriteReal(h, item[i].path, item[i].ndim, item[i].dims, item[i].data, item[i].units));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode WriteFile(const char name[], const char key[], PetscInt n, const SlipCacheItem item[])
{
  char own[PETSC_MAX_PATH_LEN], host[64];
  PetscErrorCode code;
  SlipH5 h;

  PetscFunctionBegin;
  PetscCall(PetscGetHostName(host, sizeof(host)));
  PetscCall(PetscSNPrintf(own, sizeof(own), "%s.%s.%ld", name, host, (long)getpid()));
  PetscCall(SlipH5Create(own, &h));
  code = WriteOpen(&h, key, n, item);
  if (!code)
    code = SlipH5Close(&h);
  else
    (void)SlipH5Abandon(&h);
  PetscCall(code);
  if (rename(own, name)) {
    const int reason = errno;

    (void)remove(own);
    SETERRQ(PETSC_COMM_SELF, PETSC_ERR_FILE_WRITE, "cannot replace %s: %s", name, strerror(reason));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the cache of a stiffness ---- */

/* Keeps the message of the first error; ctx is its char[1024]. */
static PetscErrorCode KeepMessage(MPI_Comm comm, int line, const char *function, const char *file, PetscErrorCode code,
                                  PetscErrorType type, const char *message, void *ctx)
{
  (void)comm, (void)line, (void)function, (void)file;
  if (type == PETSC_ERROR_INITIAL && message) (void)PetscStrncpy((char *)ctx, message, 1024);
  return code;
}

/* Rank 0: the items of the file, or a warning; those of a file that cannot be used are freed. */
static PetscErrorCode ReadOrWarn(const char name[], const char key[], PetscInt n, SlipCacheItem item[], PetscBool *good)
{
  char message[1024] = "";
  PetscErrorCode code;
  SlipH5 h;

  PetscFunctionBegin;
  PetscCall(PetscTestFile(name, '\0', good));
  if (!*good) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscPushErrorHandler(KeepMessage, message));
  code = SlipH5OpenRead(name, &h);
  if (!code) {
    code = ReadOpen(&h, key, n, item);
    PetscCall(SlipH5Close(&h));
  }
  PetscCall(PetscPopErrorHandler());
  if (!code) PetscFunctionReturn(PETSC_SUCCESS);
  *good = PETSC_FALSE;
  for (PetscInt i = 0; i < n; i++) PetscCall(PetscFree(item[i].data));
  PetscCall(SlipWarning("%s; it is computed again", message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Rank 0 reads the n items, whose paths and known dimensions are set (-1: any), when the cache of K has them; their data
  are then the caller's to free. Every rank learns whether. Collective.
*/
PetscErrorCode SlipCacheRead(Mat K, const char kind[], const char key[], PetscInt n, SlipCacheItem item[],
                             PetscBool *found)
{
  MPI_Comm comm = PetscObjectComm((PetscObject)K);
  char name[PETSC_MAX_PATH_LEN] = "";
  const char *dir;
  PetscMPIInt rank;

  PetscFunctionBegin;
  *found = PETSC_FALSE;
  PetscCall(SlipObjectQueryData((PetscObject)K, "SlipCacheDir", &dir));
  if (!dir) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  if (!rank) {
    PetscCall(NameOf(dir, kind, key, name, sizeof(name)));
    PetscCall(ReadOrWarn(name, key, n, item, found));
  }
  PetscCallMPI(MPI_Bcast(found, 1, MPIU_BOOL, 0, comm));
  if (*found) PetscCall(SlipNote(K, "SlipCache", "read from %s", name));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Rank 0 writes the n items. A failure is reported and does not stop the run. */
PetscErrorCode SlipCacheWrite(Mat K, const char kind[], const char key[], PetscInt n, const SlipCacheItem item[])
{
  char name[PETSC_MAX_PATH_LEN], message[1024] = "";
  const char *dir;
  PetscErrorCode code;
  PetscMPIInt rank;

  PetscFunctionBegin;
  PetscCall(SlipObjectQueryData((PetscObject)K, "SlipCacheDir", &dir));
  PetscCallMPI(MPI_Comm_rank(PetscObjectComm((PetscObject)K), &rank));
  if (!dir || rank) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(NameOf(dir, kind, key, name, sizeof(name)));
  PetscCall(PetscPushErrorHandler(KeepMessage, message));
  code = WriteFile(name, key, n, item);
  PetscCall(PetscPopErrorHandler());
  if (code) PetscCall(SlipWarning("%s; nothing was stored", message));
  PetscCall(SlipNote(K, "SlipCache", code ? "%s could not be written" : "not found, written to %s", name));
  PetscFunctionReturn(PETSC_SUCCESS);
}
