/* The list of files that this process writes, and how a file ends whose write fails: the error message has the place
   and the reason. */
#define _POSIX_C_SOURCE 200809L
#include <slipstep/private/slipsys.h>
#include <errno.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* An entry may remain without its SlipH5, after an error that a program survives; it is then not found any more. */
typedef struct SlipH5Entry {
  SlipH5 *h;
  dev_t device;
  ino_t inode;
  struct SlipH5Entry *next;
} SlipH5Entry;
static SlipH5Entry *written = NULL;

SlipH5 *SlipH5Written(int i)
{
  const SlipH5Entry *entry = written;

  while (entry && i--) entry = entry->next;
  return entry ? entry->h : NULL;
}

SlipH5 *SlipH5WrittenAs(const struct stat *info)
{
  const SlipH5Entry *entry = written;

  while (entry && (entry->device != info->st_dev || entry->inode != info->st_ino)) entry = entry->next;
  return entry ? entry->h : NULL;
}

/* While files are open for writing, exceeding the limit of the file size (RLIMIT_FSIZE) becomes an error of the write.
   By default a signal ends the process, also by handlers of OpenCL compilers, which MPI may load when it looks for
   devices. The previous handler is restored when all files are closed, unless another one was installed meanwhile. */
static struct sigaction limit_before;
static PetscBool limit_ours = PETSC_FALSE;

void SlipH5IgnoreLimitSignal(void)
{
  struct sigaction now, ignore = {.sa_handler = SIG_IGN};

  if (sigaction(SIGXFSZ, NULL, &now) || now.sa_handler == SIG_IGN) return;
  sigemptyset(&ignore.sa_mask);
  if (sigaction(SIGXFSZ, &ignore, NULL)) return;
  limit_before = now;
  limit_ours = PETSC_TRUE;
}

static void SlipH5RestoreLimitSignal(void)
{
  struct sigaction now;

  if (limit_ours && !sigaction(SIGXFSZ, NULL, &now) && now.sa_handler == SIG_IGN)
    (void)sigaction(SIGXFSZ, &limit_before, NULL);
  limit_ours = PETSC_FALSE;
}

PetscErrorCode SlipH5Enlist(SlipH5 *h)
{
  struct stat info;
  SlipH5Entry *entry;

  PetscFunctionBegin;
  PetscCheck(!fstat(h->fd, &info), PETSC_COMM_SELF, PETSC_ERR_FILE_OPEN, "cannot create %s: %s%s", h->name,
             strerror(errno), h->source);
  PetscCall(PetscNew(&entry));
  *entry = (SlipH5Entry){h, info.st_dev, info.st_ino, written};
  written = entry;
  SlipH5IgnoreLimitSignal();
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Releases the lock and the temporary file. */
void SlipH5Release(SlipH5 *h, PetscBool keep)
{
  for (SlipH5Entry **at = &written, *entry; (entry = *at);) {
    if (entry->h != h) {
      at = &entry->next;
      continue;
    }
    *at = entry->next;
    (void)PetscFree(entry);
  }
  if (h->fd >= 0 && !keep) unlink(h->name);
  if (h->fd >= 0) close(h->fd);
  h->fd = -1;
  h->id = -1;
  if (!written) SlipH5RestoreLimitSignal();
}

/* Closes a file in HDF5; after a failed write nothing more is written. Returns 0 or errno. */
int SlipH5CloseId(SlipH5 *h)
{
  if (h->id > 0 && H5Fclose(h->id) < 0 && !h->failed) h->failed = EIO;
  h->id = -1;
  return h->failed;
}

PetscErrorCode SlipH5WriteFailed(SlipH5 *h, int reason, const char format[], ...)
{
  char what[2 * PETSC_MAX_PATH_LEN];
  va_list args;

  PetscFunctionBegin;
  va_start(args, format);
  (void)vsnprintf(what, sizeof(what), format, args);
  va_end(args);
  if (!reason) reason = h->failed;
  if (!h->failed && !(h->live && reason)) h->failed = reason ? reason : EIO;
  if (h->id > 0 && !h->failed) (void)H5Fflush(h->id, H5F_SCOPE_LOCAL);
  (void)SlipH5CloseId(h);
  SlipH5Release(h, h->live);
  SETERRQ(PETSC_COMM_SELF, PETSC_ERR_FILE_WRITE, "cannot write %s: %s%s%s", what,
          reason ? strerror(reason) : "HDF5 gives no reason",
          h->live ? "; the file keeps the whole rows before it" : "", h->source);
}
