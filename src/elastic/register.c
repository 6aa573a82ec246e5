/* The list of the types of media, and the creation of a medium of one of these types. */
#include <slipstep/private/slipelastic.h>
#include <slipstep/private/slipsys.h>

static PetscFunctionList Types = NULL;

static PetscErrorCode Create_Static(SlipElastic el)
{
  PetscFunctionBegin;
  PetscCall(SlipElasticSetOps(el, &SlipElasticStatic, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Forget(void)
{
  PetscFunctionBegin;
  PetscCall(PetscFunctionListDestroy(&Types));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Register_Elastic(void)
{
  PetscFunctionBegin;
  PetscCall(SlipMatInitializePackage());
  PetscCall(PetscClassIdRegister("Slip medium", &SLIP_ELASTIC_CLASSID));
  PetscCall(PetscFunctionListAdd(&Types, SLIPELASTICSTATIC, Create_Static));
  PetscCall(PetscFunctionListAdd(&Types, SLIPELASTICWAVES, SlipElasticCreate_Waves));
  PetscCall(PetscRegisterFinalize(Forget));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Registers the class of media, its types, and the classes that they use. */
PetscErrorCode SlipElasticInitializePackage(void)
{
  return SlipRegisterOnce(Register_Elastic);
}

/*@C
  SlipElasticRegister - adds a type of medium

  Not collective; after PetscInitialize(), before SlipFaultSetFromOptions()

  Input Parameters:
+ name   - name of the type, which -fault_medium then accepts
- create - function that is called when the type is chosen; it must call SlipElasticSetOps()

  Level: advanced

.seealso: SlipElasticSetType(), SlipElasticSetOps()
@*/
PetscErrorCode SlipElasticRegister(const char name[], PetscErrorCode (*create)(SlipElastic))
{
  PetscFunctionBegin;
  PetscCall(SlipElasticInitializePackage());
  PetscCall(PetscFunctionListAdd(&Types, name, create));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lists the names of all types of media. */
PetscErrorCode SlipElasticListTypes(char names[], size_t len)
{
  const char **name;
  int n;

  PetscFunctionBegin;
  PetscCall(SlipElasticInitializePackage());
  PetscCall(PetscFunctionListGet(Types, &name, &n));
  PetscCall(PetscStrncpy(names, "|", len));
  for (int i = 0; i < n && name[i]; i++) { /* PETSc's n includes the NULL after the last name */
    PetscCall(PetscStrlcat(names, name[i], len));
    PetscCall(PetscStrlcat(names, "|", len));
  }
  PetscCall(PetscFree(name));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipElasticCreate - creates a medium of type static

  Collective

  Input Parameter:
. comm - communicator of the medium

  Output Parameter:
. el - the medium

  Level: advanced

.seealso: SlipElasticSetType(), SlipElasticSetStiffness(), SlipElasticSetUp(), SlipElasticDestroy()
@*/
PetscErrorCode SlipElasticCreate(MPI_Comm comm, SlipElastic *el)
{
  SlipElastic e;

  PetscFunctionBegin;
  PetscAssertPointer(el, 2);
  PetscCall(SlipElasticInitializePackage());
  PetscCall(PetscHeaderCreate(e, SLIP_ELASTIC_CLASSID, "SlipElastic", "Medium around a fault", "SlipElastic", comm,
                              SlipElasticDestroy, NULL));
  PetscCall(SlipElasticSetType(e, SLIPELASTICSTATIC));
  *el = e;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipElasticSetType - sets the type of a medium

  Collective; before SlipElasticSetUp()

  Input Parameters:
+ el   - the medium
- type - SLIPELASTICSTATIC, SLIPELASTICWAVES, or a name that SlipElasticRegister() has added

  Options Database Key:
. -fault_medium <static> - the type of a fault's medium

  Level: advanced

  Errors: PETSC_ERR_ARG_UNKNOWN_TYPE

.seealso: SlipElasticRegister()
@*/
PetscErrorCode SlipElasticSetType(SlipElastic el, const char type[])
{
  PetscErrorCode (*create)(SlipElastic);

  PetscFunctionBegin;
  PetscValidHeaderSpecific(el, SLIP_ELASTIC_CLASSID, 1);
  PetscCall(PetscFunctionListFind(Types, type, &create));
  PetscCheck(create, PetscObjectComm((PetscObject)el), PETSC_ERR_ARG_UNKNOWN_TYPE,
             "there is no type of medium \"%s\"; SlipElasticRegister() adds one", type);
  if (el->ops->destroy) PetscCall((*el->ops->destroy)(el));
  el->ops[0] = (SlipElasticOps){.force = NULL};
  el->data = NULL;
  PetscCall(PetscObjectChangeTypeName((PetscObject)el, type));
  PetscCall((*create)(el));
  if (!el->ops->force) el->ops->force = SlipElasticStatic.force;
  if (!el->ops->stage) el->ops->stage = SlipElasticStatic.stage;
  PetscFunctionReturn(PETSC_SUCCESS);
}
