"""Compares ``rher`` with Gymnasium-Robotics and Stable-Baselines3: ``python tools/compare.py``.

Everything is measured anew, side by side in one run, and written to a folder: ``compare.md`` is the
table, ``compare.json`` the raw data. ``tools/README.md`` says what has to be installed.
"""

import argparse
import json
import os
import platform
import statistics
import subprocess
import sys
import tempfile
import time
import warnings
from collections.abc import Callable
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np

import rher
from rher import _rher

PUSH, PICK = ("rher/Push-v0", "FetchPush-v4"), ("rher/PickAndPlace-v0", "FetchPickAndPlace-v4")
COPIES = 64

Measured = dict[str, Any]


def main(arguments: list[str] | None = None) -> None:
    """What the command line asks for."""
    args = _parser().parse_args(arguments)
    warnings.filterwarnings("ignore", module="gymnasium")
    args.out.mkdir(parents=True, exist_ok=True)
    results: Measured = {"machine": _machine(), "quick": args.quick}
    for part in args.parts:
        print(f"{part} ...", file=sys.stderr, flush=True)
        started = time.perf_counter()
        results[part] = PARTS[part](args)
        results[part]["seconds"] = round(time.perf_counter() - started, 1)
        # A later part may take hours, or fail.
        _write(args.out / "compare.json", json.dumps(results, indent=2) + "\n")
        _write(args.out / "compare.md", report(results))
    print(report(results))


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("compare"), help="folder of the results")
    parser.add_argument(
        "--parts", nargs="+", choices=PARTS, default=list(PARTS), metavar="PART",
        help=f"what to compare: {', '.join(PARTS)} (default: all)",
    )
    parser.add_argument("--quick", action="store_true", help="measure for moments only")
    for task in ("push", "pick"):
        parser.add_argument(
            f"--{task}", type=Path, nargs="+", default=[], metavar="POLICY",
            help=f"policies of `{task}` for `transfer`; one is trained if there are none",
        )
        parser.add_argument(
            f"--fetch-{task}", type=Path, nargs="+", default=[], metavar="POLICY",
            help=f"policies trained in {dict(push=PUSH, pick=PICK)[task][1]}, for the other way",
        )
    parser.add_argument("--episodes", type=int, default=200, help="of `transfer`, for each policy")
    parser.add_argument(
        "--budget", type=float, default=3600.0, metavar="SECONDS",
        help="after which each run of `learning` is stopped",
    )
    parser.add_argument(
        "--runs", nargs="+", choices=LEARNERS, default=list(LEARNERS), metavar="RUN",
        help=f"runs of `learning`: {', '.join(LEARNERS)} (default: all)",
    )
    return parser


def _write(path: Path, text: str) -> None:
    """Writes a file whole or not at all."""
    new = path.with_name(path.name + ".new")
    new.write_text(text)
    new.replace(path)


def _machine() -> Measured:
    packages = ("rher", "gymnasium", "gymnasium-robotics", "mujoco", "stable-baselines3", "torch")
    versions = {}
    for name in packages:
        try:
            versions[name] = version(name)
        except PackageNotFoundError:
            versions[name] = None
    cpu = platform.processor()
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
        cpu = next(line.split(":")[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        pass
    return {
        "cpu": cpu,
        "cores": os.cpu_count(),
        "load": os.getloadavg()[0],
        "python": platform.python_version(),
        "packages": versions,
    }


def _make(name: str) -> gymnasium.Env:
    """An environment; those of Fetch need their package to be imported."""
    if name.startswith("Fetch"):
        import gymnasium_robotics

        gymnasium.register_envs(gymnasium_robotics)
    return gymnasium.make(name)


def _rate(clock: Callable[[], float], seconds: float, work: Callable[[], int]) -> float:
    """What ``work`` does in a second of ``clock``, measured for ``seconds``."""
    done, started = 0, clock()
    while (elapsed := clock() - started) < seconds:
        done += work()
    return done / elapsed


def single(args: argparse.Namespace) -> Measured:
    """Environment steps per CPU-second, one environment, random actions, with resets."""
    rounds, seconds = (2, 0.5) if args.quick else (7, 3.0)
    actions = np.random.default_rng(0).uniform(-1, 1, (50, 4)).astype(np.float32)

    def episode(env: gymnasium.Env) -> Callable[[], int]:
        def play() -> int:
            env.reset()
            for action in actions:
                env.step(action)
            return len(actions)

        return play

    envs = {name: _make(name) for name in PUSH}
    rates: dict[str, list[float]] = {name: [] for name in PUSH}
    for env in envs.values():
        env.reset(seed=0)
    # Round by round, so that whatever else runs on the machine slows both.
    for _ in range(rounds):
        for name, env in envs.items():
            rates[name].append(_rate(time.process_time, seconds, episode(env)))
    ours, theirs = (statistics.median(rates[name]) for name in PUSH)
    return {"steps_per_cpu_second": rates, "ours": ours, "theirs": theirs, "ratio": ours / theirs}


#: Steps 64 environments and prints steps per second of the wall clock and of the processor.
ALONE = """
import sys, time, gymnasium, numpy as np, rher
threads, seconds, start = int(sys.argv[1]), float(sys.argv[2]), float(sys.argv[3])
envs = gymnasium.make_vec("rher/Push-v0", num_envs=64, threads=threads, copy=False)
envs.reset(seed=0)
actions = np.random.default_rng(0).uniform(-1, 1, (50, 64, 4)).astype(np.float32)
for action in actions:
    envs.step(action)
while time.time() < start:
    time.sleep(0.001)
wall, cpu, done = time.perf_counter(), time.process_time(), 0
while time.perf_counter() - wall < seconds:
    for action in actions:
        envs.step(action)
        done += 64
print(done / (time.perf_counter() - wall), done / (time.process_time() - cpu))
"""


def vector(args: argparse.Namespace) -> Measured:
    """Environment steps of 64 copies: per core, on two threads, and in two processes."""
    rounds, seconds = (1, 0.5) if args.quick else (5, 4.0)

    def processes(count: int, threads: int) -> list[tuple[float, float]]:
        start = time.time() + 2.0
        command = [sys.executable, "-c", ALONE, str(threads), str(seconds), str(start)]
        running = [
            subprocess.Popen(command, stdout=subprocess.PIPE, text=True) for _ in range(count)
        ]
        said = [process.communicate()[0].split() for process in running]
        if any(process.returncode for process in running):
            raise RuntimeError("a process that steps environments failed; its error is above")
        return [(float(wall), float(cpu)) for wall, cpu in said]

    rates: dict[str, list[Any]] = {"one_thread": [], "two_threads": [], "two_processes": []}
    theirs = []
    env = _make(PUSH[1])
    env.reset(seed=0)
    action = np.zeros(4, np.float32)

    def fetch() -> int:
        env.reset()
        for _ in range(50):
            env.step(action)
        return 50

    for _ in range(rounds):
        theirs.append(_rate(time.process_time, seconds / 2, fetch))
        rates["one_thread"] += processes(1, 1)
        rates["two_threads"] += processes(1, 2)
        rates["two_processes"].append(processes(2, 1))
    per_core = statistics.median(cpu for _, cpu in rates["one_thread"])
    one = statistics.median(wall for wall, _ in rates["one_thread"])
    two = statistics.median(wall for wall, _ in rates["two_threads"])
    apart = statistics.median(sum(wall for wall, _ in pair) for pair in rates["two_processes"])
    fetch_rate = statistics.median(theirs)
    return {
        "rates": rates,
        "theirs_rates": theirs,
        "per_core": per_core,
        "theirs": fetch_rate,
        "ratio": per_core / fetch_rate,
        "two_threads": two / one,
        "of_two_processes": two / apart,
    }


def relabeling(args: argparse.Namespace) -> Measured:
    """Relabeled samples per CPU-second, from equally many random episodes of push.

    Both replays have room for a million steps, which is the default of both.
    """
    from stable_baselines3 import HerReplayBuffer
    from stable_baselines3.common.vec_env import DummyVecEnv

    if not hasattr(_rher, "Hindsight"):
        raise RuntimeError(
            "this build of rher cannot measure relabeling: install it as tools/README.md says, "
            "with the feature `measure`"
        )
    episodes, rows = (100 if args.quick else 2000), 256
    rounds, seconds = (2, 0.3) if args.quick else (7, 2.0)
    env = DummyVecEnv([lambda: gymnasium.make(PUSH[0])])
    theirs = HerReplayBuffer(
        1_000_000, env.observation_space, env.action_space, env, device="cpu"
    )
    rng = np.random.default_rng(0)
    seen = env.reset()
    for _ in range(episodes * 50):
        action = rng.uniform(-1, 1, (1, 4)).astype(np.float32)
        after, rewards, ended, infos = env.step(action)
        end = infos[0].get("terminal_observation")
        real = {key: value[None] for key, value in end.items()} if end else after
        theirs.add(seen, real, action, rewards, ended, infos)
        seen = after
    ours = _rher.Hindsight("push", episodes)

    def draw_theirs() -> int:
        theirs.sample(rows)
        return rows

    def draw_ours() -> int:
        ours.sample(20, rows)
        return 20 * rows

    rates: dict[str, list[float]] = {"rher": [], "sb3": []}
    for _ in range(rounds):
        rates["rher"].append(_rate(time.process_time, seconds, draw_ours))
        rates["sb3"].append(_rate(time.process_time, seconds, draw_theirs))
    one, other = (statistics.median(rates[name]) for name in ("rher", "sb3"))
    return {"samples_per_cpu_second": rates, "ours": one, "theirs": other, "ratio": one / other}


def success(policy: Callable[[Any], np.ndarray], env: gymnasium.Env, episodes: int) -> int:
    """How many of these episodes a policy solves, judged at their last step."""
    solved = 0
    for seed in range(episodes):
        seen, info = env.reset(seed=seed)
        done = False
        while not done:
            seen, _, terminated, truncated, info = env.step(policy(seen))
            done = terminated or truncated
        solved += bool(info["is_success"])
    return solved


def transfer(args: argparse.Namespace) -> Measured:
    """Policies trained in one simulator, run unchanged in the other."""
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
    solved = {name: success(policy, _make(name), episodes) for name in names}
    return {"policy": str(path), "trained_in": trained, "solved": solved}


def learning(args: argparse.Namespace) -> Measured:
    """Wall clock until two consecutive evaluations of 100 episodes reach 95 %."""
    budget = min(args.budget, 20.0) if args.quick else args.budget
    runs = {}
    with tempfile.TemporaryDirectory(dir=args.out) as folder:
        for name in args.runs:
            print(f"  {name} ...", file=sys.stderr, flush=True)
            runs[name] = LEARNERS[name](Path(folder) / name, budget)
    return {"budget": budget, "runs": runs}


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
        with rher.Trainer(_make(PUSH[1]), preset=preset, out=out) as trainer:
            return _ours(lambda watch: trainer.learn(on_event=watch), budget)

    return run


def _sb3(name: str, settings: Measured) -> Callable[[Path, float], Measured]:
    """TD3 with hindsight of Stable-Baselines3, its defaults but for ``settings``."""

    def run(_: Path, budget: float) -> Measured:
        import torch
        from stable_baselines3 import TD3, HerReplayBuffer

        # Its default, one thread for each core, is slower wherever another process runs.
        torch.set_num_threads(1)
        env, test = _make(name), _make(name)
        model = TD3(
            "MultiInputPolicy", env, replay_buffer_class=HerReplayBuffer, seed=1, **settings
        )
        started = time.perf_counter()
        curve: list[Measured] = []

        def go_on(*_: Any) -> bool:
            return time.perf_counter() - started < budget

        while go_on():
            # As often as ours: every 50 episodes.
            model.learn(2500, callback=go_on, reset_num_timesteps=False)
            if not go_on():
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

PARTS: dict[str, Callable[[argparse.Namespace], Measured]] = {
    "single": single,
    "vector": vector,
    "relabeling": relabeling,
    "transfer": transfer,
    "learning": learning,
}


def report(results: Measured) -> str:
    """The table, in Markdown."""
    machine = results["machine"]
    packages = ", ".join(f"{name} {number}" for name, number in machine["packages"].items())
    lines = [
        "# rher and its neighbors",
        "",
        f"{machine['cores']} cores of {machine['cpu']}, load {machine['load']:.1f} at the start; "
        f"Python {machine['python']}, {packages}.",
        "",
    ]
    if results["quick"]:
        lines += ["Measured for moments only (`--quick`): these are no results.", ""]
    lines += ["| what | ours | theirs | ratio |", "|---|---|---|---|"]
    if (part := results.get("single")) is not None:
        lines.append(_row("steps per CPU-second, `rher/Push-v0` and `FetchPush-v4`", part))
    if (part := results.get("vector")) is not None:
        part = part | {"ours": part["per_core"]}
        lines.append(_row(f"the same for {COPIES} copies, per core", part))
        lines.append(
            f"| {COPIES} copies, two threads to one | {part['two_threads']:.2f} × | | "
            f"{part['of_two_processes']:.0%} of two processes |"
        )
    if (part := results.get("relabeling")) is not None:
        lines.append(_row("relabeled samples per CPU-second, SB3's `HerReplayBuffer`", part))
    if (part := results.get("transfer")) is not None:
        lines += ["", f"| policy | trained in | solved of {part['episodes']} episodes |"]
        lines += ["|---|---|---|"]
        for one in part["policies"]:
            solved = ", ".join(f"{name} {count}" for name, count in one["solved"].items())
            lines.append(f"| {one['policy']} | {one['trained_in']} | {solved} |")
    if (part := results.get("learning")) is not None:
        lines += ["", f"| run, stopped after {part['budget']:.0f} s | 95 % after | at the end |"]
        lines += ["|---|---|---|"]
        for name, run in part["runs"].items():
            reached, curve = run["reached"], run["curve"]
            when = "not reached"
            if reached:
                when = f"{reached['wall_s']:.0f} s, {reached['env_steps']:,} steps"
            end = "no evaluation"
            if curve:
                end = f"{curve[-1]['success']:.0%} after {curve[-1]['env_steps']:,} steps"
            lines.append(f"| {name} | {when} | {end} |")
    return "\n".join(lines) + "\n"


def _row(what: str, part: Measured) -> str:
    return f"| {what} | {part['ours']:,.0f} | {part['theirs']:,.0f} | {part['ratio']:.1f} × |"


if __name__ == "__main__":
    main()
