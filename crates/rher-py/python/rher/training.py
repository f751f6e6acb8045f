"""Training on the tasks of this package."""

import json
import os
from collections.abc import Callable, Mapping
from typing import Any, Literal

from rher import _rher
from rher._arguments import path as as_path
from rher._arguments import real, table, text, whole
from rher._progress import watcher
from rher.env import task_of
from rher.errors import InputError
from rher.run import Run

__all__ = ["resume", "train"]

Path = str | os.PathLike[str]
OnEvent = Callable[[dict[str, Any]], object]
Preset = Literal["fast", "sample-efficient", "paper"]
Method = Literal["rher", "her"]
Engine = Literal["fused", "burn"]
Precision = Literal["f32", "bf16"]


def train(
    task: str,
    *,
    seed: int = 1,
    preset: Preset | None = None,
    set: Mapping[str, Any] | None = None,
    config: Path | None = None,
    method: Method | None = None,
    env_steps: int | None = None,
    until: float | None = None,
    engine: Engine | None = None,
    precision: Precision | None = None,
    envs: int | None = None,
    out: Path | None = None,
    workers: int | None = None,
    from_run: Path | None = None,
    record_every: int | None = None,
    tensorboard: bool = False,
    max_wall: float | None = None,
    progress: bool | None = None,
    on_event: OnEvent | None = None,
) -> Run:
    """Trains on a task, like ``rher train``: the same settings give the same numbers.

    Ctrl-C ends the episode, saves everything, and raises ``KeyboardInterrupt``;
    :func:`rher.resume` continues the run.

    :param task: name of the task, see :func:`rher.tasks`, or one of :data:`rher.IDS`.
    :param seed: seed of every random draw, below 2**63.
    :param preset: ``"fast"`` (the default, with the recipe of the task), ``"sample-efficient"`` or
        ``"paper"``.
    :param set: single settings by dotted key, such as ``{"agent.discount": 0.98}``; ``rher config
        TASK`` prints all of them.
    :param config: a settings file.
    :param method: ``"rher"`` (the default) or ``"her"``.
    :param env_steps: environment steps after which it ends.
    :param until: success rate that ends the run early once two consecutive evaluations reach it; 0
        never does.
    :param engine: ``"fused"`` (the default) or ``"burn"``, which computes the networks.
    :param precision: ``"f32"`` or ``"bf16"``: of the networks' matrix products.
    :param envs: number of environments that step side by side between updates; it changes the
        result.
    :param out: folder of the run; ``runs/TASK-METHOD-PRESET-SEED`` if it is not given.
    :param workers: number of threads; by default as many as this process may use. It never changes
        the result.
    :param from_run: folder of a run whose networks and statistics the new one starts with, like
        ``rher train --from``. It may be of another task with the same hand and no more objects:
        push, then dpush, then tpush. What does not fit is a :class:`rher.SettingsError`.
    :param record_every: records every N-th training episode, beginning with the first, for Foxglove,
        in ``episodes-FIRST.mcap`` in the folder of the run.
    :param tensorboard: writes event files for ``tensorboard --logdir runs``.
    :param max_wall: seconds after which the run is saved and returned, so that :func:`rher.resume`
        can continue it; its ``state`` is ``"stopped"`` then.
    :param progress: True shows a bar of tqdm (``pip install 'rher[progress]'``), or lines in the log
        ``rher`` where tqdm is not installed. False shows nothing. By default there is a bar in
        notebooks and terminals, and the log elsewhere: ``logging.basicConfig(level="INFO")`` shows
        it.
    :param on_event: is called with a dictionary whose ``kind`` is ``"progress"`` (after every
        episode), ``"evaluated"`` (with all metrics) or ``"saved"``. An exception in it ends the
        run, saved, and comes out.
    :return: the run.
    """
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
        envs=envs,
    )
    trainer = _rher.Trainer.of_task(
        task_of(task),
        arguments,
        as_folder("out", out),
        as_workers(workers),
        as_folder("from_run", from_run),
    )
    with _Closing(trainer):
        return learn(
            trainer,
            max_wall=max_wall,
            record_every=record_every,
            tensorboard=tensorboard,
            progress=progress,
            on_event=on_event,
        )


def resume(
    path: Path,
    *,
    env_steps: int | None = None,
    until: float | None = None,
    engine: Engine | None = None,
    precision: Precision | None = None,
    workers: int | None = None,
    record_every: int | None = None,
    tensorboard: bool = False,
    max_wall: float | None = None,
    progress: bool | None = None,
    on_event: OnEvent | None = None,
) -> Run:
    """Continues a run on a task of this package: the result is as if it had never stopped.

    :param path: folder of the run.
    :param env_steps: as in :func:`rher.train`, like all other parameters; by default the value of
        the run, like ``until``, ``engine`` and ``precision``.
    :return: the run.
    """
    changes = changes_as_json(engine, precision)
    folder = as_path("path", path)
    trainer = _rher.Trainer.resumed(folder, None, as_workers(workers), changes)
    with _Closing(trainer):
        return learn(
            trainer,
            env_steps=env_steps,
            until=until,
            max_wall=max_wall,
            record_every=record_every,
            tensorboard=tensorboard,
            progress=progress,
            on_event=on_event,
        )


class _Closing:
    """Releases the folder of a run, whatever happens."""

    def __init__(self, trainer: "_rher.Trainer") -> None:
        self.trainer = trainer

    def __enter__(self) -> None:
        pass

    def __exit__(self, *_: object) -> None:
        self.trainer.close()


def learn(
    trainer: "_rher.Trainer",
    *,
    env_steps: int | None = None,
    until: float | None = None,
    max_wall: float | None = None,
    record_every: int | None = None,
    tensorboard: bool = False,
    progress: bool | None = None,
    on_event: OnEvent | None = None,
) -> Run:
    """Trains until the end of the run."""
    if on_event is not None and not callable(on_event):
        raise InputError(f"on_event is {on_event!r}, expected a function")
    if not isinstance(tensorboard, bool):
        raise InputError(f"tensorboard is {tensorboard!r}, expected True or False")
    trainer.set_end(as_env_steps(env_steps), as_until(until))
    watching = watcher(progress, trainer)
    hears = [each for each in (watching, on_event) if each is not None]

    def tell(event: dict[str, Any]) -> None:
        for each in hears:
            each(event)

    ended = "ended by an exception"
    try:
        ended = trainer.learn(
            tell if hears else None,
            None if max_wall is None else real("max_wall", max_wall, 0.0, 1e9),
            None if record_every is None else whole("record_every", record_every, 1, 2**63 - 1),
            tensorboard,
        )
    except KeyboardInterrupt:
        ended = "interrupted"
        raise
    finally:
        if watching is not None:
            watching.close(ended)
    return Run(trainer.folder)


def changes_as_json(engine: Engine | None, precision: Precision | None) -> str:
    """What a resumed run has otherwise than before, as JSON."""
    return json.dumps(
        {"engine": _name("engine", engine), "precision": _name("precision", precision)}
    )


def arguments_as_json(
    *,
    seed: int = 1,
    preset: str | None = None,
    set: Mapping[str, Any] | None = None,
    config: Path | None = None,
    method: str | None = None,
    env_steps: int | None = None,
    until: float | None = None,
    engine: str | None = None,
    precision: str | None = None,
    envs: int | None = None,
) -> str:
    """The settings that were passed, as JSON."""
    return json.dumps(
        {
            "preset": _name("preset", preset),
            "config": as_folder("config", config),
            "set": table("set", set),
            "method": _name("method", method),
            # Settings files have no larger numbers.
            "seed": whole("seed", seed, 0, 2**63 - 1),
            "env_steps": as_env_steps(env_steps),
            "until": as_until(until),
            "engine": _name("engine", engine),
            "precision": _name("precision", precision),
            "envs": None if envs is None else whole("envs", envs, 1, 2**63 - 1),
        }
    )


def as_env_steps(env_steps: Any) -> int | None:
    return None if env_steps is None else whole("env_steps", env_steps, 0, 2**63 - 1)


def as_until(until: Any) -> float | None:
    return None if until is None else real("until", until, 0.0, 1.0)


def as_workers(workers: Any) -> int | None:
    return None if workers is None else whole("workers", workers, 1, 2**16)


def as_folder(name: str, folder: Any) -> str | None:
    return None if folder is None else as_path(name, folder)


def _name(what: str, name: Any) -> str | None:
    return None if name is None else text(what, name)
