"""Runs in Trackio, Weights & Biases and MLflow, while they are trained or later.

>>> rher.track.send("runs/push-rher-fast-1", "mlflow")

``python -m rher.track RUN --to mlflow`` does the same. Where a tracker keeps its runs is its own affair:
the variables ``TRACKIO_DIR``, ``WANDB_MODE`` and ``MLFLOW_TRACKING_URI`` say it.
"""

import argparse
import importlib.util
import json
import os
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Literal, Protocol, get_args

from rher._arguments import path as as_path
from rher._arguments import text
from rher.errors import FileError, InputError, MissingError, RherError, TrackerError
from rher.run import Run

__all__ = ["TrackerName", "send"]

TrackerName = Literal["trackio", "wandb", "mlflow"]

#: What they call themselves.
TITLES: Mapping[str, str] = {
    "trackio": "Trackio",
    "wandb": "Weights & Biases",
    "mlflow": "MLflow",
}
#: In a run folder: until which step a tracker has the run, for those that do not say it themselves.
SENT_FILE = "tracked.json"
#: Seconds between two looks at a run that is being trained.
EVERY = 2.0


def send(run: Run | str | os.PathLike[str], to: TrackerName, *, project: str = "rher") -> int:
    """Sends the settings and the metrics of a run to a tracker: those that it does not have yet.

    The step of a row is its ``env_steps``, and keys are as in :attr:`rher.Run.metrics`, with a number for
    each part of a list: ``success.1``, ``success.2``. A run that is being trained is followed until its
    training ends. What was sent is not sent again, also by another process and after an interruption:
    MLflow is asked until where it has the run, and for the others ``tracked.json`` in the run folder
    remembers it.

    :param run: a run, or the path of its folder.
    :param to: the tracker: ``"trackio"``, ``"wandb"`` (Weights & Biases) or ``"mlflow"``.
    :param project: of the tracker; in MLflow it is an experiment.
    :return: how many rows were sent.
    :raise MissingError: if the tracker is not installed.
    :raise TrackerError: if it cannot be reached, or refuses the run.
    """
    if to not in TITLES:
        raise InputError(f"to is {to!r}, expected one of {', '.join(map(repr, TITLES))}")
    project = text("project", project)
    run = run if isinstance(run, Run) else Run(as_path("run", run))
    tracker: _Tracker | None = None
    sent, count = -1, 0
    try:
        while True:
            # Asked first, so that nothing is missed that is written in between.
            is_last = run.state != "running"
            rows = run._rows()
            if rows and tracker is None:
                with _refused(to):
                    tracker = _TRACKERS[to](run, str(rows[0].get("run", run.path.name)), project)
                sent = tracker.sent
            for row in rows:
                step = row["env_steps"]
                if tracker is not None and step > sent:
                    with _refused(to):
                        tracker.log(step, _numbers(row))
                    sent, count = step, count + 1
            if is_last:
                return count
            time.sleep(EVERY)
    finally:
        if tracker is not None:
            with _refused(to):
                tracker.finish()


class _Tracker(Protocol):
    #: The last step that it had before; -1 if it had none.
    sent: int

    def log(self, step: int, numbers: Mapping[str, float]) -> None:
        """Sends a row."""

    def finish(self) -> None:
        """Waits until everything has arrived."""


@contextmanager
def _refused(to: str) -> Iterator[None]:
    """Makes one exception of whatever a tracker raises."""
    try:
        yield
    except RherError:
        raise
    except ImportError as error:
        raise MissingError(
            f"{TITLES[to]} is not installed: `pip install 'rher[{to}]'` installs it"
        ) from error
    except Exception as error:
        reason = (str(error).strip() or type(error).__name__).splitlines()[0]
        raise TrackerError(f"{TITLES[to]} does not take the run: {reason}{_HINTS[to]}") from error


_HINTS: Mapping[str, str] = {
    "trackio": "",
    "wandb": "; `wandb login` or `WANDB_MODE=offline` may help",
    "mlflow": "; MLFLOW_TRACKING_URI is its address, such as file:///home/me/mlruns",
}


class _Sent:
    """Until which step a tracker has a run, in a file of the run folder."""

    def __init__(self, run: Run, tracker: str) -> None:
        self._path, self._tracker = run.path / SENT_FILE, tracker

    def _all(self) -> dict[str, int]:
        try:
            sent: dict[str, int] = json.loads(self._path.read_text())
        except FileNotFoundError:
            return {}
        except (OSError, ValueError) as error:
            raise FileError(f"cannot read `{self._path}`: {error}") from error
        return sent

    def read(self) -> int:
        return self._all().get(self._tracker, -1)

    def write(self, step: int) -> None:
        beside = self._path.with_name(f".{SENT_FILE}.{os.getpid()}")
        try:
            beside.write_text(f"{json.dumps(self._all() | {self._tracker: step}, indent=2)}\n")
            beside.replace(self._path)
        except OSError as error:
            raise FileError(f"cannot write `{self._path}`: {error}") from error


class _Trackio:
    def __init__(self, run: Run, identity: str, project: str) -> None:
        import trackio

        self._trackio = trackio
        self._sent = _Sent(run, f"trackio {project}")
        self.sent = self._sent.read()
        # Trackio knows a run by its name.
        trackio.init(
            project=project,
            name=f"{run.path.name}-{identity[:8]}",
            config=_flat(run.settings),
            resume="allow",
            auto_log_cpu=False,
            auto_log_gpu=False,
        )

    def log(self, step: int, numbers: Mapping[str, float]) -> None:
        self._trackio.log(dict(numbers), step=step)
        self._sent.write(step)

    def finish(self) -> None:
        self._trackio.finish()


class _Wandb:
    def __init__(self, run: Run, identity: str, project: str) -> None:
        import wandb

        self._sent = _Sent(run, f"wandb {project}")
        self.sent = self._sent.read()
        self._run = wandb.init(
            project=project,
            id=identity,
            name=run.path.name,
            config=run.settings,
            resume="allow",
            settings=wandb.Settings(x_disable_stats=True, console="off"),
        )

    def log(self, step: int, numbers: Mapping[str, float]) -> None:
        self._run.log(dict(numbers), step=step)
        self._sent.write(step)

    def finish(self) -> None:
        self._run.finish()


class _Mlflow:
    def __init__(self, run: Run, identity: str, project: str) -> None:
        if importlib.util.find_spec("sqlalchemy") is None:
            # Its default is a database, which `mlflow-skinny` cannot open.
            os.environ.setdefault("MLFLOW_TRACKING_URI", Path("mlruns").absolute().as_uri())
        if os.environ.get("MLFLOW_TRACKING_URI", "").startswith("file:"):
            # MLflow 3 has folders of files only for those who say that they want them.
            os.environ.setdefault("MLFLOW_ALLOW_FILE_STORE", "true")
        from mlflow import MlflowClient
        from mlflow.entities import Metric, Param

        self._metric = Metric
        self._client = MlflowClient()
        experiment = self._client.get_experiment_by_name(project)
        if experiment is None:
            number = self._client.create_experiment(project)
        else:
            number = experiment.experiment_id
        found = self._client.search_runs([number], f"tags.`rher.run` = '{identity}'")
        if found:
            self._id = found[0].info.run_id
            self.sent = int(found[0].data.metrics.get("env_steps", -1))
            return
        tags = {"rher.run": identity}
        started = self._client.create_run(number, run_name=run.path.name, tags=tags)
        self._id, self.sent = started.info.run_id, -1
        params = [Param(key, str(value)) for key, value in _flat(run.settings).items()]
        # As many at once as a server takes.
        for begin in range(0, len(params), 100):
            self._client.log_batch(self._id, params=params[begin : begin + 100])

    def log(self, step: int, numbers: Mapping[str, float]) -> None:
        now = int(1000 * time.time())
        # Last comes what says that the row is there.
        ordered = {key: value for key, value in numbers.items() if key != "env_steps"}
        ordered["env_steps"] = step
        metrics = [self._metric(key, value, now, step) for key, value in ordered.items()]
        self._client.log_batch(self._id, metrics=metrics)

    def finish(self) -> None:
        self._client.set_terminated(self._id)


_TRACKERS: Mapping[str, Callable[[Run, str, str], _Tracker]] = {
    "trackio": _Trackio,
    "wandb": _Wandb,
    "mlflow": _Mlflow,
}


def _flat(settings: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    """Settings with dotted keys."""
    flat: dict[str, Any] = {}
    for key, value in settings.items():
        if isinstance(value, Mapping):
            flat |= _flat(value, f"{prefix}{key}.")
        else:
            flat[prefix + key] = value
    return flat


def _numbers(row: Mapping[str, Any]) -> dict[str, float]:
    """What was measured in a row, number by number."""
    numbers: dict[str, float] = {}
    for key, value in row.items():
        if isinstance(value, list):
            parts = {f"{key}.{number}": part for number, part in enumerate(value, start=1)}
        else:
            parts = {key: value}
        numbers |= {name: part for name, part in parts.items() if isinstance(part, int | float)}
    return numbers


def main(arguments: Sequence[str] | None = None) -> int:
    """The command ``python -m rher.track``; its exit status."""
    parser = argparse.ArgumentParser(
        prog="python -m rher.track",
        description="Send a run to a tracker, and follow it while it is trained.",
    )
    parser.add_argument("run", help="folder of the run")
    parser.add_argument("--to", required=True, choices=get_args(TrackerName), help="the tracker")
    parser.add_argument("--project", default="rher", help="of the tracker [default: rher]")
    asked = parser.parse_args(arguments)
    try:
        count = send(asked.run, asked.to, project=asked.project)
    except RherError as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        return 130
    print(f"{count} evaluations of {asked.run} sent to {TITLES[asked.to]}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
