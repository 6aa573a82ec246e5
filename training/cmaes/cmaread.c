/* -train_calibrate: the weights of a policy that is there, and how its dial was moved before. -train_start: its
   network, which a training with more observations begins with. */
#include "cmatrain.h"
#include "common/files.h"
#include <slipcompat.h>

/* Weights in the order of CMAPolicy(), of a network with so many inputs */
static PetscErrorCode ReadLayers(SlipH5 *h, const CMAOptions *o, PetscInt in, double w[])
{
  PetscInt found[2];
  char path[64];

  PetscFunctionBegin;
  for (PetscInt l = 0; l <= o->layers; ++l) {
    const PetscInt out = l < o->layers ? o->hidden : 1, dims[2] = {out, in};
    PetscReal *weight, *bias;

    PetscCall(PetscSNPrintf(path, sizeof(path), "/layers/%" PetscInt_FMT "/weight", l));
    PetscCall(SlipH5ReadRealSized(h, path, 2, dims, NULL, found, &weight));
    PetscCall(PetscSNPrintf(path, sizeof(path), "/layers/%" PetscInt_FMT "/bias", l));
    PetscCall(SlipH5ReadRealSized(h, path, 1, dims, NULL, found, &bias));
    for (PetscInt i = 0; i < out * in; ++i) *w++ = (double)weight[i];
    for (PetscInt i = 0; i < out; ++i) *w++ = (double)bias[i];
    PetscCall(PetscFree(weight));
    PetscCall(PetscFree(bias));
    in = out;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Of this problem, with these observations. The bounds of its steps and its scales become the trainer's; what the file
   says of the dial beyond the problem's own is how far that was moved. */
static PetscErrorCode Read(CMATrainer *t, SlipPolicy p, SlipH5 *h)
{
  CMAOptions *o = &t->o;
  const PetscInt dial = CMAFind(o, SLIP_OBSERVES_ACCURACY);
  const PetscReal middle = 0.5 * PetscLog10Real(o->low * o->high), own[2] = {o->scale[dial], o->offset[dial]};
  const char *const *names, *problem;
  PetscReal *scale, *offset, number;
  PetscInt n, found[1];
  PetscBool same, has;

  PetscFunctionBegin;
  PetscCall(SlipPolicyGetAttribute(p, "problem", &problem));
  PetscCall(PetscStrcmp(problem ? problem : "", ProblemPolicy(o->problem), &same));
  PetscCheck(same, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
             "-train_calibrate %s is a policy of the problem %s, expected one of %s (-train_problem)", o->calibrate,
             problem ? problem : "(none)", ProblemPolicy(o->problem));
  PetscCall(SlipPolicyGetObservations(p, &n, &names));
  same = n == o->nobs ? PETSC_TRUE : PETSC_FALSE;
  for (PetscInt i = 0; same && i < n; ++i) PetscCall(PetscStrcmp(names[i], o->names[i], &same));
  PetscCheck(same, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
             "-train_calibrate %s observes other numbers than -train_observations names", o->calibrate);
  PetscCall(SlipPolicyGetStepBounds(p, 1, 1, &o->dt_min, &o->dt_max));
  PetscCall(SlipPolicyGetNumber(p, SLIP_POLICY_MOVING_DT_MAX, &o->moving, &has));
  if (!has) o->moving = 0;
  PetscCall(SlipPolicyGetNumber(p, "generations", &number, &has));
  if (has) t->best_generation = (PetscInt64)number;
  PetscCall(SlipPolicyGetNumber(p, "training_runs", &number, &has));
  if (has) t->evaluations = (PetscInt64)number;
  PetscCall(SlipPolicyGetNumber(p, "validation_cost", &number, &has));
  if (has) t->score.cost = number;
  PetscCall(SlipH5ReadRealSized(h, "/observation/scale", 1, &o->nobs, NULL, found, &scale));
  PetscCall(SlipH5ReadRealSized(h, "/observation/offset", 1, &o->nobs, NULL, found, &offset));
  t->shift[1] = scale[dial] / own[0] - 1;
  t->shift[0] = (offset[dial] - own[1]) / own[0] + t->shift[1] * middle;
  PetscCall(PetscArraycpy(o->scale, scale, o->nobs));
  PetscCall(PetscArraycpy(o->offset, offset, o->nobs));
  o->scale[dial] = own[0];
  o->offset[dial] = own[1];
  PetscCall(PetscFree(scale));
  PetscCall(PetscFree(offset));
  PetscCall(ReadLayers(h, o, o->nobs, t->best));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CMAPolicyRead(CMATrainer *t)
{
  SlipPolicy p;
  SlipH5 h;

  PetscFunctionBegin;
  PetscCheck(t->cma->dial == CMA_DIAL_SPREAD && !t->o.more && t->o.within > 0, t->comm, PETSC_ERR_SUP,
             "-train_calibrate is for networks with an accuracy dial and no tolerance of their own, with -train_within "
             "above 0; the problem is %s",
             t->o.problem->name);
  PetscCall(SlipPolicyCreate(PETSC_COMM_SELF, &p));
  PetscCallFile("-train_calibrate", SlipPolicyLoad(p, t->o.calibrate));
  PetscCallFile("-train_calibrate", SlipH5OpenRead(t->o.calibrate, &h));
  PetscCallFile("-train_calibrate", Read(t, p, &h));
  PetscCall(SlipH5Close(&h));
  PetscCall(SlipPolicyDestroy(&p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The first mean: the file's network, in the scales of this training. What it does not observe has weights of 0. */
PetscErrorCode CMAStartRead(const CMAOptions *o, double w[])
{
  const PetscInt count = CMACount(o);
  const char *const *names;
  PetscReal *scale, *offset;
  PetscInt n, found[1];
  double *of_file, *bias = w + o->nobs * o->hidden;
  SlipPolicy p;
  SlipH5 h;

  PetscFunctionBegin;
  PetscCall(SlipPolicyCreate(PETSC_COMM_SELF, &p));
  PetscCallFile("-train_start", SlipPolicyLoad(p, o->first));
  PetscCall(SlipPolicyGetObservations(p, &n, &names));
  for (PetscInt k = 0; k < n; ++k)
    PetscCheck(CMAFind(o, names[k]) >= 0, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
               "-train_start %s observes %s, expected no more than -train_observations names", o->first, names[k]);
  PetscCallFile("-train_start", SlipH5OpenRead(o->first, &h));
  PetscCallFile("-train_start", SlipH5ReadRealSized(&h, "/observation/scale", 1, &n, NULL, found, &scale));
  PetscCallFile("-train_start", SlipH5ReadRealSized(&h, "/observation/offset", 1, &n, NULL, found, &offset));
  PetscCall(PetscCalloc1(count, &of_file));
  PetscCallFile("-train_start", ReadLayers(&h, o, n, of_file));
  PetscCall(SlipH5Close(&h));
  PetscCall(PetscArrayzero(w, o->nobs * o->hidden));
  PetscCall(PetscArraycpy(bias, of_file + n * o->hidden, count - o->nobs * o->hidden));
  for (PetscInt k = 0; k < n; ++k) {
    const PetscInt i = CMAFind(o, names[k]);

    for (PetscInt j = 0; j < o->hidden; ++j) {
      const double weight = of_file[j * n + k], ratio = (double)(scale[k] / o->scale[i]);

      w[j * o->nobs + i] = weight * ratio;
      bias[j] += weight * ((double)offset[k] - ratio * (double)o->offset[i]);
    }
  }
  PetscCall(PetscFree(of_file));
  PetscCall(PetscFree(scale));
  PetscCall(PetscFree(offset));
  PetscCall(SlipPolicyDestroy(&p));
  PetscFunctionReturn(PETSC_SUCCESS);
}
