/* Generalised state-dependent exploration: noise that is a linear function of the actor's last hidden layer, and its
   density. */
#include "tqc.h"

void GSDESample(PetscInt H, PetscInt A, PetscInt B, const Scalar h[], const Scalar head[], const Scalar bias[],
                const Scalar sigma[], const Scalar explore[], Sample *s)
{
  const Scalar half_log_2pi = (Scalar)0.9189385332046727;

  for (PetscInt b = 0; b < B; ++b) s->logp[b] = 0;
  for (PetscInt k = 0; k < A; ++k) {
    Scalar *raw = s->mean_raw + k * B, *mean = s->mean + k * B, *n = s->noise + k * B, *S = s->var + k * B,
           *a = s->action + k * B;

    ScalarGemv(CblasRowMajor, CblasTrans, H, B, 1, h, B, head + k * H, 1, 0, raw, 1);
    for (PetscInt b = 0; b < B; ++b) {
      raw[b] += bias[k];
      mean[b] = raw[b] > 2 ? 2 : (raw[b] < -2 ? -2 : raw[b]);
      n[b] = 0;
      S[b] = (Scalar)1e-6;
    }
    for (PetscInt j = 0; explore && j < H; ++j) {
      const Scalar e = explore[j * A + k], v = sigma[j * A + k] * sigma[j * A + k], *hj = h + j * B;

      for (PetscInt b = 0; b < B; ++b) {
        n[b] += hj[b] * e;
        S[b] += hj[b] * hj[b] * v;
      }
    }
    for (PetscInt b = 0; b < B; ++b) {
      a[b] = ScalarTanh(mean[b] + n[b]);
      s->logp[b] +=
        -n[b] * n[b] / (2 * S[b]) - ScalarLog(S[b]) / 2 - half_log_2pi - ScalarLog(1 - a[b] * a[b] + (Scalar)1e-6);
    }
  }
}
