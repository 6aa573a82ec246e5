/* Inside the medium: the object, and the operations of the type that all others fall back on. */
#pragma once
#include <petsc/private/petscimpl.h>
#include <slipelastic.h>
#include <slipmat.h>
#include <slipcompat.h>
#include <slipcells.h>
#include <slipstep/private/slipmatviscosity.h>
#include <slipstep/private/slipstate.h>

/* images.c: products that are known */
typedef enum { SLIP_ELASTIC_K, SLIP_ELASTIC_H } SlipElasticImage;
typedef struct {
  Vec x, image[2];
  PetscBool has[2]; /* the images are those of x */
  PetscInt age;     /* K x is a sum of sums, so many times */
  PetscReal theta;  /* K x is as exact as forces are to rounding, over this [s]; 0: a product, or a sum */
} SlipElasticPair;
/* u and v at the start, after stage 1 and at the end, what stages start from, the loading rate, and one to spare */
enum { SLIP_ELASTIC_PAIRS = 10 };

struct _p_SlipElastic {
  PETSCHEADER(SlipElasticOps);
  void *data;          /* of the type */
  Mat K, Kn, H;        /* stiffness [Pa/m], what slip does to normal stress, NULL: nothing, viscosity [Pa s/m] */
  Mat B;               /* stage operator of K and H */
  Mat stage, coupling; /* of the last stage, borrowed from the type */
  Vec diagonal[2];     /* of K and H, once they have been asked for */
  Vec work[2];         /* of slip, on first use */
  PetscReal inertia;   /* M of the balance, 0 without [kg/m^2] */

  SlipElasticPair pair[SLIP_ELASTIC_PAIRS]; /* the last asked for first */
  PetscInt npairs;
  PetscReal theta; /* the least of those asked for in this stage [s]; 0: none */

  SlipElasticPast past[2]; /* the slots */
  PetscBool known;         /* they hold something */
  PetscBool trial;         /* slot 1 is within an attempt */

  PetscReal mass;      /* of the rock [kg/m^2] */
  PetscInt components; /* of slip */
  PetscInt *number;    /* of each cell of this process; NULL: that of its row */
  PetscReal frequency; /* the largest [rad/s]; 0: not asked for yet */
};

/* images.c; image: borrowed, NULL where it is not known */
PETSC_INTERN PetscErrorCode SlipElasticFindPair(SlipElastic el, Vec x, SlipElasticPair **pair); /* of x, likewise */
PETSC_INTERN PetscErrorCode SlipElasticTakePair(SlipElastic el, Vec x,
                                                SlipElasticPair **pair); /* instead of the oldest */
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
