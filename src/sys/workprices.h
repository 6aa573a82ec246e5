/* Made by tests/benchmarks/cost.py --calibrate. */
static const double WorkPrices[SLIP_WORKS] = {
  [SLIP_WORK_RUN] = 0.14,
};
