#!/usr/bin/env bash
# VTK's windowed sinc filter, which smooths surfaces, moves them by a share of their distance from the origin: 6.4 km in UTM coordinates.
#
# Seen with VTK 9.1.0 (Debian 12). vtkWindowedSincPolyDataFilter with its defaults, 20 iterations and a pass band of 0.1, multiplies what is
# smooth by 0.99839. A plane of 20 km by 14 km of 800 triangles is flat already; at eastings of 500 km and northings of 4000 km it moves by
# 0.8 km to the west and 6.4 km to the south, in one piece, so that nothing shows. At 50 iterations it moves by 6.7 km to the north. Its
# size changes by the same share, and its area by 0.3 %, wherever it lies. NormalizeCoordinatesOn(), off by default, keeps it in place.
# vtkSmoothPolyDataFilter leaves the plane as it is.
#
# Guess before the run: a plane stays where it is, or its corners become round.
# Exit code: 0 as seen, 1 when it behaves in another way, 77 when the packages cannot be had.
set -euo pipefail
room=$(mktemp -d)
trap 'rm -rf "$room"' EXIT
cd "$room"
mkdir -p debs/partial tree && : >status
apt-get -qq -y -o Dir::State::status="$room/status" -o Dir::Cache::archives="$room/debs" -o Debug::NoLocking=1 --no-install-recommends \
  --download-only install python3-vtk9=9.1.0+really9.1.0+dfsg2-5+deb12u1 >apt.log 2>&1 || { tail -3 apt.log; exit 77; }
rm -f debs/libc6_*.deb debs/libc6-dev_*.deb
for deb in debs/*.deb; do dpkg -x "$deb" tree; done
lib=$room/tree/usr/lib/x86_64-linux-gnu
export LD_LIBRARY_PATH=$lib:$room/tree/lib/x86_64-linux-gnu:$room/tree/usr/lib:$lib/blas:$lib/lapack HWLOC_COMPONENTS=-opencl OPENBLAS_NUM_THREADS=1

PYTHONHOME=$room/tree/usr tree/usr/bin/python3.11 - <<'PY'
import sys
sys.path.insert(0, "tree/usr/lib/python3/dist-packages")
from vtkmodules.vtkCommonCore import vtkVersion
from vtkmodules.vtkFiltersCore import vtkMassProperties, vtkSmoothPolyDataFilter, vtkTriangleFilter, vtkWindowedSincPolyDataFilter
from vtkmodules.vtkFiltersSources import vtkPlaneSource


def plane(east, north):
    source, triangles = vtkPlaneSource(), vtkTriangleFilter()
    source.SetOutputPointsPrecision(1)  # doubles
    source.SetResolution(20, 20)
    source.SetOrigin(east, north, -5e3)
    source.SetPoint1(east + 20e3, north, -5e3)
    source.SetPoint2(east, north + 10e3, -15e3)
    triangles.SetInputConnection(source.GetOutputPort())
    triangles.Update()
    return triangles.GetOutput()


def smooth(name, filter, east, north):
    mass = vtkMassProperties()
    surface = plane(east, north)
    filter.SetInputData(surface)
    filter.Update()
    mass.SetInputData(filter.GetOutput())
    moved = [b - a for a, b in zip(surface.GetCenter(), filter.GetOutput().GetCenter())]
    print(f"{name} at {east:.0f}, {north:.0f}: center moved by", *(f"{m:.1f}" for m in moved), f"m, area {mass.GetSurfaceArea() / 1e6:.2f} km2")
    return moved


def sinc(**settings):
    filter = vtkWindowedSincPolyDataFilter()
    for name, value in settings.items():
        getattr(filter, "Set" + name)(value)
    return filter


print("VTK", vtkVersion().GetVTKVersion())
far = smooth("defaults", sinc(), 5e5, 4e6)
more = smooth("50 iterations", sinc(NumberOfIterations=50), 5e5, 4e6)
near = smooth("defaults", sinc(), -1e4, -5e3)
kept = smooth("NormalizeCoordinates", sinc(NormalizeCoordinates=1), 5e5, 4e6)
other = smooth("vtkSmoothPolyDataFilter", vtkSmoothPolyDataFilter(), 5e5, 4e6)
share = far[1] / 4.005e6
print(f"a smooth surface is multiplied by {1 + share:.5f}")
seen = abs(far[1] + 6448) < 2 and abs(far[0] + 821) < 2 and more[1] > 6e3 and max(map(abs, near)) < 20
sys.exit(not (seen and max(map(abs, kept)) < 1e-6 and max(map(abs, other)) < 1e-6))
PY
