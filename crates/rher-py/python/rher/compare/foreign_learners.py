"""Who learns the tasks of other packages: this package, and Stable-Baselines3."""

import time
from pathlib import Path
from typing import Any

import rher
from rher.compare.foreign_env import WholeEpisodes, judge, make
from rher.compare.foreign_tasks import Task
from rher.compare.part import Measured


class Clocks:
    """Wall clock and processor time of this process since now."""

    def __init__(self) -> None:
        self._wall, self._cpu = time.perf_counter(), time.process_time()

    def read(self) -> Measured:
        wall, cpu = time.perf_counter() - self._wall, time.process_time() - self._cpu
        return {"wall_s": round(wall, 1), "cpu_s": round(cpu, 1)}


def ours(name: str, task: Task, seed: int, out: Path, budget: float, episodes: int) -> Measured:
    """Trains ``rher.Trainer`` until the task is solved, and at most ``budget`` seconds."""
    curve: list[Measured] = []
    clocks = Clocks()

    def watch(event: dict[str, Any]) -> None:
        if event["kind"] == "evaluated":
            row = {key: event[key] for key in ("env_steps", "updates", "success")}
            curve.append(clocks.read() | row)

    with rher.Trainer(
        WholeEpisodes(make(name, task, task.episode_steps)),
        objects=task.objects,
        gripper=slice(*task.gripper),
        tolerance=task.tolerance,
        mirrors=task.mirrors,
        permutations=task.permutations,
        seed=seed,
        env_steps=task.env_steps,
        set=task.settings,
        out=out / "run",
    ) as trainer:
        trainer.learn(max_wall=budget, on_event=watch)
        spent = clocks.read() | {"env_steps": trainer.env_steps}
        judged = judge(trainer.policy, make(name, task), task, episodes)
    return spent | {"curve": curve, "judged": judged}


def zoo(name: str, task: Task, seed: int, out: Path, budget: float, episodes: int) -> Measured:
    """Trains TQC with hindsight and the settings of the zoo for ``budget`` seconds."""
    import torch
    from sb3_contrib import TQC
    from sb3_contrib.common.wrappers import TimeFeatureWrapper
    from stable_baselines3 import HerReplayBuffer
    from stable_baselines3.common.monitor import Monitor

    # Its default, one thread for each core, is slower wherever another process runs.
    torch.set_num_threads(1)
    env = Monitor(TimeFeatureWrapper(make(name, task)), info_keywords=(task.success,))
    model = TQC(
        "MultiInputPolicy", env, replay_buffer_class=HerReplayBuffer, seed=seed, **(task.zoo or {})
    )
    curve: list[Measured] = []
    clocks = Clocks()

    def watch(values: dict[str, Any], _: dict[str, Any]) -> bool:
        latest = values["self"].ep_success_buffer
        now = clocks.read()
        if model.num_timesteps % 5_000 == 0:
            row = {"env_steps": model.num_timesteps, "success": [float(sum(latest)) / len(latest)]}
            curve.append(now | row)
        return bool(now["wall_s"] < budget)

    model.learn(task.env_steps, callback=watch)
    spent = clocks.read() | {"env_steps": model.num_timesteps}
    test = TimeFeatureWrapper(make(name, task))
    judged = judge(lambda seen: model.predict(seen, deterministic=True)[0], test, task, episodes)
    return spent | {"curve": curve, "judged": judged}


LEARNERS = {"rher": ours, "sb3-zoo": zoo}
