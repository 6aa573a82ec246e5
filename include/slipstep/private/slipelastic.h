/* Inside the medium: the object, and the operations of the type that all others fall back on. */
#pragma once
#include <petsc/private/petscimpl.h>
#include <slipelastic.h>
#include <slipmat.h>
#include <slipcompat.h>

struct _p_SlipElastic {
  PETSCHEADER(SlipElasticOps);
  void *data;          /* of the type */
  Mat K, Kn, H;        /* stiffness [Pa/m], what slip does to normal stress, NULL: nothing, viscosity [Pa s/m] */
  Mat B;               /* stage operator of K and H */
  Mat stage, coupling; /* of the last stage, borrowed from the type */
  Vec diagonal[2];     /* of K and H, once they have been asked for */
  Vec work[2];         /* of slip, on first use */

  SlipElasticPast past[2]; /* the slots */
  PetscBool known;         /* they hold something */
  PetscBool trial;         /* slot 1 is within an attempt */

  PetscReal mass;      /* of the rock [kg/m^2] */
  PetscInt components; /* of slip */
  PetscInt *number;    /* of each cell of this process; NULL: that of its row */
  PetscReal frequency; /* the largest [rad/s]; 0: not asked for yet */
};

/* static.c */
PETSC_INTERN const SlipElasticOps SlipElasticStatic;
/* elastic.c */
PETSC_INTERN PetscErrorCode SlipElasticGetWork(SlipElastic el, PetscInt n, Vec *work); /* n is 0 or 1 */
