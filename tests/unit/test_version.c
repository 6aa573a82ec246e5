/* The version that the library tells is that of the headers, whole or cut, as text and as numbers. */
#include "unit.h"

static void tells_its_version(void **state)
{
  char text[32], cut[4], built[32];
  PetscInt major = -1, minor = -1, patch = -1;

  ok(SlipStepGetVersion(text, sizeof(text)));
  ok(SlipStepGetVersionNumber(&major, &minor, &patch));
  snprintf(built, sizeof(built), "%d.%d.%d", (int)major, (int)minor, (int)patch);
  assert_string_equal(built, text);
  assert_string_equal(SLIPSTEP_BUILD_VERSION, text); /* CMake's, which installed packages carry */
  assert_string_equal(SLIPSTEP_VERSION, text);
  ok(SlipStepGetVersion(cut, sizeof(cut)));
  assert_int_equal(0, strncmp(text, cut, 3));
  assert_int_equal(0, cut[3]);
  ok(SlipStepGetVersionNumber(NULL, NULL, NULL));
}

SLIP_TESTS(tells_its_version)
