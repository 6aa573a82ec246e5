/* The -evaluate_ options. */
#include "evaluate.h"
#include "common/files.h"
#include "common/options.h"
#include <glob.h>
#include <slipcompat.h>

static const char *const ControllerNames[] = {TSADAPTHEURISTIC, TSADAPTPI, TSADAPTDSP, TSADAPTBASIC,
                                              TSADAPTNONE,      TSADAPTRL, NULL};

/* Lists are read with room for one entry too many, which PETSc would drop without a word. */
#define ROOM (EVALUATE_MAX + 1)
static PetscErrorCode CheckCount(const char option[], PetscInt n)
{
  PetscFunctionBegin;
  PetscCheck(n > 0, PETSC_COMM_WORLD, PETSC_ERR_ARG_WRONG, "%s is empty", option);
  PetscCheck(n <= EVALUATE_MAX, PETSC_COMM_WORLD, PETSC_ERR_ARG_OUTOFRANGE, "%s has more than %d entries", option,
             EVALUATE_MAX);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A list of words as indices into a table; what is there already stays when the option is not given. */
static PetscErrorCode Words(SlipOptionItems PetscOptionsObject, const char option[], const char help[],
                            const char *const list[], PetscInt *n, PetscInt index[])
{
  char *words[ROOM];
  PetscInt found = ROOM;
  PetscBool set;

  PetscFunctionBegin;
  PetscCall(PetscOptionsStringArray(option, help, NULL, words, &found, &set));
  if (!set) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(CheckCount(option, found));
  *n = found;
  for (PetscInt i = 0; i < found; i++) PetscCall(OptionFind(option, words[i], list, &index[i]));
  for (PetscInt i = 0; i < found; i++) PetscCall(PetscFree(words[i]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A list of numbers > 0 in one of two arrays; likewise */
static PetscErrorCode Numbers(SlipOptionItems PetscOptionsObject, const char option[], const char help[], PetscInt *n,
                              PetscInt integer[], PetscReal real[])
{
  PetscInt integers[ROOM] = {0}, found = ROOM;
  PetscReal reals[ROOM] = {0};
  PetscBool set;

  PetscFunctionBegin;
  if (integer) PetscCall(SlipCheckIntegerOption(PETSC_COMM_WORLD, NULL, NULL, option));
  if (integer)
    PetscCall(PetscOptionsIntArray(option, help, NULL, integers, &found, &set));
  else
    PetscCall(PetscOptionsRealArray(option, help, NULL, reals, &found, &set));
  if (!set) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(CheckCount(option, found));
  *n = found;
  for (PetscInt i = 0; i < found; i++) {
    const PetscReal x = integer ? (PetscReal)integers[i] : reals[i];

    PetscCheck(x > 0 && !PetscIsInfReal(x), PETSC_COMM_WORLD, PETSC_ERR_ARG_OUTOFRANGE,
               "%s has %.10g, expected numbers > 0", option, (double)x);
    if (integer)
      integer[i] = integers[i];
    else
      real[i] = x;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Axes(EvaluateOptions *o, SlipOptionItems PetscOptionsObject)
{
  const char *problems[EVALUATE_MAX] = {NULL};
  const Problem *rows[EVALUATE_MAX];
  PetscInt index[EVALUATE_MAX];
  PetscInt n;

  PetscFunctionBegin;
  for (PetscInt i = n = 0; ProblemTable[i]; i++) {
    if (!ProblemTable[i]->evaluation) continue;
    rows[n] = ProblemTable[i];
    problems[n++] = ProblemTable[i]->name;
  }
  o->nproblems = 1;
  index[0] = 0;
  PetscCall(Words(PetscOptionsObject, "-evaluate_problems", "Problems: fault, sliding_mode, circuit (default fault)",
                  problems, &o->nproblems, index));
  for (PetscInt i = 0; i < o->nproblems; i++) o->problems[i] = rows[index[i]];
  PetscCall(Numbers(PetscOptionsObject, "-evaluate_sizes",
                    "Edges of the square fault [km] (default 3,5); it runs 10 s "
                    "per km",
                    &o->nsizes, NULL, o->sizes));
  PetscCall(Numbers(PetscOptionsObject, "-evaluate_meshes", "Cells along each edge (default 25,50)", &o->nmeshes,
                    o->meshes, NULL));
  o->ncontrollers = 5;
  for (PetscInt i = 0; i < 5; i++) index[i] = i < 3 ? i : i + 1;
  PetscCall(Words(PetscOptionsObject, "-evaluate_controllers",
                  "Controllers: heuristic, pi, dsp, basic, none (constant steps), rl (each of -evaluate_policies); "
                  "default all but basic",
                  ControllerNames, &o->ncontrollers, index));
  for (PetscInt i = 0; i < o->ncontrollers; i++) o->controllers[i] = ControllerNames[index[i]];
  PetscCall(Words(PetscOptionsObject, "-evaluate_errors",
                  "Error estimates: embedded, doubling, none (policies only); default embedded,doubling", TSBatheErrors,
                  &o->nerrors, o->errors));
  PetscCall(Words(PetscOptionsObject, "-evaluate_reactions",
                  "Treatments of the reaction: trapezoidal, implicit (default both)", TSBatheReactionTypes,
                  &o->nreactions, o->reactions));
  PetscCall(Numbers(PetscOptionsObject, "-evaluate_tolerances",
                    "Factors of both tolerances of the problem (default 1); policies always run with 1",
                    &o->ntolerances, NULL, o->tolerances));
  PetscCall(Numbers(PetscOptionsObject, "-evaluate_accuracies",
                    "Relative errors wanted of policies that observe log_accuracy, besides the default",
                    &o->naccuracies, NULL, o->accuracies));
  for (PetscInt i = 0; i < o->naccuracies; i++)
    PetscCheck(o->accuracies[i] < 1, PETSC_COMM_WORLD, PETSC_ERR_ARG_OUTOFRANGE,
               "-evaluate_accuracies has %g, expected numbers in (0, 1)", (double)o->accuracies[i]);
  PetscCall(Numbers(PetscOptionsObject, "-evaluate_steps", "Constant steps of the controller none (default 100)",
                    &o->nsteps, o->steps, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Limits(EvaluateOptions *o, SlipOptionItems PetscOptionsObject)
{
  const NumberOption row[] = {
    OPTION_INTEGER("-evaluate_repetitions", "Runs of each cell, for the median and range of its wall time",
                   &o->repetitions, 1, EVALUATE_MAX),
    OPTION_INTEGER("-evaluate_reference_steps",
                   "Constant steps of a reference; -1: the problem's own (fault 4000, circuit 200000); 0: references "
                   "must be in the file",
                   &o->reference_steps, -1, PETSC_MAX_REAL),
    OPTION_INTEGER("-evaluate_max_attempts", "Attempts after which a run is stopped and recorded as failed",
                   &o->max_attempts, 1, PETSC_MAX_REAL),
    OPTION_INTEGER("-evaluate_spread",
                   "Meshes of up to this many cells along an edge run one a process; finer ones run on all processes",
                   &o->spread, 0, PETSC_MAX_REAL),
    OPTION_REAL("-evaluate_time_limit",
                "Begin no further run after this many seconds; the same command continues later. 0: unlimited",
                &o->time_limit, 0, PETSC_MAX_REAL)};

  PetscFunctionBegin;
  PetscCall(OptionsNumbers(PetscOptionsObject, PETSC_STATIC_ARRAY_LENGTH(row), row));
  PetscCheck(o->reference_steps != 1, PETSC_COMM_WORLD, PETSC_ERR_ARG_OUTOFRANGE,
             "-evaluate_reference_steps is 1, expected -1, 0 or a number >= 2");
  PetscCall(SlipCheckBoolOption(PETSC_COMM_WORLD, NULL, NULL, "-evaluate_list"));
  PetscCall(PetscOptionsBool("-evaluate_list", "Print the cells and whether they are done, and stop", NULL, o->list,
                             &o->list, NULL));
  PetscCall(SlipCheckBoolOption(PETSC_COMM_WORLD, NULL, NULL, "-evaluate_repeat_failed"));
  PetscCall(PetscOptionsBool("-evaluate_repeat_failed", "Run the cells that failed again", NULL, o->repeat_failed,
                             &o->repeat_failed, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- policies: files found by name or pattern, and what their headers say ---- */

static PetscErrorCode ReadText(SlipH5 *h, const char attr[], char value[], size_t len)
{
  PetscBool has;

  PetscFunctionBegin;
  value[0] = '\0';
  PetscCall(SlipH5HasAttribute(h, "/", attr, &has));
  if (has) PetscCall(SlipH5ReadAttrString(h, "/", attr, value, len));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The name of a policy is that of its file without folders and ending. */
static PetscErrorCode AddPolicy(const char file[], PetscInt *n, EvaluatePolicy **policies)
{
  const char *slash = strrchr(file, '/'), *hash, *const * names;
  EvaluatePolicy *p;
  SlipPolicy policy;
  PetscInt nobs;
  PetscBool same, has;
  SlipH5 h;
  char *dot;

  PetscFunctionBegin;
  PetscCall(PetscRealloc(sizeof(**policies) * (size_t)(*n + 1), policies));
  p = &(*policies)[*n];
  PetscCall(PetscStrncpy(p->file, file, sizeof(p->file)));
  PetscCall(PetscStrncpy(p->name, slash ? slash + 1 : file, sizeof(p->name)));
  dot = strrchr(p->name, '.');
  if (dot && dot != p->name) *dot = '\0';
  for (PetscInt i = 0; i < *n; i++) {
    PetscCall(PetscStrcmp((*policies)[i].file, file, &same));
    if (same) PetscFunctionReturn(PETSC_SUCCESS);
    PetscCall(PetscStrcmp((*policies)[i].name, p->name, &same));
    PetscCheck(!same, PETSC_COMM_WORLD, PETSC_ERR_ARG_WRONG,
               "-evaluate_policies has %s and %s: cells are kept by the name %s, expected different ones",
               (*policies)[i].file, file, p->name);
  }
  PetscCall(SlipPolicyCreate(PETSC_COMM_SELF, &policy));
  PetscCall(SlipPolicyLoad(policy, p->file)); /* complains about whatever is no policy */
  PetscCall(SlipPolicyGetHash(policy, &hash));
  PetscCall(PetscStrncpy(p->hash, hash, sizeof(p->hash)));
  PetscCall(SlipPolicyGetObservations(policy, &nobs, &names));
  p->dial = PETSC_FALSE;
  for (PetscInt i = 0; i < nobs && !p->dial; i++) PetscCall(PetscStrcmp(names[i], SLIP_OBSERVES_ACCURACY, &p->dial));
  PetscCall(SlipPolicyDestroy(&policy));
  PetscCall(SlipH5OpenRead(p->file, &h));
  PetscCall(ReadText(&h, "problem", p->problem, sizeof(p->problem)));
  PetscCall(ReadText(&h, "algorithm", p->algorithm, sizeof(p->algorithm)));
  PetscCall(SlipH5HasAttribute(&h, "/", "alpha", &has));
  p->alpha = NAN;
  if (has) PetscCall(SlipH5ReadAttrReal(&h, "/", "alpha", &p->alpha));
  PetscCall(SlipH5Close(&h));
  ++*n;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Policies(EvaluateOptions *o, SlipOptionItems PetscOptionsObject)
{
  char *patterns[ROOM];
  PetscInt n = ROOM;
  PetscBool set, same = PETSC_FALSE, wanted;

  PetscFunctionBegin;
  PetscCall(PetscOptionsStringArray("-evaluate_policies", "HDF5 files of policies, or patterns such as 'dir/*.h5'",
                                    NULL, patterns, &n, &set));
  if (set) PetscCall(CheckCount("-evaluate_policies", n));
  if (!set) n = 0;
  for (PetscInt i = 0; i < n; i++) {
    glob_t found;

    PetscCheck(!glob(patterns[i], GLOB_NOCHECK, NULL, &found), PETSC_COMM_WORLD, PETSC_ERR_FILE_OPEN,
               "-evaluate_policies %s cannot be looked up", patterns[i]);
    for (size_t k = 0; k < found.gl_pathc; k++)
      PetscCallFile("-evaluate_policies", AddPolicy(found.gl_pathv[k], &o->npolicies, &o->policies));
    globfree(&found);
    PetscCall(PetscFree(patterns[i]));
  }
  PetscCall(PetscOptionsHasName(NULL, NULL, "-evaluate_controllers", &wanted));
  for (PetscInt i = 0; i < o->ncontrollers && !same; i++) PetscCall(PetscStrcmp(o->controllers[i], TSADAPTRL, &same));
  PetscCheck(o->npolicies || !wanted || !same, PETSC_COMM_WORLD, PETSC_ERR_ARG_WRONG,
             "-evaluate_controllers has rl, expected its policies in -evaluate_policies");
  for (PetscInt i = 0; i < o->npolicies; i++) {
    same = o->policies[i].problem[0] ? PETSC_FALSE : PETSC_TRUE;
    for (PetscInt k = 0; k < o->nproblems && !same; k++)
      PetscCall(PetscStrcmp(o->policies[i].problem, o->problems[k]->name, &same));
    PetscCheck(same, PETSC_COMM_WORLD, PETSC_ERR_ARG_WRONG,
               "-evaluate_policies has %s, which is for the problem %s; expected one of -evaluate_problems",
               o->policies[i].file, o->policies[i].problem);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* What cells choose themselves must not come from the options as well. */
static PetscErrorCode CheckConflicts(void)
{
  const char *const taken[][2] = {{"-ts_adapt_type", "-evaluate_controllers"},
                                  {"-ts_adapt_rl_policy", "-evaluate_policies"},
                                  {"-ts_bathe_error", "-evaluate_errors"},
                                  {"-ts_bathe_reaction", "-evaluate_reactions"},
                                  {"-ts_rtol", "-evaluate_tolerances"},
                                  {"-ts_atol", "-evaluate_tolerances"},
                                  {"-ts_dt", "-evaluate_steps"},
                                  {"-ts_time_step", "-evaluate_steps"},
                                  {"-fault_nx", "-evaluate_meshes"},
                                  {"-fault_nz", "-evaluate_meshes"},
                                  {"-fault_mesh", "-evaluate_meshes"},
                                  {"-fault_length_x", "-evaluate_sizes"},
                                  {"-fault_length_z", "-evaluate_sizes"},
                                  {"-fault_output", "-evaluate_output"}};
  PetscBool has;

  PetscFunctionBegin;
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(taken); i++) {
    PetscCall(PetscOptionsHasName(NULL, NULL, taken[i][0], &has));
    PetscCheck(!has, PETSC_COMM_WORLD, PETSC_ERR_ARG_WRONG, "%s has no place here: %s chooses it for each cell",
               taken[i][0], taken[i][1]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The options that change results, of which the cells of one file share the same. */
static PetscErrorCode Settings(char **settings)
{
  const char *const results[] = {"-fault_", "-ts_", "-snes_", "-ksp_", "-pc_", "-mat_", "-sliding_mode_", "-circuit_"};
  char *all, *word, *text;
  size_t len;
  PetscBool keep = PETSC_FALSE;

  PetscFunctionBegin;
  PetscCall(PetscOptionsGetAll(NULL, &all));
  PetscCall(PetscStrlen(all, &len));
  PetscCall(PetscCalloc1(len + 2, &text));
  for (word = strtok(all, " "); word; word = strtok(NULL, " ")) {
    if (word[0] == '-' && !(word[1] >= '0' && word[1] <= '9') && word[1] != '.') {
      keep = PETSC_FALSE;
      for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(results) && !keep; i++)
        keep = strncmp(word, results[i], strlen(results[i])) ? PETSC_FALSE : PETSC_TRUE;
    }
    if (!keep) continue;
    if (text[0]) PetscCall(PetscStrlcat(text, " ", len + 2));
    PetscCall(PetscStrlcat(text, word, len + 2));
  }
  PetscCall(PetscFree(all));
  *settings = text;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EvaluateOptionsSet(EvaluateOptions *o)
{
  const EvaluateOptions defaults = {.output = "evaluate.h5",
                                    .nsizes = 2,
                                    .sizes = {3, 5},
                                    .nmeshes = 2,
                                    .meshes = {25, 50},
                                    .nerrors = 2,
                                    .errors = {TSBATHE_ERROR_EMBEDDED, TSBATHE_ERROR_DOUBLING},
                                    .nreactions = 2,
                                    .reactions = {TSBATHE_REACTION_TRAPEZOIDAL, TSBATHE_REACTION_IMPLICIT},
                                    .ntolerances = 1,
                                    .tolerances = {1},
                                    .nsteps = 1,
                                    .steps = {100},
                                    .repetitions = 3,
                                    .reference_steps = -1,
                                    .coarser = 1,
                                    .max_attempts = 100000,
                                    .spread = 50};
  PetscBool quick = PETSC_FALSE;

  PetscFunctionBegin;
  *o = defaults;
  PetscOptionsBegin(PETSC_COMM_WORLD, NULL, "Evaluation of step-size controllers", "evaluate");
  PetscCall(PetscOptionsString("-evaluate_output", "HDF5 file, which later runs add to", NULL, o->output, o->output,
                               sizeof(o->output), NULL));
  PetscCall(SlipCheckBoolOption(PETSC_COMM_WORLD, NULL, NULL, "-evaluate_quick"));
  PetscCall(PetscOptionsBool(
    "-evaluate_quick",
    "A matrix of seconds: 3 km, 5 x 5 cells, the default integrator, one run each, coarse references; other "
    "options still apply",
    NULL, quick, &quick, NULL));
  if (quick) {
    o->nsizes = o->nmeshes = o->nerrors = o->nreactions = o->repetitions = 1;
    o->meshes[0] = 5;
    o->coarser = 10;
  }
  PetscCall(Axes(o, PetscOptionsObject));
  PetscCall(Limits(o, PetscOptionsObject));
  PetscCall(Policies(o, PetscOptionsObject));
  PetscOptionsEnd();
  PetscCheck(o->output[0], PETSC_COMM_WORLD, PETSC_ERR_ARG_WRONG, "-evaluate_output is empty");
  PetscCall(CheckConflicts());
  PetscCall(Settings(&o->settings));
  PetscFunctionReturn(PETSC_SUCCESS);
}
