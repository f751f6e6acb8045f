"""Environment steps of 64 copies: per core, on two threads, and in two processes."""

import statistics
import subprocess
import sys
import time
from argparse import Namespace
from typing import Any

import numpy as np

from rher.compare.environments import PUSH, make
from rher.compare.part import Measured, Part, ratios
from rher.compare.rate import rate

COPIES = 64

#: Steps the copies and prints steps per second of the wall clock and of the processor.
ALONE = f"""
import sys, time, gymnasium, numpy as np, rher
threads, seconds, start = int(sys.argv[1]), float(sys.argv[2]), float(sys.argv[3])
envs = gymnasium.make_vec("rher/Push-v0", num_envs={COPIES}, threads=threads, copy=False)
envs.reset(seed=0)
actions = np.random.default_rng(0).uniform(-1, 1, (50, {COPIES}, 4)).astype(np.float32)
for action in actions:
    envs.step(action)
while time.time() < start:
    time.sleep(0.001)
wall, cpu, done = time.perf_counter(), time.process_time(), 0
while time.perf_counter() - wall < seconds:
    for action in actions:
        envs.step(action)
        done += {COPIES}
print(done / (time.perf_counter() - wall), done / (time.process_time() - cpu))
"""


def measure(args: Namespace) -> Measured:
    rounds, seconds = (1, 0.5) if args.quick else (5, 4.0)
    rates: dict[str, list[Any]] = {"one_thread": [], "two_threads": [], "two_processes": []}
    theirs = []
    env = make(PUSH[1])
    env.reset(seed=0)
    action = np.zeros(4, np.float32)

    def fetch() -> int:
        env.reset()
        for _ in range(50):
            env.step(action)
        return 50

    for _ in range(rounds):
        theirs.append(rate(time.process_time, seconds / 2, fetch))
        rates["one_thread"] += _processes(1, 1, seconds)
        rates["two_threads"] += _processes(1, 2, seconds)
        rates["two_processes"].append(_processes(2, 1, seconds))
    per_core = statistics.median(cpu for _, cpu in rates["one_thread"])
    one = statistics.median(wall for wall, _ in rates["one_thread"])
    two = statistics.median(wall for wall, _ in rates["two_threads"])
    apart = statistics.median(sum(wall for wall, _ in pair) for pair in rates["two_processes"])
    fetch_rate = statistics.median(theirs)
    return {
        "rates": rates,
        "theirs_rates": theirs,
        "per_core": per_core,
        "theirs": fetch_rate,
        "ratio": per_core / fetch_rate,
        "two_threads": two / one,
        "of_two_processes": two / apart,
    }


def _processes(count: int, threads: int, seconds: float) -> list[tuple[float, float]]:
    """Rates of that many processes at once: of the wall clock and of the processor."""
    start = time.time() + 2.0
    command = [sys.executable, "-c", ALONE, str(threads), str(seconds), str(start)]
    running = [subprocess.Popen(command, stdout=subprocess.PIPE, text=True) for _ in range(count)]
    printed = [process.communicate()[0].split() for process in running]
    if any(process.returncode for process in running):
        raise RuntimeError("a process that steps environments failed; its error is above")
    return [(float(wall), float(cpu)) for wall, cpu in printed]


def lines(found: Measured) -> list[str]:
    what = f"steps per CPU-second of {COPIES} copies, per core"
    return [
        *ratios([(what, found["per_core"], found["theirs"])]),
        f"| {COPIES} copies, two threads to one | {found['two_threads']:.2f} × | | "
        f"{found['of_two_processes']:.0%} of two processes |",
    ]


PART = Part(measure, lines)
