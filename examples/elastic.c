static const char help[] =
  "Displacement, stress and traction at points of an elastic half-space by slip on rectangles of any strike and dip, "
  "or on "
  "triangles.\n"
  "  elastic -elastic_input slip.h5 -elastic_output fields.h5 -elastic_receiver 30,60,90\n"
  "The input has /cells [N,7], x y z of the centre, length, width [m], strike and dip [deg], or /vertices [V,3], x y z "
  "[m],\n"
  "and /triangles [N,3], rows of them from 0; /slip [N,3], along strike, up dip and opening [m]; /points [n,3], x y z "
  "[m];\n"
  "x is north, y east, z down. The hanging wall is above, or where /hanging_wall [N,3], vectors into those of "
  "triangles,\n"
  "points to. The output has /displacement [n,3] [m];\n"
  "/stress [n,6], xx yy zz xy xz yz, tension positive [Pa]; and with a receiver /traction [n,3], what its foot wall "
  "does\n"
  "to its hanging wall along the rake, across it, and normal, positive in compression [Pa]. slipstep surface draws "
  "them.\n"
  "Attributes shear_modulus [Pa] and poisson_ratio of the input are its rock, as slipstep convert writes them; options "
  "come first.\n\n";

#include <slipstep.h>
#include <sliph5.h>

enum { SHEAR_MODULUS, POISSON_RATIO, NUM_ROCK };

static const struct {
  const char *attribute, *option, *help, *expected;
  PetscReal usual, above, below;
} Rock[NUM_ROCK] = {
  {"shear_modulus", "-elastic_shear_modulus", "Shear modulus G [Pa]", "a number > 0 Pa", 30e9, 0, PETSC_MAX_REAL},
  {"poisson_ratio", "-elastic_poisson_ratio", "Poisson's ratio", "a number > -1 and < 0.5", 0.25, -1, 0.5}};

typedef struct {
  char input[PETSC_MAX_PATH_LEN], output[PETSC_MAX_PATH_LEN];
  PetscReal rock[NUM_ROCK], receiver[3];
  const char *from[NUM_ROCK]; /* NULL: nobody has said it yet */
  PetscBool full_space, stress, traction;
} Options;

typedef struct {
  PetscInt ncells, n;
  PetscReal *cells;         /* [ncells][7]; NULL of triangles, which have */
  PetscReal *triangles;     /* [ncells][3][3], and perhaps */
  PetscReal *side;          /* [ncells][3] */
  PetscReal *slip, *points; /* [ncells][3], [n][3] */
} Input;

static PetscErrorCode CheckRock(MPI_Comm comm, PetscInt k, PetscReal value, const char name[])
{
  PetscFunctionBeginUser;
  PetscCheck(value > Rock[k].above && value < Rock[k].below, comm, PETSC_ERR_ARG_OUTOFRANGE, "%s is %g, expected %s",
             name, (double)value, Rock[k].expected);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadOptions(Options *o)
{
  PetscInt three = 3;
  PetscBool set;

  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(o, sizeof(*o)));
  PetscCall(SlipDeclareOptions("elastic_", "input output shear_modulus poisson_ratio full_space stress receiver"));
  PetscCall(SlipCheckOptionNames());
  PetscOptionsBegin(PETSC_COMM_WORLD, NULL, "Displacement and stress by slip", NULL);
  PetscCall(PetscOptionsString("-elastic_input", "HDF5 file of rectangles or triangles, their slip, and points", NULL,
                               o->input, o->input, sizeof(o->input), NULL));
  PetscCall(
    PetscOptionsString("-elastic_output", "HDF5 file to write", NULL, o->output, o->output, sizeof(o->output), NULL));
  for (PetscInt k = 0; k < NUM_ROCK; k++) {
    PetscCall(SlipCheckFiniteOption(PETSC_COMM_WORLD, Rock[k].option));
    PetscCall(PetscOptionsReal(Rock[k].option, Rock[k].help, NULL, Rock[k].usual, &o->rock[k], &set));
    o->from[k] = set ? Rock[k].option : NULL;
    if (set) PetscCall(CheckRock(PETSC_COMM_WORLD, k, o->rock[k], Rock[k].option));
  }
  PetscCall(PetscOptionsBool("-elastic_full_space", "Leave out the free surface z = 0", NULL, o->full_space,
                             &o->full_space, NULL));
  PetscCall(PetscOptionsBool("-elastic_stress", "Write the stress", NULL, o->stress, &o->stress, NULL));
  PetscCall(PetscOptionsRealArray("-elastic_receiver", "Strike, dip and rake [deg] of planes whose traction is written",
                                  NULL, o->receiver, &three, &set));
  PetscOptionsEnd();
  o->traction = set;
  PetscCheck(!set || (three == 3 && o->receiver[1] >= 0 && o->receiver[1] <= 90), PETSC_COMM_WORLD,
             PETSC_ERR_ARG_OUTOFRANGE, "-elastic_receiver: expected strike,dip,rake in degrees, the dip in [0, 90]");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Rank 0: corners of the triangles that a file names by rows of its vertices */
static PetscErrorCode ReadTriangles(SlipH5 *h, Input *in)
{
  PetscInt vertices[2], dims[2], want[2] = {-1, 3};
  PetscReal *vertex, *row;
  PetscBool has;

  PetscFunctionBeginUser;
  PetscCall(SlipH5ReadRealSized(h, "/vertices", 2, want, "with the columns x y z", vertices, &vertex));
  PetscCall(SlipH5ReadRealSized(h, "/triangles", 2, want, "three rows of /vertices each", dims, &row));
  in->ncells = dims[0];
  PetscCall(PetscMalloc1(9 * (size_t)in->ncells, &in->triangles));
  for (PetscInt k = 0; k < 3 * in->ncells; k++) {
    PetscCheck(row[k] >= 0 && row[k] < vertices[0] && row[k] == PetscFloorReal(row[k]), PETSC_COMM_SELF,
               PETSC_ERR_FILE_UNEXPECTED,
               "%s: /triangles, row %" PetscInt_FMT
               " has the vertex %g, expected a whole number from 0 to %" PetscInt_FMT,
               h->name, k / 3, (double)row[k], vertices[0] - 1);
    PetscCall(PetscArraycpy(in->triangles + 3 * k, vertex + 3 * (PetscInt)row[k], 3));
  }
  PetscCall(PetscFree(vertex));
  PetscCall(PetscFree(row));
  PetscCall(SlipH5Has(h, "/hanging_wall", &has));
  want[0] = in->ncells;
  if (has)
    PetscCall(SlipH5ReadRealSized(h, "/hanging_wall", 2, want, "a vector for each of the /triangles", dims, &in->side));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Rank 0: what no option has said */
static PetscErrorCode ReadRock(SlipH5 *h, Options *o)
{
  char name[2 * PETSC_MAX_PATH_LEN];
  PetscBool has;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < NUM_ROCK; k++) {
    if (o->from[k]) continue;
    PetscCall(SlipH5HasAttribute(h, "/", Rock[k].attribute, &has));
    o->from[k] = has ? o->input : "by default";
    o->rock[k] = Rock[k].usual;
    if (!has) continue;
    PetscCall(SlipH5ReadAttrReal(h, "/", Rock[k].attribute, &o->rock[k]));
    PetscCall(PetscSNPrintf(name, sizeof(name), "attribute %s of / in %s", Rock[k].attribute, o->input));
    PetscCall(CheckRock(PETSC_COMM_SELF, k, o->rock[k], name));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Rank 0 */
static PetscErrorCode ReadFile(Options *o, Input *in)
{
  PetscInt dims[2], want[2] = {-1, 7};
  PetscBool cells, triangles;
  SlipH5 h;

  PetscFunctionBeginUser;
  PetscCall(SlipH5OpenReadOption(NULL, "elastic_input", o->input, &h));
  PetscCall(SlipH5Has(&h, "/cells", &cells));
  PetscCall(SlipH5Has(&h, "/triangles", &triangles));
  PetscCheck(cells != triangles, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
             "%s has %s, expected /cells of rectangles, or /vertices and /triangles", o->input,
             cells ? "/cells and /triangles" : "neither /cells nor /triangles");
  if (triangles)
    PetscCall(ReadTriangles(&h, in));
  else {
    PetscCall(
      SlipH5ReadRealSized(&h, "/cells", 2, want, "with the columns x y z length width strike dip", dims, &in->cells));
    in->ncells = dims[0];
  }
  want[0] = in->ncells;
  want[1] = 3;
  PetscCall(
    SlipH5ReadRealSized(&h, "/slip", 2, want, "along strike, up dip and opening of each cell", dims, &in->slip));
  want[0] = -1;
  PetscCall(SlipH5ReadRealSized(&h, "/points", 2, want, "with the columns x y z", dims, &in->points));
  in->n = dims[0];
  PetscCall(ReadRock(&h, o));
  PetscCall(SlipH5Close(&h));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Numbers of rank 0, or NULL there, to all */
static PetscErrorCode Broadcast(PetscMPIInt rank, PetscInt n, PetscReal **x)
{
  PetscMPIInt there = *x ? 1 : 0;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Bcast(&there, 1, MPI_INT, 0, PETSC_COMM_WORLD));
  if (!there) PetscFunctionReturn(PETSC_SUCCESS);
  if (rank) PetscCall(PetscMalloc1(n, x));
  PetscCallMPI(MPI_Bcast(*x, (PetscMPIInt)n, MPIU_REAL, 0, PETSC_COMM_WORLD));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Numbers of this process' points, in that of all on rank 0: a dataset of the output */
static PetscErrorCode Write(SlipH5 *h, const char path[], const char units[], PetscInt n, PetscInt size,
                            const PetscReal own[], PetscInt nown)
{
  const PetscInt dims[2] = {n, size};
  PetscMPIInt rank, ranks, count = (PetscMPIInt)(size * nown), *counts, *first;
  PetscReal *all;
  PetscErrorCode ierr = PETSC_SUCCESS;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
  PetscCallMPI(MPI_Comm_size(PETSC_COMM_WORLD, &ranks));
  PetscCall(PetscMalloc3(rank ? 0 : size * n, &all, ranks, &counts, ranks, &first));
  PetscCallMPI(MPI_Gather(&count, 1, MPI_INT, counts, 1, MPI_INT, 0, PETSC_COMM_WORLD));
  first[0] = 0;
  for (PetscMPIInt r = 1; !rank && r < ranks; r++) first[r] = first[r - 1] + counts[r - 1];
  PetscCallMPI(MPI_Gatherv(own, count, MPIU_REAL, all, counts, first, MPIU_REAL, 0, PETSC_COMM_WORLD));
  if (!rank) ierr = SlipH5WriteReal(h, path, 2, dims, all, units);
  PetscCall(SlipErrorBcast(PETSC_COMM_WORLD, ierr));
  PetscCall(PetscFree3(all, counts, first));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Compute(const Options *o, const Input *in, SlipH5 *h)
{
  const SlipDippingRectangle *cells = (const SlipDippingRectangle *)in->cells; /* seven numbers each */
  PetscInt own = PETSC_DECIDE, n = in->n, first = 0;
  const PetscReal *points;
  PetscReal *u, *stress, *traction, directions[9];

  PetscFunctionBeginUser;
  PetscCall(PetscSplitOwnership(PETSC_COMM_WORLD, &own, &n));
  PetscCallMPI(MPI_Exscan(&own, &first, 1, MPIU_INT, MPI_SUM, PETSC_COMM_WORLD));
  points = in->points + 3 * first;
  PetscCall(PetscMalloc3(3 * own, &u, 6 * own, &stress, 3 * own, &traction));
  if (in->triangles)
    PetscCall(SlipTrianglesDisplacement(o->rock[POISSON_RATIO], o->full_space, in->ncells, in->triangles, in->side,
                                        in->slip, own, points, u));
  else
    PetscCall(
      SlipRectanglesDisplacement(o->rock[POISSON_RATIO], o->full_space, in->ncells, cells, in->slip, own, points, u));
  PetscCall(Write(h, "/displacement", "m", n, 3, u, own));
  if (o->stress || o->traction) {
    if (in->triangles)
      PetscCall(SlipTrianglesStress(o->rock[SHEAR_MODULUS], o->rock[POISSON_RATIO], o->full_space, in->ncells,
                                    in->triangles, in->side, in->slip, own, points, stress));
    else
      PetscCall(SlipRectanglesStress(o->rock[SHEAR_MODULUS], o->rock[POISSON_RATIO], o->full_space, in->ncells, cells,
                                     in->slip, own, points, stress));
    PetscCall(Write(h, "/stress", "Pa", n, 6, stress, own));
  }
  if (o->traction) {
    SlipPlaneDirections(o->receiver[0], o->receiver[1], o->receiver[2], directions);
    for (PetscInt k = 0; k < own; k++) SlipStressTraction(1, stress + 6 * k, directions, traction + 3 * k);
    PetscCall(Write(h, "/traction", "Pa", n, 3, traction, own));
  }
  PetscCall(PetscFree3(u, stress, traction));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Run(void)
{
  Options o;
  Input in = {0};
  SlipH5 h;
  PetscErrorCode ierr = PETSC_SUCCESS;
  PetscBool only_help, same;
  PetscMPIInt rank;

  PetscFunctionBeginUser;
  PetscCall(ReadOptions(&o));
  PetscCall(PetscOptionsHasHelp(NULL, &only_help));
  if (only_help) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCheck(o.input[0] && o.output[0], PETSC_COMM_WORLD, PETSC_ERR_ARG_WRONG,
             "expected -elastic_input and -elastic_output, HDF5 files to read and to write");
  PetscCall(PetscStrcmp(o.input, o.output, &same));
  PetscCheck(!same, PETSC_COMM_WORLD, PETSC_ERR_ARG_INCOMP,
             "%s is read and written: expected two files of -elastic_input and -elastic_output", o.input);
  PetscCall(SlipCheckUnusedOptions());
  PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
  if (!rank) {
    ierr = ReadFile(&o, &in);
    if (!ierr) ierr = SlipH5Create(o.output, &h);
  }
  PetscCall(SlipErrorBcast(PETSC_COMM_WORLD, ierr));
  PetscCallMPI(MPI_Bcast(o.rock, NUM_ROCK, MPIU_REAL, 0, PETSC_COMM_WORLD));
  PetscCallMPI(MPI_Bcast(&in.ncells, 1, MPIU_INT, 0, PETSC_COMM_WORLD));
  PetscCallMPI(MPI_Bcast(&in.n, 1, MPIU_INT, 0, PETSC_COMM_WORLD));
  PetscCall(Broadcast(rank, 7 * in.ncells, &in.cells));
  PetscCall(Broadcast(rank, 9 * in.ncells, &in.triangles));
  PetscCall(Broadcast(rank, 3 * in.ncells, &in.side));
  PetscCall(Broadcast(rank, 3 * in.ncells, &in.slip));
  PetscCall(Broadcast(rank, 3 * in.n, &in.points));
  PetscCall(Compute(&o, &in, &h));
  if (!rank) ierr = SlipH5Close(&h);
  PetscCall(SlipErrorBcast(PETSC_COMM_WORLD, ierr));
  PetscCall(PetscPrintf(PETSC_COMM_WORLD, "shear modulus %g Pa (%s), Poisson's ratio %g (%s)\n",
                        (double)o.rock[SHEAR_MODULUS], o.from[SHEAR_MODULUS], (double)o.rock[POISSON_RATIO],
                        o.from[POISSON_RATIO]));
  PetscCall(PetscFree(in.cells));
  PetscCall(PetscFree(in.triangles));
  PetscCall(PetscFree(in.side));
  PetscCall(PetscFree(in.slip));
  PetscCall(PetscFree(in.points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

int main(int argc, char **argv)
{
  PetscFunctionBeginUser;
  PetscCall(SlipProgramInitialize(&argc, &argv, "elastic", help));
  PetscCall(SlipStepInitializePackage());
  PetscCall(Run());
  PetscCall(PetscFinalize());
  return 0;
}
