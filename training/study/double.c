/* The networks and the learners once more in double precision, under the names of scalar.h, for the golden test. */
#define TRAIN_DOUBLE
#include "densenetwork.c"
#include "exploration.c"
#include "learner.c"
#include "quantile.c"
#include "tqc.c"
#include "tqcupdate.c"
