"""Relabeled samples per CPU-second, from equally many random episodes of push.

Both replays have room for a million steps, which is the default of both.
"""

import statistics
import time
from argparse import Namespace

import gymnasium
import numpy as np

from rher import _rher
from rher.compare.environments import PUSH
from rher.compare.part import Measured, Part, ratios
from rher.compare.rate import rate


def measure(args: Namespace) -> Measured:
    from stable_baselines3 import HerReplayBuffer
    from stable_baselines3.common.vec_env import DummyVecEnv

    episodes, rows = (100 if args.quick else 2000), 256
    rounds, seconds = (2, 0.3) if args.quick else (7, 2.0)
    env = DummyVecEnv([lambda: gymnasium.make(PUSH[0])])
    theirs = HerReplayBuffer(
        1_000_000, env.observation_space, env.action_space, env, device="cpu"
    )
    rng = np.random.default_rng(0)
    seen = env.reset()
    for _ in range(episodes * 50):
        action = rng.uniform(-1, 1, (1, 4)).astype(np.float32)
        after, rewards, ended, infos = env.step(action)
        end = infos[0].get("terminal_observation")
        real = {key: value[None] for key, value in end.items()} if end else after
        theirs.add(seen, real, action, rewards, ended, infos)
        seen = after
    ours = _rher.Hindsight("push", episodes)

    def draw_theirs() -> int:
        theirs.sample(rows)
        return rows

    def draw_ours() -> int:
        ours.sample(20, rows)
        return 20 * rows

    rates: dict[str, list[float]] = {"rher": [], "sb3": []}
    for _ in range(rounds):
        rates["rher"].append(rate(time.process_time, seconds, draw_ours))
        rates["sb3"].append(rate(time.process_time, seconds, draw_theirs))
    one, other = (statistics.median(rates[name]) for name in ("rher", "sb3"))
    return {"samples_per_cpu_second": rates, "ours": one, "theirs": other, "ratio": one / other}


def lines(found: Measured) -> list[str]:
    what = "relabeled samples per CPU-second, SB3's `HerReplayBuffer`"
    return ratios([(what, found["ours"], found["theirs"])])


PART = Part(measure, lines)
