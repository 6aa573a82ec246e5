/* Laws of permeability: against the differential equation, solved by a method of order 4 in steps of its own, and in
   limits; their table, to which users add. */
#include "unit.h"
#include "faultstart.h"
#include <slipstep/private/slipfault.h>
#include <math.h>

static const SlipPermeabilityLaw *Law(const char name[])
{
  const SlipPermeabilityLaw *law = SlipPermeabilityFind(name);

  assert_non_null(law);
  return law;
}

/* dk/dt = |V|/L (kmax - k) + (k0 - k)/T by the classical Runge-Kutta method in 2000 steps. Its error is
   (a/2000)^4 a/120 of what decays by exp(-a), less than 1e-11 for a <= 10. */
static PetscReal Solved(const SlipPermeability *c, PetscReal x, PetscReal slip, PetscReal h)
{
  const PetscInt steps = 2000;
  const PetscReal dt = h / steps, grow = slip / h / c->slip, heal = c->healing;

  for (PetscInt k = 0; k < steps; k++) {
    PetscReal rate[4], at = x;

    for (int s = 0; s < 4; s++) {
      rate[s] = grow * (c->maximum - at) + heal * (c->start - at);
      at = x + (s < 2 ? 0.5 : 1) * dt * rate[s];
    }
    x += dt / 6 * (rate[0] + 2 * rate[1] + 2 * rate[2] + rate[3]);
  }
  return x;
}

static void slip_and_healing(void **state)
{
  const SlipPermeabilityLaw *law = Law("slip");
  const SlipPermeability c = {.start = 1e-16, .maximum = 3e-13, .slip = 0.02, .healing = 1 / 3e7};
  const PetscReal cases[][3] = {/* k*, slip, h */
                                {1e-16, 1e-3, 1e6}, {1e-13, 1e-12, 2e7}, {3e-13, 0, 6e7},
                                {2e-14, 0.1, 1},    {5e-13, 0.1, 1e8},   {1e-16, 1e-9, 3e-3}};

  assert_int_equal(law->needs, SLIP_PERMEABILITY_BY_SLIP);
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(cases); k++) {
    const PetscReal *a = cases[k], got = SlipPermeabilityEvolve(law, &c, a[0], a[1], a[2]);
    const PetscReal half = SlipPermeabilityEvolve(law, &c, a[0], a[1] / 2, a[2] / 2);

    AssertNear(got, Solved(&c, a[0], a[1], a[2]), 2e-11 * got);
    AssertNear(SlipPermeabilityEvolve(law, &c, half, a[1] / 2, a[2] / 2), got, 2e-15 * got);
    assert_true(SlipPermeabilityValue(law, &c, got, 1e7) == got);
  }
  /* nothing happens without time and slip; a fault that slips far has kmax, one at rest for ages k0, to rounding */
  assert_true(SlipPermeabilityEvolve(law, &c, 2e-14, 0, 0) == 2e-14);
  AssertNear(SlipPermeabilityEvolve(law, &c, 1e-16, 1e20, 1), 3e-13, 1e-15 * 3e-13);
  AssertNear(SlipPermeabilityEvolve(law, &c, 1e-16, 1e300, 1), 3e-13, 1e-15 * 3e-13);
  AssertNear(SlipPermeabilityEvolve(law, &c, 3e-13, 0, 1e300), 1e-16, 1e-15 * 1e-16);
  /* tiny steps add the rate times the step; the change has the rounding of k */
  AssertNear(SlipPermeabilityEvolve(law, &c, 1e-16, 1e-15, 1e-9) - 1e-16, 1e-15 / 0.02 * (3e-13 - 1e-16), 1e-31);
  /* without healing, T = 0: never */
  {
    const SlipPermeability never = {.start = 1e-16, .maximum = 3e-13, .slip = 0.02};

    assert_true(SlipPermeabilityEvolve(law, &never, 2e-14, 0, 1e9) == 2e-14);
  }
}

static void stress(void **state)
{
  const SlipPermeabilityLaw *law = Law("stress"), *valve = Law("valve");
  const SlipPermeability c = {
    .start = 1e-16, .maximum = 3e-13, .slip = 0.02, .healing = 1 / 3e7, .stress = 2e7, .normal = 5e7};

  /* Rice (1992): d ln k/d sigma = -1/sigma*, by central differences whose error is (1e5/2e7)^2/6 of it */
  for (PetscReal s = 0; s < 2e8; s += 1e7) {
    const PetscReal slope =
      log(SlipPermeabilityValue(law, &c, 1e-16, s + 1e5) / SlipPermeabilityValue(law, &c, 1e-16, s - 1e5)) / 2e5;

    AssertNear(slope, -1 / c.stress, 5e-6 / c.stress);
  }
  assert_true(SlipPermeabilityValue(law, &c, 1e-16, c.normal) == 1e-16);
  assert_true(SlipPermeabilityEvolve(law, &c, 7e-15, 1, 1) == c.start); /* slip changes nothing */
  assert_true(SlipPermeabilityValue(valve, &c, 2e-14, 1e7) == SlipPermeabilityValue(law, &c, 2e-14, 1e7));
  assert_true(SlipPermeabilityEvolve(valve, &c, 2e-14, 0.01, 1e6) ==
              SlipPermeabilityEvolve(Law("slip"), &c, 2e-14, 0.01, 1e6));
  assert_true(SlipPermeabilityValue(Law("constant"), &c, 1e-16, 0) == 1e-16);
}

static PetscReal Twice(const SlipPermeability *c, PetscReal x, PetscReal sigma)
{
  return *(const PetscReal *)c->ctx * x;
}

static void own_law(void **state)
{
  static const PetscReal two = 2;
  const SlipPermeabilityLaw law = {.name = "twice", .value = Twice, .ctx = &two}, none = {.name = "none"};
  const SlipPermeability c = {.start = 1e-16, .ctx = &two};
  SlipFault fault;

  ok(SlipFaultCreate(PETSC_COMM_SELF, &fault));
  fails(SlipFaultSetString(fault, "permeability_law", "twice"), "expected one of constant, slip, stress, valve");
  fails(SlipFaultRegisterPermeabilityLaw(&none), "needs a name, and a function");
  ok(SlipFaultRegisterPermeabilityLaw(&law));
  fails(SlipFaultRegisterPermeabilityLaw(&law), "a permeability law twice already");
  ok(SlipFaultSetString(fault, "permeability_law", "twice"));
  assert_true(SlipPermeabilityValue(Law("twice"), &c, SlipPermeabilityEvolve(Law("twice"), &c, 1, 1, 1), 0) == 2e-16);
  ok(SlipFaultDestroy(&fault));
}

SLIP_TESTS(slip_and_healing, stress, own_law)
