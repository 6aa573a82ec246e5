/* Just enough JSON to look numbers up in a reference file: JsonFind(text, "a/b/0") walks objects by key and arrays by
   index. */
#pragma once
#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *JsonSpace(const char *s)
{
  while (*s && (isspace((unsigned char)*s) || *s == ',' || *s == ':')) s++;
  return s;
}

static const char *JsonString(const char *s) /* past the closing quote */
{
  for (s++; *s && *s != '"'; s++) {
    if (*s == '\\') s++;
  }
  return s + 1;
}

static const char *JsonSkip(const char *s) /* past one value */
{
  int depth = 0;

  s = JsonSpace(s);
  if (*s != '{' && *s != '[' && *s != '"') return s + strcspn(s, ",]} \n");
  do {
    if (*s == '"') {
      s = JsonString(s);
      continue;
    }
    if (*s == '{' || *s == '[') depth++;
    if (*s == '}' || *s == ']') depth--;
    s++;
  } while (depth && *s);
  return s;
}

static const char *JsonFind(const char *s, const char *path) /* NULL: no such entry */
{
  while (s && *path) {
    const size_t n = strcspn(path, "/");

    s = JsonSpace(s);
    if (*s == '[') {
      s = JsonSpace(s + 1);
      for (long i = strtol(path, NULL, 10); i > 0 && *s != ']'; --i) s = JsonSpace(JsonSkip(s));
      if (*s == ']') return NULL;
    } else if (*s == '{') {
      for (s = JsonSpace(s + 1);; s = JsonSpace(JsonSkip(s))) {
        const char *key = s + 1, *end;

        if (*s != '"') return NULL;
        end = JsonString(s);
        s = end;
        if ((size_t)(end - 1 - key) == n && !strncmp(key, path, n)) break;
      }
    } else
      return NULL;
    path += n;
    if (*path == '/') path++;
  }
  return s ? JsonSpace(s) : NULL;
}

static char *JsonLoad(const char *file) /* free(); NULL when the file is not there */
{
  FILE *f = fopen(file, "rb");
  char *text = NULL;
  long n;

  if (!f) return NULL;
  if (!fseek(f, 0, SEEK_END) && (n = ftell(f)) > 0 && !fseek(f, 0, SEEK_SET) && (text = calloc((size_t)n + 1, 1))) {
    if (fread(text, 1, (size_t)n, f) != (size_t)n) {
      free(text);
      text = NULL;
    }
  }
  fclose(f);
  return text;
}
