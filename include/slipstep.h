/* SlipStep: nonsmooth dynamics with PETSc's TS. Umbrella header; one header for each folder of src. */
#pragma once
#include <slipsys.h>
#include <slipelasticity.h>
#include <slipmat.h>
#include <slipcells.h>
#include <slipelastic.h>
#include <slipsnes.h>
#include <slipts.h>
#include <slippolicy.h>
#include <slipadapt.h>
#include <slipoutput.h>
#include <slipmodels.h>
#include <slipfault.h>
