// The first of the kernels' files, which CMakeLists.txt joins to one program. Numbers are doubles; sums have a fixed order, so that their bits
// are reproducible.
#pragma OPENCL EXTENSION cl_khr_fp64 : enable

// Numbers of groups of a reduction, and of items in a group
#define ITEMS 128

// Loops over the items of n that a work item has. All work items have equally many turns, of which the last may be empty: a processor, on which
// a group is a loop over its items, then has that loop inside of this one, between barriers, and can vectorize it.
#ifdef PROCESSOR
#define TOGETHER barrier(CLK_LOCAL_MEM_FENCE)
#else
#define TOGETHER (void)0
#endif
#define EACH(i, n)                                                                                                                         \
  for (int turn = 0, i = get_global_id(0); turn < (n); turn += get_global_size(0), i += get_global_size(0), TOGETHER) if (i < (n))
// The same loop for items whose own code is of vectors
#define EACH_ALONE(i, n) for (int i = get_global_id(0); i < (n); i += get_global_size(0))

// Returns the larger one; NaN counts as infinite; a is not NaN.
static double larger(double a, double b)
{
  return b == b ? (b > a ? b : a) : INFINITY;
}

// Reduces the results of a group's items to room [results][groups]: sums first, then largest values. It uses a tree; on processors, where a
// tree would take longer than the loop itself, it adds one after the other in four parts.
static void fold(int results, int sums, double *mine, __local double *all, __global double *room)
{
  const int i = get_local_id(0), group = get_group_id(0), groups = get_num_groups(0);

  for (int k = 0; k < results; k++) {
    all[i] = mine[k];
#ifdef PROCESSOR
    barrier(CLK_LOCAL_MEM_FENCE);
    if (i == 0) {
      double4 part = vload4(0, all);

      for (int j = 1; j < ITEMS / 4; j++) part = k < sums ? part + vload4(j, all) : fmax(part, vload4(j, all));
      all[0] = k < sums ? part.x + part.y + (part.z + part.w) : fmax(fmax(part.x, part.y), fmax(part.z, part.w));
    }
#else
    for (int width = ITEMS / 2; width > 0; width /= 2) {
      barrier(CLK_LOCAL_MEM_FENCE);
      if (i < width) all[i] = k < sums ? all[i] + all[i + width] : fmax(all[i], all[i + width]);
    }
#endif
    barrier(CLK_LOCAL_MEM_FENCE);
    if (i == 0) room[k * groups + group] = all[0];
    barrier(CLK_LOCAL_MEM_FENCE);
  }
}

// Reduces the results of all groups.
__kernel void fold_groups(__global const double *room, int groups, int results, int sums, __global double *out)
{
  const int k = get_global_id(0);
  double all = 0;

  if (k >= results) return;
  all = room[k * groups];
  for (int g = 1; g < groups; g++) all = k < sums ? all + room[k * groups + g] : fmax(all, room[k * groups + g]);
  out[k] = all;
}

// The loops of loops.cl as kernels
#define NUM(name) , double name
#define IN(name) , __global const double *name
#define OUT(name) , __global double *name
#define LOOP(name, arguments)                                                                                                              \
  __kernel void name(int n arguments)                                                                                                      \
  {                                                                                                                                        \
    const int i = get_global_id(0);                                                                                                        \
                                                                                                                                           \
    if (i < n)
#define END }
#define SUMS(name, sums, arguments)                                                                                                        \
  __kernel void name(int n arguments, __global double *room)                                                                               \
  {                                                                                                                                        \
    __local double all[ITEMS];                                                                                                             \
    double mine[sums];                                                                                                                     \
                                                                                                                                           \
    for (int k = 0; k < sums; k++) mine[k] = 0;                                                                                            \
    EACH(i, n)
#define END_SUMS(sums)                                                                                                                     \
  fold(sums, sums, mine, all, room);                                                                                                       \
  }
