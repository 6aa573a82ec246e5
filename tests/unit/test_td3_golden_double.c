/* The golden test of TD3 in double precision. */
#define TRAIN_DOUBLE
#include "test_td3_golden.c"
