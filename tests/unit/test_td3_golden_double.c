/* The golden test of TD3 in double precision, with the sources of the learner compiled for it. */
#define TRAIN_DOUBLE
#include "study/densenetwork.c"
#include "study/td3.c"
#include "test_td3_golden.c"
