/* The operations on a fault's cells: a table of functions, with a row for each place where arrays may be */
#pragma once
#include <slipstep/private/slipfaultproblem.h>

/* Numbers of some cells, or of the ground, which observers record after each step */
typedef struct {
  PetscInt m;              /* cells, or numbers of the ground */
  const PetscInt *cell;    /* [m] places on this process, negative elsewhere; borrowed */
  PetscReal *values;       /* [m][block + components + 1]: state, traction [Pa], effective normal stress [Pa] */
  const PetscReal *matrix; /* [components n][m] of the ground for 1 m of slip of each cell and component; borrowed */
  struct _cl_mem *places, *out; /* on a device: the cells or the matrix, and what is fetched; NULL: not used yet */
} SlipFaultLook;
PETSC_INTERN PetscErrorCode SlipFaultLookDestroy(SlipFault fault, SlipFaultLook *look);
/* A vector of cells, on the device where the states are there */
PETSC_INTERN PetscErrorCode SlipFaultCellVector(SlipFault fault, Vec *x);
/* Sums of SlipFaultCellsOps.step and .timing, see run/watch/slipestimate.c and courseestimate.c */
enum {
  STEP_WORK, /* dP of the step's error [J/m^2] */
  STEP_RESTRAINT /* sum (K u + q) s [J/m^2]: over mean(s) it resists further slip */,
  STEP_SLIP,   /* sum of s [m] */
  STEP_MOVING, /* sum of s where v is not 0 [m] */
  STEP_SUMS
};
enum {
  TIMING_RATE,   /* of |v| [m/s] */
  TIMING_SLIPS,  /* of s [m] */
  TIMING_ALONG,  /* of e_s [m] */
  TIMING_EXCESS, /* M (v e_v - a e_s) [J/m^2] */
  TIMING_VIGOUR, /* M v^2 [J/m^2] */
  TIMING_GROWTH, /* of d|v|/dt [m/s^2] */
  TIMING_SUMS
};

/* What is done with all cells: a row for the processor, observe/cellshost.c, and one for a device,
   observe/cellsopencl.c, which uses that of the processor for vectors and faults that its kernels do not know. Set-up
   chooses the row. Sums are those of this process, and every other result is collective. */
typedef struct {
  /* stages and kicks, of the functions of SlipConstraintOps and SlipExplicitOps */
  PetscErrorCode (*eliminate)(SlipFault fault, const SlipStage *stage);
  PetscErrorCode (*bound)(SlipFault fault, Vec x, Vec q, Vec dq);
  PetscErrorCode (*start_slope)(SlipFault fault, Vec dq);
  PetscErrorCode (*lift)(SlipFault fault, Vec x, Vec w);
  PetscErrorCode (*smooth)(SlipFault fault, const SlipFrictionCells *friction, Vec w, Vec relative, Vec force, Vec F);
  PetscErrorCode (*add_reaction)(SlipFault fault, PetscReal a, Vec r, Vec F);
  PetscErrorCode (*solve_mass)(SlipFault fault, Vec k);
  PetscErrorCode (*kick)(SlipFault fault, PetscReal t, PetscReal a, Vec g, Vec eta, Vec w, PetscBool *ok);
  PetscErrorCode (*drift)(SlipFault fault, PetscReal t, PetscReal h, Vec w);
  /* friction of a state, and the slip rates that balance it: balance.rate, from balance.force, and the rates F of w */
  PetscErrorCode (*strength)(SlipFault fault, PetscReal t, Vec w, Vec q);
  PetscErrorCode (*rates)(SlipFault fault, PetscReal t, Vec w, Vec F);
  PetscErrorCode (*compliance)(SlipFault fault, Vec w, PetscReal *most); /* largest dv/dtau of that balance */
  /* loads: SlipFaultGetShear(); cells that the pore pressure opens; those, at most, that bare does not mark yet */
  PetscErrorCode (*shear)(SlipFault fault, PetscReal t, Vec *shear);
  PetscErrorCode (*opened)(SlipFault fault, PetscReal t, PetscInt *opened);
  PetscErrorCode (*bare)(SlipFault fault, PetscReal t, Vec w, Vec bare, PetscInt *more, PetscReal *least);
  /* sums over the cells in the order of their enumerations, and largest values */
  PetscErrorCode (*sums)(SlipFault fault, PetscReal t, Vec w, Vec force, PetscReal sum[], PetscReal *max_v);
  PetscErrorCode (*mode)(SlipFault fault, PetscReal t, Vec w, Vec x, Vec kx, Vec nx, PetscReal sum[]);
  PetscErrorCode (*estimates)(SlipFault fault, Vec w, Vec error, Vec derivative, PetscReal sum[]);
  PetscErrorCode (*powers)(SlipFault fault, PetscReal t, Vec w, Vec r, PetscReal power[3], PetscReal friction[]);
  PetscErrorCode (*step)(SlipFault fault, PetscReal t, Vec w, Vec e, Vec ku, PetscReal sum[]);
  PetscErrorCode (*timing)(SlipFault fault, Vec w, Vec e, Vec d, PetscReal sum[]);
  PetscErrorCode (*course)(SlipFault fault, PetscReal t, Vec w, PetscReal sum[]); /* the first two of timing */
  PetscErrorCode (*moments)(SlipFault fault, PetscReal t, Vec w, PetscReal rate[], PetscReal slip[]);
  PetscErrorCode (*slip)(SlipFault fault, PetscReal dt, Vec w, Vec u, PetscReal *largest);
  PetscErrorCode (*outside)(SlipFault fault, Vec w, const PetscReal bound[], PetscInt *outside);
  /* records of a state: its traction for those who add up powers, numbers of some cells and of the ground, ruptures */
  PetscErrorCode (*traction)(SlipFault fault, PetscReal t, Vec w, Vec *r);
  PetscErrorCode (*look)(SlipFault fault, PetscReal t, Vec w, SlipFaultLook *look);
  PetscErrorCode (*ground)(SlipFault fault, Vec w, Vec start, SlipFaultLook *look, PetscReal moved[],
                           PetscReal moves[]);
  PetscErrorCode (*rupture)(SlipFault fault, PetscInt nodes, const Vec node[], const PetscReal share[], PetscReal begin,
                            PetscReal dt, Vec push, Vec rupture, PetscBool *unbroken);
} SlipFaultCellsOps;
PETSC_INTERN const SlipFaultCellsOps SlipFaultCellsHost, SlipFaultCellsOpenCL;
PETSC_INTERN void SlipFaultCellsChoose(SlipFault fault);
/* The functions of the row of the processor that stand where their callers are */
PETSC_INTERN PetscErrorCode SlipFaultHostEliminate(SlipFault fault, const SlipStage *stage);
PETSC_INTERN PetscErrorCode SlipFaultHostBound(SlipFault fault, Vec x, Vec q, Vec dq);
PETSC_INTERN PetscErrorCode SlipFaultHostStartSlope(SlipFault fault, Vec dq);
PETSC_INTERN PetscErrorCode SlipFaultHostLift(SlipFault fault, Vec x, Vec w);
PETSC_INTERN PetscErrorCode SlipFaultHostSmooth(SlipFault fault, const SlipFrictionCells *friction, Vec w, Vec relative,
                                                Vec force, Vec F);
PETSC_INTERN PetscErrorCode SlipFaultHostAddReaction(SlipFault fault, PetscReal a, Vec r, Vec F);
PETSC_INTERN PetscErrorCode SlipFaultHostSolveMass(SlipFault fault, Vec k);
PETSC_INTERN PetscErrorCode SlipFaultHostKick(SlipFault fault, PetscReal t, PetscReal a, Vec g, Vec eta, Vec w,
                                              PetscBool *ok);
PETSC_INTERN PetscErrorCode SlipFaultHostDrift(SlipFault fault, PetscReal t, PetscReal h, Vec w);
PETSC_INTERN PetscErrorCode SlipFaultHostStrength(SlipFault fault, PetscReal t, Vec w, Vec q);
PETSC_INTERN PetscErrorCode SlipFaultHostRates(SlipFault fault, PetscReal t, Vec w, Vec F);
PETSC_INTERN PetscErrorCode SlipFaultHostCompliance(SlipFault fault, Vec w, PetscReal *most);
PETSC_INTERN PetscErrorCode SlipFaultHostSums(SlipFault fault, PetscReal t, Vec w, Vec force, PetscReal sum[],
                                              PetscReal *max_v);
PETSC_INTERN PetscErrorCode SlipFaultHostMode(SlipFault fault, PetscReal t, Vec w, Vec x, Vec kx, Vec nx,
                                              PetscReal sum[]);
PETSC_INTERN PetscErrorCode SlipFaultHostPowers(SlipFault fault, PetscReal t, Vec w, Vec r, PetscReal power[3],
                                                PetscReal friction[]);
PETSC_INTERN PetscErrorCode SlipFaultGetLost(SlipFault fault, PetscReal t, Vec w, Vec rel, PetscReal *lost);
