/* TSADAPTPI: digital filters with two errors of memory. */
#include <slipstep/private/slipadapt.h>

/* A digital filter: h_new = h E_n^(-q/g1) E_(n-1)^(-q/g2) (h_(n-1)/h_(n-2))^(-kappa). */
typedef struct {
  const char *name;
  PetscReal g1, g2, kappa; /* PETSC_INFINITY leaves a factor out */
} Filter;

/* Soederlind (2003), ACM TOMS 29, 1-26, table 1 and section 5; Arevalo et al. (2020) for H211b. */
static const Filter Filters[] = {
  {"elementary", 1, PETSC_INFINITY, 0},
  {"PI33", (PetscReal)3 / 2, -3, 0},
  {"PI34", (PetscReal)10 / 7, -(PetscReal)10 / 4, 0},
  {"PI42", (PetscReal)5 / 3, -5, 0},
  {"H211PI", 6, 6, 0},
  {"H211b2", 2, 2, 0.5},
  {"H211b4", 4, 4, 0.25},
};
#define NFILTERS ((PetscInt)PETSC_STATIC_ARRAY_LENGTH(Filters))
#define DEFAULT_FILTER (NFILTERS - 1)

typedef struct {
  PetscReal failure; /* factor on the step when a solve did not converge; first, for SlipAdaptAfterFailure() */
  Filter filter;
  PetscReal r_min; /* smaller step ratios reject */
  PetscReal r_max; /* larger ones are capped */
  /* history, moved by accepted steps only */
  PetscReal error;  /* E_(n-1); 1 at the start */
  PetscReal h_last; /* last accepted step [s]; 0 at the start */
} TSAdapt_PI;

/* Pure: the step ratio of a filter. ratio: last accepted step over the one before. */
static PetscReal FilterRatio(const Filter *filter, PetscReal q, PetscReal E, PetscReal E_last, PetscReal ratio)
{
  return PetscPowReal(E, -q / filter->g1) * PetscPowReal(E_last, -q / filter->g2) * PetscPowReal(ratio, -filter->kappa);
}

static PetscErrorCode TSAdaptChoose_PI(TSAdapt adapt, TS ts, PetscReal h, PetscInt *next_sc, PetscReal *next_h,
                                       PetscBool *accept, PetscReal *wlte, PetscReal *wltea, PetscReal *wlter)
{
  TSAdapt_PI *ctx = (TSAdapt_PI *)adapt->data;
  PetscInt order;
  PetscReal E, q, r, used;

  PetscFunctionBegin;
  PetscCall(SlipAdaptEvaluateError(adapt, ts, &order, &E));
  *next_sc = 0;
  *wlte = E;
  *wltea = *wlter = -1;
  *accept = PETSC_TRUE;
  *next_h = h;
  if (ts->steprestart || !ts->steps) {
    ctx->error = 1;
    ctx->h_last = 0;
  }
  if (E < 0) PetscFunctionReturn(PETSC_SUCCESS); /* no estimate, nothing to go by */
  q = (PetscReal)1 / (PetscReal)order;
  E = PetscMax(E, PETSC_SMALL);
  r = FilterRatio(&ctx->filter, q, E, ctx->error, ctx->h_last > 0 ? h / ctx->h_last : 1);
  *accept = r >= ctx->r_min || adapt->always_accept ? PETSC_TRUE : PETSC_FALSE;
  used = PetscMin(r, ctx->r_max);
  *next_h = h * used;
  if (!*accept) {
    PetscCall(SlipAdaptCheckMinimum(adapt, ts, *next_h, "the error estimate"));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  /* Where the cap acted, remember the error that would have asked for the cap: otherwise one step without error (a
     fault at rest) would vouch for the next one, however wrong that is. */
  ctx->error = r > used ? E * PetscPowReal(r / used, ctx->filter.g1 / q) : E;
  ctx->h_last = h;
  *next_h = PetscClipInterval(*next_h, adapt->dt_min, adapt->dt_max);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode CheckParameters(TSAdapt adapt, const TSAdapt_PI *ctx)
{
  MPI_Comm comm = PetscObjectComm((PetscObject)adapt);

  PetscFunctionBegin;
  PetscCheck(ctx->filter.g1 > 0, comm, PETSC_ERR_ARG_OUTOFRANGE, "-ts_adapt_pi_g1 is %g; expected > 0",
             (double)ctx->filter.g1);
  PetscCheck(ctx->filter.g2 != 0, comm, PETSC_ERR_ARG_OUTOFRANGE, "-ts_adapt_pi_g2 is 0; expected another number");
  PetscCheck(ctx->r_min > 0 && ctx->r_min < 1, comm, PETSC_ERR_ARG_OUTOFRANGE,
             "-ts_adapt_pi_ratio_min is %g; expected a number in (0, 1)", (double)ctx->r_min);
  PetscCheck(ctx->r_max > 1, comm, PETSC_ERR_ARG_OUTOFRANGE, "-ts_adapt_pi_ratio_max is %g; expected > 1",
             (double)ctx->r_max);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TSAdaptSetFromOptions_PI(TSAdapt adapt, SlipOptionItems PetscOptionsObject)
{
  TSAdapt_PI *ctx = (TSAdapt_PI *)adapt->data;
  const char *names[PETSC_STATIC_ARRAY_LENGTH(Filters)];
  PetscInt index = DEFAULT_FILTER;
  PetscBool set;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < NFILTERS; i++) names[i] = Filters[i].name;
  PetscOptionsHeadBegin(PetscOptionsObject, "Digital filter (PI) step-size controller options");
  PetscCall(PetscOptionsEList("-ts_adapt_pi_filter", "Named filter: sets g1, g2 and kappa", "", names, NFILTERS,
                              ctx->filter.name, &index, &set));
  if (set) ctx->filter = Filters[index];
  PetscCall(PetscOptionsReal("-ts_adapt_pi_g1", "Divides the exponent of the last error", "", ctx->filter.g1,
                             &ctx->filter.g1, NULL));
  PetscCall(PetscOptionsReal("-ts_adapt_pi_g2", "Divides the exponent of the error before", "", ctx->filter.g2,
                             &ctx->filter.g2, NULL));
  PetscCall(PetscOptionsReal("-ts_adapt_pi_kappa", "Exponent of the last ratio of steps", "", ctx->filter.kappa,
                             &ctx->filter.kappa, NULL));
  PetscCall(PetscOptionsReal("-ts_adapt_pi_ratio_min", "Smaller step ratios reject the step, in (0, 1)", "", ctx->r_min,
                             &ctx->r_min, NULL));
  PetscCall(PetscOptionsReal("-ts_adapt_pi_ratio_max", "Larger step ratios are capped, > 1", "", ctx->r_max,
                             &ctx->r_max, NULL));
  PetscCall(SlipAdaptFailureOption(adapt, PetscOptionsObject, "-ts_adapt_pi_failure_factor"));
  PetscOptionsHeadEnd();
  PetscCall(CheckParameters(adapt, ctx));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TSAdaptView_PI(TSAdapt adapt, PetscViewer viewer)
{
  const TSAdapt_PI *ctx = (const TSAdapt_PI *)adapt->data;
  PetscBool ascii;

  PetscFunctionBegin;
  PetscCall(PetscObjectTypeCompare((PetscObject)viewer, PETSCVIEWERASCII, &ascii));
  if (!ascii) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscViewerASCIIPrintf(viewer, "  filter %s: g1 %g, g2 %g, kappa %g\n", ctx->filter.name,
                                   (double)ctx->filter.g1, (double)ctx->filter.g2, (double)ctx->filter.kappa));
  PetscCall(PetscViewerASCIIPrintf(viewer, "  step ratio: rejects below %g, capped at %g; %g after a failed solve\n",
                                   (double)ctx->r_min, (double)ctx->r_max, (double)ctx->failure));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*MC
  TSADAPTPI - digital filters: h_new = h E_n^(-q/g1) E_(n-1)^(-q/g2) (h_(n-1)/h_(n-2))^(-kappa)

  The error estimate E goes with h^(1/q) (TSEvaluateWLTE()). A ratio h_new/h below ratio_min rejects the step, one above
  ratio_max is capped. The history (E_(n-1), h_(n-2)) moves on accepted steps only.

  Options Database Keys:
+ -ts_adapt_pi_filter <H211b4>      - elementary, PI33, PI34, PI42, H211PI, H211b2, H211b4
. -ts_adapt_pi_g1, -ts_adapt_pi_g2, -ts_adapt_pi_kappa - any other filter
. -ts_adapt_pi_ratio_min <0.8>      - smaller step ratios reject
. -ts_adapt_pi_ratio_max <1.2>      - larger step ratios are capped
- -ts_adapt_pi_failure_factor <0.6> - factor on the step when a solve did not converge

  Level: beginner

.seealso: TSADAPTHEURISTIC, TSADAPTRL
M*/
PetscErrorCode TSAdaptCreate_PI(TSAdapt adapt)
{
  TSAdapt_PI *ctx;

  PetscFunctionBegin;
  PetscCall(PetscNew(&ctx));
  ctx->filter = Filters[DEFAULT_FILTER];
  ctx->r_min = 0.8;
  ctx->r_max = 1.2;
  ctx->failure = 0.6;
  ctx->error = 1;
  adapt->data = ctx;
  adapt->ops->choose = TSAdaptChoose_PI;
  adapt->ops->setfromoptions = TSAdaptSetFromOptions_PI;
  adapt->ops->view = TSAdaptView_PI;
  adapt->ops->destroy = SlipAdaptDestroyData;
  PetscCall(PetscObjectComposeFunction((PetscObject)adapt, "TSAdaptChooseAfterFailure_C", SlipAdaptAfterFailure));
  PetscFunctionReturn(PETSC_SUCCESS);
}
