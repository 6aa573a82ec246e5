/* Pooled target quantiles and the quantile Huber loss, vectorised over the samples of a batch. */
#include "tqc.h"

#define LANES 16 /* samples handled together: one AVX-512 register of floats */

/* Batcher's merge exchange (Knuth, The Art of Computer Programming 3, 5.2.2, Algorithm M): a sorting network, the
   same compare and exchange for every sample, so that LANES samples are sorted at once. */
TRAIN_CLONES static void SortColumns(PetscInt n, PetscInt B, Scalar z[])
{
  PetscInt top = 1;

  while (2 * top < n) top *= 2;
  for (PetscInt p = top; p > 0; p /= 2) {
    for (PetscInt q = top, r = 0, d = p;; d = q - p, q /= 2, r = p) {
      for (PetscInt i = 0; i + d < n; ++i) {
        if ((i & p) == r) {
          Scalar *restrict a = z + i * B, *restrict b = z + (i + d) * B;

          for (PetscInt s = 0; s < LANES; ++s) {
            const Scalar low = a[s] < b[s] ? a[s] : b[s], high = a[s] < b[s] ? b[s] : a[s];

            a[s] = low;
            b[s] = high;
          }
        }
      }
      if (q == p) break;
    }
  }
}

/* Copies up to LANES columns between a batch [n][B] and a block [n][LANES]. */
static void LoadColumns(PetscInt n, PetscInt B, PetscInt lanes, const Scalar z[], Scalar block[])
{
  for (PetscInt i = 0; i < n; ++i) {
    for (PetscInt s = 0; s < LANES; ++s) block[i * LANES + s] = s < lanes ? z[i * B + s] : 0;
  }
}

void QuantileTargets(PetscInt n, PetscInt keep, PetscInt B, const Scalar reward[], const Scalar done[], Scalar gamma,
                     Scalar alpha, const Scalar logp[], Scalar z[])
{
  Scalar block[n * LANES];

  for (PetscInt b = 0; b < B; b += LANES) {
    const PetscInt lanes = PetscMin(LANES, B - b);

    LoadColumns(n, B, lanes, z + b, block);
    SortColumns(n, LANES, block);
    for (PetscInt j = 0; j < keep; ++j) {
      for (PetscInt s = 0; s < lanes; ++s) {
        z[j * B + b + s] = reward[b + s] + (1 - done[b + s]) * gamma * (block[j * LANES + s] - alpha * logp[b + s]);
      }
    }
  }
}

/* Sums over the targets of w clip(delta) and w huber(delta) for LANES samples of one quantile.
   With c = clip(delta, -1, 1), huber(delta) = c (delta - c/2). */
TRAIN_CLONES static void HuberSums(PetscInt N, Scalar tau, const Scalar theta[], const Scalar y[], Scalar slope[],
                                   Scalar loss[])
{
  Scalar g[LANES] = {0}, l[LANES] = {0}, x[LANES];

  for (PetscInt s = 0; s < LANES; ++s) x[s] = theta[s];
  for (PetscInt j = 0; j < N; ++j, y += LANES) {
    for (PetscInt s = 0; s < LANES; ++s) {
      const Scalar d = y[s] - x[s], w = d < 0 ? 1 - tau : tau, up = d < 1 ? d : 1, c = up > -1 ? up : -1;

      g[s] += w * c;
      l[s] += w * c * (d - c / 2);
    }
  }
  for (PetscInt s = 0; s < LANES; ++s) {
    slope[s] = g[s];
    loss[s] = l[s];
  }
}

double QuantileHuber(PetscInt C, PetscInt Q, PetscInt N, PetscInt B, const Scalar theta[], const Scalar y[],
                     Scalar grad[])
{
  const double mean = 1. / ((double)B * (double)C * (double)Q * (double)N);
  double sum = 0;
  Scalar block[N * LANES], x[LANES], slope[LANES], loss[LANES];

  for (PetscInt b = 0; b < B; b += LANES) {
    const PetscInt lanes = PetscMin(LANES, B - b);

    LoadColumns(N, B, lanes, y + b, block);
    for (PetscInt i = 0; i < C * Q; ++i) {
      const Scalar tau = ((Scalar)(i % Q) + (Scalar)0.5) / (Scalar)Q;

      LoadColumns(1, B, lanes, theta + i * B + b, x);
      HuberSums(N, tau, x, block, slope, loss);
      for (PetscInt s = 0; s < lanes; ++s) {
        grad[i * B + b + s] = (Scalar)-mean * slope[s];
        sum += loss[s];
      }
    }
  }
  return mean * sum;
}
