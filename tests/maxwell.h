/* A medium that remembers: beside the static stiffness a spring and a dashpot in series on each cell, m' = -m/tau + k
   u', of which it keeps m. Dense. */
#pragma once
#include <slipstep/rooms/slipelastic.h>
#include <math.h>

typedef struct {
  PetscReal tau, k;    /* [s], [Pa/m] */
  PetscReal mass, eta; /* of the balance */
  Vec m[2];            /* of the slots [Pa] */
  Vec now;
  Mat K, B; /* dense */
} Maxwell;

static PetscReal Tau, Stiffness; /* of the next medium */

/* m of the state (t, u) that follows from a slot: u goes there at a constant rate */
static PetscErrorCode Memory(SlipElastic el, PetscInt slot, PetscReal t, Vec u, Vec m)
{
  SlipElasticPast past;
  PetscReal x;
  Maxwell *c;

  PetscCall(SlipElasticGetData(el, &c));
  if (slot < 0) {
    PetscCall(VecZeroEntries(m));
    return PETSC_SUCCESS;
  }
  PetscCall(SlipElasticGetPast(el, slot, &past));
  x = (t - past.t) / c->tau;
  PetscCall(VecWAXPY(c->now, -1, past.u, u));
  PetscCall(VecScale(c->now, c->k * (x > 0 ? -expm1(-x) / x : 1)));
  PetscCall(VecAXPY(c->now, exp(-x), c->m[slot]));
  return VecCopy(c->now, m);
}

static PetscErrorCode SetUp_Maxwell(SlipElastic el, const SlipElasticRock *rock)
{
  Maxwell *c;
  Mat K;

  PetscCall(SlipElasticGetData(el, &c));
  PetscCall(SlipElasticGetMatrices(el, &K, NULL, NULL));
  for (int i = 0; i < 2; i++) PetscCall(MatCreateVecs(K, &c->m[i], NULL));
  PetscCall(MatCreateVecs(K, &c->now, NULL));
  PetscCall(MatConvert(K, MATDENSE, MAT_INITIAL_MATRIX, &c->K));
  PetscCall(MatDuplicate(c->K, MAT_COPY_VALUES, &c->B));
  PetscCall(MatSetOption(c->B, MAT_SYMMETRIC, PETSC_TRUE));
  c->mass = rock->inertia ? rock->mass : 0;
  return SlipElasticGetImpedance(el, &c->eta);
}

static PetscErrorCode Force_Maxwell(SlipElastic el, PetscReal t, Vec u, Vec v, Vec shear, Vec normal)
{
  PetscInt slot;
  Vec m;

  PetscCall(SlipElasticForceStatic(el, t, u, v, shear, normal));
  if (!u || !shear) return PETSC_SUCCESS;
  PetscCall(SlipElasticFindPast(el, t, &slot));
  PetscCall(VecDuplicate(u, &m));
  PetscCall(Memory(el, slot, t, u, m));
  PetscCall(VecAXPY(shear, 1, m));
  return VecDestroy(&m);
}

static PetscErrorCode Stage_Maxwell(SlipElastic el, PetscReal t, PetscReal theta, Mat *B, Mat *C)
{
  SlipElasticPast past;
  PetscInt slot;
  PetscReal x;
  Maxwell *c;

  PetscCall(SlipElasticGetData(el, &c));
  PetscCall(SlipElasticFindPast(el, t, &slot));
  PetscCall(SlipElasticGetPast(el, slot, &past));
  x = (t - past.t) / c->tau;
  PetscCall(MatCopy(c->K, c->B, SAME_NONZERO_PATTERN));
  PetscCall(MatScale(c->B, theta));
  PetscCall(MatShift(c->B, c->mass / theta + c->eta + theta * c->k * (x > 0 ? -expm1(-x) / x : 1)));
  *B = c->B;
  *C = NULL;
  return PETSC_SUCCESS;
}

/* m^2/(2 k) in the place of u m/2, and m^2/(k tau) */
static PetscErrorCode Energy_Maxwell(SlipElastic el, PetscReal t, Vec u, PetscReal *stored)
{
  const PetscReal *a, *b;
  PetscInt slot, n;
  Maxwell *c;
  Vec m;

  PetscCall(SlipElasticGetData(el, &c));
  PetscCall(SlipElasticFindPast(el, t, &slot));
  PetscCall(VecDuplicate(u, &m));
  PetscCall(Memory(el, slot, t, u, m));
  PetscCall(VecGetLocalSize(u, &n));
  a = VecRead(u);
  b = VecRead(m);
  for (PetscInt i = 0; i < n; i++) *stored += b[i] * b[i] / (2 * c->k) - a[i] * b[i] / 2;
  return VecDestroy(&m);
}

static PetscErrorCode Power_Maxwell(SlipElastic el, PetscReal t, Vec u, Vec v, PetscReal *lost)
{
  const PetscReal *a;
  PetscInt slot, n;
  Maxwell *c;
  Vec m;

  PetscCall(SlipElasticGetData(el, &c));
  PetscCall(SlipElasticFindPast(el, t, &slot));
  PetscCall(VecDuplicate(u, &m));
  PetscCall(Memory(el, slot, t, u, m));
  PetscCall(VecGetLocalSize(u, &n));
  a = VecRead(m);
  for (PetscInt i = 0; i < n; i++) *lost += a[i] * a[i] / (c->k * c->tau);
  return VecDestroy(&m);
}

static PetscErrorCode Advance_Maxwell(SlipElastic el, PetscInt from, PetscInt to, PetscReal t, Vec u)
{
  Maxwell *c;

  PetscCall(SlipElasticGetData(el, &c));
  return Memory(el, from, t, u, c->m[to]);
}

static PetscErrorCode Copy_Maxwell(SlipElastic el, PetscInt from, PetscInt to)
{
  Maxwell *c;

  PetscCall(SlipElasticGetData(el, &c));
  return VecCopy(c->m[from], c->m[to]);
}

static PetscErrorCode Visit_Maxwell(SlipElastic el, SlipState state)
{
  Maxwell *c;

  PetscCall(SlipElasticGetData(el, &c));
  PetscCall(SlipStateVec(state, "stress_before", c->m[0]));
  return SlipStateVec(state, "stress", c->m[1]);
}

static PetscErrorCode Destroy_Maxwell(SlipElastic el)
{
  Maxwell *c;

  PetscCall(SlipElasticGetData(el, &c));
  for (int i = 0; i < 2; i++) PetscCall(VecDestroy(&c->m[i]));
  PetscCall(DestroyObjects(&c->now, &c->K, &c->B));
  return PetscFree(c);
}

static PetscErrorCode Create_Maxwell(SlipElastic el)
{
  static const SlipElasticOps ops = {.setup = SetUp_Maxwell,
                                     .force = Force_Maxwell,
                                     .stage = Stage_Maxwell,
                                     .energy = Energy_Maxwell,
                                     .power = Power_Maxwell,
                                     .advance = Advance_Maxwell,
                                     .copy = Copy_Maxwell,
                                     .visit = Visit_Maxwell,
                                     .destroy = Destroy_Maxwell};
  Maxwell *c;

  PetscCall(PetscNew(&c));
  c->tau = Tau;
  c->k = Stiffness;
  return SlipElasticSetOps(el, &ops, c);
}
