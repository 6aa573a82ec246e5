// Steps of TSADAMS, as in src/ts/adamssum.c

#define NODES 10
typedef struct {
  double of[4][NODES];
} Weights;

// The derivatives, of which those beyond the last one are it again, with weights of 0: there are no branches
#define RATES                                                                                                                              \
  __global const double *r0, __global const double *r1, __global const double *r2, __global const double *r3, __global const double *r4,   \
    __global const double *r5, __global const double *r6, __global const double *r7, __global const double *r8, __global const double *r9
#define WEIGHTED(w, i)                                                                                                                     \
  ((w)[0] * r0[i] + (w)[1] * r1[i] + (w)[2] * r2[i] + (w)[3] * r3[i] + (w)[4] * r4[i] + (w)[5] * r5[i] + (w)[6] * r6[i] + (w)[7] * r7[i] + \
   (w)[8] * r8[i] + (w)[9] * r9[i])

// y = start + the sum of derivatives times weight 0; the sum of y, which is no number where one of them is none
__kernel void adams(int n, __global const double *start, RATES, Weights weights, __global double *y, __global double *room)
{
  __local double all[ITEMS];
  double mine[1] = {0};

  EACH(i, n) {
    y[i] = start[i] + WEIGHTED(weights.of[0], i);
    mine[0] += y[i];
  }
  fold(1, 1, mine, all, room);
}

// The same with three estimates, the sums by the other weights, over their tolerances: sums of squares, and how many have a tolerance; the
// largest of each
__kernel void adams_norms(int n, __global const double *start, RATES, Weights weights, __global double *y, __global const double *absolute,
                          __global const double *relative, __global double *room)
{
  __local double all[ITEMS];
  double mine[8] = {0, 0, 0, 0, 0, 0, 0, 0};

  EACH(i, n) {
    y[i] = start[i] + WEIGHTED(weights.of[0], i);
    mine[0] += y[i];
    for (int k = 0; k < 3; k++) {
      const double e = WEIGHTED(weights.of[k + 1], i), tolerance = absolute[i] + relative[i] * fmax(fabs(y[i]), fabs(y[i] + e));
      const double share = tolerance > 0 ? fabs(e) / tolerance : 0;

      mine[1 + k] += share * share;
      mine[5 + k] = larger(mine[5 + k], share);
      if (k == 0) mine[4] += tolerance > 0;
    }
  }
  fold(8, 5, mine, all, room);
}
