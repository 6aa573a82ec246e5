/* What remains to be done with an HDF5 file when a write fails: it is closed, HDF5 must not crash over it at the end of the
   program, and the error says where and why. */
#define _GNU_SOURCE /* memfd_create() */
#include <slipstep/private/slipsys.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

/* The files that this process writes */
static SlipH5 *written[SLIP_H5_WRITTEN];

SlipH5 *SlipH5Written(int i)
{
  return i < SLIP_H5_WRITTEN ? written[i] : NULL;
}

/* While files are written, one that reaches the limit of sizes (RLIMIT_FSIZE) is an error of the write: by default there is
   a signal that ends the process. SlipH5MakeRoom() knows of the limit, but it may be lowered after that. */
static void SlipH5IgnoreLimitSignal(PetscBool ignore)
{
  static PetscBool ignored = PETSC_FALSE;
  struct sigaction action;

  if (ignore == ignored || sigaction(SIGXFSZ, NULL, &action)) return;
  if (action.sa_handler != (ignore ? SIG_DFL : SIG_IGN)) return; /* a handler of the program's */
  action.sa_handler = ignore ? SIG_IGN : SIG_DFL;
  if (!sigaction(SIGXFSZ, &action, NULL)) ignored = ignore;
}

void SlipH5Enlist(SlipH5 *h)
{
  int i = 0;

  SlipH5IgnoreLimitSignal(PETSC_TRUE);
  while (i < SLIP_H5_WRITTEN - 1 && written[i]) i++;
  written[i] = h;
}

/* Gives up what was claimed */
void SlipH5Release(SlipH5 *h, PetscBool keep)
{
  PetscBool more = PETSC_FALSE;

  for (int i = 0; i < SLIP_H5_WRITTEN; i++) {
    if (written[i] == h) written[i] = NULL;
    if (written[i]) more = PETSC_TRUE;
  }
  if (h->fd >= 0 && !keep) unlink(h->name);
  if (h->fd >= 0) close(h->fd);
  h->fd = -1;
  h->id = -1;
  if (!more) SlipH5IgnoreLimitSignal(PETSC_FALSE);
}

/* HDF5 could not close a file: its clean-up at exit is to be avoided */
static PetscBool stuck = PETSC_FALSE;

/* H5Fclose() of a file that can be written; 0, or errno */
int SlipH5CloseId(hid_t id)
{
  errno = 0;
  if (H5Fclose(id) >= 0) return 0;
  stuck = PETSC_TRUE;
  return errno ? errno : EIO;
}

PetscBool SlipH5IsStuck(void)
{
  return stuck;
}

/*
  Closes a file without writing to it any more, neither now nor in HDF5's own clean-up at exit, which crashes or does not
  end where it cannot: HDF5's descriptor becomes one of a file in memory. Limits of the size of files count there too.
*/
void SlipH5CloseNowhere(SlipH5 *h)
{
  struct rlimit limit, all;
  void *handle = NULL;
  int nowhere = -1;

#if defined(MFD_CLOEXEC)
  nowhere = memfd_create("nowhere", MFD_CLOEXEC);
#endif
  if (nowhere < 0) nowhere = open("/dev/null", O_RDWR | O_CLOEXEC);
  if (nowhere >= 0 && H5Fget_vfd_handle(h->id, H5P_DEFAULT, &handle) >= 0 && handle)
    (void)dup2(nowhere, *(int *)handle);
  if (nowhere >= 0) close(nowhere);
  (void)getrlimit(RLIMIT_FSIZE, &limit);
  all = (struct rlimit){limit.rlim_max, limit.rlim_max};
  (void)setrlimit(RLIMIT_FSIZE, &all);
  if (H5Fclose(h->id) < 0) stuck = PETSC_TRUE;
  (void)setrlimit(RLIMIT_FSIZE, &limit);
}

PetscErrorCode SlipH5WriteFailed(SlipH5 *h, int reason, PetscBool sound, const char format[], ...)
{
  const PetscBool live = h->live;
  char what[2 * PETSC_MAX_PATH_LEN];
  struct statvfs disk;
  va_list args;

  PetscFunctionBegin;
  va_start(args, format);
  (void)vsnprintf(what, sizeof(what), format, args);
  va_end(args);
  if (!reason && h->fd >= 0 && !fstatvfs(h->fd, &disk) && !disk.f_bavail) reason = ENOSPC; /* HDF5 kept it to itself */
  if (h->id > 0) {
    const PetscBool keep =
      live && sound && !SlipH5IsBeyondLimit(h->fd) && H5Fflush(h->id, H5F_SCOPE_LOCAL) >= 0 ? PETSC_TRUE : PETSC_FALSE;

    if (!keep)
      SlipH5CloseNowhere(h);
    else
      (void)SlipH5CloseId(h->id);
    if (live) (void)(keep ? SlipH5Trim(h->fd) : SlipH5MakeReadable(h->fd));
  }
  SlipH5Release(h, live);
  SETERRQ(PETSC_COMM_SELF, PETSC_ERR_FILE_WRITE, "cannot write %s: %s%s%s", what,
          reason ? strerror(reason) : "HDF5 gives no reason", live ? "; the file keeps the whole rows before it" : "",
          h->source);
}
