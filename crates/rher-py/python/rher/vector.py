"""Many environments of one task, stepped together in Rust."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from rher import _rher
from rher._arguments import whole
from rher.env import TaskEnv, as_seed, options_as_json, spaces_of
from rher.errors import InputError

__all__ = ["TaskVectorEnv"]


class TaskVectorEnv(VectorEnv):
    """``num_envs`` environments like :class:`rher.TaskEnv`, stepped on threads without Python's lock.

    Each row is, bit for bit, what its environment would be alone, whatever ``threads`` is.

    :param task: name of the task.
    :param num_envs: number of environments.
    :param threads: how many step environments at once; by default the number of processors that
        this process may use, and never more than ``num_envs``.
    :param autoreset_mode: when an environment whose episode ended starts its next one: in the
        ``NEXT_STEP``, which ignores its action; in the ``SAME_STEP``, with the end in
        ``info["final_obs"]`` and ``info["final_info"]``; or, ``DISABLED``, with
        ``reset(options={"reset_mask": ...})``.
    :param copy: whether every step returns new arrays; otherwise each step overwrites the arrays of
        the step before.
    :param options: as in :class:`rher.TaskEnv`.
    :param randomize: as in :class:`rher.TaskEnv`.
    :param max_episode_steps: steps after which an episode ends; by default those of the task.
    """

    def __init__(
        self,
        task: str,
        num_envs: int = 1,
        *,
        threads: int | None = None,
        autoreset_mode: str | AutoresetMode = AutoresetMode.NEXT_STEP,
        copy: bool = True,
        options: dict[str, Any] | None = None,
        randomize: dict[str, Any] | None = None,
        max_episode_steps: int | None = None,
        render_mode: str | None = None,
    ) -> None:
        if render_mode is not None:
            raise InputError(
                f"render_mode is {render_mode!r}, expected None: environments that are stepped "
                "together draw no pictures. gymnasium.make_vec(..., vectorization_mode=\"sync\") does"
            )
        self.num_envs = whole("num_envs", num_envs, 1, 2**31 - 1)
        if threads is not None:
            threads = whole("threads", threads, 1, 2**16)
        try:
            self.autoreset_mode = AutoresetMode(autoreset_mode)
        except ValueError:
            modes = ", ".join(mode.value for mode in AutoresetMode)
            raise InputError(f"autoreset_mode is {autoreset_mode!r}, expected {modes}") from None
        self.metadata = {"render_modes": [], "autoreset_mode": self.autoreset_mode}
        one = TaskEnv(task, options=options, randomize=randomize)
        if max_episode_steps is not None:
            max_episode_steps = whole("max_episode_steps", max_episode_steps, 1, 2**31 - 1)
        self._one = one
        self.single_observation_space, self.single_action_space = spaces_of(one._env)
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self._envs = _rher.VectorEnv(
            {
                "task": task,
                "options": options_as_json(options, randomize),
                "envs": self.num_envs,
                "threads": threads,
                "auto_reset": self.autoreset_mode.value,
                "copy": copy,
                "episode_steps": max_episode_steps,
            }
        )

    def reset(
        self,
        *,
        seed: int | Sequence[int] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
        """Starts an episode in every environment.

        :param seed: of the first environment, the others having the numbers after it; or a seed
            for each of them. Without one, the episodes that follow from the last seeds.
        :param options: ``{"reset_mask": mask}`` starts episodes only where the mask, ``(num_envs,)``
            and boolean, is true.
        """
        options = dict(options or {})
        mask = options.pop("reset_mask", None)
        if options:
            raise InputError(f"reset takes no options but reset_mask, got {options}")
        if mask is not None:
            if seed is not None:
                raise InputError("reset takes a seed or a reset_mask, not both")
            mask = np.asarray(mask)
            if mask.shape != (self.num_envs,) or mask.dtype != np.bool_:
                raise InputError(
                    f"reset_mask is {mask.dtype} of shape {mask.shape}, expected bool of "
                    f"({self.num_envs},)"
                )
            return self._envs.reset_where(mask.tolist())
        if seed is None:
            if self._envs.is_seeded:
                return self._envs.reset()
            return self._envs.reset(self.np_random.integers(2**63, size=self.num_envs).tolist())
        if np.ndim(seed) == 0:
            first = whole("seed", seed, 0, 2**64 - self.num_envs)
            super().reset(seed=first)
            return self._envs.reset(list(range(first, first + self.num_envs)))
        seeds = [as_seed(one) for one in seed]
        if len(seeds) != self.num_envs or None in seeds:
            raise InputError(f"there are seeds {seeds}, expected one for each of {self.num_envs}")
        return self._envs.reset(seeds)

    def step(
        self, actions: np.ndarray
    ) -> tuple[dict[str, np.ndarray], np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """Acts in every environment for one step; ``actions`` are ``(num_envs, action)``."""
        result = self._envs.step(actions)
        if self.autoreset_mode is AutoresetMode.SAME_STEP and (ended := result[3]).any():
            info = result[4]
            last, info["final_info"] = self._envs.last()
            info["final_obs"] = np.full(self.num_envs, None, dtype=object)
            for row in np.flatnonzero(ended):
                info["final_obs"][row] = {name: array[row] for name, array in last.items()}
            info["_final_obs"], info["_final_info"] = ended.copy(), ended.copy()
        return result

    def get_state(self) -> bytes:
        """This moment of all environments, for :meth:`set_state`.
        """
        return self._envs.get_state()

    def set_state(self, state: bytes) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
        """Returns to a moment of environments like these: observations and infos.

        The running episodes are simulated again, so this takes as long as they did. What follows
        is, bit for bit, what followed there.
        """
        if not isinstance(state, bytes):
            raise InputError(f"state is {state!r}, expected what get_state returned")
        return self._envs.set_state(state)

    def compute_reward(
        self, achieved_goal: np.ndarray, desired_goal: np.ndarray, info: Any
    ) -> np.ndarray:
        """Rewards of goals ``(..., 3 * objects)``: ``(...)``, -1 or 0; ``info`` is not used."""
        return self._one.compute_reward(achieved_goal, desired_goal, info)

    def close_extras(self, **kwargs: Any) -> None:
        """Frees the simulations."""
        self._envs.close()
