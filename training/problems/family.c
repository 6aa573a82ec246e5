/* See family.h. Lines as of PETSc's option files, "-fault_length_x 5e3:20e3": a number, a range low:high, or choices
   a|b|c; # begins a comment. */
#include "family.h"
#include "common/files.h"
#include <slipcompat.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SPREAD "spread_"
#define SPREAD_LIMIT 1 /* of the logarithm of a field */

const char *const EpisodeFieldNames[DRAW_FIELDS] = {"normal_stress", "friction_drop", "friction_residual",
                                                    "friction_slip"};

/* A number with nothing behind it but end */
static PetscBool Number(const char text[], char end, PetscReal *x, const char **rest)
{
  char *stop;

  *x = (PetscReal)strtod(text, &stop);
  if (stop == text || *stop != end || PetscIsInfOrNanReal(*x)) return PETSC_FALSE;
  *rest = stop + 1;
  return PETSC_TRUE;
}

static PetscErrorCode ParseChoices(char value[], FamilyLine *line, PetscBool *good)
{
  PetscFunctionBegin;
  *good = PETSC_TRUE;
  for (char *word = strtok(value, "|"); word && *good; word = strtok(NULL, "|")) {
    *good = line->nchoices < FAMILY_MAX_CHOICES && strlen(word) < FAMILY_NAME ? PETSC_TRUE : PETSC_FALSE;
    if (*good) PetscCall(PetscStrncpy(line->choice[line->nchoices++], word, FAMILY_NAME));
  }
  if (!line->nchoices) *good = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscBool IsField(const char name[])
{
  for (int f = 0; f < DRAW_FIELDS; ++f)
    if (!strcmp(name, EpisodeFieldNames[f])) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* May a fault have the line's values? The fault that is asked says what it expects. */
static PetscErrorCode CheckValues(SlipFault fault, const FamilyLine *line)
{
  const char *name = line->name + strlen("fault_");

  PetscFunctionBegin;
  if (line->nchoices) {
    for (PetscInt k = 0; k < line->nchoices; ++k) PetscCall(SlipFaultSetString(fault, name, line->choice[k]));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(SlipFaultSetReal(fault, name, line->low));
  PetscCall(SlipFaultSetReal(fault, name, line->high));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode CheckLine(SlipFault fault, const FamilyLine *line, PetscInt number)
{
  char text[ERROR_TEXT] = "";
  PetscErrorCode code;

  PetscFunctionBegin;
  if (!strncmp(line->name, SPREAD, strlen(SPREAD))) {
    PetscCheck(IsField(line->name + strlen(SPREAD)) && !line->nchoices && line->low >= 0 && line->high <= SPREAD_LIMIT,
               PETSC_COMM_SELF, PETSC_ERR_ARG_WRONG,
               "line %" PetscInt_FMT ": expected -spread_ and one of normal_stress, friction_drop, friction_residual, "
               "friction_slip, with a number or range in [0, %g]",
               number, (double)SPREAD_LIMIT);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (!strcmp(line->name, "margin")) {
    PetscCheck(!line->nchoices && line->low >= 1, PETSC_COMM_SELF, PETSC_ERR_ARG_WRONG,
               "line %" PetscInt_FMT ": -margin is the duration over the time to rest, expected a number or range >= 1",
               number);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCheck(!strncmp(line->name, "fault_", strlen("fault_")), PETSC_COMM_SELF, PETSC_ERR_ARG_WRONG,
             "line %" PetscInt_FMT ": -%s is not known, expected -fault_NAME, -spread_FIELD or -margin", number,
             line->name);
  PetscCall(PetscPushErrorHandler(ErrorCapture, text));
  code = CheckValues(fault, line);
  PetscCall(PetscPopErrorHandler());
  PetscCheck(!code, PETSC_COMM_SELF, PETSC_ERR_ARG_WRONG, "line %" PetscInt_FMT ": %s", number, text);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ParseLine(char text[], PetscInt number, Family *family, SlipFault fault)
{
  FamilyLine *line = &family->line[family->n];
  char name[FAMILY_NAME] = "", value[256] = "", more[2] = "";
  const char *rest;
  PetscBool good;

  PetscFunctionBegin;
  text[strcspn(text, "#\n")] = 0;
  if (text[strspn(text, " \t\r")] == 0) PetscFunctionReturn(PETSC_SUCCESS);
  good = sscanf(text, " -%63s %255s %1s", name, value, more) == 2 ? PETSC_TRUE : PETSC_FALSE;
  PetscCheck(good, PETSC_COMM_SELF, PETSC_ERR_ARG_WRONG,
             "line %" PetscInt_FMT " is \"%s\"; expected an option and its value, low:high or a|b|c", number, text);
  PetscCheck(family->n < FAMILY_MAX_LINES, PETSC_COMM_SELF, PETSC_ERR_ARG_SIZ, "expected at most %d options",
             FAMILY_MAX_LINES);
  PetscCheck(!FamilyFind(family, name), PETSC_COMM_SELF, PETSC_ERR_ARG_WRONG,
             "line %" PetscInt_FMT ": -%s stands there twice", number, name);
  *line = (FamilyLine){.nchoices = 0};
  PetscCall(PetscStrncpy(line->name, name, sizeof(line->name)));
  if (Number(value, ':', &line->low, &rest))
    good = Number(rest, 0, &line->high, &rest) && line->low <= line->high ? PETSC_TRUE : PETSC_FALSE;
  else if (Number(value, 0, &line->low, &rest))
    line->high = line->low;
  else
    PetscCall(ParseChoices(value, line, &good));
  PetscCheck(good, PETSC_COMM_SELF, PETSC_ERR_ARG_WRONG,
             "line %" PetscInt_FMT ": -%s has the value %s; expected a number, low:high or at most %d words a|b|c",
             number, name, value, FAMILY_MAX_CHOICES);
  PetscCall(CheckLine(fault, line, number));
  family->n++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadLines(const char file[], Family *family)
{
  char text[512];
  FILE *f = fopen(file, "r");
  PetscErrorCode code = PETSC_SUCCESS;
  SlipFault fault;

  PetscFunctionBegin;
  PetscCheck(f, PETSC_COMM_SELF, PETSC_ERR_FILE_OPEN, "cannot be opened");
  code = SlipFaultCreate(PETSC_COMM_SELF, &fault);
  for (PetscInt number = 1; !code && fgets(text, sizeof(text), f); ++number)
    code = ParseLine(text, number, family, fault);
  fclose(f);
  PetscCall(code);
  PetscCall(SlipFaultDestroy(&fault));
  PetscCheck(family->n > 0, PETSC_COMM_SELF, PETSC_ERR_ARG_WRONG, "holds no option");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Every rank reads: so all raise the same error. */
PetscErrorCode FamilyRead(MPI_Comm comm, const char file[], Family *family)
{
  char text[ERROR_TEXT] = "";
  PetscErrorCode code;

  PetscFunctionBegin;
  *family = (Family){.n = 0};
  PetscCall(PetscStrncpy(family->file, file, sizeof(family->file)));
  PetscCall(PetscPushErrorHandler(ErrorCapture, text));
  code = ReadLines(file, family);
  PetscCall(PetscPopErrorHandler());
  PetscCheck(!code, comm, code, "-train_family %s: %s", file, text);
  PetscFunctionReturn(PETSC_SUCCESS);
}

const FamilyLine *FamilyFind(const Family *family, const char name[])
{
  for (PetscInt i = 0; i < family->n; ++i)
    if (!strcmp(family->line[i].name, name)) return &family->line[i];
  return NULL;
}

PetscReal FamilyDraw(const FamilyLine *line, Random *random)
{
  const double x = RandomUniform(random), low = (double)line->low, high = (double)line->high;

  return low > 0 ? low * pow(high / low, x) : low + (high - low) * x;
}

const char *FamilyChoose(const FamilyLine *line, Random *random)
{
  return line->choice[RandomIndex(random, (uint64_t)line->nchoices)];
}

PetscErrorCode FamilyOption(SlipOptionItems PetscOptionsObject, PetscBool allowed, void **family)
{
  char file[PETSC_MAX_PATH_LEN] = "";
  PetscBool set;

  PetscFunctionBegin;
  *family = NULL;
  PetscCall(PetscOptionsString("-train_family", "File of the faults to train on: options with ranges", NULL, file, file,
                               sizeof(file), &set));
  PetscCheck(!set || allowed, PETSC_COMM_WORLD, PETSC_ERR_ARG_WRONG,
             "-train_family is for faults with an accuracy dial: expected -train_algorithm cmaes, or -train_problem "
             "fault_dial");
  PetscCheck(!set || file[0], PETSC_COMM_WORLD, PETSC_ERR_ARG_WRONG,
             "-train_family has no value, expected the name of a file");
  if (set) {
    PetscCall(PetscNew((Family **)family));
    PetscCall(FamilyRead(PETSC_COMM_WORLD, file, (Family *)*family));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
