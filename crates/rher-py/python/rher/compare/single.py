"""Environment steps per CPU-second, one environment, random actions, with resets."""

import statistics
import time
from argparse import Namespace
from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np

from rher.compare.environments import PUSH, make
from rher.compare.part import Measured, Part, ratios
from rher.compare.rate import rate


def measure(args: Namespace) -> Measured:
    rounds, seconds = (2, 0.5) if args.quick else (7, 3.0)
    actions = np.random.default_rng(0).uniform(-1, 1, (50, 4)).astype(np.float32)

    def episode(env: gymnasium.Env[Any, Any]) -> Callable[[], int]:
        def play() -> int:
            env.reset()
            for action in actions:
                env.step(action)
            return len(actions)

        return play

    envs = {name: make(name) for name in PUSH}
    rates: dict[str, list[float]] = {name: [] for name in PUSH}
    for env in envs.values():
        env.reset(seed=0)
    # Round by round, so that whatever else runs on the machine slows both.
    for _ in range(rounds):
        for name, env in envs.items():
            rates[name].append(rate(time.process_time, seconds, episode(env)))
    ours, theirs = (statistics.median(rates[name]) for name in PUSH)
    return {"steps_per_cpu_second": rates, "ours": ours, "theirs": theirs, "ratio": ours / theirs}


def lines(found: Measured) -> list[str]:
    what = "steps per CPU-second, `rher/Push-v0` and `FetchPush-v4`"
    return ratios([(what, found["ours"], found["theirs"])])


PART = Part(measure, lines)
