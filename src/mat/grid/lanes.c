/*
  Complex transforms of SLIP_LANES fields at once, one in each lane of a vector unit, so that all arithmetic is vector
  code for any length: Stockham's algorithm with radices 8, 5, 4, 3 and 2, whose output is in order (P. N.
  Swarztrauber, FFT algorithms for vector computers, Parallel Computing 1, 45-63, 1984).

  A point takes 0.6 to 0.7 ns with AVX-512 and 1.1 to 1.3 with AVX2, at any length of up to 128 with factors 2, 3, 5.
  FFTW's plans are estimated, so that every run rounds alike, and take 1.0 to 1.2 ns at suitable lengths and 2.1 to 2.8
  at 90, 108, 144, 180, 192, 216, 288, 300, 360 and 384 (one field after the other; interleaved ones take longer;
  measured). With AVX2 alone FFTW is therefore 6 to 13 % faster on grids of 256 and 512 rows. It is not used there,
  because it needs another order of fields and symbols, and with it a second version of every product.
*/
#include <slipstep/rooms/slipmat.h>
#include <stdlib.h>
#include <slipstep/private/slipmatgrid.h>

typedef struct {
  void (*pass)(PetscInt, PetscInt, PetscInt, const PetscReal[], const PetscReal *, const PetscReal *, PetscReal *,
               PetscReal *);
  void (*load)(PetscInt, const PetscReal[], const SlipLanesFields *, const PetscReal[], const PetscReal[],
               PetscReal *const[2], PetscReal *const[2]);
  void (*store)(const PetscReal[], const SlipLanesFields *, const PetscReal[], PetscReal, PetscReal *const[2],
                PetscReal *const[2], PetscReal[]);
  void (*multiply)(PetscInt, const PetscReal[], const PetscReal[], PetscReal *const[2]);
  void (*split)(PetscInt, PetscReal *const[2], PetscInt, PetscInt, PetscInt, PetscReal[], PetscInt);
  void (*join)(PetscInt, PetscReal *const[2], PetscInt, PetscInt, PetscInt, const PetscReal[], PetscInt);
} Unit;

/* Vector units of x86-64, of which a program chooses the machine's; elsewhere vectors have two numbers */
#if defined(__x86_64__) && defined(__gnu_linux__) && defined(__GNUC__) && !defined(__clang__) &&                       \
  !defined(__SANITIZE_ADDRESS__)
  #define WIDE
#endif

/* Fetches memory that loops need later: reals of a field, numbers of a symbol, and wavenumbers of rows. Processors do
   not foresee eight fields side by side, nor rows that are pages apart. A product of 4000 x 1000 cells takes 0.93 of
   the time that it takes without (measured, AVX2). */
#define AHEAD(p, write) __builtin_prefetch(p, write)
#define LOAD_AHEAD 64
#define SYMBOL_AHEAD 16
#define ROWS_AHEAD 8

#define LANES_WIDTH 2
#define LANES_TARGET
#define LANES_NAME(name) name##2
#include <slipstep/private/sliplanes.h>
#ifdef WIDE
  #undef LANES_WIDTH
  #undef LANES_TARGET
  #undef LANES_NAME
  #define LANES_WIDTH 4
  #define LANES_TARGET __attribute__((target("avx2,fma")))
  #define LANES_NAME(name) name##4
  #include <slipstep/private/sliplanes.h>
  #undef LANES_WIDTH
  #undef LANES_TARGET
  #undef LANES_NAME
  #define LANES_WIDTH 8
  #define LANES_TARGET __attribute__((target("avx512f")))
  #define LANES_NAME(name) name##8
  #include <slipstep/private/sliplanes.h>
#endif

enum { MOST_PASSES = 31 };

struct _n_SlipLanesFFT {
  PetscInt n, passes, radix[MOST_PASSES];
  PetscReal *twiddle[MOST_PASSES]; /* [n_i / r][r - 1] complex, n_i the remaining factor of n before the pass */
  PetscReal *spare;                /* [n] numbers */
  PetscReal *turn;                 /* [n] complex, exp(-i pi j / n) */
  const Unit *unit;
};

static const Unit *UnitOfThisMachine(void)
{
#ifdef WIDE
  if (__builtin_cpu_supports("avx512f")) return &Unit8;
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return &Unit4;
#endif
  return &Unit2;
}

/* Returns the next factor of a length: 8 unless two of 4 are better, 1 at the end. */
static PetscInt Radix(PetscInt left)
{
  if (left % 5 == 0) return 5;
  if (left % 3 == 0) return 3;
  if (left % 32 == 0 || left % 16 == 8) return 8;
  return left % 4 == 0 ? 4 : left % 2 == 0 ? 2 : 1;
}

PetscErrorCode SlipLanesFFTCreate(PetscInt n, SlipLanesFFT *fft)
{
  PetscInt left = n;
  SlipLanesFFT f;

  PetscFunctionBegin;
  PetscCall(PetscNew(&f));
  f->n = n;
  f->unit = UnitOfThisMachine();
  for (PetscInt r = Radix(left); r > 1; left /= r, r = Radix(left)) {
    PetscReal *t;

    PetscCall(PetscMalloc1(2 * (left / r) * (r - 1), &t));
    f->radix[f->passes] = r;
    f->twiddle[f->passes++] = t;
    for (PetscInt p = 0; p < left / r; p++)
      for (PetscInt k = 1; k < r; k++, t += 2) {
        t[0] = PetscCosReal(2 * PETSC_PI * (PetscReal)(p * k) / (PetscReal)left);
        t[1] = -PetscSinReal(2 * PETSC_PI * (PetscReal)(p * k) / (PetscReal)left);
      }
  }
  PetscCheck(left == 1, PETSC_COMM_SELF, PETSC_ERR_PLIB, "Transforms of length %" PetscInt_FMT " are not there", n);
  PetscCall(SlipAllocateLines((size_t)SLIP_NUMBER * n, &f->spare));
  PetscCall(PetscMalloc1(2 * n, &f->turn));
  for (PetscInt j = 0; j < n; j++) {
    f->turn[2 * j] = PetscCosReal(PETSC_PI * (PetscReal)j / (PetscReal)n);
    f->turn[2 * j + 1] = -PetscSinReal(PETSC_PI * (PetscReal)j / (PetscReal)n);
  }
  *fft = f;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipLanesFFTDestroy(SlipLanesFFT *fft)
{
  SlipLanesFFT f = *fft;

  PetscFunctionBegin;
  if (!f) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt i = 0; i < f->passes; i++) PetscCall(PetscFree(f->twiddle[i]));
  PetscCall(PetscFree(f->turn));
  free(f->spare);
  PetscCall(PetscFree(*fft));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Transforms *x [n], forward or backward, unscaled. Each pass swaps *x with the spare memory, which has the same size
   and is also of SlipAllocateLines(). */
static void Transform(SlipLanesFFT f, PetscBool back, PetscReal **x)
{
  const PetscInt re = back ? SLIP_LANES : 0, im = back ? 0 : SLIP_LANES; /* backward: the conjugate */
  PetscInt left = f->n;

  for (PetscInt i = 0; i < f->passes; i++) {
    const PetscInt r = f->radix[i], m = left / r;
    PetscReal *y = f->spare;

    (*f->unit->pass)(r, m, f->n / left, f->twiddle[i], *x + re, *x + im, y + re, y + im);
    f->spare = *x;
    *x = y;
    left = m;
  }
}

/* Adds the numbers beyond the first n of a transform of length 2 n to those n places before: for even wavenumbers with
   the same sign, for odd ones with the opposite sign. */
static void LoadRest(SlipLanesFFT f, const SlipLanesFields *g, const PetscReal field[], PetscReal *room[2])
{
  for (PetscInt i = f->n; i < g->n; i++) {
    const PetscReal *x = field + g->step * i, c = f->turn[2 * (i - f->n)], s = f->turn[2 * (i - f->n) + 1];
    PetscReal *even = room[0] + SLIP_NUMBER * (i - f->n), *odd = room[1] + SLIP_NUMBER * (i - f->n);

    for (PetscInt l = 0; l < SLIP_LANES; l++) {
      const PetscReal re = x[l * g->apart], im = x[l * g->apart + g->imaginary];

      even[l] += re;
      even[SLIP_LANES + l] += im;
      odd[l] -= c * re - s * im;
      odd[SLIP_LANES + l] -= c * im + s * re;
    }
  }
}

static void StoreRest(SlipLanesFFT f, const SlipLanesFields *g, PetscReal scale, PetscReal *room[2], PetscReal field[])
{
  for (PetscInt i = f->n; i < g->n; i++) {
    PetscReal *x = field + g->step * i;
    const PetscReal c = f->turn[2 * (i - f->n)], s = f->turn[2 * (i - f->n) + 1];
    const PetscReal *even = room[0] + SLIP_NUMBER * (i - f->n), *odd = room[1] + SLIP_NUMBER * (i - f->n);

    for (PetscInt l = 0; l < SLIP_LANES; l++) {
      x[l * g->apart] = scale * (even[l] - c * odd[l] - s * odd[SLIP_LANES + l]);
      x[l * g->apart + g->imaginary] = scale * (even[SLIP_LANES + l] - c * odd[SLIP_LANES + l] + s * odd[l]);
    }
  }
}

/* Transforms fields that are padded to 2 n numbers: even wavenumbers in room[0], odd ones in room[1]. As half of a
   padded field is zero, these are two transforms of half the length. */
void SlipLanesForward(SlipLanesFFT f, const SlipLanesFields *g, const PetscReal field[], PetscReal *room[2])
{
  SlipLanesFields first = *g;

  first.n = PetscMin(g->n, f->n);
  (*f->unit->load)(f->n, f->turn, &first, NULL, field, room, NULL);
  LoadRest(f, g, field, room);
  for (int i = 0; i < 2; i++) Transform(f, PETSC_FALSE, &room[i]);
}

/* Computes the transforms of pairs of real fields from those of complex ones, whose real and imaginary parts they are,
   for wavenumbers in [start, end): a [end - start][fields] complex, na reals from one wavenumber to the next. */
void SlipLanesSplit(SlipLanesFFT f, PetscReal *room[2], PetscInt fields, PetscInt start, PetscInt end, PetscReal a[],
                    PetscInt na)
{
  (*f->unit->split)(f->n, room, fields, start, end, a, na);
}

/* Does the inverse of SlipLanesSplit(). */
void SlipLanesJoin(SlipLanesFFT f, PetscReal *room[2], PetscInt fields, PetscInt start, PetscInt end,
                   const PetscReal a[], PetscInt na)
{
  (*f->unit->join)(f->n, room, fields, start, end, a, na);
}

/* Transforms backward, times scale; only the first numbers are used. */
void SlipLanesBackward(SlipLanesFFT f, const SlipLanesFields *g, PetscReal scale, PetscReal *room[2], PetscReal field[])
{
  SlipLanesFields first = *g;

  first.n = PetscMin(g->n, f->n);
  for (int i = 0; i < 2; i++) Transform(f, PETSC_TRUE, &room[i]);
  (*f->unit->store)(f->turn, &first, NULL, scale, room, NULL, field);
  StoreRest(f, g, scale, room, field);
}

/* Computes f = 2 n (T + A reversed - z q reversed z) f in place for SLIP_LANES fields [nz] complex, one after the
   other, nz <= n. The symbols T [n + 1][SLIP_LANES], A and q [n + 1][2][SLIP_LANES], or NULL, are those of toeplitz.c;
   z [nz]. room [4] is work, [n] numbers each, for the halves of u and v. */
void SlipLanesMultiply(SlipLanesFFT f, const SlipToeplitzSymbol *s, size_t group, PetscInt nz, const PetscReal z[],
                       PetscReal *room[4], PetscReal field[])
{
  const SlipLanesFields g = {.n = nz, .step = 2, .apart = 2 * nz, .imaginary = 1};
  const size_t at = group * SLIP_LANES * (f->n + 1);
  const int count = s->product ? 4 : 2;
  PetscReal **v = s->product ? room + 2 : NULL;

  (*f->unit->load)(f->n, f->turn, &g, z, field, room, v);
  for (int i = 0; i < count; i++) Transform(f, PETSC_FALSE, &room[i]);
  (*f->unit->multiply)(f->n, s->toeplitz + at, s->hankel ? s->hankel + 2 * at : NULL, room);
  if (v) (*f->unit->multiply)(f->n, NULL, s->product + 2 * at, v);
  for (int i = 0; i < count; i++) Transform(f, PETSC_TRUE, &room[i]);
  (*f->unit->store)(f->turn, &g, z, 1, room, v, field);
}
