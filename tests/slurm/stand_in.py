#!/usr/bin/env python3
"""sbatch, squeue and scancel for tests of what the real ones cannot be made to show.

It is called by the name of one of them and keeps its jobs in the folder where that name stands. Files there that a test
makes change what it does: `down` (no controller answers), `refuse` (sbatch fails with the words in it), `limit` (that
many tasks fit into the queue), `hold` (nothing begins while it is there), `reason` (why jobs are pending), and, each for one call of sbatch, `hide` (takes
the job but the answer is lost), `forget` (the answer is lost, and the job with it), `lose` (takes the job and loses it).
`calls` has a line for each call.
"""
import os
import signal
import subprocess
import sys
import time

HERE = os.path.dirname(os.path.abspath(sys.argv[0]))
JOBS = os.path.join(HERE, "jobs")


def there(name):
    return os.path.exists(os.path.join(HERE, name))


def once(name):
    try:
        os.remove(os.path.join(HERE, name))
        return True
    except FileNotFoundError:
        return False


def fail(words):
    sys.stderr.write(words + "\n")
    sys.exit(1)


def jobs():
    """NUMBER_TASK: (name, state, process)"""
    found = {}
    for job in os.listdir(JOBS):
        if not job.startswith("."):
            try:
                with open(os.path.join(JOBS, job)) as file:
                    found[job] = file.read().split()
            except FileNotFoundError:
                pass
    return found


def write_job(job, name, state):
    temporary = os.path.join(JOBS, "." + job)
    with open(temporary, "w") as file:
        file.write(f"{name} {state} {os.getpid()}")
    os.rename(temporary, os.path.join(JOBS, job))


def run_task(number, task, name, script, output):
    """In a process of its own: the node."""
    job = f"{number}_{task}"
    while there("hold"):
        time.sleep(0.02)
        if not os.path.exists(os.path.join(JOBS, job)):
            return
    write_job(job, name, "RUNNING")
    environment = dict(os.environ, SLURM_ARRAY_JOB_ID=str(number), SLURM_ARRAY_TASK_ID=str(task))
    signal.signal(signal.SIGTERM, signal.SIG_IGN)  # of scancel, for all that the job has started
    with open(output.replace("%a", str(task)), "a") as out:
        subprocess.call(["/bin/bash", script], env=environment, stdin=subprocess.DEVNULL, stdout=out, stderr=out,
                        restore_signals=True, preexec_fn=lambda: signal.signal(signal.SIGTERM, signal.SIG_DFL))
    os.remove(os.path.join(JOBS, job))


def sbatch(arguments):
    options = dict(a[2:].split("=", 1) for a in arguments if a.startswith("--") and "=" in a)
    if there("refuse"):
        fail("sbatch: error: " + open(os.path.join(HERE, "refuse")).read().strip())
    tasks = int(options["array"].split("-")[1]) + 1
    if there("limit") and len(jobs()) + tasks > int(open(os.path.join(HERE, "limit")).read()):
        fail("sbatch: error: QOSMaxSubmitJobPerUserLimit\n"
             "sbatch: error: Batch job submission failed: Job violates accounting/QOS policy (job submit limit)")
    timed_out = "sbatch: error: Batch job submission failed: Socket timed out on send/recv operation"
    if once("forget"):
        fail(timed_out)
    number = 100 + len([line for line in open(os.path.join(HERE, "calls")) if line.startswith("sbatch")])
    if not once("lose"):
        for task in range(tasks):
            write_job(f"{number}_{task}", options["job-name"], "PENDING")
            subprocess.Popen([sys.executable, os.path.join(HERE, "sbatch"), "--node", str(number), str(task),
                              options["job-name"], arguments[-1], options["output"]], start_new_session=True,
                             stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    if once("hide"):
        fail(timed_out)
    print(number)


def squeue():
    reason = open(os.path.join(HERE, "reason")).read() if there("reason") else "Resources"
    for job, (name, state, _) in jobs().items():
        number, task = job.split("_")
        print(f"{name}|{task}|{number}|{state}|{reason if state == 'PENDING' else 'None'}")
    print("somebody-else|N/A|7|RUNNING|None")


def scancel(arguments):
    for job, (_, state, process) in jobs().items():
        if job in arguments:
            if state == "PENDING":
                os.remove(os.path.join(JOBS, job))
            else:
                os.killpg(int(process), signal.SIGTERM)


def main():
    os.makedirs(JOBS, exist_ok=True)
    program, arguments = os.path.basename(sys.argv[0]), sys.argv[1:]
    if arguments[:1] == ["--node"]:
        run_task(int(arguments[1]), int(arguments[2]), *arguments[3:])
        return
    with open(os.path.join(HERE, "calls"), "a") as calls:
        calls.write(" ".join([program] + arguments) + "\n")
    if there("down"):
        fail("slurm_load_jobs error: Unable to contact slurm controller (connect failure)")
    {"sbatch": lambda: sbatch(arguments), "squeue": squeue, "scancel": lambda: scancel(arguments)}[program]()


main()
