/* A fault as a problem of a TS: the constraint of a stage, the balance of faults that always slide, rest, tolerances
   and defaults. */
#pragma once
#include <slipfault.h>
#include <slipcore.h>
#include <slipstep/private/slipfaultknown.h>
#include <slipstep/private/slipsnes.h>
#include <slipstep/private/slipstate.h>

/* balance.c */
typedef struct {
  PetscReal eta;      /* radiation damping [Pa s/m] */
  PetscReal rtol;     /* that the tolerances were made of */
  PetscBool known;    /* rate is that of the last right-hand side */
  PetscReal time;     /* of it [s] */
  PetscInt sides;     /* right-hand sides of the run so far */
  Vec F;              /* its rates, borrowed from the TS */
  Vec first;          /* those of the first step of a run that goes on from a checkpoint; NULL: to be computed */
  Vec u, rate, force; /* its displacement [m], slip rate [m/s], and K u [Pa] */
  Vec aside[4];       /* room for those of a state within a step, and what it does to normal stress */
  PetscInt64 put;     /* how often it was put into a state */
  PetscBool resting;  /* the step is one of rest, which needs no right-hand side: */
  Vec way, rested;    /* its rates, all the while, and the state at its end */
  PetscReal next;     /* the step to go on with from there [s] */
  PetscReal fastest;  /* the largest slip rate before the last step [m/s] */
  PetscReal least;    /* least of the slips against which those of the cells count [m] */
  PetscBool follows;  /* tolerances follow the largest displacement, against which slips count: */
  PetscBool steady;   /* those of some cells do because these do not weaken */
  PetscReal moved;    /* what that was [m] */
  Vec seen;           /* an attempt's end with its rates, which a controller observes; NULL: none has */
  PetscReal stiffest; /* largest eigenvalue of K [Pa/m]; 0: nobody has asked */
  PetscBool *creeps;  /* [n] cells that slip at the loading rate; NULL: none */
  PetscReal *direct;  /* a sigma of each cell [Pa], the strength's growth with ln |v|; NULL where kept is */
  PetscReal *kept;    /* what the law keeps of each cell; NULL where the normal stress changes */
} SlipFaultBalance;

/* faultdevice.c: where a step is computed, -fault_device */
typedef struct {
  struct _n_SlipDevice *device;                  /* NULL: by the processor */
  PetscReal bytes;                               /* that the fault and its integrator take there at most */
  struct _cl_mem *cells;                         /* what its kernels know of the cells; NULL: nothing has asked */
  struct _cl_mem *pressure, *record, *distance2; /* [n] pore pressure [Pa], -fault_pore_pressure, of the source [m^2] */
  struct _cl_mem *faults;                        /* [n] the number of the fault of each cell, of several */
  PetscBool loaded, pressed;                     /* the load, the pressure of the cells are known */
  PetscReal time, origin;                        /* of them [s] */
  SlipFaultMoment moment;                        /* of their normal stress, where slip changes it */
  Vec shear;                                     /* SlipFaultGetShear(), of shear_time from shear_origin on */
  PetscReal shear_time, shear_origin;
  PetscBool automatic;    /* chosen by -fault_device auto, */
  char why[512];          /* which takes the processor for this reason, else "" */
  PetscObjectId shear_id; /* of that of the processor, where cells stick */
  PetscObjectState shear_state;
  Vec sticking; /* what cells keep whose friction sticks; NULL until asked for */
} SlipFaultDevice;

/* devicerecord.c: numbers of some cells, and displacements of the ground, which observers read of each step there */
typedef struct {
  PetscInt m;                   /* cells, or numbers of the ground */
  struct _cl_mem *places, *out; /* [m], [m][2 components + 3]; or the matrix of the ground [m][components n] */
  PetscReal *values;            /* of the cells: state, strength, normal stress where it changes [m][] */
} SlipFaultDeviceLook;

/* faultconstraint.c: the stage being solved: u = u0 + theta v, s = s0 + theta |v|, B v = c + omega r */
typedef struct {
  SlipConstraint con;
  PetscReal time, theta; /* [s] */
  PetscBool last;        /* of its step: no other one begins where it ends */
  Vec c, u0, s0;
} SlipFaultStage;

/* explicitkick.c: slip rates relative to the far field of the nodes of the last explicit step, and their damping; the
   elastic force at its start */
typedef struct {
  PetscBool known[SLIP_NUM_NODES], forced;
  PetscReal time[SLIP_NUM_NODES];                    /* [s] */
  Vec force;                                         /* [Pa], weighted by area; known where forced */
  Vec rise;                                          /* Kn u of it, where slip changes normal stress [Pa] */
  Vec rate[SLIP_NUM_NODES], damping[SLIP_NUM_NODES]; /* [m/s], [Pa]; NULL before the first such step */
} SlipFaultSettled;

/* tolerancefile.c: relative tolerances at which controllers keep accuracies on faults of a kind, those of a group of a
   file */
enum { TOLERANCES_MOST = 16 }; /* controllers, and accuracies */
typedef struct {
  PetscInt accuracies, controllers;
  PetscReal accuracy[TOLERANCES_MOST];
  struct {
    char controller[64]; /* its type, and a filter after a colon */
    PetscReal rtol[TOLERANCES_MOST];
  } row[TOLERANCES_MOST];
} SlipFaultTolerances;
PETSC_EXTERN PetscErrorCode SlipFaultTolerancesRead(MPI_Comm comm, const char prefix[], const char file[],
                                                    const char kind[], SlipFaultTolerances *t);
PETSC_INTERN PetscReal SlipFaultTolerancesFind(const SlipFaultTolerances *t, const char controller[],
                                               PetscReal accuracy);
PETSC_INTERN PetscReal SlipFaultTolerancesAccuracy(const SlipFaultTolerances *t, const char controller[],
                                                   PetscReal rtol);

/* steps.c: what controllers go by */
typedef struct {
  PetscInt kind;      /* row of the table of kinds of runs */
  const char *policy; /* whose default policy the kind takes */
  PetscBool learned;  /* rl is the default, and nobody has chosen it */
  PetscReal rtol;     /* that the fault, or a policy, has last set; another one is the user's */
  PetscBool given;    /* the user's counts, which is */
  PetscReal user_rtol;
  PetscReal accuracy;             /* that rtol was taken for; 0: it follows none */
  SlipFaultTolerances tolerances; /* without accuracies: nothing has needed them yet, or the kind has none */
} SlipFaultSteps;
PETSC_INTERN void SlipFaultChooseSteps(SlipFault fault, PetscBool is_explicit);
/* explicitsteps.c: is it one of those that explicit steps compute by default; the type, unless options name one, and
   its tolerance; does the run follow the accuracy, by the tolerance that the fault has set */
PETSC_INTERN PetscErrorCode SlipFaultExplicitIsDefault(SlipFault fault, TS ts, PetscBool *is);
PETSC_INTERN PetscErrorCode SlipFaultExplicitSteps(SlipFault fault, TS ts, char type[], size_t len, PetscReal *rtol);
PETSC_INTERN PetscErrorCode SlipFaultExplicitFollows(SlipFault fault, TS ts, PetscBool *follows);
/* powers between rows of two numbers, the first of which falls, and beyond them those of the ends */
PETSC_INTERN PetscReal SlipFaultBetween(PetscInt rows, const PetscReal row[][2], PetscReal x);
/* the error that nine in ten such runs stay below, or why it is not known */
PETSC_INTERN PetscErrorCode SlipFaultToleranceError(SlipFault fault, TS ts, PetscReal *error);
PETSC_INTERN PetscErrorCode SlipFaultExplicitEstimate(SlipFault fault, TS ts, PetscReal *error, const char **why);
/* cyclesteps.c: the same of friction whose cells always slide */
PETSC_INTERN PetscErrorCode SlipFaultCycleSteps(SlipFault fault, TS ts, PetscReal *rtol);
PETSC_INTERN PetscErrorCode SlipFaultCycleError(SlipFault fault, TS ts, PetscReal *error, const char **why);
PETSC_INTERN PetscErrorCode SlipFaultWarnOfSlowSlip(SlipFault fault, TS ts); /* startcheck.c */
PETSC_INTERN PetscErrorCode SlipFaultConfigureSteps(SlipFault fault, TS ts);
PETSC_INTERN PetscErrorCode SlipFaultBeginSteps(TS ts, PetscBool chosen, void *fault);
PETSC_INTERN PetscErrorCode SlipFaultHandOverSteps(TS ts, TSAdapt fallback, PetscReal accuracy, void *fault);
PETSC_INTERN PetscErrorCode SlipFaultReportSteps(SlipFault fault, TS ts);
PETSC_INTERN PetscErrorCode SlipFaultStepsResult(SlipFault fault, TS ts, SlipOutput run);
PETSC_INTERN PetscErrorCode SlipFaultStepsError(SlipFault fault, TS ts, PetscReal *relative);
/* corners.c */
PETSC_EXTERN PetscErrorCode SlipFaultNextCorner(TS ts, PetscReal t, PetscReal *next, void *fault);
/* faultconstraint.c */
PETSC_INTERN PetscErrorCode SlipFaultStoreStart(SlipFault fault, const SlipStage *stage); /* constraintknown.c */
PETSC_INTERN PetscErrorCode SlipFaultStoreEnd(SlipFault fault, Vec g, Vec x, Vec w);
PETSC_EXTERN PetscErrorCode SlipFaultConstraintCreate(SlipFault fault);
PETSC_EXTERN PetscErrorCode SlipFaultConstraintStage(SlipFault fault, const SlipStage *stage);
PETSC_EXTERN PetscErrorCode SlipFaultConstraintResidual(SlipFault fault, Vec x, Vec g);
PETSC_EXTERN PetscErrorCode SlipFaultConstraintLift(SlipFault fault, Vec x, Vec w);
PETSC_EXTERN PetscErrorCode SlipFaultSmooth(SlipFault fault, PetscReal t, Vec w, Vec F);
PETSC_EXTERN PetscErrorCode SlipFaultStrength(SlipFault fault, PetscReal t, Vec w, Vec q);
/* explicitkick.c */
PETSC_INTERN const SlipExplicitOps SlipFaultExplicitOps;
/* statecache.c */
PETSC_INTERN PetscErrorCode SlipFaultDisplacementUnchanged(SlipFault fault, PetscReal t, Vec u, PetscBool *same);
PETSC_INTERN PetscErrorCode SlipFaultForce(SlipFault fault, PetscReal t, Vec w, Vec u, Vec force);
PETSC_INTERN PetscErrorCode SlipFaultDamping(SlipFault fault, PetscReal t, Vec relative, Vec damping);
PETSC_INTERN PetscErrorCode SlipFaultSettledDestroy(SlipFault fault);
/* rest.c */
PETSC_EXTERN PetscErrorCode SlipFaultRestSetUp(SlipFault fault);
PETSC_EXTERN PetscErrorCode SlipFaultRest(TS ts, PetscReal t, PetscReal limit, Vec w, Vec half, Vec after,
                                          PetscReal *end, PetscReal *h, void *fault);
/* balance.c: faults whose cells always slide */
PETSC_EXTERN PetscErrorCode SlipFaultChooseDefaults(SlipFault fault);
PETSC_INTERN PetscErrorCode SlipFaultViscosityPrint(SlipFault fault);
PETSC_INTERN SlipFrictionCells SlipFaultCellFriction(SlipFault fault, const PetscReal stress[]);
PETSC_EXTERN PetscErrorCode SlipFaultBalanceSetUp(SlipFault fault);
PETSC_EXTERN PetscErrorCode SlipFaultBalanceStart(SlipFault fault, Vec w);
PETSC_EXTERN PetscErrorCode SlipFaultRates(SlipFault fault, PetscReal t, Vec w, Vec F); /* fault->balance.rate, and F */
PETSC_EXTERN PetscErrorCode SlipFaultPutRates(SlipFault fault, Vec w);
PETSC_EXTERN PetscBool SlipFaultRateWeakens(const SlipFrictionCells *friction, PetscInt i, PetscReal rate);
/* faultdevice.c: of states that are there, SlipFaultOnDevice() */
PETSC_INTERN PetscErrorCode SlipFaultDeviceChoose(SlipFault fault); /* devicechoice.c */
PETSC_INTERN PetscErrorCode SlipFaultDeviceRoom(SlipFault fault, PetscBool *room);
PETSC_INTERN PetscErrorCode SlipFaultDeviceSetUp(SlipFault fault);
PETSC_INTERN PetscErrorCode SlipFaultDeviceDestroy(SlipFault fault);
PETSC_INTERN PetscErrorCode SlipFaultDeviceOperators(SlipFault fault, Mat K, Mat Kn);
PETSC_INTERN PetscBool SlipFaultOnDevice(SlipFault fault, Vec w);
PETSC_INTERN PetscErrorCode SlipFaultDeviceMove(SlipFault fault, Vec w, PetscInt offset, PetscBool back, Vec x);
PETSC_INTERN PetscErrorCode SlipFaultDeviceFastest(SlipFault fault, Vec w, PetscReal *largest);
PETSC_INTERN PetscErrorCode SlipFaultDeviceShear(SlipFault fault, PetscReal t, Vec *shear);
PETSC_INTERN PetscErrorCode SlipFaultDeviceOpen(SlipFault fault, PetscReal t, PetscInt *opened);
PETSC_INTERN PetscBool SlipFaultDeviceBalances(SlipFault fault);
PETSC_INTERN PetscErrorCode SlipFaultDeviceRates(SlipFault fault, PetscReal t, Vec w, Vec F);
PETSC_INTERN PetscErrorCode SlipFaultDeviceOutside(SlipFault fault, Vec w, PetscReal displacement, PetscReal bound,
                                                   PetscInt *outside);
PETSC_INTERN PetscErrorCode SlipFaultDeviceCompliance(SlipFault fault, Vec w, PetscReal *most);
PETSC_INTERN PetscErrorCode SlipFaultDeviceSums(SlipFault fault, PetscReal t, Vec w, Vec force, PetscReal sum[],
                                                PetscReal *max_v);
PETSC_INTERN PetscErrorCode SlipFaultDevicePowers(SlipFault fault, PetscReal t, Vec w, PetscReal power[3]);
PETSC_INTERN PetscErrorCode SlipFaultDeviceShares(SlipFault fault, PetscReal t, Vec w, PetscReal friction[],
                                                  PetscReal rate[], PetscReal displacement[], PetscReal loading[]);
PETSC_INTERN PetscErrorCode SlipFaultDeviceBare(SlipFault fault, PetscReal t, Vec w, Vec bare, PetscInt *more,
                                                PetscReal *least);
PETSC_INTERN PetscErrorCode SlipFaultDeviceCells(SlipFault fault, PetscReal t, Vec w, struct _cl_mem **cells,
                                                 PetscBool *changes);
PETSC_INTERN PetscErrorCode SlipFaultDeviceLookCreate(SlipFault fault, PetscInt m, const PetscInt cell[],
                                                      SlipFaultDeviceLook *look);
PETSC_INTERN PetscErrorCode SlipFaultDeviceLookAt(SlipFault fault, PetscReal t, Vec w, SlipFaultDeviceLook *look);
PETSC_INTERN PetscErrorCode SlipFaultDeviceGroundCreate(SlipFault fault, PetscInt m, const PetscReal matrix[],
                                                        SlipFaultDeviceLook *look);
PETSC_INTERN PetscErrorCode SlipFaultDeviceGround(SlipFault fault, Vec w, Vec start, const SlipFaultDeviceLook *look,
                                                  PetscReal moved[], PetscReal moves[]);
PETSC_INTERN PetscErrorCode SlipFaultDeviceLookDestroy(SlipFault fault, SlipFaultDeviceLook *look);
PETSC_INTERN PetscErrorCode SlipFaultDeviceRupture(SlipFault fault, PetscInt nodes, const Vec node[],
                                                   const PetscReal share[], PetscReal begin, PetscReal dt, Vec rupture);
PETSC_INTERN PetscErrorCode SlipFaultDeviceCellVector(SlipFault fault, Vec *x);
PETSC_INTERN PetscErrorCode SlipFaultDeviceSlip(SlipFault fault, PetscReal dt, Vec w, Vec u, PetscReal *largest);
/* explicit.c */
PETSC_EXTERN PetscErrorCode SlipFaultExplicitConfigure(SlipFault fault, TS ts);
PETSC_EXTERN PetscErrorCode SlipFaultFinishStep(TS ts, PetscReal t, Vec w, void *fault);
PETSC_INTERN PetscErrorCode SlipFaultSidesAttach(SlipFault);
PETSC_EXTERN PetscErrorCode SlipFaultObservedState(SlipFault fault, TS ts, PetscReal t, Vec w, Vec *seen);
PETSC_EXTERN PetscErrorCode SlipFaultExplicitState(SlipFault fault, SlipState s, TS ts);
PETSC_EXTERN PetscErrorCode SlipFaultFirstStep(SlipFault fault, PetscReal *step); /* where all cells slide [s] */
PETSC_EXTERN PetscErrorCode SlipFaultBalanceDestroy(SlipFault fault);
PETSC_EXTERN PetscErrorCode SlipFaultSmoothTraction(SlipFault fault, PetscReal t, Vec w,
                                                    Vec r); /* -q sign(v), weighted */
/* sticking.c: explicit steps of friction whose cells stick */
PETSC_INTERN PetscErrorCode SlipFaultStickingTraction(SlipFault fault, PetscReal t, Vec w, Vec r);
/* Ends of a step of a length [s], as states */
typedef struct {
  Vec from, to;
  PetscReal dt;
} SlipFaultStickingStep;
PETSC_INTERN PetscErrorCode SlipFaultStickingPowers(SlipFault fault, PetscReal t, Vec w,
                                                    const SlipFaultStickingStep *step, PetscReal power[3],
                                                    PetscReal friction[]);
PETSC_INTERN PetscErrorCode SlipFaultStickingPush(SlipFault fault, PetscReal t, Vec w, Vec push);
PETSC_INTERN PetscErrorCode SlipFaultStickingTolerances(SlipFault fault, PetscReal rtol, PetscReal atol[]);
PETSC_INTERN PetscErrorCode SlipFaultBeginRest(SlipFault fault, TS ts);
PETSC_INTERN PetscErrorCode SlipFaultEndRest(SlipFault fault, TS ts);
/* stop.c */
PETSC_EXTERN PetscErrorCode SlipFaultStop(SlipFault fault, PetscReal h, PetscReal rtol, PetscReal share,
                                          const Vec state[3], Vec k0, PetscReal *stop);
/* tolerance.c */
PETSC_INTERN PetscReal SlipFaultSlipScale(SlipFault fault, const SlipFrictionCells *friction, PetscInt i,
                                          PetscReal displacement, PetscBool *weakens);
/* of that of a cell */
PETSC_INTERN PetscReal SlipFaultStickingScale(SlipFault fault, PetscReal scale, PetscBool weakens,
                                              PetscReal displacement);
PETSC_INTERN PetscErrorCode SlipFaultStickingErrorNorm(SlipFault fault, PetscReal rtol, PetscReal theta, Vec e, Vec w0,
                                                       Vec w1, PetscReal *E);
PETSC_INTERN PetscErrorCode SlipFaultLeastStiffness(SlipFault fault, PetscReal *stiffness);
PETSC_INTERN PetscErrorCode SlipFaultLargestDisplacement(SlipFault fault, Vec w, PetscReal *largest);
PETSC_EXTERN PetscErrorCode SlipFaultRunaway(SlipFault fault, PetscReal t, Vec w, PetscReal *ratio);
PETSC_EXTERN PetscErrorCode SlipFaultLoadTolerance(SlipFault fault, PetscReal relative, PetscReal t, Vec w,
                                                   PetscReal tolerance[]);
PETSC_EXTERN PetscErrorCode SlipFaultErrorNorm(SlipFault fault, PetscReal rtol, PetscReal t, PetscReal h, Vec e, Vec w0,
                                               Vec w1, PetscReal *E);
PETSC_EXTERN PetscErrorCode SlipFaultRestTime(TS ts, PetscReal t, Vec w, PetscReal *rest, void *fault);
