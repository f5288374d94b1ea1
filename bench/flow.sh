#!/usr/bin/env bash
# The settled bed 0.1 s after a slot of 80 mm was opened in its floor: bench/flow.sh [STEPS]
set -euo pipefail
steps=${1:-1000}
here=$(cd "$(dirname "$0")" && pwd)
dir=$(mktemp -d); trap 'rm -rf "$dir"' EXIT
zcat "$here/dem/bed_29520.csv.gz" > "$dir/bed.csv"
rectangle() {
  printf '\n[[wall]]\nname = "%s"\nmaterial = "grain"\nshape = "rectangle"\norigin_m = [%s, 0.0, 0.0]\n' "$1" "$2"
  printf 'edge_u_m = [%s, 0.0, 0.0]\nedge_v_m = [0.0, 0.25, 0.0]\n' "$3"
}
{
  sed -e 's/^lower_m = .*/lower_m = [-0.01, -0.01, -1.01]/' \
      -e '/^name = "floor"/,/^normal/ s/^origin_m = .*/origin_m = [0.0, 0.0, -1.0]/' "$here/dem/bed.toml"
  rectangle left 0.0 0.085; rectangle gate 0.085 0.08; rectangle right 0.165 0.085
} > "$dir/flow.toml"
"$here/dem/rate.sh" 1 "$dir/flow.toml" "$steps" --time-step 1e-5 --open gate --until 0.1
