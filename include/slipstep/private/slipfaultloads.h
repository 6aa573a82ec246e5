/* The loads of a fault: shear load and effective normal stress as functions of time */
#pragma once
#include <slipstep/rooms/slipfault.h>
#include <slipstep/private/slipfaultwells.h>

/* The point source of -fault_injection */
typedef struct {
  PetscReal *distance2;                  /* [n] squared distance of the cells from it [m^2]; NULL: there is none */
  PetscReal pressure, diffusivity, stop; /* [Pa], [m^2/s], [s] */
  PetscReal time;                        /* smallest distance2/(4 D) [s] */
} SlipFaultSource;

/* The course of a stress in time: a dimensionless function */
typedef struct SlipLoadTerm SlipLoadTerm;
typedef struct {
  PetscReal (*value)(const SlipLoadTerm *term, PetscReal t);
  PetscReal (*end)(const SlipLoadTerm *term, PetscReal t);   /* the next time after t where it begins or ends */
  PetscReal (*scale)(const SlipLoadTerm *term, PetscReal t); /* its period, or the like, at t; PETSC_MAX_REAL: none */
  PetscBool once;                                            /* it starts one event at most */
} SlipCourse;

/* A stress in time: a course times fields */
struct SlipLoadTerm {
  char *name;
  const SlipCourse *course;
  PetscInt rows;             /* of a record */
  PetscReal *times, *values; /* [rows] [s], dimensionless */
  PetscReal period, phase;   /* of a tide [s], as a fraction of the period */
  PetscReal duration;        /* of a nucleation [s] */
  PetscReal *shear, *normal; /* [n][components] along slip, [n], positive in compression [Pa]; NULL: 0 */
  PetscReal largest[2];      /* of all cells, of |shear| and |normal| [Pa] */
};

/* A record of -fault_stress_history or SlipFaultAddStress() before the set-up; arrays of all cells */
typedef struct {
  char *name;
  PetscInt rows, nshear, nnormal; /* numbers of shear and normal: 0, 1, one a cell, or of shear two a cell */
  PetscReal *times, *values, *shear, *normal;
} SlipStressRecord;

typedef struct {
  SlipFault fault;                                    /* the fault with these loads */
  PetscInt n;                                         /* its cells on this process */
  const PetscReal *weight, *traction, *rate, *normal; /* [n] borrowed: area over mean area, T0, dT/dt, normal stress */
  PetscReal origin;                                   /* origin of the times (TSGetSlipOrigin()) [s] */
  PetscBool shears;                                   /* there is a shear load, or cells open */
  PetscBool grows;                                    /* it changes in time */
  PetscBool pore;                                     /* there is a pore pressure */
  PetscBool pressed;                                  /* that, or a term, changes the normal stress in time */
  PetscInt rows;                                      /* of -fault_pore_pressure */
  PetscReal *times, *record;                          /* [rows] [s], [rows][n] [Pa] */
  PetscInt nterms, ngiven;
  SlipLoadTerm *terms;     /* [nterms] stresses in time */
  SlipStressRecord *given; /* [ngiven] of SlipFaultAddStress() */
  PetscInt ncorners;
  PetscReal *corners; /* [ncorners] times of all records, ascending [s] */
  PetscReal soft;     /* stiffness of the fault as a whole [Pa/m]; 0: not computed */
  SlipFaultSource source;
  PetscInt nwells;
  SlipFaultWell *wells;         /* [nwells] of -fault_wells, the same on all processes but for their cells */
  SlipFaultPressureFn function; /* of SlipFaultSetPressureFunction(), with its context and its [n] values */
  void *ctx;
  PetscReal *own;
  PetscBool passed;          /* the message that steps pass the periods of a term was printed */
  PetscBool opened;          /* the message that cells have no strength was printed */
  Vec drive, hold;           /* at rest: rate of the load, K v_inf + w dT/dt [Pa/s]; H v_inf [Pa] */
  PetscBool drives;          /* drive is not 0 everywhere */
  Vec pull;                  /* K v_inf [Pa/s]; NULL until SlipFaultRestSetUp() */
  PetscReal fastest_healing; /* largest 1/t_h [1/s] */
} SlipFaultLoads;

/* The loads at a time; zero before the first SlipLoadsEvaluate() */
typedef struct {
  PetscReal time, origin; /* [s] */
  Vec shear; /* w (T0 + t dT/dt + terms), w: weights [Pa], of cells that open followed by -w bare; NULL: always zero */
  const PetscReal *stress; /* [n] effective normal stress before any slip, at least 0 [Pa] */
  const PetscReal *bare;   /* [n] the same without the lower bound */
  PetscReal *own;          /* [2][n] both, unless they are those of the field */
} SlipFaultLoad;

/* Times from here on are after t: a step that ends at a corner may miss it by rounding. */
static inline PetscReal SlipTimeAfter(PetscReal t)
{
  return t + (PetscReal)1e-12 * PetscAbsReal(t);
}

static inline PetscBool SlipLoadsVary(const SlipFaultLoads *loads)
{
  return loads->shears || loads->pressed ? PETSC_TRUE : PETSC_FALSE;
}

/* Does a load change in time other than at a constant rate? */
static inline PetscBool SlipLoadsChange(const SlipFaultLoads *loads)
{
  return loads->pressed || loads->nterms ? PETSC_TRUE : PETSC_FALSE;
}

PETSC_EXTERN PetscErrorCode SlipLoadsEvaluate(const SlipFaultLoads *loads, PetscReal t, SlipFaultLoad *out);
PETSC_EXTERN PetscErrorCode SlipLoadDestroy(SlipFaultLoad *load);
/* pressures.c */
PETSC_INTERN PetscErrorCode SlipLoadsPressuresSetUp(SlipFaultLoads *loads);
PETSC_INTERN PetscErrorCode SlipLoadsPressuresDestroy(SlipFault fault);
PETSC_EXTERN PetscErrorCode SlipLoadsPressures(const SlipFaultLoads *loads, PetscReal t, PetscBool diffusing,
                                               PetscReal p[]);
PETSC_INTERN PetscReal SlipLoadsPressuresEnd(const SlipFaultLoads *loads, PetscReal t);
PETSC_INTERN PetscReal SlipLoadsPressuresScale(const SlipFaultLoads *loads, PetscReal t, PetscReal duration);
PETSC_INTERN PetscErrorCode SlipLoadsOwnPressure(const SlipFaultLoads *loads, PetscReal t); /* loads->own */
PETSC_INTERN PetscInt SlipLoadsInterval(const SlipFaultLoads *loads, PetscReal t, PetscReal *share);
PETSC_INTERN void SlipLoadsAddRecord(const SlipFaultLoads *loads, PetscReal t, PetscReal p[]);
PETSC_INTERN PetscInt SlipLoadsCornerAfter(const SlipFaultLoads *loads, PetscReal t); /* its number; ncorners: none */
PETSC_INTERN PetscReal SlipLoadsNextEnd(const SlipFaultLoads *loads, PetscReal t);    /* of a source, well, course */
/* terms.c: the row of a record before t, and the share of the way from it to the next one; constant beyond the ends */
PETSC_INTERN PetscInt SlipRecordInterval(PetscInt rows, const PetscReal times[], PetscReal t, PetscReal *share);
/* Add terms at t to shear [n][components], times weight [n] unless that is NULL, and subtract their normal
   stress from p [n]; records: those of records alone; shear, p: NULL, not wanted */
PETSC_INTERN void SlipLoadsAddTerms(const SlipFaultLoads *loads, PetscReal t, PetscBool records,
                                    const PetscReal weight[], PetscReal shear[], PetscReal p[]);
/* The sum over the cells of this process of weights times the shear of terms at t times x[block * i + first ...] */
PETSC_INTERN PetscReal SlipLoadsTermsTimes(const SlipFaultLoads *loads, PetscReal t, const PetscReal x[],
                                           PetscInt first, PetscInt block);
PETSC_INTERN PetscReal SlipLoadsStartShear(const SlipFaultLoads *loads, PetscInt i); /* of terms at 0, along the rake */
PETSC_EXTERN PetscReal SlipLoadsScale(const SlipFaultLoads *loads, PetscReal t);     /* the shortest of all courses */
PETSC_INTERN PetscErrorCode SlipLoadsTermsSetUp(SlipFaultLoads *loads);
PETSC_INTERN PetscErrorCode SlipLoadsTermsDestroy(SlipFaultLoads *loads);
PETSC_INTERN PetscErrorCode SlipLoadsTermsView(const SlipFaultLoads *loads, PetscViewer viewer);
PETSC_INTERN PetscErrorCode SlipStressRecordDestroy(SlipStressRecord *record);
/* stresshistory.c: on rank 0, reads -fault_stress_history; the caller destroys the records */
PETSC_INTERN PetscErrorCode SlipLoadsReadHistory(SlipFault fault, PetscInt *n, SlipStressRecord **records);
PETSC_EXTERN PetscReal SlipLoadsNextCorner(const SlipFaultLoads *loads, PetscReal t);
PETSC_EXTERN PetscReal SlipLoadsPressureScale(const SlipFaultLoads *loads, PetscReal t, PetscReal duration);
PETSC_EXTERN PetscReal SlipExponentialIntegral(PetscReal x);
