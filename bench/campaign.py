#!/usr/bin/env python3
"""What a campaign costs beside its engine: bench/campaign.py [RUNS] [WORKERS]

Runs a campaign with an engine that does nothing but put the output of one real run in place, so that everything else is
what `repose campaign` adds: folders, records, measuring, the process. Prints the table of docs/validation/campaign.md.
BUILD names the folder of the programs.
"""
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

RUNS = int(sys.argv[1]) if len(sys.argv) > 1 else 10000
WORKERS = int(sys.argv[2]) if len(sys.argv) > 2 else 2
BUILD = Path(os.environ.get("BUILD", Path(__file__).parent.parent / "build/release/bin")).resolve()

ENGINE = """#!/bin/sh
mkdir "$3" && ln {output} "$3/run.h5"
"""
CAMPAIGN = """scenario = "scenario.toml"
points = "points.csv"
"""
SCENARIO = """scenario = "drawdown"
preset = "quick"
mass_per_thickness_kg_m = 30
"""


def timed(*command):
    """Wall time in s and largest memory in MB of a command, its children left out."""
    begin = time.monotonic()
    process = subprocess.Popen([str(c) for c in command], stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        sys.exit(f"{command} ended with code {process.returncode}")
    return time.monotonic() - begin, usage.ru_maxrss / 1024


def flushes_per_s(folder):
    """How often a small file can be written, flushed and renamed, as a run's outcome is."""
    begin, count = time.monotonic(), 0
    while time.monotonic() - begin < 1:
        temporary = folder / "flushed.tmp"
        with open(temporary, "w") as file:
            file.write("x" * 1000)
            file.flush()
            os.fsync(file.fileno())
        temporary.rename(folder / "flushed")
        handle = os.open(folder, os.O_RDONLY)
        os.fsync(handle)
        os.close(handle)
        count += 1
    return count


def campaign(folder, output, runs):
    folder.mkdir()
    (folder / "campaign.toml").write_text(CAMPAIGN)
    (folder / "scenario.toml").write_text(SCENARIO)
    (folder / "points.csv").write_text("mu_s_pp\n" + "".join(f"{0.2 + 0.6 * i / runs!r}\n" for i in range(runs)))
    engine = folder / "engine"
    engine.write_text(ENGINE.format(output=output))
    engine.chmod(0o755)
    return engine


def row(what, value, bound=""):
    print(f"| {what} | {value} | {bound} |")


def main():
    repose = BUILD / "repose"
    with tempfile.TemporaryDirectory(dir=os.environ.get("TMPDIR")) as name:
        folder = Path(name)
        (folder / "scenario.toml").write_text(SCENARIO)
        timed(repose, "simulate", folder / "scenario.toml", "--quiet", "-o", folder / "real")
        output = folder / "real/output/run.h5"

        small, large = folder / "small", folder / "large"
        campaign(small, output, max(10, RUNS // 100))
        _, small_memory = timed(repose, "campaign", "run", small, "--quiet", "--workers", WORKERS, "--engine", small / "engine")
        engine = campaign(large, output, RUNS)
        seconds, memory = timed(repose, "campaign", "run", large, "--quiet", "--workers", WORKERS, "--engine", engine)

        alone = 0.0
        for i in range(100):
            alone += timed(engine, "case.toml", "-o", folder / f"alone{i}")[0] / 100
        again, _ = timed(repose, "campaign", "run", large, "--quiet", "--engine", engine)
        status, status_memory = timed(repose, "campaign", "status", large)
        table, table_memory = timed(repose, "campaign", "table", large, "-o", folder / "runs.h5")
        (large / "index.jsonl").unlink()
        without_index, _ = timed(repose, "campaign", "status", large)

        print(f"{RUNS} runs, {WORKERS} at once, {os.cpu_count()} cores, {flushes_per_s(folder)} flushed files a second\n")
        print("| quantity | measured | required |\n|---|---|---|")
        row("overhead of a run beside its engine", f"{1000 * (seconds * WORKERS / RUNS - alone):.1f} ms", "50 ms")
        row("the engine that does nothing, by itself", f"{1000 * alone:.1f} ms")
        row("status", f"{status:.2f} s", "1 s")
        row("status without the index", f"{without_index:.2f} s")
        row("one table of all runs", f"{table:.2f} s", "10 s")
        row("calling the finished campaign again", f"{again:.2f} s")
        row(f"memory of {max(10, RUNS // 100)} runs", f"{small_memory:.0f} MB")
        row(f"memory of {RUNS} runs", f"{memory:.0f} MB", "flat")
        row("memory of status, of the table", f"{status_memory:.0f} MB, {table_memory:.0f} MB")


if __name__ == "__main__":
    main()
