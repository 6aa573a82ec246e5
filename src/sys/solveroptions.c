/* Checks options of PETSc's solvers before PETSc reads them, because its error messages do not name the option. */
#include <slipstep/rooms/slipsys.h>
#include <slipcompat.h>
#include <petsc/private/petscimpl.h>
#include <slipstep/private/slipsys.h>
#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

/* Properties of a number: bounds that are excluded, integers, infinite values */
enum { SLIP_OPEN_LOW = 1, SLIP_OPEN_HIGH = 2, SLIP_WHOLE = 4, SLIP_INFINITE = 8 };
#define NONE PETSC_MAX_REAL
#define ANY PETSC_MIN_REAL

typedef struct {
  const char *option;
  PetscReal low, high;
  int flags;
  const char *unit;
} SlipNumber;

/* Options with a number as value: PETSc's that our runs use, which have bounds here, and those of TSBATHE and our
   controllers, which check their bounds themselves and must only be finite here */
/* clang-format off */
static const SlipNumber SlipSolverNumbers[] = {
  {"-ts_dt", 0, NONE, SLIP_OPEN_LOW, "s"}, {"-ts_time_step", 0, NONE, SLIP_OPEN_LOW, "s"},
  {"-ts_init_time", ANY, NONE, 0, "s"}, {"-ts_max_time", ANY, NONE, 0, "s"},
  {"-ts_max_steps", 0, NONE, SLIP_WHOLE, ""},
  {"-ts_rtol", 0, NONE, 0, ""}, {"-ts_atol", 0, NONE, 0, ""},
  {"-ts_max_snes_failures", -1, NONE, SLIP_WHOLE, ""}, {"-ts_max_reject", -1, NONE, SLIP_WHOLE, ""},
  {"-ts_adapt_dt_min", 0, NONE, 0, "s"}, {"-ts_adapt_dt_max", 0, NONE, SLIP_OPEN_LOW | SLIP_INFINITE, "s"},
  {"-ts_adapt_safety", 0, 1, SLIP_OPEN_LOW, ""}, {"-ts_adapt_reject_safety", 0, 1, SLIP_OPEN_LOW, ""},
  {"-ts_adapt_scale_solve_failed", 0, 1, SLIP_OPEN_LOW | SLIP_OPEN_HIGH, ""},
  {"-ts_adapt_time_step_increase_delay", 0, NONE, SLIP_WHOLE, ""},
  {"-ts_adapt_heuristic_growth", ANY, NONE, 0, ""}, {"-ts_adapt_heuristic_failure_factor", ANY, NONE, 0, ""},
  {"-ts_adapt_pi_g1", ANY, NONE, SLIP_INFINITE, ""}, {"-ts_adapt_pi_g2", ANY, NONE, SLIP_INFINITE, ""},
  {"-ts_adapt_pi_kappa", ANY, NONE, 0, ""}, {"-ts_adapt_pi_ratio_min", ANY, NONE, 0, ""},
  {"-ts_adapt_pi_ratio_max", ANY, NONE, SLIP_INFINITE, ""}, {"-ts_adapt_pi_failure_factor", ANY, NONE, 0, ""},
  {"-ts_adapt_rl_accuracy", ANY, NONE, 0, ""}, {"-ts_adapt_rl_error_ceiling", ANY, NONE, SLIP_INFINITE, ""},
  {"-ts_adapt_rl_max_failures", ANY, NONE, SLIP_WHOLE, ""},
  {"-ts_adams_max_order", ANY, NONE, SLIP_WHOLE, ""}, {"-ts_adams_max_corrections", ANY, NONE, SLIP_WHOLE, ""},
  {"-ts_rkc_max_stages", ANY, NONE, SLIP_WHOLE, ""},
  {"-ts_rkc_rate", 0, 1e60, 0, "1/s"},
  {"-ts_bathe_gamma", ANY, NONE, 0, ""}, {"-ts_bathe_stage_error", ANY, NONE, 0, ""},
  {"-ts_bathe_order", ANY, NONE, SLIP_WHOLE, ""},
  {"-ts_bathe_max_failures", ANY, NONE, SLIP_WHOLE, ""},
  /* A stage below -snes_atol is accepted without iterations: residuals are relative to the strength, which the critical
     start exceeds by 1e-5, so that a fault would never move with 1e-4. Below -snes_rtol Newton steps continue to
     rounding. */
  {"-snes_rtol", 0, 1, SLIP_OPEN_HIGH, ""}, {"-snes_atol", 0, 1e-8, 0, ""}, {"-snes_stol", 0, 1, SLIP_OPEN_HIGH, ""},
  {"-snes_max_it", 0, NONE, SLIP_WHOLE, ""}, {"-snes_max_funcs", -1, NONE, SLIP_WHOLE, ""},
  {"-snes_slip_direct_max", ANY, NONE, SLIP_WHOLE, ""}};
static const SlipNumber SlipLinearNumbers[] = {
  {"-ksp_rtol", 0, 1, SLIP_OPEN_HIGH, ""}, {"-ksp_atol", 0, NONE, 0, ""},
  {"-ksp_divtol", 0, NONE, SLIP_OPEN_LOW | SLIP_INFINITE, ""}, {"-ksp_max_it", 0, NONE, SLIP_WHOLE, ""}};
/* clang-format on */

PetscErrorCode SlipPeekOption(PetscOptions options, const char prefix[], const char name[], char text[], size_t len,
                              PetscBool *has)
{
  char **names, **values, whole[SLIP_NAME_LENGTH];
  PetscInt n;

  PetscFunctionBegin;
  *has = PETSC_FALSE;
  text[0] = '\0';
  PetscCall(PetscSNPrintf(whole, sizeof(whole), "-%s%s", prefix ? prefix : "", name));
  PetscCall(PetscOptionsLeftGet(options, &n, &names, &values));
  for (PetscInt i = 0; i < n && !*has; i++) {
    *has = strcasecmp(names[i], whole + 1) ? PETSC_FALSE : PETSC_TRUE;
    if (*has && values[i]) PetscCall(PetscStrncpy(text, values[i], len));
  }
  PetscCall(PetscOptionsLeftRestore(options, &n, &names, &values));
  /* it was read before, or is not given */
  if (!*has) PetscCall(PetscOptionsGetString(options, NULL, whole, text, len, has));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipHasOption(PetscOptions options, const char prefix[], const char name[], PetscBool *has)
{
  char text[SLIP_NAME_LENGTH];

  PetscFunctionBegin;
  PetscCall(SlipPeekOption(options, prefix, name, text, sizeof(text), has));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The i-th number of both tables, NULL after the last */
static const SlipNumber *SlipNumberAt(size_t i)
{
  const size_t n = PETSC_STATIC_ARRAY_LENGTH(SlipSolverNumbers);

  if (i < n) return &SlipSolverNumbers[i];
  return i - n < PETSC_STATIC_ARRAY_LENGTH(SlipLinearNumbers) ? &SlipLinearNumbers[i - n] : NULL;
}

const char *SlipNumberOption(size_t i)
{
  const SlipNumber *number = SlipNumberAt(i);

  return number ? number->option + 1 : NULL;
}

/* Options that PETSc's TS, SNES, KSP and PC read as integers, by PetscOptionsInt() in their sources, besides those of
   the tables above. Others, such as times, may be larger. */
static const char SlipIntegers[] =
  "ts_max_step_rejections ts_run_steps ts_monitor_solution_vtk_interval ts_monitor_draw_solution "
  "ts_monitor_lg_solution ts_monitor_lg_timestep ts_monitor_lg_error ts_bdf_order ts_eimex_max_rows ts_gl_max_order "
  "ts_irk_nstages ts_rk_dtratio ts_ssp_num_stages snes_grid_sequence snes_lag_jacobian snes_lag_preconditioner "
  "snes_max_fail snes_max_linear_solve_fail snes_mf_version snes_anderson_m snes_anderson_restart snes_ngmres_m "
  "snes_ngmres_restart snes_ngs_sweeps snes_ngs_max_it snes_qn_m snes_linesearch_max_it snes_linesearch_order "
  "ksp_ew_version ksp_check_norm_iteration ksp_min_it ksp_gmres_restart ksp_gcr_restart ksp_lgmres_augment "
  "ksp_fcg_mmax ksp_bcgsl_ell ksp_idr_s ksp_chebyshev_esteig_steps pc_factor_levels pc_bjacobi_blocks pc_asm_blocks "
  "pc_asm_overlap pc_sor_its pc_sor_lits pc_mg_levels";

/* ---- integers ---- */

/* Raises an error for integers in a text that overflow PetscInt. PETSc truncates them without a message: with 32-bit
   integers it reads -ts_max_steps 4294967300 as 4. comm: the processes that fail together; name: of the
   option, without the dash; text: its value: a number, or several separated by commas, colons or dashes; other texts
   are ignored. Errors: PETSC_ERR_ARG_OUTOFRANGE, with the option, the number and the largest one. */
PetscErrorCode SlipCheckInteger(MPI_Comm comm, const char name[], const char text[])
{
  PetscFunctionBegin;
  for (const char *at = text; *at;) {
    const size_t sign = strspn(at, "+-") ? 1 : 0, digits = strspn(at + sign, "0123456789");
    const char after = at[sign + digits];
    long long value;

    if (digits && (!after || strchr(",:- ", after))) {
      errno = 0;
      value = strtoll(at, NULL, 10);
      PetscCheck(!errno && value >= PETSC_MIN_INT && value <= PETSC_MAX_INT, comm, PETSC_ERR_ARG_OUTOFRANGE,
                 "-%s is %.*s, which is more than this build's integers hold, %" PetscInt_FMT, name,
                 (int)(sign + digits), at, PETSC_MAX_INT);
    }
    at += sign + digits;
    at += strcspn(at, ",:- ");
    if (*at) at++;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Raises an error if the value of an option that is read as an integer, or as a list of them, overflows PetscInt. comm:
   the processes that fail together; options: the database, NULL for the global one; prefix: of the option, NULL for
   none; option: its name, with the dash. Errors: PETSC_ERR_ARG_OUTOFRANGE. */
PetscErrorCode SlipCheckIntegerOption(MPI_Comm comm, PetscOptions options, const char prefix[], const char option[])
{
  char name[128], text[1024];
  PetscBool set;

  PetscFunctionBegin;
  PetscCall(PetscOptionsGetString(options, prefix, option, text, sizeof(text), &set));
  PetscCall(PetscSNPrintf(name, sizeof(name), "%s%s", prefix ? prefix : "", option + 1));
  if (set) PetscCall(SlipCheckInteger(comm, name, text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* True if a name ends with this, ignoring case: the name of an option with or without a prefix */
PetscBool SlipEndsWith(const char name[], const char end[])
{
  const size_t len = strlen(name), tail = strlen(end);

  return len >= tail && !strcasecmp(name + len - tail, end) ? PETSC_TRUE : PETSC_FALSE;
}

/* ---- numbers ---- */

/* Describes the allowed values, for example "a number > 0 s", by C's %g, because PETSc's writes "0." for 0. */
static void SlipDescribeNumber(const SlipNumber *n, char text[], size_t len)
{
  char low[32] = "", high[32] = "";

  if (n->low > ANY) (void)snprintf(low, sizeof(low), " %s %g", n->flags & SLIP_OPEN_LOW ? ">" : ">=", (double)n->low);
  if (n->high < NONE)
    (void)snprintf(high, sizeof(high), "%s %s %g", low[0] ? " and" : "",
                   n->flags & SLIP_OPEN_HIGH ? "<" : "<=", (double)n->high);
  (void)snprintf(text, len, "a %s%snumber%s%s%s%s", n->flags & (SLIP_INFINITE | SLIP_WHOLE) || low[0] ? "" : "finite ",
                 n->flags & SLIP_WHOLE ? "whole " : "", low, high, n->unit[0] ? " " : "", n->unit);
}

/* Converts a text to a number; PETSc's own messages do not name the option. */
static PetscErrorCode SlipParseNumber(MPI_Comm comm, const char prefix[], const char option[], const char text[],
                                      PetscBool whole, PetscReal *value)
{
  PetscErrorCode number, integer = PETSC_SUCCESS;
  PetscInt unused;
  char name[128];

  PetscFunctionBegin;
  PetscCall(PetscPushErrorHandler(PetscReturnErrorHandler, NULL));
  number = PetscOptionsStringToReal(text, value);
  if (whole) integer = PetscOptionsStringToInt(text, &unused);
  PetscCall(PetscPopErrorHandler());
  PetscCheck(!number && !integer, comm, PETSC_ERR_ARG_WRONG, "\"%s\" is not a %snumber (-%s%s)%s", text,
             number ? "" : "whole ", prefix ? prefix : "", option + 1,
             SlipIsTimeOption(option + 1) ? ", nor one with " SLIP_TIME_UNITS " behind it" : "");
  PetscCall(PetscSNPrintf(name, sizeof(name), "%s%s", prefix ? prefix : "", option + 1));
  if (whole) PetscCall(SlipCheckInteger(comm, name, text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Options that have not been read yet; this does not mark them as read, so that programs still warn of unused ones. */
typedef struct {
  MPI_Comm comm;
  const char *prefix;
  PetscInt n;
  char **names, **values;
} SlipUnread;

/* The text of an option, "" if it has none, NULL if it was not given */
static const char *SlipUnreadValue(const SlipUnread *u, const char option[])
{
  const size_t len = u->prefix ? strlen(u->prefix) : 0;

  for (PetscInt i = 0; i < u->n; i++)
    if (!strncasecmp(u->names[i], u->prefix ? u->prefix : "", len) && !strcasecmp(u->names[i] + len, option + 1))
      return u->values[i] ? u->values[i] : "";
  return NULL;
}

/* Checks the bounds of numbers. PETSc checks words in their place (unlimited, default). */
static PetscErrorCode SlipCheckNumbers(const SlipUnread *u, size_t count, const SlipNumber number[])
{
  PetscFunctionBegin;
  for (size_t i = 0; i < count; i++) {
    const SlipNumber *n = &number[i];
    const char *text = SlipUnreadValue(u, n->option);
    char expected[128], value[32];
    PetscBool low, high;
    PetscReal x;

    if (!text) continue;
    PetscCall(
      SlipParseNumber(u->comm, u->prefix, n->option, text, n->flags & SLIP_WHOLE ? PETSC_TRUE : PETSC_FALSE, &x));
    if (isfinite(x) && isalpha((unsigned char)text[0])) continue;
    low = (n->flags & SLIP_OPEN_LOW ? x > n->low : x >= n->low) ? PETSC_TRUE : PETSC_FALSE;
    high = (n->flags & SLIP_OPEN_HIGH ? x < n->high : x <= n->high) ? PETSC_TRUE : PETSC_FALSE;
    if (isinf(x)) low = high = x > 0 && n->flags & SLIP_INFINITE ? PETSC_TRUE : PETSC_FALSE;
    SlipDescribeNumber(n, expected, sizeof(expected));
    (void)snprintf(value, sizeof(value), "%g", (double)x);
    PetscCheck(low && high, u->comm, PETSC_ERR_ARG_OUTOFRANGE, "-%s%s is %s, expected %s", u->prefix ? u->prefix : "",
               n->option + 1, value, expected);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Checks PETSc's options with several numbers. */
static PetscErrorCode SlipCheckLists(const SlipUnread *u)
{
  static const struct {
    const char *option, *expected;
    size_t least, most;
  } lists[] = {{"-ts_adapt_clip", "two numbers, low,high, with 0 <= low < 1 and high >= 1", 2, 2},
               {"-ts_adapt_dsp_pid", "one to three finite numbers with commas between", 1, 3}};

  PetscFunctionBegin;
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(lists); i++) {
    const char *text = SlipUnreadValue(u, lists[i].option);
    PetscBool good = PETSC_TRUE;
    PetscReal x[3] = {0};
    size_t n = 0;

    if (!text) continue;
    for (const char *at = text; at && good; n++) {
      char *end;
      const PetscReal value = strtod(at, &end);

      good = end > at && (!*end || *end == ',') && isfinite(value) && n < lists[i].most ? PETSC_TRUE : PETSC_FALSE;
      if (good) x[n] = value;
      at = *end ? end + 1 : NULL;
    }
    if (good && i == 0) good = n == 2 && x[0] >= 0 && x[0] < 1 && x[1] >= 1 ? PETSC_TRUE : PETSC_FALSE;
    PetscCheck(good && n >= lists[i].least, u->comm, PETSC_ERR_ARG_WRONG, "-%s%s is \"%s\", expected %s",
               u->prefix ? u->prefix : "", lists[i].option + 1, text, lists[i].expected);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Raises an error for integers in PETSc's options that overflow PetscInt, whatever their prefix. comm: the processes
   that fail together; options: the database, NULL for the global one. Errors: PETSC_ERR_ARG_OUTOFRANGE. */
PetscErrorCode SlipCheckIntegers(MPI_Comm comm, PetscOptions options)
{
  PetscInt n;
  char **names, **values;

  PetscFunctionBegin;
  PetscCall(PetscOptionsLeftGet(options, &n, &names, &values));
  for (PetscInt i = 0; i < n; i++) {
    const char *place = SlipIntegers;
    const SlipNumber *number;
    char each[SLIP_NAME_LENGTH];
    PetscBool whole = PETSC_FALSE;

    if (!values[i]) continue;
    while (!whole && SlipNextName("", &place, each)) whole = SlipEndsWith(names[i], each);
    for (size_t k = 0; !whole && (number = SlipNumberAt(k)); k++)
      whole = number->flags & SLIP_WHOLE && SlipEndsWith(names[i], number->option + 1) ? PETSC_TRUE : PETSC_FALSE;
    if (whole) PetscCall(SlipCheckInteger(comm, names[i], values[i]));
  }
  PetscCall(PetscOptionsLeftRestore(options, &n, &names, &values));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Raises an error that names the option for a value that is no number, unlike PETSc's message. comm: the processes that
   fail together; options: the database, NULL for the global one; prefix: of the option, NULL for none; option: its
   name, with the dash; whole: it is read as an integer; value: its number, 0 when it was not given; in the unit of the
   option. Errors: PETSC_ERR_ARG_WRONG for a text that is no number, or no whole one. */
PetscErrorCode SlipCheckNumberOption(MPI_Comm comm, PetscOptions options, const char prefix[], const char option[],
                                     PetscBool whole, PetscBool *set, PetscReal *value)
{
  char text[64];

  PetscFunctionBegin;
  *value = 0;
  PetscCall(PetscOptionsGetString(options, prefix, option, text, sizeof(text), set));
  if (*set) PetscCall(SlipParseNumber(comm, prefix, option, text, whole, value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipCheckFiniteOption - raises an error that names the option for a value that is not a finite number

  Not collective.

  Input Parameters:
+ comm   - the processes that fail together
- option - its name, with the dash, in the global database

  Level: developer

  Errors: PETSC_ERR_ARG_WRONG, PETSC_ERR_ARG_OUTOFRANGE

.seealso: SlipCheckNumberOption()
@*/
PetscErrorCode SlipCheckFiniteOption(MPI_Comm comm, const char option[])
{
  PetscReal value;
  PetscBool set;
  char text[32];

  PetscFunctionBegin;
  PetscCall(SlipCheckNumberOption(comm, NULL, NULL, option, PETSC_FALSE, &set, &value));
  (void)snprintf(text, sizeof(text), "%g", (double)value);
  PetscCheck(isfinite(value), comm, PETSC_ERR_ARG_OUTOFRANGE, "%s is %s, expected a finite number", option, text);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Raises an error that names the option for a value that is neither yes nor no, unlike PETSc's message. comm: the
   processes that fail together; options: the database, NULL for the global one; prefix: of the option, NULL for none;
   option: its name, with the dash. Errors: PETSC_ERR_ARG_WRONG for another text than yes, true, on, 1, no, false, off,
   0 or none. */
PetscErrorCode SlipCheckBoolOption(MPI_Comm comm, PetscOptions options, const char prefix[], const char option[])
{
  PetscErrorCode ierr;
  char text[64];
  PetscBool set, value;

  PetscFunctionBegin;
  PetscCall(PetscOptionsGetString(options, prefix, option, text, sizeof(text), &set));
  if (!set) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscPushErrorHandler(PetscReturnErrorHandler, NULL));
  ierr = PetscOptionsStringToBool(text, &value);
  PetscCall(PetscPopErrorHandler());
  PetscCheck(!ierr, comm, PETSC_ERR_ARG_WRONG, "-%s%s is \"%s\", expected yes or no", prefix ? prefix : "", option + 1,
             text);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Raises an error for a type that no library has registered. */
static PetscErrorCode CheckType(const SlipUnread *u, const char option[], const char what[], PetscFunctionList list)
{
  const char *text = SlipUnreadValue(u, option);
  void (*create)(void) = NULL;

  PetscFunctionBegin;
  if (text) PetscCall(PetscFunctionListFind(list, text, &create));
  PetscCheck(!text || create, u->comm, PETSC_ERR_ARG_UNKNOWN_TYPE, "there is no type \"%s\" of %s (-%s%s)", text, what,
             u->prefix ? u->prefix : "", option + 1);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Checks the types and numbers of a KSP. */
static PetscErrorCode CheckLinear(const SlipUnread *u)
{
  PetscFunctionBegin;
  PetscCall(KSPInitializePackage());
  PetscCall(PCInitializePackage());
  PetscCall(CheckType(u, "-ksp_type", "KSP", KSPList));
  PetscCall(CheckType(u, "-pc_type", "PC", PCList));
  PetscCall(SlipCheckNumbers(u, PETSC_STATIC_ARRAY_LENGTH(SlipLinearNumbers), SlipLinearNumbers));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Raises errors that name the option for invalid types and numbers of a KSP. options: the database, NULL for the global
   one; prefix: of the KSP, NULL for none. Errors: PETSC_ERR_ARG_UNKNOWN_TYPE, PETSC_ERR_ARG_WRONG or
   PETSC_ERR_ARG_OUTOFRANGE, with the option and what was expected. */
PetscErrorCode SlipCheckLinearOptions(MPI_Comm comm, PetscOptions options, const char prefix[])
{
  SlipUnread u = {.comm = comm, .prefix = prefix};

  PetscFunctionBegin;
  PetscCall(PetscOptionsLeftGet(options, &u.n, &u.names, &u.values));
  PetscCall(CheckLinear(&u));
  PetscCall(PetscOptionsLeftRestore(options, &u.n, &u.names, &u.values));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipCheckSolverOptions - raises errors for values that PETSc refuses without naming the option: unknown types, texts
  that are no numbers or no integers, numbers out of their bounds, bounds of the step in the wrong order. Times with a
  unit, such as -ts_max_time 100y, are converted to seconds

  Collective; before TSSetFromOptions().

  Input Parameter:
. ts - the TS, with its prefix

  Level: intermediate

  Errors: PETSC_ERR_ARG_UNKNOWN_TYPE, PETSC_ERR_ARG_WRONG or PETSC_ERR_ARG_OUTOFRANGE, each with the option in brackets.

.seealso: SlipExpandTimes(), TSBatheCheckOptions(), SlipErrorHandlerPush()
@*/
PetscErrorCode SlipCheckSolverOptions(TS ts)
{
  SlipUnread u;
  PetscOptions options;
  const char *text, *low, *high;

  PetscFunctionBegin;
  PetscValidHeaderSpecific(ts, TS_CLASSID, 1);
  PetscCall(PetscObjectGetComm((PetscObject)ts, &u.comm));
  PetscCall(PetscObjectGetOptions((PetscObject)ts, &options));
  PetscCall(PetscObjectGetOptionsPrefix((PetscObject)ts, &u.prefix));
  PetscCall(SlipExpandTimes(options));
  PetscCall(SlipCheckIntegers(u.comm, options));
  PetscCall(TSInitializePackage());
  PetscCall(SNESInitializePackage());
  PetscCall(PetscOptionsLeftGet(options, &u.n, &u.names, &u.values));
  PetscCall(CheckType(&u, "-ts_type", "TS", TSList));
  PetscCall(CheckType(&u, "-snes_type", "SNES", SNESList));
  text = SlipUnreadValue(&u, "-ts_adapt_type");
  if (text) { /* an object checks it, because the list of types is private to PETSc */
    PetscErrorCode ierr;
    TSAdapt adapt;

    PetscCall(TSAdaptCreate(u.comm, &adapt));
    PetscCall(PetscPushErrorHandler(PetscReturnErrorHandler, NULL));
    ierr = TSAdaptSetType(adapt, text);
    PetscCall(PetscPopErrorHandler());
    PetscCall(TSAdaptDestroy(&adapt));
    PetscCheck(!ierr, u.comm, PETSC_ERR_ARG_UNKNOWN_TYPE,
               "there is no type \"%s\" of TSAdapt (-%sts_adapt_type), expected rl, heuristic, pi, none, basic or dsp",
               text, u.prefix ? u.prefix : "");
  }
  PetscCall(SlipCheckNumbers(&u, PETSC_STATIC_ARRAY_LENGTH(SlipSolverNumbers), SlipSolverNumbers));
  PetscCall(SlipCheckLists(&u));
  PetscCall(CheckLinear(&u));
  low = SlipUnreadValue(&u, "-ts_adapt_dt_min");
  high = SlipUnreadValue(&u, "-ts_adapt_dt_max");
  if (low && high) {
    PetscReal least = 0, most = 0;

    PetscCall(SlipParseNumber(u.comm, u.prefix, "-ts_adapt_dt_min", low, PETSC_FALSE, &least));
    PetscCall(SlipParseNumber(u.comm, u.prefix, "-ts_adapt_dt_max", high, PETSC_FALSE, &most));
    PetscCheck(most >= least, u.comm, PETSC_ERR_ARG_OUTOFRANGE,
               "the longest step is %s s, expected a number >= the shortest one, %s s (-%sts_adapt_dt_max)", high, low,
               u.prefix ? u.prefix : "");
  }
  PetscCall(PetscOptionsLeftRestore(options, &u.n, &u.names, &u.values));
  PetscFunctionReturn(PETSC_SUCCESS);
}
