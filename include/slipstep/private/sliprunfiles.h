/* What a run of a fault leaves behind: its output with fields, stations and the file for ParaView, and the catalogue of
   events. */
#pragma once
#include <slipstep/private/sliprun.h>

/* ---- faultoutput.c, faultfile.c: what the output of a fault adds to that of any run: its mesh and its fields ---- */
/* Fields of /fields: components of the state, but traction, the reaction; pore pressure, of the time; normal stress, of
   both; and slip of a fault that heals, which is not s. Of a law with several states the others come behind the
   last. */
typedef enum {
  OUTPUT_SLIP_RATE,
  OUTPUT_DISPLACEMENT,
  OUTPUT_SLIP,
  OUTPUT_TRACTION,
  OUTPUT_STATE,
  OUTPUT_PORE_PRESSURE,
  OUTPUT_NORMAL_STRESS,
  OUTPUT_OPENING,
  OUTPUT_NUM_FIELDS
} SlipOutputFieldId;
enum { OUTPUT_MAX_FIELDS = OUTPUT_NUM_FIELDS + SLIP_MAX_STATES - 1 };

/* outputwhen.c: what decides about the next entry of /fields */
typedef struct {
  PetscBool known;      /* there was an entry, or a checkpoint that remembers it */
  PetscReal time;       /* of the last accepted step [s] */
  PetscReal entry_time; /* of the newest entry, of the run [s] */
  PetscReal entry_rate; /* largest slip rate then [m/s] */
  Vec entry_u;          /* displacement then [m]; NULL without -fault_output_slip_interval */
  PetscReal most;       /* entries there may be, by -fault_output_size; 0: no bound */
} SlipFaultWhen;

typedef struct {
  SlipFault fault; /* borrowed */
  PetscMPIInt rank;
  TS ts; /* borrowed */
  PetscBool wanted[OUTPUT_MAX_FIELDS];
  PetscBool rests;          /* /fields has time_rest */
  PetscBool resumed;        /* goes on in the file of an earlier run */
  PetscInt last_field_step; /* step of the newest entry of /fields */
  Vec w0, r0, p0, n0;       /* state, reaction, pore pressure and normal stress gathered on rank 0 */
  Vec c0;                   /* any vector of cells, likewise */
  Vec numbers;              /* before they are gathered */
  Vec shown;                /* state as /fields have it, where that is not w */
  Vec start0, vinf0;        /* rank 0, of a fault that heals: displacement of the start [m] and loading rate [m/s] */
  VecScatter gather_w, gather_r, gather_c;
  SlipFaultWhen when;
} * SlipFaultOutput;

PETSC_EXTERN PetscErrorCode SlipFaultOutputCreateRun(SlipFaultOutput out, TS ts); /* collective, no file as yet */
PETSC_EXTERN PetscErrorCode SlipFaultOutputFields(SlipFaultOutput out, PetscReal time, Vec w);
PETSC_EXTERN PetscErrorCode SlipFaultOutputLayout(SlipFault fault, SlipOutput output, void *ctx);
PETSC_INTERN PetscInt SlipFaultOutputCount(SlipFault fault); /* of fields that there may be */
PETSC_EXTERN const char *SlipFaultOutputField(SlipFault fault, PetscInt f);
PETSC_EXTERN PetscErrorCode SlipFaultNameDimensions(SlipFault fault, SlipH5 *h, const char group[], const char row[]);
PETSC_INTERN PetscInt SlipFaultOutputComponents(SlipFault fault, PetscInt f);
PETSC_EXTERN PetscErrorCode SlipFaultOutputState(SlipFaultOutput out, SlipState s); /* collective: what it remembers */

PETSC_EXTERN PetscErrorCode SlipFaultOutputWhenCheck(SlipFault fault);
PETSC_EXTERN PetscErrorCode SlipFaultOutputIsDue(SlipFaultOutput out, PetscInt step, PetscReal time, Vec w,
                                                 PetscBool *due);
PETSC_EXTERN PetscErrorCode SlipFaultOutputWasWritten(SlipFaultOutput out, PetscReal time, Vec w);
PETSC_EXTERN PetscErrorCode SlipFaultOutputSize(SlipFaultOutput out, TS ts); /* prints it */
/* Shape of a field in a file, [Nz, Nx], or [n] for a mesh: number of dimensions */

/* ---- catalogue.c, cataloguestep.c, cataloguewithin.c, cataloguerow.c, cataloguefile.c: events, a row each ---- */
/* What is integrated over an event; of several faults what friction dissipates on each comes behind these. */
typedef enum { WORK_RADIATED, WORK_DISSIPATED, WORK_LOADING, FAULT_NUM_WORKS } SlipFaultWorkId;

/* The event under way */
typedef struct {
  PetscReal onset;            /* [s] */
  PetscReal elastic, kinetic; /* energies at the onset [J] */
  PetscReal peak;             /* largest slip rate so far [m/s] */
  PetscReal time[2], rate[2]; /* ends of the last two steps [s], largest slip rates there [m/s] */
  PetscInt cell;              /* hypocentre, as the file numbers cells */
  PetscInt steps;
  PetscBool images; /* it began while waves of images of earlier events may have been under way */
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
  /* where there are several, a number for each fault */
  EVENT_FAULT_MOMENT = EVENT_NUM_COLUMNS,
  EVENT_FAULT_AREA,
  EVENT_FAULT_MEAN_SLIP,
  EVENT_FAULT_STRESS_DROP,
  EVENT_FAULT_ONSET,
  EVENT_FAULT_CELL,
  EVENT_FAULT_DISSIPATED_ENERGY,
  EVENT_ALL_COLUMNS
} SlipEventColumn;

/* A step of an event, and what of it is known: states at its nodes, from its start, or the onset in it, to its end */
#define SLIP_EVENT_NODES 3
#define SLIP_EVENT_HALVINGS 3
typedef struct {
  TS ts;
  PetscReal begin, dt; /* [s] */
  PetscInt nodes;
  PetscReal share[SLIP_EVENT_NODES], weight[SLIP_EVENT_NODES]; /* weights of TSBATHE */
  Vec node[SLIP_EVENT_NODES];                                  /* borrowed */
  PetscInt side;      /* of where the bound is passed, all is slower before (-1), after (1); 0: it is not */
  PetscReal cut;      /* the share at which it is */
  PetscInt slow;      /* TSBATHE: the node on its slow side */
  PetscBool simpson;  /* explicit steps of TSBATHE without inertia */
  PetscBool straight; /* TSLAPUSTA, within whose steps slip rates are constant: states lie on a straight line */
  PetscBool dense;    /* TSInterpolate() follows the solution */
  PetscBool sloped;   /* slopes of its ends are known */
  PetscBool sticks;   /* friction sticks without states of its own: those slopes are the rates there */
} SlipEventStep;

struct _n_SlipFaultCatalogue {
  SlipFault fault; /* borrowed */
  PetscMPIInt rank;
  PetscBool maps;           /* slip and rupture time of each cell as well */
  PetscBool begun, resumed; /* the file is there; it is that of an earlier run, cut */
  SlipH5Kind kind;
  SlipH5 file;          /* rank 0 */
  PetscBool unflushed;  /* rows that are not on the disk */
  SlipTable table;      /* rank 0: the columns */
  PetscReal last_end;   /* of the newest row, of the run [s] */
  PetscReal slip_since; /* onset of the first event whose waves of images may be under way, of the run [s] */
  PetscReal origin;     /* what the times below count from [s] */
  PetscBool active;     /* an event is under way */
  PetscBool ended;      /* it is slower than its bound, and has this row unless it goes on */
  PetscInt nrow, nwork; /* lengths of the next arrays */
  PetscReal *row;       /* its slip is in slip; of several faults each one's numbers are a column after the other */
  SlipFaultEvent event; /* and how far it is */
  PetscReal *work;      /* since its onset [J] */
  PetscInt
    *hypocentre;   /* [faults] of each, as the file numbers cells; -1: it has not broken. NULL: there is one fault */
  Vec u0, stress0; /* displacement [m] and shear stress [Pa] at its onset */
  Vec rupture;     /* when each cell exceeded the rate, after the onset [s]; -1: not yet */
  Vec before;      /* with other integrators than TSBATHE: state of the step before, else NULL */
  PetscReal time_before; /* its time [s] */
  Vec stress, slip;      /* work: shear stress [Pa], slip of the event [m] */
  /* cataloguestep.c: states within a step, where the bound is passed and elsewhere, slopes of its ends; powers [nwork]
     of the end of the last step and, for work, of this one, of where the bound is passed and within; integrals [nwork]
     over a step */
  Vec cut, middle, within, slope[2];
  PetscBool power_known; /* that of the end of the last step is */
  PetscBool unbroken;    /* friction that sticks: cells that have not exceeded the rate in this event */
  PetscBool push_known;  /* of the end of the last step is: */
  Vec push;              /* SlipFaultStickingPush() of the state before; NULL: of no step as yet */
  PetscReal *power, *next, *cut_power, *inner, *sum, *fast, *slow;
  PetscReal *romberg;              /* [SLIP_EVENT_HALVINGS + 1][nwork] */
  VecScatter gather, gather_cells; /* maps, of vectors of slip and of cells, on rank 0 */
  Vec map[2];
};

/* cataloguefile.c: times that were noted count from the origin of now */
PETSC_INTERN void SlipCatalogueFollowOrigin(SlipFaultCatalogue cat);

/* cataloguestep.c; collective */
PETSC_INTERN PetscErrorCode SlipCatalogueGetStep(SlipFaultCatalogue cat, TS ts, PetscReal time, Vec w,
                                                 SlipEventStep *step);
PETSC_INTERN PetscErrorCode SlipCatalogueCross(SlipFaultCatalogue cat, SlipEventStep *step, PetscBool upwards);
PETSC_INTERN PetscErrorCode SlipCatalogueIntegrate(SlipFaultCatalogue cat, SlipEventStep *step, PetscReal fast[],
                                                   PetscReal slow[]);
PETSC_INTERN PetscErrorCode SlipCatalogueMarkRuptured(SlipFaultCatalogue cat, const SlipEventStep *step);

/* cataloguewithin.c; collective. Powers [nwork] of a state [W], a product with H; the state w at a share of the step,
   and unless NULL its powers */
PETSC_INTERN PetscErrorCode SlipCataloguePowers(SlipFaultCatalogue cat, PetscReal t, Vec w, PetscReal power[]);
PETSC_INTERN PetscErrorCode SlipCatalogueMiddlePowers(SlipFaultCatalogue, const SlipEventStep *, Vec w,
                                                      PetscReal power[]);
PETSC_INTERN PetscErrorCode SlipCatalogueStateWithin(SlipFaultCatalogue cat, SlipEventStep *step, PetscReal share,
                                                     Vec w, PetscReal power[]);

/* cataloguerow.c: numbers of an event. Energies of a state, elastic and kinetic [J]; the fastest cells of n groups,
   group NULL: all cells are one, max [n]: how fast those are, cell [n]: N where none is; the row of the event that
   ends in the state w: its slip, counted along that of the cells that ruptured, is in cat->slip. All collective */
PETSC_EXTERN PetscErrorCode SlipCatalogueEnergies(SlipFault fault, PetscReal t, Vec w, PetscReal *elastic,
                                                  PetscReal *kinetic);
PETSC_EXTERN PetscErrorCode SlipCatalogueFastest(SlipFault fault, Vec w, PetscInt n, const PetscInt group[],
                                                 const PetscReal max[], PetscInt cell[]);
PETSC_INTERN PetscErrorCode SlipCatalogueFirstToSlip(SlipFaultCatalogue cat, PetscReal t, Vec w, PetscInt *first);
PETSC_EXTERN PetscErrorCode SlipCatalogueHypocentres(SlipFaultCatalogue cat, PetscReal dt, Vec w);
PETSC_EXTERN PetscErrorCode SlipCatalogueFillRow(SlipFaultCatalogue cat, PetscReal end, Vec w);

/* The file; collective */
PETSC_EXTERN PetscErrorCode SlipCatalogueBegin(SlipFaultCatalogue cat); /* unless it is there */
PETSC_EXTERN PetscErrorCode SlipCatalogueFlush(SlipFaultCatalogue cat); /* when it is due */
PETSC_EXTERN PetscErrorCode SlipCatalogueSync(SlipFaultCatalogue cat);
PETSC_EXTERN PetscErrorCode SlipCatalogueClose(SlipFaultCatalogue cat, PetscBool complete);
PETSC_EXTERN PetscErrorCode SlipCatalogueVisit(SlipFault fault, SlipState s, void *ctx);
PETSC_EXTERN PetscErrorCode SlipCatalogueAdd(SlipFaultCatalogue cat);
/* rank 0 */
PETSC_INTERN PetscErrorCode SlipCatalogueReadColumn(SlipFaultCatalogue cat, SlipEventColumn column, PetscInt *n,
                                                    PetscReal **values);
