/* The Gaussian policy without gSDE: mean and log standard deviation are heads of the actor, one normal per sample and
   action, squashed by tanh (as in SAC, Haarnoja et al. 2018; Stable-Baselines3's TQC with use_sde False). */
#include "tqc.h"

#define LOG_STD_MIN (-20)
#define LOG_STD_MAX 2

void GaussSample(PetscInt H, PetscInt A, PetscInt B, const Scalar h[], const Scalar head[], const Scalar bias[],
                 const Scalar std_head[], const Scalar std_bias[], const Scalar eps[], Sample *s)
{
  const Scalar half_log_2pi = (Scalar)0.9189385332046727;

  for (PetscInt b = 0; b < B; ++b) s->logp[b] = 0;
  for (PetscInt k = 0; k < A; ++k) {
    Scalar *mean = s->mean + k * B, *raw = s->std_raw + k * B;

    ScalarGemv(CblasRowMajor, CblasTrans, H, B, 1, h, B, head + k * H, 1, 0, mean, 1);
    ScalarGemv(CblasRowMajor, CblasTrans, H, B, 1, h, B, std_head + k * H, 1, 0, raw, 1);
    for (PetscInt b = 0; b < B; ++b) {
      const PetscInt i = k * B + b;
      const Scalar e = eps ? eps[i] : 0;
      Scalar log_std, sigma, a;

      raw[b] += std_bias[k];
      log_std = raw[b] > LOG_STD_MAX ? LOG_STD_MAX : (raw[b] < LOG_STD_MIN ? LOG_STD_MIN : raw[b]);
      sigma = ScalarExp(log_std);
      mean[b] += bias[k];
      s->mean_raw[i] = mean[b];
      s->noise[i] = sigma * e;
      s->var[i] = sigma * sigma;
      s->action[i] = a = ScalarTanh(mean[b] + s->noise[i]);
      s->logp[b] += -e * e / 2 - log_std - half_log_2pi - ScalarLog(1 - a * a + (Scalar)1e-6);
    }
  }
}

/* With a = tanh(m + sigma eps), o = 1 - a^2: the normal's own density depends on sigma alone, so
     dm = -(q_a/B) o + (alpha/B) 2 a o/(o + 1e-6),  d log sigma = dm sigma eps - alpha/B. */
void GaussGradients(PetscInt A, PetscInt B, Scalar alpha, const Scalar dqda[], const Sample *s, Scalar dm[],
                    Scalar dlog[])
{
  const Scalar kappa = alpha / (Scalar)B;

  for (PetscInt i = 0; i < A * B; ++i) {
    const Scalar a = s->action[i], o = 1 - a * a, raw = s->std_raw[i];

    dm[i] = -(dqda[i] / (Scalar)B) * o + kappa * 2 * a * o / (o + (Scalar)1e-6);
    dlog[i] = raw > LOG_STD_MAX || raw < LOG_STD_MIN ? 0 : dm[i] * s->noise[i] - kappa;
  }
}

void HeadBackward(PetscInt H, PetscInt A, PetscInt B, const Scalar h[], const Scalar W[], const Scalar delta[],
                  PetscBool first, Scalar gW[], Scalar gb[], Scalar dh[])
{
  ScalarGemm(CblasRowMajor, CblasNoTrans, CblasTrans, A, H, B, 1, delta, B, h, B, 0, gW, H);
  ScalarGemm(CblasRowMajor, CblasTrans, CblasNoTrans, H, B, A, 1, W, H, delta, B, first ? 0 : 1, dh, B);
  for (PetscInt k = 0; k < A; ++k) {
    gb[k] = 0;
    for (PetscInt b = 0; b < B; ++b) gb[k] += delta[k * B + b];
  }
}
