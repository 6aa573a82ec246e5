/* Files with the state of a run: HDF5 after a block of 512 bytes that has the checksum of the rest, so that changed or
   truncated files are detected before HDF5 reads them. A new file is written like every output (h5output.c), and the
   previous one is renamed to FILE.previous. */
#define _POSIX_C_SOURCE 200809L
#include <slipstep/private/sliph5.h>
#include <slipstep/private/slipstate.h>
#include <slipstep/private/slipsys.h>
#include <slipstep/rooms/slipsys.h>
#include <slipstep/rooms/slipcore.h>
#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define STATE_FORMAT "slipstep-checkpoint"
#define STATE_VERSION 11
#define STATE_BLOCK 512    /* bytes before those of HDF5, which requires a power of two from 512 on */
#define STATE_WORDS 131072 /* words that are hashed at a time */
#define STATE_PREVIOUS ".previous"
#define STATE_SUFFIX_LEN 16

/* Writes the first block, which describes the bytes after it. */
static void StateBlock(uint64_t checksum, uint64_t bytes, char block[STATE_BLOCK])
{
  memset(block, 0, STATE_BLOCK);
  (void)snprintf(block, STATE_BLOCK, "%s %d\nchecksum %016" PRIx64 " of %" PRIu64 " bytes\n", STATE_FORMAT,
                 STATE_VERSION, checksum, bytes);
}

/* Hashes the bytes after the first block; an incomplete last word is filled with zeros. */
static PetscErrorCode StateChecksum(FILE *f, const char name[], uint64_t *checksum, uint64_t *bytes)
{
  PetscReal *words;
  size_t n;
  PetscBool good;

  PetscFunctionBegin;
  *checksum = SLIP_HASH_START;
  *bytes = 0;
  PetscCall(PetscMalloc1(STATE_WORDS, &words));
  good = fseek(f, STATE_BLOCK, SEEK_SET) ? PETSC_FALSE : PETSC_TRUE;
  while (good && (n = fread(words, 1, STATE_WORDS * sizeof(*words), f)) > 0) {
    memset((char *)words + n, 0, STATE_WORDS * sizeof(*words) - n);
    *checksum = SlipHashReals(*checksum, words, (n + sizeof(*words) - 1) / sizeof(*words));
    *bytes += n;
  }
  PetscCall(PetscFree(words));
  PetscCheck(good && !ferror(f), PETSC_COMM_SELF, PETSC_ERR_FILE_READ, "cannot read %s: %s", name, strerror(errno));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds why the file differs from a state as it was written, or NULL if it does not. */
static PetscErrorCode StateVerify(const char name[], const char **why)
{
  static const char format[] = STATE_FORMAT " " PetscStringize(STATE_VERSION) "\n";
  FILE *f = fopen(name, "rb");
  char found[STATE_BLOCK], block[STATE_BLOCK];
  uint64_t checksum, bytes;

  PetscFunctionBegin;
  *why = NULL;
  if (!f) *why = errno == ENOENT ? "there is no such file" : strerror(errno);
  if (!f) PetscFunctionReturn(PETSC_SUCCESS);
  if (fread(found, 1, STATE_BLOCK, f) != STATE_BLOCK || memcmp(found, STATE_FORMAT " ", strlen(STATE_FORMAT) + 1))
    *why = "it is no checkpoint of a run";
  else if (memcmp(found, format, strlen(format)))
    *why = "it is of another format than " PetscStringize(
      STATE_VERSION) ": a run goes on with the version of SlipStep that began it";
  else {
    PetscErrorCode ierr = StateChecksum(f, name, &checksum, &bytes);

    if (!ierr) StateBlock(checksum, bytes, block);
    if (ierr || memcmp(found, block, STATE_BLOCK)) *why = "it is damaged: its checksum is not that of its content";
  }
  fclose(f);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Rank 0: completes the file by its first block and renames it; the previous file is retained. */
static PetscErrorCode StateFinish(SlipState s)
{
  SlipH5 *h = &s->file;
  char previous[PETSC_MAX_PATH_LEN + STATE_SUFFIX_LEN], block[STATE_BLOCK];
  uint64_t checksum, bytes;
  FILE *f;
  PetscErrorCode ierr;

  PetscFunctionBegin;
  PetscCall(SlipH5CloseBeside(h));
  f = fopen(h->name, "rb");
  PetscCheck(f, PETSC_COMM_SELF, PETSC_ERR_FILE_WRITE, "cannot read %s: %s", h->name, strerror(errno));
  ierr = StateChecksum(f, h->name, &checksum, &bytes);
  fclose(f);
  PetscCall(ierr);
  StateBlock(checksum, bytes, block);
  errno = 0;
  if (pwrite(h->fd, block, STATE_BLOCK, 0) != STATE_BLOCK) PetscCall(SlipH5WriteFailed(h, errno, "%s", h->target));
  PetscCall(PetscSNPrintf(previous, sizeof(previous), "%s" STATE_PREVIOUS, h->target));
  if (rename(h->target, previous) && errno != ENOENT) PetscCall(SlipH5WriteFailed(h, errno, "%s", previous));
  PetscCall(SlipH5PutInPlace(h));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Rank 0 */
static PetscErrorCode StateCreateFile(SlipState s, const char file[])
{
  const SlipH5Kind kind = {.block = STATE_BLOCK};

  PetscFunctionBegin;
  PetscCall(SlipH5CreateKind(&kind, file, &s->file));
  PetscCall(SlipH5WriteAttrString(&s->file, "/", "format", STATE_FORMAT));
  PetscCall(SlipH5WriteAttrInt(&s->file, "/", "version", STATE_VERSION));
  PetscCall(SlipH5WriteAttrString(&s->file, "/", "library_version", SLIPSTEP_VERSION));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Rank 0: opens the newest undamaged file. */
static PetscErrorCode StateOpenFile(SlipState s, const char file[], const char source[])
{
  char target[PETSC_MAX_PATH_LEN], previous[PETSC_MAX_PATH_LEN + STATE_SUFFIX_LEN];
  const char *newest = NULL, *older = NULL;

  PetscFunctionBegin;
  PetscCall(StateVerify(file, &newest));
  if (newest) {
    PetscCall(SlipH5Follow(file, "", target));
    PetscCall(PetscSNPrintf(previous, sizeof(previous), "%s" STATE_PREVIOUS, target));
    PetscCall(StateVerify(previous, &older));
    PetscCheck(!older, PETSC_COMM_SELF, PETSC_ERR_FILE_OPEN, "cannot continue from %s: %s; nor from %s: %s (%s)", file,
               newest, previous, older, source);
    PetscCall(SlipWarning("cannot continue from %s: %s; %s is used instead (%s)", file, newest, previous, source));
  }
  PetscCall(SlipH5OpenRead(newest ? previous : file, &s->file));
  PetscCall(PetscSNPrintf(s->file.source, sizeof(s->file.source), " (%s)", source));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Rank 0: writes the numbers of the cells, or finds where each cell of the file is now. */
static PetscErrorCode StateOrder(SlipState s, PetscInt cells, const PetscInt order[])
{
  PetscReal *numbers;
  PetscInt *now, dims;
  PetscBool same = PETSC_TRUE, good = PETSC_TRUE;

  PetscFunctionBegin;
  if (!s->loading) {
    PetscCall(PetscMalloc1(cells, &numbers));
    for (PetscInt e = 0; e < cells; e++) numbers[e] = (PetscReal)order[e];
    PetscCall(SlipH5WriteReal(&s->file, "/order", 1, &cells, numbers, NULL));
    PetscCall(PetscFree(numbers));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(SlipH5ReadReal(&s->file, "/order", 1, &dims, &numbers));
  PetscCheck(dims == cells, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
             "%s is of %" PetscInt_FMT " cells, expected %" PetscInt_FMT "%s", s->file.name, dims, cells,
             s->file.source);
  PetscCall(PetscMalloc1(cells, &s->place));
  PetscCall(PetscMalloc1(cells, &now));
  for (PetscInt e = 0; e < cells; e++) now[order[e]] = e;
  for (PetscInt e = 0; e < cells && good; e++) {
    good = numbers[e] >= 0 && numbers[e] < cells ? PETSC_TRUE : PETSC_FALSE;
    if (good) s->place[e] = now[(PetscInt)numbers[e]];
    if (s->place[e] != e) same = PETSC_FALSE;
  }
  if (same) PetscCall(PetscFree(s->place));
  PetscCall(PetscFree(now));
  PetscCall(PetscFree(numbers));
  PetscCheck(good, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
             "/order in %s has a cell that is none of %" PetscInt_FMT "%s", s->file.name, cells, s->file.source);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipStateCells(SlipState s, PetscInt cells, const PetscInt order[])
{
  PetscErrorCode ierr = PETSC_SUCCESS;

  PetscFunctionBegin;
  s->cells = cells;
  if (!s->rank && order) ierr = StateOrder(s, cells, order);
  PetscCall(SlipErrorBcast(s->comm, ierr));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode StateNew(MPI_Comm comm, PetscBool loading, SlipState *state)
{
  SlipState s;

  PetscFunctionBegin;
  PetscCall(PetscNew(&s));
  s->comm = comm;
  s->loading = loading;
  s->file.id = -1;
  PetscCallMPI(MPI_Comm_rank(comm, &s->rank));
  *state = s;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipStateCreate(MPI_Comm comm, const char file[], SlipState *state)
{
  PetscErrorCode ierr = PETSC_SUCCESS;

  PetscFunctionBegin;
  PetscCall(StateNew(comm, PETSC_FALSE, state));
  if (!(*state)->rank) ierr = StateCreateFile(*state, file);
  PetscCall(SlipErrorBcast(comm, ierr));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipStateOpen(MPI_Comm comm, const char file[], const char source[], SlipState *state)
{
  PetscErrorCode ierr = PETSC_SUCCESS;

  PetscFunctionBegin;
  PetscCall(StateNew(comm, PETSC_TRUE, state));
  if (!(*state)->rank) ierr = StateOpenFile(*state, file, source);
  PetscCall(SlipErrorBcast(comm, ierr));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipStateClose(SlipState *state)
{
  SlipState s = *state;
  PetscErrorCode ierr = PETSC_SUCCESS;

  PetscFunctionBegin;
  if (!s) PetscFunctionReturn(PETSC_SUCCESS);
  if (!s->rank) ierr = s->loading ? SlipH5Close(&s->file) : StateFinish(s);
  PetscCall(SlipErrorBcast(s->comm, ierr));
  PetscCall(PetscFree(s->place));
  PetscCall(PetscFree(*state));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Rank 0 */
static PetscErrorCode StateCheckFile(const SlipH5Kind *kind, const char file[], PetscBool *exists)
{
  char start[sizeof(STATE_FORMAT)] = "";
  FILE *f;
  PetscBool is = PETSC_FALSE;

  PetscFunctionBegin;
  PetscCall(SlipH5CheckCreateKind(kind, file));
  f = fopen(file, "rb");
  *exists = f ? PETSC_TRUE : PETSC_FALSE;
  if (!f) PetscFunctionReturn(PETSC_SUCCESS);
  if (fread(start, 1, sizeof(start), f) == sizeof(start) && !memcmp(start, STATE_FORMAT " ", sizeof(start)))
    is = PETSC_TRUE;
  fclose(f);
  PetscCheck(is, PETSC_COMM_SELF, PETSC_ERR_FILE_OPEN,
             "%s is there and is no checkpoint of a run: it is not replaced (-%s%s)", file,
             kind->prefix ? kind->prefix : "", kind->option);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipStateCheckCreate(MPI_Comm comm, const char prefix[], const char option[], const char file[],
                                    PetscBool *exists)
{
  const SlipH5Kind kind = {.prefix = prefix, .option = option, .block = STATE_BLOCK};
  PetscErrorCode ierr = PETSC_SUCCESS;
  PetscMPIInt rank;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  *exists = PETSC_FALSE;
  if (!rank) ierr = StateCheckFile(&kind, file, exists);
  PetscCall(SlipErrorBcast(comm, ierr));
  PetscCallMPI(MPI_Bcast(exists, 1, MPIU_BOOL, 0, comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}
