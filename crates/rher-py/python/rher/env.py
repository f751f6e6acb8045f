"""The tasks as Gymnasium environments."""

import json
from collections.abc import Mapping
from typing import Any, Literal

import gymnasium
import numpy as np
from gymnasium import spaces
from numpy.typing import ArrayLike, NDArray

from rher import _rher
from rher._arguments import table, text, whole
from rher._beginning import FAR, beginning
from rher.errors import InputError

__all__ = ["DENSE_IDS", "IDS", "TaskEnv"]

Observation = dict[str, NDArray[np.float64]]
Action = NDArray[np.float32]

#: Ids of Gymnasium and the names of their tasks.
IDS = {
    "rher/Reach-v0": "reach",
    "rher/Push-v0": "push",
    "rher/PickAndPlace-v0": "pick",
    "rher/Slide-v0": "slide",
    "rher/Insert-v0": "insert",
    "rher/ObstaclePush-v0": "obstacle-push",
    "rher/Drawer-v0": "drawer",
    "rher/CuePush-v0": "cue-push",
    "rher/DPush-v0": "dpush",
    "rher/Stack-v0": "stack",
    "rher/DrawerBox-v0": "drawer-box",
    "rher/TPush-v0": "tpush",
    "rher/TStack-v0": "tstack",
}

#: The same tasks with ``reward_type="dense"``.
DENSE_IDS = {name.replace("-v0", "Dense-v0"): task for name, task in IDS.items()}

RewardType = Literal["sparse", "dense"]


def task_of(name: Any) -> str:
    """The task of a name or of an id."""
    name = text("task", name)
    return IDS.get(name) or DENSE_IDS.get(name) or name


def options_as_json(
    options: Mapping[str, Any] | None, randomize: Mapping[str, Any] | None
) -> str:
    """The options of a task, as the compiled half reads them."""
    return json.dumps({"task": table("options", options), "randomize": table("randomize", randomize)})


def spaces_of(env: "_rher.Env") -> tuple[spaces.Dict, spaces.Box]:
    """Spaces of observations and actions."""

    def anywhere(width: int) -> spaces.Box:
        return spaces.Box(-FAR, FAR, (width,), np.float64)

    goal = 3 * env.objects
    observation = spaces.Dict(
        {
            "observation": anywhere(env.observation_width),
            "achieved_goal": anywhere(goal),
            "desired_goal": anywhere(goal),
        }
    )
    return observation, spaces.Box(-1.0, 1.0, (env.action_width,), np.float32)


def as_seed(seed: Any) -> int | None:
    """``seed`` as an ``int``."""
    return None if seed is None else whole("seed", seed, 0, 2**64 - 1)


class TaskEnv(gymnasium.Env[Observation, Action]):
    """One task, with the multi-goal interface of Gymnasium-Robotics.

    Observations are dictionaries of 64-bit arrays: ``observation``; ``achieved_goal`` and
    ``desired_goal``, each ``(3 * objects,)`` in meters, with the objects in the order in which they
    are to be placed. Actions are 32-bit, ``(4,)`` (``(3,)`` for ``cue-push``), within -1 and 1: the
    gripper's displacement along x, y, z (1 asks for 5 cm), then the opening of its fingers.
    Episodes never end by themselves; ``gymnasium.make`` ends them after ``episode_steps``.

    :param task: name of the task, see :func:`rher.tasks`, or one of :data:`rher.IDS`.
    :param reward_type: ``"sparse"`` rewards with 0 when every object is at its place and with -1
        otherwise, ``"dense"`` with minus the length of ``desired_goal - achieved_goal``, in meters.
    :param options: settings of this task, such as ``{"noise": 0.0}`` for ``cue-push``.
    :param randomize: ranges of what is drawn for every episode, such as ``{"friction": (0.5, 1.5)}``:
        ``friction``, ``mass``, ``size`` (factors), ``sensor_noise`` (meters) and ``action_delay``
        (steps).
    :param render_mode: ``"rgb_array"`` if pictures are wanted; they need no graphics card.
    :param width: of pictures, in pixels.
    :param height: of pictures, in pixels.
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": 25}

    def __init__(
        self,
        task: str,
        *,
        reward_type: RewardType = "sparse",
        options: Mapping[str, Any] | None = None,
        randomize: Mapping[str, Any] | None = None,
        render_mode: str | None = None,
        width: int = 480,
        height: int = 480,
    ) -> None:
        if render_mode not in (None, *self.metadata["render_modes"]):
            raise InputError(f"render_mode is {render_mode!r}, expected 'rgb_array'")
        self.render_mode = render_mode
        self.width, self.height = whole("width", width, 1, 4096), whole("height", height, 1, 4096)
        self.reward_type = text("reward_type", reward_type)
        self._env = _rher.Env(
            task_of(task), options_as_json(options, randomize), self.reward_type
        )
        self.observation_space, self.action_space = spaces_of(self._env)

    @property
    def task(self) -> str:
        """Name of the task."""
        return self._env.task

    @property
    def episode_steps(self) -> int:
        """Steps of an episode."""
        return self._env.episode_steps

    @property
    def objects(self) -> int:
        """How many objects there are."""
        return self._env.objects

    @property
    def distance_threshold(self) -> float:
        """Distance below which an object counts as at its place, in meters."""
        return self._env.tolerance

    def reset(
        self, *, seed: int | None = None, options: Mapping[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Starts the next episode.

        With a seed this is the first episode of that seed, and those that follow without one
        follow from it: a run of episodes repeats bitwise, on every machine.

        :param options: what is not drawn in this episode: ``"goal"``, the ``desired_goal``,
            ``(3 * objects,)`` in meters; ``"layout"``, where the objects start, as in
            ``achieved_goal``; ``"turns"``, how far they are turned about the vertical,
            ``(objects,)`` in radians.
        """
        seed = as_seed(seed)
        begun = beginning(options, self.objects)
        super().reset(seed=seed)
        if seed is None and not self._env.is_seeded:
            seed = int(self.np_random.integers(2**63))
        return self._env.reset(seed, begun)

    def step(self, action: Action) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Acts for one step of 40 ms.

        Numbers outside of -1 and 1 are clipped.
        """
        return self._env.step(action)

    def compute_reward(
        self, achieved_goal: ArrayLike, desired_goal: ArrayLike, info: Any
    ) -> Any:
        """Rewards of goals ``(..., 3 * objects)``: ``(...)``; ``info`` is not used."""
        rewards = self._env.compute_reward(achieved_goal, desired_goal)
        return rewards if rewards.ndim else rewards[()]

    def compute_terminated(
        self, achieved_goal: ArrayLike, desired_goal: ArrayLike, info: Any
    ) -> bool:
        """False: reaching the goal ends nothing."""
        return False

    def compute_truncated(
        self, achieved_goal: ArrayLike, desired_goal: ArrayLike, info: Any
    ) -> bool:
        """False: the wrapper of ``gymnasium.make`` ends episodes."""
        return False

    def get_state(self) -> "_rher.State":
        """This moment of the episode, for :meth:`set_state`.

        It can be pickled; unpickling simulates the episode again.
        """
        return self._env.get_state()

    def set_state(
        self, state: "_rher.State"
    ) -> tuple[Observation, dict[str, Any]]:
        """Returns to a moment of an environment like this one, and returns its observation and info.

        What follows is, bit for bit, what followed there.
        """
        if not isinstance(state, _rher.State):
            raise InputError(f"state is {state!r}, expected what get_state returned")
        return self._env.set_state(state)

    def render(self) -> NDArray[np.uint8] | None:
        """A picture ``(height, width, 3)`` of 8-bit numbers with marks at the goals.

        It is None without a ``render_mode``.
        """
        if self.render_mode is None:
            return None
        return self._env.render(self.width, self.height)

    def close(self) -> None:
        """Frees the simulation."""
        self._env.close()


def register() -> None:
    """Registers the ids with Gymnasium."""
    steps = {task: _rher.Env(task, "{}").episode_steps for task in IDS.values()}
    # What is the default is not in the specification, which datasets are compared by.
    kinds: list[tuple[dict[str, str], dict[str, str]]] = [
        (IDS, {}),
        (DENSE_IDS, {"reward_type": "dense"}),
    ]
    for ids, kind in kinds:
        for name, task in ids.items():
            gymnasium.register(
                id=name,
                entry_point="rher.env:TaskEnv",
                vector_entry_point="rher.vector:TaskVectorEnv",
                max_episode_steps=steps[task],
                # Both are done by the environment itself, at a fraction of the cost.
                order_enforce=False,
                disable_env_checker=True,
                kwargs={"task": task, **kind},
            )
