"""Finished and running runs, read from their folders."""

import json
import os
from pathlib import Path
from typing import Any

import numpy as np

from rher import _rher
from rher._arguments import path as as_path
from rher.errors import FileError

__all__ = ["Run"]


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
        return json.loads(_rher.run_settings(self.path))

    @property
    def policy(self) -> "_rher.Policy":
        """The policy as it was last saved."""
        return _rher.Policy.load(self.path / "policy.safetensors")

    @property
    def metrics(self) -> dict[str, np.ndarray]:
        """Every metric as an array with a row for each evaluation.

        Keys of parts are dotted (``time.update``); lists, such as ``success`` of every sub-task,
        are ``(evaluations, parts)``; what was not measured is NaN. ``docs/metrics.md`` says what
        each of them means.
        """
        path = self.path / "metrics.jsonl"
        try:
            text = path.read_text()
        except OSError as error:
            raise FileError(f"cannot read `{path}`: {error}") from error
        # A run that is being written may end in a part of a line.
        lines = text[: text.rfind("\n") + 1].splitlines()
        try:
            rows = [_flat(json.loads(line)) for line in lines]
        except json.JSONDecodeError as error:
            raise FileError(f"`{path}` is damaged: {error}") from error
        # The identity of the run and the checksum of the line are no metrics.
        keys = [key for key in (rows[0] if rows else ()) if key not in ("run", "crc32")]
        return {key: np.array([_number(row.get(key)) for row in rows]) for key in keys}

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
