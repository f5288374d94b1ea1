#!/usr/bin/env bash
# repose_dem_rate on so many processes: bench/dem/rate.sh RANKS CASE STEPS [OPTIONS]
set -euo pipefail
ranks=$1; shift
program=${BUILD:-$(cd "$(dirname "$0")/../.." && pwd)/build/release/bin}/repose_dem_rate
if [ "$ranks" -gt 1 ]; then exec mpirun --allow-run-as-root --oversubscribe --bind-to none -np "$ranks" "$program" "$@"; fi
exec "$program" "$@"
