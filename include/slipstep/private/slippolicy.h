/* Inside of SlipPolicy, shared by the files of src/policy and its tests. */
#pragma once
#include <petsc/private/petscimpl.h>
#include <petscviewer.h>
#include <sliph5.h>
#include <slippolicy.h>
#include <slipcompat.h>

/* One dense layer y = f(W x + b). The weight is kept transposed so that the forward pass runs along contiguous
   memory. */
typedef struct {
  PetscInt in, out;
  PetscReal *weight; /* [in][out], the transpose of what the file holds */
  PetscReal *bias;   /* [out] */
  SlipActivation activation;
} SlipLayer;

struct _p_SlipPolicy {
  PETSCHEADER(int);
  PetscInt n;       /* number of observations */
  char **names;     /* their names, in the network's order */
  PetscReal *scale; /* the network sees obs * scale + offset */
  PetscReal *offset;
  PetscReal *range; /* [2n] minima, then maxima in training; NULL when not known */
  PetscInt nlayers;
  SlipLayer *layers;
  PetscBool has_action;
  PetscReal low, high;   /* of the action */
  PetscReal dt[2];       /* step at the lowest and at the highest action */
  PetscInt dt_unit[2];   /* index into SlipStepUnits */
  PetscBool log_spacing; /* steps between the two bounds in geometric proportion */
  PetscInt
    factor; /* observation that steps are multiplied by, its power of ten: 1 + number; -1: none, 0: not looked up */
  PetscInt nattributes; /* what the file says of the training, as text */
  char **attributes;    /* [2 nattributes]: name, value, ... sorted by name */
  char *file;           /* where it was loaded from or stored to; NULL when made in memory */
  char hash[17];        /* digest of the content, hexadecimal; empty when not computed yet */
  PetscInt width;       /* widest layer */
  PetscReal *work;      /* [2 width] of the forward pass */
};

PETSC_EXTERN const char *const SlipStepUnits[]; /* "s", "T*", "t_max", "h", NULL */
enum { SLIP_STEP_UNIT_TMAX = 2, SLIP_STEP_UNIT_H = 3 };

/* policydefault.c, on one rank. Opens a file of measured numbers, such as "tolerances.h5", in SLIPSTEP_POLICY_DIR, or
   where it has none in the library's folder; what they are, for messages */
PETSC_INTERN PetscErrorCode SlipPolicyOpenData(const char name[], const char what[], SlipH5 *h);
PETSC_INTERN PetscErrorCode SlipPolicyCheckFormat(SlipH5 *h, const char format[], PetscInt version);
PETSC_INTERN PetscErrorCode SlipPolicyClear_Private(SlipPolicy p); /* forget the content */
PETSC_INTERN PetscErrorCode SlipPolicyCheck_Private(SlipPolicy p); /* complete and consistent, or an error */
PETSC_INTERN const char *SlipPolicySource_Private(SlipPolicy p);   /* its file, or "(in memory)" */
PETSC_INTERN PetscErrorCode SlipPolicyPack_Private(SlipPolicy p, size_t *n, char **bytes); /* free with PetscFree() */
PETSC_INTERN PetscErrorCode SlipPolicyUnpack_Private(SlipPolicy p, size_t n, const char *bytes);
PETSC_INTERN PetscBool SlipPolicyOwnAttribute_Private(const char name[]);
PETSC_INTERN PetscReal SlipPolicyParseNumber_Private(const char text[]);
PETSC_INTERN PetscErrorCode SlipPolicyAttributeNumber_Private(const char name[], const char value[], PetscReal *number);
PETSC_INTERN PetscErrorCode SlipPolicyNumberText_Private(PetscReal number, size_t len, char text[]);
