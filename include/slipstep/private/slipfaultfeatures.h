/* What goes with what: the features of a fault and of its runs, and the combinations of them that are refused. A choice
   whose meaning needs another choice, or excludes it, is a rule here, and nowhere else; what depends on numbers that
   are computed is refused where they are. */
#pragma once
#include <slipfault.h>

typedef enum {
  FEATURE_GRID,
  FEATURE_RECTANGLES,
  FEATURE_TRIANGLES,
  FEATURE_PLANES,
  FEATURE_OBLIQUE,
  FEATURE_MESH_FRAME,
  FEATURE_MESH_UNIT,
  FEATURE_STIFFNESS_FILE,
  FEATURE_HALF_SPACE,
  FEATURE_FULL_SPACE,
  FEATURE_WAVES,
  FEATURE_WAVE_PLANE,
  FEATURE_CENTRE,
  FEATURE_CELL,
  FEATURE_WHOLE,
  FEATURE_MEAN_SLIP,
  FEATURE_DENSE,
  FEATURE_FFT,
  FEATURE_HMAT,
  FEATURE_STIFFNESS_VIEW,
  FEATURE_DEVICE,
  FEATURE_SQRTM,
  FEATURE_SPECTRAL,
  FEATURE_LANCZOS,
  FEATURE_RADIATION,
  FEATURE_NONE,
  FEATURE_UNDAMPED,
  FEATURE_INERTIA,
  FEATURE_BALANCE,
  FEATURE_SLIP_WEAKENING,
  FEATURE_RATE_WEAKENING,
  FEATURE_ALWAYS_SLIDES,
  FEATURE_SLIP_LAW,
  FEATURE_ALPHA,
  FEATURE_HEALING,
  FEATURE_CREEP,
  FEATURE_CRITICAL,
  FEATURE_REST,
  FEATURE_TRACTION,
  FEATURE_RATE,
  FEATURE_LOADING,
  FEATURE_STRESSING,
  FEATURE_COUPLED,
  FEATURE_UNCOUPLED,
  FEATURE_VECTOR,
  FEATURE_OPENING,
  FEATURE_INJECTION,
  FEATURE_INJECTED,
  FEATURE_SOURCE,
  FEATURE_PRESSURE,
  FEATURE_OUTPUT,
  FEATURE_OUTPUT_PRESSURE,
  FEATURE_OUTPUT_OPENING,
  FEATURE_STATIONS,
  FEATURE_SURFACE_STATIONS,
  FEATURE_CATALOGUE,
  FEATURE_CHECKPOINT,
  FEATURE_CHECK_ERROR,
  FEATURE_BATHE,
  FEATURE_MOREAU,
  FEATURE_ADAMS,
  FEATURE_RK,
  FEATURE_RKC,
  FEATURE_LAPUSTA,
  FEATURE_OTHER_TS,
  FAULT_NUM_FEATURES
} SlipFaultFeatureId;

typedef struct {
  const char *name; /* what a user writes, or a few words */
  PetscInt group;   /* of features that are choices of one thing, from 1 on; 0: of its own */
  PetscBool late;   /* known when a run begins, or set after SlipFaultSetUp() */
  /* Is it on? ts: NULL in SlipFaultSetUp() */
  PetscBool (*on)(SlipFault fault, TS ts);
} SlipFaultFeature;
PETSC_EXTERN const SlipFaultFeature SlipFaultFeatures[FAULT_NUM_FEATURES];

/* Sets of features, bit by bit, in two words */
__extension__ typedef unsigned __int128 SlipFaultFeatureSet;
#define SLIP_FEATURE(name) ((SlipFaultFeatureSet)1 << FEATURE_##name)

/* Where one of these is on and none of unless, one of others must not be, or must be. What the user reads: of an option
   -fault_NAME the prefix is added, and % is the value of the option before it. */
typedef struct {
  SlipFaultFeatureSet these;
  PetscBool needs;
  SlipFaultFeatureSet others, unless;
  const char *sentence;
} SlipFaultRule;
PETSC_EXTERN const SlipFaultRule SlipFaultRules[]; /* the last has no sentence */

/* Those that are on, of a fault whose cells are set up; ts NULL: without the late ones */
PETSC_EXTERN SlipFaultFeatureSet SlipFaultFeaturesOn(SlipFault fault, TS ts);
PETSC_EXTERN PetscErrorCode SlipFaultRuleText(SlipFault fault, TS ts, const SlipFaultRule *rule, char text[],
                                              size_t len);
/* The sentence of the first rule that refuses what is on with these, but not what is on; "": none does */
PETSC_INTERN PetscErrorCode SlipFaultRefuses(SlipFault fault, TS ts, SlipFaultFeatureSet these, char text[],
                                             size_t len);
/* Refuses what does not go together; once before anything is computed, ts NULL, and once more before a run */
PETSC_EXTERN PetscErrorCode SlipFaultCheckFeatures(SlipFault fault, TS ts);
