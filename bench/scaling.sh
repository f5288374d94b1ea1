#!/usr/bin/env bash
# The engine on more and more processes, in turn: bench/scaling.sh [ROUNDS [STEPS [RANKS...]]]
# strong: the settled bed. weak: beds side by side, one a process. A line a run, as bench/bed.sh prints it.
set -euo pipefail
rounds=${1:-5} steps=${2:-500}; shift $(( $# < 2 ? $# : 2 ))
[ $# -gt 0 ] || set -- 1 2
here=$(cd "$(dirname "$0")" && pwd)
dir=$(mktemp -d); trap 'rm -rf "$dir"' EXIT
zcat "$here/dem/bed_29520.csv.gz" > "$dir/bed.csv"
cp "$here/dem/bed.toml" "$dir/bed.toml"
for ranks in "$@"; do
  awk -F, -v n="$ranks" 'NR == 1 { print; next } { for (k = 0; k < n; ++k) printf "%.10g,%s,%s,%s\n", $1 + 0.25 * k, $2, $3, $4 }' \
    "$dir/bed.csv" > "$dir/beds_$ranks.csv"
  sed -e "s/bed.csv/beds_$ranks.csv/" -e "s/^upper_m = .*/upper_m = [$(awk -v n="$ranks" 'BEGIN { print 0.25 * n + 0.01 }'), 0.26, 0.9]/" \
      -e "/^name = \"x_high\"/,/^normal/ s/^origin_m = .*/origin_m = [$(awk -v n="$ranks" 'BEGIN { print 0.25 * n }'), 0.0, 0.0]/" \
      "$here/dem/bed.toml" > "$dir/beds_$ranks.toml"
done
for ((round = 0; round < rounds; ++round)); do
  for ranks in "$@"; do
    echo "strong $("$here/dem/rate.sh" "$ranks" "$dir/bed.toml" "$steps" --time-step 1e-5)"
    echo "weak $("$here/dem/rate.sh" "$ranks" "$dir/beds_$ranks.toml" "$steps" --time-step 1e-5)"
  done
done
