/* Registers users' friction laws, rows of the table of laws with the law's parameters, and permeability laws. */
#include <slipstep/private/slipfault.h>
#include <string.h>

/* Returns whether the word is in a list separated by blanks. */
static PetscBool IsListed(const char word[], const char list[])
{
  const size_t len = strlen(word);

  for (const char *c = strstr(list, word); c; c = strstr(c + 1, word))
    if ((c == list || c[-1] == ' ') && (c[len] == ' ' || !c[len])) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* Returns whether this is a valid name of a parameter or a state. */
static PetscBool IsName(const char name[])
{
  static const char letters[] = "abcdefghijklmnopqrstuvwxyz0123456789_";
  const size_t len = strlen(name);

  return len > 0 && len < FAULT_MAX_NAME && strspn(name, letters) == len ? PETSC_TRUE : PETSC_FALSE;
}

/* Returns whether a state can start with this parameter. */
static PetscBool IsStart(const SlipFrictionLaw *law, const char name[])
{
  if (!name) return PETSC_FALSE;
  for (const SlipParameter *p = law->own; p && p->name; p++)
    if (!strcmp(p->name, name)) return PetscIsNanReal(p->value);
  return strcmp(name, "initial_state") ? PETSC_FALSE : PETSC_TRUE;
}

/* Returns whether a state starts with this parameter, so that it has no default. */
static PetscBool Starts(const SlipFrictionLaw *law, const char name[])
{
  for (PetscInt k = 0; k < law->nstates; k++)
    if (law->states[k].start && !strcmp(law->states[k].start, name)) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* Refuses parameters whose names belong to another option or dataset, and invalid rows. */
static PetscErrorCode CheckOwn(const SlipFrictionLaw *law)
{
  static const char datasets[] = "cells stiffness x y z length width critical_displacement"; /* of inputs and outputs */
  char names[FAULT_MAX_NAMES], bounds[128];
  PetscInt n = 0;

  PetscFunctionBegin;
  while (SlipFaultOwnRow(n, NULL)) n++;
  PetscCall(SlipFaultOptionNames(names, sizeof(names)));
  for (const SlipParameter *p = law->own; p && p->name; p++, n++) {
    const char *const name = law->name ? law->name : "";

    PetscCheck(IsName(p->name), PETSC_COMM_SELF, PETSC_ERR_ARG_WRONG,
               "The friction law %s brings a parameter \"%s\", expected a name of small letters, digits and _, of less "
               "than %d",
               name, p->name, FAULT_MAX_NAME);
    PetscCheck(!IsListed(p->name, names) && !IsListed(p->name, datasets), PETSC_COMM_SELF, PETSC_ERR_ARG_WRONG,
               "The friction law %s brings a parameter \"%s\", which there is already, expected another name", name,
               p->name);
    PetscCheck(p->unit && p->help, PETSC_COMM_SELF, PETSC_ERR_ARG_WRONG,
               "The parameter %s of the friction law %s needs a unit, \"\" for none, and a help text", p->name, name);
    SlipParameterBounds(p, PETSC_FALSE, bounds, sizeof(bounds));
    PetscCheck(SlipParameterHolds(p, p->value) || (isnan(p->value) && Starts(law, p->name)), PETSC_COMM_SELF,
               PETSC_ERR_ARG_OUTOFRANGE, "The parameter %s of the friction law %s is %g by default, expected %s",
               p->name, name, (double)p->value, bounds);
    PetscCheck(n < FAULT_MAX_OWN, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
               "The parameter %s of the friction law %s is one of more than %d", p->name, name, FAULT_MAX_OWN);
    PetscCall(PetscStrlcat(names, " ", sizeof(names)));
    PetscCall(PetscStrlcat(names, p->name, sizeof(names)));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Refuses states whose names are those of other datasets, and starts that no parameter gives */
static PetscErrorCode CheckStates(const SlipFrictionLaw *law)
{
  char names[FAULT_MAX_NAMES] =
    "time slip_rate slip displacement traction pore_pressure normal_stress temperature shear_zone_pressure opening "
    "permeability fluid_flux stress x y z";

  PetscFunctionBegin;
  for (PetscInt k = 0; k < law->nstates; k++) {
    const SlipFrictionState *const s = &law->states[k];

    PetscCheck(IsName(s->name) && !IsListed(s->name, names), PETSC_COMM_SELF, PETSC_ERR_ARG_WRONG,
               "State %" PetscInt_FMT
               " of the friction law %s is called \"%s\", expected a name of small letters, digits "
               "and _, of less than %d, that no other dataset has",
               k, law->name, s->name, FAULT_MAX_NAME);
    PetscCall(PetscStrlcat(names, " ", sizeof(names)));
    PetscCall(PetscStrlcat(names, s->name, sizeof(names)));
    PetscCheck(
      !law->always_slides || IsStart(law, s->start), PETSC_COMM_SELF, PETSC_ERR_ARG_WRONG,
      "The state %s of the friction law %s starts with the parameter \"%s\", expected initial_state, or one of the "
      "law's own whose default is NaN",
      s->name, law->name, s->start ? s->start : "");
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipFaultRegisterFrictionLaw - adds a choice to -fault_friction_law

  Not collective, on every process in the same order; before the options of a fault are read

  Input Parameter:
. law - its name; mu and its derivatives with respect to the states s[] and to v = |slip rate| [m/s]; a formula for
        -help; for a law with states of its own, their names, their rates with derivatives, and the s that are steady
        at a rate; its parameters. Copied; strings, states, parameters and context stay the caller's

  Level: advanced

  Notes:
  All functions are pure functions of one cell, whose parameters they get in SlipFriction. A law without states of its
  own gets the slip of both signs as s[0] and gives mu minus -fault_friction_residual; |tau| <= sigma mu is its bound.
  A law whose cells always slide gives mu itself, which is 0 at v = 0 and grows with v: without inertia the fault is an
  explicit problem for TSRK and TSADAMS.

  A law declares up to SLIP_MAX_STATES states (SlipFrictionState), and one function gives the rates of all of them. No
  rate may grow with its own state. A change of s[k] by 1 should matter as much as slip by -fault_friction_slip, as
  tolerances treat both alike. Stages of TSBATHE need no more: they solve s = s0 + theta ds/dt with the derivatives.
  Each state is a field of -fault_output_fields, a column of stations and a name for SlipFaultGetCellValues(), in its
  unit, converted by its functions shown and of_shown. Where all cells slide, a state starts with the parameter that it
  names, initial_state or one of own with the default NaN, or is steady where no number is given.

  Each row of own becomes a parameter of every fault: an option -fault_<name>, with a unit of time where it is in s, an
  argument of SlipFaultSetReal(), SlipFaultSetField() and SlipFaultGetField(), and a dataset of -fault_parameters and
  of outputs. The law's functions get those of their cell in SlipFriction, own[k] for the k-th row. Each has a default,
  and a name that no other option of faults has.

  See examples/friction_law.c.

  Errors: PETSC_ERR_ARG_WRONG for a used name of the law, of a parameter or of a state, and for a law without
  the functions that it needs; PETSC_ERR_ARG_OUTOFRANGE for a default out of bounds and too many parameters or states

.seealso: SlipFaultSetString(), SlipFaultSetReal(), SlipFaultSetField(), SlipFaultSetFromOptions()
@*/
PetscErrorCode SlipFaultRegisterFrictionLaw(const SlipFrictionLaw *law)
{
  PetscFunctionBegin;
  PetscAssertPointer(law, 1);
  PetscCall(SlipFrictionCheck(law));
  PetscCall(CheckOwn(law));
  PetscCall(CheckStates(law));
  PetscCall(SlipFrictionRegister(law));
  if (PetscInitializeCalled) PetscCall(SlipFaultDeclareOptions()); /* else SlipStepInitializePackage() does */
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipFaultRegisterPermeabilityLaw - adds a choice to -fault_permeability_law

  Not collective, on every process in the same order; before the options of a fault are read

  Input Parameter:
. law - its name; which of -fault_permeability_maximum with -fault_permeability_slip [m], and -fault_permeability_stress
        [Pa], it needs; how k* [m^2] of a cell evolves in h [s] with some slip [m]; k [m^2] from k* and the effective
        normal stress [Pa]. Copied; strings and context stay the caller's

  Level: advanced

  Note:
  Both functions are pure functions of one cell, whose numbers they get in SlipPermeability; one of them may be NULL.
  evolve() should be exact at a constant slip rate: two calls for halves of the time and slip give what one call gives.

  Errors: PETSC_ERR_ARG_WRONG for a used name and for a law without functions, PETSC_ERR_ARG_OUTOFRANGE for too many

.seealso: SlipFaultRegisterFrictionLaw(), SlipFaultSetString()
@*/
PetscErrorCode SlipFaultRegisterPermeabilityLaw(const SlipPermeabilityLaw *law)
{
  PetscFunctionBegin;
  PetscAssertPointer(law, 1);
  PetscCall(SlipPermeabilityRegister(law));
  if (PetscInitializeCalled) PetscCall(SlipFaultDeclareOptions()); /* else SlipStepInitializePackage() does */
  PetscFunctionReturn(PETSC_SUCCESS);
}
