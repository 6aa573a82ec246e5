/* The scalar type of the trainer: float, or double when TRAIN_DOUBLE is defined before inclusion. The same sources
   are compiled for both (double.c), the double versions under other names, so that the golden test can compare to
   1e-9. */
#pragma once
#include <petscsys.h>
#include "common/rowblas.h"
#include <math.h>

#if defined(TRAIN_DOUBLE)
typedef double Scalar;
  #define SCALAR_EPSILON 2.220446049250313e-16 /* 2^-52 */
  #define ScalarGemm cblas_dgemm
  #define ScalarGemv cblas_dgemv
  #define ScalarExp exp
  #define ScalarLog log
  #define ScalarTanh tanh
  #define ScalarSqrt sqrt
  #define DenseShapeInit DenseShapeInit_Double
  #define DenseInitialize DenseInitialize_Double
  #define DenseWorkCreate DenseWorkCreate_Double
  #define DenseWorkDestroy DenseWorkDestroy_Double
  #define DenseForward DenseForward_Double
  #define DenseBackward DenseBackward_Double
  #define DenseInputGradient DenseInputGradient_Double
  #define AdamCreate AdamCreate_Double
  #define AdamDestroy AdamDestroy_Double
  #define AdamStep AdamStep_Double
  #define PolyakAverage PolyakAverage_Double
  #define GSDESample GSDESample_Double
  #define QuantileTargets QuantileTargets_Double
  #define QuantileHuber QuantileHuber_Double
  #define GaussSample GaussSample_Double
  #define GaussGradients GaussGradients_Double
  #define HeadBackward HeadBackward_Double
  #define LearnerShape LearnerShape_Double
  #define LearnerCheckOptions LearnerCheckOptions_Double
  #define TQCNoiseCount TQCNoiseCount_Double
  #define TD3Create TD3Create_Double
  #define TD3Destroy TD3Destroy_Double
  #define TD3Update TD3Update_Double
  #define TQCCreate TQCCreate_Double
  #define TQCDestroy TQCDestroy_Double
  #define TQCUpdate TQCUpdate_Double
#else
typedef float Scalar;
  #define SCALAR_EPSILON 1.1920928955078125e-07f /* 2^-23 */
  #define ScalarGemm cblas_sgemm
  #define ScalarGemv cblas_sgemv
  #define ScalarExp expf
  #define ScalarLog logf
  #define ScalarTanh tanhf
  #define ScalarSqrt sqrtf
#endif

/* The loops over a batch are compiled for three instruction sets and chosen when the program starts. */
#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__) && !defined(__SANITIZE_ADDRESS__) && __GNUC__ >= 12
  #define TRAIN_CLONES __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
  #define TRAIN_CLONES
#endif
