/* The mesh of a fault: its cells, where they are, and who owns them. A kind of mesh is a row of functions, in a file of
   its own; nobody else asks which kind it is. */
#pragma once
#include <petscmat.h>
#include <slipcells.h>
#include <slipcore.h>
#include <sliph5.h>
#include <slipmat.h>
#include <slipstep/private/slipsys.h>
#include <math.h>

/* What can be metres of a fault: along strike the Earth's circumference, which coordinates of a map keep to as well; in
   depth more than the 700 km below which no rock breaks. */
#define MESH_MAX_REACH 4e7
#define MESH_MAX_DEPTH 1e6

/* Numbers of a uniform grid, and in files of any mesh what they are of the whole: cells, extents and depth [m], angles
   [deg] */
enum { MESH_NX, MESH_NZ, MESH_LENGTH_X, MESH_LENGTH_Z, MESH_DEPTH_TOP, MESH_STRIKE, MESH_DIP, MESH_REALS };

/* A cell; x north, y east, z down [m]; of vertical planes along x, x along strike and y to its right */
typedef struct {
  PetscReal centre[3];
  PetscReal size[2];         /* along strike and down dip [m] */
  PetscReal direction[3][3]; /* unit vectors: along strike, down dip, and their normal towards the hanging wall */
  PetscInt plane;            /* to which it belongs, from 0 */
  const PetscReal
    *vertices; /* [3][3] of a triangle, whose centre is its centroid and whose sides are its extent along strike and
                                its area over that; NULL: a rectangle */
} SlipFaultCell;

typedef struct _SlipFaultMesh SlipFaultMesh;

enum { MESH_VERTICAL_COLUMNS = 5, MESH_COLUMNS = 7 }; /* of rectangles: x y z length width, and strike dip */
/* What a file holds, on rank 0: rectangles or triangles, and the faults that they are of */
typedef struct {
  PetscBool triangles;
  PetscInt n; /* cells */
  PetscInt columns;
  PetscReal *rows;          /* [n][columns] of rectangles */
  PetscInt nvertices;       /* of triangles */
  PetscReal *vertex;        /* [nvertices][3] north, east and down [m] */
  PetscInt sides;           /* 3, or 4 of rectangles that are not rows yet */
  PetscInt *corner;         /* [n][sides] numbers of vertices, from 0 */
  PetscInt *number, *label; /* [n] of each cell in messages, and its fault; NULL: from 0, and not said */
  PetscInt *vertex_number;  /* [nvertices] likewise */
  char *names;              /* of the faults, "label name; label name", or NULL */
  PetscBool metres;         /* the file says that lengths are metres, however small */
  PetscBool upward;         /* z of the file was taken to be upward */
} SlipFaultMeshFile;

/* What a mesh is made of; strings are borrowed and not NULL */
typedef struct {
  MPI_Comm comm;
  const char *prefix;               /* of options, for messages */
  const char *file, *frame, *unit;  /* -fault_mesh, "": a uniform grid; and how its numbers are read */
  const char *type;                 /* -fault_operator, by which cells are ordered */
  const char *fields;               /* datasets that a file may hold besides, with blanks between */
  const PetscReal *extent;          /* [MESH_REALS] of a uniform grid */
  SlipKernel rectangles, triangles; /* of cells of that shape */
  PetscInt block;                   /* numbers of a cell in a state */
} SlipFaultMeshOptions;

/* What its stiffness is made of */
typedef struct {
  SlipKernel kernel;
  PetscBool dipping;     /* the kernel is that of any direction */
  const char *type;      /* -fault_operator */
  PetscReal tolerance;   /* of hierarchical storage */
  const PetscReal *rake; /* [n] of the cells of this process, where dipping [deg] */
} SlipFaultStiffness;

/* A row of a file, or the number iz nx + ix in a grid, names a cell; those of this process are cells start, start + 1
   ... */
typedef struct {
  /* all but n, start and weight; file: what that of -fault_mesh holds, on rank 0, else empty but for triangles */
  PetscErrorCode (*create)(SlipFaultMesh *mesh, const SlipFaultMeshOptions *o, const SlipFaultMeshFile *file);
  void (*cell)(const SlipFaultMesh *mesh, PetscInt row, SlipFaultCell *cell);
  PetscErrorCode (*stiffness)(const SlipFaultMesh *mesh, const SlipFaultStiffness *s, Mat *K,
                              Mat *Kn);                          /* Kn: NULL where it is not wanted */
  PetscErrorCode (*write)(const SlipFaultMesh *mesh, SlipH5 *h); /* /mesh of a file */
  PetscErrorCode (*corners)(const SlipFaultMesh *mesh, PetscReal points[],
                            PetscInt corners[]);                                /* [npoints][3], [N][sides] */
  PetscErrorCode (*digest)(const SlipFaultMesh *mesh, char text[], size_t len); /* says whether two are the same */
  PetscInt sides;                                                               /* of a cell: 3 or 4 */
} SlipFaultMeshKind;

struct _SlipFaultMesh {
  const SlipFaultMeshKind *kind; /* NULL before SlipFaultMeshCreate() */
  MPI_Comm comm;
  PetscInt N, n, start;   /* all, of this rank, the first of this rank */
  PetscInt ndim, dims[2]; /* shape of a number for each cell in files: [nz][nx], or [N] */
  PetscInt npoints;       /* corners of all cells, those that cells share counted once */
  PetscInt planes;        /* on which the cells are */
  PetscReal extent[MESH_REALS];
  PetscReal area;     /* mean of a cell [m^2] */
  PetscBool dips;     /* not all cells are on vertical planes of one strike */
  PetscReal unit;     /* the reciprocal [1/m^2]; 0 where all cells have the same area */
  PetscReal *weight;  /* [n] area over the mean area: rows of K, H and B are multiplied by it, and so is the strength */
  PetscInt *order;    /* [N] row of each cell; NULL: they are the same */
  PetscInt *plane;    /* [N] of each row; NULL: there is one */
  PetscInt *label;    /* [N] the fault of each row, of the file's /fault, by default the plane; NULL: there is one, 0 */
  PetscBool labelled; /* by the file */
  PetscInt faults;    /* that have numbers of their own in files */
  PetscInt *labels;   /* [faults] of each, ascending */
  PetscInt *fault;    /* [N] which of these each row is of; NULL: there is one */
  SlipCells
    cells; /* of a list, in the order of its rows, owned; strike and dip NULL where they are 0 and 90, rake always */
  PetscReal *vertex; /* [npoints][3] of triangles */
  PetscInt *corner;  /* [N][3], around the normal into the hanging wall */
  char *names;       /* of the faults, as the file has them, on rank 0, or NULL */
};

/* Row of cell i of this process */
static inline PetscInt SlipFaultMeshRow(const SlipFaultMesh *mesh, PetscInt i)
{
  return mesh->order ? mesh->order[mesh->start + i] : mesh->start + i;
}

/* Of which fault a row is, from 0, in the order of labels */
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
PETSC_INTERN PetscErrorCode SlipFaultCellsCreate(const SlipKernel *kernel, PetscInt n, PetscInt columns,
                                                 SlipCells *cells, PetscReal *column[]);

PETSC_INTERN const SlipFaultMeshKind SlipFaultMeshTriangles; /* triangles.c: those of -fault_mesh */
/* list.c: of any cells that mesh->cells has */
PETSC_INTERN PetscErrorCode SlipFaultCellsStiffness(const SlipFaultMesh *mesh, const SlipFaultStiffness *s, Mat *K,
                                                    Mat *Kn);
PETSC_INTERN void SlipFaultCellsDirection(const SlipCells *cells, PetscReal *strike, PetscReal *dip);
PETSC_INTERN PetscErrorCode SlipFaultCellsWrite(const SlipFaultMesh *mesh, SlipH5 *h);
PETSC_INTERN PetscErrorCode SlipFaultCellsDigest(const SlipFaultMesh *mesh, char text[], size_t len);
PETSC_INTERN PetscErrorCode SlipFaultCellsShare(SlipFaultMesh *mesh, const char type[]);

/* read.c; on rank 0 */
enum { MESH_MAX_NAMES = 65536 };
#define MESH_MAX_LABEL 1e9 /* what every PetscInt holds, and single precision nearly does */
PETSC_INTERN PetscErrorCode SlipFaultMeshRead(const SlipFaultMeshOptions *o, SlipFaultMeshFile *file);
PETSC_INTERN PetscErrorCode SlipFaultMeshFileDestroy(SlipFaultMeshFile *file);
/* gmsh.c: numbers as they are in a file of Gmsh */
PETSC_INTERN PetscErrorCode SlipFaultMeshReadGmsh(const char name[], const char source[], SlipFaultMeshFile *file);
/* units.c: unit, frame: something says what they are */
PETSC_INTERN PetscErrorCode SlipFaultMeshCheckUnit(const char prefix[], const char source[], PetscBool unit,
                                                   PetscBool frame, const SlipFaultMeshFile *file);
/* rectangles.c: rows in place of the corners of rectangles, which others are refused as; trianglecheck.c, orient.c:
   what is wrong with triangles, one by one and beside each other, is refused; vertices in one place become one, and
   corners go around the normals into the hanging wall. source: what messages begin with */
PETSC_INTERN PetscErrorCode SlipFaultMeshRectangles(const char source[], SlipFaultMeshFile *file);
PETSC_INTERN PetscErrorCode SlipFaultMeshUseVertices(const char source[], SlipFaultMeshFile *file);
PETSC_INTERN PetscErrorCode SlipFaultTrianglesCheck(const char source[], PetscBool full_space, SlipFaultMeshFile *file);
PETSC_INTERN PetscErrorCode SlipFaultTrianglesOrient(const char source[], SlipFaultMeshFile *file);

/* Items to group by several keys, one after the other: planefaults.c */
typedef struct {
  PetscReal key;
  PetscInt group, cell; /* of those whose keys so far agree; which it is */
} SlipFaultItem;
PETSC_INTERN void SlipFaultSplit(PetscInt n, SlipFaultItem item[], PetscReal rounding);

PETSC_INTERN PetscErrorCode SlipFaultMeshPlanes(SlipFaultMesh *mesh); /* planefaults.c */
/* faults.c; collective */
PETSC_INTERN PetscErrorCode SlipFaultMeshFaults(SlipFaultMesh *mesh, const SlipFaultMeshOptions *o);

/* Cells, their owners and weights of a mesh that is all zero; collective */
PETSC_EXTERN PetscErrorCode SlipFaultMeshCreate(const SlipFaultMeshOptions *o, SlipFaultMesh *mesh);
PETSC_EXTERN PetscErrorCode SlipFaultMeshDestroy(SlipFaultMesh *mesh);
PETSC_EXTERN PetscErrorCode SlipFaultGatherCreate(const SlipFaultMesh *mesh, Vec x, VecScatter *scatter, Vec *x0);
/* A number for each cell of this process [n] to those of all, by rows [N], on all; collective */
PETSC_INTERN PetscErrorCode SlipFaultGatherAll(const SlipFaultMesh *mesh, const PetscReal local[], PetscReal all[]);
