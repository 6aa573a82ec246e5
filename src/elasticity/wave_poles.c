/*
  The kernels of waves as sums of decaying exponentials, with which any history of slip is stored in as many numbers.

  Poles are those of a rational function that interpolates the Laplace transform of -dW/dT just right of the imaginary
  axis, at points that are added where its error is largest (AAA: Nakatsukasa, Sete & Trefethen 2018). Support points
  and weights are conjugate pairs, so that all results are real. Poles in the right half-plane, which are noise, are
  removed, and so are those that hardly decay. The amplitudes fit W(T) over times by least squares with two constraints:
  W(0), so that slip which has just begun has the impedance alone, and the integral 1, so that slow slip has no damping.
*/
#include <slipstep/rooms/slipwaves.h>
#include <slipcompat.h>
#include <petscblaslapack.h>
#include <complex.h>
#include <math.h>

#define OFFSET 5e-4  /* real part of the points that interpolate the transform: half of 1/SLIP_WAVE_LONGEST */
#define SLOWEST 1e-4 /* slowest decay, so that none lasts much longer than the times to which amplitudes are fitted */
#define NEAR 60      /* times up to here have equal distances */
#define NEAR_TIMES 2000
#define FAR_TIMES 1000 /* later times, up to SLIP_WAVE_LONGEST, have equal ratios */
#define TIMES (NEAR_TIMES + FAR_TIMES)
#define BOUND 1e3 /* weight of the constraints in least squares, which are projected on them afterwards */
#define FINER 0.5 /* ratio of the transform's next tolerance to the last */
#define FINEST 1e-12
#define CUTOFF 1e-13 /* relative cutoff of singular values */
enum { AROUND = 140, HIGH = 120, BELOW = 60, POINTS = 4 * AROUND + HIGH + BELOW, PAIRS = SLIP_WAVE_MOST_POLES };

typedef struct {
  SlipWaveMode mode;
  double ratio;
  int n; /* number of points */
  double complex Z[POINTS], F[POINTS];
  PetscBool support[POINTS];
  int m; /* number of pairs of support points */
  double complex z[PAIRS], f[PAIRS], w[PAIRS];
} Fit;

/* Returns the Laplace transform of -dW/dT, Re p > 0, without cancellation for small p. */
static double complex Transform(const Fit *fit, double complex p)
{
  const double complex s = csqrt(p - I) * csqrt(p + I);
  const double a = fit->ratio;
  double complex X;

  if (fit->mode == SLIP_WAVE_ANTIPLANE) return 1 / (s + p);
  X = s * csqrt(p / a - I) * csqrt(p / a + I);
  return (4 + p * p - 4 * (1 + 1 / (a * a) + p * p / (a * a)) / (1 + X)) / s - p;
}

/* Sets the frequencies, which are dense around the branch points 1 and a, and extend far beyond. */
static void SetPoints(Fit *fit)
{
  const int inplane = fit->mode == SLIP_WAVE_INPLANE;
  double w[POINTS];
  int n = 0;

  for (int i = 0; i < AROUND; i++) {
    const double g = (OFFSET / 4) * pow(4 / OFFSET, (double)i / AROUND);

    w[n++] = 1 + g;
    w[n++] = 1 - g;
    if (inplane) {
      w[n++] = fit->ratio + g;
      w[n++] = fabs(fit->ratio - g);
    }
  }
  for (int i = 0; i < HIGH; i++) w[n++] = pow(10, 0.3 + 3.2 * i / (HIGH - 1));
  for (int i = 0; i < BELOW; i++) w[n++] = (i + 0.5) / BELOW;
  fit->n = n;
  for (int i = 0; i < n; i++) {
    fit->Z[i] = OFFSET + I * w[i];
    fit->F[i] = Transform(fit, fit->Z[i]);
  }
}

/* Returns the rational function at a point that is no support point. */
static double complex Rational(const Fit *fit, double complex Z)
{
  double complex N = 0, D = 0;

  for (int j = 0; j < fit->m; j++) {
    const double complex there = fit->w[j] / (Z - fit->z[j]), below = conj(fit->w[j]) / (Z - conj(fit->z[j]));

    N += there * fit->f[j] + below * conj(fit->f[j]);
    D += there + below;
  }
  return N / D;
}

/* Sets the weights to the right singular vector of the linearised error's least singular value, real and imaginary. */
static PetscErrorCode SetWeights(Fit *fit, PetscReal A[], PetscReal work[], PetscBLASInt size)
{
  const int m = fit->m;
  PetscBLASInt rows = 2 * (fit->n - m), columns = 2 * m, one = 1, info;
  PetscReal s[2 * PAIRS], VT[4 * PAIRS * PAIRS];
  int row = 0;

  PetscFunctionBegin;
  for (int i = 0; i < fit->n; i++) {
    if (fit->support[i]) continue;
    for (int j = 0; j < m; j++) {
      const double complex there = (fit->F[i] - fit->f[j]) / (fit->Z[i] - fit->z[j]),
                           below = (fit->F[i] - conj(fit->f[j])) / (fit->Z[i] - conj(fit->z[j])), real = there + below,
                           imaginary = I * (there - below);

      A[row + rows * 2 * j] = (PetscReal)creal(real);
      A[row + 1 + rows * 2 * j] = (PetscReal)cimag(real);
      A[row + rows * (2 * j + 1)] = (PetscReal)creal(imaginary);
      A[row + 1 + rows * (2 * j + 1)] = (PetscReal)cimag(imaginary);
    }
    row += 2;
  }
  PetscCallBLAS("LAPACKgesvd",
                LAPACKgesvd_("N", "A", &rows, &columns, A, &rows, s, NULL, &one, VT, &columns, work, &size, &info));
  PetscCheck(info == 0, PETSC_COMM_SELF, PETSC_ERR_LIB, "LAPACK's gesvd returned %d", (int)info);
  for (int j = 0; j < m; j++)
    fit->w[j] = VT[columns - 1 + columns * 2 * j] + I * VT[columns - 1 + columns * (2 * j + 1)];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds a pair of support points where the error is largest; *error is the relative error after that. */
static PetscErrorCode AddPair(Fit *fit, PetscReal A[], PetscReal work[], PetscBLASInt size, double *error)
{
  double worst = -1, largest = 0;
  int at = 0;

  PetscFunctionBegin;
  for (int i = 0; i < fit->n; i++) {
    const double off = fit->support[i] ? -1 : cabs(fit->F[i] - (fit->m ? Rational(fit, fit->Z[i]) : 0));

    if (off > worst) {
      worst = off;
      at = i;
    }
    largest = fmax(largest, cabs(fit->F[i]));
  }
  fit->support[at] = PETSC_TRUE;
  fit->z[fit->m] = fit->Z[at];
  fit->f[fit->m++] = fit->F[at];
  PetscCall(SetWeights(fit, A, work, size));
  *error = 0;
  for (int i = 0; i < fit->n; i++)
    if (!fit->support[i]) *error = fmax(*error, cabs(fit->F[i] - Rational(fit, fit->Z[i])) / largest);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the zeros of the denominator sum w/(Z - z), which are eigenvalues of diag(z) - e (w z)'/sum(w), in real form,
   except one that is 0. It takes the upper one of each pair in the left half-plane. */
static PetscErrorCode FindPoles(const Fit *fit, SlipWavePoles *p)
{
  PetscBLASInt n = 2 * fit->m, one = 1, info, size = 16 * PAIRS;
  PetscReal A[4 * PAIRS * PAIRS], re[2 * PAIRS], im[2 * PAIRS], work[16 * PAIRS], sum = 0, none = 0;
  PetscInt least = 0;

  PetscFunctionBegin;
  for (int j = 0; j < fit->m; j++) sum += 2 * (PetscReal)creal(fit->w[j]);
  PetscCall(PetscArrayzero(A, n * n));
  for (int j = 0; j < fit->m; j++) {
    const double complex wz = fit->w[j] * fit->z[j];
    const PetscReal x = (PetscReal)creal(fit->z[j]), y = (PetscReal)cimag(fit->z[j]);

    A[2 * j + n * 2 * j] = A[2 * j + 1 + n * (2 * j + 1)] = x;
    A[2 * j + 1 + n * 2 * j] = y;
    A[2 * j + n * (2 * j + 1)] = -y;
    for (int i = 0; i < fit->m; i++) {
      A[2 * i + n * 2 * j] -= 2 * (PetscReal)creal(wz) / sum;
      A[2 * i + n * (2 * j + 1)] += 2 * (PetscReal)cimag(wz) / sum;
    }
  }
  PetscCallBLAS("LAPACKgeev", LAPACKgeev_("N", "N", &n, A, &n, re, im, &none, &one, &none, &one, work, &size, &info));
  PetscCheck(info == 0, PETSC_COMM_SELF, PETSC_ERR_LIB, "LAPACK's geev returned %d", (int)info);
  for (PetscInt i = 1; i < n; i++)
    if (hypot(re[i], im[i]) < hypot(re[least], im[least])) least = i;
  p->n = 0;
  for (PetscInt i = 0; i < n; i++) {
    if (i == least || im[i] < 0 || !(re[i] < -SLOWEST) || p->n == SLIP_WAVE_MOST_POLES) continue;
    p->s[2 * p->n] = re[i];
    p->s[2 * p->n++ + 1] = im[i];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- amplitudes ---- */

/* Computes the coefficients of the unknown k, real or imaginary part of a_k/2, in W(0) and in the integral of W. */
static void Bind(const SlipWavePoles *p, PetscInt k, PetscReal c[2])
{
  const PetscReal x = p->s[k - k % 2], y = p->s[k - k % 2 + 1], square = x * x + y * y;

  c[0] = k % 2 ? 0 : 1;
  c[1] = -(k % 2 ? y : x) / square; /* Re -a/s */
}

static PetscErrorCode FindAmplitudes(const Fit *fit, const PetscReal T[], const PetscReal W[], PetscReal A[],
                                     PetscReal work[], PetscBLASInt size, SlipWavePoles *p)
{
  const PetscReal to[2] = {SlipWaveStatic(fit->mode, (PetscReal)fit->ratio), 1};
  PetscBLASInt rows = TIMES + 2, columns = (PetscBLASInt)(2 * p->n), one = 1, rank, info;
  PetscReal s[2 * SLIP_WAVE_MOST_POLES], b[TIMES + 2], cutoff = (PetscReal)CUTOFF;
  PetscReal G[3] = {0, 0, 0}, off[2] = {to[0], to[1]}, c[2], x[2], det;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < p->n; k++)
    for (PetscInt i = 0; i < TIMES; i++) {
      const PetscReal size = PetscExpReal(p->s[2 * k] * T[i]), turn = p->s[2 * k + 1] * T[i];

      A[i + rows * 2 * k] = size * PetscCosReal(turn);
      A[i + rows * (2 * k + 1)] = -size * PetscSinReal(turn);
    }
  for (PetscInt k = 0; k < 2 * p->n; k++) {
    PetscReal c[2];

    Bind(p, k, c);
    if (k % 2 && p->s[k] == 0) c[1] = 0;
    A[TIMES + rows * k] = (PetscReal)BOUND * c[0];
    A[TIMES + 1 + rows * k] = (PetscReal)BOUND * c[1];
  }
  PetscCall(PetscArraycpy(b, W, TIMES));
  for (int i = 0; i < 2; i++) b[TIMES + i] = (PetscReal)BOUND * to[i];
  PetscCallBLAS("LAPACKgelss",
                LAPACKgelss_(&rows, &columns, &one, A, &rows, b, &rows, s, &cutoff, &rank, work, &size, &info));
  PetscCheck(info == 0, PETSC_COMM_SELF, PETSC_ERR_LIB, "LAPACK's gelss returned %d", (int)info);
  PetscCall(PetscArraycpy(p->a, b, 2 * p->n));
  for (PetscInt k = 0; k < p->n; k++)
    if (p->s[2 * k + 1] == 0) p->a[2 * k + 1] = 0;
  for (PetscInt k = 0; k < 2 * p->n; k++) {
    if (k % 2 && p->s[k] == 0) continue;
    Bind(p, k, c);
    G[0] += c[0] * c[0];
    G[1] += c[0] * c[1];
    G[2] += c[1] * c[1];
    off[0] -= c[0] * p->a[k];
    off[1] -= c[1] * p->a[k];
  }
  det = G[0] * G[2] - G[1] * G[1];
  x[0] = (G[2] * off[0] - G[1] * off[1]) / det;
  x[1] = (G[0] * off[1] - G[1] * off[0]) / det;
  for (PetscInt k = 0; k < 2 * p->n; k++) {
    if (k % 2 && p->s[k] == 0) continue;
    Bind(p, k, c);
    p->a[k] += c[0] * x[0] + c[1] * x[1];
  }
  p->error = 0;
  for (PetscInt i = 0; i < TIMES; i++)
    p->error = PetscMax(p->error, PetscAbsReal(SlipWavePolesEvaluate(p, T[i]) - W[i]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- all together ---- */

/* Reduces the tolerance of the transform until W has the wanted accuracy. */
static PetscErrorCode Refine(Fit *fit, PetscReal tolerance, const PetscReal T[], const PetscReal W[], SlipWavePoles *p)
{
  const PetscBLASInt size = 64 * (TIMES + 2);
  const PetscReal wanted = tolerance;
  double finer = (double)tolerance, error = 1;
  PetscReal *A, *work;

  PetscFunctionBegin;
  PetscCall(PetscMalloc2((size_t)(TIMES + 2) * 2 * SLIP_WAVE_MOST_POLES, &A, size, &work));
  p->error = PETSC_MAX_REAL;
  for (; p->error > wanted && fit->m < PAIRS / 2 && finer > FINEST; finer *= FINER) {
    if (error <= finer) continue;
    while (error > finer && fit->m < PAIRS / 2) PetscCall(AddPair(fit, A, work, size, &error));
    PetscCall(FindPoles(fit, p));
    PetscCall(FindAmplitudes(fit, T, W, A, work, size, p));
  }
  PetscCall(PetscFree2(A, work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes W as a sum of decaying exponentials. mode: SLIP_WAVE_ANTIPLANE or SLIP_WAVE_INPLANE; ratio: cp/cs, above 1;
   of mode II alone, dimensionless; tolerance: largest error of W, 1e-8 to 1e-1, dimensionless; poles: the sum, which
   SlipWavePolesDestroy() frees; its sum of amplitudes is W(0), its integral 1, as those of W. Errors:
   PETSC_ERR_ARG_OUTOFRANGE; PETSC_ERR_NOT_CONVERGED where that many poles are not enough. Nakatsukasa, Sete & Trefethen
   (2018). */
PetscErrorCode SlipWavePolesCreate(SlipWaveMode mode, PetscReal ratio, PetscReal tolerance, SlipWavePoles *poles)
{
  PetscReal *T, *W;
  Fit *fit;

  PetscFunctionBegin;
  PetscCheck(tolerance >= (PetscReal)SLIP_WAVE_FINEST && tolerance <= 0.1, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
             "Tolerance of waves is %g, expected 1e-8 to 0.1", (double)tolerance);
  PetscCheck(mode == SLIP_WAVE_ANTIPLANE || ratio > 1, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
             "cp/cs is %g, expected more than 1", (double)ratio);
  PetscCall(PetscCalloc1(1, &fit));
  fit->mode = mode;
  fit->ratio = (double)ratio;
  SetPoints(fit);
  PetscCall(PetscMalloc2(TIMES, &T, TIMES, &W));
  for (PetscInt i = 0; i < NEAR_TIMES; i++) T[i] = (PetscReal)NEAR * (PetscReal)i / NEAR_TIMES;
  for (PetscInt i = 0; i < FAR_TIMES; i++)
    T[NEAR_TIMES + i] =
      (PetscReal)NEAR * PetscPowReal((PetscReal)SLIP_WAVE_LONGEST / NEAR, (PetscReal)i / (FAR_TIMES - 1));
  PetscCall(SlipWaveKernel(mode, ratio, TIMES, T, W));
  PetscCall(PetscMalloc2(2 * SLIP_WAVE_MOST_POLES, &poles->s, 2 * SLIP_WAVE_MOST_POLES, &poles->a));
  PetscCall(Refine(fit, tolerance, T, W, poles));
  PetscCall(PetscFree2(T, W));
  PetscCall(PetscFree(fit));
  PetscCheck(poles->error <= tolerance, PETSC_COMM_SELF, PETSC_ERR_NOT_CONVERGED,
             "Tolerance of waves is %g, which %" PetscInt_FMT " exponentials do not reach: expected at least %g",
             (double)tolerance, poles->n, (double)poles->error);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Evaluates the sum of exponentials at a time. T: time k cs t, not negative, dimensionless. */
PetscReal SlipWavePolesEvaluate(const SlipWavePoles *p, PetscReal T)
{
  PetscReal sum = 0;

  for (PetscInt k = 0; k < p->n; k++)
    sum += PetscExpReal(p->s[2 * k] * T) *
           (p->a[2 * k] * PetscCosReal(p->s[2 * k + 1] * T) - p->a[2 * k + 1] * PetscSinReal(p->s[2 * k + 1] * T));
  return sum;
}

/* Frees a sum of exponentials. p: the sum, which is empty afterwards. */
PetscErrorCode SlipWavePolesDestroy(SlipWavePoles *p)
{
  PetscFunctionBegin;
  PetscCall(PetscFree2(p->s, p->a));
  p->n = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}
