"""Relay hindsight experience replay: tasks, an agent, and training on environments of your own.

Importing this package makes its environments known to Gymnasium::

    import gymnasium
    import rher

    env = gymnasium.make("rher/Push-v0")
"""

from rher import env as _env
from rher._rher import Policy, State, tasks
from rher.env import IDS, TaskEnv
from rher.errors import (
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

__all__ = [
    "IDS",
    "EnvError",
    "FileError",
    "InputError",
    "InternalError",
    "Policy",
    "PolicyError",
    "RherError",
    "SettingsError",
    "State",
    "StateError",
    "TaskEnv",
    "TrainError",
    "tasks",
]

_env.register()
