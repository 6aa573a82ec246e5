/* The mesh of a fault: its cells, where they are, and who owns them. A kind of mesh is a row of functions, in a file of its
   own; nobody else asks which kind it is. */
#pragma once
#include <slipfault.h>
#include <slipcells.h>
#include <sliph5.h>
#include <slipstep/private/slipfaultparameters.h>

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

/* A row of a file, or the number iz nx + ix in a grid, names a cell; those of this process are cells start, start + 1 ... */
typedef struct {
  /* all but n, start and weight; file: of -fault_mesh, on rank 0, else empty but for triangles */
  PetscErrorCode (*create)(SlipFault fault, const SlipFaultMeshFile *file);
  void (*cell)(const SlipFaultMesh *mesh, PetscInt row, SlipFaultCell *cell);
  PetscErrorCode (*stiffness)(SlipFault fault, Mat *K, Mat *Kn); /* Kn: NULL where it is not wanted */
  PetscErrorCode (*write)(const SlipFaultMesh *mesh, SlipH5 *h); /* /mesh of a file */
  PetscErrorCode (*corners)(const SlipFaultMesh *mesh, PetscReal points[],
                            PetscInt corners[]);                                /* [npoints][3], [N][sides] */
  PetscErrorCode (*digest)(const SlipFaultMesh *mesh, char text[], size_t len); /* says whether two are the same */
  PetscInt sides;                                                               /* of a cell: 3 or 4 */
} SlipFaultMeshKind;

struct _SlipFaultMesh {
  const SlipFaultMeshKind *kind;      /* NULL before SlipFaultSetUp() */
  PetscInt N, n, start;               /* all, of this rank, the first of this rank */
  PetscInt ndim, dims[2];             /* shape of a number for each cell in files: [nz][nx], or [N] */
  PetscInt npoints;                   /* corners of all cells, those that cells share counted once */
  PetscInt planes;                    /* on which the cells are */
  PetscReal extent[FAULT_MESH_REALS]; /* what SlipFaultGetReal() says of FAULT_NX, FAULT_NZ, FAULT_LENGTH_X ... */
  PetscReal area;                     /* mean of a cell [m^2] */
  PetscBool dips;                     /* not all cells are on vertical planes of one strike */
  PetscReal unit;                     /* the reciprocal [1/m^2]; 0 where all cells have the same area */
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

/* meshcells.c: directions of a cell of this strike and dip [deg] */
PETSC_INTERN void SlipFaultCellDirections(PetscReal strike, PetscReal dip, SlipFaultCell *cell);
PETSC_INTERN const SlipFaultMeshKind SlipFaultMeshGrid; /* meshgrid.c: the uniform grid of the options */
PETSC_INTERN const SlipFaultMeshKind SlipFaultMeshList; /* meshlist.c: the cells of -fault_mesh */
PETSC_INTERN PetscErrorCode SlipFaultCellsCreate(SlipFault fault, PetscInt n, PetscInt columns, SlipCells *cells,
                                                 PetscReal *column[]);

PETSC_INTERN const SlipFaultMeshKind SlipFaultMeshTriangles; /* meshtriangles.c: those of -fault_mesh */
/* meshlist.c: of any cells that mesh->cells has */
PETSC_INTERN PetscErrorCode SlipFaultCellsStiffness(SlipFault fault, Mat *K, Mat *Kn);
PETSC_INTERN void SlipFaultCellsDirection(const SlipCells *cells, PetscReal *strike, PetscReal *dip);
PETSC_INTERN PetscErrorCode SlipFaultCellsWrite(const SlipFaultMesh *mesh, SlipH5 *h);
PETSC_INTERN PetscErrorCode SlipFaultCellsDigest(const SlipFaultMesh *mesh, char text[], size_t len);
PETSC_INTERN PetscErrorCode SlipFaultCellsShare(SlipFault fault);

/* meshread.c; on rank 0 */
enum { MESH_MAX_NAMES = 65536 };
#define MESH_MAX_LABEL 1e9 /* what every PetscInt holds, and single precision nearly does */
PETSC_INTERN PetscErrorCode SlipFaultMeshRead(SlipFault fault, SlipFaultMeshFile *file);
PETSC_INTERN PetscErrorCode SlipFaultMeshFileDestroy(SlipFaultMeshFile *file);
/* meshgmsh.c: numbers as they are in a file of Gmsh */
PETSC_INTERN PetscErrorCode SlipFaultMeshReadGmsh(const char name[], const char source[], SlipFaultMeshFile *file);
/* meshunits.c: unit, frame: something says what they are */
PETSC_INTERN PetscErrorCode SlipFaultMeshCheckUnit(const char prefix[], const char source[], PetscBool unit,
                                                   PetscBool frame, const SlipFaultMeshFile *file);
/* meshrectangles.c: rows in place of the corners of rectangles, which others are refused as; meshsurface.c, meshorient.c: what is wrong with triangles, one by one and beside each other, is refused; vertices in one place become
   one, and corners go around the normals into the hanging wall. source: what messages begin with */
PETSC_INTERN PetscErrorCode SlipFaultMeshRectangles(const char source[], SlipFaultMeshFile *file);
PETSC_INTERN PetscErrorCode SlipFaultMeshUseVertices(const char source[], SlipFaultMeshFile *file);
PETSC_INTERN PetscErrorCode SlipFaultTrianglesCheck(const char source[], PetscBool full_space, SlipFaultMeshFile *file);
PETSC_INTERN PetscErrorCode SlipFaultTrianglesOrient(const char source[], SlipFaultMeshFile *file);

/* Items to group by several keys, one after the other: meshplanes.c */
typedef struct {
  PetscReal key;
  PetscInt group, cell; /* of those whose keys so far agree; which it is */
} SlipFaultItem;
PETSC_INTERN void SlipFaultSplit(PetscInt n, SlipFaultItem item[], PetscReal rounding);

PETSC_INTERN PetscErrorCode SlipFaultMeshPlanes(SlipFaultMesh *mesh); /* meshplanes.c */
PETSC_INTERN PetscErrorCode SlipFaultMeshFaults(SlipFault fault);     /* meshfaults.c; collective */

PETSC_EXTERN PetscErrorCode SlipFaultMeshSetUp(SlipFault fault); /* cells, their owners and weights; collective */
PETSC_EXTERN PetscErrorCode SlipFaultMeshDestroy(SlipFaultMesh *mesh);
PETSC_EXTERN PetscErrorCode SlipFaultGatherCreate(SlipFault fault, Vec x, VecScatter *scatter, Vec *x0);
PETSC_EXTERN PetscErrorCode SlipFaultWeightedSum(SlipFault fault, Vec x, PetscReal *sum);
