"""Policies trained in one simulator, run unchanged in the other."""

from argparse import ArgumentParser, Namespace
from pathlib import Path

import rher
from rher.compare.environments import PICK, PUSH, make, success
from rher.compare.part import Measured, Part


def add_arguments(parser: ArgumentParser) -> None:
    for task, (_, fetch) in (("push", PUSH), ("pick", PICK)):
        parser.add_argument(
            f"--{task}", type=Path, nargs="+", default=[], metavar="POLICY",
            help=f"policies of `{task}` for `transfer`; one is trained if there are none",
        )
        parser.add_argument(
            f"--fetch-{task}", type=Path, nargs="+", default=[], metavar="POLICY",
            help=f"policies trained in {fetch}, for the other way",
        )
    parser.add_argument(
        "--episodes", type=int, default=200, help="of `transfer` and `blocks`, for each policy"
    )


def measure(args: Namespace) -> Measured:
    episodes = 20 if args.quick else args.episodes
    found = []
    given = [(args.push, PUSH, "push"), (args.pick, PICK, "pick")]
    for policies, names, task in given:
        if not policies and not args.quick:
            run = rher.train(task, out=args.out / f"{task}-trained")
            policies = [run.path / "policy.safetensors"]
        found += [_transferred(path, names, names[0], episodes) for path in policies]
    for policies, names in [(args.fetch_push, PUSH), (args.fetch_pick, PICK)]:
        found += [_transferred(path, names, names[1], episodes) for path in policies]
    return {"episodes": episodes, "policies": found}


def _transferred(path: Path, names: tuple[str, str], trained: str, episodes: int) -> Measured:
    policy = rher.Policy.load(path)
    solved = {name: success(policy, make(name), episodes) for name in names}
    return {"policy": str(path), "trained_in": trained, "solved": solved}


def lines(found: Measured) -> list[str]:
    table = [f"| policy | trained in | solved of {found['episodes']} episodes |", "|---|---|---|"]
    for one in found["policies"]:
        solved = ", ".join(f"{name} {count}" for name, count in one["solved"].items())
        table.append(f"| {one['policy']} | {one['trained_in']} | {solved} |")
    return table


PART = Part(measure, lines, add_arguments)
