/* Computes slip rates at which friction, elasticity and radiation damping balance, for faults whose cells always slide,
   as with rate-and-state friction, and for those whose cells stick while friction holds them. Without inertia the slip
   rate is a function of displacement and state,

      T - K u - eta (v - v_inf) = sigma mu(s, |v|) sign(v),   du/dt = v - v_inf,   ds/dt of the law,

   with v/|v| for sign(v) where slip has two components: v is then along T - K u + eta v_inf, and |v| follows from its
   magnitude; or v = 0 where |T - K u + eta v_inf| does not exceed sigma mu(s, 0). It is an explicit problem in (u, s)
   with one product with K for each right-hand side, and one with Kn where slip changes sigma. The component v of the
   state vector has no rate of its own: after a step it is set to that of the balance, for all readers. */
#include <slipstep/private/slipfault.h>
#include <slipstep/private/slipfaultregional.h>
#include <slipstep/private/slipsys.h>
#include <math.h>
#include <slipstep/private/slipwork.h>

/* Slip rate over the loading rate of cells that weaken, at the default start: a stress that is 7 a sigma below the
   steady one, about what an event leaves, so that the start is forgotten before cells reach their strength */
#define START_LOCKED 1e-3

/* ---- set-up ---- */

/* Gets the user's choice, or the given one in place of "auto". */
static PetscErrorCode Choose(SlipFault fault, SlipFaultStringId id, const char otherwise[], const char **choice)
{
  PetscBool automatic;

  PetscFunctionBegin;
  PetscCall(PetscStrcmp(fault->options.text[id], "auto", &automatic));
  *choice = automatic ? otherwise : fault->options.text[id];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Inertia is a lumped mass, not waves: radiation damping alone describes better what a rupture passes through. It is
   the default where all cells slide at once, as from the critical start, where strength falls with the slip rate, which
   has no balance without inertia, and where no viscosity limits slip rates. Waves contain all inertia. */
static PetscErrorCode ChooseInertia(SlipFault fault, PetscBool traction)
{
  PetscBool none;

  PetscFunctionBegin;
  PetscCall(PetscStrcmp(fault->options.text[FAULT_VISCOSITY], "none", &none));
  fault->kind.inertia = fault->options.inertia;
  if (fault->options.inertia_given) PetscFunctionReturn(PETSC_SUCCESS);
  fault->kind.inertia =
    fault->friction.law->always_slides || fault->kind.waves || (traction && !fault->friction.law->by_rate && !none)
      ? PETSC_FALSE
      : PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prints a line before the run where -fault_inertia yes has changed the default of another option. */
PetscErrorCode SlipFaultViscosityPrint(SlipFault fault)
{
  const char *prefix = SlipFaultPrefix(fault);
  PetscBool automatic, sqrtm, traction;

  PetscFunctionBegin;
  PetscCall(PetscStrcmp(fault->options.text[FAULT_VISCOSITY], "auto", &automatic));
  PetscCall(PetscStrcmp(fault->kind.viscosity, "sqrtm", &sqrtm));
  PetscCall(PetscStrcmp(fault->kind.initial, "traction", &traction));
  if (!fault->options.progress || !automatic || !sqrtm || !traction || fault->friction.law->by_rate)
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscPrintf(
    fault->comm,
    "%-24s sqrtm, the default with -%sfault_inertia yes, which does not limit how fast ruptures run; without "
    "inertia it is radiation (-%sfault_viscosity)\n",
    "viscosity:", prefix, prefix));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ChooseStateLaw(SlipFault fault)
{
  static const char *const names[] = {[SLIP_STATE_AGING] = "aging",
                                      [SLIP_STATE_SLIP] = "slip",
                                      [SLIP_STATE_COMPOSITE] = "composite",
                                      [SLIP_STATE_PRZ] = "prz"};

  PetscFunctionBegin;
  for (int k = 0; k < (int)PETSC_STATIC_ARRAY_LENGTH(names); k++) {
    PetscBool same;

    PetscCall(PetscStrcmp(fault->options.text[FAULT_STATE_LAW], names[k], &same));
    if (same) fault->friction.state_law = (SlipStateLaw)k;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Chooses what "auto" means for the law and the start, and whether there is inertia. */
PetscErrorCode SlipFaultChooseDefaults(SlipFault fault)
{
  PetscBool traction;

  PetscFunctionBegin;
  PetscCall(Choose(fault, FAULT_INITIAL,
                   SlipFaultHasRegional(fault)          ? "traction"
                   : fault->friction.law->always_slides ? "rate"
                                                        : "critical",
                   &fault->kind.initial));
  PetscCall(PetscStrcmp(fault->kind.initial, "traction", &traction));
  PetscCall(PetscStrcmp(fault->options.text[FAULT_MEDIUM], SLIPELASTICWAVES, &fault->kind.waves));
  PetscCall(ChooseInertia(fault, traction));
  PetscCall(Choose(fault, FAULT_VISCOSITY,
                   fault->friction.law->always_slides || (traction && !fault->kind.inertia) ? "radiation" : "sqrtm",
                   &fault->kind.viscosity));
  PetscCall(ChooseStateLaw(fault));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscBool Creeps(SlipFault fault, PetscInt i)
{
  return fault->balance.creeps && fault->balance.creeps[i] ? PETSC_TRUE : PETSC_FALSE;
}

static PetscErrorCode FindCreep(SlipFault fault)
{
  PetscInt any = 0;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < fault->mesh.n; i++) any |= fault->fields.cell[FIELD_CREEP][i] != 0;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &any, 1, MPIU_INT, MPI_MAX, fault->comm));
  if (!any) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(PetscMax(fault->mesh.n, 1), &fault->balance.creeps));
  for (PetscInt i = 0; i < fault->mesh.n; i++)
    fault->balance.creeps[i] = fault->fields.cell[FIELD_CREEP][i] != 0 ? PETSC_TRUE : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns whether steady slip at this rate is unstable in sufficiently soft surroundings. */
PetscBool SlipFaultRateWeakens(const SlipFrictionCells *friction, PetscInt i, PetscReal rate)
{
  PetscReal fall, critical;

  if (rate == 0) return PETSC_FALSE;
  SlipFrictionWeakening(friction, i, PetscAbsReal(rate), &fall, &critical);
  return critical > 0 ? PETSC_TRUE : PETSC_FALSE;
}

/* Gets the states of cell i at the start; the fields have them in users' units. */
static void StartStates(SlipFault fault, const SlipFrictionCells *friction, PetscInt i, PetscReal s[])
{
  for (PetscInt k = 0; k < fault->layout.states; k++)
    s[k] = SlipFrictionOfShown(friction, i, k, fault->friction.start[k][i]);
}

/* Makes the states of cell i that were not given steady at a rate; where mu is not NULL, the first of them follows from
   the friction mu. Returns false where a state is not finite. */
static PetscBool FillStates(SlipFault fault, const SlipFrictionCells *friction, PetscInt i, PetscReal rate,
                            const PetscReal *mu)
{
  PetscReal **start = fault->friction.start, s[SLIP_MAX_STATES];
  PetscInt first = -1;
  PetscBool good = PETSC_TRUE;

  SlipFrictionSteady(friction, i, rate, s);
  for (PetscInt k = fault->layout.states - 1; k >= 0; k--)
    if (isnan(start[k][i]))
      first = k;
    else
      s[k] = SlipFrictionOfShown(friction, i, k, start[k][i]);
  if (first < 0) return PETSC_TRUE;
  if (mu) SlipFrictionStateOf(friction, i, first, *mu, rate, s);
  for (PetscInt k = 0; k < fault->layout.states; k++) {
    if (isnan(start[k][i])) start[k][i] = SlipFrictionShown(friction, i, k, s[k]);
    if (!isfinite(start[k][i])) good = PETSC_FALSE;
  }
  return good;
}

/* Returns whether all states of cell i are given. */
static PetscBool KnowsStates(SlipFault fault, PetscInt i)
{
  for (PetscInt k = 0; k < fault->layout.states; k++)
    if (isnan(fault->friction.start[k][i])) return PETSC_FALSE;
  return PETSC_TRUE;
}

/* Fills in the rate and state that were not given, as far as they do not need the stress. The fields contain theta. All
   cells at the loading rate in the steady state would be an equilibrium, unstable where cells weaken, which only
   rounding leaves: unless a rate is given, cells that weaken begin locked, as some time after an event. */
static PetscErrorCode FillStart(SlipFault fault, const SlipFrictionCells *friction, PetscBool traction)
{
  PetscReal *rate = fault->fields.cell[FIELD_INITIAL_RATE];
  const PetscReal *vinf = fault->fields.cell[FIELD_LOADING_RATE], *load = fault->fields.cell[FIELD_INITIAL_TRACTION];
  const char *prefix = SlipFaultPrefix(fault);
  PetscInt bad = 0, bare = 0; /* cells whose state would follow from a traction of 0, which no friction has */

  PetscFunctionBegin;
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    const PetscReal steady = PetscAbsReal(vinf[i]) > 0 ? vinf[i] : rate[i];
    const PetscReal all = load[i] + SlipLoadsStartShear(&fault->loads, i);

    if (isnan(rate[i])) {
      rate[i] = vinf[i];
      if (!traction && !Creeps(fault, i) && SlipFaultRateWeakens(friction, i, vinf[i])) rate[i] *= START_LOCKED;
    }
    if (KnowsStates(fault, i)) continue;
    if (traction && all == 0)
      bare++;
    else {
      const PetscReal mu = PetscAbsReal(all) / friction->stress[i];

      if (!FillStates(fault, friction, i, traction ? rate[i] : steady, traction ? &mu : NULL)) bad = 1;
    }
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &bare, 1, MPIU_INT, MPI_SUM, fault->comm));
  PetscCheck(!bare, fault->comm, PETSC_ERR_ARG_INCOMP,
             "-%sfault_initial traction with -%sfault_friction_law %s needs -%sfault_initial_traction (or a field "
             "initial_traction) other than 0, or -%sfault_%s: the traction is 0 in %" PetscInt_FMT " of %" PetscInt_FMT
             " cells",
             prefix, prefix, fault->friction.law->name, prefix, prefix, fault->friction.law->states[0].start, bare,
             fault->mesh.N);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &bad, 1, MPIU_INT, MPI_MAX, fault->comm));
  PetscCheck(!bad, fault->comm, PETSC_ERR_ARG_INCOMP,
             "the state of -%sfault_friction_law %s at the start is not known: expected -%sfault_%s, or "
             "-%sfault_initial_rate or -%sfault_loading_rate other than 0",
             prefix, fault->friction.law->name, prefix, fault->friction.law->states[0].start, prefix, prefix);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets T0 = sigma mu + H (v - v_inf), less the terms of the load, which balances the start, along the rake. */
static PetscErrorCode FillTraction(SlipFault fault, const SlipFrictionCells *friction)
{
  const PetscReal *rate = fault->fields.cell[FIELD_INITIAL_RATE], *vinf = fault->fields.cell[FIELD_LOADING_RATE], *f;
  Vec relative, force;
  PetscReal *x;

  PetscFunctionBegin;
  PetscCall(SlipFaultGetWork(fault, &relative));
  PetscCall(SlipFaultGetWork(fault, &force));
  PetscCall(PetscMalloc1(fault->mesh.n + 1, &x));
  for (PetscInt i = 0; i < fault->mesh.n; i++) x[i] = Creeps(fault, i) ? 0 : rate[i] - vinf[i];
  PetscCall(SlipFaultFillAlong(fault, x, PETSC_FALSE, relative));
  PetscCall(PetscFree(x));
  PetscCall(SlipElasticForce(fault->medium, 0, NULL, relative, force, NULL));
  PetscCall(VecGetArrayRead(force, &f));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    PetscReal s[SLIP_MAX_STATES], mu, ds, dv;

    StartStates(fault, friction, i, s);
    SlipFrictionEvaluate(friction, i, s, PetscAbsReal(rate[i]), &mu, &ds, &dv);
    fault->fields.cell[FIELD_INITIAL_TRACTION][i] =
      (rate[i] < 0 ? -mu : mu) * friction->stress[i] +
      SlipFaultDot(fault, f + fault->layout.components * i, SlipFaultAlong(fault, i)) / fault->mesh.weight[i];
    if (fault->loads.nterms) fault->fields.cell[FIELD_INITIAL_TRACTION][i] -= SlipLoadsStartShear(&fault->loads, i);
  }
  fault->fields.source[FIELD_INITIAL_TRACTION] = "-fault_initial rate";
  PetscCall(VecRestoreArrayRead(force, &f));
  PetscCall(SlipFaultRestoreWork(fault, &force));
  PetscCall(SlipFaultRestoreWork(fault, &relative));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates the vectors that right-hand sides fill. */
static PetscErrorCode CreateRoom(SlipFault fault)
{
  Vec *vecs[] = {&fault->balance.u, &fault->balance.rate, &fault->balance.force};

  PetscFunctionBegin;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(vecs); k++)
    if (!*vecs[k]) PetscCall(VecDuplicate(fault->critical.uc, vecs[k]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets up the start, and what right-hand sides need; after the operators are set up. */
PetscErrorCode SlipFaultBalanceSetUp(SlipFault fault)
{
  SlipFaultBalance *b = &fault->balance;
  SlipFrictionCells friction;
  PetscBool traction;

  PetscFunctionBegin;
  PetscCall(FindCreep(fault));
  PetscCall(SlipElasticGetImpedance(fault->medium, &b->eta));
  if (!fault->friction.law->always_slides) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(CreateRoom(fault));
  for (PetscInt k = 0; k < fault->layout.states; k++)
    fault->friction.start[k] = fault->fields.cell[SlipFaultFindField(fault->friction.law->states[k].start)];
  PetscCall(PetscStrcmp(fault->kind.initial, "traction", &traction));
  PetscCall(SlipFaultGetFriction(fault, 0, &friction));
  PetscCall(FillStart(fault, &friction, traction));
  if (!traction) PetscCall(FillTraction(fault, &friction));
  PetscCall(SlipLoadDestroy(&fault->known.load)); /* the initial traction has changed */
  PetscCall(SlipFaultGetFriction(fault, 0, &friction));
  if (b->eta > 0 && friction.law->keep && !fault->loads.pressed && !SlipFaultNormalFollows(fault)) {
    PetscCall(PetscMalloc1(friction.law->nkept * fault->mesh.n + 1, &b->kept));
    friction.law->keep(&friction, fault->mesh.n, b->eta, b->kept);
    PetscCall(PetscMalloc1(fault->mesh.n + 1, &b->direct));
    for (PetscInt i = 0; i < fault->mesh.n; i++) b->direct[i] = SlipFrictionDirect(&friction, i) * friction.stress[i];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultBalanceDestroy(SlipFault fault)
{
  SlipFaultBalance *b = &fault->balance;

  PetscFunctionBegin;
  PetscCall(VecDestroy(&b->u));
  PetscCall(VecDestroy(&b->rate));
  PetscCall(VecDestroy(&b->force));
  PetscCall(VecDestroy(&b->first));
  PetscCall(VecDestroy(&b->seen));
  for (PetscInt k = 0; k < 4; k++) PetscCall(VecDestroy(&b->aside[k]));
  PetscCall(VecDestroy(&b->rested));
  PetscCall(VecDestroy(&b->way));
  PetscCall(PetscFree(b->creeps));
  PetscCall(PetscFree(b->kept));
  PetscCall(PetscFree(b->direct));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- slip rates ---- */

/* Finds rates of two components from the stress tau that friction and radiation damping balance: v is along tau, and
   |v| follows from its magnitude. The rates of u and s go into f, unless that is NULL. */
static void BalanceVectors(SlipFault fault, const SlipFrictionCells *friction, const PetscReal tau[],
                           const PetscReal a[], PetscReal v[], PetscReal f[])
{
  const SlipFaultLayout *layout = &fault->layout;
  PetscReal *size = layout->sizes, *speed = layout->sizes + fault->mesh.n;

  for (PetscInt i = 0; i < fault->mesh.n; i++) size[i] = SlipFaultLength(fault, tau + 2 * i);
  SlipFrictionBalance(friction, fault->balance.kept, fault->mesh.n, fault->balance.eta, size, layout->block,
                      a + layout->state, speed, f ? f + layout->state : NULL);
  for (PetscInt i = 0; i < fault->mesh.n; i++)
    for (PetscInt k = 0; k < 2; k++) v[2 * i + k] = size[i] > 0 ? speed[i] * (tau[2 * i + k] / size[i]) : 0;
}

/* Computes the shear stress that friction and radiation damping balance, for each component and cell; shear NULL: no
   load. */
static void StressToBalance(SlipFault fault, const PetscReal *restrict shear, const PetscReal *restrict force,
                            const PetscReal *restrict vinf, PetscReal *restrict tau)
{
  const PetscReal *weight = fault->mesh.weight, eta = fault->balance.eta;
  const PetscInt c = fault->layout.components, n = c * fault->mesh.n;

  if (!shear)
    for (PetscInt i = 0; i < n; i++) tau[i] = eta * weight[i / c] * vinf[i] - force[i];
  else if (c == 1)
    for (PetscInt i = 0; i < n; i++) tau[i] = shear[i] - force[i] + eta * weight[i] * vinf[i];
  else
    for (PetscInt i = 0; i < n; i++) tau[i] = shear[i] - force[i] + eta * weight[i / c] * vinf[i];
}

/* Writes the rates of displacements into the rates f of a state, and 0 for those of slip rates. */
static void RatesOfDisplacement(SlipFault fault, const PetscReal *restrict v, const PetscReal *restrict vinf,
                                PetscReal *restrict f)
{
  const PetscInt c = fault->layout.components, block = fault->layout.block, n = fault->mesh.n;
  PetscReal *restrict rate = f + fault->layout.rate, *restrict displacement = f + fault->layout.displacement;

  for (PetscInt k = 0; k < c; k++)
    for (PetscInt i = 0; i < n; i++) {
      rate[block * i + k] = 0;
      displacement[block * i + k] = v[c * i + k] - vinf[c * i + k];
    }
}

/* Computes b->rate from b->force, and the rates F unless that is NULL. */
PetscErrorCode SlipFaultHostRates(SlipFault fault, PetscReal t, Vec w, Vec F)
{
  SlipFaultBalance *b = &fault->balance;
  const PetscInt c = fault->layout.components;
  const PetscReal *a, *force, *shear = NULL, *vinf;
  PetscReal *tau, *v, *f = NULL;
  SlipFrictionCells friction;
  const SlipFaultLoad *load;
  Vec stress;

  PetscFunctionBegin;
  PetscCall(SlipFaultGetLoad(fault, t, &load));
  if (SlipFaultNormalFollows(fault)) {
    PetscCall(SlipFaultCoupledFriction(fault, t, 0, &friction));
    fault->coupling.balanced = fault->kind.coupled;
  } else {
    PetscCall(SlipFaultGetFriction(fault, t, &friction));
  }
  PetscCall(SlipFaultGetWork(fault, &stress));
  const SlipArrays arrays[] = {{w, .read = &a},
                               {b->force, .read = &force},
                               {fault->operators.vinf, .read = &vinf},
                               {b->rate, .write = &v},
                               {F, .write = &f}};

  PetscCall(SlipArraysGet(F ? 5 : 4, arrays));
  PetscCall(VecGetArrayWrite(stress, &tau));
  if (load->shear) PetscCall(VecGetArrayRead(load->shear, &shear));
  StressToBalance(fault, shear, force, vinf, tau);
  if (fault->zone.presses) PetscCall(SlipFaultZoneOfBalance(fault, t, a, tau, fault->coupling.stress));
  if (c == 2)
    BalanceVectors(fault, &friction, tau, a, v, f);
  else
    SlipFrictionBalance(&friction, b->kept, fault->mesh.n, b->eta, tau, fault->layout.block, a + fault->layout.state, v,
                        f ? f + fault->layout.state : NULL);
  for (PetscInt i = 0; i < fault->mesh.n && b->creeps; i++) {
    if (!b->creeps[i]) continue;
    for (PetscInt k = c * i; k < c * (i + 1); k++) v[k] = vinf[k];
    for (PetscInt k = 0; k < fault->layout.states && f; k++) f[SlipFaultStateAt(fault, i) + k] = 0;
  }
  if (f) RatesOfDisplacement(fault, v, vinf, f);
  if (load->shear) PetscCall(VecRestoreArrayRead(load->shear, &shear));
  PetscCall(VecRestoreArrayWrite(stress, &tau));
  PetscCall(SlipArraysRestore(F ? 5 : 4, arrays));
  PetscCall(SlipFaultRestoreWork(fault, &stress));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes b->rate for the state w at t, and the rates F of the state unless F is NULL. */
PetscErrorCode SlipFaultRates(SlipFault fault, PetscReal t, Vec w, Vec F)
{
  SlipFaultBalance *b = &fault->balance;

  PetscFunctionBegin;
  b->time = t;
  b->known = PETSC_TRUE;
  PetscCall(CreateRoom(fault));
  PetscCall(SlipFaultGetDisplacement(fault, w, b->u));
  PetscCall(
    SlipElasticForce(fault->medium, t, b->u, NULL, b->force, fault->kind.coupled ? fault->coupling.rise : NULL));
  PetscCall(PetscLogEventBegin(SLIP_Cells, 0, 0, 0, 0));
  SlipWorkAdd(SLIP_WORK_RATE, 1);
  SlipWorkAdd(fault->friction.law->always_slides ? SLIP_WORK_BALANCE : SLIP_WORK_STRENGTH,
              (PetscReal)(fault->mesh.n * fault->layout.components));
  PetscCall((*fault->cell_ops->rates)(fault, t, w, F));
  PetscCall(PetscLogEventEnd(SLIP_Cells, 0, 0, 0, 0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Puts b->rate into the state w. */
PetscErrorCode SlipFaultPutRates(SlipFault fault, Vec w)
{
  PetscFunctionBegin;
  fault->balance.put++;
  PetscCall(SlipFaultMove(fault, fault->layout.rate, PETSC_TRUE, w, fault->balance.rate));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Fills w with the start. */
PetscErrorCode SlipFaultBalanceStart(SlipFault fault, Vec w)
{
  const PetscReal *rate = fault->fields.cell[FIELD_INITIAL_RATE], *vinf = fault->fields.cell[FIELD_LOADING_RATE];
  SlipFrictionCells friction;
  PetscReal *a;

  PetscFunctionBegin;
  PetscCall(SlipFaultGetFriction(fault, 0, &friction)); /* slip has changed nothing yet */
  PetscCall(VecGetArray(w, &a));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    for (PetscInt k = 0; k < fault->layout.components; k++)
      a[SlipFaultRateAt(fault, i) + k] = (Creeps(fault, i) ? vinf[i] : rate[i]) * SlipFaultAlong(fault, i)[k];
    StartStates(fault, &friction, i, a + SlipFaultStateAt(fault, i));
  }
  PetscCall(VecRestoreArray(w, &a));
  if (fault->kind.inertia || fault->balance.eta == 0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipFaultRates(fault, 0, w, NULL)); /* "traction" with a given state has another rate */
  PetscCall(SlipFaultPutRates(fault, w));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the friction of a state in the form of the reaction of other laws. */
PetscErrorCode SlipFaultSmoothTraction(SlipFault fault, PetscReal t, Vec w, Vec r)
{
  const PetscReal *a;
  PetscReal *q;

  PetscFunctionBegin;
  if (fault->layout.components == 2) {
    const PetscReal *strength;

    PetscCall(SlipFaultStrength(fault, t, w, fault->cells));
    PetscCall(VecGetArrayRead(fault->cells, &strength));
    PetscCall(VecGetArrayRead(w, &a));
    PetscCall(VecGetArrayWrite(r, &q));
    for (PetscInt i = 0; i < fault->mesh.n; i++) {
      const PetscReal speed = SlipFaultSpeed(fault, a, i);

      for (PetscInt k = 0; k < 2; k++)
        q[2 * i + k] = speed > 0 ? -strength[i] * (a[SlipFaultRateAt(fault, i) + k] / speed) : 0;
    }
    PetscCall(VecRestoreArrayWrite(r, &q));
    PetscCall(VecRestoreArrayRead(w, &a));
    PetscCall(VecRestoreArrayRead(fault->cells, &strength));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(SlipFaultStrength(fault, t, w, r));
  PetscCall(VecGetArrayRead(w, &a));
  PetscCall(VecGetArray(r, &q));
  for (PetscInt i = 0; i < fault->mesh.n; i++) q[i] *= a[SlipFaultRateAt(fault, i)] > 0 ? -1 : 1;
  PetscCall(VecRestoreArray(r, &q));
  PetscCall(VecRestoreArrayRead(w, &a));
  PetscFunctionReturn(PETSC_SUCCESS);
}
