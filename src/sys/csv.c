/* Reads tables of words that commas separate, as Python's csv does. */
#include <slipstep/private/slipsys.h>
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static char *Strip(char word[])
{
  static const char space[] = " \t\r\n\f\v";
  size_t n;

  word += strspn(word, space);
  for (n = strlen(word); n && strchr(space, word[n - 1]); n--) word[n - 1] = '\0';
  return word;
}

/* Finds the words of the next line, in place, where a word may be in quotation marks; false after the last line. */
static PetscBool NextLine(SlipCsv *l)
{
  char *out = l->at, *begin = out;
  const char *c = l->at;
  PetscBool quoted = PETSC_FALSE;

  if (!*c) return PETSC_FALSE;
  l->words = 0;
  l->number++;
  for (PetscBool more = PETSC_TRUE; more; c++) {
    const PetscBool newline = *c == '\n' || *c == '\r' ? PETSC_TRUE : PETSC_FALSE;

    if (*c && *c == '"' && quoted && c[1] == '"')
      *out++ = *c++;
    else if (*c == '"' && (quoted || out == begin))
      quoted = !quoted;
    else if (*c && (quoted || (*c != ',' && !newline)))
      *out++ = *c;
    else {
      more = *c == ',' ? PETSC_TRUE : PETSC_FALSE;
      l->at = (char *)c + (*c == '\r' && c[1] == '\n') + (*c != '\0');
      *out++ = '\0';
      if (l->words < SLIP_CSV_WORDS) l->word[l->words] = Strip(begin);
      l->words++;
      begin = out;
    }
  }
  return PETSC_TRUE;
}

/* Finds the words of the next line that is neither blank nor a comment; false after the last one. */
PetscBool SlipCsvNext(SlipCsv *l)
{
  while (NextLine(l)) {
    PetscBool any = l->words > SLIP_CSV_WORDS ? PETSC_TRUE : PETSC_FALSE;

    for (int k = 0; k < PetscMin(l->words, SLIP_CSV_WORDS); k++) any = any || l->word[k][0] ? PETSC_TRUE : PETSC_FALSE;
    if (any && l->word[0][0] != '#') return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* A finite decimal number and nothing else, which Python reads alike */
PetscBool SlipCsvNumber(const char word[], PetscReal *x)
{
  char *end;

  *x = (PetscReal)strtod(word, &end);
  return end > word && !*end && strspn(word, "0123456789.eE+-") == strlen(word) && isfinite(*x) ? PETSC_TRUE
                                                                                                : PETSC_FALSE;
}

/* Bytes of UTF-8 that a program can print */
static PetscBool IsText(const char text[])
{
  int follow = 0;

  for (const unsigned char *c = (const unsigned char *)text; *c; c++) {
    if ((*c & 0xc0) == 0x80 ? follow-- <= 0 : follow > 0) return PETSC_FALSE;
    if (*c >= 0xc0) follow = *c >= 0xf0 ? 3 : *c >= 0xe0 ? 2 : 1;
  }
  return follow ? PETSC_FALSE : PETSC_TRUE;
}

/* Reads a file whole, on the calling process. option: that names it, for messages, with the prefix before it */
PetscErrorCode SlipCsvOpen(const char file[], const char prefix[], const char option[], SlipCsv *csv)
{
  FILE *from = fopen(file, "rb");
  size_t length = 0, got = 1;
  PetscBool failed;

  PetscFunctionBegin;
  *csv = (SlipCsv){.number = 0};
  (void)snprintf(csv->name, sizeof(csv->name), "%s (-%s%s)", file, prefix, option);
  PetscCheck(from, PETSC_COMM_SELF, PETSC_ERR_FILE_OPEN, "%s cannot be read: %s", csv->name, strerror(errno));
  while (got) {
    PetscCall(PetscRealloc(length + 65537, &csv->text));
    got = fread(csv->text + length, 1, 65536, from);
    length += got;
  }
  csv->text[length] = '\0';
  failed = ferror(from) ? PETSC_TRUE : PETSC_FALSE;
  (void)fclose(from);
  if (!failed && strlen(csv->text) == length && IsText(csv->text)) {
    csv->at = csv->text;
    if (!strncmp(csv->at, "\xef\xbb\xbf", 3)) csv->at += 3; /* the byte order mark of spreadsheets */
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(SlipCsvClose(csv));
  PetscCheck(!failed, PETSC_COMM_SELF, PETSC_ERR_FILE_READ, "%s cannot be read", csv->name);
  SETERRQ(PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
          "%s is no text in UTF-8, expected lines of words, separated by commas", csv->name);
}

PetscErrorCode SlipCsvClose(SlipCsv *csv)
{
  PetscFunctionBegin;
  PetscCall(PetscFree(csv->text));
  PetscFunctionReturn(PETSC_SUCCESS);
}
