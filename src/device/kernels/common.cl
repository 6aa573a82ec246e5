// The first of the kernels' files, which CMakeLists.txt joins to one program. Numbers are doubles; sums have a fixed tree, so that their bits
// repeat.
#pragma OPENCL EXTENSION cl_khr_fp64 : enable

// Places of the groups of a reduction, and of its items
#define ITEMS 128

// The items that a work item has of n. All of them have as many turns, of which the last may be none: processors, on which a group is a
// loop over its items, then have that loop inside of this one, between barriers, and vector units for it.
#ifdef PROCESSOR
#define TOGETHER barrier(CLK_LOCAL_MEM_FENCE)
#else
#define TOGETHER (void)0
#endif
#define EACH(i, n)                                                                                                                         \
  for (int turn = 0, i = get_global_id(0); turn < (n); turn += get_global_size(0), i += get_global_size(0), TOGETHER) if (i < (n))
// The same where the code of one item is of vectors by itself
#define EACH_ALONE(i, n) for (int i = get_global_id(0); i < (n); i += get_global_size(0))

// What is no number counts as infinite; a is a number.
static double larger(double a, double b)
{
  return b == b ? (b > a ? b : a) : INFINITY;
}

// The results of a group from those of its items, into room [results][groups]. Sums first, then largest values. By a tree, or on processors,
// where it would take longer than what it sums, one after the other in four parts.
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

// And those of all groups
__kernel void fold_groups(__global const double *room, int groups, int results, int sums, __global double *out)
{
  const int k = get_global_id(0);
  double all = 0;

  if (k >= results) return;
  all = room[k * groups];
  for (int g = 1; g < groups; g++) all = k < sums ? all + room[k * groups + g] : fmax(all, room[k * groups + g]);
  out[k] = all;
}
