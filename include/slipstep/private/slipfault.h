/* Internal header of the fault: its parts, each with a header of its own. Output of a run is in sliprunfiles.h. */
#pragma once
#include <petsc/private/petscimpl.h>
#include <slipstep/rooms/slipfault.h>
#include <slipstep/rooms/slipcells.h>
#include <slipstep/rooms/slipcore.h>
#include <slipstep/rooms/slipsys.h>
#include <slipstep/rooms/slipoutput.h>
#include <slipstep/rooms/sliph5.h>
#include <slipcompat.h>
#include <slipstep/private/sliprunoutput.h>
#include <slipstep/private/slipfaultcells.h>
#include <slipstep/private/sliploops.h>
#include <slipstep/private/slipfaultknown.h>
#include <slipstep/private/slipfaultfluid.h>
#include <slipstep/private/slipfaultloads.h>
#include <slipstep/private/slipmesh.h>
#include <slipstep/private/slipfaultoperators.h>
#include <slipstep/private/slipfaultparameters.h>
#include <slipstep/private/slipfaultproblem.h>
#include <slipstep/private/slipfaultzone.h>
#include <slipstep/private/slipstate.h>
#include <slipstep/private/slipsys.h>
#include <math.h>

/* ---- resolution.c: the lengths of a rupture relative to the cells ---- */
typedef struct {
  PetscBool weakens;    /* some cell weakens */
  PetscBool known;      /* it does, and there are several cells, so that the members below are valid */
  PetscBool zone;       /* the length is that of a cohesive zone, else of nucleation */
  PetscReal least;      /* least ratio of length to cell, over all cells that weaken */
  PetscReal length;     /* there [m] */
  PetscReal cell;       /* there [m] */
  PetscReal wanted;     /* smallest recommended ratio */
  PetscReal alone;      /* fraction of the weakening cells which can fail on their own */
  PetscReal nucleation; /* least length of nucleation [m] */
  PetscReal critical;   /* mean stiffness below which slip is unstable, over the cells that weaken [Pa/m] */
} SlipFaultResolution;

/* ---- the parts of a fault, each filled by the named file, in the order of SlipFaultSetUp() ---- */

/* parameters.c: the user's choices, which no other file changes */
typedef struct {
  PetscReal value[FAULT_MAX_REALS]; /* NaN: not given; the default is computed, or that of a registered law */
  char text[FAULT_NUM_STRINGS][PETSC_MAX_PATH_LEN];
  char *longer[FAULT_NUM_STRINGS]; /* lists of points too long for text; else NULL */
  PetscBool inertia;               /* -fault_inertia */
  PetscBool inertia_given;         /* otherwise the law decides */
  PetscBool initial_unstable;      /* -fault_initial_unstable */
  PetscBool opening;               /* -fault_opening */
  PetscBool check_error;           /* -fault_check_error */
  PetscBool progress;              /* -fault_progress */
  PetscBool output_overwrite;      /* -fault_output_overwrite */
  PetscBool output_xdmf;           /* -fault_output_xdmf */
  PetscBool interval_given;        /* output_interval was set */
  PetscBool catalogue_maps;        /* -fault_catalogue_maps */
  PetscBool reports;               /* its options were read: it prints warnings and results */
  PetscViewer viewer;              /* -fault_view */
  PetscViewerFormat format;
  PetscViewer stiffness_viewer; /* -fault_stiffness_view */
  PetscViewerFormat stiffness_format;
} SlipFaultOptions;

/* cellparameters.c: parameters cell by cell */
typedef struct {
  PetscReal *given[FAULT_MAX_FIELDS]; /* of SlipFaultSetField(): all cells, [nx nz]; NULL: the scalar parameter */
  PetscInt ngiven[FAULT_MAX_FIELDS];
  PetscReal *cell[FAULT_MAX_FIELDS];    /* [n]; NULL: of a law that was registered after the set-up */
  const char *source[FAULT_MAX_FIELDS]; /* source, for views; NULL: the scalar parameters */
  const char *regional;                 /* the option that gives the stress of a region; NULL: there is none */
  PetscReal *tendency;                  /* [n] slip tendency under it, else NULL */
} SlipFaultCellFields;

/* The positions of a cell's numbers in a state, and in its rates and errors; block numbers per cell. Slip has one
   component, along the rake, or two, along strike and up dip; rates and displacements have them one after the other,
   and so have vectors of slip, shear stress and the like. Cells that open have a third component in all of these,
   normal to their plane. A vector of cells has one number per cell. */
typedef struct {
  PetscInt components; /* of these vectors: 1, 2, or 3 if cells open, with the opening last */
  PetscInt plane;      /* those in the plane of a cell: 1 or 2 components of slip */
  PetscInt block;
  PetscInt rate;         /* slip rate [m/s] */
  PetscInt displacement; /* relative to the far field [m] */
  PetscInt state;        /* of friction: cumulative slip [m], or the law's own states */
  PetscInt states;       /* number of states */
  PetscReal *along;      /* [n][components] unit vector of the rake: of loading and shear load */
  PetscReal *sizes;      /* [2 n] of several components: work space for magnitudes; else NULL */
} SlipFaultLayout;

/* The friction of the cells, without their normal stress, which SlipFaultLoads has */
typedef struct {
  const SlipFrictionLaw *law;
  SlipStateLaw state_law;            /* -fault_state_law */
  PetscBool follows;                 /* the state depends on changing normal stress (-fault_friction_alpha) */
  PetscReal *start[SLIP_MAX_STATES]; /* initial fields of cells that always slide; NULL: none */
  PetscReal *healing;                /* [n] 1/t_h [1/s]; NULL: 0 */
  PetscReal *own;                    /* [n][nown] parameters of the law */
  PetscReal *known;                  /* see SlipFrictionCells; NULL: the law caches nothing */
  PetscInt nown;
} SlipFaultFriction;

/* Properties of the problem that follow from the parameters */
typedef struct {
  PetscBool loaded;                /* some v_inf is not zero */
  const char *initial, *viscosity; /* the choices, with "auto" resolved */
  PetscBool oblique;               /* planes that dip, or slip in other directions than strike */
  PetscBool dipping;               /* its kernel is that for any direction */
  PetscBool coupled;               /* slip changes the normal stress */
  PetscBool inertia;               /* likewise; -fault_inertia */
  PetscBool waves;                 /* the medium has waves, and stores them */
  PetscBool heals;                 /* some healing time is finite */
  PetscBool flows;                 /* some permeability is not 0: pore fluid diffuses in the cells */
  PetscBool sequence;              /* loading, stressing or healing may cause several events */
  PetscBool driven; /* by loading, stressing, pressure or healing, or without inertia: times at rest are unlimited */
} SlipFaultKind;

/* Number of work vectors of slip that nested functions may use at one time */
enum { FAULT_WORK = 6 };

struct _p_SlipFault {
  PETSCHEADER(int);
  MPI_Comm comm; /* of the header, for short */
  SlipFaultOptions options;
  PetscBool meshed; /* SlipFaultSetUpMesh() was called: the mesh is valid, and its parameters cannot change */
  PetscBool setup;  /* SlipFaultSetUp() was called: the members below are valid */
  SlipFaultMesh mesh;
  SlipFaultLayout layout;
  SlipFaultCellFields fields;
  SlipFaultFriction friction;
  SlipFaultLoads loads;
  SlipFaultKind kind;
  SlipElastic medium; /* computes the stress that slip causes */
  SlipFaultOperators operators;
  SlipFaultCritical critical;
  SlipFaultStage stage;
  SlipFaultSettled settled;
  SlipFaultDevice device;
  const SlipFaultCellsOps *cell_ops; /* operations on the cells, by where these are */
  SlipFaultBalance balance;          /* if all cells slide: the slip rates of the last evaluated state */
  SlipFaultResolution resolution;
  SlipProblemOps problem;  /* functions that its TS calls */
  PetscBool corner_passed; /* a constant step passed one, and the warning was printed */
  SlipFaultSteps steps;
  SlipFaultKnown known;
  SlipFaultCoupling coupling;
  SlipFaultZone zone;
  SlipFaultFluid fluid;
  struct _n_SlipFaultRun *run;                           /* of src/record */
  PetscErrorCode (*told)(SlipFault fault, const char[]); /* called before long parts of the set-up */
  Vec work[FAULT_WORK];                                  /* of slip, SlipFaultGetWork() */
  PetscBool taken[FAULT_WORK];
  Vec cells; /* of cells: work within a function, and for its layout */
};

/* The wanted accuracy of the run */
static inline PetscReal SlipFaultAccuracy(SlipFault fault)
{
  const PetscReal given = fault->options.value[FAULT_ACCURACY];

  return PetscIsNanReal(given) ? (PetscReal)SLIP_FAULT_ACCURACY : given;
}

/* Indices of cell i of this rank in a state */
static inline PetscInt SlipFaultRateAt(SlipFault fault, PetscInt i)
{
  return fault->layout.block * i + fault->layout.rate;
}

static inline PetscInt SlipFaultDisplacementAt(SlipFault fault, PetscInt i)
{
  return fault->layout.block * i + fault->layout.displacement;
}

static inline PetscInt SlipFaultStateAt(SlipFault fault, PetscInt i)
{
  return fault->layout.block * i + fault->layout.state;
}

/* The largest magnitude of the states of cell i, or of numbers in their place, such as errors */
static inline PetscReal SlipFaultStateSize(SlipFault fault, const PetscReal a[], PetscInt i)
{
  const PetscReal *s = a + SlipFaultStateAt(fault, i);
  PetscReal size = PetscAbsReal(*s);

  for (PetscInt k = 1; k < fault->layout.states; k++)
    if (!(PetscAbsReal(s[k]) <= size)) size = PetscAbsReal(s[k]); /* also if it is NaN */
  return size;
}

/* x.y of vectors of slip of one cell, and |x|, both in its plane */
static inline PetscReal SlipFaultDot(SlipFault fault, const PetscReal x[], const PetscReal y[])
{
  return fault->layout.components == 1 ? x[0] * y[0] : x[0] * y[0] + x[1] * y[1];
}
static inline PetscReal SlipFaultLength(SlipFault fault, const PetscReal x[])
{
  return fault->layout.components == 1 ? PetscAbsReal(x[0]) : hypot(x[0], x[1]);
}

/* The slip [components] of cell i in h seconds, from one displacement to another; these are relative to the far field,
   whose rates are vinf [n][components]. Returns its length [m]. */
static inline PetscReal SlipFaultSlipped(SlipFault fault, PetscInt i, PetscReal h, const PetscReal from[],
                                         const PetscReal to[], const PetscReal vinf[], PetscReal slip[3])
{
  const PetscInt c = fault->layout.components;

  for (PetscInt k = 0; k < c; k++) slip[k] = to[k] - from[k] + h * vinf[c * i + k];
  return SlipFaultLength(fault, slip);
}

/* |v| of cell i in the state a, or of numbers in the place of v */
static inline PetscReal SlipFaultSpeed(SlipFault fault, const PetscReal a[], PetscInt i)
{
  return SlipFaultLength(fault, a + SlipFaultRateAt(fault, i));
}

/* |u| likewise */
static inline PetscReal SlipFaultDistance(SlipFault fault, const PetscReal a[], PetscInt i)
{
  return SlipFaultLength(fault, a + SlipFaultDisplacementAt(fault, i));
}

/* y along x, for vectors of slip of one cell; 0 if x = 0 */
static inline PetscReal SlipFaultAlongSlip(SlipFault fault, const PetscReal x[], const PetscReal y[])
{
  const PetscReal size = SlipFaultLength(fault, x);

  if (size == 0) return 0;
  return fault->layout.components == 1 ? PetscSign(x[0]) * y[0] : SlipFaultDot(fault, x, y) / size;
}

/* Can cells open? */
static inline PetscBool SlipFaultOpens(SlipFault fault)
{
  return fault->layout.components == 3 ? PETSC_TRUE : PETSC_FALSE;
}

/* The opening of cell i, in a state from the rates or the displacements on; 0 if cells do not open */
static inline PetscReal SlipFaultAcross(SlipFault fault, const PetscReal x[])
{
  return fault->layout.components == 3 ? x[2] : 0;
}

/* The largest of the numbers of cell i in a vector of slip, such as a diagonal */
static inline PetscReal SlipFaultLargest(SlipFault fault, const PetscReal x[], PetscInt i)
{
  const PetscInt c = fault->layout.components;

  return c == 1 ? x[i] : PetscMax(x[c * i], x[c * i + 1]);
}

/* Does the normal stress depend on the state? */
static inline PetscBool SlipFaultNormalFollows(SlipFault fault)
{
  return fault->kind.coupled || fault->zone.presses ? PETSC_TRUE : PETSC_FALSE;
}

/* Does slip change the pressure of fluid, across the fault or along it? */
static inline PetscBool SlipFaultPressureFollows(SlipFault fault)
{
  return fault->zone.presses || fault->fluid.follows ? PETSC_TRUE : PETSC_FALSE;
}

/* The unit vector of the rake of cell i */
static inline const PetscReal *SlipFaultAlong(SlipFault fault, PetscInt i)
{
  return fault->layout.along + fault->layout.components * i;
}

/* Checks that the fault, which is argument arg, has been set up. */
#define SlipFaultCheckSetUp(fault, arg)                                                                                \
  do {                                                                                                                 \
    PetscValidHeaderSpecific(fault, SLIP_FAULT_CLASSID, arg);                                                          \
    PetscCheck((fault)->setup, (fault)->comm, PETSC_ERR_ORDER, "call SlipFaultSetUp() first");                         \
  } while (0)

/* For messages: "-%sfault_nx" has the options prefix after the dash. */
static inline const char *SlipFaultPrefix(SlipFault fault)
{
  const char *prefix = ((PetscObject)fault)->prefix;

  return prefix ? prefix : "";
}

PETSC_EXTERN PetscErrorCode SlipFaultCellsSetUp(SlipFault fault);        /* fields */
PETSC_INTERN const char *SlipFaultGetText(SlipFault fault, PetscInt id); /* a choice; after set-up without "auto" */
PETSC_INTERN const char *SlipFaultFieldNames(void);
PETSC_INTERN PetscErrorCode SlipFaultOptionNames(char names[], size_t len);
/* parameters.c */
PETSC_INTERN PetscErrorCode SlipFaultCheckReal(SlipFault fault, const SlipParameter *p, PetscReal x);
PETSC_INTERN PetscErrorCode SlipFaultListChoices(const SlipFaultString *p, const char value[], char list[], size_t len,
                                                 PetscBool *is);
PETSC_INTERN PetscBool SlipParameterHolds(const SlipParameter *p, PetscReal x);
PETSC_INTERN void SlipParameterBounds(const SlipParameter *p, PetscBool cell, char text[], size_t len);
/* hmattolerance.c */
PETSC_INTERN PetscErrorCode SlipFaultHmatTolerance(SlipFault fault, PetscReal *tolerance, char why[], size_t len);
PETSC_INTERN PetscErrorCode SlipFaultHmatSetUp(SlipFault fault);
PETSC_INTERN PetscErrorCode SlipFaultIsHierarchical(SlipFault fault, PetscBool *is);
PETSC_INTERN PetscErrorCode SlipFaultHmatPrint(SlipFault fault);
PETSC_INTERN PetscErrorCode SlipFaultHmatResult(SlipFault fault, SlipOutput run);
/* geometry.c */
/* access.c: geometry of a cell by name; ends with NULL */
typedef struct {
  const char *name, *unit;
} SlipFaultGeometryName;
PETSC_INTERN const SlipFaultGeometryName SlipFaultGeometryNames[];
PETSC_EXTERN PetscErrorCode SlipFaultMeshSetUp(SlipFault fault);
PETSC_INTERN PetscErrorCode SlipFaultMeshForecast(SlipFault fault, PetscMPIInt size, SlipCellsForecast forecast[]);
PETSC_INTERN PetscErrorCode SlipFaultMeshStiffness(SlipFault fault, Mat *K, Mat *Kn);
PETSC_EXTERN PetscErrorCode SlipFaultWeightedSum(SlipFault fault, Vec x, PetscReal *sum);
PETSC_INTERN PetscErrorCode SlipFaultCheckTraction(SlipFault fault); /* startcheck.c */
PETSC_INTERN PetscErrorCode SlipFaultStressPrint(SlipFault fault);
PETSC_EXTERN PetscErrorCode SlipFaultGetSlip(SlipFault fault, PetscReal t, Vec w, Vec slip);
/* components.c */
PETSC_INTERN PetscErrorCode SlipFaultChooseComponents(SlipFault fault);
PETSC_INTERN PetscErrorCode SlipFaultComponentsSetUp(SlipFault fault);
PETSC_INTERN PetscErrorCode SlipFaultMove(SlipFault fault, PetscInt offset, PetscBool back, Vec w, Vec x);
PETSC_EXTERN PetscErrorCode SlipFaultGetRate(SlipFault fault, Vec w, Vec v); /* v and u of w as vectors of slip */
PETSC_EXTERN PetscErrorCode SlipFaultGetDisplacement(SlipFault fault, Vec w, Vec u);
PETSC_INTERN PetscErrorCode SlipFaultFillAlong(SlipFault fault, const PetscReal value[], PetscBool weighted, Vec x);
PETSC_EXTERN PetscErrorCode SlipFaultGetWork(SlipFault fault, Vec *x); /* a vector of slip with undefined content */
PETSC_EXTERN PetscErrorCode SlipFaultRestoreWork(SlipFault fault, Vec *x);
PETSC_EXTERN PetscErrorCode SlipFaultLargestSpeed(SlipFault fault, Vec w, PetscReal *largest);
PETSC_EXTERN PetscErrorCode SlipFaultCheckFileNames(SlipFault fault); /* runfiles.c */
/* points.c. Collective: reads the points [n][3] of a list or file, freed by PetscFree(). axes are two letters; a third
   coordinate may be given between them, and is NaN otherwise. */
PETSC_INTERN PetscErrorCode SlipFaultReadPoints(SlipFault fault, PetscInt id, const char axes[2], PetscBool three,
                                                PetscInt *n, PetscReal **points);
/* Reads up to `most` numbers of an option's list; good: it is one. */
PETSC_INTERN PetscErrorCode SlipFaultReadNumbers(SlipFault fault, PetscInt id, PetscInt most, PetscReal x[],
                                                 PetscInt *n, PetscBool *good);
/* Gets the point of -fault_injection or -fault_nucleation in space, from the numbers x,z or x,y,z of the option, with
   `more` numbers after them. */
PETSC_INTERN PetscErrorCode SlipFaultReadPoint(SlipFault fault, PetscInt id, PetscInt more, const char what[],
                                               PetscReal point[3], PetscReal rest[]);
/* loads.c */
PETSC_EXTERN PetscErrorCode SlipFaultLoadsSetUp(SlipFault fault);
PETSC_EXTERN PetscErrorCode SlipFaultLoadsDestroy(SlipFault fault);
PETSC_EXTERN PetscErrorCode SlipFaultGetLoad(SlipFault fault, PetscReal t, const SlipFaultLoad **load);
PETSC_INTERN PetscErrorCode SlipFaultGetShear(SlipFault fault, PetscReal t, Vec *shear); /* borrowed, NULL: none */
PETSC_EXTERN PetscErrorCode SlipFaultReportOpening(SlipFault fault, PetscReal t);
/* coupling.c */
PETSC_INTERN PetscErrorCode SlipFaultChooseCoupling(SlipFault fault);
PETSC_INTERN PetscErrorCode SlipFaultCouplingSetUp(SlipFault fault);
PETSC_INTERN PetscErrorCode SlipFaultCouplingDestroy(SlipFault fault);
PETSC_INTERN PetscErrorCode SlipFaultCoupledFriction(SlipFault fault, PetscReal t, PetscReal rest,
                                                     SlipFrictionCells *friction);
PETSC_INTERN PetscErrorCode SlipFaultCoupledBound(SlipFault fault, Vec x, SlipFrictionCells *friction);
/* resolution.c */
PETSC_EXTERN PetscErrorCode SlipFaultResolutionSetUp(SlipFault fault);
PETSC_EXTERN PetscErrorCode SlipFaultResolutionText(SlipFault fault, char text[], size_t len); /* for views and lines */
PETSC_EXTERN PetscErrorCode SlipFaultResolutionPrint(SlipFault fault);
PETSC_EXTERN PetscErrorCode SlipFaultResolutionResult(SlipFault fault, SlipOutput run);
PETSC_EXTERN PetscErrorCode SlipFaultResolutionWarn(SlipFault fault);
/* warn.c */
PETSC_EXTERN PetscErrorCode SlipFaultWarn(SlipFault fault);
PETSC_INTERN PetscErrorCode SlipFaultWarnOfIdle(SlipFault fault);          /* unused options; on rank 0 */
PETSC_EXTERN PetscBool SlipFaultHasField(SlipFault fault, PetscInt field); /* its law or its pore fluid uses it */
PETSC_INTERN PetscErrorCode SlipFaultFollowSetUp(SlipFault fault);         /* cellfriction.c */
