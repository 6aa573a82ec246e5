/* The stress of a region: rows of the tables of parameters, and what it makes of the cells. */
#pragma once
#include <slipstep/rooms/slipfault.h>

#define SLIP_GRAVITY 9.81          /* [m/s^2] */
#define SLIP_WATER_GRADIENT 9.81e3 /* hydrostatic, of 1000 kg/m^3 [Pa/m] */

/* Of SlipFaultReals */
#define SLIP_FAULT_REGIONAL_REALS                                                                                      \
  [FAULT_REGIONAL_AZIMUTH] = {                                                                                         \
    "regional_azimuth",                                                                                                \
    0,                                                                                                                 \
    "degrees",                                                                                                         \
    -360,                                                                                                              \
    360,                                                                                                               \
    PETSC_FALSE,                                                                                                       \
    PETSC_FALSE,                                                                                                       \
    "Direction of the largest horizontal compression SHmax of -fault_regional_ratios, clockwise from north",           \
    SLIP_PART_CONTENT}

/* Of SlipFaultStrings */
#define SLIP_FAULT_REGIONAL_STRINGS                                                                                    \
  [FAULT_REGIONAL_STRESS] =                                                                                            \
    {"regional_stress", "", NULL,                                                                                      \
     "Stress of the region at depth 0, positive in compression, as are normal stresses: six numbers [Pa] "             \
     "north-north,east-east,down-down,north-east,north-down,east-down. With -fault_regional_pressure it gives each "   \
     "cell its effective normal stress and initial traction along the rake, or with two components the direction of "  \
     "the rake, and the default start is traction. A negative north-east drives left-lateral slip of a plane that "    \
     "strikes north. Fields override it",                                                                              \
     SLIP_PART_CONTENT},                                                                                               \
  [FAULT_REGIONAL_STRESS_GRADIENT] = {"regional_stress_gradient", "", NULL,                                            \
                                      "Six numbers [Pa/m] that a cell adds to -fault_regional_stress, times the "      \
                                      "depth of its centre",                                                           \
                                      SLIP_PART_CONTENT},                                                              \
  [FAULT_REGIONAL_RATIOS] = {"regional_ratios", "", NULL,                                                              \
                             "Stress of the region by two numbers SHmax/Sv,Shmin/Sv of total stresses, in place of "   \
                             "-fault_regional_stress: Sv is -fault_density times 9.81 m/s^2 times depth, and SHmax "   \
                             "has the direction -fault_regional_azimuth",                                              \
                             SLIP_PART_CONTENT},                                                                       \
  [FAULT_REGIONAL_PRESSURE] = {"regional_pressure", "hydrostatic", NULL,                                               \
                               "Pore pressure that the effective normal stress of the region is without: "             \
                               "hydrostatic, 9.81 kPa/m; none, where the stresses are effective ones; or two "         \
                               "numbers p,dp/dz [Pa], [Pa/m]",                                                         \
                               SLIP_PART_CONTENT},                                                                     \
  [FAULT_REGIONAL_RAKE] = {                                                                                            \
    "regional_rake", "given", "|given|shear|",                                                                         \
    "Rake of cells under the stress of the region: given, that of -fault_rake; shear, the direction of their shear "   \
    "stress, in which loading then acts as well, and which two components always have",                                \
    SLIP_PART_PROBLEM}

/* The stress, positive in compression, at a depth z: at + per z, xx, yy, zz, xy, xz, yz; the pressure p + dp z */
typedef struct {
  PetscReal at[6], per[6];          /* [Pa], [Pa/m] */
  PetscReal pressure, pressure_per; /* [Pa], [Pa/m] */
} SlipRegionalStress;

/* regional.c: whether an option gives a stress of the region; fills normal stress, initial traction and rake where no
   field was given; NULL arrays of tendency where there is no such stress */
PETSC_INTERN PetscBool SlipFaultHasRegional(SlipFault fault);
PETSC_INTERN PetscErrorCode SlipFaultRegionalSetUp(SlipFault fault);
PETSC_EXTERN void SlipRegionalResolve(const SlipRegionalStress *s, PetscReal depth, const PetscReal directions[],
                                      PetscReal *normal, PetscReal shear[2]);
