/* The mesh of a fault: its cells, their geometry, and the processes that own them. Each kind of mesh is a table of
   functions in a file of its own; no other code depends on the kind. */
#pragma once
#include <petscmat.h>
#include <slipstep/rooms/slipcells.h>
#include <slipstep/rooms/slipcore.h>
#include <slipstep/rooms/sliph5.h>
#include <slipstep/rooms/slipmat.h>
#include <slipstep/private/slipsys.h>
#include <math.h>

/* Largest plausible coordinates of a fault in metres: along strike the Earth's circumference, which also bounds map
   coordinates; in depth more than the 700 km below which no rock breaks */
#define MESH_MAX_REACH 4e7
#define MESH_MAX_DEPTH 1e6

/* Parameters of a uniform grid, in files those of the whole mesh: cells, extents and depth [m], angles [deg] */
enum { MESH_NX, MESH_NZ, MESH_LENGTH_X, MESH_LENGTH_Z, MESH_DEPTH_TOP, MESH_STRIKE, MESH_DIP, MESH_REALS };

/* A cell; x north, y east, z down [m]; on vertical planes along x, x is along strike and y to its right */
typedef struct {
  PetscReal centre[3];
  PetscReal size[2];         /* along strike and down dip [m] */
  PetscReal direction[3][3]; /* unit vectors: along strike, down dip, and their normal towards the hanging wall */
  PetscInt plane;            /* its plane, from 0 */
  const PetscReal
    *vertices; /* [3][3] of a triangle, whose centre is its centroid and whose sides are its extent along strike and
                                its area over that; NULL: a rectangle */
} SlipFaultCell;

typedef struct _SlipFaultMesh SlipFaultMesh;

enum { MESH_VERTICAL_COLUMNS = 5, MESH_COLUMNS = 7 }; /* of rectangles: x y z length width, and strike dip */
/* Content of a mesh file, on rank 0: rectangles or triangles, and the faults they belong to */
typedef struct {
  PetscBool triangles;
  PetscInt n; /* cells */
  PetscInt columns;
  PetscReal *rows;          /* [n][columns] of rectangles */
  PetscInt nvertices;       /* of triangles */
  PetscReal *vertex;        /* [nvertices][3] north, east and down [m] */
  PetscInt sides;           /* 3, or 4 for rectangles that have no rows yet */
  PetscInt *corner;         /* [n][sides] numbers of vertices, from 0 */
  PetscInt *number, *label; /* [n] number of each cell in messages, and its fault; NULL: from 0; none */
  PetscInt *vertex_number;  /* [nvertices] likewise */
  char *names;              /* of the faults, "label name; label name", or NULL */
  PetscBool metres;         /* the file states that lengths are metres, however small */
  PetscBool upward;         /* z of the file was interpreted as upward */
} SlipFaultMeshFile;

/* The input of a mesh; strings are borrowed and not NULL */
typedef struct {
  MPI_Comm comm;
  const char *prefix;               /* of options, for messages */
  const char *file, *frame, *unit;  /* -fault_mesh, "": a uniform grid; axes and unit of its numbers */
  const char *type;                 /* -fault_operator, which decides the order of cells */
  const char *fields;               /* other datasets that a file may have, separated by blanks */
  const PetscReal *extent;          /* [MESH_REALS] of a uniform grid */
  SlipKernel rectangles, triangles; /* of cells of that shape */
  PetscInt block;                   /* numbers of a cell in a state */
} SlipFaultMeshOptions;

/* The input of its stiffness */
typedef struct {
  SlipKernel kernel;
  PetscBool dipping;     /* the kernel is that for any direction */
  const char *type;      /* -fault_operator */
  PetscReal tolerance;   /* of hierarchical storage */
  const PetscReal *rake; /* [n] of the cells of this process, if dipping [deg] */
} SlipFaultStiffness;

/* Cells are numbered by their rows in a file, or iz nx + ix in a grid; this process has cells start, start + 1 ... */
typedef struct {
  /* sets all but n, start and weight; file: content of -fault_mesh on rank 0, else empty except for triangles */
  PetscErrorCode (*create)(SlipFaultMesh *mesh, const SlipFaultMeshOptions *o, SlipFaultMeshFile *file);
  void (*cell)(const SlipFaultMesh *mesh, PetscInt row, SlipFaultCell *cell);
  PetscErrorCode (*stiffness)(const SlipFaultMesh *mesh, const SlipFaultStiffness *s, Mat *K,
                              Mat *Kn);                          /* Kn: may be NULL */
  PetscErrorCode (*write)(const SlipFaultMesh *mesh, SlipH5 *h); /* /mesh of a file */
  PetscErrorCode (*corners)(const SlipFaultMesh *mesh, PetscReal points[],
                            PetscInt corners[]);                                /* [npoints][3], [N][sides] */
  PetscErrorCode (*digest)(const SlipFaultMesh *mesh, char text[], size_t len); /* a text that identifies a mesh */
  PetscInt sides;                                                               /* of a cell: 3 or 4 */
} SlipFaultMeshKind;

struct _SlipFaultMesh {
  const SlipFaultMeshKind *kind; /* NULL before SlipFaultMeshCreate() */
  MPI_Comm comm;
  SlipShared shared;      /* arrays of numbers of all cells, which the processes of a machine hold once */
  PetscInt N, n, start;   /* number of all cells, of this rank; first of this rank */
  PetscInt ndim, dims[2]; /* shape of a number per cell in files: [nz][nx], or [N] */
  PetscInt npoints;       /* corners of all cells; shared ones count once */
  PetscInt planes;        /* number of planes */
  PetscReal extent[MESH_REALS];
  PetscReal area;     /* mean of a cell [m^2] */
  PetscBool dips;     /* not all cells are on vertical planes of one strike */
  PetscReal unit;     /* the reciprocal of mean areas [1/m^2]; 0 if all areas are equal */
  PetscReal *weight;  /* [n] area over the mean area, a factor on rows of K, H and B, and on the strength */
  PetscInt *order;    /* [N] row of each cell; NULL: its number */
  PetscInt *plane;    /* [N] of each row; NULL: there is only one */
  PetscInt *label;    /* [N] the fault of each row, by the file's /fault or the plane; NULL: only one, 0 */
  PetscBool labelled; /* by the file */
  PetscInt faults;    /* number of faults with their own numbers in files */
  PetscInt *labels;   /* [faults] of each, ascending */
  PetscInt *fault;    /* [N] index of each row's fault; NULL: there is only one */
  SlipCells
    cells; /* of a list, in the order of its rows, owned; strike and dip NULL if they are 0 and 90; rake always set */
  PetscReal *vertex; /* [npoints][3] of triangles */
  PetscInt *corner;  /* [N][3], around the normal into the hanging wall */
  char *names;       /* of the faults, as in the file, on rank 0, or NULL */
};

/* Row of cell i of this process */
static inline PetscInt SlipFaultMeshRow(const SlipFaultMesh *mesh, PetscInt i)
{
  return mesh->order ? mesh->order[mesh->start + i] : mesh->start + i;
}

/* Index of the fault of a row, in the order of labels */
static inline PetscInt SlipFaultMeshFaultOf(const SlipFaultMesh *mesh, PetscInt row)
{
  return mesh->fault ? mesh->fault[row] : 0;
}

/* Row of a cell of any process */
static inline PetscInt SlipFaultMeshRowOf(const SlipFaultMesh *mesh, PetscInt e)
{
  return mesh->order ? mesh->order[e] : e;
}

/* directions.c: directions of a cell of this strike and dip [deg] */
PETSC_INTERN void SlipFaultCellDirections(PetscReal strike, PetscReal dip, SlipFaultCell *cell);
PETSC_INTERN const SlipFaultMeshKind SlipFaultMeshGrid; /* gridmesh.c: the uniform grid of the options */
PETSC_INTERN const SlipFaultMeshKind SlipFaultMeshList; /* list.c: the cells of -fault_mesh */
PETSC_INTERN PetscErrorCode SlipFaultCellsCreate(SlipShared shared, const SlipKernel *kernel, PetscInt n,
                                                 PetscInt columns, SlipCells *cells, PetscReal *column[]);

PETSC_INTERN const SlipFaultMeshKind SlipFaultMeshTriangles; /* triangles.c: those of -fault_mesh */
/* list.c: for any mesh with mesh->cells */
PETSC_INTERN PetscErrorCode SlipFaultCellsForecast(const SlipFaultMesh *mesh, const SlipFaultStiffness *s,
                                                   PetscBool normal, PetscMPIInt size, SlipCellsForecast forecast[]);
PETSC_INTERN PetscErrorCode SlipFaultCellsStiffness(const SlipFaultMesh *mesh, const SlipFaultStiffness *s, Mat *K,
                                                    Mat *Kn);
PETSC_INTERN void SlipFaultCellsDirection(const SlipCells *cells, PetscReal *strike, PetscReal *dip);
PETSC_INTERN PetscErrorCode SlipFaultCellsWrite(const SlipFaultMesh *mesh, SlipH5 *h);
PETSC_INTERN PetscErrorCode SlipFaultCellsDigest(const SlipFaultMesh *mesh, char text[], size_t len);
PETSC_INTERN PetscErrorCode SlipFaultCellsShare(SlipFaultMesh *mesh, const char type[]);

/* read.c; on rank 0 */
enum { MESH_MAX_NAMES = 65536 };
#define MESH_MAX_LABEL 1e9 /* every PetscInt holds it, and single precision nearly does */
PETSC_INTERN PetscErrorCode SlipFaultMeshRead(const SlipFaultMeshOptions *o, SlipFaultMeshFile *file);
PETSC_INTERN PetscErrorCode SlipFaultMeshFileDestroy(SlipFaultMeshFile *file);
/* gmsh.c: reads a file of Gmsh with its own numbers */
PETSC_INTERN PetscErrorCode SlipFaultMeshReadGmsh(const char name[], const char source[], SlipFaultMeshFile *file);
/* units.c: unit, frame: they were given */
PETSC_INTERN PetscErrorCode SlipFaultMeshCheckUnit(const char prefix[], const char source[], PetscBool unit,
                                                   PetscBool frame, const SlipFaultMeshFile *file);
/* rectangles.c: replaces the corners of rectangles by rows, and raises an error for other quadrilaterals;
   trianglecheck.c, orient.c: raise errors for invalid triangles and pairs of them, merge vertices at one place, and
   orient corners around the normals into the hanging wall. source: beginning of messages */
PETSC_INTERN PetscErrorCode SlipFaultMeshRectangles(const char source[], SlipFaultMeshFile *file);
PETSC_INTERN PetscErrorCode SlipFaultMeshUseVertices(const char source[], SlipFaultMeshFile *file);
PETSC_INTERN PetscErrorCode SlipFaultTrianglesCheck(const char source[], PetscBool full_space, SlipFaultMeshFile *file);
PETSC_INTERN PetscErrorCode SlipFaultTrianglesOrient(const char source[], SlipFaultMeshFile *file);

/* Items to group by several keys, one after the other: faults.c */
typedef struct {
  PetscReal key;
  PetscInt group, cell; /* group of items with equal keys so far; index of the item */
} SlipFaultItem;
PETSC_INTERN void SlipFaultSplit(PetscInt n, SlipFaultItem item[], PetscReal rounding);

PETSC_INTERN PetscErrorCode SlipFaultMeshPlanes(SlipFaultMesh *mesh); /* faults.c */
/* faults.c; collective */
PETSC_INTERN PetscErrorCode SlipFaultMeshFaults(SlipFaultMesh *mesh, const SlipFaultMeshOptions *o);

/* Creates cells, owners and weights of a mesh that is zero; collective. */
PETSC_EXTERN PetscErrorCode SlipFaultMeshCreate(const SlipFaultMeshOptions *o, SlipFaultMesh *mesh);
PETSC_EXTERN PetscErrorCode SlipFaultMeshDestroy(SlipFaultMesh *mesh);
PETSC_EXTERN PetscErrorCode SlipFaultGatherCreate(const SlipFaultMesh *mesh, Vec x, VecScatter *scatter, Vec *x0);
/* Gathers a number for each cell of this process [n] by rows [N] on all, or all to the first; collective. */
PETSC_INTERN PetscErrorCode SlipFaultGatherAll(const SlipFaultMesh *mesh, const PetscReal local[], PetscReal all[]);
PETSC_INTERN PetscErrorCode SlipFaultGatherFirst(const SlipFaultMesh *mesh, const PetscReal local[], PetscReal all[]);
/* Sends numbers of all cells by rows [N], which the first process has, to the owners of the cells [n]; collective. */
PETSC_INTERN PetscErrorCode SlipFaultScatterFirst(const SlipFaultMesh *mesh, const PetscReal all[], PetscReal local[]);
