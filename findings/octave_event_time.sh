#!/usr/bin/env bash
# Octave's ode45 finds the time of an event by a straight line through its step: a smaller tolerance can make it worse.
#
# Seen with Octave 7.3.0 (Debian 12). y' = -y from 1 falls to one half at ln 2. At RelTol = AbsTol = 1e-3 the time of the event is
# 3.7e-3 too late, at 1e-6 it is 6.4e-3 too late, though the solution itself is right to 3e-7 and 1e-7: the event is put where the
# chord of the step crosses. The reported state is 0.5 exactly, as if the event had been met. ode15s, by SUNDIALS, is 600 times closer
# at 1e-6. For an onset or a stop use MaxStep, or refine by hand.
#
# Guess before the run: the time of an event is as exact as the solution, as in MATLAB, whose interface it is.
# Exit code: 0 as seen, 1 when it behaves in another way, 77 when the packages cannot be had.
set -euo pipefail
room=$(mktemp -d)
trap 'rm -rf "$room"' EXIT
cd "$room"
mkdir -p debs/partial tree && : >status
apt-get -qq -y -o Dir::State::status="$room/status" -o Dir::Cache::archives="$room/debs" -o Debug::NoLocking=1 \
  --no-install-recommends --download-only install octave=7.3.0-2 >apt.log 2>&1 || { tail -3 apt.log; exit 77; }
rm -f debs/libc6_*.deb debs/libc6-dev_*.deb
for deb in debs/*.deb; do dpkg -x "$deb" tree; done
lib=$room/tree/usr/lib/x86_64-linux-gnu
export LD_LIBRARY_PATH=$lib:$room/tree/lib/x86_64-linux-gnu:$room/tree/usr/lib:$lib/blas:$lib/lapack:$lib/pulseaudio:$lib/octave/7.3.0
export OCTAVE_HOME=$room/tree/usr OCTAVE_EXEC_HOME=$room/tree/usr HWLOC_COMPONENTS=-opencl OPENBLAS_NUM_THREADS=1

cat >try.m <<'M'
1;
warning("off", "all");
function [value, stops, direction] = half(t, y)
  value = y(1) - 0.5; stops = 1; direction = 0;
end
seen = true;
late = [];
for tol = [1e-3 1e-6]
  o = odeset("RelTol", tol, "AbsTol", tol);
  [t, y] = ode45(@(t, y) -y, [0 3], 1, o);
  [~, ~, te, ye] = ode45(@(t, y) -y, [0 3], 1, odeset(o, "Events", @half));
  [~, ~, ts] = ode15s(@(t, y) -y, [0 3], 1, odeset(o, "Events", @half));
  printf("tolerance %g: ode45 right to %.1e, its event late by %.2e, state there off by %.0e; ode15s late by %.2e\n", tol, ...
    max(abs(y - exp(-t))), te(1) - log(2), ye(1) - 0.5, ts(1) - log(2));
  late(end + 1) = te(1) - log(2);
  seen = seen && max(abs(y - exp(-t))) < tol && late(end) > 3 * tol && abs(ye(1) - 0.5) < 1e-14;
end
exit(!(seen && late(2) > late(1)));
M
tree/usr/bin/octave-cli --no-gui --no-init-file --no-site-file -q try.m 2>error.txt || { cat error.txt; exit 1; }
