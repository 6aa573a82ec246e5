/* Pairs of triangles in lanes against the functions for one pair: at random, and at positions that need care. */
#include "triangles.h"
#include <slipstep/private/slipelasticity.h>

static const SlipKernelType *const Types[] = {&SlipKernelTriangle, &SlipKernelTriangleVector,
                                              &SlipKernelTriangleOpening};

/* Computes the blocks of a row of normal stress, or of shear components, by lanes and one by one. Rounding of
   coordinates is multiplied by the square of the distance over the size, and beside an edge by the inverse of that, in
   both functions: their difference is to be compared with the block that a source of that size has on itself. */
static void Blocks(const SlipKernel *kernel, PetscBool normal, const SlipCell receiver[], const SlipCell source[],
                   PetscReal lanes[], PetscReal near[], PetscReal singly[], PetscReal *own)
{
  const SlipKernelLanes *l = SlipKernelGetLanes(kernel);
  const PetscInt c = kernel->type->components, rows = normal ? 1 : c;
  PetscReal *numbers[2], *one, block[SLIP_KERNEL_BLOCK];

  ok(PetscMalloc3(l->numbers * SLIP_PAIRS, &numbers[0], l->numbers * SLIP_PAIRS, &numbers[1], l->numbers, &one));
  *own = 0;
  for (PetscInt k = 0; k < SLIP_PAIRS; k++) {
    for (int side = 0; side < 2; side++) {
      (*l->cell)(kernel, side ? &source[k] : &receiver[k], one);
      for (PetscInt i = 0; i < l->numbers; i++) numbers[side][i * SLIP_PAIRS + k] = one[i];
    }
    SlipKernelBlock(kernel, &receiver[k], &source[k], block);
    for (PetscInt i = 0; i < rows * c; i++) singly[i * SLIP_PAIRS + k] = block[i + (normal ? c * c : 0)];
    SlipKernelBlock(kernel, &source[k], &source[k], block);
    *own = PetscMax(*own, PetscAbsReal(block[0]));
  }
  (*l->blocks)(kernel, normal, numbers[0], numbers[1], lanes, near);
  ok(PetscFree3(numbers[0], numbers[1], one));
}

/* Compares all kernels and media, to a share of the source's block on itself; edges: lanes with a receiver on one. */
static void Compare(PetscReal v[2 * SLIP_PAIRS][3][3], PetscReal share, const PetscBool edges[])
{
  PetscReal directions[2 * SLIP_PAIRS][9];
  SlipCell cell[2 * SLIP_PAIRS];

  for (int k = 0; k < 2 * SLIP_PAIRS; k++) {
    PetscReal angles[2];

    ok(SlipTriangleDirections(v[k][0], NULL, angles, NULL));
    SlipPlaneDirections(angles[0], angles[1], Random(0, 360), directions[k]);
    cell[k] = (SlipCell){.vertices = v[k][0], .directions = directions[k]};
  }
  for (size_t t = 0; t < PETSC_STATIC_ARRAY_LENGTH(Types); t++)
    for (int space = 0; space < 2; space++)
      for (int normal = 0; normal <= Types[t]->normals; normal++) {
        const SlipKernel kernel = {
          .type = Types[t], .shear_modulus = 30e9, .poisson_ratio = 0.2, .full_space = (PetscBool)space};
        const PetscInt size = Types[t]->components * (normal ? 1 : Types[t]->components);
        PetscReal lanes[SLIP_KERNEL_BLOCK * SLIP_PAIRS], singly[SLIP_KERNEL_BLOCK * SLIP_PAIRS], near[SLIP_PAIRS], own;

        Blocks(&kernel, (PetscBool)normal, cell, cell + SLIP_PAIRS, lanes, near, singly, &own);
        for (int k = 0; k < SLIP_PAIRS; k++) {
          assert_int_equal(near[k] != 0, edges && edges[k]);
          for (PetscInt i = 0; i < size && near[k] == 0; i++)
            AssertNear(lanes[i * SLIP_PAIRS + k], singly[i * SLIP_PAIRS + k], share * own);
        }
      }
}

/* Moves the middle of a triangle. */
static void MoveTo(PetscReal v[3][3], const PetscReal to[3])
{
  for (int i = 0; i < 3; i++) {
    const PetscReal by = to[i] - (v[0][i] + v[1][i] + v[2][i]) / 3;

    for (int k = 0; k < 3; k++) v[k][i] += by;
  }
}

/* Of sides of 1 to 2, some units apart, in the ground. The block on itself, which is about the shear modulus over the
   size, is larger than any other one unless the receiver is next to an edge. */
static void random_pairs(void **state)
{
  for (int trial = 0; trial < 300; trial++) {
    PetscReal v[2 * SLIP_PAIRS][3][3];

    for (int k = 0; k < 2 * SLIP_PAIRS; k++) do
        AnyTriangle(Random(1, 90), v[k]);
      while (Flat(v[k]));
    Compare(v, 1e-12, NULL);
  }
}

/* Triangles of a plane, which touch or are apart; a source as its own receiver; on the ground */
static void same_plane(void **state)
{
  for (int trial = 0; trial < 60; trial++) {
    const PetscReal dip = trial % 3 == 0 ? 90 : trial % 3 == 1 ? 30 : Random(5, 85), strike = trial % 2 ? 0 : 33;
    const PetscReal size = trial % 2 ? 1 : 0.7; /* without rounding and with it */
    PetscReal v[2 * SLIP_PAIRS][3][3], d[9];

    SlipPlaneDirections(strike, dip, 0, d);
    for (int k = 0; k < 2 * SLIP_PAIRS; k++) { /* lower and upper halves of squares in a row; the source is the first */
      static const int corner[2][3][2] = {{{0, 0}, {1, 0}, {0, 1}}, {{1, 0}, {1, 1}, {0, 1}}};
      const int place = k < SLIP_PAIRS ? k : 0;

      for (int j = 0; j < 3; j++)
        for (int i = 0; i < 3; i++)
          v[k][j][i] = 3 * (i == 1) + size * (place / 2 + corner[place % 2][j][0]) * d[i] -
                       (corner[place % 2][j][1] + 0.5 * (trial % 4)) * d[3 + i];
    }
    for (int k = 0; k < 2 * SLIP_PAIRS; k++)
      for (int j = 0; j < 3; j++) v[k][j][2] = PetscMax(v[k][j][2], 0);
    Compare(v, 1e-12, NULL);
  }
}

/* Centroids on edges, which lanes leave to the function for one pair, and on their lines; across the plane from an edge
   and from a vertex, above and below a vertex, and in the plane beside one. Then 1e-3 beside these, where the block is
   up to 1e3 times the source's own and rounding of coordinates, 1e-15, changes it by 1e-12 of that. */
static void special_positions(void **state)
{
  for (int trial = 0; trial < 200; trial++) {
    const PetscReal off = trial % 2 ? 0 : 1e-3, t = Random(0.2, 1) * (trial % 3 ? 1 : -1);
    PetscReal v[2 * SLIP_PAIRS][3][3];
    PetscBool edges[SLIP_PAIRS];

    for (int k = 0; k < SLIP_PAIRS; k++) {
      PetscReal(*s)[3] = v[SLIP_PAIRS + k], at[3], d[9];

      AnyTriangle(Random(1, 90), v[k]);
      do {
        AnyTriangle(trial % 5 ? Random(1, 89) : 90, s);
        if (trial % 7 == 1) s[1][2] = s[0][2];
      } while (Flat(s));
      ok(SlipTriangleDirections(s[0], NULL, NULL, d));
      for (int i = 0; i < 3; i++) {
        const PetscReal along = s[1][i] - s[0][i];
        const PetscReal place[SLIP_PAIRS] = {s[0][i] + 0.5 * along,
                                             s[0][i] + (t > 0 ? 1 + t : t) * along,
                                             s[0][i] + 0.5 * along + t * d[6 + i],
                                             s[2][i] + t * d[6 + i],
                                             s[2][i] + t * (i == 2),
                                             s[2][i] + t * (2 * s[2][i] - s[0][i] - s[1][i]),
                                             s[1][i] - 0.1 * along,
                                             s[2][i] + PetscAbsReal(t) * (s[2][i] - s[0][i])};

        at[i] = place[k] + off * (0.8 * d[3 + i] + 0.6 * d[6 + i]);
      }
      MoveTo(v[k], at);
      for (int j = 0; j < 3; j++) v[k][j][2] += 5; /* below the ground */
      for (int j = 0; j < 3; j++) s[j][2] += 5;
      edges[k] = (PetscBool)(off == 0 && (k == 0 || k == 6));
    }
    Compare(v, off > 0 ? 1e-9 : 1e-11, edges);
  }
}

/* Beside the horizontal and the vertical: edges of the image within 1e-12 to 1e-2 of them, where the choice of their
   direction changes, and of a plunge of 30 degrees, where it may not be made */
static void edges_of_the_image(void **state)
{
  static const PetscReal steps[SLIP_PAIRS] = {0, 1e-15, -1e-12, 1e-9, -1e-6, 1e-3, -1e-2, 0.1};

  for (int trial = 0; trial < 100; trial++) {
    PetscReal v[2 * SLIP_PAIRS][3][3];

    for (int k = 0; k < SLIP_PAIRS; k++) {
      PetscReal(*s)[3] = v[SLIP_PAIRS + k];

      do {
        AnyTriangle(Random(1, 90), v[k]);
        AnyTriangle(Random(1, 90), s);
        if (trial % 3 == 0) s[1][2] = s[0][2] + steps[k];
        if (trial % 3 == 1) s[1][0] = s[0][0] + steps[k], s[1][1] = s[0][1];
        if (trial % 3 == 2) /* the sine of the plunge is 1/2 to rounding */
          s[1][0] = s[0][0] + 0.9 * PetscSqrtReal(3), s[1][1] = s[0][1], s[1][2] = s[0][2] + 0.9 * (1 + steps[k]);
      } while (Flat(v[k]) || Flat(s));
      if (trial % 2) { /* on the extension of the edge, seen from above: an image's is there at no depth */
        const PetscReal to[3] = {s[0][0] + 3 * (s[1][0] - s[0][0]), s[0][1] + 3 * (s[1][1] - s[0][1]), 0.5};

        MoveTo(v[k], to);
        for (int j = 0; j < 3; j++) v[k][j][2] = PetscMax(v[k][j][2], 0);
      }
    }
    Compare(v, 1e-11, NULL);
  }
}

SLIP_TESTS(random_pairs, same_plane, special_positions, edges_of_the_image)
