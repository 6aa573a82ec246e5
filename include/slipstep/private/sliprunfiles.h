/* The files of a run of a fault: its output with fields and stations, the file for ParaView, the catalogue of events */
#pragma once
#include <slipstep/private/sliprun.h>

/* ---- faultoutput.c, faultfile.c: the additions of a fault to the output of a run: its mesh and its fields ---- */
/* Fields of /fields: components of the state, except that traction is the reaction, pore pressure depends on time,
   normal stress on both, and slip of a fault that heals is not s. Further states of a law follow at the end. */
typedef enum {
  OUTPUT_SLIP_RATE,
  OUTPUT_DISPLACEMENT,
  OUTPUT_SLIP,
  OUTPUT_TRACTION,
  OUTPUT_STATE,
  OUTPUT_PORE_PRESSURE,
  OUTPUT_NORMAL_STRESS,
  OUTPUT_TEMPERATURE,
  OUTPUT_ZONE_PRESSURE,
  OUTPUT_PERMEABILITY,
  OUTPUT_FLUID_FLUX,
  OUTPUT_OPENING,
  OUTPUT_NUM_FIELDS
} SlipOutputFieldId;
enum { OUTPUT_MAX_FIELDS = OUTPUT_NUM_FIELDS + SLIP_MAX_STATES - 1 };

/* Conditions for the next entry of /fields */
typedef struct {
  PetscBool known;      /* there was an entry, also before a checkpoint */
  PetscReal time;       /* of the last accepted step [s] */
  PetscReal entry_time; /* of the newest entry, of the run [s] */
  PetscReal entry_rate; /* largest slip rate then [m/s] */
  Vec entry_u;          /* displacement then [m]; NULL without -fault_output_slip_interval */
  PetscReal most;       /* largest number of entries, by -fault_output_size; 0: no bound */
} SlipFaultWhen;

typedef struct {
  SlipFault fault; /* borrowed */
  PetscMPIInt rank;
  TS ts; /* borrowed */
  PetscBool wanted[OUTPUT_MAX_FIELDS];
  PetscBool rests;           /* /fields has time_rest */
  PetscBool resumed;         /* continues the file of an earlier run */
  PetscInt last_field_step;  /* step of the newest entry of /fields */
  Vec w0, r0;                /* state and reaction gathered on rank 0 */
  Vec of[OUTPUT_NUM_FIELDS]; /* fields that are no part of these, likewise; NULL: not written */
  Vec c0;                    /* any vector of cells, likewise */
  Vec numbers;               /* not gathered yet */
  Vec shown;                 /* state as in /fields, unless that is w */
  Vec start0, vinf0;         /* rank 0, for a fault that heals: displacement of the start [m], loading rate [m/s] */
  VecScatter gather_w, gather_r, gather_c;
  SlipFaultWhen when;
} * SlipFaultOutput;

PETSC_EXTERN PetscErrorCode SlipFaultOutputCreateRun(SlipFaultOutput out, TS ts); /* collective, without a file yet */
PETSC_INTERN PetscErrorCode SlipFaultSeriesCreate(SlipFault fault, TS ts);        /* faultseries.c */
PETSC_INTERN PetscErrorCode SlipFaultSeriesName(SlipFault fault, SlipH5 *h);
PETSC_EXTERN PetscErrorCode SlipFaultOutputFields(SlipFaultOutput out, PetscReal time, Vec w);
PETSC_EXTERN PetscErrorCode SlipFaultOutputLayout(SlipFault fault, SlipOutput output, void *ctx);
PETSC_INTERN PetscInt SlipFaultOutputCount(SlipFault fault); /* possible number of fields */
PETSC_EXTERN const char *SlipFaultOutputField(SlipFault fault, PetscInt f);
PETSC_EXTERN PetscErrorCode SlipFaultNameDimensions(SlipFault fault, SlipH5 *h, const char group[], const char row[]);
PETSC_INTERN PetscInt SlipFaultOutputComponents(SlipFault fault, PetscInt f);

/* ---- catalogue.c, cataloguestep.c, cataloguewithin.c, cataloguerow.c, cataloguefile.c: events, a row each ---- */
/* Quantities integrated over an event; with several faults, the dissipation of friction on each follows. */
typedef enum { WORK_RADIATED, WORK_DISSIPATED, WORK_LOADING, FAULT_NUM_WORKS } SlipFaultWorkId;

/* The present event */
typedef struct {
  PetscReal onset;            /* [s] */
  PetscReal elastic, kinetic; /* energies at the onset [J] */
  PetscReal peak;             /* largest slip rate so far [m/s] */
  PetscReal pressure;         /* of pore fluid at the hypocentre at the onset, where fluid diffuses [Pa] */
  PetscReal time[2], rate[2]; /* ends of the last two steps [s], largest slip rates there [m/s] */
  PetscInt cell;              /* hypocentre, numbered as in files */
  PetscInt steps;
  PetscBool images; /* waves of images of earlier events may have been present at the onset */
} SlipFaultEvent;

typedef enum {
  EVENT_ONSET,
  EVENT_END,
  EVENT_X,
  EVENT_Y,
  EVENT_Z,
  EVENT_CELL,
  EVENT_AREA,
  EVENT_MEAN_SLIP,
  EVENT_MAX_SLIP,
  EVENT_DIRECTION,
  EVENT_MOMENT,
  EVENT_MAGNITUDE,
  EVENT_STRESS_DROP,
  EVENT_PEAK_SLIP_RATE,
  EVENT_ELASTIC_ENERGY,
  EVENT_KINETIC_ENERGY,
  EVENT_DISSIPATED_ENERGY,
  EVENT_RADIATED_ENERGY,
  EVENT_LOADING_WORK,
  EVENT_ENERGY_RESIDUAL,
  EVENT_STEPS,
  EVENT_FAULT,
  EVENT_RAKE,
  EVENT_RUPTURE_SPEED,
  EVENT_RADIATED_EFFICIENCY,
  EVENT_GOES_ON,
  EVENT_IMAGES,
  EVENT_NUM_COLUMNS,
  /* one number per fault, if there are several */
  EVENT_FAULT_MOMENT = EVENT_NUM_COLUMNS,
  EVENT_FAULT_AREA,
  EVENT_FAULT_MEAN_SLIP,
  EVENT_FAULT_STRESS_DROP,
  EVENT_FAULT_ONSET,
  EVENT_FAULT_CELL,
  EVENT_FAULT_DISSIPATED_ENERGY,
  EVENT_ALL_COLUMNS
} SlipEventColumn;
/* Where pore fluid diffuses in the fault, two more follow, which are the last ones of a row: the distance from the
   hypocentre to the nearest well, and the pressure there at the onset. */
enum { EVENT_FLUID_COLUMNS = 2 };

/* A step of an event and its cached data: states at its nodes, from its start, or the onset in it, to its end */
#define SLIP_EVENT_NODES 3
#define SLIP_EVENT_HALVINGS 3
typedef struct {
  TS ts;
  PetscReal begin, dt; /* [s] */
  PetscInt nodes;
  PetscReal share[SLIP_EVENT_NODES], weight[SLIP_EVENT_NODES]; /* weights of TSBATHE */
  Vec node[SLIP_EVENT_NODES];                                  /* borrowed */
  PetscInt side;      /* side of the crossing of the bound on which all is slower: before (-1), after (1); 0: none */
  PetscReal cut;      /* its fraction of the step */
  PetscInt slow;      /* TSBATHE: the last node on its slow side */
  PetscBool simpson;  /* explicit steps of TSBATHE without inertia */
  PetscBool straight; /* TSLAPUSTA, whose slip rates are constant in a step: states lie on a straight line */
  PetscBool dense;    /* TSInterpolate() is accurate */
  PetscBool sloped;   /* slopes at its ends are available */
  PetscBool sticks;   /* friction sticks without its own states: those slopes are the rates there */
} SlipEventStep;

struct _n_SlipFaultCatalogue {
  SlipFault fault; /* borrowed */
  PetscMPIInt rank;
  PetscBool maps;           /* slip and rupture time of each cell are stored, too */
  PetscBool begun, resumed; /* the file exists; it is that of an earlier run, truncated */
  SlipH5Kind kind;
  SlipH5 file;           /* rank 0 */
  PetscBool unflushed;   /* some rows are not on the disk */
  SlipTable table;       /* rank 0: the columns */
  PetscReal last_end;    /* of the newest row, of the run [s] */
  PetscReal slip_since;  /* onset of the first event whose image waves may still be present, of the run [s] */
  PetscReal origin;      /* origin of the times below [s] */
  PetscBool active;      /* there is an event now */
  PetscBool ended;       /* it is slower than its bound; this is its row unless it continues */
  PetscInt nrow, nwork;  /* lengths of the next arrays */
  PetscReal *row;        /* its slip is in slip; numbers of several faults follow one another */
  SlipFaultEvent event;  /* and its progress */
  PetscReal *work;       /* since its onset [J] */
  PetscInt *hypocentre;  /* [faults] of each, numbered as in files; -1: no rupture yet. NULL: there is one fault */
  Vec u0, stress0;       /* displacement [m] and shear stress [Pa] at its onset */
  Vec rupture;           /* when each cell exceeded the rate, after the onset [s]; -1: not yet */
  Vec before;            /* with other integrators than TSBATHE: the previous state, else NULL */
  PetscReal time_before; /* its time [s] */
  Vec stress, slip;      /* work: shear stress [Pa], slip of the event [m] */
  /* cataloguestep.c: states in a step, at the crossing of the bound and elsewhere, slopes at its ends; powers [nwork]
     at the end of the last step and, as work space, of this one, at the crossing and inside; integrals [nwork] */
  Vec cut, middle, within, slope[2];
  PetscBool power_known; /* that at the end of the last step is valid */
  PetscBool unbroken;    /* friction that sticks: cells that have not exceeded the rate in this event */
  PetscBool push_known;  /* valid for the end of the last step: */
  Vec push;              /* SlipFaultStickingPush() of the previous state; NULL: no step yet */
  PetscReal *power, *next, *cut_power, *inner, *sum, *fast, *slow;
  PetscReal *romberg;              /* [SLIP_EVENT_HALVINGS + 1][nwork] */
  VecScatter gather, gather_cells; /* for maps, of vectors of slip and of cells, on rank 0 */
  Vec map[2];
};

/* cataloguefile.c: converts stored times to the present origin */
PETSC_INTERN void SlipCatalogueFollowOrigin(SlipFaultCatalogue cat);

/* cataloguestep.c; collective */
PETSC_INTERN PetscErrorCode SlipCatalogueGetStep(SlipFaultCatalogue cat, TS ts, PetscReal time, Vec w,
                                                 SlipEventStep *step);
PETSC_INTERN PetscErrorCode SlipCatalogueCross(SlipFaultCatalogue cat, SlipEventStep *step, PetscBool upwards);
PETSC_INTERN PetscErrorCode SlipCatalogueIntegrate(SlipFaultCatalogue cat, SlipEventStep *step, PetscReal fast[],
                                                   PetscReal slow[]);
PETSC_INTERN PetscErrorCode SlipCatalogueMarkRuptured(SlipFaultCatalogue cat, const SlipEventStep *step);

/* cataloguewithin.c; collective. Computes the powers [nwork] of a state [W], with a product with H; the state w at a
   fraction of the step, and its powers unless NULL */
PETSC_INTERN PetscErrorCode SlipCataloguePowers(SlipFaultCatalogue cat, PetscReal t, Vec w, PetscReal power[]);
PETSC_INTERN PetscErrorCode SlipCatalogueMiddlePowers(SlipFaultCatalogue, const SlipEventStep *, Vec w,
                                                      PetscReal power[]);
PETSC_INTERN PetscErrorCode SlipCatalogueStateWithin(SlipFaultCatalogue cat, SlipEventStep *step, PetscReal share,
                                                     Vec w, PetscReal power[]);

/* cataloguerow.c: numbers of an event, collective. Energies of a state, elastic and kinetic [J]; the fastest cells of n
   groups (group NULL: one group), their rates max [n], and their numbers cell [n], N if none slips; the row of the
   event that ends in the state w, whose slip, along that of the ruptured cells, is in cat->slip */
PETSC_EXTERN PetscErrorCode SlipCatalogueEnergies(SlipFault fault, PetscReal t, Vec w, PetscReal *elastic,
                                                  PetscReal *kinetic);
PETSC_EXTERN PetscErrorCode SlipCatalogueFastest(SlipFault fault, Vec w, PetscInt n, const PetscInt group[],
                                                 const PetscReal max[], PetscInt cell[]);
PETSC_INTERN PetscErrorCode SlipCatalogueFirstToSlip(SlipFaultCatalogue cat, PetscReal t, Vec w, PetscInt *first);
PETSC_EXTERN PetscErrorCode SlipCatalogueHypocentres(SlipFaultCatalogue cat, PetscReal dt, Vec w);
PETSC_EXTERN PetscErrorCode SlipCatalogueFillRow(SlipFaultCatalogue cat, PetscReal end, Vec w);

/* The file; collective */
PETSC_EXTERN PetscErrorCode SlipCatalogueBegin(SlipFaultCatalogue cat); /* unless it exists */
PETSC_EXTERN PetscErrorCode SlipCatalogueFlush(SlipFaultCatalogue cat); /* when it is due */
PETSC_EXTERN PetscErrorCode SlipCatalogueClose(SlipFaultCatalogue cat, PetscBool complete);
PETSC_EXTERN PetscErrorCode SlipCatalogueVisit(SlipFault fault, SlipState s, void *ctx);
PETSC_EXTERN PetscErrorCode SlipCatalogueAdd(SlipFaultCatalogue cat);
/* rank 0 */
PETSC_INTERN PetscErrorCode SlipCatalogueReadColumn(SlipFaultCatalogue cat, SlipEventColumn column, PetscInt *n,
                                                    PetscReal **values);
