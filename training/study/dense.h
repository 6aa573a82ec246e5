/* Dense networks on BLAS: forward, backward, Adam, Polyak averaging. Batches are feature-major, x[feature][sample]
   with leading dimension B, so that every loop over samples is contiguous. Several networks of one shape lie one after
   the other in one parameter vector and share their input (the critics). */
#pragma once
#include "scalar.h"
#include "common/random.h"

#define DENSE_MAX_LAYERS 8

typedef struct {
  PetscInt nets;                       /* networks of this shape */
  PetscInt layers;                     /* linear layers of each */
  PetscInt size[DENSE_MAX_LAYERS + 1]; /* inputs, hidden widths, outputs */
  PetscBool relu_last;                 /* the last layer has a ReLU like all others; otherwise it is linear */
  size_t weight[DENSE_MAX_LAYERS];     /* offset of W[out][in] in the parameters of one network */
  size_t bias[DENSE_MAX_LAYERS];       /* offset of b[out] */
  size_t count;                        /* parameters of one network */
} DenseShape;

typedef struct {
  PetscInt batch;                  /* capacity in samples */
  Scalar *out[DENSE_MAX_LAYERS];   /* output of each layer [nets][size][B] */
  Scalar *delta[DENSE_MAX_LAYERS]; /* gradient with respect to the layer's pre-activation, same shape */
  Scalar *ones;                    /* [batch], for sums over the batch */
} DenseWork;

/* Adam (Kingma & Ba 2015), beta = (0.9, 0.999), eps = 1e-8. */
typedef struct {
  size_t n;
  Scalar *m, *v;
  PetscInt64 t; /* steps done */
} Adam;

PETSC_INTERN void DenseShapeInit(DenseShape *s, PetscInt nets, PetscInt layers, const PetscInt size[],
                                 PetscBool relu_last);
/* Every weight and bias ~ U(-1/sqrt(fan_in), 1/sqrt(fan_in)), as torch.nn.Linear. p [nets * count] */
PETSC_INTERN void DenseInitialize(const DenseShape *s, Random *r, Scalar p[]);
PETSC_INTERN PetscErrorCode DenseWorkCreate(const DenseShape *s, PetscInt batch, DenseWork *w);
PETSC_INTERN PetscErrorCode DenseWorkDestroy(DenseWork *w);
/* x [size[0]][B]; the result is w->out[layers-1], [nets][size[layers]][B]. */
PETSC_INTERN void DenseForward(const DenseShape *s, const Scalar p[], PetscInt B, const Scalar x[], DenseWork *w);
/* Fill w->delta[layers-1] with the gradient of the loss with respect to the output first. grad [nets * count] is
   overwritten; NULL leaves out the parameters' gradient (only the deltas are needed for the gradient with respect to
   the input). */
PETSC_INTERN void DenseBackward(const DenseShape *s, const Scalar p[], PetscInt B, const Scalar x[], DenseWork *w,
                                Scalar grad[]);
/* After DenseBackward: gradient with respect to one row of the input, summed over the networks. dx [B] */
PETSC_INTERN void DenseInputGradient(const DenseShape *s, const Scalar p[], PetscInt B, const DenseWork *w,
                                     PetscInt row, Scalar dx[]);

PETSC_INTERN PetscErrorCode AdamCreate(size_t n, Adam *a);
PETSC_INTERN PetscErrorCode AdamDestroy(Adam *a);
PETSC_INTERN void AdamStep(Adam *a, double lr, const Scalar grad[], Scalar p[]);
/* target <- (1 - tau) target + tau p */
PETSC_INTERN void PolyakAverage(size_t n, double tau, const Scalar p[], Scalar target[]);
