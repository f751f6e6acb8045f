"""The environments that exist in both packages."""

from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np

#: The same task here and in Gymnasium-Robotics.
PUSH, PICK = ("rher/Push-v0", "FetchPush-v4"), ("rher/PickAndPlace-v0", "FetchPickAndPlace-v4")


def make(name: str) -> gymnasium.Env[Any, Any]:
    """An environment; those of Fetch need their package to be imported."""
    if name.startswith("Fetch"):
        import gymnasium_robotics

        gymnasium.register_envs(gymnasium_robotics)
    return gymnasium.make(name)


def success(
    policy: Callable[[Any], np.ndarray], env: gymnasium.Env[Any, Any], episodes: int
) -> int:
    """How many of these episodes a policy solves, judged at their last step."""
    solved = 0
    for seed in range(episodes):
        seen, info = env.reset(seed=seed)
        done = False
        while not done:
            seen, _, terminated, truncated, info = env.step(policy(seen))
            done = terminated or truncated
        solved += bool(info["is_success"])
    return solved
