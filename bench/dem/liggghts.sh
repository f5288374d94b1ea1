#!/usr/bin/env bash
# LIGGGHTS (Debian package liggghts) on the beds of this folder: liggghts.sh bed|flow STEPS [RANKS]
# flow: the floor has a slot of 80 mm; the clock starts after 0.1 s.
set -euo pipefail
which=$1 steps=${2:-1000} ranks=${3:-1}
here=$(cd "$(dirname "$0")" && pwd)
dir=$(mktemp -d); trap 'rm -rf "$dir"' EXIT
cd "$dir"
low=0; if [ "$which" = flow ]; then low=-1; fi
zcat "$here/bed_29520.csv.gz" | awk -F, -v low=$low '
  NR > 1 { row[++n] = n " 1 " 2 * $4 " 3500 " $1 " " $2 " " $3 }
  END {
    print "settled bed\n\n" n " atoms\n1 atom types\n\n0 0.25 xlo xhi\n0 0.25 ylo yhi\n" low " 0.9 zlo zhi\n\nAtoms\n"
    for (k = 1; k <= n; ++k) print row[k]
  }' > bed.data

# Two triangles of a rectangle in the plane z = 0, from x = $1 to x = $2.
rectangle() {
  printf 'facet normal 0 0 1\nouter loop\nvertex %s 0 0\nvertex %s 0 0\nvertex %s 0.25 0\nendloop\nendfacet\n' "$1" "$2" "$2"
  printf 'facet normal 0 0 1\nouter loop\nvertex %s 0 0\nvertex %s 0.25 0\nvertex %s 0.25 0\nendloop\nendfacet\n' "$1" "$2" "$1"
}
law="hertz tangential history rolling_friction epsd"
warm=100 floor="fix z0 all wall/gran model $law primitive type 1 zplane 0.0"
if [ "$which" = flow ]; then
  warm=10000
  { echo "solid floor"; rectangle 0 0.085; rectangle 0.165 0.25; echo "endsolid floor"; } > floor.stl
  floor="fix mesh all mesh/surface file floor.stl type 1
fix z0 all wall/gran model $law mesh n_meshes 1 meshes mesh
fix z1 all wall/gran model $law primitive type 1 zplane -1.0"
fi
cat > in.run <<EOF
units si
atom_style granular
atom_modify map array
boundary f f f
newton off
communicate single vel yes
processors * * 1
read_data bed.data
neighbor 0.002 bin
neigh_modify delay 0
fix e all property/global youngsModulus peratomtype 2.5e8
fix nu all property/global poissonsRatio peratomtype 0.25
fix cor all property/global coefficientRestitution peratomtypepair 1 0.5
fix mu all property/global coefficientFriction peratomtypepair 1 0.5
fix mur all property/global coefficientRollingFriction peratomtypepair 1 0.15
fix etar all property/global coefficientRollingViscousDamping peratomtypepair 1 0.3
pair_style gran model $law
pair_coeff * *
timestep 1e-5
fix g all gravity 9.81 vector 0 0 -1
fix x0 all wall/gran model $law primitive type 1 xplane 0.0
fix x1 all wall/gran model $law primitive type 1 xplane 0.25
fix y0 all wall/gran model $law primitive type 1 yplane 0.0
fix y1 all wall/gran model $law primitive type 1 yplane 0.25
$floor
fix i all nve/sphere
thermo_style custom step atoms ke
thermo 1000000
thermo_modify lost ignore norm no
run $warm
run $steps
EOF
mpirun --allow-run-as-root --oversubscribe --bind-to none -np "$ranks" liggghts -in in.run > log 2>&1 ||
  { tail -20 log >&2; exit 1; }
awk -v s="$steps" -v r="$ranks" '/^Loop time/ { t = $4; n = $12 }
  END { if (t == "") exit 1; printf "liggghts ranks=%s loop_s=%s sphere_steps_per_s=%.4g\n", r, t, n * s / t }' log
