/* Dense networks, see dense.h. */
#include "learner.h"
#include <slipcompat.h>

void DenseShapeInit(DenseShape *s, PetscInt nets, PetscInt layers, const PetscInt size[], PetscBool relu_last)
{
  s->nets = nets;
  s->layers = layers;
  s->relu_last = relu_last;
  s->count = 0;
  s->size[0] = size[0];
  for (PetscInt l = 0; l < layers; ++l) {
    s->size[l + 1] = size[l + 1];
    s->weight[l] = s->count;
    s->bias[l] = s->weight[l] + (size_t)(size[l] * size[l + 1]);
    s->count = s->bias[l] + (size_t)size[l + 1];
  }
}

void DenseInitialize(const DenseShape *s, Random *r, Scalar p[])
{
  for (PetscInt k = 0; k < s->nets; ++k, p += s->count) {
    for (PetscInt l = 0; l < s->layers; ++l) {
      const double bound = 1 / sqrt((double)s->size[l]);
      const size_t end = l + 1 < s->layers ? s->weight[l + 1] : s->count;

      for (size_t i = s->weight[l]; i < end; ++i) p[i] = (Scalar)(bound * (2 * RandomUniform(r) - 1));
    }
  }
}

PetscErrorCode DenseWorkCreate(const DenseShape *s, PetscInt batch, DenseWork *w)
{
  PetscFunctionBegin;
  w->batch = batch;
  for (PetscInt l = 0; l < s->layers; ++l) {
    PetscCall(PetscCalloc1((size_t)(s->nets * s->size[l + 1] * batch), &w->out[l]));
    PetscCall(PetscCalloc1((size_t)(s->nets * s->size[l + 1] * batch), &w->delta[l]));
  }
  for (PetscInt l = s->layers; l < DENSE_MAX_LAYERS; ++l) w->out[l] = w->delta[l] = NULL;
  PetscCall(PetscMalloc1((size_t)batch, &w->ones));
  for (PetscInt b = 0; b < batch; ++b) w->ones[b] = 1;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode DenseWorkDestroy(DenseWork *w)
{
  PetscFunctionBegin;
  for (PetscInt l = 0; l < DENSE_MAX_LAYERS; ++l) {
    PetscCall(PetscFree(w->out[l]));
    PetscCall(PetscFree(w->delta[l]));
  }
  PetscCall(PetscFree(w->ones));
  PetscFunctionReturn(PETSC_SUCCESS);
}

TRAIN_CLONES static void AddBias(PetscInt rows, PetscInt B, const Scalar bias[], PetscBool relu, Scalar y[])
{
  for (PetscInt i = 0; i < rows; ++i, y += B) {
    const Scalar b = bias[i];

    if (relu) {
      for (PetscInt j = 0; j < B; ++j) y[j] = y[j] + b > 0 ? y[j] + b : 0;
    } else {
      for (PetscInt j = 0; j < B; ++j) y[j] += b;
    }
  }
}

/* The gradient passes where the ReLU was active; its derivative at 0 is 0. */
TRAIN_CLONES static void MaskRelu(size_t n, const Scalar out[], Scalar delta[])
{
  for (size_t i = 0; i < n; ++i) delta[i] = out[i] > 0 ? delta[i] : 0;
}

void DenseForward(const DenseShape *s, const Scalar p[], PetscInt B, const Scalar x[], DenseWork *w)
{
  for (PetscInt k = 0; k < s->nets; ++k, p += s->count) {
    const Scalar *in = x;

    for (PetscInt l = 0; l < s->layers; ++l) {
      const PetscInt ni = s->size[l], no = s->size[l + 1];
      Scalar *out = w->out[l] + k * no * B;

      ScalarGemm(CblasRowMajor, CblasNoTrans, CblasNoTrans, no, B, ni, 1, p + s->weight[l], ni, in, B, 0, out, B);
      AddBias(no, B, p + s->bias[l], l + 1 < s->layers || s->relu_last ? PETSC_TRUE : PETSC_FALSE, out);
      in = out;
    }
  }
}

void DenseBackward(const DenseShape *s, const Scalar p[], PetscInt B, const Scalar x[], DenseWork *w, Scalar grad[])
{
  for (PetscInt k = 0; k < s->nets; ++k, p += s->count) {
    for (PetscInt l = s->layers - 1; l >= 0; --l) {
      const PetscInt ni = s->size[l], no = s->size[l + 1];
      const Scalar *in = l ? w->out[l - 1] + k * ni * B : x;
      Scalar *delta = w->delta[l] + k * no * B;

      if (l + 1 < s->layers || s->relu_last) MaskRelu((size_t)(no * B), w->out[l] + k * no * B, delta);
      if (grad) {
        ScalarGemm(CblasRowMajor, CblasNoTrans, CblasTrans, no, ni, B, 1, delta, B, in, B, 0, grad + s->weight[l], ni);
        ScalarGemv(CblasRowMajor, CblasNoTrans, no, B, 1, delta, B, w->ones, 1, 0, grad + s->bias[l], 1);
      }
      if (l) {
        ScalarGemm(CblasRowMajor, CblasTrans, CblasNoTrans, ni, B, no, 1, p + s->weight[l], ni, delta, B, 0,
                   w->delta[l - 1] + k * ni * B, B);
      }
    }
    if (grad) grad += s->count;
  }
}

void DenseInputGradient(const DenseShape *s, const Scalar p[], PetscInt B, const DenseWork *w, PetscInt row,
                        Scalar dx[])
{
  const PetscInt ni = s->size[0], no = s->size[1];

  for (PetscInt k = 0; k < s->nets; ++k, p += s->count) {
    ScalarGemv(CblasRowMajor, CblasTrans, no, B, 1, w->delta[0] + k * no * B, B, p + s->weight[0] + row, ni, k ? 1 : 0,
               dx, 1);
  }
}

PetscErrorCode AdamCreate(size_t n, Adam *a)
{
  PetscFunctionBegin;
  a->n = n;
  a->t = 0;
  PetscCall(PetscCalloc2(n, &a->m, n, &a->v));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode AdamDestroy(Adam *a)
{
  PetscFunctionBegin;
  PetscCall(PetscFree2(a->m, a->v));
  PetscFunctionReturn(PETSC_SUCCESS);
}

TRAIN_CLONES static void AdamLoop(size_t n, Scalar step, Scalar root, const Scalar g[], Scalar m[], Scalar v[],
                                  Scalar p[])
{
  const Scalar b1 = (Scalar)(1 - 0.9), b2 = (Scalar)0.999, c2 = (Scalar)(1 - 0.999), eps = (Scalar)1e-8;

  for (size_t i = 0; i < n; ++i) {
    m[i] += b1 * (g[i] - m[i]);
    v[i] = b2 * v[i] + c2 * g[i] * g[i];
    p[i] -= step * m[i] / (ScalarSqrt(v[i]) / root + eps);
  }
}

void AdamStep(Adam *a, double lr, const Scalar grad[], Scalar p[])
{
  a->t++;
  AdamLoop(a->n, (Scalar)(lr / (1 - pow(0.9, (double)a->t))), (Scalar)sqrt(1 - pow(0.999, (double)a->t)), grad, a->m,
           a->v, p);
}

TRAIN_CLONES void PolyakAverage(size_t n, double tau, const Scalar p[], Scalar target[])
{
  const Scalar t = (Scalar)tau, r = (Scalar)(1 - tau);

  for (size_t i = 0; i < n; ++i) target[i] = r * target[i] + t * p[i];
}

/* ---- what the learners share, see learner.h ---- */

void LearnerShape(PetscInt nets, PetscInt in, PetscInt hidden, const PetscInt width[], PetscInt out, DenseShape *s)
{
  PetscInt size[LEARNER_MAX_HIDDEN + 2] = {in};

  for (PetscInt l = 0; l < hidden; ++l) size[l + 1] = width[l];
  size[hidden + 1] = out;
  DenseShapeInit(s, nets, out ? hidden + 1 : hidden, size, out ? PETSC_FALSE : PETSC_TRUE);
}

PetscErrorCode LearnerCheckOptions(const LearnerOptions *o)
{
  PetscFunctionBegin;
  PetscCheck(o->critics > 0 && o->batch > 0, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
             "Critics %" PetscInt_FMT ", batch %" PetscInt_FMT ": both must be positive", o->critics, o->batch);
  PetscCheck(o->actor_layers > 0 && o->actor_layers <= LEARNER_MAX_HIDDEN && o->critic_layers > 0 &&
               o->critic_layers <= LEARNER_MAX_HIDDEN,
             PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
             "%" PetscInt_FMT " hidden layers of the actor and %" PetscInt_FMT " of the critics, expected 1 to %d",
             o->actor_layers, o->critic_layers, LEARNER_MAX_HIDDEN);
  PetscFunctionReturn(PETSC_SUCCESS);
}
