/*
  The stage operator of irregular cells inverted in parts, for preconditioning (additive Schwarz, Smith, Bjorstad &
  Gropp 1996, chapter 1): clusters of cells with those around them, and means over larger clusters for what is smooth.
  With the eigenvectors of K within a part, W^(-1/2) K_i W^(-1/2) = V L V',

     P = sum_i D_i V_i f(L_i) V_i' D_i + R' V_0 f(L_0) V_0' R,
     f(k) = 1 / (M / theta + 2 zeta (M k)^(1/2) + theta k + slope),

  D_i = (W n)^(-1/2), n the number of clusters that a cell is in, R means over large clusters: positive definite, and
  ready for any theta. Parts come from bisection of all cells and each belongs to one process, so that P does not depend
  on the number of processes.
*/
#include <slipmat.h>
#include <slipstep/private/slipsys.h>
#include <slipstep/private/slipmatstage.h>
#include <petscblaslapack.h>

/* On graded meshes of 1536 cells CG needs 37 iterations for 1e-6 with the diagonal at theta = 6 T*, 19 with clusters of
   64, 12 with cells around them as well, 11 with means; twice as much overlap saves one more for four times the
   storage. */
#define SCHWARZ_LEAF 64         /* cells of a cluster */
#define SCHWARZ_OVERLAP 0.25    /* cells as far as this share of its diameter are in the part as well */
#define SCHWARZ_COARSE_LEAF 256 /* cells that a mean is taken over, at least */
#define SCHWARZ_COARSE_MAX 64   /* means, at most twice as many: each costs a product with K at set-up */

/* Eigenvectors of K in a part, column-major; f of the last set-up. */
typedef struct {
  PetscInt n, *row;
  PetscReal *values, *vectors, *f;
} Part;

struct _n_SlipSchwarz {
  PetscInt N, nparts; /* parts of this process */
  Part *part, coarse; /* coarse.row is [N]: the mean that each row is in */
  PetscReal *d;       /* [N] D */
  PetscReal *length;  /* [coarse.n] square root of the weights of a mean's cells */
  SlipGather gather;
  PetscReal *z, *s, *t; /* [N], [widest part] */
};

/* ---- parts ---- */

static PetscErrorCode PartDestroy(Part *p)
{
  PetscFunctionBegin;
  PetscCall(PetscFree(p->row));
  PetscCall(PetscFree3(p->values, p->vectors, p->f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode PartEigen(Part *p)
{
  PetscInt info;

  PetscFunctionBegin;
  PetscCall(SlipDenseEigen(p->n, p->vectors, p->values, &info));
  PetscCheck(!info, PETSC_COMM_SELF, PETSC_ERR_LIB, "LAPACK syevd: info %" PetscInt_FMT, info);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void PartFunction(Part *p, PetscReal scale, const SlipStageParts *stage, PetscReal slope, PetscReal limit)
{
  for (PetscInt k = 0; k < p->n; k++) {
    const PetscReal v = scale * PetscMax(p->values[k], 0);
    const PetscReal symbol = stage->mass / stage->theta + stage->damping * PetscSqrtReal(v) + stage->theta * v;

    p->f[k] = 1 / PetscMax(symbol + slope, (1 - limit) * symbol);
  }
}

/* s := V f V' s; t [n] */
static PetscErrorCode PartApply(const Part *p, PetscReal s[], PetscReal t[])
{
  const PetscScalar one = 1, zero = 0;
  PetscBLASInt n, inc = 1;

  PetscFunctionBegin;
  PetscCall(PetscBLASIntCast(p->n, &n));
  PetscCallBLAS("BLASgemv", BLASgemv_("T", &n, &n, &one, p->vectors, &n, s, &inc, &zero, t, &inc));
  for (PetscInt k = 0; k < p->n; k++) t[k] *= p->f[k];
  PetscCallBLAS("BLASgemv", BLASgemv_("N", &n, &n, &one, p->vectors, &n, t, &inc, &zero, s, &inc));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Cells of all nodes whose centres are near a cluster's box: list[0 .. *n). */
static void Collect(const SlipCells *c, const SlipClusterTree *tree, PetscInt node, const SlipCluster *box,
                    PetscReal distance, PetscInt list[], PetscInt *n)
{
  const SlipCluster *p = &tree->node[node];

  if (SlipClusterDistance(p, box) > distance) return;
  for (int k = 0; k < 2 && p->child[0] >= 0; k++) Collect(c, tree, p->child[k], box, distance, list, n);
  for (PetscInt k = p->start; k < p->end && p->child[0] < 0; k++) {
    const PetscInt e = tree->perm[k];
    const SlipCluster point = {.low = {c->x[e], c->y[e], c->z[e]}, .top = {c->x[e], c->y[e], c->z[e]}};

    if (SlipClusterDistance(&point, box) <= distance) list[(*n)++] = e;
  }
}

/* K within a part and its eigenvectors, weighted. */
static PetscErrorCode PartCreate(const SlipCells *c, const PetscInt row[], PetscInt n, const PetscInt cells[], Part *p)
{
  const PetscReal unit = SlipCellsUnit(c);

  PetscFunctionBegin;
  p->n = n;
  PetscCall(PetscMalloc1(n, &p->row));
  PetscCall(PetscMalloc3(n, &p->values, n * n, &p->vectors, n, &p->f));
  for (PetscInt i = 0; i < n; i++) {
    p->row[i] = row[cells[i]];
    for (PetscInt j = 0; j <= i; j++) {
      const PetscInt a = cells[i], b = cells[j];
      const PetscReal wa = 2 * unit * c->length[a] * c->width[a], wb = 2 * unit * c->length[b] * c->width[b];

      p->vectors[i * n + j] = p->vectors[j * n + i] =
        SlipCellsEntry(c, unit, PetscMin(a, b), PetscMax(a, b)) / PetscSqrtReal(wa * wb);
    }
  }
  PetscCall(PartEigen(p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The process with the most cells of a cluster, the first of equals. */
static PetscMPIInt Owner(const SlipClusterTree *tree, const SlipCluster *p, const PetscInt row[],
                         const PetscInt ranges[], PetscMPIInt size, PetscInt count[])
{
  PetscMPIInt most = 0;

  for (PetscMPIInt r = 0; r < size; r++) count[r] = 0;
  for (PetscInt k = p->start; k < p->end; k++) {
    PetscMPIInt r = 0;

    while (row[tree->perm[k]] >= ranges[r + 1]) r++;
    count[r]++;
  }
  for (PetscMPIInt r = 1; r < size; r++)
    if (count[r] > count[most]) most = r;
  return most;
}

/* The parts of this process, and how many parts each cell is in: overlap [N]. */
static PetscErrorCode CreateParts(Mat K, const SlipCells *c, const PetscInt row[], PetscInt overlap[], SlipSchwarz s)
{
  const PetscInt *ranges;
  PetscInt *list, *count;
  PetscMPIInt rank, size;
  SlipClusterTree tree;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(PetscObjectComm((PetscObject)K), &rank));
  PetscCallMPI(MPI_Comm_size(PetscObjectComm((PetscObject)K), &size));
  PetscCall(MatGetOwnershipRanges(K, &ranges));
  PetscCall(SlipClusterTreeCreate(c, SCHWARZ_LEAF, &tree));
  PetscCall(PetscMalloc2(c->n, &list, size, &count));
  PetscCall(PetscCalloc1(tree.nnodes, &s->part));
  for (PetscInt k = 0; k < tree.nnodes; k++) {
    const SlipCluster *p = &tree.node[k];
    PetscInt n = 0;

    if (p->child[0] >= 0) continue;
    Collect(c, &tree, 0, p, SCHWARZ_OVERLAP * SlipClusterDiameter(p), list, &n);
    for (PetscInt i = 0; i < n; i++) overlap[list[i]]++;
    if (Owner(&tree, p, row, ranges, size, count) == rank)
      PetscCall(PartCreate(c, row, n, list, &s->part[s->nparts++]));
  }
  PetscCall(PetscFree2(list, count));
  PetscCall(SlipClusterTreeDestroy(&tree));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- means ---- */

/* K over the kernel of its cells: what MatScale() has made of it. */
static PetscErrorCode ScaleOf(Mat K, PetscReal *scale)
{
  const SlipCells *c;
  PetscReal sum = 0;
  PetscMPIInt rank;
  Vec d;

  PetscFunctionBegin;
  PetscCall(SlipCellsOf(K, &c));
  PetscCallMPI(MPI_Comm_rank(PetscObjectComm((PetscObject)K), &rank));
  PetscCall(MatCreateVecs(K, &d, NULL));
  PetscCall(MatGetDiagonal(K, d));
  if (!rank) {
    const PetscInt e = SlipCellsAt(c, 0);
    const PetscReal *a;

    PetscCall(VecGetArrayRead(d, &a));
    sum = a[0] / SlipCellsEntry(c, SlipCellsUnit(c), e, e);
    PetscCall(VecRestoreArrayRead(d, &a));
  }
  PetscCallMPI(MPI_Bcast(&sum, 1, MPIU_REAL, 0, PetscObjectComm((PetscObject)K)));
  PetscCall(VecDestroy(&d));
  *scale = sum;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* coarse.row and length from the leaves of a tree with few of them. */
static PetscErrorCode CreateMeans(const SlipCells *c, const PetscInt row[], SlipSchwarz s)
{
  const PetscReal unit = SlipCellsUnit(c);
  SlipClusterTree tree;

  PetscFunctionBegin;
  PetscCall(SlipClusterTreeCreate(c, PetscMax(SCHWARZ_COARSE_LEAF, c->n / SCHWARZ_COARSE_MAX), &tree));
  PetscCall(PetscMalloc1(c->n, &s->coarse.row));
  PetscCall(PetscCalloc1(tree.nnodes, &s->length));
  for (PetscInt k = 0; k < tree.nnodes; k++) {
    const SlipCluster *p = &tree.node[k];

    if (p->child[0] >= 0) continue;
    for (PetscInt i = p->start; i < p->end; i++) {
      const PetscInt e = tree.perm[i];

      s->coarse.row[row[e]] = s->coarse.n;
      s->length[s->coarse.n] += 2 * unit * c->length[e] * c->width[e];
    }
    s->length[s->coarse.n] = PetscSqrtReal(s->length[s->coarse.n]);
    s->coarse.n++;
  }
  PetscCall(SlipClusterTreeDestroy(&tree));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Column k of K between means, by a product. */
static PetscErrorCode CoarseColumn(Mat K, PetscReal scale, SlipSchwarz s, PetscInt k, Vec x, Vec y, PetscReal column[])
{
  PetscReal *a;
  const PetscReal *b;

  PetscFunctionBegin;
  PetscCall(VecGetArrayWrite(x, &a));
  for (PetscInt i = s->gather.start; i < s->gather.end; i++) a[i - s->gather.start] = s->coarse.row[i] == k ? 1 : 0;
  PetscCall(VecRestoreArrayWrite(x, &a));
  PetscCall(MatMult(K, x, y));
  PetscCall(PetscArrayzero(column, s->coarse.n));
  PetscCall(VecGetArrayRead(y, &b));
  for (PetscInt i = s->gather.start; i < s->gather.end; i++) {
    const PetscInt j = s->coarse.row[i];

    column[j] += b[i - s->gather.start] / (scale * s->length[j] * s->length[k]);
  }
  PetscCall(VecRestoreArrayRead(y, &b));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode CreateCoarse(Mat K, const SlipCells *c, const PetscInt row[], SlipSchwarz s)
{
  Part *p = &s->coarse;
  PetscMPIInt count;
  PetscReal scale;
  Vec x, y;

  PetscFunctionBegin;
  PetscCall(ScaleOf(K, &scale));
  PetscCall(CreateMeans(c, row, s));
  PetscCall(PetscMalloc3(p->n, &p->values, p->n * p->n, &p->vectors, p->n, &p->f));
  PetscCall(MatCreateVecs(K, &x, &y));
  for (PetscInt k = 0; k < p->n; k++) PetscCall(CoarseColumn(K, scale, s, k, x, y, p->vectors + k * p->n));
  PetscCall(PetscMPIIntCast(p->n * p->n, &count));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, p->vectors, count, MPIU_REAL, MPIU_SUM, PetscObjectComm((PetscObject)K)));
  PetscCall(PartEigen(p));
  PetscCall(VecDestroy(&x));
  PetscCall(VecDestroy(&y));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the whole ---- */

static PetscErrorCode SchwarzDestroy(SlipContainerArg arg)
{
  SlipSchwarz s = (SlipSchwarz)SlipContainerArgPointer(arg);

  PetscFunctionBegin;
  for (PetscInt k = 0; k < s->nparts; k++) PetscCall(PartDestroy(&s->part[k]));
  PetscCall(PartDestroy(&s->coarse));
  PetscCall(PetscFree(s->part));
  PetscCall(PetscFree(s->length));
  PetscCall(PetscFree4(s->d, s->z, s->s, s->t));
  PetscCall(SlipGatherDestroy(&s->gather));
  PetscCall(PetscFree(s));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SchwarzCreate(Mat K, const SlipCells *c, SlipSchwarz *schwarz)
{
  const PetscReal unit = SlipCellsUnit(c);
  PetscInt *row, *overlap, widest = 0;
  SlipSchwarz s;

  PetscFunctionBegin;
  PetscCall(PetscNew(&s));
  s->N = c->n;
  PetscCall(SlipGatherCreate(K, NULL, &s->gather));
  PetscCall(PetscMalloc1(c->n, &row));
  PetscCall(PetscCalloc1(c->n, &overlap));
  for (PetscInt i = 0; i < c->n; i++) row[SlipCellsAt(c, i)] = i;
  PetscCall(CreateParts(K, c, row, overlap, s));
  PetscCall(CreateCoarse(K, c, row, s));
  widest = s->coarse.n;
  for (PetscInt k = 0; k < s->nparts; k++) widest = PetscMax(widest, s->part[k].n);
  PetscCall(PetscMalloc4(c->n, &s->d, c->n, &s->z, widest, &s->s, widest, &s->t));
  for (PetscInt e = 0; e < c->n; e++)
    s->d[row[e]] = 1 / PetscSqrtReal(2 * unit * c->length[e] * c->width[e] * (PetscReal)overlap[e]);
  PetscCall(PetscFree(row));
  PetscCall(PetscFree(overlap));
  PetscCall(PetscInfo(K, "%" PetscInt_FMT " parts of at most %" PetscInt_FMT " cells here, %" PetscInt_FMT " means\n",
                      s->nparts, widest, s->coarse.n));
  *schwarz = s;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Borrowed from K, made when first asked for; NULL when K is not of irregular cells. Collective. */
PetscErrorCode SlipSchwarzOf(Mat K, SlipSchwarz *schwarz)
{
  const SlipCells *cells;

  PetscFunctionBegin;
  *schwarz = NULL;
  PetscCall(SlipCellsOf(K, &cells));
  if (!cells) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipObjectQueryData((PetscObject)K, "SlipSchwarz", schwarz));
  if (*schwarz) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SchwarzCreate(K, cells, schwarz));
  PetscCall(SlipObjectComposeData((PetscObject)K, "SlipSchwarz", *schwarz, SchwarzDestroy));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* For a stage and a mean slope of the bound, of which at most the share limit of the operator is taken away.
   Collective. */
PetscErrorCode SlipSchwarzSetUp(SlipSchwarz s, const SlipStageParts *stage, PetscReal slope, PetscReal limit)
{
  PetscReal scale;

  PetscFunctionBegin;
  PetscCall(ScaleOf(stage->K, &scale));
  for (PetscInt k = 0; k < s->nparts; k++) PartFunction(&s->part[k], scale, stage, slope, limit);
  PartFunction(&s->coarse, scale, stage, slope, limit);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* z += the part that is smooth, of the whole x; on one process only */
static PetscErrorCode ApplyCoarse(SlipSchwarz s, const PetscReal x[])
{
  PetscFunctionBegin;
  if (s->gather.start > 0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscArrayzero(s->s, s->coarse.n));
  for (PetscInt i = 0; i < s->N; i++) s->s[s->coarse.row[i]] += x[i] / s->length[s->coarse.row[i]];
  PetscCall(PartApply(&s->coarse, s->s, s->t));
  for (PetscInt i = 0; i < s->N; i++) s->z[i] += s->s[s->coarse.row[i]] / s->length[s->coarse.row[i]];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* x := P x. Collective. */
PetscErrorCode SlipSchwarzApply(SlipSchwarz s, Vec x)
{
  const PetscReal *a;

  PetscFunctionBegin;
  PetscCall(SlipGatherGet(&s->gather, x, &a));
  PetscCall(PetscArrayzero(s->z, s->N));
  for (PetscInt k = 0; k < s->nparts; k++) {
    const Part *p = &s->part[k];

    for (PetscInt i = 0; i < p->n; i++) s->s[i] = s->d[p->row[i]] * a[p->row[i]];
    PetscCall(PartApply(p, s->s, s->t));
    for (PetscInt i = 0; i < p->n; i++) s->z[p->row[i]] += s->d[p->row[i]] * s->s[i];
  }
  PetscCall(ApplyCoarse(s, a));
  PetscCall(SlipGatherRestore(&s->gather, x, &a));
  PetscCall(SlipGatherSum(&s->gather, s->z, x));
  PetscFunctionReturn(PETSC_SUCCESS);
}
