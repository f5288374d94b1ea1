#!/usr/bin/env bash
# The draw-down at the thesis' scale (dem/drawdown_thesis.toml), timed while it fills or while it flows:
# bench/drawdown.sh fill|flow [STEPS [RANKS]]   flow simulates 0.6 s first, some ten minutes on two processes.
set -euo pipefail
which=$1 steps=${2:-2000} ranks=${3:-2}
here=$(cd "$(dirname "$0")" && pwd)
when=(--until 0.1)
if [ "$which" = flow ]; then when=(--open gate --open-at 0.4 --until 0.6); fi
"$here/dem/rate.sh" "$ranks" "$here/dem/drawdown_thesis.toml" "$steps" "${when[@]}"
