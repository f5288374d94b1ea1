#!/usr/bin/env python3
"""What a campaign through SLURM costs beside SLURM itself: bench/slurm.py [RUNS] [MAX_JOBS], as root

Brings up a SLURM of one node (tests/slurm/one_node), sends a job array of RUNS tasks that do nothing through it, then a
campaign whose engine only puts the output of one real run in place, all of it in the queue at once if MAX_JOBS is not
given. Prints the table of docs/validation/campaign.md. BUILD names the folder of the programs.
"""
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

RUNS = int(sys.argv[1]) if len(sys.argv) > 1 else 200
MAX_JOBS = int(sys.argv[2]) if len(sys.argv) > 2 else RUNS
ROOT = Path(__file__).resolve().parent.parent
BUILD = Path(os.environ.get("BUILD", ROOT / "build/release/bin")).resolve()
ONE_NODE = ROOT / "tests/slurm/one_node"

ENGINE = """#!/bin/sh
date +%s.%N > "${{1%/*}}/began"
mkdir "$3" && ln {output} "$3/run.h5"
"""
CAMPAIGN = """scenario = "scenario.toml"
points = "points.csv"
[compute]
executor = "slurm"
[slurm]
max_jobs = {max_jobs}
"""
SCENARIO = """scenario = "drawdown"
preset = "quick"
mass_per_thickness_kg_m = 30
"""


def call(*command, **options):
    return subprocess.run([str(c) for c in command], check=True, stdout=subprocess.PIPE, text=True, **options).stdout


def array_of_nothing(folder):
    """Seconds until SLURM has done it."""
    script = folder / "nothing.sh"
    script.write_text("#!/bin/sh\nexec true\n")
    begin = time.monotonic()
    call("sbatch", f"--array=0-{RUNS - 1}", "--output=/dev/null", script)
    while call("squeue", "--noheader"):
        time.sleep(0.2)
    return time.monotonic() - begin


def campaign(folder, output):
    """Seconds of the campaign, and from its start to that of the first and last engine."""
    place = folder / "c"
    place.mkdir()
    (place / "scenario.toml").write_text(SCENARIO)
    (place / "campaign.toml").write_text(CAMPAIGN.format(max_jobs=MAX_JOBS))
    (place / "points.csv").write_text("mu_s_pp\n" + "".join(f"{0.3 + 0.4 * i / RUNS:.9f}\n" for i in range(RUNS)))
    engine = folder / "engine"
    engine.write_text(ENGINE.format(output=output))
    engine.chmod(0o755)
    clock, begin = time.time(), time.monotonic()
    call(BUILD / "repose", "campaign", "run", place, "--engine", engine, "--quiet")
    seconds = time.monotonic() - begin
    began = [float(file.read_text()) - clock for file in place.glob("runs/*/began")]
    assert len(began) == RUNS, f"{len(began)} of {RUNS} engines were started"
    return seconds, min(began), max(began)


def main():
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        os.environ["SLURM_CONF"] = str(folder / "node/slurm.conf")
        (folder / "scenario.toml").write_text(SCENARIO)
        call(BUILD / "repose", "simulate", folder / "scenario.toml", "-o", folder / "one", "--quiet")
        call(ONE_NODE, "start", folder / "node")
        try:
            if (folder / "node/unavailable").exists():
                sys.exit((folder / "node/unavailable").read_text())
            nothing = array_of_nothing(folder)
            seconds, first, last = campaign(folder, folder / "one/output/run.h5")
        finally:
            call(ONE_NODE, "stop", folder / "node")
    print(f"{RUNS} runs, {MAX_JOBS} in the queue at most, {os.cpu_count()} cores")
    print(f"SLURM by itself, tasks that do nothing  {nothing:7.2f} s  {1e3 * nothing / RUNS:7.1f} ms a run")
    print(f"the campaign                            {seconds:7.2f} s  {1e3 * seconds / RUNS:7.1f} ms a run")
    print(f"from its start to that of the first run {first:7.2f} s")
    print(f"from that of the last run to its end    {seconds - last:7.2f} s")


if __name__ == "__main__":
    main()
