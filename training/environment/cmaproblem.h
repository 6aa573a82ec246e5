/* A problem as CMA-ES sees it: instances that are drawn of a seed and kept ready for many runs, what a run costs, and
   the network that is trained. Faults, small models, users' problems and random equations have a row each. */
#pragma once
#include "family.h"
#include "problem.h"
#include <slipstep/rooms/slipcore.h>

enum {
  CMA_MAX_OBS = 24,
  CMA_MAX_LAYERS = 4,
  CMA_DIALS = 3, /* each episode of a validation runs at so many positions of the dial, where there is one */
  CMA_KINDS = 2  /* single cells and meshes; other problems have the first only */
};

typedef struct _RunKind RunKind; /* runs/runs.h */

/* The -train_ options of -train_algorithm cmaes */
typedef struct {
  const Problem *problem;
  Family *family; /* of the faults that are drawn; NULL: the trainer's own draws */
  PetscInt nobs;
  char *names[CMA_MAX_OBS];
  PetscReal scale[CMA_MAX_OBS], offset[CMA_MAX_OBS]; /* the network sees obs * scale + offset */
  PetscInt hidden, layers;                           /* width and number of the hidden layers */
  SlipActivation activation;                         /* of these */
  PetscInt more;                                     /* numbers that are trained besides the weights */
  PetscReal dt_min, dt_max;                          /* bounds of the action, logarithmic spacing */
  PetscReal moving;                                  /* longest step while anything moves [T*], 0: no limit */
  char dt_max_unit[8];                               /* "T*" or "t_max"; dt_min is in T* */
  PetscInt nsingle, nmesh, side;                     /* episodes of one cell, of meshes; cells along a side */
  PetscInt batch_single, batch_mesh;                 /* of a generation */
  PetscInt late_generations, late_single, late_mesh; /* at the end, and the episodes of one of these */
  PetscInt validation, calibration;                  /* episodes of each kind */
  PetscInt population;                               /* 0: CMA-ES's default */
  PetscInt diagonal;                                 /* generations with a diagonal covariance */
  PetscReal sigma;
  PetscInt generations;
  PetscReal minutes; /* wall time after which training ends */
  PetscInt interval; /* generations between validations */
  PetscInt seed;
  PetscReal low, high; /* range of the dial */
  PetscReal within;    /* share of either kind's runs that shall keep the dial everywhere in its range, 0: as trained */
  char output[PETSC_MAX_PATH_LEN], log[PETSC_MAX_PATH_LEN], checkpoint[PETSC_MAX_PATH_LEN], resume[PETSC_MAX_PATH_LEN];
  char first[PETSC_MAX_PATH_LEN];     /* a policy file whose network training begins with */
  char calibrate[PETSC_MAX_PATH_LEN]; /* a policy file: nothing is trained, its dial is calibrated anew */
  PetscReal move[2]; /* where it is moved to, as by CMAPolicy(), in place of a calibration by episodes */
  PetscBool moved;
} CMAOptions;

/* Of a run */
typedef struct {
  PetscInt solves;                   /* what it took: solves, evaluations, products with K */
  PetscInt attempts, failures;       /* steps that were tried, and those in vain */
  PetscReal error;                   /* by the episode's measure; of other problems their first error */
  PetscReal errors[SLIP_NUM_ERRORS]; /* of a fault */
  PetscReal done;                    /* share of the duration that was reached: 1 when finished */
  PetscReal cost;                    /* what CMA-ES minimises the mean of */
  PetscReal work;                    /* SlipProducts.cost [us], where it is counted */
} EpisodeResult;

/* Means over a validation. */
typedef struct {
  PetscReal cost, solves, within;       /* share of the runs within the dial */
  PetscReal error;                      /* geometric mean of error over dial */
  PetscReal failures;                   /* share of the attempts */
  PetscReal kept[CMA_KINDS][CMA_DIALS]; /* within, of either kind in each third of the dial's range, the finest first */
} CMAScore;

/* An observer of every observation vector [n] of a policy */
typedef void (*EpisodeWatchFn)(PetscInt n, const PetscReal obs[], void *ctx);

typedef enum {
  CMA_DIAL_NONE,  /* runs have no accuracy that is wanted */
  CMA_DIAL_SPREAD /* a generation's positions are spread evenly over the range, and validation's too; calibrated */
} CMADial;

struct _CMAProblem {
  const char *episodes; /* what they are called */
  uint64_t (*seed)(PetscInt seed, PetscInt stream, PetscInt64 k);
  PetscInt stream; /* the first of four: training, validation, generations, calibration */
  PetscInt first;  /* number of the first generation in its stream */
  CMADial dial;
  PetscBool kinds;        /* single cells and meshes; options speak of these */
  PetscBool start_counts; /* the start is validated as well */
  const char *measure;    /* what the dial bounds, for the policy's attribute; NULL: not said */
  const RunKind *runs;    /* of runs of the library; NULL: others */
  /* Observations, defaults of all numbers, activation. NULL: no policy of the problem is trained, it is for classical
     controllers */
  PetscErrorCode (*setup)(CMAOptions *o);
  void (*start)(const CMAOptions *o, double w[]); /* the first mean, w 0 on entry [CMACount()] */
  /* The action and attributes of a policy whose network is made. */
  PetscErrorCode (*policy)(const CMAOptions *o, const double w[], SlipPolicy policy);
  /* side: cells along a side at most, 1: one cell */
  PetscErrorCode (*create)(const CMAOptions *o, uint64_t seed, PetscInt side, void **episode);
  PetscErrorCode (*destroy)(void **episode);
  PetscErrorCode (*run)(void *episode, SlipPolicy policy, PetscReal accuracy, EpisodeResult *result);
  /* Under a classical controller in place of a policy, as "dsp" or with a named filter "dsp:PI42"; its cost is not set.
     NULL: the problem cannot */
  PetscErrorCode (*classical)(void *episode, TSAdaptType type, PetscReal rtol, EpisodeResult *result);
  PetscErrorCode (*watch)(void *episode, SlipPolicy policy, PetscReal accuracy, EpisodeWatchFn fn, void *ctx);
  PetscErrorCode (*say)(const CMAScore *score, char text[], size_t len); /* of a validation, for the line of progress */
};

/* Names that end with NULL, and the scaling that brings them to order one */
PETSC_INTERN PetscErrorCode CMAObservationsSet(CMAOptions *o, const char *const names[]);
/* An observation, scaled and shifted to order one; start: by how much it moves the logarithm of the ratio of steps at
   the start */
typedef struct {
  const char *name;
  double scale, offset, start;
} CMARow;
PETSC_INTERN PetscErrorCode CMARowsSet(CMAOptions *o, PetscInt n, const CMARow row[]);
PETSC_INTERN PetscInt CMACount(const CMAOptions *o); /* weights, and what is trained besides */
/* Position of an observation; -1: not observed */
PETSC_INTERN PetscInt CMAFind(const CMAOptions *o, const char name[]);
/* shift: decades by which the dial is moved before the network sees it, in the middle of its range, and per decade */
PETSC_INTERN PetscErrorCode CMAPolicy(const CMAOptions *o, const double w[], const PetscReal shift[2],
                                      SlipPolicy *policy);
