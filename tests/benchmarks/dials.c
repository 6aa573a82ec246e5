static const char help[] = "What a policy and classical controllers need for an accuracy, on drawn episodes of a "
                           "problem that no training has seen.\n"
                           "  dials -problem rupture -policy training/policies/rupture.h5\n"
                           "  dials -problem rupture -cases 8 -seed 3   (classical controllers alone)\n"
                           "  dials -problem rupture -train_family thrusts.opts   (a user's own faults)\n"
                           "Prints tables in Markdown.\n\n";

#include "common/options.h"
#include "dials/ladder.h"
#include "environment/family.h"
#include <slipcompat.h>
#include <slipstep/rooms.h>

static const PetscReal Dials[] = {1e-1, 3e-2, 1e-2, 3e-3};
enum { DIALS = PETSC_STATIC_ARRAY_LENGTH(Dials) };
#define WITHIN 0.95
/* Classical runs are tightened until their errors are this share of the finest dial and of all the policy's, or
   -most_solves is reached: runs at the tightest tolerances, which run out of attempts, took most of the time */
#define SMALL 0.5

typedef struct {
  const Problem *problem;
  Family *family; /* NULL: the problem's own draws */
  PetscInt seed, stream, first, cases;
  PetscReal most; /* solves of a classical run beyond which none is tighter, over the policy's most */
  PetscBool cost;
  char policy[PETSC_MAX_PATH_LEN], controllers[256];
} Options;

static PetscErrorCode ReadOptions(Options *o)
{
  const NumberOption row[] = {OPTION_INTEGER("-seed", "Of the draws", &o->seed, 0, PETSC_MAX_INT),
                              OPTION_INTEGER("-stream", "Of seeds; training has others", &o->stream, 0, 1000000),
                              OPTION_INTEGER("-first", "The first draw of the stream", &o->first, 0, PETSC_MAX_INT),
                              OPTION_INTEGER("-cases", "Draws", &o->cases, 1, 100000),
                              OPTION_REAL("-most_solves",
                                          "A classical run with so many times the most solves of the policy on this "
                                          "draw is the last one of its controller; what it is not exact enough for "
                                          "counts as none. 0: no limit",
                                          &o->most, 0, PETSC_MAX_REAL)};
  const char *names[64] = {NULL};
  PetscInt n = 0, k = 0;

  *o = (Options){.stream = 99, .cases = 40, .most = 20, .controllers = DIAL_CONTROLLERS};
  for (PetscInt i = 0; ProblemTable[i]; i++)
    if (ProblemTable[i]->cma && ProblemTable[i]->cma->classical) names[n++] = ProblemTable[i]->name;
  PetscOptionsBegin(PETSC_COMM_SELF, NULL, "Dials", "");
  PetscCall(OptionChoice(PetscOptionsObject, "-problem", "Whose episodes are drawn", names, &k));
  PetscCall(OptionsNumbers(PetscOptionsObject, PETSC_STATIC_ARRAY_LENGTH(row), row));
  PetscCall(PetscOptionsString("-policy", "File of the policy (default: classical controllers alone)", NULL, o->policy,
                               o->policy, sizeof(o->policy), NULL));
  PetscCall(PetscOptionsString("-controllers", "Classical types, and filters of pi and dsp, with commas between", NULL,
                               o->controllers, o->controllers, sizeof(o->controllers), NULL));
  PetscCall(PetscOptionsBool("-cost",
                             "Runs are weighed by their cost [us], not by their solves (rupture, injection, sequence)",
                             NULL, o->cost, &o->cost, NULL));
  PetscCall(FamilyOption(PetscOptionsObject, &o->family));
  PetscOptionsEnd();
  for (PetscInt i = 0; ProblemTable[i]; i++)
    if (!strcmp(ProblemTable[i]->name, names[k])) o->problem = ProblemTable[i];
  PetscCheck(!o->cost || o->problem->cma->runs, PETSC_COMM_SELF, PETSC_ERR_SUP,
             "-cost: the problem %s counts none, expected one of rupture, injection and sequence", names[k]);
  return ProblemCheckFamily(o->problem, o->family);
}

/* run [DIALS][n] */
static PetscErrorCode RunPolicy(const Options *o, Ladder *l, LadderRun run[])
{
  SlipPolicy policy;
  EpisodeResult r;

  PetscCall(SlipPolicyCreate(PETSC_COMM_SELF, &policy));
  PetscCall(SlipPolicyLoad(policy, o->policy));
  /* As one for any TS: the library would refuse one of another problem than it names by itself to such runs. */
  PetscCall(SlipPolicySetAttribute(policy, "problem", "ode"));
  for (PetscInt d = 0; d < DIALS; d++)
    for (PetscInt e = 0; e < l->n; e++) {
      PetscCall((*l->cma->run)(l->episode[e], policy, Dials[d], &r));
      run[d * l->n + e] =
        (LadderRun){LadderCost(l, &r), r.done < 1 || PetscIsInfOrNanReal(r.error) ? PETSC_MAX_REAL : r.error};
    }
  return SlipPolicyDestroy(&policy);
}

/* ---- tables ---- */

/* Of pairs */
typedef struct {
  PetscReal mean, least;
  PetscInt n, none; /* none: no classical run was exact enough */
} Ratio;

static void RatioAdd(Ratio *r, PetscInt best, PetscInt solves)
{
  const PetscReal x = (PetscReal)best / (PetscReal)PetscMax(solves, 1);

  if (!best) {
    r->none++;
    return;
  }
  r->mean = (r->mean * (PetscReal)r->n + x) / (PetscReal)(r->n + 1);
  r->least = r->n ? PetscMin(r->least, x) : x;
  r->n++;
}

static const char *Counted(const Ladder *l)
{
  return l->work ? "us" : "solves";
}

static PetscErrorCode PolicyTable(const Ladder *l, const LadderRun run[])
{
  PetscCall(PetscPrintf(PETSC_COMM_SELF,
                        "| dial | policy: kept | median error | %s | best classical at the dial over "
                        "it: mean | least | at its error: mean | least | none |\n"
                        "|---|---|---|---|---|---|---|---|---|\n",
                        Counted(l)));
  for (PetscInt d = 0; d < DIALS; d++) {
    const LadderRun *r = run + d * l->n;
    Ratio dial = {0}, equal = {0};
    LadderScore score;

    LadderScoreRuns(l->n, r, Dials[d], &score);
    for (PetscInt e = 0; e < l->n; e++) {
      RatioAdd(&dial, LadderCheapest(l, e, Dials[d]), r[e].solves);
      RatioAdd(&equal, LadderCheapest(l, e, r[e].error), r[e].solves);
    }
    PetscCall(PetscPrintf(PETSC_COMM_SELF,
                          "| %g | %.1f %% | %.2e | %.1f | %.2f | %.2f | %.2f | %.2f | %" PetscInt_FMT " |\n",
                          (double)Dials[d], 100 * (double)score.kept, (double)score.median, (double)score.solves,
                          (double)dial.mean, (double)dial.least, (double)equal.mean, (double)equal.least, equal.none));
  }
  return PetscPrintf(PETSC_COMM_SELF, "\n");
}

/* The setting, of all controllers and of the ladder's tolerances, with the fewest solves of those that keep the dial */
static PetscErrorCode BestSetting(Ladder *l, PetscReal dial, PetscInt *controller, PetscInt *rung, PetscReal *solves)
{
  PetscReal worst[LADDER_RUNGS];

  *solves = 0;
  *controller = *rung = 0;
  for (PetscInt c = 0; c < l->ncontrollers; c++) {
    LadderWorst(l, c, (PetscReal)WITHIN, worst);
    for (PetscInt k = 0; k < LADDER_RUNGS; k++) {
      PetscReal mean = 0;
      LadderRun run;

      if (worst[k] > dial) continue;
      for (PetscInt e = 0; e < l->n; e++) {
        PetscCall(LadderRunAt(l, e, c, k, &run));
        mean += (PetscReal)run.solves / (PetscReal)l->n;
      }
      if (*solves == 0 || mean < *solves) {
        *solves = mean;
        *controller = c;
        *rung = k;
      }
      break; /* tighter ones cost more */
    }
  }
  return PETSC_SUCCESS;
}

static PetscErrorCode ClassicalTable(Ladder *l)
{
  PetscCall(PetscPrintf(PETSC_COMM_SELF,
                        "| dial | best classical run, chosen afterwards: %s | the one setting that keeps the dial in "
                        "%g %% | its %s |\n|---|---|---|---|\n",
                        Counted(l), 100 * WITHIN, Counted(l)));
  for (PetscInt d = 0; d < DIALS; d++) {
    PetscReal mean = 0, solves;
    PetscInt c, k, none = 0;

    for (PetscInt e = 0; e < l->n; e++) {
      const PetscInt best = LadderCheapest(l, e, Dials[d]);

      mean += (PetscReal)best;
      none += best ? 0 : 1;
    }
    PetscCall(BestSetting(l, Dials[d], &c, &k, &solves));
    PetscCall(PetscPrintf(PETSC_COMM_SELF, "| %g | %.1f", (double)Dials[d],
                          (double)(mean / (PetscReal)PetscMax(l->n - none, 1))));
    if (none) PetscCall(PetscPrintf(PETSC_COMM_SELF, " (none in %" PetscInt_FMT ")", none));
    if (solves > 0)
      PetscCall(PetscPrintf(PETSC_COMM_SELF, " | `%s` %.3g | %.1f |\n", l->controller[c], (double)LadderTolerance(k),
                            (double)solves));
    else
      PetscCall(PetscPrintf(PETSC_COMM_SELF, " | none | |\n"));
  }
  return PetscPrintf(PETSC_COMM_SELF, "\n");
}

/* Each controller at the tolerance of -fault_accuracy */
static PetscErrorCode LibraryTable(Ladder *l, const char problem[])
{
  static const char *const kinds[] = {"rupture", "sequence", "injection", NULL};
  const char *kind = NULL;

  if (!strcmp(problem, "fault_dial")) kind = "event";
  for (PetscInt i = 0; kinds[i]; i++)
    if (!strcmp(problem, kinds[i])) kind = kinds[i];
  if (!kind) return PETSC_SUCCESS;
  PetscCall(PetscPrintf(PETSC_COMM_SELF,
                        "| `-fault_accuracy` | controller | `-ts_rtol` | kept | median error | %s |\n"
                        "|---|---|---|---|---|---|\n",
                        Counted(l)));
  for (PetscInt d = 0; d < DIALS; d++)
    for (PetscInt c = 0; c < l->ncontrollers; c++) {
      LadderScore score;
      PetscReal rtol;

      PetscCall(SlipFaultFindTolerance(kind, l->controller[c], Dials[d], &rtol));
      if (rtol == 0) continue;
      PetscCall(LadderScoreSetting(l, l->controller[c], rtol, Dials[d], &score));
      PetscCall(PetscPrintf(PETSC_COMM_SELF, "| %g | `%s` | %.3g | %.1f %% | %.2e | %.1f |\n", (double)Dials[d],
                            l->controller[c], (double)rtol, 100 * (double)score.kept, (double)score.median,
                            (double)score.solves));
    }
  return PETSC_SUCCESS;
}

/* run [DIALS][n], of the policy; 0 where there is none */
static PetscErrorCode Climb(const Options *o, Ladder *l, const LadderRun run[])
{
  PetscInt limited = 0;
  PetscBool cut;

  for (PetscInt e = 0; e < l->n; e++) {
    PetscReal below = (PetscReal)SMALL * Dials[DIALS - 1], most = 0;

    for (PetscInt d = 0; d < DIALS && o->policy[0]; d++) {
      below = PetscMin(below, (PetscReal)SMALL * run[d * l->n + e].error);
      most = PetscMax(most, o->most * (PetscReal)run[d * l->n + e].solves);
    }
    for (PetscInt c = 0; c < l->ncontrollers; c++) {
      PetscCall(LadderClimb(l, e, c, below, (PetscInt)PetscMin(most, (PetscReal)1e9), &cut));
      limited += cut ? 1 : 0;
    }
  }
  if (limited)
    PetscCall(PetscPrintf(PETSC_COMM_SELF,
                          "%" PetscInt_FMT " of %" PetscInt_FMT " pairs of a draw and a classical controller ended at "
                          "%g times the policy's solves (-most_solves)\n\n",
                          limited, l->n * l->ncontrollers, (double)o->most));
  return PETSC_SUCCESS;
}

static PetscErrorCode Run(void)
{
  PetscBool only_help;
  LadderRun *run;
  Options o;
  Ladder l;

  PetscCall(ReadOptions(&o));
  PetscCall(PetscOptionsHasHelp(NULL, &only_help));
  if (only_help) return PETSC_SUCCESS;
  PetscCall(LadderCreate(o.problem, o.family, o.seed, o.stream, o.first, o.cases, o.controllers, &l));
  l.work = o.cost;
  PetscCall(PetscCalloc1(DIALS * l.n, &run));
  if (o.policy[0]) PetscCall(RunPolicy(&o, &l, run));
  PetscCall(PetscPrintf(PETSC_COMM_SELF,
                        "%s: draws %" PetscInt_FMT " to %" PetscInt_FMT " of stream %" PetscInt_FMT
                        ", seed %" PetscInt_FMT "\n\n",
                        o.problem->name, o.first, o.first + o.cases - 1, o.stream, o.seed));
  PetscCall(Climb(&o, &l, run));
  if (o.policy[0]) PetscCall(PolicyTable(&l, run));
  PetscCall(ClassicalTable(&l));
  PetscCall(LibraryTable(&l, o.problem->name));
  PetscCall(PetscFree(run));
  PetscCall(LadderDestroy(&l));
  return PetscFree(o.family);
}

int main(int argc, char **argv)
{
  PetscCall(PetscInitialize(&argc, &argv, NULL, help));
  PetscCall(SlipStepInitializePackage());
  PetscCall(Run());
  return PetscFinalize();
}
