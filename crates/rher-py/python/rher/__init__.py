"""Relay hindsight experience replay: tasks, an agent, and training on your own environments.

Importing this package registers its environments with Gymnasium::

    import gymnasium
    import rher

    env = gymnasium.make("rher/Push-v0")
"""

from rher import env as _env
from rher._rher import Policy, State, __version__, tasks
from rher.env import IDS, TaskEnv
from rher.errors import (
    ClusterError,
    EnvError,
    FileError,
    InputError,
    InternalError,
    PolicyError,
    RherError,
    SettingsError,
    StateError,
    TrainError,
)
from rher.run import Run
from rher.training import Trainer, resume, train
from rher.vector import TaskVectorEnv

__all__ = [
    "IDS",
    "ClusterError",
    "EnvError",
    "FileError",
    "InputError",
    "InternalError",
    "Policy",
    "PolicyError",
    "RherError",
    "Run",
    "SettingsError",
    "State",
    "StateError",
    "TaskEnv",
    "TaskVectorEnv",
    "TrainError",
    "Trainer",
    "__version__",
    "resume",
    "tasks",
    "train",
]

_env.register()
