/* Pore fluid that diffuses in the cells of a fault, with a permeability that slip and stress may change */
#pragma once
#include <slipstep/rooms/slipfault.h>
#include <slipstep/rooms/slipcore.h>
#include <slipstep/rooms/slipfluid.h>
#include <slipstep/private/slipfaultloads.h>
#include <slipstep/private/slipstate.h>

#define SLIP_FLUID_GAMMA 0.29289321881345247559916 /* of the stages of a step, 1 - 1/sqrt(2) */

/* Volumes so far [m^3]: injected by wells and the source; lost into the rock; through the border; by which pores have
   grown as they dilate, at constant pressure */
typedef enum { FLUID_INJECTED, FLUID_LEAKED, FLUID_BORDER, FLUID_PORES, FLUID_NUM_VOLUMES } SlipFluidVolumeId;

/* The fluid at a time; arrays of the cells of this process [n] */
typedef struct {
  PetscReal time;      /* [s] */
  PetscReal next;      /* proposed length of the next step of the diffusion [s] */
  PetscBool fresh;     /* the rates of pressure are not those from here on: a run begins, or a well has changed */
  PetscReal *pressure; /* [Pa] */
  PetscReal *rate;     /* dp/dt [Pa/s] */
  PetscReal *state;    /* k* of the permeability law [m^2] */
  PetscReal *onset;    /* time at which fluid that leaks by Carter's law has reached the cell [s]; largest: not yet */
  PetscReal volume[FLUID_NUM_VOLUMES];
} SlipFluidNode;

/* Work space of the cells: permeability, and then conductance, along strike and down dip; what leaves per pressure,
   and of that into the rock; what enters; the right-hand side; by how much the first stage of a step has raised the
   pressure; k* at that stage; normal stress without this fluid; pressure */
enum {
  FLUID_WORK_ALONG,
  FLUID_WORK_DOWN,
  FLUID_WORK_SINK,
  FLUID_WORK_LEAK,
  FLUID_WORK_INFLOW,
  FLUID_WORK_RIGHT,
  FLUID_WORK_RAISED,
  FLUID_WORK_STATE,
  FLUID_WORK_HOLD,
  FLUID_WORK_OWN,
  FLUID_NUM_WORK
};

/* Numbers of a cell in the history */
enum {
  FLUID_PRESSURE,
  FLUID_RATE,
  FLUID_STATE,
  FLUID_ONSET,
  FLUID_SPEED, /* slip rate [m/s], */
  FLUID_CURVE, /* and half its mean derivative over the last step [m/s^2] */
  FLUID_EXTRA, /* normal stress that slip has made [Pa], and its rate [Pa/s] */
  FLUID_EXTRA_RATE,
  FLUID_PSI, /* first friction state and its rate [1/s], of dilatancy */
  FLUID_PSI_RATE,
  FLUID_DISPLACEMENT /* [components] [m]; then [most] pressures of sides [Pa] */
};

/* What drives the fluid from the history on, as functions of the time since then: the slip is that of the speed and a
   curve, the normal stress without this fluid, beyond that of the loads, is extra and its rate; dilating pores take
   in the volume dilation t + swelling t^2 */
typedef struct {
  PetscReal *speed, *curve, *extra, *extra_rate; /* [n] [m/s], [m/s^2], [Pa], [Pa/s] */
  PetscReal *dilation, *swelling;                /* [n] [m^3/s], [m^3/s^2] */
} SlipFluidDrive;

/* A way through steps of the diffusion, of which the last two are known: their ends, and the pressure within. Searches
   for an onset go forth and back. */
typedef struct {
  PetscBool begun, stepped, kept; /* from is valid; to is; before is */
  PetscInt slot;
  PetscReal start;  /* time of the history where it began [s] */
  PetscReal target; /* where its steps were to end; NaN: there were solves of others since */
  SlipFluidDrive drive;
  SlipFluidNode before, from, to;
  /* at a share SLIP_FLUID_GAMMA of either step: pressure [n] [Pa], volumes */
  PetscReal *middle, *middle_before, between[FLUID_NUM_VOLUMES], between_before[FLUID_NUM_VOLUMES];
} SlipFluidPath;

/* The step of a path that contains a time, and the shares of its start, the first stage and its end there; without a
   step only the first */
typedef struct {
  const SlipFluidNode *from, *to;
  const PetscReal *middle, *between;
  PetscReal weight[3], share; /* share: of the way in time */
} SlipFluidPlace;

typedef struct {
  PetscBool on;       /* some permeability is not 0 */
  PetscBool follows;  /* slip changes the permeability, or pores */
  PetscInt dilates;   /* pores dilate with the friction state */
  PetscInt leaks;     /* fluid leaks by Carter's law */
  PetscBool stressed; /* the effective normal stress does */
  const SlipPermeabilityLaw *law;
  /* of pressures.c: the other pressures at t [n] [Pa], and the next time at which one of all has a kink [s] */
  PetscErrorCode (*given)(const SlipFaultLoads *loads, PetscReal t, PetscReal p[]);
  PetscReal (*change)(const SlipFaultLoads *loads, PetscReal t);
  SlipDiffusion diffusion;
  SlipDiffusion
    shown;         /* of the flux that is asked for, so that solvers of the run do not see whether it is; NULL: never */
  PetscReal first; /* length of a first step of the diffusion [s] */
  PetscReal *storage, *unit, *leak, *source; /* [n] [m^3/Pa]; w/eta [m/(Pa s)]; [m^3/(Pa s)]; [m^3/s] */
  PetscReal *border;                         /* [n] [Pa]; NaN: nothing flows there */
  PetscReal *index;                          /* [nwells] rate over conductance and pressure; 0: of spread rates */
  PetscReal *work[FLUID_NUM_WORK];           /* [n] each */
  PetscInt block;                            /* numbers of a cell in a slot */
  PetscBool trial;
  struct {
    PetscReal time, next, volume[FLUID_NUM_VOLUMES];
    PetscBool fresh;
    Vec cells;
  } past[2];              /* the history, in two slots as in slipelastic.h */
  PetscInt most;          /* pressures of sides that a cell keeps, with which solves begin, [n][most] */
  PetscReal *sides[3];    /* of the stages of the last step of the first path; at the end of the second one */
  SlipFluidPath path[2];  /* by the drive as of the history; and by what happened */
  PetscReal allowed;      /* error of a pressure that solves of the second one may leave [Pa] */
  PetscBool computed;     /* the second one leads to this displacement of all cells at its end: */
  PetscReal *reached;     /* [n][components] [m] */
  PetscInt steps, solves; /* of the diffusion, so far */
} SlipFaultFluid;

PETSC_INTERN PetscErrorCode SlipFaultFluidSetUp(SlipFault fault);
PETSC_INTERN PetscErrorCode SlipFaultFluidDestroy(SlipFault fault);
/* fluidresults.c */
PETSC_INTERN PetscErrorCode SlipFaultFluidView(SlipFault fault, PetscViewer viewer);
PETSC_INTERN PetscErrorCode SlipFaultFluidWarn(SlipFault fault); /* of cells that meet without a common side */
/* fluid.c: collective. Adds the pressure at t to p [n] [Pa]; the volumes at t, and the stored one */
PETSC_INTERN PetscErrorCode SlipFaultFluidPressure(SlipFault fault, PetscReal t, PetscReal p[]);
PETSC_INTERN PetscErrorCode SlipFaultFluidVolumes(SlipFault fault, PetscReal t, PetscReal volume[], PetscReal *stored);
/* The permeability of the cells at t [m^2] and the Darcy flux along strike and down dip [n][2] [m/s]; NULL: not wanted
 */
PETSC_INTERN PetscErrorCode SlipFaultFluidFlow(SlipFault fault, PetscReal t, PetscReal permeability[],
                                               PetscReal flux[]);
/* Rates [m^3/s] and pressures [Pa] of all wells at t, [nwells] on every process */
PETSC_INTERN PetscErrorCode SlipFaultFluidWells(SlipFault fault, PetscReal t, PetscReal rate[], PetscReal pressure[]);
/* For how long after t pressure is nearly linear in time [s] */
PETSC_INTERN PetscReal SlipFaultFluidScale(SlipFault fault, PetscReal t);
PETSC_INTERN PetscErrorCode SlipFluidWalk(SlipFault fault, SlipFluidPath *path, PetscReal t, PetscBool ends);
PETSC_INTERN PetscErrorCode SlipFluidBegin(SlipFault fault, SlipFluidPath *path, PetscInt slot);
PETSC_INTERN PetscReal SlipFaultFluidPores(SlipFault fault, PetscInt i);
/* fluidleak.c */
PETSC_INTERN void SlipFluidLeak(SlipFault fault, PetscReal t, PetscReal h, int k, const PetscReal onset[]);
PETSC_INTERN PetscErrorCode SlipFluidReached(SlipFault fault, const SlipFluidNode *from, PetscReal h, SlipFluidNode *to,
                                             PetscBool *any);
/* fluidpermeability.c */
PETSC_INTERN void SlipFluidEvolve(SlipFault fault, SlipFluidPath *path, PetscReal own, PetscReal other,
                                  PetscReal stage[]);
PETSC_INTERN PetscErrorCode SlipFluidPermeability(SlipFault fault, const SlipFluidPath *path, PetscReal t,
                                                  const PetscReal state[], const PetscReal pressure[], PetscReal k[]);
PETSC_INTERN PetscErrorCode SlipFluidSetOperator(SlipFault fault, PetscReal t);
PETSC_INTERN PetscErrorCode SlipFluidPressureAt(SlipFault fault, PetscReal t, PetscReal p[]);
PETSC_INTERN PetscErrorCode SlipFluidReach(SlipFault fault, PetscReal t, SlipFluidPlace *place);
PETSC_INTERN PetscErrorCode SlipFluidHold(SlipFault fault, PetscReal t, PetscReal stress[]);
PETSC_INTERN PetscErrorCode SlipFluidPutNode(SlipFault fault, const SlipFluidNode *node);
PETSC_INTERN void SlipFluidForget(SlipFault fault);
/* fluidhistory.c: what SlipElasticAccept() and its like do for the medium */
PETSC_INTERN PetscErrorCode SlipFaultFluidStart(SlipFault fault, PetscReal t);
PETSC_INTERN PetscErrorCode SlipFaultFluidAccept(SlipFault fault, PetscReal t, Vec w, PetscBool first,
                                                 const PetscReal stress[]);
PETSC_INTERN PetscErrorCode SlipFaultFluidAdvance(SlipFault fault, PetscReal t, Vec w, const PetscReal stress[]);
PETSC_INTERN PetscErrorCode SlipFaultFluidRollBack(SlipFault fault);
PETSC_INTERN PetscErrorCode SlipFaultFluidVisit(SlipFault fault, SlipState state);
PETSC_INTERN PetscReal SlipFaultFluidUndrained(SlipFault fault, PetscInt i, PetscReal h, PetscReal change,
                                               PetscReal rate);
PETSC_INTERN PetscErrorCode SlipFaultFluidError(SlipFault fault, PetscReal rtol, PetscReal t, Vec w, PetscReal *E);
