/* Reads the points of -fault_stations or -fault_surface_stations, a list, or a file with one point on each line, and
   the point of -fault_injection or -fault_nucleation. */
#include <slipstep/private/slipfault.h>
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { LONGEST_LINE = 256 };

/* Reads two or three numbers, separated by commas, or also by space if allowed, and nothing else. */
static PetscBool ReadPoint(const char text[], PetscBool space, PetscBool three, PetscReal point[3])
{
  static const char Space[] = " \t\r\n";
  const char *c = text;
  PetscInt n = 0;
  char *end;

  while (n < (three ? 3 : 2)) {
    point[n] = (PetscReal)strtod(c, &end);
    if (end == c || PetscIsInfOrNanReal(point[n])) return PETSC_FALSE;
    n++;
    c = end + strspn(end, Space);
    if (!*c) break;
    if (*c == ',')
      c++;
    else if (!space || c == end)
      return PETSC_FALSE;
    if (n == (three ? 3 : 2)) return PETSC_FALSE; /* one number too many */
    if (!*c) return PETSC_FALSE;
  }
  if (n < 2 || *c) return PETSC_FALSE;
  if (n == 2) {
    point[2] = point[1];
    point[1] = (PetscReal)NAN;
  }
  return PETSC_TRUE;
}

/* On rank 0: reads n points from a text file; the caller frees them with PetscFree(). */
static PetscErrorCode ReadFile(const char option[], const char name[], const char forms[], PetscBool three, PetscInt *n,
                               PetscReal **point)
{
  FILE *file = fopen(name, "r");
  char line[LONGEST_LINE];
  PetscInt room = 0;

  PetscFunctionBegin;
  *n = 0;
  *point = NULL;
  PetscCheck(file, PETSC_COMM_SELF, PETSC_ERR_FILE_OPEN, "%s (%s) cannot be read: %s", name, option, strerror(errno));
  for (PetscInt number = 1; fgets(line, LONGEST_LINE, file); number++) {
    const size_t length = strlen(line), used = strcspn(line, "#");
    const PetscBool whole = length + 1 < LONGEST_LINE || line[length - 1] == '\n' ? PETSC_TRUE : PETSC_FALSE;

    line[whole ? used : strcspn(line, "\n")] = '\0';
    if (whole && line[strspn(line, " \t\r\n")] == '\0') continue;
    if (*n == room) PetscCall(PetscRealloc(3 * (size_t)(room = 2 * room + 64) * sizeof(**point), point));
    if (whole && ReadPoint(line, PETSC_TRUE, three, *point + 3 * *n)) {
      ++*n;
      continue;
    }
    (void)fclose(file);
    PetscCall(PetscFree(*point));
    line[strcspn(line, "\r\n")] = '\0';
    SETERRQ(PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
            "%s (%s), line %" PetscInt_FMT ": \"%.60s\", expected a point %s in m, or a comment after #", name, option,
            number, line, forms);
  }
  (void)fclose(file);
  PetscCheck(*n, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED, "%s (%s) has no points, expected one %s in m on each line",
             name, option, forms);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultReadPoints(SlipFault fault, PetscInt id, const char axes[2], PetscBool three, PetscInt *n,
                                   PetscReal **points)
{
  const char *text = fault->options.longer[id] ? fault->options.longer[id] : fault->options.text[id];
  char option[96], forms[64], expected[256];
  PetscErrorCode ierr = PETSC_SUCCESS;
  PetscBool file = PETSC_FALSE;
  PetscMPIInt rank;
  char **point;
  int count;

  PetscFunctionBegin;
  (void)snprintf(option, sizeof(option), "-%sfault_%s", SlipFaultPrefix(fault), SlipFaultStrings[id].name);
  (void)snprintf(forms, sizeof(forms), "\"%c,%c\" or \"%c %c\"", axes[0], axes[1], axes[0], axes[1]);
  (void)snprintf(expected, sizeof(expected),
                 "expected points \"%c,%c;%c,%c\" in m, %sor a file with a point %s on each line", axes[0], axes[1],
                 axes[0], axes[1], three ? "\"x,y,z\" where planes overlap, " : "", forms);
  PetscCallMPI(MPI_Comm_rank(fault->comm, &rank));
  if (!rank && !fault->options.longer[id]) PetscCall(PetscTestFile(text, '\0', &file));
  PetscCallMPI(MPI_Bcast(&file, 1, MPIU_BOOL, 0, fault->comm));
  if (file) {
    if (!rank) ierr = ReadFile(option, text, forms, three, n, points);
    PetscCall(SlipErrorBcast(fault->comm, ierr));
    PetscCallMPI(MPI_Bcast(n, 1, MPIU_INT, 0, fault->comm));
    if (rank) PetscCall(PetscMalloc1(3 * (size_t)*n, points));
    PetscCallMPI(MPI_Bcast(*points, (PetscMPIInt)(3 * *n), MPIU_REAL, 0, fault->comm));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(PetscStrToArray(text, ';', &count, &point));
  PetscCheck(count > 0, fault->comm, PETSC_ERR_ARG_WRONG, "%s is \"%s\", %s", option, text, expected);
  *n = count;
  PetscCall(PetscMalloc1(3 * (size_t)count, points));
  for (int k = 0; k < count; k++)
    PetscCheck(ReadPoint(point[k], PETSC_FALSE, three, *points + 3 * k), fault->comm, PETSC_ERR_ARG_WRONG,
               "%s has the point \"%.60s\", %s", option, point[k], expected);
  PetscCall(PetscStrToArrayDestroy(count, point));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads the numbers, separated by commas, of an option. most: room in x; n: how many words there are; good: the first
   ones that x has room for are finite numbers */
PetscErrorCode SlipFaultReadNumbers(SlipFault fault, PetscInt id, PetscInt most, PetscReal x[], PetscInt *n,
                                    PetscBool *good)
{
  PetscErrorCode ierr = PETSC_SUCCESS;
  char **part;
  int count;

  PetscFunctionBegin;
  PetscCall(PetscStrToArray(fault->options.text[id], ',', &count, &part));
  *n = count;
  PetscCall(PetscPushErrorHandler(PetscReturnErrorHandler, NULL));
  for (PetscInt k = 0; k < PetscMin(most, *n) && !ierr; k++) {
    ierr = PetscOptionsStringToReal(part[k], &x[k]);
    if (!ierr && !isfinite(x[k])) ierr = PETSC_ERR_FP;
  }
  PetscCall(PetscPopErrorHandler());
  PetscCall(PetscStrToArrayDestroy(count, part));
  *good = ierr ? PETSC_FALSE : PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads the point [x, y, z] from "x,z" for one plane, or from "x,y,z" for several [m], and the numbers behind it. */
PetscErrorCode SlipFaultReadPoint(SlipFault fault, PetscInt id, PetscInt more, const char what[], PetscReal point[3],
                                  PetscReal rest[])
{
  PetscReal number[16];
  SlipFaultCell cell;
  PetscBool planes, good; /* planes: x and z alone do not define a point */
  PetscInt n, want;

  PetscFunctionBegin;
  fault->mesh.kind->cell(&fault->mesh, 0, &cell);
  planes = fault->mesh.planes > 1 || cell.direction[1][2] == 0 ? PETSC_TRUE : PETSC_FALSE;
  want = (planes ? 3 : 2) + more;
  PetscCall(SlipFaultReadNumbers(fault, id, want, number, &n, &good));
  PetscCheck(
    n == want && good, fault->comm, PETSC_ERR_ARG_WRONG, "-%sfault_%s is \"%s\", expected %s%s", SlipFaultPrefix(fault),
    SlipFaultStrings[id].name, fault->options.text[id],
    planes ? "three numbers x,y,z of m, as the mesh has several planes or a level one: along strike, across, and depth"
           : "two numbers x,z of m: along strike, and depth",
    what);
  PetscCall(PetscArraycpy(point, number, planes ? 3 : 2));
  for (PetscInt k = 0; k < more; k++) rest[k] = number[want - more + k];
  if (planes) PetscFunctionReturn(PETSC_SUCCESS);
  /* on the plane: x is along its strike s, depth gives the place along its dip d; both from the origin's foot, D n */
  {
    const PetscReal *s = cell.direction[0], *d = cell.direction[1], *m = cell.direction[2], *c = cell.centre;
    const PetscReal x = point[0], z = point[1], D = c[0] * m[0] + c[1] * m[1] + c[2] * m[2];
    const PetscReal down = (z - D * m[2]) / d[2];

    for (int k = 0; k < 3; k++) point[k] = x * s[k] + D * m[k] + down * d[k];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
