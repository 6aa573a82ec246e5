/* Finds the policies and measured numbers that come with the library, wherever that was installed or moved to. */
#define _GNU_SOURCE /* dladdr() */
#include <slipstep/rooms/slippolicy.h>
#include <slipstep/rooms/slipsys.h>
#include <slipcompat.h>
#include <slipstep/private/slippolicy.h>
#include <dlfcn.h>
#include <stdlib.h>
#include <string.h>

#ifndef SLIPSTEP_LIB_TO_POLICIES
  #define SLIPSTEP_LIB_TO_POLICIES "../share/slipstep/policies" /* as installed with default folder names */
#endif
#ifndef SLIPSTEP_INSTALLED_POLICIES /* for programs anywhere that contain the static library */
  #define SLIPSTEP_INSTALLED_POLICIES "/usr/local/share/slipstep/policies"
#endif
/* In the build tree a link beside the library points to training/policies. Its address identifies the library. */
static const char build_policies[] = "slipstep-policies";

/* Gets the folder of the shared library, or of the program that contains the static one, without a / at its end. */
static PetscErrorCode LibraryFolder(char folder[], size_t len)
{
  Dl_info info;
  char path[PETSC_MAX_PATH_LEN], *slash;

  PetscFunctionBegin;
  folder[0] = 0;
  if (!dladdr(build_policies, &info) || !info.dli_fname) PetscFunctionReturn(PETSC_SUCCESS);
  /* the name of a program found by PATH has no folder */
  PetscCall(PetscGetRealPath(strchr(info.dli_fname, '/') ? info.dli_fname : "/proc/self/exe", path));
  PetscCall(PetscStrrchr(path, '/', &slash)); /* the text after the last /, or path itself */
  if (slash == path) PetscFunctionReturn(PETSC_SUCCESS);
  slash[-1] = 0;
  PetscCall(PetscStrncpy(folder, path, len));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* On one rank: the folder of the library's own policies */
static PetscErrorCode OwnFolder(char folder[], size_t len)
{
  char library[PETSC_MAX_PATH_LEN];
  PetscBool build, beside, installed = PETSC_FALSE;

  PetscFunctionBegin;
  PetscCall(LibraryFolder(library, sizeof(library)));
  PetscCall(PetscSNPrintf(folder, len, "%s/%s", library, build_policies));
  PetscCall(PetscTestDirectory(folder, 'r', &build));
  if (!build) PetscCall(PetscSNPrintf(folder, len, "%s/%s", library, SLIPSTEP_LIB_TO_POLICIES));
  PetscCall(PetscTestDirectory(folder, 'r', &beside));
  if (!beside) PetscCall(PetscTestDirectory(SLIPSTEP_INSTALLED_POLICIES, 'r', &installed));
  if (installed) PetscCall(PetscStrncpy(folder, SLIPSTEP_INSTALLED_POLICIES, len));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* On one rank: the folder that is used */
static PetscErrorCode PolicyFolder(char folder[], size_t len)
{
  const char *given = getenv("SLIPSTEP_POLICY_DIR");

  PetscFunctionBegin;
  if (given && given[0])
    PetscCall(PetscStrncpy(folder, given, len));
  else
    PetscCall(OwnFolder(folder, len));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Opens a file of measured numbers. A user's folder may have only policies; the library's own is searched then. */
PetscErrorCode SlipPolicyOpenData(const char name[], const char what[], SlipH5 *h)
{
  char folder[PETSC_MAX_PATH_LEN], path[PETSC_MAX_PATH_LEN];
  PetscBool exists;

  PetscFunctionBegin;
  PetscCall(PolicyFolder(folder, sizeof(folder)));
  PetscCall(PetscSNPrintf(path, sizeof(path), "%s/%s", folder, name));
  PetscCall(PetscTestFile(path, 'r', &exists));
  if (!exists) PetscCall(OwnFolder(folder, sizeof(folder)));
  if (!exists) PetscCall(PetscSNPrintf(path, sizeof(path), "%s/%s", folder, name));
  PetscCall(PetscTestFile(path, 'r', &exists));
  PetscCheck(
    exists, PETSC_COMM_SELF, PETSC_ERR_FILE_OPEN,
    "there is no file %s, which has %s: expected it beside the default policies of the library, or in the folder "
    "SLIPSTEP_POLICY_DIR",
    path, what);
  PetscCall(SlipH5OpenRead(path, h));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Checks format and version, with which files of policies and measured numbers begin. */
PetscErrorCode SlipPolicyCheckFormat(SlipH5 *h, const char format[], PetscInt version)
{
  char found[64];
  PetscInt number;

  PetscFunctionBegin;
  PetscCall(SlipH5ReadAttrString(h, "/", "format", found, sizeof(found)));
  PetscCheck(!strcmp(found, format), PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
             "%s: attribute format of / is \"%s\"; expected \"%s\"%s", h->name, found, format, h->source);
  PetscCall(SlipH5ReadAttrInt(h, "/", "version", &number));
  PetscCheck(number == version, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
             "%s: attribute version of / is %" PetscInt_FMT "; this library reads version %" PetscInt_FMT "%s", h->name,
             number, version, h->source);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipPolicyFindDefault - finds the file of the policy that comes with the library for a problem

  Collective

  Input Parameters:
+ comm    - communicator; its first rank searches, and all get the result
. problem - such as "fault": the policy is the file problem.h5
- len     - length of file, including the terminating zero

  Output Parameters:
+ file  - path of the policy, or where it would have to be
- found - whether it exists and can be read

  Level: intermediate

  Note:
  The folder is that of the environment variable `SLIPSTEP_POLICY_DIR` if it is set; else share/slipstep/policies of the
  installation that the shared library belongs to, wherever that was moved; else, in the build tree, training/policies
  of the source. With the static library the path is relative to the program, and then the folder that CMake was told
  to install to is searched.

.seealso: SlipPolicyLoad(), TSAdaptRLSetPolicyFile(), TSADAPTRL
@*/
PetscErrorCode SlipPolicyFindDefault(MPI_Comm comm, const char problem[], char file[], size_t len, PetscBool *found)
{
  char folder[PETSC_MAX_PATH_LEN], path[PETSC_MAX_PATH_LEN] = "", plain[PETSC_MAX_PATH_LEN];
  PetscMPIInt rank, there = 0;
  PetscErrorCode ierr = PETSC_SUCCESS;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  if (!rank) {
    PetscBool exists = PETSC_FALSE;

    ierr = PolicyFolder(folder, sizeof(folder));
    if (!ierr) ierr = PetscSNPrintf(path, sizeof(path), "%s/%s.h5", folder, problem);
    if (!ierr) ierr = PetscTestFile(path, 'r', &exists);
    if (!ierr && exists) ierr = PetscGetRealPath(path, plain); /* without links and .. */
    if (!ierr && exists) ierr = PetscStrncpy(path, plain, sizeof(path));
    there = exists ? 1 : 0;
  }
  PetscCall(SlipErrorBcast(comm, ierr));
  PetscCallMPI(MPI_Bcast(path, (PetscMPIInt)sizeof(path), MPI_CHAR, 0, comm));
  PetscCallMPI(MPI_Bcast(&there, 1, MPI_INT, 0, comm));
  PetscCall(PetscStrncpy(file, path, len));
  *found = there ? PETSC_TRUE : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}
