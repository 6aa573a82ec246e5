#!/usr/bin/env bash
# Debian's FFTW has no AVX2, FMA or AVX-512 codelets: it transforms doubles by four with AVX on any processor.
#
# Seen with FFTW 3.3.10-1 (Debian 12, amd64; that of Debian 13 says the same). FFTW's configure has --enable-avx2, --enable-avx512 and
# --enable-fma, and its codelets are chosen at run time, so that a distribution can build all of them for one library. fftw_version of the
# package is "fftw-3.3.10-sse2-avx" (of floats likewise), its symbols have codelets of genus sse2 and avx alone, and plans on a processor
# with AVX2 are made of them, also with FFTW_PATIENT. A library of its own build may be faster by what fused multiply-add is worth.
#
# Guess before the run: "fftw-3.3.10-sse2-avx-avx2-avx2_128", and avx2 codelets in plans, as the processor decides at run time.
# Exit code: 0 as seen, 1 when it behaves in another way, 77 when the packages cannot be had.
set -euo pipefail
room=$(mktemp -d)
trap 'rm -rf "$room"' EXIT
cd "$room"
mkdir -p debs/partial tree && : >status
apt-get -qq -y -o Dir::State::status="$room/status" -o Dir::Cache::archives="$room/debs" -o Debug::NoLocking=1 --no-install-recommends \
  --download-only install libfftw3-double3=3.3.10-1 libfftw3-single3=3.3.10-1 libfftw3-dev=3.3.10-1 >apt.log 2>&1 || { tail -3 apt.log; exit 77; }
for deb in debs/libfftw3*.deb; do dpkg -x "$deb" tree; done
lib=$room/tree/usr/lib/x86_64-linux-gnu

cat >try.c <<'C'
#include <complex.h>
#include <fftw3.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int main(void)
{
  const int lengths[] = {64, 100, 240, 1024};
  int codelets = 0, other = 0;

  for (int i = 0; i < 4; i++) {
    const int n = lengths[i];
    fftw_complex *x = fftw_alloc_complex((size_t)n * 64);
    fftw_plan plan = fftw_plan_many_dft(1, &n, 64, x, NULL, 1, n, x, NULL, 1, n, FFTW_FORWARD, FFTW_PATIENT);
    char *text = fftw_sprint_plan(plan);

    for (char *word = strtok(text, " ()\n"); word; word = strtok(NULL, " ()\n")) {
      const char *genus = strrchr(word, '_');

      if (!strstr(word, "fv_")) continue; /* of vectors */
      codelets++;
      if (!strstr(word, "_avx\"") && !strstr(word, "_sse2\"")) other++, puts(genus ? genus : word);
    }
    fftw_destroy_plan(plan);
    fftw_free(x);
    free(text);
  }
  printf("%s %s: %s of vectors, %d others\n", fftw_version, fftwf_version, codelets ? "codelets" : "no codelets", other);
  return 0;
}
C
cc try.c -I tree/usr/include -o try "$lib"/libfftw3.so "$lib"/libfftw3f.so -lm 2>/dev/null || cc try.c -I tree/usr/include -o try -L "$lib" -l:libfftw3.so.3 -l:libfftw3f.so.3 -lm
export LD_LIBRARY_PATH=$lib
./try | tee seen.txt
grep -ao 'fftw_solvtab_dft_[a-z0-9_]*' "$lib"/libfftw3.so.3 | sort -u | tee tables.txt
grep -qx 'fftw-3.3.10-sse2-avx fftw-3.3.10-sse2-avx: codelets of vectors, 0 others' seen.txt && ! grep -q 'avx2\|avx512\|fma' tables.txt
