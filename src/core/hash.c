/* Fowler, Noll & Vo's 64-bit hash, FNV-1a (IETF draft-eastlake-fnv): it identifies policies and cached operators, and
   is not for security. */
#include <slipstep/rooms/slipcore.h>
#include <string.h>

#define PRIME UINT64_C(1099511628211)

/* Continues an FNV-1a hash over bytes. hash: SLIP_HASH_START, or the hash of what precedes. */
uint64_t SlipHashBytes(uint64_t hash, const void *data, size_t n)
{
  const unsigned char *b = (const unsigned char *)data;

  for (size_t i = 0; i < n; i++) hash = (hash ^ b[i]) * PRIME;
  return hash;
}

/* Continues a hash over numbers, each as one word, which is eight times as fast as over their bytes. hash:
   SLIP_HASH_START, or the hash of what precedes; a: the numbers, dimensionless or not. Each word is followed by a shift
   of the high half into the low one, because a product moves bits only upwards. */
uint64_t SlipHashReals(uint64_t hash, const PetscReal a[], size_t n)
{
  for (size_t i = 0; i < n; i++) {
    uint64_t word;

    memcpy(&word, &a[i], sizeof(word));
    hash = (hash ^ word) * PRIME;
    hash ^= hash >> 32;
  }
  return hash;
}
