/* The scalar type of the trainer: float, or double when TRAIN_DOUBLE is defined before inclusion. The golden tests
   compile the same sources for double, so that they can compare to 1e-9. */
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
