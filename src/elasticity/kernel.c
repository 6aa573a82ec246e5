/*
  Kernels, what the entries of a stiffness are computed from: vertical strike-slip rectangles, those of any direction, and
  triangles, the closed forms of the files beside this one as rows of functions.
*/
#include <slipcompat.h>
#include <slipstep/private/sliptriangle.h>
#include <slipstep/private/slipelasticity.h>
#include <math.h>

/*@
  SlipKernelCheck - refuse a kernel that no stiffness can be computed from

  Not collective, but every process of comm must pass the same kernel

  Input Parameters:
+ comm   - communicator of the error messages
- kernel - the kernel

  Errors: PETSC_ERR_ARG_NULL without a type, PETSC_ERR_ARG_OUTOFRANGE for elastic constants out of range, PETSC_ERR_SUP
  for more than one component of slip or row of normal stress, and averages that the type does not know

  Level: developer

.seealso: SlipKernelBlock(), MatCreateSlipStiffness(), MatCreateSlipCellStiffness()
@*/
PetscErrorCode SlipKernelCheck(MPI_Comm comm, const SlipKernel *k)
{
  PetscFunctionBegin;
  PetscCheck(k->type && k->type->centre, comm, PETSC_ERR_ARG_NULL,
             "A kernel needs a type with a function for the centre, such as SlipKernelStrikeSlip");
  PetscCheck(k->shear_modulus > 0 && PetscIsNormalReal(k->shear_modulus), comm, PETSC_ERR_ARG_OUTOFRANGE,
             "Shear modulus must be positive and finite, not %g Pa", (double)k->shear_modulus);
  PetscCheck(k->poisson_ratio > -1 && k->poisson_ratio < 0.5, comm, PETSC_ERR_ARG_OUTOFRANGE,
             "Poisson's ratio must lie in (-1, 0.5), not %g", (double)k->poisson_ratio);
  PetscCheck(k->type->components == 1 && k->type->normals >= 0 && k->type->normals <= 1, comm, PETSC_ERR_SUP,
             "Kernel \"%s\" has %" PetscInt_FMT " components of slip and %" PetscInt_FMT
             " rows of normal stress, expected 1 and at most 1",
             k->type->name, k->type->components, k->type->normals);
  PetscCheck(k->average == SLIP_AVERAGE_CENTRE || k->type->average, comm, PETSC_ERR_SUP,
             "Kernel \"%s\" knows no average over a cell, expected SLIP_AVERAGE_CENTRE", k->type->name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void Centre_StrikeSlip(const SlipKernel *k, const SlipCell *receiver, const SlipCell *source, PetscReal block[])
{
  const SlipDippingRectangle *r = &receiver->rectangle, *s = &source->rectangle;

  block[0] = SlipKernelOffset(k->shear_modulus, k->poisson_ratio, r->x - s->x, r->y - s->y, r->z, s->z, s->length,
                              s->width, k->full_space);
}

/* An edge that both have has the mean core. */
static void Average_StrikeSlip(const SlipKernel *k, const SlipCell *receiver, const SlipCell *source, PetscReal block[])
{
  const SlipDippingRectangle *a = &receiver->rectangle, *b = &source->rectangle;
  const SlipRectangle r = {a->x, a->y, a->z, a->length, a->width}, s = {b->x, b->y, b->z, b->length, b->width};
  const PetscReal share = SlipAverageCore(k->average);
  const PetscReal core[2] = {share * PetscSqrtReal(r.length * s.length), share * PetscSqrtReal(r.width * s.width)};

  block[0] = SlipKernelAverage(k->shear_modulus, k->poisson_ratio, &r, &s, core, k->full_space);
}

/* Averages have that form as they are; of the values at centres c + z l + z^2 q (dislocation.c) the symmetric part has,
   as (z + z')/2 l and (z^2 + z'^2)/2 q are s/2 l and s^2/2 q - z z' q, s = z + z'. */
static void Surface_StrikeSlip(const SlipKernel *k, PetscReal dx, PetscReal s, PetscReal a, PetscReal b,
                               PetscReal part[2])
{
  PetscReal centre[3];

  if (k->average) {
    SlipAverageSurface_Private(k->shear_modulus, k->poisson_ratio, SlipAverageCore(k->average), dx, s, a, b, part);
    return;
  }
  SlipKernelSurface_Private(k->shear_modulus, k->poisson_ratio, dx, s, a, b, centre);
  part[0] = centre[0] + s * (0.5 * centre[1] + 0.5 * s * centre[2]);
  part[1] = centre[2];
}

const SlipKernelType SlipKernelStrikeSlip = {
  .name = "strike_slip",
  .components = 1,
  .symmetry = {SLIP_EVEN_STRIKE, SLIP_EVEN_STRIKE | SLIP_EVEN_DEPTH},
  .centre = Centre_StrikeSlip,
  .average = Average_StrikeSlip,
  .surface = Surface_StrikeSlip,
  .edge = SlipAverageEdge_Private,
};

/* Cells were checked when they were taken: what is refused here has no meaning, and is not a number. */
static void Centre_Dipping(const SlipKernel *k, const SlipCell *receiver, const SlipCell *source, PetscReal block[])
{
  const SlipDippingRectangle *r = &receiver->rectangle;
  const PetscReal centre[3] = {r->x, r->y, r->z};
  PetscReal slip[3] = {0, 0, 0}, stress[6], directions[9], traction[3];

  SlipDegrees(source->rake, &slip[1], &slip[0]);
  SlipPlaneDirections(r->strike, r->dip, receiver->rake, directions);
  if (SlipDippingStress(k->shear_modulus, k->poisson_ratio, k->full_space, &source->rectangle, slip, 1, centre, stress))
    stress[0] = stress[3] = stress[4] = (PetscReal)NAN;
  SlipStressTraction(1, stress, directions, traction);
  block[0] = traction[0];
  block[1] = traction[2];
}

/* Many points of one source, 0.45 us each where Centre_Dipping() takes 1.1 us, measured */
static PetscErrorCode Plane_Dipping(const SlipKernel *k, const SlipDippingRectangle *source, PetscInt component,
                                    PetscInt n, const PetscReal points[], PetscReal traction[])
{
  const PetscReal slip[3] = {component == 0, component == 1, 0};
  PetscReal stress[6 * SLIP_LANES], directions[9];

  PetscFunctionBegin;
  SlipPlaneDirections(source->strike, source->dip, 0, directions);
  for (PetscInt first = 0; first < n; first += SLIP_LANES) {
    const PetscInt count = PetscMin(SLIP_LANES, n - first);

    PetscCall(SlipDippingStress(k->shear_modulus, k->poisson_ratio, k->full_space, source, slip, count,
                                points + 3 * first, stress));
    for (PetscInt i = 0; i < count; i++) SlipStressTraction(1, stress + 6 * i, directions, traction + 3 * (first + i));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* 0.33 us a pair where Centre_Dipping() takes 1 us, measured */
static void Centres_Dipping(const SlipKernel *k, PetscInt n, const SlipCell receiver[], const SlipCell source[],
                            PetscReal block[])
{
  for (PetscInt first = 0; first < n; first += SLIP_LANES) {
    const PetscInt count = PetscMin(SLIP_LANES, n - first);
    PetscReal traction[3 * SLIP_LANES];

    SlipDippingTractions_Private(k->shear_modulus, k->poisson_ratio, k->full_space, count, receiver + first,
                                 source + first, traction);
    for (PetscInt i = 0; i < count; i++) {
      block[2 * (first + i)] = traction[3 * i];
      block[2 * (first + i) + 1] = traction[3 * i + 2];
    }
  }
}

const SlipKernelType SlipKernelDipping = {
  .name = "dipping",
  .components = 1,
  .normals = 1,
  .centre = Centre_Dipping,
  .plane = Plane_Dipping,
  .centres = Centres_Dipping,
};

static void CellOf(const SlipCell *c, SlipTriangleCell *cell)
{
  for (int k = 0; k < 9; k++) cell->vertices[k] = c->vertices[k];
  if (!c->directions) SlipPlaneDirections(c->rectangle.strike, c->rectangle.dip, c->rake, cell->directions);
  for (int k = 0; k < 9 && c->directions; k++) cell->directions[k] = c->directions[k];
}

/* Is b the cell before, as in a row or column of a stiffness? */
static PetscBool Same(const SlipCell *a, const SlipCell *b)
{
  return a->vertices == b->vertices && a->rake == b->rake ? PETSC_TRUE : PETSC_FALSE;
}

/* Pairs in a row that share their source take less, as SlipTriangleTractions() knows it by its address. */
static void Centres_Triangle(const SlipKernel *k, PetscInt n, const SlipCell receiver[], const SlipCell source[],
                             PetscReal block[])
{
  for (PetscInt first = 0; first < n; first += SLIP_LANES) {
    const PetscInt count = PetscMin(SLIP_LANES, n - first);
    SlipTriangleCell cell[2 * SLIP_LANES];
    const SlipTriangleCell *r[SLIP_LANES], *s[SLIP_LANES];
    PetscReal traction[3 * SLIP_LANES];

    for (PetscInt i = 0; i < count; i++) {
      const SlipCell *p = receiver + first + i, *q = source + first + i;

      r[i] = i > 0 && Same(p, p - 1) ? r[i - 1] : &cell[2 * i];
      s[i] = i > 0 && Same(q, q - 1) ? s[i - 1] : &cell[2 * i + 1];
      if (r[i] == &cell[2 * i]) CellOf(p, &cell[2 * i]);
      if (s[i] == &cell[2 * i + 1]) CellOf(q, &cell[2 * i + 1]);
    }
    SlipTriangleTractions(k->shear_modulus, k->poisson_ratio, k->full_space, count, r, s, traction);
    for (PetscInt i = 0; i < count; i++) {
      block[2 * (first + i)] = traction[3 * i];
      block[2 * (first + i) + 1] = traction[3 * i + 2];
    }
  }
}

static void Centre_Triangle(const SlipKernel *k, const SlipCell *receiver, const SlipCell *source, PetscReal block[])
{
  Centres_Triangle(k, 1, receiver, source, block);
}

/* 2 us without a surface, 4 to 8 below one, 100 and more next to the ground */
static void Average_Triangle(const SlipKernel *k, const SlipCell *receiver, const SlipCell *source, PetscReal block[])
{
  SlipTriangleCell r, s;

  CellOf(receiver, &r);
  CellOf(source, &s);
  SlipTriangleAverage(k->shear_modulus, k->poisson_ratio, k->full_space, &r, &s, SlipAverageCore(k->average), block);
}

static PetscReal Side_Triangle(const SlipKernel *k, const SlipCell *cell, PetscInt side, PetscReal share,
                               PetscReal ratio)
{
  SlipTriangleCell c;

  CellOf(cell, &c);
  return SlipTriangleAverageEdge(k->shear_modulus, k->poisson_ratio, &c, side, share, ratio);
}

const SlipKernelType SlipKernelTriangle = {
  .name = "triangle",
  .components = 1,
  .normals = 1,
  .centre = Centre_Triangle,
  .average = Average_Triangle,
  .centres = Centres_Triangle,
  .side = Side_Triangle,
};
