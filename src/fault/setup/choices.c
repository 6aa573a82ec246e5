/* The tables of the choices, texts and switches of a fault, beside that of its numbers in parameters.c. */
#include <slipstep/private/slipfault.h>
#include <slipstep/private/slipfaultregional.h>
#include <stddef.h>

#define PROBLEM SLIP_PART_PROBLEM
#define CONTENT SLIP_PART_CONTENT
#define STEPS SLIP_PART_STEPS
#define RUN SLIP_PART_RUN
#define OUTPUT SLIP_PART_OUTPUT

const SlipFaultString SlipFaultStrings[FAULT_NUM_STRINGS] = {
  [FAULT_FRICTION_LAW] = {"friction_law", "exponential_slip_weakening", "|rows of SlipFrictionLaws|", "Friction law",
                          PROBLEM},
  [FAULT_STATE_LAW] = {"state_law", "aging", "|aging|slip|composite|prz|",
                       "Evolution of the state of rate-and-state friction; prz: Perrin, Rice and Zheng", PROBLEM},
  [FAULT_MEDIUM] = {"medium", "static", "|types of SlipElasticRegister()|",
                    "What answers slip: static, at once, by stiffness and viscosity; or a type of "
                    "SlipElasticRegister()",
                    PROBLEM},
  [FAULT_KERNEL] = {"kernel", "half_space", "|half_space|full_space|mirror|",
                    "Elastic medium: with or without the free surface; mirror: the image of slip above the surface "
                    "stands for it, an approximation for slip along strike on vertical faults, exact where slip does "
                    "not vary along strike, with which -fault_medium waves has planes up to the ground",
                    PROBLEM},
  [FAULT_NORMAL_COUPLING] = {"normal_coupling", "auto", "|auto|yes|no|",
                             "Slip changes the normal stress, and so the strength; auto: yes for dipping faults, and "
                             "for vertical ones with a rake other than 0 or 180",
                             PROBLEM},
  [FAULT_INITIAL] = {"initial", "auto", "|auto|critical|rest|traction|rate|",
                     "Start: critical, at the frictional instability; rest, without stress; traction, under the shear "
                     "stress initial_traction; rate, at initial_rate under the stress that balances it; auto: "
                     "traction under -fault_regional_stress, rate for rate-and-state friction, else critical",
                     PROBLEM},
  [FAULT_OPERATOR] = {"operator", "auto", "|dense|fft|hmat|auto|",
                      "Storage of the stiffness; auto: fft on grids, dense up to 800 cells of a mesh, hmat above",
                      CONTENT},
  [FAULT_VISCOSITY] =
    {"viscosity", "auto", "|auto|sqrtm|spectral|lanczos|radiation|none|",
     "Viscosity H: sqrtm, exact matrix square root; spectral, one value per wavenumber; lanczos, exact in each product "
     "without set-up; radiation, radiation damping G/(2 cs); none; auto: radiation for rate-and-state friction and, "
     "without inertia, for -fault_initial traction, else sqrtm",
     CONTENT},
  [FAULT_STIFFNESS_AVERAGE] = {"stiffness_average", "centre", "|centre|cell|whole|",
                               "Where stress is evaluated: centre of each cell, where friction chooses the edge of "
                               "slip (ruptures, injections, cycles); cell, averaged over it, where cells that do not "
                               "slip prescribe the edge; whole, averaged for faults all of whose cells slide",
                               PROBLEM},
  [FAULT_STIFFNESS_FILE] = {"stiffness_file", "", NULL,
                            "Stiffness from F.h5[:/dataset] (default /stiffness), [N,N] in Pa/m, instead of the kernel",
                            CONTENT},
  [FAULT_STIFFNESS_SCALING] =
    {"stiffness_scaling", "none", "|mean_slip|none|",
     "Scaling of K: none, as computed or read; mean_slip, multiplied so that mean(K^-1 sigma_n) = mean(sigma_n) Ly/G",
     PROBLEM},
  [FAULT_PARAMETERS] =
    {"parameters", "", NULL,
     "HDF5 file of fields [Nz,Nx] with a value per cell, named as the options whose values they override", CONTENT},
  [FAULT_MESH] =
    {"mesh", "", NULL,
     "File of cells in place of the grid and its extents: HDF5 with rectangles, /cells [n,5] with x, y, z "
     "of the centre, length and width [m], or [n,7] with strike and dip, or with triangles, /vertices [v,3] "
     "and /triangles [n,3]; or .msh of Gmsh",
     CONTENT},
  [FAULT_MESH_FRAME] = {"mesh_frame", "auto", "|auto|enu|ned|end|",
                        "Axes of vertices in the file of -fault_mesh: enu is x east, y north, z up, ned is x north, y "
                        "east, z down, end is x east, y north, z down; auto: enu of Gmsh, ned of HDF5",
                        CONTENT},
  [FAULT_MESH_UNIT] =
    {"mesh_unit", "auto", "|auto|m|km|",
     "Unit of lengths in the file of -fault_mesh; auto: what the file says, else m, but lengths that may be kilometres "
     "or degrees are an error",
     CONTENT},
  [FAULT_PORE_PRESSURE] = {"pore_pressure", "", NULL,
                           "HDF5 file of pore pressure in time, /time [m] in s and /pressure [m,Nz,Nx] or [m,N] in Pa, "
                           "linear between times and constant beyond",
                           CONTENT},
  [FAULT_INJECTION] = {"injection", "", NULL,
                       "Point x,z [m] of the fault, x,y,z where a mesh has several planes, at which fluid is injected "
                       "from time 0 on",
                       PROBLEM},
  [FAULT_PERMEABILITY_LAW] =
    {"permeability_law", "constant", "|rows of SlipPermeabilityLaws|",
     "How -fault_permeability changes: constant; slip, grows with slip and heals in time; stress, falls with effective "
     "normal stress; valve, both; or a law of SlipFaultRegisterPermeabilityLaw()",
     PROBLEM},
  [FAULT_FLUID_BORDER] = {"fluid_border", "closed", "|closed|open|",
                          "Border of the fault for pore fluid: closed, nothing flows through; open, its pressure is 0 "
                          "there, unless -fault_border_pressure holds another",
                          PROBLEM},
  [FAULT_WELLS] =
    {"wells", "", NULL,
     "FILE.csv of wells, with the columns well,x,y,z,days (or hours, s) and m3/day (or L/s, m3/s, MPa, "
     "Pa), a line for each change: a rate goes into the fault, 0 shuts the well in, a pressure is held in "
     "it. y may be left out; two more columns may be radius [m] of the well (0.1), and spread [m], over "
     "whose Gaussian the rate is distributed (0: into the nearest cell)",
     CONTENT},
  SLIP_FAULT_REGIONAL_STRINGS,
  [FAULT_STRESS_HISTORY] =
    {"stress_history", "", NULL,
     "HDF5 file of stresses in time, a group for each: time [n] in s, course [n], shear and normal in Pa, one number "
     "or "
     "one a cell, shear also with components along strike and up dip; or FILE.csv with columns time, shear and normal. "
     "course times shear, along the rake, adds to the shear stress, course times normal to the normal stress, positive "
     "in compression; linear between times and constant beyond",
     CONTENT},
  [FAULT_TIDE_PERIOD] = {"tide_period", "", NULL,
                         "Periods P of tides, separated by commas, each with a stress A sin(2 pi t/P + phase) [s]",
                         PROBLEM},
  [FAULT_TIDE_SHEAR] = {"tide_shear", "", NULL,
                        "Amplitudes A of the shear stress along the rake, one for each of -fault_tide_period [Pa]",
                        PROBLEM},
  [FAULT_TIDE_NORMAL] = {"tide_normal", "", NULL,
                         "Amplitudes A of the normal stress, positive in compression, one for each of "
                         "-fault_tide_period [Pa]",
                         PROBLEM},
  [FAULT_TIDE_PHASE] = {"tide_phase", "", NULL, "Phases of tides, one for each of -fault_tide_period [degrees]",
                        PROBLEM},
  [FAULT_NUCLEATION] =
    {"nucleation", "", NULL,
     "Shear stress that starts a rupture, x,z,radius,amplitude,duration [m, m, m, Pa, s], at a point as that of "
     "-fault_injection (x,y,z where a mesh has several planes): amplitude exp(r^2/(r^2 - radius^2)) at the distance r, "
     "times a smooth rise from 0 to 1 between time 0 and the duration",
     PROBLEM},
  [FAULT_TOLERANCES] = {"tolerances", "", NULL,
                        "HDF5 file of the tolerances at which classical controllers keep -fault_accuracy, which train "
                        "-train_algorithm tolerances writes, in place of tolerances.h5 beside the default policies",
                        STEPS},
  [FAULT_ESTIMATES] = {"estimates", "", NULL,
                       "HDF5 file of the factors of the estimated errors in the summary, which verdict.py --calibrate "
                       "writes, in place of estimates.h5 beside the default policies",
                       RUN},
  [FAULT_OUTPUT] = {"output", "", NULL, "HDF5 file to write the run to", OUTPUT},
  [FAULT_OUTPUT_FIELDS] =
    {"output_fields", "slip_rate,slip,displacement,traction", NULL,
     "Fields to write, separated by commas, of slip_rate, slip, displacement, traction, state (each of several by the "
     "name that the law gives it), pore_pressure, normal_stress (effective), temperature (its rise) and "
     "shear_zone_pressure of "
     "-fault_shear_zone_width, permeability and fluid_flux (along strike and down dip) of -fault_permeability; opening "
     "comes with -fault_opening",
     OUTPUT},
  [FAULT_OUTPUT_PRECISION] = {"output_precision", "double", "|double|single|", "Precision of numbers in /fields",
                              OUTPUT},
  [FAULT_STATIONS] = {"stations", "", NULL,
                      "Points \"x,z;x,z\" [m], \"x,y,z\" where planes overlap, or a file with a point on each line and "
                      "comments after #; values of their cells are written to /stations of -fault_output at every "
                      "accepted step",
                      OUTPUT},
  [FAULT_SURFACE_STATIONS] = {"surface_stations", "", NULL,
                              "Points \"x,y;x,y\" [m] of the free surface, or a file with a point \"x,y\" or \"x y\" "
                              "on each line and comments after #; x is north, y is east. Their displacement and "
                              "velocity are written to /surface of -fault_output at every accepted step",
                              OUTPUT},
  [FAULT_SURFACE_MOTION] = {"surface_motion", "relative", "|relative|total|",
                            "Motion of -fault_surface_stations where plates load the fault: relative to that of the "
                            "plates, or total, with half of -fault_loading_rate along the rake on the side of the "
                            "hanging wall, and against it on the other, for one plane with one rate and rake",
                            OUTPUT},
  [FAULT_CATALOGUE] = {"catalogue", "", NULL,
                       "HDF5 file to write the catalogue to, with a row for every event of the run", OUTPUT},
  [FAULT_CHECKPOINT] = {"checkpoint", "", NULL, "HDF5 file to write the state of the run to, for -fault_restart", RUN},
  [FAULT_RESTART] = {"restart", "", NULL, "Checkpoint to continue from; may be the file of -fault_checkpoint", RUN},
  [FAULT_STOP_FILE] = {"stop_file", "", NULL,
                       "File that stops the run after its step when it appears, with a checkpoint and exit code 138",
                       RUN},
  [FAULT_DEVICE] = {"device", "none", "|none|opencl|auto|",
                    "Compute steps on a graphics card by OpenCL; auto: where there is one that can", STEPS},
  [FAULT_DEVICE_NAME] = {"device_name", "", NULL,
                         "Part of the name of the device or of its platform, or its number in clinfo -l", RUN},
};

#define AT(member) offsetof(struct _p_SlipFault, member)

const SlipFaultSwitch SlipFaultSwitches[FAULT_NUM_SWITCHES] = {
  {"check_error", AT(options.check_error), OUTPUT, "SlipFaultOutputFinish",
   "Measure the errors of the run: repeat it with every step divided into four, which costs five times its Bathe "
   "solves in addition; with -ts_type bathe (default no; the estimate in the summary costs nothing)"},
  {"inertia", AT(options.inertia), PROBLEM, "SlipFaultSetInertia",
   "Include inertia M = rho Ly, a mass per area without waves; no: quasi-dynamic (default yes; no for rate-and-state "
   "friction, and for slip weakening with -fault_initial traction unless -fault_viscosity is none)"},
  {"initial_unstable", AT(options.initial_unstable), RUN, "SlipFaultSetInitialState",
   "With -fault_initial traction: cells may start above their strength; a line says where, and how many are outside of "
   "the largest patch (default no)"},
  {"opening", AT(options.opening), PROBLEM, "SlipFaultSetBool",
   "Cells without normal stress may open, and close again; needs -fault_slip_components 2, -fault_initial traction and "
   "a friction law that sticks (default no: they slide freely, but stay closed)"},
  {"output_xdmf", AT(options.output_xdmf), OUTPUT, "SlipFaultOutputStart",
   "Write FILE.xdmf2 beside FILE of -fault_output, for ParaView (default yes)"},
  {"progress", AT(options.progress), OUTPUT, "SlipFaultOutputStart",
   "Print progress, every few seconds on a terminal, else once a minute: time, largest slip rate, steps and time left "
   "(default yes)"},
  {"output_overwrite", AT(options.output_overwrite), OUTPUT, "SlipFaultOutputStart",
   "Overwrite an unfinished FILE.part of -fault_output and -fault_catalogue (default no)"},
  {"catalogue_maps", AT(options.catalogue_maps), OUTPUT, "SlipFaultOutputStart",
   "Write slip and rupture time of every cell for each event of -fault_catalogue (default no)"},
};
