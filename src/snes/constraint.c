/* SlipConstraint: a set-valued reaction, which a problem defines by a table of operations. */
#include <slipstep/private/sliploops.h>
#include <slipstep/private/slipsnes.h>
#include <slipstep/rooms/slipcore.h>

/*@C
  SlipConstraintDestroy - destroys a constraint when its last reference is gone

  Collective

  Input Parameter:
. con - the constraint; it is set to NULL

  Level: intermediate

.seealso: SlipConstraintCreate()
@*/
PetscErrorCode SlipConstraintDestroy(SlipConstraint *con)
{
  PetscFunctionBegin;
  if (*con) PetscValidHeaderSpecific(*con, SLIP_CONSTRAINT_CLASSID, 1);
  if (*con && --((PetscObject)*con)->refct == 0) {
    SlipConstraint c = *con;
    Vec *vecs[] = {&c->x,   &c->w,   &c->r,  &c->g,     &c->q,      &c->dq,   &c->F,     &c->mask,  &c->slope,
                   &c->rho, &c->row, &c->cx, &c->cells, &c->normal, &c->hold, &c->cross, &c->spare, &c->friction};

    for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(vecs); i++) PetscCall(VecDestroy(vecs[i]));
    PetscCall(PetscHeaderDestroy(con));
  }
  *con = NULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipConstraintGetContext - gets the context that was passed to SlipConstraintCreate()

  Not collective

  Input Parameter:
. con - the constraint

  Output Parameter:
. ctx - address of a pointer that receives the context

  Level: intermediate

.seealso: SlipConstraintCreate()
@*/
PetscErrorCode SlipConstraintGetContext(SlipConstraint con, void *ctx)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(con, SLIP_CONSTRAINT_CLASSID, 1);
  *(void **)ctx = con->ctx;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipConstraintSetRefuseUnstable - sets whether solves fail where the stage goes past an instability

  Logically collective

  Input Parameters:
+ con    - the constraint
- refuse - PETSC_TRUE: a solve with SNESSEMISMOOTH fails if the generalised Jacobian on the sliding set is not positive
           definite, as that of a short step is, or with a coupling if an eigenvalue has no positive real part;
           PETSC_FALSE (the default): the solve continues to a stable solution beyond the instability

  Level: advanced

  Note:
  A step that is longer than the growth time of an instability also has a stable solution, after the event: the event is
  skipped, or becomes creep. A run of a single event from its instability needs such steps, and a run over many events
  must not take them. With the operation start_slope the Jacobian with the bound's slope at the stage's start must also
  be positive definite, because an instability may begin and end within a stage. Solves with a smooth bound (solve_cells
  of SlipConstraintOps) always fail there.

.seealso: SlipConstraintWasUnstable(), SNESSEMISMOOTH
@*/
PetscErrorCode SlipConstraintSetRefuseUnstable(SlipConstraint con, PetscBool refuse)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(con, SLIP_CONSTRAINT_CLASSID, 1);
  PetscValidLogicalCollectiveBool(con, refuse, 2);
  con->refuse = refuse;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipConstraintWasUnstable - returns whether the last solve failed because the stage goes past an instability

  Not collective

  Input Parameter:
. con - the constraint

  Output Parameter:
. unstable - `PETSC_TRUE` if it did; always false unless SlipConstraintSetRefuseUnstable() was set

  Level: advanced

.seealso: SlipConstraintSetRefuseUnstable()
@*/
PetscErrorCode SlipConstraintWasUnstable(SlipConstraint con, PetscBool *unstable)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(con, SLIP_CONSTRAINT_CLASSID, 1);
  *unstable = con->unstable;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipConstraintSetComponents - sets how many numbers a cell has in reduced vectors

  Collective

  Input Parameters:
+ con   - the constraint
. c     - 1 (the default); 2: then |r_i| <= q_i in the Euclidean norm, and r_i = -q_i x_i / |x_i| where x_i != 0; or 3:
          as 2, and the cell may open
- cells - a vector with one number per cell in the layout of q (its values are not used; NULL allowed with c = 1)

  Level: advanced

  Notes:
  Call it before the first solve. With c = 2 the numbers of cell i are x[2 i] and x[2 i + 1], on one process. In
  SlipConstraintOps, x, g and r have two numbers per cell, and B is 2 n x 2 n for n cells; q and dq (bound, bound_state,
  start_slope) have one, and dq is the derivative by |x_i|. C of coupling is n x 2 n, and its a has one number per cell.

  Where the bound is smooth, the mask of prescribed has one number per cell: where it is 0, x is that of the guess,
  which reduce provides. D, f and x of solve_cells have one: it sets the speed |x_i| >= 0 with D_i |x_i| + omega
  q_i(|x_i|) = f_i >= 0 from the guess in x, and the cell moves along the load, whose size is f_i. D_i is the larger of
  the cell's diagonal entries of B; a solution does not depend on it.

  The directions of components do not matter, and may differ from cell to cell.

  With c = 3 the third number of a cell, x[3 i + 2], is its opening: x >= 0, its reaction, the pressure, is r >= 0, and
  x r = 0. The other two are as with c = 2, and the bound is friction: q and dq of SlipConstraintOps (bound,
  start_slope) are relative to the unknown pressure of the same stage: |r_i| <= q_i r, and an open cell has no reaction.
  In bound_state q is the strength, 0 where a cell is open. A coupling or a smooth bound is not possible then.

  Errors: PETSC_ERR_ARG_OUTOFRANGE for another c, PETSC_ERR_ARG_SIZ when x has not c numbers for each of cells,
  PETSC_ERR_ORDER after a solve, PETSC_ERR_SUP for several of SlipConstraintCreateSmall() and
  for three with the operations coupling or solve_cells.

.seealso: SlipConstraintGetComponents(), SlipConstraintCreate()
@*/
PetscErrorCode SlipConstraintSetComponents(SlipConstraint con, PetscInt c, Vec cells)
{
  PetscInt n, m = 0;

  PetscFunctionBegin;
  PetscValidHeaderSpecific(con, SLIP_CONSTRAINT_CLASSID, 1);
  PetscValidLogicalCollectiveInt(con, c, 2);
  if (cells) PetscValidHeaderSpecific(cells, VEC_CLASSID, 3);
  PetscCheck(c >= 1 && c <= 3, PetscObjectComm((PetscObject)con), PETSC_ERR_ARG_OUTOFRANGE,
             "Cells have %" PetscInt_FMT " components, expected 1, 2 or 3", c);
  PetscCheck(
    c < 3 || !(con->ops->coupling || con->ops->solve_cells), PetscObjectComm((PetscObject)con), PETSC_ERR_SUP,
    "Cells that open need a set-valued bound that does not depend on other cells, expected neither the operation "
    "coupling nor solve_cells");
  PetscCheck(c == 1 || !con->single, PetscObjectComm((PetscObject)con), PETSC_ERR_SUP,
             "Rows of SlipConstraintCreateSmall() have one component each, expected 1, not %" PetscInt_FMT, c);
  PetscCheck(!con->r, PetscObjectComm((PetscObject)con), PETSC_ERR_ORDER,
             "Call SlipConstraintSetComponents() before the first solve");
  PetscCall(VecDestroy(&con->cells));
  con->components = c;
  if (c == 1) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecGetLocalSize(con->x, &n));
  if (cells) PetscCall(VecGetLocalSize(cells, &m));
  PetscCheck(cells && n == c * m, PETSC_COMM_SELF, PETSC_ERR_ARG_SIZ,
             "The reduced vectors have %" PetscInt_FMT " numbers here, expected %" PetscInt_FMT
             " for each of %" PetscInt_FMT " cells",
             n, c, m);
  PetscCall(VecDuplicate(cells, &con->cells));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets how many numbers a cell has in reduced vectors. */
PetscErrorCode SlipConstraintGetComponents(SlipConstraint con, PetscInt *c)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(con, SLIP_CONSTRAINT_CLASSID, 1);
  PetscAssertPointer(c, 2);
  *c = con->components;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets the problem's operations for TSBATHE, and checks that none is missing that a time step needs. */
PetscErrorCode SlipConstraintGetOps(SlipConstraint con, const SlipConstraintOps **ops)
{
  PetscFunctionBegin;
  PetscCheck(
    con->ops->stage && con->ops->reduce && con->ops->lift && con->ops->smooth && con->ops->add_reaction &&
      con->ops->solve_mass && con->ops->bound_state,
    PetscObjectComm((PetscObject)con), PETSC_ERR_ARG_WRONG,
    "TSBATHE needs every operation of SlipConstraintOps: stage, reduce, lift, smooth, add_reaction, solve_mass "
    "and bound_state are not all set");
  *ops = con->ops;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates a zero vector with the layout of the reduced unknowns. */
PetscErrorCode SlipConstraintCreateReduced(SlipConstraint con, Vec *x)
{
  PetscFunctionBegin;
  PetscCall(VecDuplicate(con->x, x));
  PetscCall(VecZeroEntries(*x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipConstraintInitialReaction - computes the reaction at the start of a run

  Collective

  Input Parameters:
+ con - the constraint, with the operations smooth, reduce, add_reaction, bound_state
. t   - the time [s]
- w   - the full state

  Output Parameter:
. r - reduced: the static balance -F_s projected on |r| <= q where x = 0, -q x / |x| where x != 0; the pressure of cells
      with three components is also that of balance, where it is positive and q is not 0

  Level: intermediate

  Errors: PETSC_ERR_ARG_WRONG when the problem has no operation smooth, reduce or bound_state

.seealso: SlipConstraintCreate(), TSBatheSetInitialReaction()
@*/
PetscErrorCode SlipConstraintInitialReaction(SlipConstraint con, PetscReal t, Vec w, Vec r)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(con, SLIP_CONSTRAINT_CLASSID, 1);
  PetscCheck(con->ops->smooth, PetscObjectComm((PetscObject)con), PETSC_ERR_ARG_WRONG,
             "SlipConstraintOps must supply smooth, reduce and bound_state");
  if (!con->w) PetscCall(VecDuplicate(w, &con->w));
  PetscCall((*con->ops->smooth)(con, t, w, con->w, con->ctx));
  PetscCall(SlipConstraintReactionOf(con, t, w, con->w, r));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the reaction as SlipConstraintInitialReaction() does, from a given F_s. con: the constraint, with the
   operations reduce and bound_state; t: the time [s]; r: reduced, as of SlipConstraintInitialReaction(). Errors:
   PETSC_ERR_ARG_WRONG when the problem has no operation reduce or bound_state. */
PetscErrorCode SlipConstraintReactionOf(SlipConstraint con, PetscReal t, Vec w, Vec Fs, Vec r)
{
  const PetscInt c = con->components;
  PetscInt n;
  const PetscScalar *x, *q, *f;
  PetscScalar *rr;

  PetscFunctionBegin;
  PetscValidHeaderSpecific(con, SLIP_CONSTRAINT_CLASSID, 1);
  PetscCheck(con->ops->reduce && con->ops->bound_state, PetscObjectComm((PetscObject)con), PETSC_ERR_ARG_WRONG,
             "SlipConstraintOps must supply smooth, reduce and bound_state");
  PetscCall(SlipConstraintSetUpWork(con));
  PetscCall((*con->ops->reduce)(con, Fs, con->g, con->ctx)); /* the reduced rows of F_s are those that r enters */
  PetscCall((*con->ops->reduce)(con, w, con->x, con->ctx));
  PetscCall((*con->ops->bound_state)(con, t, w, con->q, con->ctx));
  PetscCall(VecGetLocalSize(con->q, &n));
  if (!con->cells) {
    PetscCall(SlipLoopRun(SLIP_LOOP_CONE_REACTION, n, NULL, (const Vec[]){con->x, con->q, con->g, r}, NULL));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(VecGetArrayRead(con->x, &x));
  PetscCall(VecGetArrayRead(con->q, &q));
  PetscCall(VecGetArrayRead(con->g, &f));
  PetscCall(VecGetArrayWrite(r, &rr));
  for (PetscInt i = 0; i < n; i++) {
    const PetscReal g[] = {-f[c * i], -f[c * i + 1]};

    SlipDiskReaction(1.0, &x[c * i], g, q[i], &rr[c * i]);
    if (c == 3) rr[c * i + 2] = q[i] > 0 ? PetscMax(-f[c * i + 2], 0) : 0;
  }
  PetscCall(VecRestoreArrayWrite(r, &rr));
  PetscCall(VecRestoreArrayRead(con->g, &f));
  PetscCall(VecRestoreArrayRead(con->q, &q));
  PetscCall(VecRestoreArrayRead(con->x, &x));
  PetscFunctionReturn(PETSC_SUCCESS);
}
