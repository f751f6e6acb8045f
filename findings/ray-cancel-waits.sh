#!/usr/bin/env bash
# ray 2.60.0: `ray.cancel` of a task that waits for a process, or in one long `time.sleep`, has no effect
# until the waiting is over: the task holds its core for all of that time, and the KeyboardInterrupt that
# the documentation promises comes afterwards. A task that waits in short steps is cancelled at once.
#
# A good guess: KeyboardInterrupt ends `subprocess.run` and `time.sleep` at once, as Ctrl-C does.
#
# Seen, where each task takes 15 s and is cancelled after 2 s:
#   steps: cancelled after 0 s
#   sleep: cancelled after 13 s
#   process: cancelled after 13 s
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check ray==2.60.0
export RAY_USAGE_STATS_ENABLED=0
"$folder/venv/bin/python" -W ignore - <<'EOF'
import subprocess
import time

import ray

ray.init("local", num_cpus=1, include_dashboard=False, log_to_driver=False, logging_level="error")


@ray.remote(max_retries=0)
def steps():
    for _ in range(150):
        time.sleep(0.1)


@ray.remote(max_retries=0)
def sleep():
    time.sleep(15)


@ray.remote(max_retries=0)
def process():
    subprocess.run(["sleep", "15"])


@ray.remote(max_retries=0)
def nothing():
    pass


# So that the worker is there.
ray.get(nothing.remote())
seconds = {}
for name, task in {"steps": steps, "sleep": sleep, "process": process}.items():
    running = task.remote()
    time.sleep(2)
    started = time.monotonic()
    ray.cancel(running)
    try:
        ray.get(running)
    except ray.exceptions.RayError:
        seconds[name] = time.monotonic() - started
    print(f"{name}: cancelled after {seconds[name]:.0f} s")
assert seconds["steps"] < 5
assert min(seconds["sleep"], seconds["process"]) > 10, "Ray behaves differently now"
EOF
