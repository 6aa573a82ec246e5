#!/usr/bin/env bash
# HMAT's ACA+ and partial cross approximation stop too early for some kernels: the error is 5e-3 at any tolerance, also at 1e-7.
#
# Seen with hmat-oss 1.8.1 (Debian 12), 1600 points of a square grid one apart, product with a vector of ones against the sums of the rows.
# Covariance exp(-(r/8)^2), as of random fields: errors of SVD and full cross approximation fall with the tolerance, to 1e-9 at 1e-7; those
# of ACA+ stay at 5e-3, of partial ACA at 8e-4. Two components that do not act on each other, (1 + r^2)^-1.5 between points of one
# component: partial ACA stays at 6e-3, as its rows and columns stay within one component. With exp(-r/8) all four are right, which makes a
# test on a friendly kernel misleading. A block ends where the last row and column that were looked at are small; nothing is reported. Check
# a kernel against SVD.
#
# Guess before the run: errors of about the tolerance, by each of them.
# Exit code: 0 as seen, 1 when it behaves in another way, 77 when the packages cannot be had.
set -euo pipefail
room=$(mktemp -d)
trap 'rm -rf "$room"' EXIT
cd "$room"
mkdir -p debs/partial tree && : >status
apt-get -qq -y -o Dir::State::status="$room/status" -o Dir::Cache::archives="$room/debs" -o Debug::NoLocking=1 --no-install-recommends \
  --download-only install libhmat-oss-dev=1.8.1-2 >apt.log 2>&1 || { tail -3 apt.log; exit 77; }
rm -f debs/libc6_*.deb debs/libc6-dev_*.deb
for deb in debs/*.deb; do dpkg -x "$deb" tree; done
lib=$room/tree/usr/lib/x86_64-linux-gnu

cat >try.c <<'C'
#include <hmat/hmat.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { SIDE = 40, POINTS = SIDE * SIDE };
static double point[3 * POINTS];
static int    kernel;

static void Entry(void *context, int i, int j, void *entry)
{
  const double x = point[3 * i] - point[3 * j], y = point[3 * i + 1] - point[3 * j + 1], r2 = x * x + y * y;
  const int    same = (i + i / SIDE) % 2 == (j + j / SIDE) % 2;

  *(double *)entry = kernel == 0 ? exp(-r2 / 64) : kernel == 1 ? (same ? pow(1 + r2, -1.5) : 0) : exp(-sqrt(r2) / 8);
}

static double Error(hmat_interface_t *hmat, const hmat_compression_algorithm_t *compression, double tolerance)
{
  hmat_clustering_algorithm_t *clustering = hmat_create_clustering_median();
  hmat_cluster_tree_t         *tree = hmat_create_cluster_tree(point, 3, POINTS, clustering);
  hmat_matrix_t               *matrix = hmat->create_empty_hmatrix_admissibility(tree, tree, 0, hmat_create_admissibility_standard(2));
  hmat_assemble_context_t      assemble;
  double                       x[POINTS], y[POINTS], one = 1, zero = 0, error = 0, size = 0;

  hmat_assemble_context_init(&assemble);
  assemble.progress = NULL;
  assemble.compression = compression;
  assemble.simple_compute = Entry;
  hmat->set_low_rank_epsilon(matrix, tolerance);
  hmat->assemble_generic(matrix, &assemble);
  for (int i = 0; i < POINTS; i++) {
    x[i] = 1;
    y[i] = 0;
  }
  hmat->gemv('N', &one, matrix, x, &zero, y, 1);
  for (int i = 0; i < POINTS; i++) {
    double sum = 0;

    for (int j = 0; j < POINTS; j++) {
      double entry;

      Entry(NULL, i, j, &entry);
      sum += entry;
    }
    error += (y[i] - sum) * (y[i] - sum);
    size += sum * sum;
  }
  hmat->destroy(matrix);
  hmat_delete_cluster_tree(tree);
  return sqrt(error / size);
}

int main(void)
{
  const char      *name[] = {"exp(-(r/8)^2)", "two components", "exp(-r/8)"};
  hmat_settings_t  settings;
  hmat_interface_t hmat;
  int              seen = 1;

  for (int i = 0; i < POINTS; i++) {
    point[3 * i] = i % SIDE;
    point[3 * i + 1] = i / SIDE;
  }
  hmat_get_parameters(&settings);
  hmat_init_default_interface(&hmat, HMAT_DOUBLE_PRECISION);
  hmat_set_parameters(&settings);
  if (hmat.init()) return 2;
  for (kernel = 0; kernel < 3; kernel++)
    for (int k = 0; k < 3; k++) {
      const double tolerance[] = {1e-3, 1e-5, 1e-7};
      const double t = tolerance[k];
      const double svd = Error(&hmat, hmat_create_compression_svd(t), t), full = Error(&hmat, hmat_create_compression_aca_full(t), t);
      const double part = Error(&hmat, hmat_create_compression_aca_partial(t), t), plus = Error(&hmat, hmat_create_compression_aca_plus(t), t);

      printf("%s, tolerance %.0e: errors of SVD %.1e, full ACA %.1e, partial ACA %.1e, ACA+ %.1e\n", name[kernel], t, svd, full, part, plus);
      seen = seen && svd < t && full < t && (kernel < 2 ? part > 5e-4 : part < t) && (kernel == 0 ? plus > 1e-3 : plus < t);
    }
  return !seen;
}
C
cc -I tree/usr/include try.c -o try "$lib"/libhmat.so.3 -Wl,--allow-shlib-undefined -lm
export LD_LIBRARY_PATH=$lib:$room/tree/lib/x86_64-linux-gnu:$lib/blas:$lib/lapack OMP_NUM_THREADS=1
./try 2>error.txt || { tail -3 error.txt; exit 1; }
