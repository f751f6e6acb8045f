"""Environments of other packages, and how a policy does in them."""

import importlib
from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np

from rher.compare.foreign_tasks import Task
from rher.compare.part import Measured

#: The first seed of the episodes that judge; training draws its own from 2**31.
UNSEEN = 1_000_000


class WholeEpisodes(gymnasium.Wrapper[Any, Any, Any, Any]):
    """Goes on after success until the time is up, so that what is solved has to stay so."""

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        seen, reward, _, truncated, info = self.env.step(action)
        return seen, reward, False, truncated, info


def make(name: str, task: Task, episode_steps: int | None = None) -> gymnasium.Env[Any, Any]:
    """The environment as its package registers it, but for the steps of an episode."""
    module = importlib.import_module(task.package)
    gymnasium.register_envs(module)
    return gymnasium.make(
        name, max_episode_steps=episode_steps, disable_env_checker=True, **task.make
    )


def judge(
    policy: Callable[[Any], np.ndarray], env: gymnasium.Env[Any, Any], task: Task, episodes: int
) -> Measured:
    """How many unseen episodes a policy solves.

    ``solved`` counts those that the environment calls a success when it ends them: many end at the
    first success. ``held`` counts those that are one at the time limit, and ``placed`` those in
    which each object is within the tolerance of training of its place then.
    """
    counts = {"episodes": episodes, "solved": 0, "held": 0, "placed": 0}
    for episode in range(episodes):
        seen, _ = env.reset(seed=UNSEEN + episode)
        solved, truncated = None, False
        while not truncated:
            seen, _, terminated, truncated, info = env.step(policy(seen))
            if solved is None and (terminated or truncated):
                solved = bool(info[task.success])
        away = np.subtract(seen["achieved_goal"], seen["desired_goal"])
        away = away.reshape(max(task.objects, 1), -1)
        counts["solved"] += bool(solved)
        counts["held"] += bool(info[task.success])
        counts["placed"] += bool((np.linalg.norm(away, axis=1) < task.tolerance).all())
    return counts
