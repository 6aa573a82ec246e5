/* The policies of a matrix: files found by name or pattern, and what their headers say. */
#include "evaluate.h"
#include <slipcompat.h>
#include "common/files.h"
#include <glob.h>

/* The name of a policy is that of its file without folders and ending. */
static PetscErrorCode NameOf(const char file[], char name[], size_t len)
{
  const char *slash = strrchr(file, '/');
  char *dot;

  PetscFunctionBegin;
  PetscCall(PetscStrncpy(name, slash ? slash + 1 : file, len));
  dot = strrchr(name, '.');
  if (dot && dot != name) *dot = '\0';
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadText(SlipH5 *h, const char attr[], char value[], size_t len)
{
  PetscBool has;

  PetscFunctionBegin;
  value[0] = '\0';
  PetscCall(SlipH5HasAttribute(h, "/", attr, &has));
  if (has) PetscCall(SlipH5ReadAttrString(h, "/", attr, value, len));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadHeader(EvaluatePolicy *p)
{
  SlipH5 h;
  SlipPolicy policy;
  const char *hash, *const *names;
  PetscInt n;
  PetscBool has;

  PetscFunctionBegin;
  PetscCall(SlipPolicyCreate(PETSC_COMM_SELF, &policy));
  PetscCall(SlipPolicyLoad(policy, p->file)); /* complains about whatever is no policy */
  PetscCall(SlipPolicyGetHash(policy, &hash));
  PetscCall(PetscStrncpy(p->hash, hash, sizeof(p->hash)));
  PetscCall(SlipPolicyGetObservations(policy, &n, &names));
  p->dial = PETSC_FALSE;
  for (PetscInt i = 0; i < n && !p->dial; i++) PetscCall(PetscStrcmp(names[i], "log_accuracy", &p->dial));
  PetscCall(SlipPolicyDestroy(&policy));
  PetscCall(SlipH5OpenRead(p->file, &h));
  PetscCall(ReadText(&h, "problem", p->problem, sizeof(p->problem)));
  PetscCall(ReadText(&h, "algorithm", p->algorithm, sizeof(p->algorithm)));
  PetscCall(SlipH5HasAttribute(&h, "/", "alpha", &has));
  p->alpha = NAN;
  if (has) PetscCall(SlipH5ReadAttrReal(&h, "/", "alpha", &p->alpha));
  PetscCall(SlipH5Close(&h));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Add(const char file[], PetscInt *n, EvaluatePolicy **policies)
{
  EvaluatePolicy *p;
  PetscBool same;

  PetscFunctionBegin;
  PetscCall(PetscRealloc(sizeof(**policies) * (size_t)(*n + 1), policies));
  p = &(*policies)[*n];
  PetscCall(PetscStrncpy(p->file, file, sizeof(p->file)));
  PetscCall(NameOf(file, p->name, sizeof(p->name)));
  for (PetscInt i = 0; i < *n; i++) {
    PetscCall(PetscStrcmp((*policies)[i].file, file, &same));
    if (same) PetscFunctionReturn(PETSC_SUCCESS);
    PetscCall(PetscStrcmp((*policies)[i].name, p->name, &same));
    PetscCheck(!same, PETSC_COMM_WORLD, PETSC_ERR_ARG_WRONG,
               "-evaluate_policies has %s and %s: cells are kept by the name %s, expected different ones",
               (*policies)[i].file, file, p->name);
  }
  PetscCall(ReadHeader(p));
  ++*n;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EvaluatePoliciesFind(PetscInt n, char *const patterns[], PetscInt *npolicies, EvaluatePolicy **policies)
{
  PetscFunctionBegin;
  *npolicies = 0;
  *policies = NULL;
  for (PetscInt i = 0; i < n; i++) {
    glob_t found;

    PetscCheck(!glob(patterns[i], GLOB_NOCHECK, NULL, &found), PETSC_COMM_WORLD, PETSC_ERR_FILE_OPEN,
               "-evaluate_policies %s cannot be looked up", patterns[i]);
    for (size_t k = 0; k < found.gl_pathc; k++)
      PetscCallFile("-evaluate_policies", Add(found.gl_pathv[k], npolicies, policies));
    globfree(&found);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
