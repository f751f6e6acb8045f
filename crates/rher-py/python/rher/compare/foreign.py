"""The agent on environments of other packages: steps, seconds and success of unseen episodes."""

import json
import sys
from argparse import ArgumentParser, Namespace
from dataclasses import replace

from rher.compare.foreign_learners import LEARNERS
from rher.compare.foreign_tasks import TASKS
from rher.compare.part import Measured, Part


def add_arguments(parser: ArgumentParser) -> None:
    parser.add_argument(
        "--tasks", nargs="+", choices=TASKS, default=list(TASKS), metavar="TASK",
        help=f"tasks of `foreign`: {', '.join(TASKS)} (default: all)",
    )
    parser.add_argument(
        "--seeds", nargs="+", type=int, default=[1], metavar="SEED",
        help="seeds of `foreign`, one run for each (default: 1)",
    )
    parser.add_argument(
        "--learners", nargs="+", choices=LEARNERS, default=["rher"], metavar="LEARNER",
        help=f"who trains in `foreign`: {', '.join(LEARNERS)} (default: rher); sb3-zoo only trains "
        "tasks for which there are settings",
    )
    parser.add_argument(
        "--minutes", type=float, default=60.0, help="after which a run of `foreign` is stopped"
    )


def measure(args: Namespace) -> Measured:
    """Trains every task with every seed; finished runs of the same folder are not repeated."""
    runs = []
    for name in args.tasks:
        for seed in args.seeds:
            for learner in args.learners:
                if learner == "rher" or TASKS[name].zoo is not None:
                    runs.append(_run(name, seed, learner, args))
    return {"minutes": args.minutes, "runs": runs}


def _run(name: str, seed: int, learner: str, args: Namespace) -> Measured:
    out = args.out / f"{name}-{learner}-seed{seed}"
    result = out / "result.json"
    if not result.exists():
        print(f"  {name}, {learner}, seed {seed} ...", file=sys.stderr, flush=True)
        out.mkdir(parents=True, exist_ok=True)
        task, budget, episodes = TASKS[name], 60 * args.minutes, 200
        if args.quick:
            task, budget, episodes = replace(task, env_steps=2000), min(budget, 20.0), 2
        found = LEARNERS[learner](name, task, seed, out, budget, episodes)
        found = {"task": name, "learner": learner, "seed": seed, "aim": task.aim} | found
        result.write_text(json.dumps(found) + "\n")
    found = json.loads(result.read_text())
    assert isinstance(found, dict)
    return found


def lines(found: Measured) -> list[str]:
    table = [
        "| task | learner | seed | steps | wall | processor | solved | held | placed | aim |",
        "|---|---|---|---|---|---|---|---|---|---|",
    ]
    for run in found["runs"]:
        judged = run["judged"]
        counts = " | ".join(
            f"{judged[what] / judged['episodes']:.1%}" for what in ("solved", "held", "placed")
        )
        aim = "–" if run["aim"] is None else f"{run['aim']:.0%}"
        table.append(
            f"| {run['task']} | {run['learner']} | {run['seed']} | {run['env_steps']:,} | "
            f"{run['wall_s'] / 60:.1f} min | {run['cpu_s']:.0f} s | {counts} | {aim} |"
        )
    return table


PART = Part(measure, lines, add_arguments)
