#!/usr/bin/env bash
# Runs the engine on the settled bed and prints its sphere-steps per second: bench/bed.sh [STEPS [RANKS]]
# BUILD names the folder of the programs, COMPAT=liggghts takes the peer's order of the contact history.
set -euo pipefail
steps=${1:-1000} ranks=${2:-1}
here=$(cd "$(dirname "$0")" && pwd)
build=${BUILD:-$here/../build/release/bin}
dir=$(mktemp -d); trap 'rm -rf "$dir"' EXIT
zcat "$here/dem/bed_29520.csv.gz" > "$dir/bed.csv"
cp "$here/dem/bed.toml" "$dir/bed.toml"
if [ -n "${COMPAT:-}" ]; then printf '\n[contact]\ncompat = "%s"\n' "$COMPAT" >> "$dir/bed.toml"; fi
launch=()
if [ "$ranks" -gt 1 ]; then launch=(mpirun --allow-run-as-root --oversubscribe --bind-to none -np "$ranks"); fi
"${launch[@]}" "$build/repose_dem_rate" "$dir/bed.toml" "$steps" --time-step 1e-5
