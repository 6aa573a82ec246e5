/* A fault as a problem of a TS: the constraint of a stage, the balance of faults that always slide, rest, tolerances
   and defaults */
#pragma once
#include <slipstep/rooms/slipfault.h>
#include <slipstep/rooms/slipcore.h>
#include <slipstep/private/slipfaultknown.h>
#include <slipstep/private/slipsnes.h>
#include <slipstep/private/slipstate.h>

/* balance.c */
typedef struct {
  PetscReal eta;      /* radiation damping [Pa s/m] */
  PetscReal rtol;     /* that on which the tolerances are based */
  PetscBool known;    /* rate is that of the last right-hand side */
  PetscReal time;     /* time of it [s] */
  PetscInt sides;     /* right-hand sides of the run so far */
  Vec F;              /* its rates, borrowed from the TS */
  Vec first;          /* those of the first step of a run that continues from a checkpoint; NULL: to be computed */
  Vec u, rate, force; /* its displacement [m], slip rate [m/s], and K u [Pa] */
  Vec aside[4];       /* work vectors for a state within a step, and its effect on normal stress */
  PetscInt64 put;     /* how often it was written into a state */
  PetscBool resting;  /* the step is one of rest, without a right-hand side: */
  Vec way, rested;    /* its constant rates, and the state at its end */
  PetscReal next;     /* the next step after it [s] */
  PetscReal fastest;  /* the largest slip rate before the last step [m/s] */
  PetscReal least;    /* smallest reference slip for the errors of cells [m] */
  PetscBool follows;  /* tolerances grow with the largest displacement, the reference slip: */
  PetscBool steady;   /* those of some cells grow because these do not weaken */
  PetscReal moved;    /* its value [m] */
  Vec seen;           /* end of an attempt with its rates, which a controller observes; NULL: none */
  PetscReal stiffest; /* largest eigenvalue of K [Pa/m]; 0: not computed */
  PetscBool *creeps;  /* [n] cells that slip at the loading rate; NULL: none */
  PetscReal *direct;  /* a sigma of each cell [Pa], dq/d ln |v|; NULL if kept is used */
  PetscReal *kept;    /* cached numbers of the law; NULL if the normal stress changes */
} SlipFaultBalance;

/* devicechoice.c, devicecells.c: where steps are computed, -fault_device */
typedef struct {
  struct _n_SlipDevice *device;                  /* NULL: on the processor */
  PetscReal bytes;                               /* upper bound of the memory of fault and integrator there */
  struct _cl_mem *cells;                         /* data of the cells for its kernels; NULL: not used yet */
  struct _cl_mem *pressure, *record, *distance2; /* [n] pore pressure [Pa], -fault_pore_pressure, of the source [m^2] */
  struct _cl_mem *faults;                        /* [n] index of the fault of each cell, if there are several */
  PetscBool loaded, pressed;                     /* the load, the pressure of the cells are up to date */
  PetscReal time, origin;                        /* time and origin of both [s] */
  SlipFaultMoment moment;                        /* of their normal stress, if slip changes it */
  Vec shear;                                     /* SlipFaultGetShear() at shear_time with the origin shear_origin */
  PetscReal shear_time, shear_origin;
  PetscBool automatic;    /* chosen by -fault_device auto, */
  char why[512];          /* reason why that uses the processor, else "" */
  PetscObjectId shear_id; /* of the processor's vector, if cells stick */
  PetscObjectState shear_state;
  Vec sticking; /* cached numbers of cells whose friction sticks; NULL until used */
} SlipFaultDevice;

/* faultconstraint.c: the present stage: u = u0 + theta v, s = s0 + theta |v|, B v = c + omega r */
typedef struct {
  SlipConstraint con;
  PetscReal time, theta; /* [s] */
  PetscBool last;        /* the last one of its step */
  Vec c, u0, s0;
} SlipFaultStage;

/* explicitkick.c: slip rates relative to the far field at the nodes of the last explicit step, and their damping; the
   elastic force at its start */
typedef struct {
  PetscBool known[SLIP_NUM_NODES], forced;
  PetscReal time[SLIP_NUM_NODES];                    /* [s] */
  Vec force;                                         /* [Pa], weighted by area; valid if forced */
  Vec rise;                                          /* Kn u of it, if slip changes normal stress [Pa] */
  Vec rate[SLIP_NUM_NODES], damping[SLIP_NUM_NODES]; /* [m/s], [Pa]; NULL before the first such step */
} SlipFaultSettled;

/* tolerancefile.c: relative tolerances by which controllers reach accuracies on a kind of faults, by group of a file */
enum { TOLERANCES_MOST = 16 }; /* largest number of controllers, and of accuracies */
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

/* steps.c: the basis of controllers */
typedef struct {
  PetscInt kind;      /* row of the table of kinds of runs */
  const char *policy; /* default policy of the kind */
  PetscBool learned;  /* rl is the default, and the user did not choose it */
  PetscReal rtol;     /* last set by the fault or a policy; another value is the user's */
  PetscBool given;    /* the user's value is used, user_rtol */
  PetscReal user_rtol;
  PetscReal accuracy;             /* for which rtol was chosen; 0: none */
  SlipFaultTolerances tolerances; /* without accuracies: not needed yet, or the kind has none */
} SlipFaultSteps;
PETSC_INTERN void SlipFaultChooseSteps(SlipFault fault, PetscBool is_explicit);
/* explicitsteps.c: is this a run with explicit steps by default; their type, unless options name one, and its
   tolerance; does the run follow the accuracy, by the tolerance of the fault */
PETSC_INTERN PetscErrorCode SlipFaultExplicitIsDefault(SlipFault fault, TS ts, PetscBool *is);
PETSC_INTERN PetscErrorCode SlipFaultExplicitSteps(SlipFault fault, TS ts, char type[], size_t len, PetscReal *rtol);
PETSC_INTERN PetscErrorCode SlipFaultExplicitFollows(SlipFault fault, TS ts, PetscBool *follows);
/* Interpolates by powers between rows of two numbers, the first of which decreases; beyond them those of the ends. */
PETSC_INTERN PetscReal SlipFaultBetween(PetscInt rows, const PetscReal row[][2], PetscReal x);
/* The error that nine in ten such runs do not exceed, or why it is unknown */
PETSC_INTERN PetscErrorCode SlipFaultToleranceError(SlipFault fault, TS ts, PetscReal *error);
PETSC_INTERN PetscErrorCode SlipFaultExplicitEstimate(SlipFault fault, TS ts, PetscReal *error, const char **why);
/* cyclesteps.c: the same for friction whose cells always slide */
PETSC_INTERN PetscErrorCode SlipFaultCycleSteps(SlipFault fault, TS ts, PetscReal *rtol);
PETSC_INTERN PetscErrorCode SlipFaultCycleError(SlipFault fault, TS ts, PetscReal *error, const char **why);
PETSC_INTERN PetscErrorCode SlipFaultWarnOfSlowSlip(SlipFault fault, TS ts); /* startcheck.c */
PETSC_INTERN PetscErrorCode SlipFaultConfigureSteps(SlipFault fault, TS ts);
PETSC_INTERN PetscErrorCode SlipFaultBeginSteps(TS ts, PetscBool chosen, void *fault);
PETSC_INTERN PetscErrorCode SlipFaultHandOverSteps(TS ts, TSAdapt fallback, PetscReal accuracy, void *fault);
PETSC_INTERN PetscErrorCode SlipFaultReportSteps(SlipFault fault, TS ts);
PETSC_INTERN PetscErrorCode SlipFaultStepsResult(SlipFault fault, TS ts, SlipOutput run);
PETSC_INTERN PetscErrorCode SlipFaultStepsError(SlipFault fault, TS ts, PetscReal *relative);
/* stepends.c */
PETSC_EXTERN PetscErrorCode SlipFaultNextCorner(TS ts, PetscReal t, PetscReal *next, void *fault);
PETSC_INTERN PetscErrorCode SlipFaultLimitStep(SlipFault fault, TS ts);
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
PETSC_INTERN PetscReal SlipFaultFirstStateRate(SlipFault fault, PetscInt i, const PetscReal a[], PetscReal speed);
PETSC_INTERN PetscReal SlipFaultFrictionChange(SlipFault fault, PetscInt i);
PETSC_EXTERN PetscErrorCode SlipFaultBalanceSetUp(SlipFault fault);
PETSC_EXTERN PetscErrorCode SlipFaultBalanceStart(SlipFault fault, Vec w);
PETSC_EXTERN PetscErrorCode SlipFaultRates(SlipFault fault, PetscReal t, Vec w, Vec F); /* fault->balance.rate, and F */
PETSC_EXTERN PetscErrorCode SlipFaultPutRates(SlipFault fault, Vec w);
PETSC_EXTERN PetscBool SlipFaultRateWeakens(const SlipFrictionCells *friction, PetscInt i, PetscReal rate);
/* devicechoice.c; devicecells.c, for states on the device, SlipFaultOnDevice() */
PETSC_INTERN PetscErrorCode SlipFaultDeviceChoose(SlipFault fault); /* devicechoice.c */
PETSC_INTERN PetscErrorCode SlipFaultDeviceRoom(SlipFault fault, PetscBool *room);
PETSC_INTERN PetscErrorCode SlipFaultDeviceSetUp(SlipFault fault);
PETSC_INTERN PetscErrorCode SlipFaultDeviceView(SlipFault fault, PetscViewer viewer);
PETSC_INTERN void SlipFaultDeviceTraffic(PetscInt64 traffic[3]);
PETSC_INTERN PetscErrorCode SlipFaultDeviceDestroy(SlipFault fault);
PETSC_INTERN PetscErrorCode SlipFaultDeviceOperators(SlipFault fault, Mat K, Mat Kn);
PETSC_INTERN PetscBool SlipFaultOnDevice(SlipFault fault, Vec w);
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
PETSC_INTERN PetscErrorCode SlipFaultDevicePut(SlipFault fault, size_t n, const PetscReal from[], const char what[],
                                               struct _cl_mem **to);
PETSC_INTERN PetscErrorCode SlipFaultDeviceCells(SlipFault fault, PetscReal t, Vec w, struct _cl_mem **cells,
                                                 PetscBool *changes);
PETSC_INTERN PetscErrorCode SlipFaultDeviceSlip(SlipFault fault, PetscReal dt, Vec w, Vec u, PetscReal *largest);
/* explicit.c */
PETSC_EXTERN PetscErrorCode SlipFaultExplicitConfigure(SlipFault fault, TS ts);
PETSC_EXTERN PetscErrorCode SlipFaultFinishStep(TS ts, PetscReal t, Vec w, void *fault);
PETSC_INTERN PetscErrorCode SlipFaultSidesAttach(SlipFault);
PETSC_EXTERN PetscErrorCode SlipFaultObservedState(SlipFault fault, TS ts, PetscReal t, Vec w, Vec *seen);
PETSC_EXTERN PetscErrorCode SlipFaultExplicitState(SlipFault fault, SlipState s, TS ts);
PETSC_EXTERN PetscErrorCode SlipFaultFirstStep(SlipFault fault, PetscReal *step); /* if all cells slide [s] */
PETSC_EXTERN PetscErrorCode SlipFaultBalanceDestroy(SlipFault fault);
PETSC_EXTERN PetscErrorCode SlipFaultSmoothTraction(SlipFault fault, PetscReal t, Vec w,
                                                    Vec r); /* -q sign(v), weighted */
/* sticking.c: explicit steps of friction whose cells stick */
PETSC_INTERN PetscErrorCode SlipFaultStickingTraction(SlipFault fault, PetscReal t, Vec w, Vec r);
/* Start and end of a step of a length [s], as states */
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
/* stepends.c */
PETSC_EXTERN PetscErrorCode SlipFaultStop(SlipFault fault, PetscReal h, PetscReal rtol, PetscReal share,
                                          const Vec state[3], Vec k0, PetscReal *stop);
/* tolerance.c */
PETSC_INTERN PetscReal SlipFaultSlipScale(SlipFault fault, const SlipFrictionCells *friction, PetscInt i,
                                          PetscReal displacement, PetscBool *weakens);
/* Scale of a cell's slip */
PETSC_INTERN PetscReal SlipFaultStickingScale(SlipFault fault, PetscReal scale, PetscBool weakens,
                                              PetscReal displacement);
PETSC_INTERN PetscErrorCode SlipFaultStickingErrorNorm(SlipFault fault, PetscReal rtol, PetscReal theta, Vec e, Vec w0,
                                                       Vec w1, PetscReal *E);
PETSC_INTERN PetscErrorCode SlipFaultLeastStiffness(SlipFault fault, PetscReal *stiffness);
PETSC_INTERN PetscErrorCode SlipFaultLargestDisplacement(SlipFault fault, Vec w, PetscReal *largest);
PETSC_EXTERN PetscErrorCode SlipFaultRunaway(SlipFault fault, PetscReal t, Vec w, PetscReal *ratio);
PETSC_EXTERN PetscErrorCode SlipFaultLoadTolerance(SlipFault fault, PetscReal relative, PetscReal t, Vec w,
                                                   PetscReal pressure[], PetscReal shear[]);
PETSC_EXTERN PetscErrorCode SlipFaultErrorNorm(SlipFault fault, PetscReal rtol, PetscReal t, PetscReal h, Vec e, Vec w0,
                                               Vec w1, PetscReal *E);
PETSC_EXTERN PetscErrorCode SlipFaultRestTime(TS ts, PetscReal t, Vec w, PetscReal *rest, void *fault);
