#!/usr/bin/env bash
# Spheres in clumps of three, or as many single spheres of the same mass, fallen into a box and at
# rest there, about 0.04 m deep for any number of clumps: bench/clumps.sh clumps|spheres [STEPS] [CLUMPS]
set -euo pipefail
which=$1 steps=${2:-300} clumps=${3:-25000}
here=$(cd "$(dirname "$0")" && pwd)
build=${BUILD:-$here/../build/release/bin}
dir=$(mktemp -d); trap 'rm -rf "$dir"' EXIT
# A clump has the volume of a sphere of 10 mm, a single sphere a third of it.
diameter=0.010 clump='clump = "sinter_3"'
if [ "$which" = spheres ]; then diameter=0.0069336 clump=; fi
mass=$(awk -v n="$clumps" 'BEGIN { print n * 3.14159265 / 6 * 1e-6 * 2500 }')
height=0.12 side=$(awk -v n="$clumps" 'BEGIN { print 0.3 * sqrt(n / 4000) }')
edge=$(awk -v s="$side" 'BEGIN { print s + 0.02 }')
cat > "$dir/box.toml" <<EOF
[run]
time_step_rayleigh_fraction = 0.25

[domain]
lower_m = [-0.02, -0.02, -0.02]
upper_m = [$edge, $edge, 1.0]

[[material]]
name = "grain"
density_kg_m3 = 2500.0
youngs_modulus_pa = 1e7
poissons_ratio = 0.25

[[pair]]
materials = ["grain", "grain"]
restitution = 0.3
mu_s = 0.5
mu_r = 0.1

[[box]]
name = "bin"
material = "grain"
lower_m = [0.0, 0.0, 0.0]
upper_m = [$side, $side, 1.0]
open = ["+z"]

[fill]
lower_m = [0.0, 0.0, 0.0]
upper_m = [$side, $side, $height]
solid_fraction = 0.25

[[fill.layer]]
material = "grain"
$clump
mass_kg = $mass
sizes = [{diameter_m = $diameter, mass_fraction = 1.0}]

[[stage]]
name = "rest"
duration_s = 1.0
EOF
"$build/repose_dem_rate" "$dir/box.toml" "$steps" --until "${UNTIL:-0.3}"
