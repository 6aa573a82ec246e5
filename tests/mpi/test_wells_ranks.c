/* The cells of wells, and their shares of the rates, on all ranks against each rank alone and against loops over all
   cells, on a grid, rectangles and triangles; the rate in time, and its changes, at which steps end. */
#include "ranks.h"
#include "cells.h"
#include "faultstart.h"
#include <slipstep/private/slipfault.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

enum { NX = 9, NZ = 7, WELLS = 4, MOST = 4 * NX * NZ };
static const char csv[] = "test_wells_ranks.csv";

/* What a fault makes of the wells, by rows; the same on all ranks */
typedef struct {
  PetscInt N, fault[MOST];
  PetscReal centre[MOST][3], weight[MOST], share[WELLS][MOST], place[WELLS][3];
} Found;

static PetscErrorCode Find(MPI_Comm comm, const char mesh[], Found *f)
{
  SlipFault fault;

  memset(f, 0, sizeof(*f));
  PetscCall(SlipFaultCreate(comm, &fault));
  PetscCall(FaultSetReals(fault, {"nx", NX}, {"nz", NZ}, {"dip", 60}, {"rake", 90}, {"permeability", 1e-15}));
  PetscCall(FaultSetStrings(fault, {"wells", csv}, {"mesh_frame", mesh ? "ned" : "auto"}, {"mesh", mesh ? mesh : ""}));
  PetscCall(SlipFaultSetUp(fault));
  f->N = fault->mesh.N;
  Check(fault->loads.nwells == WELLS, "%d wells, expected %d", (int)fault->loads.nwells, WELLS);
  for (int w = 0; w < WELLS; w++) {
    const SlipFaultWell *well = &fault->loads.wells[w];

    PetscCall(PetscArraycpy(f->place[w], well->place, 3));
    for (PetscInt k = 0; k < well->ncells; k++)
      f->share[w][SlipFaultMeshRow(&fault->mesh, well->cell[k])] = well->share[k];
  }
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    const PetscInt row = SlipFaultMeshRow(&fault->mesh, i);
    SlipFaultCell cell;

    fault->mesh.kind->cell(&fault->mesh, row, &cell);
    PetscCall(PetscArraycpy(f->centre[row], cell.centre, 3));
    f->weight[row] = fault->mesh.weight[i];
    f->fault[row] = SlipFaultMeshFaultOf(&fault->mesh, row);
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, f->fault, MOST, MPIU_INT, MPI_SUM, comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, f->centre, (4 + WELLS) * MOST, MPIU_REAL, MPIU_SUM, comm));
  return SlipFaultDestroy(&fault);
}

/* Writes the file, at the start and the end of which all ranks wait. */
static PetscErrorCode Write(const char text[])
{
  PetscMPIInt rank;

  PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
  PetscCallMPI(MPI_Barrier(PETSC_COMM_WORLD));
  if (!rank) {
    FILE *file = fopen(csv, "w");

    Check(file && fputs(text, file) >= 0 && !fclose(file), "%s cannot be written", csv);
  }
  PetscCallMPI(MPI_Barrier(PETSC_COMM_WORLD));
  return PETSC_SUCCESS;
}

static PetscReal Distance2(const PetscReal a[3], const PetscReal b[3], PetscBool y)
{
  return PetscSqr(a[0] - b[0]) + (y ? PetscSqr(a[1] - b[1]) : 0) + PetscSqr(a[2] - b[2]);
}

/* Wells at x, z with a spread; places: x, y, z of each, as they were found before, or NULL: the file has no y */
static PetscErrorCode Compare(const char mesh[], const PetscReal xz[WELLS][3], PetscReal places[WELLS][3], PetscBool y)
{
  static Found all, alone;
  char text[1024];
  int n = snprintf(text, sizeof(text), "well,x,%sz,days,L/s,spread\n", y ? "y," : "");

  for (int w = 0; w < WELLS; w++) {
    n += snprintf(text + n, sizeof(text) - (size_t)n, "%d,%g,", w, (double)xz[w][0]);
    if (y) n += snprintf(text + n, sizeof(text) - (size_t)n, "%.17g,", (double)places[w][1]);
    n += snprintf(text + n, sizeof(text) - (size_t)n, "%g,0,1,%g\n", (double)xz[w][1], (double)xz[w][2]);
  }
  PetscCall(Write(text));
  PetscCall(Find(PETSC_COMM_WORLD, mesh, &all));
  PetscCall(Find(PETSC_COMM_SELF, mesh, &alone));
  Check(!memcmp(all.place, alone.place, sizeof(all.place)), "places depend on ranks");
  for (int w = 0; w < WELLS; w++) {
    const PetscReal s = xz[w][2], *at = all.place[w];
    PetscReal sum = 0, want = 0;
    PetscInt nearest = 0;

    for (PetscInt e = 0; e < all.N; e++) {
      sum += all.share[w][e];
      if (Distance2(at, all.centre[e], y) < Distance2(at, all.centre[nearest], y)) nearest = e;
    }
    Check(fabs(sum - 1) < 1e-14, "the shares of well %d sum to %.17g", w, (double)sum);
    Check(at[0] == xz[w][0] && at[1] == (y ? places[w][1] : all.centre[nearest][1]) && at[2] == xz[w][1],
          "well %d is at %g, %g, %g", w, (double)at[0], (double)at[1], (double)at[2]);
    for (PetscInt e = 0; e < all.N; e++) /* 0 for the other fault */
      want += all.weight[e] * (all.fault[e] == all.fault[nearest]) *
              exp(s > 0 ? -Distance2(at, all.centre[e], y) / (2 * s * s) : 0);
    for (PetscInt e = 0; e < all.N; e++) {
      const PetscReal value = s < 10 ? (e == nearest)
                                     : all.weight[e] * (all.fault[e] == all.fault[nearest]) *
                                         exp(-Distance2(at, all.centre[e], y) / (2 * s * s)) / want;

      Check(fabs(all.share[w][e] - value) < 1e-14, "cell %d of well %d has the share %.17g, expected %.17g", (int)e, w,
            (double)all.share[w][e], (double)value);
      /* sums over the cells differ by rounding */
      Check(fabs(all.share[w][e] - alone.share[w][e]) <= 1e-15 * (PetscReal)all.N * alone.share[w][e],
            "cell %d of well %d has the share %.17g on all ranks, %.17g on one", (int)e, w, (double)all.share[w][e],
            (double)alone.share[w][e]);
    }
  }
  return PetscArraycpy(places[0], all.place[0], 3 * WELLS);
}

static PetscErrorCode Times(void)
{
  const PetscReal change[] = {0.3, 1e6, 1e6 * (1 + 1e-9)};
  const SlipFaultWell *well;
  PetscReal t = -1;
  SlipFault fault;
  char text[256];

  (void)snprintf(text, sizeof(text), "well,x,z,s,L/s\nA,100,100,%.17g,1\nA,100,100,%.17g,-2\nA,100,100,%.17g,0\n",
                 change[0], change[1], change[2]);
  PetscCall(Write(text));
  PetscCall(SlipFaultCreate(PETSC_COMM_WORLD, &fault));
  PetscCall(FaultSetReals(fault, {"nx", 4}, {"permeability", 1e-15}));
  PetscCall(FaultSetStrings(fault, {"wells", csv}));
  PetscCall(SlipFaultSetUp(fault));
  well = fault->loads.wells;
  Check(SlipFaultWellValue(well, 0) == 0 && SlipFaultWellValue(well, 0.3) == 1e-3, "not from 0.3 s on");
  Check(SlipFaultWellValue(well, 1e6 - 1) == 1e-3 && SlipFaultWellValue(well, 1e6) == -2e-3, "not from 1e6 s on");
  Check(SlipFaultWellValue(well, 1e6 * (1 - 1e-15)) == -2e-3, "not in a step that begins there, to rounding");
  Check(SlipFaultWellValue(well, 1e9) == 0 && !SlipFaultWellHolds(well, 1e9), "not shut in, or held");
  for (int k = 0; k < 4; k++) {
    const PetscReal next = SlipLoadsNextCorner(&fault->loads, t);

    Check(next == (k < 3 ? change[k] : PETSC_MAX_REAL), "the change %d is at %.17g s", k, (double)next);
    t = next * (1 - 1e-15); /* a step that ends there, to rounding */
  }
  PetscCall(SlipFaultDestroy(&fault));
  PetscCall(Write("well,x,z,days,MPa\nA,100,100,1,2\n"));
  PetscCall(SlipFaultCreate(PETSC_COMM_WORLD, &fault));
  PetscCall(FaultSetReals(fault, {"nx", 4}, {"permeability", 1e-15}));
  PetscCall(FaultSetStrings(fault, {"wells", csv}));
  PetscCall(SlipFaultSetUp(fault));
  well = fault->loads.wells;
  Check(!SlipFaultWellHolds(well, 86399) && SlipFaultWellHolds(well, 86400) && SlipFaultWellValue(well, 86400) == 2e6,
        "2 MPa are not held from a day on");
  return SlipFaultDestroy(&fault);
}

/* One process; the mesh merges vertices at one place. */
static PetscErrorCode WriteTriangles(const char file[], const SlipCells *c)
{
  const PetscInt vertices[] = {3 * c->n, 3}, triangles[] = {c->n, 3};
  static PetscInt corner[3 * MOST];
  SlipH5 h;

  for (PetscInt k = 0; k < 3 * c->n; k++) corner[k] = k;
  PetscCall(SlipH5Create(file, &h));
  PetscCall(SlipH5WriteReal(&h, "/vertices", 2, vertices, c->vertices, "m"));
  PetscCall(SlipH5WriteInt(&h, "/triangles", 2, triangles, corner, NULL));
  return SlipH5Close(&h);
}

static PetscErrorCode Run(void)
{
  static const PetscReal grid[WELLS][3] = {{1010, 600, 0}, {2900, 2300, 0}, {1500, 1200, 400}, {40, 60, 1}};
  static const PetscReal planes[WELLS][3] = {{310, 400, 0}, {850, 900, 0}, {480, 500, 150}, {20, 950, 1}};
  static const char *const file[] = {NULL, "test_wells_ranks.h5", "test_wells_ranks_triangles.h5"};
  static PetscReal numbers[8 * 2 * NX * NZ], places[WELLS][3];
  const SlipCells cells = TwoDippingPlanes(NX, NZ, numbers);
  PetscMPIInt rank;

  PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
  if (!rank) {
    static PetscReal data[TRIANGLE_COLUMNS * MOST];
    const SlipCells t = TrianglesOf(&cells, data);

    PetscCall(WriteCells(file[1], &cells));
    PetscCall(WriteTriangles(file[2], &t));
  }
  for (int k = 0; k < 3; k++)
    for (int y = 0; y < 2; y++) PetscCall(Compare(file[k], k ? planes : grid, places, y ? PETSC_TRUE : PETSC_FALSE));
  PetscCall(Times());
  PetscCallMPI(MPI_Barrier(PETSC_COMM_WORLD));
  if (!rank) (void)(unlink(csv) + unlink(file[1]) + unlink(file[2]));
  return PETSC_SUCCESS;
}

SLIP_RANKS(Run)
