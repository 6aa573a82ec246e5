/* Kernels of slip as a vector in each cell's plane: against fields, against those of slip along rakes, by reciprocity
   and in turned axes. */
#include "vectorcells.h"
#include "operators.h"

/* Rectangles in runs of one source, of one receiver, and of neither; with directions given and not */
static void pairs_at_once(void **state)
{
  enum { pairs = 53 };
  SlipCells vectors[2], scalars[2];
  SlipCell receiver[pairs], source[pairs];
  PetscReal directions[9 * pairs];

  Meshes(vectors, scalars);
  for (int p = 0; p < pairs; p++) {
    receiver[p] = CellOf(&scalars[0], p < 20 ? 3 : 7 * p % vectors[0].n);
    source[p] = CellOf(&scalars[0], p < 20 ? 3 * p : p < 40 ? 11 : 13 * p % vectors[0].n);
    if (p % 3) continue;
    SlipPlaneDirections(source[p].rectangle.strike, source[p].rectangle.dip, 0, directions + 9 * p);
    source[p].directions = directions + 9 * p;
  }
  AssertPairsAtOnce(&vectors[0].kernel, pairs, receiver, source);
}

/* Of the operators of a mesh */
static PetscReal DifferenceOfMesh(const SlipCells *vectors, const SlipCells *scalars)
{
  PetscReal difference;
  Mat S[2], Kn[2];

  ok(MatCreateSlipCellVectorStiffness(PETSC_COMM_SELF, vectors, "dense", 1e-6, &S[0], &Kn[0]));
  ok(MatCreateSlipCellStiffness(PETSC_COMM_SELF, scalars, "dense", 1e-6, &S[1]));
  ok(MatCreateSlipCellNormalStiffness(PETSC_COMM_SELF, scalars, "dense", 1e-6, &Kn[1]));
  difference = ProjectedDifference(S, Kn, scalars->rake);
  ObjectsDestroy(&S[0], &S[1], &Kn[0], &Kn[1]);
  return difference;
}

/* Slip along rakes, each cell its own, is what the vectors' operators are there: of rectangles and triangles, with
   averages and their edges, which some cells share and some do not. One formula, linear in both directions:
   rounding. */
static void projections_are_scalar(void **state)
{
  SlipCells vectors[2], scalars[2];

  Meshes(vectors, scalars);
  for (int space = 0; space < 2; space++)
    for (int k = 0; k < 3; k++) {
      SlipCells v = vectors[k > 0], s = scalars[k > 0];

      v.kernel.full_space = s.kernel.full_space = (PetscBool)space;
      v.kernel.average = s.kernel.average = k == 2 ? SLIP_AVERAGE_CELL : SLIP_AVERAGE_CENTRE;
      assert_true(DifferenceOfMesh(&v, &s) < 1e-12);
    }
}

/* Vertical cells, and overturned ones with the hanging wall below */
static void projections_at_any_dip(void **state)
{
  SlipCells vectors[2], scalars[2];

  Meshes(vectors, scalars);
  for (PetscInt e = 0; e < N; e++) {
    PetscReal *data = rectangle_data;

    data[N + e] = e < N / 2 ? 0 : 500;
    data[2 * N + e] = 80 * (e / NX % NZ + 0.5);
    data[6 * N + e] = 90;
  }
  assert_true(DifferenceOfMesh(&vectors[0], &scalars[0]) < 1e-12);
  scalars[1] = TrianglesOf(&scalars[0], triangle_data);
  assert_true(DifferenceOfMesh(&vectors[1], &scalars[1]) < 1e-12);
  Meshes(vectors, scalars);
  for (PetscInt e = 0; e < T; e++) {
    if (triangle_data[6 * T + e] > 50) continue;
    triangle_data[5 * T + e] = 180;
    triangle_data[6 * T + e] = 180 - triangle_data[6 * T + e];
  }
  assert_true(DifferenceOfMesh(&vectors[1], &scalars[1]) < 1e-12);
}

/* u' S u of slip [n] in space that lies in the plane of the cells */
static PetscReal Energy(const SlipCells *c, PetscReal slip[][3])
{
  PetscReal energy;
  Vec u, f;
  Mat S;

  ok(MatCreateSlipCellVectorStiffness(PETSC_COMM_SELF, c, "dense", 1e-6, &S, NULL));
  ok(MatCreateVecs(S, &u, &f));
  for (PetscInt e = 0; e < c->n; e++) {
    PetscReal d[9];

    SlipPlaneDirections(c->strike[e], c->dip[e], 0, d);
    for (int k = 0; k < 2; k++)
      ok(VecSetValue(u, 2 * e + k, d[3 * k] * slip[e][0] + d[3 * k + 1] * slip[e][1] + d[3 * k + 2] * slip[e][2],
                     INSERT_VALUES));
  }
  ok(MatMult(S, u, f));
  ok(VecDot(u, f, &energy));
  ObjectsDestroy(&u, &f, &S);
  return energy;
}

/* Triangles of one horizontal plane in a full space: their axes may be turned in the plane, from cell to cell too, and
   the plane with all on it to any other, vertical ones with either side as the hanging wall. The energy of the same
   slip in space stays, at centres and with averages: 1e-11 as coordinates round. */
static void energy_knows_no_axes(void **state)
{
  const PetscReal turned[4][3] = {
    {0, 0, 0}, {25, 90, 0}, {25, 90, 180}, {310, 40, 0}}; /* strike, dip, to the other side */
  SlipCells vectors[2], scalars[2], *c = &vectors[1];
  static PetscReal slip[T][3], in_plane[T][2];

  Meshes(vectors, scalars);
  for (PetscInt e = 0; e < N; e++) {
    const PetscReal flat[3] = {100.0 * (e % NX), 80.0 * (e / NX), 3000};

    for (int k = 0; k < 3; k++) rectangle_data[k * N + e] = flat[k];
    rectangle_data[5 * N + e] = rectangle_data[6 * N + e] = 0;
  }
  for (PetscInt e = 0; e < T; e++)
    for (int k = 0; k < 2; k++) in_plane[e][k] = Random(-1, 1);
  for (int average = 0; average < 2; average++) {
    PetscReal energy = 0;

    for (int t = 0; t < 4; t++) {
      PetscReal d[9];

      scalars[1] = TrianglesOf(&scalars[0], triangle_data);
      c->kernel.full_space = PETSC_TRUE;
      c->kernel.average = average ? SLIP_AVERAGE_CELL : SLIP_AVERAGE_CENTRE;
      SlipPlaneDirections(turned[t][0], turned[t][1], 0, d);
      /* north and west of the horizontal plane become strike and up dip */
      for (PetscInt e = 0; e < T; e++) {
        for (int k = 0; k < 3; k++) slip[e][k] = in_plane[e][0] * d[k] + in_plane[e][1] * d[3 + k];
        for (int v = 0; v < 4; v++) {
          PetscReal *p = v < 3 ? triangle_data + 8 * T + 9 * e + 3 * v : NULL;
          const PetscReal x = p ? p[0] : triangle_data[e], y = p ? -p[1] : -triangle_data[T + e];

          for (int k = 0; k < 3; k++) {
            const PetscReal at = x * d[k] + y * d[3 + k] + (k == 2 ? 3000 : 0);

            if (p)
              p[k] = at;
            else
              triangle_data[k * T + e] = at;
          }
        }
        triangle_data[5 * T + e] = turned[t][0] + turned[t][2];
        triangle_data[6 * T + e] = turned[t][1];
      }
      if (t == 0) energy = Energy(c, slip);
      AssertNear(Energy(c, slip), energy, 1e-11 * energy);
      if (turned[t][1] > 0) continue;
      for (PetscInt e = 0; e < T; e++) triangle_data[5 * T + e] = 30 + (PetscReal)(e % 50);
      AssertNear(Energy(c, slip), energy, 1e-11 * energy);
    }
    assert_true(energy > 0);
  }
}

SLIP_TESTS(pairs_at_once, projections_are_scalar, projections_at_any_dip, energy_knows_no_axes)
