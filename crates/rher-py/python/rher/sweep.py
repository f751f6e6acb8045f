"""Sweeps on a Ray cluster: every cell of a plan is a task of Ray.

``rher sweep push --seeds 1-10 --plan plan.jsonl`` writes a plan. :func:`run`, or ``python -m rher.sweep
plan.jsonl --ray auto``, trains its cells on all machines of a cluster. The folder of the plan is one
that all of them see, under the same path, and ``rher`` is installed on all of them.
"""

import argparse
import heapq
import json
import os
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from rher._arguments import path as as_path
from rher._arguments import whole
from rher._command import command, last_error, output
from rher.errors import ClusterError, FileError, InputError, MissingError, RherError
from rher.run import Run

__all__ = ["Cell", "run"]

OnEvent = Callable[[dict[str, Any]], object]

#: How often in a row a cell may be interrupted before it has saved anything new.
PATIENCE = 5
#: Seconds until a cell is tried again that another worker trains: at first, and at most.
FIRST_WAIT, LONGEST_WAIT = 1.0, 30.0

#: Exit statuses of a run that was interrupted, and is continued by the same command. Negative ones
#: are signals that ended the process before it could save.
BUSY = 15
INTERRUPTED = {16, 129, 130, 143, -1, -2, -9, -15}


@dataclass(frozen=True)
class Cell:
    """A cell of a plan, and how its training ended."""

    #: Number in the plan.
    number: int
    #: Name of the task.
    task: str
    seed: int
    #: What it is one of several seeds of.
    group: str
    #: Folder of the run.
    folder: Path
    #: Exit status of ``rher``: 0 if the cell is done, None if no process ended by itself.
    status: int | None = None
    #: Why it is not done.
    why: str | None = None
    #: How often its training was started by this call.
    attempts: int = 0

    @property
    def run(self) -> Run:
        """The run."""
        return Run(self.folder)


def run(
    plan: str | os.PathLike[str],
    address: str = "auto",
    *,
    cpus: int = 1,
    on_event: OnEvent | None = None,
) -> list[Cell]:
    """Trains all cells of a plan on a Ray cluster.

    Cells whose worker or machine dies are continued elsewhere; those that fail are not tried again,
    and do not end the others. Where this call itself is ended or killed, its workers save their cells
    and end, and the same call continues all of them. None of this changes a bit of a result.

    :param plan: path of the plan.
    :param address: where the cluster is, as ``ray.init`` reads it: ``"auto"`` is the one that this
        machine belongs to, ``"local"`` starts one on this machine only. If ``ray.init`` was called
        before, that connection is used.
    :param cpus: number of cores that Ray reserves for each cell, and of the cell's threads. It never
        changes a result.
    :param on_event: is called with a dictionary when an attempt to train a cell has ended: ``kind`` is
        ``"done"``, ``"failed"`` or ``"interrupted"`` (it is continued), ``cell`` is the cell, ``done``
        the number of cells that are done, and ``cells`` the number of all.
    :return: the cells in the order of their numbers. They are done if their ``status`` is 0.
    """
    path = Path(os.path.abspath(as_path("plan", plan)))
    cpus = whole("cpus", cpus, 1, 2**16)
    cells = _cells(path)
    if all(cell.status == 0 for cell in cells):
        return cells
    ray = _ray()
    ours = not ray.is_initialized()
    if ours:
        try:
            ray.init(address=address, log_to_driver=False, logging_level="warning")
        except ConnectionError as error:
            raise ClusterError(
                f"there is no Ray cluster at {address!r}: start one with `ray start --head`, and join "
                "it from other machines with `ray start --address`, or use this machine alone with "
                f"the address 'local' ({error})"
            ) from error
    try:
        return _Driver(ray, path, cpus, on_event, cells).run()
    finally:
        if ours:
            ray.shutdown()


def _ray() -> Any:
    try:
        import ray
    except ImportError as error:
        raise MissingError(
            "Ray is not installed: `pip install 'rher[ray]'` installs it; without it, `rher sweep "
            "--plan` trains a plan on this machine, and docs/cluster has files for Slurm and Kubernetes"
        ) from error
    return ray


def _cells(plan: Path) -> list[Cell]:
    """The cells of a plan; those that are done have the status 0."""
    try:
        listed = output("sweep", "--status", str(plan), "--json")
    except RherError as error:
        raise FileError(str(error)) from error
    return [
        Cell(
            number=cell["cell"],
            task=cell["task"],
            seed=cell["seed"],
            group=cell["group"],
            folder=plan.parent / cell["folder"],
            status=0 if cell["state"] == "done" else None,
        )
        for cell in json.loads(listed)["list"]
    ]


def _train(plan: str, cell: int, cpus: int) -> tuple[int, str]:
    """Trains a cell in a worker; its exit status, and what it said."""
    # It ends like after SIGTERM when this process dies, so that a killed worker leaves nothing behind.
    line = command("sweep", "--plan", plan, "--cell", str(cell), "--workers", str(cpus))
    line += ["--parent", str(os.getpid())]
    child = subprocess.Popen(
        line,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        errors="replace",
    )
    try:
        while True:
            try:
                # Ray interrupts a cancelled task between two lines of Python only.
                _, said = child.communicate(timeout=0.5)
                return child.returncode, said[-2000:]
            except subprocess.TimeoutExpired:
                pass
    finally:
        if child.returncode is None:
            child.terminate()
            child.wait()


class _Driver:
    """Submits cells until all of them are done or have failed."""

    def __init__(
        self, ray: Any, plan: Path, cpus: int, on_event: OnEvent | None, cells: list[Cell]
    ) -> None:
        self.ray = ray
        self.plan = str(plan)
        self.cpus = cpus
        self.on_event = on_event
        self.cells = cells
        self.train = ray.remote(num_cpus=cpus, max_retries=0)(_train)
        self.submitted: dict[Any, int] = {}
        #: When cells are to be tried again, and which.
        self.later: list[tuple[float, int]] = []
        self.waits: dict[int, float] = {}
        #: What of a cell was saved at its last interruption, and how often in a row nothing was new.
        self.saved: dict[int, tuple[int, int] | None] = {}
        self.in_vain: dict[int, int] = {}

    def run(self) -> list[Cell]:
        for cell in self.cells:
            if cell.status != 0:
                self.saved[cell.number] = _saved(cell)
                self.submit(cell.number)
        try:
            while self.submitted or self.later:
                self.step()
        finally:
            self.cancel()
        return self.cells

    def submit(self, number: int) -> None:
        cell = self.cells[number]
        self.cells[number] = replace(cell, attempts=cell.attempts + 1)
        self.submitted[self.train.remote(self.plan, number, self.cpus)] = number

    def step(self) -> None:
        """Waits until a cell ends or is due, and deals with it."""
        now = time.monotonic()
        while self.later and self.later[0][0] <= now:
            self.submit(heapq.heappop(self.later)[1])
        until = max(self.later[0][0] - now, 0.0) if self.later else None
        if not self.submitted:
            time.sleep(until or 0.0)
            return
        ended, _ = self.ray.wait(list(self.submitted), timeout=until)
        for reference in ended:
            number = self.submitted.pop(reference)
            try:
                status, said = self.ray.get(reference)
                self.ended(number, status, last_error(said))
            except self.ray.exceptions.RayTaskError as error:
                self.report(
                    "failed", number, None, f"its worker cannot start `rher`: {error.cause!r}"
                )
            except self.ray.exceptions.RayError as error:
                why = str(error).partition(". ")[0]
                self.interrupted(number, None, f"{type(error).__name__}: {why}")

    def ended(self, number: int, status: int, said: str) -> None:
        """Deals with a process that ended by itself."""
        why = said or f"exit status {status}"
        if status == 0:
            self.report("done", number, 0, None)
        elif status == BUSY:
            wait = self.waits.get(number, FIRST_WAIT)
            self.waits[number] = min(2 * wait, LONGEST_WAIT)
            heapq.heappush(self.later, (time.monotonic() + wait, number))
        elif status in INTERRUPTED:
            self.interrupted(number, status, why)
        else:
            self.report("failed", number, status, why)

    def interrupted(self, number: int, status: int | None, why: str) -> None:
        """Tries a cell again, unless it never gets any further."""
        saved = _saved(self.cells[number])
        in_vain = 0 if saved != self.saved[number] else self.in_vain.get(number, 0) + 1
        self.saved[number], self.in_vain[number] = saved, in_vain
        self.waits.pop(number, None)
        if in_vain == PATIENCE:
            why = f"it was interrupted {PATIENCE} times in a row before it could save: {why}"
            self.report("failed", number, status, why)
        else:
            self.report("interrupted", number, status, why)
            self.submit(number)

    def report(self, kind: str, number: int, status: int | None, why: str | None) -> None:
        cell = replace(self.cells[number], status=status, why=why)
        self.cells[number] = cell
        if self.on_event is not None:
            done = sum(cell.status == 0 for cell in self.cells)
            self.on_event({"kind": kind, "cell": cell, "done": done, "cells": len(self.cells)})

    def cancel(self) -> None:
        """Lets workers save what they train, if something ended this early."""
        for reference in self.submitted:
            self.ray.cancel(reference)
        if self.submitted:
            references = list(self.submitted)
            self.ray.wait(references, num_returns=len(references), timeout=10.0)


def _saved(cell: Cell) -> tuple[int, int] | None:
    """What tells one checkpoint of a cell from the next."""
    try:
        file = os.stat(cell.folder / "checkpoint" / "current.ckpt")
    except OSError:
        return None
    return file.st_mtime_ns, file.st_ino


def main(arguments: Sequence[str] | None = None) -> int:
    """The command ``python -m rher.sweep``; its exit status."""
    parser = argparse.ArgumentParser(
        prog="python -m rher.sweep",
        description="Train the cells of a plan on a Ray cluster; `rher sweep --status PLAN` says how far "
        "they are.",
    )
    parser.add_argument("plan", help="plan, as `rher sweep TASK --plan PLAN` writes it")
    parser.add_argument(
        "--ray",
        default="auto",
        metavar="ADDRESS",
        help="address of the cluster: `auto` is the one of this machine, `local` starts one here "
        "[default: auto]",
    )
    parser.add_argument(
        "--cpus", type=int, default=1, metavar="N", help="cores of each cell [default: 1]"
    )
    asked = parser.parse_args(arguments)
    try:
        cells = run(asked.plan, asked.ray, cpus=asked.cpus, on_event=_Progress())
    except (ClusterError, FileError, InputError, MissingError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    failed = [cell for cell in cells if cell.status != 0]
    for cell in failed:
        print(f"cell {cell.number} failed: {cell.why} ({cell.folder})", file=sys.stderr)
    print(f"{len(cells) - len(failed)} of {len(cells)} cells are done", file=sys.stderr)
    return 1 if failed else 0


class _Progress:
    """Prints what becomes of each cell, and how long the rest will take."""

    def __init__(self) -> None:
        self.started = time.monotonic()
        self.ended = 0

    def __call__(self, event: dict[str, Any]) -> None:
        cell, done, cells = event["cell"], event["done"], event["cells"]
        what = f"cell {cell.number} ({cell.group or cell.task} seed {cell.seed})"
        if event["kind"] == "done":
            self.ended += 1
            left = (time.monotonic() - self.started) / self.ended * (cells - done)
            print(f"{done} of {cells} done, ETA {left:.0f} s: {what}", file=sys.stderr)
        else:
            print(f"{what} {event['kind']}: {cell.why}", file=sys.stderr)


if __name__ == "__main__":
    try:
        sys.exit(main())
    except KeyboardInterrupt:
        print("interrupted; the same command continues", file=sys.stderr)
        sys.exit(130)
