/* The quantities of a stage at one point: natural residual, slope and coupling of the bound, and the reaction of a
   solution. They use the loops of cone.c over rows for one component a cell, those over cells for two, and also those
   of contact.c for three. */
#include <slipstep/private/sliploops.h>
#include <slipstep/private/slipsnes.h>
#include <slipstep/private/slipsys.h>
#include <math.h>

/* Creates the work vectors on first use. */
PetscErrorCode SlipConstraintSetUpWork(SlipConstraint con)
{
  Vec *work[] = {&con->r, &con->g, &con->F, &con->mask, &con->slope, &con->rho}, *one[] = {&con->q, &con->dq};
  Vec *vectors[] = {&con->hold, &con->cross, &con->spare}, cells = con->cells ? con->cells : con->x;

  PetscFunctionBegin;
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(work); i++)
    if (!*work[i]) PetscCall(VecDuplicate(con->x, work[i]));
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(one); i++)
    if (!*one[i]) PetscCall(VecDuplicate(cells, one[i]));
  if (con->cells && !con->normal) {
    PetscCall(VecDuplicate(con->x, &con->normal));
    for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(vectors); i++) PetscCall(VecDuplicate(cells, vectors[i]));
  }
  if (con->ops->coupling && !con->row) {
    PetscCall(VecDuplicate(con->x, &con->row));
    PetscCall(VecDuplicate(cells, &con->cx));
  }
  if (con->components == 3 && !con->friction) {
    PetscCall(VecDuplicate(con->x, &con->row));
    PetscCall(VecDuplicate(cells, &con->friction));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipConstraintJacobian(SlipConstraint con, Vec x)
{
  PetscFunctionBegin;
  PetscCall((*con->ops->jacobian)(con, x, &con->B, con->ctx));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipConstraintNorm(SlipConstraint con, Vec v, PetscReal *norm)
{
  PetscInt n;
  const PetscInt c = con->components;
  const PetscReal *a;

  PetscFunctionBegin;
  if (!con->cells) {
    PetscCall(SlipVecLargest(v, norm));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  *norm = 0.0;
  PetscCall(VecGetLocalSize(con->cells, &n));
  PetscCall(VecGetArrayRead(v, &a));
  for (PetscInt i = 0; i < n; i++) {
    const PetscReal size = SlipBlockSize(c, a + c * i);

    *norm = PetscMax(*norm, size);
  }
  PetscCall(VecRestoreArrayRead(v, &a));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, norm, 1, MPIU_REAL, MPIU_MAX, PetscObjectComm((PetscObject)con)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets mask to 0 where x is prescribed, and to 1 elsewhere. */
static PetscErrorCode SlipConstraintPrescribed(SlipConstraint con)
{
  PetscInt n;
  const PetscReal *one;
  PetscReal *mask;
  const SlipArrays arrays[] = {{con->spare, .read = &one}, {con->mask, .write = &mask}};

  PetscFunctionBegin;
  PetscCall(VecSet(con->mask, 1.0));
  if (!con->ops->prescribed) PetscFunctionReturn(PETSC_SUCCESS);
  if (!con->cells) {
    PetscCall((*con->ops->prescribed)(con, con->mask, con->ctx));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(VecSet(con->spare, 1.0));
  PetscCall((*con->ops->prescribed)(con, con->spare, con->ctx));
  PetscCall(VecGetLocalSize(con->cells, &n));
  PetscCall(SlipArraysGet(2, arrays));
  for (PetscInt i = 0; i < n; i++) mask[2 * i] = mask[2 * i + 1] = one[i];
  PetscCall(SlipArraysRestore(2, arrays));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets B, rho = 1/diag(B) and the characteristic traction max(omega q) + max |G(0)| at the start of a solve. */
PetscErrorCode SlipConstraintBegin(SlipConstraint con, Vec x)
{
  PetscReal qmax, cmax, dmin, *a;
  PetscInt n;

  PetscFunctionBegin;
  PetscCall(SlipConstraintSetUpWork(con));
  if (con->ops->at_rest) /* it saves a product with the operator in each stage */
    PetscCall((*con->ops->at_rest)(con, con->g, con->ctx));
  else {
    PetscCall(VecZeroEntries(con->x));
    PetscCall((*con->ops->residual)(con, con->x, con->g, con->ctx));
  }
  PetscCall(SlipConstraintNorm(con, con->g, &cmax));
  PetscCall((*con->ops->bound)(con, x, con->q, NULL, con->ctx));
  if (con->friction) { /* q becomes the strength under the pressure at rest */
    PetscCall(VecZeroEntries(con->x));
    PetscCall(VecSet(con->rho, 1.0));
    PetscCall(SlipConstraintPress(con, con->x, con->q));
  }
  PetscCall(SlipVecLargest(con->q, &qmax));
  con->scale = con->omega * qmax + cmax;
  if (con->scale == 0.0) con->scale = 1.0;
  PetscCall(SlipConstraintJacobian(con, x));
  PetscCall(MatGetDiagonal(con->B, con->rho));
  PetscCall(VecMin(con->rho, NULL, &dmin));
  PetscCheck(dmin > 0.0, PetscObjectComm((PetscObject)con), PETSC_ERR_ARG_OUTOFRANGE,
             "The stage operator has the diagonal entry %g; it must be positive definite", (double)dmin);
  if (con->cells) {
    PetscCall(VecGetLocalSize(con->rho, &n));
    PetscCall(VecGetArray(con->rho, &a));
    for (PetscInt i = 0; i < n; i += con->components) a[i] = a[i + 1] = PetscMax(a[i], a[i + 1]);
    PetscCall(VecRestoreArray(con->rho, &a));
  }
  PetscCall(VecReciprocal(con->rho));
  if (con->ops->solve_cells) PetscCall(SlipConstraintPrescribed(con));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipConstraintPress(SlipConstraint con, Vec x, Vec v)
{
  PetscInt n;
  const PetscReal *xx, *g, *rho;
  PetscReal *p;
  const SlipArrays arrays[] = {
    {x, .read = &xx}, {con->g, .read = &g}, {con->rho, .read = &rho}, {con->spare, .write = &p}};

  PetscFunctionBegin;
  if (!con->friction) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecGetLocalSize(v, &n));
  PetscCall(SlipArraysGet(4, arrays));
  SlipContactPressure(n, con->omega, xx, g, rho, p);
  PetscCall(SlipArraysRestore(4, arrays));
  PetscCall(VecPointwiseMult(v, v, con->spare));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes g = G(x) of the stage, or of its model. */
PetscErrorCode SlipConstraintResidual(SlipConstraint con, const SlipStageModel *model, Vec x, Vec g)
{
  PetscFunctionBegin;
  if (model)
    PetscCall(MatMultAdd(model->A, x, model->offset, g));
  else
    PetscCall((*con->ops->residual)(con, x, g, con->ctx));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The next function for cells with two components: the factors of rows are omega n a. */
static PetscErrorCode SlipConstraintCouplingOfVectors(SlipConstraint con)
{
  PetscInt n;
  const PetscInt c = con->components;
  const PetscReal omega = con->friction ? 1 : con->omega; /* q is friction times G_n / omega */
  const PetscReal *a, *q, *mask, *normal;
  PetscReal *row;
  const SlipArrays arrays[] = {{con->friction ? con->friction : con->cx, .read = &a},
                               {con->q, .read = &q},
                               {con->mask, .read = &mask},
                               {con->normal, .read = &normal},
                               {con->row, .write = &row}};

  PetscFunctionBegin;
  if (!con->friction) PetscCall((*con->ops->coupling)(con, &con->C, con->cx, con->ctx));
  PetscCall(VecGetLocalSize(con->row, &n));
  PetscCall(SlipArraysGet(5, arrays));
  for (PetscInt i = 0; i < n; i++)
    row[i] = mask[i] != 0.0 && q[i / c] > 0.0 ? omega * normal[i] * a[i / c] : 0.0; /* in normal rows, normal is 0 */
  PetscCall(SlipArraysRestore(5, arrays));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets C and computes the factors of its rows, omega sign a where a cell slides against a bound. */
static PetscErrorCode SlipConstraintCoupling(SlipConstraint con)
{
  PetscInt n;
  const PetscScalar *g, *F, *q, *mask;
  PetscScalar *row;
  const SlipArrays arrays[] = {{con->g, .read = &g},
                               {con->F, .read = &F},
                               {con->q, .read = &q},
                               {con->mask, .read = &mask},
                               {con->row, .write = &row}};

  PetscFunctionBegin;
  if (con->cells) {
    PetscCall(SlipConstraintCouplingOfVectors(con));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall((*con->ops->coupling)(con, &con->C, con->row, con->ctx));
  PetscCall(VecGetLocalSize(con->row, &n));
  PetscCall(SlipArraysGet(5, arrays));
  for (PetscInt i = 0; i < n; i++)
    row[i] = mask[i] != 0.0 && q[i] > 0.0 ? (F[i] > g[i] ? con->omega : -con->omega) * row[i] : 0.0;
  PetscCall(SlipArraysRestore(5, arrays));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipConstraintAddCoupling(SlipConstraint con, Vec x, Vec y)
{
  PetscFunctionBegin;
  if (con->friction)
    PetscCall(SlipAddPressure(con->row, y, x, con->rho, y));
  else if (con->C)
    PetscCall(SlipAddCoupling(con->C, con->row, x, con->cx, y));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes F, mask, n and k of cells with two components from g and q. */
static PetscErrorCode SlipConstraintVectors(SlipConstraint con, Vec x)
{
  PetscInt n;
  const PetscReal *xx, *g, *q, *dq, *rho;
  PetscReal *F, *mask, *normal, *hold;
  const SlipArrays arrays[] = {
    {x, .read = &xx},           {con->g, .read = &g},  {con->q, .read = &q},        {con->dq, .read = &dq},
    {con->rho, .read = &rho},   {con->F, .write = &F}, {con->mask, .write = &mask}, {con->normal, .write = &normal},
    {con->hold, .write = &hold}};

  PetscFunctionBegin;
  PetscCall(VecGetLocalSize(con->cells, &n));
  PetscCall(SlipArraysGet(9, arrays));
  if (con->ops->solve_cells)
    SlipDiskSmooth(n, con->components, con->omega, xx, g, q, dq, mask, F, normal, hold);
  else
    SlipDiskNatural(n, con->components, con->omega, xx, g, q, rho, F, mask, normal, hold);
  if (con->friction) SlipContactNatural(n, xx, g, rho, F, mask);
  PetscCall(SlipArraysRestore(9, arrays));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipConstraintSlope(SlipConstraint con, Vec x, Vec dq, Vec slope, Vec *cross)
{
  const PetscReal *xx, *normal, *hold, *d = NULL;
  PetscReal *ss, *cc;
  PetscInt n;

  PetscFunctionBegin;
  if (!con->cells) {
    *cross = NULL;
    if (!dq) {
      PetscCall(VecZeroEntries(slope));
      PetscFunctionReturn(PETSC_SUCCESS);
    }
    if (slope != dq) PetscCall(VecCopy(dq, slope));
    PetscCall(VecScale(slope, con->omega));
    PetscCall(VecPointwiseMult(slope, slope, con->mask));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (slope == con->slope)
    *cross = con->cross;
  else
    *cross = con->spare;
  const SlipArrays arrays[] = {{x, .read = &xx},           {dq, .read = &d},      {con->normal, .read = &normal},
                               {con->hold, .read = &hold}, {slope, .write = &ss}, {*cross, .write = &cc}};

  PetscCall(VecGetLocalSize(con->cells, &n));
  PetscCall(SlipArraysGet(6, arrays));
  SlipDiskSlope(n, con->components, con->omega, xx, d, normal, hold, ss, cc);
  PetscCall(SlipArraysRestore(6, arrays));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SlipConstraintNatural(SlipConstraint con, Vec x)
{
  PetscInt n;
  const PetscScalar *xx, *g, *q, *dq;
  PetscScalar *F, *mask, *slope;
  const SlipArrays arrays[] = {
    {x, .read = &xx},      {con->g, .read = &g},        {con->q, .read = &q},         {con->dq, .read = &dq},
    {con->F, .write = &F}, {con->mask, .write = &mask}, {con->slope, .write = &slope}};
  Vec cross;

  PetscFunctionBegin;
  if (con->cells) {
    PetscCall(SlipConstraintVectors(con, x));
    PetscCall(SlipConstraintSlope(con, x, con->dq, con->slope, &cross));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(VecGetLocalSize(x, &n));
  if (con->ops->solve_cells) {
    PetscCall(SlipArraysGet(7, arrays));
    SlipConeSmooth(n, con->omega, xx, g, q, dq, mask, F, slope);
    PetscCall(SlipArraysRestore(7, arrays));
  } else
    PetscCall(SlipLoopRun(SLIP_LOOP_CONE_NATURAL, n, &con->omega,
                          (const Vec[]){x, con->g, con->q, con->dq, con->rho, con->F, con->mask, con->slope}, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipConstraintEvaluate(SlipConstraint con, const SlipStageModel *model, Vec x)
{
  PetscFunctionBegin;
  PetscCall(SlipConstraintResidual(con, model, x, con->g));
  PetscCall(SlipConstraintEvaluateKnown(con, x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipConstraintEvaluateKnown(SlipConstraint con, Vec x)
{
  PetscFunctionBegin;
  PetscCall(PetscLogEventBegin(SLIP_Cone, con, x, 0, 0));
  PetscCall((*con->ops->bound)(con, x, con->q, con->dq, con->ctx));
  if (con->friction) PetscCall(VecCopy(con->q, con->friction));
  PetscCall(SlipConstraintPress(con, x, con->q));
  PetscCall(SlipConstraintPress(con, x, con->dq));
  PetscCall(SlipConstraintNatural(con, x));
  if (con->row) PetscCall(SlipConstraintCoupling(con));
  PetscCall(VecNorm(con->F, NORM_2, &con->merit));
  PetscCall(SlipConstraintNorm(con, con->F, &con->norm));
  con->merit /= con->scale;
  con->norm /= con->scale;
  PetscCall(PetscLogEventEnd(SLIP_Cone, con, x, 0, 0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns whether x and con->x are equal bit by bit. */
static PetscErrorCode SlipConstraintSameAs(SlipConstraint con, Vec x, PetscBool *same)
{
  PetscFunctionBegin;
  PetscCall(SlipVecSame(x, con->x, same));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, same, 1, MPIU_BOOL, MPI_LAND, PetscObjectComm((PetscObject)con)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets sticking cells to exactly zero, the reaction inside the cone, and the cell with the largest residual. */
PetscErrorCode SlipConstraintFinish(SlipConstraint con, Vec x)
{
  PetscInt n, rstart, worst;
  const PetscScalar *g, *q, *rho;
  PetscScalar *xx, *r;
  const PetscInt c = con->components;
  struct {
    double value;
    int index;
  } mine = {-1.0, -1}, all;
  const SlipArrays arrays[] = {
    {x, .write = &xx}, {con->r, .write = &r}, {con->g, .read = &g}, {con->q, .read = &q}, {con->rho, .read = &rho}};

  PetscFunctionBegin;
  PetscCall(VecCopy(x, con->x));
  PetscCall(VecGetLocalSize(con->q, &n));
  PetscCall(VecGetOwnershipRange(con->q, &rstart, NULL));
  con->resnorm = con->norm;
  if (!con->cells && !con->ops->solve_cells)
    PetscCall(
      SlipLoopRun(SLIP_LOOP_CONE_FINISH, n, &con->omega, (const Vec[]){con->g, con->q, con->rho, x, con->r}, NULL));
  else {
    PetscCall(SlipArraysGet(5, arrays));
    if (con->cells && con->ops->solve_cells)
      for (PetscInt i = 0; i < n; i++) SlipDiskReaction(con->omega, &xx[2 * i], &g[2 * i], q[i], &r[2 * i]);
    else if (con->cells)
      SlipDiskFinish(n, c, con->omega, g, q, rho, xx, r);
    else
      for (PetscInt i = 0; i < n; i++) r[i] = xx[i] > 0 ? -q[i] : q[i];
    if (con->friction) SlipContactFinish(n, con->omega, g, rho, xx, r);
    PetscCall(SlipArraysRestore(5, arrays));
  }
  PetscCall(SlipVecLargestBlock(con->F, c, &mine.value, &worst));
  mine.index = worst < 0 ? SLIP_WORST_UNKNOWN : (int)(rstart + worst);
  PetscCallMPI(MPI_Allreduce(&mine, &all, 1, MPI_DOUBLE_INT, MPI_MAXLOC, PetscObjectComm((PetscObject)con)));
  con->worst = all.index;
  PetscCall(SlipConstraintSameAs(con, x, &con->balanced));
  PetscFunctionReturn(PETSC_SUCCESS);
}
