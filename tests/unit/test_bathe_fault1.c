/* The 3 km fault with one element, constant steps: errors of the final slip of DESIGN.md section 2. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <cmocka.h>
#include "sliders.h"

static const PetscReal G = 30e9, rho = 2500.0, L = 3000.0, sigma = 15e3 * 1500.0, tmax = 30.0;

static PetscReal stiffness(PetscInt i, PetscInt j, PetscInt n)
{
  (void)i;
  (void)j;
  (void)n;
  return G / L;
}

/* Final slip with constant steps */
static PetscErrorCode FinalSlip(TSBatheReaction reaction, PetscInt steps, PetscReal *slip)
{
  Sliders p;
  Vec w;
  PetscReal K = G / L, M = rho * L, zeta = 0.8 / 3.0;

  PetscFunctionBegin;
  PetscCall(SlidersCreate(PETSC_COMM_SELF, 1, stiffness, M, 2.0 * zeta * PetscSqrtReal(M * K), &p));
  p.mud = 0.5;
  p.dmu = 0.1;
  p.dc = 0.1;
  PetscCall(VecSet(p.bound, sigma));
  PetscCall(SlidersCreateState(&p, &w));
  PetscCall(VecSetValue(w, 1, -(1.0 + 1e-5) * 0.6 * sigma / K, INSERT_VALUES));
  PetscCall(VecAssemblyBegin(w));
  PetscCall(VecAssemblyEnd(w));
  PetscCall(SlidersSolve(&p, reaction, tmax, steps, w, NULL));
  PetscCall(VecGetValues(w, 1, (const PetscInt[]){2}, slip));
  PetscCall(VecDestroy(&w));
  PetscCall(SlidersDestroy(&p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reference: classical RK4 of the sliding phase, from rest until the velocity returns to zero, 2e5 steps. The start is an
   instability (initial acceleration 1e-5 of the strength), after which the element sticks for good. */
static PetscReal Reference(void)
{
  const PetscReal K = G / L, M = rho * L, H = 2.0 * 0.8 / 3.0 * PetscSqrtReal(M * K);
  const PetscInt n = 200000;
  PetscReal y[3] = {0.0, -(1.0 + 1e-5) * 0.6 * sigma / K, 0.0}, h = tmax / n;

  for (PetscInt k = 0; k < n; k++) {
    PetscReal d[4][3], z[3];

    for (int s = 0; s < 4; s++) {
      const PetscReal a = s == 0 ? 0.0 : (s == 3 ? h : 0.5 * h);

      for (int i = 0; i < 3; i++) z[i] = y[i] + (s ? a * d[s - 1][i] : 0.0);
      d[s][0] = (-H * z[0] - K * z[1] - sigma * (0.5 + 0.1 * PetscExpReal(-z[2] / 0.1))) / M;
      d[s][1] = d[s][2] = z[0];
    }
    for (int i = 0; i < 3; i++) y[i] += h / 6.0 * (d[0][i] + 2.0 * d[1][i] + 2.0 * d[2][i] + d[3][i]);
    if (y[0] <= 0.0) break;
  }
  return y[2];
}

static void check(TSBatheReaction reaction, PetscInt steps, double percent, double slack)
{
  PetscReal slip, ref = Reference();

  assert_int_equal(FinalSlip(reaction, steps, &slip), 0);
  print_message("%s, %d steps: %.4f %% (reference slip %.6f m)\n", TSBatheReactions[reaction], (int)steps,
                100.0 * PetscAbsReal(slip / ref - 1.0), ref);
  assert_true(PetscAbsReal(100.0 * PetscAbsReal(slip / ref - 1.0) - percent) < slack);
}

/* DESIGN.md prints three or two digits: half a unit of the last one, plus the reference's own (far smaller) error */
static void test_errors_of_final_slip(void **state)
{
  (void)state;
  check(TSBATHE_REACTION_IMPLICIT, 20, 11.3, 0.051);
  check(TSBATHE_REACTION_IMPLICIT, 100, 1.54, 0.0051);
  check(TSBATHE_REACTION_TRAPEZOIDAL, 20, 1.44, 0.0051);
  check(TSBATHE_REACTION_TRAPEZOIDAL, 100, 0.09, 0.0051);
}

int main(int argc, char **argv)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_errors_of_final_slip)};
  int failed;

  if (PetscInitialize(&argc, &argv, NULL, NULL)) return 1;
  if (SlipStepInitializePackage()) return 1;
  failed = cmocka_run_group_tests(tests, NULL, NULL);
  return PetscFinalize() || failed;
}
