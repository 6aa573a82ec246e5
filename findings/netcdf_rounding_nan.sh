#!/usr/bin/env bash
# netCDF's lossy rounding to significant digits turns NaN and infinity into 0, also where NaN is the fill value.
#
# Seen with netCDF 4.9.0 and NCO 5.1.4 (Debian 12). nc_def_var_quantize() with NC_QUANTIZE_GRANULARBR, and "ncks --ppc default=3", whose
# default is the same algorithm, promise three significant digits. 1/3 becomes 0.33301; NaN becomes -0, infinity -0 and minus infinity 0. In
# a variable whose _FillValue is NaN the missing values become zeros as well: cells that have no slip yet, or lie outside of a fault, join
# the means. NaN passes NC_QUANTIZE_BITROUND and "--baa=8", which round to a number of bits. There is no warning. netCDF's repository spares
# NaN, not infinity, since February 2025.
#
# Guess before the run: NaN and infinity stay what they are, as numbers without digits, and fill values anyway.
# Exit code: 0 as seen, 1 when it behaves in another way, 77 when the packages cannot be had.
set -euo pipefail
room=$(mktemp -d)
trap 'rm -rf "$room"' EXIT
cd "$room"
mkdir -p debs/partial tree && : >status
apt-get -qq -y -o Dir::State::status="$room/status" -o Dir::Cache::archives="$room/debs" -o Debug::NoLocking=1 --no-install-recommends \
  --download-only install libnetcdf-dev=1:4.9.0-3+b1 netcdf-bin=1:4.9.0-3+b1 nco=5.1.4-1+deb12u1 >apt.log 2>&1 || { tail -3 apt.log; exit 77; }
rm -f debs/libc6_*.deb debs/libc6-dev_*.deb
for deb in debs/*.deb; do dpkg -x "$deb" tree; done
lib=$room/tree/usr/lib/x86_64-linux-gnu

cat >try.c <<'C'
#include <math.h>
#include <netcdf.h>
#include <stdio.h>

int main(void)
{
  const double value[4] = {1. / 3, NAN, INFINITY, -INFINITY}, none = NAN;
  const int    mode[] = {NC_QUANTIZE_GRANULARBR, NC_QUANTIZE_BITROUND}, digits[] = {3, 10};
  const char  *name[] = {"granular", "bits", "granular_fill", "bits_fill"};
  int          file, dim, var, seen = 1;

  nc_create("rounded.nc", NC_NETCDF4 | NC_CLOBBER, &file);
  nc_def_dim(file, "x", 4, &dim);
  for (int k = 0; k < 4; k++) {
    nc_def_var(file, name[k], NC_DOUBLE, 1, &dim, &var);
    if (k > 1) nc_def_var_fill(file, var, NC_FILL, &none);
    if (nc_def_var_quantize(file, var, mode[k % 2], digits[k % 2])) return 2;
    nc_put_var_double(file, var, value);
  }
  nc_close(file);
  nc_open("rounded.nc", NC_NOWRITE, &file);
  for (int k = 0; k < 4; k++) {
    double x[4];

    nc_inq_varid(file, name[k], &var);
    nc_get_var_double(file, var, x);
    printf("%s: 1/3, NaN, inf and -inf become %.5f, %g, %g and %g\n", name[k], x[0], x[1], x[2], x[3]);
    seen = seen && fabs(x[0] - value[0]) < 1e-3 && (k % 2 ? isnan(x[1]) && isinf(x[2]) && isinf(x[3]) : x[1] == 0 && x[2] == 0 && x[3] == 0);
  }
  nc_close(file);
  return !seen;
}
C
cc -I tree/usr/include try.c -o try "$lib"/libnetcdf.so -Wl,--allow-shlib-undefined -lm
export LD_LIBRARY_PATH=$lib:$room/tree/lib/x86_64-linux-gnu:$room/tree/usr/lib/nco:$lib/blas:$lib/lapack
echo "netCDF $(sed -n 's/^Version: *//p' "$lib"/pkgconfig/netcdf.pc)"
./try

tree/usr/bin/ncgen -4 -o in.nc <<'CDL'
netcdf in { dimensions: x = 4; variables: double plain(x); double fill(x); fill:_FillValue = NaN;
data: plain = 0.333333333333, NaN, Infinity, -Infinity; fill = 0.333333333333, NaN, Infinity, -Infinity; }
CDL
tree/usr/bin/ncks -O -7 --ppc default=3 in.nc digits.nc 2>said.txt
tree/usr/bin/ncks -O -7 --baa=8 --ppc default=10 in.nc bits.nc
values() { tree/usr/bin/ncdump -v "$2" "$1".nc | sed -n '/^data:/,$ { s/^ *'"$2"' = \(.*\) ;$/\1/p }'; }
for variable in plain fill; do echo "ncks, $variable: $(values digits $variable); with --baa=8: $(values bits $variable)"; done
[ "$(values digits plain | cut -d , -f 2-)" = " -0, -0, 0" ] && [ "$(values digits fill | cut -d , -f 2-)" = " -0, -0, 0" ] && [ ! -s said.txt ] &&
  [ "$(values bits plain | cut -d , -f 2-)" = " NaN, Infinity, -Infinity" ]
