/*
  Kernels, from which the entries of a stiffness are computed: vertical strike-slip rectangles, those of any direction,
  and triangles. Each kernel is a table of functions with the closed forms of the other files in this folder.
*/
#include <slipcompat.h>
#include <slipstep/private/sliptrianglelanes.h>
#include <slipstep/private/slipelasticity.h>
#include <math.h>

/* Checks that a stiffness can be computed from a kernel. comm: communicator of the error messages. Errors:
   PETSC_ERR_ARG_NULL without a type, PETSC_ERR_ARG_OUTOFRANGE for elastic constants out of range, PETSC_ERR_SUP for
   more than three components of slip or one row of normal stress, and averages that the type does not support. */
PetscErrorCode SlipKernelCheck(MPI_Comm comm, const SlipKernel *k)
{
  PetscFunctionBegin;
  PetscCheck(k->type && k->type->centre, comm, PETSC_ERR_ARG_NULL,
             "A kernel needs a type with a function for the centre, such as SlipKernelStrikeSlip");
  PetscCheck(k->shear_modulus > 0 && PetscIsNormalReal(k->shear_modulus), comm, PETSC_ERR_ARG_OUTOFRANGE,
             "Shear modulus must be positive and finite, not %g Pa", (double)k->shear_modulus);
  PetscCheck(k->poisson_ratio > -1 && k->poisson_ratio < 0.5, comm, PETSC_ERR_ARG_OUTOFRANGE,
             "Poisson's ratio must lie in (-1, 0.5), not %g", (double)k->poisson_ratio);
  PetscCheck(k->type->components >= 1 && k->type->components <= 3 && k->type->normals >= 0 && k->type->normals <= 1,
             comm, PETSC_ERR_SUP,
             "Kernel \"%s\" has %" PetscInt_FMT " components of slip and %" PetscInt_FMT
             " rows of normal stress, expected 1 to 3 and at most 1",
             k->type->name, k->type->components, k->type->normals);
  PetscCheck(k->average == SLIP_AVERAGE_CENTRE || k->type->average, comm, PETSC_ERR_SUP,
             "Kernel \"%s\" knows no average over a cell, expected SLIP_AVERAGE_CENTRE", k->type->name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Checks also that the kernel has one component of slip or several, as the caller needs. */
PetscErrorCode SlipKernelCheckComponents(MPI_Comm comm, const SlipKernel *k, PetscInt components)
{
  PetscFunctionBegin;
  PetscCheck((k->type->components > 1) == (components > 1), comm, PETSC_ERR_SUP,
             "Kernel \"%s\" has %" PetscInt_FMT " components of slip, expected %s: %s", k->type->name,
             k->type->components, components == 1 ? "1" : "2, or 3 with opening",
             components == 1 ? "vectors of slip are for MatCreateSlipCellVectorStiffness() and its sister of grids"
                             : "take one for vectors of slip, such as SlipKernelDippingVector");
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void Centre_StrikeSlip(const SlipKernel *k, const SlipCell *receiver, const SlipCell *source, PetscReal block[])
{
  const SlipDippingRectangle *r = &receiver->rectangle, *s = &source->rectangle;

  block[0] = SlipKernelOffset(k->shear_modulus, k->poisson_ratio, r->x - s->x, r->y - s->y, r->z, s->z, s->length,
                              s->width, k->full_space);
}

/* Computes the average; an edge that both cells share has the mean core. */
static void Average_StrikeSlip(const SlipKernel *k, const SlipCell *receiver, const SlipCell *source, PetscReal block[])
{
  const SlipDippingRectangle *a = &receiver->rectangle, *b = &source->rectangle;
  const SlipRectangle r = {a->x, a->y, a->z, a->length, a->width}, s = {b->x, b->y, b->z, b->length, b->width};
  const PetscReal share = SlipAverageCore(k->average);
  const PetscReal core[2] = {share * PetscSqrtReal(r.length * s.length), share * PetscSqrtReal(r.width * s.width)};

  block[0] = SlipKernelAverage(k->shear_modulus, k->poisson_ratio, &r, &s, core, k->full_space);
}

/* Computes the surface's part. Averages already have its form; the values at centres c + z l + z^2 q (dislocation.c)
   have it in their symmetric part, as (z + z')/2 l and (z^2 + z'^2)/2 q are s/2 l and s^2/2 q - z z' q, s = z + z'. */
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

/* ---- the mirror image in place of the free surface ---- */

static void Centre_Mirror(const SlipKernel *k, const SlipCell *receiver, const SlipCell *source, PetscReal block[])
{
  const SlipDippingRectangle *r = &receiver->rectangle, *s = &source->rectangle;

  block[0] = 0;
  for (int side = 1; side >= -1; side -= 2)
    block[0] += SlipKernelOffset(k->shear_modulus, k->poisson_ratio, r->x - s->x, r->y - s->y, r->z, side * s->z,
                                 s->length, s->width, PETSC_TRUE);
}

static void Average_Mirror(const SlipKernel *k, const SlipCell *receiver, const SlipCell *source, PetscReal block[])
{
  SlipCell image = *source;
  SlipKernel full = *k;
  PetscReal part;

  full.full_space = PETSC_TRUE;
  Average_StrikeSlip(&full, receiver, source, block);
  image.rectangle.z = -image.rectangle.z;
  Average_StrikeSlip(&full, receiver, &image, &part);
  block[0] += part;
}

static void Surface_Mirror(const SlipKernel *k, PetscReal dx, PetscReal s, PetscReal a, PetscReal b, PetscReal part[2])
{
  SlipCell receiver = {.rectangle = {.x = dx, .z = s / 2, .length = a, .width = b}}, image = receiver;
  SlipKernel full = *k;

  full.full_space = PETSC_TRUE;
  image.rectangle.x = 0;
  image.rectangle.z = -s / 2;
  (*(k->average ? Average_StrikeSlip : Centre_StrikeSlip))(&full, &receiver, &image, part);
  part[1] = 0;
}

const SlipKernelType SlipKernelMirror = {
  .name = "mirror",
  .components = 1,
  .symmetry = {SLIP_EVEN_STRIKE, SLIP_EVEN_STRIKE},
  .centre = Centre_Mirror,
  .average = Average_Mirror,
  .surface = Surface_Mirror,
  .edge = SlipAverageEdge_Private,
};

/* Computes the value at the centre. Cells were checked before, so that this should not fail; if it does, it is NaN. */
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

/* Computes many points of one source, in 0.45 us each where Centre_Dipping() takes 1.1 us (measured). */
static PetscErrorCode Plane_Dipping(const SlipKernel *k, const SlipDippingRectangle *source, PetscInt component,
                                    PetscInt n, const PetscReal points[], PetscReal traction[])
{
  const PetscReal slip[3] = {component == 0, component == 1, component == 2};
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

/* Puts tractions [n][slips][3] into blocks: [n][3][slips], and of one slip [n][2], along the rake and normal. Both
   components together take 1.3 times as long as one, for triangles 1.4 times (measured). */
static void PutBlocks(PetscInt slips, PetscInt n, const PetscReal traction[], PetscReal block[])
{
  for (PetscInt k = 0; k < n; k++, traction += 3 * slips)
    for (PetscInt i = 0; i < 3; i++)
      for (PetscInt j = 0; j < slips; j++)
        if (slips > 1 || i != 1) *block++ = traction[3 * j + i];
}

/* Computes many pairs, of one component in 0.21 us each where Centre_Dipping() takes 1 us (measured). */
static void Centres_Dipping(const SlipKernel *k, PetscInt n, const SlipCell receiver[], const SlipCell source[],
                            PetscReal block[])
{
  const PetscInt slips = k->type->components;

  for (PetscInt first = 0; first < n; first += SLIP_LANES) {
    const PetscInt count = PetscMin(SLIP_LANES, n - first);
    PetscReal traction[9 * SLIP_LANES];

    SlipDippingTractions_Private(k->shear_modulus, k->poisson_ratio, k->full_space, slips, count, receiver + first,
                                 source + first, traction);
    PutBlocks(slips, count, traction, block + (slips > 1 ? 3 * slips : 2) * first);
  }
}

const SlipKernelType SlipKernelDipping = {
  .name = "dipping",
  .components = 1,
  .normals = 1,
  .symmetry = {0, SLIP_EVEN_DEPTH},
  .centre = Centre_Dipping,
  .plane = Plane_Dipping,
  .centres = Centres_Dipping,
};

static void Centre_DippingVector(const SlipKernel *k, const SlipCell *receiver, const SlipCell *source,
                                 PetscReal block[])
{
  Centres_Dipping(k, 1, receiver, source, block);
}

const SlipKernelType SlipKernelDippingVector = {
  .name = "dipping_vector",
  .components = 2,
  .normals = 1,
  .symmetry = {0, SLIP_EVEN_DEPTH},
  .centre = Centre_DippingVector,
  .plane = Plane_Dipping,
  .centres = Centres_Dipping,
};

const SlipKernelType SlipKernelDippingOpening = {
  .name = "dipping_opening",
  .components = 3,
  .symmetry = {0, SLIP_EVEN_DEPTH},
  .centre = Centre_DippingVector,
  .plane = Plane_Dipping,
  .centres = Centres_Dipping,
};

/* Sets up a triangle; for vectors of slip with the directions of rake 0 */
static void CellOf(const SlipKernel *k, const SlipCell *c, SlipTriangleCell *cell)
{
  const PetscReal rake = k->type->components > 1 ? 0 : c->rake;

  for (int i = 0; i < 9; i++) cell->vertices[i] = c->vertices[i];
  if (!c->directions) SlipPlaneDirections(c->rectangle.strike, c->rectangle.dip, rake, cell->directions);
  for (int i = 0; i < 9 && c->directions; i++) cell->directions[i] = c->directions[i];
}

static void Cell_Triangle(const SlipKernel *k, const SlipCell *cell, PetscReal numbers[])
{
  SlipTriangleCell c;

  CellOf(k, cell, &c);
  SlipTriangleDataOf_Private(k->poisson_ratio, k->full_space, k->type->components, &c, (SlipTriangleData *)numbers);
}

static void Blocks_Triangle(const SlipKernel *k, PetscBool normal, const PetscReal receiver[], const PetscReal source[],
                            PetscReal block[], PetscReal near[])
{
  const PetscInt slips = k->type->components;

  SlipTriangleLanesTractions_Private(k->shear_modulus, k->poisson_ratio, k->full_space, slips, normal ? 2 : 0,
                                     normal ? 1 : slips, (const SlipTriangleLanes *)receiver,
                                     (const SlipTriangleLanes *)source, block, near);
}

static void Centre_Triangle(const SlipKernel *k, const SlipCell *receiver, const SlipCell *source, PetscReal block[])
{
  SlipTriangleCell r, s;
  PetscReal traction[9];

  CellOf(k, receiver, &r);
  CellOf(k, source, &s);
  SlipTriangleTractions(k->shear_modulus, k->poisson_ratio, k->full_space, k->type->components, &r, &s, traction);
  PutBlocks(k->type->components, 1, traction, block);
}

/* Computes the average, in 2 us without a surface, 4 to 8 us below one, 100 us and more next to the ground. */
static void Average_Triangle(const SlipKernel *k, const SlipCell *receiver, const SlipCell *source, PetscReal block[])
{
  SlipTriangleCell r, s;

  CellOf(k, receiver, &r);
  CellOf(k, source, &s);
  SlipTriangleAverage(k->shear_modulus, k->poisson_ratio, k->full_space, k->type->components, &r, &s,
                      SlipAverageCore(k->average), block);
}

static void Side_Triangle(const SlipKernel *k, const SlipCell *cell, PetscInt side, PetscReal share, PetscReal ratio,
                          PetscReal block[])
{
  SlipTriangleCell c;

  CellOf(k, cell, &c);
  SlipTriangleAverageEdge(k->shear_modulus, k->poisson_ratio, k->type->components, &c, side, share, ratio, block);
}

const SlipKernelType SlipKernelTriangle = {
  .name = "triangle",
  .components = 1,
  .normals = 1,
  .centre = Centre_Triangle,
  .average = Average_Triangle,
  .side = Side_Triangle,
};

const SlipKernelType SlipKernelTriangleVector = {
  .name = "triangle_vector",
  .components = 2,
  .normals = 1,
  .centre = Centre_Triangle,
  .average = Average_Triangle,
  .side = Side_Triangle,
};

const SlipKernelType SlipKernelTriangleOpening = {
  .name = "triangle_opening",
  .components = 3,
  .centre = Centre_Triangle,
  .average = Average_Triangle,
  .side = Side_Triangle,
};

const SlipKernelLanes *SlipKernelGetLanes(const SlipKernel *kernel)
{
  static const SlipKernelLanes triangles = {
    .numbers = sizeof(SlipTriangleData) / sizeof(PetscReal), .cell = Cell_Triangle, .blocks = Blocks_Triangle};

  return kernel->type->centre == Centre_Triangle && !kernel->average ? &triangles : NULL;
}
