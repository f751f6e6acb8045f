"""The exceptions of ``rher``, all of them :class:`RherError`."""

import gymnasium.error

__all__ = [
    "EnvError",
    "FileError",
    "InputError",
    "InternalError",
    "PolicyError",
    "RherError",
    "SettingsError",
    "StateError",
    "TrainError",
]


class RherError(Exception):
    """Anything that ``rher`` can complain of."""


class InputError(RherError, ValueError):
    """An argument has the wrong shape or type, or is outside its range."""


class StateError(RherError, gymnasium.error.ResetNeeded, RuntimeError):
    """Something was used before its first reset, after its end, or by two threads at once."""


class SettingsError(RherError, ValueError):
    """Settings of a run do not exist, or are outside their ranges."""


class FileError(RherError, OSError):
    """A file or folder cannot be read or written."""


class PolicyError(RherError, ValueError):
    """A file holds no policy, or a policy is for another environment."""


class EnvError(RherError, RuntimeError):
    """An environment of yours raised (see ``__cause__``), or returned what it should not."""


class TrainError(RherError, RuntimeError):
    """A run cannot go on; what was saved before is untouched."""


class InternalError(RherError, RuntimeError):
    """A bug in ``rher``."""
