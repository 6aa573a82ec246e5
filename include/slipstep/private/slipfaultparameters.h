/* The parameters of a fault: tables of numbers, of choices, of switches and of the fields that may replace numbers cell
   by cell. After the numbers and fields of the tables follow those of registered friction laws: ids from
   FAULT_NUM_REALS and FAULT_NUM_FIELDS on, one law after another. */
#pragma once
#include <slipstep/rooms/slipcore.h>
#include <slipstep/private/slipmesh.h>

/* Largest number of parameters of registered laws, and length of their names */
enum { FAULT_MAX_OWN = 64, FAULT_MAX_NAME = 48 };
/* Length of all names of options or of fields, separated by blanks, and of a list of choices */
enum { FAULT_MAX_NAMES = 8192, FAULT_MAX_CHOICES = 4096 };

/* Reference absolute tolerance of u and s, and of v times T*: 1e-6 in units of 0.1 mm [m] */
#define SLIP_FAULT_ATOL 1e-10
/* Default of -fault_accuracy, and its bounds */
#define SLIP_FAULT_ACCURACY 1e-2
#define SLIP_FAULT_STRESS_GRADIENT 15e3 /* of normal stress that is not given [Pa/m] */
#define SLIP_FAULT_ACCURACY_MIN 1e-3
#define SLIP_FAULT_ACCURACY_MAX 1e-1
typedef enum {
  FAULT_NX = MESH_NX,
  FAULT_NZ = MESH_NZ,
  FAULT_LENGTH_X = MESH_LENGTH_X,
  FAULT_LENGTH_Z = MESH_LENGTH_Z,
  FAULT_DEPTH_TOP = MESH_DEPTH_TOP,
  FAULT_STRIKE = MESH_STRIKE,
  FAULT_DIP = MESH_DIP,
  FAULT_RAKE = MESH_REALS, /* a mesh file may set those before it */
  FAULT_SLIP_COMPONENTS,
  FAULT_THICKNESS,
  FAULT_SHEAR_MODULUS,
  FAULT_POISSON_RATIO,
  FAULT_DENSITY,
  FAULT_DAMPING_RATIO,
  FAULT_LOADING_RATE,
  FAULT_NORMAL_STRESS,
  FAULT_NORMAL_STRESS_GRADIENT,
  FAULT_FRICTION_RESIDUAL,
  FAULT_FRICTION_DROP,
  FAULT_FRICTION_SLIP,
  FAULT_FRICTION_RATE,
  FAULT_FRICTION_A,
  FAULT_FRICTION_B,
  FAULT_FRICTION_ALPHA,
  FAULT_FRICTION_REFERENCE,
  FAULT_FRICTION_REFERENCE_RATE,
  FAULT_STATE_CUTOFF_RATE,
  FAULT_HEALING_TIME,
  FAULT_INITIAL_TRACTION,
  FAULT_INITIAL_RATE,
  FAULT_INITIAL_STATE,
  FAULT_CREEP,
  FAULT_STRESSING_RATE,
  FAULT_REGIONAL_AZIMUTH,
  FAULT_INJECTION_PRESSURE,
  FAULT_INJECTION_DIFFUSIVITY,
  FAULT_INJECTION_STOP,
  FAULT_SHEAR_ZONE_WIDTH,
  FAULT_SHEAR_ZONE_TOLERANCE,
  FAULT_HEAT_CAPACITY,
  FAULT_THERMAL_DIFFUSIVITY,
  FAULT_HYDRAULIC_DIFFUSIVITY,
  FAULT_THERMAL_PRESSURISATION,
  FAULT_DILATANCY,
  FAULT_DILATANCY_STORAGE,
  FAULT_DILATANCY_TIME,
  FAULT_INITIAL_PERTURBATION,
  FAULT_VELOCITY_SCALE,
  FAULT_OUTPUT_INTERVAL,
  FAULT_OUTPUT_SLIP_INTERVAL,
  FAULT_OUTPUT_TIME_INTERVAL,
  FAULT_OUTPUT_RATE_CHANGE,
  FAULT_OUTPUT_SIZE,
  FAULT_OUTPUT_COMPRESSION,
  FAULT_HMAT_TOLERANCE,
  FAULT_KRYLOV_TOLERANCE,
  FAULT_WAVES_TOLERANCE,
  FAULT_WAVES_PADDING,
  FAULT_RATE_TOLERANCE,
  FAULT_ACCURACY,
  FAULT_CHECKPOINT_INTERVAL,
  FAULT_RESTART_DT,
  FAULT_WALL_LIMIT,
  FAULT_EVENT_RATE,
  FAULT_NUM_REALS
} SlipFaultRealId;

enum { FAULT_MAX_REALS = FAULT_NUM_REALS + FAULT_MAX_OWN };
PETSC_EXTERN const SlipParameter SlipFaultReals[FAULT_NUM_REALS];
PETSC_INTERN const SlipParameter *SlipFaultRealRow(PetscInt id); /* NULL after the last */

typedef enum {
  FAULT_FRICTION_LAW,
  FAULT_STATE_LAW,
  FAULT_MEDIUM,
  FAULT_KERNEL,
  FAULT_NORMAL_COUPLING,
  FAULT_INITIAL,
  FAULT_OPERATOR,
  FAULT_VISCOSITY,
  FAULT_STIFFNESS_AVERAGE,
  FAULT_STIFFNESS_FILE,
  FAULT_STIFFNESS_SCALING,
  FAULT_PARAMETERS,
  FAULT_MESH,
  FAULT_MESH_FRAME,
  FAULT_MESH_UNIT,
  FAULT_PORE_PRESSURE,
  FAULT_INJECTION,
  FAULT_REGIONAL_STRESS,
  FAULT_REGIONAL_STRESS_GRADIENT,
  FAULT_REGIONAL_RATIOS,
  FAULT_REGIONAL_PRESSURE,
  FAULT_REGIONAL_RAKE,
  FAULT_STRESS_HISTORY,
  FAULT_TIDE_PERIOD,
  FAULT_TIDE_SHEAR,
  FAULT_TIDE_NORMAL,
  FAULT_TIDE_PHASE,
  FAULT_NUCLEATION,
  FAULT_TOLERANCES,
  FAULT_ESTIMATES,
  FAULT_OUTPUT,
  FAULT_OUTPUT_FIELDS,
  FAULT_OUTPUT_PRECISION,
  FAULT_STATIONS,
  FAULT_SURFACE_STATIONS,
  FAULT_SURFACE_MOTION,
  FAULT_CATALOGUE,
  FAULT_CHECKPOINT,
  FAULT_RESTART,
  FAULT_STOP_FILE,
  FAULT_DEVICE,
  FAULT_DEVICE_NAME,
  FAULT_NUM_STRINGS
} SlipFaultStringId;

typedef struct {
  const char *name;
  const char *value;   /* default */
  const char *choices; /* "|a|b|", or NULL for a file name or list */
  const char *help;
  SlipPart part;
} SlipFaultString;
PETSC_EXTERN const SlipFaultString SlipFaultStrings[FAULT_NUM_STRINGS];

enum { FAULT_NUM_SWITCHES = 8 };
/* Options with the values yes and no */
typedef struct {
  const char *name;
  size_t offset;      /* of a PetscBool in a fault */
  SlipPart part;      /* those of the output may be set after SlipFaultSetUp() */
  const char *manual; /* name of the manual page for -help */
  const char *help;
} SlipFaultSwitch;
PETSC_EXTERN const SlipFaultSwitch SlipFaultSwitches[FAULT_NUM_SWITCHES];

/* Per-cell fields */
typedef enum {
  FIELD_NORMAL_STRESS,
  FIELD_FRICTION_RESIDUAL,
  FIELD_FRICTION_DROP,
  FIELD_FRICTION_SLIP,
  FIELD_FRICTION_RATE,
  FIELD_LOADING_RATE,
  FIELD_HEALING_TIME,
  FIELD_INITIAL_TRACTION,
  FIELD_STRESSING_RATE,
  FIELD_FRICTION_A,
  FIELD_FRICTION_B,
  FIELD_FRICTION_ALPHA,
  FIELD_FRICTION_REFERENCE,
  FIELD_INITIAL_RATE,
  FIELD_INITIAL_STATE,
  FIELD_CREEP,
  FIELD_RAKE,
  FIELD_THERMAL_PRESSURISATION,
  FIELD_DILATANCY,
  FAULT_NUM_FIELDS
} SlipFaultFieldId;
enum { FAULT_MAX_FIELDS = FAULT_NUM_FIELDS + FAULT_MAX_OWN };
PETSC_INTERN const SlipParameter *SlipFaultFieldRow(PetscInt field); /* of that number; NULL after the last */
PETSC_INTERN PetscInt SlipFaultFieldOf(PetscInt id);                 /* the field that replaces a number; -1: none */
PETSC_INTERN PetscInt SlipFaultFindField(const char name[]);         /* -1: none */
/* Row k among those of registered laws, and its law (NULL allowed) */
PETSC_INTERN const SlipParameter *SlipFaultOwnRow(PetscInt k, const SlipFrictionLaw **law);
