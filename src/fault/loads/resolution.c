/* Checks whether cells resolve a rupture. Where friction weakens it sets lengths, and cells must be smaller: else the
   mesh decides the result, and a cell can fail without its neighbours. W [Pa/m] is the fall of strength per metre of
   slip, K_c [Pa/m] the stiffness below which slip is unstable, and G the shear modulus, which for antiplane slip makes
   shorter lengths than G/(1 - nu) for inplane slip:
     rate and state    cohesive zone L_b = G/W, W = b sigma/d_c (Rubin & Ampuero 2005); K_c = sigma (b - a)/d_c (Ruina
                       1983), nucleation h* = (2/pi) G/K_c (Rice 1993)
     strong weakening  the same K_c, of slow slip. At the constant rate of a rupture friction falls exponentially over
                       d_c, from its peak to its steady value there (strongweakening.c): the zone is that of slip
                       weakening, W = (f_peak - f_steady) sigma/d_c
     slip weakening    cohesive zone (9 pi/32) G/W (Day et al. 2005), W = K_c = -dq/ds at the start, dmu sigma/d_c;
                       nucleation 1.158 G/W (Uenishi & Rice 2003)
     rate weakening    no cohesive zone: strength falls at once. Motion runs away where damping is lost, d = dq/d|v| + H
                       < 0, and K < K_c = d^2/(4 M) (runaway.c); nucleation (2/pi) G/K_c

   Pressure in a shear zone adds what slip too fast for diffusion has, f^2 sigma Lambda/(rho c sqrt(2 pi) w), to W of a
   cohesive zone (Rice 2006), and nothing to slow slip.

   A cell can fail alone where its own stiffness K_ii is below K_c. */
#include <slipstep/private/slipfault.h>
#include <slipstep/private/slipsys.h>
#include <slipstep/rooms/slipsys.h>
#include <stdio.h>

/* Cells that a cohesive zone must have: Day et al. (2005) for ruptures, and Jiang et al. (2022) for cycles */
#define CELLS_OF_ZONE 3
#define CELLS_OF_NUCLEATION 1
#define SLIP_ZONE (9 * PETSC_PI / 32)

/* Finds by how much pressure makes strength fall with fast slip, over the normal stress [1/m], for friction f. */
static PetscReal Pressurised(SlipFault fault, PetscInt i, PetscReal f)
{
  const PetscReal *value = fault->options.value, w = value[FAULT_SHEAR_ZONE_WIDTH];

  return w > 0 ? f * f * fault->fields.cell[FIELD_THERMAL_PRESSURISATION][i] /
                   (value[FAULT_HEAT_CAPACITY] * PetscSqrtReal(2 * PETSC_PI) * w)
               : 0;
}

/* Finds the lengths [m] that a cell's friction sets, of its cohesive zone (0: none) and of nucleation, and K_c [Pa/m].
   Returns false where it does not weaken. damping: H of the cell [Pa s/m] */
static PetscBool Lengths(SlipFault fault, const SlipFrictionCells *friction, PetscInt i, PetscReal damping,
                         PetscReal length[2], PetscReal *critical)
{
  const PetscReal G = fault->options.value[FAULT_SHEAR_MODULUS], sigma = fault->fields.cell[FIELD_NORMAL_STRESS][i];
  PetscReal mu, ds, dv, rate;

  if (fault->friction.law->nstates) {
    rate = PetscAbsReal(fault->fields.cell[FIELD_LOADING_RATE][i]);
    if (rate == 0) rate = fault->options.value[FAULT_FRICTION_REFERENCE_RATE];
    SlipFrictionWeakening(friction, i, rate, &ds, critical);
    *critical *= sigma;
    if (ds > 0) ds += Pressurised(fault, i, fault->fields.cell[FIELD_FRICTION_REFERENCE][i]);
    length[0] = ds > 0 ? (fault->friction.law->rupture ? SLIP_ZONE : 1) * G / (ds * sigma) : 0;
    length[1] = 2 / PETSC_PI * G / *critical;
    return *critical > 0 ? PETSC_TRUE : PETSC_FALSE;
  }
  SlipFrictionEvaluate(friction, i, NULL, 0, &mu, &ds, &dv);
  if (fault->friction.law->by_rate) {
    const PetscReal loss = dv * sigma + damping;

    length[0] = 0;
    *critical = loss < 0 && fault->kind.inertia ? loss * loss / (4 * fault->operators.mass) : 0;
    length[1] = 2 / PETSC_PI * G / *critical;
    return *critical > 0 ? PETSC_TRUE : PETSC_FALSE;
  }
  *critical = -ds * sigma;
  length[0] = SLIP_ZONE * G / (*critical + Pressurised(fault, i, mu) * sigma);
  length[1] = 1.158 * G / *critical;
  return *critical > 0 ? PETSC_TRUE : PETSC_FALSE;
}

/* Returns the longer side of a cell. A side along which a grid has no other cell does not count, as antiplane faults
   have cells of 10,000 km along strike. */
static PetscReal Extent(SlipFault fault, PetscInt i)
{
  const SlipFaultMesh *mesh = &fault->mesh;
  SlipFaultCell cell;

  mesh->kind->cell(mesh, SlipFaultMeshRow(mesh, i), &cell);
  if (mesh->ndim == 2 && mesh->dims[1] == 1) return cell.size[1];
  if (mesh->ndim == 2 && mesh->dims[0] == 1) return cell.size[0];
  return PetscMax(cell.size[0], cell.size[1]);
}

/* Sets up the resolution; after the start. A fault of one cell needs none. */
PetscErrorCode SlipFaultResolutionSetUp(SlipFault fault)
{
  SlipFaultResolution *r = &fault->resolution;
  const PetscInt c = fault->layout.components;
  Vec k, h = NULL;
  PetscReal best[3] = {PETSC_MAX_REAL, PETSC_MAX_REAL, PETSC_MAX_REAL}; /* ratio, its length, nucleation */
  PetscReal count[3] = {0, 0, 0}; /* cells that weaken, that can fail alone, and sum of K_c */
  const PetscReal *stiffness, *damping = NULL;
  SlipFrictionCells friction;

  PetscFunctionBegin;
  PetscCall(SlipElasticGetDiagonals(fault->medium, &k,
                                    fault->friction.law->by_rate && !fault->friction.law->nstates ? &h : NULL));
  PetscCall(SlipFaultGetFriction(fault, 0, &friction));
  PetscCall(VecGetArrayRead(k, &stiffness));
  if (h) PetscCall(VecGetArrayRead(h, &damping));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    PetscReal length[2], critical, ratio;

    if (fault->balance.creeps && fault->balance.creeps[i]) continue;
    if (!Lengths(fault, &friction, i, damping ? damping[c * i] / fault->mesh.weight[i] : 0, length, &critical))
      continue;
    count[0]++;
    if (PetscMin(stiffness[c * i], stiffness[c * i + fault->layout.plane - 1]) / fault->mesh.weight[i] < critical)
      count[1]++;
    count[2] += critical;
    best[2] = PetscMin(best[2], length[1]);
    if (length[0] == 0) length[0] = length[1];
    ratio = length[0] / Extent(fault, i);
    if (ratio < best[0]) {
      best[0] = ratio;
      best[1] = length[0];
    }
  }
  if (h) PetscCall(VecRestoreArrayRead(h, &damping));
  PetscCall(VecRestoreArrayRead(k, &stiffness));
  r->least = best[0];
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &r->least, 1, MPIU_REAL, MPIU_MIN, fault->comm));
  if (best[0] > r->least) best[1] = PETSC_MAX_REAL; /* the smallest ratio is on another process */
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, best + 1, 2, MPIU_REAL, MPIU_MIN, fault->comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, count, 3, MPIU_REAL, MPIU_SUM, fault->comm));
  r->weakens = count[0] > 0 ? PETSC_TRUE : PETSC_FALSE;
  r->known = r->weakens && fault->mesh.N > 1 ? PETSC_TRUE : PETSC_FALSE;
  r->zone = fault->friction.law->nstates || !fault->friction.law->by_rate ? PETSC_TRUE : PETSC_FALSE;
  r->wanted = r->zone ? CELLS_OF_ZONE : CELLS_OF_NUCLEATION;
  r->length = best[1];
  r->cell = r->known ? best[1] / r->least : 0;
  r->nucleation = best[2];
  r->alone = r->weakens ? count[1] / count[0] : 0;
  r->critical = r->weakens ? count[2] / count[0] : 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes, for example, "0.64 cells of 1000 m in the smallest cohesive zone of 640 m, nucleation length at least 1222 m,
   100 % of the cells that weaken can fail alone". */
PetscErrorCode SlipFaultResolutionText(SlipFault fault, char text[], size_t len)
{
  const SlipFaultResolution *r = &fault->resolution;

  PetscFunctionBegin;
  (void)snprintf(
    text, len,
    "%.3g cells of %.4g m in the smallest %s of %.4g m, nucleation length at least %.4g m, %.3g %% of the cells "
    "that weaken can fail alone",
    (double)r->least, (double)r->cell, r->zone ? "cohesive zone" : "nucleation length", (double)r->length,
    (double)r->nucleation, (double)(100 * r->alone));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prints a line before the run. Collective. */
PetscErrorCode SlipFaultResolutionPrint(SlipFault fault)
{
  char text[256];

  PetscFunctionBegin;
  if (!fault->resolution.known || !fault->options.progress) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipFaultResolutionText(fault, text, sizeof(text)));
  PetscCall(PetscPrintf(fault->comm, "%-24s %s\n", "resolution:", text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the resolution to /result and the summary. */
PetscErrorCode SlipFaultResolutionResult(SlipFault fault, SlipOutput run)
{
  const SlipFaultResolution *r = &fault->resolution;

  PetscFunctionBegin;
  if (!r->known) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipOutputAddResult(run, "least_resolution", "least resolution",
                                r->zone ? "cells in a cohesive zone" : "cells in a length of nucleation", r->least));
  PetscCall(SlipOutputAddResult(run, "cells_fail_alone", "cells that fail alone", "of those that weaken", r->alone));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Warns of a poor resolution, on rank 0. A fault that starts at its instability without loading slides as a whole: it
   has no front to resolve. */
PetscErrorCode SlipFaultResolutionWarn(SlipFault fault)
{
  const SlipFaultResolution *r = &fault->resolution;
  const char *prefix = SlipFaultPrefix(fault);
  char cells[128];
  PetscBool critical;

  PetscFunctionBegin;
  PetscCall(PetscStrcmp(fault->kind.initial, "critical", &critical));
  if (!r->known || r->least >= r->wanted || (critical && !fault->kind.driven)) PetscFunctionReturn(PETSC_SUCCESS);
  if (fault->mesh.ndim == 1)
    PetscCall(PetscSNPrintf(cells, sizeof(cells), "-%sfault_mesh", prefix));
  else
    PetscCall(PetscSNPrintf(cells, sizeof(cells), "-%sfault_nx, -%sfault_nz", prefix, prefix));
  if (r->zone)
    PetscCall(SlipWarning(
      "cells of %.4g m are too large for the cohesive zone of %.4g m: it has %.3g cells, expected at "
      "least %d (Day et al. 2005), and %.3g %% of the cells that weaken can fail alone. Use smaller "
      "cells (%s), or a larger -%sfault_friction_slip",
      (double)r->cell, (double)r->length, (double)r->least, CELLS_OF_ZONE, (double)(100 * r->alone), cells, prefix));
  else
    PetscCall(SlipWarning("cells of %.4g m are larger than the length of %.4g m over which slip becomes unstable (Rice "
                          "1993): %.3g %% of the cells that weaken can fail alone. Use smaller cells (%s), or a larger "
                          "-%sfault_friction_rate",
                          (double)r->cell, (double)r->length, (double)(100 * r->alone), cells, prefix));
  PetscFunctionReturn(PETSC_SUCCESS);
}
