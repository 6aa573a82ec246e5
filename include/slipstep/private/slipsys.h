/* Internal: registration, data attached to PETSc objects, events of -log_view, and options */
#pragma once
#include <math.h>
#include <petscmat.h>
#include <slipcompat.h>
#include <slipstep/rooms/sliph5.h>
#include <slipstep/rooms/slipsys.h>

/* ---- package.c ---- */
/* Calls a function that registers classes, types and events, once between PetscInitialize() and PetscFinalize(). */
PETSC_INTERN PetscErrorCode SlipRegisterOnce(PetscErrorCode (*registers)(void));
PETSC_INTERN PetscErrorCode SlipGetStartTime(PetscLogDouble *time); /* time of the first such call, by PetscTime() */

PETSC_INTERN const char *SlipSignalName(int number); /* signals.c */

/* ---- vectors.c ---- */
/* One of the vectors whose arrays a loop accesses together; a NULL vector leaves its pointer unchanged. */
typedef struct {
  Vec vec;
  const PetscScalar **read; /* pointer to the array, if it is only read */
  PetscScalar **write;      /* likewise, if it is changed or written */
} SlipArrays;
PETSC_INTERN PetscErrorCode SlipArraysGet(PetscInt n, const SlipArrays list[]);
PETSC_INTERN PetscErrorCode SlipArraysRestore(PetscInt n, const SlipArrays list[]);

/* The larger of both; NaN if one is NaN */
static inline PetscReal SlipLarger(PetscReal a, PetscReal b)
{
  return b > a || b != b ? b : a; /* avoids a call */
}
/* The larger of |v| in the plane of a cell with c = 2 or 3 numbers and the size of its opening component. For Inf or
   NaN it returns INFINITY and not PETSC_INFINITY, a quarter of the largest number, as only INFINITY exceeds all. */
static inline PetscReal SlipBlockSize(PetscInt c, const PetscReal v[])
{
  const PetscReal size = hypot(v[0], v[1]), open = c == 3 ? PetscAbsReal(v[2]) : 0;

  return PetscIsInfOrNanReal(size) || PetscIsInfOrNanReal(open) ? (PetscReal)INFINITY : PetscMax(size, open);
}
PETSC_EXTERN PetscErrorCode SlipAllreduceLargest(MPI_Comm comm, PetscInt n, PetscReal x[]);
PETSC_EXTERN PetscErrorCode SlipVecLargest(Vec x, PetscReal *largest);

/* ---- package.c ---- */
/* Attaches data, replacing those of the same name. destroy: SlipContainerDestroyDefault for memory of PetscMalloc() */
PETSC_INTERN PetscErrorCode SlipObjectComposeData(PetscObject obj, const char name[], void *data,
                                                  PetscErrorCode (*destroy)(SlipContainerArg));
/* data: address of a pointer, borrowed; NULL if there are no data of that name */
PETSC_INTERN PetscErrorCode SlipObjectQueryData(PetscObject obj, const char name[], void *data);

/* ---- csv.c: a table of words, read by one process, line by line ---- */
enum { SLIP_CSV_WORDS = 16 };
typedef struct {
  char name[PETSC_MAX_PATH_LEN + 64]; /* of the file and its option, for messages */
  char *text, *at;
  PetscInt number; /* of the line */
  int words;       /* in it; of those beyond SLIP_CSV_WORDS only the count */
  char *word[SLIP_CSV_WORDS];
} SlipCsv;
PETSC_INTERN PetscErrorCode SlipCsvOpen(const char file[], const char prefix[], const char option[], SlipCsv *csv);
PETSC_INTERN PetscErrorCode SlipCsvClose(SlipCsv *csv);
PETSC_INTERN PetscBool SlipCsvNext(SlipCsv *csv);
PETSC_INTERN PetscBool SlipCsvNumber(const char word[], PetscReal *x);

/* ---- shared.c: arrays that the processes of a machine hold once ---- */
PETSC_EXTERN PetscErrorCode SlipSharedCreate(MPI_Comm comm, SlipShared *shared);
PETSC_EXTERN PetscErrorCode SlipSharedDestroy(SlipShared *shared);
PETSC_EXTERN PetscErrorCode SlipSharedMalloc(SlipShared shared, size_t bytes, void *array);
PETSC_EXTERN PetscErrorCode SlipSharedFree(SlipShared shared, void *array);
PETSC_EXTERN void SlipSharedSlice(SlipShared shared, const void *array, PetscInt n, PetscInt *start, PetscInt *end);
PETSC_EXTERN PetscErrorCode SlipSharedReady(SlipShared shared);
PETSC_EXTERN PetscErrorCode SlipSharedBcast(SlipShared shared, void *array, PetscInt n, MPI_Datatype type);
PETSC_EXTERN PetscErrorCode SlipSharedMove(SlipShared shared, size_t bytes, void *array);
PETSC_EXTERN PetscErrorCode SlipSharedValues(SlipShared shared, PetscInt n, PetscInt values[]);
PETSC_EXTERN PetscBool SlipSharedFirst(SlipShared shared);
PETSC_EXTERN PetscReal SlipSharedMachineBytes(SlipShared shared);
PETSC_EXTERN void SlipMemoryReturn(void);

#define SlipSharedMalloc1(shared, n, array)                                                                            \
  SlipSharedMalloc(shared, (size_t)PetscMax(n, 1) * sizeof(**(array)), (void *)(array))

/* ---- solveroptions.c ---- */
PETSC_INTERN const char *
SlipNumberOption(size_t i); /* name of the i-th number of PETSc's solvers, NULL after the last */

/* Gets whether an option is given, without marking it as read: it may still be reported as unused. name: without
   dash */
PETSC_INTERN PetscErrorCode SlipHasOption(PetscOptions options, const char prefix[], const char name[], PetscBool *has);
PETSC_INTERN PetscErrorCode SlipPeekOption(PetscOptions options, const char prefix[], const char name[], char text[],
                                           size_t len, PetscBool *has); /* likewise, and its text */

PETSC_INTERN PetscBool SlipEndsWith(const char name[], const char end[]);

/* ---- optiontimes.c ---- */
#define SLIP_TIME_UNITS "s, min, h, d or y"                 /* for messages */
PETSC_INTERN PetscBool SlipIsTimeOption(const char name[]); /* without dash, a prefix before it or not */
/* Writes a time with so many digits in the unit that fits: "12.5 s", "3.2 h", "113.4 years". */
PETSC_EXTERN void SlipTimeText(PetscReal seconds, int digits, char text[], size_t len);

/* ---- words.c ---- */
#define SLIP_NAME_LENGTH 128
/* Gets the next of the names after *place, which advances, following prefix; false after the last. */
PETSC_INTERN PetscBool SlipNextName(const char prefix[], const char **place, char name[SLIP_NAME_LENGTH]);

/* ---- optionnames.c ---- */
#define SLIP_HINT_LENGTH (SLIP_NAME_LENGTH + 32)
PETSC_INTERN PetscErrorCode SlipSuggestName(const char word[], const char names[], char text[SLIP_HINT_LENGTH]);
PETSC_INTERN PetscBool SlipIsHelpOption(const char name[]); /* ours, or of PETSc's those that every run needs */

/* ---- log.c ---- */
/* Events are nested: a product with B may contain products with K and H, the output those of its rows. */
PETSC_INTERN PetscLogEvent SLIP_StiffnessSetUp, SLIP_StiffnessMult; /* K */
PETSC_INTERN PetscLogEvent SLIP_ViscositySetUp, SLIP_ViscosityMult; /* H */
PETSC_INTERN PetscLogEvent SLIP_StageMult;                          /* B */
PETSC_INTERN PetscLogEvent SLIP_PCSetUp, SLIP_PCApply;
PETSC_INTERN PetscLogEvent SLIP_Direct;  /* solves of a few cells' rows */
PETSC_INTERN PetscLogEvent SLIP_Cells;   /* slip rates of all cells: friction in balance, kicks */
PETSC_INTERN PetscLogEvent SLIP_Cone;    /* bound, natural map, projection */
PETSC_INTERN PetscLogEvent SLIP_Policy;  /* forward pass */
PETSC_INTERN PetscLogEvent SLIP_Observe; /* observations of the policy */
PETSC_INTERN PetscLogEvent SLIP_Output;  /* gathering and writing */

PETSC_INTERN PetscErrorCode SlipLogRegister(void); /* all of them; later calls do nothing */
PETSC_INTERN PetscErrorCode SlipLogProducts(Mat A, PetscLogEvent event);
PETSC_INTERN PetscErrorCode SlipLogProductsReplace(Mat A, PetscErrorCode (*mult)(Mat, Vec, Vec),
                                                   PetscErrorCode (**before)(Mat, Vec, Vec));
PETSC_INTERN PetscErrorCode SlipLogsProducts(Mat A, PetscBool *counted);
/* Begin and end the stage and the event of output. */
PETSC_INTERN PetscErrorCode SlipLogOutputBegin(void);
PETSC_INTERN PetscErrorCode SlipLogOutputEnd(void);

/* ---- workcounts.c ---- */
/* For what products are used: the run; work done once and again when a run continues; or only information about a run,
   that is output and estimates of its error */
typedef enum { SLIP_PRODUCTS_RUN, SLIP_PRODUCTS_SETUP, SLIP_PRODUCTS_LOOK, SLIP_PRODUCTS_USERS } SlipProductsUser;
PETSC_INTERN void SlipProductsAdd(SlipProducts more);
/* Gets the products of a run up to its last row, and those since then, with their cost, and begins the next row. */
PETSC_INTERN SlipProducts SlipProductsRow(SlipProducts *last);
PETSC_INTERN SlipProducts SlipProductsNow(void); /* of the user of now */
PETSC_INTERN PetscErrorCode SlipProductsPush(SlipProductsUser user);
PETSC_INTERN PetscErrorCode SlipProductsPop(void);
PETSC_INTERN void SlipProductsRun(void);
PETSC_INTERN void SlipProductsGetOf(SlipProductsUser of, SlipProducts *products);
PETSC_INTERN SlipProducts SlipProductsSince(const SlipProducts *now, const SlipProducts *before);

/* ---- wait.c ---- */
typedef PetscErrorCode (*SlipWaitFn)(void *ctx, const char what[], PetscReal share);
PETSC_INTERN PetscErrorCode SlipWaitListen(SlipWaitFn fn, void *ctx);
PETSC_INTERN PetscBool SlipWaitDue(void);
PETSC_INTERN PetscErrorCode SlipWaitReport(const char what[], PetscReal share);

/* ---- error.c ---- */
PETSC_INTERN void SlipErrorAtEnd(void (*end)(void));     /* called before the error handler of a program ends it */
PETSC_INTERN PetscErrorCode SlipErrorHandlerBegin(void); /* before PetscInitialize() */
