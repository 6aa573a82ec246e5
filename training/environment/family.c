/* See family.h. Lines as of PETSc's option files, "-fault_length_x 5e3:20e3": a number, a range low:high, choices
   a|b|c, or, of a switch, nothing; # begins a comment. */
#include "family.h"
#include "common/files.h"
#include <slipcompat.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SPREAD "spread_"
#define SPREAD_LIMIT 1 /* of the logarithm of a field */

/* Names that are no options of faults. In [low, high] or, with open, above low; stress, event: of faults under a given
   stress, or of events from the instability, only */
static const struct {
  const char *name, *meaning;
  PetscReal low, high;
  PetscBool open, stress, event;
} Own[] = {
  {"margin", "the duration over the time to rest", 1, PETSC_MAX_REAL, PETSC_FALSE, PETSC_FALSE, PETSC_FALSE},
  {"weakening", "of the critical displacement over its stiffness, which gives friction_slip", 1, PETSC_MAX_REAL,
   PETSC_TRUE, PETSC_FALSE, PETSC_TRUE},
  {"correlation", "the shortest wave of fields that vary [m]", 0, PETSC_MAX_REAL, PETSC_TRUE, PETSC_TRUE, PETSC_FALSE},
  {"stress_share", "the stress above the residual strength, over the drop", 0, 1, PETSC_FALSE, PETSC_TRUE, PETSC_FALSE},
  {"patch_radius", "of the patch in which the stress exceeds the strength [m]", 0, PETSC_MAX_REAL, PETSC_TRUE,
   PETSC_TRUE, PETSC_FALSE},
  {"patch_excess", "of the stress over the strength there, relative", 0, 1, PETSC_TRUE, PETSC_TRUE, PETSC_FALSE},
  {"duration", "of a run under a pore pressure [s]", 0, PETSC_MAX_REAL, PETSC_TRUE, PETSC_TRUE, PETSC_FALSE},
  {"patch_x", "its centre along strike, over the length of the fault", 0, 1, PETSC_FALSE, PETSC_TRUE, PETSC_FALSE},
  {"patch_z", "its centre in depth, over the width of the fault", 0, 1, PETSC_FALSE, PETSC_TRUE, PETSC_FALSE},
};

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

PetscErrorCode FamilySetWord(SlipFault fault, const char name[], const char word[])
{
  PetscBool value = PETSC_FALSE;
  PetscErrorCode code;

  PetscFunctionBegin;
  PetscCall(PetscPushErrorHandler(PetscReturnErrorHandler, NULL));
  code = PetscOptionsStringToBool(word, &value);
  if (!code) code = SlipFaultSetBool(fault, name, value);
  PetscCall(PetscPopErrorHandler());
  if (code) PetscCall(SlipFaultSetString(fault, name, word));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscBool IsFile(const char name[])
{
  return strcmp(name, "fault_parameters") && strcmp(name, "fault_mesh") ? PETSC_FALSE : PETSC_TRUE;
}

/* May a fault have the line's values? The fault that is asked says what it expects. */
static PetscErrorCode CheckValues(SlipFault fault, const FamilyLine *line)
{
  const char *name = line->name + strlen("fault_");
  PetscReal value;
  PetscErrorCode code;

  PetscFunctionBegin;
  PetscCall(PetscPushErrorHandler(PetscReturnErrorHandler, NULL));
  code = SlipFaultGetReal(fault, name, &value);
  PetscCall(PetscPopErrorHandler());
  PetscCheck(code || !line->nchoices, PETSC_COMM_SELF, PETSC_ERR_ARG_WRONG, "%s is no number, expected one or low:high",
             line->choice[0]);
  if (!line->nchoices) {
    PetscCall(SlipFaultSetReal(fault, name, line->low));
    PetscCall(SlipFaultSetReal(fault, name, line->high));
  }
  for (PetscInt k = 0; k < line->nchoices; ++k) {
    PetscBool there = PETSC_TRUE;

    PetscCall(FamilySetWord(fault, name, line->choice[k]));
    if (IsFile(line->name)) PetscCall(PetscTestFile(line->choice[k], 'r', &there));
    PetscCheck(there, PETSC_COMM_SELF, PETSC_ERR_FILE_OPEN, "%s cannot be read, expected a file", line->choice[k]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Of a field of faults, an option of faults, or a name of the table */
static PetscErrorCode CheckLine(SlipFault fault, const FamilyLine *line)
{
  const PetscReal one = 1;
  size_t i = 0;

  PetscFunctionBegin;
  if (!strncmp(line->name, SPREAD, strlen(SPREAD))) {
    PetscCheck(!line->nchoices && line->low >= 0 && line->high <= SPREAD_LIMIT, PETSC_COMM_SELF,
               PETSC_ERR_ARG_OUTOFRANGE, "expected a number or range in [0, %g]", (double)SPREAD_LIMIT);
    PetscCall(SlipFaultSetField(fault, line->name + strlen(SPREAD), 1, &one));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (!strncmp(line->name, "fault_", strlen("fault_"))) {
    PetscCall(CheckValues(fault, line));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  while (i < PETSC_STATIC_ARRAY_LENGTH(Own) && strcmp(line->name, Own[i].name)) ++i;
  PetscCheck(i < PETSC_STATIC_ARRAY_LENGTH(Own), PETSC_COMM_SELF, PETSC_ERR_ARG_WRONG,
             "not known, expected -fault_NAME, -spread_FIELD, -margin, -weakening, "
             "-correlation, -stress_share, -duration, -patch_radius, _excess, _x or _z");
  PetscCheck(!line->nchoices && line->low >= Own[i].low && (!Own[i].open || line->low > Own[i].low) &&
               line->high <= Own[i].high,
             PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE, "%s; expected a number or range %s %g%s", Own[i].meaning,
             Own[i].open ? ">" : ">=", (double)Own[i].low, Own[i].high < PETSC_MAX_REAL ? " and at most 1" : "");
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ParseLine(char text[], PetscInt number, Family *family, SlipFault fault)
{
  FamilyLine *line = &family->line[family->n];
  char name[FAMILY_NAME] = "", value[FAMILY_WORD] = "yes", more[2] = "";
  char reason[ERROR_TEXT] = "";
  const char *rest;
  PetscErrorCode code;
  PetscBool good;
  int words;

  PetscFunctionBegin;
  text[strcspn(text, "#\n")] = 0;
  if (text[strspn(text, " \t\r")] == 0) PetscFunctionReturn(PETSC_SUCCESS);
  words = sscanf(text, " -%63s %255s %1s", name, value, more);
  PetscCheck(words == 1 || words == 2, PETSC_COMM_SELF, PETSC_ERR_ARG_WRONG,
             "line %" PetscInt_FMT " is \"%s\"; expected an option and its value, low:high or a|b|c", number, text);
  PetscCheck(family->n < FAMILY_MAX_LINES, PETSC_COMM_SELF, PETSC_ERR_ARG_SIZ, "expected at most %d options",
             FAMILY_MAX_LINES);
  PetscCheck(!FamilyFind(family, name), PETSC_COMM_SELF, PETSC_ERR_ARG_WRONG,
             "line %" PetscInt_FMT ": -%s stands there twice", number, name);
  *line = (FamilyLine){.number = number};
  PetscCall(PetscStrncpy(line->name, name, sizeof(line->name)));
  if (Number(value, ':', &line->low, &rest))
    good = Number(rest, 0, &line->high, &rest) && line->low <= line->high ? PETSC_TRUE : PETSC_FALSE;
  else if (Number(value, 0, &line->low, &rest)) {
    line->high = line->low;
    good = PETSC_TRUE;
  } else {
    good = PETSC_TRUE;
    for (char *word = strtok(value, "|"); word && good; word = strtok(NULL, "|")) {
      good = line->nchoices < FAMILY_MAX_CHOICES && strlen(word) < FAMILY_WORD ? PETSC_TRUE : PETSC_FALSE;
      if (good) PetscCall(PetscStrncpy(line->choice[line->nchoices++], word, FAMILY_WORD));
    }
    if (!line->nchoices) good = PETSC_FALSE;
  }
  PetscCheck(good, PETSC_COMM_SELF, PETSC_ERR_ARG_WRONG,
             "line %" PetscInt_FMT ": -%s has the value %s; expected a number, low:high or at most %d words a|b|c",
             number, name, value, FAMILY_MAX_CHOICES);
  PetscCall(PetscPushErrorHandler(ErrorCapture, reason));
  code = CheckLine(fault, line);
  PetscCall(PetscPopErrorHandler());
  PetscCheck(!code, PETSC_COMM_SELF, PETSC_ERR_ARG_WRONG, "line %" PetscInt_FMT ": -%s: %s", number, name, reason);
  family->n++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* What runs a file may describe, by the lines that it has: the first row of which it has one, and all of a given stress
   but the last */
static const struct {
  const char *problem, *describes, *line[3];
} Kinds[] = {
  {"rupture", "ruptures from a given stress", {"fault_initial_unstable"}},
  {"injection", "slip under a pore pressure", {"fault_injection", "fault_pore_pressure"}},
  {"sequence", "sequences of events under loading", {"fault_loading_rate", "fault_stressing_rate"}},
  {"fault_dial", "events from the instability", {NULL}},
};
/* What the file describes, and that all lines are of that */
static PetscErrorCode CheckKind(Family *family)
{
  const FamilyLine *initial = FamilyFind(family, "fault_initial"), *law = FamilyFind(family, "fault_friction_law");
  PetscBool injection;

  PetscFunctionBegin;
  family->stress = initial && !strcmp(initial->choice[0], "traction") ? PETSC_TRUE : PETSC_FALSE;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(Kinds) && !family->problem; ++k) {
    PetscBool is = family->stress || Kinds[k].line[0] ? PETSC_FALSE : PETSC_TRUE;

    for (PetscInt i = 0; family->stress && Kinds[k].line[i]; ++i)
      if (FamilyFind(family, Kinds[k].line[i])) is = PETSC_TRUE;
    if (!is) continue;
    family->problem = Kinds[k].problem;
    family->describes = Kinds[k].describes;
  }
  for (PetscInt k = 1; initial && k < initial->nchoices; ++k)
    PetscCheck((strcmp(initial->choice[k], "traction") ? PETSC_FALSE : PETSC_TRUE) == family->stress, PETSC_COMM_SELF,
               PETSC_ERR_ARG_WRONG, "line %" PetscInt_FMT ": -fault_initial: expected traction alone, or none of it",
               initial->number);
  for (PetscInt k = 0; law && k < law->nchoices && family->stress; ++k)
    PetscCheck(strcmp(law->choice[k], "rate_and_state"), PETSC_COMM_SELF, PETSC_ERR_ARG_WRONG,
               "line %" PetscInt_FMT ": -fault_friction_law: rate_and_state has no ruptures from a given stress here, "
               "expected another law (cycles keep -fault_accuracy without a policy)",
               law->number);
  PetscCheck(family->problem, PETSC_COMM_SELF, PETSC_ERR_ARG_WRONG,
             "line %" PetscInt_FMT
             ": -fault_initial: expected -fault_initial_unstable with it, as a rupture begins where the stress exceeds "
             "the strength, or loading (-fault_loading_rate, -fault_stressing_rate), or a pore pressure "
             "(-fault_injection, -fault_pore_pressure)",
             initial->number);
  injection = strcmp(family->problem, "injection") ? PETSC_FALSE : PETSC_TRUE;
  PetscCheck(injection == (FamilyFind(family, "duration") ? PETSC_TRUE : PETSC_FALSE), PETSC_COMM_SELF,
             PETSC_ERR_ARG_WRONG, "has %s, expected both or none",
             injection ? "a pore pressure but no -duration [s] of runs" : "a -duration but no pore pressure");
  for (PetscInt i = 0; i < family->n; ++i) {
    const FamilyLine *line = &family->line[i];
    PetscBool of_stress = IsFile(line->name), of_event = PETSC_FALSE;

    for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(Own); ++k)
      if (!strcmp(line->name, Own[k].name)) {
        of_stress = Own[k].stress;
        of_event = Own[k].event;
      }
    if (!strncmp(line->name, SPREAD, strlen(SPREAD))) of_stress = PETSC_TRUE;
    for (int f = 0; f < DRAW_FIELDS && of_stress; ++f)
      if (!strcmp(line->name + strlen(SPREAD), EpisodeFieldNames[f])) of_stress = PETSC_FALSE;
    PetscCheck(
      !of_stress || family->stress, PETSC_COMM_SELF, PETSC_ERR_ARG_WRONG,
      "line %" PetscInt_FMT
      ": -%s is for ruptures from a given stress, sequences and injections, expected -fault_initial traction in "
      "the file",
      line->number, line->name);
    PetscCheck(!of_event || !family->stress, PETSC_COMM_SELF, PETSC_ERR_ARG_WRONG,
               "line %" PetscInt_FMT
               ": -%s is for events from the instability, expected no -fault_initial traction in the "
               "file",
               line->number, line->name);
  }
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
  PetscCall(CheckKind(family));
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

PetscReal FamilyNumber(const Family *family, const char name[], PetscReal other, Random *random)
{
  const FamilyLine *line = FamilyFind(family, name);

  return line ? FamilyDraw(line, random) : other;
}

const char *FamilyChoose(const FamilyLine *line, Random *random)
{
  return line->choice[RandomIndex(random, (uint64_t)line->nchoices)];
}

PetscErrorCode FamilyOption(SlipOptionItems PetscOptionsObject, Family **family)
{
  char file[PETSC_MAX_PATH_LEN] = "";
  PetscBool set;

  PetscFunctionBegin;
  *family = NULL;
  PetscCall(PetscOptionsString("-train_family", "File of the faults to train on: options with ranges", NULL, file, file,
                               sizeof(file), &set));
  PetscCheck(!set || file[0], PETSC_COMM_WORLD, PETSC_ERR_ARG_WRONG,
             "-train_family has no value, expected the name of a file");
  if (set) {
    PetscCall(PetscNew(family));
    PetscCall(FamilyRead(PETSC_COMM_WORLD, file, *family));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
