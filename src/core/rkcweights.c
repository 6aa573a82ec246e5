/* Coefficients of the stabilised formulas of Runge, Kutta and Chebyshev of second order: B. P. Sommeijer, L. F.
   Shampine, J. G. Verwer, RKC: an explicit solver for parabolic PDEs, J. Comput. Appl. Math. 88 (1998). */
#include <slipcompat.h>
#include <slipstep/rooms/slipcore.h>

/* Damping of all but the slowest modes, from the paper */
#define DAMPING (2.0 / 13.0)
/* Stages squared over h rho for which a step is stable, as stability ends at 0.65 (s^2 - 1); from the paper */
#define STAGES_SQUARED 1.54

/* Chebyshev polynomial of the first kind of degree j at x with two derivatives, computed from the previous degrees */
typedef struct {
  PetscReal T, d, dd;
} Chebyshev;

static Chebyshev Next(PetscReal x, const Chebyshev *one, const Chebyshev *two)
{
  return (Chebyshev){2 * x * one->T - two->T, 2 * one->T + 2 * x * one->d - two->d,
                     4 * one->d + 2 * x * one->dd - two->dd};
}

/* Number of stages, at least 2, with which a step h is stable if modes relax at rates up to rho; hrho = h rho */
PetscReal SlipRKCStages(PetscReal hrho)
{
  return PetscMax(2, 1 + PetscFloorReal(PetscSqrtReal(STAGES_SQUARED * hrho + 1)));
}

/* The largest stable h rho of this number of stages */
PetscReal SlipRKCLongest(PetscInt stages)
{
  return (PetscSqr((PetscReal)stages) - 1) / STAGES_SQUARED * (1 - 1e-12);
}

/*
  SlipRKCCoefficients - computes c[j] of the stages j = 1 ... s, at most SLIP_RKC_MOST:

  Y_1 = y + c[1].rate h F_0; Y_j = (1 - one - two) y + one Y_j-1 + two Y_j-2 + rate h F(Y_j-1) + start h F_0, at the
  time t + share h; Y_s is the step's end. */
void SlipRKCCoefficients(PetscInt s, SlipRKCStage c[])
{
  const PetscReal w0 = 1 + DAMPING / ((PetscReal)s * (PetscReal)s);
  Chebyshev p[SLIP_RKC_MOST + 1] = {{1, 0, 0}, {w0, 1, 0}};
  PetscReal b[SLIP_RKC_MOST + 1] = {0}, w1;

  for (PetscInt j = 2; j <= s; j++) {
    p[j] = Next(w0, &p[j - 1], &p[j - 2]);
    b[j] = p[j].dd / PetscSqr(p[j].d);
  }
  b[0] = b[1] = b[2];
  w1 = p[s].d / p[s].dd;
  for (PetscInt j = 2; j <= s; j++) {
    c[j].one = 2 * b[j] * w0 / b[j - 1];
    c[j].two = -b[j] / b[j - 2];
    c[j].rate = 2 * b[j] * w1 / b[j - 1];
    c[j].start = -(1 - b[j - 1] * p[j - 1].T) * c[j].rate;
    c[j].share = w1 * p[j].dd / p[j].d;
  }
  c[1] = (SlipRKCStage){.rate = b[1] * w1, .share = c[2].share / p[2].d};
  c[s].share = 1;
}
