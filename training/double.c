/* The networks and TQC once more in double precision, under the names of scalar.h, for the golden test. */
#define TRAIN_DOUBLE
#include "dense.c"
#include "gsde.c"
#include "quantile.c"
#include "tqc.c"
#include "tqcupdate.c"
