/* The golden test in double precision. */
#define TRAIN_DOUBLE
#include "test_tqc_golden.c"
