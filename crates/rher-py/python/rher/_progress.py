"""How far a run is, for those who watch it."""

import importlib.util
import logging
import sys
import warnings
from typing import Any

from rher import _rher
from rher.errors import InputError

__all__ = ["Bar", "Log", "watcher"]

logger = logging.getLogger("rher")

#: How a run ended, in words.
ENDS = {"steps-spent": "all steps taken"}


def watcher(progress: Any, trainer: "_rher.Trainer") -> "Bar | Log | None":
    """What shows the progress of a run.

    :param progress: True for a bar, False for nothing; None for a bar where somebody sees it, and
        lines in the log elsewhere.
    """
    if progress is not None and not isinstance(progress, bool):
        raise InputError(f"progress is {progress!r}, expected True, False or None")
    if progress is False:
        return None
    if importlib.util.find_spec("tqdm") is not None and (progress or _is_watched()):
        return Bar(trainer)
    return Log(trainer)


def _is_watched() -> bool:
    """Whether this is a notebook, or the errors go to a terminal."""
    return "ipykernel" in sys.modules or (sys.stderr is not None and sys.stderr.isatty())


class Log:
    """A line for each evaluation, and one at the end, in the log ``rher``."""

    def __init__(self, trainer: "_rher.Trainer") -> None:
        self.task = trainer.task
        self.steps, self.until = trainer.end
        self.env_steps = trainer.env_steps
        self.say(self.aim())

    def aim(self) -> str:
        """When the run ends."""
        steps = f"{self.steps:,} steps"
        if not self.until:
            return f"trains for {steps}"
        return f"trains until success {self.until:.0%} in two evaluations, at most {steps}"

    def __call__(self, event: dict[str, Any]) -> None:
        """Takes note of an event of the run."""
        if event["kind"] == "progress":
            self.env_steps = event["env_steps"]
        if event["kind"] == "evaluated":
            self.env_steps = event["env_steps"]
            self.evaluated(self.rates(event))

    def say(self, line: str) -> None:
        logger.info("%s: %s", self.task, line)

    def rates(self, metrics: dict[str, Any]) -> str:
        """Success rates of an evaluation, sub-task by sub-task."""
        rates = metrics["success"]
        names = _names(self.task, len(rates))
        known = [
            f"{name} {rate:.0%}" for name, rate in zip(names, rates, strict=True) if rate is not None
        ]
        return " · ".join(known)

    def evaluated(self, rates: str) -> None:
        self.say(f"{self.env_steps:,} steps: {rates}")

    def close(self, ended: str) -> None:
        """Says how the run ended."""
        self.say(f"{ENDS.get(ended, ended)} after {self.env_steps:,} steps")


class Bar(Log):
    """A line of tqdm that counts steps, with a line above it for each evaluation."""

    #: Where a success rate ends the run, a bar that counts to its last step would say nothing.
    OPEN_END = "{desc}: {n:,} of at most {total:,} steps [{elapsed}, {rate_fmt}{postfix}]"

    def __init__(self, trainer: "_rher.Trainer") -> None:
        with warnings.catch_warnings():
            # Without ipywidgets it draws the bar as text, which is good enough.
            warnings.simplefilter("ignore")
            from tqdm.auto import tqdm
        steps, until = trainer.end
        self.bar = tqdm(
            total=steps,
            initial=trainer.env_steps,
            desc=trainer.task,
            unit=" steps",
            unit_scale=True,
            bar_format=self.OPEN_END if until else None,
        )
        super().__init__(trainer)

    def __call__(self, event: dict[str, Any]) -> None:
        super().__call__(event)
        self.bar.update(self.env_steps - self.bar.n)

    def say(self, line: str) -> None:
        self.bar.write(f"{self.task}: {line}", file=sys.stderr)

    def evaluated(self, rates: str) -> None:
        super().evaluated(rates)
        self.bar.set_postfix_str(rates)

    def close(self, ended: str) -> None:
        self.bar.close()
        super().close(ended)


def _names(task: str, count: int) -> list[str]:
    """What the sub-tasks of a task are called; those of an environment of the user's are to reach
    and to place.
    """
    if task in _rher.tasks():
        return _rher.subtasks(task)
    both = ("reach", "place")
    if count <= len(both):
        return list(both[:count])
    return [f"{both[index % 2]} {index // 2 + 1}" for index in range(count)]
