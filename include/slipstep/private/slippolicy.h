/* Internal header of SlipPolicy for src/policy and its tests */
#pragma once
#include <petsc/private/petscimpl.h>
#include <petscviewer.h>
#include <slipstep/rooms/sliph5.h>
#include <slipstep/rooms/slippolicy.h>
#include <slipcompat.h>

/* One dense layer y = f(W x + b). The weight is stored transposed, so that the evaluation accesses memory
   contiguously. */
typedef struct {
  PetscInt in, out;
  PetscReal *weight; /* [in][out], the transpose of that in the file */
  PetscReal *bias;   /* [out] */
  SlipActivation activation;
} SlipLayer;

struct _p_SlipPolicy {
  PETSCHEADER(int);
  PetscInt n;       /* number of observations */
  char **names;     /* their names, in the network's order */
  PetscReal *scale; /* the network sees obs * scale + offset */
  PetscReal *offset;
  PetscReal *range; /* [2n] minima, then maxima in training; NULL if unknown */
  PetscInt nlayers;
  SlipLayer *layers;
  PetscBool has_action;
  PetscReal low, high;   /* of the action */
  PetscReal dt[2];       /* step at the lowest and at the highest action */
  PetscInt dt_unit[2];   /* index into SlipStepUnits */
  PetscBool log_spacing; /* steps between the two bounds in geometric proportion */
  PetscInt factor;       /* observation whose power of ten multiplies steps: 1 + number; -1: none, 0: not looked up */
  PetscInt nattributes;  /* description of the training, as text */
  char **attributes;     /* [2 nattributes]: name, value, ... sorted by name */
  char *file;            /* from which it was loaded or to which it was stored; NULL if made in memory */
  char hash[17];         /* hash of the content, hexadecimal; empty if not computed yet */
  PetscInt width;        /* widest layer */
  PetscReal *work;       /* [2 width] of the evaluation */
};

PETSC_EXTERN const char *const SlipStepUnits[]; /* "s", "T*", "t_max", "h", NULL */
enum { SLIP_STEP_UNIT_TMAX = 2, SLIP_STEP_UNIT_H = 3 };

/* policydefault.c, on one rank. Opens a file of measured numbers, such as "tolerances.h5", in SLIPSTEP_POLICY_DIR or,
   if it has none, in the library's folder; what: their meaning, for messages */
PETSC_INTERN PetscErrorCode SlipPolicyOpenData(const char name[], const char what[], SlipH5 *h);
PETSC_INTERN PetscErrorCode SlipPolicyCheckFormat(SlipH5 *h, const char format[], PetscInt version);
PETSC_INTERN PetscErrorCode SlipPolicyClear_Private(SlipPolicy p); /* removes the content */
PETSC_INTERN PetscErrorCode SlipPolicyCheck_Private(SlipPolicy p); /* raises an error unless complete and consistent */
PETSC_INTERN const char *SlipPolicySource_Private(SlipPolicy p);   /* its file, or "(in memory)" */
PETSC_INTERN PetscErrorCode SlipPolicyPack_Private(SlipPolicy p, size_t *n, char **bytes); /* free with PetscFree() */
PETSC_INTERN PetscErrorCode SlipPolicyUnpack_Private(SlipPolicy p, size_t n, const char *bytes);
PETSC_INTERN PetscBool SlipPolicyOwnAttribute_Private(const char name[]);
PETSC_INTERN PetscReal SlipPolicyParseNumber_Private(const char text[]);
PETSC_INTERN PetscErrorCode SlipPolicyAttributeNumber_Private(const char name[], const char value[], PetscReal *number);
PETSC_INTERN PetscErrorCode SlipPolicyNumberText_Private(PetscReal number, size_t len, char text[]);
