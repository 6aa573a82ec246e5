/* Options of PETSc's solvers, checked before PETSc reads them: its messages about them do not name the option. */
#include <slipsys.h>
#include <slipcompat.h>
#include <petsc/private/petscimpl.h>
#include <math.h>

/* Options with a number as value, those of PETSc that a run of ours meets and those of TSBATHE and our controllers; and
   those of them whose number is a whole one. */
/* clang-format off */
static const char *const SlipNumbers[] = {
  "-ts_dt", "-ts_init_time", "-ts_max_time", "-ts_rtol", "-ts_atol", "-ts_adapt_dt_min", "-ts_adapt_dt_max",
  "-ts_adapt_safety", "-ts_adapt_reject_safety", "-ts_adapt_scale_solve_failed", "-ts_adapt_heuristic_growth",
  "-ts_adapt_heuristic_failure_factor", "-ts_adapt_pi_g1", "-ts_adapt_pi_g2", "-ts_adapt_pi_kappa",
  "-ts_adapt_pi_ratio_min", "-ts_adapt_pi_ratio_max", "-ts_adapt_pi_failure_factor", "-ts_adapt_rl_accuracy",
  "-ts_adapt_rl_error_ceiling", "-ts_bathe_gamma", "-snes_rtol", "-snes_atol", "-snes_stol", "-ksp_rtol", "-ksp_atol",
  "-ksp_divtol"
};
static const char *const SlipIntegers[] = {
  "-ts_max_steps", "-ts_max_snes_failures", "-ts_max_reject", "-ts_adapt_time_step_increase_delay",
  "-ts_adapt_rl_max_failures", "-ts_bathe_order", "-ts_bathe_max_failures", "-snes_max_it", "-snes_max_funcs",
  "-snes_slip_direct_max", "-ksp_max_it"
};
/* clang-format on */

/*@C
  SlipCheckNumberOption - refuse a value that is no number, with a message that names the option, which PETSc's does not

  Not collective.

  Input Parameters:
+ comm    - the processes that fail together
. options - the database, NULL for the global one
. prefix  - of the option, NULL for none
. option  - its name, with the dash
- whole   - it is read as an integer

  Output Parameters:
+ set   - whether it was given
- value - its number, 0 when it was not given; in the unit of the option

  Level: developer

  Errors: PETSC_ERR_ARG_WRONG for a text that is no number, or no whole one.

.seealso: SlipCheckSolverOptions()
@*/
PetscErrorCode SlipCheckNumberOption(MPI_Comm comm, PetscOptions options, const char prefix[], const char option[],
                                     PetscBool whole, PetscBool *set, PetscReal *value)
{
  PetscErrorCode number, integer = PETSC_SUCCESS;
  PetscInt unused;
  char text[64];

  PetscFunctionBegin;
  *value = 0;
  PetscCall(PetscOptionsGetString(options, prefix, option, text, sizeof(text), set));
  if (!*set) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscPushErrorHandler(PetscReturnErrorHandler, NULL));
  number = PetscOptionsStringToReal(text, value);
  if (whole) integer = PetscOptionsStringToInt(text, &unused);
  PetscCall(PetscPopErrorHandler());
  PetscCheck(!number && !integer, comm, PETSC_ERR_ARG_WRONG, "\"%s\" is not a %snumber (-%s%s)", text,
             number ? "" : "whole ", prefix ? prefix : "", option + 1);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipCheckSolverOptions - refuse values of PETSc's options that PETSc refuses without naming the option: types that are
  not known, texts that are no numbers or no whole ones, bounds of the step in the wrong order

  Collective; before TSSetFromOptions().

  Input Parameter:
. ts - the TS, with its prefix

  Level: intermediate

  Errors: PETSC_ERR_ARG_UNKNOWN_TYPE, PETSC_ERR_ARG_WRONG or PETSC_ERR_ARG_OUTOFRANGE, each with the option in brackets.

.seealso: TSBatheCheckOptions(), SlipErrorHandlerPush()
@*/
PetscErrorCode SlipCheckSolverOptions(TS ts)
{
  const struct {
    const char *option, *what;
    PetscFunctionList *list;
  } type[] = {{"-ts_type", "TS", &TSList},
              {"-snes_type", "SNES", &SNESList},
              {"-ksp_type", "KSP", &KSPList},
              {"-pc_type", "PC", &PCList}};
  const char *prefix;
  PetscOptions options;
  MPI_Comm comm;
  PetscReal low, high, value;
  PetscBool set, bounded;

  PetscFunctionBegin;
  PetscValidHeaderSpecific(ts, TS_CLASSID, 1);
  PetscCall(PetscObjectGetComm((PetscObject)ts, &comm));
  PetscCall(PetscObjectGetOptions((PetscObject)ts, &options));
  PetscCall(PetscObjectGetOptionsPrefix((PetscObject)ts, &prefix));
  PetscCall(TSInitializePackage());
  PetscCall(SNESInitializePackage());
  PetscCall(KSPInitializePackage());
  PetscCall(PCInitializePackage());
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(type); i++) {
    void (*create)(void) = NULL;
    char text[64];

    PetscCall(PetscOptionsGetString(options, prefix, type[i].option, text, sizeof(text), &set));
    if (set) PetscCall(PetscFunctionListFind(*type[i].list, text, &create));
    PetscCheck(!set || create, comm, PETSC_ERR_ARG_UNKNOWN_TYPE, "there is no type \"%s\" of %s (-%s%s)", text,
               type[i].what, prefix ? prefix : "", type[i].option + 1);
  }
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(SlipNumbers); i++)
    PetscCall(SlipCheckNumberOption(comm, options, prefix, SlipNumbers[i], PETSC_FALSE, &set, &value));
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(SlipIntegers); i++)
    PetscCall(SlipCheckNumberOption(comm, options, prefix, SlipIntegers[i], PETSC_TRUE, &set, &value));
  PetscCall(SlipCheckNumberOption(comm, options, prefix, "-ts_adapt_dt_min", PETSC_FALSE, &set, &low));
  PetscCall(SlipCheckNumberOption(comm, options, prefix, "-ts_adapt_dt_max", PETSC_FALSE, &bounded, &high));
  PetscCheck(!set || (low >= 0 && isfinite(low)), comm, PETSC_ERR_ARG_OUTOFRANGE,
             "the shortest step is %g s, expected a number >= 0 (-%sts_adapt_dt_min)", (double)low,
             prefix ? prefix : "");
  PetscCheck(!bounded || (high > 0 && high >= low), comm, PETSC_ERR_ARG_OUTOFRANGE,
             "the longest step is %g s, expected a number > 0 and >= the shortest one, %g s (-%sts_adapt_dt_max)",
             (double)high, (double)low, prefix ? prefix : "");
  PetscFunctionReturn(PETSC_SUCCESS);
}
