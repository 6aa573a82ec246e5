/* Computes the sums over the cells of a state, from which observations and results follow. */
#include <slipstep/private/slipfault.h>
#include <slipstep/private/slipsys.h>
#include <slipcompat.h>

/* ---- cells that always slide, along their rakes ---- */

/* Each addition of one sum waits for the one before it: PLACES cells at a time go into separate sums instead. */
enum { PLACES = 64 };
typedef struct {
  PetscReal of[FAULT_NUM_SUMS][PLACES], largest[PLACES];
} Places;

/* Adds n consecutive cells; q: strength; rate: loading rate. */
SLIP_VECTOR static void AddMotion(PetscInt n, const PetscReal *restrict weight, const PetscReal *restrict rate,
                                  const PetscReal *restrict v, const PetscReal *restrict u, const PetscReal *restrict s,
                                  const PetscReal *restrict force, const PetscReal *restrict q, Places *restrict p)
{
  for (PetscInt i = 0; i < n; i++) {
    const PetscReal speed = PetscAbsReal(v[i]), against = PetscAbsReal(force[i]) - q[i];
    const PetscReal along = v[i] > 0 ? force[i] : -force[i], rests = against > 0 ? against : 0;

    p->of[SUM_V][i] += weight[i] * v[i];
    p->of[SUM_ABS_V][i] += weight[i] * speed;
    p->of[SUM_V2][i] += weight[i] * (v[i] * v[i]);
    p->of[SUM_U][i] += weight[i] * u[i];
    p->of[SUM_S][i] += weight[i] * s[i];
    p->of[SUM_SLIDING][i] += v[i] != 0 ? weight[i] : 0;
    p->of[SUM_U_KU][i] += u[i] * force[i];
    p->of[SUM_V_KU][i] += v[i] * force[i];
    p->of[SUM_VINF_KU][i] += rate[i] * force[i];
    p->of[SUM_VINF][i] += weight[i] * rate[i];
    p->of[SUM_STRENGTH][i] += q[i];
    p->of[SUM_PUSH][i] += v[i] != 0 ? -along - q[i] : rests; /* SlipConePush() */
    p->largest[i] = speed > p->largest[i] ? speed : p->largest[i];
  }
}

/* Adds the work of the shear load: start at the start of the loading, and rise per time t since then. */
SLIP_VECTOR static void AddLoads(PetscInt n, const PetscReal *restrict weight, const PetscReal *restrict rate,
                                 PetscReal t, const PetscReal *restrict start, const PetscReal *restrict rise,
                                 const PetscReal *restrict u, Places *restrict p)
{
  for (PetscInt i = 0; i < n; i++) {
    const PetscReal shear = start[i] + t * rise[i];

    p->of[SUM_U_T][i] += weight[i] * u[i] * shear;
    p->of[SUM_LOADING_T][i] += weight[i] * (rate[i] * shear - u[i] * rise[i]);
  }
}

/* SlipFaultAddUp() for one component of slip and cells that always slide, whose weakest strength is 0. */
static PetscErrorCode AddUpSliding(SlipFault fault, PetscReal t, Vec w, Vec ku, PetscReal sum[], PetscReal *max_v)
{
  const PetscReal *weight = fault->mesh.weight, *rate = fault->fields.cell[FIELD_LOADING_RATE], *a, *f, *r;
  PetscReal v[PLACES], u[PLACES], s[PLACES], q[PLACES];
  Places places;
  Vec traction;

  PetscFunctionBegin;
  PetscCall(PetscMemzero(&places, sizeof(places)));
  PetscCall(SlipFaultStepTraction(fault, t, w, &traction));
  const SlipArrays arrays[] = {{w, .read = &a}, {ku, .read = &f}, {traction, .read = &r}};

  PetscCall(SlipArraysGet(3, arrays));
  for (PetscInt i = 0; i < fault->mesh.n; i += PLACES) {
    const PetscInt n = PetscMin(PLACES, fault->mesh.n - i), block = fault->layout.block;
    const PetscReal *from = a + block * i;

    for (PetscInt k = 0; k < n; k++, from += block) {
      v[k] = from[fault->layout.rate];
      u[k] = from[fault->layout.displacement];
      s[k] = from[fault->layout.state];
      q[k] = v[k] > 0 ? -r[i + k] : r[i + k];
    }
    AddMotion(n, weight + i, rate + i, v, u, s, f + i, q, &places);
    if (fault->loads.shears)
      AddLoads(n, weight + i, rate + i, fault->loads.origin + t, fault->fields.cell[FIELD_INITIAL_TRACTION] + i,
               fault->fields.cell[FIELD_STRESSING_RATE] + i, u, &places);
  }
  PetscCall(SlipArraysRestore(3, arrays));
  for (PetscInt i = 0; i < PLACES; i++) {
    for (PetscInt k = 0; k < FAULT_NUM_SUMS; k++) sum[k] += places.of[k][i];
    *max_v = PetscMax(*max_v, places.largest[i]);
  }
  sum[SUM_WEAKENING] = sum[SUM_STRENGTH];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- sums of any fault ---- */

/* Adds this rank's part of the sums, weighted by area; ku = K u contains the weights already. */
static PetscErrorCode SlipFaultAddUp(SlipFault fault, PetscReal t, Vec w, Vec ku, PetscReal sum[], PetscReal *max_v)
{
  SlipFrictionCells friction;
  const SlipFaultLoad *load;
  const PetscReal *a, *f;
  PetscReal *values;
  const SlipArrays arrays[] = {{w, .read = &a}, {ku, .read = &f}, {fault->cells, .write = &values}};
  PetscBool at_once;

  PetscFunctionBegin;
  PetscCall(SlipFaultGetFrictionOf(fault, t, w, &friction));
  PetscCall(SlipFaultGetLoad(fault, t, &load));
  PetscCall(SlipArraysGet(3, arrays));
  at_once =
    friction.law->values && !friction.law->remembers && fault->layout.components == 1 ? PETSC_TRUE : PETSC_FALSE;
  if (at_once)
    friction.law->values(&friction, fault->mesh.n, fault->layout.block, a + fault->layout.state, fault->layout.block,
                         a + fault->layout.rate, values);
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    const PetscReal *v = a + SlipFaultRateAt(fault, i), *u = a + SlipFaultDisplacementAt(fault, i),
                    *force = f + fault->layout.components * i, *along = SlipFaultAlong(fault, i);
    const PetscReal *s = a + SlipFaultStateAt(fault, i), speed = SlipFaultLength(fault, v),
                    weight = fault->mesh.weight[i];
    const PetscReal weak = SlipFrictionWeakest(&friction, i);
    PetscReal mu, ds, dv, q;

    if (at_once)
      mu = values[i];
    else
      SlipFrictionEvaluate(&friction, i, s, speed, &mu, &ds, &dv);
    sum[SUM_V] += weight * SlipFaultDot(fault, v, along);
    sum[SUM_ABS_V] += weight * speed;
    sum[SUM_V2] += weight * (SlipFaultDot(fault, v, v) + PetscSqr(SlipFaultAcross(fault, v)));
    sum[SUM_U] += weight * SlipFaultDot(fault, u, along);
    sum[SUM_S] += weight * *s;
    sum[SUM_SLIDING] += speed != 0 ? weight : 0;
    sum[SUM_U_KU] += SlipFaultDot(fault, u, force) + SlipFaultAcross(fault, u) * SlipFaultAcross(fault, force);
    sum[SUM_V_KU] += SlipFaultDot(fault, v, force) + SlipFaultAcross(fault, v) * SlipFaultAcross(fault, force);
    sum[SUM_VINF_KU] += fault->fields.cell[FIELD_LOADING_RATE][i] * SlipFaultDot(fault, along, force);
    sum[SUM_VINF] += weight * fault->fields.cell[FIELD_LOADING_RATE][i];
    if (fault->loads.shears) {
      const PetscReal rate = fault->fields.cell[FIELD_STRESSING_RATE][i];
      const PetscReal shear = fault->fields.cell[FIELD_INITIAL_TRACTION][i] + (fault->loads.origin + t) * rate;

      sum[SUM_U_T] += weight * SlipFaultDot(fault, u, along) * shear;
      sum[SUM_LOADING_T] +=
        weight * (fault->fields.cell[FIELD_LOADING_RATE][i] * shear - SlipFaultDot(fault, u, along) * rate);
    }
    if (SlipFaultOpens(fault)) { /* the constant normal stress closes the cell, the pore pressure opens it */
      const PetscReal normal = fault->loads.normal[i];

      sum[SUM_U_T] -= weight * SlipFaultAcross(fault, u) * normal;
      sum[SUM_LOADING_T] += weight * SlipFaultAcross(fault, v) * (normal - load->bare[i]);
    }
    sum[SUM_WEAKENING] += (mu - weak) * (weight * friction.stress[i]);
    q = mu * (weight * friction.stress[i]);
    sum[SUM_STRENGTH] += q;
    sum[SUM_PUSH] +=
      fault->layout.components == 1
        ? SlipConePush(*v, *force, q)
        : SlipConePush(speed, speed > 0 ? SlipFaultDot(fault, v, force) / speed : SlipFaultLength(fault, force), q);
    *max_v = PetscMax(*max_v, speed);
  }
  PetscCall(SlipArraysRestore(3, arrays));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultHostSums(SlipFault fault, PetscReal t, Vec w, Vec force, PetscReal sum[], PetscReal *max_v)
{
  const PetscReal *a;

  PetscFunctionBegin;
  PetscCall(PetscArrayzero(sum, FAULT_NUM_SUMS));
  *max_v = 0;
  if (fault->friction.law->always_slides && fault->layout.components == 1)
    PetscCall(AddUpSliding(fault, t, w, force, sum, max_v));
  else
    PetscCall(SlipFaultAddUp(fault, t, w, force, sum, max_v));
  if (!fault->loads.nterms) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecGetArrayRead(w, &a)); /* the terms' work is that of v (stress.c) */
  sum[SUM_LOADING_T] += SlipLoadsTermsTimes(&fault->loads, t, a, fault->layout.rate, fault->layout.block);
  PetscCall(VecRestoreArrayRead(w, &a));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets the sums of the state w at t; computes them (one product with K, two reductions) when either has changed. */
PetscErrorCode SlipFaultGetSums(SlipFault fault, PetscReal t, Vec w, const SlipFaultSums **sums)
{
  SlipFaultSums *c = &fault->known.sums;
  SlipFaultMoment now;
  PetscReal stored;
  PetscBool same;
  Vec u, force;

  PetscFunctionBegin;
  *sums = c;
  PetscCall(SlipFaultStateUnchanged(fault, t, w, &c->moment, &now, &same));
  if (same) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipFaultGetWork(fault, &u));
  PetscCall(SlipFaultGetWork(fault, &force));
  PetscCall(SlipFaultForce(fault, t, w, u, force));
  PetscCall(SlipElasticGetEnergy(fault->medium, t, u, &stored));
  PetscCall((*fault->cell_ops->sums)(fault, t, w, force, c->sum, &c->max_v));
  PetscCall(SlipFaultRestoreWork(fault, &force));
  PetscCall(SlipFaultRestoreWork(fault, &u));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, c->sum, FAULT_NUM_SUMS, MPIU_REAL, MPIU_SUM, fault->comm));
  c->sum[SUM_U_KU] += 2 * stored;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &c->max_v, 1, MPIU_REAL, MPIU_MAX, fault->comm));
  c->moment = now;
  PetscFunctionReturn(PETSC_SUCCESS);
}
