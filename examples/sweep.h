/* Several runs in one process: one line of options each. A small fault takes milliseconds, starting a process a tenth
   of a second. */
#pragma once
#include <slipfault.h>
#include <slipsys.h>
#include <stdio.h>
#include <string.h>

/* The options of the program, where the line does not replace them */
static inline PetscErrorCode SweepOptions(const char line[], PetscOptions *options)
{
  char *all, **words;
  int n;

  PetscFunctionBeginUser;
  PetscCall(PetscStrToArray(line, ' ', &n, &words));
  PetscCall(SlipCheckOptionWords(n, (const char *const *)words, " (-fault_sweep)"));
  PetscCall(PetscStrToArrayDestroy(n, words));
  PetscCall(PetscOptionsGetAll(NULL, &all));
  PetscCall(PetscOptionsCreate(options));
  PetscCall(PetscOptionsInsertString(*options, all));
  PetscCall(PetscFree(all));
  PetscCall(PetscOptionsClearValue(*options, "-fault_sweep"));
  PetscCall(PetscOptionsInsertString(*options, line));
  PetscFunctionReturn(0);
}

typedef struct {
  PetscInt n, size;
  PetscInt *number; /* [n] of the line */
  char **line;      /* [n] */
  PetscOptions *options;
} SweepRuns;

static inline PetscErrorCode SweepAdd(SweepRuns *runs, const char line[], PetscInt number)
{
  PetscFunctionBeginUser;
  if (runs->n == runs->size) {
    runs->size = 2 * runs->size + 16;
    PetscCall(PetscRealloc(runs->size * sizeof(*runs->number), &runs->number));
    PetscCall(PetscRealloc(runs->size * sizeof(*runs->line), &runs->line));
    PetscCall(PetscRealloc(runs->size * sizeof(*runs->options), &runs->options));
  }
  runs->number[runs->n] = number;
  PetscCall(PetscStrallocpy(line, &runs->line[runs->n]));
  PetscCall(SweepOptions(line, &runs->options[runs->n]));
  runs->n++;
  PetscFunctionReturn(0);
}

/* Every line of a file that is neither empty nor begins with # */
static inline PetscErrorCode SweepRead(const char file[], SweepRuns *runs)
{
  char line[8192];
  FILE *f = fopen(file, "r");

  PetscFunctionBeginUser;
  PetscCheck(f, PETSC_COMM_WORLD, PETSC_ERR_FILE_OPEN,
             "cannot read %s (-fault_sweep): expected a line of options a run", file);
  for (PetscInt number = 1; fgets(line, sizeof(line), f); number++) {
    PetscCheck(strlen(line) < sizeof(line) - 1, PETSC_COMM_WORLD, PETSC_ERR_FILE_UNEXPECTED,
               "%s (-fault_sweep): a line has more than %d characters", file, (int)sizeof(line) - 2);
    line[strcspn(line, "\r\n")] = 0;
    if (line[strspn(line, " \t")] && line[0] != '#') PetscCall(SweepAdd(runs, line, number));
  }
  fclose(f);
  PetscCheck(runs->n, PETSC_COMM_WORLD, PETSC_ERR_FILE_UNEXPECTED, "%s (-fault_sweep) has no line of options", file);
  PetscFunctionReturn(0);
}

/* run() once for every line. The first that fails ends the program; lines that write one file are refused before. */
static inline PetscErrorCode Sweep(const char file[], PetscErrorCode (*run)(void))
{
  SweepRuns runs = {0};

  PetscFunctionBeginUser;
  PetscCall(SweepRead(file, &runs));
  PetscCall(SlipFaultCheckSweepFiles(PETSC_COMM_WORLD, runs.n, runs.options, runs.number));
  for (PetscInt k = 0; k < runs.n; k++) {
    PetscCall(PetscPrintf(PETSC_COMM_WORLD, "run %" PetscInt_FMT ": %s\n", k + 1, runs.line[k]));
    PetscCall(PetscOptionsPush(runs.options[k]));
    PetscCall((*run)());
    PetscCall(PetscOptionsPop());
    PetscCall(PetscOptionsDestroy(&runs.options[k]));
    PetscCall(PetscFree(runs.line[k]));
  }
  PetscCall(PetscFree(runs.line));
  PetscCall(PetscFree(runs.number));
  PetscCall(PetscFree(runs.options));
  PetscFunctionReturn(0);
}
