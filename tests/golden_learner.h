/* For the golden tests of the learners: networks and a batch from an integer hash, and comparison with tqc_golden.json
   when it is found. Tolerances: double 1e-9; both sides round at 1e-16 and sums have some 1e5 terms. Float 1e-5
   relative to the l2 norm of a tensor (SB3's atanh round trip alone costs 1e-6), see Close(). */
#pragma once
#include "study/learner.h"
#include "unit.h"
#include "golden_json.h"

#if defined(TRAIN_DOUBLE)
  #define TOLERANCE 1e-9
  #define PRECISION "f64"
#else
  #define TOLERANCE 1e-5
  #define PRECISION "f32"
#endif

enum { BATCH = 8, OBS = 6, WIDTH = 64 };

/* Formats the path of an entry. */
static void Path(size_t size, char out[], const char format[], ...)
{
  va_list args;
  int n;

  va_start(args, format);
  n = vsnprintf(out, size, format, args);
  va_end(args);
  assert_true(n > 0 && (size_t)n < size);
}

static char *golden; /* text of tqc_golden.json or NULL */

static Scalar Hash(uint32_t k, uint32_t tensor, double shift, double scale)
{
  uint32_t x = 2654435761u * (k + 1) + 1013904223u * (tensor + 1);

  for (int i = 0; i < 2; ++i) {
    x ^= x >> 16;
    x *= 73244475u;
  }
  x ^= x >> 16;
  return (Scalar)(float)(shift + scale * (2 * ((double)x + 0.5) / 4294967296.0 - 1));
}

static void Fill(size_t n, uint32_t tensor, double shift, double scale, Scalar *p)
{
  for (size_t k = 0; k < n; ++k) p[k] = Hash((uint32_t)k, tensor, shift, scale);
}

static void FillLayers(const DenseShape *s, PetscInt net, uint32_t tensor, double last_gain, Scalar *p)
{
  p += (size_t)net * s->count;
  for (PetscInt l = 0; l < s->layers; ++l) {
    const double scale = (l + 1 == s->layers ? last_gain : 1) / sqrt((double)s->size[l]);

    Fill((size_t)(s->size[l] * s->size[l + 1]), tensor + 2 * (uint32_t)l, 0, scale, p + s->weight[l]);
    Fill((size_t)s->size[l + 1], tensor + 2 * (uint32_t)l + 1, 0, scale, p + s->bias[l]);
  }
}

/* What both learners' options have in common. */
static LearnerOptions GoldenOptions(PetscInt critics)
{
  return (LearnerOptions){.obs = OBS,
                          .actor_layers = 2,
                          .actor = {WIDTH, WIDTH},
                          .critic_layers = 3,
                          .critic = {WIDTH, WIDTH, WIDTH},
                          .critics = critics,
                          .batch = BATCH,
                          .gamma = 0.99,
                          .tau = 0.005};
}

static Batch GoldenBatch(void)
{
  static Scalar obs[OBS * BATCH], next[OBS * BATCH], act[BATCH], rew[BATCH], done[BATCH];
  Batch b = {obs, next, act, rew, done};

  for (uint32_t i = 0; i < BATCH; ++i) {
    for (uint32_t j = 0; j < OBS; ++j) {
      obs[j * BATCH + i] = Hash(i * OBS + j, 500, 0, 3);
      next[j * BATCH + i] = Hash(i * OBS + j, 501, 0, 3);
    }
    act[i] = Hash(i, 502, 0, 1);
    rew[i] = Hash(i, 503, 0, 2);
    done[i] = i % 4 == 3;
  }
  return b;
}

/* scale: magnitude against which the error is relative */
static void Close(const char *what, double value, double expected, double scale)
{
  if (!(fabs(value - expected) <= TOLERANCE * fmax(scale, fabs(expected)))) {
    fail_msg("%s is %.16g, the reference %.16g (difference %.2e, allowed %.2e)", what, value, expected,
             fabs(value - expected), TOLERANCE * fmax(scale, fabs(expected)));
  }
}

static double Number(const char *path)
{
  const char *s = JsonFind(golden, path);

  if (!s) fail_msg("tqc_golden.json has no %s", path);
  return strtod(s, NULL);
}

/* A tensor against its shape-independent summary: sum, l2 norm, first three entries and last. */
static void CheckTensor(const char *path, size_t n, const Scalar *p)
{
  char entry[256];
  double sum = 0, l2 = 0, norm;

  for (size_t i = 0; i < n; ++i) {
    sum += p[i];
    l2 += (double)p[i] * p[i];
  }
  Path(sizeof(entry), entry, "%s/l2", path);
  norm = Number(entry);
  Close(entry, sqrt(l2), norm, norm);
  Path(sizeof(entry), entry, "%s/sum", path);
  Close(entry, sum, Number(entry), sqrt((double)n) * norm); /* |sum| <= sqrt(n) l2: entries cancel */
  for (size_t i = 0; i < (n < 3 ? n : 3); ++i) {
    Path(sizeof(entry), entry, "%s/first/%d", path, (int)i);
    Close(entry, (double)p[i], Number(entry), norm);
  }
  Path(sizeof(entry), entry, "%s/last", path);
  Close(entry, (double)p[n - 1], Number(entry), norm);
}

/* Layers under names such as actor.W1; prefix "actor." */
static void CheckLayers(const char *base, const char *prefix, const DenseShape *s, const Scalar *p)
{
  char path[256];

  for (PetscInt l = 0; l < s->layers; ++l) {
    Path(sizeof(path), path, "%s/%sW%d", base, prefix, (int)l + 1);
    CheckTensor(path, (size_t)(s->size[l] * s->size[l + 1]), p + s->weight[l]);
    Path(sizeof(path), path, "%s/%sb%d", base, prefix, (int)l + 1);
    CheckTensor(path, (size_t)s->size[l + 1], p + s->bias[l]);
  }
}

/* The group's setup: reads the full set if it is there; says so. */
static int GoldenLoad(void **state)
{
  const char *source = getenv("SLIPSTEP_SOURCE");
  const char *const places[] = {"../shared/references", "../../shared/references"};
  char file[4096];

  for (size_t i = 0; i < 2 && !golden; ++i) {
    Path(sizeof(file), file, "%s/%s/tqc_golden.json", source ? source : ".", places[i]);
    golden = JsonLoad(file);
  }
  if (golden)
    printf("comparing with every number of %s\n", file);
  else
    printf("tqc_golden.json not found: only the committed numbers are compared, the full set is skipped\n");
  return 0;
}

static int GoldenFree(void **state)
{
  free(golden);
  return 0;
}
