"""Training on your own environments."""

import json
from collections.abc import Mapping, Sequence
from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces

from rher import _rher
from rher._arguments import path as as_path
from rher._arguments import real, text, whole
from rher.errors import EnvError, InputError
from rher.goals import Tail
from rher.goals import checked as checked_tail
from rher.run import Run
from rher.training import (
    Engine,
    Method,
    OnEvent,
    Path,
    Precision,
    Preset,
    arguments_as_json,
    as_folder,
    as_workers,
    changes_as_json,
    learn,
)

__all__ = ["Trainer"]


class Trainer:
    """Relay hindsight experience replay on your own goal environment.

    The environment has the interface of Gymnasium-Robotics: observations are dictionaries with
    ``observation``, ``achieved_goal`` (where the objects are) and ``desired_goal`` (where they
    should be), actions are within -1 and 1, and every episode has the same number of steps. Its
    reward is ignored: the reward is 0 where every object is within ``tolerance`` of its
    place, and -1 elsewhere. Only ``reset`` and ``step`` are called.

    >>> env = gymnasium.make("FetchPush-v4")
    >>> trainer = rher.Trainer(env, objects=1, gripper=slice(0, 3), preset="paper")
    >>> run = trainer.learn(env_steps=80_000)
    >>> action = trainer.policy(env.reset()[0])

    :param env: the environment.
    :param objects: how many objects it has (1 to 3), three numbers of a goal for each, in the order
        in which they are to be placed; 0 if the goal is a place for the gripper itself.
    :param gripper: slice of ``observation`` that holds the position of the gripper, in meters.
    :param tolerance: distance below which a goal counts as reached, in meters; by default
        ``env.unwrapped.distance_threshold``, or 0.05 without one.
    :param tail: what a goal says of each object after its three numbers of position, or instead of
        them: a list of :class:`rher.Number`, :class:`rher.Angle`, :class:`rher.Quaternion` and
        :class:`rher.Flag`, each with a tolerance. A goal is reached where every object is within
        ``tolerance`` of its place and within the tolerance of every part.
    :param positions: slices of ``observation`` that hold the position of each object, where goals
        have none: the hand learns to reach an object before it learns to change it.
    :param episode_steps: number of steps of every episode; by default that of ``gymnasium.make``.
    :param name: name of the environment in the run and in its policy.
    :param seed: as in :func:`rher.train`, like the parameters that follow.
    :param from_run: as in :func:`rher.train`; its environment has the same dimensions and as many
        objects.
    :param resume: folder of a run on this environment to continue with its own settings.
    """

    def __init__(
        self,
        env: gymnasium.Env[Any, Any],
        *,
        objects: int = 1,
        gripper: slice = slice(0, 3),
        tolerance: float | None = None,
        tail: Sequence[Tail] = (),
        positions: Sequence[slice] | None = None,
        episode_steps: int | None = None,
        name: str | None = None,
        seed: int = 1,
        preset: Preset | None = None,
        set: Mapping[str, Any] | None = None,
        config: Path | None = None,
        method: Method | None = None,
        env_steps: int | None = None,
        until: float | None = None,
        engine: Engine | None = None,
        precision: Precision | None = None,
        out: Path | None = None,
        workers: int | None = None,
        from_run: Path | None = None,
        resume: Path | None = None,
    ) -> None:
        about = json.dumps(
            _about(env, objects, gripper, tolerance, tail, positions, episode_steps, name)
        )
        if resume is None:
            arguments = arguments_as_json(
                seed=seed,
                preset=preset,
                set=set,
                config=config,
                method=method,
                env_steps=env_steps,
                until=until,
                engine=engine,
                precision=precision,
            )
            self._trainer = _rher.Trainer.of_env(
                env,
                about,
                arguments,
                as_folder("out", out),
                as_workers(workers),
                as_folder("from_run", from_run),
            )
        else:
            folder, changes = as_path("resume", resume), changes_as_json(engine, precision)
            self._trainer = _rher.Trainer.resumed(
                folder, (env, about), as_workers(workers), changes
            )

    @property
    def policy(self) -> "_rher.Policy":
        """The policy as it is now."""
        return self._trainer.policy

    @property
    def run(self) -> Run:
        """The folder of the run."""
        return Run(self._trainer.folder)

    @property
    def env_steps(self) -> int:
        """Environment steps of training so far."""
        return self._trainer.env_steps

    def learn(
        self,
        env_steps: int | None = None,
        until: float | None = None,
        on_event: OnEvent | None = None,
        *,
        tensorboard: bool = False,
        max_wall: float | None = None,
        progress: bool | None = None,
    ) -> Run:
        """Trains until the run has taken ``env_steps`` in total, or has reached ``until``.

        An exception in the environment becomes the cause of a :class:`rher.EnvError`, and
        everything before that episode is saved. Ctrl-C and the parameters are as in
        :func:`rher.train`.
        """
        return learn(
            self._trainer,
            env_steps=env_steps,
            until=until,
            max_wall=max_wall,
            tensorboard=tensorboard,
            progress=progress,
            on_event=on_event,
        )

    def close(self) -> None:
        """Releases the folder of the run, so that it can be resumed elsewhere."""
        self._trainer.close()

    def __enter__(self) -> "Trainer":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def _about(
    env: gymnasium.Env[Any, Any],
    objects: int,
    gripper: slice,
    tolerance: float | None,
    tail: Sequence[Tail],
    positions: Sequence[slice] | None,
    episode_steps: int | None,
    name: str | None,
) -> dict[str, Any]:
    """What the learner needs to know about an environment, after checking that it can be learned."""
    objects = whole("objects", objects, 0, 3)
    observation_space, action_space = env.observation_space, env.action_space
    keys = ("observation", "achieved_goal", "desired_goal")
    if not isinstance(observation_space, spaces.Dict) or not all(
        isinstance(observation_space.spaces.get(key), spaces.Box)
        and len(observation_space[key].shape) == 1
        for key in keys
    ):
        raise InputError(
            f"the observation space is {observation_space}, expected a Dict with the one-dimensional "
            f"Boxes {', '.join(keys)}"
        )
    width, *goals = (observation_space[key].shape[0] for key in keys)
    parts = checked_tail(tail)
    numbers = sum(part.numbers for part in tail)
    if parts and objects == 0:
        raise InputError(
            "objects is 0 and tail is not empty, expected no tail where the goal is a place for the "
            "gripper"
        )
    count = max(objects, 1)
    has_positions = goals != [numbers * count] * 2 or not parts
    goal = (3 + numbers) * count
    if has_positions and goals != [goal, goal]:
        instead = f", or {numbers * count} where goals have no positions" if parts else ""
        raise InputError(
            f"goals have {goals} numbers, expected {goal} each for objects={objects}"
            + (f" and a tail of {numbers}{instead}" if parts else "")
        )
    if not isinstance(action_space, spaces.Box) or len(action_space.shape) != 1:
        raise InputError(f"the action space is {action_space}, expected a one-dimensional Box")
    if not (np.all(action_space.low == -1) and np.all(action_space.high == 1)):
        raise InputError(
            f"the action space is {action_space}, expected -1 to 1: "
            "gymnasium.wrappers.RescaleAction makes it so"
        )
    if not isinstance(gripper, slice):
        raise InputError(f"gripper is {gripper!r}, expected a slice such as slice(0, 3)")
    first, last, step = gripper.indices(width)
    if step != 1 or last - first != 3:
        raise InputError(f"gripper is {gripper}, expected three numbers of the {width} observed")
    if has_positions and positions is not None:
        raise InputError("positions is given, but goals have positions: leave it out")
    if not has_positions and positions is None:
        raise InputError(
            f"goals have no positions, expected positions=[slice(...), ...]: {objects} slices of "
            "observation that say where the objects are"
        )
    if positions is not None:
        places: list[int] | None = _places(positions, objects, width)
    else:
        places = _find_objects(env, objects)
    if episode_steps is None:
        episode_steps = env.spec.max_episode_steps if env.spec is not None else None
    episode_steps = whole("episode_steps", episode_steps, 1, 2**31 - 1)
    if tolerance is None:
        tolerance = getattr(env.unwrapped, "distance_threshold", 0.05)
    tolerance = real("tolerance", tolerance, 0.0, float(np.finfo(np.float32).max))
    if tolerance == 0:
        raise InputError("tolerance is 0.0, expected a distance in meters")
    if name is None:
        name = env.spec.id if env.spec is not None else type(env.unwrapped).__name__
    return {
        "name": text("name", name).replace("/", "-"),
        "objects": objects,
        "observation": width,
        "action": action_space.shape[0],
        "episode_steps": episode_steps,
        "tolerance": tolerance,
        "has_positions": has_positions,
        "tail": parts,
        "places": {"gripper": first, "objects": places},
    }


def _places(positions: Sequence[slice], objects: int, width: int) -> list[int]:
    """Where in observations the positions of the objects begin."""
    places = []
    for position in positions:
        if not isinstance(position, slice):
            raise InputError(f"positions has {position!r}, expected a slice such as slice(3, 6)")
        first, last, step = position.indices(width)
        if step != 1 or last - first != 3:
            raise InputError(
                f"positions has {position}, expected three numbers of the {width} observed"
            )
        places.append(first)
    if len(places) != objects:
        raise InputError(f"positions has {len(places)} slices, expected {objects}")
    return places


def _find_objects(env: gymnasium.Env[Any, Any], objects: int) -> list[int] | None:
    """Where in observations the positions of the objects are, if all of them are there.

    They are looked for at the beginning of two episodes. Only calls of a policy without
    ``achieved_goal`` need them.
    """
    places: list[list[int]] = []
    for seed in range(2):
        try:
            seen, _ = env.reset(seed=seed)
        except Exception as error:
            raise EnvError(f"the environment cannot be reset: {error}") from error
        observation = np.asarray(seen["observation"])
        for index, position in enumerate(np.reshape(seen["achieved_goal"], (max(objects, 1), -1))[:objects, :3]):
            windows = np.lib.stride_tricks.sliding_window_view(observation, 3)
            here = np.flatnonzero((windows == position).all(axis=1)).tolist()
            if seed == 0:
                places.append(here)
            else:
                places[index] = [place for place in places[index] if place in here]
    return [place[0] for place in places] if objects and all(places) else None
