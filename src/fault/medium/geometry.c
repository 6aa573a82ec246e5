/* Connects a fault with its mesh: creates the cells by the options, and the kernel and stiffness between them, and sums
   over the cells. */
#include <slipstep/private/slipfault.h>
#include <string.h>

/* Gets the kernel for the options and the shape of the cells. */
static PetscErrorCode SlipFaultKernel(SlipFault fault, PetscBool triangles, SlipKernel *kernel)
{
  const char *text = fault->options.text[FAULT_STIFFNESS_AVERAGE];
  const SlipKernelType *type = triangles             ? &SlipKernelTriangle
                               : fault->kind.dipping ? &SlipKernelDipping
                                                     : &SlipKernelStrikeSlip;
  PetscBool cell, whole, mirror;

  PetscFunctionBegin;
  PetscCall(PetscStrcmp(text, "cell", &cell));
  PetscCall(PetscStrcmp(text, "whole", &whole));
  PetscCall(PetscStrcmp(fault->options.text[FAULT_KERNEL], "mirror", &mirror));
  if (mirror && !triangles) type = &SlipKernelMirror;
  if (fault->layout.components == 2) type = triangles ? &SlipKernelTriangleVector : &SlipKernelDippingVector;
  if (SlipFaultOpens(fault)) type = triangles ? &SlipKernelTriangleOpening : &SlipKernelDippingOpening;
  *kernel = (SlipKernel){.type = type,
                         .shear_modulus = fault->options.value[FAULT_SHEAR_MODULUS],
                         .poisson_ratio = fault->options.value[FAULT_POISSON_RATIO],
                         .average = cell    ? SLIP_AVERAGE_CELL
                                    : whole ? SLIP_AVERAGE_WHOLE
                                            : SLIP_AVERAGE_CENTRE};
  PetscCall(PetscStrcmp(fault->options.text[FAULT_KERNEL], "full_space", &kernel->full_space));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates the cells, their distribution and weights. Collective. */
PetscErrorCode SlipFaultMeshSetUp(SlipFault fault)
{
  const char(*text)[PETSC_MAX_PATH_LEN] = (const char(*)[PETSC_MAX_PATH_LEN])fault->options.text;
  SlipFaultMeshOptions o = {.comm = fault->comm,
                            .prefix = SlipFaultPrefix(fault),
                            .file = text[FAULT_MESH],
                            .frame = text[FAULT_MESH_FRAME],
                            .unit = text[FAULT_MESH_UNIT],
                            .type = text[FAULT_OPERATOR],
                            .fields = SlipFaultFieldNames(),
                            .extent = fault->options.value,
                            .block = fault->layout.block};

  PetscFunctionBegin;
  PetscCall(SlipFaultKernel(fault, PETSC_FALSE, &o.rectangles));
  PetscCall(SlipFaultKernel(fault, PETSC_TRUE, &o.triangles));
  PetscCall(SlipFaultMeshCreate(&o, &fault->mesh));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets how K is made of the cells. */
static PetscErrorCode GetStiffness(SlipFault fault, SlipFaultStiffness *s)
{
  PetscFunctionBegin;
  *s = (SlipFaultStiffness){.type = fault->options.text[FAULT_OPERATOR],
                            .dipping = fault->kind.dipping,
                            .rake = fault->fields.cell[FIELD_RAKE]};
  PetscCall(SlipFaultHmatTolerance(fault, &s->tolerance, NULL, 0));
  PetscCall(SlipFaultKernel(fault, fault->mesh.cells.vertices ? PETSC_TRUE : PETSC_FALSE, &s->kernel));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Predicts K, and Kn where there is one, of a mesh for size processes, forecast [1 or 2][size]. Collective. */
PetscErrorCode SlipFaultMeshForecast(SlipFault fault, PetscMPIInt size, SlipCellsForecast forecast[])
{
  SlipFaultStiffness s;

  PetscFunctionBegin;
  PetscCall(GetStiffness(fault, &s));
  PetscCall(SlipFaultCellsForecast(&fault->mesh, &s, fault->kind.coupled, size, forecast));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes K of the mesh, and Kn unless it is NULL. Collective. */
PetscErrorCode SlipFaultMeshStiffness(SlipFault fault, Mat *K, Mat *Kn)
{
  SlipFaultStiffness s;

  PetscFunctionBegin;
  PetscCall(SlipFaultHmatSetUp(fault));
  PetscCall(GetStiffness(fault, &s));
  PetscCall(fault->mesh.kind->stiffness(&fault->mesh, &s, K, Kn));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sums the weighted values of a vector of slip along the rake. Collective. */
PetscErrorCode SlipFaultWeightedSum(SlipFault fault, Vec x, PetscReal *sum)
{
  const PetscReal *a;

  PetscFunctionBegin;
  *sum = 0;
  PetscCall(VecGetArrayRead(x, &a));
  for (PetscInt i = 0; i < fault->mesh.n; i++)
    *sum += fault->mesh.weight[i] * SlipFaultDot(fault, a + fault->layout.components * i, SlipFaultAlong(fault, i));
  PetscCall(VecRestoreArrayRead(x, &a));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 1, MPIU_REAL, MPIU_SUM, fault->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}
