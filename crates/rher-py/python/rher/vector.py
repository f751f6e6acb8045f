"""Many environments of one task, stepped together in Rust."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import ArrayLike, NDArray

from rher import _rher
from rher._arguments import whole
from rher._beginning import Beginning, beginnings
from rher.env import Action, Observation, RewardType, TaskEnv, as_seed, options_as_json, spaces_of
from rher.errors import InputError

__all__ = ["TaskVectorEnv"]


class TaskVectorEnv(VectorEnv[Observation, Action, NDArray[Any]]):
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
    :param reward_type: as in :class:`rher.TaskEnv`, like the parameters that follow.
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
        reward_type: RewardType = "sparse",
        options: Mapping[str, Any] | None = None,
        randomize: Mapping[str, Any] | None = None,
        render_mode: str | None = None,
        width: int = 480,
        height: int = 480,
        max_episode_steps: int | None = None,
    ) -> None:
        self.num_envs = whole("num_envs", num_envs, 1, 2**31 - 1)
        if threads is not None:
            threads = whole("threads", threads, 1, 2**16)
        try:
            self.autoreset_mode = AutoresetMode(autoreset_mode)
        except ValueError:
            modes = ", ".join(mode.value for mode in AutoresetMode)
            raise InputError(f"autoreset_mode is {autoreset_mode!r}, expected {modes}") from None
        one = TaskEnv(
            task,
            reward_type=reward_type,
            options=options,
            randomize=randomize,
            render_mode=render_mode,
            width=width,
            height=height,
        )
        self.metadata = {**one.metadata, "autoreset_mode": self.autoreset_mode}
        self.render_mode = render_mode
        if max_episode_steps is not None:
            max_episode_steps = whole("max_episode_steps", max_episode_steps, 1, 2**31 - 1)
        #: One of them that is not stepped: its attributes are those of all.
        self.one = one
        self.single_observation_space, self.single_action_space = spaces_of(one._env)
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self._envs = _rher.VectorEnv(
            {
                "task": one.task,
                "options": options_as_json(options, randomize),
                "envs": self.num_envs,
                "threads": threads,
                "auto_reset": self.autoreset_mode.value,
                "reward_type": one.reward_type,
                "copy": copy,
                "episode_steps": max_episode_steps,
            }
        )

    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | None = None,
        options: Mapping[str, Any] | None = None,
    ) -> tuple[Observation, dict[str, Any]]:
        """Starts an episode in every environment.

        :param seed: of the first environment, the others having the numbers after it; or a seed
            for each of them. Without one, the episodes that follow from the last seeds.
        :param options: ``{"reset_mask": mask}`` starts episodes only where the mask, ``(num_envs,)``
            and boolean, is true. ``goal``, ``layout`` and ``turns`` are as in
            :meth:`rher.TaskEnv.reset`: for all environments, or with a row for each. They are for the
            episodes that begin now; those that follow are drawn.
        """
        mask = None
        if isinstance(options, Mapping) and "reset_mask" in options:
            options = dict(options)
            mask = options.pop("reset_mask")
        begun = beginnings(options, self.one.objects, self.num_envs)
        if mask is not None:
            if seed is not None:
                raise InputError("reset takes a seed or a reset_mask, not both")
            mask = np.asarray(mask)
            if mask.shape != (self.num_envs,) or mask.dtype != np.bool_:
                raise InputError(
                    f"reset_mask is {mask.dtype} of shape {mask.shape}, expected bool of "
                    f"({self.num_envs},)"
                )
            return self._envs.reset_where(mask.tolist(), begun)
        return self.begin(seed, begun)

    def begin(
        self, seed: int | Sequence[int | None] | None, begun: list[Beginning] | None
    ) -> tuple[Observation, dict[str, Any]]:
        """Starts an episode in every environment, with what is chosen for each; see :meth:`reset`."""
        if seed is None:
            if self._envs.is_seeded:
                return self._envs.reset(None, begun)
            drawn = self.np_random.integers(2**63, size=self.num_envs)
            return self._envs.reset(drawn.tolist(), begun)
        if not isinstance(seed, (Sequence, np.ndarray)):
            first = whole("seed", seed, 0, 2**64 - self.num_envs)
            super().reset(seed=first)
            return self._envs.reset(list(range(first, first + self.num_envs)), begun)
        seeds = [as_seed(one) for one in seed]
        known = [one for one in seeds if one is not None]
        if not len(seeds) == len(known) == self.num_envs:
            raise InputError(f"there are seeds {seeds}, expected one for each of {self.num_envs}")
        return self._envs.reset(known, begun)

    def step(
        self, actions: Action
    ) -> tuple[Observation, NDArray[Any], NDArray[Any], NDArray[Any], dict[str, Any]]:
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
        """This moment of all environments, for :meth:`set_state`."""
        return self._envs.get_state()

    def set_state(self, state: bytes) -> tuple[Observation, dict[str, Any]]:
        """Returns to a moment of environments like these: observations and infos.

        The running episodes are simulated again, so this takes as long as they did. What follows
        is, bit for bit, what followed there.
        """
        if not isinstance(state, bytes):
            raise InputError(f"state is {state!r}, expected what get_state returned")
        return self._envs.set_state(state)

    def compute_reward(
        self, achieved_goal: ArrayLike, desired_goal: ArrayLike, info: Any
    ) -> Any:
        """Rewards of goals ``(..., 3 * objects)``: ``(...)``; ``info`` is not used."""
        return self.one.compute_reward(achieved_goal, desired_goal, info)

    def render(self) -> tuple[NDArray[np.uint8], ...] | None:
        """A picture of every environment, as :meth:`rher.TaskEnv.render` draws it.

        It is None without a ``render_mode``.
        """
        if self.render_mode is None:
            return None
        return tuple(self._envs.render(self.one.width, self.one.height))

    @property
    def objects(self) -> int:
        """How many objects there are in each."""
        return self.one.objects

    def close_extras(self, **kwargs: Any) -> None:
        """Frees the simulations."""
        self._envs.close()
