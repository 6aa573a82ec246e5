/* How the permeability of a fault changes: laws, one row each, as pure functions of one cell. Slip opens paths for
   fluid and minerals seal them again, as in the fault valving of Zhu, Allison, Dunham and Yang (2020,
   doi:10.1038/s41467-020-18598-z); permeability falls as effective normal stress presses them together (Rice 1992). */
#include <slipstep/rooms/slipcore.h>
#include <math.h>
#include <stdlib.h>

enum { PERMEABILITY_REGISTERED = 16 };

/* dk/dt = |V|/L (kmax - k) + (k0 - k)/T for h [s] at a constant rate, exactly: with d slip and a = d/L + h/T, k decays
   by exp(-a) towards the mean of kmax and k0 with the weights d/L and h/T. All terms are positive, so that nothing
   cancels, and nothing is divided by a small a. */
static PetscReal EvolveWithSlip(const SlipPermeability *c, PetscReal x, PetscReal slip, PetscReal h)
{
  const PetscReal grown = slip / c->slip, healed = h * c->healing, a = grown + healed;
  const PetscReal share = a > 0 ? -(PetscReal)expm1(-a) / a : 1;

  return x * PetscExpReal(-a) + share * (grown * c->maximum + healed * c->start);
}

static PetscReal ValueAtStress(const SlipPermeability *c, PetscReal x, PetscReal stress)
{
  return x * PetscExpReal(-(stress - c->normal) / c->stress);
}

#define BY_SLIP SLIP_PERMEABILITY_BY_SLIP
#define BY_STRESS SLIP_PERMEABILITY_BY_STRESS
const SlipPermeabilityLaw SlipPermeabilityLaws[] = {
  {.name = "constant"},
  {.name = "slip", .needs = BY_SLIP, .evolve = EvolveWithSlip},
  {.name = "stress", .needs = BY_STRESS, .value = ValueAtStress},
  {.name = "valve", .needs = BY_SLIP | BY_STRESS, .evolve = EvolveWithSlip, .value = ValueAtStress},
  {.name = NULL},
};

static SlipPermeabilityLaw *registered[PERMEABILITY_REGISTERED];
static PetscInt nregistered = 0;

/* The rows in sequence, then those of users: the first after NULL, NULL after the last */
const SlipPermeabilityLaw *SlipPermeabilityNext(const SlipPermeabilityLaw *law)
{
  if (!law) return SlipPermeabilityLaws;
  for (PetscInt k = 0; k < nregistered; k++)
    if (law == registered[k]) return k + 1 < nregistered ? registered[k + 1] : NULL;
  if (law[1].name) return law + 1;
  return nregistered ? registered[0] : NULL;
}

/* The law with a name; NULL: none */
const SlipPermeabilityLaw *SlipPermeabilityFind(const char name[])
{
  for (const SlipPermeabilityLaw *law = SlipPermeabilityNext(NULL); law; law = SlipPermeabilityNext(law)) {
    PetscBool same = PETSC_FALSE;

    (void)PetscStrcmp(name, law->name, &same);
    if (same) return law;
  }
  return NULL;
}

/* Adds a copy of the row, which is never freed, because faults refer to it. */
PetscErrorCode SlipPermeabilityRegister(const SlipPermeabilityLaw *law)
{
  PetscFunctionBegin;
  PetscCheck(law->name && law->name[0] && (law->evolve || law->value), PETSC_COMM_SELF, PETSC_ERR_ARG_WRONG,
             "A permeability law needs a name, and a function evolve or value");
  PetscCheck(!SlipPermeabilityFind(law->name), PETSC_COMM_SELF, PETSC_ERR_ARG_WRONG,
             "There is a permeability law %s already", law->name);
  PetscCheck(nregistered < PERMEABILITY_REGISTERED, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
             "The permeability law %s would be one of more than %d", law->name, PERMEABILITY_REGISTERED);
  registered[nregistered] = (SlipPermeabilityLaw *)malloc(sizeof(*law));
  PetscCheck(registered[nregistered], PETSC_COMM_SELF, PETSC_ERR_MEM, "No memory for the permeability law %s",
             law->name);
  *registered[nregistered++] = *law;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* k* of a cell after h [s] with this much slip >= 0 [m] at a constant rate */
PetscReal SlipPermeabilityEvolve(const SlipPermeabilityLaw *law, const SlipPermeability *c, PetscReal x, PetscReal slip,
                                 PetscReal h)
{
  return law->evolve ? (*law->evolve)(c, x, slip, h) : c->start;
}

/* k of a cell with k* under this effective normal stress [Pa] */
PetscReal SlipPermeabilityValue(const SlipPermeabilityLaw *law, const SlipPermeability *c, PetscReal x,
                                PetscReal stress)
{
  return law->value ? (*law->value)(c, x, stress) : x;
}
