"""Policies of our tasks with several blocks, run unchanged in MuJoCo."""

from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np

import rher
from rher.compare.part import Measured, Part
from rher.errors import InputError

#: Height of the table in meters: the middle of a block that has left it is below.
TABLE = 0.4


def add_arguments(parser: ArgumentParser) -> None:
    parser.add_argument(
        "--blocks", type=Path, nargs="+", default=[], metavar="POLICY",
        help="policies of tasks with several blocks for `blocks`, beside those that ship",
    )


def measure(args: Namespace) -> Measured:
    # It needs MuJoCo, which the other parts may do without.
    from rher.compare import block_scene

    episodes = 5 if args.quick else args.episodes
    policies = {f"ships for {task}": rher.Policy.pretrained(task) for task in block_scene.TASKS}
    policies |= {str(path): rher.Policy.load(path) for path in args.blocks}
    for name, policy in policies.items():
        if policy.task not in block_scene.TASKS:
            raise InputError(
                f"`{name}` is a policy of `{policy.task}`, expected one of "
                f"{', '.join(block_scene.TASKS)}"
            )
    found = []
    for name, policy in policies.items():
        ours = rher.TaskEnv(policy.task)
        simulators = {
            "ours": gymnasium.wrappers.TimeLimit(ours, ours.episode_steps),
            "mujoco": block_scene.make(policy.task),
        }
        failures = {where: _failures(policy, env, episodes) for where, env in simulators.items()}
        found.append({"policy": name, "task": policy.task, "failures": failures})
    return {"episodes": episodes, "policies": found}


def _failures(
    policy: rher.Policy, env: gymnasium.Env[Any, Any], episodes: int
) -> list[Measured]:
    """The episodes that a policy does not solve, judged at their last step: how far each block is
    from its place, in meters, and whether one has left the table.
    """
    failures = []
    for seed in range(episodes):
        seen, info = env.reset(seed=seed)
        act, done = policy.begin(seen), False
        while not done:
            seen, _, terminated, truncated, info = env.step(act(seen))
            done = terminated or truncated
        if not info["is_success"]:
            places = seen["achieved_goal"].reshape(-1, 3)
            goals = seen["desired_goal"].reshape(-1, 3)
            distances = np.linalg.norm(places - goals, axis=1).round(3).tolist()
            lost = bool((places[:, 2] < TABLE).any())
            failures.append({"seed": seed, "distances": distances, "lost": lost})
    return failures


def lines(found: Measured) -> list[str]:
    episodes = found["episodes"]
    solved = f"solved of {episodes} in ours | in MuJoCo"
    table = [
        f"| policy | task | {solved} | a block off the table in failures |",
        "|---|---|---|---|---|",
    ]
    for one in found["policies"]:
        ours, mujoco = one["failures"]["ours"], one["failures"]["mujoco"]
        lost = sum(failure["lost"] for failure in mujoco)
        counts = f"{episodes - len(ours)} | {episodes - len(mujoco)} | {lost} of {len(mujoco)}"
        table.append(f"| {one['policy']} | {one['task']} | {counts} |")
    return table


PART = Part(measure, lines, add_arguments)
