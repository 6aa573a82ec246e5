/* Several runs in one process: one line of options each. A small fault takes milliseconds, starting a process a tenth
   of a second. */
#pragma once
#include <slipsys.h>
#include <stdio.h>
#include <string.h>

/* run() with the options of the program, where the line does not replace them */
static inline PetscErrorCode SweepLine(const char line[], PetscErrorCode (*run)(void))
{
  PetscOptions options;
  char *all, **words;
  int n;

  PetscFunctionBeginUser;
  PetscCall(PetscStrToArray(line, ' ', &n, &words));
  PetscCall(SlipCheckOptionWords(n, (const char *const *)words, " (-fault_sweep)"));
  PetscCall(PetscStrToArrayDestroy(n, words));
  PetscCall(PetscOptionsGetAll(NULL, &all));
  PetscCall(PetscOptionsCreate(&options));
  PetscCall(PetscOptionsInsertString(options, all));
  PetscCall(PetscFree(all));
  PetscCall(PetscOptionsClearValue(options, "-fault_sweep"));
  PetscCall(PetscOptionsInsertString(options, line));
  PetscCall(PetscOptionsPush(options));
  PetscCall((*run)());
  PetscCall(PetscOptionsPop());
  PetscCall(PetscOptionsDestroy(&options));
  PetscFunctionReturn(0);
}

/* run() once for every line of a file that is neither empty nor begins with #. The first that fails ends the
   program. */
static inline PetscErrorCode Sweep(const char file[], PetscErrorCode (*run)(void))
{
  char line[8192];
  PetscInt n = 0;
  FILE *f = fopen(file, "r");

  PetscFunctionBeginUser;
  PetscCheck(f, PETSC_COMM_WORLD, PETSC_ERR_FILE_OPEN,
             "cannot read %s (-fault_sweep): expected a line of options a run", file);
  while (fgets(line, sizeof(line), f)) {
    PetscCheck(strlen(line) < sizeof(line) - 1, PETSC_COMM_WORLD, PETSC_ERR_FILE_UNEXPECTED,
               "%s (-fault_sweep): a line has more than %d characters", file, (int)sizeof(line) - 2);
    line[strcspn(line, "\r\n")] = 0;
    if (!line[strspn(line, " \t")] || line[0] == '#') continue;
    PetscCall(PetscPrintf(PETSC_COMM_WORLD, "run %" PetscInt_FMT ": %s\n", ++n, line));
    PetscCall(SweepLine(line, run));
  }
  fclose(f);
  PetscCheck(n, PETSC_COMM_WORLD, PETSC_ERR_FILE_UNEXPECTED, "%s (-fault_sweep) has no line of options", file);
  PetscFunctionReturn(0);
}
