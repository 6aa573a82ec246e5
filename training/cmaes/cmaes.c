/* CMA-ES, see cmaes.h. Equations are those of the tutorial (version of 2016, figure 6). */
#include "cmaes.h"
#include <petscblaslapack.h>
#include <slipcompat.h>
#include "common/rowblas.h"
#include <math.h>

/* Weights of equations 49 to 53, positive ones first; learning rates of equations 54 to 58 */
static void SetWeights(CMAES *es)
{
  const double n = (double)es->n, speed = es->diagonal ? (n + 2) / 3 : 1;
  double sum = 0, sum2 = 0, minus = 0, minus2 = 0, mueff_minus, limit;

  for (PetscInt i = 0; i < es->lambda; ++i) {
    double w = log(((double)es->lambda + 1) / 2) - log((double)i + 1);

    es->weight[i] = w;
    if (i < es->mu)
      sum += w, sum2 += w * w;
    else
      minus += w, minus2 += w * w;
  }
  es->mueff = sum * sum / sum2;
  mueff_minus = minus2 > 0 ? minus * minus / minus2 : 0;
  es->c1 = speed * 2 / ((n + 1.3) * (n + 1.3) + es->mueff);
  es->cmu = PetscMin(1 - es->c1, speed * 2 * (0.25 + es->mueff + 1 / es->mueff - 2) / ((n + 2) * (n + 2) + es->mueff));
  limit = PetscMin(1 + es->c1 / es->cmu, 1 + 2 * mueff_minus / (es->mueff + 2));
  limit = PetscMin(limit, (1 - es->c1 - es->cmu) / (n * es->cmu)); /* keeps C positive definite */
  for (PetscInt i = 0; i < es->lambda; ++i)
    es->weight[i] = i < es->mu ? es->weight[i] / sum : (minus < 0 ? -limit * es->weight[i] / minus : 0);
  es->cs = (es->mueff + 2) / (n + es->mueff + 5);
  es->damps = 1 + 2 * PetscMax(0, sqrt((es->mueff - 1) / (n + 1)) - 1) + es->cs;
  es->cc = (4 + es->mueff / n) / (n + 4 + 2 * es->mueff / n);
  es->chi = sqrt(n) * (1 - 1 / (4 * n) + 1 / (21 * n * n));
  es->interval = PetscMax(1, (PetscInt64)(1 / ((es->c1 + es->cmu) * n * 10)));
}

PetscErrorCode CMAESCreate(PetscInt n, PetscInt lambda, const double mean[], double sigma, CMAES *es)
{
  PetscFunctionBegin;
  PetscCheck(n > 1, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
             "CMA-ES in %" PetscInt_FMT " dimensions, expected 2 or more", n);
  PetscCheck(sigma > 0, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE, "CMA-ES with sigma %g, expected a number > 0",
             sigma);
  PetscCheck(lambda == 0 || lambda >= 4, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
             "CMA-ES with a population of %" PetscInt_FMT ", expected 4 or more (-train_population)", lambda);
  PetscCall(PetscMemzero(es, sizeof(*es)));
  es->n = n;
  es->lambda = lambda ? lambda : 4 + (PetscInt)(3 * log((double)n));
  es->mu = es->lambda / 2;
  es->sigma = sigma;
  PetscCall(PetscCalloc5(n, &es->mean, n, &es->ps, n, &es->pc, n, &es->D, es->lambda, &es->weight));
  PetscCall(PetscCalloc3(n * n, &es->C, n * n, &es->B, n * (es->lambda + 2), &es->work));
  PetscCall(PetscArraycpy(es->mean, mean, n));
  for (PetscInt i = 0; i < n; ++i) es->C[i * n + i] = es->B[i * n + i] = es->D[i] = 1;
  SetWeights(es);
  PetscFunctionReturn(PETSC_SUCCESS);
}

void CMAESSetDiagonal(CMAES *es, PetscBool diagonal)
{
  es->diagonal = diagonal;
  SetWeights(es);
}

PetscErrorCode CMAESDestroy(CMAES *es)
{
  PetscFunctionBegin;
  PetscCall(PetscFree5(es->mean, es->ps, es->pc, es->D, es->weight));
  PetscCall(PetscFree3(es->C, es->B, es->work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* B and D from C */
static PetscErrorCode Decompose(CMAES *es)
{
  const PetscInt n = es->n;
  PetscBLASInt nn, lwork, info;
  PetscReal *work;

  PetscFunctionBegin;
  if (es->diagonal) { /* B is the identity, whatever it was */
    PetscCall(PetscArrayzero(es->B, n * n));
    for (PetscInt i = 0; i < n; ++i) {
      es->B[i * n + i] = 1;
      es->D[i] = sqrt(es->C[i * n + i]);
    }
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(PetscBLASIntCast(n, &nn));
  lwork = 8 * nn;
  PetscCall(PetscMalloc1(lwork, &work));
  PetscCall(PetscArraycpy(es->B, es->C, n * n));
  PetscCallBLAS("LAPACKsyev", LAPACKsyev_("V", "U", &nn, es->B, &nn, es->D, work, &lwork, &info));
  PetscCall(PetscFree(work));
  PetscCheck(!info, PETSC_COMM_SELF, PETSC_ERR_LIB, "LAPACK syev of the covariance failed: info %d", (int)info);
  /* rounding may leave a tiny negative eigenvalue where the landscape is flat by 1e14 */
  for (PetscInt i = 0; i < n; ++i) es->D[i] = sqrt(PetscMax(es->D[i], 1e-14 * es->D[n - 1]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CMAESAsk(CMAES *es, Random *random, double x[])
{
  const PetscInt n = es->n;
  double *z = es->work;

  PetscFunctionBegin;
  if (es->generation && es->generation % es->interval == 0) PetscCall(Decompose(es));
  for (PetscInt k = 0; k < es->lambda; ++k)
    for (PetscInt i = 0; i < n; ++i) z[k * n + i] = es->D[i] * RandomNormal(random);
  for (PetscInt k = 0; k < es->lambda; ++k) PetscCall(PetscArraycpy(x + k * n, es->mean, n));
  cblas_dgemm(CblasRowMajor, CblasNoTrans, CblasNoTrans, (int)es->lambda, (int)n, (int)n, es->sigma, z, (int)n, es->B,
              (int)n, 1, x, (int)n);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Equation 47: decay, rank one and rank mu. y [lambda][n], ranked. */
static void UpdateCovariance(CMAES *es, PetscBool stalled, double y[], double work[])
{
  const int n = (int)es->n;
  const double stall = stalled ? es->c1 * es->cc * (2 - es->cc) : 0;
  double sum = 0;

  for (PetscInt k = 0; k < es->lambda; ++k) sum += es->weight[k];
  cblas_dscal(n * n, 1 + stall - es->c1 - es->cmu * sum, es->C, 1);
  cblas_dsyr(CblasRowMajor, CblasUpper, n, es->c1, es->pc, 1, es->C, n);
  for (PetscInt k = 0; k < es->lambda; ++k) {
    double w = es->weight[k], *yk = y + k * n;

    if (w < 0) { /* as long as a typical step, however far out it lies */
      cblas_dgemv(CblasRowMajor, CblasNoTrans, n, n, 1, es->B, n, yk, 1, 0, work, 1);
      for (int i = 0; i < n; ++i) work[i] /= es->D[i];
      w *= n / PetscMax(cblas_ddot(n, work, 1, work, 1), 1e-300);
    }
    cblas_dsyr(CblasRowMajor, CblasUpper, n, es->cmu * w, yk, 1, es->C, n);
  }
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < i; ++j) {
      if (es->diagonal) es->C[j * n + i] = 0;
      es->C[i * n + j] = es->C[j * n + i];
    }
}

PetscErrorCode CMAESTell(CMAES *es, const double x[], const double f[])
{
  const PetscInt n = es->n;
  const double rate = sqrt(es->cs * (2 - es->cs) * es->mueff);
  double *y = es->work, *yw = es->work + n * es->lambda, *work = yw + n, norm, limit;
  PetscInt *order;
  PetscBool stalled;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(es->lambda, &order));
  for (PetscInt i = 0; i < es->lambda; ++i) { /* stable insertion sort, NaN last */
    PetscInt k = i;

    for (; k > 0 && (f[order[k - 1]] > f[i] || (isnan(f[order[k - 1]]) && !isnan(f[i]))); --k) order[k] = order[k - 1];
    order[k] = i;
  }
  for (PetscInt k = 0; k < es->lambda; ++k)
    for (PetscInt i = 0; i < n; ++i) y[k * n + i] = (x[order[k] * n + i] - es->mean[i]) / es->sigma;
  PetscCall(PetscFree(order));
  PetscCall(PetscArrayzero(yw, n));
  for (PetscInt k = 0; k < es->mu; ++k) cblas_daxpy((int)n, es->weight[k], y + k * n, 1, yw, 1);
  cblas_daxpy((int)n, es->sigma, yw, 1, es->mean, 1);
  /* equation 43: ps <- (1 - cs) ps + sqrt(cs (2 - cs) mueff) C^(-1/2) yw */
  cblas_dgemv(CblasRowMajor, CblasNoTrans, (int)n, (int)n, 1, es->B, (int)n, yw, 1, 0, work, 1);
  for (PetscInt i = 0; i < n; ++i) work[i] /= es->D[i];
  cblas_dgemv(CblasRowMajor, CblasTrans, (int)n, (int)n, rate, es->B, (int)n, work, 1, 1 - es->cs, es->ps, 1);
  es->generation++;
  norm = cblas_dnrm2((int)n, es->ps, 1);
  limit = (1.4 + 2 / ((double)n + 1)) * es->chi * sqrt(1 - pow(1 - es->cs, 2 * (double)es->generation));
  stalled = norm >= limit ? PETSC_TRUE : PETSC_FALSE;
  for (PetscInt i = 0; i < n; ++i)
    es->pc[i] = (1 - es->cc) * es->pc[i] + (stalled ? 0 : sqrt(es->cc * (2 - es->cc) * es->mueff) * yw[i]);
  UpdateCovariance(es, stalled, y, work);
  es->sigma *= exp(PetscMin(1, es->cs / es->damps * (norm / es->chi - 1)));
  PetscFunctionReturn(PETSC_SUCCESS);
}
