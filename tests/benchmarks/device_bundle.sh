#!/usr/bin/env bash
# Packs the program fault, the libraries that it needs, and what device.sh reads into a tar that runs under another distribution, whose driver of
# OpenCL it takes:
#
#   tests/benchmarks/device_bundle.sh [device.tar.gz]     then there: tar xf device.tar.gz && device/device.sh [DEVICE]
set -euo pipefail
tar=$(realpath -m "${1:-device.tar.gz}")
cd "$(dirname "$0")"
. ../setup.sh
slipstep_environment
build=${SLIPSTEP_BUILD:-$PWD/../../build}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
to=$work/device/bundle
mkdir -p "$to/lib" "$to/openmpi/lib"
cmake --install "$build" --prefix "$to" >/dev/null
rm -rf "$to/include" "$to"/lib/*.a "$to/lib/python3" "$to/share/doc" "$to/share/man"
# all libraries but those of the C library, which belong to the system
ldd "$build/bin/fault" | grep -o '/[^ ]*' | grep -v '/libslipstep\|/ld-linux\|/lib\(c\|m\|dl\|rt\|pthread\|resolv\)\.so' | xargs -I{} cp -L {} "$to/lib"
mpi=$(dirname "$(ldd "$build/bin/fault" | grep -o '/[^ ]*libmpi\.so[^ ]*')")
for plugins in "$mpi/openmpi/lib/openmpi3" "$mpi/openmpi"; do
  if [ -d "$plugins" ]; then cp -Lr "$plugins" "$to/openmpi/lib/openmpi3"; break; fi
done
grep -v '^-ts_type\|^-ts_adapt_type\|^-fault_stations\|^-fault_output' ../../examples/seas_bp5.opts >"$to/bp5.opts"
for cell in 1000 250 100; do "${SLIPSTEP_PYTHON:-python3}" ../../examples/make_seas.py bp5 "$to/f$cell.h5" --cell "$cell" >/dev/null; done
cp device.sh "$work/device"
tar -C "$work" -czf "$tar" device
echo "$tar: $(du -m "$tar" | cut -f1) MB"
