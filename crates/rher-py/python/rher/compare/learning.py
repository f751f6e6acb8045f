"""Wall clock until two consecutive evaluations of 100 episodes reach 95 %."""

import sys
import tempfile
import time
from argparse import ArgumentParser, Namespace
from collections.abc import Callable
from pathlib import Path
from typing import Any

import rher
from rher.compare.environments import PUSH, make, success
from rher.compare.part import Measured, Part


def add_arguments(parser: ArgumentParser) -> None:
    parser.add_argument(
        "--budget", type=float, default=3600.0, metavar="SECONDS",
        help="after which each run of `learning` is stopped",
    )
    parser.add_argument(
        "--runs", nargs="+", choices=LEARNERS, default=list(LEARNERS), metavar="RUN",
        help=f"runs of `learning`: {', '.join(LEARNERS)} (default: all)",
    )


def measure(args: Namespace) -> Measured:
    budget = min(args.budget, 20.0) if args.quick else args.budget
    runs = {}
    with tempfile.TemporaryDirectory(dir=args.out) as folder:
        for name in args.runs:
            print(f"  {name} ...", file=sys.stderr, flush=True)
            runs[name] = LEARNERS[name](Path(folder) / name, budget)
    return {"budget": budget, "runs": runs}


def lines(found: Measured) -> list[str]:
    table = [f"| run, stopped after {found['budget']:.0f} s | 95 % after | at the end |"]
    table.append("|---|---|---|")
    for name, run in found["runs"].items():
        reached, curve = run["reached"], run["curve"]
        when = "not reached"
        if reached:
            when = f"{reached['wall_s']:.0f} s, {reached['env_steps']:,} steps"
        end = "no evaluation"
        if curve:
            end = f"{curve[-1]['success']:.0%} after {curve[-1]['env_steps']:,} steps"
        table.append(f"| {name} | {when} | {end} |")
    return table


class _Spent(Exception):
    """The budget is spent."""


def _ours(train: Callable[..., Any], budget: float) -> Measured:
    """A run of ours; ``train`` takes what is to be called at every event."""
    started = time.perf_counter()
    curve: list[Measured] = []

    def watch(event: Measured) -> None:
        wall = time.perf_counter() - started
        if event["kind"] == "evaluated":
            rate = event["success_final"]
            curve.append({"wall_s": wall, "env_steps": event["env_steps"], "success": rate})
        if wall > budget:
            raise _Spent

    try:
        train(watch)
    except _Spent:
        pass
    return _curve(curve, time.perf_counter() - started)


def _curve(curve: list[Measured], spent: float) -> Measured:
    """A learning curve and when it was at 95 % for good."""
    reached = None
    for before, now in zip(curve, curve[1:]):
        if before["success"] >= 0.95 and now["success"] >= 0.95:
            reached = {key: now[key] for key in ("wall_s", "env_steps")}
            break
    return {"reached": reached, "spent_s": spent, "curve": curve}


def _ours_in_ours(out: Path, budget: float) -> Measured:
    return _ours(lambda watch: rher.train("push", out=out, on_event=watch), budget)


def _ours_in_fetch(preset: str) -> Callable[[Path, float], Measured]:
    def run(out: Path, budget: float) -> Measured:
        with rher.Trainer(make(PUSH[1]), preset=preset, out=out) as trainer:
            return _ours(lambda watch: trainer.learn(on_event=watch), budget)

    return run


def _sb3(name: str, settings: Measured) -> Callable[[Path, float], Measured]:
    """TD3 with hindsight of Stable-Baselines3, its defaults but for ``settings``."""

    def run(_: Path, budget: float) -> Measured:
        import torch
        from stable_baselines3 import TD3, HerReplayBuffer

        # Its default, one thread for each core, is slower wherever another process runs.
        torch.set_num_threads(1)
        env, test = make(name), make(name)
        model = TD3(
            "MultiInputPolicy", env, replay_buffer_class=HerReplayBuffer, seed=1, **settings
        )
        started = time.perf_counter()
        curve: list[Measured] = []

        def time_is_left(*_: Any) -> bool:
            return time.perf_counter() - started < budget

        while time_is_left():
            # As often as ours: every 50 episodes.
            model.learn(2500, callback=time_is_left, reset_num_timesteps=False)
            if not time_is_left():
                break
            act = lambda seen: model.predict(seen, deterministic=True)[0]  # noqa: E731
            rate = success(act, test, 100) / 100
            wall = time.perf_counter() - started
            curve.append({"wall_s": wall, "env_steps": model.num_timesteps, "success": rate})
            if [row["success"] >= 0.95 for row in curve[-2:]] == [True, True]:
                break
        return _curve(curve, time.perf_counter() - started)

    return run


#: The zoo's settings for FetchPush, which are for TQC, as far as TD3 has them.
ZOO: Measured = {
    "batch_size": 2048,
    "gamma": 0.95,
    "learning_rate": 1e-3,
    "tau": 0.05,
    "policy_kwargs": {"net_arch": [512, 512, 512]},
}

LEARNERS: dict[str, Callable[[Path, float], Measured]] = {
    "rher-in-rher": _ours_in_ours,
    "rher-in-fetch": _ours_in_fetch("fast"),
    "rher-paper-in-fetch": _ours_in_fetch("paper"),
    "sb3-in-rher": _sb3(PUSH[0], {}),
    "sb3-in-fetch": _sb3(PUSH[1], {}),
    "sb3-zoo-in-fetch": _sb3(PUSH[1], ZOO),
}

PART = Part(measure, lines, add_arguments)
