"""Training on your own environments."""

import json
import threading
from collections.abc import Mapping, Sequence
from typing import Any

from rher import _rher
from rher._about import about as about_env
from rher._arguments import path as as_path
from rher._arguments import real
from rher._given_envs import Given, GivenEnvs
from rher.goals import Tail
from rher.run import Run
from rher.symmetry import Mirror, Permutation
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
    should be), and perhaps more, which is not used. Its reward is ignored: the reward is 0 where
    every object is within ``tolerance`` of its place, and -1 elsewhere. Only ``reset`` and ``step``
    are called.

    Episodes may differ in length. One that is ``truncated`` is learned from as one of all steps is.
    One that is ``terminated`` stays as it ended: its last reward repeats forever. It ended on success
    where its ``info`` says so (``is_success`` or ``success``), or, without that, where the goal is
    reached; in other goals that it is replayed for it did not end. Every other end is a failure, for
    every goal. An episode counts as solved if its last state is within ``tolerance``.

    Actions and the policy that is learned are in the units of the environment's ``action_space``.

    >>> env = gymnasium.make("FetchPush-v4")
    >>> trainer = rher.Trainer(env, objects=1, gripper=slice(0, 3), preset="paper")
    >>> run = trainer.learn(env_steps=80_000)
    >>> action = trainer.policy(env.reset()[0])

    Several environments are played side by side, each in a process of its own, which pays where their
    steps are dear: pass a list of functions that make one each, such as ``[make] * 2``. A
    ``SyncVectorEnv`` of Gymnasium is taken apart and played in this process. Of an ``AsyncVectorEnv``
    and of what ``gymnasium.make_vec`` made, the environments are made once more, each in a process of
    its own; the vector environment itself is not used, and can be closed. Every episode is reset by
    its seed, so that no ``autoreset_mode`` plays a part, and a run depends on the number of
    environments, but not on their speed.

    :param env: the environment, a vector environment, or a list of functions.
    :param objects: how many objects it has (1 to 3), three numbers of a goal for each, in the order
        in which they are to be placed; 0 if the goal is a place for the gripper itself.
    :param gripper: slice of ``observation`` that holds the position of the gripper, in meters; by
        default its first numbers. Positions have three numbers, or two where the goals have two for
        each object: their height is then 0.
    :param tolerance: distance below which a goal counts as reached, in meters; by default
        ``env.unwrapped.distance_threshold``, or that of ``env.unwrapped.task``, or 0.05 without one.
    :param tail: what a goal says of each object after its three numbers of position, or instead of
        them: a list of :class:`rher.Number`, :class:`rher.Angle`, :class:`rher.Quaternion` and
        :class:`rher.Flag`, each with a tolerance. A goal is reached where every object is within
        ``tolerance`` of its place and within the tolerance of every part.
    :param positions: slices of ``observation`` that hold the position of each object, where goals
        have none: the hand learns to reach an object before it learns to change it.
    :param episode_steps: the most steps of an episode; by default that of ``gymnasium.make``, or else
        that of an episode of random actions that is truncated.
    :param name: name of the environment in the run and in its policy.
    :param seed: as in :func:`rher.train`, like the parameters that follow.
    :param from_run: as in :func:`rher.train`; its environment has the same dimensions and as many
        objects.
    :param resume: folder of a run on this environment to continue with its own settings.
    :param step_timeout: seconds after which a ``step`` or ``reset`` that has not returned is given up
        with an error, and everything before its episode is saved; by default never. An environment in
        this process that keeps Python's lock cannot be given up: use a process.
    :param mirrors: the scene's planes of symmetry, each perpendicular to another axis; how often rows
        are mirrored is the setting ``relay.mirror``.
    :param permutations: orders in which interchangeable objects may be given, besides the usual one;
        ``relay.exchange`` and ``relay.object_order`` are about them. Both kinds of symmetries must be
        the same when a run is resumed, and :func:`rher.symmetries` tests whether they hold.
    """

    def __init__(
        self,
        env: Given,
        *,
        objects: int = 1,
        gripper: slice | None = None,
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
        step_timeout: float | None = None,
        mirrors: Sequence[Mirror] = (),
        permutations: Sequence[Permutation] = (),
    ) -> None:
        if step_timeout is not None:
            step_timeout = real("step_timeout", step_timeout, 0.001, threading.TIMEOUT_MAX)
        self._given = GivenEnvs(env, step_timeout)
        try:
            first = self._given.first
            about = about_env(
                first,
                objects,
                gripper,
                tolerance,
                tail,
                positions,
                episode_steps,
                name,
                mirrors,
                permutations,
            )
            self._given.looked()
            envs, about_json = self._given.envs, json.dumps(about)
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
                    envs=len(envs) if len(envs) > 1 else None,
                )
                self._trainer = _rher.Trainer.of_env(
                    envs,
                    about_json,
                    arguments,
                    as_folder("out", out),
                    as_workers(workers),
                    as_folder("from_run", from_run),
                )
            else:
                folder, changes = as_path("resume", resume), changes_as_json(engine, precision)
                self._trainer = _rher.Trainer.resumed(
                    folder, (envs, about_json), as_workers(workers), changes
                )
        except BaseException:
            self._given.close()
            raise

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
        """Releases the folder of the run, so that it can be resumed elsewhere, and ends the processes
        of environments that were made for it.
        """
        self._trainer.close()
        self._given.close()

    def __enter__(self) -> "Trainer":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
