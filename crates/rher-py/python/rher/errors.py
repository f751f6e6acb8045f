"""The exceptions of ``rher``, all of them :class:`RherError`."""

import gymnasium.error

__all__ = [
    "ClusterError",
    "EnvError",
    "FileError",
    "InputError",
    "InternalError",
    "MissingError",
    "PolicyError",
    "RherError",
    "SettingsError",
    "StateError",
    "TrackerError",
    "TrainError",
]


class RherError(Exception):
    """The base class of every exception of ``rher``."""


class InputError(RherError, ValueError):
    """An argument has the wrong shape or type, or is outside its range."""


class StateError(RherError, gymnasium.error.ResetNeeded, RuntimeError):
    """An object was used before its first reset, after it was closed, or by two threads at once."""


class SettingsError(RherError, ValueError):
    """Settings of a run do not exist, or are outside their ranges."""


class FileError(RherError, OSError):
    """A file or folder cannot be read or written."""


class PolicyError(RherError, ValueError):
    """A file holds no policy, or a policy is for another environment."""


class EnvError(RherError, RuntimeError):
    """Your environment raised an exception (see ``__cause__``) or returned something wrong."""


class TrainError(RherError, RuntimeError):
    """A run cannot continue; what was saved before is unchanged."""


class ClusterError(RherError, RuntimeError):
    """A Ray cluster cannot be reached."""


class TrackerError(RherError, RuntimeError):
    """A tracker of experiments cannot be reached, or refuses a run."""


class MissingError(RherError, ImportError):
    """A package is not installed that only a part of ``rher`` needs."""


class InternalError(RherError, RuntimeError):
    """A bug in ``rher``."""
