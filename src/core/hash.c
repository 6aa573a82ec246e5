/* Fowler, Noll & Vo's 64-bit hash, FNV-1a (IETF draft-eastlake-fnv): it identifies policies and cached operators, and
   is not for security. */
#include <slipcore.h>
#include <string.h>

#define PRIME UINT64_C(1099511628211)

/*@C
  SlipHashBytes - continues an FNV-1a hash over bytes

  Not collective.

  Input Parameters:
+ hash - SLIP_HASH_START, or the hash of what precedes
. data - the bytes
- n    - their number

  Level: developer

.seealso: SlipHashReals()
@*/
uint64_t SlipHashBytes(uint64_t hash, const void *data, size_t n)
{
  const unsigned char *b = (const unsigned char *)data;

  for (size_t i = 0; i < n; i++) hash = (hash ^ b[i]) * PRIME;
  return hash;
}

/*@C
  SlipHashReals - continues a hash over numbers, each as one word, which is eight times as fast as over their bytes

  Not collective.

  Input Parameters:
+ hash - SLIP_HASH_START, or the hash of what precedes
. a    - the numbers, dimensionless or not
- n    - how many

  Level: developer

  Note:
  Each word is followed by a shift of the high half into the low one, because a product moves bits only upwards.

.seealso: SlipHashBytes()
@*/
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
