/* Faults of a user's family that begin under a given stress: a fault of its options, whose fields vary by waves, and
   whose stress is given by a share of the drop and a patch, by the field initial_traction, or by both. */
#include "runs.h"
#include <slipcompat.h>
#include <math.h>
#include <string.h>

#define WAVES 40
#define LONGEST_WAVE 8 /* over the shortest one */
#define SHORTEST 4     /* the shortest wave without -correlation, over the mean side of a cell */
#define FULL 0.98      /* of the strength: the stress outside of the patch is at most this */
#define EXCESS 0.01    /* of the patch, without -patch_excess */

static const char *const Fields[] = {"normal_stress",    "friction_residual", "friction_drop",
                                     "friction_slip",    "friction_rate",     "loading_rate",
                                     "initial_traction", "stressing_rate",    "healing_time"};
enum { FIELDS = PETSC_STATIC_ARRAY_LENGTH(Fields), STRESS = 0, RESIDUAL = 1, DROP = 2, TRACTION = 6 };

/* Cells of a fault that was set up, and what it has there; field[k] NULL: the fault has none */
typedef struct {
  PetscInt n;
  PetscReal *x, *y, *z; /* [n] centres [m] */
  PetscReal *field[FIELDS];
} Cells;

static PetscErrorCode CellsGet(SlipFault fault, Cells *c)
{
  PetscErrorCode code;
  Vec w;

  PetscFunctionBegin;
  PetscCall(SlipFaultCreateState(fault, &w));
  PetscCall(VecGetSize(w, &c->n));
  PetscCall(VecDestroy(&w));
  c->n /= 3;
  PetscCall(PetscMalloc3(c->n, &c->x, c->n, &c->y, c->n, &c->z));
  PetscCall(SlipFaultGetCentres(fault, c->n, c->x, c->y, c->z));
  for (PetscInt k = 0; k < FIELDS; ++k) {
    PetscCall(PetscMalloc1(c->n, &c->field[k]));
    PetscCall(PetscPushErrorHandler(PetscReturnErrorHandler, NULL));
    code = SlipFaultGetField(fault, Fields[k], c->n, c->field[k]);
    PetscCall(PetscPopErrorHandler());
    if (code) PetscCall(PetscFree(c->field[k]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- what is drawn ---- */

/* Numbers and words of a fault, the same for both of its makings */
typedef struct {
  PetscReal value[FAMILY_MAX_LINES];
  const char *word[FAMILY_MAX_LINES]; /* NULL: a number */
} Values;

static PetscReal Value(const Family *family, const Values *v, const char name[], PetscReal other)
{
  const FamilyLine *line = FamilyFind(family, name);

  return line ? v->value[line - family->line] : other;
}

/* files: with -fault_parameters; without it the fields are set one by one */
static PetscErrorCode MakeFault(const Family *family, const Values *v, PetscBool files, SlipFault *fault)
{
  PetscFunctionBegin;
  PetscCall(SlipFaultCreate(PETSC_COMM_SELF, fault));
  for (PetscInt i = 0; i < family->n; ++i) {
    const char *name = family->line[i].name + strlen("fault_");

    if (strncmp(family->line[i].name, "fault_", strlen("fault_"))) continue;
    if (!files && !strcmp(name, "parameters")) continue;
    if (v->word[i])
      PetscCall(FamilySetWord(*fault, name, v->word[i]));
    else
      PetscCall(SlipFaultSetReal(*fault, name, v->value[i]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Multiplies a field by exp(spread g), g of mean 0 and variance 1 over all draws: waves of random directions */
static void Vary(Random *random, const Cells *c, PetscReal spread, PetscReal shortest, PetscReal field[])
{
  if (spread <= 0) return;
  for (PetscInt k = 0; k < WAVES; ++k) {
    const double angle = 2 * PETSC_PI * RandomUniform(random), phase = 2 * PETSC_PI * RandomUniform(random);
    const double number = 2 * PETSC_PI / ((double)shortest * RandomLog(random, 1, LONGEST_WAVE));

    for (PetscInt i = 0; i < c->n; ++i)
      field[i] *= (PetscReal)exp((double)spread * sqrt(2.0 / WAVES) *
                                 cos(number * (cos(angle) * (double)c->x[i] + sin(angle) * (double)c->z[i]) + phase));
  }
}

static void Bounds(PetscInt n, const PetscReal x[], PetscReal *low, PetscReal *high)
{
  *low = *high = x[0];
  for (PetscInt i = 1; i < n; ++i) {
    *low = PetscMin(*low, x[i]);
    *high = PetscMax(*high, x[i]);
  }
}

/* Stress that is a share of the drop above the residual strength, below the strength outside of the patch */
static void SetStress(const Family *family, const Values *v, Random *random, Cells *c)
{
  const PetscReal share = Value(family, v, "stress_share", -1), radius = Value(family, v, "patch_radius", 0),
                  excess = Value(family, v, "patch_excess", (PetscReal)EXCESS),
                  at[2] = {RandomUniform(random), RandomUniform(random)};
  PetscReal low[2], high[2], centre[2], y = c->y[0], least = PETSC_MAX_REAL;

  Bounds(c->n, c->x, &low[0], &high[0]);
  Bounds(c->n, c->z, &low[1], &high[1]);
  centre[0] = low[0] + Value(family, v, "patch_x", at[0]) * (high[0] - low[0]);
  centre[1] = low[1] + Value(family, v, "patch_z", at[1]) * (high[1] - low[1]);
  for (PetscInt i = 0; i < c->n; ++i) { /* of the fault there */
    const PetscReal away = (PetscReal)hypot((double)(c->x[i] - centre[0]), (double)(c->z[i] - centre[1]));

    if (away < least) y = c->y[i];
    least = PetscMin(least, away);
  }
  for (PetscInt i = 0; i < c->n; ++i) {
    const PetscReal residual = c->field[RESIDUAL][i] * c->field[STRESS][i],
                    drop = c->field[DROP] ? c->field[DROP][i] * c->field[STRESS][i] : 0;
    PetscReal *stress = &c->field[TRACTION][i];

    if (share >= 0) *stress = PetscMin(residual + share * drop * (*stress), (PetscReal)FULL * (residual + drop));
    if (radius > 0 && hypot(hypot((double)(c->x[i] - centre[0]), (double)(c->z[i] - centre[1])),
                            (double)(c->y[i] - y)) < (double)radius)
      *stress = (1 + excess) * (residual + drop);
  }
}

/* A field of initial_traction varies by its spread whether it is given or a share of the drop. */
static PetscErrorCode DrawFields(const Family *family, const Values *v, Random *random, Cells *c)
{
  PetscReal low, high, shortest;

  PetscFunctionBegin;
  Bounds(c->n, c->x, &low, &high);
  shortest =
    Value(family, v, "correlation", (PetscReal)SHORTEST * PetscMax(high - low, 1) / PetscSqrtReal((PetscReal)c->n));
  if (FamilyFind(family, "stress_share"))
    for (PetscInt i = 0; i < c->n; ++i) c->field[TRACTION][i] = 1;
  for (PetscInt k = 0; k < FIELDS; ++k) {
    char name[FAMILY_NAME];

    PetscCall(PetscSNPrintf(name, sizeof(name), "spread_%s", Fields[k]));
    if (c->field[k]) Vary(random, c, Value(family, v, name, 0), shortest, c->field[k]);
  }
  SetStress(family, v, random, c);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The fault is made twice: first to know its cells and what files say of them. */
PetscErrorCode RunDrawOfFamily(RunEpisode *e, Random *random)
{
  const Family *family = e->family;
  SlipFault first;
  Cells cells;
  Values v;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < family->n; ++i) {
    const FamilyLine *line = &family->line[i];

    v.word[i] = line->nchoices ? FamilyChoose(line, random) : NULL;
    v.value[i] = line->nchoices ? 0 : FamilyDraw(line, random);
    if (!strcmp(line->name, "fault_nx") || !strcmp(line->name, "fault_nz"))
      v.value[i] = PetscFloorReal(v.value[i] + (PetscReal)0.5);
  }
  e->margin = Value(family, &v, "margin", (PetscReal)(1 + 2 * RandomUniform(random) * RandomUniform(random)));
  e->end = Value(family, &v, "duration", 0);
  PetscCall(MakeFault(family, &v, PETSC_TRUE, &first));
  PetscCall(SlipFaultSetBool(first, "initial_unstable", PETSC_TRUE));
  PetscCall(SlipFaultSetUp(first));
  PetscCall(CellsGet(first, &cells));
  PetscCall(SlipFaultDestroy(&first));
  PetscCall(DrawFields(family, &v, random, &cells));
  PetscCall(MakeFault(family, &v, PETSC_FALSE, &e->fault));
  for (PetscInt k = 0; k < FIELDS; ++k)
    if (cells.field[k]) PetscCall(SlipFaultSetField(e->fault, Fields[k], cells.n, cells.field[k]));
  PetscCall(SlipFaultSetUp(e->fault));
  e->n = cells.n;
  PetscCall(PetscFree3(cells.x, cells.y, cells.z));
  for (PetscInt k = 0; k < FIELDS; ++k) PetscCall(PetscFree(cells.field[k]));
  PetscFunctionReturn(PETSC_SUCCESS);
}
