/* Friction laws of others: a row of the table of laws, and the parameters that it brings. */
#include <slipstep/private/slipfault.h>
#include <string.h>

/* Is the word one of a list with blanks between? */
static PetscBool IsListed(const char word[], const char list[])
{
  const size_t len = strlen(word);

  for (const char *c = strstr(list, word); c; c = strstr(c + 1, word))
    if ((c == list || c[-1] == ' ') && (c[len] == ' ' || !c[len])) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* Refuses parameters whose names belong to another option or dataset, and rows that cannot be */
static PetscErrorCode CheckOwn(const SlipFrictionLaw *law)
{
  static const char letters[] = "abcdefghijklmnopqrstuvwxyz0123456789_";
  static const char datasets[] = "cells stiffness x y z length width critical_displacement"; /* of inputs and outputs */
  char names[FAULT_MAX_NAMES], bounds[128];
  PetscInt n = 0;

  PetscFunctionBegin;
  while (SlipFaultOwnRow(n, NULL)) n++;
  PetscCall(SlipFaultOptionNames(names, sizeof(names)));
  for (const SlipParameter *p = law->own; p && p->name; p++, n++) {
    const size_t len = strlen(p->name);
    const char *const name = law->name ? law->name : "";

    PetscCheck(len > 0 && len < FAULT_MAX_NAME && strspn(p->name, letters) == len, PETSC_COMM_SELF, PETSC_ERR_ARG_WRONG,
               "The friction law %s brings a parameter \"%s\", expected a name of small letters, digits and _, of less "
               "than %d",
               name, p->name, FAULT_MAX_NAME);
    PetscCheck(!IsListed(p->name, names) && !IsListed(p->name, datasets), PETSC_COMM_SELF, PETSC_ERR_ARG_WRONG,
               "The friction law %s brings a parameter \"%s\", which there is already, expected another name", name,
               p->name);
    PetscCheck(p->unit && p->help, PETSC_COMM_SELF, PETSC_ERR_ARG_WRONG,
               "The parameter %s of the friction law %s needs a unit, \"\" for none, and a help text", p->name, name);
    SlipParameterBounds(p, PETSC_FALSE, bounds, sizeof(bounds));
    PetscCheck(SlipParameterHolds(p, p->value), PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
               "The parameter %s of the friction law %s is %g by default, expected %s", p->name, name, (double)p->value,
               bounds);
    PetscCheck(n < FAULT_MAX_OWN, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
               "The parameter %s of the friction law %s is one of more than %d", p->name, name, FAULT_MAX_OWN);
    PetscCall(PetscStrlcat(names, " ", sizeof(names)));
    PetscCall(PetscStrlcat(names, p->name, sizeof(names)));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipFaultRegisterFrictionLaw - add a choice to -fault_friction_law

  Not collective, on every process in the same order; before the options of a fault are read

  Input Parameter:
. law - its name; mu and its derivatives with respect to the state s and to v = |slip rate| [m/s]; a formula for -help; and,
        for a law with a state of its own, the rate of s with its derivatives and the s that is steady at a rate; parameters that
        it brings. Copied; strings, parameters and context stay the caller's

  Level: advanced

  Notes:
  All functions are pure, of one cell, whose parameters they find in SlipFriction. A law without a state of its own gets the
  slip of both signs as s and gives what mu exceeds -fault_friction_residual by; |tau| <= sigma mu is its bound. A law whose
  cells always slide gives mu itself, 0 at v = 0 and growing with v: without inertia the fault is an explicit problem for TSRK
  and TSADAMS. The rate of s must not grow with s. The field initial_state and the state of outputs are s itself, or what the
  functions shown and of_shown make of it, in state_unit.

  Each row of own is from then on what the numbers of every fault are: an option -fault_<name>, with a unit of time where it
  is in s, an argument of SlipFaultSetReal(), SlipFaultSetField() and SlipFaultGetField(), and a dataset of -fault_parameters
  and of outputs. The law's functions find those of their cell in SlipFriction, own[k] of the k-th row. All have a default,
  and names that no other option of faults has.

  See examples/friction_law.c.

  Errors: PETSC_ERR_ARG_WRONG for a name that is taken, of the law or of a parameter, and for a law without the functions that
  it needs; PETSC_ERR_ARG_OUTOFRANGE for a default out of bounds and too many parameters

.seealso: SlipFaultSetString(), SlipFaultSetReal(), SlipFaultSetField(), SlipFaultSetFromOptions()
@*/
PetscErrorCode SlipFaultRegisterFrictionLaw(const SlipFrictionLaw *law)
{
  PetscFunctionBegin;
  PetscAssertPointer(law, 1);
  PetscCall(CheckOwn(law));
  PetscCall(SlipFrictionRegister(law));
  if (PetscInitializeCalled) PetscCall(SlipFaultDeclareOptions()); /* else SlipStepInitializePackage() does */
  PetscFunctionReturn(PETSC_SUCCESS);
}
