/* Fowler, Noll & Vo's 64-bit hash, FNV-1a (IETF draft-eastlake-fnv): not for security, only to tell policies and cached
   operators apart. */
#include <slipcore.h>
#include <string.h>

#define PRIME UINT64_C(1099511628211)

/*@C
  SlipHashBytes - continue a hash over bytes, FNV-1a

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
  SlipHashReals - continue a hash over numbers, each as one word: eight times as fast as over their bytes

  Not collective.

  Input Parameters:
+ hash - SLIP_HASH_START, or the hash of what precedes
. a    - the numbers
- n    - how many

  Level: developer

  Note:
  High halves are folded in after each word, for a product moves bits up only.

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
