/* The medium around a fault: what slip does to the stress there. A class whose types are tables of operations. */
#pragma once
#include <petscmat.h>
#include <slipsys.h>

/*
   The balance on the fault is M dv/dt = -f(u, v, t) + T + r. Of displacement u and slip rate v, both relative to the
   far field, the medium answers with the stress f(u, v, t) that resists, and with what it adds to the normal stress. It
   is affine,
      f(u, v, t) = f(u, t) + (df/dv) v,
   and what depends on the history of slip, if anything does, is in f(u, t). "static" has f = K u + H v, and no history.
   Vectors of slip and of shear stress have 1, 2 or 3 numbers a cell, those of normal stress one; rows of stress count
   by the weights of the stiffness (areas over their mean).

   A medium that remembers keeps two slots of history. Slot 1 is that of the step's start; within a step of several
   parts that of the start of the last part, and slot 0 that of the step's. A trial state (u, t) follows from slot 1, or
   where t is before it from slot 0: SlipElasticFindPast(). Asking for trial states changes nothing.
*/
typedef struct _p_SlipElastic *SlipElastic;
PETSC_EXTERN PetscClassId SLIP_ELASTIC_CLASSID;
#define SLIPELASTICSTATIC "static"
#define SLIPELASTICWAVES "waves"

/* A state that the history has come by */
typedef struct {
  PetscReal t; /* [s] */
  Vec u;       /* [m] */
} SlipElasticPast;

/* One plane with equal cells, row after row from its upper edge on; one column: an antiplane line */
typedef struct {
  PetscInt nx, nz;       /* cells along strike and down dip */
  PetscReal size[2];     /* of a cell [m] */
  PetscReal depth_top;   /* of the upper edge [m] */
  PetscBool full_space;  /* there is no ground */
  const PetscReal *rake; /* [cells of this process] of slip with one component [deg]; NULL: 0; borrowed, during setup */
} SlipElasticGrid;
/* An antiplane line's cells are this much longer than the line, at least */
#define SLIP_WAVE_ENDLESS 100

/* What the rock is like */
typedef struct {
  PetscReal shear_modulus, poisson_ratio, density; /* [Pa], [1], [kg/m^3] */
  PetscReal mass;                           /* rho Ly, of M and of the square root H = 2 zeta (M K)^(1/2) [kg/m^2] */
  PetscBool inertia;                        /* M is in the balance */
  const char *viscosity;                    /* "radiation" or a type of MatCreateSlipViscosity() */
  PetscReal zeta;                           /* damping ratio; 0: no viscosity, unless that is "radiation" */
  PetscReal impedance;                      /* of radiation, G/(2 cs) [Pa s/m] */
  PetscReal across;                         /* of what opens cells, rho cp/2 [Pa s/m]; 0: cells do not open */
  PetscReal tolerance;                      /* relative, of products with a viscosity by Lanczos' method */
  PetscReal waves_tolerance, waves_padding; /* of the type waves: of its kernels, and the period over the length */
  PetscInt components;                      /* of slip in each cell */
  const SlipElasticGrid *grid;              /* NULL: the cells are no grid; borrowed, during setup */
  const PetscInt *order; /* [cells] a number of each that no distribution changes; NULL: its row; borrowed likewise */
  Vec along;             /* stress of 1 Pa along the rake of each cell, in rows of stress; borrowed, during setup */
} SlipElasticRock;

/* A type. Any function may be NULL: then that of static takes its place, which works with the matrices of
   SlipElasticSetStiffness(), and where static has none, nothing is done. All are collective. */
typedef struct {
  PetscErrorCode (*setup)(SlipElastic, const SlipElasticRock *rock); /* after the matrices are there */
  /* shear = f(u, v, t) [Pa], normal: what is added to compression [Pa]; u NULL: shear = (df/dv) v alone; v NULL: v = 0;
     either output may be NULL */
  PetscErrorCode (*force)(SlipElastic, PetscReal t, Vec u, Vec v, Vec shear, Vec normal);
  /* B(theta) = M/theta + df/dv + theta df/du [Pa s/m] of a stage that ends at t, in which u = u0 + theta v, and C =
     d normal/du there [Pa/m], NULL: 0; both borrowed, until the next stage */
  PetscErrorCode (*stage)(SlipElastic, PetscReal t, PetscReal theta, Mat *B, Mat *C);
  /* Energy besides u.f(u, t)/2, and what is lost besides v.(df/dv) v; of the cells of this process [J/m^2, W/m^2] */
  PetscErrorCode (*energy)(SlipElastic, PetscReal t, Vec u, PetscReal *stored);
  PetscErrorCode (*power)(SlipElastic, PetscReal t, Vec u, Vec v,
                          PetscReal *lost); /* in /series/viscous_power; < 0: received */
  /* Of media that remember. The history of slot to from that of slot from, of the same number or not, by the way to u
     at t; from -1: nothing was before. The slots' times and displacements are those of SlipElasticGetPast(), before the
     change. Without copy it remembers whole steps alone, and slot 0 is not used. */
  PetscErrorCode (*advance)(SlipElastic, PetscInt from, PetscInt to, PetscReal t, Vec u);
  PetscErrorCode (*copy)(SlipElastic, PetscInt from, PetscInt to);
  /* The history of both slots, for checkpoints, in both directions; of any medium, what else of it a run depends on */
  PetscErrorCode (*visit)(SlipElastic, SlipState);
  /* The largest frequency of mass^-1 df/du, from above [rad/s]; NULL: found by products with df/du */
  PetscErrorCode (*frequency)(SlipElastic, PetscReal *omega);
  PetscErrorCode (*view)(SlipElastic, PetscViewer);
  PetscErrorCode (*destroy)(SlipElastic);
  /* f depends on u and v alone, neither on t, be it linearly, nor on the past: until when a fault sticks then follows
     from its own loads, and quiet times are skipped without a solve. static sets it */
  PetscBool rests;
  /* The longest step within which slip is known to change stress but where it is [s]; NULL: 0 */
  PetscErrorCode (*shortest)(SlipElastic, PetscReal *step);
  PetscBool loads; /* it loads the fault by itself, as by a stress that grows: steps are those of a loaded fault */
  /* From when until when, after slip, stress may come that only the method makes, as of periodic images [s]; NULL:
     never */
  PetscErrorCode (*images)(SlipElastic, PetscReal *first, PetscReal *last);
} SlipElasticOps;

PETSC_EXTERN PetscErrorCode SlipElasticInitializePackage(void); /* called by what creates objects; again does nothing */
PETSC_EXTERN PetscErrorCode SlipElasticRegister(const char name[], PetscErrorCode (*create)(SlipElastic));
PETSC_EXTERN PetscErrorCode SlipElasticListTypes(char names[], size_t len); /* "|static|...|" */
/* ---- its life ---- */
PETSC_EXTERN PetscErrorCode SlipElasticCreate(MPI_Comm comm, SlipElastic *el);
PETSC_EXTERN PetscErrorCode SlipElasticSetType(SlipElastic el, const char type[]);
PETSC_EXTERN PetscErrorCode SlipElasticSetOps(SlipElastic el, const SlipElasticOps *ops, void *data); /* by types */
PETSC_EXTERN PetscErrorCode SlipElasticGetData(SlipElastic el, void *data);                           /* likewise */
PETSC_EXTERN PetscErrorCode SlipElasticSetStiffness(SlipElastic el, Mat K, Mat Kn);
PETSC_EXTERN PetscErrorCode SlipElasticScale(SlipElastic el, PetscReal factor);
PETSC_EXTERN PetscErrorCode SlipElasticSetUp(SlipElastic el, const SlipElasticRock *rock);
PETSC_EXTERN PetscErrorCode SlipElasticGetMatrices(SlipElastic el, Mat *K, Mat *Kn, Mat *H); /* to look at */
PETSC_EXTERN PetscErrorCode SlipElasticView(SlipElastic el, PetscReal theta, PetscViewer viewer);
PETSC_EXTERN PetscErrorCode SlipElasticDestroy(SlipElastic *el);
/* ---- what it answers ---- */
PETSC_EXTERN PetscErrorCode SlipElasticForce(SlipElastic el, PetscReal t, Vec u, Vec v, Vec shear, Vec normal);
PETSC_EXTERN PetscErrorCode SlipElasticForceStatic(SlipElastic el, PetscReal t, Vec u, Vec v, Vec shear, Vec normal);
PETSC_EXTERN PetscErrorCode SlipElasticViscous(SlipElastic el, Vec v, PetscReal tolerance, Vec stress);
PETSC_EXTERN PetscErrorCode SlipElasticStage(SlipElastic el, PetscReal t, PetscReal theta);
PETSC_EXTERN PetscErrorCode SlipElasticGetStage(SlipElastic el, Mat *B, Mat *C);
PETSC_EXTERN PetscErrorCode SlipElasticApplyStage(SlipElastic el, Vec x, Vec y);
PETSC_EXTERN PetscErrorCode SlipElasticForget(SlipElastic el);
PETSC_EXTERN PetscErrorCode SlipElasticStore(SlipElastic el, Vec x, Vec kx);
PETSC_EXTERN PetscErrorCode SlipElasticStoreStage(SlipElastic el, Vec x, Vec bx);
PETSC_EXTERN PetscErrorCode SlipElasticStoreSum(SlipElastic el, Vec y, PetscInt n, const PetscReal a[], const Vec x[]);
PETSC_EXTERN PetscErrorCode SlipElasticApply(SlipElastic el, Vec x, Vec shear,
                                             Vec normal);                   /* K x, Kn x: of slow slip */
PETSC_EXTERN PetscErrorCode SlipElasticSolve(SlipElastic el, Vec b, Vec x); /* K x = b */
PETSC_EXTERN PetscErrorCode SlipElasticIsIndefinite(SlipElastic el, PetscInt products, Vec b, Vec x, PetscBool *is);
PETSC_EXTERN PetscErrorCode SlipElasticGetDiagonals(SlipElastic el, Vec *k, Vec *h); /* of K and df/dv, borrowed */
PETSC_EXTERN PetscErrorCode SlipElasticGetImpedance(SlipElastic el, PetscReal *eta);
PETSC_EXTERN PetscErrorCode SlipElasticGetEnergy(SlipElastic el, PetscReal t, Vec u, PetscReal *stored);
PETSC_EXTERN PetscErrorCode SlipElasticGetPower(SlipElastic el, PetscReal t, Vec u, Vec v, PetscReal *lost);
PETSC_EXTERN PetscErrorCode SlipElasticGetFrequency(SlipElastic el, PetscReal *omega);
PETSC_EXTERN PetscErrorCode SlipElasticGetFoundFrequency(SlipElastic el, PetscReal *omega);
/* ---- its history ---- */
PETSC_EXTERN PetscErrorCode SlipElasticRests(SlipElastic el, PetscBool *rests);
PETSC_EXTERN PetscErrorCode SlipElasticLoads(SlipElastic el, PetscBool *loads);
PETSC_EXTERN PetscErrorCode SlipElasticGetShortestStep(SlipElastic el, PetscReal *step);
PETSC_EXTERN PetscErrorCode SlipElasticGetImages(SlipElastic el, PetscReal *first, PetscReal *last);
PETSC_EXTERN PetscErrorCode SlipElasticRemembers(SlipElastic el, PetscBool *remembers);
PETSC_EXTERN PetscErrorCode SlipElasticAccept(SlipElastic el, PetscReal t, Vec u, PetscBool first);
PETSC_EXTERN PetscErrorCode SlipElasticAdvance(SlipElastic el, PetscReal t, Vec u);
PETSC_EXTERN PetscErrorCode SlipElasticRollBack(SlipElastic el);
PETSC_EXTERN PetscErrorCode SlipElasticFindPast(SlipElastic el, PetscReal t, PetscInt *slot);
PETSC_EXTERN PetscErrorCode SlipElasticGetPast(SlipElastic el, PetscInt slot, SlipElasticPast *past);
PETSC_EXTERN PetscErrorCode SlipElasticVisit(SlipElastic el, SlipState state);
