"""What an environment was really asked to do: for robots, whose steps are dear."""

import json
import os
import time
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import gymnasium

from rher._arguments import path as as_path
from rher.errors import FileError

__all__ = ["StepLog", "Taken"]


@dataclass(frozen=True)
class Taken:
    """Everything that an environment was asked to do since its log began."""

    #: Calls of ``step``, also those that raised.
    steps: int = 0
    #: Calls of ``reset``: how often a person had to put things back.
    resets: int = 0
    #: Episodes that had not ended when the next one began, because something raised, or the process
    #: was stopped.
    aborted_episodes: int = 0
    #: Steps of those.
    aborted_steps: int = 0


class StepLog(gymnasium.Wrapper[Any, Any, Any, Any]):
    """Counts what an environment is asked to do, in a file that outlives the process.

    ``Trainer.env_steps`` are the steps that were learned from; a robot also takes those of
    evaluations, and those of episodes that were aborted. All of them are here:

    >>> env = rher.StepLog(arm, "arm.jsonl")
    >>> trainer = rher.Trainer(env, objects=0, episode_steps=40)
    >>> env.taken.steps - env.taken.aborted_steps - trainer.env_steps  # of evaluations

    The file has a line for each call, which is written before the call, so that nothing is missing
    after a crash: ``kind`` is ``reset``, ``step`` or, where an episode ended, ``end``; ``at`` is the
    time in seconds since 1970. It is continued where it is there already.

    :param env: the environment, which says by ``terminated`` or ``truncated`` when an episode ends.
    :param path: the file.
    :raise FileError: if it cannot be read or written, or has a line that is none of its own.
    """

    def __init__(self, env: gymnasium.Env[Any, Any], path: str | os.PathLike[str]) -> None:
        super().__init__(env)
        self._path = Path(as_path("path", path))
        try:
            before = self._path.read_bytes() if self._path.exists() else b""
            # Where the disk was full, the last line is cut, and its call was never made.
            whole = before[: before.rfind(b"\n") + 1]
            self._taken, self._running = _count(self._path, whole.splitlines())
            # Unbuffered: what was written is in the file, whatever happens next.
            self._file = self._path.open("ab", buffering=0)
            self._file.truncate(len(whole))
        except OSError as error:
            raise FileError(f"cannot use `{self._path}` as a log of steps: {error}") from error

    @property
    def taken(self) -> Taken:
        """What was asked of the environment so far, in earlier processes, too."""
        return self._taken

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Starts an episode; one that had not ended counts as aborted."""
        self._write("reset")
        return self.env.reset(seed=seed, options=options)

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        """Carries out an action."""
        self._write("step")
        result = self.env.step(action)
        if result[2] or result[3]:
            self._write("end")
        return result

    def close(self) -> None:
        """Closes the environment and the file."""
        self._file.close()
        self.env.close()

    def _write(self, kind: str) -> None:
        try:
            line = json.dumps({"kind": kind, "at": time.time()})
            self._file.write(line.encode() + b"\n")
        except (OSError, ValueError) as error:
            raise FileError(f"cannot write `{self._path}`: {error}") from error
        self._taken, self._running = _after(self._taken, self._running, kind)


def _after(taken: Taken, running: int, kind: str) -> tuple[Taken, int]:
    """The counts, and the steps of the running episode, after a line."""
    if kind == "step":
        return replace(taken, steps=taken.steps + 1), running + 1
    if kind == "end":
        return taken, 0
    aborted = running > 0
    return (
        replace(
            taken,
            resets=taken.resets + 1,
            aborted_episodes=taken.aborted_episodes + aborted,
            aborted_steps=taken.aborted_steps + running,
        ),
        0,
    )


def _count(path: Path, lines: Iterable[bytes]) -> tuple[Taken, int]:
    taken, running = Taken(), 0
    for number, line in enumerate(lines, 1):
        try:
            kind = json.loads(line)["kind"]
            if kind not in ("reset", "step", "end"):
                raise ValueError
        except (ValueError, TypeError, KeyError):
            raise FileError(
                f"line {number} of `{path}` is {line[:60]!r}, expected one of a log of steps: give "
                "the log a file of its own"
            ) from None
        taken, running = _after(taken, running, kind)
    return taken, running
