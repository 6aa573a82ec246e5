#!/usr/bin/env bash
# PETSc's DMPlex reads a surface of Gmsh without the third coordinate: a vertical fault has no depth and the area 0.
#
# Seen with PETSc 3.18.5 and Gmsh 4.8.4 (Debian 12). Gmsh's files have three coordinates for each node. DMPlexCreateFromFile() keeps as many
# as the cells have dimensions: of triangles x and y. A vertical square of 1 by 1 becomes a line with the area 0; one that dips by 63
# degrees and has the area 1.118 gets 0.5, that of its map view. No warning, in formats 2.2 and 4.1 alike. Anything computed of it, areas,
# moments, normals, is that of the flat mesh. With the option -dm_plex_gmsh_spacedim 3 all is right. PETSc's repository of August 2026 has
# the same default.
#
# Guess before the run: three coordinates, as they are in the file and do not lie in the plane z = 0.
# Exit code: 0 as seen, 1 when it behaves in another way, 77 when the packages cannot be had.
set -euo pipefail
room=$(mktemp -d)
trap 'rm -rf "$room"' EXIT
cd "$room"
mkdir -p debs/partial tree && : >status
apt-get -qq -y -o Dir::State::status="$room/status" -o Dir::Cache::archives="$room/debs" -o Debug::NoLocking=1 --no-install-recommends \
  --download-only install libpetsc-real3.18=3.18.5+dfsg1-1 libpetsc-real3.18-dev=3.18.5+dfsg1-1 gmsh=4.8.4+ds2-3 >apt.log 2>&1 || { tail -3 apt.log; exit 77; }
rm -f debs/libc6_*.deb debs/libc6-dev_*.deb
for deb in debs/*.deb; do dpkg -x "$deb" tree; done
lib=$room/tree/usr/lib/x86_64-linux-gnu petsc=$(echo "$room"/tree/usr/lib/petscdir/petsc*/x86_64-linux-gnu-real)

cat >try.c <<'C'
#include <petscdmplex.h>

int main(int argc, char **argv)
{
  DM        plex;
  PetscInt  dim, start, end;
  PetscReal low[3] = {0}, high[3] = {0}, area = 0;

  if (PetscInitialize(&argc, &argv, NULL, NULL)) return 2;
  if (DMPlexCreateFromFile(PETSC_COMM_SELF, argv[1], "fault", PETSC_TRUE, &plex)) return 2;
  DMGetCoordinateDim(plex, &dim);
  DMGetBoundingBox(plex, low, high);
  DMPlexGetHeightStratum(plex, 0, &start, &end);
  for (PetscInt cell = start; cell < end; cell++) {
    PetscReal size, center[3], normal[3];

    DMPlexComputeCellGeometryFVM(plex, cell, &size, center, normal);
    area += size;
  }
  printf("coordinates %d, z from %g to %g, area %.3f\n", (int)dim, low[2], high[2], area);
  DMDestroy(&plex);
  PetscFinalize();
  return 0;
}
C
include=$(for folder in "$petsc"/include "$petsc"/../include tree/usr/include tree/usr/lib/x86_64-linux-gnu/openmpi/include; do printf ' -I %s' "$folder"; done)
cc $include try.c -o try -L "$petsc"/lib -lpetsc_real -L "$lib" -lmpi -Wl,--allow-shlib-undefined -lm
export LD_LIBRARY_PATH=$petsc/lib:$lib:$room/tree/lib/x86_64-linux-gnu:$lib/blas:$lib/lapack:$lib/pulseaudio OPAL_PREFIX=$room/tree/usr PMIX_INSTALL_PREFIX=$lib/pmix2 HWLOC_COMPONENTS=-opencl
export OMPI_MCA_mca_base_component_path=$lib/openmpi/lib/openmpi3 OMPI_MCA_ess_singleton_isolated=1 OMPI_MCA_btl=self OMPI_MCA_pml=ob1 PMIX_MCA_gds=hash

seen=true
for north in 0 0.5; do # of the lower edge
  cat >fault.geo <<GEO
Point(1) = {0, 0, 0, 1}; Point(2) = {1, 0, 0, 1}; Point(3) = {1, $north, -1, 1}; Point(4) = {0, $north, -1, 1};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4}; Plane Surface(1) = {1}; Physical Surface("fault", 7) = {1};
GEO
  for format in msh22 msh41; do
    tree/usr/bin/gmsh -nopopup -v 1 -2 -format $format -o fault.msh fault.geo
    plain=$(./try fault.msh 2>>said.txt) asked=$(./try fault.msh -dm_plex_gmsh_spacedim 3)
    echo "$format, lower edge $north north of the upper one: $plain; with -dm_plex_gmsh_spacedim 3: $asked"
    [ "$plain" = "coordinates 2, z from 0 to 0, area $([ $north = 0 ] && echo 0.000 || echo 0.500)" ] || seen=false
    [ "$asked" = "coordinates 3, z from -1 to 0, area $([ $north = 0 ] && echo 1.000 || echo 1.118)" ] || seen=false
  done
done
$seen && [ ! -s said.txt ]
