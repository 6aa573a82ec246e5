/* How many products with K, H and stage operators there were, and what was done for whom. Counts are plain integers of
   this process; operators are collective, so that all processes count the same. */
#include <slipsys.h>
#include <slipstep/private/slipsys.h>
#include <slipstep/private/slipwork.h>

/* For whom they are made, the last of users now */
#define USERS_MOST 32
static SlipProducts counts[SLIP_PRODUCTS_USERS];
static SlipProductsUser users[USERS_MOST];
static PetscInt last;

SlipProducts SlipProductsRow(SlipProducts *last_row)
{
  const SlipProducts before = *last_row;

  SlipWorkTake();
  *last_row = counts[SLIP_PRODUCTS_RUN];
  return SlipProductsSince(last_row, &before);
}

/* Formed beside MatMult(), or inside of it as one */
void SlipProductsAdd(SlipProducts more)
{
  SlipProductsAddFor(users[last], more);
}

void SlipProductsAddFor(SlipProductsUser user, SlipProducts more)
{
  SlipProducts *c = &counts[user];

  *c = (SlipProducts){c->k + more.k, c->h + more.h, c->pc + more.pc, c->all + more.all, c->cost + more.cost};
}

SlipProductsUser SlipProductsUserNow(void)
{
  return users[last];
}

SlipProducts SlipProductsNow(void)
{
  return counts[users[last]];
}

SlipProducts SlipProductsSince(const SlipProducts *now, const SlipProducts *before)
{
  return (SlipProducts){now->k - before->k, now->h - before->h, now->pc - before->pc, now->all - before->all,
                        now->cost - before->cost};
}

/* Those that follow are made for this user, until it is popped. */
PetscErrorCode SlipProductsPush(SlipProductsUser user)
{
  PetscFunctionBegin;
  PetscCheck(last + 1 < USERS_MOST, PETSC_COMM_SELF, PETSC_ERR_PLIB, "products are made for %d users at once",
             USERS_MOST);
  SlipWorkTake();
  users[++last] = user;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipProductsPop(void)
{
  PetscFunctionBegin;
  PetscCheck(last > 0, PETSC_COMM_SELF, PETSC_ERR_PLIB, "products are made for nobody else");
  SlipWorkTake();
  last--;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A run begins, or nothing does, whatever an error has left. */
void SlipProductsRun(void)
{
  SlipWorkTake();
  last = 0;
  SlipWorkReset();
}

void SlipProductsGetOf(SlipProductsUser of, SlipProducts *products)
{
  SlipWorkTake();
  *products = counts[of];
}

/*@
  SlipProductsGet - products with stiffness and viscosity of this process so far

  Not collective

  Output Parameter:
. products - those with K and H and applications of the preconditioner, but for those of set-up and of output and
             estimates; differences say what something took

  Level: advanced

  Notes:
  `k` are those with K or Kn, those that products with H are made of included, `h` those with a viscosity that is no
  multiple of the identity. A stage operator that forms both at once counts in both. `pc` are applications of
  PCSLIPSTAGE by transforms, which cost about as much. `all` are those with K, and those with H that are not made of
  them, a product with both at once counted once. Solves with the rows of a few cells have none. What a medium of your
  own does in a call of its force counts as one product with K unless it multiplies by matrices of slipmat.h.

  `cost` is the processor time [s] of what was done, without set-up, output and estimates: kinds of work that are
  counted, each at a fixed price. The same run costs the same to the bit, on any machine and whatever else that does.
  On a device it is what the processor would have taken for the same products.

.seealso: SlipAttempt, TSBatheGetLastAttempt()
@*/
PetscErrorCode SlipProductsGet(SlipProducts *products)
{
  PetscFunctionBegin;
  SlipProductsGetOf(SLIP_PRODUCTS_RUN, products);
  PetscFunctionReturn(PETSC_SUCCESS);
}
