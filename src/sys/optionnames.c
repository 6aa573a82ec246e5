/* Finds options and words that no code will read, and suggests the nearest known name. Only programs that call these
   functions end with such errors, because the library in another program has no list of that program's words and
   options. */
#include <slipstep/rooms/slipsys.h>
#include <slipcompat.h>
#include <slipstep/private/slipsys.h>
#include <ctype.h>
#include <string.h>
#include <strings.h>

enum { SLIP_MAX_DECLARED = 32 };

typedef struct {
  const char *prefix, *names;
} SlipNames;

/* Options that the library reads, except those of faults, which declare theirs from their tables, and the numbers of
   solveroptions.c. test_options.py compares the list with the sources. */
static const SlipNames SlipLibrary[] = {
  {"slip_", "traceback"},
  {"slipstep_", "version"},
  {"ts_adams_", ""},
  {"ts_rkc_", ""},
  {"ts_bathe_", "method first_stage reaction error"},
  {"ts_adapt_heuristic_", ""},
  {"ts_adapt_pi_", "filter"},
  {"ts_adapt_rl_", "policy problem measure strict"},
  {"snes_slip_", ""},
  {"mat_slip", "_share fft_depth spectral_type sqrtm_setup sqrtm_tolerance stage_jacobian"},
  {"pc_slipstage_", "type"},
  {"circuit_", "case c1 c2 r l m start unit"},
  {"sliding_mode_", "case gain amplitude frequency start"},
};
/* Removed options: old scripts that give them still run, with a warning why they have no effect */
static const struct {
  const char *name, *why;
} SlipRetired[] = {
  {"fault_cache_dir", "no part of the set-up is kept in files since version 0.4.0, as computing it is as fast"},
};
static SlipNames SlipDeclared[SLIP_MAX_DECLARED];
static int SlipNumDeclared;

/* PETSc's options that our runs read, besides the numbers of solveroptions.c, for suggestions */
static const SlipNames SlipPetsc[] = {
  {"ts_", "type exact_final_time monitor monitor_cancel view rk_type error_if_step_fails save_trajectory"},
  {"ts_adapt_", "type always_accept clip monitor wnormtype dsp_filter dsp_pid"},
  {"snes_", "type monitor view converged_reason linesearch_type lag_jacobian"},
  {"ksp_", "type monitor monitor_true_residual view converged_reason norm_type gmres_restart pc_side"},
  {"pc_", "type factor_levels factor_mat_ordering_type view"},
};
/* Those of PETSc's options that every run needs, for the -help of a program's own options */
static const char SlipEssential[] = "ts_type ts_max_time ts_max_steps ts_dt ts_time_step ts_rtol ts_adapt_type "
                                    "ts_adapt_dt_min ts_adapt_dt_max snes_type";

/* Endings of options that PETSc reads during the solve, and of those that it reads when it ends */
static const char *const SlipReadInSolve[] = {"_view", "_view_solution", "_view_pre", "_converged_reason"};
static const char *const SlipReadAtEnd[] = {"citations",    "get_total_flops", "memory_view", "objects_dump",
                                            "options_left", "options_view",    "malloc_",     "log_"};

static PetscErrorCode SlipForgetDeclared(void)
{
  SlipNumDeclared = 0;
  return PETSC_SUCCESS;
}

/*@C
  SlipDeclareOptions - declares options that begin with a user's own prefix, for SlipCheckOptionNames()

  Not collective; after PetscInitialize().

  Input Parameters:
+ prefix - such as "oscillator_", borrowed; no other options begin with it
- names  - the rest of the names, separated by blanks, such as "mass stiffness"; one that ends with * covers all that
           begin so. Borrowed: constant text

  Level: intermediate

  Note:
  Several calls may declare options of one prefix.

  Errors: PETSC_ERR_PLIB for too many lists

.seealso: SlipCheckOptionNames()
@*/
PetscErrorCode SlipDeclareOptions(const char prefix[], const char names[])
{
  PetscFunctionBegin;
  for (int i = 0; i < SlipNumDeclared; i++)
    if (SlipDeclared[i].prefix == prefix && SlipDeclared[i].names == names) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCheck(SlipNumDeclared < SLIP_MAX_DECLARED, PETSC_COMM_SELF, PETSC_ERR_PLIB, "more than %d lists of options",
             SLIP_MAX_DECLARED);
  if (!SlipNumDeclared) PetscCall(PetscRegisterFinalize(SlipForgetDeclared));
  SlipDeclared[SlipNumDeclared++] = (SlipNames){prefix, names};
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- names ---- */

/* The i-th list; NULL after the last */
static const SlipNames *SlipList(size_t i)
{
  const size_t library = PETSC_STATIC_ARRAY_LENGTH(SlipLibrary);

  if (i < library) return &SlipLibrary[i];
  return i - library < (size_t)SlipNumDeclared ? &SlipDeclared[i - library] : NULL;
}

/* Number of letters to insert, remove, replace or swap with their neighbour that turn a into b, ignoring case (the
   restricted distance of Damerau 1964, Comm. ACM 7, 171) */
static int SlipNameDistance(const char a[], const char b[])
{
  static int row[3][SLIP_NAME_LENGTH + 1];
  const int m = (int)PetscMin(strlen(a), SLIP_NAME_LENGTH), n = (int)PetscMin(strlen(b), SLIP_NAME_LENGTH);

  for (int j = 0; j <= n; j++) row[0][j] = j;
  for (int i = 1; i <= m; i++) {
    int *now = row[i % 3], *last = row[(i + 2) % 3], *before = row[(i + 1) % 3];

    now[0] = i;
    for (int j = 1; j <= n; j++) {
      const int x = tolower((unsigned char)a[i - 1]), y = tolower((unsigned char)b[j - 1]);

      now[j] = PetscMin(last[j - 1] + (x != y), PetscMin(last[j], now[j - 1]) + 1);
      if (i > 1 && j > 1 && x == tolower((unsigned char)b[j - 2]) && y == tolower((unsigned char)a[i - 2]))
        now[j] = PetscMin(now[j], before[j - 2] + 1);
    }
  }
  return row[m % 3][n];
}

/* Finds the nearest of names after prefix, if it is nearer than *distance, which is updated. */
static void SlipNearer(const char word[], const char prefix[], const char names[], int *distance,
                       char nearest[SLIP_NAME_LENGTH])
{
  char name[SLIP_NAME_LENGTH];

  while (SlipNextName(prefix, &names, name)) {
    const int d = strchr(name, '*') ? SLIP_NAME_LENGTH : SlipNameDistance(word, name);

    if (d >= *distance) continue;
    *distance = d;
    memcpy(nearest, name, sizeof(name));
  }
}

/* Writes ": did you mean -x?" for the nearest name if at most a third of its own letters differ, else "". Its own
   letters are those after the part that both names share up to a _, because "fault_" makes no name similar. Returns the
   distance if it is at most two of eight or more own letters, or one of fewer, because no option of PETSc that we do
   not list is so close to one that we do; otherwise SLIP_NAME_LENGTH. */
static int SlipSuggest(const char word[], const char dash[], const char nearest[], int distance,
                       char text[SLIP_HINT_LENGTH])
{
  size_t common = 0;
  int letters;

  for (size_t k = 0; nearest[k] && tolower((unsigned char)word[k]) == tolower((unsigned char)nearest[k]); k++)
    if (nearest[k] == '_') common = k + 1;
  letters = (int)strlen(nearest + common);
  text[0] = '\0';
  if (distance > PetscMax(1, letters / 3)) return SLIP_NAME_LENGTH;
  (void)PetscSNPrintf(text, SLIP_HINT_LENGTH, ": did you mean %s%s?", dash, nearest);
  return distance <= (letters < 8 ? 1 : 2) ? distance : SLIP_NAME_LENGTH;
}

/* Writes the end of a message, ": did you mean NAME?" with the name nearest to a word, or "". */
PetscErrorCode SlipSuggestName(const char word[], const char names[], char text[SLIP_HINT_LENGTH])
{
  char nearest[SLIP_NAME_LENGTH] = "";
  int distance = SLIP_NAME_LENGTH;

  PetscFunctionBegin;
  SlipNearer(word, "", names, &distance, nearest);
  (void)SlipSuggest(word, "", nearest, distance, text);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* True if the name and the option belong to different classes of PETSc, as -dm_view and -ts_view */
static PetscBool SlipIsOfOtherClass(const char name[], const char option[])
{
  static const char *const classes[] = {"ts_", "snes_", "ksp_", "pc_", "mat_", "vec_", "dm_", "is_", "tao_"};

  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(classes); i++)
    if (!strncasecmp(name, classes[i], strlen(classes[i])))
      return strncasecmp(option, classes[i], strlen(classes[i])) ? PETSC_TRUE : PETSC_FALSE;
  return PETSC_FALSE;
}

/* Suggests the nearest known option, of ours or of PETSc's that our runs read. */
static int SlipSuggestOption(const char name[], const char dash[], char hint[SLIP_HINT_LENGTH])
{
  char nearest[SLIP_NAME_LENGTH] = "";
  const SlipNames *list;
  int distance = SLIP_NAME_LENGTH;
  const char *option;

  for (size_t i = 0; (list = SlipList(i)); i++) SlipNearer(name, list->prefix, list->names, &distance, nearest);
  for (size_t i = 0; (option = SlipNumberOption(i)); i++)
    if (!SlipIsOfOtherClass(name, option)) SlipNearer(name, "", option, &distance, nearest);
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(SlipPetsc); i++)
    if (!SlipIsOfOtherClass(name, SlipPetsc[i].prefix))
      SlipNearer(name, SlipPetsc[i].prefix, SlipPetsc[i].names, &distance, nearest);
  return SlipSuggest(name, dash, nearest, distance, hint);
}

/* True if the name is in a list; patterns: a name there that ends with * covers all that begin so */
static PetscBool SlipIsListed(const char name[], const SlipNames *list, PetscBool patterns)
{
  const char *place = list->names;
  char each[SLIP_NAME_LENGTH];

  while (SlipNextName(list->prefix, &place, each)) {
    const size_t last = strlen(each) - 1;

    if (each[last] == '*' ? patterns && !strncasecmp(name, each, last) : !strcasecmp(name, each)) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* True if the name begins with one of our prefixes; known: it is a known option */
static PetscBool SlipIsOurs(const char name[], PetscBool patterns, PetscBool *known)
{
  const SlipNames *list;
  const char *option;
  PetscBool ours = PETSC_FALSE;

  *known = PETSC_FALSE;
  for (size_t i = 0; (list = SlipList(i)) && !*known; i++) {
    if (strncasecmp(name, list->prefix, strlen(list->prefix))) continue;
    ours = PETSC_TRUE;
    *known = SlipIsListed(name, list, patterns);
  }
  for (size_t i = 0; ours && !*known && (option = SlipNumberOption(i)); i++)
    *known = strcasecmp(name, option) ? PETSC_FALSE : PETSC_TRUE;
  return ours;
}

/* True for our options by their full names, and for those of PETSc that every run needs */
PetscBool SlipIsHelpOption(const char name[])
{
  const SlipNames essential = {"", SlipEssential};
  PetscBool known;

  return (SlipIsOurs(name, PETSC_FALSE, &known) && known) || SlipIsListed(name, &essential, PETSC_FALSE) ? PETSC_TRUE
                                                                                                         : PETSC_FALSE;
}

/* ---- words ---- */

/* Number of bytes of a dash other than hyphen-minus at the beginning of a word, as in text copied from pages */
static size_t SlipForeignDash(const char word[])
{
  static const char *const dashes[] = {"\xE2\x80\x90", "\xE2\x80\x91", "\xE2\x80\x92", "\xE2\x80\x93", "\xE2\x80\x94",
                                       "\xE2\x80\x95", "\xE2\x88\x92", "\xEF\xB9\xA3", "\xEF\xBC\x8D"};

  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(dashes); i++)
    if (!strncmp(word, dashes[i], 3)) return 3;
  return 0;
}

/* Raises an error for "--name" and "-name=value", which PETSc stores as options that no code reads. */
static PetscErrorCode SlipCheckSpelling(const char name[], const char where[])
{
  const char *equals = strchr(name, '=');

  PetscFunctionBegin;
  PetscCheck(name[0] != '-', PETSC_COMM_WORLD, PETSC_ERR_ARG_WRONG, "-%s%s has two dashes, expected %s", name, where,
             name);
  PetscCheck(!equals, PETSC_COMM_WORLD, PETSC_ERR_ARG_WRONG, "-%s%s has an equals sign, expected -%.*s %s", name, where,
             (int)(equals - name), name, equals + 1);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipCheckOptionWords - raises an error for words that are no options: without a dash, with another sign for it, with
  two, or with an equals sign. PETSc ignores them without a message

  Collective on PETSC_COMM_WORLD

  Input Parameters:
+ n     - their number
. words - [n], as a shell would split them
- where - their source, for messages: " (file.txt)"; "" for the command line

  Level: developer

  Errors: PETSC_ERR_ARG_WRONG, with the word and what was expected

.seealso: SlipCheckOptionNames()
@*/
PetscErrorCode SlipCheckOptionWords(PetscInt n, const char *const words[], const char where[])
{
  PetscBool value = PETSC_FALSE, key; /* value: the word may be the value of the option before it */

  PetscFunctionBegin;
  for (PetscInt i = 0; i < n; i++) {
    const char *word = words[i];
    const size_t dash = SlipForeignDash(word);
    char hint[SLIP_HINT_LENGTH];

    PetscCheck(!dash, PETSC_COMM_WORLD, PETSC_ERR_ARG_WRONG,
               "%s%s begins with another sign than the dash of options, expected -%s", word, where, word + dash);
    PetscCall(PetscOptionsValidKey(word, &key));
    if (key) PetscCall(SlipCheckSpelling(word + 1, where));
    if (!key && !value) (void)SlipSuggestOption(word, "-", hint);
    PetscCheck(key || value, PETSC_COMM_WORLD, PETSC_ERR_ARG_WRONG,
               "%s%s follows no option, expected one word after each: lists have commas, patterns quotes%s", word,
               where, hint);
    value = key;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Raises an error for unknown options with our prefixes; words: also for options with a wrong dash or an equals sign */
static PetscErrorCode SlipCheckNames(MPI_Comm comm, PetscOptions options, const char prefix[], PetscBool words)
{
  const size_t len = strlen(prefix);
  PetscInt n;
  char **names, **values;

  PetscFunctionBegin;
  PetscCall(PetscOptionsLeftGet(options, &n, &names, &values));
  for (PetscInt i = 0; i < n; i++) {
    const char *name = names[i] + len;
    char hint[SLIP_HINT_LENGTH], dash[SLIP_NAME_LENGTH];
    PetscBool known, retired = PETSC_FALSE;

    if (words) PetscCall(SlipCheckSpelling(names[i], "")); /* options from files and the environment */
    if (strncasecmp(names[i], prefix, len) || !SlipIsOurs(name, PETSC_TRUE, &known) || known) continue;
    for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(SlipRetired) && !retired; k++) {
      if (strcasecmp(name, SlipRetired[k].name)) continue;
      PetscCall(SlipWarning("-%s%s does nothing: %s", prefix, SlipRetired[k].name, SlipRetired[k].why));
      PetscCall(PetscSNPrintf(dash, sizeof(dash), "-%s%s", prefix, name));
      PetscCall(PetscOptionsHasName(options, NULL, dash, &known)); /* this marks it as read */
      retired = PETSC_TRUE;
    }
    if (retired) continue;
    PetscCall(PetscSNPrintf(dash, sizeof(dash), "-%s", prefix));
    (void)SlipSuggestOption(name, dash, hint);
    SETERRQ(comm, PETSC_ERR_ARG_WRONG, "there is no option -%s%s", names[i], hint);
  }
  PetscCall(PetscOptionsLeftRestore(options, &n, &names, &values));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipCheckOptionNames - raises an error for unknown options with a prefix of the library or of SlipDeclareOptions(),
  and for words of the command line that belong to no option

  Collective on PETSC_COMM_WORLD; in a program, before anything is set up.

  Level: intermediate

  Note:
  The message has the nearest known name. Other options may belong to other code: SlipCheckUnusedOptions().

  Errors: PETSC_ERR_ARG_WRONG, with the option or word and what was expected

.seealso: SlipDeclareOptions(), SlipCheckUnusedOptions(), SlipErrorHandlerPush()
@*/
PetscErrorCode SlipCheckOptionNames(void)
{
  char **words;
  int argc;

  PetscFunctionBegin;
  PetscCall(PetscGetArgs(&argc, &words));
  if (argc > 1) PetscCall(SlipCheckOptionWords(argc - 1, (const char *const *)words + 1, ""));
  PetscCall(SlipCheckNames(PETSC_COMM_WORLD, NULL, "", PETSC_TRUE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipCheckOwnOptions - raises an error for unknown options with a prefix of the library, and for no others

  Not collective; for languages or programs that have words and other options of their own.

  Input Parameters:
+ comm    - the processes that fail together
. options - the database, NULL for the global one
- prefix  - prefix of all names, for two faults in one program; NULL for none

  Level: developer

  Errors: PETSC_ERR_ARG_WRONG, with the option and the nearest known one

.seealso: SlipCheckOptionNames(), SlipDeclareOptions()
@*/
PetscErrorCode SlipCheckOwnOptions(MPI_Comm comm, PetscOptions options, const char prefix[])
{
  PetscFunctionBegin;
  PetscCall(SlipCheckNames(comm, options, prefix ? prefix : "", PETSC_FALSE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- unused options ---- */

static PetscBool SlipIsReadLater(const char name[], PetscBool solved)
{
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(SlipReadInSolve) && !solved; i++)
    if (SlipEndsWith(name, SlipReadInSolve[i])) return PETSC_TRUE;
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(SlipReadAtEnd); i++)
    if (!strncasecmp(name, SlipReadAtEnd[i], strlen(SlipReadAtEnd[i]))) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* before: the solve is still to come, and names that resemble known ones are errors */
static PetscErrorCode SlipCheckUnused(PetscBool before)
{
  PetscInt n;
  PetscMPIInt rank;
  char **names, **values;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
  PetscCall(PetscOptionsLeftGet(NULL, &n, &names, &values));
  for (PetscInt i = 0; i < n; i++) {
    char option[SLIP_NAME_LENGTH + 1], hint[SLIP_HINT_LENGTH];
    const int distance = SlipSuggestOption(names[i], "-", hint);
    PetscBool known;

    if (!distance) hint[0] = '\0'; /* the option is a known one */
    PetscCheck(!before || !distance || distance == SLIP_NAME_LENGTH || SlipIsOurs(names[i], PETSC_TRUE, &known),
               PETSC_COMM_WORLD, PETSC_ERR_ARG_WRONG, "nothing reads the option -%s%s", names[i], hint);
    if (SlipIsReadLater(names[i], !before)) continue;
    if (!rank) PetscCall(SlipWarning("nothing has read the option -%s%s", names[i], hint));
    PetscCall(PetscSNPrintf(option, sizeof(option), "-%s", names[i]));
    PetscCall(PetscOptionsHasName(NULL, NULL, option, &known)); /* marks it as read, which avoids a second warning */
  }
  PetscCall(PetscOptionsLeftRestore(NULL, &n, &names, &values));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipCheckUnusedOptions - warns of unused options, and raises an error for those that differ by a letter or two from a
  known one

  Collective on PETSC_COMM_WORLD; in a program, after everything is set up and before the solve.

  Level: intermediate

  Note:
  Options that PETSc reads later are checked by SlipWarnOfUnusedOptions().

  Errors: PETSC_ERR_ARG_WRONG, with the option and the known one

.seealso: SlipCheckOptionNames(), SlipWarnOfUnusedOptions()
@*/
PetscErrorCode SlipCheckUnusedOptions(void)
{
  PetscFunctionBegin;
  PetscCall(SlipCheckUnused(PETSC_TRUE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipWarnOfUnusedOptions - warns of unused options, which are most often mistyped

  Collective on PETSC_COMM_WORLD; at the end of a program.

  Level: intermediate

  Note:
  Options that SlipCheckUnusedOptions() has named are not named again.

.seealso: SlipErrorHandlerPush(), SlipCheckUnusedOptions()
@*/
PetscErrorCode SlipWarnOfUnusedOptions(void)
{
  PetscFunctionBegin;
  PetscCall(SlipCheckUnused(PETSC_FALSE));
  PetscFunctionReturn(PETSC_SUCCESS);
}
