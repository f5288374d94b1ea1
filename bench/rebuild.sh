#!/usr/bin/env bash
# What a build of the neighbor lists of the settled bed costs, without and with a large sphere in it.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
build=${BUILD:-$here/../build/release/bin}
dir=$(mktemp -d); trap 'rm -rf "$dir"' EXIT
zcat "$here/dem/bed_29520.csv.gz" > "$dir/bed.csv"
cp "$here/dem/bed.toml" "$dir/bed.toml"
"$build/repose_rebuild_rate" "$dir/bed.toml"
