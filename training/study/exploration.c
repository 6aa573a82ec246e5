/* How TQC explores: noise that is a linear function of the actor's last hidden layer (generalised state-dependent
   exploration), or a Gaussian whose mean and log standard deviation are heads of the actor, one normal per sample (as
   in SAC, Haarnoja et al. 2018; Stable-Baselines3's TQC with use_sde False). Both are squashed by tanh. */
#include "tqc.h"

#define HALF_LOG_2PI ((Scalar)0.9189385332046727)
#define LOG_STD_MIN (-20)
#define LOG_STD_MAX 2

void GSDESample(PetscInt H, PetscInt B, const Scalar h[], const Scalar head[], const Scalar bias[],
                const Scalar sigma[], const Scalar explore[], Sample *s)
{
  ScalarGemv(CblasRowMajor, CblasTrans, H, B, 1, h, B, head, 1, 0, s->mean_raw, 1);
  for (PetscInt b = 0; b < B; ++b) {
    s->mean_raw[b] += bias[0];
    s->mean[b] = s->mean_raw[b] > 2 ? 2 : (s->mean_raw[b] < -2 ? -2 : s->mean_raw[b]);
    s->noise[b] = 0;
    s->var[b] = (Scalar)1e-6;
  }
  for (PetscInt j = 0; explore && j < H; ++j) {
    const Scalar v = sigma[j] * sigma[j], *hj = h + j * B;

    for (PetscInt b = 0; b < B; ++b) {
      s->noise[b] += hj[b] * explore[j];
      s->var[b] += hj[b] * hj[b] * v;
    }
  }
  for (PetscInt b = 0; b < B; ++b) {
    const Scalar n = s->noise[b], S = s->var[b], a = ScalarTanh(s->mean[b] + n);

    s->action[b] = a;
    s->logp[b] = -n * n / (2 * S) - ScalarLog(S) / 2 - HALF_LOG_2PI - ScalarLog(1 - a * a + (Scalar)1e-6);
  }
}

void GaussSample(PetscInt H, PetscInt B, const Scalar h[], const Scalar head[], const Scalar bias[],
                 const Scalar std_head[], const Scalar std_bias[], const Scalar eps[], Sample *s)
{
  ScalarGemv(CblasRowMajor, CblasTrans, H, B, 1, h, B, head, 1, 0, s->mean, 1);
  ScalarGemv(CblasRowMajor, CblasTrans, H, B, 1, h, B, std_head, 1, 0, s->std_raw, 1);
  for (PetscInt b = 0; b < B; ++b) {
    const Scalar e = eps ? eps[b] : 0, raw = s->std_raw[b] += std_bias[0],
                 log_std = raw > LOG_STD_MAX ? LOG_STD_MAX : (raw < LOG_STD_MIN ? LOG_STD_MIN : raw),
                 sigma = ScalarExp(log_std);
    Scalar a;

    s->mean_raw[b] = s->mean[b] += bias[0];
    s->noise[b] = sigma * e;
    s->var[b] = sigma * sigma;
    s->action[b] = a = ScalarTanh(s->mean[b] + s->noise[b]);
    s->logp[b] = -e * e / 2 - log_std - HALF_LOG_2PI - ScalarLog(1 - a * a + (Scalar)1e-6);
  }
}

/* With a = tanh(m + sigma eps), o = 1 - a^2: the normal's own density depends on sigma alone, so
     dm = -(q_a/B) o + (alpha/B) 2 a o/(o + 1e-6),  d log sigma = dm sigma eps - alpha/B. */
void GaussGradients(PetscInt B, Scalar alpha, const Scalar dqda[], const Sample *s, Scalar dm[], Scalar dlog[])
{
  const Scalar kappa = alpha / (Scalar)B;

  for (PetscInt i = 0; i < B; ++i) {
    const Scalar a = s->action[i], o = 1 - a * a, raw = s->std_raw[i];

    dm[i] = -(dqda[i] / (Scalar)B) * o + kappa * 2 * a * o / (o + (Scalar)1e-6);
    dlog[i] = raw > LOG_STD_MAX || raw < LOG_STD_MIN ? 0 : dm[i] * s->noise[i] - kappa;
  }
}

void HeadBackward(PetscInt H, PetscInt B, const Scalar h[], const Scalar W[], const Scalar delta[], PetscBool first,
                  Scalar gW[], Scalar gb[], Scalar dh[])
{
  ScalarGemm(CblasRowMajor, CblasNoTrans, CblasTrans, 1, H, B, 1, delta, B, h, B, 0, gW, H);
  ScalarGemm(CblasRowMajor, CblasTrans, CblasNoTrans, H, B, 1, 1, W, H, delta, B, first ? 0 : 1, dh, B);
  gb[0] = 0;
  for (PetscInt b = 0; b < B; ++b) gb[0] += delta[b];
}
