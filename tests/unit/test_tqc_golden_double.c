/* The golden test in double precision, with the sources of the learner compiled for it. */
#define TRAIN_DOUBLE
#include "study/densenetwork.c"
#include "study/quantile.c"
#include "study/tqc.c"
#include "test_tqc_golden.c"
