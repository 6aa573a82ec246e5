/* Parameters that a registered friction law brings: names and bounds that are refused; numbers, options and fields of a fault that
   was there before the law; what the law's functions get of each cell. */
#include "unit.h"
#include <slipstep/private/slipfault.h>

enum { DROP, COUNT, TIME, NOWN };
static const SlipParameter own[] = {
  {"mine_drop", 0.25, "", 0, 0.5, PETSC_TRUE, PETSC_FALSE, "Drop", SLIP_PART_PROBLEM},
  {"mine_count", 2, "", 1, PETSC_MAX_REAL, PETSC_FALSE, PETSC_TRUE, "Count", SLIP_PART_PROBLEM},
  {"mine_time", 5, "s", PETSC_MIN_REAL, PETSC_MAX_REAL, PETSC_FALSE, PETSC_FALSE, "Time", SLIP_PART_PROBLEM},
  {.name = NULL},
};

/* Tells the parameters apart */
static void Mine(const SlipFriction *p, PetscReal s, PetscReal v, PetscReal *excess, PetscReal *ds, PetscReal *dv)
{
  (void)s, (void)v;
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

  (void)state;
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
  fails(SlipFaultRegisterFrictionLaw(&bad), "many_61 of the friction law bad is one of more than 64");

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
  ok(SlipFaultSetString(fault, "friction_law", "mine"));
  ok(SlipFaultSetString(fault, "initial", "rest"));
  ok(SlipFaultSetField(fault, "mine_drop", 4, cells));
  ok(SlipFaultSetUp(fault));
  ok(SlipFaultGetFriction(fault, 0, &f));
  for (PetscInt i = 0; i < 4; i++) {
    PetscReal mu, ds, dv;

    SlipFrictionEvaluate(&f, i, 0, 0, &mu, &ds, &dv);
    assert_true(fabs(mu - (0.5 + 1e-3 * cells[i] + 3e-6 + 120e-9)) < 1e-15);
  }
  ok(SlipFaultGetField(fault, "mine_count", 4, sum));
  assert_true(sum[0] == 3 && sum[3] == 3);
  ok(SlipFaultGetField(fault, "mine_drop", 4, sum));
  assert_memory_equal(sum, cells, sizeof(cells));
  fails(SlipFaultSetReal(fault, "mine_drop", 0.1), "mine_drop must be set before");
  ok(SlipFaultDestroy(&fault));
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

  (void)state;
  for (size_t k = 0; k < sizeof(bad) / sizeof(*bad); k++) {
    const PetscReal values[] = {bad[k].value > 1 ? 1 : 0.25, bad[k].value};

    ok(SlipFaultCreate(PETSC_COMM_SELF, &fault));
    ok(SlipFaultSetReal(fault, "nx", 2));
    ok(SlipFaultSetField(fault, bad[k].name, 2, values));
    fails(SlipFaultSetUp(fault), bad[k].words);
    ok(SlipFaultDestroy(&fault));
  }
}

SLIP_TESTS(late_and_refused, fields)
