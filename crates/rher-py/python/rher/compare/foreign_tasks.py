"""The tasks of other packages that `foreign` trains: one row each."""

from dataclasses import dataclass, field
from typing import Any

from rher import Mirror, Permutation
from rher.compare.foreign_symmetries import fetch_mirror, panda_exchange, panda_mirror

#: For a simulator that makes hundreds of steps per CPU-second: shorter evaluations.
_DEAR = {"evaluation.episodes": 40, "evaluation.subtask_episodes": 8}

#: Where 97 % of unseen episodes are the aim.
_PRECISE = {"until": 0.97, "evaluation.subtask_episodes": 8}

#: What the zoo of Stable-Baselines3 trains panda-gym with, for TQC.
_ZOO_PANDA = {
    "batch_size": 2048,
    "buffer_size": 1_000_000,
    "gamma": 0.95,
    "learning_rate": 1e-3,
    "tau": 0.05,
    "policy_kwargs": {"net_arch": [512, 512, 512], "n_critics": 2},
    "replay_buffer_kwargs": {"goal_selection_strategy": "future", "n_sampled_goal": 4},
}


@dataclass(frozen=True)
class Task:
    """How a task is made, what the agent has to know about it, and how it is trained."""

    #: Module that registers it with Gymnasium.
    package: str
    #: Budget in environment steps.
    env_steps: int
    #: Share of unseen episodes that it should solve; none where nobody has set one.
    aim: float | None
    #: Arguments of ``gymnasium.make``.
    make: dict[str, Any] = field(default_factory=dict)
    objects: int = 1
    #: Where in an observation the position of the gripper begins and ends.
    gripper: tuple[int, int] = (0, 3)
    #: Distance in meters within which each object counts as placed in training.
    tolerance: float = 0.05
    #: Steps of an episode of training; by default those of the environment, as in all that judge.
    episode_steps: int | None = None
    mirrors: tuple[Mirror, ...] = ()
    permutations: tuple[Permutation, ...] = ()
    #: Settings of ``rher.Trainer``.
    settings: dict[str, Any] = field(default_factory=dict)
    #: What ``info`` calls success.
    success: str = "is_success"
    #: Settings of the zoo, where Stable-Baselines3 is trained beside ours.
    zoo: dict[str, Any] | None = None


TASKS: dict[str, Task] = {
    # Success is √(e₁² + e₂²) < 10 cm with the distances of the cubes to their places, which two
    # cubes beside each other reach, too: within 7 cm each is enough.
    "PandaStack-v3": Task(
        "panda_gym", 300_000, 0.95,
        objects=2, tolerance=0.07, episode_steps=60,
        mirrors=(panda_mirror(7, 2),), permutations=(panda_exchange(7),),
        settings=_DEAR | {"evaluation.every_episodes": 100, "replay.updates_per_episode": 80},
        zoo=_ZOO_PANDA,
    ),
    "PandaPush-v3": Task(
        "panda_gym", 150_000, 0.95, mirrors=(panda_mirror(6, 1),), settings=_DEAR
    ),
    # A grasp takes fingers that stay open, then closed, for some steps.
    "PandaPickAndPlace-v3": Task(
        "panda_gym", 150_000, 0.95,
        mirrors=(panda_mirror(7, 1),),
        settings=_DEAR | {"exploration.random_steps": 4},
    ),
    "FetchPush-v4": Task(
        "gymnasium_robotics", 100_000, 0.97, mirrors=(fetch_mirror(),), settings=_PRECISE
    ),
    "FetchPickAndPlace-v4": Task(
        "gymnasium_robotics", 150_000, 0.97, mirrors=(fetch_mirror(),), settings=_PRECISE
    ),
    "FetchSlide-v4": Task(
        "gymnasium_robotics", 300_000, 0.70, mirrors=(fetch_mirror(),), settings={"until": 0.75}
    ),
}
