/* Internal: registration, data attached to PETSc objects, events of -log_view, options, and HDF5 files */
#pragma once
#include <math.h>
#include <petscmat.h>
#include <slipcompat.h>
#include <slipstep/rooms/sliph5.h>
#include <slipstep/rooms/slipsys.h>
#include <sys/stat.h>

/* ---- package.c ---- */
/* Calls a function that registers classes, types and events, once between PetscInitialize() and PetscFinalize(). */
PETSC_INTERN PetscErrorCode SlipRegisterOnce(PetscErrorCode (*registers)(void));
PETSC_INTERN PetscErrorCode SlipGetStartTime(PetscLogDouble *time); /* time of the first such call, by PetscTime() */

PETSC_INTERN const char *SlipSignalName(int number); /* signals.c */

/* ---- arrays.c ---- */
/* One of the vectors whose arrays a loop accesses together; a NULL vector leaves its pointer unchanged. */
typedef struct {
  Vec vec;
  const PetscScalar **read; /* pointer to the array, if it is only read */
  PetscScalar **write;      /* likewise, if it is changed or written */
} SlipArrays;
PETSC_INTERN PetscErrorCode SlipArraysGet(PetscInt n, const SlipArrays list[]);
PETSC_INTERN PetscErrorCode SlipArraysRestore(PetscInt n, const SlipArrays list[]);

/* ---- largest.c ---- */
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

/* ---- compose.c ---- */
/* Attaches data, replacing those of the same name. destroy: SlipContainerDestroyDefault for memory of PetscMalloc() */
PETSC_INTERN PetscErrorCode SlipObjectComposeData(PetscObject obj, const char name[], void *data,
                                                  PetscErrorCode (*destroy)(SlipContainerArg));
/* data: address of a pointer, borrowed; NULL if there are no data of that name */
PETSC_INTERN PetscErrorCode SlipObjectQueryData(PetscObject obj, const char name[], void *data);

/* ---- solveroptions.c ---- */
PETSC_INTERN const char *
SlipNumberOption(size_t i); /* name of the i-th number of PETSc's solvers, NULL after the last */

/* Gets whether an option is given, without marking it as read: it may still be reported as unused. name: without
   dash */
PETSC_INTERN PetscErrorCode SlipHasOption(PetscOptions options, const char prefix[], const char name[], PetscBool *has);

/* ---- optionintegers.c ---- */
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

/* ---- h5heap.c ---- */
PETSC_INTERN PetscErrorCode SlipH5StringsAreWhole(hid_t id, PetscInt n, PetscInt64 most, PetscBool *whole);

/* ---- h5file.c ---- */
PETSC_INTERN PetscErrorCode SlipH5Clear(const char prefix[], const char option[], SlipH5 *h);
PETSC_INTERN PetscErrorCode SlipH5CheckNoInput(const char file[], const char source[]);

/* ---- h5claim.c ---- */
/* Resolves symbolic links of a name, also to a file that does not exist yet. */
PETSC_INTERN PetscErrorCode SlipH5Follow(const char file[], const char source[], char target[PETSC_MAX_PATH_LEN]);
PETSC_INTERN PetscErrorCode SlipH5Refuse(const SlipH5 *h, const char file[], int reason);
PETSC_INTERN PetscErrorCode SlipH5Claim(const SlipH5Kind *kind, const char file[], SlipH5 *h);
/* Gets the rows of the longest series of an open file, without the first ones, see SlipH5Kind. */
PETSC_INTERN hsize_t SlipH5MostRows(hid_t id, int first);
/* ---- usedfiles.c ---- */
#define SLIP_FILE_ENDINGS 8
typedef struct {
  char option[96];               /* option that names it, with its dash */
  char name[PETSC_MAX_PATH_LEN]; /* "": no file */
  const char
    *endings[SLIP_FILE_ENDINGS + 1]; /* what the run appends to the name: "" for the file itself; ended by NULL */
  PetscBool written;                 /* or only read */
  PetscInt family;                   /* files of one family may be the same file; 0: none */
} SlipNamedFile;
PETSC_INTERN PetscErrorCode SlipFilesCheckNames(MPI_Comm comm, PetscInt n, const SlipNamedFile file[]);
/* ---- h5names.c ---- */
/* Gets the names of the root's attributes, to be freed one by one; more than `most` are an error. */
PETSC_INTERN PetscErrorCode SlipH5GetAttributes(SlipH5 *h, PetscInt most, PetscInt *n, char *names[]);
PETSC_INTERN PetscErrorCode SlipH5IsText(SlipH5 *h, const char path[], const char attr[], PetscBool *text);
/* HDF5's type of a PetscInt in memory */
static inline hid_t SlipH5PetscInt(void)
{
  return sizeof(PetscInt) == 8 ? H5T_NATIVE_INT64 : H5T_NATIVE_INT32;
}
/* ---- h5write.c, h5read.c: entries start to start + n of a dataset of N numbers, which the first write creates ---- */
PETSC_INTERN PetscErrorCode SlipH5WritePiece(SlipH5 *h, const char path[], PetscInt N, PetscInt start, PetscInt n,
                                             const PetscReal data[]);
PETSC_INTERN PetscErrorCode SlipH5ReadPiece(SlipH5 *h, const char path[], PetscInt N, PetscInt start, PetscInt n,
                                            PetscReal data[]);
/* ---- h5whole.c ---- */
PETSC_INTERN PetscBool SlipH5IsWhole(hid_t id, char object[PETSC_MAX_PATH_LEN]);

/* ---- h5output.c: the two halves of SlipH5Close() for a file that was written, with other work in between ---- */
PETSC_INTERN PetscErrorCode SlipH5CloseBeside(SlipH5 *h);
PETSC_INTERN PetscErrorCode SlipH5PutInPlace(SlipH5 *h);

/* ---- error.c ---- */
PETSC_INTERN void SlipErrorAtEnd(void (*end)(void));     /* called before the error handler of a program ends it */
PETSC_INTERN PetscErrorCode SlipErrorHandlerBegin(void); /* before PetscInitialize() */

/* ---- h5fail.c ---- */
/* Raises the error of a write and closes the file. reason: errno of a call of ours, while HDF5 is intact; 0: HDF5 has
   failed, or its driver */
PETSC_INTERN PetscErrorCode SlipH5WriteFailed(SlipH5 *h, int reason, const char format[], ...)
  PETSC_ATTRIBUTE_FORMAT(3, 4);

PETSC_INTERN SlipH5 *SlipH5Written(int i);                     /* the i-th file that this process writes, or NULL */
PETSC_INTERN SlipH5 *SlipH5WrittenAs(const struct stat *info); /* the one with this inode, or NULL */
PETSC_INTERN PetscErrorCode SlipH5Enlist(SlipH5 *h);           /* until it is released */
PETSC_INTERN void SlipH5IgnoreLimitSignal(void);               /* until no file is enlisted */
PETSC_INTERN void SlipH5Release(SlipH5 *h, PetscBool keep);    /* closes the descriptor, removes the file unless keep */
PETSC_INTERN int SlipH5CloseId(SlipH5 *h);                     /* 0, or errno */

/* ---- h5driver.c ---- */
PETSC_INTERN void SlipH5SetDriver(hid_t access);
PETSC_INTERN int SlipH5MakeRoom(SlipH5 *h, PetscInt64 bytes); /* 0, or errno */
