static const char help[] =
  "First-order sliding mode controller dw/dt = D sin(omega t) + F_r, F_r in -k Sign(w).\n"
  "  sliding_mode -ts_adapt_type pi -sliding_mode_output run.h5\n"
  "Defaults: the evaluation setting, 0.5 s (-ts_max_time), steps from 1e-9 s to 2 pi/(10 omega) "
  "(-ts_adapt_dt_min, -ts_adapt_dt_max), -ts_rtol 1e-3, -ts_atol 1e-6, -ts_adapt_type heuristic.\n\n";

#include "smallmodel.h"

static PetscErrorCode Solution(const Run *run, PetscReal t, PetscReal w[])
{
  PetscReal reaction;

  PetscFunctionBeginUser;
  w[0] = (*run->model->ops->exact)(run->model, t, &reaction);
  PetscFunctionReturn(0);
}

static PetscErrorCode Results(const Run *run, const PetscReal w[], SlipOutput output)
{
  PetscFunctionBeginUser;
  PetscCall(SlipOutputAddResult(output, "w", "final w", NULL, w[0]));
  PetscCall(SlipOutputAddResult(output, "l2_error", "L2 error", NULL, PetscSqrtReal(run->errors / run->time)));
  PetscCall(SlipOutputAddResult(output, "max_error", "largest error", NULL, run->largest));
  PetscFunctionReturn(0);
}

int main(int argc, char **argv)
{
  const Program program = {
    "sliding_mode", help,     "sliding_mode_", "output output_overwrite", &SlipSlidingModeOps, NULL,
    NULL,           Solution, Results};

  return RunProgram(argc, argv, &program);
}
