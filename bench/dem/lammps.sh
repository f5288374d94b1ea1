#!/usr/bin/env bash
# LAMMPS (Debian package lammps, its GRANULAR package) on the settled bed: lammps.sh STEPS [RANKS]
# It has no rolling friction of type C; its sds is of the same cost.
set -euo pipefail
steps=${1:-1000} ranks=${2:-1}
here=$(cd "$(dirname "$0")" && pwd)
dir=$(mktemp -d); trap 'rm -rf "$dir"' EXIT
cd "$dir"
zcat "$here/bed_29520.csv.gz" | awk -F, '
  NR > 1 { row[++n] = n " 1 " 2 * $4 " 3500 " $1 " " $2 " " $3 }
  END {
    print "settled bed\n\n" n " atoms\n1 atom types\n\n0 0.25 xlo xhi\n0 0.25 ylo yhi\n0 0.9 zlo zhi\n\nAtoms # sphere\n"
    for (k = 1; k <= n; ++k) print row[k]
  }' > bed.data
law="hertz/material 2.5e8 0.5 0.25 tangential mindlin NULL 1.0 0.5 rolling sds 1e4 0.01 0.15 damping tsuji"
cat > in.run <<EOF
units si
atom_style sphere
boundary f f f
newton off
comm_modify vel yes
processors * * 1
read_data bed.data
neighbor 0.002 bin
neigh_modify delay 0 every 1 check yes
pair_style granular
pair_coeff * * $law
timestep 1e-5
fix g all gravity 9.81 vector 0 0 -1
fix i all nve/sphere
fix x all wall/gran granular $law xplane 0 0.25
fix y all wall/gran granular $law yplane 0 0.25
fix z all wall/gran granular $law zplane 0 0.9
thermo 1000000
thermo_style custom step atoms ke
run 100
run $steps
EOF
mpirun --allow-run-as-root --oversubscribe --bind-to none -np "$ranks" lmp -in in.run > log 2>&1 ||
  { tail -20 log >&2; exit 1; }
awk -v s="$steps" -v r="$ranks" '/^Loop time/ { t = $4; n = $12 }
  END { if (t == "") exit 1; printf "lammps ranks=%s loop_s=%s sphere_steps_per_s=%.4g\n", r, t, n * s / t }' log
