#!/usr/bin/env bash
# cdo rewrites times that count seconds from no date: a mere copy turns 3,000,000 s into 62,400 s.
#
# Seen with CDO 2.1.1 (Debian 12). Simulations count time in seconds from their start, units "s" without "since". cdo makes a
# date of day 0, month 0, year 0 of it, finds its own date wrong ("Reset wrong date/time to ...") and goes on; `cdo copy`, which one
# uses to change the format, then writes the clock time of that date: whole days are gone. A mean over time has the same
# times. The exit code is 0, the data are right, the units still "s". With "seconds since 2000-01-01" the axis is kept.
#
# Guess before the run: an error, or the axis as it was.
# Exit code: 0 as seen, 1 when it behaves in another way, 77 when the packages cannot be had.
set -euo pipefail
room=$(mktemp -d)
trap 'rm -rf "$room"' EXIT
cd "$room"
mkdir -p debs/partial tree && : >status
apt-get -qq -y -o Dir::State::status="$room/status" -o Dir::Cache::archives="$room/debs" -o Debug::NoLocking=1 --no-install-recommends \
  --download-only install cdo=2.1.1-1+deb12u1 netcdf-bin=1:4.9.0-3+b1 >apt.log 2>&1 || { tail -3 apt.log; exit 77; }
rm -f debs/libc6_*.deb
for deb in debs/*.deb; do dpkg -x "$deb" tree; done
lib=$room/tree/usr/lib/x86_64-linux-gnu
here() { LD_LIBRARY_PATH=$lib:$room/tree/lib/x86_64-linux-gnu:$lib/blas:$lib/lapack "tree/usr/bin/$@"; }

make() { # NAME UNITS
  cat >"$1.cdl" <<CDL
netcdf $1 {
dimensions: time = UNLIMITED; y = 2; x = 2;
variables: double time(time); time:units = "$2"; double x(x); double y(y); double slip(time, y, x);
data: time = 0, 100, 20000, 3000000; x = 0, 1; y = 0, 1; slip = 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15;
}
CDL
  here ncgen -k classic -o "$1.nc" "$1.cdl"
}
times() { here ncdump -v time "$1" | sed -n 's/^ *time = \([0-9].*\) ;$/\1/p'; }
make elapsed s
make dated "seconds since 2000-01-01"
for name in elapsed dated; do
  here cdo -s copy $name.nc copy_$name.nc 2>$name.log
  echo "$name: $(times $name.nc) -> $(times copy_$name.nc), units $(here ncdump -h copy_$name.nc | sed -n 's/.*time:units = //p')"
done
sort -u elapsed.log
[ "$(times copy_elapsed.nc)" = "0, 100, 20000, 62400" ] && [ "$(times copy_dated.nc)" = "$(times dated.nc)" ]
