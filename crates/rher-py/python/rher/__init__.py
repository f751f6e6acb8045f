"""Relay hindsight experience replay: tasks, an agent, and training on your own environments.

Importing this package registers its environments with Gymnasium::

    import gymnasium
    import rher

    env = gymnasium.make("rher/Push-v0")
"""

from rher import env as _env
from rher._check_env import Problem, check
from rher._rher import Policy, State, __version__, tasks
from rher._test_symmetries import Tested, symmetries
from rher.env import DENSE_IDS, IDS, TaskEnv
from rher.errors import (
    ClusterError,
    EnvError,
    FileError,
    InputError,
    InternalError,
    MissingError,
    PolicyError,
    RherError,
    SettingsError,
    StateError,
    TrackerError,
    TrainError,
)
from rher.goals import Angle, Flag, Number, Quaternion
from rher.run import Run
from rher.step_log import StepLog, Taken
from rher.symmetry import Image, Mirror, Permutation
from rher.trainer import Trainer
from rher.training import resume, train
from rher.vector import TaskVectorEnv

__all__ = [
    "DENSE_IDS",
    "IDS",
    "Angle",
    "ClusterError",
    "EnvError",
    "FileError",
    "Flag",
    "Image",
    "InputError",
    "InternalError",
    "Mirror",
    "MissingError",
    "Number",
    "Permutation",
    "Policy",
    "PolicyError",
    "Problem",
    "Quaternion",
    "RherError",
    "Run",
    "SettingsError",
    "State",
    "StateError",
    "StepLog",
    "Taken",
    "TaskEnv",
    "TaskVectorEnv",
    "Tested",
    "TrackerError",
    "TrainError",
    "Trainer",
    "__version__",
    "check",
    "resume",
    "symmetries",
    "tasks",
    "train",
]

_env.register()
