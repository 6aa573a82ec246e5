/* Parameters that a registered friction law brings: names and bounds that are refused; numbers, options and fields of a
   fault that was there before the law; what the law's functions get of each cell. */
#include "unit.h"
#include "faultstart.h"
#include <slipstep/private/slipfault.h>

enum { DROP, COUNT, TIME, NOWN };
static const SlipParameter own[] = {
  {"mine_drop", 0.25, "", 0, 0.5, PETSC_TRUE, PETSC_FALSE, "Drop", SLIP_PART_PROBLEM},
  {"mine_count", 2, "", 1, PETSC_MAX_REAL, PETSC_FALSE, PETSC_TRUE, "Count", SLIP_PART_PROBLEM},
  {"mine_time", 5, "s", PETSC_MIN_REAL, PETSC_MAX_REAL, PETSC_FALSE, PETSC_FALSE, "Time", SLIP_PART_PROBLEM},
  {.name = NULL},
};

/* Tells the parameters apart */
static void Mine(const SlipFriction *p, const PetscReal s[], PetscReal v, PetscReal *excess, PetscReal ds[],
                 PetscReal *dv)
{
  *excess = p->own ? 1e-3 * p->own[DROP] + 1e-6 * p->own[COUNT] + 1e-9 * p->own[TIME] : 0;
  *ds = *dv = 0;
}

static SlipFrictionLaw Law(const char name[], const SlipParameter *rows)
{
  return (SlipFrictionLaw){.name = name, .eval = Mine, .formula = "mine", .own = rows};
}

/* After a law with one row like another, with another name, the table is what it was. */
static void Refused(SlipParameter row, const char name[], const char words[])
{
  SlipParameter rows[] = {row, {.name = NULL}};
  const SlipFrictionLaw law = Law("bad", rows), *found;

  rows[0].name = name;
  fails(SlipFaultRegisterFrictionLaw(&law), words);
  ok(SlipFrictionFind("bad", &found));
  assert_null(found);
}

static void late_and_refused(void **state)
{
  const SlipFrictionLaw law = Law("mine", own), other = Law("other", NULL);
  static const char *const taken[] = {"friction_a", "nx", "friction_law", "inertia", "view", "cells", "x", "mine_time"};
  SlipParameter row = own[0], many[FAULT_MAX_OWN + 1] = {{.name = NULL}};
  const SlipParameter twice[] = {own[0], own[0], {.name = NULL}};
  SlipFault fault;
  PetscReal x, cells[] = {0.1, 0.2, 0.3, 0.4}, sum[4];
  SlipFrictionCells f;
  char names[FAULT_MAX_OWN][16];
  SlipFrictionLaw bad = Law("bad", twice);

  ok(SlipFaultCreate(PETSC_COMM_SELF, &fault));
  fails(SlipFaultGetReal(fault, "mine_drop", &x), "no number \"mine_drop\"");
  ok(SlipFaultRegisterFrictionLaw(&other));
  ok(SlipFaultRegisterFrictionLaw(&law));
  for (size_t k = 0; k < sizeof(taken) / sizeof(*taken); k++) Refused(own[0], taken[k], taken[k]);
  Refused(own[0], "two words", "\"two words\", expected a name");
  Refused(own[0], "a_name_that_is_longer_than_anybody_could_want_it_to_be", "expected a name");
  row.value = 0.5;
  Refused(row, "bad_drop", "bad_drop of the friction law bad is 0.5 by default, expected a number > 0 and < 0.5");
  row.value = NAN;
  Refused(row, "bad_drop", "bad_drop");
  row = own[0];
  row.help = NULL;
  Refused(row, "bad_drop", "bad_drop");
  fails(SlipFaultRegisterFrictionLaw(&bad), "mine_drop");
  for (int k = 0; k < FAULT_MAX_OWN; k++) {
    many[k] = own[0];
    many[k].name = names[k];
    (void)snprintf(names[k], sizeof(names[k]), "many_%d", k);
  }
  bad.own = many;
  fails(SlipFaultRegisterFrictionLaw(&bad), "many_59 of the friction law bad is one of more than 64");

  /* the fault was there before */
  ok(SlipFaultGetReal(fault, "mine_drop", &x));
  assert_true(x == 0.25);
  fails(SlipFaultSetReal(fault, "mine_drop", 0.5), "-fault_mine_drop is 0.5, expected a number > 0 and < 0.5");
  fails(SlipFaultSetReal(fault, "mine_count", 1.5), "expected a whole number >= 1");
  ok(PetscOptionsInsertString(NULL, "-fault_nx 2 -fault_nz 2 -fault_mine_time 2min -fault_mine_count 3"));
  ok(SlipFaultDeclareOptions());
  ok(SlipCheckOwnOptions(PETSC_COMM_SELF, NULL, NULL));
  ok(SlipFaultSetFromOptions(fault));
  ok(PetscOptionsClear(NULL));
  ok(SlipFaultGetReal(fault, "mine_time", &x));
  assert_true(x == 120);
  ok(FaultSetStrings(fault, {"friction_law", "mine"}, {"initial", "rest"}));
  ok(SlipFaultSetField(fault, "mine_drop", 4, cells));
  ok(SlipFaultSetUp(fault));
  ok(SlipFaultGetFriction(fault, 0, &f));
  for (PetscInt i = 0; i < 4; i++) {
    PetscReal mu, ds, dv;

    SlipFrictionEvaluate(&f, i, NULL, 0, &mu, &ds, &dv);
    assert_true(fabs(mu - (0.5 + 1e-3 * cells[i] + 3e-6 + 120e-9)) < 1e-15);
  }
  ok(SlipFaultGetField(fault, "mine_count", 4, sum));
  assert_true(sum[0] == 3 && sum[3] == 3);
  ok(SlipFaultGetField(fault, "mine_drop", 4, sum));
  assert_memory_equal(sum, cells, sizeof(cells));
  fails(SlipFaultSetReal(fault, "mine_drop", 0.1), "mine_drop must be set before");
  ok(SlipFaultDestroy(&fault));
}

/* Rate-and-state friction with a second state that decays with slip */
static void Warm(const SlipFriction *p, const PetscReal s[], PetscReal v, PetscReal *mu, PetscReal ds[], PetscReal *dv)
{
  SlipRateAndState(p, s, v, mu, ds, dv);
  ds[1] = 0;
}

static void WarmRate(const SlipFriction *p, const PetscReal s[], PetscReal v, PetscReal rate[], PetscReal ds[],
                     PetscReal dv[])
{
  SlipRateAndStateRate(p, s, v, rate, ds, dv);
  rate[1] = -v * s[1];
  ds[3] = -v;
  dv[1] = -s[1];
}

static void WarmSteady(const SlipFriction *p, PetscReal v, PetscReal s[])
{
  SlipRateAndStateSteady(p, v, s);
  s[1] = 0;
}

/* States whose names or starts are no good, and a law that begins with a parameter which has no default */
static void states(void **unused)
{
  static const SlipParameter start[] = {{.name = "initial_warmth",
                                         .value = (PetscReal)NAN,
                                         .unit = "K",
                                         .upper = PETSC_MAX_REAL,
                                         .help = "Warmth at the start"},
                                        {.name = NULL}};
  static const struct {
    const char *name, *start, *words;
  } bad[] = {{"Warmth", "initial_warmth", "is called \"Warmth\", expected a name"},
             {"slip", "initial_warmth",
              "is called \"slip\", expected a name of small letters, digits and _, of less than 48, that no other"},
             {"state", "initial_warmth", "State 1 of the friction law warm is called \"state\""},
             {"warmth", "initial_heat", "starts with the parameter \"initial_heat\", expected initial_state"},
             {"warmth", "mine_drop", "starts with the parameter \"mine_drop\""},
             {"warmth", NULL, "starts with the parameter \"\""}};
  SlipFrictionLaw law;
  SlipFrictionState two[2];
  SlipFault fault;
  PetscReal x, rtol;
  PetscInt n;
  const PetscReal *a;
  const SlipFrictionLaw *found;
  TS ts;
  Vec w, atol;

  ok(SlipFrictionFind("rate_and_state", &found));
  law = *found;
  law.name = "warm";
  law.states = two;
  law.nstates = 2;
  law.eval = Warm;
  law.rate = WarmRate;
  law.steady = WarmSteady;
  law.balance = NULL;
  law.keep = NULL;
  two[0] = found->states[0];
  for (size_t k = 0; k < sizeof(bad) / sizeof(*bad); k++) {
    law.own = k < 3 ? start : NULL;
    two[1] = (SlipFrictionState){.name = bad[k].name, .start = bad[k].start};
    fails(SlipFaultRegisterFrictionLaw(&law), bad[k].words);
  }
  law.own = start;
  two[1] = (SlipFrictionState){.name = "warmth", .start = "initial_state"};
  fails(SlipFaultRegisterFrictionLaw(&law), "initial_warmth of the friction law warm is nan. by default");
  two[1].start = "initial_warmth";
  two[1].shown = found->states[0].shown;
  fails(SlipFaultRegisterFrictionLaw(&law), "State 1 of the friction law warm needs a name, and both or none of shown");
  two[1].shown = NULL;
  ok(SlipFaultRegisterFrictionLaw(&law));
  ok(SlipFaultCreate(PETSC_COMM_SELF, &fault));
  ok(SlipFaultGetReal(fault, "initial_warmth", &x));
  assert_true(isnan(x));
  fails(SlipFaultSetReal(fault, "initial_warmth", -1), "-fault_initial_warmth is -1, expected a number");
  /* its place in the state, behind v, u and theta, its start, and its tolerance, that of ln theta */
  ok(SlipFaultSetString(fault, "friction_law", "warm"));
  ok(FaultSetReals(fault, {"initial_warmth", 3}, {"loading_rate", 1e-9}));
  ok(FaultSetUpState(fault, &w));
  ok(TSCreate(PETSC_COMM_SELF, &ts));
  ok(SlipFaultConfigureTS(fault, ts));
  ok(TSGetTolerances(ts, NULL, &atol, &rtol, NULL));
  ok(VecGetSize(w, &n));
  assert_int_equal(n, 4);
  a = VecRead(w);
  assert_true(a[3] == 3 && VecRead(atol)[3] == rtol && VecRead(atol)[2] == rtol);
  ObjectsDestroy(&ts, &w, &fault);
}

enum { TIME_UP = 4, TIME_DOWN = 9 }; /* [s] */

/* A law that sticks, stronger with each of two states, which approach 1 and -1 while nothing slips */
static void Sets(const SlipFriction *p, const PetscReal s[], PetscReal v, PetscReal *excess, PetscReal ds[],
                 PetscReal *dv)
{
  *excess = 0.1 * s[0] - 0.01 * s[1];
  ds[0] = 0.1;
  ds[1] = -0.01;
  *dv = 0;
}

static void SetsRate(const SlipFriction *p, const PetscReal s[], PetscReal v, PetscReal rate[], PetscReal ds[],
                     PetscReal dv[])
{
  rate[0] = (1 - s[0]) / TIME_UP - v * s[0];
  rate[1] = (-1 - s[1]) / TIME_DOWN - v * s[1];
  ds[0] = -1.0 / TIME_UP - v;
  ds[3] = -1.0 / TIME_DOWN - v;
  dv[0] = -s[0];
  dv[1] = -s[1];
}

static void SetsSteady(const SlipFriction *p, PetscReal v, PetscReal s[])
{
  s[0] = 1 / (1 + TIME_UP * v);
  s[1] = -1 / (1 + TIME_DOWN * v);
}

/* Both states of a loaded cell that rests are where the exponentials are, 1 - exp(-t/T), to a step of second order,
   (h/T)^2/12 with h = 0.1; and no rest is jumped over. Started without stress, it does not slip within the time. */
static void states_at_rest(void **unused)
{
  static const SlipFrictionState two[] = {{.name = "up"}, {.name = "down"}};
  const SlipFrictionLaw law = {.name = "sets",
                               .eval = Sets,
                               .formula = "sets",
                               .states = two,
                               .nstates = 2,
                               .rate = SetsRate,
                               .steady = SetsSteady};
  PetscReal up, down, other;
  SlipFault fault;
  TS ts;
  Vec w;

  ok(SlipFaultRegisterFrictionLaw(&law));
  ok(SlipFaultCreate(PETSC_COMM_SELF, &fault));
  ok(FaultSetStrings(fault, {"friction_law", "sets"}, {"initial", "rest"}));
  ok(SlipFaultSetReal(fault, "loading_rate", 1e-9));
  ok(FaultSetUpState(fault, &w));
  ok(TSCreate(PETSC_COMM_SELF, &ts));
  ok(SlipFaultConfigureTS(fault, ts));
  SetAdapt(ts, TSADAPTNONE);
  ok(TSSetTimeStep(ts, 0.1));
  ok(TSSetMaxTime(ts, 5));
  ok(TSSolve(ts, w));
  ok(SlipFaultGetCellValues(fault, 5, w, "up", 1, &up));
  ok(SlipFaultGetCellValues(fault, 5, w, "down", 1, &down));
  assert_true(fabs(up - (1 - exp(-5.0 / TIME_UP))) < 1e-4);
  assert_true(fabs(down + (1 - exp(-5.0 / TIME_DOWN))) < 1e-4);
  fails(SlipFaultGetCellValues(fault, 5, w, "state", 1, &other),
        "a state has no \"state\", expected slip_rate, displacement, slip, up, down,");
  ObjectsDestroy(&ts, &w, &fault);
}

/* Values out of bounds, or that are not whole, of a field */
static void fields(void **state)
{
  static const struct {
    const char *name;
    PetscReal value;
    const char *words;
  } bad[] = {{"mine_drop", 0.5, "/mine_drop[0, 1] is 0.5, expected a finite number > 0 and < 0.5"},
             {"mine_count", 1.5, "/mine_count[0, 1] is 1.5, expected a whole number >= 1"},
             {"mine_time", NAN, "/mine_time[0, 1] is nan, expected a finite number s"}};
  SlipFault fault;

  for (size_t k = 0; k < sizeof(bad) / sizeof(*bad); k++) {
    const PetscReal values[] = {bad[k].value > 1 ? 1 : 0.25, bad[k].value};

    ok(SlipFaultCreate(PETSC_COMM_SELF, &fault));
    ok(SlipFaultSetReal(fault, "nx", 2));
    ok(SlipFaultSetField(fault, bad[k].name, 2, values));
    fails(SlipFaultSetUp(fault), bad[k].words);
    ok(SlipFaultDestroy(&fault));
  }
}

SLIP_TESTS(late_and_refused, states, states_at_rest, fields)
