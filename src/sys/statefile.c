/* Files that hold the state of a run: HDF5 behind a block of 512 bytes with the checksum of the rest, so that a file that
   was changed or cut is known as such before HDF5 sees it. A new one is written as FILE.part, and takes its place when
   it is on the disk; the one before stays as FILE.previous. */
#define _POSIX_C_SOURCE 200809L
#include <slipstep/private/slipstate.h>
#include <slipstep/private/slipsys.h>
#include <slipsys.h>
#include <slipcore.h>
#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define STATE_FORMAT "slipstep-checkpoint"
#define STATE_VERSION 1
#define STATE_BLOCK 512    /* bytes before those of HDF5, which wants a power of two from 512 on */
#define STATE_WORDS 131072 /* words that are hashed at a time */
#define STATE_SUFFIX_LEN 16

/* What the first block says of the bytes after it. */
static void StateBlock(uint64_t checksum, uint64_t bytes, char block[STATE_BLOCK])
{
  memset(block, 0, STATE_BLOCK);
  (void)snprintf(block, STATE_BLOCK, "%s %d\nchecksum %016" PRIx64 " of %" PRIu64 " bytes\n", STATE_FORMAT,
                 STATE_VERSION, checksum, bytes);
}

/* Hash of what follows the first block; what does not fill a word counts with zeros behind it. */
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

/* Why the file is not a state as it was written, or NULL. */
static PetscErrorCode StateVerify(const char name[], const char **why)
{
  FILE *f = fopen(name, "rb");
  char found[STATE_BLOCK], block[STATE_BLOCK];
  uint64_t checksum, bytes;

  PetscFunctionBegin;
  *why = NULL;
  if (!f) *why = errno == ENOENT ? "there is no such file" : strerror(errno);
  if (!f) PetscFunctionReturn(PETSC_SUCCESS);
  if (fread(found, 1, STATE_BLOCK, f) != STATE_BLOCK || memcmp(found, STATE_FORMAT " ", strlen(STATE_FORMAT) + 1))
    *why = "it is no checkpoint of a run";
  else {
    PetscErrorCode ierr = StateChecksum(f, name, &checksum, &bytes);

    if (!ierr) StateBlock(checksum, bytes, block);
    if (ierr || memcmp(found, block, STATE_BLOCK)) *why = "it is damaged: its checksum is not that of its content";
  }
  fclose(f);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode StateSync(const char name[], int flags)
{
  const int fd = open(name, flags);

  PetscFunctionBegin;
  /* a file system that cannot sync a directory says EINVAL */
  const PetscBool good = fd >= 0 && (!fsync(fd) || errno == EINVAL) ? PETSC_TRUE : PETSC_FALSE;

  if (fd >= 0) close(fd);
  PetscCheck(good, PETSC_COMM_SELF, PETSC_ERR_FILE_WRITE, "cannot bring %s to the disk: %s", name, strerror(errno));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Rank 0: the first block of the file just closed, then the file takes its place. */
static PetscErrorCode StatePutInPlace(const char part[], const char file[])
{
  char previous[PETSC_MAX_PATH_LEN + STATE_SUFFIX_LEN], folder[PETSC_MAX_PATH_LEN], block[STATE_BLOCK], *slash;
  uint64_t checksum, bytes;
  FILE *f = fopen(part, "r+b");
  PetscErrorCode ierr;
  PetscBool good;

  PetscFunctionBegin;
  PetscCheck(f, PETSC_COMM_SELF, PETSC_ERR_FILE_WRITE, "cannot write %s: %s", part, strerror(errno));
  ierr = StateChecksum(f, part, &checksum, &bytes);
  StateBlock(checksum, bytes, block);
  good = !ierr && !fseek(f, 0, SEEK_SET) && fwrite(block, 1, STATE_BLOCK, f) == STATE_BLOCK ? PETSC_TRUE : PETSC_FALSE;
  if (fclose(f)) good = PETSC_FALSE;
  PetscCheck(good, PETSC_COMM_SELF, PETSC_ERR_FILE_WRITE, "cannot write %s: %s", part, strerror(errno));
  PetscCall(StateSync(part, O_RDWR));
  PetscCall(PetscSNPrintf(previous, sizeof(previous), "%s.previous", file));
  PetscCheck(!rename(file, previous) || errno == ENOENT, PETSC_COMM_SELF, PETSC_ERR_FILE_WRITE,
             "cannot rename %s to %s: %s", file, previous, strerror(errno));
  PetscCheck(!rename(part, file), PETSC_COMM_SELF, PETSC_ERR_FILE_WRITE, "cannot rename %s to %s: %s", part, file,
             strerror(errno));
  PetscCall(PetscStrncpy(folder, file, sizeof(folder)));
  slash = strrchr(folder, '/');
  if (slash)
    slash[1] = '\0';
  else
    PetscCall(PetscStrncpy(folder, ".", sizeof(folder)));
  PetscCall(StateSync(folder, O_RDONLY));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Rank 0 */
static PetscErrorCode StateCreateFile(SlipState s, const char file[])
{
  const hid_t plist = H5Pcreate(H5P_FILE_CREATE);

  PetscFunctionBegin;
  PetscCall(SlipH5Clear(NULL, NULL, &s->file));
  PetscCall(PetscStrncpy(s->file.target, file, sizeof(s->file.target)));
  PetscCall(PetscSNPrintf(s->file.name, sizeof(s->file.name), "%s.part", file));
  H5Pset_userblock(plist, STATE_BLOCK);
  s->file.id = H5Fcreate(s->file.name, H5F_ACC_TRUNC, plist, H5P_DEFAULT);
  H5Pclose(plist);
  PetscCheck(s->file.id >= 0, PETSC_COMM_SELF, PETSC_ERR_FILE_OPEN, "cannot write %s: %s", s->file.name,
             strerror(errno));
  s->file.fd = open(s->file.name, O_RDWR | O_CLOEXEC);
  SlipH5Enlist(&s->file); /* what ends the program from now on removes it */
  PetscCall(SlipH5WriteAttrString(&s->file, "/", "format", STATE_FORMAT));
  PetscCall(SlipH5WriteAttrInt(&s->file, "/", "version", STATE_VERSION));
  PetscCall(SlipH5WriteAttrString(&s->file, "/", "library_version", SLIPSTEP_VERSION));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Rank 0: the newest file that is whole. */
static PetscErrorCode StateOpenFile(SlipState s, const char file[], const char source[])
{
  char previous[PETSC_MAX_PATH_LEN + STATE_SUFFIX_LEN];
  const char *newest = NULL, *older = NULL;

  PetscFunctionBegin;
  PetscCall(StateVerify(file, &newest));
  if (newest) {
    PetscCall(PetscSNPrintf(previous, sizeof(previous), "%s.previous", file));
    PetscCall(StateVerify(previous, &older));
    PetscCheck(!older, PETSC_COMM_SELF, PETSC_ERR_FILE_OPEN, "cannot go on from %s: %s; nor from %s: %s (%s)", file,
               newest, previous, older, source);
    PetscCall(SlipWarning("cannot go on from %s: %s; %s is taken instead (%s)", file, newest, previous, source));
  }
  PetscCall(SlipH5OpenRead(newest ? previous : file, &s->file));
  PetscCall(PetscSNPrintf(s->file.source, sizeof(s->file.source), " (%s)", source));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Rank 0: the numbers of the cells are written, or where each of the file's cells is now is found out. */
static PetscErrorCode StateOrder(SlipState s, PetscInt cells, const PetscInt order[])
{
  PetscReal *numbers;
  PetscInt *now, dims;
  PetscBool same = PETSC_TRUE;

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
  for (PetscInt e = 0; e < cells; e++) {
    s->place[e] = now[(PetscInt)numbers[e]];
    if (s->place[e] != e) same = PETSC_FALSE;
  }
  if (same) PetscCall(PetscFree(s->place));
  PetscCall(PetscFree(now));
  PetscCall(PetscFree(numbers));
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

/* Rank 0: the file that was written is closed, and takes its place. */
static PetscErrorCode StateFinish(SlipState s)
{
  const int reason = SlipH5CloseId(s->file.id);
  struct stat info;

  PetscFunctionBegin;
  if (!reason && s->file.fd >= 0 && !fstat(s->file.fd, &info) && ftruncate(s->file.fd, info.st_size))
    PetscCall(PetscInfo(NULL, "%s keeps the room that was taken for it\n", s->file.name));
  SlipH5Release(&s->file, reason ? PETSC_FALSE : PETSC_TRUE);
  PetscCheck(!reason, PETSC_COMM_SELF, PETSC_ERR_FILE_WRITE, "cannot write %s: %s", s->file.name, strerror(reason));
  PetscCall(StatePutInPlace(s->file.name, s->file.target));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipStateClose(SlipState *state)
{
  SlipState s = *state;
  PetscErrorCode ierr = PETSC_SUCCESS;

  PetscFunctionBegin;
  if (!s) PetscFunctionReturn(PETSC_SUCCESS);
  if (!s->rank && s->loading) H5Fclose(s->file.id);
  if (!s->rank && !s->loading) ierr = StateFinish(s);
  PetscCall(SlipErrorBcast(s->comm, ierr));
  PetscCall(PetscFree(s->place));
  PetscCall(PetscFree(*state));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Rank 0 */
static PetscErrorCode StateCheckFile(const char file[], const char source[], PetscBool *exists)
{
  char part[PETSC_MAX_PATH_LEN + STATE_SUFFIX_LEN], start[sizeof(STATE_FORMAT)] = "";
  struct stat info;
  FILE *f;
  PetscBool is = PETSC_FALSE;

  PetscFunctionBegin;
  *exists = stat(file, &info) ? PETSC_FALSE : PETSC_TRUE;
  if (*exists) {
    f = S_ISREG(info.st_mode) ? fopen(file, "rb") : NULL;
    if (f)
      is = fread(start, 1, sizeof(start), f) == sizeof(start) && !memcmp(start, STATE_FORMAT " ", sizeof(start))
             ? PETSC_TRUE
             : PETSC_FALSE;
    if (f) fclose(f);
    PetscCheck(is, PETSC_COMM_SELF, PETSC_ERR_FILE_OPEN,
               "%s is there and is no checkpoint of a run: it is not replaced (%s)", file, source);
  }
  PetscCall(PetscSNPrintf(part, sizeof(part), "%s.part", file));
  f = fopen(part, "ab");
  PetscCheck(f, PETSC_COMM_SELF, PETSC_ERR_FILE_OPEN, "cannot write %s: %s (%s)", part, strerror(errno), source);
  fclose(f);
  remove(part);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipStateCheckCreate(MPI_Comm comm, const char file[], const char source[], PetscBool *exists)
{
  PetscErrorCode ierr = PETSC_SUCCESS;
  PetscMPIInt rank;
  int there = 0;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  if (!rank) ierr = StateCheckFile(file, source, exists);
  PetscCall(SlipErrorBcast(comm, ierr));
  if (!rank) there = *exists ? 1 : 0;
  PetscCallMPI(MPI_Bcast(&there, 1, MPI_INT, 0, comm));
  *exists = there ? PETSC_TRUE : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}
