/* Reads sections and numbers of a .msh file of Gmsh in memory. */
#include <slipstep/private/slipgmsh.h>
#include <slipcompat.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define Fail(...) SETERRQ(PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED, __VA_ARGS__)

static PetscBool IsSpace(char c)
{
  return c == ' ' || c == '\t' || c == '\n' || c == '\r' ? PETSC_TRUE : PETSC_FALSE;
}

static void SkipSpace(SlipGmsh *g)
{
  while (g->at < g->size && IsSpace(g->text[g->at])) g->at++;
}

PetscErrorCode SlipGmshOpen(const char name[], const char source[], SlipGmsh *g)
{
  FILE *file = fopen(name, "rb");
  long size = -1;
  size_t got = 0;

  PetscFunctionBegin;
  *g = (SlipGmsh){.source = source};
  PetscCheck(file, PETSC_COMM_SELF, PETSC_ERR_FILE_OPEN, "%s cannot be read: %s", source, strerror(errno));
  if (!fseek(file, 0, SEEK_END)) size = ftell(file);
  if (size >= 0 && !fseek(file, 0, SEEK_SET)) {
    g->size = (size_t)size;
    PetscCall(PetscMalloc1(g->size + 1, &g->text));
    got = fread(g->text, 1, g->size, file);
    g->text[got] = '\0';
  }
  (void)fclose(file);
  PetscCheck(size >= 0 && got == g->size, PETSC_COMM_SELF, PETSC_ERR_FILE_READ, "%s cannot be read", source);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipGmshClose(SlipGmsh *g)
{
  PetscFunctionBegin;
  PetscCall(PetscFree(g->text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const char *SlipGmshPlace(const SlipGmsh *g, char text[], size_t len)
{
  size_t line = 1;

  for (size_t i = 0; i < g->at && i < g->size; i++) line += g->text[i] == '\n' ? 1 : 0;
  if (g->binary)
    (void)snprintf(text, len, "$%s, byte %zu", g->section, g->at);
  else
    (void)snprintf(text, len, "%s%s%sline %zu", g->section[0] ? "$" : "", g->section, g->section[0] ? ", " : "", line);
  return text;
}

/* ---- sections ---- */

PetscErrorCode SlipGmshBegin(SlipGmsh *g)
{
  size_t n = 0;
  char place[96];

  PetscFunctionBegin;
  g->section[0] = '\0';
  SkipSpace(g);
  if (g->at == g->size) PetscFunctionReturn(PETSC_SUCCESS);
  while (g->at + 1 + n < g->size && !IsSpace(g->text[g->at + 1 + n])) n++;
  if (g->text[g->at] != '$' || !n || n >= sizeof(g->section))
    Fail("%s: %s begins no section, expected one as $Nodes", g->source, SlipGmshPlace(g, place, sizeof(place)));
  PetscCall(PetscStrncpy(g->section, g->text + g->at + 1, n + 1));
  PetscCall(SlipGmshLine(g));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipGmshEnd(SlipGmsh *g)
{
  char word[80], place[96];
  const size_t n = (size_t)snprintf(word, sizeof(word), "$End%s", g->section);

  PetscFunctionBegin;
  SkipSpace(g);
  if (g->size - g->at < n || strncmp(g->text + g->at, word, n))
    Fail("%s: %s: expected %s", g->source, SlipGmshPlace(g, place, sizeof(place)), word);
  g->at += n;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Skips a section, which may contain any bytes. */
PetscErrorCode SlipGmshSkip(SlipGmsh *g)
{
  char word[80];
  const size_t n = (size_t)snprintf(word, sizeof(word), "$End%s", g->section);

  PetscFunctionBegin;
  while (g->size - g->at >= n && memcmp(g->text + g->at, word, n)) g->at++;
  if (g->size - g->at < n) g->at = g->size;
  PetscCall(SlipGmshEnd(g));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- numbers ---- */

static PetscErrorCode Bytes(SlipGmsh *g, size_t bytes, void *number)
{
  char place[96];

  PetscFunctionBegin;
  if (g->size - g->at < bytes)
    Fail("%s: %s: the file ends here, expected a number of %zu bytes", g->source,
         SlipGmshPlace(g, place, sizeof(place)), bytes);
  memcpy(number, g->text + g->at, bytes);
  g->at += bytes;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Moves behind a number in text; end is the position after it. */
static PetscErrorCode Taken(SlipGmsh *g, const char *end, const char what[])
{
  const size_t to = (size_t)(end - g->text);
  char place[96], word[32];

  PetscFunctionBegin;
  if (to == g->at || (to < g->size && !IsSpace(*end))) {
    size_t n = 0;

    while (n + 1 < sizeof(word) && g->at + n < g->size && !IsSpace(g->text[g->at + n])) n++;
    PetscCall(PetscStrncpy(word, g->text + g->at, n + 1));
    Fail("%s: %s: \"%s\", expected %s", g->source, SlipGmshPlace(g, place, sizeof(place)), word, what);
  }
  g->at = to;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipGmshInts(SlipGmsh *g, PetscInt n, size_t bytes, PetscInt64 number[])
{
  PetscFunctionBegin;
  for (PetscInt i = 0; i < n; i++) {
    int four;
    char *end;

    if (!g->binary) {
      SkipSpace(g);
      number[i] = (PetscInt64)strtoll(g->text + g->at, &end, 10);
      PetscCall(Taken(g, end, "a whole number"));
    } else if (bytes == sizeof(four)) {
      PetscCall(Bytes(g, bytes, &four));
      number[i] = four;
    } else
      PetscCall(Bytes(g, sizeof(number[i]), &number[i]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipGmshReals(SlipGmsh *g, PetscInt n, PetscReal number[])
{
  PetscFunctionBegin;
  for (PetscInt i = 0; i < n; i++) {
    double value;
    char *end;

    if (g->binary)
      PetscCall(Bytes(g, sizeof(value), &value));
    else {
      SkipSpace(g);
      value = strtod(g->text + g->at, &end);
      PetscCall(Taken(g, end, "a number"));
    }
    number[i] = (PetscReal)value;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipGmshFits(const SlipGmsh *g, PetscInt64 count, size_t bytes, const char what[])
{
  char place[96];

  PetscFunctionBegin;
  if (count < 0 || (size_t)count > (g->size - g->at) / bytes || count > PETSC_MAX_INT / 4)
    Fail("%s: %s: %lld %s are to follow, expected as many as the rest of the file can hold", g->source,
         SlipGmshPlace(g, place, sizeof(place)), (long long)count, what);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipGmshLine(SlipGmsh *g)
{
  PetscFunctionBegin;
  while (g->at < g->size && g->text[g->at] != '\n') g->at++;
  if (g->at < g->size) g->at++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipGmshQuoted(SlipGmsh *g, char text[], size_t len)
{
  const char *begin, *end = NULL;
  char place[96];

  PetscFunctionBegin;
  SkipSpace(g);
  begin = g->text + g->at;
  if (*begin == '"') end = memchr(begin + 1, '"', g->size - g->at - 1);
  if (!end) Fail("%s: %s: expected a name in quotation marks", g->source, SlipGmshPlace(g, place, sizeof(place)));
  (void)snprintf(text, len, "%.*s", (int)PetscMin((size_t)(end - begin - 1), len - 1), begin + 1);
  for (char *c = text; *c; c++)
    if ((unsigned char)*c < ' ' || *c == ';') *c = ' '; /* these would end a line or a name */
  g->at = (size_t)(end + 1 - g->text);
  PetscFunctionReturn(PETSC_SUCCESS);
}
