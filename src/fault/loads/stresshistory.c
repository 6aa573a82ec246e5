/* Reads the stresses in time of -fault_stress_history: from HDF5, a group each, or from CSV, uniform ones. */
#include <slipstep/private/slipfault.h>
#include <slipstep/private/slipsys.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

/* ---- HDF5 ---- */

/* Reads one number, or one for each cell, [N], and of a grid [Nz, Nx]; where components are allowed, each of these may
   be followed by 2. */
static PetscErrorCode ReadStress(SlipFault fault, SlipH5 *h, const char path[], PetscBool components, PetscInt *n,
                                 PetscReal **x)
{
  const SlipFaultMesh *mesh = &fault->mesh;
  const PetscInt grid[] = {mesh->dims[0], mesh->dims[1], 2}, list[] = {mesh->N, 2};
  PetscInt dims[4], ndim, size[2] = {-1, -1}, most = mesh->ndim + (components ? 1 : 0);
  PetscBool has, listed;

  PetscFunctionBegin;
  PetscCall(SlipH5Has(h, path, &has));
  if (!has) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipH5CheckUnits(h, path, "Pa", &has));
  PetscCall(SlipH5GetRank(h, path, &ndim));
  for (PetscInt k = 0; k < 2 && k < ndim; k++) PetscCall(SlipH5GetSize(h, path, k, &size[k]));
  listed = ndim < 2 || mesh->ndim == 1 || (components && ndim == 2 && size[0] == mesh->N && size[1] == 2) ? PETSC_TRUE
                                                                                                          : PETSC_FALSE;
  PetscCall(SlipH5ReadRealSized(h, path, PetscMin(ndim, most), listed ? list : grid,
                                components ? "one number, or one or two for each cell"
                                           : "one number, or one for each "
                                             "cell",
                                dims, x));
  *n = 1;
  for (PetscInt k = 0; k < ndim; k++) *n *= dims[k];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads the group `group` of the open file. */
static PetscErrorCode ReadGroup(SlipFault fault, SlipH5 *h, const char group[], SlipStressRecord *record)
{
  const PetscInt any = -1;
  PetscInt dims[1];
  char path[512], name[PETSC_MAX_PATH_LEN + 512];
  PetscBool said;

  PetscFunctionBegin;
  (void)snprintf(name, sizeof(name), "%s/%s (-%sfault_stress_history)", h->name, group, SlipFaultPrefix(fault));
  PetscCall(PetscStrallocpy(name, &record->name));
  (void)snprintf(path, sizeof(path), "/%s", group);
  PetscCall(SlipH5CheckMembers(h, path, "time course shear normal"));
  (void)snprintf(path, sizeof(path), "/%s/time", group);
  PetscCall(SlipH5ReadRealSized(h, path, 1, &any, "n times", dims, &record->times));
  PetscCall(SlipH5CheckUnits(h, path, "s", &said));
  record->rows = dims[0];
  (void)snprintf(path, sizeof(path), "/%s/course", group);
  PetscCall(SlipH5ReadRealSized(h, path, 1, dims, "one for each of time", dims, &record->values));
  PetscCall(SlipH5CheckUnits(h, path, "", &said));
  (void)snprintf(path, sizeof(path), "/%s/shear", group);
  PetscCall(ReadStress(fault, h, path, PETSC_TRUE, &record->nshear, &record->shear));
  (void)snprintf(path, sizeof(path), "/%s/normal", group);
  PetscCall(ReadStress(fault, h, path, PETSC_FALSE, &record->nnormal, &record->normal));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadGroups(SlipFault fault, SlipH5 *h, PetscInt *n, SlipStressRecord **records)
{
  char group[256];

  PetscFunctionBegin;
  for (PetscInt k = 0; SlipH5MemberName(h, "/", k, group, sizeof(group)); k++) {
    PetscCall(PetscRealloc(sizeof(**records) * (size_t)(k + 1), records));
    (*records)[k] = (SlipStressRecord){0};
    *n = k + 1;
    PetscCall(ReadGroup(fault, h, group, &(*records)[k]));
  }
  PetscCheck(*n, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
             "%s (-%sfault_stress_history) is empty, expected a group with time, course, and shear or normal, for each "
             "stress",
             h->name, SlipFaultPrefix(fault));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- CSV ---- */

enum { TIME, SHEAR, NORMAL, COLUMNS };
static const char *const Columns[COLUMNS] = {"time", "shear", "normal"};

typedef struct {
  SlipCsv csv;
  int place[COLUMNS]; /* of each column in a line, -1: none */
  int count;          /* of columns */
  PetscInt rows, room;
  PetscReal *of[COLUMNS];
} Table;

static PetscErrorCode ReadHeader(Table *table)
{
  PetscBool good = PETSC_TRUE;

  PetscFunctionBegin;
  table->count = table->csv.words;
  for (int k = 0; k < COLUMNS; k++) table->place[k] = -1;
  for (int i = 0; i < table->count && good; i++) {
    int k = 0;

    while (i < SLIP_CSV_WORDS && k < COLUMNS && strcmp(table->csv.word[i], Columns[k])) k++;
    good = k < COLUMNS && table->place[k] < 0 ? PETSC_TRUE : PETSC_FALSE;
    if (good) table->place[k] = i;
  }
  PetscCheck(good && table->place[TIME] >= 0 && table->count > 1, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
             "%s, line %" PetscInt_FMT ": expected time,shear,normal, or one of shear and normal", table->csv.name,
             table->csv.number);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the numbers of a line, as many as there are columns. */
static PetscErrorCode ReadRow(Table *table)
{
  PetscReal value[COLUMNS] = {0};
  PetscBool good = table->csv.words == table->count ? PETSC_TRUE : PETSC_FALSE;

  PetscFunctionBegin;
  for (int i = 0; i < table->count && good; i++) good = SlipCsvNumber(table->csv.word[i], &value[i]);
  PetscCheck(good, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
             "%s, line %" PetscInt_FMT ": expected %d finite numbers, separated by commas, of s and Pa",
             table->csv.name, table->csv.number, table->count);
  if (table->rows == table->room) {
    table->room = 2 * table->room + 64;
    for (int k = 0; k < COLUMNS; k++) PetscCall(PetscRealloc(sizeof(PetscReal) * (size_t)table->room, &table->of[k]));
  }
  for (int k = 0; k < COLUMNS; k++) table->of[k][table->rows] = table->place[k] < 0 ? 0 : value[table->place[k]];
  table->rows++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadLines(Table *table)
{
  PetscBool first = PETSC_TRUE;

  PetscFunctionBegin;
  for (; SlipCsvNext(&table->csv); first = PETSC_FALSE)
    if (first)
      PetscCall(ReadHeader(table));
    else
      PetscCall(ReadRow(table));
  PetscCheck(table->rows, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
             "%s has no times, expected a line time,shear,normal, and numbers below it", table->csv.name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads a table, whose columns are the courses of two records of 1 Pa. */
static PetscErrorCode ReadTable(SlipFault fault, const char name[], PetscInt *n, SlipStressRecord **records)
{
  Table table = {.rows = 0};
  PetscErrorCode ierr;

  PetscFunctionBegin;
  PetscCall(SlipCsvOpen(name, SlipFaultPrefix(fault), "fault_stress_history", &table.csv));
  ierr = ReadLines(&table);
  PetscCall(SlipCsvClose(&table.csv));
  if (!ierr) PetscCall(PetscCalloc1(2, records));
  for (int k = SHEAR; k < COLUMNS && !ierr; k++) {
    SlipStressRecord *record = &(*records)[*n];
    char text[sizeof(table.csv.name) + 16];

    if (table.place[k] < 0) continue;
    ++*n;
    (void)snprintf(text, sizeof(text), "%s, %s", table.csv.name, Columns[k]);
    PetscCall(PetscStrallocpy(text, &record->name));
    record->rows = table.rows;
    PetscCall(PetscMalloc1(table.rows, &record->times));
    PetscCall(PetscMalloc1(table.rows, &record->values));
    PetscCall(PetscArraycpy(record->times, table.of[TIME], table.rows));
    PetscCall(PetscArraycpy(record->values, table.of[k], table.rows));
    PetscCall(PetscMalloc1(1, k == SHEAR ? &record->shear : &record->normal));
    *(k == SHEAR ? record->shear : record->normal) = 1;
    *(k == SHEAR ? &record->nshear : &record->nnormal) = 1;
  }
  for (int k = 0; k < COLUMNS; k++) PetscCall(PetscFree(table.of[k]));
  PetscCall(ierr);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipLoadsReadHistory(SlipFault fault, PetscInt *n, SlipStressRecord **records)
{
  const char *name = fault->options.text[FAULT_STRESS_HISTORY];
  const size_t length = strlen(name);
  PetscErrorCode ierr;
  SlipH5 h;

  PetscFunctionBegin;
  *n = 0;
  if (length > 4 && !strcasecmp(name + length - 4, ".csv")) {
    PetscCall(ReadTable(fault, name, n, records));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(SlipH5OpenReadOption(SlipFaultPrefix(fault), "fault_stress_history", name, &h));
  ierr = ReadGroups(fault, &h, n, records);
  PetscCall(SlipH5Close(&h));
  PetscCall(ierr);
  PetscFunctionReturn(PETSC_SUCCESS);
}
