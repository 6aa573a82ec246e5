/* Everything that rooms of the library offer to each other; the trainer and tests use it, other programs slipstep.h. */
#pragma once
#include <slipstep.h>
#include <slipstep/rooms/slipadapt.h>
#include <slipstep/rooms/slipcells.h>
#include <slipstep/rooms/slipcore.h>
#include <slipstep/rooms/slipelastic.h>
#include <slipstep/rooms/slipelasticity.h>
#include <slipstep/rooms/slipfault.h>
#include <slipstep/rooms/slipmat.h>
#include <slipstep/rooms/slipmodels.h>
#include <slipstep/rooms/slipoutput.h>
#include <slipstep/rooms/slippolicy.h>
#include <slipstep/rooms/slipsnes.h>
#include <slipstep/rooms/slipsys.h>
#include <slipstep/rooms/slipts.h>
