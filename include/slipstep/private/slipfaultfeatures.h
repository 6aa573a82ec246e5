/* The combinations of features of a fault and of its runs that are errors. A choice that needs or excludes another
   choice is a rule here and nowhere else; conditions on computed numbers are checked where these are computed. */
#pragma once
#include <slipstep/rooms/slipfault.h>

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
  const char *name; /* the user's option, or a few words */
  PetscInt group;   /* of features that are values of one choice, from 1 on; 0: none */
  PetscBool late;   /* decided when a run begins, or after SlipFaultSetUp() */
  /* Is it active? ts: NULL in SlipFaultSetUp() */
  PetscBool (*on)(SlipFault fault, TS ts);
} SlipFaultFeature;
PETSC_EXTERN const SlipFaultFeature SlipFaultFeatures[FAULT_NUM_FEATURES];

/* Sets of features, bit by bit, in two words */
__extension__ typedef unsigned __int128 SlipFaultFeatureSet;
#define SLIP_FEATURE(name) ((SlipFaultFeatureSet)1 << FEATURE_##name)

/* If one of `these` is active and none of `unless`, one of the others must not be, or must be. The sentence is for the
   user: -fault_NAME gets the prefix, and % is the value of the option before it. */
typedef struct {
  SlipFaultFeatureSet these;
  PetscBool needs;
  SlipFaultFeatureSet others, unless;
  const char *sentence;
} SlipFaultRule;
PETSC_EXTERN const SlipFaultRule SlipFaultRules[]; /* the last one has no sentence */

/* The active features of a fault whose cells are set up; ts NULL: without the late ones */
PETSC_EXTERN SlipFaultFeatureSet SlipFaultFeaturesOn(SlipFault fault, TS ts);
PETSC_EXTERN PetscErrorCode SlipFaultRuleText(SlipFault fault, TS ts, const SlipFaultRule *rule, char text[],
                                              size_t len);
/* Gets the sentence of the first rule that forbids these with the active features, but not those alone, or "". */
PETSC_INTERN PetscErrorCode SlipFaultRefuses(SlipFault fault, TS ts, SlipFaultFeatureSet these, char text[],
                                             size_t len);
/* Raises errors for forbidden combinations, before any computation with ts NULL, and again before a run. */
PETSC_EXTERN PetscErrorCode SlipFaultCheckFeatures(SlipFault fault, TS ts);
