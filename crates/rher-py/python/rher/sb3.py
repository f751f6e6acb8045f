"""The tasks as vector environments of Stable-Baselines3, which has to be installed.

>>> from stable_baselines3 import SAC, HerReplayBuffer
>>> envs = rher.sb3.TaskVecEnv("rher/Push-v0", n_envs=8)
>>> model = SAC("MultiInputPolicy", envs, replay_buffer_class=HerReplayBuffer, learning_starts=1000)
>>> model.learn(100_000)
"""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode
from numpy.typing import NDArray

from rher._arguments import whole
from rher._beginning import beginning
from rher.env import Action, Observation, RewardType
from rher.errors import InputError, MissingError
from rher.vector import TaskVectorEnv

try:
    from stable_baselines3.common.vec_env import VecEnv
except ImportError as error:
    raise MissingError(
        "Stable-Baselines3 is not installed: `pip install 'rher[sb3]'` installs it"
    ) from error

__all__ = ["TaskVecEnv"]

#: Methods of a single environment that `env_method` calls.
METHODS = ("compute_reward", "compute_terminated", "compute_truncated")


class TaskVecEnv(VecEnv):
    """``n_envs`` environments of a task, stepped together in Rust, as a ``VecEnv``.

    It works with ``HerReplayBuffer``, ``VecMonitor`` and ``VecVideoRecorder``, and can be copied and
    pickled.

    :param task: name of the task, or one of :data:`rher.IDS`.
    :param n_envs: number of environments.
    :param seed: of the first environment; by default the next episodes are drawn at random.
    :param threads: as in :class:`rher.TaskVectorEnv`, like the parameters that follow.
    """

    def __init__(
        self,
        task: str,
        n_envs: int = 1,
        *,
        seed: int | None = None,
        threads: int | None = None,
        reward_type: RewardType = "sparse",
        options: Mapping[str, Any] | None = None,
        randomize: Mapping[str, Any] | None = None,
        render_mode: str | None = None,
        width: int = 480,
        height: int = 480,
        max_episode_steps: int | None = None,
    ) -> None:
        n_envs = whole("n_envs", n_envs, 1, 2**31 - 1)
        self._envs = TaskVectorEnv(
            task,
            n_envs,
            threads=threads,
            autoreset_mode=AutoresetMode.SAME_STEP,
            reward_type=reward_type,
            options=options,
            randomize=randomize,
            render_mode=render_mode,
            width=width,
            height=height,
            max_episode_steps=max_episode_steps,
        )
        self.metadata: dict[str, Any] = self._envs.metadata
        self._actions: Action | None = None
        super().__init__(
            n_envs, self._envs.single_observation_space, self._envs.single_action_space
        )
        if seed is not None:
            self.seed(whole("seed", seed, 0, 2**64 - n_envs))

    def reset(self) -> Observation:
        """Starts an episode in every environment: with the seeds and options that ``seed`` and
        ``set_options`` were given, the latter as in :meth:`rher.TaskEnv.reset`.
        """
        objects = self._envs.objects
        chosen = [beginning(options or None, objects) for options in self._options]
        begun = [one or (None, None, None) for one in chosen] if any(chosen) else None
        seeds = None if None in self._seeds else self._seeds
        observations, infos = self._envs.begin(seeds, begun)
        self._reset_seeds()
        self._reset_options()
        solved = infos["is_success"]
        self.reset_infos = [{"is_success": float(one)} for one in solved]
        return observations

    def step_async(self, actions: Action) -> None:
        """Keeps the actions for :meth:`step_wait`."""
        self._actions = actions

    def step_wait(
        self,
    ) -> tuple[Observation, NDArray[np.float32], NDArray[np.bool_], list[dict[str, Any]]]:
        """Acts in every environment for one step.

        Where an episode ended, the next one has begun: its end is in ``terminal_observation``.
        """
        if self._actions is None:
            raise InputError("there are no actions: call step, or step_async before step_wait")
        actions, self._actions = self._actions, None
        observations, rewards, _, dones, info = self._envs.step(actions)
        solved = info["is_success"]
        if dones.any():
            solved = np.where(dones, info["final_info"]["is_success"], solved)
        infos: list[dict[str, Any]] = [
            {"is_success": float(success), "TimeLimit.truncated": bool(done)}
            for success, done in zip(solved, dones, strict=True)
        ]
        for row in np.flatnonzero(dones):
            infos[row]["terminal_observation"] = info["final_obs"][row]
        return observations, rewards.astype(np.float32), dones, infos

    def close(self) -> None:
        """Frees the simulations."""
        self._envs.close()

    def get_state(self) -> bytes:
        """This moment of all environments, for :meth:`set_state`."""
        return self._envs.get_state()

    def set_state(self, state: bytes) -> Observation:
        """Returns to a moment of environments like these, and returns what is observed there."""
        return self._envs.set_state(state)[0]

    def get_images(self) -> Sequence[NDArray[np.uint8] | None]:
        """A picture of every environment, or None for each without a ``render_mode``."""
        return self._envs.render() or [None] * self.num_envs

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        """An attribute of the environments, which is the same for all of them."""
        value = getattr(self._envs.one, attr_name)
        return [value for _ in self._rows(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        """Refused: the environments have no attributes of their own."""
        raise InputError(
            f"`{attr_name}` cannot be set: environments that are stepped together are made once"
        )

    def env_method(
        self, method_name: str, *method_args: Any, indices: Any = None, **method_kwargs: Any
    ) -> list[Any]:
        """Calls a method that needs no episode, such as ``compute_reward``."""
        if method_name not in METHODS:
            raise InputError(
                f"`{method_name}` cannot be called for single environments, expected one of "
                f"{', '.join(METHODS)}"
            )
        method = getattr(self._envs.one, method_name)
        return [method(*method_args, **method_kwargs) for _ in self._rows(indices)]

    def env_is_wrapped(self, wrapper_class: type[Any], indices: Any = None) -> list[bool]:
        """False for all of them."""
        return [False for _ in self._rows(indices)]

    def _rows(self, indices: Any) -> Iterable[int]:
        rows: Iterable[int] = self._get_indices(indices)
        return rows
