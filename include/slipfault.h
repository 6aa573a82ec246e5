/* The strike-slip fault as a TS problem: parameters, friction laws, observables and output */
#pragma once
#include <petscts.h>
#include <slipmat.h>
#include <slipcore.h>
#include <slipsnes.h>
#include <slipts.h>
#include <slipsys.h>
#include <slipoutput.h>

/* A fault: its mesh, parameters and operators. */
typedef struct _p_SlipFault *SlipFault;
PETSC_EXTERN PetscClassId SLIP_FAULT_CLASSID;

PETSC_EXTERN PetscErrorCode SlipFaultCreate(MPI_Comm comm, SlipFault *fault); /* reference case "3 km", one cell */
PETSC_EXTERN PetscErrorCode SlipFaultSetFromOptions(SlipFault fault);         /* -fault_* */
/* Sets or gets any scalar parameter by its option's name without "fault_": "length_x", "thickness", "nx", ... */
PETSC_EXTERN PetscErrorCode SlipFaultSetReal(SlipFault fault, const char name[], PetscReal value);
PETSC_EXTERN PetscErrorCode SlipFaultGetReal(SlipFault fault, const char name[], PetscReal *value);
/* Sets a choice or a file name likewise: "friction_law", "operator", "viscosity", "initial", "mesh", ... */
PETSC_EXTERN PetscErrorCode SlipFaultSetString(SlipFault fault, const char name[], const char value[]);
/* Sets a parameter cell by cell, as a dataset of -fault_parameters does: values [n = nx nz, or the cells of a mesh in
   the order of its file], all on every rank. */
PETSC_EXTERN PetscErrorCode SlipFaultSetField(SlipFault fault, const char name[], PetscInt n, const PetscReal values[]);
/* Sets a switch: "inertia", "initial_unstable", "check_error", "output_overwrite", "output_xdmf", "progress",
   "catalogue_maps". */
PETSC_EXTERN PetscErrorCode SlipFaultSetBool(SlipFault fault, const char name[], PetscBool value);
PETSC_EXTERN PetscErrorCode SlipFaultGetString(SlipFault fault, const char name[], char value[], size_t len);
/* Gets values of all cells on every rank, in the order of the grid or of the mesh's file, after SlipFaultSetUp(). */
PETSC_EXTERN PetscErrorCode SlipFaultGetField(SlipFault fault, const char name[], PetscInt n, PetscReal values[]);
/* Gets "x", "y", "z" [m], "area" [m^2], "strike", "dip" [degrees] or "fault", after SlipFaultSetUpMesh(). */
PETSC_EXTERN PetscErrorCode SlipFaultGetGeometry(SlipFault fault, const char name[], PetscInt n, PetscReal values[]);
PETSC_EXTERN PetscErrorCode SlipFaultWriteCells(SlipFault fault, const char file[]);
PETSC_EXTERN PetscErrorCode SlipFaultGetCentres(SlipFault fault, PetscInt n, PetscReal x[], PetscReal y[],
                                                PetscReal z[]);
PETSC_EXTERN PetscErrorCode SlipFaultGetCellComponents(SlipFault fault, const char name[], PetscInt *n);
PETSC_EXTERN PetscErrorCode SlipFaultGetCellValues(SlipFault fault, PetscReal t, Vec w, const char name[], PetscInt n,
                                                   PetscReal values[]);
PETSC_EXTERN PetscErrorCode SlipFaultGetLabels(SlipFault fault, PetscInt size, PetscInt *n, PetscInt label[]);
PETSC_EXTERN PetscErrorCode SlipFaultGetEvents(SlipFault fault, const char column[], PetscInt size, PetscInt *n,
                                               PetscReal values[]);
/* Computes the pore pressure p [n] in Pa of the n cells of this process at t [s], in the order of the state. */
typedef PetscErrorCode (*SlipFaultPressureFn)(SlipFault fault, PetscReal t, PetscInt n, PetscReal p[], void *ctx);
PETSC_EXTERN PetscErrorCode
SlipFaultRegisterFrictionLaw(const SlipFrictionLaw *law); /* adds a friction law with its parameters; slipcore.h */
PETSC_EXTERN PetscErrorCode
SlipFaultRegisterPermeabilityLaw(const SlipPermeabilityLaw *law); /* adds a permeability law; slipcore.h */
PETSC_EXTERN PetscErrorCode SlipFaultSetPressureFunction(SlipFault fault, SlipFaultPressureFn function, void *ctx);
PETSC_EXTERN PetscErrorCode SlipFaultAddStress(SlipFault fault, PetscInt rows, const PetscReal time[],
                                               const PetscReal course[], PetscInt nshear, const PetscReal shear[],
                                               PetscInt nnormal, const PetscReal normal[]);
PETSC_EXTERN PetscErrorCode SlipFaultSetUpMesh(SlipFault fault); /* creates the cells, which fields may need */
PETSC_EXTERN PetscErrorCode SlipFaultSetUp(SlipFault fault);     /* creates K, H, parameters and the critical state */
PETSC_EXTERN PetscErrorCode SlipFaultView(SlipFault fault, PetscViewer viewer);
/* memory and time on numbers of processes, for a mesh */
PETSC_EXTERN PetscErrorCode SlipFaultPlan(SlipFault fault, PetscInt n, const PetscInt size[], PetscViewer viewer);
PETSC_EXTERN PetscErrorCode SlipFaultFeaturesView(PetscViewer viewer); /* which features can be combined */
PETSC_EXTERN PetscErrorCode SlipFaultDestroy(SlipFault *fault);
/* The prefix "upper_" turns -fault_nx into -upper_fault_nx. */
PETSC_EXTERN PetscErrorCode SlipFaultSetOptionsPrefix(SlipFault fault, const char prefix[]);
PETSC_EXTERN PetscErrorCode SlipFaultAppendOptionsPrefix(SlipFault fault, const char prefix[]);
PETSC_EXTERN PetscErrorCode SlipFaultGetOptionsPrefix(SlipFault fault, const char *prefix[]);

/* The state w has the block size 3, (v, u, s) per cell [m/s, m, m], or more with two components of slip or several
   states of friction; cell e = iz * nx + ix; PETSc's default distribution of cells. */
PETSC_EXTERN PetscErrorCode SlipFaultCreateState(SlipFault fault, Vec *w);
PETSC_EXTERN PetscErrorCode SlipFaultSetInitialState(SlipFault fault, Vec w);
/* SlipFaultConfigureTS() makes a TS of type bathe (which -ts_type may change afterwards), with smooth right-hand side,
   constraint, reference tolerances, max time 30 s, unlimited rejections and SNES failures, and the functions that
   controllers call (TSSetSlipProblem()). Call TSSetFromOptions() after it. */
PETSC_EXTERN PetscErrorCode SlipFaultConfigureTS(SlipFault fault, TS ts);
PETSC_EXTERN PetscErrorCode SlipFaultGetOperators(SlipFault fault, Mat *K, Mat *H, PetscReal *mass); /* borrowed */
/* Gets the friction of the local cells, with borrowed arrays. */
PETSC_EXTERN PetscErrorCode SlipFaultGetFriction(SlipFault fault, PetscReal t, SlipFrictionCells *friction);

typedef struct {
  PetscReal mean_slip_rate, max_slip_rate;                /* [m/s], max of |v| */
  PetscReal mean_slip;                                    /* cumulative s [m] */
  PetscReal mean_displacement;                            /* u [m] */
  PetscReal sliding_fraction;                             /* share of cells with v != 0 */
  PetscReal kinetic, elastic;                             /* mean energy per unit area [J/m^2] */
  PetscReal viscous_power, friction_power, loading_power; /* mean [W/m^2] at the time of the state */
} SlipFaultObservables;
/* r: the reaction, or NULL */
PETSC_EXTERN PetscErrorCode SlipFaultGetObservables(SlipFault fault, PetscReal t, Vec w, Vec r,
                                                    SlipFaultObservables *obs);

/* Elastic shear stress on each cell [Pa], positive if it drives slip forward */
PETSC_EXTERN PetscErrorCode SlipFaultStress(SlipFault fault, PetscReal t, Vec w, Vec T);

/* -fault_catalogue writes a row per event to a file of its own: /onset, /end, /x, /y, /z, /cell, /area, /mean_slip,
   /max_slip, /direction, /moment, /magnitude, /stress_drop, /peak_slip_rate, /elastic_energy, /kinetic_energy,
   /dissipated_energy, /radiated_energy, /loading_work, /energy_residual, /steps, /fault, /rake, /rupture_speed,
   /radiated_efficiency, /goes_on, /images [event], for several faults /fault_moment and others [event, faults],
   /mesh (centres), and /maps/slip, /maps/rupture_time as [event, Nz, Nx], or [event, N] of a mesh; output/README.md
   defines them. -fault_output writes the file of slipoutput.h by monitors, with /parameters (scalars and choices),
   /mesh (x, z of the centres [m], per-cell parameters) and /fields (time, and slip_rate, slip, displacement, traction,
   state, pore_pressure as [n, Nz, Nx], or [n, N] of a mesh), with -fault_stations /stations/K (K = 0, 1, ...; time,
   slip, slip_rate, traction, state at the start and every accepted step; attributes x, z, cell, cell_x, cell_z), with
   -fault_surface_stations /ground (time, displacement and velocity [n, stations, 3]) and /ground_points (x, y), and
   /surface/K (time, displacement and velocity [n, 3]; attributes x, y); /xdmf (corners of the cells) and FILE.xdmf2
   beside it. SlipFaultOutputStart() opens the files; SlipFaultOutputFinish() writes /result and /run and renames. */
PETSC_EXTERN PetscErrorCode SlipFaultOutputStart(SlipFault fault, TS ts);
/* Before a sweep: raises an error that names the lines if two of n runs write one file. */
PETSC_EXTERN PetscErrorCode SlipFaultCheckSweepFiles(MPI_Comm comm, PetscInt n, const PetscOptions options[],
                                                     const PetscInt line[]);
PETSC_EXTERN PetscErrorCode SlipFaultOutputFinish(SlipFault fault, TS ts, PetscReal wall_setup, PetscReal wall_solve);
/* An observer of runs of faults; any function may be NULL, see SlipFaultRegisterObserver(). */
typedef struct {
  const char *name;
  PetscErrorCode (*create)(SlipFault fault, TS ts, PetscBool *wanted, void **ctx);
  PetscErrorCode (*layout)(SlipFault fault, SlipOutput output, void *ctx);
  PetscErrorCode (*start)(SlipFault fault, TS ts, PetscReal time, Vec w, void *ctx);
  PetscErrorCode (*step)(SlipFault fault, TS ts, PetscInt step, PetscReal time, Vec w, void *ctx);
  PetscErrorCode (*visit)(SlipFault fault, SlipState state, void *ctx);
  PetscErrorCode (*finish)(SlipFault fault, TS ts, SlipOutput output, void *ctx);
  PetscErrorCode (*destroy)(void **ctx);
  void *ctx;         /* what create() finds in ctx */
  PetscBool repeats; /* it also observes the repetition of -fault_check_error */
} SlipFaultObserver;
PETSC_EXTERN PetscErrorCode SlipFaultRegisterObserver(const SlipFaultObserver *observer);
/* Start and end of -fault_checkpoint, -fault_restart and -fault_wall_limit; code is the exit code of a run that was
   stopped early, else 0. */
PETSC_EXTERN PetscErrorCode SlipFaultCheckpointStart(SlipFault fault, TS ts);
PETSC_EXTERN PetscErrorCode SlipFaultCheckpointFinish(SlipFault fault, TS ts, int *code);
PETSC_EXTERN PetscErrorCode SlipFaultReportEnd(SlipFault fault, TS ts, PetscBool *complete);
PETSC_EXTERN PetscErrorCode SlipFaultReportStop(SlipFault fault, TS ts, PetscReal wall_setup, PetscReal wall_solve);
