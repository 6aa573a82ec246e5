/* Seeded random numbers of the trainer, see random.h. */
#include "random.h"
#include <math.h>

void RandomSeed(Random *r, uint64_t seed)
{
  for (int i = 0; i < 4; ++i) { /* splitmix64 */
    uint64_t z = (seed += 0x9e3779b97f4a7c15u);

    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    r->s[i] = z ^ (z >> 31);
  }
  r->spare = 0;
  r->has_spare = 0;
}

static inline uint64_t Rotate(uint64_t x, int k)
{
  return (x << k) | (x >> (64 - k));
}

double RandomUniform(Random *r)
{
  uint64_t *s = r->s;
  const uint64_t bits = Rotate(s[0] + s[3], 23) + s[0], t = s[1] << 17;

  s[2] ^= s[0];
  s[3] ^= s[1];
  s[1] ^= s[2];
  s[0] ^= s[3];
  s[2] ^= t;
  s[3] = Rotate(s[3], 45);
  return (double)(bits >> 11) * 0x1.0p-53;
}

double RandomNormal(Random *r)
{
  double radius, angle;

  if (r->has_spare) {
    r->has_spare = 0;
    return r->spare;
  }
  radius = sqrt(-2 * log(1 - RandomUniform(r))); /* 1 - u is in (0, 1] */
  angle = 6.283185307179586 * RandomUniform(r);
  r->spare = radius * sin(angle);
  r->has_spare = 1;
  return radius * cos(angle);
}

uint64_t RandomIndex(Random *r, uint64_t n)
{
  return (uint64_t)(RandomUniform(r) * (double)n); /* bias below n 2^-53 */
}

double RandomLog(Random *r, double low, double high)
{
  return low * exp(log(high / low) * RandomUniform(r));
}

uint64_t RandomStream(PetscInt seed, PetscInt stream, PetscInt64 k)
{
  return (uint64_t)seed * 0x9e3779b97f4a7c15u + (uint64_t)(1000000 * (PetscInt64)stream + k);
}

uint64_t RandomStreamHashed(PetscInt seed, PetscInt stream, PetscInt64 k)
{
  Random r;

  RandomSeed(&r, ((uint64_t)seed << 34) + ((uint64_t)stream << 32) + (uint64_t)k);
  return r.s[0];
}
