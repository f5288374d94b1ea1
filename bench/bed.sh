#!/usr/bin/env bash
# Runs the engine on the settled bed and prints its sphere-steps per second: bench/bed.sh [STEPS [RANKS]]
# BUILD names the folder of the programs, COMPAT=liggghts takes the peer's order of the contact history.
set -euo pipefail
steps=${1:-1000} ranks=${2:-1}
here=$(cd "$(dirname "$0")" && pwd)
dir=$(mktemp -d); trap 'rm -rf "$dir"' EXIT
zcat "$here/dem/bed_29520.csv.gz" > "$dir/bed.csv"
cp "$here/dem/bed.toml" "$dir/bed.toml"
if [ -n "${COMPAT:-}" ]; then printf '\n[contact]\ncompat = "%s"\n' "$COMPAT" >> "$dir/bed.toml"; fi
"$here/dem/rate.sh" "$ranks" "$dir/bed.toml" "$steps" --time-step 1e-5
