/* The files that this process writes, and the end of one whose write fails: the error says where and why. */
#define _POSIX_C_SOURCE 200809L
#include <slipstep/private/slipsys.h>
#include <errno.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* Also of one whose SlipH5 is gone, as after an error that a program outlives: that one is found no more. */
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

/* While files are written, one that reaches the limit of sizes (RLIMIT_FSIZE) is an error of the write: by default
   there is a signal that ends the process, as the handlers of compilers for OpenCL end it, which MPI may load when it
   looks for devices. Who handled it before has it again when all files are closed, unless somebody else has taken it
   meanwhile. */
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

/* Gives up what was claimed */
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

/* Closes a file for HDF5; after a write that failed nothing more is written. 0, or errno */
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
