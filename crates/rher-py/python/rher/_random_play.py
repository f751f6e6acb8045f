"""Episodes of random actions, to look at an environment before training."""

from dataclasses import dataclass, field
from typing import Any

import gymnasium
import numpy as np
from numpy.typing import NDArray

from rher._about import KEYS
from rher.errors import EnvError

__all__ = ["Episode", "play"]

#: Steps for which an action is kept, so that something moves.
KEPT = 5


@dataclass
class Episode:
    """An episode of T steps."""

    #: ``[T + 1, observation]``.
    observation: list[NDArray[Any]] = field(default_factory=list)
    #: ``[T + 1, goal]``.
    achieved: list[NDArray[Any]] = field(default_factory=list)
    #: ``[T + 1, goal]``.
    desired: list[NDArray[Any]] = field(default_factory=list)
    #: ``[T, action]``, within -1 and 1.
    actions: list[NDArray[Any]] = field(default_factory=list)
    #: ``[T]``.
    rewards: list[float] = field(default_factory=list)
    #: ``[T]``.
    infos: list[dict[str, Any]] = field(default_factory=list)
    #: Whether the environment ended it with ``terminated``.
    is_terminated: bool = False

    def _add(self, seen: Any) -> None:
        numbers = [np.array(seen[key], dtype=np.float64) for key in KEYS]
        for key, part in zip(KEYS, numbers, strict=True):
            if not np.all(np.isfinite(part)):
                raise EnvError(f"{key} is {part}, expected finite numbers")
        for frames, part in zip(
            (self.observation, self.achieved, self.desired), numbers, strict=True
        ):
            frames.append(part)


def play(env: gymnasium.Env[Any, Any], steps: int, episode_steps: int) -> list[Episode]:
    """Episodes of at least so many steps together, always the same ones."""
    rng = np.random.default_rng(0)
    low, high = env.action_space.low, env.action_space.high  # type: ignore[attr-defined]
    episodes: list[Episode] = []
    taken = 0
    try:
        while taken < steps:
            episode = Episode()
            episodes.append(episode)
            seen, _ = env.reset(seed=len(episodes))
            episode._add(seen)
            action = np.zeros(0)
            for step in range(episode_steps):
                if step % KEPT == 0:
                    action = rng.uniform(-1.0, 1.0, low.shape)
                scaled = (low + (high - low) * (action + 1.0) / 2.0).astype(low.dtype)
                seen, reward, terminated, truncated, info = env.step(np.clip(scaled, low, high))
                episode._add(seen)
                episode.actions.append(action)
                episode.rewards.append(float(reward))
                episode.infos.append(info)
                taken += 1
                if terminated or truncated:
                    episode.is_terminated = bool(terminated)
                    break
    except EnvError:
        raise
    except Exception as error:
        raise EnvError(f"the environment cannot be played: {error!r}") from error
    return episodes
