/* Internal header of the medium: the object, and the type "static", whose operations all others use by default */
#pragma once
#include <petsc/private/petscimpl.h>
#include <slipstep/rooms/slipelastic.h>
#include <slipstep/rooms/slipmat.h>
#include <slipcompat.h>
#include <slipstep/rooms/slipcells.h>
#include <slipstep/private/slipmatviscosity.h>
#include <slipstep/private/slipstate.h>

/* images.c: cached products */
typedef enum { SLIP_ELASTIC_K, SLIP_ELASTIC_H } SlipElasticImage;
typedef struct {
  Vec x, image[2];
  PetscBool has[2]; /* the images are those of x */
  PetscInt age;     /* number of nested sums in K x */
  PetscReal theta;  /* K x is as exact as forces to rounding, over this [s]; 0: a product or sum */
} SlipElasticPair;
/* u and v at the start, after stage 1 and at the end, start vectors of stages, the loading rate, and a spare one */
enum { SLIP_ELASTIC_PAIRS = 10 };

struct _p_SlipElastic {
  PETSCHEADER(SlipElasticOps);
  void *data;          /* of the type */
  Mat K, Kn, H;        /* stiffness [Pa/m], effect of slip on normal stress (NULL: none), viscosity [Pa s/m] */
  Mat B;               /* stage operator of K and H */
  Mat stage, coupling; /* of the last stage, borrowed from the type */
  Vec diagonal[2];     /* of K and H, computed on first use */
  Vec work[2];         /* of slip, on first use */
  PetscReal inertia;   /* M of the balance, 0 without [kg/m^2] */

  SlipElasticPair pair[SLIP_ELASTIC_PAIRS]; /* most recently used first */
  PetscInt npairs;
  PetscReal theta; /* smallest theta used in this stage [s]; 0: none */

  SlipElasticPast past[2]; /* the slots */
  PetscBool known;         /* they have been set */
  PetscBool trial;         /* slot 1 is inside of an attempt */

  PetscReal mass;      /* of the rock [kg/m^2] */
  PetscInt components; /* of slip */
  PetscInt *number;    /* of each cell of this process; NULL: that of its row */
  PetscReal frequency; /* the largest [rad/s]; 0: not computed yet */
};

/* images.c; image: borrowed, NULL if it is not cached */
PETSC_INTERN PetscErrorCode SlipElasticFindPair(SlipElastic el, Vec x, SlipElasticPair **pair); /* that of x, or NULL */
PETSC_INTERN PetscErrorCode SlipElasticTakePair(SlipElastic el, Vec x,
                                                SlipElasticPair **pair); /* replaces the oldest */
PETSC_INTERN PetscErrorCode SlipElasticSetImage(SlipElasticPair *pair, SlipElasticImage of, Vec image);
PETSC_INTERN PetscErrorCode SlipElasticFindImage(SlipElastic el, SlipElasticImage of, Vec x, Vec *image);
PETSC_INTERN PetscErrorCode SlipElasticKeepImage(SlipElastic el, SlipElasticImage of, Vec x, Vec image);
PETSC_INTERN PetscErrorCode SlipElasticDestroyImages(SlipElastic el);
PETSC_INTERN PetscErrorCode SlipElasticImagesState(SlipElastic el, SlipState state);
/* static.c */
PETSC_INTERN const SlipElasticOps SlipElasticStatic;
/* waves.c */
PETSC_INTERN PetscErrorCode SlipElasticCreate_Waves(SlipElastic el);
/* medium.c */
PETSC_INTERN PetscErrorCode SlipElasticGetWork(SlipElastic el, PetscInt n, Vec *work); /* n is 0 or 1 */
