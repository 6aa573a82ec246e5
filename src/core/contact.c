/* Contact of the two sides of a cell: its third number y is the opening, G_n = omega r_n, and

     y >= 0,  r_n >= 0,  y r_n = 0.

   With z = y - rho G_n it is equivalent to the natural map y = max(0, z): this is Signorini's condition, which Alart
   and Curnier (1991), CMAME 92, solve together with the friction disk |r_t| <= mu r_n. Cells have blocks of three
   numbers, two in the plane (cone.c) and y.

   Where z <= 0 a cell is closed: F = y / rho, its row is an identity, and friction uses the pressure -z / rho = G_n -
   y / rho, which changes by dG_n + y / rho in the step dy = -y of a closed cell. Elsewhere it is open: F = G_n. */
#include <slipcompat.h>
#include <slipstep/rooms/slipcore.h>

enum { BLOCK = 3, NORMAL = 2 };

/* r_n of each cell, 0 where it is open; NaN is passed on */
void SlipContactPressure(PetscInt n, PetscReal omega, const PetscReal x[], const PetscReal g[], const PetscReal rho[],
                         PetscReal p[])
{
  for (PetscInt i = 0, k = NORMAL; i < n; i++, k += BLOCK) {
    const PetscReal z = x[k] - rho[k] * g[k];

    p[i] = z > 0 ? 0 : -z / (rho[k] * omega);
  }
}

/* F and mask of the normal rows: 1 where open */
void SlipContactNatural(PetscInt n, const PetscReal x[], const PetscReal g[], const PetscReal rho[], PetscReal F[],
                        PetscReal mask[])
{
  for (PetscInt i = 0, k = NORMAL; i < n; i++, k += BLOCK) {
    mask[k] = x[k] - rho[k] * g[k] <= 0 ? 0 : 1; /* NaN counts as open, so that F becomes NaN */
    F[k] = mask[k] == 0 ? x[k] / rho[k] : g[k];
  }
}

/* Makes closed cells exactly closed, with the pressure that friction used, and open cells free of reaction. */
void SlipContactFinish(PetscInt n, PetscReal omega, const PetscReal g[], const PetscReal rho[], PetscReal x[],
                       PetscReal r[])
{
  for (PetscInt i = 0, k = NORMAL; i < n; i++, k += BLOCK) {
    const PetscReal z = x[k] - rho[k] * g[k];

    r[k] = z > 0 ? 0 : -z / (rho[k] * omega);
    x[k] = z > 0 ? PetscMax(x[k], 0) : 0;
  }
}

/* One step of the fixed point */
void SlipContactProject(PetscInt n, const PetscReal x[], const PetscReal g[], const PetscReal rho[], PetscReal x1[])
{
  for (PetscInt i = 0, k = NORMAL; i < n; i++, k += BLOCK) x1[k] = PetscMax(x[k] - rho[k] * g[k], 0);
}
