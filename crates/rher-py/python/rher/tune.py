"""Settings that Ray Tune looks for, with runs of this package as its trials.

>>> from ray import tune
>>> trainable = rher.tune.trainable("push", env_steps=200_000)
>>> space = {"agent.discount": tune.uniform(0.9, 0.99), "seed": tune.randint(1, 1000)}
>>> tuner = tune.Tuner(trainable, param_space=space, tune_config=tune.TuneConfig(
...     metric="success_final", mode="max", num_samples=50,
...     scheduler=ASHAScheduler(time_attr="env_steps", max_t=200_000, grace_period=20_000),
...     search_alg=OptunaSearch()))
>>> tuner.fit()
"""

import os
import shutil
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from rher import _rher
from rher._arguments import table, whole
from rher.errors import MissingError
from rher.run import Run
from rher.env import task_of
from rher.training import arguments_as_json, changes_as_json, learn

__all__ = ["trainable"]

#: Writing checkpoints for Tune takes at most this part of the time.
CHECKPOINT_SHARE = 0.1


def trainable(
    task: str,
    *,
    set: Mapping[str, Any] | None = None,
    seed: int = 1,
    preset: str | None = None,
    config: str | os.PathLike[str] | None = None,
    method: str | None = None,
    env_steps: int | None = None,
    until: float | None = None,
    workers: int = 1,
) -> Callable[[dict[str, Any]], None]:
    """A trainable of Ray Tune that trains on a task like :func:`rher.train`.

    The configuration of a trial is a dictionary of settings by dotted key, such as
    ``{"agent.discount": 0.98}``; ``"seed"`` may be in it, too.

    After every evaluation it reports ``success_final``, ``env_steps`` and the other metrics that are
    single numbers (``docs/metrics.md``). From time to time, and at the end, the run folder comes with
    them as a checkpoint: a trial whose worker or machine died continues from there, with the same
    bits as one that was not disturbed, if ``tune.FailureConfig`` allows it. To keep only the latest
    checkpoint, set ``num_to_keep`` in ``tune.CheckpointConfig``.

    :param task: as in :func:`rher.train`, like the parameters that follow.
    :param set: settings that all trials share.
    :param workers: number of threads of a trial, and of the cores that Tune reserves for it.
    :return: what ``tune.Tuner`` takes.
    """
    try:
        from ray import tune
    except ImportError as error:
        raise MissingError(
            "Ray Tune is not installed: `pip install 'rher[ray]'` installs it"
        ) from error
    shared = table("set", set)
    workers = whole("workers", workers, 1, 2**16)
    task = task_of(task)

    def run(trial: dict[str, Any]) -> None:
        settings = shared | table("the configuration of a trial", trial)
        seed_of_trial = settings.pop("seed", seed)
        arguments = arguments_as_json(
            seed=seed_of_trial,
            preset=preset,
            set=settings,
            config=config,
            method=method,
            env_steps=env_steps,
            until=until,
        )
        out = Path(tune.get_context().get_trial_dir()) / "run"
        # What an earlier attempt left is newer than what it reported.
        shutil.rmtree(out, ignore_errors=True)
        checkpoint = tune.get_checkpoint()
        if checkpoint is None:
            trainer = _rher.Trainer.of_task(task, arguments, str(out), workers, None)
        else:
            checkpoint.to_directory(out)
            trainer = _rher.Trainer.resumed(str(out), None, workers, changes_as_json(None, None))
        try:
            _report_all(tune, trainer, out)
        finally:
            trainer.close()

    return tune.with_resources(run, {"cpu": workers})


class _Evaluated(Exception):
    """Stops training, saved, while Tune decides about the trial."""


def _report_all(tune: Any, trainer: "_rher.Trainer", out: Path) -> None:
    """Trains to the end, and reports every evaluation."""

    def on_event(event: dict[str, Any]) -> None:
        if event["kind"] == "evaluated":
            raise _Evaluated

    reported = len(_evaluations(out))
    all_steps = Run(out).settings["env_steps"]
    due = time.monotonic()
    finished = False
    while not finished:
        try:
            learn(trainer, progress=False, on_event=on_event)
            finished = True
        except _Evaluated:
            pass
        evaluations = _evaluations(out)
        is_last = finished or evaluations[-1]["env_steps"] >= all_steps
        new = evaluations[reported:]
        if finished and not new:
            # The last evaluation once more, with the end of the run.
            new = evaluations[-1:]
        for index, metrics in enumerate(new, start=1):
            started = time.monotonic()
            if index == len(new) and (is_last or started >= due):
                tune.report(metrics, checkpoint=tune.Checkpoint.from_directory(out))
                ended = time.monotonic()
                due = ended + (ended - started) / CHECKPOINT_SHARE
            else:
                tune.report(metrics)
        reported = len(evaluations)


def _evaluations(out: Path) -> list[dict[str, float]]:
    """The metrics of every evaluation that are single numbers."""
    metrics = Run(out).metrics
    numbers = {name: values.tolist() for name, values in metrics.items() if values.ndim == 1}
    return [dict(zip(numbers, row)) for row in zip(*numbers.values())]
