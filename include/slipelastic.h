/* The medium around a fault: the stress that slip causes there. SlipElastic is a class; its types are tables of
   operations. */
#pragma once
#include <petscmat.h>
#include <slipsys.h>

/*
   The balance on the fault is M dv/dt = -f(u, v, t) + T + r. For the displacement u and the slip rate v, both relative
   to the far field, the medium computes the resisting stress f(u, v, t) and the change of normal stress. The stress is
   affine,
      f(u, v, t) = f(u, t) + (df/dv) v,
   and f(u, t) may depend on the history of slip. The type "static" has f = K u + H v, without a history.
   Vectors of slip and of shear stress have 1, 2 or 3 numbers per cell, those of normal stress one; rows of stress are
   weighted as the stiffness is (by areas over their mean).

   A medium with memory stores its history in two slots. Slot 1 is that of the start of the step or, within a step of
   several parts, that of the start of the last part, and then slot 0 is that of the start of the step. A trial state
   (u, t) follows from slot 1, or from slot 0 if t is before slot 1: SlipElasticFindPast(). Trial states change nothing.
*/
typedef struct _p_SlipElastic *SlipElastic;
PETSC_EXTERN PetscClassId SLIP_ELASTIC_CLASSID;
#define SLIPELASTICSTATIC "static"
#define SLIPELASTICWAVES "waves"

/* A state in the history */
typedef struct {
  PetscReal t; /* [s] */
  Vec u;       /* [m] */
} SlipElasticPast;

/* A plane with equal cells, row after row from its upper edge down; a single column is an antiplane line. */
typedef struct {
  PetscInt nx, nz;       /* cells along strike and down dip */
  PetscReal size[2];     /* of a cell [m] */
  PetscReal depth_top;   /* of the upper edge [m] */
  PetscBool full_space;  /* there is no free surface */
  PetscBool mirror;      /* the image of slip in a full space stands for the free surface */
  const PetscReal *rake; /* of slip with one component [cells of this process] [deg]; NULL: 0; borrowed, during setup */
} SlipElasticGrid;
/* The cells of an antiplane line are at least this much longer than the line. */
#define SLIP_WAVE_ENDLESS 100

/* Properties of the rock */
typedef struct {
  PetscReal shear_modulus, poisson_ratio, density; /* [Pa], [1], [kg/m^3] */
  PetscReal mass;                           /* rho Ly, for M and for the square root H = 2 zeta (M K)^(1/2) [kg/m^2] */
  PetscBool inertia;                        /* the balance contains M */
  const char *viscosity;                    /* "radiation" or a type of MatCreateSlipViscosity() */
  PetscReal zeta;                           /* damping ratio; 0: no viscosity, unless it is "radiation" */
  PetscReal impedance;                      /* of radiation, G/(2 cs) [Pa s/m] */
  PetscReal across;                         /* impedance of opening, rho cp/2 [Pa s/m]; 0: cells do not open */
  PetscReal tolerance;                      /* relative tolerance of products with a viscosity by Lanczos' method */
  PetscReal waves_tolerance, waves_padding; /* type "waves": tolerance of kernels, period over length */
  PetscInt components;                      /* components of slip per cell */
  const SlipElasticGrid *grid;              /* NULL: the cells are not a grid; borrowed, during setup */
  const PetscInt *order; /* [cells] numbers, the same on any number of processes; NULL: rows; borrowed */
  Vec along;             /* stress of 1 Pa along the rake of each cell, in rows of stress; borrowed, during setup */
} SlipElasticRock;

/* A type. Where a function is NULL, that of "static" is used, which works with the matrices of
   SlipElasticSetStiffness(); if it has none either, nothing is done. All functions are collective. */
typedef struct {
  PetscErrorCode (*setup)(SlipElastic, const SlipElasticRock *rock); /* called when the matrices exist */
  /* shear = f(u, v, t) [Pa], normal = increase of compression [Pa]; u NULL: shear = (df/dv) v only; v NULL: v = 0;
     either output may be NULL */
  PetscErrorCode (*force)(SlipElastic, PetscReal t, Vec u, Vec v, Vec shear, Vec normal);
  /* Matrices of a stage that ends at t, where u = u0 + theta v: B(theta) = M/theta + df/dv + theta df/du [Pa s/m] and C
     = d normal/du [Pa/m], NULL: 0; both are borrowed until the next stage. */
  PetscErrorCode (*stage)(SlipElastic, PetscReal t, PetscReal theta, Mat *B, Mat *C);
  /* Energy besides u.f(u, t)/2 and dissipation besides v.(df/dv) v, of the cells of this process [J/m^2, W/m^2] */
  PetscErrorCode (*energy)(SlipElastic, PetscReal t, Vec u, PetscReal *stored);
  PetscErrorCode (*power)(SlipElastic, PetscReal t, Vec u, Vec v,
                          PetscReal *lost); /* part of /series/viscous_power; < 0: gained */
  /* For media with memory. advance() sets the history of slot `to` from that of slot `from`, which may be the same,
     along the way to u at t; from -1: there is no history. SlipElasticGetPast() gives times and displacements of the
     slots before the change. Without copy() the medium stores only whole steps, and slot 0 is unused. */
  PetscErrorCode (*advance)(SlipElastic, PetscInt from, PetscInt to, PetscReal t, Vec u);
  PetscErrorCode (*copy)(SlipElastic, PetscInt from, PetscInt to);
  /* Visits the history of both slots to write or read a checkpoint, and all else that a run depends on in any medium.
     */
  PetscErrorCode (*visit)(SlipElastic, SlipState);
  /* An upper bound of the largest frequency of mass^-1 df/du [rad/s]; NULL: products with df/du find it */
  PetscErrorCode (*frequency)(SlipElastic, PetscReal *omega);
  PetscErrorCode (*view)(SlipElastic, PetscViewer);
  PetscErrorCode (*destroy)(SlipElastic);
  /* f depends only on u and v, neither on t, even linearly, nor on history, so that the loads of a fault alone decide
     how long it sticks, and times at rest are skipped without a solve. "static" sets it. */
  PetscBool rests;
  /* The longest step in which slip changes stress only at its own cell [s]; NULL: 0 */
  PetscErrorCode (*shortest)(SlipElastic, PetscReal *step);
  PetscBool loads; /* it loads the fault by itself, for example by growing stress: steps are those of a loaded fault */
  /* From when until when after slip [s] stress may arrive that only the numerical method causes, as from periodic
     images; NULL: never */
  PetscErrorCode (*images)(SlipElastic, PetscReal *first, PetscReal *last);
} SlipElasticOps;

PETSC_EXTERN PetscErrorCode SlipElasticRegister(const char name[], PetscErrorCode (*create)(SlipElastic));
/* ---- life cycle ---- */
PETSC_EXTERN PetscErrorCode SlipElasticCreate(MPI_Comm comm, SlipElastic *el);
PETSC_EXTERN PetscErrorCode SlipElasticSetType(SlipElastic el, const char type[]);
PETSC_EXTERN PetscErrorCode SlipElasticSetOps(SlipElastic el, const SlipElasticOps *ops, void *data); /* for types */
PETSC_EXTERN PetscErrorCode SlipElasticGetData(SlipElastic el, void *data);                           /* for types */
PETSC_EXTERN PetscErrorCode SlipElasticSetStiffness(SlipElastic el, Mat K, Mat Kn);
PETSC_EXTERN PetscErrorCode SlipElasticSetUp(SlipElastic el, const SlipElasticRock *rock);
PETSC_EXTERN PetscErrorCode SlipElasticGetMatrices(SlipElastic el, Mat *K, Mat *Kn, Mat *H); /* for inspection */
PETSC_EXTERN PetscErrorCode SlipElasticView(SlipElastic el, PetscReal theta, PetscViewer viewer);
PETSC_EXTERN PetscErrorCode SlipElasticDestroy(SlipElastic *el);
/* ---- evaluation ---- */
PETSC_EXTERN PetscErrorCode SlipElasticForce(SlipElastic el, PetscReal t, Vec u, Vec v, Vec shear, Vec normal);
PETSC_EXTERN PetscErrorCode SlipElasticForceStatic(SlipElastic el, PetscReal t, Vec u, Vec v, Vec shear, Vec normal);
PETSC_EXTERN PetscErrorCode SlipElasticStage(SlipElastic el, PetscReal t, PetscReal theta);
PETSC_EXTERN PetscErrorCode SlipElasticGetStage(SlipElastic el, Mat *B, Mat *C);
PETSC_EXTERN PetscErrorCode SlipElasticSolve(SlipElastic el, Vec b, Vec x); /* K x = b */
PETSC_EXTERN PetscErrorCode SlipElasticGetEnergy(SlipElastic el, PetscReal t, Vec u, PetscReal *stored);
/* ---- history ---- */
PETSC_EXTERN PetscErrorCode SlipElasticFindPast(SlipElastic el, PetscReal t, PetscInt *slot);
PETSC_EXTERN PetscErrorCode SlipElasticGetPast(SlipElastic el, PetscInt slot, SlipElasticPast *past);
