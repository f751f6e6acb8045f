"""Finished and running runs, read from their folders."""

import json
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from rher import _rher
from rher._arguments import path as as_path
from rher._arguments import table, text, whole
from rher._command import output
from rher.errors import FileError, InputError, MissingError

if TYPE_CHECKING:
    import pandas

__all__ = ["Run"]

Camera = Literal["corner", "front", "side", "top", "close"]


class Run:
    """The folder of a run of ``rher train``, :func:`rher.train` or :class:`rher.Trainer`.

    :param path: the folder.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = Path(as_path("path", path))
        if not (self.path / "config.toml").is_file():
            raise FileError(f"`{self.path}` holds no run: there is no `config.toml` in it")

    @property
    def settings(self) -> dict[str, Any]:
        """Every setting, section by section."""
        settings: dict[str, Any] = json.loads(_rher.run_settings(self.path))
        return settings

    @property
    def state(self) -> Literal["running", "solved", "spent", "stopped"]:
        """Whether it goes on: ``"running"`` somewhere, ``"solved"``, ``"spent"`` when it has taken all
        of its steps, or ``"stopped"``, so that :func:`rher.resume` continues it.
        """
        return _rher.run_state(self.path)

    @property
    def policy(self) -> "_rher.Policy":
        """The policy as it was last saved."""
        return _rher.Policy.load(self.path / "policy.safetensors")

    @property
    def metrics(self) -> dict[str, NDArray[Any]]:
        """Every metric as an array with a row for each evaluation.

        Keys of parts are dotted (``time.update``); lists, such as ``success`` of every sub-task,
        are ``(evaluations, parts)``; what was not measured is NaN. ``docs/metrics.md`` says what
        each of them means.
        """
        rows = self._rows()
        # The identity of the run and the checksum of the line are no metrics.
        keys = [key for key in (rows[0] if rows else ()) if key not in ("run", "crc32")]
        return {key: np.array([_number(row.get(key)) for row in rows]) for key in keys}

    def _rows(self) -> list[dict[str, Any]]:
        """The evaluations as they are written, with dotted keys."""
        path = self.path / "metrics.jsonl"
        try:
            written = path.read_text()
        except OSError as error:
            raise FileError(f"cannot read `{path}`: {error}") from error
        # A run that is being written may end in a part of a line.
        lines = written[: written.rfind("\n") + 1].splitlines()
        try:
            return [_flat(json.loads(line)) for line in lines]
        except json.JSONDecodeError as error:
            raise FileError(f"`{path}` is damaged: {error}") from error

    def to_pandas(self) -> "pandas.DataFrame":
        """The metrics as a table of pandas, with a row for each evaluation.

        Lists have a column for each part, counted from 1: ``success.1``, ``success.2``.

        :raise MissingError: without pandas.
        """
        try:
            import pandas
        except ImportError as error:
            raise MissingError(
                "pandas is not installed: `pip install 'rher[pandas]'` installs it"
            ) from error
        columns: dict[str, NDArray[Any]] = {}
        for name, values in self.metrics.items():
            if values.ndim == 1:
                columns[name] = values
            else:
                parts = values.reshape(len(values), -1).T
                columns |= {f"{name}.{part}": column for part, column in enumerate(parts, start=1)}
        return pandas.DataFrame(columns)

    def evaluate(
        self,
        *,
        episodes: int = 100,
        seed: int | None = None,
        set: Mapping[str, Any] | None = None,
        workers: int | None = None,
    ) -> dict[str, Any]:
        """Success of the policy, as ``rher eval`` measures it.

        :param episodes: number of episodes of each sub-task.
        :param seed: of the episodes; by default one that training has not evaluated with.
        :param set: settings of the environments that are other than in training, such as
            ``{"randomize.friction": (0.5, 1.5)}``.
        :param workers: number of threads; it never changes the result.
        :return: ``success_final`` with ``ci95``, its 95 % interval; ``success`` of each sub-task,
            ``final_distance`` in meters, and more.
        """
        arguments = ["--episodes", str(whole("episodes", episodes, 1, 2**31 - 1)), "--json"]
        if seed is not None:
            arguments += ["--seed", str(whole("seed", seed, 0, 2**63 - 1))]
        for key, value in table("set", set).items():
            arguments += ["--set", f"{key}={json.dumps(value)}"]
        if workers is not None:
            arguments += ["--workers", str(whole("workers", workers, 1, 2**16))]
        report: dict[str, Any] = json.loads(self._rher("eval", *arguments))
        return report

    def play(
        self,
        out: str | os.PathLike[str],
        *,
        episodes: int = 1,
        seed: int = 0,
        camera: Camera = "corner",
        size: tuple[int, int] = (400, 300),
        trim: bool = False,
    ) -> Path:
        """Plays episodes of the policy and draws or records them, like ``rher play``.

        :param out: the file; its ending says what it is: ``.gif``, ``.mp4`` or ``.webm`` a film, of
            which the last two need ``ffmpeg``; ``.mcap`` a recording for Foxglove.
        :param episodes: number of episodes.
        :param seed: of the episodes.
        :param camera: from where films are drawn.
        :param size: width and height of films, in pixels.
        :param trim: cuts each episode of a film shortly after its success.
        :return: the file.
        """
        file = Path(as_path("out", out))
        arguments = ["--episodes", str(whole("episodes", episodes, 1, 2**31 - 1))]
        arguments += ["--seed", str(whole("seed", seed, 0, 2**63 - 1))]
        if file.suffix in (".gif", ".mp4", ".webm"):
            if not isinstance(size, Sequence) or len(size) != 2:
                raise InputError(f"size is {size!r}, expected a width and a height in pixels")
            width, height = (whole("size", pixels, 1, 4096) for pixels in size)
            arguments += ["--film", str(file), "--size", f"{width}x{height}"]
            arguments += ["--camera", text("camera", camera)]
            if trim:
                arguments.append("--trim")
        elif file.suffix == ".mcap":
            arguments += ["--mcap", str(file)]
        else:
            raise InputError(
                f"out is `{file}`, expected a name that ends in .gif, .mp4, .webm or .mcap"
            )
        self._rher("play", *arguments)
        return file

    def plot(
        self,
        out: str | os.PathLike[str],
        *others: "Run",
        x: Literal["steps", "time"] = "steps",
        measure: Literal["mean", "iqm"] = "mean",
        title: str | None = None,
        subtasks: bool = True,
    ) -> Path:
        """Draws learning curves, like ``rher plot``.

        :param out: the picture, whose name ends in ``.svg`` or ``.png``.
        :param others: runs that are drawn, too; several seeds are one line with a band.
        :param x: environment steps or the wall clock.
        :param measure: what a line shows of several runs: the mean or the interquartile mean.
        :param title: above the panels.
        :param subtasks: whether there are panels for sub-tasks.
        :return: the picture.
        """
        file = Path(as_path("out", out))
        arguments = ["--x", text("x", x), "--measure", text("measure", measure)]
        if title is not None:
            arguments += ["--title", text("title", title)]
        if not subtasks:
            arguments.append("--no-subtasks")
        folders = [str(run.path) for run in (self, *others)]
        output("plot", *arguments, "--out", str(file), "--", *folders)
        return file

    def _rher(self, verb: str, *arguments: str) -> str:
        """What the program says about this run.

        :raise InputError: if it is on an environment that the program does not have.
        """
        task = self.settings["task"]["name"]
        if task not in _rher.tasks():
            raise InputError(
                f"the run is on an environment of your own, `{task}`, which `rher {verb}` does not "
                "have: step it with `run.policy`, or give `run.policy` to Stable-Baselines3's "
                "`evaluate_policy`"
            )
        return output(verb, *arguments, "--", str(self.path))

    def __repr__(self) -> str:
        return f"Run({str(self.path)!r})"


def _flat(metrics: dict[str, Any], prefix: str = "") -> dict[str, Any]:
    """The metrics with dotted keys."""
    flat: dict[str, Any] = {}
    for key, value in metrics.items():
        if isinstance(value, dict):
            flat |= _flat(value, f"{prefix}{key}.")
        else:
            flat[prefix + key] = value
    return flat


def _number(value: Any) -> Any:
    """``value`` with NaN for what is missing."""
    if isinstance(value, list):
        return [_number(part) for part in value]
    return np.nan if value is None else value
