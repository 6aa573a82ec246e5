/* TD3 once more in double precision, see double.c: a file of its own, for its functions have names that TQC uses. */
#define TRAIN_DOUBLE
#include "td3.c"
