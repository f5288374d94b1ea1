#!/usr/bin/env bash
# What 8 to 4,096 processes would send and compute, counted by one: bench/decomposition.sh [SPHERES_PER_RANK [RANKS...]]
# 4,096 ranks of 7,000 spheres take some minutes and 3 GB.
set -euo pipefail
spheres=${1:-7000}; shift || true
[ $# -gt 0 ] || set -- 8 64 512 4096
here=$(cd "$(dirname "$0")" && pwd)
build=${BUILD:-$here/../build/release/bin}
dir=$(mktemp -d); trap 'rm -rf "$dir"' EXIT
zcat "$here/dem/bed_29520.csv.gz" > "$dir/bed.csv"
cp "$here/dem/bed.toml" "$dir/bed.toml"
"$build/repose_dry_decomposition" "$dir/bed.toml" "$spheres" "$@"
