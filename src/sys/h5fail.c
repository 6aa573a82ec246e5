/* The files that this process writes, and the end of one whose write fails: the error says where and why. */
#include <slipstep/private/slipsys.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

static SlipH5 *written[SLIP_H5_WRITTEN];

SlipH5 *SlipH5Written(int i)
{
  return i < SLIP_H5_WRITTEN ? written[i] : NULL;
}

void SlipH5Enlist(SlipH5 *h)
{
  int i = 0;

  while (i < SLIP_H5_WRITTEN - 1 && written[i]) i++;
  written[i] = h;
}

/* Gives up what was claimed */
void SlipH5Release(SlipH5 *h, PetscBool keep)
{
  for (int i = 0; i < SLIP_H5_WRITTEN; i++)
    if (written[i] == h) written[i] = NULL;
  if (h->fd >= 0 && !keep) unlink(h->name);
  if (h->fd >= 0) close(h->fd);
  h->fd = -1;
  h->id = -1;
}

/* What the file does not have yet it does not get: neither whole rows of some series nor the end that HDF5 would write. */
void SlipH5CloseAsIs(SlipH5 *h, int reason)
{
  if (!h->failed) h->failed = reason;
  if (h->id > 0) (void)H5Fclose(h->id);
}

PetscErrorCode SlipH5WriteFailed(SlipH5 *h, int reason, const char format[], ...)
{
  const PetscBool live = h->live;
  char what[2 * PETSC_MAX_PATH_LEN];
  va_list args;

  PetscFunctionBegin;
  va_start(args, format);
  (void)vsnprintf(what, sizeof(what), format, args);
  va_end(args);
  SlipH5CloseAsIs(h, reason);
  SlipH5Release(h, live);
  SETERRQ(PETSC_COMM_SELF, PETSC_ERR_FILE_WRITE, "cannot write %s: %s%s%s", what, strerror(h->failed),
          live ? "; the file keeps the whole rows before it" : "", h->source);
}
