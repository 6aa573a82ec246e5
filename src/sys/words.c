/* Lists of names in one text, separated by blanks */
#include <slipstep/private/slipsys.h>
#include <string.h>

PetscBool SlipNextName(const char prefix[], const char **place, char name[SLIP_NAME_LENGTH])
{
  const char *begin = *place + strspn(*place, " ");
  const size_t len = strcspn(begin, " "), before = strlen(prefix);

  if (!len || before + len >= SLIP_NAME_LENGTH) return PETSC_FALSE;
  memcpy(name, prefix, before);
  memcpy(name + before, begin, len);
  name[before + len] = '\0';
  *place = begin + len;
  return PETSC_TRUE;
}
